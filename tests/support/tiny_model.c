/* SPDX-License-Identifier: MIT
 *
 * A small network with random weights and the layout of the recipe `nqm`.
 */
#include "support/tiny_model.h"
#include "percept/percept.h"

#include <nqm/train.h>
#include <string.h>

static nqm_status fill(nqm_model *model, size_t n, nqm_error *err) {
    const nqm_net_shape shape = {2, {9 * n, 8, 1}};
    nqm_directions_options options = nqm_directions_options_default();
    options.n = n;
    nqm_directions *directions = NULL;
    nqm_status status = nqm_params_create(&shape, &model->params, err);
    if (status == NQM_OK)
        status = nqm_directions_create(&options, 0, NULL, &directions, err);
    if (status != NQM_OK)
        return status;
    nqm_params_init(&model->params, 1);
    model->n_directions = n;
    model->directions_deg = nqm_alloc(n, 3 * sizeof(double));
    if (model->directions_deg)
        memcpy(model->directions_deg, nqm_directions_degrees(directions), n * 3 * sizeof(double));
    nqm_directions_free(directions);
    for (size_t k = 0; k < 3; ++k) {
        model->mean[k] = 0.4f;
        model->std[k] = 0.3f;
    }
    model->layout = NQM_LAYOUT_REF_DIFF_ABSDIFF;
    model->difference_scale = 3;
    model->target = NQM_TARGET_LOG_DELTA_E;
    model->target_mean = 2, model->target_std = 1;
    model->out_lo = -3, model->out_hi = 3;
    model->curve = nqm_curve_published;
    model->id = nqm_strdup("tiny");
    model->card = nqm_strdup("Random weights, for tests only.");
    bool complete = model->directions_deg && model->id && model->card;
    return complete ? nqm_model_attach_directions(model, err) : nqm_fail_nomem(err, 0);
}

nqm_status make_tiny_model(size_t n, nqm_model **model_ret, nqm_error *err) {
    *model_ret = NULL;
    nqm_model *model = nqm_alloc(1, sizeof *model);
    if (!model)
        return nqm_fail_nomem(err, sizeof *model);
    nqm_status status = fill(model, n, err);
    if (status == NQM_OK)
        *model_ret = model;
    else
        nqm_model_free(model);
    return status;
}
