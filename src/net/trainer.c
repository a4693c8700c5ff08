/* SPDX-License-Identifier: MIT
 *
 * Creation of a trainer, parameters to and from the layout of net.h, and the forward pass.
 */
#include "net/trainer_state.h"

#include <string.h>

static bool is_rounded(const nqm_trainer *t) {
    return t->options.precision == NQM_PRECISION_BF16;
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* The arrays of a trainer are views into one block (of large pages: products read a dozen rows at once). They are set twice:
 * without a block to add up n_block, then with it. */
static float *next_floats(nqm_trainer *t, size_t n) {
    float *view = t->block ? t->block + t->n_block : NULL;
    t->n_block += nqm_ceil_div(n, 16) * 16; /* whole cache lines */
    return view;
}

static uint32_t *next_words(nqm_trainer *t, size_t n) {
    return (uint32_t *)next_floats(t, n);
}

/* Words of the columns of a matrix. */
static uint32_t *next_columns(nqm_trainer *t, size_t n, size_t width) {
    return next_words(t, nqm_ceil_div(n, width) * nqm_columns_step(t->options.precision, width, t->options.max_batch));
}

/* A matrix without memory of its own. */
static nqm_batch_matrix matrix_of(const nqm_trainer *t, size_t n, size_t width) {
    return (nqm_batch_matrix){.n = n,
                              .ld = nqm_row_stride(n),
                              .rows = t->rows,
                              .ld_rows = nqm_row_stride(nqm_words(t->options.precision, n)),
                              .width = width,
                              .step = nqm_columns_step(t->options.precision, width, t->options.max_batch)};
}

/* The input of a layer. */
static void set_input(nqm_trainer *t, size_t n, nqm_batch_matrix *m) {
    *m = matrix_of(t, n, NQM_STRIP);
    m->x = next_floats(t, t->options.max_batch * m->ld);
    if (!is_rounded(t))
        m->rows = (uint32_t *)m->x;
    m->columns = next_columns(t, n, NQM_STRIP);
}

/* The gradient of a layer's product. */
static void set_gradient(nqm_trainer *t, size_t n, nqm_batch_matrix *m) {
    *m = matrix_of(t, n, NQM_PANEL);
    m->columns = t->dz_columns;
    m->x = is_rounded(t) ? t->dz : next_floats(t, t->options.max_batch * m->ld);
    if (!is_rounded(t))
        m->rows = (uint32_t *)m->x;
}

static void set_layer(nqm_trainer *t, size_t l) {
    nqm_trainer_layer *layer = &t->layer[l];
    const size_t out = t->shape.sizes[l + 1], batch = t->options.max_batch;
    layer->in = t->shape.sizes[l], layer->out = out, layer->ld = nqm_row_stride(out);
    for (size_t i = 0; i < NQM_STORED_VALUES * NQM_VECTORS; ++i)
        layer->stored[i / NQM_VECTORS].vector[i % NQM_VECTORS] = next_floats(t, out);
    layer->xhat = next_floats(t, batch * layer->ld);
    set_gradient(t, out, &layer->dz);
    if (l + 1 < t->n_hidden)
        set_input(t, out, &layer->y);
    else
        layer->y = (nqm_batch_matrix){.n = out, .ld = layer->ld, .x = next_floats(t, batch * layer->ld)};
    layer->slope = next_floats(t, batch * layer->ld);
    layer->rstd = next_floats(t, batch);
}

static void set_output(nqm_trainer *t) {
    nqm_trainer_output *output = &t->output;
    output->n = t->shape.sizes[t->n_hidden];
    output->n_outputs = t->shape.sizes[t->n_hidden + 1];
    for (size_t i = 0; i < NQM_STORED_VALUES; ++i)
        output->stored[i] = next_floats(t, output->n_outputs * (output->n + 1));
    output->sums = next_floats(t, nqm_row_blocks(t->options.max_batch) * output->n_outputs * output->n);
}

/* Arrays that the layers use in turn. */
static void set_shared(nqm_trainer *t) {
    const size_t batch = t->options.max_batch, *sizes = t->shape.sizes;
    size_t widest_out = 0;
    for (size_t l = 0; l < t->n_hidden; ++l)
        widest_out = nqm_larger(sizes[l + 1], widest_out);
    t->sums = next_floats(t, nqm_row_blocks(batch) * NQM_VECTORS * nqm_row_stride(widest_out));
    t->dz_columns = next_columns(t, widest_out, NQM_PANEL);
    if (!is_rounded(t))
        return;
    const nqm_batch_matrix widest = matrix_of(t, widest_out, NQM_PANEL);
    t->rows = next_words(t, batch * widest.ld_rows);
    t->dz = next_floats(t, batch * widest.ld);
    t->zeros = next_floats(t, nqm_larger(sizes[0], widest_out));
}

static void set_views(nqm_trainer *t) {
    t->n_block = 0;
    set_shared(t);
    set_input(t, t->shape.sizes[0], &t->input);
    if (is_rounded(t)) /* rows of its own: they are used again in the backward pass */
        t->input.rows = next_words(t, t->options.max_batch * t->input.ld_rows);
    for (size_t l = 0; l < t->n_hidden; ++l)
        set_layer(t, l);
    set_output(t);
}

static nqm_status create_panels(nqm_trainer *t, size_t l, nqm_error *err) {
    nqm_trainer_layer *layer = &t->layer[l];
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < NQM_STORED_VALUES && status == NQM_OK; ++i)
        status = nqm_panels_create(NQM_PRECISION_F32, layer->in, layer->out, &layer->stored[i].w, err);
    if (status == NQM_OK && is_rounded(t))
        status = nqm_panels_create(t->options.precision, layer->in, layer->out, &layer->rounded, err);
    if (status == NQM_OK && l > 0)
        status = nqm_panels_create(t->options.precision, layer->out, layer->in, &layer->backward, err);
    return status;
}

