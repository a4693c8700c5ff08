/* SPDX-License-Identifier: MIT
 *
 * Pairs with an anisotropic BRDF. The directions of the models "default" and "transport" have one azimuth, which is
 * enough for isotropic BRDFs; the model "anisotropic" makes small pictures of any BRDF (metric/slopes.c). So the former
 * hand such pairs to the latter; where the anisotropy is slight, the score is between both, and continuous.
 */
#include "metric/azimuths.h"
#include "brdf/brdf.h"

#include <math.h>
#include <string.h>

/* Anisotropy (nqm_brdf_check_report) from which on a pair has the score of "anisotropic" alone. */
static const double plain_anisotropy = 0.02;

struct nqm_azimuths {
    const nqm_model *model;
    nqm_model *owned; /* NULL: the model is the scorer's */
    float *totals;
};

/* Whether the model is a built-in one of the standard scenes, or its file: those of other scenes may have the same id. */
static nqm_status find_served(const nqm_model *model, bool *is_served, nqm_error *err) {
    static const char *const served[] = {"default", "transport"};
    nqm_status status = NQM_OK;
    *is_served = model->slopes;
    for (size_t i = 0; status == NQM_OK && i < sizeof served / sizeof *served; ++i) {
        nqm_model *builtin;
        if (strcmp(model->id, served[i]) != 0)
            continue;
        status = nqm_model_builtin(served[i], &builtin, err);
        *is_served = status == NQM_OK && strcmp(model->sha256, builtin->sha256) == 0;
        nqm_model_free(builtin);
    }
    return status;
}

nqm_status nqm_azimuths_create(const nqm_model *model, nqm_azimuths **azimuths_ret, nqm_error *err) {
    bool is_served;
    *azimuths_ret = NULL;
    nqm_status status = find_served(model, &is_served, err);
    if (status != NQM_OK || !is_served)
        return status;
    nqm_azimuths *a = nqm_alloc(1, sizeof *a);
    status = a ? NQM_OK : nqm_fail_nomem(err, sizeof *a);
    if (status == NQM_OK && !model->slopes)
        status = nqm_model_builtin("anisotropic", &a->owned, err);
    if (status == NQM_OK) {
        a->model = a->owned ? a->owned : model;
        a->totals = nqm_alloc(a->model->n_slope_points, 3 * sizeof *a->totals);
        status = a->totals ? NQM_OK : nqm_fail_nomem(err, 3 * a->model->n_slope_points * sizeof *a->totals);
    }
    if (status == NQM_OK) {
        nqm_azimuths_totals(a->model, a->totals);
        *azimuths_ret = a;
    } else {
        nqm_azimuths_free(a);
    }
    return status;
}

