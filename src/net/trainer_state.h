/* SPDX-License-Identifier: MIT
 *
 * trainer_state.h - the state of a training: used by trainer.c (forward) and trainer_back.c (backward) only.
 */
#ifndef NQM_SRC_NET_TRAINER_STATE_H
#define NQM_SRC_NET_TRAINER_STATE_H

#include "kernel/panel.h"
#include "net/trainer.h"

/** Bias and LayerNorm of a hidden layer: (out) each. */
enum { NQM_BIAS, NQM_GAMMA, NQM_BETA, NQM_VECTORS };

/** What is stored of each parameter: its value, and Adam's moments of it. */
enum { NQM_VALUE, NQM_MOMENT1, NQM_MOMENT2, NQM_STORED_VALUES };

/** One of these for each parameter of a hidden layer. */
typedef struct nqm_layer_values {
    nqm_panels w; /**< (in, out), NQM_PRECISION_F32 */
    float *vector[NQM_VECTORS];
} nqm_layer_values;

/** A matrix (batch, n) of activations or of gradients, in the forms that products read: rows are the left factor of a
 *  product, columns a factor of a weight gradient. In NQM_PRECISION_F32 the rows are x. */
typedef struct nqm_batch_matrix {
    size_t n, ld;   /**< floats from row to row of x; zeros from n to ld */
    float *x;       /**< (max_batch, ld) */
    uint32_t *rows; /**< (max_batch, ld_rows) words */
    size_t ld_rows; /**< words */
    size_t width;   /**< columns of a group: NQM_STRIP for the input of a layer, NQM_PANEL for the product's gradient */
    uint32_t *columns; /**< (groups, step) words */
    size_t step;
} nqm_batch_matrix;

/** A hidden layer and its activations for a batch. */
typedef struct nqm_trainer_layer {
    size_t in, out, ld; /**< ld: floats from row to row of the activations */
    nqm_layer_values stored[NQM_STORED_VALUES];
    nqm_panels rounded;  /**< the weights in NQM_PRECISION_BF16, for the forward product; else empty */
    nqm_panels backward; /**< (out, in) the transposed weights, for the gradient of the input; empty in layer 0 */
    float *xhat;         /**< (max_batch, ld) the product, then the normalised values */
    nqm_batch_matrix y;  /**< the output of the layer; of the last hidden layer x only */
    nqm_batch_matrix dz; /**< d loss / d y, then d loss / d(product) */
    float *slope;        /**< (max_batch, ld) */
    float *rstd;         /**< (max_batch) */
} nqm_trainer_layer;

/** The output layer, which is float in every precision. */
typedef struct nqm_trainer_output {
    size_t n, n_outputs;              /**< n: inputs */
    float *stored[NQM_STORED_VALUES]; /**< values of the weights (n_outputs, n), then of the biases (n_outputs) */
    float *sums;                      /**< (row blocks, n_outputs, n) gradients of the weights */
} nqm_trainer_output;

struct nqm_trainer {
    float *block; /**< (n_block) floats and 32-bit words: all arrays below except panels are views into it */
    size_t n_block;
    nqm_net_shape shape;
    nqm_trainer_options options;
    nqm_batch_matrix input;
    size_t n_hidden; /**< hidden layers, at least one */
    nqm_trainer_layer layer[NQM_NET_MAX_LAYERS];
    nqm_trainer_output output;
    uint32_t *dz_columns; /**< of every gradient, in turn: read by one product before the next gradient is computed */
    /* NQM_PRECISION_BF16 only: arrays that the layers use in turn, so that they stay in the caches. */
    uint32_t *rows; /**< of every matrix but the input: read by one product before the next matrix is computed */
    float *dz;      /**< x of every gradient */
    float *zeros;   /**< (widest layer) the second row of a pair after the last row */
    float *sums;    /**< (row blocks, NQM_VECTORS, widest ld) gradients of bias and LayerNorm */
    uint64_t n_steps;
};

/** Gradients are summed over blocks of this many rows first, so that they do not depend on the number of threads. Even. */
enum { NQM_ROW_BLOCK = 32 };

static inline size_t nqm_row_blocks(size_t batch) {
    return (batch + NQM_ROW_BLOCK - 1) / NQM_ROW_BLOCK;
}

/** Copy rows [first, first + n) of a matrix, n <= 2, from x to its rows and columns, as far as these are not x. first is even. */
void nqm_trainer_rows_done(const nqm_trainer *trainer, const nqm_batch_matrix *m, size_t first, size_t n);

#endif