nqm_status nqm_trainer_create(const nqm_net_shape *shape, const nqm_trainer_options *options, nqm_trainer **trainer_ret,
                              nqm_error *err) {
    *trainer_ret = NULL;
    nqm_status status = nqm_net_shape_check(shape, err);
    if (status != NQM_OK)
        return status;
    if (options->max_batch < 1 || options->max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)",
                        options->max_batch);
    if (options->precision != NQM_PRECISION_F32 && options->precision != NQM_PRECISION_BF16)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: training is in f32 or bf16");
    nqm_trainer *t = nqm_alloc(1, sizeof *t);
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    t->shape = *shape;
    t->options = *options;
    t->n_hidden = shape->n_layers - 1;
    set_views(t);
    t->block = nqm_alloc_pages(t->n_block, sizeof *t->block);
    if (t->block)
        set_views(t);
    else
        status = nqm_fail_nomem(err, t->n_block * sizeof *t->block);
    for (size_t l = 0; l < t->n_hidden && status == NQM_OK; ++l)
        status = create_panels(t, l, err);
    if (status == NQM_OK)
        *trainer_ret = t;
    else
        nqm_trainer_free(t);
    return status;
}

void nqm_trainer_free(nqm_trainer *t) {
    if (!t)
        return;
    for (size_t l = 0; l < t->n_hidden; ++l) {
        nqm_trainer_layer *layer = &t->layer[l];
        for (size_t i = 0; i < NQM_STORED_VALUES; ++i)
            nqm_panels_free(&layer->stored[i].w);
        nqm_panels_free(&layer->rounded);
        nqm_panels_free(&layer->backward);
    }
    nqm_free_pages(t->block, t->n_block, sizeof *t->block);
    nqm_free(t);
}

/* ---- weights and moments ----------------------------------------------------------------------------------------- */