void nqm_azimuths_free(nqm_azimuths *azimuths) {
    if (!azimuths)
        return;
    nqm_model_free(azimuths->owned);
    nqm_free(azimuths->totals);
    nqm_free(azimuths);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* A BRDF of the pairs, by its name or opened. */
typedef struct subject {
    const char *name; /* NULL: */
    const nqm_brdf *brdf;
    nqm_brdf *opened;
    size_t beside; /* subject with which it is compared, a reference; SIZE_MAX: it is one */
    nqm_lobe lobe; /* zeroed without a BRDF: like none */
    double *itp;   /* its picture (3, n_points) */
    nqm_status status;
} subject;

typedef struct gallery {
    const nqm_azimuths *azimuths;
    bool is_light; /* cd/m2 is wanted, not ITP */
    size_t n;
    subject *subjects;
} gallery;

static size_t find(gallery *g, const char *name, const nqm_brdf *brdf, size_t beside) {
    for (size_t i = 0; i < g->n; ++i)
        if (g->subjects[i].beside == beside &&
            (name ? strcmp(g->subjects[i].name, name) == 0 : g->subjects[i].brdf == brdf))
            return i;
    g->subjects[g->n] = (subject){.name = name, .brdf = brdf, .beside = beside};
    return g->n++;
}

static nqm_picture_points points_of(const nqm_azimuths *a) {
    return (nqm_picture_points){a->model->n_slope_points, a->model->slope_points};
}

/* Whether half vectors for one lobe suit the other, too: sizes and distance within a third. With the same ones the sun
 * falls to the same ones, so that BRDFs which hardly differ have pictures that do. */
static bool is_like(const nqm_lobe *a, const nqm_lobe *b) {
    static const double most = 0.3;
    const double apart = hypot(a->center[0] - b->center[0], a->center[1] - b->center[1]);
    double turned = 0; /* of axes times its transpose: a round lobe has no direction */
    for (size_t i = 0; i < 2; ++i)
        for (size_t j = 0; j < 2; ++j)
            turned = fmax(turned, fabs(a->axes[2 * i] * a->axes[2 * j] + a->axes[2 * i + 1] * a->axes[2 * j + 1] -
                                       b->axes[2 * i] * b->axes[2 * j] - b->axes[2 * i + 1] * b->axes[2 * j + 1]));
    return fabs(log(a->width / b->width)) < most && apart < most * a->width && turned < most;
}

static void measure(void *user, size_t i) {
    subject *s = &((const gallery *)user)->subjects[i];
    if (s->name)
        s->status = nqm_brdf_open(s->name, &s->opened, NULL);
    s->brdf = s->name ? s->opened : s->brdf;
    if (s->status == NQM_OK)
        s->lobe = nqm_lobe_measure(s->brdf);
}

static void show(void *user, size_t i) {
    const gallery *g = user;
    const nqm_picture_points points = points_of(g->azimuths);
    subject *s = &g->subjects[i];
    const subject *ref = s->beside == SIZE_MAX ? s : &g->subjects[s->beside];
    const nqm_lobe *lobe = is_like(&ref->lobe, &s->lobe) ? &ref->lobe : &s->lobe;
    if (s->status == NQM_OK && !nqm_azimuths_light(g->azimuths->model, g->azimuths->totals, s->brdf, lobe, s->itp))
        s->status = NQM_ERR_NOMEM;
    if (s->status == NQM_OK && !g->is_light)
        nqm_picture_show(&points, s->itp, s->itp);
}

/* Make the pictures of all subjects; false: cancelled. */
static bool show_all(gallery *g, nqm_ticker *ticker) {
    nqm_parallel_for(g->n, measure, g);
    const bool is_stopped = nqm_parallel_ticking(ticker, "far", g->n, show, g);
    for (size_t i = 0; i < g->n; ++i)
        nqm_brdf_free(g->subjects[i].opened);
    return !is_stopped;
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/* 0 for 0, 1 from plain_anisotropy on; smooth. */
static double weight_of(double anisotropy) {
    const double t = fmin(anisotropy / plain_anisotropy, 1);
    return t * t * (3 - 2 * t);
}

/* The result keeps the metrics and counts of the model's own directions; people's similarity is not known. */
static void take(const nqm_azimuths *a, const nqm_label *label, nqm_score_result *r) {
    const double w = a->owned ? weight_of(r->anisotropy) : 1, jod = nqm_curve_jod(&a->model->curve, label->delta_e);
    double low, high;
    nqm_label mean = {.delta_e = 0};
    r->identical = r->identical && label->delta_e == 0;
    nqm_model_interval(a->model, jod, NAN, 0, &low, &high);
    if (r->identical)
        low = high = 10;
    nqm_label_add(&mean, w, label);
    if (w < 1) { /* 0 NaN is NaN */
        nqm_label_add(&mean, 1 - w, &r->parts);
        low = w * low + (1 - w) * r->jod_low;
        high = w * high + (1 - w) * r->jod_high;
    }
    r->delta_e = w < 1 ? w * label->delta_e + (1 - w) * r->delta_e : label->delta_e;
    r->jod = w < 1 ? w * jod + (1 - w) * r->jod : jod;
    r->jod_low = low;
    r->jod_high = high;
    r->parts = mean;
    r->novelty = r->similarity[0] = r->similarity[1] = r->similarity[2] = NAN;
}

bool nqm_azimuths_needed(const nqm_model *model, const nqm_score_result *r) {
    return r->status == NQM_OK && (r->anisotropy > 0 || model->slopes);
}

nqm_status nqm_azimuths_score(const nqm_azimuths *a, size_t n, const nqm_azimuth_pairs *pairs, const nqm_model *model,
                              nqm_score_result *results, nqm_error *err) {
    if (!a) {
        for (size_t i = 0; i < n; ++i)
            if (nqm_azimuths_needed(model, &results[i])) {
                const double anisotropy = results[i].anisotropy;
                results[i] = nqm_no_score(NQM_ERR_INCOMPATIBLE);
                results[i].anisotropy = anisotropy;
            }
        return NQM_OK;
    }
    const size_t n_values = 3 * a->model->n_slope_points;
    size_t place[NQM_SCORE_BLOCK][2];
    gallery g = {.azimuths = a};
    double *itp;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&g.subjects, 2 * n, sizeof *g.subjects}, {&itp, 2 * n, n_values * sizeof *itp}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n; ++i)
        if (nqm_azimuths_needed(model, &results[i])) {
            const nqm_named_pair *named = pairs->named ? &pairs->named[i] : NULL;
            place[i][0] = find(&g, named ? named->ref : NULL, pairs->ref, SIZE_MAX);
            place[i][1] = find(&g, named ? named->test : NULL, named ? NULL : pairs->tests[i], place[i][0]);
        }
    for (size_t i = 0; i < g.n; ++i)
        g.subjects[i].itp = itp + i * n_values;
    (void)show_all(&g, NULL);
    for (size_t i = 0; i < n; ++i) {
        if (!nqm_azimuths_needed(model, &results[i]))
            continue;
        const subject *ref = &g.subjects[place[i][0]], *test = &g.subjects[place[i][1]];
        const nqm_picture_points points = points_of(a);
        if (ref->status != NQM_OK || test->status != NQM_OK) {
            results[i] = nqm_no_score(ref->status != NQM_OK ? ref->status : test->status);
        } else {
            const nqm_label label = nqm_picture_label(&points, ref->itp, test->itp);
            take(a, &label, &results[i]);
        }
    }
    nqm_free(g.subjects);
    return NQM_OK;
}

