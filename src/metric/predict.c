/* SPDX-License-Identifier: MIT
 *
 * Predicts the JOD of sampled pairs: computes the features of each pair, runs one forward pass for the batch, and
 * converts the outputs to JOD.
 */
#include "kernel/kernel.h"
#include "kernel/panel.h"
#include "math/math.h"
#include "metric/metric.h"
#include "metric/sums.h"
#include "net/inference.h"
#include "percept/percept.h"
#include "sample/loops.h"

#include <math.h>
#include <omp.h>
#include <string.h>

struct nqm_predictor {
    const nqm_model *model;
    size_t samples_width;     /* number of inputs that come from samples */
    size_t stride;            /* floats from one row of x to the next */
    size_t n_threads;         /* when it was created: buffers are for so many tasks */
    nqm_sum_plan *plan;       /* of the scalar features and metrics */
    nqm_inference_work *work; /* NULL: the model has no network */
    float *t;             /* (tasks, 2, n_directions, 3) transformed reference and test: a task stays in the L2 cache */
    float *root;          /* (tasks, 1 + NQM_COMPARE_MAX, n_directions, 3) cube roots of a reference and its tests */
    nqm_pair_sums *sums;  /* (tasks, NQM_COMPARE_MAX) of a reference and its tests */
    double *bound;        /* (max_batch) of nqm_delta_e_bound() */
    double *spread;       /* (max_batch, 2) scalar features "estimate" and "ref_peak", for nqm_spread_features() */
    float *x;             /* (max_batch, stride) network inputs */
    float *z;             /* (max_batch, n_outputs) network outputs */
    nqm_label *estimates; /* (max_batch) by transport, if the model has it */
};

/* Pairs per task: enough to share the matrix of light transport, few enough for all threads. Their references may differ. */
static size_t pairs_per_task(size_t n, size_t n_threads) {
    return nqm_smaller(nqm_ceil_div(n, n_threads), NQM_COMPARE_MAX);
}

/* The most tasks of a call with at most n pairs. */
static size_t most_tasks(size_t n, size_t n_threads) {
    return nqm_smaller(n, nqm_larger(n_threads, nqm_ceil_div(n, NQM_COMPARE_MAX)));
}

nqm_status nqm_predictor_create(const nqm_model *model, nqm_precision precision, size_t max_batch,
                                nqm_predictor **predictor_ret, nqm_error *err) {
    *predictor_ret = NULL;
    const nqm_inference_net *net = NULL;
    nqm_status status = NQM_OK;
    if (nqm_model_has_network(model))
        status = nqm_model_inference(model, precision, &net, err);
    if (status != NQM_OK)
        return status;
    const size_t n_directions = model->directions->n;
    const size_t samples_width = nqm_features_width(model->features.layout, n_directions);
    const size_t stride = nqm_row_stride(samples_width + nqm_model_n_scalars(model));
    nqm_predictor *p;
    const size_t n_threads = (size_t)omp_get_max_threads(), n_tasks = most_tasks(max_batch, n_threads);
    const size_t n = 3 * n_directions;
    float *t, *root, *x, *z;
    nqm_pair_sums *sums;
    double *bound, *spread;
    nqm_label *estimates;
    status = nqm_alloc_arrays(NQM_ARRAYS({&p, 1, sizeof *p}, {&t, n_tasks, 2 * n * sizeof *t},
                                         {&root, n_tasks, (1 + NQM_COMPARE_MAX) * n * sizeof *root},
                                         {&sums, n_tasks, NQM_COMPARE_MAX * sizeof *sums},
                                         {&bound, max_batch, sizeof *bound}, {&spread, max_batch, 2 * sizeof *spread},
                                         {&x, max_batch, stride * sizeof *x},
                                         {&z, max_batch, nqm_model_n_outputs(model) * sizeof *z},
                                         {&estimates, model->transport ? max_batch : 0, sizeof *estimates}),
                              err);
    if (status != NQM_OK)
        return status;
    *p = (nqm_predictor){.model = model,
                         .samples_width = samples_width,
                         .stride = stride,
                         .n_threads = n_threads,
                         .t = t,
                         .root = root,
                         .sums = sums,
                         .bound = bound,
                         .spread = spread,
                         .x = x,
                         .z = z,
                         .estimates = model->transport ? estimates : NULL};
    status = nqm_sum_plan_create(model->directions, &p->plan, err);
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
    nqm_sum_plan_free(predictor->plan);
    nqm_free(predictor);
}

