/* SPDX-License-Identifier: MIT
 *
 * surface_keys.h - the inputs of the surface shaders of MaterialX 1.39 that are keys of shading models, with the defaults of their
 * definitions (libraries/bxdf/ *.mtlx): X(INDEX, NAME, TYPE, LOW, HIGH, DEFAULT), to which `.turns = true` may be added
 * (nqm_spec_key). The files of MaterialX are read by them, and the
 * models of src/brdf have them as keys. Colours above 1 are those that a conversion to BT.709 can give.
 */
#ifndef NQM_SRC_MATERIAL_SURFACE_KEYS_H
#define NQM_SRC_MATERIAL_SURFACE_KEYS_H

/** Numbers of a value of this type. */
#define NQM_KEY_N(TYPE) (__builtin_strcmp(TYPE, "color3") == 0 ? 3 : __builtin_strcmp(TYPE, "float2") == 0 ? 2 : 1)

/* clang-format off */
#define NQM_OPEN_PBR_KEYS(X)                                                   \
    X(BASE_WEIGHT, "base_weight", "float", 0, 1, 1)                            \
    X(BASE_COLOR, "base_color", "color3", 0, 2, 0.8)                           \
    X(BASE_DIFFUSE_ROUGHNESS, "base_diffuse_roughness", "float", 0, 1, 0)      \
    X(BASE_METALNESS, "base_metalness", "float", 0, 1, 0)                      \
    X(SPECULAR_WEIGHT, "specular_weight", "float", 0, 10, 1)                   \
    X(SPECULAR_COLOR, "specular_color", "color3", 0, 2, 1)                     \
    X(SPECULAR_ROUGHNESS, "specular_roughness", "float", 0, 1, 0.3)            \
    X(SPECULAR_ANISOTROPY, "specular_roughness_anisotropy", "float", 0, 1, 0, .turns = true) \
    X(SPECULAR_IOR, "specular_ior", "float", 0, 100, 1.5)                      \
    X(FUZZ_WEIGHT, "fuzz_weight", "float", 0, 1, 0)                            \
    X(FUZZ_COLOR, "fuzz_color", "color3", 0, 2, 1)                             \
    X(FUZZ_ROUGHNESS, "fuzz_roughness", "float", 0, 1, 0.5)                    \
    X(COAT_WEIGHT, "coat_weight", "float", 0, 1, 0)                            \
    X(COAT_COLOR, "coat_color", "color3", 0, 2, 1)                             \
    X(COAT_ROUGHNESS, "coat_roughness", "float", 0, 1, 0)                      \
    X(COAT_ANISOTROPY, "coat_roughness_anisotropy", "float", 0, 1, 0, .turns = true) \
    X(COAT_IOR, "coat_ior", "float", 0.01, 100, 1.6)                           \
    X(COAT_DARKENING, "coat_darkening", "float", 0, 1, 1)                      \
    X(THIN_FILM_WEIGHT, "thin_film_weight", "float", 0, 1, 0)                  \
    X(THIN_FILM_THICKNESS, "thin_film_thickness", "float", 0, 1000, 0.5)       \
    X(THIN_FILM_IOR, "thin_film_ior", "float", 0, 100, 1.4)

#define NQM_STANDARD_SURFACE_KEYS(X)                                           \
    X(BASE, "base", "float", 0, 1, 1)                                          \
    X(BASE_COLOR, "base_color", "color3", 0, 2, 0.8)                           \
    X(DIFFUSE_ROUGHNESS, "diffuse_roughness", "float", 0, 1, 0)                \
    X(METALNESS, "metalness", "float", 0, 1, 0)                                \
    X(SPECULAR, "specular", "float", 0, 1, 1)                                  \
    X(SPECULAR_COLOR, "specular_color", "color3", 0, 2, 1)                     \
    X(SPECULAR_ROUGHNESS, "specular_roughness", "float", 0, 1, 0.2)            \
    X(SPECULAR_IOR, "specular_IOR", "float", 0, 100, 1.5)                      \
    X(SPECULAR_ANISOTROPY, "specular_anisotropy", "float", 0, 1, 0, .turns = true) \
    X(SPECULAR_ROTATION, "specular_rotation", "float", -1000, 1000, 0, .turns = true) \
    X(SHEEN, "sheen", "float", 0, 1, 0)                                        \
    X(SHEEN_COLOR, "sheen_color", "color3", 0, 2, 1)                           \
    X(SHEEN_ROUGHNESS, "sheen_roughness", "float", 0, 1, 0.3)                  \
    X(COAT, "coat", "float", 0, 1, 0)                                          \
    X(COAT_COLOR, "coat_color", "color3", 0, 2, 1)                             \
    X(COAT_ROUGHNESS, "coat_roughness", "float", 0, 1, 0.1)                    \
    X(COAT_ANISOTROPY, "coat_anisotropy", "float", 0, 1, 0, .turns = true) \
    X(COAT_ROTATION, "coat_rotation", "float", -1000, 1000, 0, .turns = true) \
    X(COAT_IOR, "coat_IOR", "float", 0, 100, 1.5)                              \
    X(COAT_AFFECT_COLOR, "coat_affect_color", "float", 0, 1, 0)                \
    X(COAT_AFFECT_ROUGHNESS, "coat_affect_roughness", "float", 0, 1, 0)        \
    X(THIN_FILM_THICKNESS, "thin_film_thickness", "float", 0, 1000000, 0)      \
    X(THIN_FILM_IOR, "thin_film_IOR", "float", 0, 100, 1.5)

