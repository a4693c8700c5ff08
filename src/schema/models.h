/* SPDX-License-Identifier: MIT
 *
 * models.h - the keys of the shading models of renderers: X(INDEX, NAME, TYPE, ROLE, LOW, HIGH, DEFAULT, ...), after which members
 * of nqm_schema_key may follow. Names and defaults of the surface shaders of MaterialX 1.39 (open-pbr, standard-surface, gltf,
 * usd-preview, disney) are those of the inputs in their definitions (libraries/bxdf/ *.mtlx), whose files are read by these lists.
 * Colours above 1 are those that a conversion to BT.709 can give.
 */
#ifndef NQM_SRC_SCHEMA_MODELS_H
#define NQM_SRC_SCHEMA_MODELS_H

#include "schema/schema.h"

/** Every shading model to which others can be fitted, and those that are too slow for it: X(name, "spec", LIST OF KEYS, "another name" or
 *  NULL, "what it is"). A new one has its keys below, a line here, and its formulas in brdf/models/shading_NAME.c. */
#define NQM_SHADING_SCHEMAS(X)                                                                                         \
    X(rough_plastic, "rough-plastic", NQM_ROUGH_PLASTIC_KEYS, NULL, "Mitsuba's roughplastic and plastic")              \
    X(rough_conductor, "rough-conductor", NQM_ROUGH_CONDUCTOR_KEYS, NULL, "Mitsuba's roughconductor")                  \
    X(pbrt_conductor, "pbrt-conductor", NQM_PBRT_CONDUCTOR_KEYS, NULL, "pbrt's conductor")                             \
    X(open_pbr, "open-pbr", NQM_OPEN_PBR_KEYS, "openpbr", "OpenPBR Surface")                                           \
    X(gltf, "gltf", NQM_GLTF_KEYS, NULL, "glTF 2.0 with specular, ior, anisotropy, iridescence, sheen, clearcoat")     \
    X(usd_preview, "usd-preview", NQM_USD_PREVIEW_KEYS, "usd", "UsdPreviewSurface")                                    \
    X(standard_surface, "standard-surface", NQM_STANDARD_SURFACE_KEYS, NULL, "Autodesk Standard Surface")              \
    X(disney, "disney", NQM_DISNEY_KEYS, NULL, "Disney Principled, of MaterialX")                                      \
    X(principled, "principled", NQM_PRINCIPLED_KEYS, NULL, "Mitsuba's principled")                                     \
    X(blender, "blender-principled", NQM_BLENDER_KEYS, "blender", "Blender's Principled BSDF")
#define NQM_SLOW_SCHEMAS(X)                                                                                            \
    X(coated, "pbrt-coated-diffuse", NQM_COATED_KEYS, NULL, "pbrt's coateddiffuse")                                    \
    X(coated_conductor, "pbrt-coated-conductor", NQM_COATED_CONDUCTOR_KEYS, NULL, "pbrt's coatedconductor")
/** The one of analytic models that material files have. */
#define NQM_LAMBERT_KEYS(X)  X(KD, "kd", "color3", BASE_COLOR, 0, 10, 0, .required = true)
#define NQM_PLAIN_SCHEMAS(X) X(lambert, "lambert", NQM_LAMBERT_KEYS, NULL, NULL)

#define NQM_DECLARE_SCHEMA(NAME, ...) extern const nqm_schema nqm_##NAME##_schema;
NQM_SHADING_SCHEMAS(NQM_DECLARE_SCHEMA)
NQM_SLOW_SCHEMAS(NQM_DECLARE_SCHEMA)
NQM_PLAIN_SCHEMAS(NQM_DECLARE_SCHEMA)

/** Numbers of a value of this type. */
#define NQM_KEY_N(TYPE) (__builtin_strcmp(TYPE, "color3") == 0 ? 3 : __builtin_strcmp(TYPE, "float2") == 0 ? 2 : 1)
/** The index and the row of a key. */
#define NQM_KEY_INDEX(INDEX, ...) INDEX,
#define NQM_KEY_ROW(INDEX, NAME, TYPE, ROLE, LOW, HIGH, ...)                                                           \
    {.name = (NAME),                                                                                                   \
     .n = NQM_KEY_N(TYPE),                                                                                             \
     .low = (LOW),                                                                                                     \
     .high = (HIGH),                                                                                                   \
     .whole = sizeof(TYPE) == sizeof "integer",                                                                        \
     .role = NQM_ROLE_##ROLE,                                                                                          \
     .fallback = __VA_ARGS__},

