/* SPDX-License-Identifier: MIT
 *
 * The properties of glTF materials that nqm reads, refuses or ignores: the core and the extensions by Khronos.
 */
#include "material/gltf.h"

#define NUMBER(NAME, KEY, DEFAULT)                                                                                     \
    { NAME, nqm_rule_set, KEY, 1, DEFAULT, NULL, NULL, NULL, 0, false }
#define COLOR(NAME, KEY, DEFAULT)                                                                                      \
    { NAME, nqm_rule_set, KEY, 3, DEFAULT, NULL, NULL, NULL, 0, false }
#define TEXTURE(NAME, FACTOR)                                                                                          \
    { NAME, nqm_gltf_read_texture, NULL, 0, 0, NULL, FACTOR, NULL, 0, false }

static const char through[] = "light that passes through the surface is not part of a BRDF";

/* The emission is texture times factor, whose default is 0. Code for the whole material reads what others change. */
const nqm_gltf_group nqm_gltf_members = {
    .name = "the material",
    .rules = {{"emissiveFactor", nqm_rule_later, NULL, 3, 0, NULL, NULL, NULL, 0, false},
              {"emissiveTexture", nqm_gltf_read_texture, NULL, 0, 0,
               "light that the surface emits is not part of a BRDF", "emissiveFactor", NULL, NQM_IGNORE_EMISSION,
               false},
              TEXTURE("normalTexture", NULL),
              {"occlusionTexture", nqm_gltf_read_occlusion, NULL, 0, 0, NULL, NULL, NULL, 0, false},
              NQM_RULE_LATER("name extensions pbrMetallicRoughness alphaMode"),
              NQM_RULE_IGNORED("alphaCutoff doubleSided")}};

const nqm_gltf_group nqm_gltf_core = {
    .name = "pbrMetallicRoughness",
    .rules = {NUMBER("metallicFactor", "metallic", 1),
              {"baseColorFactor", nqm_gltf_read_base_color, "base_color", 4, 1, NULL, NULL, NULL, 0, false},
              NUMBER("roughnessFactor", "roughness", 1),
              TEXTURE("baseColorTexture", NULL),
              TEXTURE("metallicRoughnessTexture", NULL)}};

/* The materials of KHR_materials_specular with an index of 0, as that extension says: its diffuse reflection has the rest of the
 * Fresnel factor. */
const nqm_gltf_group nqm_gltf_glossiness = {
    .name = "KHR_materials_pbrSpecularGlossiness",
    .rules = {{"diffuseFactor", nqm_gltf_read_base_color, "base_color", 4, 1, NULL, NULL, NULL, 0, false},
              COLOR("specularFactor", "specular_color", 1),
              {"glossinessFactor", nqm_gltf_read_glossiness, "roughness", 1, 1, NULL, NULL, NULL, 0, false},
              TEXTURE("diffuseTexture", NULL),
              TEXTURE("specularGlossinessTexture", NULL)}};

const nqm_gltf_group nqm_gltf_extensions[NQM_GLTF_N_EXTENSIONS] = {
    {.name = "KHR_materials_ior", .rules = {NUMBER("ior", "ior", 1.5)}},
    {.name = "KHR_materials_specular",
     .rules = {NUMBER("specularFactor", "specular", 1), COLOR("specularColorFactor", "specular_color", 1),
               TEXTURE("specularTexture", "specularFactor"), TEXTURE("specularColorTexture", "specularFactor")}},
    {.name = "KHR_materials_clearcoat",
     .rules = {NUMBER("clearcoatFactor", "clearcoat", 0), NUMBER("clearcoatRoughnessFactor", "clearcoat_roughness", 0),
               TEXTURE("clearcoatTexture", "clearcoatFactor"), TEXTURE("clearcoatRoughnessTexture", "clearcoatFactor"),
               TEXTURE("clearcoatNormalTexture", "clearcoatFactor")}},
    {.name = "KHR_materials_sheen",
     .rules = {COLOR("sheenColorFactor", "sheen_color", 0), NUMBER("sheenRoughnessFactor", "sheen_roughness", 0),
               TEXTURE("sheenColorTexture", "sheenColorFactor"), TEXTURE("sheenRoughnessTexture", "sheenColorFactor")}},
    {.name = "KHR_materials_transmission",
     .rules = {NQM_RULE_WEIGHT("transmissionFactor", through, NQM_IGNORE_TRANSMISSION),
               NQM_RULE_IGNORED("transmissionTexture")}},
    {.name = "KHR_materials_diffuse_transmission",
     .rules = {NQM_RULE_WEIGHT("diffuseTransmissionFactor", through, NQM_IGNORE_TRANSMISSION),
               NQM_RULE_IGNORED("diffuseTransmissionTexture diffuseTransmissionColorFactor "
                                "diffuseTransmissionColorTexture")}},
    {.name = "KHR_materials_volume",
     .rules = {NQM_RULE_ASIDE("thicknessFactor", "light that enters a volume is not part of a BRDF",
                              NQM_IGNORE_TRANSMISSION),
               NQM_RULE_IGNORED("thicknessTexture attenuationDistance attenuationColor")}},
    {.name = "KHR_materials_anisotropy",
     .rules = {NUMBER("anisotropyStrength", "anisotropy_strength", 0),
               NUMBER("anisotropyRotation", "anisotropy_rotation", 0),
               TEXTURE("anisotropyTexture", "anisotropyStrength")}},
    {.name = "KHR_materials_iridescence",
     .rules = {NUMBER("iridescenceFactor", "iridescence", 0),
               NUMBER("iridescenceIor", "iridescence_ior", 1.3),
               NUMBER("iridescenceThicknessMaximum", "iridescence_thickness", 400),
               {"iridescenceThicknessMinimum", nqm_gltf_read_minimum, NULL, 1, 100, NULL, NULL, NULL, 0, false},
               TEXTURE("iridescenceTexture", "iridescenceFactor"),
               TEXTURE("iridescenceThicknessTexture", "iridescenceFactor")}},
    {.name = "KHR_materials_dispersion",
     .rules = {NQM_RULE_ASIDE("dispersion", "dispersion is not part of a BRDF in RGB", NQM_IGNORE_TRANSMISSION)}},
    {.name = "KHR_materials_emissive_strength", .rules = {NQM_RULE_IGNORED("emissiveStrength")}},
    {.name = "KHR_materials_unlit", .refusal = "a surface without lighting has no BRDF"},
};
