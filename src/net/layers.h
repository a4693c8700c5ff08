/* SPDX-License-Identifier: MIT
 *
 * layers.h - what a hidden layer does behind its matrix product: bias, LayerNorm, GELU, dropout, and the way back. Used
 * by mlp.c only.
 */
#ifndef NQM_SRC_NET_LAYERS_H
#define NQM_SRC_NET_LAYERS_H

#include "net/net.h"

/** One hidden layer with its buffers. The last three are NULL in inference. */
typedef struct nqm_hidden {
    size_t index, n;        /* which layer; its width */
    const nqm_layer *layer; /* b, gamma, beta */
    float *y;               /* (batch, n) forward: receives the output */
    float *xhat;            /* (batch, n) in: x W^T; forward leaves the normalised values there */
    float *slope;           /* (batch, n) forward: dy / d(LayerNorm's output), dropout included */
    float *rstd;            /* (batch) 1 / standard deviation of each row before the normalisation */
} nqm_hidden;

/** From x W^T (in xhat, or in y when xhat is NULL) to the layer's output y. dropout NULL: none. */
void nqm_hidden_forward(const nqm_hidden *hidden, size_t batch, const nqm_dropout *dropout);
/** dy (batch, n): in d loss / d y, out d loss / d (x W^T). Writes the gradients of b, gamma, beta; uses up `slope`. */
void nqm_hidden_backward(const nqm_hidden *hidden, size_t batch, float *dy, const nqm_layer *grad);
/** sums[j] = sum over rows of x[i][j], each column in the order of the rows. */
void nqm_column_sums(size_t rows, size_t columns, const float *x, float *sums);

#endif
