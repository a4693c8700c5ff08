/* SPDX-License-Identifier: MIT
 *
 * The backward pass, layer by layer from the output. The gradient of a layer's input is computed first, from the weights
 * before their step; then tiles of the weight gradient are passed to a sink, which updates the weights or stores the gradient.
 */
#include "net/trainer_state.h"

#include <string.h>

enum { TILE = NQM_STRIP * NQM_PANEL };

/* Receives the gradients of a layer. */
typedef struct sink {
    nqm_trainer_layer *layer;
    nqm_adam_rate rate;   /* of the layer's weights and bias */
    nqm_adam_rate norm;   /* of its LayerNorm */
    bool frozen_norm;     /* LayerNorm is not updated */
    const nqm_layer *out; /* store gradients here; NULL: update the parameters */
} sink;

/* ---- weights ----------------------------------------------------------------------------------------------------- */

static size_t tile_at(const nqm_panels *w, size_t strip, size_t panel) {
    return (panel * w->stride + strip * NQM_STRIP) * NQM_PANEL;
}

static void prefetch_for_step(void *user, size_t strip, size_t panel, const float *prefetch[NQM_PREFETCH]) {
    const sink *s = user;
    const nqm_layer_values *stored = s->layer->stored;
    for (size_t i = 0; i < NQM_PREFETCH; ++i)
        prefetch[i] = (const float *)stored[i].w.data + tile_at(&stored[i].w, strip, panel);
}

