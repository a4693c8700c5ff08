/* SPDX-License-Identifier: MIT
 *
 * The stages of the fit of a shading model: least squares from generic starts on a part of the directions, layers that help,
 * least squares on all directions, then the whole loss, and the removal of what does not matter.
 */
#include "fit/shading.h"
#include "math/math.h"

#include <math.h>
#include <stdlib.h>

/* ---- search ------------------------------------------------------------------------------------------------------- */

nqm_status nqm_shading_thin(const nqm_fit_target *from, size_t n, nqm_fit_target *thin, nqm_error *err) {
    const size_t stride = nqm_larger(from->n / n, 1);
    *thin = *from;
    thin->n = (from->n + stride - 1) / stride;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&thin->wi, thin->n, 3 * sizeof(double)}, {&thin->wo, thin->n, 3 * sizeof(double)},
                                    {&thin->weight, thin->n, sizeof(double)}, {&thin->rgb, thin->n, 3 * sizeof(double)},
                                    {&thin->goal, thin->n, 3 * sizeof(double)}),
                         err);
    for (size_t i = 0; status == NQM_OK && i < thin->n; ++i) {
        const size_t at = i * stride;
        thin->weight[i] = from->weight[at];
        memcpy(thin->wi + 3 * i, from->wi + 3 * at, 3 * sizeof(double));
        memcpy(thin->wo + 3 * i, from->wo + 3 * at, 3 * sizeof(double));
        memcpy(thin->rgb + 3 * i, from->rgb + 3 * at, 3 * sizeof(double));
        memcpy(thin->goal + 3 * i, from->goal + 3 * at, 3 * sizeof(double));
    }
    return status;
}

/* The albedo at normal incidence, and that of a Lambert BRDF with the median f_r. */
static nqm_status measure_albedos(const nqm_brdf *ref, const nqm_fit_target *target, double *diffuse, double *albedo,
                                  nqm_error *err) {
    double *values = nqm_alloc(target->n, sizeof *values);
    if (!values)
        return nqm_fail_nomem(err, target->n * sizeof *values);
    nqm_brdf_albedo(ref, 0, 1, albedo);
    for (size_t c = 0; c < 3; ++c) {
        for (size_t i = 0; i < target->n; ++i)
            values[i] = target->rgb[3 * i + c];
        diffuse[c] = fmin(NQM_PI * nqm_quantile(target->n, values, 0.5), 1);
        albedo[c] = isfinite(albedo[c]) ? albedo[c] : diffuse[c];
    }
    nqm_free(values);
    return NQM_OK;
}

static int compare_points(const void *a, const void *b) {
    const nqm_shading_point *x = a, *y = b;
    return x->loss != y->loss ? (x->loss > y->loss) - (x->loss < y->loss)
                              : (x->start > y->start) - (x->start < y->start);
}

/* The points to start from: that of the options first. */
static nqm_status make_starts(const nqm_shading_space *space, const nqm_brdf *ref, const nqm_fit_target *target,
                              const nqm_fit_options *options, bool only_start, nqm_shading_point *points, size_t *n,
                              nqm_error *err) {
    double diffuse[3], albedo[3];
    *n = 0;
    nqm_status status = NQM_OK;
    if (options->start)
        status = nqm_shading_read_spec(space, options->start, &points[(*n)++].values, err);
    if (status != NQM_OK || (options->start && only_start))
        return status;
    status = measure_albedos(ref, target, diffuse, albedo, err);
    for (size_t i = 0; status == NQM_OK && *n < NQM_SHADING_MAX_STARTS &&
                       nqm_shading_start(space, i, diffuse, albedo, &points[*n].values);
         ++i)
        ++*n;
    for (size_t i = 0; i < *n; ++i)
        points[i].start = i;
    return status;
}

static nqm_status refine_all(const nqm_shading_space *space, const nqm_fit_target *target, size_t n_steps,
                             nqm_ticker *ticker, nqm_shading_point *points, size_t n, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = nqm_shading_refine(space, target, n_steps, ticker, &points[i], err);
    if (status == NQM_OK)
        qsort(points, n, sizeof *points, compare_points);
    return status;
}

/* Begin each layer anew, over the base as it is and over a rougher one, and keep it if that lowers the loss clearly. */
static nqm_status try_layers(const nqm_shading_space *space, const nqm_fit_target *target, nqm_ticker *ticker,
                             nqm_shading_point *point, nqm_error *err) {
    enum { FIRST = 6, STEPS = 12 };
    const double clearly = 0.98, hopeless = 1.5;
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK; ++i) {
        nqm_shading_point with[2] = {*point, *point};
        if (!nqm_shading_add_layer(space, i, false, &with[0].values))
            break;
        nqm_shading_add_layer(space, i, true, &with[1].values);
        status = refine_all(space, target, FIRST, ticker, with, 2, err);
        if (status == NQM_OK && with->loss < hopeless * point->loss)
            status = nqm_shading_refine(space, target, STEPS, ticker, with, err);
        if (with->loss < clearly * point->loss)
            *point = *with;
    }
    return status;
}

