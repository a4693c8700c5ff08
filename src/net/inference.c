/* SPDX-License-Identifier: MIT
 *
 * Networks for inference: creation, workspaces, and the forward pass, each product of which is on all threads.
 */
#include "net/inference.h"
#include "kernel/panel.h"

#include <string.h>

enum { MAX_SEGMENTS = NQM_MAX_INPUT_GROUPS + 1 };

/* Consecutive inputs of a layer that share a precision and a scale. A layer's product is the sum over its segments. */
typedef struct segment {
    size_t first;      /* index of its first input */
    size_t word;       /* rounded segments: offset of its inputs in a row of rounded inputs, 32-bit words */
    nqm_panels panels; /* (inputs, outputs) */
} segment;

/* A hidden layer: product, LayerNorm, GELU. */
typedef struct hidden_layer {
    size_t n_out, n_segments;
    bool differences; /* segment 1 multiplies its inputs minus those of segment 0 */
    segment segment[MAX_SEGMENTS];
    size_t n_words; /* 32-bit words of a row of all rounded segments */
} hidden_layer;

struct nqm_inference_net {
    const nqm_params *params;   /* borrowed */
    size_t n_layers, n_outputs; /* n_layers: hidden ones, at least one */
    hidden_layer layer[NQM_NET_MAX_LAYERS];
};

/* Rows of max_batch; strides in floats or 32-bit words. Views into the block that begins with this struct. */
struct nqm_inference_work {
    const nqm_inference_net *net;
    size_t max_batch;
    size_t stride, rounded_stride, ref_stride; /* per row of layers' outputs, of rounded inputs, of references */
    float *y[2];                               /* (max_batch, stride) outputs of even and of odd layers */
    uint32_t *rounded;                         /* (max_batch, rounded_stride) the rounded inputs of a layer */
    nqm_byte_scale *scale; /* (MAX_SEGMENTS, max_batch) NQM_PRECISION_INT8: scales of the rounded inputs */
    int32_t *sums;         /* (max_batch, stride) NQM_PRECISION_INT8: a product of bytes; else empty */
    float *difference;     /* (max_batch, reference inputs) if layer 0 takes differences */
    /* References of this call, 1..n_refs; 0 is the last one of the call before. */
    size_t n_refs;
    size_t *ref_of;            /* (max_batch) a row's reference */
    size_t *ref_row;           /* (max_batch) the first row of reference 1 + i */
    uint32_t *ref;             /* (max_batch, ref_stride) inputs of reference 1 + i in the precision of segment 0 */
    nqm_byte_scale *ref_scale; /* (max_batch) */
    float *partial;            /* (1 + max_batch, stride) partial products of the references */
    float *kept_ref;           /* (reference inputs) of reference 0 */
    const nqm_kernels *kept_kernels; /* that computed its partial product; NULL: there is no reference 0 */
};

/* ---- network ----------------------------------------------------------------------------------------------------- */

/* Add a segment for n inputs from `first` on; w (n_out, n) are their weights. */
static nqm_status add_segment(hidden_layer *layer, nqm_weights w, size_t first, size_t n, nqm_precision precision,
                              nqm_error *err) {
    segment *s = &layer->segment[layer->n_segments++];
    nqm_status status = nqm_panels_create(precision, n, layer->n_out, &s->panels, err);
    if (status != NQM_OK)
        return status;
    s->first = first;
    s->word = layer->n_words;
    if (precision != NQM_PRECISION_F32)
        layer->n_words += s->panels.words;
    nqm_panels_pack(&s->panels, w);
    return NQM_OK;
}

/* W_ref ref + W_test test = (W_ref + W_test) ref + W_test (test - ref). The right side rounds the difference at its own,
 * small, scale, so that a test which hardly differs from its reference keeps its score. */
static nqm_status add_sum_of_groups(hidden_layer *layer, nqm_weights w, size_t n, nqm_precision precision,
                                    nqm_error *err) {
    float *sum = nqm_alloc(layer->n_out + 2, n * sizeof *sum); /* and two rows that are converted */
    if (!sum)
        return nqm_fail_nomem(err, layer->n_out * n * sizeof *sum);
    float *converted = sum + layer->n_out * n;
    for (size_t j = 0; j < layer->n_out; ++j) {
        const float *a = nqm_weights_row(nqm_weights_at(w, j, 0), n, converted);
        const float *b = nqm_weights_row(nqm_weights_at(w, j, n), n, converted + n);
        for (size_t i = 0; i < n; ++i)
            sum[j * n + i] = a[i] + b[i];
    }
    nqm_status status = add_segment(layer, (nqm_weights){sum, NULL, n}, 0, n, precision, err);
    layer->differences = true;
    nqm_free(sum);
    return status;
}

