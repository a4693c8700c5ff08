/* SPDX-License-Identifier: MIT
 *
 * kernel.h - the arithmetic that dominates the network's time: float matrix products, GELU, Adam. Every product has a
 * scalar reference that defines the result; faster variants stay within rounding of it and stand behind one table.
 *
 * Results do not depend on the number of threads: the output is cut into blocks whose size depends on its shape only,
 * and each element is summed over k by one thread in a fixed order.
 */
#ifndef NQM_SRC_KERNEL_H
#define NQM_SRC_KERNEL_H

#include "base/base.h"

/** C = alpha op(A) op(B) + beta C, row-major; op(A) is (m, k), op(B) is (k, n), C is (m, n). beta 0 ignores what C
 * holds. */
typedef struct nqm_gemm {
    size_t m, n, k;
    float alpha, beta;
    bool trans_a, trans_b; /**< op(X) is the transpose of X */
    const float *a, *b;
    float *c;
    size_t lda, ldb, ldc; /**< numbers from one row to the next, as stored */
} nqm_gemm;

/** One way to compute; all fields are set. */
typedef struct nqm_kernels {
    const char *name;
    void (*gemm)(const nqm_gemm *g);
} nqm_kernels;

/** Plain loops, products summed in double and rounded once: the definition. */
extern const nqm_kernels nqm_kernels_scalar;
/** oneDNN's sgemm on blocks. */
extern const nqm_kernels nqm_kernels_onednn;

/** The table in use: oneDNN unless nqm_kernels_use() chose another. Any thread. */
const nqm_kernels *nqm_kernels_get(void);
/** Choose the table for the whole process; for tests and benchmarks. NULL: back to the default. */
void nqm_kernels_use(const nqm_kernels *kernels);

/**
 * GELU with the exact (erf) definition: y = x Phi(x), slope = dy/dx = Phi(x) + x phi(x), for n values. Phi is within
 * 3e-7 of the true normal distribution function everywhere.
 *
 * @param y      (n) may be x
 * @param slope  (n), or NULL; neither x nor y
 */
void nqm_gelu(size_t n, const float *x, float *y, float *slope);

/** How far a step of Adam goes. */
typedef struct nqm_adam_rate {
    double lr, weight_decay;
    uint64_t step; /**< 1 for the first */
} nqm_adam_rate;
/** One step of Adam for n parameters; m, v: (n) the moments, zeros before the first step. */
void nqm_adam_update(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v, float *param);

#endif
