/* SPDX-License-Identifier: MIT
 *
 * Every kernel table that this processor supports against the plain loops: products and weight gradients in float and
 * bfloat16 within the rounding bound; equal bits from tables with fused multiply-add, for any number of rows and threads; and
 * how a table is chosen.
 */
#include "kernel/panel.h"
#include "support/check.h"

#include <omp.h>

static const uint64_t seed = 17;

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* A product in a precision; C initially holds `before`. */
typedef struct problem {
    nqm_precision precision;
    size_t m, k, n, lda, ldc;
    float *x, *w;
    uint32_t *a;
    nqm_panels b;
    float *before;
} problem;

/* The transpose of w (n, k) in panels. */
static nqm_panels panels_of(nqm_precision precision, size_t k, size_t n, const float *w) {
    nqm_panels floats, rounded;
    assert_int_equal(nqm_panels_create(NQM_PRECISION_F32, k, n, &floats, NULL), NQM_OK);
    nqm_panels_pack(&floats, (nqm_weights){w, NULL, k});
    if (precision == NQM_PRECISION_F32)
        return floats;
    assert_int_equal(nqm_panels_create(precision, k, n, &rounded, NULL), NQM_OK);
    nqm_panels_round(&floats, &rounded);
    nqm_panels_free(&floats);
    return rounded;
}

static problem make_problem(nqm_rng *rng, nqm_precision precision, size_t m, size_t k, size_t n) {
    problem p = {.precision = precision, .m = m, .k = k, .n = n, .lda = nqm_row_stride(k), .ldc = nqm_row_stride(n)};
    p.x = random_block(rng, m * k);
    p.w = random_block(rng, n * k);
    p.a = nqm_alloc(m * p.lda, sizeof *p.a);
    for (size_t i = 0; i < m; ++i) {
        uint32_t *row = p.a + i * p.lda;
        if (precision == NQM_PRECISION_F32)
            memcpy(row, p.x + i * k, k * sizeof(float));
        else
            nqm_kernels_get()->round_row(k, p.x + i * k, row);
    }
    p.b = panels_of(precision, k, n, p.w);
    p.before = random_block(rng, m * p.ldc);
    return p;
}

static void free_problem(problem *p) {
    nqm_free(p->x);
    nqm_free(p->w);
    nqm_free(p->a);
    nqm_free(p->before);
    nqm_panels_free(&p->b);
}

static float *solve(const problem *p, const nqm_kernels *kernels, size_t first, size_t m, bool add) {
    float *c = nqm_alloc(m * p->ldc, sizeof *c);
    memcpy(c, p->before + first * p->ldc, m * p->ldc * sizeof *c);
    nqm_kernels_use(kernels);
    nqm_multiply(&p->b, m, p->a + first * p->lda, p->lda, add, c, p->ldc);
    use_chosen_kernels();
    return c;
}

static double magnitude(const problem *p, size_t i, size_t j) {
    double sum = fabs((double)p->before[i * p->ldc + j]);
    for (size_t k = 0; k < p->k; ++k)
        sum += fabs((double)p->x[i * p->k + k] * (double)p->w[j * p->k + k]);
    return sum;
}

static void check_product(const problem *p, const nqm_kernels *kernels, bool add) {
    float *expected = solve(p, &nqm_kernels_scalar, 0, p->m, add), *actual = solve(p, kernels, 0, p->m, add);
    for (size_t i = 0; i < p->m; ++i)
        for (size_t j = 0; j < p->n; ++j)
            assert_near((double)actual[i * p->ldc + j], (double)expected[i * p->ldc + j],
                        (double)(p->k + 2) * 0x1p-24 * 1.02 * magnitude(p, i, j));
    nqm_free(expected);
    nqm_free(actual);
}

static const size_t shapes[][3] = {{1, 1, 1},    {1, 45, 33}, {2, 7, 64},  {3, 9, 5},     {4, 33, 31},
                                   {12, 64, 40}, {13, 3, 96}, {29, 50, 7}, {70, 130, 65}, {7, 1700, 33}};
enum { N_SHAPES = sizeof shapes / sizeof *shapes };

