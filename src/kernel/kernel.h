/* SPDX-License-Identifier: MIT
 *
 * kernel.h - the arithmetic that dominates the network's time, as tables of functions: one table for each instruction
 * set, and one of plain loops that defines the results. Products, rows of hidden layers, GELU and Adam stand here; how
 * matrices lie in memory, and the loops over them on several threads, in kernel/panel.h.
 *
 * Results do not depend on the number of threads: each number is summed by one thread, over ascending k, in one chain
 * that starts from 0 or from what C holds; however the work is cut, the same operations are done. The tables of one
 * machine differ by rounding only: those with fused multiply-add give the same bits in NQM_PRECISION_F32.
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

enum {
    NQM_PANEL = 32, /**< columns of C that a panel holds */
    NQM_STRIP = 12  /**< rows of C that a strip holds */
};

/** Factors lie in words of 32 bits: 1, 2 or 4 neighbours along k. The last unit is filled up with zeros. */
static inline size_t nqm_words(nqm_precision precision, size_t k) {
    return ((k - 1) >> precision) + 1;
}

/** C (m, NQM_PANEL) = A B, or C + A B. A unit counts as many products as it holds factors. */
typedef struct nqm_product {
    size_t m, words;
    bool add;      /**< go on from C; false: from 0 */
    const void *a; /**< (m, words), lda words from row to row */
    const void *b; /**< (words, NQM_PANEL): a panel, aligned to 64 bytes */
    void *c;       /**< (m, NQM_PANEL) float, or int32_t for NQM_PRECISION_INT8; ldc numbers from row to row */
    size_t lda, ldc;
} nqm_product;

/** The same for one row and neighbouring panels: c (n_panels, NQM_PANEL) = a B, or c + a B. How fast the panels come
 *  bounds it: several of them at once keep enough sums going. */
typedef struct nqm_row_product {
    size_t words, n_panels;
    size_t stride; /**< words of a column from one panel to the next */
    bool add;
    const void *a, *b;
    void *c;
} nqm_row_product;

/** Arrays that a step of Adam reads: weights and moments. */
enum { NQM_PREFETCH = 3 };

/** A tile of a weight gradient: c (NQM_STRIP, NQM_PANEL) = left^T right, summed over `words` rows of both. */
typedef struct nqm_tile_gradient {
    size_t words;
    const void *left;  /**< (words, NQM_STRIP), of rows ld_left words apart */
    const void *right; /**< (words, NQM_PANEL), of rows ld_right words apart */
    size_t ld_left, ld_right;
    float *c;
    /** (NQM_STRIP, NQM_PANEL) each: needed soon, to be fetched meanwhile; c where nothing is. */
    const float *prefetch[NQM_PREFETCH];
} nqm_tile_gradient;

/** What a row of unsigned bytes stands for: (byte - zero) scale. */
typedef struct nqm_byte_scale {
    float scale;
    int32_t zero; /**< 0..255 */
} nqm_byte_scale;

/** The smallest scale for numbers of [low, high], low <= 0 <= high. */
static inline nqm_byte_scale nqm_byte_scale_of(float low, float high) {
    const float scale = high > low ? (high - low) / 255 : 1;
    return (nqm_byte_scale){scale, (int32_t)(-low / scale + 0.5f)};
}

/** What the columns of a panel of signed bytes stand for. */
typedef struct nqm_byte_columns {
    const float *scale; /**< (NQM_PANEL) a byte is worth this much */
    const int32_t *sum; /**< (NQM_PANEL) of all bytes of the column */
} nqm_byte_columns;

#define NQM_LAYERNORM_EPS 1e-5f

/** One row of a hidden layer behind its matrix product: xhat = normalise(x + bias), y = dropout(gelu(gamma xhat + beta)).
 *  All arrays: (n). */
typedef struct nqm_hidden_row {
    size_t n;
    const float *bias, *gamma, *beta;
    float *x;            /**< in: the product; out: xhat; may be y */
    float *y;            /**< out */
    float *slope;        /**< out: dy / d(gamma xhat + beta), dropout included; NULL: not prefetch, no dropout then */
    float *rstd;         /**< out (1): 1 / standard deviation of x + bias; NULL: not prefetch */
    const uint8_t *keep; /**< dropout: 0 drops; NULL: see threshold */
    double p;            /**< probability of 0: what is kept is scaled by 1/(1-p); 0: no dropout */
    uint64_t key,
        counter; /**< without `keep`, element i is dropped when 16 bits of hash (key, counter + i/4) are < p */
} nqm_hidden_row;

/** The way back through such a row, with the sums over rows: every array (n). */
typedef struct nqm_hidden_row_back {
    size_t n;
    const float *gamma, *xhat, *slope;
    float rstd;
    float *dy;                     /**< in: d loss / d y; out: d loss / d(product) */
    float *dbias, *dgamma, *dbeta; /**< this row is added */
} nqm_hidden_row_back;

/** Adam's decay of the first and the second moment, and what keeps it from dividing by zero. */
#define NQM_ADAM_BETA1   0.9
#define NQM_ADAM_BETA2   0.999
#define NQM_ADAM_EPSILON 1e-8

/** How far a step of Adam goes: nqm_adam_rate_at(). */
typedef struct nqm_adam_rate {
    double step_size; /**< learning rate / (1 - beta1^step) */
    double v_scale;   /**< 1 / sqrt(1 - beta2^step): both moments begin at 0 */
    double weight_decay;
} nqm_adam_rate;
/** The rate of a step, from 1 for the first. */
nqm_adam_rate nqm_adam_rate_at(double lr, double weight_decay, uint64_t step);

