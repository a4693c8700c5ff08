/* SPDX-License-Identifier: MIT
 *
 * The surface shaders of MaterialX against their node graphs in 80-bit floats (tests/vectors/shading_materialx.py), and their
 * energy.
 */
#include "io/io.h"
#include "math/math.h"
#include "support/rows.h"
#include "support/shading.h"
#include "support/test.h"
#include <nqm/brdf.h>

TEST(test_node_graphs) {
    check_shading_vectors("shading_materialx.csv", 940, 1e-9, 1e-13);
}

/* The integral over lights at a fixed viewer, which is the albedo that layers use. */
static double albedo_of(const nqm_brdf *brdf, double theta_o) {
    enum { N = 64 };
    const double wo[3] = {sin(theta_o), 0, cos(theta_o)};
    double sum = 0;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) {
            const double cos2 = (i + 0.5) / N, phi = (j + 0.5) / N * NQM_PI, r = sqrt(1 - cos2);
            const double wi[3] = {r * cos(phi), r * sin(phi), sqrt(cos2)};
            double rgb[3];
            nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
            sum += rgb[1];
        }
    return sum * NQM_PI / (N * N);
}

/* No light is made, within the error of the fits of directional albedos and of Schlick's factor in them. */
TEST(test_energy) {
    EVERY_ROW(row, "surfaces without too much light") {
        nqm_brdf *brdf = must_open(row[0]);
        for (double theta = 0.1; theta < 1.4; theta += 0.3) {
            const double albedo = albedo_of(brdf, theta);
            if (!(albedo < 1.04))
                fail_msg("%s: albedo %g at %g rad", row[0], albedo, theta);
        }
        nqm_brdf_free(brdf);
    }
}

/* At roughness 0 the energy-preserving model of Oren and Nayar is Lambert's. */
TEST(test_lambert) {
    nqm_brdf *brdf = must_open("open-pbr:base_color=.5;specular_weight=0;specular_ior=1");
    const double wi[3] = {0.6, 0, 0.8}, wo[3] = {0, 0.6, 0.8};
    double rgb[3];
    nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
    assert_true(rgb[0] > 0.4 / 3.15 && rgb[0] < 0.5 / 3.14); /* the layer takes its F90 share */
    nqm_brdf_free(brdf);
}

/* Keys of anisotropy: those that are 0 or equal are isotropic; values outside of their range are refused. */
TEST(test_anisotropy) {
    EVERY_ROW(row, "specs with keys of anisotropy") {
        nqm_brdf *brdf = must_open(row[0]);
        assert_int_equal(nqm_brdf_get_info(brdf).isotropic, atoi(row[1]));
        nqm_brdf_free(brdf);
    }
    EVERY_ROW(row, "faulty keys of anisotropy") {
        nqm_brdf *brdf;
        assert_int_equal(nqm_brdf_open(row[0], &brdf, NULL), NQM_ERR_ARG);
    }
}

/* A rotation of Standard Surface turns the material clockwise. */
TEST(test_rotation) {
    nqm_brdf *turned = must_open("standard-surface:metalness=1;specular_anisotropy=.7;specular_rotation=.0625");
    nqm_brdf *plain = must_open("standard-surface:metalness=1;specular_anisotropy=.7");
    const double turn[2] = {-sin(NQM_PI / 8), cos(NQM_PI / 8)}, wi[3] = {0.48, 0.36, 0.8}, wo[3] = {-0.6, 0, 0.8};
    double in[3], out[3], a[3], b[3];
    nqm_turn3(turn, wi, in);
    nqm_turn3(turn, wo, out);
    nqm_brdf_eval(plain, 1, wi, wo, a, NULL);
    nqm_brdf_eval(turned, 1, in, out, b, NULL);
    assert_near(a[0], b[0], 1e-12 * a[0]);
    nqm_brdf_eval(turned, 1, wi, wo, b, NULL);
    assert_true(fabs(a[0] - b[0]) > 0.01 * a[0]);
    nqm_brdf_free(turned);
    nqm_brdf_free(plain);
}
