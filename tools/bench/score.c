/* SPDX-License-Identifier: MIT
 *
 * Scoring: the packed network alone, everything from samples to JOD, and to its gradient, for several batch sizes, with one or
 * nine tests per reference. The network caches the contribution of the last reference, so successive calls use different
 * ones.
 */
#include "bench/bench.h"
#include "kernel/panel.h"
#include "metric/metric.h"
#include "net/inference.h"
#include "train/train.h"

#include <string.h>

enum { N_REFS = 64, TESTS_PER_REF = 9, TURNS = 3 /* sets of references, used in turns */ };

/* Pairs to score, as samples and as inputs of the network. */
typedef struct material_pairs {
    size_t n, n_values, stride;
    float *x;          /* (n, stride), inputs; owns the block of all four */
    float *x_shared;   /* (n, stride), inputs where TESTS_PER_REF neighbours have the same reference */
    float *ref, *test; /* (n, n_values): pair i has reference i % N_REFS, so that neighbours have different ones */
} material_pairs;

enum { MAX_BATCH = NQM_PREDICT_BATCH };

/* A batch and its results. */
typedef struct job {
    const material_pairs *pairs;
    nqm_inference_work *work;
    nqm_predictor *predictor;
    nqm_gradients *gradients; /* NULL: not of this batch */
    float *gradient;          /* (batch, n_values) */
    size_t batch, turn;
    bool is_shared; /* references are shared */
    float z[MAX_BATCH * (1 + NQM_LABEL_PARTS)];
    double jod[MAX_BATCH];
    nqm_prediction predictions[MAX_BATCH];
} job;

static void run_network(void *user) {
    job *j = user;
    const material_pairs *p = j->pairs;
    const size_t turn = j->turn++ % TURNS;
    const float *x = j->is_shared ? p->x_shared + turn * TESTS_PER_REF * p->stride : p->x + turn * p->stride;
    nqm_inference_run(j->work, j->batch, x, p->stride, j->z);
}

static void run_all(void *user) {
    job *j = user;
    const material_pairs *p = j->pairs;
    const size_t first = j->turn++ % TURNS;
    nqm_sample_pair pairs[MAX_BATCH];
    for (size_t i = 0; i < j->batch; ++i)
        pairs[i] = (nqm_sample_pair){p->ref + (first + (j->is_shared ? i / TESTS_PER_REF : i)) * p->n_values,
                                     p->test + (first + i) * p->n_values, NULL};
    nqm_predictor_run(j->predictor, j->batch, pairs, j->predictions, NULL);
}

