/* SPDX-License-Identifier: MIT
 *
 * Sampling: order, counts, and each policy for directions without a value.
 */
#include "base/memory_test.h"
#include "brdf/brdf.h"
#include "math/math.h"
#include "sample/sample.h"
#include "support/check.h"

enum { N = 6 };

/* theta_h selects the case, in degrees: below 10 valid, from 10 a negative channel, from 20 no value, from 30
 * infinite. */
static const double degrees[N][3] = {{1, 20, 90}, {12, 10, 0}, {22, 10, 30}, {2, 60, 10}, {31, 5, 5}, {89, 80, 0}};

static void eval_cases(const void *self, size_t n, const double *hd, double *rgb) {
    bool empty = *(const bool *)self;
    for (size_t i = 0; i < n; ++i) {
        double theta_h = hd[3 * i] * (180 / NQM_PI);
        rgb[3 * i] = theta_h < 20 && !empty ? theta_h : NAN;
        rgb[3 * i + 1] = theta_h < 10 ? 2 : -1;
        rgb[3 * i + 2] = theta_h < 30 ? 1e-3 : INFINITY;
    }
}

static const nqm_brdf_class cases = {.format = "test", .eval_half_diff = eval_cases, .free = free_nothing};
static nqm_directions *directions;
static nqm_brdf *brdf, *empty_brdf;

static int setup(void **state) {
    (void)state;
    static bool full = false, empty = true;
    assert_int_equal(nqm_directions_from_degrees(N, &degrees[0][0], &directions, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_wrap(&cases, &full, &(nqm_brdf_info){.name = "cases"}, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_wrap(&cases, &empty, &(nqm_brdf_info){.name = "empty"}, &empty_brdf, NULL), NQM_OK);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    nqm_directions_free(directions);
    nqm_brdf_free(brdf);
    nqm_brdf_free(empty_brdf);
    return 0;
}

TEST(test_values_and_flags) {
    float rgb[N][3];
    uint8_t flag[N];
    nqm_sample_report report;
    assert_int_equal(nqm_sample(brdf, directions, NQM_INVALID_DROP, &rgb[0][0], flag, &report, NULL), NQM_OK);
    const uint8_t expected[N] = {NQM_VALUE_OK, NQM_VALUE_CLAMPED, NQM_VALUE_INVALID,
                                 NQM_VALUE_OK, NQM_VALUE_INVALID, NQM_VALUE_HORIZON};
    assert_memory_equal(flag, expected, N);
    assert_int_equal(report.n, N);
    assert_int_equal(report.n_clamped, 1);
    assert_int_equal(report.n_invalid, 3);
    assert_near(rgb[0][0], 1, 1e-6);
    assert_near(rgb[0][1], 2, 0);
    assert_near(rgb[0][2], 1e-3, 1e-9);
    assert_near(rgb[1][0], 12, 1e-5);
    assert_near(rgb[1][1], 0, 0);
    for (size_t k = 0; k < 3; ++k) {
        assert_near(rgb[2][k], 0, 0);
        assert_near(rgb[4][k], 0, 0);
        assert_near(rgb[5][k], 0, 0);
    }
}

TEST(test_nearest) {
    float rgb[N][3];
    uint8_t flag[N];
    assert_int_equal(nqm_sample(brdf, directions, NQM_INVALID_NEAREST, &rgb[0][0], flag, NULL, NULL), NQM_OK);
    assert_memory_equal(rgb[2], rgb[1], sizeof rgb[1]);
    assert_memory_equal(rgb[4], rgb[1], sizeof rgb[1]);
    assert_int_equal(flag[2], NQM_VALUE_INVALID); /* the flag still marks the value as invalid */
}

/* phi_d is periodic with pi by reciprocity: a hole at 179 degrees is filled from 0, not from 90. */
static void eval_by_azimuth(const void *self, size_t n, const double *hd, double *rgb) {
    (void)self;
    for (size_t i = 0; i < n; ++i) {
        double phi_d = hd[3 * i + 2] * (180 / NQM_PI);
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = phi_d > 170 ? NAN : phi_d;
    }
}

TEST(test_nearest_knows_reciprocity) {
    static const nqm_brdf_class by_azimuth = {
        .format = "test", .eval_half_diff = eval_by_azimuth, .free = free_nothing};
    const double places[3][3] = {{10, 50, 90}, {10, 50, 179}, {10, 50, 0}};
    nqm_directions *three;
    nqm_brdf *azimuth;
    assert_int_equal(nqm_directions_from_degrees(3, &places[0][0], &three, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_wrap(&by_azimuth, NULL, &(nqm_brdf_info){.name = "azimuth"}, &azimuth, NULL), NQM_OK);
    float rgb[3][3];
    assert_int_equal(nqm_sample(azimuth, three, NQM_INVALID_NEAREST, &rgb[0][0], NULL, NULL, NULL), NQM_OK);
    assert_near(rgb[1][0], 0, 0);
    nqm_directions_free(three);
    nqm_brdf_free(azimuth);
}

TEST(test_refusals) {
    float rgb[3 * N];
    nqm_error err = {0};
    nqm_sample_report report;
    assert_int_equal(nqm_sample(brdf, directions, NQM_INVALID_ERROR, rgb, NULL, &report, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "cases: no value at 3 of 6 directions"));
    assert_int_equal(report.n_invalid, 3);
    for (int policy = NQM_INVALID_DROP; policy <= NQM_INVALID_ERROR; ++policy)
        assert_int_equal(nqm_sample(empty_brdf, directions, (nqm_invalid_policy)policy, rgb, NULL, NULL, &err),
                         NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "empty: no value at any of the 6"));
}

TEST(test_policy_words) {
    assert_string_equal(nqm_invalid_words[NQM_INVALID_DROP], "drop");
    assert_string_equal(nqm_invalid_words[NQM_INVALID_ZERO], "zero");
    assert_string_equal(nqm_invalid_words[NQM_INVALID_NEAREST], "nearest");
    assert_string_equal(nqm_invalid_words[NQM_INVALID_ERROR], "error");
    assert_null(nqm_invalid_words[NQM_INVALID_ERROR + 1]);
}

TEST(test_out_of_memory) {
    float rgb[3 * N];
    nqm_alloc_fail_after(0);
    const nqm_status status = nqm_sample(brdf, directions, NQM_INVALID_NEAREST, rgb, NULL, NULL, NULL);
    nqm_alloc_fail_after(-1);
    assert_int_equal(status, NQM_ERR_NOMEM);
}

TEST_FILE(setup, teardown)
