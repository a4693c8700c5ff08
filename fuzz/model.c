/* SPDX-License-Identifier: MIT
 *
 * What must hold for a model file with any bytes: the reader accepts or refuses it with a message, and an accepted model scores.
 */
#include "fuzz.h"
#include "metric/metric.h"

#include <math.h>
#include <unistd.h>

/* Its interval contains the score, and its novelty is not negative or NaN. */
static void check_interval(const struct nqm_model *model, double jod) {
    double low, high, scalars[NQM_SCALAR_COUNT] = {3}, novelty = nqm_model_novelty(model, scalars);
    if (model->n_novelty && !(novelty >= 0))
        abort();
    nqm_model_interval(model, jod, novelty, 0, &low, &high);
    if (model->interval && isfinite(jod) && !(low <= jod && jod <= high))
        abort();
}

static void score(const struct nqm_model *model) {
    const size_t n = 3 * model->directions->n;
    float *samples = calloc(2 * n, sizeof *samples);
    if (!samples)
        abort();
    for (size_t i = 0; i < n; ++i)
        samples[i] = 1;
    nqm_predictor *predictor;
    nqm_prediction prediction;
    if (nqm_predictor_create(model, 1, &predictor, NULL) != NQM_OK)
        abort();
    nqm_predictor_run(predictor, 1, &(nqm_sample_pair){samples, samples + n, NULL}, &prediction, NULL);
    check_interval(model, prediction.jod);
    nqm_predictor_free(predictor);
    free(samples);
}

void fuzz_model(const uint8_t *data, size_t n_bytes) {
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
}

struct nqm_model *fuzz_model_make(void) {
    enum { N_DIRECTIONS = 2, POINTS = 2 * NQM_TRANSPORT_STEP };
    static const nqm_output_range range = {.std = 1, .hi = 1};
    static const float light[N_DIRECTIONS * 3 * POINTS];
    const double degrees[3 * N_DIRECTIONS] = {0};
    double points[3 * POINTS];
    struct nqm_model *model = nqm_alloc(1, sizeof *model);
    for (size_t i = 0; i < POINTS; ++i) {
        points[3 * i] = 1.0 / NQM_TRANSPORT_STEP;
        points[3 * i + 1] = (double)(i / NQM_TRANSPORT_STEP);
        points[3 * i + 2] = 1000;
    }
    const nqm_transport transport = {N_DIRECTIONS, light, {POINTS, points}};
    if (!model || nqm_directions_from_degrees(N_DIRECTIONS, degrees, &model->directions, NULL) != NQM_OK ||
        nqm_model_set_transport(model, &transport, NULL) != NQM_OK)
        abort();
    model->target = NQM_TARGET_LOG_DELTA_E;
    model->curve = nqm_curve_published;
    model->output = range;
    for (size_t i = 0; i < NQM_LABEL_PARTS; ++i)
        model->parts[i] = range;
    for (size_t i = 0; i < 3; ++i)
        model->features.std[i] = 1;
    return model;
}

blob fuzz_model_save(struct nqm_model *model) {
    static const char path[] = "fuzz_model.tmp";
    char name[64];
    snprintf(name, sizeof name, "%s.%ld", path, (long)getpid());
    if (nqm_model_save(model, name, NULL) != NQM_OK)
        abort();
    nqm_model_free(model);
    blob b = blob_load(name);
    unlink(name);
    return b;
}
