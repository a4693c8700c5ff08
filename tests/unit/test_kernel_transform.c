/* SPDX-License-Identifier: MIT
 *
 * Roots and logarithms of samples, rounding of rows and products of one row: every table against the plain loops and,
 * bit for bit, against the other tables.
 */
#include "kernel/panel.h"
#include "support/check.h"
#include "support/tables.h"

#include <math.h>
#include <string.h>

static const uint64_t seed = 3;

enum { N = 501 };

/* Random values from 1e-26 to 1e34, uniform in the logarithm. */
static void spread(nqm_rng *rng, float *x) {
    for (size_t i = 0; i < N; ++i)
        x[i] = (float)exp(-60 + 138 * nqm_rng_uniform(rng));
}

static void samples(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(seed, 0);
    static float rho[N], root[N], t[N], first[2][N];
    for (int round = 0; round < 20; ++round) {
        spread(&rng, rho);
        rho[0] = 0, rho[1] = 1e-38f, rho[2] = 1e37f, rho[N - 1] = 8;
        for (size_t k = 0; every_table(k); ++k) {
            every_table(k)->sample_log(N, rho, root, t);
            for (size_t i = 2; i < N; ++i) {
                assert_relative((double)root[i], cbrt((double)rho[i]), 4e-7);
                assert_relative((double)t[i], log1p(cbrt((double)rho[i])), 4e-7);
            }
            assert_true(t[0] == 0 && t[1] == 0 && root[0] == 0 && root[1] == 0);
            if (k == 0)
                memcpy(first[0], t, sizeof t), memcpy(first[1], root, sizeof root);
            if (every_table(k) != &nqm_kernels_scalar) {
                assert_memory_equal(t, first[0], sizeof t);
                assert_memory_equal(root, first[1], sizeof root);
            }
        }
    }
    const float odd[] = {NAN, 3e38f};
    for (size_t k = 0; every_table(k); ++k) {
        every_table(k)->sample_log(2, odd, t, t);
        assert_true(isnan(t[0]) && t[1] > 28 && t[1] < 30);
    }
}

static void roots_and_logarithms(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(seed, 1);
    static float x32[N];
    static double x[N], root[N], y[N], near_minus_1[N], z[N], first[3][N];
    for (int round = 0; round < 20; ++round) {
        spread(&rng, x32);
        for (size_t i = 0; i < N; ++i) {
            x[i] = (double)x32[i];
            near_minus_1[i] = x[i] - 0.997;
        }
        for (size_t k = 0; every_table(k); ++k) {
            const nqm_kernels *kernels = every_table(k);
            kernels->cube_root(N, x, root);
            kernels->log_1p(N, x, y);
            kernels->log_1p(N, near_minus_1, z);
            for (size_t i = 0; i < N; ++i) {
                double expected = log1p(near_minus_1[i]);
                assert_relative(root[i], cbrt(x[i]), 1e-15);
                assert_relative(y[i], log1p(x[i]), 1e-15);
                assert_near(z[i], expected, 4e-16 * fmax(1, fabs(expected)));
            }
            const double *all[] = {root, y, z};
            for (size_t j = 0; j < 3; ++j) {
                if (k == 0)
                    memcpy(first[j], all[j], sizeof first[j]);
                if (kernels != &nqm_kernels_scalar)
                    assert_memory_equal(all[j], first[j], sizeof first[j]);
            }
        }
    }
    const double odd[] = {NAN, 0};
    for (size_t k = 0; every_table(k); ++k) {
        every_table(k)->cube_root(2, odd, root);
        every_table(k)->log_1p(2, odd, y);
        assert_true(isnan(root[0]) && isnan(y[0]) && root[1] == 0 && y[1] == 0);
    }
}

static double log_ratio(float offset, float x, float y) {
    const double a = (double)x + (double)offset, difference = (double)y - (double)x;
    return fabs(difference) < 0.5 * a ? log1p(difference / a) : log(((double)y + (double)offset) / a);
}

