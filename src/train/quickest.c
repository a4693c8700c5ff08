/* SPDX-License-Identifier: MIT
 *
 * The choice of NQM_PRECISION_AUTO for a training: float or bfloat16, whichever takes less time for a few steps on this processor. The
 * instructions for bfloat16 have twice the rate of those for float on some processors, half of it on others, and are missing
 * on most.
 */
#include "net/trainer.h"
#include "train/train.h"

#include <math.h>
#include <string.h>

/* A part of the network is enough: the products are most of the time, and their speed depends little on their size. */
enum { MAX_INPUTS = 1024, MAX_HIDDEN = 512, MAX_BATCH = 256, N_STEPS = 4 };

static const double gain = 0.9; /* of the time: bfloat16 has to take less */

/* Processor time of a step on one thread, the shortest of a few. */
static nqm_status time_step(const nqm_net_shape *shape, nqm_precision precision, size_t batch, double *seconds_ret,
                            nqm_error *err) {
    const nqm_trainer_options options = {.precision = precision, .max_batch = batch};
    const nqm_step_rates rates = {.lr_first = 1e-4, .lr_deeper = 1e-3};
    float z[MAX_BATCH], dz[MAX_BATCH];
    nqm_trainer *trainer;
    *seconds_ret = INFINITY;
    nqm_status status = nqm_trainer_create(shape, &options, &trainer, err);
    for (size_t step = 0; step < N_STEPS && status == NQM_OK; ++step) {
        for (size_t i = 0; i < batch; ++i) {
            float *row = nqm_trainer_input(trainer, i);
            for (size_t k = 0; k < shape->sizes[0]; ++k)
                row[k] = (float)((i + k) % 7) - 3;
            dz[i] = 1e-3F;
            if (i % 2 || i + 1 == batch)
                nqm_trainer_inputs_done(trainer, i - i % 2, 1 + i % 2);
        }
        const double begin = nqm_thread_clock_s();
        nqm_trainer_forward(trainer, batch, NULL, z);
        nqm_trainer_step(trainer, batch, dz, &rates);
        *seconds_ret = fmin(*seconds_ret, nqm_thread_clock_s() - begin);
    }
    nqm_trainer_free(trainer);
    return status;
}

nqm_status nqm_quickest_training(const nqm_net_shape *shape, size_t batch, nqm_precision *precision_ret,
                                 nqm_error *err) {
    const nqm_net_shape part = {
        .n_layers = 2,
        .sizes = {nqm_smaller(shape->sizes[0], MAX_INPUTS), nqm_smaller(shape->sizes[1], MAX_HIDDEN), 1}};
    double f32_s, bf16_s = INFINITY;
    const int n_threads = nqm_limit_threads(1);
    nqm_status status = time_step(&part, NQM_PRECISION_F32, nqm_smaller(batch, MAX_BATCH), &f32_s, err);
    if (status == NQM_OK)
        status = time_step(&part, NQM_PRECISION_BF16, nqm_smaller(batch, MAX_BATCH), &bf16_s, err);
    nqm_limit_threads(n_threads);
    *precision_ret = bf16_s < gain * f32_s ? NQM_PRECISION_BF16 : NQM_PRECISION_F32;
    return status;
}