TEST(products_of_every_table) {
    const nqm_kernels *before = nqm_kernels_get();
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        print_message("%s\n", nqm_kernels_at(t)->name);
        for (size_t s = 0; s < N_SHAPES; ++s)
            for (int precision = 0; precision < NQM_PRECISION_COUNT; ++precision) {
                problem p = make_problem(&rng, (nqm_precision)precision, shapes[s][0], shapes[s][1], shapes[s][2]);
                check_product(&p, nqm_kernels_at(t), false);
                check_product(&p, nqm_kernels_at(t), true);
                free_problem(&p);
            }
    }
    assert_ptr_equal(nqm_kernels_get(), before);
}

/* Strided products have the bits of a product of the same factors. */
TEST(strided_products_of_every_table) {
    enum { M = 13, K = 37, STEP = 3, LDA = STEP * K + 5, LDB = 2 * NQM_PANEL, LDC = NQM_PANEL + 8 };
    nqm_rng rng = nqm_rng_make(seed, 3);
    for (size_t t = 0; nqm_kernels_at(t); ++t)
        for (size_t m = 1; m <= M; ++m) {
            const size_t n_a = (m - 1) * LDA + (K - 1) * STEP + 1; /* exactly, so that sanitizers see reads beyond */
            float *a = random_block(&rng, n_a), *b = random_block(&rng, (K - 1) * LDB + NQM_PANEL);
            float *dense_a = nqm_alloc(m * K, sizeof *dense_a), *dense_b = nqm_alloc(K * NQM_PANEL, sizeof *dense_b);
            float c[M * LDC] = {0}, expected[M * LDC] = {0};
            for (size_t u = 0; u < K; ++u) {
                memcpy(dense_b + u * NQM_PANEL, b + u * LDB, NQM_PANEL * sizeof *b);
                for (size_t i = 0; i < m; ++i)
                    dense_a[i * K + u] = a[i * LDA + u * STEP];
            }
            for (int add = 0; add < 2; ++add) { /* the second adds to the first */
                nqm_kernels_at(t)->strided_product(&(nqm_strided_product){.m = m,
                                                                          .k = K,
                                                                          .add = add,
                                                                          .a = a,
                                                                          .b = b,
                                                                          .c = c,
                                                                          .lda = LDA,
                                                                          .step = STEP,
                                                                          .ldb = LDB,
                                                                          .ldc = LDC});
                nqm_kernels_at(t)->product[NQM_PRECISION_F32](&(nqm_product){.m = m,
                                                                             .words = K,
                                                                             .n_panels = 1,
                                                                             .add = add,
                                                                             .a = dense_a,
                                                                             .b = dense_b,
                                                                             .c = expected,
                                                                             .lda = K,
                                                                             .ldc = LDC});
                assert_memory_equal(c, expected, sizeof c);
            }
            float *const blocks[] = {a, b, dense_a, dense_b};
            for (size_t i = 0; i < 4; ++i)
                nqm_free(blocks[i]);
        }
}

/* The plain loops against hand-computed values of x w^T with the rounding of each precision. */
TEST(the_definition_by_hand) {
    const float x[] = {1, -2, 0.25f, 253}, w[] = {3, 1, -4, 127, 0.25f, 0, 127, -127};
    const double expected[] = {3 - 2 - 1 + 253.0 * 127, 0.25 + 31.75 - 253.0 * 127};
    for (int precision = 0; precision < NQM_PRECISION_COUNT; ++precision) {
        nqm_panels b = panels_of((nqm_precision)precision, 4, 2, w);
        uint32_t a[4];
        float c[NQM_PANEL] = {0};
        memcpy(a, x, sizeof x);
        if (precision == NQM_PRECISION_BF16)
            nqm_kernels_get()->round_row(4, x, a);
        nqm_kernels_use(&nqm_kernels_scalar);
        nqm_multiply(&b, 1, a, 4, false, c, NQM_PANEL);
        for (size_t j = 0; j < 2; ++j)
            assert_near((double)c[j], expected[j], 1e-3);
        use_chosen_kernels();
        nqm_panels_free(&b);
    }
}

static bool has_fma(const nqm_kernels *kernels) {
#if defined __aarch64__
    return kernels != &nqm_kernels_scalar;
#else
    return kernels != &nqm_kernels_scalar && kernels != &nqm_kernels_generic;
#endif
}

