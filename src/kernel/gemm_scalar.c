/* SPDX-License-Identifier: MIT
 *
 * The matrix product by its definition: for each element of C a sum over k in ascending order, in double, rounded to
 * float once. Slow on purpose; every other variant is judged by it.
 */
#include "kernel/kernel.h"

static float element(const nqm_gemm *g, size_t i, size_t j) {
    size_t a_step = g->trans_a ? g->lda : 1;
    size_t b_step = g->trans_b ? 1 : g->ldb;
    const float *a = g->trans_a ? g->a + i : g->a + i * g->lda;
    const float *b = g->trans_b ? g->b + j * g->ldb : g->b + j;
    double sum = 0;
    for (size_t k = 0; k < g->k; ++k)
        sum += (double)a[k * a_step] * (double)b[k * b_step];
    double kept = g->beta != 0.0f ? (double)g->beta * (double)g->c[i * g->ldc + j] : 0;
    return (float)((double)g->alpha * sum + kept);
}

static void gemm(const nqm_gemm *g) {
    for (size_t i = 0; i < g->m; ++i)
        for (size_t j = 0; j < g->n; ++j)
            g->c[i * g->ldc + j] = element(g, i, j);
}

const nqm_kernels nqm_kernels_scalar = {"scalar", gemm};
