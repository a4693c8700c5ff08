/* SPDX-License-Identifier: MIT
 *
 * Materials that do more than reflect: what of them reflects, which properties must be ignored for that, and the prefix
 * "ignore:". Expected values follow from the node graphs of MaterialX's definitions by hand: the diffuse reflection
 * keeps 1 - transmission, metals all of theirs.
 */
#include "material/maps.h"
#include "support/check.h"
#include "support/map_text.h"
#include "support/material_text.h"
#include "support/temp_file.h"

#include <nqm/brdf.h>
#include <nqm/texture.h>

#define SURFACE(NODE, INPUTS)                                                                                          \
    "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<image name=\"map\" type=\"float\"><input name=\"file\" "  \
    "type=\"filename\" value=\"a.png\"/></image>\n<" NODE " name=\"s\" type=\"surfaceshader\">\n" INPUTS "</" NODE     \
    ">\n</materialx>\n"
#define IN(NAME, TYPE, VALUE) "<input name=\"" NAME "\" type=\"" TYPE "\" value=\"" VALUE "\"/>\n"
#define MAP(NAME)             "<input name=\"" NAME "\" type=\"float\" nodename=\"map\"/>\n"

/* The material is refused unless exactly these words are ignored, and then has these settings in its spec. */
static void expect_reflection(const char *text, const char *words, const char *const *settings) {
    nqm_materials *materials = open_text(text);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    unsigned set;
    if (!info.ignorable || strcmp(info.ignorable, words) != 0)
        fail_msg("%s: ignorable: %s", words,
                 info.ignorable ? info.ignorable
                 : info.refusal ? info.refusal
                                : "accepted");
    assert_non_null(info.refusal);
    assert_null(info.spec);
    assert_true(nqm_ignore_parse(words, strlen(words), &set));
    assert_non_null(nqm_materials_reflecting(materials, 0, set & (set - 1)).refusal); /* one word is missing */
    const nqm_material_info taken = nqm_materials_reflecting(materials, 0, ~0U);
    assert_null(taken.refusal);
    assert_string_equal(taken.spec, info.reflection);
    for (; *settings; ++settings)
        if (!strstr(taken.spec, *settings))
            fail_msg("%s is not in %s", *settings, taken.spec);
    nqm_brdf_free(must_open(taken.spec));
    nqm_materials_free(materials);
}
#define EXPECT(TEXT, WORDS, ...) expect_reflection(TEXT, WORDS, (const char *const[]){__VA_ARGS__, NULL})

TEST(test_transmission) {
    EXPECT(SURFACE("open_pbr_surface", IN("transmission_weight", "float", "0.25") IN("base_weight", "float", "0.8")),
           "transmission", ":base_weight=0.6", "base_color=0.8");
    EXPECT(SURFACE("standard_surface", IN("transmission", "float", "0.5") IN("base", "float", "1")
                                           IN("metalness", "float", "1") IN("sheen", "float", "0.5")),
           "transmission", ":base=1", "sheen=0.5");
    EXPECT(SURFACE("standard_surface",
                   IN("transmission", "float", "0.5") IN("base", "float", "1") IN("sheen", "float", "0.5")),
           "transmission", ":base=0.5", "sheen=0.25");
    EXPECT(SURFACE("gltf_pbr", IN("transmission", "float", "0.75") IN("metallic", "float", "0")
                                   IN("base_color", "color3", "0.8, 0.4, 0.2")),
           "transmission", "base_color=0.2,0.1,0.05");
    EXPECT(SURFACE("disney_principled", IN("specTrans", "float", "0.5") IN("baseColor", "color3", "0.8, 0.4, 0.2")),
           "transmission", "baseColor=0.4,0.2,0.1");
    EXPECT("{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0},"
           "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.5},"
           "\"KHR_materials_volume\":{\"thicknessFactor\":1},"
           "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":0.5}}}]}",
           "transmission", "base_color=0.25");
    EXPECT(
        "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.5]},"
        "\"alphaMode\":\"BLEND\",\"emissiveFactor\":[1,0,0]}]}",
        "emission,opacity", "base_color=1");
    EXPECT("<scene version='3.0.0'><bsdf type='principled' id='a'><float name='spec_trans' value='0.5'/>"
           "<rgb name='base_color' value='0.4 0.2 0.1'/></bsdf></scene>",
           "transmission", "base_color=0.2,0.1,0.05");
}

