/* SPDX-License-Identifier: MIT
 *
 * The inputs of MaterialX 1.39's surface shaders, with the defaults of their definitions (libraries/bxdf/ *.mtlx). Inputs that matter
 * only with another one that must be 0, such as a colour of transmission, are ignored.
 */
#include "material/materialx.h"

#define N_OF(TYPE) (sizeof(TYPE) == sizeof "color3" ? 3 : 1)
#define KEY(NAME, TYPE, DEFAULT)                                                                                       \
    { NAME, nqm_mtlx_read_key, NAME, N_OF(TYPE), DEFAULT, NULL, NULL, TYPE }
#define NEUTRAL(NAME, TYPE, DEFAULT, WHY)                                                                              \
    { NAME, nqm_rule_neutral, NULL, N_OF(TYPE), DEFAULT, WHY, NULL, TYPE }
#define GATED(NAME, TYPE, DEFAULT, WHY, GATE)                                                                          \
    { NAME, nqm_rule_neutral, NULL, N_OF(TYPE), DEFAULT, WHY, GATE, TYPE }
#define NORMAL(NAME)                                                                                                   \
    { NAME, nqm_mtlx_read_normal, NULL, 0, 0, NULL, NULL, NULL }
#define IGNORED(NAMES)                                                                                                 \
    { NAMES, nqm_rule_ignore, NULL, 0, 0, NULL, NULL, NULL }
#define END                                                                                                            \
    { NULL, NULL, NULL, 0, 0, NULL, NULL, NULL }

#define NOT_PART " is not part of these BRDFs"
static const char transmission[] = "transmission" NOT_PART, subsurface[] = "subsurface scattering" NOT_PART,
                  anisotropy[] = "anisotropy" NOT_PART, thin_film[] = "a thin film" NOT_PART,
                  emission[] = "emission" NOT_PART, opacity[] = "opacity" NOT_PART,
                  displacement[] = "displacement" NOT_PART;

static const nqm_rule open_pbr[] = {
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
    IGNORED("transmission_color transmission_depth transmission_scatter "
            "transmission_scatter_anisotropy transmission_dispersion_scale "
            "transmission_dispersion_abbe_number subsurface_color subsurface_radius "
            "subsurface_radius_scale subsurface_scatter_anisotropy thin_film_thickness thin_film_ior "
            "emission_color geometry_thin_walled geometry_tangent geometry_coat_tangent"),
    END,
};

static const nqm_rule standard_surface[] = {
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
    IGNORED("specular_rotation transmission_color transmission_depth transmission_scatter "
            "transmission_scatter_anisotropy transmission_dispersion transmission_extra_roughness "
            "subsurface_color subsurface_radius subsurface_scale subsurface_anisotropy coat_rotation "
            "thin_film_IOR emission_color thin_walled tangent"),
    END,
};

static const nqm_rule gltf_pbr[] = {
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
    {"occlusion", nqm_mtlx_read_occlusion, NULL, 0, 0, NULL, NULL, NULL},
    IGNORED("alpha alpha_cutoff iridescence_ior iridescence_thickness emissive_strength thickness "
            "attenuation_distance attenuation_color anisotropy_rotation dispersion"),
    END,
};

static const nqm_rule usd_preview_surface[] = {
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
    NEUTRAL("displacement", "float", 0, displacement),
    NORMAL("normal"),
    IGNORED("opacityMode opacityThreshold"),
    {"occlusion", nqm_mtlx_read_occlusion, NULL, 0, 0, NULL, NULL, NULL},
    END,
};

static const nqm_rule disney[] = {
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
    IGNORED("ior subsurfaceDistance"),
    END,
};

const nqm_mtlx_surface nqm_mtlx_surfaces[NQM_MTLX_N_SURFACES] = {
    {"open_pbr_surface", "open-pbr", open_pbr},
    {"standard_surface", "standard-surface", standard_surface},
    {"gltf_pbr", "gltf", gltf_pbr},
    {"UsdPreviewSurface", "usd-preview", usd_preview_surface},
    {"disney_principled", "disney", disney},
};
