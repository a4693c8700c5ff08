/* SPDX-License-Identifier: MIT
 *
 * Coverage of a model's intervals: the fraction of labels inside, over all pairs, by material and by predicted JOD.
 */
#include "judge/bootstrap.h"
#include "judge/evaluate.h"
#include "model/model.h"

#include <math.h>
#include <string.h>

static const double range_from[NQM_COVERAGE_RANGES] = {0, 4, 8, 9.5, 9.9};

static size_t range_of(double jod) {
    size_t i = NQM_COVERAGE_RANGES - 1;
    while (i > 0 && jod < range_from[i])
        --i;
    return i;
}

/* Number of labels, and of labels inside the intervals; both (n_groups). */
typedef struct tally {
    double *n, *inside;
} tally;

/* Sum over the pairs; finish() converts the sums to fractions and means. */
static void count(const nqm_evaluation *ev, const nqm_selection *s, size_t model, tally *t, nqm_coverage *c) {
    const nqm_dataset *d = ev->dataset;
    for (size_t k = 0; k < s->n; ++k) {
        size_t pair = s->pairs[k], group = d->ref_group[d->pair_ref[pair]];
        double low, high, jod = ev->values[model * d->n_pairs + pair], label = d->jod[pair];
        double novelty = nqm_model_novelty(ev->models[model], ev->scalars + pair * NQM_SCALAR_COUNT);
        nqm_model_interval(ev->models[model], jod, novelty, &low, &high);
        nqm_coverage_range *range = &c->ranges[range_of(jod)];
        bool inside = label >= low && label <= high;
        t->n[group] += 1;
        t->inside[group] += inside;
        c->inside.value += inside;
        c->below += label < low;
        c->above += label > high;
        c->mean_width += high - low;
        ++range->n;
        range->inside += inside;
        range->mean_width += high - low;
    }
}

static void finish(const nqm_dataset *d, const nqm_selection *s, const tally *t, nqm_coverage *c) {
    c->n = s->n;
    c->lowest = INFINITY;
    for (size_t g = 0; g < d->n_groups; ++g) {
        if (t->n[g] == 0)
            continue;
        double share = t->inside[g] / t->n[g];
        ++c->n_materials;
        c->by_material.value += share;
        if (share < c->lowest) {
            c->lowest = share;
            c->lowest_material = nqm_name(&d->group_names, g);
        }
    }
    c->by_material.value /= (double)c->n_materials;
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

/* Compute percentile intervals over resamples of the groups with pairs. */
static nqm_status resample(const nqm_eval_options *o, size_t n_groups, const tally *t, nqm_coverage *c,
                           nqm_error *err) {
    for (size_t k = 0; k < 2; ++k)
        c->inside.ci95[k] = c->by_material.ci95[k] = NAN;
    if (o->n_bootstrap == 0 || c->n_materials < 2)
        return NQM_OK;
    size_t *occurring, n_occurring = 0;
    double *weight, *inside, *mean;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&occurring, c->n_materials, sizeof *occurring}, {&weight, n_groups, sizeof *weight},
                   {&inside, o->n_bootstrap, sizeof *inside}, {&mean, o->n_bootstrap, sizeof *mean}),
        err);
    if (status != NQM_OK)
        return status;
    for (size_t g = 0; g < n_groups; ++g)
        if (t->n[g] > 0)
            occurring[n_occurring++] = g;
    for (size_t i = 0; i < o->n_bootstrap; ++i) {
        memset(weight, 0, n_groups * sizeof *weight);
        nqm_bootstrap_draw(o->seed, i, n_occurring, occurring, weight);
        double n = 0, n_inside = 0, shares = 0;
        for (size_t k = 0; k < n_occurring; ++k) {
            size_t g = occurring[k];
            n += weight[g] * t->n[g];
            n_inside += weight[g] * t->inside[g];
            shares += weight[g] * t->inside[g] / t->n[g];
        }
        inside[i] = n_inside / n;
        mean[i] = shares / (double)n_occurring;
    }
    nqm_interval95(o->n_bootstrap, inside, c->inside.ci95);
    nqm_interval95(o->n_bootstrap, mean, c->by_material.ci95);
    nqm_free(occurring);
    return NQM_OK;
}

nqm_status nqm_evaluation_coverage(const nqm_evaluation *ev, const nqm_eval_options *options, size_t model,
                                   nqm_coverage *coverage_ret, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    nqm_eval_options o = options ? *options : nqm_eval_options_default();
    if (model >= ev->n_models || !ev->models[model]->interval)
        return nqm_fail(err, NQM_ERR_ARG, -1, "predictor %zu is no model with intervals", model);
    if (d->order_only)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the labels are no JOD");
    nqm_selection s;
    nqm_status status = nqm_selection_create(ev, &o, &s, err);
    if (status != NQM_OK)
        return status;
    *coverage_ret = (nqm_coverage){0};
    tally t;
    status =
        nqm_alloc_arrays(NQM_ARRAYS({&t.n, d->n_groups, sizeof *t.n}, {&t.inside, d->n_groups, sizeof *t.inside}), err);
    if (status == NQM_OK) {
        count(ev, &s, model, &t, coverage_ret);
        finish(d, &s, &t, coverage_ret);
        status = resample(&o, d->n_groups, &t, coverage_ret, err);
    }
    nqm_free(t.n);
    nqm_selection_free(&s);
    return status;
}