static nqm_status add_first_segments(hidden_layer *layer, nqm_weights w, const nqm_input_groups *inputs,
                                     nqm_precision precision, nqm_error *err) {
    size_t first = 0;
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < inputs->n_groups; first += inputs->width, ++i)
        if (i == 0 && inputs->test_itself && precision != NQM_PRECISION_F32)
            status = add_sum_of_groups(layer, w, inputs->width, precision, err);
        else
            status = add_segment(layer, nqm_weights_at(w, 0, first), first, inputs->width, precision, err);
    if (status == NQM_OK && inputs->n_scalars)
        status = add_segment(layer, nqm_weights_at(w, 0, first), first, inputs->n_scalars, NQM_PRECISION_F32, err);
    return status;
}

static nqm_status add_layers(nqm_inference_net *net, const nqm_params *params, const nqm_input_groups *inputs,
                             nqm_precision precision, nqm_error *err) {
    const nqm_net_shape *shape = &params->shape;
    nqm_status status = NQM_OK;
    net->params = params;
    net->n_layers = shape->n_layers - 1;
    net->n_outputs = shape->sizes[shape->n_layers];
    for (size_t l = 0; status == NQM_OK && l < net->n_layers; ++l) {
        const size_t n_in = shape->sizes[l];
        const nqm_weights w = {params->layer[l].w, params->layer[l].half, n_in};
        net->layer[l].n_out = shape->sizes[l + 1];
        status = l == 0 ? add_first_segments(&net->layer[l], w, inputs, precision, err)
                        : add_segment(&net->layer[l], w, 0, n_in, precision, err);
    }
    return status;
}

nqm_status nqm_inference_net_create(const nqm_params *params, const nqm_input_groups *inputs, nqm_precision precision,
                                    nqm_inference_net **net_ret, nqm_error *err) {
    *net_ret = NULL;
    nqm_inference_net *net = nqm_alloc(1, sizeof *net);
    if (!net)
        return nqm_fail_nomem(err, sizeof *net);
    nqm_status status = add_layers(net, params, inputs, precision, err);
    if (status == NQM_OK)
        *net_ret = net;
    else
        nqm_inference_net_free(net);
    return status;
}

void nqm_inference_net_free(nqm_inference_net *net) {
    if (!net)
        return;
    for (size_t l = 0; l < net->n_layers; ++l)
        for (size_t s = 0; s < net->layer[l].n_segments; ++s)
            nqm_panels_free(&net->layer[l].segment[s].panels);
    nqm_free(net);
}

/* ---- workspace --------------------------------------------------------------------------------------------------- */

/* The panels that multiply the references. */
static const nqm_panels *ref_panels(const nqm_inference_net *net) {
    return &net->layer[0].segment[0].panels;
}

nqm_status nqm_inference_work_create(const nqm_inference_net *net, size_t max_batch, nqm_inference_work **work_ret,
                                     nqm_error *err) {
    *work_ret = NULL;
    if (max_batch < 1 || max_batch > (size_t)1 << 24)
        return nqm_fail(err, NQM_ERR_ARG, -1, "network: batch of %zu is out of range (1..16777216)", max_batch);
    const size_t n = max_batch, n_ref = ref_panels(net)->k;
    size_t widest = 0, n_words = 0;
    for (size_t l = 0; l < net->n_layers; ++l) {
        widest = nqm_larger(widest, net->layer[l].n_out);
        n_words = nqm_larger(n_words, net->layer[l].n_words);
    }
    nqm_inference_work *work, w = {.net = net,
                                   .max_batch = n,
                                   .stride = nqm_row_stride(widest),
                                   .rounded_stride = n_words ? nqm_row_stride(n_words) : 0,
                                   .ref_stride = nqm_row_stride(ref_panels(net)->words)};
    const size_t n_sums = ref_panels(net)->precision == NQM_PRECISION_INT8 ? n : 0;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&work, 1, sizeof w}, {&w.y[0], n, w.stride * sizeof *w.y[0]},
                   {&w.y[1], n, w.stride * sizeof *w.y[1]}, {&w.rounded, n, w.rounded_stride * sizeof *w.rounded},
                   {&w.scale, n, MAX_SEGMENTS * sizeof *w.scale}, {&w.sums, n_sums, w.stride * sizeof *w.sums},
                   {&w.difference, net->layer[0].differences ? n : 0, n_ref * sizeof *w.difference},
                   {&w.ref_of, n, sizeof *w.ref_of}, {&w.ref_row, n, sizeof *w.ref_row},
                   {&w.ref, n, w.ref_stride * sizeof *w.ref}, {&w.ref_scale, n, sizeof *w.ref_scale},
                   {&w.partial, n + 1, w.stride * sizeof *w.partial}, {&w.kept_ref, n_ref, sizeof *w.kept_ref}),
        err);
    if (status == NQM_OK) {
        *work = w;
        *work_ret = work;
    }
    return status;
}