/* ---- means ------------------------------------------------------------------------------------------------------- */

/* The label of the means over every `step`-th member from `first` on. subjects: (2 n) references, then tests; mean (2,
 * 3, n_points) is workspace. */
static nqm_label label_means(const gallery *g, const double *weights, size_t first, size_t step, double *mean) {
    const nqm_picture_points points = points_of(g->azimuths);
    const size_t n = g->n / 2, n_values = 3 * points.n;
    double sum = 0;
    memset(mean, 0, 2 * n_values * sizeof *mean);
    for (size_t i = first; i < n; i += step)
        sum += weights[i];
    for (size_t s = 0; s < 2; ++s, mean += n_values) {
        for (size_t i = first; i < n; i += step)
            for (size_t k = 0; k < n_values; ++k)
                mean[k] += weights[i] / sum * g->subjects[s * n + i].itp[k];
        nqm_picture_show(&points, mean, mean);
    }
    return nqm_picture_label(&points, mean - 2 * n_values, mean - n_values);
}

/* Few members differ more than the means over all would: the square of their Delta-E has a part that is inverse to
 * their number, which the halves show. */
static nqm_label label_all(const gallery *g, const double *weights, double *mean) {
    nqm_label label = label_means(g, weights, 0, 1, mean);
    if (g->n < 4)
        return label;
    const nqm_label half[2] = {label_means(g, weights, 0, 2, mean), label_means(g, weights, 1, 2, mean)};
    const double of_halves = (half[0].delta_e * half[0].delta_e + half[1].delta_e * half[1].delta_e) / 2;
    label.delta_e = sqrt(fmax(2 * label.delta_e * label.delta_e - of_halves, 0));
    return label;
}

nqm_status nqm_azimuths_score_means(const nqm_azimuths *a, size_t n, const nqm_named_pair *members,
                                    const double *weights, nqm_ticker *ticker, nqm_score_result *result,
                                    nqm_error *err) {
    gallery g = {.azimuths = a, .is_light = true, .n = 2 * n};
    double *light, *mean;
    if (!a)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the model has no estimate for leaning normals");
    const size_t n_values = 3 * a->model->n_slope_points;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&g.subjects, g.n, sizeof *g.subjects}, {&light, g.n, n_values * sizeof *light},
                                    {&mean, 2, n_values * sizeof *mean}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < g.n; ++i)
        g.subjects[i] = (subject){.name = i < n ? members[i].ref : members[i - n].test,
                                  .beside = i < n ? SIZE_MAX : i - n,
                                  .itp = light + i * n_values};
    if (!show_all(&g, ticker))
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    for (size_t i = 0; status == NQM_OK && i < g.n; ++i)
        if ((status = g.subjects[i].status) != NQM_OK)
            nqm_fail(err, status, -1, "%.300s: %s", g.subjects[i].name, nqm_status_text(status));
    if (status == NQM_OK) {
        const nqm_label label = label_all(&g, weights, mean);
        *result = (nqm_score_result){.anisotropy = 1};
        take(a, &label, result);
    }
    nqm_free(g.subjects);
    return status;
}
