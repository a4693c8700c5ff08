/* SPDX-License-Identifier: MIT
 *
 * From sampled pairs to the inputs of a model's network, for scores and for gradients: transformed samples, sums over
 * the directions, and from these and the estimated labels the metrics and scalar features.
 */
#include "metric/compose.h"
#include "kernel/panel.h"
#include "sample/loops.h"

#include <omp.h>

nqm_status nqm_composer_create(const nqm_model *model, size_t max_batch, nqm_composer **composer_ret, nqm_error *err) {
    *composer_ret = NULL;
    const size_t n = 3 * model->directions->n, samples_width = nqm_features_width(model->features.layout, n / 3);
    const size_t n_threads = (size_t)omp_get_max_threads();
    const size_t n_tasks = nqm_smaller(max_batch, nqm_larger(n_threads, nqm_ceil_div(max_batch, NQM_COMPARE_MAX)));
    nqm_composer *c, made = {.model = model,
                             .samples_width = samples_width,
                             .stride = nqm_row_stride(samples_width + model->scalars.n),
                             .n_threads = n_threads};
    const size_t n_rows = nqm_model_has_network(model) ? max_batch : 0;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&c, 1, sizeof *c}, {&made.t, n_tasks, 2 * n * sizeof *made.t},
                   {&made.root, n_tasks, (1 + NQM_COMPARE_MAX) * n * sizeof *made.root},
                   {&made.x, n_rows, made.stride * sizeof *made.x}, {&made.sums, max_batch, sizeof *made.sums},
                   {&made.scalars, max_batch, NQM_SCALAR_COUNT * sizeof *made.scalars},
                   {&made.bound, max_batch, sizeof *made.bound}, {&made.estimate, max_batch, sizeof *made.estimate},
                   {&made.looks, max_batch, sizeof *made.looks}),
        err);
    if (status != NQM_OK)
        return status;
    *c = made;
    status = nqm_sum_plan_create(model->directions, &c->plan, err);
    if (status == NQM_OK)
        *composer_ret = c;
    else
        nqm_composer_free(c);
    return status;
}

void nqm_composer_free(nqm_composer *composer) {
    if (!composer)
        return;
    nqm_sum_plan_free(composer->plan);
    nqm_free(composer);
}

size_t nqm_composer_task(const nqm_composer *c, size_t n) {
    return nqm_smaller(nqm_ceil_div(n, c->n_threads), NQM_COMPARE_MAX);
}

static bool needs_sums(const nqm_composer *c, bool with_metrics) {
    return c->model->scalars.n > 0 || c->model->transport || with_metrics;
}

/* How many pairs at the beginning have the same reference. */
static size_t run_of(size_t n, const nqm_sample_pair *pairs) {
    size_t run = 1;
    while (run < n && pairs[run].ref == pairs[0].ref)
        ++run;
    return run;
}

float *nqm_composer_root(const nqm_composer *c, size_t task) {
    return c->root + task * (1 + NQM_COMPARE_MAX) * 3 * c->model->directions->n;
}

void nqm_compose_samples(const nqm_composer *c, size_t task, size_t first, size_t n, const nqm_sample_pair *pairs,
                         bool with_metrics) {
    const nqm_model *m = c->model;
    const size_t n_directions = m->directions->n, n_values = 3 * n_directions;
    const bool has_network = nqm_model_has_network(m);
    float *ref_t = c->t + task * 2 * n_values, *test_t = ref_t + n_values, *root = nqm_composer_root(c, task);
    for (size_t i = 0; i < n; ++i)
        c->bound[first + i] = nqm_delta_e_bound(n_directions, &pairs[i]);
    if (!has_network && !needs_sums(c, with_metrics))
        return;
    for (size_t begin = 0, run; begin < n; begin += run) { /* the reference of a run is transformed once */
        run = run_of(n - begin, pairs + begin);
        nqm_sample_logs(n_values, pairs[begin].ref, root, ref_t);
        for (size_t i = 0; i < run; ++i) {
            const nqm_sample_pair *p = &pairs[begin + i];
            nqm_sample_logs(n_values, p->test, root + (1 + i) * n_values, test_t);
            if (has_network)
                nqm_features_compose(&m->features, n_directions, ref_t, test_t, p->used,
                                     c->x + c->stride * (first + begin + i));
        }
        if (needs_sums(c, with_metrics))
            nqm_compare_sums(c->plan, run, pairs + begin, root, m->scalars.n > 0, c->sums + first + begin);
    }
}

void nqm_compose_scalars(const nqm_composer *c, size_t first, size_t n, double *metrics) {
    const nqm_model *m = c->model;
    const bool with_scalars = m->scalars.n > 0;
    for (size_t i = first; (with_scalars || metrics) && i < first + n; ++i) {
        double *scalars = with_scalars ? c->scalars + i * NQM_SCALAR_COUNT : NULL;
        nqm_compare_finish(&c->sums[i], m->transport ? &c->estimate[i] : NULL,
                           metrics ? metrics + i * NQM_METRIC_COUNT : NULL, scalars);
        if (with_scalars && nqm_model_has_network(m))
            nqm_scalars_whiten(&m->scalars, scalars, c->x + c->stride * i + c->samples_width);
    }
}