/* clang-format off */
#define NQM_ROUGH_PLASTIC_KEYS(X)                                                      \
    X(ALPHA, "alpha", "float", WIDTH, 1e-4, 1, 0.1, .unit = NQM_UNIT_ALPHA)            \
    X(DISTRIBUTION, "distribution", "integer", NONE, 0, 1, 0)                          \
    X(ETA, "eta", "float", IOR, 1.05, 3, 1.49 / 1.000277)                              \
    X(DIFFUSE_REFLECTANCE, "diffuse_reflectance", "color3", BASE_COLOR, 0, 1, 0.5)     \
    X(SPECULAR_REFLECTANCE, "specular_reflectance", "color3", SPECULAR_COLOR, 0, 1, 1) \
    X(NONLINEAR, "nonlinear", "integer", NONE, 0, 1, 0)

#define NQM_ROUGH_CONDUCTOR_KEYS(X)                                                    \
    X(ALPHA, "alpha", "float2", WIDTH, 1e-4, 2, 0.1, .unit = NQM_UNIT_ALPHA)           \
    X(DISTRIBUTION, "distribution", "integer", NONE, 0, 1, 0)                          \
    X(ETA, "eta", "color3", METAL_ETA, 0, 20, 0)                                       \
    X(K, "k", "color3", METAL_K, 0, 20, 1)                                             \
    X(SPECULAR_REFLECTANCE, "specular_reflectance", "color3", SPECULAR_COLOR, 0, 1, 1)

#define NQM_PBRT_CONDUCTOR_KEYS(X)                                                                                \
    X(PBRT_ROUGHNESS, "roughness", "float2", WIDTH, 1e-6, 4, 0, .required = true, .unit = NQM_UNIT_ALPHA_SQUARED) \
    X(PBRT_ETA, "eta", "color3", METAL_ETA, 0, 20, 0, .required = true)                                           \
    X(PBRT_K, "k", "color3", METAL_K, 0, 200, 0, .required = true)

#define NQM_OPEN_PBR_KEYS(X)                                                                                        \
    X(BASE_WEIGHT, "base_weight", "float", BASE_WEIGHT, 0, 1, 1, .is_below = true)                                  \
    X(BASE_COLOR, "base_color", "color3", BASE_COLOR, 0, 2, 0.8)                                                    \
    X(BASE_DIFFUSE_ROUGHNESS, "base_diffuse_roughness", "float", DIFFUSE_ROUGHNESS, 0, 1, 0)                        \
    X(BASE_METALNESS, "base_metalness", "float", METAL, 0, 1, 0)                                                    \
    X(SPECULAR_WEIGHT, "specular_weight", "float", SPECULAR_WEIGHT, 0, 10, 1)                                       \
    X(SPECULAR_COLOR, "specular_color", "color3", SPECULAR_COLOR, 0, 2, 1)                                          \
    X(SPECULAR_ROUGHNESS, "specular_roughness", "float", WIDTH, 0, 1, 0.3)                                          \
    X(SPECULAR_ANISOTROPY, "specular_roughness_anisotropy", "float", ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO_MEAN) \
    X(SPECULAR_IOR, "specular_ior", "float", IOR, 0, 100, 1.5)                                                      \
    X(FUZZ_WEIGHT, "fuzz_weight", "float", SHEEN_WEIGHT, 0, 1, 0)                                                   \
    X(FUZZ_COLOR, "fuzz_color", "color3", SHEEN_COLOR, 0, 2, 1)                                                     \
    X(FUZZ_ROUGHNESS, "fuzz_roughness", "float", SHEEN_WIDTH, 0, 1, 0.5)                                            \
    X(COAT_WEIGHT, "coat_weight", "float", COAT_WEIGHT, 0, 1, 0)                                                    \
    X(COAT_COLOR, "coat_color", "color3", COAT_COLOR, 0, 2, 1)                                                      \
    X(COAT_ROUGHNESS, "coat_roughness", "float", COAT_WIDTH, 0, 1, 0)                                               \
    X(COAT_ANISOTROPY, "coat_roughness_anisotropy", "float", COAT_ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO_MEAN) \
    X(COAT_IOR, "coat_ior", "float", COAT_IOR, 0.01, 100, 1.6)                                                      \
    X(COAT_DARKENING, "coat_darkening", "float", COAT_EFFECT, 0, 1, 1)                                              \
    X(THIN_FILM_WEIGHT, "thin_film_weight", "float", FILM_WEIGHT, 0, 1, 0)                                          \
    X(THIN_FILM_THICKNESS, "thin_film_thickness", "float", FILM_THICKNESS, 0, 1000, 0.5, .unit = NQM_UNIT_MICROMETRES) \
    X(THIN_FILM_IOR, "thin_film_ior", "float", FILM_IOR, 0, 100, 1.4)

