/* SPDX-License-Identifier: MIT
 *
 * Scoring: the packed network alone, and everything from samples to JOD, for several batch sizes, with one or nine
 * tests per reference. The network caches the contribution of the last reference, so successive calls use different
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
    size_t batch, turn;
    bool is_shared; /* references are shared */
    float z[MAX_BATCH * (1 + NQM_LABEL_PARTS)];
    double jod[MAX_BATCH];
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
    const float *ref[MAX_BATCH], *test[MAX_BATCH];
    for (size_t i = 0; i < j->batch; ++i) {
        ref[i] = p->ref + (first + (j->is_shared ? i / TESTS_PER_REF : i)) * p->n_values;
        test[i] = p->test + (first + i) * p->n_values;
    }
    nqm_predictor_run(j->predictor, &(nqm_sampled_pairs){.n = j->batch, .ref = ref, .test = test}, j->jod, NULL);
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
    if (status == NQM_OK)
        fill_inputs(p, n_in, p->n_values);
    nqm_dataset_free(d);
    return status;
}

/* ---- timing ------------------------------------------------------------------------------------------------------ */

static nqm_status make_job(job *j, const nqm_model *model, nqm_precision precision, nqm_error *err) {
    const nqm_inference_net *net;
    nqm_status status = nqm_model_inference(model, precision, &net, err);
    if (status == NQM_OK)
        status = nqm_inference_work_create(net, j->batch, &j->work, err);
    if (status == NQM_OK)
        status = nqm_predictor_create(model, precision, j->batch, &j->predictor, err);
    return status;
}

/* The work of a batch: multiply-adds, without those that shared references save, and the bytes of the weights. */
static nqm_bench_entry describe(nqm_bench *bench, const nqm_model *model, const job *j, nqm_precision precision,
                                const char *name, const char *id) {
    const nqm_net_shape *shape = &model->params.shape;
    double n_weights = 0;
    for (size_t l = 0; l < shape->n_layers; ++l)
        n_weights += (double)shape->sizes[l] * (double)shape->sizes[l + 1];
    double mac = n_weights * (double)j->batch;
    const size_t n_refs = j->is_shared ? (j->batch + TESTS_PER_REF - 1) / TESTS_PER_REF : j->batch;
    mac -= (double)(j->batch - n_refs) * (double)(3 * model->directions->n) * (double)shape->sizes[1];
    nqm_bench_entry entry = nqm_bench_entry_make("score", name);
    entry.row.model = id;
    entry.row.size.batch = j->batch;
    nqm_bench_entry_work(bench, &entry, precision, 2 * mac);
    nqm_bench_entry_reading(bench, &entry, (size_t)n_weights * sizeof(float) >> precision);
    return entry;
}

static nqm_status bench_batch(nqm_bench *bench, const nqm_model *model, const char *id, const material_pairs *pairs,
                              size_t batch, nqm_precision precision, nqm_error *err) {
    job own = {.pairs = pairs, .batch = batch};
    nqm_status status = make_job(&own, model, precision, err);
    job shared = own; /* with the same workspaces */
    shared.is_shared = true;
    if (status == NQM_OK) {
        const nqm_bench_contender contenders[] = {
            {run_network, &own, NULL}, {run_all, &own, NULL}, {run_network, &shared, NULL}, {run_all, &shared, NULL}};
        nqm_bench_entry entries[] = {
            describe(bench, model, &own, precision, "network", id),
            describe(bench, model, &own, precision, "samples to JOD", id),
            describe(bench, model, &shared, precision, "network, 9 tests a reference", id),
            describe(bench, model, &shared, precision, "samples to JOD, 9 tests a reference", id)};
        entries[2].alternative = entries[3].alternative = 2;
        status = nqm_bench_race(bench, batch == TESTS_PER_REF || batch == MAX_BATCH ? 4 : 2, contenders, entries, err);
    }
    nqm_inference_work_free(own.work);
    nqm_predictor_free(own.predictor);
    return status;
}

/* id: in the rows, which outlive the model. */
static nqm_status bench_model(nqm_bench *bench, const nqm_model *model, const char *id, nqm_error *err) {
    static const size_t batches[] = {1, TESTS_PER_REF, 180, MAX_BATCH};
    const size_t n_batches = bench->options.quick ? 2 : 4;
    material_pairs pairs;
    nqm_status status = nqm_bench_take_memory(bench, err);
    if (status == NQM_OK)
        status = make_pairs(&pairs, model, err);
    if (status != NQM_OK)
        return status;
    bench->done = 0;
    bench->total = (double)(n_batches * bench->options.rounds * (size_t)NQM_PRECISION_COUNT);
    for (size_t b = 0; b < n_batches; ++b)
        for (nqm_precision p = NQM_PRECISION_F32; p < NQM_PRECISION_COUNT && status == NQM_OK; ++p)
            if (nqm_bench_has_precision(bench, p))
                status = bench_batch(bench, model, id, &pairs, batches[b], p, err);
    nqm_free(pairs.x);
    return status;
}

nqm_status nqm_bench_score(nqm_bench *bench, nqm_error *err) {
    const char *name = bench->options.model;
    nqm_status status = NQM_OK;
    if (name && strchr(name, '.')) { /* a file */
        if (!bench->model)
            status = nqm_model_load(name, &bench->model, err);
        return status == NQM_OK ? bench_model(bench, bench->model, bench->model->id, err) : status;
    }
    for (size_t i = 0; i < (name ? 1 : nqm_model_builtin_count()) && status == NQM_OK; ++i) {
        const char *id = name ? name : nqm_model_builtin_name(i);
        nqm_model *model;
        status = nqm_model_builtin(id, &model, err);
        if (status == NQM_OK && (name || nqm_model_get_info(model).n_layers > 0))
            status = bench_model(bench, model, id, err);
        nqm_model_free(model);
    }
    return status;
}
