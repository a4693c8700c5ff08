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
    nqm_status status = nqm_params_create(&shape, &model->params, err);
    if (status == NQM_OK)
        status = nqm_directions_create(&options, 0, NULL, &model->directions, err);
    if (status != NQM_OK)
        return status;
    nqm_params_init(&model->params, 1);
    for (size_t k = 0; k < 3; ++k) {
        model->features.mean[k] = 0.4f;
        model->features.std[k] = 0.3f;
    }
    model->features.layout = NQM_LAYOUT_REF_DIFF_ABSDIFF;
    model->features.difference_scale = 3;
    model->target = NQM_TARGET_LOG_DELTA_E;
    model->output.mean = 2, model->output.std = 1;
    model->output.lo = -3, model->output.hi = 3;
    model->curve = nqm_curve_published;
    model->id = nqm_strdup("tiny");
    model->card = nqm_strdup("Random weights, for tests only.");
    return model->id && model->card ? NQM_OK : nqm_fail_nomem(err, 0);
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
