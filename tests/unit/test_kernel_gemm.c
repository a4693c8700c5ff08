/* SPDX-License-Identifier: MIT
 *
 * Matrix products: the scalar reference against hand-computed products, every variant against the reference within the
 * rounding bound (k eps sum |a| |b|), for shapes with tails, transposes and padded rows; the same bits for one and two
 * threads.
 */
#include "kernel/kernel.h"
#include "support/check.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>

static const uint64_t seed = 11;

static void reference_by_hand(void **state) {
    (void)state;
    const float a[] = {1, 2, 3, 4, 5, 6};     /* (2, 3) */
    const float b[] = {1, -1, 2, 0, 0.5f, 3}; /* (3, 2) */
    const float a_t[] = {1, 4, 2, 5, 3, 6}, b_t[] = {1, 2, 0.5f, -1, 0, 3};
    const float expected[] = {6.5f, 8, 17, 14};
    for (int t = 0; t < 4; ++t) {
        float c[4] = {10, 20, 30, 40};
        nqm_gemm g = {.m = 2, .n = 2, .k = 3, .alpha = 2, .beta = 0.5f, .c = c, .ldc = 2};
        g.trans_a = t & 1, g.a = g.trans_a ? a_t : a, g.lda = g.trans_a ? 2 : 3;
        g.trans_b = t & 2, g.b = g.trans_b ? b_t : b, g.ldb = g.trans_b ? 3 : 2;
        nqm_kernels_scalar.gemm(&g);
        for (size_t i = 0; i < 4; ++i)
            assert_true(c[i] == 2 * expected[i] + 5 * (float)(i + 1));
    }
}

/* A random problem; the row strides of all three matrices exceed the row lengths by `gap` elements. */
typedef struct problem {
    nqm_gemm g;
    float *a, *b, *c, *initial;
    size_t n_c;
} problem;

static problem make_problem(nqm_rng *rng, size_t m, size_t n, size_t k, int variant) {
    size_t gap = variant & 4 ? 3 : 0;
    problem p = {.g = {.m = m, .n = n, .k = k, .alpha = 1, .trans_a = variant & 1, .trans_b = variant & 2}};
    p.g.beta = variant & 4 ? -0.5f : 0;
    p.g.lda = (p.g.trans_a ? m : k) + gap;
    p.g.ldb = (p.g.trans_b ? k : n) + gap;
    p.g.ldc = n + gap;
    p.n_c = m * p.g.ldc;
    p.a = random_block(rng, (p.g.trans_a ? k : m) * p.g.lda);
    p.b = random_block(rng, (p.g.trans_b ? n : k) * p.g.ldb);
    p.c = nqm_alloc(p.n_c, sizeof *p.c);
    p.initial = random_block(rng, p.n_c);
    if (p.g.beta == 0) /* the initial content of C must be ignored */
        p.initial[0] = NAN;
    p.g.a = p.a, p.g.b = p.b, p.g.c = p.c;
    return p;
}

static void free_problem(problem *p) {
    nqm_free(p->a);
    nqm_free(p->b);
    nqm_free(p->c);
    nqm_free(p->initial);
}

static float *solve(const problem *p, void (*gemm)(const nqm_gemm *)) {
    float *result = nqm_alloc(p->n_c, sizeof *result);
    memcpy(p->c, p->initial, p->n_c * sizeof *p->c);
    gemm(&p->g);
    memcpy(result, p->c, p->n_c * sizeof *result);
    return result;
}

/* sum over k of |a| |b| for one element, plus the initial |C| unless beta is 0. */
static double magnitude(const problem *p, size_t i, size_t j) {
    const nqm_gemm *g = &p->g;
    double sum = 0;
    for (size_t k = 0; k < g->k; ++k)
        sum += fabs((double)g->a[g->trans_a ? k * g->lda + i : i * g->lda + k]) *
               fabs((double)g->b[g->trans_b ? j * g->ldb + k : k * g->ldb + j]);
    return sum + (g->beta != 0.0f ? fabs((double)p->initial[i * g->ldc + j]) : 0);
}

static void check_problem(const problem *p) {
    const nqm_gemm *g = &p->g;
    float *expected = solve(p, nqm_kernels_scalar.gemm), *actual = solve(p, nqm_gemm_onednn);
    size_t step = g->m * g->n > 10000 ? 97 : 1; /* check a sample of the elements of large products */
    for (size_t e = 0; e < g->m * g->n; e += step) {
        size_t i = e / g->n, j = e % g->n, at = i * g->ldc + j;
        double bound = (double)(g->k + 2) * 0x1p-24 * magnitude(p, i, j);
        assert_near((double)actual[at], (double)expected[at], bound);
    }
    for (size_t i = 0; i < g->m; ++i) /* the padding between rows must not change */
        assert_memory_equal(actual + i * g->ldc + g->n, p->initial + i * g->ldc + g->n,
                            (g->ldc - g->n) * sizeof(float));
    nqm_free(expected);
    nqm_free(actual);
}

static void onednn_against_reference(void **state) {
    (void)state;
    static const size_t shapes[][3] = {{1, 1, 1},    {1, 70, 33},  {3, 5, 7},      {17, 65, 31},  {33, 129, 16},
                                       {257, 3, 40}, {40, 513, 9}, {300, 530, 12}, {1030, 20, 8}, {12, 1, 501}};
    nqm_rng rng = nqm_rng_make(seed, 0);
    printf("seed %llu\n", (unsigned long long)seed);
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; ++s)
        for (int variant = 0; variant < 8; ++variant) {
            problem p = make_problem(&rng, shapes[s][0], shapes[s][1], shapes[s][2], variant);
            check_problem(&p);
            free_problem(&p);
        }
}

static void same_bits_for_any_threads(void **state) {
    (void)state;
    static const size_t shapes[][3] = {{1, 700, 350},  {40, 60, 100},    {75, 1, 290},    {1, 700, 900},
                                       {20, 700, 900}, {300, 1030, 400}, {1030, 3100, 64}};
    nqm_rng rng = nqm_rng_make(seed, 1);
    int threads = omp_get_max_threads();
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; ++s)
        for (int variant = 0; variant < 4; ++variant) {
            problem p = make_problem(&rng, shapes[s][0], shapes[s][1], shapes[s][2], variant);
            omp_set_num_threads(1);
            float *one = solve(&p, nqm_gemm_onednn);
            for (int n = 2; n <= 3; ++n) {
                omp_set_num_threads(n);
                float *more = solve(&p, nqm_gemm_onednn);
                assert_memory_equal(one, more, p.n_c * sizeof *one);
                nqm_free(more);
            }
            nqm_free(one);
            free_problem(&p);
        }
    omp_set_num_threads(threads);
}

static void nothing_to_do(void **state) {
    (void)state;
    float c = 3;
    nqm_gemm g = {.m = 0, .n = 4, .k = 2, .alpha = 1, .c = &c, .lda = 2, .ldb = 4, .ldc = 4};
    nqm_gemm_onednn(&g);
    g = (nqm_gemm){.m = 4, .n = 0, .k = 2, .alpha = 1, .c = &c, .lda = 2, .ldb = 1, .ldc = 1};
    nqm_gemm_onednn(&g);
    assert_true(c == 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_by_hand),
        cmocka_unit_test(onednn_against_reference),
        cmocka_unit_test(same_bits_for_any_threads),
        cmocka_unit_test(nothing_to_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
