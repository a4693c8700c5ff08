/* SPDX-License-Identifier: MIT
 *
 * The encodings hyper-*: networks predicted by the embedded hypernetwork from samples of a BRDF, and the file of that.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* ---- the file: tensors layers.N.weight (in, out) and layers.N.bias (out) ----------------------------------------- */

enum { N_TENSORS = 2 * NQM_HYPER_N_LAYERS };

nqm_tensor nqm_hyper_tensor(size_t i, const nqm_hyper_layer *layer, char name[NQM_HYPER_NAME_BYTES]) {
    const bool is_bias = i % 2 != 0;
    snprintf(name, NQM_HYPER_NAME_BYTES, "layers.%zu.%s", i / 2, is_bias ? "bias" : "weight");
    return nqm_tensor_of(name, NQM_F32, is_bias ? 0 : layer->n_in, layer->n_out, is_bias ? layer->b : layer->w);
}

/* Find all tensors; the file determines the widths of the hidden layers. */
static nqm_status find_tensors(const nqm_safetensors *st, const char *file, const nqm_tensor **tensor, nqm_error *err) {
    nqm_hyper_layer layer = {.n_out = NQM_HYPER_FEATURES};
    for (size_t i = 0; i < N_TENSORS; ++i) {
        char name[NQM_HYPER_NAME_BYTES];
        if (i % 2 == 0) {
            layer.n_in = i == 2 * NQM_HYPER_POOLED ? 2 * layer.n_out + 1 : layer.n_out;
            layer.n_out = i == N_TENSORS - 2 ? NQM_NBRDF_WEIGHTS : 0; /* 0: any */
        }
        const nqm_tensor expected = nqm_hyper_tensor(i, &layer, name);
        nqm_status status = nqm_safetensors_floats(st, &expected, NQM_ERR_MODEL, &tensor[i], err);
        if (status != NQM_OK)
            return status;
        layer.n_out = tensor[i]->dims[tensor[i]->n_dims - 1];
    }
    if (nqm_safetensors_count(st) != N_TENSORS)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: %zu tensors instead of %d", file, nqm_safetensors_count(st),
                        N_TENSORS);
    return NQM_OK;
}

nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name, nqm_hyper *hyper_ret,
                          nqm_error *err) {
    nqm_safetensors *st;
    const nqm_tensor *tensor[N_TENSORS];
    nqm_hyper_shape shape;
    *hyper_ret = (nqm_hyper){0};
    nqm_status status = nqm_encoder_parse(data, n_bytes, name, "hyper", &st, err);
    if (status == NQM_OK)
        status = find_tensors(st, name, tensor, err);
    for (size_t l = 0; status == NQM_OK && l < NQM_HYPER_N_LAYERS; ++l)
        shape.n_out[l] = tensor[2 * l]->dims[1];
    if (status == NQM_OK)
        status = nqm_hyper_create(&shape, hyper_ret, err);
    float *next = hyper_ret->block;
    for (size_t i = 0; status == NQM_OK && i < N_TENSORS; ++i) {
        memcpy(next, tensor[i]->data, tensor[i]->n_bytes);
        next += tensor[i]->n_bytes / sizeof *next;
    }
    nqm_safetensors_free(st);
    return status;
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

static const double max_polar_rad = 80 * NQM_PI / 180; /* measurements at larger angles are often extrapolated */

/* theta_d and phi_d uniform up to 90 and 180 degrees. */
static void draw_dense(nqm_rng *rng, double *hd) {
    nqm_encode_draw_dense(rng, max_polar_rad, NQM_PI / 2, NQM_PI, hd);
}

/* Features (NQM_HYPER_PLACE) of half-vector coordinates hd (3). */
static void fill_place(const double *hd, float *feature) {
    double wi[3], wo[3], difference[3];
    nqm_half_diff_to_pair(hd, wi, wo);
    nqm_spherical(hd[1], hd[2], difference);
    feature[0] = (float)sin(hd[0]);
    feature[1] = (float)cos(hd[0]);
    for (size_t k = 0; k < 3; ++k)
        feature[2 + k] = (float)difference[k];
    feature[5] = (float)(2 * sqrt(hd[0] / (NQM_PI / 2)) - 1);
    feature[6] = (float)(2 * wi[2] * wo[2] - 1);
}

/* Features (6) of a value rgb (3), on two logarithmic scales: one resolves dark bases, one bright highlights. */
static void fill_value(const float *rgb, float *feature) {
    const float dark = 1e-3f, centre = 2, spread = 0.5f;
    for (size_t c = 0; c < 3; ++c) {
        feature[c] = spread * (logf(rgb[c] + dark) + centre);
        feature[3 + c] = log1pf(rgb[c]);
    }
}

/* Draw n samples of `ref`: hd, rgb (n, 3). They are dense about the mirror direction, because few samples would otherwise
 * miss narrow lobes. NQM_ERR_INCOMPATIBLE if most directions have no value. */
static nqm_status sample(const nqm_brdf *ref, size_t n, nqm_rng *rng, double *hd, double *rgb, nqm_error *err) {
    const size_t kept = nqm_encode_sample(ref, n, draw_dense, rng, hd, rgb);
    return kept == n ? NQM_OK
                     : nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions",
                                nqm_brdf_get_info(ref).name, kept, n);
}

