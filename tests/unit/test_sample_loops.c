/* SPDX-License-Identifier: MIT
 *
 * The loops over samples, for each width of vectors: against the functions of the C library, and bit for bit against each other.
 */
#include "sample/loops.h"
#include "support/check.h"
#include "support/loops.h"

static const uint64_t seed = 3;

enum { N = 501 };

/* Random values from 1e-26 to 1e34, uniform in the logarithm. */
static void spread(nqm_rng *rng, float *x) {
    for (size_t i = 0; i < N; ++i)
        x[i] = (float)exp(-60 + 138 * nqm_rng_uniform(rng));
}

TEST(samples) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    static float rho[N], root[N], t[N], first[2][N];
    for (int round = 0; round < 20; ++round) {
        spread(&rng, rho);
        rho[0] = 0, rho[1] = 1e-38f, rho[2] = 1e37f, rho[N - 1] = 8;
        for (size_t k = 0; sample_loops_at(k); ++k) {
            sample_loops_at(k)->logs(N, rho, root, t);
            for (size_t i = 2; i < N; ++i) {
                assert_relative((double)root[i], cbrt((double)rho[i]), 4e-7);
                assert_relative((double)t[i], log1p(cbrt((double)rho[i])), 4e-7);
            }
            assert_true(t[0] == 0 && t[1] == 0 && root[0] == 0 && root[1] == 0);
            if (k == 0)
                memcpy(first[0], t, sizeof t), memcpy(first[1], root, sizeof root);
            assert_memory_equal(t, first[0], sizeof t);
            assert_memory_equal(root, first[1], sizeof root);
        }
    }
    const float odd[] = {NAN, 3e38f};
    for (size_t k = 0; sample_loops_at(k); ++k) {
        sample_loops_at(k)->logs(2, odd, t, t);
        assert_true(isnan(t[0]) && t[1] > 28 && t[1] < 30);
    }
}

TEST(limits) {
    nqm_rng rng = nqm_rng_make(seed, 9);
    static float x[N], y[N];
    spread(&rng, x);
    for (size_t k = 0; sample_loops_at(k); ++k) {
        sample_loops_at(k)->limit(N, 1e15f, x, y);
        for (size_t i = 0; i < N; ++i)
            assert_true(y[i] == (x[i] < 1e15f ? x[i] : 1e15f));
    }
}

static double log_ratio(float offset, float x, float y) {
    const double a = (double)x + (double)offset, difference = (double)y - (double)x;
    return fabs(difference) < 0.5 * a ? log1p(difference / a) : log(((double)y + (double)offset) / a);
}

/* Any two values, and two that are close: the relative error does not grow as their difference gets smaller. */
TEST(ratios) {
    const double denormal = 1e-38; /* quotients by a large offset have fewer digits */
    static const float offsets[] = {1e-6f, 0.003f, 1, 30, 1e30f};
    nqm_rng rng = nqm_rng_make(seed, 4);
    static float x[N], y[N], close[N], far[N], near[N], first[2][N], offset[N];
    for (size_t i = 0; i < N; ++i)
        offset[i] = offsets[i % 5];
    for (int round = 0; round < 60; ++round) {
        spread(&rng, x);
        spread(&rng, y);
        x[0] = 0, y[1] = 0, x[2] = 1e37f, y[3] = 1e37f;
        for (size_t i = 0; i < N; ++i)
            close[i] = i % 8 ? x[i] * (1 + ldexpf((float)nqm_rng_normal(&rng), -(int)(i % 24))) : x[i];
        for (size_t i = 0; i < N; ++i)
            close[i] = close[i] < 0 ? 0 : close[i] > 1e37f ? 1e37f : close[i];
        for (size_t k = 0; sample_loops_at(k); ++k) {
            sample_loops_at(k)->log_ratios(N, offset, x, y, far);
            sample_loops_at(k)->log_ratios(N, offset, x, close, near);
            for (size_t i = 0; i < N; ++i) {
                const double a = log_ratio(offset[i], x[i], close[i]), b = log_ratio(offset[i], x[i], y[i]);
                assert_near((double)near[i], a,
                            3e-7 * (fabs(a) < 0.28 ? fabs(a) : fmax(1, fabs(a))) + (offset[i] > 1 ? denormal : 0));
                assert_near((double)far[i], b, 3e-7 * fmax(1, fabs(b)));
            }
            if (k == 0)
                memcpy(first[0], far, sizeof far), memcpy(first[1], near, sizeof near);
            assert_memory_equal(far, first[0], sizeof far);
            assert_memory_equal(near, first[1], sizeof near);
        }
    }
}

/* Any two values, and two that are close. */
TEST(root_differences) {
    nqm_rng rng = nqm_rng_make(seed, 6);
    static float x[N], y[N], scale[N], root_x[N], root_y[N], t[N], by[N], first[N];
    for (int round = 0; round < 40; ++round) {
        for (size_t i = 0; i < N; ++i) {
            x[i] = (float)exp(-70 + 138 * nqm_rng_uniform(&rng));
            y[i] = (float)exp(-70 + 138 * nqm_rng_uniform(&rng));
            scale[i] = (float)nqm_rng_uniform(&rng);
            if (i % 2)
                y[i] = x[i] * (1 + ldexpf(1, -(int)(i % 24)));
        }
        x[0] = y[1] = x[2] = y[2] = 0;
        for (size_t k = 0; sample_loops_at(k); ++k) {
            sample_loops_at(k)->logs(N, x, root_x, t);
            sample_loops_at(k)->logs(N, y, root_y, t);
            sample_loops_at(k)->root_differences(N, scale, x, y, root_x, root_y, by);
            for (size_t i = 0; i < N; ++i) {
                const double difference = (double)y[i] - (double)x[i], a = cbrt((double)x[i]), b = cbrt((double)y[i]);
                const double expected = (double)scale[i] * (difference != 0 ? difference / (a * a + a * b + b * b) : 0);
                assert_near((double)by[i], expected, 2e-6 * fabs(expected) + 1e-10 * (double)scale[i]);
            }
            if (k == 0)
                memcpy(first, by, sizeof by);
            assert_memory_equal(by, first, sizeof by);
        }
    }
}

