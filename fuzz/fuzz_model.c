/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the model reader, with and without its checksum. A model that it accepts must score without a fault.
 */
#include "fuzz.h"
#include "net/net.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

static void score(const struct nqm_model *model) {
    const nqm_net_shape *shape = &model->params.shape;
    nqm_net_work *work;
    float z, *x = calloc(shape->sizes[0], sizeof *x);
    if (!x || nqm_net_work_create(shape, 1, false, &work, NULL) != NQM_OK)
        abort();
    nqm_net_forward(&model->params, work, 1, x, NULL, &z);
    double jod = nqm_model_jod(model, (double)z, NULL), low, high;
    nqm_model_interval(model, jod, &low, &high);
    if (model->interval && isfinite(jod) && !(low <= jod && jod <= high))
        abort();
    nqm_net_work_free(work);
    free(x);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    for (int verify = 0; verify < 2; ++verify) {
        struct nqm_model *model;
        nqm_error err = {0};
        nqm_status status = nqm_model_parse(data, n_bytes, "fuzz", verify, &model, &err);
        if ((status == NQM_OK) != (model != NULL) || (status != NQM_OK && err.message[0] == '\0'))
            abort();
        if (model)
            score(model);
        nqm_model_destroy(model);
    }
    return 0;
}

blob fuzz_seed(void) {
    enum { N_DIRECTIONS = 2 };
    static const char path[] = "fuzz_model.tmp";
    double directions[3 * N_DIRECTIONS] = {0};
    struct nqm_model model = {.n_directions = N_DIRECTIONS, .directions_deg = directions, .target_std = 1, .out_hi = 1};
    static char scalar_names[] = "a";
    model.scalar_names = scalar_names;
    double interval[6] = {0, 0, 1, 10, 9, 10};
    static char calibration[] = "{}";
    model.interval = interval;
    model.n_interval = 2;
    model.calibration = calibration;
    model.scalar_scale = 1;
    for (size_t i = 0; i < 3; ++i)
        model.std[i] = 1;
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        model.scalar_std[i] = 1;
    if (nqm_params_create(&(nqm_net_shape){2, {6 * N_DIRECTIONS + NQM_SCALAR_COUNT, 3, 1}}, &model.params, NULL) !=
        NQM_OK)
        abort();
    nqm_params_init(&model.params, 1);
    if (nqm_model_write(&model, path, NULL) != NQM_OK)
        abort();
    nqm_params_free(&model.params);
    blob b = blob_load(path);
    unlink(path);
    return b;
}
