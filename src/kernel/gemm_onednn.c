/* SPDX-License-Identifier: MIT
 *
 * Matrix product by oneDNN's sgemm. The threading of oneDNN may split the sum over k, which would make the result
 * depend on the number of threads. Therefore this file splits C into blocks that depend only on the shape of the
 * product, and computes each block with one single-threaded call. The block sizes were measured to be fast on the
 * shapes of the paper's network.
 */
#include "kernel/kernel.h"
#include "kernel/onednn.h"

#include <omp.h>

/* NQM_ONEDNN_SONAME is the shared library that CMakeLists.txt found at build time. */
static const char *const names[] = {NQM_ONEDNN_FUNCTIONS(NQM_LIBRARY_NAME)};
static nqm_onednn functions;
static nqm_library library = NQM_LIBRARY(NQM_ONEDNN_SONAME, names, functions);

const nqm_onednn *nqm_onednn_get(void) {
    return nqm_library_get(&library) ? &functions : NULL;
}

enum { MIN_PARALLEL = 1 << 18 }; /* multiply-adds; below this, waking a thread costs more than it saves */

typedef struct blocks {
    size_t rows, cols; /* of a block; blocks at the right and bottom edges may be smaller */
} blocks;

static blocks choose_blocks(const nqm_gemm *g) {
    if (g->m <= 32) /* few rows: reading B takes most of the time, and narrow blocks divide it evenly among threads */
        return (blocks){32, 64};
    /* Weight gradients (A transposed) have a small k: only large blocks amortise oneDNN's packing. */
    size_t widest = g->trans_a ? 1536 : 512;
    size_t n_across = nqm_ceil_div(g->n, 2 * widest) * 2; /* even, so that two threads get equal work */
    size_t cols = nqm_ceil_div(nqm_ceil_div(g->n, n_across), 16) * 16;
    return (blocks){g->trans_a ? 1024 : 256, cols};
}

static void gemm_block(const nqm_onednn *onednn, const nqm_gemm *g, blocks size, size_t row, size_t col) {
    nqm_gemm part = *g;
    part.m = g->m - row < size.rows ? g->m - row : size.rows;
    part.n = g->n - col < size.cols ? g->n - col : size.cols;
    part.a = g->trans_a ? g->a + row : g->a + row * g->lda;
    part.b = g->trans_b ? g->b + col * g->ldb : g->b + col;
    part.c = g->c + row * g->ldc + col;
    dnnl_status_t status =
        onednn->dnnl_sgemm(g->trans_a ? 'T' : 'N', g->trans_b ? 'T' : 'N', (dnnl_dim_t)part.m, (dnnl_dim_t)part.n,
                           (dnnl_dim_t)part.k, part.alpha, part.a, (dnnl_dim_t)part.lda, part.b, (dnnl_dim_t)part.ldb,
                           part.beta, part.c, (dnnl_dim_t)part.ldc);
    if (status != dnnl_success) /* out of memory for packing; C is unchanged */
        nqm_kernels_scalar.gemm(&part);
}

void nqm_gemm_onednn(const nqm_gemm *g) {
    const nqm_onednn *onednn = nqm_onednn_get();
    if (g->m == 0 || g->n == 0)
        return;
    if (!onednn) {
        nqm_kernels_scalar.gemm(g);
        return;
    }
    blocks size = choose_blocks(g);
    size_t n_down = nqm_ceil_div(g->m, size.rows);
    size_t n_blocks = n_down * nqm_ceil_div(g->n, size.cols);
#pragma omp parallel if (g->m * g->n * g->k >= MIN_PARALLEL)
    {
        omp_set_num_threads(1); /* for this thread in this region: keeps oneDNN single-threaded */
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < n_blocks; ++i)
            gemm_block(onednn, g, size, i % n_down * size.rows, i / n_down * size.cols);
    }
}
