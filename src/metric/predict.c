/* SPDX-License-Identifier: MIT
 *
 * From sampled pairs to JOD: features of each pair, one forward pass for the batch, the meaning of its output.
 */
#include "kernel/panel.h"
#include "metric/metric.h"
#include "net/inference.h"

#include <math.h>

struct nqm_predictor {
    const nqm_model *model;
    nqm_features features;
    size_t samples_width; /* the part of the input that comes from samples */
    size_t stride;        /* numbers from one input to the next */
    nqm_inference_work *work;
    float *t; /* (max_batch, 2, n_directions, 3) transformed reference and test */
    float *x; /* (max_batch, stride) */
    float *z; /* (max_batch) */
};

nqm_status nqm_predictor_create(const nqm_model *model, nqm_precision precision, size_t max_batch,
                                nqm_predictor **predictor_ret, nqm_error *err) {
    *predictor_ret = NULL;
    const nqm_inference_net *net;
    nqm_status status = nqm_model_inference(model, precision, &net, err);
    if (status != NQM_OK)
        return status;
    nqm_predictor *p = nqm_alloc(1, sizeof *p);
    if (!p)
        return nqm_fail_nomem(err, sizeof *p);
    p->model = model;
    p->features = (nqm_features){.layout = model->layout, .difference_scale = model->difference_scale};
    for (size_t k = 0; k < 3; ++k) {
        p->features.mean[k] = model->mean[k];
        p->features.std[k] = model->std[k];
    }
    p->samples_width = nqm_features_width(model->layout, model->n_directions);
    p->stride = nqm_row_stride(p->samples_width + nqm_model_n_scalars(model));
    p->t = nqm_alloc(max_batch, 6 * model->n_directions * sizeof *p->t);
    p->x = nqm_alloc(max_batch, p->stride * sizeof *p->x);
    p->z = nqm_alloc(max_batch, sizeof *p->z);
    if (!p->t || !p->x || !p->z)
        status = nqm_fail_nomem(err, max_batch * (6 * model->n_directions + p->stride + 1) * sizeof(float));
    else
        status = nqm_inference_work_create(net, max_batch, &p->work, err);
    if (status != NQM_OK) {
        nqm_predictor_free(p);
        return status;
    }
    *predictor_ret = p;
    return NQM_OK;
}

void nqm_predictor_free(nqm_predictor *predictor) {
    if (!predictor)
        return;
    nqm_inference_work_free(predictor->work);
    nqm_free(predictor->t);
    nqm_free(predictor->x);
    nqm_free(predictor->z);
    nqm_free(predictor);
}

typedef struct compose_job {
    nqm_predictor *predictor;
    const nqm_sampled_pairs *pairs;
} compose_job;

static void compose_pair(void *user, size_t i) {
    const compose_job *job = user;
    nqm_predictor *p = job->predictor;
    const nqm_sampled_pairs *pairs = job->pairs;
    size_t n_directions = p->model->n_directions, n = 3 * n_directions;
    float *ref_t = p->t + 2 * n * i, *test_t = ref_t + n;
    if (pairs->one_ref)
        ref_t = p->t; /* transformed beforehand */
    else
        nqm_features_transform(n, pairs->ref + n * i, ref_t);
    nqm_features_transform(n, pairs->test + n * i, test_t);
    const uint8_t *used = pairs->used ? pairs->used + n_directions * i : NULL;
    float *x = p->x + p->stride * i;
    if (pairs->novelty)
        pairs->novelty[i] = NAN;
    nqm_features_compose(&p->features, n_directions, ref_t, test_t, used, x);
    if (nqm_model_n_scalars(p->model) == 0)
        return;
    double scalars[NQM_SCALAR_COUNT];
    const nqm_scalar_whitening whitening = {p->model->scalar_mean, p->model->scalar_std, p->model->scalar_scale};
    nqm_scalars_compute(p->model->directions, pairs->one_ref ? pairs->ref : pairs->ref + n * i, pairs->test + n * i,
                        used, scalars);
    nqm_scalars_whiten(&whitening, scalars, x + p->samples_width);
    if (pairs->novelty)
        pairs->novelty[i] = nqm_model_novelty(p->model, scalars);
}

void nqm_predictor_run(nqm_predictor *p, const nqm_sampled_pairs *pairs, double *jod, double *delta_e) {
    if (pairs->n == 0)
        return;
    if (pairs->one_ref)
        nqm_features_transform(3 * p->model->n_directions, pairs->ref, p->t);
    compose_job job = {p, pairs};
    if (pairs->n == 1)
        compose_pair(&job, 0);
    else
        nqm_parallel_for(pairs->n, compose_pair, &job);
    nqm_inference_run(p->work, pairs->n, p->x, p->stride, p->z);
    for (size_t i = 0; i < pairs->n; ++i)
        jod[i] = nqm_model_jod(p->model, (double)p->z[i], delta_e ? &delta_e[i] : NULL);
}

nqm_status nqm_model_predict(const nqm_model *model, size_t n_pairs, const float *ref, const float *test, double *jod,
                             nqm_error *err) {
    if (n_pairs == 0)
        return NQM_OK;
    nqm_predictor *predictor;
    nqm_status status = nqm_predictor_create(
        model, NQM_PRECISION_F32, n_pairs < NQM_PREDICT_BATCH ? n_pairs : NQM_PREDICT_BATCH, &predictor, err);
    if (status != NQM_OK)
        return status;
    size_t n = 3 * model->n_directions;
    for (size_t begin = 0; begin < n_pairs; begin += NQM_PREDICT_BATCH) {
        size_t left = n_pairs - begin;
        nqm_sampled_pairs pairs = {
            .n = left < NQM_PREDICT_BATCH ? left : NQM_PREDICT_BATCH, .ref = ref + n * begin, .test = test + n * begin};
        nqm_predictor_run(predictor, &pairs, jod + begin, NULL);
    }
    nqm_predictor_free(predictor);
    return NQM_OK;
}