TEST(test_subsurface) {
    EXPECT(SURFACE("open_pbr_surface",
                   IN("subsurface_weight", "float", "1") IN("subsurface_color", "color3", "0.7, 0.5, 0.3")
                       IN("base_diffuse_roughness", "float", "0.5") IN("base_weight", "float", "0.1")),
           "subsurface", "base_color=0.7,0.5,0.3", "base_weight=1", "base_diffuse_roughness=0");
    EXPECT(SURFACE("open_pbr_surface", IN("subsurface_weight", "float", "0.5") IN("base_color", "color3", "0.5, 0, 1")
                                           IN("subsurface_color", "color3", "0.5, 1, 0")),
           "subsurface", "base_color=0.5,0.5,0.5;");
    EXPECT(SURFACE("open_pbr_surface", IN("subsurface_weight", "float", "1") IN("base_metalness", "float", "1")),
           "subsurface", "base_color=0.8", "base_weight=1");
    EXPECT(SURFACE("standard_surface", IN("subsurface", "float", "1") IN("subsurface_color", "color3", "0.7, 0.5, 0.3")
                                           IN("transmission", "float", "0.5")),
           "transmission,subsurface", "base_color=0.7,0.5,0.3", ":base=0.5");
    EXPECT(SURFACE("standard_surface", IN("subsurface", "float", "1") IN("thin_walled", "boolean", "true")),
           "subsurface", "base_color=0,0,0;", ":base=1");
    EXPECT(SURFACE("open_pbr_surface",
                   IN("subsurface_weight", "float", "1") IN("geometry_thin_walled", "boolean", "true")
                       IN("subsurface_scatter_anisotropy", "float", "0.5") IN("subsurface_color", "color3", "1, 1, 1")),
           "subsurface", "base_color=0.25");
    EXPECT(SURFACE("disney_principled", IN("subsurface", "float", "1") IN("baseColor", "color3", "0.5, 0.5, 0.5")),
           "subsurface", "baseColor=0.5");
}

/* f_r of what of the material reflects, at a few pairs of directions. */
enum { PAIRS = 4 };
static void evaluate(const char *text, double rgb[3 * PAIRS]) {
    static const double wi[3 * PAIRS] = {0, 0, 1, 0.6, 0, 0.8, -0.48, 0.64, 0.6, 0.96, 0, 0.28};
    static const double wo[3 * PAIRS] = {0, 0.6, 0.8, 0, 0, 1, 0.6, 0, 0.8, -0.6, 0, 0.8};
    nqm_materials *materials = open_text(text);
    nqm_brdf *brdf = must_open(nqm_materials_reflecting(materials, 0, ~0U).spec);
    nqm_brdf_eval(brdf, PAIRS, wi, wo, rgb, NULL);
    nqm_brdf_free(brdf);
    nqm_materials_free(materials);
}

/* In the node graphs, a mixture of BSDFs of weights 1 - t and t: its f_r is linear in t, from that without transmission
 * to that with nothing but transmission below the specular reflection. */
static void expect_linear(const char *none, const char *part, const char *all, double t) {
    double f[3][3 * PAIRS];
    evaluate(none, f[0]);
    evaluate(part, f[1]);
    evaluate(all, f[2]);
    for (size_t i = 0; i < 3 * PAIRS; ++i)
        assert_true(fabs(f[1][i] - (1 - t) * f[0][i] - t * f[2][i]) < 1e-12 && f[0][i] > f[2][i]);
}
#define LINEAR(NODE, KEY, INPUTS)                                                                                      \
    expect_linear(SURFACE(NODE, INPUTS), SURFACE(NODE, INPUTS IN(KEY, "float", "0.25")),                               \
                  SURFACE(NODE, INPUTS IN(KEY, "float", "1")), 0.25)

TEST(test_mixture) {
    LINEAR("open_pbr_surface", "transmission_weight", IN("base_color", "color3", "0.7, 0.5, 0.3"));
    LINEAR("standard_surface", "transmission",
           IN("base_color", "color3", "0.7, 0.5, 0.3") IN("diffuse_roughness", "float", "0.5"));
    LINEAR("gltf_pbr", "transmission", IN("base_color", "color3", "0.7, 0.5, 0.3") IN("metallic", "float", "0"));
    LINEAR("disney_principled", "specTrans", IN("baseColor", "color3", "0.7, 0.5, 0.3"));
}