#define NQM_GLTF_KEYS(X)                                                                                      \
    X(BASE_COLOR, "base_color", "color3", BASE_COLOR, 0, 1, 1, .is_below = true)                              \
    X(METALLIC, "metallic", "float", METAL, 0, 1, 1)                                                          \
    X(ROUGHNESS, "roughness", "float", WIDTH, 0, 1, 1)                                                        \
    X(ANISOTROPY_STRENGTH, "anisotropy_strength", "float", ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_STRENGTH)    \
    X(ANISOTROPY_ROTATION, "anisotropy_rotation", "float", AZIMUTH, -1000, 1000, 0, .unit = NQM_UNIT_RADIANS) \
    X(IOR, "ior", "float", IOR, 0, 1e7, 1.5)                                                                  \
    X(SPECULAR, "specular", "float", SPECULAR_WEIGHT, 0, 1, 1)                                                \
    X(SPECULAR_COLOR, "specular_color", "color3", SPECULAR_COLOR, 0, 1000, 1)                                 \
    X(CLEARCOAT, "clearcoat", "float", COAT_WEIGHT, 0, 1, 0)                                                  \
    X(CLEARCOAT_ROUGHNESS, "clearcoat_roughness", "float", COAT_WIDTH, 0, 1, 0)                               \
    X(SHEEN_COLOR, "sheen_color", "color3", SHEEN_COLOR, 0, 1, 0)                                             \
    X(SHEEN_ROUGHNESS, "sheen_roughness", "float", SHEEN_WIDTH, 0, 1, 0)                                      \
    X(IRIDESCENCE, "iridescence", "float", FILM_WEIGHT, 0, 1, 0)                                              \
    X(IRIDESCENCE_IOR, "iridescence_ior", "float", FILM_IOR, 0, 100, 1.3)                                     \
    X(IRIDESCENCE_THICKNESS, "iridescence_thickness", "float", FILM_THICKNESS, 0, 1000000, 400, .unit = NQM_UNIT_NANOMETRES)

#define NQM_USD_PREVIEW_KEYS(X)                                                   \
    X(DIFFUSE_COLOR, "diffuseColor", "color3", BASE_COLOR, 0, 1, 0.18)            \
    X(USE_SPECULAR_WORKFLOW, "useSpecularWorkflow", "integer", NONE, 0, 1, 0)     \
    X(SPECULAR_COLOR, "specularColor", "color3", NONE, 0, 1, 0)                   \
    X(METALLIC, "metallic", "float", METAL, 0, 1, 0)                              \
    X(ROUGHNESS, "roughness", "float", WIDTH, 0, 1, 0.5)                          \
    X(CLEARCOAT, "clearcoat", "float", COAT_WEIGHT, 0, 1, 0)                      \
    X(CLEARCOAT_ROUGHNESS, "clearcoatRoughness", "float", COAT_WIDTH, 0, 1, 0.01) \
    X(IOR, "ior", "float", IOR, 0, 100, 1.5)

