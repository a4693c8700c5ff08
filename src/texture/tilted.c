/* SPDX-License-Identifier: MIT
 *
 * The score of means of BRDFs with different normals: the light of their pictures is averaged, which one set of half vectors for
 * all lobes could not give.
 */
#include "lobes/lobes.h"
#include "texture/score.h"

#include <math.h>

/* Pictures of n references, then of n tests, and their weights (n). */
typedef struct members {
    const nqm_picture_points *points;
    size_t n;
    const nqm_lobe_picture *pictures;
    const double *weights;
    double *mean; /* (2, 3, n_points) workspace */
} members;

/* The label of the means over every `step`-th member from `first` on. */
static nqm_label label_means(const members *m, size_t first, size_t step) {
    const size_t n_values = 3 * m->points->n;
    double sum = 0;
    memset(m->mean, 0, 2 * n_values * sizeof *m->mean);
    for (size_t i = first; i < m->n; i += step)
        sum += m->weights[i];
    for (size_t s = 0; s < 2; ++s) {
        double *mean = m->mean + s * n_values;
        for (size_t i = first; i < m->n; i += step)
            for (size_t k = 0; k < n_values; ++k)
                mean[k] += m->weights[i] / sum * m->pictures[s * m->n + i].light[k];
        nqm_picture_show(m->points, mean, mean);
    }
    return nqm_picture_label(m->points, m->mean, m->mean + n_values);
}

/* Few members differ more than the means over all would: the square of their Delta-E has a part that is inverse to
 * their number, which the halves show. */
static nqm_label label_all(const members *m) {
    nqm_label label = label_means(m, 0, 1);
    if (m->n < 2)
        return label;
    const nqm_label half[2] = {label_means(m, 0, 2), label_means(m, 1, 2)};
    const double of_halves = (half[0].delta_e * half[0].delta_e + half[1].delta_e * half[1].delta_e) / 2;
    label.delta_e = sqrt(fmax(2 * label.delta_e * label.delta_e - of_halves, 0));
    return label;
}

nqm_status nqm_texture_score_tilted(const nqm_model *model, size_t n, const nqm_subject *subjects,
                                    const double *weights, nqm_ticker *ticker, nqm_score_result *result,
                                    nqm_error *err) {
    const nqm_slope_light light = nqm_model_slope_light(model);
    const size_t n_values = 3 * light.points.n;
    members m = {.points = &light.points, .n = n, .weights = weights};
    nqm_lobe_picture *pictures;
    double *values;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&pictures, 2 * n, sizeof *pictures}, {&values, 2 * n, n_values * sizeof *values},
                                    {&m.mean, 2, n_values * sizeof *m.mean}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < 2 * n; ++i)
        pictures[i] = (nqm_lobe_picture){
            .subject = &subjects[i], .ref = i < n ? SIZE_MAX : i - n, .light = values + i * n_values};
    m.pictures = pictures;
    status = nqm_lobes_pictures(&light, 2 * n, pictures, ticker, err);
    for (size_t i = 0; status == NQM_OK && i < 2 * n; ++i)
        if ((status = pictures[i].status) != NQM_OK)
            nqm_fail(err, status, -1, "%.300s: %s",
                     subjects[i].name ? subjects[i].name : subjects[i].values->schema->model, nqm_status_text(status));
    if (status == NQM_OK) {
        result->parts = label_all(&m);
        result->delta_e = result->parts.delta_e;
        result->jod = nqm_curve_jod(&model->curve, result->delta_e);
        nqm_model_interval(model, result->jod, NAN, 0, &result->jod_low, &result->jod_high);
    }
    nqm_free(pictures);
    return status;
}
