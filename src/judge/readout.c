/* SPDX-License-Identifier: MIT
 *
 * Weights of the parts of a difference, fitted to people's answers by logistic regression with weights >= 0 and a ridge: the
 * similarity of a model for one study. What it gains is measured on materials that the weights were not fitted to.
 */
#include "judge/judge.h"
#include "metric/metric.h"

#include <math.h>
#include <string.h>

enum { FOLDS = 5, MAX_SWEEPS = 200, JOD = 0, SIMILARITY = 1, FITTED = 2, SCORES = 3 };
static const double ridge = 0.02; /* of weights of distances whose mean is 1: a normal prior with the deviation 5 */

typedef struct fit_work {
    size_t n, n_groups, n_pairs, n_resamples;
    const nqm_triplet *t;      /* (n) */
    double *mean;              /* (NQM_APART) of the distances; owns the block of all arrays */
    double *apart;             /* (n_pairs, NQM_APART) distances, divided by their means */
    double *score;             /* (n_pairs, 2) JOD and similarity */
    double *choices, *met;     /* (n_groups), (n_groups, SCORES) */
    double *resampled, *share; /* (n_resamples, NQM_APART) weights; (SCORES, n_resamples) */
} fit_work;

const char *const nqm_apart_names[NQM_APART] = {"delta_e", "brightness", "colour", "contrast", "structure", "built_in"};

void nqm_readout_set(const nqm_readout *r, nqm_model *model) {
    for (size_t k = 0; k < NQM_APART; ++k)
        model->similarity[k] = r->scale * r->weight[k];
    model->similarity[NQM_APART] = r->half_width;
}

/* ---- fit --------------------------------------------------------------------------------------------------------- */

/* Improve one weight, by a Newton step with a curvature that does not vanish; z (n) are the differences of distances.
 * Returns by how much it changed. */
static double improve(const fit_work *w, const double *times, double total, size_t k, double *weight, double *z) {
    double slope = 2 * ridge / total * weight[k], curvature = 2 * ridge / total;
    for (size_t i = 0; i < w->n; ++i) {
        const nqm_triplet *t = &w->t[i];
        const double d = w->apart[t->b * NQM_APART + k] - w->apart[t->a * NQM_APART + k], p = 1 / (1 + exp(-z[i]));
        slope += times[t->group] * (t->n_b * p - t->n_a * (1 - p)) * d / total;
        curvature += times[t->group] * (t->n_a + t->n_b) * d * d * fmax(p * (1 - p), 0.06) / total;
    }
    const double better = fmax(weight[k] - slope / curvature, 0), change = better - weight[k];
    weight[k] = better;
    for (size_t i = 0; change != 0 && i < w->n; ++i)
        z[i] += change * (w->apart[w->t[i].b * NQM_APART + k] - w->apart[w->t[i].a * NQM_APART + k]);
    return fabs(change);
}

/* Fit to the triplets of each group `times` so often, from the weights given. z: (n) scratch. */
static void fit(const fit_work *w, const double *times, double *weight, double *z) {
    double total = 0, change = 1;
    for (size_t i = 0; i < w->n; ++i) {
        const nqm_triplet *t = &w->t[i];
        total += times[t->group] * (t->n_a + t->n_b);
        z[i] = 0;
        for (size_t k = 0; k < NQM_APART; ++k)
            z[i] += weight[k] * (w->apart[t->b * NQM_APART + k] - w->apart[t->a * NQM_APART + k]);
    }
    for (int sweep = 0; total > 0 && change > 1e-3 && sweep < MAX_SWEEPS; ++sweep) {
        change = 0;
        for (size_t k = 0; k < NQM_APART; ++k)
            change = fmax(change, improve(w, times, total, k, weight, z));
    }
}

static double distance_of(const fit_work *w, const double *weight, size_t pair) {
    double sum = 0;
    for (size_t k = 0; k < NQM_APART; ++k)
        sum += weight[k] * w->apart[pair * NQM_APART + k];
    return sum;
}

/* The mean of such distances over all pairs, for each of which the mean is 1. */
static double sum_of(const double *weight) {
    double sum = 0;
    for (size_t k = 0; k < NQM_APART; ++k)
        sum += weight[k];
    return sum;
}

