/* SPDX-License-Identifier: MIT
 *
 * The way back through the network in training. Layer by layer from the output: the gradient with respect to a layer's
 * input comes first, by the weights before their step; tiles of the gradient of the weights go into a sink, which steps them
 * or stores the gradient.
 */
#include "net/trainer_state.h"

#include <string.h>

enum { TILE = NQM_STRIP * NQM_PANEL };

/* What becomes of gradients. */
typedef struct sink {
    nqm_trainer_layer *layer;
    nqm_adam_rate rate;   /* of the layer's weights and bias */
    nqm_adam_rate norm;   /* of its LayerNorm */
    bool frozen_norm;     /* which takes no step */
    const nqm_layer *out; /* store here instead of stepping; NULL: step */
} sink;

/* ---- weights ----------------------------------------------------------------------------------------------------- */

static size_t tile_at(const nqm_panels *w, size_t strip, size_t panel) {
    return (panel * w->stride + strip * NQM_STRIP) * NQM_PANEL;
}

static void wanted_for_step(void *user, size_t strip, size_t panel, const float *prefetch[NQM_PREFETCH]) {
    const sink *s = user;
    const nqm_panels *const values[NQM_PREFETCH] = {&s->layer->value.w, &s->layer->m.w, &s->layer->v.w};
    for (size_t i = 0; i < NQM_PREFETCH; ++i)
        prefetch[i] = (const float *)values[i]->data + tile_at(values[i], strip, panel);
}