void nqm_inference_work_free(nqm_inference_work *work) {
    nqm_free(work);
}

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* The left factor of a product: rows of floats, or of rounded inputs. */
typedef struct left_rows {
    size_t n;
    const uint32_t *words;
    size_t stride;
    const nqm_byte_scale *scale; /* (n) NQM_PRECISION_INT8 */
} left_rows;

/* c (a.n, stride) = A B, or c + A B, in float for any precision. */
static void multiply(const nqm_inference_work *work, const nqm_panels *b, left_rows a, bool add, float *c) {
    const nqm_kernels *kernels = nqm_kernels_get();
    const size_t stride = work->stride;
    if (b->precision != NQM_PRECISION_INT8) {
        nqm_multiply(b, a.n, a.words, a.stride, add, c, stride);
        return;
    }
    nqm_multiply(b, a.n, a.words, a.stride, false, work->sums, stride);
#pragma omp parallel for schedule(static) if (a.n * b->n >= NQM_MIN_PARALLEL)
    for (size_t i = 0; i < a.n; ++i)
        for (size_t p = 0; p < b->n_panels; ++p) {
            const nqm_byte_columns columns = nqm_panel_columns(b, p);
            const size_t at = i * stride + p * NQM_PANEL;
            kernels->dequantise(1, &a.scale[i], &columns, add, work->sums + at, c + at, stride);
        }
}

/* x (inputs of the panels) in their precision. */
static void round_inputs(const nqm_panels *p, const float *x, uint32_t *words, nqm_byte_scale *scale) {
    if (p->precision == NQM_PRECISION_F32)
        memcpy(words, x, p->k * sizeof *x);
    else if (p->precision == NQM_PRECISION_BF16)
        nqm_kernels_get()->round_row(p->k, x, words);
    else
        *scale = nqm_kernels_get()->quantise_row(p->k, x, words);
}

/* ---- references -------------------------------------------------------------------------------------------------- */

/* Rows of inputs, ldx floats from row to row. */
typedef struct rows {
    size_t n;
    const float *x;
    size_t ldx;
} rows;

/* Number the references of a call: a row with the same reference inputs as the row before has the same number. */
static void find_references(nqm_inference_work *work, const rows *in) {
    const size_t n_bytes = ref_panels(work->net)->k * sizeof *in->x;
    const float *before = work->kept_kernels == nqm_kernels_get() ? work->kept_ref : NULL;
    work->n_refs = 0;
    for (size_t i = 0; i < in->n; ++i) {
        const float *x = in->x + i * in->ldx;
        /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): equal bits are meant */
        if (!before || memcmp(before, x, n_bytes) != 0)
            work->ref_row[work->n_refs++] = i;
        work->ref_of[i] = work->n_refs;
        before = x;
    }
}

/* Their partial products of layer 0. */
static void multiply_references(nqm_inference_work *work, const rows *in) {
    const nqm_panels *panels = ref_panels(work->net);
    find_references(work, in);
#pragma omp parallel for schedule(static) if (work->n_refs * panels->k >= NQM_MIN_PARALLEL)
    for (size_t i = 0; i < work->n_refs; ++i)
        round_inputs(panels, in->x + work->ref_row[i] * in->ldx, work->ref + i * work->ref_stride, &work->ref_scale[i]);
    multiply(work, panels, (left_rows){work->n_refs, work->ref, work->ref_stride, work->ref_scale}, false,
             work->partial + work->stride);
}

