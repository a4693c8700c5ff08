/* SPDX-License-Identifier: MIT
 *
 * kernel.h - the arithmetic of the network, as tables of functions: one table for each instruction set (isa_*.c), and one of
 * plain loops that defines the results (scalar.c). This file declares the functions; how matrices are stored, and the loops over
 * them on several threads, are in kernel/panel.h.
 *
 * A hidden layer computes y = dropout(GELU(LayerNorm(x W^T + b))) for a batch of rows:
 *
 *   product                C = A B         x W^T with W^T in panels: the forward pass, and the gradient of the input
 *   strided_product        C = A B         of floats in other layouts
 *   gradient               C = A^T B       the gradient of the weights, tile by tile
 *   hidden_row, _back      one row after the product, and its backward pass
 *   adam                   one step of the optimiser
 *   round_*                                floats to bfloat16, the factors of a training's products
 *
 * The factors of a product are 32-bit words, each of which holds one float, or two bfloat16 that are neighbours along k, the
 * index that is summed over.
 *
 * Results do not depend on the number of threads: each element of C is one chain of multiply-adds over ascending k, started
 * from 0 or from the value in C. However a product is cut, the operations are the same. The tables of one machine differ by
 * rounding only; those with fused multiply-add give the same bits in NQM_PRECISION_F32.
 */
#ifndef NQM_SRC_KERNEL_H
#define NQM_SRC_KERNEL_H

#include "base/base.h"

enum {
    NQM_PANEL = 32, /**< columns of B and C in a panel */
    NQM_STRIP = 12  /**< rows of C in a strip: the height of the largest tile that fits into registers */
};

/** 32-bit words of a row of k factors; the last word is filled up with zeros. */
static inline size_t nqm_words(nqm_precision precision, size_t k) {
    return ((k - 1) >> precision) + 1;
}

/** The bits of x as bfloat16, to nearest, ties to even; a NaN stays a NaN. */
static inline uint32_t nqm_bf16_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    uint32_t rounded = (bits + 0x7fff + (bits >> 16 & 1)) >> 16;
    return (bits & 0x7fffffff) > 0x7f800000 ? bits >> 16 | 0x40 : rounded;
}

/** C (m, n_panels NQM_PANEL) = A B, or C + A B. The product of two words is the sum of the products of their factors. */
typedef struct nqm_product {
    size_t m, words, n_panels;
    bool add;          /**< start from C; false: from 0 */
    const void *a;     /**< (m, words), lda words from row to row */
    const void *b;     /**< (n_panels, words, NQM_PANEL), aligned to 64 bytes */
    size_t panel_step; /**< words from one panel of b to the next */
    float *c;          /**< ldc floats from row to row */
    size_t lda, ldc;
} nqm_product;

/** C (m, NQM_PANEL) = A B, or C + A B, of floats with any strides. */
typedef struct nqm_strided_product {
    size_t m, k;
    bool add;       /**< start from C; false: from 0 */
    const float *a; /**< (m, k), lda floats from row to row and `step` from column to column */
    const float *b; /**< (k, NQM_PANEL), ldb floats from row to row */
    float *c;       /**< (m, NQM_PANEL), ldc floats from row to row */
    size_t lda, step, ldb, ldc;
} nqm_strided_product;

/** Arrays that are prefetched while a tile of a gradient is computed: weights and Adam's two moments. */
enum { NQM_PREFETCH = 3 };

/** Tiles of a weight gradient: c (n_strips, NQM_STRIP, NQM_PANEL) = left^T right, summed over the rows of both. */
typedef struct nqm_tile_gradient {
    size_t n_strips;
    size_t words;      /**< rows: of the batch, or pairs of them in NQM_PRECISION_BF16 */
    const void *left;  /**< strips (words, NQM_STRIP), `step` words from strip to strip */
    const void *right; /**< (words, NQM_PANEL) */
    size_t step;
    float *c;
    const float *prefetch[NQM_PREFETCH]; /**< each like c: will be read next; c if there is nothing */
} nqm_tile_gradient;

#define NQM_LAYERNORM_EPS 1e-5f

/** One row of a hidden layer after its matrix product: xhat = (x + bias - mean) / sqrt(variance + NQM_LAYERNORM_EPS),
 *  y = dropout(gelu(gamma xhat + beta)). All arrays are (n) unless a shape is given. */
typedef struct nqm_hidden_row {
    size_t n;
    const float *bias, *gamma, *beta;
    float *x;     /**< in: the product; out: xhat; may be y */
    float *y;     /**< out */
    float *slope; /**< out: dy / d(gamma xhat + beta), dropout included; NULL: not computed, only without dropout */
    float *rstd;  /**< out (1): 1 / sqrt(variance + eps); NULL: not stored */
    double p;     /**< dropout probability: kept elements are scaled by 1/(1-p); 0: no dropout */
    const uint8_t *keep; /**< the dropout mask, 0 drops; NULL: a hash decides */
    uint64_t key; /**< without a mask, element i is dropped when 16 bits of hash(key, counter + i/4) are < p 2^16 */
    uint64_t counter;
} nqm_hidden_row;

