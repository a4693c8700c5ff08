/* SPDX-License-Identifier: MIT
 *
 * tiny_model FILE [N]: write a model of N (default 500) directions with random weights, so that the command-line tests
 * have a model whatever is built in. What it scores means nothing, except that equal pairs are equal.
 */
#include "metric/metric.h"

#include <nqm/train.h>
#include <stdio.h>
#include <stdlib.h>
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
    model->curve = nqm_jod_curve_published;
    model->id = nqm_strdup("tiny");
    model->card = nqm_strdup("Random weights, for tests only.");
    bool complete = model->directions_deg && model->id && model->card;
    return complete ? nqm_model_attach_directions(model, err) : nqm_fail_nomem(err, 0);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fputs("usage: tiny_model FILE [N]\n", stderr);
        return 2;
    }
    nqm_error err = {0};
    nqm_model *model = nqm_alloc(1, sizeof *model);
    nqm_status status = model ? fill(model, argc > 2 ? strtoul(argv[2], NULL, 10) : 500, &err) : NQM_ERR_NOMEM;
    if (status == NQM_OK)
        status = nqm_model_save(model, argv[1], &err);
    nqm_model_free(model);
    if (status != NQM_OK)
        fprintf(stderr, "tiny_model: %s\n", err.message);
    return status != NQM_OK;
}