/** A multiple of the three channels that is one of every processor's vectors too. */
enum { NQM_WHITEN_PERIOD = 48 };

/** One way to compute; all fields are set. */
typedef struct nqm_kernels {
    const char *name;
    /** oneDNN's, or plain loops: the products of fits, whose shapes and layouts vary. */
    void (*gemm)(const nqm_gemm *g);
    /** Rows times a panel. */
    void (*product[NQM_PRECISION_COUNT])(const nqm_product *p);
    /** The same bits as `product` with m = 1. */
    void (*row_product[NQM_PRECISION_COUNT])(const nqm_row_product *p);
    /** NQM_PRECISION_F32 and _BF16 only; the last is NULL. */
    void (*gradient[NQM_PRECISION_COUNT])(const nqm_tile_gradient *g);
    /** The sum of x y over n numbers. */
    float (*dot)(size_t n, const float *x, const float *y);
    void (*hidden_row)(const nqm_hidden_row *row);
    void (*hidden_row_back)(const nqm_hidden_row_back *row);
    /**
     * GELU with the exact (erf) definition: y = x Phi(x), slope = dy/dx = Phi(x) + x phi(x), for n values. Phi is within
     * 3e-7 of the true normal distribution function everywhere. y may be x; slope may be NULL.
     */
    void (*gelu)(size_t n, const float *x, float *y, float *slope);
    /** n values t = log(cbrt(f_r) + 1) become those of s f_r, with k1 = cbrt(s) - 1, |k1| <= 0.018: within 3e-7 (1 + t). */
    void (*scale_log)(size_t n, float k1, const float *t, float *scaled);
    /** x = (t - mean) scale for n numbers; x may be t. Mean and scale, (NQM_WHITEN_PERIOD), begin again and again. */
    void (*whiten)(size_t n, const float *mean, const float *scale, const float *t, float *x);
    /** difference = s (b - a) and magnitude = s |b - a| for n numbers; difference may be b. */
    void (*differ)(size_t n, float s, const float *a, const float *b, float *difference, float *magnitude);
    /** x (n) as bfloat16 (nqm_words() words), to nearest, ties to even. */
    void (*round_row)(size_t n, const float *x, uint32_t *words);
    /** Two rows (n) likewise, but a unit holds two neighbours of a column; groups of columns, `width` (NQM_STRIP or NQM_PANEL)
     *  each, go to places `step` words apart, the last one filled up with zeros. */
    void (*round_pair)(size_t n, const float *even, const float *odd, size_t width, size_t step, uint32_t *words);
    /** x (NQM_STRIP, NQM_PANEL) likewise: (NQM_STRIP / 2, NQM_PANEL). */
    void (*round_tile)(const float *x, uint32_t *words);
    /** x (n) as unsigned bytes; returns what they stand for: 0 stands for itself. */
    nqm_byte_scale (*quantise_row)(size_t n, const float *x, uint32_t *words);
    /** c (m, NQM_PANEL) = what the integer sums (m, NQM_PANEL) of bytes stand for, or c + that; rows: (m). */
    void (*dequantise)(size_t m, const nqm_byte_scale *rows, const nqm_byte_columns *columns, bool add,
                       const int32_t *sums, float *c, size_t ldc);
    /** t = log(cbrt(rho) + 1) for n values rho >= 0, within 4e-7 relative; below 1e-30 0, above 1e37 as there. */
    void (*sample_log)(size_t n, const float *rho, float *t);
    /** The cube root of n values >= 0, within 1e-15 relative; below 1e-30 0, above 1e37 as there. */
    void (*cube_root)(size_t n, const double *x, double *root);
    /** y = log(1 + x) for n finite values x > -1, within 4e-16 or that relative, whichever is more. */
    void (*log_1p)(size_t n, const double *x, double *y);
    /** One step of Adam for n parameters; m, v: (n) the moments, zeros before the first step. */
    void (*adam)(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v, float *param);
} nqm_kernels;

/** Plain loops, products summed in double and rounded once: the definition. */
extern const nqm_kernels nqm_kernels_scalar;
/** Vectors of 16 bytes, for every machine of the build's target: SSE2, NEON. */
extern const nqm_kernels nqm_kernels_generic;
#if defined __x86_64__
extern const nqm_kernels nqm_kernels_avx2;        /**< AVX2, FMA */
extern const nqm_kernels nqm_kernels_avx512;      /**< AVX-512 F, BW, DQ, VL */
extern const nqm_kernels nqm_kernels_avx512_bf16; /**< and BF16, VNNI */
#endif

/** The table in use: the best that the processor can run, unless nqm_kernels_use() chose another. Any thread. */
const nqm_kernels *nqm_kernels_get(void);
/** Choose the table for the whole process; for tests and benchmarks. NULL: back to the best. */
void nqm_kernels_use(const nqm_kernels *kernels);
/** The i-th table that this processor can run, best first, the plain loops last; NULL beyond. */
const nqm_kernels *nqm_kernels_at(size_t i);

/** oneDNN's sgemm on blocks (gemm_onednn.c); plain loops where it is not installed. */
void nqm_gemm_onednn(const nqm_gemm *g);

/** GELU by the table in use. */
static inline void nqm_gelu(size_t n, const float *x, float *y, float *slope) {
    nqm_kernels_get()->gelu(n, x, y, slope);
}
/** Adam by the table in use. */
static inline void nqm_adam_update(size_t n, const nqm_adam_rate *rate, const float *grad, float *m, float *v,
                                   float *param) {
    nqm_kernels_get()->adam(n, rate, grad, m, v, param);
}

#endif