/* Any two values, and two that are close: the relative error does not grow as their difference gets smaller. */
static void ratios(void **state) {
    (void)state;
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
        for (size_t k = 0; every_table(k); ++k) {
            every_table(k)->log_ratio(N, offset, x, y, far);
            every_table(k)->log_ratio(N, offset, x, close, near);
            for (size_t i = 0; i < N; ++i) {
                const double a = log_ratio(offset[i], x[i], close[i]), b = log_ratio(offset[i], x[i], y[i]);
                assert_near((double)near[i], a,
                            3e-7 * (fabs(a) < 0.28 ? fabs(a) : fmax(1, fabs(a))) + (offset[i] > 1 ? denormal : 0));
                assert_near((double)far[i], b, 3e-7 * fmax(1, fabs(b)));
            }
            if (k == 0)
                memcpy(first[0], far, sizeof far), memcpy(first[1], near, sizeof near);
            if (every_table(k) != &nqm_kernels_scalar) {
                assert_memory_equal(far, first[0], sizeof far);
                assert_memory_equal(near, first[1], sizeof near);
            }
        }
    }
}

/* Any two values, and two that are close. */
static void root_differences(void **state) {
    (void)state;
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
        for (size_t k = 0; every_table(k); ++k) {
            every_table(k)->sample_log(N, x, root_x, t);
            every_table(k)->sample_log(N, y, root_y, t);
            every_table(k)->root_difference(N, scale, x, y, root_x, root_y, by);
            for (size_t i = 0; i < N; ++i) {
                const double difference = (double)y[i] - (double)x[i], a = cbrt((double)x[i]), b = cbrt((double)y[i]);
                const double expected = (double)scale[i] * (difference != 0 ? difference / (a * a + a * b + b * b) : 0);
                assert_near((double)by[i], expected, 2e-6 * fabs(expected) + 1e-10 * (double)scale[i]);
            }
            if (k == 0)
                memcpy(first, by, sizeof by);
            assert_true(every_table(k) == &nqm_kernels_scalar || memcmp(by, first, sizeof by) == 0);
        }
    }
}

/* Any of many points may be the nearest; all but the scalar table give the same bits. */
static void nearest_points(void **state) {
    (void)state;
    enum { WIDTH = 47, BLOCKS = 3, MOST = BLOCKS * NQM_POINTS };
    nqm_rng rng = nqm_rng_make(seed, 8);
    static float points[WIDTH * MOST];
    float y[WIDTH], first = 0;
    for (size_t i = 0; i < WIDTH * MOST; ++i)
        points[i] = (float)nqm_rng_normal(&rng);
    for (size_t p = 0; p < MOST; ++p) {
        for (size_t i = 0; i < WIDTH; ++i) /* a squared distance of 0.47 from point p */
            y[i] = points[(p / NQM_POINTS * WIDTH + i) * NQM_POINTS + p % NQM_POINTS] + (i % 2 ? 0.1F : -0.1F);
        for (size_t k = 0; every_table(k); ++k) {
            const float square = every_table(k)->nearest_square(WIDTH, BLOCKS, points, y);
            assert_near((double)square, 0.01 * WIDTH, 1e-5);
            if (k == 0)
                first = square;
            assert_true(every_table(k) == &nqm_kernels_scalar || square == first);
        }
    }
    for (size_t k = 0; every_table(k); ++k)
        assert_true(isinf(every_table(k)->nearest_square(WIDTH, 0, points, y)));
}

static void sums_of_magnitudes(void **state) {
    (void)state;
    enum { MOST = 12 * NQM_PANEL };
    nqm_rng rng = nqm_rng_make(seed, 5);
    static float x[MOST];
    for (size_t i = 0; i < MOST; ++i)
        x[i] = (float)nqm_rng_normal(&rng);
    for (size_t n = 0; n <= MOST; n += NQM_PANEL) {
        float sum, squares, first[2] = {0};
        double expected = 0, expected_squares = 0;
        for (size_t i = 0; i < n; ++i) {
            expected += fabs((double)x[i]);
            expected_squares += (double)x[i] * (double)x[i];
        }
        for (size_t k = 0; every_table(k); ++k) {
            every_table(k)->magnitudes(n, x, &sum, &squares);
            assert_near((double)sum, expected, 5e-7 * expected);
            assert_near((double)squares, expected_squares, 5e-7 * expected_squares);
            if (k == 0)
                first[0] = sum, first[1] = squares;
            if (every_table(k) != &nqm_kernels_scalar)
                assert_true(sum == first[0] && squares == first[1]);
        }
    }
}