/** The backward pass of such a row, with gradients summed over rows. All arrays are (n). */
typedef struct nqm_hidden_row_back {
    size_t n;
    const float *gamma, *xhat, *slope;
    float rstd;
    float *dy;                     /**< in: d loss / d y; out: d loss / d(product) */
    float *dbias, *dgamma, *dbeta; /**< this row's gradients are added */
} nqm_hidden_row_back;

/** Adam's decay rates of the first and the second moment, and the constant that keeps it from dividing by zero. */
#define NQM_ADAM_BETA1   0.9
#define NQM_ADAM_BETA2   0.999
#define NQM_ADAM_EPSILON 1e-8

/** The constants of one step of Adam. */
typedef struct nqm_adam_rate {
    double step_size; /**< learning rate / (1 - beta1^step) */
    double v_scale;   /**< 1 / sqrt(1 - beta2^step): corrects for moments that start at 0 */
    double weight_decay;
} nqm_adam_rate;
/** The constants of step `step`; the first step is 1. */
nqm_adam_rate nqm_adam_rate_at(double lr, double weight_decay, uint64_t step);

/** The functions of one instruction set; every member is set unless its comment says otherwise. */
typedef struct nqm_kernels {
    const char *name;
    /** Rows times panels. A row has the same bits in any product. */
    void (*product[NQM_PRECISION_COUNT])(const nqm_product *p);
    /** Rows of the light transport (metric/transport.c). */
    void (*strided_product)(const nqm_strided_product *p);
    void (*gradient[NQM_PRECISION_COUNT])(const nqm_tile_gradient *g);
    /** The sum of x y over n floats. */
    float (*dot)(size_t n, const float *x, const float *y);
    void (*hidden_row)(const nqm_hidden_row *row);
    void (*hidden_row_back)(const nqm_hidden_row_back *row);
    /**
     * GELU with the exact (erf) definition: y = x Phi(x), slope = dy/dx = Phi(x) + x phi(x), for n values. Phi is within
     * 3e-7 of the normal distribution function everywhere. y may be x; slope may be NULL.
     */
    void (*gelu)(size_t n, const float *x, float *y, float *slope);
    /** x (n) as bfloat16 in nqm_words() words, to nearest, ties to even. */
    void (*round_row)(size_t n, const float *x, uint32_t *words);
    /** Two rows (n) as bfloat16; a word holds both values of a column. Groups of `width` columns (NQM_STRIP or NQM_PANEL)
     *  are stored `step` words apart; the last group is filled up with zeros. */
    void (*round_pair)(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *words);
    /** x (NQM_STRIP, NQM_PANEL) as bfloat16; a word holds two rows: (NQM_STRIP / 2, NQM_PANEL). */
    void (*round_tile)(const float *x, uint32_t *words);
    /** One step of Adam for n parameters; m, v: (n) the moments, 0 before the first step. */
    void (*adam)(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v, float *param);
} nqm_kernels;

/** Plain loops; products are summed in double and rounded once. Defines the results. */
extern const nqm_kernels nqm_kernels_scalar;
/** Vectors of 16 bytes, for every machine of the build's target: SSE2, NEON. */
extern const nqm_kernels nqm_kernels_generic;
#if defined __x86_64__
extern const nqm_kernels nqm_kernels_avx2;        /**< AVX2, FMA */
extern const nqm_kernels nqm_kernels_avx512;      /**< AVX-512 F, BW, DQ, VL */
extern const nqm_kernels nqm_kernels_avx512_bf16; /**< the same with BF16 */
#endif

/** The table in use: nqm_kernels_at(0) unless nqm_kernels_use() chose another. Any thread. */
const nqm_kernels *nqm_kernels_get(void);
/** Choose the table for the whole process; for tests and benchmarks. NULL: nqm_kernels_at(0). */
void nqm_kernels_use(const nqm_kernels *kernels);
/** The i-th table that this processor can run, the widest instructions first, the plain loops last; NULL beyond. */
const nqm_kernels *nqm_kernels_at(size_t i);

/** GELU by the table in use. */
static inline void nqm_gelu(size_t n, const float *x, float *y, float *slope) {
    nqm_kernels_get()->gelu(n, x, y, slope);
}
/** Adam by the table in use. */
static inline void nqm_adam_update(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v,
                                   float *param) {
    nqm_kernels_get()->adam(n, rate, grad, m, v, param);
}

/** The names of nqm_precision, "f32" and "bf16", then NULL. */
extern const char *const nqm_precision_words[];

/** The i-th kernel set ("avx512+bf16", "avx512", "avx2", "generic", "scalar") that this processor supports, the widest
 *  instructions first; static storage; NULL when there are not that many. "scalar" consists of plain loops: slow, and
 *  the reference for the others. */
const char *nqm_kernels_name(size_t i);

/** Select a kernel set for the whole process, for tests and benchmarks; NULL selects the first. NQM_ERR_ARG when this
 *  processor does not support it. Do not call it while another thread computes. */
NQM_MUST_CHECK nqm_status nqm_kernels_select(const char *name, nqm_error *err);

#endif
