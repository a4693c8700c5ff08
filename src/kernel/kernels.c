/* SPDX-License-Identifier: MIT
 *
 * Which table of kernels is in use.
 */
#include "kernel/kernel.h"

#include <stdatomic.h>

static const nqm_kernels *_Atomic active = &nqm_kernels_onednn;

const nqm_kernels *nqm_kernels_get(void) {
    return atomic_load_explicit(&active, memory_order_acquire);
}

void nqm_kernels_use(const nqm_kernels *kernels) {
    atomic_store_explicit(&active, kernels ? kernels : &nqm_kernels_onednn, memory_order_release);
}
