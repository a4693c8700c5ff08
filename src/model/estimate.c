/* SPDX-License-Identifier: MIT
 *
 * Models without a network, whose predictions are the estimates by the light of a scene.
 */
#include "model/model.h"
#include "sample/node_grid.h"

#include <string.h>

static const char matrix_card[] = "Estimate by light transport, without a network: the Delta-E ITP and JOD of "
                                  "pictures of few points that a matrix makes of\n"
                                  "the samples. It has no intervals: nothing was trained or calibrated.\n";

static const char slopes_card[] =
    "Estimate by light transport for any BRDF, anisotropic or not, without a network: the Delta-E ITP and JOD of"
    "\npictures of few points, whose light is known by the slope of the half vector. The BRDF is evaluated at half"
    "\nvectors placed by its lobe. Nothing was trained.\n";

static nqm_status set_texts(nqm_model *m, const char *id, const char *card, nqm_error *err) {
    struct {
        char **to;
        const char *text;
    } texts[] = {{&m->id, id},     {&m->recipe, "transport"}, {&m->licence, "MIT"},
                 {&m->card, card}, {&m->training, "{}"},      {&m->manifest_sha256, ""}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        if (!(*texts[i].to = nqm_strdup(texts[i].text)))
            return nqm_fail_nomem(err, strlen(texts[i].text));
    return NQM_OK;
}

/* Ranges in which an output of 0 corrects nothing, and a whitening that finds no sample unusual. */
static void set_constants(nqm_model *m) {
    const nqm_output_range none = {.mean = 0, .std = 1, .lo = -1, .hi = 1};
    m->target = NQM_TARGET_LOG_DELTA_E;
    m->curve = nqm_curve_published;
    m->output = none;
    m->features.difference_scale = 1;
    for (size_t k = 0; k < NQM_LABEL_PARTS; ++k)
        m->parts[k] = none;
    for (size_t k = 0; k < 3; ++k)
        m->features.std[k] = 1;
}

static nqm_status alloc_light(nqm_model *m, bool by_slopes, size_t n_points, nqm_error *err) {
    const size_t n_rows = by_slopes ? NQM_SLOPE_CELLS : m->directions->n;
    float *light = nqm_alloc(n_rows, 3 * n_points * sizeof *light);
    double *points = nqm_alloc(n_points, 3 * sizeof *points);
    if (by_slopes) {
        m->slopes = light;
        m->slope_points = points;
        m->slope_wo = nqm_alloc(n_points, 3 * sizeof *m->slope_wo);
        m->n_slopes = n_rows;
        m->n_slope_points = m->n_slope_wo = n_points;
    } else {
        m->transport = light;
        m->transport_points = points;
        m->n_transport = n_rows;
        m->n_points = n_points;
    }
    const bool ok = light && points && (m->slope_wo || !by_slopes);
    return ok ? NQM_OK : nqm_fail_nomem(err, n_rows * 3 * n_points * sizeof *light);
}

nqm_status nqm_model_of_light(const char *id, bool by_slopes, size_t n_points, nqm_model **model_ret, nqm_error *err) {
    nqm_model *m = *model_ret = nqm_alloc(1, sizeof *m);
    nqm_status status = m ? nqm_node_grid_directions(&m->directions, err) : nqm_fail_nomem(err, sizeof *m);
    if (status == NQM_OK)
        status = set_texts(m, id, by_slopes ? slopes_card : matrix_card, err);
    if (status == NQM_OK)
        status = alloc_light(m, by_slopes, n_points, err);
    if (status == NQM_OK) {
        set_constants(m);
        return NQM_OK;
    }
    nqm_model_free(m);
    *model_ret = NULL;
    return status;
}
