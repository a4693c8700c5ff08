/* SPDX-License-Identifier: MIT
 *
 * Our labels beside somebody else's for the same pairs: by rank, encoding by encoding, with what trivial predictors reach.
 */
#include "base/base.h"
#include "brdf/brdf.h"
#include "io/io.h"
#include "judge/agreement.h"
#include "math/math.h"

#include <math.h>
#include <nqm/label.h>
#include <string.h>

enum { N_BOOTSTRAP = 2000 };

/* One row of the file. Strings are lent by the CSV. */
typedef struct pair {
    const char *reference, *encoding;
    double theirs, ours, luminance; /* luminance: mean over the picture of the reference */
} pair;

typedef struct comparing {
    const nqm_csv *csv;
    const char *path, *root;
    const nqm_scene *scene;
    const nqm_fit_options *fit;
    int reference, test, encoding, delta_e; /* columns */
    size_t n;
    pair *pairs;                /* (n) */
    double *ref_rgb, *test_rgb; /* (n_points, 3) */
    double *x, *y;              /* (n) scratch */
    nqm_brdf *ref;              /* of the row at hand */
    nqm_error *err;
} comparing;

/* ---- our labels -------------------------------------------------------------------------------------------------- */

static nqm_status take_reference(comparing *c, size_t row) {
    nqm_brdf_free(c->ref);
    nqm_status status = nqm_brdf_open_below(c->pairs[row].reference, c->root, &c->ref, c->err);
    return status == NQM_OK ? nqm_scene_render(c->scene, c->ref, c->ref_rgb, c->err) : status;
}

static double mean_luminance(const comparing *c) {
    size_t n = nqm_scene_count(c->scene);
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += nqm_luminance(c->ref_rgb + 3 * i);
    return sum / (double)n;
}

static nqm_status label_row(comparing *c, size_t row) {
    pair *p = &c->pairs[row];
    const char *test_name = nqm_csv_text(c->csv, row, c->test);
    nqm_brdf *test = NULL;
    nqm_fit_report report;
    nqm_status status = NQM_OK;
    if (row == 0 || strcmp(p->reference, c->pairs[row - 1].reference) != 0)
        status = take_reference(c, row);
    if (status == NQM_OK)
        status = strcmp(test_name, "fit") == 0 ? nqm_fit(c->ref, p->encoding, c->fit, &report, &test, c->err)
                                               : nqm_brdf_open_below(test_name, c->root, &test, c->err);
    if (status == NQM_OK)
        status = nqm_scene_render(c->scene, test, c->test_rgb, c->err);
    if (status == NQM_OK) {
        p->ours = nqm_scene_delta_e(c->scene, c->ref_rgb, c->test_rgb);
        p->luminance = mean_luminance(c);
    }
    nqm_brdf_free(test);
    return status;
}

/* ---- figures ----------------------------------------------------------------------------------------------------- */

/* Spearman and its interval; each pair is a group of its own. */
static nqm_status correlate(const comparing *c, size_t n, nqm_compare_row *row) {
    size_t *begin = nqm_alloc(n + 1, sizeof *begin);
    nqm_agreement result;
    if (!begin)
        return nqm_fail_nomem(c->err, (n + 1) * sizeof *begin);
    for (size_t i = 0; i <= n; ++i)
        begin[i] = i;
    const nqm_judgement judgement = {
        .n = n, .n_groups = n, .n_predictors = 1, .group_begin = begin, .label = c->y, .prediction = c->x};
    nqm_status status = nqm_judge(&judgement, N_BOOTSTRAP, 1, &result, c->err);
    if (status == NQM_OK) {
        row->spearman = result.spearman;
        memcpy(row->spearman_ci95, result.spearman_ci95, sizeof row->spearman_ci95);
    }
    nqm_free(begin);
    return status;
}

/* The row of an encoding; NULL: of all pairs. */
static nqm_status summarise(const comparing *c, const char *encoding, nqm_compare_row *row) {
    size_t n = 0;
    *row = (nqm_compare_row){0};
    snprintf(row->encoding, sizeof row->encoding, "%s", encoding ? encoding : "all");
    for (size_t i = 0; i < c->n; ++i)
        if (!encoding || strcmp(c->pairs[i].encoding, encoding) == 0) {
            c->x[n] = c->pairs[i].luminance;
            c->y[n++] = c->pairs[i].theirs;
        }
    row->n = n;
    row->null_luminance = nqm_spearman(n, c->x, c->y);
    n = 0;
    for (size_t i = 0; i < c->n; ++i)
        if (!encoding || strcmp(c->pairs[i].encoding, encoding) == 0)
            c->x[n++] = c->pairs[i].ours;
    nqm_status status = correlate(c, n, row);
    if (status != NQM_OK)
        return status;
    row->median_ours = nqm_quantile(n, c->x, 0.5);
    row->median_theirs = nqm_quantile(n, c->y, 0.5);
    n = 0;
    for (size_t i = 0; i < c->n; ++i)
        if ((!encoding || strcmp(c->pairs[i].encoding, encoding) == 0) && c->pairs[i].theirs > 0)
            c->x[n++] = c->pairs[i].ours / c->pairs[i].theirs;
    row->median_ratio = n ? nqm_quantile(n, c->x, 0.5) : NAN;
    return NQM_OK;
}

/* What the name of the encoding says: the median of theirs over the other references with it. */
static double encoding_null(const comparing *c) {
    double *value = c->x;
    for (size_t i = 0; i < c->n; ++i) {
        size_t n = 0;
        for (size_t j = 0; j < c->n; ++j)
            if (j != i && strcmp(c->pairs[j].encoding, c->pairs[i].encoding) == 0)
                c->y[n++] = c->pairs[j].theirs;
        value[i] = n ? nqm_quantile(n, c->y, 0.5) : 0;
    }
    for (size_t i = 0; i < c->n; ++i)
        c->y[i] = c->pairs[i].theirs;
    return nqm_spearman(c->n, value, c->y);
}

