/* SPDX-License-Identifier: MIT
 *
 * Pairs with an anisotropic BRDF. The directions of the models "default" and "transport" have one azimuth, which is
 * enough for isotropic BRDFs; the model "anisotropic" makes small pictures of any BRDF (lobes/lobes.h). So the former
 * hand such pairs to the latter; where the anisotropy is slight, the score is between both, and continuous.
 */
#include "lobes/lobes.h"
#include "metric/metric.h"

#include <math.h>
#include <string.h>

/* Anisotropy (nqm_brdf_check_report) from which on a pair has the score of "anisotropic" alone. */
static const double plain_anisotropy = 0.02;

/* Whether it is a built-in model of the standard scenes, or its file: those of other scenes may have the same id. */
nqm_status nqm_anisotropic_find(const nqm_model *model, nqm_model **anisotropic_ret, nqm_error *err) {
    nqm_model *builtin = NULL;
    *anisotropic_ret = NULL;
    if (strcmp(model->id, "default") != 0 && strcmp(model->id, "transport") != 0)
        return NQM_OK;
    nqm_status status = nqm_model_builtin(model->id, &builtin, err);
    if (status == NQM_OK && strcmp(model->sha256, builtin->sha256) == 0)
        status = nqm_model_builtin("anisotropic", anisotropic_ret, err);
    nqm_model_free(builtin);
    return status;
}

bool nqm_anisotropic_is_needed(const nqm_model *model, const nqm_score_result *r) {
    return r->status == NQM_OK && (r->anisotropy > 0 || model->slopes);
}

/* 0 for 0, 1 from plain_anisotropy on; smooth. */
static double weight_of(double anisotropy) {
    const double t = fmin(anisotropy / plain_anisotropy, 1);
    return t * t * (3 - 2 * t);
}

/* Set what `anisotropic` predicts with weight w, where the result has what another model predicts. It keeps the metrics
 * and counts of that model's directions; people's similarity is not known. */
static void blend(const nqm_model *anisotropic, double w, const nqm_label *label, nqm_score_result *r) {
    const double jod = nqm_curve_jod(&anisotropic->curve, label->delta_e);
    double low, high;
    nqm_label mean = {.delta_e = 0};
    r->identical = r->identical && label->delta_e == 0;
    nqm_model_interval(anisotropic, jod, NAN, 0, &low, &high);
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

static void drop_scores(const nqm_model *model, size_t n, nqm_score_result *results) {
    for (size_t i = 0; i < n; ++i)
        if (nqm_anisotropic_is_needed(model, &results[i])) {
            const double anisotropy = results[i].anisotropy;
            results[i] = nqm_no_score(NQM_ERR_INCOMPATIBLE);
            results[i].anisotropy = anisotropy;
        }
}

/* The picture of a BRDF, of which *n have a place. ref: as in nqm_lobe_picture. */
static size_t find(nqm_lobe_picture *pictures, size_t *n, const nqm_subject *subject, const nqm_brdf *brdf,
                   size_t ref) {
    for (size_t i = 0; i < *n; ++i)
        if (pictures[i].ref == ref &&
            (subject ? nqm_subjects_equal(pictures[i].subject, subject) : pictures[i].brdf == brdf))
            return i;
    pictures[*n] = (nqm_lobe_picture){.subject = subject, .brdf = brdf, .ref = ref};
    return (*n)++;
}

nqm_status nqm_anisotropic_score(const nqm_model *anisotropic, const nqm_model *model, size_t n,
                                 const nqm_opened_pairs *pairs, nqm_score_result *results, nqm_error *err) {
    if (!anisotropic) {
        drop_scores(model, n, results);
        return NQM_OK;
    }
    const nqm_slope_light light = nqm_model_slope_light(anisotropic);
    const size_t n_values = 3 * light.points.n;
    size_t n_pictures = 0, place[NQM_SCORE_BLOCK][2];
    nqm_lobe_picture *pictures;
    double *itp;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&pictures, 2 * n, sizeof *pictures}, {&itp, 2 * n, n_values * sizeof *itp}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n; ++i)
        if (nqm_anisotropic_is_needed(model, &results[i])) {
            const nqm_subject *pair = pairs->subjects ? &pairs->subjects[2 * i] : NULL;
            const nqm_brdf *test = pair ? NULL : pairs->tests[i];
            place[i][0] = find(pictures, &n_pictures, pair, pairs->ref, SIZE_MAX);
            place[i][1] = find(pictures, &n_pictures, pair ? pair + 1 : NULL, test, place[i][0]);
        }
    for (size_t i = 0; i < n_pictures; ++i)
        pictures[i].light = itp + i * n_values;
    status = nqm_lobes_pictures(&light, n_pictures, pictures, NULL, err);
    for (size_t i = 0; status == NQM_OK && i < n_pictures; ++i)
        nqm_picture_show(&light.points, pictures[i].light, pictures[i].light);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        nqm_score_result *r = &results[i];
        if (!nqm_anisotropic_is_needed(model, r))
            continue;
        const nqm_lobe_picture *ref = &pictures[place[i][0]], *test = &pictures[place[i][1]];
        const nqm_label label = nqm_picture_label(&light.points, ref->light, test->light);
        if (ref->status != NQM_OK || test->status != NQM_OK)
            *r = nqm_no_score(ref->status != NQM_OK ? ref->status : test->status);
        else
            blend(anisotropic, model->slopes ? 1 : weight_of(r->anisotropy), &label, r);
    }
    nqm_free(pictures);
    return status;
}