TEST(test_others) {
    EXPECT(SURFACE("open_pbr_surface", IN("emission_luminance", "float", "10") IN("geometry_opacity", "float", "0.5")),
           "emission,opacity", "base_weight=1");
    EXPECT(SURFACE("UsdPreviewSurface", MAP("opacity")), "opacity", "diffuseColor");
    expect_refusal(SURFACE("UsdPreviewSurface", MAP("opacity") IN("displacement", "float", "1")), "displacement");
}

#define BSDF(TYPE, PROPERTIES) "<bsdf type='" TYPE "' id='a'>" PROPERTIES "</bsdf>"
#define SCENE(BSDFS)           "<scene version='3.0.0'>" BSDFS "</scene>"
#define FLOAT(NAME, VALUE)     "<float name='" NAME "' value='" VALUE "'/>"
#define PANE                   "eta=1.08;k=0.5946427498" /* by NumPy */

TEST(test_interfaces) {
    EXPECT(SCENE(BSDF("roughdielectric",
                      FLOAT("alpha_u", ".2") FLOAT("alpha_v", ".3") FLOAT("int_ior", "1.5") FLOAT("ext_ior", "1")
                          FLOAT("specular_reflectance", ".5") FLOAT("specular_transmittance", "0"))),
           "transmission", "rough-conductor:", "alpha=0.2,0.3;eta=1.5;k=0", "specular_reflectance=0.5");
    EXPECT(SCENE(BSDF("dielectric", "<string name='int_ior' value='diamond'/>" FLOAT("ext_ior", "1"))), "transmission",
           "rough-conductor:alpha=0.0001;", "eta=2.419;k=0");
    EXPECT(SCENE(BSDF("thindielectric", FLOAT("int_ior", "1.5") FLOAT("ext_ior", "1"))), "transmission", PANE);
    EXPECT("Material \"dielectric\" \"float roughness\" .09 \"spectrum eta\" \"glass-F11\"", "transmission",
           "pbrt-conductor:roughness=0.09;eta=1.78472;k=0");
    EXPECT("Material \"dielectric\"", "transmission", "pbrt-conductor:roughness=1e-06;eta=1.5;k=0");
    EXPECT("Material \"thindielectric\" \"float eta\" 1.5", "transmission", "roughness=1e-06;" PANE);
    EXPECT("Material \"subsurface\" \"float roughness\" .09 \"rgb mfp\" [1 2 3]", "subsurface",
           "pbrt-conductor:roughness=0.09;eta=1.33;k=0");
    EXPECT("Material \"diffusetransmission\" \"rgb reflectance\" [.2 .4 .6] \"float scale\" .5", "transmission",
           "lambert:kd=0.1,0.2,0.3");
    expect_refusal(SCENE(BSDF("dielectric", "<string name='int_ior' value='cheese'/>")), "cheese");
    expect_refusal(SCENE(BSDF("dielectric", FLOAT("alpha", ".1"))), "alpha");
    expect_refusal(SCENE(BSDF("dielectric", FLOAT("ext_ior", "0"))), "refraction is inf");
    expect_refusal("Material \"dielectric\" \"spectrum eta\" \"glass-X\"", "glass-X");
    expect_refusal("Material \"dielectric\" \"float vroughness\" -1", "negative");
    expect_refusal("Material \"dielectric\" \"float eta\" -1.5", "refraction is -1.5");
    expect_refusal("Material \"thindielectric\" \"float roughness\" .1", "roughness");
}

/* The interface reflects as that of `rough-plastic`, whose Fresnel factor has a formula of its own; a pane as both faces of it. */
TEST(test_reflectances) {
    static const char *const specs[] = {"rough-plastic:alpha=.3;eta=1.5;diffuse_reflectance=0",
                                        "rough-conductor:alpha=.3;eta=1.5;k=0", "rough-conductor:alpha=.3;" PANE,
                                        "rough-conductor:alpha=.3" /* of reflectance 1 */};
    const double wi[] = {0, 0, 1, 0.6, 0, 0.8, 0.8, 0, 0.6, 0.96, 0, 0.28};
    const double wo[] = {0, 0, 1, -0.6, 0, 0.8, -0.8, 0, 0.6, -0.96, 0, 0.28};
    double f[4][12];
    for (size_t i = 0; i < 4; ++i) {
        nqm_brdf *brdf = must_open(specs[i]);
        nqm_brdf_eval(brdf, 4, wi, wo, f[i], NULL);
        nqm_brdf_free(brdf);
    }
    for (size_t i = 0; i < 12; ++i) {
        const double one = f[1][i] / f[3][i], both = 2 * one / (1 + one), error = f[2][i] / f[3][i] / both - 1;
        assert_true(fabs(f[1][i] / f[0][i] - 1) < 1e-9);
        assert_true(fabs(error) < (i < 3 ? 1e-9 : 0.12));
    }
    assert_true(fabs(f[1][0] / f[3][0] - 0.04) < 1e-12);
}

