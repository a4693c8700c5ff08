/* SPDX-License-Identifier: MIT
 *
 * Predictions of a model: its network, packed at the first use, and the conversion of the network's output to JOD.
 */
#include "model/model.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>

double nqm_model_jod(const struct nqm_model *model, double z, double *delta_e_ret) {
    const nqm_output_range *o = &model->output;
    double normalised = o->lo + (o->hi - o->lo) * nqm_sigmoid(z);
    double target = o->mean + o->std * normalised;
    double delta_e = model->target == NQM_TARGET_LOG_DELTA_E ? exp(target) : (double)NAN;
    if (delta_e_ret)
        *delta_e_ret = delta_e;
    return model->target == NQM_TARGET_LOG_DELTA_E ? nqm_curve_jod(&model->curve, delta_e) : target;
}

static nqm_input_groups input_groups(const struct nqm_model *model) {
    nqm_input_groups inputs = {.n_groups = model->features.layout == NQM_LAYOUT_REF_TEST ? 2 : 3,
                               .n_scalars = nqm_model_n_scalars(model),
                               .test_itself = model->features.layout == NQM_LAYOUT_REF_TEST};
    for (size_t i = 0; i < inputs.n_groups; ++i)
        inputs.width[i] = 3 * model->directions->n;
    return inputs;
}

static pthread_mutex_t inference_lock = PTHREAD_MUTEX_INITIALIZER; /* locked while the network of any model is packed */

nqm_status nqm_model_inference(const struct nqm_model *model, nqm_precision precision,
                               const nqm_inference_net **net_ret, nqm_error *err) {
    nqm_inference_net *_Atomic *place = &((struct nqm_model *)(uintptr_t)model)->inference[precision];
    nqm_inference_net *net = atomic_load_explicit(place, memory_order_acquire);
    nqm_status status = NQM_OK;
    if (!net) {
        pthread_mutex_lock(&inference_lock);
        net = atomic_load_explicit(place, memory_order_acquire);
        if (!net) { /* no other thread packed it in the meantime */
            const nqm_input_groups inputs = input_groups(model);
            status = nqm_inference_net_create(&model->params, &inputs, precision, &net, err);
            atomic_store_explicit(place, net, memory_order_release);
        }
        pthread_mutex_unlock(&inference_lock);
    }
    *net_ret = net;
    return status;
}
