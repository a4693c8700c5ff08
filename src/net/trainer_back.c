/* SPDX-License-Identifier: MIT
 *
 * The backward pass, layer by layer from the output. The gradient of a layer's input is computed first, from the weights
 * before their step; then the weights are updated by tiles of their gradient as these are summed.
 */
#include "net/trainer_state.h"

#include <string.h>

enum { TILE = NQM_STRIP * NQM_PANEL };

/* A step of a layer. */
typedef struct layer_step {
    nqm_trainer_layer *layer;
    nqm_adam_rate rate; /* rate of the layer's weights and bias */
    nqm_adam_rate norm; /* rate of its LayerNorm */
    bool frozen_norm;   /* LayerNorm is not updated */
} layer_step;

/* ---- weights ----------------------------------------------------------------------------------------------------- */

static size_t tile_at(const nqm_panels *w, size_t strip, size_t panel) {
    return (panel * w->stride + strip * NQM_STRIP) * NQM_PANEL;
}

static void prefetch_for_step(void *user, size_t strip, size_t panel, const float *prefetch[NQM_PREFETCH]) {
    const layer_step *s = user;
    const nqm_layer_values *stored = s->layer->stored;
    for (size_t i = 0; i < NQM_PREFETCH; ++i)
        prefetch[i] = (const float *)stored[i].w.data + tile_at(&stored[i].w, strip, panel);
}

static void step_tiles(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    const layer_step *s = user;
    const nqm_layer_values *stored = s->layer->stored;
    const nqm_panels *w = &stored[NQM_VALUE].w;
    const size_t at = tile_at(w, strip, panel);
    float *value = (float *)w->data + at, *m = (float *)stored[NQM_MOMENT1].w.data + at;
    nqm_adam_update(n_strips * TILE, &s->rate, tiles, m, (float *)stored[NQM_MOMENT2].w.data + at, value);
    if (s->layer->backward.data) /* the product with the old weights is done */
        nqm_panels_transpose_rows(w, &s->layer->backward, strip * NQM_STRIP, n_strips * NQM_STRIP, panel);
    if (!s->layer->rounded.data)
        return;
    uint32_t *words = nqm_panel_at(&s->layer->rounded, panel) + strip * TILE / 2;
    for (size_t i = 0; i < n_strips; ++i)
        nqm_kernels_get()->round_tile(value + i * TILE, words + i * TILE / 2);
}

/* Update the weights of a layer with input x. */
static void step_weights(const nqm_trainer *t, layer_step *s, size_t batch, const nqm_batch_matrix *x) {
    const nqm_batch_matrix *dz = &s->layer->dz;
    nqm_gradient_run(&(nqm_gradient){.precision = t->options.precision,
                                     .m = batch,
                                     .k = x->n,
                                     .n = dz->n,
                                     .x = {x->columns, x->step},
                                     .z = {dz->columns, dz->step},
                                     .sink = step_tiles,
                                     .prefetch = prefetch_for_step,
                                     .user = s});
}

/* ---- bias and LayerNorm ------------------------------------------------------------------------------------------ */

/* Round rows in pairs; the last row of an odd number by itself. */
static void dz_row_done(const nqm_trainer *t, const nqm_trainer_layer *layer, size_t row, size_t end) {
    const size_t first = row / 2 * 2;
    if (row > first || row + 1 == end)
        nqm_trainer_rows_done(t, &layer->dz, first, row - first + 1);
}

/* Add the sums (n_blocks, n) of all blocks to those of the first. */
static void add_blocks(size_t n_blocks, size_t n, float *sums) {
    for (size_t block = 1; block < n_blocks; ++block)
        for (size_t i = 0; i < n; ++i)
            sums[i] += sums[block * n + i];
}

static void block_back(nqm_trainer *t, size_t l, size_t block, size_t batch) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const nqm_trainer_layer *layer = &t->layer[l];
    float *sums = t->sums + block * NQM_VECTORS * layer->ld;
    memset(sums, 0, NQM_VECTORS * layer->ld * sizeof *sums);
    const size_t end = nqm_smaller((block + 1) * NQM_ROW_BLOCK, batch);
    for (size_t row = block * NQM_ROW_BLOCK; row < end; ++row) {
        kernels->hidden_row_back(&(nqm_hidden_row_back){.n = layer->out,
                                                        .gamma = layer->stored[NQM_VALUE].vector[NQM_GAMMA],
                                                        .xhat = layer->xhat + row * layer->ld,
                                                        .slope = layer->slope + row * layer->ld,
                                                        .rstd = layer->rstd[row],
                                                        .dy = layer->dz.x + row * layer->ld,
                                                        .dbias = sums + NQM_BIAS * layer->ld,
                                                        .dgamma = sums + NQM_GAMMA * layer->ld,
                                                        .dbeta = sums + NQM_BETA * layer->ld});
        dz_row_done(t, layer, row, end);
    }
}

