/* SPDX-License-Identifier: MIT
 *
 * The choice of kernels: the table with the widest instructions that the processor has, unless the caller chose another.
 */
#include "base/os.h"
#include "kernel/kernel.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { MAX_TABLES = 5 };

static const nqm_kernels *tables[MAX_TABLES]; /* those that this processor can run, the widest first */
static size_t n_tables;
static pthread_once_t once = PTHREAD_ONCE_INIT;
static const nqm_kernels *_Atomic chosen; /* NULL: the first of them */

static void find_tables(void) {
#if defined __x86_64__
    __builtin_cpu_init();
    const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    if (avx512 && __builtin_cpu_supports("avx512bf16"))
        tables[n_tables++] = &nqm_kernels_avx512_bf16;
    if (avx512)
        tables[n_tables++] = &nqm_kernels_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        tables[n_tables++] = &nqm_kernels_avx2;
#endif
    tables[n_tables++] = &nqm_kernels_generic;
    tables[n_tables++] = &nqm_kernels_scalar;
}

const nqm_kernels *nqm_kernels_at(size_t i) {
    pthread_once(&once, find_tables);
    return i < n_tables ? tables[i] : NULL;
}

const nqm_kernels *nqm_kernels_get(void) {
    const nqm_kernels *kernels = atomic_load_explicit(&chosen, memory_order_acquire);
    return kernels ? kernels : nqm_kernels_at(0);
}

void nqm_kernels_use(const nqm_kernels *kernels) {
    atomic_store_explicit(&chosen, kernels, memory_order_release);
}

nqm_adam_rate nqm_adam_rate_at(double lr, double weight_decay, uint64_t step) {
    const double t = (double)step;
    return (nqm_adam_rate){.step_size = lr / (1 - pow(NQM_ADAM_BETA1, t)),
                           .v_scale = 1 / sqrt(1 - pow(NQM_ADAM_BETA2, t)),
                           .weight_decay = weight_decay};
}

const char *nqm_kernels_name(size_t i) {
    const nqm_kernels *kernels = nqm_kernels_at(i);
    return kernels ? kernels->name : NULL;
}

nqm_status nqm_kernels_select(const char *name, nqm_error *err) {
    const nqm_kernels *kernels = NULL;
    for (size_t i = 0; name && (kernels = nqm_kernels_at(i)) && strcmp(kernels->name, name) != 0;)
        ++i;
    if (name && !kernels)
        return nqm_fail(err, NQM_ERR_ARG, -1, "kernels '%.40s': this build or processor does not have them", name);
    nqm_kernels_use(kernels);
    return NQM_OK;
}

const char *const nqm_precision_words[] = {"f32", "bf16", NULL};