/* ---- a bound ----------------------------------------------------------------------------------------------------- */

/* A picture changes by at most about this Delta-E for a change of ln(f + 0.003) by 1 at every direction. Measured: at most 93 in
 * 3,641 pairs of 45 references and 61 kinds of difference, from roundings to other materials. 0.003 is NQM_DARK. */
static const double delta_e_per_log = 120;
static const float darkness = (float)NQM_DARK;

static float ratio_of(float ref, float test) {
    const float a = ref + darkness, b = test + darkness;
    return a > b ? a / b : b / a;
}

/* The largest ratio of the members in any channel of n directions. */
static float worst_ratio(size_t n, const float *ref, const float *test, const uint8_t *used) {
    float worst = 1;
    if (used && memchr(used, 0, n)) {
        for (size_t k = 0; k < 3 * n; ++k)
            if (used[k / 3])
                worst = fmaxf(worst, ratio_of(ref[k], test[k]));
        return worst;
    }
#pragma omp simd reduction(max : worst)
    for (size_t k = 0; k < 3 * n; ++k) {
        const float ratio = ratio_of(ref[k], test[k]);
        worst = ratio > worst ? ratio : worst;
    }
    return worst;
}

double nqm_delta_e_bound(size_t n_directions, const float *ref, const float *test, const uint8_t *used) {
    enum { AT_ONCE = 32 };
    const float large = 1.65F; /* a factor in any channel of any direction beyond which the bound says nothing */
    float worst = 1;
    for (size_t i = 0; i < n_directions && worst < large; i += AT_ONCE)
        worst = fmaxf(worst, worst_ratio(nqm_smaller(n_directions - i, AT_ONCE), ref + 3 * i, test + 3 * i,
                                         used ? used + i : NULL));
    return worst < large ? delta_e_per_log * log((double)worst) : INFINITY;
}

double nqm_delta_e_bound_slope(size_t n_directions, const float *ref, const float *test, const uint8_t *used,
                               size_t *at_ret) {
    float worst = 1;
    double slope = 0;
    *at_ret = 0;
    for (size_t k = 0; k < 3 * n_directions; ++k) {
        const float ratio = ratio_of(ref[k], test[k]);
        if ((!used || used[k / 3]) && ratio > worst) {
            worst = ratio;
            *at_ret = k;
            slope = (test[k] > ref[k] ? delta_e_per_log : -delta_e_per_log) / (double)(test[k] + darkness);
        }
    }
    return slope;
}

void nqm_raise_low(double delta_e_bound, double *jod_low) {
    /* Labels see all directions, samples a few: a rounding that leaves the samples of a mirror equal changed its label by up to
     * 0.33 Delta-E (3,039 pairs of 100 references; 1.5 is JOD 9.98). */
    static const double unseen = 1.5;
    const double least = isfinite(delta_e_bound) ? nqm_curve_jod(&nqm_curve_published, delta_e_bound + unseen) : 0;
    if (*jod_low < least) /* false for NaN */
        *jod_low = least;
}

/* ---- features ---------------------------------------------------------------------------------------------------- */

typedef struct compose_job {
    nqm_predictor *predictor;
    const nqm_sampled_pairs *pairs;
    size_t n_at_once; /* pairs per task */
} compose_job;

/* The buffers of a task. */
typedef struct task_buffers {
    nqm_predictor *predictor;
    const nqm_sampled_pairs *pairs;
    float *ref_t, *test_t;
    float *root; /* of the reference; those of its tests follow */
    nqm_pair_sums *sums;
} task_buffers;

/* Compute the inputs that come from samples of pairs [begin, end), which have the same reference. */
static void compose_samples(const task_buffers *task, size_t begin, size_t end) {
    const nqm_predictor *p = task->predictor;
    const nqm_sampled_pairs *pairs = task->pairs;
    const size_t n_directions = p->model->directions->n, n = 3 * n_directions;
    nqm_sample_logs(n, pairs->ref[begin], task->root, task->ref_t);
    for (size_t i = begin; i < end; ++i) {
        nqm_sample_logs(n, pairs->test[i], task->root + (1 + i - begin) * n, task->test_t);
        if (p->work)
            nqm_features_compose(&p->model->features, n_directions, task->ref_t, task->test_t,
                                 pairs->used ? pairs->used + n_directions * i : NULL, p->x + p->stride * i);
    }
}

