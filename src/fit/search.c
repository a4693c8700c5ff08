/* SPDX-License-Identifier: MIT
 *
 * The first stage of a fit: least squares from the starts of the model, of shading models on a part of the directions and with
 * layers that help; and random values.
 */
#include "fit/fit.h"
#include "math/math.h"

#include <math.h>
#include <stdlib.h>

/* ---- refinement --------------------------------------------------------------------------------------------------- */

static int compare_points(const void *a, const void *b) {
    const nqm_fit_point *x = a, *y = b;
    return x->loss != y->loss ? (x->loss > y->loss) - (x->loss < y->loss)
                              : (x->start > y->start) - (x->start < y->start);
}

static nqm_status refine_all(nqm_fit_run *run, const nqm_fit_target *target, size_t n_steps, nqm_fit_point *points,
                             size_t n) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = nqm_fit_refine(&run->space, target, n_steps, &run->ticker, &points[i], run->err);
    if (status == NQM_OK)
        qsort(points, n, sizeof *points, compare_points);
    return status;
}

/* Begin each layer anew, over the base as it is and over a rougher one, and keep it if that lowers the loss clearly. */
static nqm_status try_layers(nqm_fit_run *run, const nqm_fit_target *target, nqm_fit_point *point) {
    enum { FIRST = 6, STEPS = 12 };
    const double clearly = 0.99, hopeless = 1.5;
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK; ++i) {
        nqm_fit_point with[2] = {*point, *point};
        if (!nqm_fit_add_layer(&run->space, i, false, &with[0].values))
            break;
        nqm_fit_add_layer(&run->space, i, true, &with[1].values);
        status = refine_all(run, target, FIRST, with, 2);
        if (status == NQM_OK && with->loss < hopeless * point->loss)
            status = nqm_fit_refine(&run->space, target, STEPS, &run->ticker, with, run->err);
        if (with->loss < clearly * point->loss)
            *point = *with;
    }
    return status;
}

/* ---- starts ------------------------------------------------------------------------------------------------------- */

/* The albedo at normal incidence, and that of a Lambert BRDF with the median f_r. */
nqm_status nqm_fit_measure_albedos(const nqm_brdf *ref, const nqm_fit_target *target, double *diffuse, double *albedo,
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

/* Insert a point into the sorted list of the n_max with the smallest losses. */
static void insert(nqm_fit_point *best, size_t *n, size_t n_max, const nqm_fit_point *point) {
    size_t at = *n;
    while (at > 0 && best[at - 1].loss > point->loss)
        --at;
    if (at == n_max)
        return;
    memmove(best + at + 1, best + at, (nqm_smaller(*n, n_max - 1) - at) * sizeof *best);
    best[at] = *point;
    *n = nqm_smaller(*n + 1, n_max);
}

/* Number of starts that are refined: more if those of an analytic model differ in more than the width; of shading
 * models all, of which two are kept. */
static size_t n_kept(const nqm_fit_entry *entry) {
    return entry->n_start > 2 || entry->n_shape == 0 ? NQM_FIT_MAX_POINTS : 2;
}

/* Of shading models, the best of the dielectric and of the metallic starts: few directions do not tell mirrors apart. */
static void keep_both(nqm_fit_point *points, size_t *n, size_t first_metal) {
    size_t k = 1;
    while (k < *n && (points[k].start >= first_metal) == (points->start >= first_metal))
        ++k;
    if (k < *n)
        points[1] = points[k];
    *n = nqm_smaller(*n, 2);
}

/* The best of the starts: analytic models with the best albedos, shading models after a few steps. */
static nqm_status scan_starts(nqm_fit_run *run, const nqm_fit_target *target, nqm_fit_point *points, size_t *n) {
    enum { FIRST_STEPS = 6 };
    const bool is_analytic = run->space.entry->n_shape > 0;
    const size_t n_given = run->options->start != NULL;
    double diffuse[3], albedo[3];
    nqm_status status =
        is_analytic ? NQM_OK : nqm_fit_measure_albedos(run->ref, &run->target, diffuse, albedo, run->err);
    *n = 0;
    for (size_t i = 0; status == NQM_OK; ++i) {
        nqm_fit_point point = {.start = i};
        if (i < n_given)
            status = nqm_fit_read_spec(&run->space, run->options->start, &point.values, run->err);
        else if (!nqm_fit_start(&run->space, i - n_given, run->options->n_starts, diffuse, albedo, &point.values))
            break;
        else if (is_analytic)
            status = nqm_fit_solve_albedos(&run->space, target, &point.values, run->err);
        if (status == NQM_OK)
            status = nqm_fit_refine(&run->space, target, is_analytic ? 0 : FIRST_STEPS, &run->ticker, &point, run->err);
        if (status == NQM_OK)
            insert(points, n, n_kept(run->space.entry), &point);
    }
    if (!is_analytic)
        keep_both(points, n, n_given + NQM_FIT_N_WIDTHS);
    return status;
}

nqm_status nqm_fit_search(nqm_fit_run *run, nqm_fit_point *points, size_t *n) {
    enum { THIN = 1000, STEPS = 25 };
    const bool is_analytic = run->space.entry->n_shape > 0;
    nqm_fit_target thin = {0};
    nqm_status status = nqm_fit_target_thin(&run->target, is_analytic ? run->target.n : THIN, &thin, run->err);
    if (status == NQM_OK)
        status = scan_starts(run, &thin, points, n);
    if (status == NQM_OK)
        status = refine_all(run, &thin, STEPS, points, *n);
    for (size_t i = 0; status == NQM_OK && i < *n; ++i)
        status = try_layers(run, &thin, &points[i]);
    if (status == NQM_OK)
        status = refine_all(run, &run->target, STEPS, points, *n);
    nqm_free(thin.wi);
    return status;
}

/* ---- random values ------------------------------------------------------------------------------------------------ */

/* Albedos times random factors in [1/20, 20]. */
static void scatter_albedos(const nqm_fit_space *space, nqm_rng *rng, const char *name, nqm_values *values) {
    const size_t key = nqm_schema_key_named(space->model->schema, name, strlen(name));
    double albedo[3];
    for (size_t c = 0; c < 3; ++c)
        albedo[c] = fmax(values->v[key][c], 1e-3) * pow(20, 2 * nqm_rng_uniform(rng) - 1);
    nqm_fit_set(space, values, key, albedo);
}

nqm_status nqm_fit_random(const nqm_fit_space *space, const nqm_fit_target *target, nqm_rng *rng, nqm_values *values,
                          nqm_error *err) {
    double x[NQM_FIT_MAX_FREE], low[NQM_FIT_MAX_FREE], high[NQM_FIT_MAX_FREE];
    *values = space->defaults;
    nqm_fit_coordinates(space, values, x);
    nqm_fit_bounds(space, low, high);
    for (size_t i = 0; i < space->n; ++i)
        if (nqm_fit_find_shape(space->entry, space->model->schema->keys[space->parameters[i].key].name))
            x[i] = low[i] + (high[i] - low[i]) * nqm_rng_uniform(rng);
    nqm_fit_values(space, x, values);
    nqm_status status = nqm_fit_solve_albedos(space, target, values, err);
    if (status == NQM_OK) {
        scatter_albedos(space, rng, "kd", values);
        scatter_albedos(space, rng, "ks", values);
    }
    return status;
}