/* Count the choices that a score agrees with, whose values of a and b differ by `better`. */
static void count(const fit_work *w, const nqm_triplet *t, int score, double better) {
    const double a = better > 0 ? 1 : better < 0 ? 0 : 0.5;
    w->met[t->group * SCORES + (size_t)score] += a * t->n_a + (1 - a) * t->n_b;
}

/* Judge each fold of the groups by weights that are fitted to the others, and both scores of the model. times:
 * (n_groups) scratch. */
static void cross_validate(const fit_work *w, const double *all, double *times, double *z) {
    for (size_t fold = 0; fold < FOLDS; ++fold) {
        double weight[NQM_APART];
        memcpy(weight, all, sizeof weight);
        for (size_t g = 0; g < w->n_groups; ++g)
            times[g] = g % FOLDS != fold;
        fit(w, times, weight, z);
        for (size_t i = 0; i < w->n; ++i) {
            const nqm_triplet *t = &w->t[i];
            if (t->group % FOLDS != fold)
                continue;
            w->choices[t->group] += t->n_a + t->n_b;
            count(w, t, FITTED, distance_of(w, weight, t->b) - distance_of(w, weight, t->a));
            for (int s = JOD; s <= SIMILARITY; ++s)
                count(w, t, s, w->score[2 * t->a + (size_t)s] - w->score[2 * t->b + (size_t)s]);
        }
    }
}

static double share_of(const fit_work *w, int score, const double *times) {
    return nqm_share_of(w->n_groups, SCORES, w->met + score, w->choices, times);
}

/* ---- intervals --------------------------------------------------------------------------------------------------- */

/* 1.96 times the root mean square, over resamples and pairs, of the change of the logarithm of the distance over its mean. */
static double half_width_of(const fit_work *w, const double *weight) {
    double squares = 0, n = 0;
    for (size_t r = 0; r < w->n_resamples; ++r) {
        const double *own = w->resampled + r * NQM_APART;
        const double means = sum_of(own) / sum_of(weight);
        for (size_t i = 0; i < w->n_pairs; ++i) {
            const double change = log(distance_of(w, own, i) / distance_of(w, weight, i) / means);
            squares += isfinite(change) ? change * change : 0;
            n += isfinite(change);
        }
    }
    return fmax(n > 0 ? 1.96 * sqrt(squares / n) : 0, 1e-6);
}

static void find_intervals(const fit_work *w, uint64_t seed, nqm_readout *to, double *times, double *z) {
    for (size_t r = 0; r < w->n_resamples; ++r) {
        double *own = w->resampled + r * NQM_APART;
        nqm_bootstrap_draw(seed, r, w->n_groups, times);
        memcpy(own, to->weight, sizeof to->weight);
        fit(w, times, own, z);
        for (int s = 0; s < SCORES; ++s)
            w->share[(size_t)s * w->n_resamples + r] = share_of(w, s, times);
    }
    to->half_width = half_width_of(w, to->weight);
    const int rival = to->jod > to->similarity ? JOD : SIMILARITY;
    to->gain = nqm_difference_of(to->fitted - fmax(to->jod, to->similarity), w->n_resamples,
                                 w->share + FITTED * w->n_resamples, w->share + (size_t)rival * w->n_resamples, z);
    for (size_t k = 0; k < NQM_APART; ++k) {
        for (size_t r = 0; r < w->n_resamples; ++r)
            z[r] = w->resampled[r * NQM_APART + k] / w->mean[k];
        nqm_interval95(w->n_resamples, z, to->ci95[k]);
        to->weight[k] /= w->mean[k];
    }
}

/* ---- answers ----------------------------------------------------------------------------------------------------- */

/* Choices, or for scores each two tests of a material whose scores differ; *own_ret owns the latter. */
static nqm_status list_triplets(const nqm_human *h, fit_work *w, nqm_triplet **own_ret, nqm_error *err) {
    const nqm_dataset *d = h->dataset;
    size_t max_n = 0;
    w->t = h->triplets;
    w->n = h->n_triplets;
    if (h->kind == NQM_HUMAN_CHOICE)
        return NQM_OK;
    for (size_t b = 0; b < d->n_pairs; ++b)
        for (size_t a = 0; a < b; ++a) {
            const uint32_t group = d->ref_group[d->pair_ref[a]];
            const double x = d->jod[a], y = d->jod[b];
            if (group != d->ref_group[d->pair_ref[b]] || x == y)
                continue;
            nqm_triplet *grown = nqm_grow(*own_ret, &max_n, w->n + 1, sizeof *grown);
            if (!grown)
                return nqm_fail_nomem(err, (w->n + 1) * sizeof *grown);
            grown[w->n++] = (nqm_triplet){group, (uint32_t)a, (uint32_t)b, x > y, y > x};
            w->t = *own_ret = grown;
        }
    return NQM_OK;
}

