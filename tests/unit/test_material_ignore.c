/* SPDX-License-Identifier: MIT
 *
 * Materials that do more than reflect: what of them reflects, which properties must be ignored for that, and the prefix
 * "ignore:". Most cases are rows of vectors/materials.txt.
 */
#include "material/maps.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/material_text.h"

#include <nqm/brdf.h>
#include <nqm/texture.h>

#define SURFACE(NODE, INPUTS)                                                                                          \
    "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<image name=\"map\" type=\"float\"><input name=\"file\" "  \
    "type=\"filename\" value=\"a.png\"/></image>\n<" NODE " name=\"s\" type=\"surfaceshader\">\n" INPUTS "</" NODE     \
    ">\n</materialx>\n"
#define IN(NAME, TYPE, VALUE) "<input name=\"" NAME "\" type=\"" TYPE "\" value=\"" VALUE "\"/>\n"
#define MAP(NAME)             "<input name=\"" NAME "\" type=\"float\" nodename=\"map\"/>\n"

/* f_r of what of the material reflects, at a few pairs of directions. */
enum { PAIRS = 4 };
static void evaluate(const char *text, double rgb[3 * PAIRS]) {
    static const double wi[3 * PAIRS] = {0, 0, 1, 0.6, 0, 0.8, -0.48, 0.64, 0.6, 0.96, 0, 0.28};
    static const double wo[3 * PAIRS] = {0, 0.6, 0.8, 0, 0, 1, 0.6, 0, 0.8, -0.6, 0, 0.8};
    nqm_materials *materials = text_as_materials("x.mtlx", text);
    nqm_brdf *brdf = must_open(nqm_materials_reflecting(materials, 0, ~0U).spec);
    nqm_brdf_eval(brdf, PAIRS, wi, wo, rgb, NULL);
    nqm_brdf_free(brdf);
    nqm_materials_free(materials);
}

/* The part has the share t of `one` and the rest of the other; `one` is darker where it must be. */
static void expect_mixture(const char *part, const char *one, const char *other, double t, bool is_darker) {
    double f[3][3 * PAIRS];
    evaluate(part, f[0]);
    evaluate(one, f[1]);
    evaluate(other, f[2]);
    for (size_t i = 0; i < 3 * PAIRS; ++i) {
        assert_near(f[0][i], t * f[1][i] + (1 - t) * f[2][i], 1e-12);
        assert_true(!is_darker || f[1][i] < f[2][i]);
    }
}

/* In the node graphs, a mixture of BSDFs of weights 1 - t and t: its f_r is linear in t, from that without transmission
 * to that with nothing but transmission below the specular reflection. */
#define LINEAR(NODE, KEY, INPUTS)                                                                                      \
    expect_mixture(SURFACE(NODE, INPUTS IN(KEY, "float", "0.25")), SURFACE(NODE, INPUTS IN(KEY, "float", "1")),        \
                   SURFACE(NODE, INPUTS), 0.25, true)

TEST(test_mixture) {
    LINEAR("open_pbr_surface", "transmission_weight", IN("base_color", "color3", "0.7, 0.5, 0.3"));
    LINEAR("standard_surface", "transmission",
           IN("base_color", "color3", "0.7, 0.5, 0.3") IN("diffuse_roughness", "float", "0.5"));
    LINEAR("gltf_pbr", "transmission", IN("base_color", "color3", "0.7, 0.5, 0.3") IN("metallic", "float", "0"));
    LINEAR("disney_principled", "specTrans", IN("baseColor", "color3", "0.7, 0.5, 0.3"));
}

/* What is a metal in part is that part of the metal, as it is without transmission, and the rest of what is no metal. */
#define MIXTURE(NODE, METAL, KEY, INPUTS)                                                                              \
    expect_mixture(SURFACE(NODE, INPUTS IN(KEY, "float", "0.75") IN(METAL, "float", "0.3")),                           \
                   SURFACE(NODE, INPUTS IN(METAL, "float", "1")),                                                      \
                   SURFACE(NODE, INPUTS IN(KEY, "float", "0.75") IN(METAL, "float", "0")), 0.3, false)