/* Keep the last reference as reference 0 of the next call. */
static void keep_reference(nqm_inference_work *work, const rows *in) {
    if (work->n_refs == 0)
        return;
    memcpy(work->kept_ref, in->x + (in->n - 1) * in->ldx, ref_panels(work->net)->k * sizeof *in->x);
    memcpy(work->partial, work->partial + work->n_refs * work->stride, work->stride * sizeof *work->partial);
    work->kept_kernels = nqm_kernels_get();
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

static const float *subtract_reference(const nqm_inference_work *work, size_t n, const float *test, const float *ref,
                                       size_t i) {
    float *difference = work->difference + i * n;
#pragma omp simd
    for (size_t k = 0; k < n; ++k)
        difference[k] = test[k] - ref[k];
    return difference;
}

/* Round the inputs x of layer l for row i; its segments of floats are read in place, and the references' are done. */
static void round_segments(const nqm_inference_work *work, size_t l, size_t i, const float *x) {
    const hidden_layer *layer = &work->net->layer[l];
    for (size_t s = l == 0; s < layer->n_segments; ++s) {
        const segment *own = &layer->segment[s];
        const float *from = x + own->first;
        if (own->panels.precision == NQM_PRECISION_F32)
            continue;
        if (layer->differences && s == 1)
            from = subtract_reference(work, own->panels.k, from, x, i);
        round_inputs(&own->panels, from, work->rounded + i * work->rounded_stride + own->word,
                     &work->scale[s * work->max_batch + i]);
    }
}

/* c (n, stride) = the product of layer l, whose rounded inputs round_segments() left. */
static void multiply_layer(const nqm_inference_work *work, size_t l, const rows *in, float *c) {
    const hidden_layer *layer = &work->net->layer[l];
    for (size_t i = 0; l == 0 && i < in->n; ++i)
        memcpy(c + i * work->stride, work->partial + work->ref_of[i] * work->stride, work->stride * sizeof *c);
    for (size_t s = l == 0; s < layer->n_segments; ++s) {
        const segment *own = &layer->segment[s];
        left_rows a = {in->n, work->rounded + own->word, work->rounded_stride, work->scale + s * work->max_batch};
        if (own->panels.precision == NQM_PRECISION_F32)
            a = (left_rows){in->n, (const uint32_t *)(const void *)(in->x + own->first), in->ldx, NULL};
        multiply(work, &own->panels, a, l == 0, c);
    }
}

/* Row i, y, from the product of layer l to the inputs of the next layer, or to z (outputs). */
static void finish_row(const nqm_inference_work *work, size_t l, size_t i, float *y, float *z) {
    const nqm_inference_net *net = work->net;
    const nqm_kernels *kernels = nqm_kernels_get();
    const nqm_layer *layer = &net->params->layer[l], *output = &net->params->layer[net->n_layers];
    const size_t n = net->layer[l].n_out;
    kernels->hidden_row(
        &(nqm_hidden_row){.n = n, .bias = layer->b, .gamma = layer->gamma, .beta = layer->beta, .x = y, .y = y});
    if (l + 1 < net->n_layers)
        round_segments(work, l + 1, i, y);
    else
        for (size_t o = 0; o < net->n_outputs; ++o)
            z[o] = kernels->dot(n, output->w + o * n, y) + output->b[o];
}

void nqm_inference_run(nqm_inference_work *work, size_t n, const float *x, size_t ldx, float *z) {
    const nqm_inference_net *net = work->net;
    const rows all = {n, x, ldx};
    rows in = all;
    if (n == 0)
        return;
    multiply_references(work, &all);
#pragma omp parallel for schedule(static) if (n * net->layer[0].n_words >= NQM_MIN_PARALLEL)
    for (size_t i = 0; i < n; ++i)
        round_segments(work, 0, i, x + i * ldx);
    for (size_t l = 0; l < net->n_layers; ++l) {
        float *y = work->y[l % 2];
        multiply_layer(work, l, &in, y);
#pragma omp parallel for schedule(static) if (n * net->layer[l].n_out >= NQM_MIN_PARALLEL)
        for (size_t i = 0; i < n; ++i)
            finish_row(work, l, i, y + i * work->stride, z + i * net->n_outputs);
        in = (rows){n, y, work->stride};
    }
    keep_reference(work, &all);
}