/* Quantised values are within half a step of x, 0 is exact, and the whole range 0..255 is used. */
static void rows_of_bytes(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(seed, 2);
    static float x[N];
    static uint32_t words[N / 4 + 1], first[N / 4 + 1];
    for (int round = 0; round < 40; ++round) {
        const double low = round % 4 == 1 ? 0 : -nqm_rng_uniform(&rng);
        for (size_t i = 0; i < N; ++i)
            x[i] = i % 9 == 0 ? 0 : (float)(low + (round % 4 == 2 ? -low : 1) * nqm_rng_uniform(&rng));
        for (size_t k = 0; every_table(k); ++k) {
            memset(words, 255, sizeof words);
            nqm_byte_scale by = every_table(k)->quantise_row(N, x, words);
            const unsigned char *bytes = (const unsigned char *)words;
            unsigned char least = 255, most = 0;
            for (size_t i = 0; i < N; ++i) {
                double back = (double)by.scale * ((double)bytes[i] - (double)by.zero);
                assert_near(back, (double)x[i], 0.51 * (double)by.scale + (bytes[i] == 255 ? (double)by.scale : 0));
                assert_true(x[i] != 0 || back == 0);
                least = bytes[i] < least ? bytes[i] : least;
                most = bytes[i] > most ? bytes[i] : most;
            }
            assert_true(least <= 1 && most >= 254);
            if (k == 0)
                memcpy(first, words, sizeof first);
            assert_memory_equal(words, first, sizeof first);
        }
    }
    const float zeros[7] = {0};
    nqm_byte_scale by = nqm_kernels_get()->quantise_row(7, zeros, words);
    assert_true(by.scale > 0 && ((unsigned char *)words)[3] == by.zero);
}

static void one_row_like_many(void **state) {
    (void)state;
    enum { K = 77, WIDTH = 200 }; /* seven panels */
    nqm_rng rng = nqm_rng_make(seed, 3);
    static float w[WIDTH * K], x[K];
    for (size_t i = 0; i < WIDTH * K; ++i)
        w[i] = (float)nqm_rng_normal(&rng);
    for (size_t i = 0; i < K; ++i)
        x[i] = (float)nqm_rng_normal(&rng);
    for (size_t t = 0; every_table(t); ++t)
        for (int p = 0; p < NQM_PRECISION_COUNT; ++p) {
            const nqm_kernels *kernels = every_table(t);
            const nqm_precision precision = (nqm_precision)p;
            nqm_panels b;
            uint32_t a[K];
            static float expected[WIDTH + NQM_PANEL], actual[WIDTH + NQM_PANEL];
            assert_int_equal(nqm_panels_create(precision, K, WIDTH, &b, NULL), NQM_OK);
            nqm_panels_pack(&b, (nqm_weights){w, NULL, K});
            memcpy(a, x, sizeof x);
            if (precision == NQM_PRECISION_BF16)
                kernels->round_row(K, x, a);
            else if (precision == NQM_PRECISION_INT8)
                (void)kernels->quantise_row(K, x, a);
            for (int add = 0; add < 2; ++add) {
                nqm_kernels_use(kernels);
                nqm_multiply(&b, 1, a, K, add, expected, WIDTH + NQM_PANEL);
                use_chosen_kernels();
                kernels->row_product[precision](&(nqm_row_product){.words = b.words,
                                                                   .n_panels = b.n_panels,
                                                                   .stride = b.stride,
                                                                   .add = add,
                                                                   .a = a,
                                                                   .b = b.data,
                                                                   .c = actual});
                assert_memory_equal(actual, expected, b.n_panels * NQM_PANEL * sizeof *actual);
            }
            nqm_panels_free(&b);
        }
}

int main(void) {
    printf("seed %llu\n", (unsigned long long)seed);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples),          cmocka_unit_test(roots_and_logarithms), cmocka_unit_test(ratios),
        cmocka_unit_test(root_differences), cmocka_unit_test(sums_of_magnitudes),   cmocka_unit_test(nearest_points),
        cmocka_unit_test(rows_of_bytes),    cmocka_unit_test(one_row_like_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