/* Tables that unpack bfloat16 to floats and use fused multiply-add: they have the same bits in every precision. */
static bool unpacks_bf16(const nqm_kernels *kernels) {
    return strcmp(kernels->name, "avx2") == 0 || strcmp(kernels->name, "avx512") == 0;
}

/* Equal bits for any instruction set with fused multiply-add, number of rows and number of threads. */
TEST(the_same_bits) {
    nqm_rng rng = nqm_rng_make(seed, 1);
    int threads = omp_get_max_threads();
    for (int precision = 0; precision < NQM_PRECISION_COUNT; ++precision) {
        problem p = make_problem(&rng, (nqm_precision)precision, 150, 301, 90);
        float *first = solve(&p, nqm_kernels_at(0), 0, p.m, true);
        for (size_t t = 0; nqm_kernels_at(t); ++t) {
            const nqm_kernels *kernels = nqm_kernels_at(t);
            omp_set_num_threads((int)(t % 2) + 1);
            float *all = solve(&p, kernels, 0, p.m, true);
            if ((precision == NQM_PRECISION_F32 && has_fma(kernels)) ||
                (unpacks_bf16(nqm_kernels_at(0)) && unpacks_bf16(kernels)))
                assert_memory_equal(all, first, p.m * p.ldc * sizeof *all);
            for (size_t i = 0; i < p.m; i += 7) {
                omp_set_num_threads((int)(i % 3) + 1);
                float *one = solve(&p, kernels, i, 1, true);
                assert_memory_equal(one, all + i * p.ldc, p.n * sizeof *one);
                nqm_free(one);
            }
            nqm_free(all);
        }
        nqm_free(first);
        free_problem(&p);
    }
    omp_set_num_threads(threads);
}

/* So many panels that a block has several of them, fewer for more threads. */
TEST(the_same_bits_of_many_panels) {
    nqm_rng rng = nqm_rng_make(seed, 7);
    const int threads = omp_get_max_threads();
    for (int precision = 0; precision < NQM_PRECISION_COUNT; ++precision) {
        problem p = make_problem(&rng, (nqm_precision)precision, 400, 41, 1000);
        float *first = NULL;
        for (int n = 1; n <= 3; ++n) {
            omp_set_num_threads(n);
            float *all = solve(&p, NULL, 0, p.m, true);
            first = first ? first : all;
            assert_memory_equal(all, first, p.m * p.ldc * sizeof *all);
            for (size_t i = 0; i < p.m; i += 57) {
                float *one = solve(&p, NULL, i, 1, true);
                assert_memory_equal(one, all + i * p.ldc, p.n * sizeof *one);
                nqm_free(one);
            }
            if (all != first)
                nqm_free(all);
        }
        nqm_free(first);
        free_problem(&p);
    }
    omp_set_num_threads(threads);
}