/* Estimate the labels of pairs [begin, end). */
static void estimate(nqm_predictor *p, const nqm_sampled_pairs *pairs, size_t begin, size_t end) {
    const nqm_transport t = nqm_model_transport(p->model);
    nqm_transport_estimates(&t, end - begin, pairs->ref + begin, pairs->test + begin,
                            pairs->used ? pairs->used + t.n_directions * begin : NULL, p->estimates + begin);
}

static bool needs_sums(const task_buffers *task) {
    return nqm_model_n_scalars(task->predictor->model) > 0 || task->pairs->metrics;
}

/* The comparison of pairs [begin, end), which have the same reference. */
static nqm_comparison comparison_of(const task_buffers *task, size_t begin, size_t end) {
    const nqm_predictor *p = task->predictor;
    const nqm_sampled_pairs *pairs = task->pairs;
    const nqm_directions *directions = p->model->directions;
    return (nqm_comparison){.directions = directions,
                            .ref = pairs->ref[begin],
                            .n = end - begin,
                            .test = pairs->test + begin,
                            .used = pairs->used ? pairs->used + directions->n * begin : NULL,
                            .estimate = p->estimates ? p->estimates + begin : NULL};
}

/* Compute what does not depend on the estimate, of the same pairs: the inputs that come from samples, and the sums. */
static void compare(const task_buffers *task, size_t begin, size_t end) {
    const nqm_predictor *p = task->predictor;
    const nqm_sampled_pairs *pairs = task->pairs;
    const size_t n = p->model->directions->n;
    const nqm_comparison c = comparison_of(task, begin, end);
    for (size_t i = begin; i < end; ++i) {
        p->bound[i] = nqm_delta_e_bound(n, pairs->ref[i], pairs->test[i], pairs->used ? pairs->used + n * i : NULL);
        if (pairs->novelty)
            pairs->novelty[i] = NAN;
    }
    if (p->work || pairs->metrics)
        compose_samples(task, begin, end);
    if (needs_sums(task))
        nqm_compare_sums_float(p->plan, &c, task->root, nqm_model_n_scalars(p->model) > 0, task->sums);
}

/* Compute the metrics and the scalar inputs of the same pairs from their sums and estimates. */
static void finish(const task_buffers *task, size_t begin, size_t end) {
    const nqm_predictor *p = task->predictor;
    const nqm_sampled_pairs *pairs = task->pairs;
    const nqm_model *m = p->model;
    const bool with_scalars = nqm_model_n_scalars(m) > 0;
    const nqm_comparison c = comparison_of(task, begin, end);
    double scalars[NQM_COMPARE_MAX * NQM_SCALAR_COUNT];
    if (!needs_sums(task))
        return;
    nqm_compare_finish(&c, task->sums, pairs->metrics ? pairs->metrics + begin * NQM_METRIC_COUNT : NULL,
                       with_scalars ? scalars : NULL);
    for (size_t i = begin; with_scalars && i < end; ++i) {
        const double *own = scalars + (i - begin) * NQM_SCALAR_COUNT;
        nqm_scalars_whiten(&m->scalars, own, p->x + p->stride * i + p->samples_width);
        if (pairs->novelty)
            pairs->novelty[i] = nqm_model_novelty(m, own);
        p->spread[2 * i] = own[NQM_SCALAR_ESTIMATE];
        p->spread[2 * i + 1] = own[NQM_SCALAR_REF_PEAK];
    }
}

static task_buffers buffers_of(const compose_job *job, size_t i_task) {
    nqm_predictor *p = job->predictor;
    const size_t n = 3 * p->model->directions->n;
    float *t = p->t + i_task * 2 * n;
    return (task_buffers){
        p, job->pairs, t, t + n, p->root + i_task * (1 + NQM_COMPARE_MAX) * n, p->sums + i_task * NQM_COMPARE_MAX};
}