#define NQM_STANDARD_SURFACE_KEYS(X)                                                                              \
    X(BASE, "base", "float", BASE_WEIGHT, 0, 1, 1, .is_below = true)                                              \
    X(BASE_COLOR, "base_color", "color3", BASE_COLOR, 0, 2, 0.8)                                                  \
    X(DIFFUSE_ROUGHNESS, "diffuse_roughness", "float", DIFFUSE_ROUGHNESS, 0, 1, 0)                                \
    X(METALNESS, "metalness", "float", METAL, 0, 1, 0)                                                            \
    X(SPECULAR, "specular", "float", SPECULAR_WEIGHT, 0, 1, 1)                                                    \
    X(SPECULAR_COLOR, "specular_color", "color3", SPECULAR_COLOR, 0, 2, 1)                                        \
    X(SPECULAR_ROUGHNESS, "specular_roughness", "float", WIDTH, 0, 1, 0.2)                                        \
    X(SPECULAR_IOR, "specular_IOR", "float", IOR, 0, 100, 1.5)                                                    \
    X(SPECULAR_ANISOTROPY, "specular_anisotropy", "float", ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO)           \
    X(SPECULAR_ROTATION, "specular_rotation", "float", AZIMUTH, -1000, 1000, 0, .unit = NQM_UNIT_TURNS_CLOCKWISE) \
    X(SHEEN, "sheen", "float", SHEEN_WEIGHT, 0, 1, 0, .is_below = true)                                           \
    X(SHEEN_COLOR, "sheen_color", "color3", SHEEN_COLOR, 0, 2, 1)                                                 \
    X(SHEEN_ROUGHNESS, "sheen_roughness", "float", SHEEN_WIDTH, 0, 1, 0.3)                                        \
    X(COAT, "coat", "float", COAT_WEIGHT, 0, 1, 0)                                                                \
    X(COAT_COLOR, "coat_color", "color3", COAT_COLOR, 0, 2, 1)                                                    \
    X(COAT_ROUGHNESS, "coat_roughness", "float", COAT_WIDTH, 0, 1, 0.1)                                           \
    X(COAT_ANISOTROPY, "coat_anisotropy", "float", COAT_ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO)              \
    X(COAT_ROTATION, "coat_rotation", "float", COAT_AZIMUTH, -1000, 1000, 0, .unit = NQM_UNIT_TURNS_CLOCKWISE)    \
    X(COAT_IOR, "coat_IOR", "float", COAT_IOR, 0, 100, 1.5)                                                       \
    X(COAT_AFFECT_COLOR, "coat_affect_color", "float", COAT_EFFECT, 0, 1, 0)                                      \
    X(COAT_AFFECT_ROUGHNESS, "coat_affect_roughness", "float", COAT_EFFECT, 0, 1, 0)                              \
    X(THIN_FILM_THICKNESS, "thin_film_thickness", "float", FILM_THICKNESS, 0, 1000000, 0, .unit = NQM_UNIT_NANOMETRES) \
    X(THIN_FILM_IOR, "thin_film_IOR", "float", FILM_IOR, 0, 100, 1.5)

#define NQM_DISNEY_KEYS(X)                                                                     \
    X(BASE_COLOR, "baseColor", "color3", BASE_COLOR, 0, 2, 0.16, .is_below = true)             \
    X(METALLIC, "metallic", "float", METAL, 0, 1, 0)                                           \
    X(ROUGHNESS, "roughness", "float", WIDTH, 0, 1, 0.5)                                       \
    X(ANISOTROPIC, "anisotropic", "float", ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO)        \
    X(SPECULAR, "specular", "float", SPECULAR_WEIGHT, 0, 1, 0.5)                               \
    X(SPECULAR_TINT, "specularTint", "float", SPECULAR_TINT, 0, 1, 0)                          \
    X(SHEEN, "sheen", "float", SHEEN_WEIGHT, 0, 1, 0, .is_below = true)                        \
    X(SHEEN_TINT, "sheenTint", "float", SHEEN_TINT, 0, 1, 0.5)                                 \
    X(CLEARCOAT, "clearcoat", "float", COAT_WEIGHT, 0, 1, 0)                                   \
    X(CLEARCOAT_GLOSS, "clearcoatGloss", "float", COAT_WIDTH, 0, 1, 1, .unit = NQM_UNIT_GLOSS)

#define NQM_PRINCIPLED_KEYS(X)                                                                  \
    X(BASE_COLOR, "base_color", "color3", BASE_COLOR, 0, 1, 0.5, .is_below = true)              \
    X(ROUGHNESS, "roughness", "float", WIDTH, 0, 1, 0.5)                                        \
    X(ANISOTROPIC, "anisotropic", "float", ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO_90)      \
    X(METALLIC, "metallic", "float", METAL, 0, 1, 0)                                            \
    X(ETA, "eta", "float", IOR, 1, 4, 1.5)                                                      \
    X(SPEC_TINT, "spec_tint", "float", SPECULAR_TINT, 0, 1, 0)                                  \
    X(SHEEN, "sheen", "float", SHEEN_WEIGHT, 0, 1, 0)                                           \
    X(SHEEN_TINT, "sheen_tint", "float", SHEEN_TINT, 0, 1, 0)                                   \
    X(FLATNESS, "flatness", "float", NONE, 0, 1, 0)                                             \
    X(CLEARCOAT, "clearcoat", "float", COAT_WEIGHT, 0, 1, 0)                                    \
    X(CLEARCOAT_GLOSS, "clearcoat_gloss", "float", COAT_WIDTH, 0, 1, 0, .unit = NQM_UNIT_GLOSS)

