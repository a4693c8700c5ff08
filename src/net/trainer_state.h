/* SPDX-License-Identifier: MIT
 *
 * trainer_state.h - what a training holds: used by trainer.c (forward) and trainer_back.c (backward) only.
 */
#ifndef NQM_SRC_NET_TRAINER_STATE_H
#define NQM_SRC_NET_TRAINER_STATE_H

#include "kernel/panel.h"
#include "net/trainer.h"

/** Bias and LayerNorm of a hidden layer: (out) each. */
enum { NQM_BIAS, NQM_GAMMA, NQM_BETA, NQM_VECTORS };

/** A value of every trained number of a hidden layer: the weights, a moment. */
typedef struct nqm_layer_values {
    nqm_panels w; /* (in, out), NQM_PRECISION_F32 */
    float *vector[NQM_VECTORS];
} nqm_layer_values;

/** A matrix (batch, n) on its way into products. In NQM_PRECISION_F32 these take the numbers as they lie. */
typedef struct nqm_factor {
    size_t n, ld; /* rows of x go on with zeros up to ld */
    float *x;     /* (max_batch, ld), or two rows a thread where that is enough: */
    bool two_rows;
    uint32_t *rows; /* (max_batch, ld_rows) words of neighbours in a row, or x itself: the left factor of a product */
    size_t ld_rows;
    size_t width; /* of a group of columns: NQM_STRIP for a layer's input, NQM_PANEL for its product's gradient */
    nqm_columns columns; /* the same as a factor of a weight gradient; x itself, or in `pairs` */
    uint32_t *pairs;     /* (groups, columns.step); NQM_PRECISION_BF16 only */
} nqm_factor;

/** A hidden layer with what follows it, and its activations for a batch. */
typedef struct nqm_trainer_layer {
    size_t in, out, ld; /* ld: from row to row of the activations */
    nqm_layer_values value, m, v;
    nqm_panels rounded; /* the weights as the forward product reads them; NQM_PRECISION_BF16 only */
    nqm_panels
        backward;  /* (out, in) the transpose, as the product for the input's gradient reads it; empty: not needed */
    float *xhat;   /* (max_batch, ld) the product, then the normalised values */
    nqm_factor y;  /* what it gives; of the last one the numbers alone */
    nqm_factor dz; /* the gradient with respect to y, then to the product */
    float *slope;  /* (max_batch, ld) */
    float *rstd;   /* (max_batch) */
} nqm_trainer_layer;

/** A block of memory, in numbers or words. */
typedef struct nqm_trainer_block {
    void *data;
    size_t n;
} nqm_trainer_block;

enum { NQM_TRAINER_BLOCKS = 16 * NQM_NET_MAX_LAYERS };

/** The output, of one unit: the weights of what the last hidden layer gives (n), then the bias. It takes floats in every
 *  precision. */
typedef struct nqm_trainer_output {
    size_t n;
    float *value, *m, *v; /* (n + 1) */
    float *sums;          /* (blocks of rows, n) of the gradient */
} nqm_trainer_output;

struct nqm_trainer {
    nqm_trainer_block blocks[NQM_TRAINER_BLOCKS]; /* all that the pointers below lead to, but for panels */
    size_t n_blocks;
    nqm_net_shape shape;
    nqm_trainer_options options;
    nqm_factor input;
    size_t n_hidden; /* at least one */
    nqm_trainer_layer layer[NQM_NET_MAX_LAYERS];
    nqm_trainer_output output;
    /* NQM_PRECISION_BF16 only: what layers take turns with, so that it stays in the caches. */
    uint32_t *rows;     /* of all factors but the input: each is read by one product before the next one is made */
    float *dz;          /* likewise of gradients, */
    uint32_t *dz_pairs; /* which two products read */
    float *zeros;       /* (widest) the neighbour of a last row without one */
    float *sums;        /* (blocks of rows, NQM_VECTORS, widest ld) of the gradients of bias and LayerNorm */
    uint64_t n_steps;
};

/** Rows whose sums are added first, so that these do not depend on the number of threads. Even. */
enum { NQM_ROW_BLOCK = 32 };

static inline size_t nqm_row_blocks(size_t batch) {
    return (batch + NQM_ROW_BLOCK - 1) / NQM_ROW_BLOCK;
}

/** Rows first and, where n is 2, first + 1 of a factor are complete: x, one below the other. first is even. */
void nqm_factor_rows_done(const nqm_trainer *trainer, const nqm_factor *f, size_t first, size_t n, const float *x);

/** Bring the weights' other forms up to date. */
void nqm_trainer_refresh(nqm_trainer *trainer);

#endif