static void step_tiles(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    const sink *s = user;
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

static void store_tiles(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    const sink *s = user;
    const size_t in = s->layer->in, out = s->layer->out, first = strip * NQM_STRIP;
    for (size_t i = 0; i < n_strips * NQM_STRIP && first + i < in; ++i)
        for (size_t j = 0; j < NQM_PANEL && panel * NQM_PANEL + j < out; ++j)
            s->out->w[(panel * NQM_PANEL + j) * in + first + i] = tiles[i * NQM_PANEL + j];
}

/* Pass the gradient of the weights of a layer with input x to the sink. */
static void weight_gradient(const nqm_trainer *t, sink *s, size_t batch, const nqm_factor *x) {
    const nqm_factor *dz = &s->layer->dz;
    nqm_gradient_run(&(nqm_gradient){.precision = t->options.precision,
                                     .m = batch,
                                     .k = x->n,
                                     .n = dz->n,
                                     .x = x->columns,
                                     .z = dz->columns,
                                     .sink = s->out ? store_tiles : step_tiles,
                                     .prefetch = s->out ? NULL : prefetch_for_step,
                                     .user = s});
}

/* ---- bias and LayerNorm ------------------------------------------------------------------------------------------ */

static void vector_gradient(const sink *s, size_t which, const float *gradient) {
    const size_t n = s->layer->out;
    const nqm_layer_values *stored = s->layer->stored;
    float *const out[] = {s->out ? s->out->b : NULL, s->out ? s->out->gamma : NULL, s->out ? s->out->beta : NULL};
    if (s->out)
        memcpy(out[which], gradient, n * sizeof *gradient);
    else
        nqm_adam_update(n, which == NQM_BIAS ? &s->rate : &s->norm, gradient, stored[NQM_MOMENT1].vector[which],
                        stored[NQM_MOMENT2].vector[which], stored[NQM_VALUE].vector[which]);
}

/* Round rows in pairs; the last row of an odd number by itself. */
static void dz_row_done(const nqm_trainer *t, const nqm_trainer_layer *layer, size_t row, size_t end) {
    const size_t first = row / 2 * 2;
    if (row > first || row + 1 == end)
        nqm_factor_rows_done(t, &layer->dz, first, row - first + 1, layer->dz.x + first * layer->dz.ld);
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
static void hidden_back(nqm_trainer *t, const sink *s, size_t l, size_t batch) {
    const nqm_trainer_layer *layer = &t->layer[l];
    const size_t n_blocks = nqm_row_blocks(batch), n = NQM_VECTORS * layer->ld;
#pragma omp parallel for schedule(static) if (batch * layer->out >= NQM_MIN_PARALLEL)
    for (size_t block = 0; block < n_blocks; ++block)
        block_back(t, l, block, batch);
    add_blocks(n_blocks, n, t->sums);
    for (size_t which = 0; which < NQM_VECTORS; ++which)
        if (which == NQM_BIAS || !s->frozen_norm)
            vector_gradient(s, which, t->sums + which * layer->ld);
}

/* ---- backward pass ----------------------------------------------------------------------------------------------- */

typedef struct backward {
    size_t batch;
    const float *dz;             /* (batch, outputs) d loss / d z */
    const nqm_step_rates *rates; /* of a step; NULL: store gradients in grads */
    nqm_params *grads;
    float *dx; /* (batch, inputs) NULL: not computed */
} backward;

static sink sink_of(nqm_trainer *t, const backward *pass, size_t l) {
    sink s = {.layer = &t->layer[l]};
    const nqm_step_rates *rates = pass->rates;
    if (!rates) {
        s.out = &pass->grads->layer[l];
        return s;
    }
    s.rate = nqm_adam_rate_at(l == 0 ? rates->lr_first : rates->lr_deeper, rates->weight_decay, t->n_steps);
    s.norm = nqm_adam_rate_at(rates->lr_deeper, rates->weight_decay, t->n_steps);
    s.frozen_norm = l == 0 && rates->freeze_first_layernorm;
    return s;
}

/* On entry dz of layer l is the gradient of the layer's output; on return dz of layer l - 1 is that of its output. */
static void layer_back(nqm_trainer *t, const backward *pass, size_t l) {
    const size_t batch = pass->batch;
    sink s = sink_of(t, pass, l);
    nqm_trainer_layer *layer = s.layer, *below = l > 0 ? &t->layer[l - 1] : NULL;
    hidden_back(t, &s, l, batch);
    if (below)
        nqm_multiply(&layer->backward, batch, layer->dz.rows, layer->dz.ld_rows, false, below->dz.x, below->dz.ld);
    weight_gradient(t, &s, batch, below ? &below->y : &t->input);
}

/* A block of rows of the output layer: the gradient of its input, and the sum of the gradients of its weights. */
static void output_block_back(nqm_trainer *t, const backward *pass, size_t block) {
    const nqm_trainer_layer *layer = &t->layer[t->n_hidden - 1];
    const size_t n = t->output.n, n_outputs = t->output.n_outputs, first = block * NQM_ROW_BLOCK;
    const size_t end = nqm_smaller(first + NQM_ROW_BLOCK, pass->batch);
    const float *w = t->output.stored[NQM_VALUE];
    float *sums = memset(t->output.sums + block * n_outputs * n, 0, n_outputs * n * sizeof *sums);
    for (size_t row = first; row < end; ++row) {
        const float *y = layer->y.x + row * layer->ld;
        float *dy = memset(layer->dz.x + row * layer->ld, 0, n * sizeof *dy);
        for (size_t o = 0; o < n_outputs; ++o) {
            const float dz = pass->dz[row * n_outputs + o];
#pragma omp simd
            for (size_t i = 0; i < n; ++i) {
                dy[i] += dz * w[o * n + i];
                sums[o * n + i] += dz * y[i];
            }
        }
    }
}

static void output_back(nqm_trainer *t, const backward *pass) {
    const nqm_trainer_output *output = &t->output;
    const size_t n_blocks = nqm_row_blocks(pass->batch), n_outputs = output->n_outputs, n = n_outputs * output->n;
    float *sums = output->sums, bias[NQM_NET_MAX_OUTPUTS];
#pragma omp parallel for schedule(static) if (pass->batch * n >= NQM_MIN_PARALLEL)
    for (size_t block = 0; block < n_blocks; ++block)
        output_block_back(t, pass, block);
    add_blocks(n_blocks, n, sums);
    for (size_t o = 0; o < n_outputs; ++o) {
        double sum = 0;
        for (size_t i = 0; i < pass->batch; ++i)
            sum += (double)pass->dz[i * n_outputs + o];
        bias[o] = (float)sum;
    }
    if (!pass->rates) {
        const nqm_layer *grads = &pass->grads->layer[t->n_hidden];
        memcpy(grads->w, sums, n * sizeof *sums);
        memcpy(grads->b, bias, n_outputs * sizeof *bias);
        return;
    }
    const nqm_adam_rate rate = nqm_adam_rate_at(pass->rates->lr_deeper, pass->rates->weight_decay, t->n_steps);
    float *value = output->stored[NQM_VALUE], *m = output->stored[NQM_MOMENT1], *v = output->stored[NQM_MOMENT2];
    nqm_adam_update(n, &rate, sums, m, v, value);
    nqm_adam_update(n_outputs, &rate, bias, m + n, v + n, value + n);
}

/* Overwrites the inputs with their gradient. */
static void input_back(nqm_trainer *t, const backward *pass) {
    const nqm_trainer_layer *first = &t->layer[0];
    nqm_multiply(&first->backward, pass->batch, first->dz.rows, first->dz.ld_rows, false, t->input.x, t->input.ld);
    for (size_t i = 0; i < pass->batch; ++i)
        memcpy(pass->dx + i * t->input.n, t->input.x + i * t->input.ld, t->input.n * sizeof *pass->dx);
}

static void run_backward(nqm_trainer *t, const backward *pass) {
    output_back(t, pass);
    for (size_t l = t->n_hidden; l-- > 0;)
        layer_back(t, pass, l);
    if (pass->dx)
        input_back(t, pass);
}

void nqm_trainer_step(nqm_trainer *t, size_t batch, const float *dz, const nqm_step_rates *rates) {
    t->n_steps++;
    run_backward(t, &(backward){.batch = batch, .dz = dz, .rates = rates});
}

void nqm_trainer_gradients(nqm_trainer *t, size_t batch, const float *dz, nqm_params *grads, float *dx) {
    run_backward(t, &(backward){.batch = batch, .dz = dz, .grads = grads, .dx = dx});
}
