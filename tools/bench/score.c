/* SPDX-License-Identifier: MIT
 *
 * Scoring: the packed network alone, everything from samples to JOD, and to its gradient, for several batch sizes. The network
 * caches the contribution of the last reference, so successive calls use different ones.
 */
#include "bench/bench.h"
#include "kernel/panel.h"
#include "metric/metric.h"
#include "net/inference.h"
#include "train/train.h"

#include <string.h>

enum { N_REFS = 64, TURNS = 3 /* sets of references, used in turns */, MAX_BATCH = NQM_PREDICT_BATCH };

/* Pairs to score, as samples and as inputs of the network. */
typedef struct material_pairs {
    nqm_dataset *samples;
    size_t stride;
    float *x; /* (MAX_BATCH + TURNS, stride), inputs */
} material_pairs;

/* A batch and its results. */
typedef struct job {
    const material_pairs *pairs;
    nqm_inference_work *work;
    nqm_predictor *predictor;
    nqm_gradients *gradients; /* NULL: not of this batch */
    float *gradient;          /* (batch, n_values) */
    size_t batch, turn;
    float z[MAX_BATCH * (1 + NQM_LABEL_PARTS)];
    double jod[MAX_BATCH];
    nqm_prediction predictions[MAX_BATCH];
} job;

static void run_network(void *user) {
    job *j = user;
    const material_pairs *p = j->pairs;
    nqm_inference_run(j->work, j->batch, p->x + j->turn++ % TURNS * p->stride, p->stride, j->z);
}

/* The pairs of the next call; neighbours have different references. */
static void take_pairs(job *j, nqm_sample_pair pairs[MAX_BATCH]) {
    const nqm_dataset *d = j->pairs->samples;
    const size_t first = j->turn++ % TURNS, n_values = 3 * d->n_directions;
    for (size_t i = first; i < first + j->batch; ++i) {
        const size_t ref = i % N_REFS, test = ref * (d->n_pairs / d->n_refs) + i / N_REFS;
        pairs[i - first] = (nqm_sample_pair){d->ref_rgb + ref * n_values, d->test_rgb + test * n_values, NULL};
    }
}

static void run_all(void *user) {
    job *j = user;
    nqm_sample_pair pairs[MAX_BATCH];
    take_pairs(j, pairs);
    nqm_predictor_run(j->predictor, j->batch, pairs, j->predictions, NULL);
}

static void run_gradient(void *user) {
    job *j = user;
    nqm_sample_pair pairs[MAX_BATCH];
    take_pairs(j, pairs);
    nqm_gradients_run(j->gradients, NQM_SCORE_JOD, j->batch, pairs, j->jod, j->gradient);
}

static nqm_status make_pairs(material_pairs *p, const nqm_model *model, nqm_error *err) {
    *p = (material_pairs){.stride = nqm_row_stride(model->params.shape.sizes[0])};
    const size_t n = (MAX_BATCH + TURNS) * p->stride;
    p->x = nqm_alloc(n, sizeof *p->x);
    if (!p->x)
        return nqm_fail_nomem(err, n * sizeof *p->x);
    /* Random inputs: the time of the network does not depend on their values. */
    nqm_rng rng = nqm_rng_make(2, 0);
    for (size_t i = 0; i < n; ++i)
        p->x[i] = (float)nqm_rng_normal(&rng);
    return nqm_bench_pairs(N_REFS, model->directions, &p->samples, err);
}

/* ---- timing ------------------------------------------------------------------------------------------------------ */

static nqm_status make_job(job *j, const nqm_model *model, nqm_error *err) {
    const nqm_inference_net *net;
    nqm_status status = NQM_OK;
    if (nqm_model_has_network(model)) {
        status = nqm_model_inference(model, &net, err);
        if (status == NQM_OK)
            status = nqm_inference_work_create(net, j->batch, &j->work, err);
    }
    if (status == NQM_OK)
        status = nqm_predictor_create(model, j->batch, &j->predictor, err);
    if (status == NQM_OK && (j->batch == 1 || j->batch == MAX_BATCH)) {
        const size_t n_values = 3 * j->batch * model->directions->n;
        status = nqm_gradients_create(model, j->batch, &j->gradients, err);
        j->gradient = nqm_alloc(n_values, sizeof *j->gradient);
        if (status == NQM_OK && !j->gradient)
            status = nqm_fail_nomem(err, n_values * sizeof *j->gradient);
    }
    return status;
}

/* passes: 1 for a score; 2 with its gradient, whose backward pass is one product each, too. The work of a batch: multiply-adds, and
 * the bytes of weights and of the transport matrix. */
static void describe(nqm_bench *bench, const nqm_model *model, const job *j, double passes, nqm_bench_entry *entry) {
    const double n_light = nqm_model_has_network(model) ? 0 : 3 * (double)(model->n_transport * model->n_points);
    const double n_weights = (double)nqm_params_count(&model->params.shape);
    nqm_bench_text(entry, "model", model->id);
    nqm_bench_count(entry, "batch", j->batch);
    nqm_bench_entry_work(bench, entry, NQM_PRECISION_F32, 2 * passes * (n_weights + 2 * n_light) * (double)j->batch);
    nqm_bench_entry_reading(bench, entry, (size_t)(n_weights + n_light) * sizeof(float));
}

static nqm_status bench_batch(nqm_bench *bench, const nqm_model *model, const material_pairs *pairs, size_t batch,
                              nqm_error *err) {
    job j = {.pairs = pairs, .batch = batch};
    nqm_bench_entry entries[3];
    size_t n = 0;
    nqm_status status = make_job(&j, model, err);
    if (status == NQM_OK) {
        if (j.work)
            entries[n++] = nqm_bench_entry_make("score", "network", run_network, &j);
        entries[n++] = nqm_bench_entry_make("score", "samples to JOD", run_all, &j);
        if (j.gradients)
            entries[n++] = nqm_bench_entry_make("score", "samples to JOD and gradient", run_gradient, &j);
        for (size_t i = 0; i < n; ++i)
            describe(bench, model, &j, entries[i].run == run_gradient ? 2 : 1, &entries[i]);
        status = nqm_bench_race(bench, n, entries, err);
    }
    nqm_inference_work_free(j.work);
    nqm_predictor_free(j.predictor);
    nqm_gradients_free(j.gradients);
    nqm_free(j.gradient);
    return status;
}

static nqm_status bench_model(nqm_bench *bench, const nqm_model *model, nqm_error *err) {
    static const size_t batches[] = {1, 9, 180, MAX_BATCH};
    const size_t n_batches = bench->options.quick ? 2 : 4;
    material_pairs pairs;
    nqm_status status = nqm_bench_take_memory(bench, err);
    if (status != NQM_OK)
        return status;
    status = make_pairs(&pairs, model, err);
    for (size_t b = 0; b < n_batches && status == NQM_OK; ++b)
        status = bench_batch(bench, model, &pairs, batches[b], err);
    nqm_dataset_free(pairs.samples);
    nqm_free(pairs.x);
    return status;
}

nqm_status nqm_bench_score(nqm_bench *bench, nqm_error *err) {
    const char *name = bench->options.model;
    nqm_status status = NQM_OK;
    for (size_t i = 0; (name ? i == 0 : nqm_model_builtin_name(i) != NULL) && status == NQM_OK; ++i) {
        const char *id = name ? name : nqm_model_builtin_name(i);
        nqm_model *model;
        status = nqm_model_load(id, &model, err);
        if (status == NQM_OK)
            status = bench_model(bench, model, err);
        nqm_model_free(model);
    }
    return status;
}