static const pair *find_pair(const comparing *c, const char *reference, const char *encoding) {
    for (size_t i = 0; i < c->n; ++i)
        if (strcmp(c->pairs[i].reference, reference) == 0 && strcmp(c->pairs[i].encoding, encoding) == 0)
            return &c->pairs[i];
    return NULL;
}

static void count_order(const comparing *c, nqm_comparison *result) {
    for (size_t i = 0; i < c->n; ++i) {
        const pair *nbrdf = &c->pairs[i], *ward = find_pair(c, nbrdf->reference, "ward"),
                   *ggx = find_pair(c, nbrdf->reference, "ggx");
        if (strcmp(nbrdf->encoding, "nbrdf") != 0 || !ward || !ggx)
            continue;
        ++result->n_triples;
        result->n_ordered += nbrdf->ours < fmin(ward->ours, ggx->ours);
        result->n_ordered_theirs += nbrdf->theirs < fmin(ward->theirs, ggx->theirs);
    }
}

static nqm_status compare(const comparing *c, nqm_comparison *result) {
    nqm_status status = summarise(c, NULL, &result->pooled);
    for (size_t i = 0; status == NQM_OK && i < c->n; ++i) {
        size_t e = 0;
        while (e < result->n_encodings && strcmp(result->rows[e].encoding, c->pairs[i].encoding) != 0)
            ++e;
        if (e < result->n_encodings)
            continue;
        if (e == NQM_COMPARE_MAX_ENCODINGS)
            return nqm_fail(c->err, NQM_ERR_LIMIT, -1, "%s: more than %d encodings", c->path,
                            (int)NQM_COMPARE_MAX_ENCODINGS);
        status = summarise(c, c->pairs[i].encoding, &result->rows[e]);
        result->n_encodings = e + 1;
    }
    result->pooled_null_encoding = encoding_null(c);
    count_order(c, result);
    return status;
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

static nqm_status find_columns(comparing *c) {
    const struct {
        const char *name;
        int *column;
    } wanted[] = {
        {"reference", &c->reference}, {"test", &c->test}, {"encoding", &c->encoding}, {"delta_e", &c->delta_e}};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; ++i) {
        *wanted[i].column = nqm_csv_column(c->csv, wanted[i].name);
        if (*wanted[i].column < 0)
            return nqm_fail(c->err, NQM_ERR_FORMAT, 0, "%s: the header has no column %s", c->path, wanted[i].name);
    }
    return NQM_OK;
}

static nqm_status read_pairs(comparing *c) {
    nqm_status status = find_columns(c);
    if (status != NQM_OK)
        return status;
    c->n = nqm_csv_rows(c->csv);
    if (c->n < 2)
        return nqm_fail(c->err, NQM_ERR_INCOMPATIBLE, -1, "%s: a comparison needs 2 pairs or more", c->path);
    size_t n_points = nqm_scene_count(c->scene);
    c->pairs = nqm_alloc(c->n, sizeof *c->pairs);
    c->x = nqm_alloc(c->n, sizeof *c->x);
    c->y = nqm_alloc(c->n, sizeof *c->y);
    c->ref_rgb = nqm_alloc(n_points, 3 * sizeof *c->ref_rgb);
    c->test_rgb = nqm_alloc(n_points, 3 * sizeof *c->test_rgb);
    if (!c->pairs || !c->x || !c->y || !c->ref_rgb || !c->test_rgb)
        return nqm_fail_nomem(c->err, n_points * 6 * sizeof(double));
    for (size_t i = 0; status == NQM_OK && i < c->n; ++i) {
        c->pairs[i].reference = nqm_csv_text(c->csv, i, c->reference);
        c->pairs[i].encoding = nqm_csv_text(c->csv, i, c->encoding);
        if (strlen(c->pairs[i].encoding) >= sizeof((nqm_compare_row *)0)->encoding)
            return nqm_fail(c->err, NQM_ERR_LIMIT, -1, "%s: the encoding's name '%.40s...' is too long", c->path,
                            c->pairs[i].encoding);
        status = nqm_csv_number(c->csv, i, c->delta_e, &c->pairs[i].theirs, c->err);
    }
    return status;
}

nqm_status nqm_compare_labels(const char *pairs_csv, const char *root, const nqm_scene *scene,
                              const nqm_fit_options *fit, nqm_progress_fn progress, void *progress_user,
                              nqm_comparison *comparison_ret, nqm_error *err) {
    nqm_csv *csv;
    nqm_comparison result = {0};
    nqm_status status = nqm_csv_load(pairs_csv, &csv, err);
    if (status != NQM_OK)
        return status;
    comparing c = {.csv = csv, .path = pairs_csv, .root = root, .scene = scene, .fit = fit, .err = err};
    status = read_pairs(&c);
    for (size_t i = 0; status == NQM_OK && i < c.n; ++i) {
        status = label_row(&c, i);
        if (status == NQM_OK && progress && progress(progress_user, "compare", (double)(i + 1), (double)c.n) != 0)
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    }
    if (status == NQM_OK)
        status = compare(&c, &result);
    if (status == NQM_OK)
        *comparison_ret = result;
    nqm_brdf_free(c.ref);
    nqm_free(c.pairs);
    nqm_free(c.x);
    nqm_free(c.y);
    nqm_free(c.ref_rgb);
    nqm_free(c.test_rgb);
    nqm_csv_free(csv);
    return status;
}
