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
    size_t n, n_values, stride;
    float *x;          /* (n, stride), inputs; owns the block of all three */
    float *ref, *test; /* (n, n_values): pair i has reference i % N_REFS, so that neighbours have different ones */
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

/* The pairs of the next call. */
static void take_pairs(job *j, nqm_sample_pair pairs[MAX_BATCH]) {
    const material_pairs *p = j->pairs;
    const size_t first = j->turn++ % TURNS;
    for (size_t i = first; i < first + j->batch; ++i)
        pairs[i - first] = (nqm_sample_pair){p->ref + i * p->n_values, p->test + i * p->n_values, NULL};
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
    nqm_dataset *d;
    nqm_status status = nqm_bench_pairs(N_REFS, model->directions, &d, err);
    if (status != NQM_OK)
        return status;
    const size_t n_in = model->params.shape.sizes[0], n = MAX_BATCH + TURNS;
    *p = (material_pairs){.n = n, .n_values = 3 * model->directions->n, .stride = nqm_row_stride(n_in)};
    status =
        nqm_alloc_arrays(NQM_ARRAYS({&p->x, n, p->stride * sizeof *p->x}, {&p->ref, n, p->n_values * sizeof *p->ref},
                                    {&p->test, n, p->n_values * sizeof *p->test}),
                         err);
    for (size_t i = 0; i < n && status == NQM_OK; ++i) {
        const size_t ref = i % N_REFS, test = ref * (d->n_pairs / d->n_refs) + i / N_REFS;
        memcpy(p->ref + i * p->n_values, d->ref_rgb + ref * p->n_values, p->n_values * sizeof *p->ref);
        memcpy(p->test + i * p->n_values, d->test_rgb + test * p->n_values, p->n_values * sizeof *p->test);
    }
    /* Random inputs: the time of the network does not depend on their values. */
    nqm_rng rng = nqm_rng_make(2, 0);
    for (size_t i = 0; i < n * p->stride && status == NQM_OK; ++i)
        p->x[i] = (float)nqm_rng_normal(&rng);
    nqm_dataset_free(d);
    return status;
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
        status = nqm_gradients_create(model, j->batch, &j->gradients, err);
        j->gradient = nqm_alloc(j->batch * j->pairs->n_values, sizeof *j->gradient);
        if (status == NQM_OK && !j->gradient)
            status = nqm_fail_nomem(err, j->batch * j->pairs->n_values * sizeof *j->gradient);
    }
    return status;
}

/* passes: 1 for a score; 2 with its gradient, whose backward pass is one product each, too. The work of a batch: multiply-adds, and
 * the bytes of weights and of the transport matrix. */
static nqm_bench_entry describe(nqm_bench *bench, const nqm_model *model, size_t batch, double passes,
                                const char *name) {
    const nqm_net_shape *shape = &model->params.shape;
    const double n_light = nqm_model_has_network(model) ? 0 : 3 * (double)(model->n_transport * model->n_points);
    double n_weights = 0;
    for (size_t l = 0; l < shape->n_layers; ++l)
        n_weights += (double)shape->sizes[l] * (double)shape->sizes[l + 1];
    nqm_bench_entry entry = nqm_bench_entry_make("score", name);
    nqm_bench_text(&entry, "model", model->id);
    nqm_bench_count(&entry, "batch", batch);
    nqm_bench_entry_work(bench, &entry, NQM_PRECISION_F32, 2 * passes * (n_weights + 2 * n_light) * (double)batch);
    nqm_bench_entry_reading(bench, &entry, (size_t)(n_weights + n_light) * sizeof(float));
    return entry;
}

static nqm_status bench_batch(nqm_bench *bench, const nqm_model *model, const material_pairs *pairs, size_t batch,
                              nqm_error *err) {
    job j = {.pairs = pairs, .batch = batch};
    nqm_bench_contender contenders[3];
    nqm_bench_entry entries[3];
    size_t n = 0;
    nqm_status status = make_job(&j, model, err);
    if (status == NQM_OK) {
        if (j.work) {
            contenders[n] = (nqm_bench_contender){run_network, &j};
            entries[n++] = describe(bench, model, batch, 1, "network");
        }
        contenders[n] = (nqm_bench_contender){run_all, &j};
        entries[n++] = describe(bench, model, batch, 1, "samples to JOD");
        if (j.gradients) {
            contenders[n] = (nqm_bench_contender){run_gradient, &j};
            entries[n++] = describe(bench, model, batch, 2, "samples to JOD and gradient");
        }
        status = nqm_bench_race(bench, n, contenders, entries, err);
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
    if (status == NQM_OK)
        status = make_pairs(&pairs, model, err);
    if (status != NQM_OK)
        return status;
    for (size_t b = 0; b < n_batches && status == NQM_OK; ++b)
        status = bench_batch(bench, model, &pairs, batches[b], err);
    nqm_free(pairs.x);
    return status;
}

nqm_status nqm_bench_score(nqm_bench *bench, nqm_error *err) {
    const char *name = bench->options.model;
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < (name ? 1 : nqm_model_builtin_count()) && status == NQM_OK; ++i) {
        const char *id = name ? name : nqm_model_builtin_name(i);
        nqm_model *model;
        status = strchr(id, '.') ? nqm_model_load(id, &model, err) : nqm_model_builtin(id, &model, err);
        if (status == NQM_OK)
            status = bench_model(bench, model, err);
        nqm_model_free(model);
    }
    return status;
}