static void load_layer(nqm_layer_values *values, const nqm_layer *layer) {
    nqm_panels_pack(&values->w, (nqm_weights){layer->w, NULL, values->w.k});
    const float *const vectors[] = {layer->b, layer->gamma, layer->beta};
    for (size_t i = 0; i < NQM_VECTORS; ++i)
        memcpy(values->vector[i], vectors[i], values->w.n * sizeof(float));
}

static void store_layer(const nqm_layer_values *values, const nqm_layer *layer) {
    nqm_panels_unpack(&values->w, layer->w, values->w.k);
    float *const vectors[] = {layer->b, layer->gamma, layer->beta};
    for (size_t i = 0; i < NQM_VECTORS; ++i)
        memcpy(vectors[i], values->vector[i], values->w.n * sizeof(float));
}

static void clear_layer(nqm_layer_values *values) {
    memset(values->w.data, 0, values->w.n_panels * values->w.stride * NQM_PANEL * sizeof *values->w.data);
    for (size_t i = 0; i < NQM_VECTORS; ++i)
        memset(values->vector[i], 0, values->w.n * sizeof(float));
}

/* Update `rounded` and `backward` from the weights. */
static void convert_weights(nqm_trainer *t) {
    for (size_t l = 0; l < t->n_hidden; ++l) {
        nqm_trainer_layer *layer = &t->layer[l];
        if (is_rounded(t))
            nqm_panels_round(&layer->stored[NQM_VALUE].w, &layer->rounded);
        if (layer->backward.data)
            nqm_panels_transpose(&layer->stored[NQM_VALUE].w, &layer->backward);
    }
}

void nqm_trainer_load(nqm_trainer *t, const nqm_params *params, const nqm_adam *adam) {
    const nqm_params *const from[NQM_STORED_VALUES] = {params, adam ? &adam->m : NULL, adam ? &adam->v : NULL};
    const size_t n_biases = t->output.n_outputs, n_weights = n_biases * t->output.n;
    for (size_t i = 0; i < NQM_STORED_VALUES; ++i) {
        float *output = memset(t->output.stored[i], 0, (n_weights + n_biases) * sizeof *output);
        for (size_t l = 0; l < t->n_hidden; ++l)
            if (from[i])
                load_layer(&t->layer[l].stored[i], &from[i]->layer[l]);
            else
                clear_layer(&t->layer[l].stored[i]);
        if (from[i]) {
            memcpy(output, from[i]->layer[t->n_hidden].w, n_weights * sizeof *output);
            memcpy(output + n_weights, from[i]->layer[t->n_hidden].b, n_biases * sizeof *output);
        }
    }
    t->n_steps = adam ? adam->step : 0;
    convert_weights(t);
}

void nqm_trainer_store(const nqm_trainer *t, nqm_params *params, nqm_adam *adam) {
    nqm_params *const to[NQM_STORED_VALUES] = {params, adam ? &adam->m : NULL, adam ? &adam->v : NULL};
    const size_t n_biases = t->output.n_outputs, n_weights = n_biases * t->output.n;
    for (size_t i = 0; i < NQM_STORED_VALUES && to[i]; ++i) {
        for (size_t l = 0; l < t->n_hidden; ++l)
            store_layer(&t->layer[l].stored[i], &to[i]->layer[l]);
        memcpy(to[i]->layer[t->n_hidden].w, t->output.stored[i], n_weights * sizeof(float));
        memcpy(to[i]->layer[t->n_hidden].b, t->output.stored[i] + n_weights, n_biases * sizeof(float));
    }
    if (adam)
        adam->step = t->n_steps;
}

uint64_t nqm_trainer_steps(const nqm_trainer *t) {
    return t->n_steps;
}

/* ---- rows of a batch --------------------------------------------------------------------------------------------- */

