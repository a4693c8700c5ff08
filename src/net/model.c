/* SPDX-License-Identifier: MIT
 *
 * What a model's raw output means, the names in its file, and its end.
 */
#include "net/inference.h"
#include "net/model_file.h"
#include "net/net.h"

#include <math.h>
#include <nqm/train.h>

const char *const nqm_layer_suffixes[] = {"weight", "bias", "norm.weight", "norm.bias"};
const char *const nqm_layout_names[] = {
    [NQM_LAYOUT_REF_TEST] = "ref_test", [NQM_LAYOUT_REF_DIFF_ABSDIFF] = "ref_diff_absdiff"};
const char *const nqm_target_names[] = {[NQM_TARGET_JOD] = "jod", [NQM_TARGET_LOG_DELTA_E] = "log_delta_e"};

double nqm_model_jod(const struct nqm_model *model, double z, double *delta_e_ret) {
    double normalised = model->out_lo + (model->out_hi - model->out_lo) * nqm_sigmoid(z);
    double target = model->target_mean + model->target_std * normalised;
    double delta_e = model->target == NQM_TARGET_LOG_DELTA_E ? exp(target) : (double)NAN;
    if (delta_e_ret)
        *delta_e_ret = delta_e;
    return model->target == NQM_TARGET_LOG_DELTA_E ? nqm_jod_from_delta_e(&model->curve, delta_e) : target;
}

void nqm_model_destroy(struct nqm_model *model) {
    if (!model)
        return;
    if (model->directions_free)
        model->directions_free(model->directions);
    nqm_params_free(&model->params);
    char *texts[] = {model->id,      model->recipe,       model->card,
                     model->licence, model->training,     model->manifest_sha256,
                     model->golden,  model->scalar_names, model->calibration};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        nqm_free(texts[i]);
    for (size_t i = 0; i < NQM_PRECISION_COUNT; ++i)
        nqm_inference_net_free(model->inference[i]);
    nqm_free(model->directions_deg);
    nqm_free(model->interval);
    nqm_free(model->novelty_points);
    if (model->file)
        nqm_map_close(model->file);
    nqm_free(model->file);
    nqm_free(model);
}