/* Any of many points may be the nearest; all widths give the same bits. */
TEST(nearest_points) {
    enum { WIDTH = 47, BLOCKS = 3, MOST = BLOCKS * NQM_POINTS };
    nqm_rng rng = nqm_rng_make(seed, 8);
    static float points[WIDTH * MOST];
    float y[WIDTH], first = 0;
    for (size_t i = 0; i < WIDTH * MOST; ++i)
        points[i] = (float)nqm_rng_normal(&rng);
    for (size_t p = 0; p < MOST; ++p) {
        for (size_t i = 0; i < WIDTH; ++i) /* a squared distance of 0.47 from point p */
            y[i] = points[(p / NQM_POINTS * WIDTH + i) * NQM_POINTS + p % NQM_POINTS] + (i % 2 ? 0.1F : -0.1F);
        for (size_t k = 0; sample_loops_at(k); ++k) {
            const float square = sample_loops_at(k)->nearest(WIDTH, BLOCKS, points, y);
            assert_near((double)square, 0.01 * WIDTH, 1e-5);
            if (k == 0)
                first = square;
            assert_true(square == first);
        }
    }
    for (size_t k = 0; sample_loops_at(k); ++k)
        assert_true(isinf(sample_loops_at(k)->nearest(WIDTH, 0, points, y)));
}

TEST(sums_of_magnitudes) {
    enum { MOST = 12 * NQM_SAMPLE_LANES };
    nqm_rng rng = nqm_rng_make(seed, 5);
    static float x[MOST];
    for (size_t i = 0; i < MOST; ++i)
        x[i] = (float)nqm_rng_normal(&rng);
    for (size_t n = 0; n <= MOST; n += NQM_SAMPLE_LANES) {
        float sum, squares, first[2] = {0};
        double expected = 0, expected_squares = 0;
        for (size_t i = 0; i < n; ++i) {
            expected += fabs((double)x[i]);
            expected_squares += (double)x[i] * (double)x[i];
        }
        for (size_t k = 0; sample_loops_at(k); ++k) {
            sample_loops_at(k)->sums(n, x, &sum, &squares);
            assert_near((double)sum, expected, 5e-7 * expected);
            assert_near((double)squares, expected_squares, 5e-7 * expected_squares);
            if (k == 0)
                first[0] = sum, first[1] = squares;
            assert_true(sum == first[0] && squares == first[1]);
        }
    }
}

TEST(scaled_logs) {
    static float t[N], first[N], actual[N];
    for (size_t i = 0; i < N; ++i)
        t[i] = 6.0f * (float)i / N;
    for (int sign = -1; sign <= 1; sign += 2)
        for (size_t k = 0; sample_loops_at(k); ++k) {
            const float k1 = 0.0172f * (float)sign;
            sample_loops_at(k)->scale(N, k1, t, actual);
            if (k == 0)
                memcpy(first, actual, sizeof first);
            assert_memory_equal(actual, first, sizeof actual);
            for (size_t i = 0; i < N; ++i) {
                const double expected = log1p((1 + (double)k1) * expm1((double)t[i]));
                assert_near((double)actual[i], expected, 3e-7 * (1 + expected));
            }
        }
}

/* Whitened pairs and their differences, in exactly sized arrays and in place. */
TEST(whitening) {
    nqm_rng rng = nqm_rng_make(seed, 12);
    enum { P = NQM_WHITEN_PERIOD };
    float *t = random_block(&rng, N + 1), *mean = random_block(&rng, P), *scale = random_block(&rng, P);
    static float actual[4][N + 1], first[3][N + 1];
    for (size_t k = 0; sample_loops_at(k); ++k) {
        const sample_loops *loops = sample_loops_at(k);
        memcpy(actual[0], t, sizeof actual[0]);
        loops->whiten(N, mean, scale, t, actual[1]);
        loops->whiten(N, mean, scale, actual[0], actual[0]);
        assert_true(actual[0][N] == t[N]);
        assert_memory_equal(actual[0], actual[1], N * sizeof *t);
        loops->differences(N, 3, t, actual[1], actual[2], actual[3]);
        if (k == 0)
            memcpy(first, actual[1], sizeof first);
        assert_memory_equal(first, actual[1], sizeof first);
        for (size_t i = 0; i < N; ++i) {
            const double x = ((double)t[i] - (double)mean[i % P]) * (double)scale[i % P];
            assert_near((double)actual[1][i], x, 2e-7 * fabs(x) + 1e-12);
            const double d = (double)actual[1][i] - (double)t[i];
            assert_near((double)actual[2][i], 3 * d, 4e-7 * fabs(d));
            assert_true(actual[3][i] == fabsf(actual[2][i]));
        }
        loops->differences(N, 3, t, actual[1], actual[1], actual[0]);
        assert_memory_equal(actual[1], actual[2], N * sizeof *t);
    }
    nqm_free(t);
    nqm_free(mean);
    nqm_free(scale);
}
