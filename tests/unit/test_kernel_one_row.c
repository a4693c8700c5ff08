/* SPDX-License-Identifier: MIT
 *
 * Rounding of rows and products of one row: every table against the plain loops and, bit for bit, against the other tables.
 */
#include "kernel/panel.h"
#include "support/check.h"
#include "support/tables.h"

#include <math.h>
#include <string.h>

static const uint64_t seed = 3;

enum { N = 501 };

/* Quantised values are within half a step of x, 0 is exact, and the whole range 0..255 is used. */
TEST(rows_of_bytes) {
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

TEST(one_row_like_many) {
    enum { K = 77, WIDTH = 200, ROWS = 5 }; /* seven panels */
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
            static float expected[WIDTH + NQM_PANEL], actual[ROWS * (WIDTH + NQM_PANEL)];
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
                kernels->product[precision](&(nqm_product){.m = ROWS,
                                                           .words = b.words,
                                                           .n_panels = b.n_panels,
                                                           .add = add,
                                                           .a = a,
                                                           .b = b.data,
                                                           .panel_step = b.stride * NQM_PANEL,
                                                           .c = actual,
                                                           .ldc = WIDTH + NQM_PANEL});
                assert_memory_equal(actual, expected, b.n_panels * NQM_PANEL * sizeof *actual);
            }
            nqm_panels_free(&b);
        }
}
