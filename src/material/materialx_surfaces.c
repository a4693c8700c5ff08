/* SPDX-License-Identifier: MIT
 *
 * The inputs of MaterialX 1.39's surface shaders: those that are keys (schema/models.h), and the others with the defaults of their
 * definitions. Inputs that matter only with another one that must be 0, such as a colour of transmission, are ignored.
 */
#include "material/materialx.h"
#include "schema/models.h"

#define FIRST(X, ...) X
#define KEY(INDEX, NAME, TYPE, ROLE, LOW, HIGH, ...)                                                                   \
    {NAME, nqm_mtlx_read_key, NAME, NQM_KEY_N(TYPE), FIRST(__VA_ARGS__, 0), NULL, NULL, TYPE, 0, false},
#define VALUE(NAME, READ, TYPE, DEFAULT, WHY, IGNORABLE, IS_WEIGHT)                                                    \
    { NAME, READ, NULL, NQM_KEY_N(TYPE), DEFAULT, WHY, NULL, TYPE, IGNORABLE, IS_WEIGHT }
#define NEUTRAL(NAME, TYPE, DEFAULT, WHY) VALUE(NAME, nqm_rule_neutral, TYPE, DEFAULT, WHY, 0, false)
#define OPACITY(NAME, TYPE, DEFAULT)      VALUE(NAME, nqm_rule_neutral, TYPE, DEFAULT, opacity, NQM_IGNORE_OPACITY, false)
#define TRANSMISSION(NAME)                VALUE(NAME, nqm_rule_neutral, "float", 0, transmission, NQM_IGNORE_TRANSMISSION, true)
#define SUBSURFACE(NAME, READ, IS_WEIGHT) VALUE(NAME, READ, "float", 0, subsurface, NQM_IGNORE_SUBSURFACE, IS_WEIGHT)
#define EMISSION(NAME, TYPE)              VALUE(NAME, nqm_mtlx_read_emission, TYPE, 0, emission, NQM_IGNORE_EMISSION, false)
#define VECTOR(NAME, READ, GATE)                                                                                       \
    { .name = NAME, .read = READ, .gate = GATE }
#define NORMAL(NAME)              VECTOR(NAME, nqm_mtlx_read_normal, NULL)
#define COAT_NORMAL(NAME, COAT)   VECTOR(NAME, nqm_mtlx_read_coat_normal, COAT)
#define TANGENT(NAME, ANISOTROPY) VECTOR(NAME, nqm_mtlx_read_tangent, ANISOTROPY)
#define OCCLUSION                 VECTOR("occlusion", nqm_mtlx_read_occlusion, NULL)
#define END                                                                                                            \
    { .name = NULL }

#define NOT_PART " is not part of these BRDFs"
static const char transmission[] = "transmission" NOT_PART, subsurface[] = "subsurface scattering" NOT_PART,
                  emission[] = "emission" NOT_PART, opacity[] = "opacity" NOT_PART,
                  retroreflection[] = "retroreflection" NOT_PART;

static const nqm_rule open_pbr[] = {
    NQM_OPEN_PBR_KEYS(KEY) TRANSMISSION("transmission_weight"),
    SUBSURFACE("subsurface_weight", nqm_rule_neutral, true),
    EMISSION("emission_luminance", "float"),
    OPACITY("geometry_opacity", "float", 1),
    NORMAL("geometry_normal"),
    COAT_NORMAL("geometry_coat_normal", "coat_weight"),
    TANGENT("geometry_tangent", "specular_roughness_anisotropy"),
    TANGENT("geometry_coat_tangent", "coat_roughness_anisotropy"),
    NEUTRAL("specular_retroreflectivity", "float", 0, retroreflection),
    NQM_RULE_IGNORED("transmission_color transmission_depth transmission_scatter "
                     "transmission_scatter_anisotropy transmission_dispersion_scale "
                     "transmission_dispersion_abbe_number subsurface_color subsurface_radius "
                     "subsurface_radius_scale subsurface_scatter_anisotropy "
                     "emission_color geometry_thin_walled"),
    END,
};

static const nqm_rule standard_surface[] = {
    NQM_STANDARD_SURFACE_KEYS(KEY) TRANSMISSION("transmission"),
    SUBSURFACE("subsurface", nqm_mtlx_read_subsurface, true),
    EMISSION("emission", "float"),
    OPACITY("opacity", "color3", 1),
    NORMAL("normal"),
    COAT_NORMAL("coat_normal", "coat"),
    TANGENT("tangent", "specular_anisotropy coat_anisotropy"),
    NQM_RULE_IGNORED("transmission_color transmission_depth transmission_scatter "
                     "transmission_scatter_anisotropy transmission_dispersion transmission_extra_roughness "
                     "subsurface_color subsurface_radius subsurface_scale subsurface_anisotropy "
                     "emission_color thin_walled"),
    END,
};

static const nqm_rule gltf_pbr[] = {
    NQM_GLTF_KEYS(KEY) TRANSMISSION("transmission"),
    OPACITY("alpha_mode", "integer", 0),
    EMISSION("emissive", "color3"),
    NORMAL("normal"),
    COAT_NORMAL("clearcoat_normal", "clearcoat"),
    TANGENT("tangent", "anisotropy_strength"),
    OCCLUSION,
    NQM_RULE_IGNORED("alpha alpha_cutoff emissive_strength thickness "
                     "attenuation_distance attenuation_color dispersion"),
    END,
};

static const nqm_rule usd_preview_surface[] = {
    NQM_USD_PREVIEW_KEYS(KEY) EMISSION("emissiveColor", "color3"),
    OPACITY("opacity", "float", 1),
    VECTOR("displacement", nqm_mtlx_read_unused, NULL), /* the material has it */
    NORMAL("normal"),
    NQM_RULE_IGNORED("opacityMode opacityThreshold"),
    OCCLUSION,
    END,
};

static const nqm_rule disney[] = {
    NQM_DISNEY_KEYS(KEY) TRANSMISSION("specTrans"),
    SUBSURFACE("subsurface", nqm_rule_neutral, false),
    NQM_RULE_IGNORED("ior subsurfaceDistance"),
    END,
};

const nqm_mtlx_surface nqm_mtlx_surfaces[NQM_MTLX_N_SURFACES] = {
    {"open_pbr_surface", "open-pbr", open_pbr},
    {"standard_surface", "standard-surface", standard_surface},
    {"gltf_pbr", "gltf", gltf_pbr},
    {"UsdPreviewSurface", "usd-preview", usd_preview_surface},
    {"disney_principled", "disney", disney},
};

const nqm_mtlx_surface *nqm_mtlx_find_surface(const char *node, const char *model) {
    for (size_t s = 0; s < NQM_MTLX_N_SURFACES; ++s)
        if (nqm_texts_equal(node, nqm_mtlx_surfaces[s].node) || nqm_texts_equal(model, nqm_mtlx_surfaces[s].model))
            return &nqm_mtlx_surfaces[s];
    return NULL;
}
