/* SPDX-License-Identifier: MIT
 *
 * Intervals around predictions, from residuals of unseen materials: locally scaled conformal prediction (Lei et al.
 * 2018, arXiv:1604.04173, section 5.2; Romano et al. 2019, arXiv:1905.03222) for data in groups (Dunn et al. 2022,
 * arXiv:1809.07441; Lee et al. 2023, arXiv:2306.06342).
 *
 * 1. Residuals are computed in y = log(JOD / (10 - JOD)), so that the saturation near JOD 10 does not compress them.
 * 2. The local scales, up and down, are the 95 % quantiles of the residuals and of the negated residuals in windows of
 *    neighbouring predictions.
 * 3. The score of a pair is its residual divided by the scale that was estimated without the pair's material.
 * 4. The half-widths of the interval are the scales times one factor: the smallest factor for which the fraction of
 *    scores below it, averaged over materials, is 0.95 at its lower 95 % confidence limit. Pairs of a material are not
 *    independent, so that the sample size is the number of materials; the confidence limit accounts for a small number
 *    of them.
 * 5. Where features f_k >= 0 of the pairs are known that predict the size of errors (the novelty, and those of
 *    nqm_spread_features()), residuals are first divided by exp(sum_k g_k f_k), and the interval is widened by the same
 *    factor. The growths g_k >= 0 are those of a grid that minimise the interval score (Gneiting and Raftery 2007,
 *    DOI 10.1198/016214506000001437, section 6.2), averaged over materials: the width plus a penalty for each label
 *    outside.
 * 6. No half-width is below 1.96 times the standard errors of labels near that prediction, where they are known, nor below
 *    0.001 JOD, differences that y hides.
 */
#include "math/math.h"
#include "train/train.h"

#include <math.h>
#include <stdlib.h>

static const double level = 0.95;
static const double jod_top = 10;
static const double least_jod = 1e-3;   /* half-width */
static const double least_scale = 0.02; /* in y; positive, so that a factor also widens windows with residuals of 0 */
enum { MAX_WINDOWS = 10, PAIRS_PER_WINDOW = 50 };

static const size_t nobody = SIZE_MAX; /* no material is left out */

/* ---- local scales ------------------------------------------------------------------------------------------------ */

/* Local scales as a function of the prediction: interpolated between the medians of the windows, constant outside. */
typedef struct scales {
    size_t n;
    double at[MAX_WINDOWS], down[MAX_WINDOWS], up[MAX_WINDOWS];
} scales;

static double scale_at(const scales *s, const double *values, double y) {
    size_t i = 0;
    while (i < s->n && y > s->at[i])
        ++i;
    if (i == 0 || i == s->n)
        return values[i ? s->n - 1 : 0];
    double t = (y - s->at[i - 1]) / (s->at[i] - s->at[i - 1]);
    return (1 - t) * values[i - 1] + t * values[i];
}

/* Data and scratch memory of one fit. */
typedef struct fit {
    const nqm_residuals *r;
    size_t n_materials;
    size_t *count;         /* (n_groups) pairs; owns all arrays */
    double *y;             /* (n) y of the prediction */
    double *error;         /* (n) y of the label minus y of the prediction */
    double *times;         /* (n) the factor of step 5, by which errors are divided */
    double *down;          /* (n) scale at the pair, estimated without its material */
    double *up;            /* (n) likewise */
    double *score;         /* (n) see step 3 */
    nqm_indexed *sorted;   /* (n) pairs by prediction */
    nqm_indexed *window;   /* (n) scratch */
    size_t *kept;          /* (n) scratch: pairs of the other materials, by prediction */
    nqm_indexed *by_score; /* (n) pairs by score */
    size_t *inside;        /* (n_groups) scratch: pairs inside the interval */
    double *loss;          /* (N_GROWTHS, n_groups) mean interval score of each material; 0 without features */
} fit;