nqm_status nqm_hyper_encode(const nqm_hyper *hyper, size_t n, const double *hd, const double *rgb, float step,
                            float *weights, nqm_error *err) {
    float *x = nqm_alloc(n, NQM_HYPER_FEATURES * sizeof *x);
    if (!x)
        return nqm_fail_nomem(err, n * NQM_HYPER_FEATURES * sizeof *x);
    for (size_t i = 0; i < n; ++i) {
        const float value[3] = {(float)rgb[3 * i], (float)rgb[3 * i + 1], (float)rgb[3 * i + 2]};
        fill_place(hd + 3 * i, x + i * NQM_HYPER_FEATURES);
        fill_value(value, x + i * NQM_HYPER_FEATURES + NQM_HYPER_PLACE);
    }
    nqm_status status = nqm_hyper_forward(hyper, n, x, step, weights, err);
    nqm_free(x);
    for (size_t i = 0; status == NQM_OK && i < NQM_NBRDF_WEIGHTS; ++i)
        if (!isfinite(weights[i]))
            status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "the hypernetwork predicted a weight that is not finite");
    return status;
}

/* nqm_nbrdf_loss() of the weights at n samples hd, rgb (n, 3) of the reference. */
static nqm_status measure_loss(const float *weights, size_t n, const double *hd, const double *rgb, double *loss_ret,
                               nqm_error *err) {
    float *input = nqm_alloc(n, 10 * sizeof *input); /* input (6, n), weight (n), goal (3, n) */
    if (!input)
        return nqm_fail_nomem(err, 10 * n * sizeof *input);
    float *weight = input + 6 * n, *goal = weight + n;
    nqm_nbrdf_fill(n, hd, rgb, input, weight, goal);
    *loss_ret =
        nqm_nbrdf_loss(weights, &(nqm_nbrdf_batch){.n = n, .input = input, .weight = weight, .goal = goal}, NULL);
    nqm_free(input);
    return NQM_OK;
}

nqm_status nqm_hyper_encode_brdf(const nqm_hyper *hyper, const nqm_brdf *ref, const nqm_encode_options *options,
                                 nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    size_t n_read = options->n, n = nqm_larger(n_read, options->n_directions);
    float weights[NQM_NBRDF_WEIGHTS];
    /* An encoding with fewer samples reads a subset of those of one with more. */
    nqm_rng rng = nqm_rng_make(options->seed, 0), check = nqm_rng_make(options->seed, 1);
    double *hd = nqm_alloc(n, 6 * sizeof *hd);
    if (!hd)
        return nqm_fail_nomem(err, 6 * n * sizeof *hd);
    double *rgb = hd + 3 * n;
    nqm_status status = sample(ref, n_read, &rng, hd, rgb, err);
    if (status == NQM_OK)
        status = nqm_hyper_encode(hyper, n_read, hd, rgb, options->step, weights, err);
    if (status == NQM_OK)
        status = sample(ref, options->n_directions, &check, hd, rgb, err);
    if (status == NQM_OK)
        status = measure_loss(weights, options->n_directions, hd, rgb, &report->loss, err);
    if (status == NQM_OK)
        status = nqm_nbrdf_create(weights, options->name, brdf_ret, err);
    if (status == NQM_OK) {
        report->n_directions = options->n_directions;
        report->n_numbers = NQM_NBRDF_WEIGHTS;
    }
    nqm_free(hd);
    return status;
}

nqm_status nqm_encode_hyper(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                            nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_hyper hyper;
    size_t n_bytes = 0;
    const unsigned char *bytes = nqm_encoder_bytes("hyper", &n_bytes);
    nqm_status status = nqm_hyper_read(bytes, n_bytes, "built-in hypernetwork", &hyper, err);
    if (status == NQM_OK)
        status = nqm_hyper_encode_brdf(&hyper, ref, options, report, brdf_ret, err);
    nqm_free(hyper.block);
    return status;
}
