/* SPDX-License-Identifier: MIT
 *
 * The encodings hyper-*: networks predicted by the embedded hypernetwork from samples of a BRDF.
 */
#include "encode/hyper.h"
#include "encode/nbrdf_net.h"

#include <math.h>
#include <string.h>

nqm_status nqm_hyper_encode(const nqm_hyper *hyper, size_t n, const double *hd, const double *rgb, float *weights,
                            nqm_error *err) {
    nqm_hyper_pass pass;
    nqm_status status = nqm_hyper_pass_create(hyper, 1, n, &pass, err);
    if (status == NQM_OK) {
        for (size_t i = 0; i < n; ++i) {
            float *feature = pass.input + i * NQM_HYPER_FEATURES;
            const float value[3] = {(float)rgb[3 * i], (float)rgb[3 * i + 1], (float)rgb[3 * i + 2]};
            nqm_hyper_place(hd + 3 * i, feature);
            nqm_hyper_value(value, feature + NQM_HYPER_PLACE);
        }
        memcpy(weights, nqm_hyper_forward(hyper, &pass), NQM_NBRDF_WEIGHTS * sizeof *weights);
    }
    nqm_hyper_pass_free(&pass);
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

nqm_status nqm_hyper_encode_brdf(nqm_hyper *hyper, const nqm_brdf *ref, const nqm_encode_options *options,
                                 nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    size_t n_read = options->n, n = nqm_larger(n_read, options->n_directions);
    float weights[NQM_NBRDF_WEIGHTS];
    /* An encoding with fewer samples reads a subset of those of one with more. */
    nqm_rng rng = nqm_rng_make(options->seed, 0), check = nqm_rng_make(options->seed, 1);
    double *hd = nqm_alloc(n, 6 * sizeof *hd);
    if (!hd)
        return nqm_fail_nomem(err, 6 * n * sizeof *hd);
    double *rgb = hd + 3 * n;
    nqm_status status = nqm_hyper_sample(ref, n_read, &rng, hd, rgb, err);
    hyper->step = options->step;
    if (status == NQM_OK)
        status = nqm_hyper_encode(hyper, n_read, hd, rgb, weights, err);
    if (status == NQM_OK)
        status = nqm_hyper_sample(ref, options->n_directions, &check, hd, rgb, err);
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
