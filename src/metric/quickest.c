/* SPDX-License-Identifier: MIT
 *
 * The choice of NQM_PRECISION_AUTO: the quickest precision of a model's network on this machine among those that change few scores.
 * Both are measured, because neither follows from the instruction set: on some processors the instructions for bfloat16 have
 * half the rate of those for float.
 */
#include "math/math.h"
#include "metric/metric.h"
#include "net/inference.h"

#include <math.h>
#include <stdatomic.h>

/* ---- accuracy ---------------------------------------------------------------------------------------------------- */

enum { N_PAIRS = NQM_GOLDEN_MATERIALS * NQM_GOLDEN_MATERIALS };

/* Largest allowed change of a score among all pairs of the golden materials. Measured for two models: over thousands of pairs of
 * measured materials the largest change is 3 to 7 times as large, here at most 0.01. */
static const double bound_jod = 0.0025;

/* rgb (NQM_GOLDEN_MATERIALS, n_directions, 3) */
static nqm_status sample_materials(const nqm_directions *directions, float *rgb, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < NQM_GOLDEN_MATERIALS && status == NQM_OK; ++i) {
        nqm_brdf *brdf;
        status = nqm_brdf_open(nqm_golden_materials[i], &brdf, err);
        if (status == NQM_OK)
            status = nqm_sample(brdf, directions, NQM_INVALID_ZERO, rgb + i * 3 * directions->n, NULL, NULL, err);
        nqm_brdf_free(brdf);
    }
    return status;
}

static nqm_status score_all(const nqm_model *model, nqm_precision precision, const float *rgb, double *jod,
                            nqm_error *err) {
    const float *ref[N_PAIRS], *test[N_PAIRS];
    for (size_t i = 0; i < N_PAIRS; ++i) {
        ref[i] = rgb + i / NQM_GOLDEN_MATERIALS * 3 * model->directions->n;
        test[i] = rgb + i % NQM_GOLDEN_MATERIALS * 3 * model->directions->n;
    }
    nqm_predictor *predictor;
    const nqm_status status = nqm_predictor_create(model, precision, N_PAIRS, &predictor, err);
    if (status == NQM_OK)
        nqm_predictor_run(predictor, &(nqm_sampled_pairs){.n = N_PAIRS, .ref = ref, .test = test}, jod, NULL);
    nqm_predictor_free(predictor);
    return status;
}

nqm_status nqm_precision_changes(const nqm_model *model, double change[NQM_PRECISION_COUNT], nqm_error *err) {
    double jod[NQM_PRECISION_COUNT][N_PAIRS];
    float *rgb = nqm_alloc(NQM_GOLDEN_MATERIALS * model->directions->n, 3 * sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, NQM_GOLDEN_MATERIALS * model->directions->n * 3 * sizeof *rgb);
    nqm_status status = sample_materials(model->directions, rgb, err);
    for (nqm_precision p = NQM_PRECISION_F32; p < NQM_PRECISION_COUNT && status == NQM_OK; ++p) {
        status = score_all(model, p, rgb, jod[p], err);
        change[p] = 0;
        for (size_t i = 0; i < N_PAIRS && status == NQM_OK; ++i)
            change[p] = fmax(change[p], fabs(jod[p][i] - jod[NQM_PRECISION_F32][i]));
    }
    nqm_free(rgb);
    return status;
}

/* ---- speed ------------------------------------------------------------------------------------------------------- */

enum { N_ROWS = 64, N_TURNS = 5 };

static const double gain = 0.9; /* of the time: a less accurate precision has to take less */

/* Processor time of the network on one thread, for random rows; the shortest of several turns, taken alternately. */
static nqm_status time_networks(const nqm_model *model, const bool *is_tried, double *seconds, nqm_error *err) {
    const size_t width = model->params.shape.sizes[0], n_z = N_ROWS * nqm_model_n_outputs(model);
    nqm_inference_work *work[NQM_PRECISION_COUNT] = {NULL};
    float *x, *z;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&x, N_ROWS, width * sizeof *x}, {&z, n_z, sizeof *z}), err);
    if (status != NQM_OK)
        return status;
    nqm_rng rng = nqm_rng_make(1, 0);
    for (size_t i = 0; i < N_ROWS * width; ++i)
        x[i] = (float)nqm_rng_normal(&rng);
    for (nqm_precision p = NQM_PRECISION_F32; p < NQM_PRECISION_COUNT && status == NQM_OK; ++p) {
        const nqm_inference_net *net;
        seconds[p] = INFINITY;
        if (is_tried[p])
            status = nqm_model_inference(model, p, &net, err);
        if (is_tried[p] && status == NQM_OK)
            status = nqm_inference_work_create(net, N_ROWS, &work[p], err);
    }
    for (size_t turn = 0; turn < N_TURNS && status == NQM_OK; ++turn)
        for (size_t p = 0; p < NQM_PRECISION_COUNT; ++p) {
            const double begin = nqm_thread_clock_s();
            if (work[p])
                nqm_inference_run(work[p], N_ROWS, x, width, z);
            if (work[p])
                seconds[p] = fmin(seconds[p], nqm_thread_clock_s() - begin);
        }
    for (size_t p = 0; p < NQM_PRECISION_COUNT; ++p)
        nqm_inference_work_free(work[p]);
    nqm_free(x);
    return status;
}

static nqm_status choose(const nqm_model *model, nqm_precision *precision_ret, nqm_error *err) {
    double change[NQM_PRECISION_COUNT], seconds[NQM_PRECISION_COUNT];
    bool is_tried[NQM_PRECISION_COUNT];
    nqm_status status = nqm_precision_changes(model, change, err);
    for (size_t p = 0; p < NQM_PRECISION_COUNT && status == NQM_OK; ++p)
        is_tried[p] = change[p] <= bound_jod;
    const int n_threads = nqm_limit_threads(1);
    if (status == NQM_OK)
        status = time_networks(model, is_tried, seconds, err);
    nqm_limit_threads(n_threads);
    *precision_ret = NQM_PRECISION_F32;
    for (nqm_precision p = NQM_PRECISION_BF16; p < NQM_PRECISION_COUNT && status == NQM_OK; ++p)
        if (seconds[p] < gain * seconds[*precision_ret])
            *precision_ret = p;
    return status;
}

nqm_status nqm_model_quickest_precision(const nqm_model *model, nqm_precision *precision_ret, nqm_error *err) {
    NQM_REQUIRE(err, model, precision_ret);
    _Atomic int *place = &((struct nqm_model *)(uintptr_t)model)->quickest;
    int found = atomic_load_explicit(place, memory_order_acquire);
    *precision_ret = NQM_PRECISION_F32;
    if (found == 0 && nqm_model_has_network(model)) {
        const nqm_status status = choose(model, precision_ret, err);
        if (status != NQM_OK)
            return status;
        const int chosen = 1 + (int)*precision_ret;
        if (atomic_compare_exchange_strong(place, &found, chosen)) /* else another thread was first */
            found = chosen;
    }
    if (found)
        *precision_ret = (nqm_precision)(found - 1);
    return NQM_OK;
}
