/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the model reader, with and without its checksum, from a model that has everything but parts.
 */
#include "fuzz.h"
#include "model/model.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_model(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const double interval[6] = {0, 0, 1, 10, 9, 10};
    struct nqm_model *model = fuzz_model_make();
    const nqm_net_shape shape = {2, {6 * model->directions->n + NQM_SCALAR_COUNT, 3, 1}};
    model->scalar_names = nqm_scalar_names();
    model->interval = nqm_alloc(6, sizeof *model->interval);
    model->calibration = nqm_strdup("{}");
    model->novelty_points = nqm_alloc(NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK, sizeof *model->novelty_points);
    if (!model->scalar_names || !model->interval || !model->calibration || !model->novelty_points ||
        nqm_params_create(&shape, &model->params, NULL) != NQM_OK)
        abort();
    nqm_params_init(&model->params, 1);
    memcpy(model->interval, interval, sizeof interval);
    model->n_interval = 2;
    model->n_novelty = 1;
    model->novelty_unit = model->novelty_growth = 1;
    model->scalars.scale = 1;
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        model->scalars.std[i] = 1;
    return fuzz_model_save(model);
}

FUZZ_TARGET(run_one, make_seed)