TEST(test_metal_in_part) {
    MIXTURE("open_pbr_surface", "base_metalness", "transmission_weight", IN("base_color", "color3", "0.7, 0.5, 0.3"));
    MIXTURE("open_pbr_surface", "base_metalness", "subsurface_weight",
            IN("base_color", "color3", "0.7, 0.5, 0.3") IN("subsurface_color", "color3", "0.1, 0.9, 0.3"));
    MIXTURE("standard_surface", "metalness", "transmission",
            IN("base_color", "color3", "0.7, 0.5, 0.3") IN("sheen", "float", "0.5"));
    MIXTURE("standard_surface", "metalness", "subsurface",
            IN("base_color", "color3", "0.7, 0.5, 0.3") IN("subsurface_color", "color3", "0.1, 0.9, 0.3"));
    MIXTURE("gltf_pbr", "metallic", "transmission",
            IN("base_color", "color3", "0.7, 0.5, 0.3") IN("clearcoat", "float", "0.5"));
    MIXTURE("disney_principled", "metallic", "specTrans", IN("baseColor", "color3", "0.7, 0.5, 0.3"));
}

#define PANE "eta=1.08;k=0.5946427498" /* by NumPy */

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

TEST(test_maps) {
    static const char text[] = SURFACE("gltf_pbr", MAP("transmission") IN("metallic", "float", "0")
                                                       IN("base_color", "color3", "0.8, 0.4, 0.2"));
    nqm_materials *materials = text_as_materials("x.mtlx", text);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    assert_string_equal(info.ignorable, "transmission");
    assert_null(info.reflection);
    assert_int_equal(info.n_maps, 0);
    assert_null(nqm_materials_maps(materials, 0, 0));
    const nqm_textured *t = nqm_materials_maps(materials, 0, NQM_IGNORE_TRANSMISSION);
    assert_non_null(t);
    assert_int_equal(t->n_outputs, 1);
    assert_string_equal(t->outputs[0].key, "base_color");
    assert_int_equal(nqm_materials_reflecting(materials, 0, NQM_IGNORE_TRANSMISSION).n_maps, 1);
    nqm_materials_free(materials);
}

TEST(test_words) {
    unsigned set;
    char words[NQM_IGNORE_SIZE];
    assert_true(nqm_ignore_parse("opacity,transmission", 20, &set));
    assert_string_equal(nqm_ignore_words(set, words), "transmission,opacity");
    assert_string_equal(nqm_ignore_words(63, words), "transmission,subsurface,emission,opacity,displacement,bump");
    assert_false(nqm_ignore_parse("opacity,", 8, &set));
    assert_int_equal(set, 0);
}

TEST(test_arguments) {
    nqm_brdf *brdf;
    nqm_texture *texture;
    nqm_error err = {0};
    char argument[300];
    const char *path = scratch_path("glass.mtlx");
    char text[] = SURFACE("gltf_pbr", IN("transmission", "float", "1") IN("metallic", "float", "0"));
    blob_save(&(blob){(unsigned char *)text, sizeof text - 1}, path);
    assert_int_equal(nqm_brdf_open(path, &brdf, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "--ignore transmission"));
    snprintf(argument, sizeof argument, "ignore:transmission:%s:s", path);
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), NQM_OK);
    assert_string_equal(nqm_brdf_get_info(brdf).name, argument);
    nqm_brdf_free(brdf);
    assert_int_equal(nqm_texture_open(argument, NULL, NULL, &texture, &err), NQM_OK);
    nqm_texture_free(texture);
    snprintf(argument, sizeof argument, "ignore:opacity:%s", path);
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), NQM_ERR_FORMAT);
    snprintf(argument, sizeof argument, "ignore:glass:%s", path);
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_brdf_open("ignore:opacity:lambert:kd=.5", &brdf, &err), NQM_OK);
    nqm_brdf_free(brdf);
}
