/* SPDX-License-Identifier: MIT
 *
 * Fits of anisotropic references: both widths and the azimuth are found, and models of one width stay as they are.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"
#include "support/check.h"

#include <math.h>

static nqm_fit_report fit(const char *ref_spec, const char *model) {
    nqm_brdf *ref = must_open(ref_spec);
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_report report;
    nqm_error err = {0};
    options.n_directions = 2000;
    options.n_starts = 4;
    if (nqm_fit(ref, model, &options, &report, NULL, &err) != NQM_OK)
        fail_msg("%s", err.message);
    nqm_brdf_free(ref);
    return report;
}

/* A model fitted to itself is the same BRDF, also where the spec names the other axis. */
TEST(models_are_recovered) {
    static const char *const specs[][2] = {{"ggx:kd=0.1;ks=1;alpha=0.1,0.4;f0=0.9", "ggx"},
                                           {"rotate:deg=33;of=ggx:kd=0.2,0.1,0.1;ks=1;alpha=0.3,0.06;f0=0.04", "ggx"},
                                           {"rotate:deg=120;of=ward:kd=0.1;ks=0.2;alpha=0.05,0.2", "ward"},
                                           {"ashikhmin-shirley:kd=0.1;ks=0.5;n=20,400;f0=0.3", "ashikhmin-shirley"}};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i) {
        const nqm_fit_report report = fit(specs[i][0], specs[i][1]);
        nqm_brdf *ref = must_open(specs[i][0]), *found = must_open(report.spec);
        nqm_brdf_difference difference;
        assert_true(strncmp(report.spec, "rotate:deg=", 11) == 0 || i == 3);
        assert_int_equal(nqm_brdf_compare(ref, found, 0.05, 1, &difference, NULL), NQM_OK);
        assert_true((double)difference.n_different < 0.02 * (double)difference.n_pairs);
        nqm_brdf_free(ref);
        nqm_brdf_free(found);
    }
}

/* The number that follows a text in a spec. */
static double value_after(const nqm_fit_report *report, const char *text) {
    const char *at = strstr(report->spec, text);
    if (!at)
        fail_msg("%s is not in %s", text, report->spec);
    return strtod(at + strlen(text), NULL);
}

/* Shading models have the anisotropy of the measured lobe, and are turned if they cannot turn it themselves. */
TEST(shading_models) {
    static const char gold[] =
        "gltf:base_color=0.9,0.6,0.3;metallic=1;roughness=0.3;anisotropy_strength=0.6;anisotropy_rotation=0.5";
    const nqm_fit_report same = fit(gold, "gltf"), turned = fit(gold, "open-pbr"), isotropic = fit(gold, "usd-preview");
    assert_true(fabs(value_after(&same, "anisotropy_strength=") - 0.6) < 0.03);
    assert_true(fabs(value_after(&same, "anisotropy_rotation=") - 0.5) < 0.03);
    assert_true(fabs(value_after(&turned, "rotate:deg=") - 28.65) < 1);
    assert_true(fabs(value_after(&turned, "specular_roughness_anisotropy=") - 0.79) < 0.03);
    assert_true(same.loss < 0.3 * isotropic.loss && turned.loss < 0.3 * isotropic.loss);
    assert_true(strncmp(isotropic.spec, "usd-preview:", 12) == 0);
}

/* What the keys of a model say of its lobe is written by the same keys. */
TEST(lobes_are_copied_within_a_model) {
    static const struct {
        const char *from, *to, *keys[2];
    } rows[] = {
        {"gltf:roughness=0.5;anisotropy_strength=0.6", "gltf:roughness=0.2", {"roughness", "anisotropy_strength"}},
        {"open-pbr:specular_roughness=0.5;specular_roughness_anisotropy=0.6",
         "open-pbr:",
         {"specular_roughness", "specular_roughness_anisotropy"}},
        {"standard-surface:specular_roughness=0.5;specular_anisotropy=0.4",
         "standard-surface:",
         {"specular_roughness", "specular_anisotropy"}}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        nqm_brdf *brdf = must_open(rows[i].from);
        nqm_values from, to;
        assert_int_equal(nqm_values_parse_spec(nqm_brdf_get_info(brdf).spec, &from, NULL), NQM_OK);
        assert_int_equal(nqm_values_parse_spec(rows[i].to, &to, NULL), NQM_OK);
        nqm_fit_copy_anisotropy(&from, &to);
        for (size_t k = 0; k < 2; ++k) {
            const double *has = nqm_values_given(&to, rows[i].keys[k]);
            assert_non_null(has);
            assert_near(*has, *nqm_values_given(&from, rows[i].keys[k]), 1e-4);
        }
        nqm_brdf_free(brdf);
    }
}

/* Between models the lobe stays: metals of each have the width and the ratio of that of the reference. */
TEST(lobes_are_copied_between_models) {
    static const char *const specs[] = {"gltf:metallic=1;roughness=0.5;anisotropy_strength=0.6",
                                        "open-pbr:base_metalness=1",
                                        "standard-surface:metalness=1",
                                        "disney:metallic=1;specular=0",
                                        "principled:metallic=1",
                                        "blender-principled:metallic=1",
                                        "rough-conductor:eta=0.2;k=3;distribution=1",
                                        "pbrt-conductor:roughness=0.1;eta=0.2;k=3"};
    nqm_brdf *ref = must_open(specs[0]);
    const nqm_lobe lobe = nqm_lobe_measure(ref);
    nqm_values from, to;
    assert_int_equal(nqm_values_parse_spec(nqm_brdf_get_info(ref).spec, &from, NULL), NQM_OK);
    for (size_t i = 1; i < sizeof specs / sizeof *specs; ++i) {
        assert_int_equal(nqm_values_parse_spec(specs[i], &to, NULL), NQM_OK);
        nqm_fit_copy_anisotropy(&from, &to);
        char *spec = nqm_values_spec(&to);
        nqm_brdf *copy = must_open(spec);
        const nqm_lobe found = nqm_lobe_measure(copy);
        const double ratio = hypot(found.axes[0], found.axes[2]) / hypot(lobe.axes[0], lobe.axes[2]);
        if (fabs(ratio - 1) > 0.02 || fabs(found.width / lobe.width - 1) > 0.02)
            fail_msg("%s: width %g, ratio %g", spec, found.width / lobe.width, ratio);
        nqm_brdf_free(copy);
        nqm_free(spec);
    }
    nqm_brdf_free(ref);
}

TEST(models_of_one_width) {
    assert_true(strncmp(fit("ggx:kd=0.1;ks=1;alpha=0.1,0.4;f0=0.9", "blinn-phong").spec, "blinn-phong:", 12) == 0);
    assert_true(strncmp(fit("ggx:kd=0.1;ks=1;alpha=0.2;f0=0.9", "ggx").spec, "ggx:", 4) == 0);
}