/* Weighted quantile of `n` sorted values: the smallest one with at least the fraction `level` of the weight at or below
 * it. Every material has the same total weight. step -1: quantile of the negated values. */
static double weighted_quantile(const fit *f, size_t n, const nqm_indexed *values, int step) {
    double total = 0, sum = 0;
    for (size_t i = 0; i < n; ++i)
        total += 1 / (double)f->count[f->r->group[values[i].index]];
    for (size_t k = 0; k < n; ++k) {
        const nqm_indexed *v = &values[step > 0 ? k : n - 1 - k];
        sum += 1 / (double)f->count[f->r->group[v->index]];
        if (sum >= level * total)
            return step * v->value;
    }
    return step * values[step > 0 ? n - 1 : 0].value;
}

/* Estimate the scales from all materials except `left_out`. */
static scales find_scales(const fit *f, size_t left_out) {
    size_t n = 0;
    for (size_t i = 0; i < f->r->n; ++i)
        if (f->r->group[f->sorted[i].index] != left_out)
            f->kept[n++] = f->sorted[i].index;
    size_t n_windows = n / PAIRS_PER_WINDOW;
    n_windows = n_windows < 1 ? 1 : n_windows > MAX_WINDOWS ? MAX_WINDOWS : n_windows;
    scales s = {.n = n_windows};
    for (size_t w = 0; w < n_windows; ++w) { /* each window overlaps half of each neighbouring window */
        size_t begin = w ? n * (2 * w - 1) / (2 * n_windows) : 0;
        size_t end = w + 1 < n_windows ? n * (2 * w + 3) / (2 * n_windows) : n;
        for (size_t i = begin; i < end; ++i)
            f->window[i - begin] = (nqm_indexed){f->error[f->kept[i]] / f->times[f->kept[i]], f->kept[i]};
        s.at[w] = f->y[f->kept[begin + (end - begin) / 2]];
        qsort(f->window, end - begin, sizeof *f->window, nqm_compare_indexed);
        s.up[w] = fmax(least_scale, weighted_quantile(f, end - begin, f->window, 1));
        s.down[w] = fmax(least_scale, weighted_quantile(f, end - begin, f->window, -1));
    }
    return s;
}

/* ---- the factor -------------------------------------------------------------------------------------------------- */

/* True if the lower 95 % confidence limit of the mean coverage over n materials (f->inside) is at least `level`. */
static bool suffices(const fit *f, size_t left_out, size_t n) {
    double sum = 0, squares = 0;
    for (size_t g = 0; g < f->r->n_groups; ++g)
        if (f->count[g] && g != left_out)
            sum += (double)f->inside[g] / (double)f->count[g];
    double mean = sum / (double)n;
    for (size_t g = 0; g < f->r->n_groups; ++g)
        if (f->count[g] && g != left_out)
            squares += pow((double)f->inside[g] / (double)f->count[g] - mean, 2);
    double error = sqrt(squares / ((double)(n - 1) * (double)n));
    return mean - nqm_student95((double)(n - 1)) * error >= level;
}

/* Try the scores as factors, largest first, and return the last one before the coverage becomes too low. */
static double find_factor(const fit *f, size_t left_out) {
    size_t n = f->n_materials - (left_out != nobody);
    double factor = 0;
    for (size_t g = 0; g < f->r->n_groups; ++g)
        f->inside[g] = f->count[g];
    for (size_t i = f->r->n; i-- > 0;) {
        size_t group = f->r->group[f->by_score[i].index];
        if (group == left_out)
            continue;
        if (f->by_score[i].value < factor && !suffices(f, left_out, n))
            return factor;
        factor = f->by_score[i].value;
        --f->inside[group]; /* with a smaller factor this pair is outside */
    }
    return factor;
}

/* ---- the growths -------------------------------------------------------------------------------------------------- */

/* A grid of growths: of the novelty, then of nqm_spread_features(). Those of features that are not known stay 0. */
enum { N_NOVELTY = 6, N_SPREAD = 3, N_GROWTHS = N_NOVELTY * N_SPREAD * N_SPREAD };
typedef struct growths {
    double novelty, spread[NQM_SPREAD_FEATURES];
} growths;