TEST(one_row_like_many) {
    enum { K = 77, WIDTH = 200, ROWS = 5 }; /* seven panels */
    nqm_rng rng = nqm_rng_make(seed, 10);
    static float w[WIDTH * K], x[K];
    for (size_t i = 0; i < WIDTH * K; ++i)
        w[i] = (float)nqm_rng_normal(&rng);
    for (size_t i = 0; i < K; ++i)
        x[i] = (float)nqm_rng_normal(&rng);
    for (size_t t = 0; nqm_kernels_at(t); ++t)
        for (int p = 0; p < NQM_PRECISION_COUNT; ++p) {
            const nqm_kernels *kernels = nqm_kernels_at(t);
            const nqm_precision precision = (nqm_precision)p;
            nqm_panels b = panels_of(precision, K, WIDTH, w);
            uint32_t a[K];
            static float expected[WIDTH + NQM_PANEL], actual[ROWS * (WIDTH + NQM_PANEL)];
            memcpy(a, x, sizeof x);
            if (precision == NQM_PRECISION_BF16)
                kernels->round_row(K, x, a);
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

/* Panels are packed one at a time, also if the number of rows is not a multiple of the transposed block. */
TEST(panels_packed_one_by_one) {
    nqm_rng rng = nqm_rng_make(seed, 6);
    static const size_t sizes[][3] = {{1, 1, 1}, {1, 192, 32}, {2, 193, 33}, {5, 391, 70}, {13, 1027, 67}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s) {
        problem p = make_problem(&rng, NQM_PRECISION_F32, sizes[s][0], sizes[s][1], sizes[s][2]);
        float *panel = random_block(&rng, p.k * NQM_PANEL);
        for (size_t i = 0; i < p.b.n_panels; ++i) {
            const size_t first = i * NQM_PANEL, width = p.n - first < NQM_PANEL ? p.n - first : NQM_PANEL;
            nqm_pack_panel(width, p.k, (nqm_weights){p.w + first * p.k, NULL, p.k}, panel);
            assert_memory_equal(panel, nqm_panel_at(&p.b, i), p.k * NQM_PANEL * sizeof *panel);
        }
        nqm_free(panel);
        free_problem(&p);
    }
}

TEST(panels_and_back) {
    nqm_rng rng = nqm_rng_make(seed, 2);
    enum { K = 45, N = 70 };
    float *w = random_block(&rng, K * N), back[K * N], back_t[K * N];
    nqm_panels b, t, bf16, bf16_t;
    assert_int_equal(nqm_panels_create(NQM_PRECISION_F32, K, N, &b, NULL), NQM_OK);
    assert_int_equal(nqm_panels_create(NQM_PRECISION_F32, N, K, &t, NULL), NQM_OK);
    assert_int_equal(nqm_panels_create(NQM_PRECISION_BF16, N, K, &bf16, NULL), NQM_OK);
    nqm_panels_pack(&b, (nqm_weights){w, NULL, K});
    nqm_panels_unpack(&b, back, K);
    assert_memory_equal(back, w, sizeof back);
    nqm_panels_transpose(&b, &t);
    nqm_panels_unpack(&t, back_t, N);
    for (size_t i = 0; i < N; ++i)
        for (size_t j = 0; j < K; ++j)
            assert_true(back_t[j * N + i] == w[i * K + j]);
    nqm_panels_transpose(&b, &bf16);
    bf16_t = panels_of(NQM_PRECISION_BF16, N, K, back_t);
    assert_memory_equal(bf16.data, bf16_t.data, bf16.n_panels * bf16.stride * NQM_PANEL * sizeof *bf16.data);
    nqm_panels *all[] = {&b, &t, &bf16, &bf16_t};
    for (size_t i = 0; i < 4; ++i)
        nqm_panels_free(all[i]);
    nqm_free(w);
}

TEST(rounding_to_bfloat16) {
    const float x[] = {1, 0x1.01p0f, 0x1.03p0f, 0x1.0101p0f, -0x1.01p0f, 0x1.ffp127f, INFINITY, -0.0f, 3.14159f, NAN};
    const float expected[] = {1, 1, 0x1.04p0f, 0x1.02p0f, -1, INFINITY, INFINITY, -0.0f, 0x1.92p1f};
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        uint32_t words[5];
        nqm_kernels_at(t)->round_row(10, x, words);
        for (size_t i = 0; i < 10; ++i) {
            uint32_t bits = i % 2 ? words[i / 2] & 0xffff0000u : words[i / 2] << 16;
            float value;
            memcpy(&value, &bits, sizeof value);
            if (i == 9)
                assert_true(isnan(value));
            else
                assert_true(value == expected[i] && signbit(value) == signbit(expected[i]));
        }
    }
}

/* ---- gradients --------------------------------------------------------------------------------------------------- */

typedef struct collected {
    size_t ld;
    float *c;
    unsigned char *seen;
    size_t n_panels;
} collected;

static void collect(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    collected *all = user;
    for (size_t i = 0; i < n_strips; ++i)
        all->seen[(strip + i) * all->n_panels + panel]++;
    for (size_t i = 0; i < n_strips * NQM_STRIP; ++i)
        memcpy(all->c + (strip * NQM_STRIP + i) * all->ld + panel * NQM_PANEL, tiles + i * NQM_PANEL,
               NQM_PANEL * sizeof *tiles);
}

/* x (m, n) as a factor of a gradient, in a block of exactly the required size, so that sanitizers see reads beyond
 * it. */
static nqm_columns factor_of(nqm_precision precision, size_t m, size_t n, size_t width, const float *x) {
    const size_t words = nqm_words(precision, m), n_groups = (n + width - 1) / width;
    const bool rounded = precision == NQM_PRECISION_BF16;
    uint32_t *data = nqm_alloc(n_groups * words, width * sizeof *data);
    float *zeros = nqm_alloc(n, sizeof *zeros);
    for (size_t u = 0; u < words; ++u) {
        const float *row = x + (u << precision) * n;
        if (rounded)
            nqm_kernels_get()->round_pair(n, row, 2 * u + 1 < m ? row + n : zeros, width, words * width,
                                          data + u * width);
        else
            nqm_columns_copy(n, row, width, words * width, (float *)data + u * width);
    }
    nqm_free(zeros);
    return (nqm_columns){data, words * width};
}

static float *gradient_of(const nqm_kernels *kernels, nqm_precision precision, const size_t size[3], const float *x,
                          const float *z) {
    const size_t m = size[0], k = size[1], n = size[2];
    const size_t n_strips = (k + NQM_STRIP - 1) / NQM_STRIP, n_panels = (n + NQM_PANEL - 1) / NQM_PANEL;
    nqm_kernels_use(kernels);
    const nqm_columns left = factor_of(precision, m, k, NQM_STRIP, x), right = factor_of(precision, m, n, NQM_PANEL, z);
    collected all = {.ld = n_panels * NQM_PANEL, .n_panels = n_panels};
    all.c = nqm_alloc(n_strips * NQM_STRIP * all.ld, sizeof *all.c);
    all.seen = nqm_alloc(n_strips * n_panels, 1);
    nqm_gradient_run(&(nqm_gradient){
        .precision = precision, .m = m, .k = k, .n = n, .x = left, .z = right, .sink = collect, .user = &all});
    use_chosen_kernels();
    for (size_t i = 0; i < n_strips * n_panels; ++i)
        assert_int_equal(all.seen[i], 1);
    nqm_free(all.seen);
    nqm_free((void *)(uintptr_t)left.data);
    nqm_free((void *)(uintptr_t)right.data);
    return all.c;
}

TEST(gradients_of_every_table) {
    nqm_rng rng = nqm_rng_make(seed, 3);
    static const size_t sizes[][3] = {{1, 1, 1}, {7, 25, 40}, {64, 12, 32}, {33, 50, 70}, {200, 400, 65}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s) {
        const size_t m = sizes[s][0], k = sizes[s][1], n = sizes[s][2],
                     ld = (n + NQM_PANEL - 1) / NQM_PANEL * NQM_PANEL;
        float *x = random_block(&rng, m * k), *z = random_block(&rng, m * n);
        for (size_t t = 0; nqm_kernels_at(t); ++t)
            for (int precision = 0; precision < NQM_PRECISION_COUNT; ++precision) {
                float *c = gradient_of(nqm_kernels_at(t), (nqm_precision)precision, sizes[s], x, z);
                for (size_t i = 0; i < k; i += 1 + k / 20)
                    for (size_t j = 0; j < n; ++j) {
                        double sum = 0, size = 0;
                        for (size_t r = 0; r < m; ++r) {
                            sum += (double)x[r * k + i] * (double)z[r * n + j];
                            size += fabs((double)x[r * k + i] * (double)z[r * n + j]);
                        }
                        double rounding = precision == NQM_PRECISION_BF16 ? 0x1p-7 : 0;
                        assert_near((double)c[i * ld + j], sum, (rounding + (double)m * 0x1p-24) * size);
                    }
                nqm_free(c);
            }
        nqm_free(x);
        nqm_free(z);
    }
}

/* ---- choice ------------------------------------------------------------------------------------------------------- */

TEST(choice_by_name) {
    for (size_t i = 0; nqm_kernels_name(i); ++i) {
        assert_int_equal(nqm_kernels_select(nqm_kernels_name(i), NULL), NQM_OK);
        assert_ptr_equal(nqm_kernels_get(), nqm_kernels_at(i));
        assert_string_equal(nqm_kernels_get()->name, nqm_kernels_name(i));
    }
    nqm_error err = {0};
    assert_int_equal(nqm_kernels_select("abacus", &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "abacus"));
    assert_ptr_equal(nqm_kernels_get(), &nqm_kernels_scalar); /* a refused selection has no effect */
    assert_int_equal(nqm_kernels_select(NULL, NULL), NQM_OK);
    assert_ptr_equal(nqm_kernels_get(), nqm_kernels_at(0));
    assert_string_equal(nqm_precision_words[NQM_PRECISION_BF16], "bf16");
    assert_null(nqm_precision_words[NQM_PRECISION_COUNT]);
}