/* Replace d loss / d y in the layer's dz by d loss / d(product), and update bias and LayerNorm. */
static void hidden_back(nqm_trainer *t, const layer_step *s, size_t l, size_t batch) {
    const nqm_trainer_layer *layer = s->layer;
    const size_t n_blocks = nqm_row_blocks(batch), n = NQM_VECTORS * layer->ld;
#pragma omp parallel for schedule(static) if (batch * layer->out >= NQM_MIN_PARALLEL)
    for (size_t block = 0; block < n_blocks; ++block)
        block_back(t, l, block, batch);
    add_blocks(n_blocks, n, t->sums);
    for (size_t i = 0; i < NQM_VECTORS; ++i)
        if (i == NQM_BIAS || !s->frozen_norm)
            nqm_adam_update(layer->out, i == NQM_BIAS ? &s->rate : &s->norm, t->sums + i * layer->ld,
                            layer->stored[NQM_MOMENT1].vector[i], layer->stored[NQM_MOMENT2].vector[i],
                            layer->stored[NQM_VALUE].vector[i]);
}

/* ---- backward pass ----------------------------------------------------------------------------------------------- */

/* On entry dz of layer l is the gradient of the layer's output; on return dz of layer l - 1 is that of its output. */
static void layer_back(nqm_trainer *t, size_t l, size_t batch, const nqm_step_rates *rates) {
    nqm_trainer_layer *layer = &t->layer[l], *below = l > 0 ? &t->layer[l - 1] : NULL;
    layer_step s = {.layer = layer,
                    .rate =
                        nqm_adam_rate_at(l == 0 ? rates->lr_first : rates->lr_deeper, rates->weight_decay, t->n_steps),
                    .norm = nqm_adam_rate_at(rates->lr_deeper, rates->weight_decay, t->n_steps),
                    .frozen_norm = l == 0 && rates->freeze_first_layernorm};
    hidden_back(t, &s, l, batch);
    if (below)
        nqm_multiply(&layer->backward, batch, layer->dz.rows, layer->dz.ld_rows, false, below->dz.x, below->dz.ld);
    step_weights(t, &s, batch, below ? &below->y : &t->input);
}

/* A block of rows of the output layer: the gradient of its input, and the sum of the gradients of its weights. */
static void output_block_back(nqm_trainer *t, size_t block, size_t batch, const float *dz) {
    const nqm_trainer_layer *layer = &t->layer[t->n_hidden - 1];
    const size_t n = t->output.n, n_outputs = t->output.n_outputs, first = block * NQM_ROW_BLOCK;
    const size_t end = nqm_smaller(first + NQM_ROW_BLOCK, batch);
    const float *w = t->output.stored[NQM_VALUE];
    float *sums = memset(t->output.sums + block * n_outputs * n, 0, n_outputs * n * sizeof *sums);
    for (size_t row = first; row < end; ++row) {
        const float *y = layer->y.x + row * layer->ld;
        float *dy = memset(layer->dz.x + row * layer->ld, 0, n * sizeof *dy);
        for (size_t o = 0; o < n_outputs; ++o) {
            const float slope = dz[row * n_outputs + o];
#pragma omp simd
            for (size_t i = 0; i < n; ++i) {
                dy[i] += slope * w[o * n + i];
                sums[o * n + i] += slope * y[i];
            }
        }
    }
}

static void output_back(nqm_trainer *t, size_t batch, const float *dz, const nqm_step_rates *rates) {
    const nqm_trainer_output *output = &t->output;
    const size_t n_blocks = nqm_row_blocks(batch), n_outputs = output->n_outputs, n = n_outputs * output->n;
    float *sums = output->sums, bias[NQM_NET_MAX_OUTPUTS];
#pragma omp parallel for schedule(static) if (batch * n >= NQM_MIN_PARALLEL)
    for (size_t block = 0; block < n_blocks; ++block)
        output_block_back(t, block, batch, dz);
    add_blocks(n_blocks, n, sums);
    for (size_t o = 0; o < n_outputs; ++o) {
        double sum = 0;
        for (size_t i = 0; i < batch; ++i)
            sum += (double)dz[i * n_outputs + o];
        bias[o] = (float)sum;
    }
    const nqm_adam_rate rate = nqm_adam_rate_at(rates->lr_deeper, rates->weight_decay, t->n_steps);
    float *value = output->stored[NQM_VALUE], *m = output->stored[NQM_MOMENT1], *v = output->stored[NQM_MOMENT2];
    nqm_adam_update(n, &rate, sums, m, v, value);
    nqm_adam_update(n_outputs, &rate, bias, m + n, v + n, value + n);
}

void nqm_trainer_step(nqm_trainer *t, size_t batch, const float *dz, const nqm_step_rates *rates) {
    t->n_steps++;
    output_back(t, batch, dz, rates);
    for (size_t l = t->n_hidden; l-- > 0;)
        layer_back(t, l, batch, rates);
}
