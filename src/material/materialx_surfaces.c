/* SPDX-License-Identifier: MIT
 *
 * The inputs of MaterialX 1.39's surface shaders, with the defaults of their definitions (libraries/bxdf/ *.mtlx). Inputs that matter
 * only with another one that must be 0, such as a colour of transmission, are ignored.
 */
#include "material/materialx.h"

#define KEY(NAME, TYPE, DEFAULT)                                                                                       \
    { NAME, NQM_MTLX_KEY, TYPE, DEFAULT, NULL, NULL }
#define NEUTRAL(NAME, TYPE, DEFAULT, WHAT)                                                                             \
    { NAME, NQM_MTLX_NEUTRAL, TYPE, DEFAULT, WHAT, NULL }
#define GATED(NAME, TYPE, DEFAULT, WHAT, GATE)                                                                         \
    { NAME, NQM_MTLX_NEUTRAL, TYPE, DEFAULT, WHAT, GATE }
#define NORMAL(NAME)                                                                                                   \
    { NAME, NQM_MTLX_NORMAL, NULL, 0, NULL, NULL }
#define IGNORED(NAME)                                                                                                  \
    { NAME, NQM_MTLX_IGNORED, NULL, 0, NULL, NULL }

static const char transmission[] = "transmission", subsurface[] = "subsurface scattering", anisotropy[] = "anisotropy",
                  thin_film[] = "a thin film", emission[] = "emission", opacity[] = "opacity";

static const nqm_mtlx_input open_pbr[] = {
    KEY("base_weight", "float", 1),
    KEY("base_color", "color3", 0.8),
    KEY("base_diffuse_roughness", "float", 0),
    KEY("base_metalness", "float", 0),
    KEY("specular_weight", "float", 1),
    KEY("specular_color", "color3", 1),
    KEY("specular_roughness", "float", 0.3),
    KEY("specular_ior", "float", 1.5),
    KEY("fuzz_weight", "float", 0),
    KEY("fuzz_color", "color3", 1),
    KEY("fuzz_roughness", "float", 0.5),
    KEY("coat_weight", "float", 0),
    KEY("coat_color", "color3", 1),
    KEY("coat_roughness", "float", 0),
    KEY("coat_ior", "float", 1.6),
    KEY("coat_darkening", "float", 1),
    NEUTRAL("specular_roughness_anisotropy", "float", 0, anisotropy),
    NEUTRAL("transmission_weight", "float", 0, transmission),
    NEUTRAL("subsurface_weight", "float", 0, subsurface),
    GATED("coat_roughness_anisotropy", "float", 0, anisotropy, "coat_weight"),
    NEUTRAL("thin_film_weight", "float", 0, thin_film),
    NEUTRAL("emission_luminance", "float", 0, emission),
    NEUTRAL("geometry_opacity", "float", 1, opacity),
    NORMAL("geometry_normal"),
    NORMAL("geometry_coat_normal"),
    IGNORED("transmission_color"),
    IGNORED("transmission_depth"),
    IGNORED("transmission_scatter"),
    IGNORED("transmission_scatter_anisotropy"),
    IGNORED("transmission_dispersion_scale"),
    IGNORED("transmission_dispersion_abbe_number"),
    IGNORED("subsurface_color"),
    IGNORED("subsurface_radius"),
    IGNORED("subsurface_radius_scale"),
    IGNORED("subsurface_scatter_anisotropy"),
    IGNORED("thin_film_thickness"),
    IGNORED("thin_film_ior"),
    IGNORED("emission_color"),
    IGNORED("geometry_thin_walled"),
    IGNORED("geometry_tangent"),
    IGNORED("geometry_coat_tangent"),
};