static void step_tiles(void *user, size_t strip, size_t n_strips, size_t panel, const float *tiles) {
    const sink *s = user;
    const nqm_panels *w = &s->layer->value.w;
    const size_t at = tile_at(w, strip, panel);
    float *value = (float *)w->data + at, *m = (float *)s->layer->m.w.data + at, *v = (float *)s->layer->v.w.data + at;
    nqm_adam_update(n_strips * TILE, &s->rate, tiles, m, v, value);
    if (s->layer->backward.data) /* its product has been taken */
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

/* The gradient of the weights of a layer with input x, into the sink. */
static void weight_gradient(const nqm_trainer *t, sink *s, size_t batch, const nqm_factor *x) {
    const nqm_factor *dz = &s->layer->dz;
    nqm_gradient_run(&(nqm_gradient){.precision = t->options.precision,
                                     .m = batch,
                                     .k = x->n,
                                     .n = dz->n,
                                     .x = x->columns,
                                     .z = dz->columns,
                                     .sink = s->out ? store_tiles : step_tiles,
                                     .prefetch = s->out ? NULL : wanted_for_step,
                                     .user = s});
}

/* ---- bias and LayerNorm ------------------------------------------------------------------------------------------ */

static void take_vector(const sink *s, size_t which, const float *gradient) {
    const size_t n = s->layer->out;
    float *const stored[] = {s->out ? s->out->b : NULL, s->out ? s->out->gamma : NULL, s->out ? s->out->beta : NULL};
    if (s->out)
        memcpy(stored[which], gradient, n * sizeof *gradient);
    else
        nqm_adam_update(n, which == NQM_BIAS ? &s->rate : &s->norm, gradient, s->layer->m.vector[which],
                        s->layer->v.vector[which], s->layer->value.vector[which]);
}

/* Rows are rounded two at a time, the last one of all alone. */
static void dz_row_done(const nqm_trainer *t, const nqm_trainer_layer *layer, size_t row, size_t end) {
    const size_t first = row / 2 * 2;
    if (row > first || row + 1 == end)
        nqm_factor_rows_done(t, &layer->dz, first, row - first + 1, layer->dz.x + first * layer->dz.ld);
}

/* The sums (n) of blocks, one behind the other, into the first. */
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
                                                        .gamma = layer->value.vector[NQM_GAMMA],
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

/* Its dz holds d loss / d y, and afterwards d loss / d (its product). */
static void hidden_back(nqm_trainer *t, const sink *s, size_t l, size_t batch) {
    const nqm_trainer_layer *layer = &t->layer[l];
    const size_t n_blocks = nqm_row_blocks(batch), n = NQM_VECTORS * layer->ld;
#pragma omp parallel for schedule(static) if (batch * layer->out >= NQM_MIN_PARALLEL)
    for (size_t block = 0; block < n_blocks; ++block)
        block_back(t, l, block, batch);
    add_blocks(n_blocks, n, t->sums);
    for (size_t which = 0; which < NQM_VECTORS; ++which)
        if (which == NQM_BIAS || !s->frozen_norm)
            take_vector(s, which, t->sums + which * layer->ld);
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

typedef struct way_back {
    size_t batch;
    const float *dz;
    const nqm_step_rates *rates; /* NULL: store */
    nqm_params *grads;
    float *dx; /* NULL: not prefetch */
} way_back;

static sink sink_of(nqm_trainer *t, const way_back *way, size_t l) {
    sink s = {.layer = &t->layer[l]};
    const nqm_step_rates *rates = way->rates;
    if (!rates) {
        s.out = &way->grads->layer[l];
        return s;
    }
    s.rate = nqm_adam_rate_at(l == 0 ? rates->lr_first : rates->lr_deeper, rates->weight_decay, t->n_steps);
    s.norm = nqm_adam_rate_at(rates->lr_deeper, rates->weight_decay, t->n_steps);
    s.frozen_norm = l == 0 && rates->freeze_first_layernorm;
    return s;
}

/* Layer l, whose dz holds the gradient of what it gives; afterwards that of the layer below does. */
static void layer_back(nqm_trainer *t, const way_back *way, size_t l) {
    const size_t batch = way->batch;
    sink s = sink_of(t, way, l);
    nqm_trainer_layer *layer = s.layer, *below = l > 0 ? &t->layer[l - 1] : NULL;
    hidden_back(t, &s, l, batch);
    if (below)
        nqm_multiply(&layer->backward, batch, layer->dz.rows, layer->dz.ld_rows, false, below->dz.x, below->dz.ld);
    weight_gradient(t, &s, batch, below ? &below->y : &t->input);
}

/* Some rows of the output: the gradient of what the last hidden layer gives, and the sum of the weights'. */
static void output_block_back(nqm_trainer *t, const way_back *way, size_t block) {
    const nqm_trainer_layer *layer = &t->layer[t->n_hidden - 1];
    const size_t n = t->output.n, first = block * NQM_ROW_BLOCK;
    const size_t end = nqm_smaller(first + NQM_ROW_BLOCK, way->batch);
    const float *w = t->output.value;
    float *sums = memset(t->output.sums + block * n, 0, n * sizeof *sums);
    for (size_t row = first; row < end; ++row) {
        const float dz = way->dz[row], *y = layer->y.x + row * layer->ld;
        float *dy = layer->dz.x + row * layer->ld;
#pragma omp simd
        for (size_t i = 0; i < n; ++i) {
            dy[i] = dz * w[i];
            sums[i] += dz * y[i];
        }
    }
}

static void output_back(nqm_trainer *t, const way_back *way) {
    const nqm_trainer_output *output = &t->output;
    const size_t n_blocks = nqm_row_blocks(way->batch), n = output->n;
    float *sums = output->sums;
#pragma omp parallel for schedule(static) if (way->batch * n >= NQM_MIN_PARALLEL)
    for (size_t block = 0; block < n_blocks; ++block)
        output_block_back(t, way, block);
    add_blocks(n_blocks, n, sums);
    double sum = 0;
    for (size_t i = 0; i < way->batch; ++i)
        sum += (double)way->dz[i];
    const float bias = (float)sum;
    if (!way->rates) {
        const nqm_layer *grads = &way->grads->layer[t->n_hidden];
        memcpy(grads->w, sums, n * sizeof *sums);
        grads->b[0] = bias;
        return;
    }
    const nqm_adam_rate rate = nqm_adam_rate_at(way->rates->lr_deeper, way->rates->weight_decay, t->n_steps);
    nqm_adam_update(n, &rate, sums, output->m, output->v, output->value);
    nqm_adam_update(1, &rate, &bias, output->m + n, output->v + n, output->value + n);
}

/* The gradient of the inputs takes their place. */
static void input_back(nqm_trainer *t, const way_back *way) {
    const nqm_trainer_layer *first = &t->layer[0];
    nqm_multiply(&first->backward, way->batch, first->dz.rows, first->dz.ld_rows, false, t->input.x, t->input.ld);
    for (size_t i = 0; i < way->batch; ++i)
        memcpy(way->dx + i * t->input.n, t->input.x + i * t->input.ld, t->input.n * sizeof *way->dx);
}

static void go_back(nqm_trainer *t, const way_back *way) {
    output_back(t, way);
    for (size_t l = t->n_hidden; l-- > 0;)
        layer_back(t, way, l);
    if (way->dx)
        input_back(t, way);
}

void nqm_trainer_step(nqm_trainer *t, size_t batch, const float *dz, const nqm_step_rates *rates) {
    t->n_steps++;
    go_back(t, &(way_back){.batch = batch, .dz = dz, .rates = rates});
}

void nqm_trainer_gradients(nqm_trainer *t, size_t batch, const float *dz, nqm_params *grads, float *dx) {
    go_back(t, &(way_back){.batch = batch, .dz = dz, .grads = grads, .dx = dx});
}
