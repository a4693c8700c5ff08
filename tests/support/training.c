/* SPDX-License-Identifier: MIT
 *
 * Quick trainings on toy datasets.
 */
#include "support/training.h"
#include "support/check.h"
#include "support/scratch.h"

nqm_train_options small_recipe(const char *recipe, size_t width, size_t epochs) {
    nqm_train_options o;
    assert_int_equal(nqm_train_options_recipe(recipe, &o, NULL), NQM_OK);
    o.network.n_hidden = 1;
    o.network.hidden[0] = width;
    o.optimiser.batch = 32;
    o.optimiser.epochs = epochs;
    o.optimiser.lr_first = 1e-3;
    return o;
}

nqm_model *train_model(const nqm_dataset *dataset, const nqm_train_options *options, nqm_train_report *report) {
    nqm_model *model;
    nqm_error err = {0};
    if (nqm_train(dataset, options, &model, report, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return model;
}

nqm_status save_calibrated(const nqm_model *model, const nqm_dataset *d, int materials_are_new,
                           nqm_calibration *calibration, nqm_error *err) {
    nqm_model *calibrated;
    nqm_status status = nqm_model_calibrate(model, d, materials_are_new, &calibrated, calibration, err);
    if (status == NQM_OK)
        status = nqm_model_save(calibrated, scratch_path("model"), err);
    nqm_model_free(calibrated);
    return status;
}