static growths growths_at(size_t i) {
    static const double novelty[N_NOVELTY] = {0, 0.5, 1, 2, 3, 4.5}, spread[N_SPREAD] = {0, 0.5, 1};
    return (growths){novelty[i % N_NOVELTY], {spread[i / N_NOVELTY % N_SPREAD], spread[i / N_NOVELTY / N_SPREAD]}};
}

static size_t growth_count(const fit *f) {
    return f->r->spread ? N_GROWTHS : f->r->novelty ? N_NOVELTY : 1;
}

/* The factor of step 5. */
static double times_of(const nqm_residuals *r, size_t i, const growths *g) {
    double sum = r->novelty ? g->novelty * r->novelty[i] : 0;
    for (size_t k = 0; r->spread && k < NQM_SPREAD_FEATURES; ++k)
        sum += g->spread[k] * r->spread[i * NQM_SPREAD_FEATURES + k];
    return exp(sum);
}

/* Compute all scores for one element of the grid, each with the scales of the other materials. */
static void find_scores(fit *f, size_t index) {
    const growths g_k = growths_at(index);
    for (size_t i = 0; i < f->r->n; ++i)
        f->times[i] = times_of(f->r, i, &g_k);
    for (size_t g = 0; g < f->r->n_groups; ++g) {
        if (!f->count[g])
            continue;
        scales s = find_scales(f, g);
        for (size_t i = 0; i < f->r->n; ++i) {
            if (f->r->group[i] != g)
                continue;
            double error = f->error[i] / f->times[i];
            f->up[i] = scale_at(&s, s.up, f->y[i]);
            f->down[i] = scale_at(&s, s.down, f->y[i]);
            f->score[i] = fmax(error / f->up[i], -error / f->down[i]);
        }
    }
    nqm_sort_indexed(f->r->n, f->score, f->by_score);
}

/* loss (n_groups) receives the mean interval score of each material, with the factor of the other materials. */
static void find_losses(fit *f, double *loss) {
    for (size_t g = 0; g < f->r->n_groups; ++g) {
        double factor = f->count[g] ? find_factor(f, g) : 0;
        loss[g] = 0;
        for (size_t i = 0; i < f->r->n; ++i) {
            if (f->r->group[i] != g)
                continue;
            double low = nqm_interval_jod(f->y[i] - factor * f->times[i] * f->down[i]);
            double high = nqm_interval_jod(f->y[i] + factor * f->times[i] * f->up[i]), label = f->r->label[i];
            double outside = fmax(0, low - label) + fmax(0, label - high);
            loss[g] += (high - low + 2 / (1 - level) * outside) / (double)f->count[g];
        }
    }
}

/* Index of the growths with the smallest total loss over all materials except `left_out`; loss (N_GROWTHS, n_groups). */
static size_t best_growth(const fit *f, const double *loss, size_t left_out) {
    size_t best = 0;
    double least = INFINITY;
    for (size_t k = 0; k < growth_count(f); ++k) {
        double sum = 0;
        for (size_t g = 0; g < f->r->n_groups; ++g)
            sum += g == left_out ? 0 : loss[k * f->r->n_groups + g];
        if (sum < least) {
            least = sum;
            best = k;
        }
    }
    return best;
}

/* ---- fit --------------------------------------------------------------------------------------------------------- */

