/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the model reader, with and without its checksum. An accepted model must run inference; its interval must
 * contain the score, and its novelty must not be negative or NaN.
 */
#include "fuzz.h"
#include "model/model.h"
#include "net/inference.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

static void score(const struct nqm_model *model) {
    const size_t width = model->params.shape.sizes[0];
    const nqm_inference_net *net;
    nqm_inference_work *work = NULL;
    float z, *x = calloc(width, sizeof *x);
    if (!x || nqm_model_inference(model, NQM_PRECISION_F32, &net, NULL) != NQM_OK ||
        nqm_inference_work_create(net, 1, &work, NULL) != NQM_OK)
        abort();
    nqm_inference_run(work, 1, x, width, &z);
    const nqm_label estimate = {.delta_e = 1};
    double jod = nqm_model_jod(model, (double)z, model->transport ? &estimate : NULL, NULL), low, high;
    double scalars[NQM_SCALAR_COUNT] = {3}, novelty = nqm_model_novelty(model, scalars);
    if (model->n_novelty && !(novelty >= 0))
        abort();
    nqm_model_interval(model, jod, novelty, &low, &high);
    if (model->interval && isfinite(jod) && !(low <= jod && jod <= high))
        abort();
    nqm_inference_work_free(work);
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
        nqm_model_free(model);
    }
    return 0;
}

blob fuzz_seed(void) {
    enum { N_DIRECTIONS = 2 };
    static const char path[] = "fuzz_model.tmp";
    const double degrees[3 * N_DIRECTIONS] = {0};
    static float light[N_DIRECTIONS * 3 * NQM_TRANSPORT_POINTS];
    struct nqm_model model = {.target = NQM_TARGET_LOG_DELTA_E,
                              .curve = nqm_curve_published,
                              .n_transport = N_DIRECTIONS,
                              .transport = light,
                              .output = {.std = 1, .hi = 1},
                              .scalar_names = nqm_scalar_names()};
    if (!model.scalar_names || nqm_directions_from_degrees(N_DIRECTIONS, degrees, &model.directions, NULL) != NQM_OK)
        abort();
    double interval[6] = {0, 0, 1, 10, 9, 10};
    static char calibration[] = "{}";
    model.interval = interval;
    model.n_interval = 2;
    model.calibration = calibration;
    static float points[NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK];
    model.n_novelty = 1;
    model.novelty_points = points;
    model.novelty_unit = model.novelty_growth = 1;
    model.scalars.scale = 1;
    for (size_t i = 0; i < NQM_TRANSPORT_POINTS; ++i) {
        model.transport_points[3 * i] = 1.0 / NQM_TRANSPORT_POINTS;
        model.transport_points[3 * i + 2] = 1000;
    }
    for (size_t i = 0; i < 3; ++i)
        model.features.std[i] = 1;
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        model.scalars.std[i] = 1;
    if (nqm_params_create(&(nqm_net_shape){2, {6 * N_DIRECTIONS + NQM_SCALAR_COUNT, 3, 1}}, &model.params, NULL) !=
        NQM_OK)
        abort();
    nqm_params_init(&model.params, 1);
    if (nqm_model_save(&model, path, NULL) != NQM_OK)
        abort();
    nqm_params_free(&model.params);
    nqm_directions_free(model.directions);
    nqm_free(model.scalar_names);
    blob b = blob_load(path);
    unlink(path);
    return b;
}
