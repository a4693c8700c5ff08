/* SPDX-License-Identifier: MIT
 *
 * Adam's moments in the layout of the parameters, as a checkpoint stores them.
 */
#include "net/net.h"

nqm_status nqm_adam_create(const nqm_net_shape *shape, nqm_adam *adam_ret, nqm_error *err) {
    *adam_ret = (nqm_adam){0};
    nqm_status status = nqm_params_create(shape, &adam_ret->m, err);
    if (status == NQM_OK)
        status = nqm_params_create(shape, &adam_ret->v, err);
    if (status != NQM_OK)
        nqm_adam_free(adam_ret);
    return status;
}

void nqm_adam_free(nqm_adam *adam) {
    nqm_params_free(&adam->m);
    nqm_params_free(&adam->v);
    *adam = (nqm_adam){0};
}