nqm_status nqm_shading_search(const nqm_shading_space *space, const nqm_brdf *ref, const nqm_fit_target *target,
                              const nqm_fit_options *options, bool only_start, nqm_ticker *ticker,
                              nqm_shading_point *best, size_t *n_best, nqm_error *err) {
    enum { THIN = 1000, FIRST_STEPS = 6, STEPS = 25, MAX_KEPT = 2 };
    nqm_fit_target thin = {0};
    size_t n = 0;
    nqm_status status = make_starts(space, ref, target, options, only_start, best, &n, err);
    if (status == NQM_OK)
        status = nqm_shading_thin(target, THIN, &thin, err);
    if (status == NQM_OK && n > 1)
        status = refine_all(space, &thin, FIRST_STEPS, ticker, best, n, err);
    n = nqm_smaller(n, MAX_KEPT);
    if (status == NQM_OK)
        status = refine_all(space, &thin, STEPS, ticker, best, n, err);
    for (size_t i = 0; status == NQM_OK && !only_start && i < n; ++i)
        status = try_layers(space, &thin, ticker, &best[i], err);
    if (status == NQM_OK)
        status = refine_all(space, target, STEPS, ticker, best, n, err);
    nqm_free(thin.wi);
    *n_best = n;
    return status;
}

/* ---- removal of what does not matter ------------------------------------------------------------------------------ */

typedef struct simplification {
    nqm_shading_objective *objective;
    const nqm_fit_target *target; /* of its terms */
    nqm_shading_space space;      /* without the keys that have been decided */
    double budget;                /* of the loss */
    nqm_ticker *ticker;
    nqm_shading_point *point;
    nqm_error *err;
} simplification;

static bool has_value(const nqm_spec_values *values, size_t key, double v) {
    return values->v[key][0] == v && values->v[key][1] == v && values->v[key][2] == v;
}

/* Replace the point by one of least squares near it if that has the smaller loss: exact where keys make up for each other. */
static nqm_status adapt(const simplification *s, const nqm_shading_space *space, nqm_shading_point *point) {
    enum { N_STEPS = 3 };
    nqm_shading_point next = *point;
    nqm_status status = nqm_shading_refine(space, s->target, N_STEPS, s->ticker, &next, s->err);
    if (status == NQM_OK)
        status = nqm_shading_objective_value(s->objective, &next.values, &next.loss, s->err);
    if (status == NQM_OK && next.loss < point->loss)
        *point = next;
    return status;
}

/* Give a free key one value if the loss with the best values of the others stays within the budget. */
static nqm_status try_value(simplification *s, size_t key, double v) {
    enum { TRIAL_STEPS = 8 };
    nqm_shading_space without = s->space;
    nqm_shading_point next = *s->point;
    nqm_shading_fix(&without, key);
    if (without.n == s->space.n)
        return NQM_OK;
    for (size_t c = 0; c < 3; ++c)
        next.values.v[key][c] = v;
    nqm_status status = nqm_shading_objective_value(s->objective, &next.values, &next.loss, s->err);
    if (status == NQM_OK && next.loss > s->budget)
        status = adapt(s, &without, &next);
    if (status == NQM_OK && next.loss > s->budget)
        status = nqm_shading_descend(s->objective, &without, TRIAL_STEPS, s->ticker, &next, s->err);
    if (status == NQM_OK && next.loss <= s->budget) {
        *s->point = next;
        s->space = without;
    }
    return status;
}

/* Metals become 0 or 1; then defaults: of layers first, and of the last keys of the schema, which are extensions, before
 * others. */
static nqm_status try_all(simplification *s) {
    const nqm_spec_schema *schema = &s->space.model->schema;
    nqm_status status = NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < schema->n_keys; ++k)
        if (strstr(schema->keys[k].name, "metal"))
            status = try_value(s, k, round(s->point->values.v[k][0]));
    for (size_t i = 2 * schema->n_keys; status == NQM_OK && i-- > 0;) {
        const size_t k = i % schema->n_keys;
        const nqm_spec_key *key = &schema->keys[k];
        const bool is_first = i >= schema->n_keys;
        if (is_first == nqm_shading_is_layer(key) && !key->required && !has_value(&s->point->values, k, key->fallback))
            status = try_value(s, k, key->fallback);
    }
    return status;
}