#define NQM_GLTF_KEYS(X)                                                       \
    X(BASE_COLOR, "base_color", "color3", 0, 1, 1)                             \
    X(METALLIC, "metallic", "float", 0, 1, 1)                                  \
    X(ROUGHNESS, "roughness", "float", 0, 1, 1)                                \
    X(ANISOTROPY_STRENGTH, "anisotropy_strength", "float", 0, 1, 0, .turns = true) \
    X(ANISOTROPY_ROTATION, "anisotropy_rotation", "float", -1000, 1000, 0, .turns = true) \
    X(IOR, "ior", "float", 0, 1e7, 1.5)                                        \
    X(SPECULAR, "specular", "float", 0, 1, 1)                                  \
    X(SPECULAR_COLOR, "specular_color", "color3", 0, 1000, 1)                  \
    X(CLEARCOAT, "clearcoat", "float", 0, 1, 0)                                \
    X(CLEARCOAT_ROUGHNESS, "clearcoat_roughness", "float", 0, 1, 0)            \
    X(SHEEN_COLOR, "sheen_color", "color3", 0, 1, 0)                           \
    X(SHEEN_ROUGHNESS, "sheen_roughness", "float", 0, 1, 0)              \
    X(IRIDESCENCE, "iridescence", "float", 0, 1, 0)                            \
    X(IRIDESCENCE_IOR, "iridescence_ior", "float", 0, 100, 1.3)                \
    X(IRIDESCENCE_THICKNESS, "iridescence_thickness", "float", 0, 1000000, 400)

#define NQM_USD_PREVIEW_KEYS(X)                                                \
    X(DIFFUSE_COLOR, "diffuseColor", "color3", 0, 1, 0.18)                     \
    X(USE_SPECULAR_WORKFLOW, "useSpecularWorkflow", "integer", 0, 1, 0)        \
    X(SPECULAR_COLOR, "specularColor", "color3", 0, 1, 0)                      \
    X(METALLIC, "metallic", "float", 0, 1, 0)                                  \
    X(ROUGHNESS, "roughness", "float", 0, 1, 0.5)                              \
    X(CLEARCOAT, "clearcoat", "float", 0, 1, 0)                                \
    X(CLEARCOAT_ROUGHNESS, "clearcoatRoughness", "float", 0, 1, 0.01)          \
    X(IOR, "ior", "float", 0, 100, 1.5)

#define NQM_DISNEY_KEYS(X)                                                     \
    X(BASE_COLOR, "baseColor", "color3", 0, 2, 0.16)                           \
    X(METALLIC, "metallic", "float", 0, 1, 0)                                  \
    X(ROUGHNESS, "roughness", "float", 0, 1, 0.5)                              \
    X(ANISOTROPIC, "anisotropic", "float", 0, 1, 0, .turns = true)              \
    X(SPECULAR, "specular", "float", 0, 1, 0.5)                                \
    X(SPECULAR_TINT, "specularTint", "float", 0, 1, 0)                         \
    X(SHEEN, "sheen", "float", 0, 1, 0)                                        \
    X(SHEEN_TINT, "sheenTint", "float", 0, 1, 0.5)                             \
    X(CLEARCOAT, "clearcoat", "float", 0, 1, 0)                                \
    X(CLEARCOAT_GLOSS, "clearcoatGloss", "float", 0, 1, 1)
/* clang-format on */

#endif