void nqm_trainer_rows_done(const nqm_trainer *t, const nqm_batch_matrix *m, size_t first, size_t n) {
    const float *x = m->x + first * m->ld;
    const nqm_kernels *kernels = nqm_kernels_get();
    if (!is_rounded(t)) {
        for (size_t i = 0; i < n; ++i)
            nqm_columns_copy(m->n, x + i * m->ld, m->width, m->step, (float *)m->columns + (first + i) * m->width);
        return;
    }
    for (size_t i = 0; i < n; ++i)
        kernels->round_row(m->n, x + i * m->ld, m->rows + (first + i) * m->ld_rows);
    kernels->round_pair(m->n, x, n == 2 ? x + m->ld : t->zeros, m->width, m->step, m->columns + first / 2 * m->width);
}

/* ---- forward ----------------------------------------------------------------------------------------------------- */

float *nqm_trainer_input(nqm_trainer *t, size_t i) {
    return t->input.x + i * t->input.ld;
}

void nqm_dropout_of_row(const nqm_dropout *dropout, size_t layer, size_t row, size_t n, nqm_hidden_row *r) {
    r->p = dropout->p;
    r->keep = dropout->given[layer] ? dropout->given[layer] + row * n : NULL;
    r->key = nqm_hash_u64(dropout->seed, dropout->step * NQM_NET_MAX_LAYERS + layer);
    r->counter = row * ((n + 3) / 4);
}

static nqm_hidden_row hidden_row_at(const nqm_trainer *t, size_t l, size_t row, const nqm_dropout *dropout) {
    const nqm_trainer_layer *layer = &t->layer[l];
    nqm_hidden_row r = {.n = layer->out,
                        .bias = layer->stored[NQM_VALUE].vector[NQM_BIAS],
                        .gamma = layer->stored[NQM_VALUE].vector[NQM_GAMMA],
                        .beta = layer->stored[NQM_VALUE].vector[NQM_BETA],
                        .x = layer->xhat + row * layer->ld,
                        .y = layer->y.x + row * layer->y.ld,
                        .slope = layer->slope + row * layer->ld,
                        .rstd = layer->rstd + row};
    if (dropout && dropout->p > 0)
        nqm_dropout_of_row(dropout, l, row, layer->out, &r);
    return r;
}

/* LayerNorm, GELU and dropout of layer l, after the product. For the last hidden layer, z (batch, outputs) receives the output
 * layer's values. */
static void hidden_forward(nqm_trainer *t, size_t l, size_t batch, const nqm_dropout *dropout, float *z) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const nqm_trainer_output *output = &t->output;
    const float *w = output->stored[NQM_VALUE];
    nqm_trainer_layer *layer = &t->layer[l];
#pragma omp parallel for schedule(static) if (batch * layer->out >= NQM_MIN_PARALLEL)
    for (size_t first = 0; first < batch; first += 2) {
        const size_t n = batch - first < 2 ? 1 : 2;
        for (size_t i = first; i < first + n; ++i) {
            nqm_hidden_row r = hidden_row_at(t, l, i, dropout);
            kernels->hidden_row(&r);
            for (size_t o = 0; l + 1 == t->n_hidden && o < output->n_outputs; ++o)
                z[i * output->n_outputs + o] =
                    kernels->dot(output->n, w + o * output->n, r.y) + w[output->n_outputs * output->n + o];
        }
        if (l + 1 < t->n_hidden)
            nqm_trainer_rows_done(t, &layer->y, first, n);
    }
}

void nqm_trainer_inputs_done(nqm_trainer *t, size_t first, size_t n) {
    nqm_trainer_rows_done(t, &t->input, first, n);
}

void nqm_trainer_forward(nqm_trainer *t, size_t batch, const nqm_dropout *dropout, float *z) {
    for (size_t l = 0; l < t->n_hidden; ++l) {
        nqm_trainer_layer *layer = &t->layer[l];
        const nqm_batch_matrix *x = l > 0 ? &t->layer[l - 1].y : &t->input;
        nqm_multiply(is_rounded(t) ? &layer->rounded : &layer->stored[NQM_VALUE].w, batch, x->rows, x->ld_rows, false,
                     layer->xhat, layer->ld);
        hidden_forward(t, l, batch, dropout, z);
    }
}