static nqm_status make_room(fit *f, nqm_error *err) {
    const size_t n = f->r->n, n_groups = f->r->n_groups;
    return nqm_alloc_arrays(
        NQM_ARRAYS({&f->count, n_groups, sizeof *f->count}, {&f->inside, n_groups, sizeof *f->inside},
                   {&f->loss, n_groups, N_GROWTHS * sizeof *f->loss}, {&f->y, n, sizeof *f->y},
                   {&f->error, n, sizeof *f->error}, {&f->times, n, sizeof *f->times}, {&f->down, n, sizeof *f->down},
                   {&f->up, n, sizeof *f->up}, {&f->score, n, sizeof *f->score}, {&f->sorted, n, sizeof *f->sorted},
                   {&f->window, n, sizeof *f->window}, {&f->by_score, n, sizeof *f->by_score},
                   {&f->kept, n, sizeof *f->kept}),
        err);
}

static void prepare(fit *f) {
    for (size_t i = 0; i < f->r->n; ++i) {
        ++f->count[f->r->group[i]];
        f->y[i] = nqm_interval_y(f->r->predicted[i]);
        f->error[i] = nqm_interval_y(f->r->label[i]) - f->y[i];
    }
    nqm_sort_indexed(f->r->n, f->y, f->sorted);
    for (size_t k = 0; growth_count(f) > 1 && k < growth_count(f); ++k) {
        find_scores(f, k);
        find_losses(f, f->loss + k * f->r->n_groups);
    }
}

static void fill_table(const fit *f, double *table) {
    scales s = find_scales(f, nobody);
    double factor = find_factor(f, nobody);
    for (size_t k = 0; k < NQM_INTERVAL_ROWS; ++k) {
        double y = nqm_interval_y(jod_top) * (2 * (double)k / (NQM_INTERVAL_ROWS - 1) - 1), *row = table + 3 * k;
        row[0] = nqm_interval_jod(y);
        row[1] = fmin(row[0], nqm_interval_jod(y - factor * scale_at(&s, s.down, y)));
        row[2] = fmax(row[0], nqm_interval_jod(y + factor * scale_at(&s, s.up, y)));
    }
    for (size_t k = 1; k < NQM_INTERVAL_ROWS; ++k) /* make both ends monotonic by widening only */
        table[3 * k + 2] = fmax(table[3 * k + 2], table[3 * k - 1]);
    for (size_t k = NQM_INTERVAL_ROWS - 1; k-- > 0;)
        table[3 * k + 1] = fmin(table[3 * k + 1], table[3 * k + 4]);
}

void nqm_interval_find_floor(const nqm_residuals *r, double *least) {
    const double step = nqm_interval_knot(1) - nqm_interval_knot(0);
    for (size_t k = 0; k < NQM_INTERVAL_KNOTS; ++k) {
        const double y = nqm_interval_knot(k), jod = nqm_interval_jod(y);
        double total = 0, sum = 0; /* pairs within one step, the nearer the more */
        for (size_t i = 0; i < r->n; ++i) {
            const double weight = fmax(0, 1 - fabs(nqm_interval_y(r->predicted[i]) - y) / step);
            total += weight;
            sum += weight * r->noise[i] * r->noise[i];
        }
        least[k] = fmax(total > 0 ? 1.96 * sqrt(sum / total) : 0,
                        nqm_interval_y(fmax(jod, least_jod)) - nqm_interval_y(fmax(0, jod - least_jod)));
    }
}

/* Coverage of each material with the growths and the factor that were fitted to the other materials. */
static void measure_materials(fit *f, nqm_calibration *report) {
    for (size_t k = 0; k < growth_count(f); ++k) {
        bool scored = false;
        for (size_t g = 0; g < f->r->n_groups; ++g) {
            if (!f->count[g] || best_growth(f, f->loss, g) != k)
                continue;
            if (!scored)
                find_scores(f, k);
            scored = true;
            double factor = find_factor(f, g), n_inside = 0;
            for (size_t i = 0; i < f->r->n; ++i)
                n_inside += f->r->group[i] == g && f->score[i] <= factor;
            double share = n_inside / (double)f->count[g];
            report->coverage += share / (double)f->n_materials;
            report->coverage_pairs += n_inside / (double)f->r->n;
            report->coverage_lowest = fmin(report->coverage_lowest, share);
        }
    }
}

