/* SPDX-License-Identifier: MIT
 *
 * Blender's Principled BSDF against an evaluation in 80-bit floats (tests/vectors/shading_blender.py) and what Cycles renders
 * (cycles_principled.py), and the energy of its lobes.
 */
#include "support/shading.h"
#include "support/test.h"

TEST(values_are_those_of_the_formulas) {
    check_shading_vectors("shading_blender.csv", 160, 1e-9, 1e-15);
}

/* It has floats, and its tables other samples. */
TEST(values_are_those_of_cycles) {
    check_shading_vectors("cycles_principled.csv", 330, 1e-4, 2e-5);
}

/* A white furnace: Cycles reflects what arrives, within the errors of its tables and of the layers. A rough coat loses light. */
TEST(white_reflects_everything) {
    static const char *const specs[] = {"base_color=1", "base_color=1;metallic=1;roughness=1",
                                        "base_color=1;roughness=.3;coat_weight=1;coat_roughness=.2"};
    for (size_t i = 0; i < 3; ++i)
        for (double cosine = 0.3; cosine < 1; cosine += 0.3) {
            double albedo[3];
            char spec[120];
            snprintf(spec, sizeof spec, "blender-principled:%s", specs[i]);
            nqm_brdf *brdf = must_open(spec);
            enum { N = 96 };
            double sum = 0;
            for (int k = 0; k < N * N; ++k) {
                const double cos2 = (k / N + 0.5) / N, phi = (k % N + 0.5) / N * acos(-1), r = sqrt(1 - cos2);
                const double wi[3] = {r * cos(phi), r * sin(phi), sqrt(cos2)};
                const double wo[3] = {sqrt(1 - cosine * cosine), 0, cosine};
                nqm_brdf_eval(brdf, 1, wi, wo, albedo, NULL);
                sum += albedo[1] * acos(-1) / (N * N);
            }
            assert_near(sum, 1, 0.02);
            nqm_brdf_free(brdf);
        }
}
