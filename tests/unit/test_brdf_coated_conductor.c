/* SPDX-License-Identifier: MIT
 *
 * pbrt's coatedconductor against 400,000 random walks a pair (tests/vectors/shading_coated_conductor.py), symmetries,
 * and limits that have a closed form.
 */
#include "support/check.h"

#define METAL "conductor.eta=.2,.9,1.5;conductor.k=3.9,2.4,1.2;"

static void eval_spec(const char *spec, const double *wi, const double *wo, double *rgb) {
    nqm_brdf *brdf = must_open(spec);
    nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
    nqm_brdf_free(brdf);
}

/* D G / (4 cos cos) of an interface of this roughness: pbrt's conductor that reflects all light. */
static double lobe(double roughness, const double *wi, const double *wo) {
    char spec[100];
    double rgb[3];
    snprintf(spec, sizeof spec, "pbrt-conductor:roughness=%g;eta=0;k=1", roughness);
    eval_spec(spec, wi, wo, rgb);
    return rgb[0];
}

/* Of a dielectric with a relative index eta. */
static double fresnel(double eta, double c) {
    const double g = sqrt(eta * eta + c * c - 1), a = (g - c) / (g + c), b = ((g + c) * c - 1) / ((g - c) * c + 1);
    return a * a * (1 + b * b) / 2;
}

/* Smooth interfaces: the vectors lack their mirror, which has a roughness of 1e-6 here. Mirrors: a reflectance. */
TEST(values_are_means_of_random_walks) {
    nqm_csv *csv;
    double largest = 0, squares = 0;
    assert_int_equal(nqm_csv_load(test_vector("shading_coated_conductor.csv"), &csv, NULL), NQM_OK);
    const size_t n = nqm_csv_rows(csv);
    assert_true(n == 44);
    for (size_t row = 0; row < n; ++row) {
        const char *spec = nqm_csv_text(csv, row, 0);
        const bool is_smooth = strstr(spec, "interface.roughness=0;"), is_mirror = csv_number(csv, row, 10) == 0;
        double v[12], rgb[3], eta = strtod(strstr(spec, "interface.eta=") + 14, NULL);
        for (int k = 0; k < 12; ++k)
            v[k] = csv_number(csv, row, k + 1);
        eval_spec(spec, v, v + 3, rgb);
        const double mirror = is_smooth ? lobe(1e-6, v, v + 3) : 0;
        const double x = v[0] + v[3], y = v[1] + v[4], z = v[2] + v[5];
        const double f = fresnel(eta, sqrt(x * x + y * y + z * z) / 2);
        for (int k = 0; k < 3; ++k) {
            const double value = is_mirror ? rgb[k] / mirror : rgb[k] - f * mirror, error = value / v[6 + k] - 1;
            assert_near(value, v[6 + k], (is_mirror ? 2e-4 : 0.08) * v[6 + k] + 4 * v[9 + k]);
            largest = fmax(largest, fabs(error));
            squares += error * error;
        }
    }
    print_message("largest relative difference %.2g, rms %.2g\n", largest, sqrt(squares / (3 * (double)n)));
    assert_true(squares < 0.02 * 0.02 * 3 * (double)n);
    nqm_csv_free(csv);
}

/* Rotations and reflections of a pair change nothing but rounding, at the normal too. */
TEST(values_are_isotropic) {
    static const double pairs[][6] = {{0.6, 0, 0.8, -0.28, 0.3, 0}, {0, 0, 1, 0.6, 0, 0.8}, {0.6, 0, 0.8, 0, 0, 1}};
    nqm_brdf *brdf = must_open("pbrt-coated-conductor:" METAL "interface.roughness=.1;conductor.roughness=.2");
    for (size_t k = 0; k < 3; ++k) {
        const double *p = pairs[k];
        double first[3], rgb[3], wi[3] = {p[0], p[1], p[2]}, wo[3] = {p[3], p[4], sqrt(1 - p[3] * p[3] - p[4] * p[4])};
        nqm_brdf_eval(brdf, 1, wi, wo, first, NULL);
        for (int turn = 1; turn < 8; ++turn) {
            const double c = cos(turn), s = sin(turn), m = turn % 2 ? 1 : -1;
            double a[3] = {c * wi[0] - s * wi[1] * m, s * wi[0] + c * wi[1] * m, wi[2]},
                   b[3] = {c * wo[0] - s * wo[1] * m, s * wo[0] + c * wo[1] * m, wo[2]};
            nqm_brdf_eval(brdf, 1, a, b, rgb, NULL);
            for (int i = 0; i < 3; ++i)
                assert_near(rgb[i], first[i], 1e-9 * first[i]);
        }
    }
    nqm_brdf_free(brdf);
}

/* Values do not depend on what else is evaluated with them. */
TEST(values_are_repeated) {
    static const double wi[9] = {0.6, 0, 0.8, 0, 0.6, 0.8, 0, 0, 1}, wo[9] = {0, 0.6, 0.8, 0, 0.6, 0.8, 0.6, 0, 0.8};
    double all[9], one[3];
    nqm_brdf *brdf = must_open("pbrt-coated-conductor:" METAL "interface.roughness=.1;conductor.roughness=.2");
    nqm_brdf_eval(brdf, 3, wi, wo, all, NULL);
    for (size_t k = 0; k < 3; ++k) {
        nqm_brdf_eval(brdf, 1, wi + 3 * k, wo + 3 * k, one, NULL);
        assert_memory_equal(one, all + 3 * k, sizeof one);
    }
    nqm_brdf_free(brdf);
}

/* A gap that absorbs everything leaves the interface; below a smooth interface, the first order is the conductor's value for the
 * refracted directions. */
TEST(limits_are_known) {
    static const double wi[3] = {0.6, 0, 0.8}, wo[3] = {-0.28, 0, 0.96};
    const double ti[3] = {0.4, 0, sqrt(1 - 0.4 * 0.4)}, to[3] = {-0.28 / 1.5, 0, sqrt(1 - 0.28 * 0.28 / 2.25)};
    double coat[3], metal[3];
    eval_spec("pbrt-coated-conductor:" METAL "interface.roughness=.2;conductor.roughness=.1;thickness=100", wi, wo,
              coat);
    eval_spec("pbrt-conductor:roughness=.2;eta=1.5;k=0", wi, wo, metal);
    assert_near(coat[0], metal[0], 1e-12 * metal[0]);
    eval_spec("pbrt-coated-conductor:conductor.eta=.3,.9,1.5;conductor.k=3,2.4,1.2;conductor.roughness=.1;maxdepth=1",
              wi, wo, coat);
    eval_spec("pbrt-conductor:roughness=.1;eta=.2,.6,1;k=2,1.6,.8", ti, to, metal);
    const double through =
        (1 - fresnel(1.5, 0.8)) * (1 - fresnel(1.5, 0.96)) * exp(-0.01 / ti[2] - 0.01 / to[2]) / 2.25;
    const double mirror = lobe(1e-6, wi, wo) * fresnel(1.5, sqrt(0.32 * 0.32 + 1.76 * 1.76) / 2);
    for (int c = 0; c < 3; ++c)
        assert_near(coat[c], through * metal[c] + mirror, 1e-4 * coat[c]);
}