static const nqm_mtlx_input standard_surface[] = {
    KEY("base", "float", 1),
    KEY("base_color", "color3", 0.8),
    KEY("diffuse_roughness", "float", 0),
    KEY("metalness", "float", 0),
    KEY("specular", "float", 1),
    KEY("specular_color", "color3", 1),
    KEY("specular_roughness", "float", 0.2),
    KEY("specular_IOR", "float", 1.5),
    KEY("sheen", "float", 0),
    KEY("sheen_color", "color3", 1),
    KEY("sheen_roughness", "float", 0.3),
    KEY("coat", "float", 0),
    KEY("coat_color", "color3", 1),
    KEY("coat_roughness", "float", 0.1),
    KEY("coat_IOR", "float", 1.5),
    KEY("coat_affect_color", "float", 0),
    KEY("coat_affect_roughness", "float", 0),
    NEUTRAL("specular_anisotropy", "float", 0, anisotropy),
    NEUTRAL("transmission", "float", 0, transmission),
    NEUTRAL("subsurface", "float", 0, subsurface),
    GATED("coat_anisotropy", "float", 0, anisotropy, "coat"),
    NEUTRAL("thin_film_thickness", "float", 0, thin_film),
    NEUTRAL("emission", "float", 0, emission),
    NEUTRAL("opacity", "color3", 1, opacity),
    NORMAL("normal"),
    NORMAL("coat_normal"),
    IGNORED("specular_rotation"),
    IGNORED("transmission_color"),
    IGNORED("transmission_depth"),
    IGNORED("transmission_scatter"),
    IGNORED("transmission_scatter_anisotropy"),
    IGNORED("transmission_dispersion"),
    IGNORED("transmission_extra_roughness"),
    IGNORED("subsurface_color"),
    IGNORED("subsurface_radius"),
    IGNORED("subsurface_scale"),
    IGNORED("subsurface_anisotropy"),
    IGNORED("coat_rotation"),
    IGNORED("thin_film_IOR"),
    IGNORED("emission_color"),
    IGNORED("thin_walled"),
    IGNORED("tangent"),
};

static const nqm_mtlx_input gltf_pbr[] = {
    KEY("base_color", "color3", 1),
    KEY("metallic", "float", 1),
    KEY("roughness", "float", 1),
    KEY("ior", "float", 1.5),
    KEY("specular", "float", 1),
    KEY("specular_color", "color3", 1),
    KEY("clearcoat", "float", 0),
    KEY("clearcoat_roughness", "float", 0),
    KEY("sheen_color", "color3", 0),
    KEY("sheen_roughness", "float", 0),
    NEUTRAL("transmission", "float", 0, transmission),
    NEUTRAL("alpha_mode", "integer", 0, opacity),
    NEUTRAL("iridescence", "float", 0, thin_film),
    NEUTRAL("emissive", "color3", 0, emission),
    NEUTRAL("anisotropy_strength", "float", 0, anisotropy),
    NORMAL("normal"),
    NORMAL("clearcoat_normal"),
    IGNORED("tangent"),
    IGNORED("occlusion"),
    IGNORED("alpha"),
    IGNORED("alpha_cutoff"),
    IGNORED("iridescence_ior"),
    IGNORED("iridescence_thickness"),
    IGNORED("emissive_strength"),
    IGNORED("thickness"),
    IGNORED("attenuation_distance"),
    IGNORED("attenuation_color"),
    IGNORED("anisotropy_rotation"),
    IGNORED("dispersion"),
};

static const nqm_mtlx_input usd_preview_surface[] = {
    KEY("diffuseColor", "color3", 0.18),
    KEY("useSpecularWorkflow", "integer", 0),
    KEY("specularColor", "color3", 0),
    KEY("metallic", "float", 0),
    KEY("roughness", "float", 0.5),
    KEY("clearcoat", "float", 0),
    KEY("clearcoatRoughness", "float", 0.01),
    KEY("ior", "float", 1.5),
    NEUTRAL("emissiveColor", "color3", 0, emission),
    NEUTRAL("opacity", "float", 1, opacity),
    NEUTRAL("displacement", "float", 0, "displacement"),
    NORMAL("normal"),
    IGNORED("opacityMode"),
    IGNORED("opacityThreshold"),
    IGNORED("occlusion"),
};

static const nqm_mtlx_input disney[] = {
    KEY("baseColor", "color3", 0.16),
    KEY("metallic", "float", 0),
    KEY("roughness", "float", 0.5),
    KEY("specular", "float", 0.5),
    KEY("specularTint", "float", 0),
    KEY("sheen", "float", 0),
    KEY("sheenTint", "float", 0.5),
    KEY("clearcoat", "float", 0),
    KEY("clearcoatGloss", "float", 1),
    NEUTRAL("anisotropic", "float", 0, anisotropy),
    NEUTRAL("specTrans", "float", 0, transmission),
    NEUTRAL("subsurface", "float", 0, subsurface),
    IGNORED("ior"),
    IGNORED("subsurfaceDistance"),
};

#define SURFACE(NODE, MODEL, INPUTS)                                                                                   \
    { NODE, MODEL, sizeof(INPUTS) / sizeof *(INPUTS), INPUTS }
const nqm_mtlx_surface nqm_mtlx_surfaces[NQM_MTLX_N_SURFACES] = {
    SURFACE("open_pbr_surface", "open-pbr", open_pbr),
    SURFACE("standard_surface", "standard-surface", standard_surface),
    SURFACE("gltf_pbr", "gltf", gltf_pbr),
    SURFACE("UsdPreviewSurface", "usd-preview", usd_preview_surface),
    SURFACE("disney_principled", "disney", disney),
};