/* One task: processes its pairs in runs with the same reference, which is transformed once per run. */
static void compose(void *user, size_t i_task) {
    const compose_job *job = user;
    const nqm_sampled_pairs *pairs = job->pairs;
    const size_t first = i_task * job->n_at_once, end = nqm_smaller(first + job->n_at_once, pairs->n);
    const task_buffers task = buffers_of(job, i_task);
    if (job->predictor->estimates)
        estimate(job->predictor, pairs, first, end);
    for (size_t begin = first, next; begin < end; begin = next) {
        for (next = begin + 1; next < end && pairs->ref[next] == pairs->ref[begin];)
            ++next;
        compare(&task, begin, next);
        finish(&task, begin, next);
    }
}

/* Half of the work of a single pair. */
static void compose_half(void *user, size_t half) {
    const compose_job *job = user;
    const task_buffers task = buffers_of(job, 0);
    if (half == 0)
        estimate(job->predictor, job->pairs, 0, 1);
    else
        compare(&task, 0, 1);
}

/* A single pair: two threads, if both have enough to do. */
static void compose_one(compose_job *job) {
    const task_buffers task = buffers_of(job, 0);
    if (job->predictor->estimates && needs_sums(&task)) {
        nqm_parallel_for(2, compose_half, job);
        finish(&task, 0, 1);
    } else {
        compose(job, 0);
    }
}

/* ---- prediction -------------------------------------------------------------------------------------------------- */

/* The label for the outputs z of a model with parts. Delta-E, the length of the shift and structure are at most `bound`. */
static nqm_label bounded_label(const nqm_model *model, const float *z, const nqm_label *estimate, double bound) {
    const nqm_label whole = nqm_model_label(model, z, estimate);
    const double shift = sqrt(nqm_dot3(whole.shift, whole.shift));
    const double size = fmax(whole.delta_e, fmax(shift, fmax(whole.structure, fabs(whole.contrast))));
    nqm_label label = {.delta_e = 0};
    nqm_label_add(&label, size > bound ? bound / size : 1, &whole);
    return label;
}

/* The result of nqm_model_spread() for pair i with this prediction. */
static double spread_of(const nqm_predictor *p, size_t i, double jod) {
    double features[NQM_SPREAD_FEATURES];
    if (!nqm_model_has_spread(p->model) || nqm_model_n_scalars(p->model) == 0 || !isfinite(jod))
        return 0;
    nqm_spread_features(p->model, jod, p->spread[2 * i], p->spread[2 * i + 1], features);
    return nqm_model_spread(p->model, features);
}

void nqm_predictor_run(nqm_predictor *p, const nqm_sampled_pairs *pairs, double *jod, double *delta_e) {
    if (pairs->n == 0)
        return;
    compose_job job = {p, pairs, pairs_per_task(pairs->n, p->n_threads)};
    if (pairs->n == 1)
        compose_one(&job);
    else
        nqm_parallel_for(nqm_ceil_div(pairs->n, job.n_at_once), compose, &job);
    if (p->work)
        nqm_inference_run(p->work, pairs->n, p->x, p->stride, p->z);
    if (pairs->bound)
        memcpy(pairs->bound, p->bound, pairs->n * sizeof *p->bound);
    const size_t n_outputs = nqm_model_n_outputs(p->model);
    const double nan = (double)NAN;
    for (size_t i = 0; i < pairs->n; ++i) {
        const float *z = p->z + i * n_outputs;
        const double bound = p->bound[i];
        const nqm_label *estimate = p->estimates ? &p->estimates[i] : NULL;
        double own;
        jod[i] = nqm_model_jod(p->model, (double)*z, estimate, &own);
        if (own > bound) { /* false for NaN: models that predict no Delta-E */
            own = bound;
            jod[i] = nqm_curve_jod(&p->model->curve, own);
        }
        if (delta_e)
            delta_e[i] = own;
        if (pairs->spread)
            pairs->spread[i] = spread_of(p, i, jod[i]);
        if (pairs->labels)
            pairs->labels[i] = nqm_model_has_parts(p->model) ? bounded_label(p->model, z, estimate, bound)
                                                             : (nqm_label){nan, {nan, nan, nan}, nan, nan, 0};
    }
}