nqm_status nqm_shading_simplify(nqm_shading_objective *thin, const nqm_fit_target *target, nqm_shading_space *space,
                                double tolerance, nqm_ticker *ticker, nqm_shading_point *point, nqm_error *err) {
    const double share_of_black = 0.05; /* exact fits have no loss to compare with */
    double black;
    simplification s = {
        .objective = thin, .target = target, .space = *space, .ticker = ticker, .point = point, .err = err};
    if (tolerance <= 0)
        return NQM_OK;
    nqm_status status = nqm_shading_objective_black(thin, &black, err);
    if (status == NQM_OK)
        status = nqm_shading_objective_value(thin, &point->values, &point->loss, err);
    s.budget = point->loss + tolerance * (point->loss + share_of_black * black);
    if (status == NQM_OK)
        status = try_all(&s);
    *space = s.space;
    return status;
}

nqm_status nqm_shading_finish(const nqm_shading_space *full, const nqm_fit_target *target, size_t n_terms,
                              const nqm_fit_term *terms, nqm_shading_objective *objective, double tolerance,
                              nqm_ticker *ticker, nqm_shading_point *point, nqm_error *err) {
    enum { THIN = 600 };
    nqm_shading_space space = *full;
    nqm_fit_target thin_target = {0};
    nqm_shading_objective *thin = NULL;
    nqm_status status = nqm_shading_thin(target, THIN, &thin_target, err);
    if (status == NQM_OK)
        status = nqm_shading_objective_make(&space, &thin_target, n_terms, terms, &thin, err);
    if (status == NQM_OK)
        status = nqm_shading_simplify(thin, &thin_target, &space, tolerance, ticker, point, err);
    if (status == NQM_OK)
        status = nqm_shading_descend(objective, &space, NQM_SHADING_STEPS, ticker, point, err);
    nqm_shading_objective_free(thin);
    nqm_free(thin_target.wi);
    return status;
}

/* ---- the whole fit ------------------------------------------------------------------------------------------------ */

nqm_status nqm_shading_report(const nqm_shading_space *space, nqm_shading_objective *o, size_t n_directions,
                              nqm_shading_point *point, nqm_fit_report *report, nqm_error *err) {
    report->n_directions = n_directions;
    report->best_start = point->start;
    report->n_numbers = space->n;
    nqm_status status = nqm_shading_write_spec(space, &point->values, report->spec, sizeof report->spec, err);
    return status == NQM_OK ? nqm_shading_objective_value(o, &point->values, &report->loss, err) : status;
}

/* From the results of the search to the best under the whole loss, first. */
static nqm_status descend_all(const nqm_shading_space *space, nqm_shading_objective *o, nqm_ticker *ticker, size_t n,
                              nqm_shading_point *points, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = nqm_shading_descend(o, space, NQM_SHADING_STEPS, ticker, &points[i], err);
    if (status == NQM_OK)
        qsort(points, n, sizeof *points, compare_points);
    return status;
}

nqm_status nqm_fit_shading_model(const nqm_brdf *ref, const nqm_fit_entry *entry, const nqm_fit_options *options,
                                 nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_ticker ticker = {.fn = options->progress, .user = options->progress_user};
    nqm_shading_space space;
    nqm_fit_options first = *options;
    nqm_fit_target target = {0};
    nqm_shading_objective *objective = NULL;
    nqm_shading_point points[NQM_SHADING_MAX_STARTS] = {{.loss = 0}};
    const nqm_fit_term only = {.weight = 1, .loss = options->loss};
    const nqm_fit_term *terms = options->n_terms ? options->terms : &only;
    size_t n = 0, n_terms = nqm_larger(options->n_terms, 1);
    first.loss = nqm_fit_first_loss(options);
    nqm_status status = nqm_shading_space_make(entry->shading, options, &space, err);
    if (status == NQM_OK)
        status = nqm_fit_target_make(ref, &first, &target, err);
    if (status == NQM_OK)
        status = nqm_shading_objective_make(&space, &target, n_terms, terms, &objective, err);
    if (status == NQM_OK)
        status = nqm_shading_search(&space, ref, &target, options, options->start != NULL, &ticker, points, &n, err);
    if (status == NQM_OK)
        status = descend_all(&space, objective, &ticker, n, points, err);
    if (status == NQM_OK)
        status =
            nqm_shading_finish(&space, &target, n_terms, terms, objective, options->simplify, &ticker, points, err);
    if (status == NQM_OK)
        status = nqm_shading_report(&space, objective, target.n, points, report, err);
    if (status == NQM_OK)
        status = nqm_brdf_open(report->spec, brdf_ret, err);
    nqm_shading_objective_free(objective);
    nqm_free(target.wi);
    return status;
}
