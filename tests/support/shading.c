/* SPDX-License-Identifier: MIT */
#include "support/shading.h"
#include "base/base.h"
#include "math/math.h"

#include <math.h>

double check_shading_vectors(const char *name, size_t n_rows, double relative, double absolute) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector(name), &csv, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(csv), n_rows);
    double largest = 0;
    for (size_t row = 0; row < n_rows; ++row) {
        nqm_brdf *brdf = must_open(nqm_csv_text(csv, row, 0));
        double v[9], rgb[3], swapped[3];
        for (int k = 0; k < 9; ++k)
            v[k] = csv_number(csv, row, k + 1);
        nqm_brdf_eval(brdf, 1, v, v + 3, rgb, NULL);
        nqm_brdf_eval(brdf, 1, v + 3, v, swapped, NULL);
        for (int c = 0; c < 3; ++c) {
            assert_near(rgb[c], v[6 + c], relative * fabs(v[6 + c]) + absolute);
            largest = rgb[c] > 0 ? fmax(largest, fabs(rgb[c] - swapped[c]) / rgb[c]) : largest;
        }
        nqm_brdf_free(brdf);
    }
    nqm_csv_free(csv);
    return largest;
}

static void random_direction(nqm_rng *rng, double *w) {
    const double phi = 2 * NQM_PI * nqm_rng_uniform(rng);
    w[2] = 0.02 + 0.98 * nqm_rng_uniform(rng);
    w[0] = sqrt(1 - w[2] * w[2]) * cos(phi);
    w[1] = sqrt(1 - w[2] * w[2]) * sin(phi);
}

int is_shading_reciprocal(const char *spec) {
    nqm_brdf *brdf = must_open(spec);
    nqm_rng rng = nqm_rng_make(14, 0);
    int reciprocal = 1;
    for (int i = 0; i < 200; ++i) {
        double wi[3], wo[3], rgb[3], swapped[3];
        random_direction(&rng, wi);
        random_direction(&rng, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
        nqm_brdf_eval(brdf, 1, wo, wi, swapped, NULL);
        for (int c = 0; c < 3; ++c)
            reciprocal &= fabs(rgb[c] - swapped[c]) <= 1e-13 * rgb[c];
    }
    nqm_brdf_free(brdf);
    return reciprocal;
}

void check_shading_reciprocity(const char *spec) {
    assert_true(is_shading_reciprocal(spec));
}

double shading_albedo(const char *spec, double theta) {
    enum { N = 120 }; /* midpoints in cosine squared and azimuth */
    nqm_brdf *brdf = must_open(spec);
    const double wi[3] = {sin(theta), 0, cos(theta)};
    double sum[3] = {0};
    for (size_t i = 0; i < N * N; ++i) {
        const double sin2 = ((double)(i / N) + 0.5) / N, phi = ((double)(i % N) + 0.5) / N * NQM_PI;
        const double wo[3] = {sqrt(sin2) * cos(phi), sqrt(sin2) * sin(phi), sqrt(1 - sin2)};
        double rgb[3];
        nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
        for (int c = 0; c < 3; ++c)
            sum[c] += rgb[c] * NQM_PI / (N * N);
    }
    nqm_brdf_free(brdf);
    return fmax(sum[0], fmax(sum[1], sum[2]));
}
