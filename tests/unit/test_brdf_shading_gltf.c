/* SPDX-License-Identifier: MIT
 *
 * The shading model of glTF against its specification in 80-bit floats (tests/vectors/shading_gltf.py), the albedo of its sheen
 * against quadrature (sheen_albedo.py), reciprocity where it holds, and light that is neither lost nor gained.
 */
#include "math/math.h"
#include "support/check.h"
#include "support/shading.h"

TEST(gltf_is_its_specification) {
    check_shading_vectors("shading_gltf.csv", 632, 1e-9, 1e-15);
}

TEST(gltf_is_reciprocal_without_clear_coat) {
    check_shading_reciprocity(
        "gltf:base_color=.8,.2,.1;metallic=.3;roughness=.4;sheen_color=.5,.2,.6;sheen_roughness=.3");
    assert_int_equal(is_shading_reciprocal("gltf:metallic=0;clearcoat=1"), 0);
}

/* E = 1 - what the sheen lets pass of a white base. */
TEST(sheen_keeps_the_light_that_it_reflects) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("sheen_albedo.csv"), &csv, NULL), NQM_OK);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        const double cosine = csv_number(csv, row, 1), w[3] = {sqrt(1 - cosine * cosine), 0, cosine};
        double f[3], value[3];
        for (int i = 0; i < 3; ++i) {
            char spec[200];
            snprintf(spec, sizeof spec, "gltf:metallic=0;base_color=%d;specular=0;sheen_color=%d;sheen_roughness=%s",
                     i != 1, i != 0, nqm_csv_text(csv, row, 0));
            nqm_brdf *brdf = must_open(spec);
            nqm_brdf_eval(brdf, 1, w, w, value, NULL);
            f[i] = value[0];
            nqm_brdf_free(brdf);
        }
        assert_near(1 - (f[2] - f[1]) / f[0], csv_number(csv, row, 2), 0.01);
    }
    nqm_csv_free(csv);
}

/* Not at grazing angles, where the specification itself says that its Fresnel mix gains light. */
TEST(albedos_are_plausible) {
    static const char *const specs[] = {"gltf:roughness=.4", "gltf:metallic=0;roughness=.5",
                                        "gltf:metallic=0;roughness=.5;clearcoat=1;clearcoat_roughness=.3",
                                        "gltf:metallic=0;roughness=.7;sheen_color=1;sheen_roughness=.6",
                                        "gltf:metallic=0;roughness=.3;specular_color=20;ior=1.6"};
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i)
        for (double theta = 0; theta < 1; theta += 0.3)
            assert_near(shading_albedo(specs[i], theta), 0.93, 0.08);
}