static void run_gradient(void *user) {
    job *j = user;
    const material_pairs *p = j->pairs;
    const size_t first = j->turn++ % TURNS;
    nqm_sample_pair pairs[MAX_BATCH];
    for (size_t i = 0; i < j->batch; ++i)
        pairs[i] = (nqm_sample_pair){p->ref + (first + i) * p->n_values, p->test + (first + i) * p->n_values, NULL};
    nqm_gradients_run(j->gradients, NQM_SCORE_JOD, j->batch, pairs, j->jod, j->gradient);
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* Random inputs: the time of the network does not depend on their values. */
static void fill_inputs(material_pairs *p, size_t n_in, size_t n_ref) {
    nqm_rng rng = nqm_rng_make(2, 0);
    for (size_t i = 0; i < p->n; ++i)
        for (size_t k = 0; k < n_in; ++k)
            p->x[i * p->stride + k] = (float)nqm_rng_normal(&rng);
    for (size_t i = 0; i < p->n; ++i) {
        float *x = p->x_shared + i * p->stride;
        memcpy(x, p->x + i * p->stride, n_in * sizeof *x);
        memcpy(x, p->x + i / TESTS_PER_REF * p->stride, n_ref * sizeof *x);
    }
}

static nqm_status make_pairs(material_pairs *p, const nqm_model *model, nqm_error *err) {
    nqm_dataset *d;
    nqm_status status = nqm_bench_pairs(N_REFS, model->directions, &d, err);
    if (status != NQM_OK)
        return status;
    const size_t n_in = model->params.shape.sizes[0], n = MAX_BATCH + TURNS * TESTS_PER_REF;
    *p = (material_pairs){.n = n, .n_values = 3 * model->directions->n, .stride = nqm_row_stride(n_in)};
    status = nqm_alloc_arrays(
        NQM_ARRAYS({&p->x, n, p->stride * sizeof *p->x}, {&p->x_shared, n, p->stride * sizeof *p->x},
                   {&p->ref, n, p->n_values * sizeof *p->ref}, {&p->test, n, p->n_values * sizeof *p->test}),
        err);
    for (size_t i = 0; i < n && status == NQM_OK; ++i) {
        const size_t ref = i % N_REFS, test = ref * (d->n_pairs / d->n_refs) + i / N_REFS;
        memcpy(p->ref + i * p->n_values, d->ref_rgb + ref * p->n_values, p->n_values * sizeof *p->ref);
        memcpy(p->test + i * p->n_values, d->test_rgb + test * p->n_values, p->n_values * sizeof *p->test);
    }
    if (status == NQM_OK && nqm_model_has_network(model))
        fill_inputs(p, n_in, p->n_values);
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

/* The work of a batch: multiply-adds, without those that shared references save, and the bytes of weights and of the transport
 * matrix. */
static nqm_bench_entry describe(nqm_bench *bench, const nqm_model *model, const job *j, const char *name,
                                const char *id) {
    const nqm_net_shape *shape = &model->params.shape;
    const double n_light = nqm_model_has_network(model) ? 0 : 3 * (double)(model->n_transport * model->n_points);
    double n_weights = 0;
    for (size_t l = 0; l < shape->n_layers; ++l)
        n_weights += (double)shape->sizes[l] * (double)shape->sizes[l + 1];
    double mac = (n_weights + 2 * n_light) * (double)j->batch;
    const size_t n_refs = j->is_shared ? (j->batch + TESTS_PER_REF - 1) / TESTS_PER_REF : j->batch;
    mac -= (double)(j->batch - n_refs) * (n_light + (double)(3 * model->directions->n) * (double)shape->sizes[1]);
    nqm_bench_entry entry = nqm_bench_entry_make("score", name);
    nqm_bench_text(&entry, "model", id);
    nqm_bench_count(&entry, "batch", j->batch);
    nqm_bench_entry_work(bench, &entry, NQM_PRECISION_F32, 2 * mac);
    nqm_bench_entry_reading(bench, &entry, (size_t)(n_weights + n_light) * sizeof(float));
    return entry;
}

/* What is timed in turns. */
typedef struct race {
    size_t n;
    nqm_bench_contender contender[5];
    nqm_bench_entry entry[5];
} race;

/* alternative: how many entries before it the one is to which its speed is compared; 0: none. */
static void enter(race *r, void (*run)(void *user), job *j, size_t alternative, nqm_bench_entry entry) {
    entry.alternative = alternative;
    r->contender[r->n] = (nqm_bench_contender){run, j, NULL};
    r->entry[r->n++] = entry;
}

static nqm_status bench_batch(nqm_bench *bench, const nqm_model *model, const char *id, const material_pairs *pairs,
                              size_t batch, nqm_error *err) {
    const bool has_network = nqm_model_has_network(model), with_shared = batch == TESTS_PER_REF || batch == MAX_BATCH;
    job own = {.pairs = pairs, .batch = batch};
    nqm_status status = make_job(&own, model, err);
    job shared = own; /* uses the workspaces of `own` */
    shared.is_shared = true;
    if (status == NQM_OK) {
        race r = {0};
        if (has_network)
            enter(&r, run_network, &own, 0, describe(bench, model, &own, "network", id));
        enter(&r, run_all, &own, 0, describe(bench, model, &own, "samples to JOD", id));
        if (own.gradients) { /* forward and backward are one product each */
            nqm_bench_entry entry = describe(bench, model, &own, "samples to JOD and gradient", id);
            entry.gflop *= 2;
            enter(&r, run_gradient, &own, 1, entry);
        }
        const size_t distance = r.n;
        if (with_shared && has_network)
            enter(&r, run_network, &shared, distance,
                  describe(bench, model, &shared, "network, 9 tests a reference", id));
        if (with_shared)
            enter(&r, run_all, &shared, distance,
                  describe(bench, model, &shared, "samples to JOD, 9 tests a reference", id));
        status = nqm_bench_race(bench, r.n, r.contender, r.entry, err);
    }
    nqm_inference_work_free(own.work);
    nqm_predictor_free(own.predictor);
    nqm_gradients_free(own.gradients);
    nqm_free(own.gradient);
    return status;
}

static nqm_status bench_model(nqm_bench *bench, const nqm_model *model, const char *id, nqm_error *err) {
    static const size_t batches[] = {1, TESTS_PER_REF, 180, MAX_BATCH};
    const size_t n_batches = bench->options.quick ? 2 : 4;
    material_pairs pairs;
    nqm_status status = nqm_bench_take_memory(bench, err);
    if (status == NQM_OK)
        status = make_pairs(&pairs, model, err);
    if (status != NQM_OK)
        return status;
    for (size_t b = 0; b < n_batches && status == NQM_OK; ++b)
        status = bench_batch(bench, model, id, &pairs, batches[b], err);
    nqm_free(pairs.x);
    return status;
}

nqm_status nqm_bench_score(nqm_bench *bench, nqm_error *err) {
    const char *name = bench->options.model;
    const bool is_file = name && strchr(name, '.');
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < (name ? 1 : nqm_model_builtin_count()) && status == NQM_OK; ++i) {
        const char *id = name ? name : nqm_model_builtin_name(i);
        nqm_model *model;
        status = is_file ? nqm_model_load(id, &model, err) : nqm_model_builtin(id, &model, err);
        if (status == NQM_OK)
            status = bench_model(bench, model, is_file ? model->id : id, err);
        if (status == NQM_OK && strcmp(id, "default") == 0)
            status = nqm_bench_textures(bench, model, err);
        nqm_model_free(model);
    }
    return status;
}