#define NQM_BLENDER_KEYS(X)                                                                                           \
    X(BASE_COLOR, "base_color", "color3", BASE_COLOR, 0, 1, 0.8, .is_below = true)                                    \
    X(METALLIC, "metallic", "float", METAL, 0, 1, 0)                                                                  \
    X(ROUGHNESS, "roughness", "float", WIDTH, 0, 1, 0.5)                                                              \
    X(IOR, "ior", "float", IOR, 0.01, 1000, 1.5)                                                                      \
    X(DIFFUSE_ROUGHNESS, "diffuse_roughness", "float", DIFFUSE_ROUGHNESS, 0, 1, 0)                                    \
    X(SPECULAR_IOR_LEVEL, "specular_ior_level", "float", SPECULAR_LEVEL, 0, 1, 0.5)                                   \
    X(SPECULAR_TINT, "specular_tint", "color3", SPECULAR_COLOR, 0, 1000, 1)                                           \
    X(ANISOTROPIC, "anisotropic", "float", ANISOTROPY, 0, 1, 0, .unit = NQM_UNIT_RATIO_90)                            \
    X(ANISOTROPIC_ROTATION, "anisotropic_rotation", "float", AZIMUTH, -1000, 1000, 0, .unit = NQM_UNIT_TURNS)         \
    X(COAT_WEIGHT, "coat_weight", "float", COAT_WEIGHT, 0, 1, 0)                                                      \
    X(COAT_ROUGHNESS, "coat_roughness", "float", COAT_WIDTH, 0, 1, 0.03)                                              \
    X(COAT_IOR, "coat_ior", "float", COAT_IOR, 1, 4, 1.5)                                                             \
    X(COAT_TINT, "coat_tint", "color3", COAT_COLOR, 0, 1, 1)                                                          \
    X(SHEEN_WEIGHT, "sheen_weight", "float", SHEEN_WEIGHT, 0, 1, 0)                                                   \
    X(SHEEN_ROUGHNESS, "sheen_roughness", "float", SHEEN_WIDTH, 0, 1, 0.5)                                            \
    X(SHEEN_TINT, "sheen_tint", "color3", SHEEN_COLOR, 0, 1, 1)                                                       \
    X(THIN_FILM_THICKNESS, "thin_film_thickness", "float", FILM_THICKNESS, 0, 100000, 0, .unit = NQM_UNIT_NANOMETRES) \
    X(THIN_FILM_IOR, "thin_film_ior", "float", FILM_IOR, 1, 1000, 1.33)                                               \
    X(MULTISCATTER, "multiscatter", "integer", NONE, 0, 1, 1)

#define NQM_COATED_KEYS(X)                                                                                  \
    X(ROUGHNESS, "roughness", "float", WIDTH, 1e-6, 4, 0, .required = true, .unit = NQM_UNIT_ALPHA_SQUARED) \
    X(ETA, "eta", "float", IOR, 1.01, 4, 1.5)                                                               \
    X(REFLECTANCE, "reflectance", "color3", BASE_COLOR, 0, 1, 0.5)                                          \
    X(THICKNESS, "thickness", "float", NONE, 0, 100, 0.01)                                                  \
    X(MAX_DEPTH, "maxdepth", "integer", NONE, 1, 1000, 10)

#define NQM_COATED_CONDUCTOR_KEYS(X)                                                                            \
    X(INTERFACE_ROUGHNESS, "interface.roughness", "float", COAT_WIDTH, 0, 4, 0, .unit = NQM_UNIT_ALPHA_SQUARED) \
    X(INTERFACE_ETA, "interface.eta", "float", COAT_IOR, 1.01, 4, 1.5)                                          \
    X(CONDUCTOR_ROUGHNESS, "conductor.roughness", "float", WIDTH, 0, 4, 0, .unit = NQM_UNIT_ALPHA_SQUARED)      \
    X(CONDUCTOR_ETA, "conductor.eta", "color3", METAL_ETA, 0, 20, 0, .required = true)                          \
    X(CONDUCTOR_K, "conductor.k", "color3", METAL_K, 0, 200, 0, .required = true)                               \
    X(THICKNESS, "thickness", "float", NONE, 0, 100, 0.01)                                                      \
    X(MAX_DEPTH, "maxdepth", "integer", NONE, 1, 1000, 10)
/* clang-format on */

#endif