static nqm_status predict(const nqm_human *h, const nqm_model *model, fit_work *w, nqm_error *err) {
    size_t *pairs;
    nqm_prediction *to;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&to, w->n_pairs, sizeof *to}, {&pairs, w->n_pairs, sizeof *pairs}), err);
    for (size_t i = 0; status == NQM_OK && i < w->n_pairs; ++i)
        pairs[i] = i;
    const nqm_dataset_prediction p = {h->dataset, model, w->n_pairs, pairs, to, NULL, NULL};
    if (status != NQM_OK)
        return status;
    status = nqm_dataset_predict(&p, err);
    for (size_t k = 0; status == NQM_OK && k < NQM_APART; ++k) {
        for (size_t i = 0; i < w->n_pairs; ++i)
            w->mean[k] += to[i].apart[k] / (double)w->n_pairs;
        w->mean[k] = fmax(w->mean[k], 1e-9);
        for (size_t i = 0; i < w->n_pairs; ++i)
            w->apart[i * NQM_APART + k] = to[i].apart[k] / w->mean[k];
    }
    for (size_t i = 0; status == NQM_OK && i < w->n_pairs; ++i) {
        w->score[2 * i + JOD] = to[i].jod;
        w->score[2 * i + SIMILARITY] = to[i].similarity[0];
    }
    nqm_free(to);
    return status;
}

/* Everything but memory. times: (n_groups), z: (larger of n and n_resamples). */
static nqm_status fit_readout(const fit_work *w, uint64_t seed, nqm_readout *to, double *times, double *z,
                              nqm_error *err) {
    for (size_t g = 0; g < w->n_groups; ++g)
        times[g] = 1;
    fit(w, times, to->weight, z);
    cross_validate(w, to->weight, times, z);
    to->scale = sum_of(to->weight) > 0 ? w->mean[NQM_APART_BUILT_IN] / sum_of(to->weight) : 1;
    for (size_t g = 0; g < w->n_groups; ++g) {
        to->n_choices += w->choices[g];
        to->n_materials += w->choices[g] > 0;
    }
    if (to->n_materials < FOLDS)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "answers are about %zu materials; %d are needed",
                        to->n_materials, FOLDS);
    to->n_triplets = w->n;
    to->jod = share_of(w, JOD, NULL);
    to->similarity = share_of(w, SIMILARITY, NULL);
    to->fitted = share_of(w, FITTED, NULL);
    find_intervals(w, seed, to, times, z);
    return NQM_OK;
}

nqm_status nqm_human_fit_readout(const nqm_human *human, const nqm_model *model, const nqm_eval_options *options,
                                 nqm_readout *readout_ret, nqm_error *err) {
    const nqm_dataset *d = human->dataset;
    fit_work w = {.n_groups = d->n_groups, .n_pairs = d->n_pairs, .n_resamples = options->n_bootstrap};
    nqm_triplet *own = NULL;
    double *times, *z;
    if (!model->transport)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "model '%s' has no transport matrix, and so no similarity",
                        model->id);
    nqm_status status = list_triplets(human, &w, &own, err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(
            NQM_ARRAYS({&w.mean, NQM_APART, sizeof *w.mean}, {&w.apart, w.n_pairs, NQM_APART * sizeof *w.apart},
                       {&w.score, w.n_pairs, 2 * sizeof *w.score}, {&w.choices, w.n_groups, sizeof *w.choices},
                       {&w.met, w.n_groups, SCORES * sizeof *w.met},
                       {&w.share, w.n_resamples, SCORES * sizeof *w.share},
                       {&w.resampled, w.n_resamples, NQM_APART * sizeof *w.resampled},
                       {&times, w.n_groups, sizeof *times}, {&z, nqm_larger(w.n, w.n_resamples), sizeof *z}),
            err);
    if (status == NQM_OK)
        status = predict(human, model, &w, err);
    if (status == NQM_OK) {
        *readout_ret = (nqm_readout){0};
        status = fit_readout(&w, options->seed, readout_ret, times, z, err);
    }
    nqm_free(w.mean);
    nqm_free(own);
    return status;
}
