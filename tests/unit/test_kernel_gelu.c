/* SPDX-License-Identifier: MIT
 *
 * GELU and its derivative against erf and exp of the C library in double, over the whole range, at its limits, in
 * place; fused multiply-add in float against the C library; the description of the build.
 */
#include "kernel/kernel.h"
#include "kernel/multiply_add.h"
#include "support/check.h"

static double distribution(double x) {
    return 0.5 * erfc(-x / sqrt(2));
}

static double density(double x) {
    return exp(-0.5 * x * x) / sqrt(2 * acos(-1));
}

TEST(whole_range) {
    enum { N = 200001 };
    static float x[N], y[N], slope[N];
    for (size_t i = 0; i < N; ++i)
        x[i] = -20.0f + 40.0f * (float)i / (N - 1);
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        nqm_kernels_at(t)->gelu(N, x, y, slope);
        double worst = 0;
        for (size_t i = 0; i < N; ++i) {
            double at = (double)x[i], expected = at * distribution(at);
            /* error of the normal distribution (3e-7) plus rounding of the product */
            assert_near((double)y[i], expected, 3e-7 * fabs(at) + 1e-7 * fabs(expected));
            assert_near((double)slope[i], distribution(at) + at * density(at), 6e-7);
            worst = fmax(worst, fabs((double)y[i] - expected));
        }
        print_message("%s: largest difference from the exact GELU: %.2g\n", nqm_kernels_at(t)->name, worst);
    }
}

TEST(far_ends) {
    const float x[] = {0, -0.0f, 1e-30f, -1e-30f, 100, -100, 1e18f, -1e18f};
    float y[8], slope[8];
    nqm_gelu(8, x, y, slope);
    for (size_t i = 0; i < 8; ++i) {
        double at = (double)x[i], expected = fabs(at) < 1 ? at / 2 : fmax(at, 0);
        assert_near((double)y[i], expected, 1e-6 * fabs(expected) + 1e-37);
        assert_near((double)slope[i], fabs(at) < 1 ? 0.5 : at > 0 ? 1 : 0, 1e-6);
    }
    const float nan = NAN;
    nqm_gelu(1, &nan, y, slope);
    assert_true(isnan(y[0]) && isnan(slope[0]));
}

TEST(in_place_and_without_slope) {
    float x[37], y[37], slope[37], alone[37];
    for (size_t i = 0; i < 37; ++i)
        x[i] = 0.3f * (float)i - 5;
    nqm_gelu(37, x, y, slope);
    nqm_gelu(37, x, alone, NULL);
    assert_memory_equal(y, alone, sizeof y);
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        float other[37];
        nqm_kernels_at(t)->gelu(37, x, y, slope);
        nqm_kernels_at(t)->gelu(37, x, alone, NULL);
        assert_memory_equal(y, alone, sizeof y);
        memcpy(other, x, sizeof other);
        nqm_kernels_at(t)->gelu(37, other, other, slope);
        assert_memory_equal(y, other, sizeof y);
    }
    nqm_gelu(37, x, y, slope);
    nqm_gelu(37, x, x, slope);
    assert_memory_equal(y, x, sizeof y);
}

/* The result is rounded once, also with cancellation and for denormal and infinite results. */
TEST(fused_by_hand) {
    nqm_rng rng = nqm_rng_make(1, 0);
    for (size_t i = 0; i < 1000000; ++i) {
        const uint64_t random[2] = {nqm_rng_u64(&rng), nqm_rng_u64(&rng)};
        float x[4];
        memcpy(x, random, sizeof x);
        if (i % 2) /* a b + c cancels */
            x[2] = -(x[0] * x[1]) * (1 + ldexpf(x[3] > 0 ? 1.0f : -1.0f, -(int)(random[1] % 24)));
        const float actual = nqm_multiply_add(x[0], x[1], x[2]), expected = fmaf(x[0], x[1], x[2]);
        assert_true(actual == expected || (isnan(actual) && isnan(expected)));
    }
}

TEST(build_info) {
    const char *line = nqm_build_info();
    print_message("%s\n", line);
    assert_non_null(strstr(line, "libzip 1."));
    assert_null(strchr(line, '\n'));
    assert_ptr_equal(line, nqm_build_info());
}
