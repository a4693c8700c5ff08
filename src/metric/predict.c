/* SPDX-License-Identifier: MIT
 *
 * Predicts the JOD of sampled pairs: computes the inputs of each pair, runs one forward pass for the batch, and converts
 * the outputs to JOD.
 */
#include "math/math.h"
#include "metric/compose.h"
#include "net/inference.h"
#include "percept/percept.h"

#include <math.h>

struct nqm_predictor {
    const nqm_model *model;
    nqm_composer *inputs;
    nqm_inference_work *work; /* NULL: the model has no network */
    float *z;                 /* (max_batch, n_outputs) network outputs */
};

nqm_status nqm_predictor_create(const nqm_model *model, size_t max_batch, nqm_predictor **predictor_ret,
                                nqm_error *err) {
    *predictor_ret = NULL;
    const nqm_inference_net *net = NULL;
    nqm_predictor *p;
    float *z;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&p, 1, sizeof *p}, {&z, max_batch, nqm_model_n_outputs(model) * sizeof *z}), err);
    if (status != NQM_OK)
        return status;
    *p = (nqm_predictor){.model = model, .z = z};
    if (nqm_model_has_network(model))
        status = nqm_model_inference(model, &net, err);
    if (status == NQM_OK)
        status = nqm_composer_create(model, max_batch, &p->inputs, err);
    if (status == NQM_OK && net)
        status = nqm_inference_work_create(net, max_batch, &p->work, err);
    if (status == NQM_OK)
        *predictor_ret = p;
    else
        nqm_predictor_free(p);
    return status;
}

void nqm_predictor_free(nqm_predictor *predictor) {
    if (!predictor)
        return;
    nqm_inference_work_free(predictor->work);
    nqm_composer_free(predictor->inputs);
    nqm_free(predictor);
}

/* ---- inputs ------------------------------------------------------------------------------------------------------ */

typedef struct predict_job {
    nqm_predictor *predictor;
    const nqm_sample_pair *pairs;
    nqm_prediction *to;
    double *metrics;     /* NULL: not computed */
    size_t n, n_at_once; /* pairs, and those per task */
} predict_job;

/* A task's pairs: estimates, inputs and novelty. */
static void run_task(void *user, size_t task) {
    const predict_job *job = user;
    const nqm_composer *c = job->predictor->inputs;
    const nqm_transport t = nqm_model_transport(c->model);
    const size_t first = task * job->n_at_once, n = nqm_smaller(job->n_at_once, job->n - first);
    const bool with_scalars = c->model->scalars.n > 0;
    if (t.light)
        nqm_transport_estimates(&t, n, job->pairs + first, c->estimate + first, c->looks + first);
    nqm_compose_samples(c, task, first, n, job->pairs + first, job->metrics);
    nqm_compose_scalars(c, first, n, job->metrics);
    for (size_t i = first; i < first + n; ++i)
        job->to[i].novelty =
            with_scalars ? nqm_model_novelty(c->model, c->scalars + i * NQM_SCALAR_COUNT) : (double)NAN;
}

/* ---- prediction -------------------------------------------------------------------------------------------------- */

/* The label for the outputs z of a model with parts. Delta-E, the length of the shift and structure are at most `bound`. */
static nqm_label bounded_label(const nqm_model *model, const float *z, const nqm_label *estimated, double bound) {
    const nqm_label whole = nqm_model_label(model, z, estimated);
    const double shift = sqrt(nqm_dot3(whole.shift, whole.shift));
    const double size = fmax(whole.delta_e, fmax(shift, fmax(whole.structure, fabs(whole.contrast))));
    nqm_label label = {.delta_e = 0};
    nqm_label_add(&label, size > bound ? bound / size : 1, &whole);
    return label;
}

/* The result of nqm_model_spread() for pair i with this prediction. */
static double spread_of(const nqm_predictor *p, size_t i, double jod) {
    const double *scalars = p->inputs->scalars + i * NQM_SCALAR_COUNT;
    double features[NQM_SPREAD_FEATURES];
    if (!nqm_model_has_spread(p->model) || p->model->scalars.n == 0 || !isfinite(jod))
        return 0;
    nqm_spread_features(p->model, jod, scalars[NQM_SCALAR_ESTIMATE], scalars[NQM_SCALAR_REF_PEAK], features);
    return nqm_model_spread(p->model, features);
}

/* Convert the outputs of pair i. */
static void conclude(const predict_job *job, size_t i) {
    const nqm_predictor *p = job->predictor;
    nqm_prediction *to = &job->to[i];
    const float *z = p->z + i * nqm_model_n_outputs(p->model);
    const double nan = (double)NAN;
    const nqm_label *estimated = p->model->transport ? &p->inputs->estimate[i] : NULL;
    to->bound = p->inputs->bound[i];
    to->jod = nqm_model_jod(p->model, (double)*z, estimated, &to->delta_e);
    (void)nqm_bound_score(p->model, to->bound, &to->jod, &to->delta_e);
    to->spread = spread_of(p, i, to->jod);
    to->label = nqm_model_has_parts(p->model) ? bounded_label(p->model, z, estimated, to->bound)
                                              : (nqm_label){nan, {nan, nan, nan}, nan, nan, 0};
    to->similarity[0] = to->similarity[1] = to->similarity[2] = nan;
    if (!estimated)
        return;
    nqm_apart_distances(estimated, p->inputs->looks[i], &p->inputs->sums[i].metrics, to->apart);
    nqm_similarity(p->model, to->apart, to->similarity);
}

void nqm_predictor_run(nqm_predictor *p, size_t n, const nqm_sample_pair *pairs, nqm_prediction *to, double *metrics) {
    if (n == 0)
        return;
    predict_job job = {p, pairs, to, metrics, n, nqm_composer_task(p->inputs, n)};
    nqm_parallel_for(nqm_ceil_div(n, job.n_at_once), run_task, &job);
    if (p->work)
        nqm_inference_run(p->work, n, p->inputs->x, p->inputs->stride, p->z);
    for (size_t i = 0; i < n; ++i)
        conclude(&job, i);
}
nqm_score_result nqm_no_score(nqm_status status) {
    nqm_score_result result = {.status = status,
                               .jod = NAN,
                               .delta_e = NAN,
                               .jod_low = NAN,
                               .jod_high = NAN,
                               .novelty = NAN,
                               .parts = {NAN, {NAN, NAN, NAN}, NAN, NAN},
                               .similarity = {NAN, NAN, NAN}};
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        result.metrics[m] = NAN;
    return result;
}
