/* SPDX-License-Identifier: MIT
 *
 * Coverage of a model's intervals: the fraction of labels inside, over all pairs, by material and by predicted JOD.
 */
#include "judge/judge.h"
#include "metric/metric.h"

#include <math.h>

static const double range_from[NQM_COVERAGE_RANGES] = {0, 4, 8, 9.5, 9.9};

static size_t range_of(double jod) {
    size_t i = NQM_COVERAGE_RANGES - 1;
    while (i > 0 && jod < range_from[i])
        --i;
    return i;
}

/* Whether a label is inside its interval; adds to the sums, which conclude() converts to fractions and means. */
static bool count(const nqm_evaluation *ev, size_t model, size_t pair, nqm_coverage *c) {
    const nqm_dataset *d = nqm_evaluation_samples(ev, model);
    const size_t at = model * d->n_pairs + pair;
    double low, high, jod = ev->values[at], label = d->jod[pair];
    nqm_bounded_interval(ev->models[model], &ev->predictions[at], &low, &high);
    nqm_coverage_range *range = &c->ranges[range_of(jod)];
    const bool inside = label >= low && label <= high;
    c->inside.value += inside;
    c->below += label < low;
    c->above += label > high;
    c->mean_width += high - low;
    ++range->n;
    range->inside += inside;
    range->mean_width += high - low;
    return inside;
}

static void conclude(const nqm_dataset *d, const nqm_selection *s, const double *inside, nqm_coverage *c) {
    c->lowest = INFINITY;
    for (size_t g = 0; g < s->n_groups; ++g) {
        double share = inside[g] / (double)(s->group_begin[g + 1] - s->group_begin[g]);
        c->by_material.value += share;
        if (share < c->lowest) {
            c->lowest = share;
            c->lowest_material = nqm_name(&d->group_names, d->ref_group[d->pair_ref[s->pairs[s->group_begin[g]]]]);
        }
    }
    c->by_material.value /= (double)s->n_groups;
    double *sums[] = {&c->inside.value, &c->below, &c->above, &c->mean_width};
    for (size_t i = 0; i < sizeof sums / sizeof *sums; ++i)
        *sums[i] /= (double)s->n;
    for (size_t i = 0; i < NQM_COVERAGE_RANGES; ++i) {
        nqm_coverage_range *range = &c->ranges[i];
        range->from = range_from[i];
        range->inside /= (double)range->n; /* NaN for an empty range */
        range->mean_width /= (double)range->n;
    }
}

/* Compute percentile intervals over n resamples of the groups. */
static nqm_status resample(const nqm_selection *s, size_t n, uint64_t seed, const double *inside, nqm_coverage *c,
                           nqm_error *err) {
    double *weight, *shares, *means;
    const nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&weight, s->n_groups, sizeof *weight}, {&shares, n, sizeof *shares}, {&means, n, sizeof *means}),
        err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n; ++i) {
        nqm_bootstrap_draw(seed, i, s->n_groups, weight);
        double n_pairs = 0, n_inside = 0, sum = 0;
        for (size_t g = 0; g < s->n_groups; ++g) {
            const double n_group = (double)(s->group_begin[g + 1] - s->group_begin[g]);
            n_pairs += weight[g] * n_group;
            n_inside += weight[g] * inside[g];
            sum += weight[g] * inside[g] / n_group;
        }
        shares[i] = n_inside / n_pairs;
        means[i] = sum / (double)s->n_groups;
    }
    nqm_interval95(n, shares, c->inside.ci95);
    nqm_interval95(n, means, c->by_material.ci95);
    nqm_free(weight);
    return NQM_OK;
}

nqm_status nqm_evaluation_coverage(const nqm_evaluation *evaluation, const nqm_eval_options *options, size_t model,
                                   nqm_coverage *coverage_ret, nqm_error *err) {
    if (model >= evaluation->n_models || !evaluation->models[model]->interval)
        return nqm_fail(err, NQM_ERR_ARG, -1, "predictor %zu is no model with intervals", model);
    if (evaluation->dataset->order_only)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the labels are no JOD");
    nqm_selection s;
    nqm_status status = nqm_selection_create(evaluation, options, 1, &s, err);
    if (status != NQM_OK)
        return status;
    double *inside = s.prediction; /* (n_groups), each of which has a pair */
    *coverage_ret = (nqm_coverage){.n = s.n, .n_materials = s.n_groups};
    for (size_t g = 0; g < s.n_groups; ++g)
        for (size_t k = s.group_begin[g]; k < s.group_begin[g + 1]; ++k)
            inside[g] += count(evaluation, model, s.pairs[k], coverage_ret);
    conclude(evaluation->dataset, &s, inside, coverage_ret);
    status =
        resample(&s, nqm_bootstrap_count(s.n_groups, options->n_bootstrap), options->seed, inside, coverage_ret, err);
    nqm_selection_free(&s);
    return status;
}