static void measure_width(const fit *f, const double *table, nqm_calibration *report) {
    for (size_t i = 0; i < f->r->n; ++i) {
        double low, high;
        nqm_interval_at(NQM_INTERVAL_ROWS, table, f->r->predicted[i], &low, &high);
        if (f->times[i] > 1)
            nqm_interval_widen(f->times[i], f->r->predicted[i], &low, &high);
        report->mean_width += (high - low) / (double)f->r->n;
    }
}

nqm_status nqm_residuals_create(const nqm_dataset *d, size_t max_n, nqm_residuals *r, nqm_error *err) {
    *r = (nqm_residuals){.n_groups = d->n_groups};
    return nqm_alloc_arrays(NQM_ARRAYS({&r->predicted, max_n, sizeof *r->predicted},
                                       {&r->label, max_n, sizeof *r->label}, {&r->group, max_n, sizeof *r->group},
                                       {&r->novelty, max_n, sizeof *r->novelty},
                                       {&r->spread, max_n, NQM_SPREAD_FEATURES * sizeof *r->spread},
                                       {&r->noise, max_n, sizeof *r->noise}, {&r->pairs, max_n, sizeof *r->pairs}),
                            err);
}

/* The standard error of y of a label: half the difference between a Delta-E one standard error lower and higher. */
static double noise_of(const nqm_dataset *d, size_t pair) {
    const double e = d->delta_e_error ? d->delta_e_error[pair] : 0, delta_e = d->delta_e[pair];
    const double y[2] = {nqm_interval_y(nqm_curve_jod(&nqm_curve_published, delta_e - e)),
                         nqm_interval_y(nqm_curve_jod(&nqm_curve_published, delta_e + e))};
    return (y[0] - y[1]) / 2;
}

void nqm_residuals_add(nqm_residuals *r, const nqm_dataset *d, size_t pair, double predicted) {
    r->predicted[r->n] = predicted;
    r->label[r->n] = d->jod[pair];
    r->group[r->n] = d->ref_group[d->pair_ref[pair]];
    r->noise[r->n] = noise_of(d, pair);
    r->pairs[r->n++] = pair;
}

bool nqm_residuals_suffice(const nqm_residuals *r, size_t *n_materials_ret) {
    uint8_t *seen = nqm_alloc(r->n_groups, sizeof *seen);
    size_t n_materials = 0;
    for (size_t i = 0; seen && i < r->n; ++i) {
        n_materials += !seen[r->group[i]];
        seen[r->group[i]] = 1;
    }
    nqm_free(seen);
    if (n_materials_ret)
        *n_materials_ret = n_materials;
    return r->n >= NQM_CALIBRATION_MIN_PAIRS && n_materials >= NQM_CALIBRATION_MIN_MATERIALS;
}

nqm_status nqm_interval_fit(const nqm_residuals *residuals, double *table, nqm_calibration *report, nqm_error *err) {
    fit f = {.r = residuals};
    if (!nqm_residuals_suffice(residuals, &f.n_materials))
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "%zu pairs of %zu materials are too few for an interval: %d of %d are needed", residuals->n,
                        f.n_materials, NQM_CALIBRATION_MIN_PAIRS, NQM_CALIBRATION_MIN_MATERIALS);
    nqm_status status = make_room(&f, err);
    if (status == NQM_OK) {
        prepare(&f);
        *report = (nqm_calibration){.n_pairs = residuals->n, .n_materials = f.n_materials, .coverage_lowest = 1};
        measure_materials(&f, report);
        const size_t best = best_growth(&f, f.loss, nobody);
        const growths g = growths_at(best);
        report->novelty_growth = g.novelty;
        report->disagreement_growth = g.spread[NQM_SPREAD_DISAGREEMENT];
        report->peak_growth = g.spread[NQM_SPREAD_PEAK];
        find_scores(&f, best);
        fill_table(&f, table);
        measure_width(&f, table, report);
    }
    nqm_free(f.count);
    return status;
}