TEST(test_masks) {
#define MASK(OPACITY)                                                                                                  \
    SCENE("<bsdf type='mask' id='m'>" OPACITY "<bsdf type='twosided'>" BSDF("diffuse", "") "</bsdf></bsdf>")
    EXPECT(MASK(""), "opacity", "lambert:kd=0.5");
    EXPECT(MASK("<texture name='opacity' type='bitmap'><string name='filename' value='a.png'/></texture>"), "opacity",
           "lambert:kd=0.5");
    expect_spec(MASK(FLOAT("opacity", "1")), "lambert:kd=0.5");
    expect_refusal(MASK("<string name='opacity' value='x'/>"), "opacity");
    expect_refusal(SCENE("<bsdf type='mask'/>"), "contains no BSDF");
    EXPECT(SCENE("<bsdf type='mask' id='m'>" BSDF("roughdielectric", "") "</bsdf>"), "transmission,opacity", "k=0");
    EXPECT("{\"type\": \"blender-principled\", \"transmission_weight\": 0.5, \"alpha\": 0.5, \"emission_strength\": 1, "
           "\"subsurface_weight\": 1, \"base_color\": {\"type\": \"rgb\", \"value\": [0.8, 0.4, 0.2]}}",
           "transmission,subsurface,emission,opacity", "base_color=0.4,0.2,0.1");
}

TEST(test_maps) {
    static const char text[] = SURFACE("gltf_pbr", MAP("transmission") IN("metallic", "float", "0")
                                                       IN("base_color", "color3", "0.8, 0.4, 0.2"));
    nqm_materials *materials = open_text(text);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    assert_string_equal(info.ignorable, "transmission");
    assert_null(info.reflection);
    assert_int_equal(info.n_maps, 0);
    assert_null(nqm_materials_textured(materials, 0));
    const nqm_textured *t = nqm_materials_maps(materials, 0, NQM_IGNORE_TRANSMISSION);
    assert_non_null(t);
    assert_int_equal(t->n_outputs, 1);
    assert_string_equal(t->outputs[0].key, "base_color");
    assert_int_equal(nqm_materials_reflecting(materials, 0, NQM_IGNORE_TRANSMISSION).n_maps, 1);
    nqm_materials_free(materials);
    expect_survives_no_memory(text);
}

TEST(test_prefix) {
    unsigned set;
    char words[NQM_IGNORE_SIZE];
    assert_int_equal(nqm_ignore_prefix("ignore:opacity,transmission:a.gltf:b", &set), 28);
    assert_string_equal(nqm_ignore_words(set, words), "transmission,opacity");
    assert_string_equal(nqm_ignore_words(15, words), "transmission,subsurface,emission,opacity");
    assert_int_equal(nqm_ignore_prefix("ignore:opacity", &set), 0);
    assert_int_equal(nqm_ignore_prefix("ignored:opacity:a", &set), 0);
    assert_int_equal(nqm_ignore_prefix("ignore::a", &set), 8);
    assert_int_equal(set, 0);
    assert_false(nqm_ignore_parse("opacity,", 8, &set));
}

TEST(test_arguments) {
    nqm_brdf *brdf;
    nqm_texture *texture;
    nqm_error err = {0};
    char argument[300];
    nqm_materials_free(open_text(SURFACE("gltf_pbr", IN("transmission", "float", "1") IN("metallic", "float", "0"))));
    assert_int_equal(nqm_brdf_open(temp_file, &brdf, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "--ignore transmission"));
    snprintf(argument, sizeof argument, "ignore:transmission:%s:s", temp_file);
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), NQM_OK);
    assert_string_equal(nqm_brdf_get_info(brdf).name, argument);
    nqm_brdf_free(brdf);
    assert_int_equal(nqm_texture_open(argument, NULL, NULL, &texture, &err), NQM_OK);
    nqm_texture_free(texture);
    snprintf(argument, sizeof argument, "ignore:opacity:%s", temp_file);
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), NQM_ERR_FORMAT);
    snprintf(argument, sizeof argument, "ignore:glass:%s", temp_file);
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_brdf_open("ignore:opacity:lambert:kd=.5", &brdf, &err), NQM_OK);
    nqm_brdf_free(brdf);
}

TEST_FILE(make_temp_file, remove_temp_file)
