/* SPDX-License-Identifier: MIT
 *
 * The choice of kernels: the best table that the processor can run, determined once, unless the caller chose another. The best is the
 * one with the widest instructions. Only AVX2 and AVX-512 are compared by a measurement, because they give the same bits in every
 * precision: results depend on what the processor can do, never on a timing.
 */
#include "kernel/kernel.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

enum { MAX_TABLES = 6, N_TURNS = 5 };

static const double gain = 0.9; /* of the time: narrower instructions have to take less */

static const nqm_kernels *tables[MAX_TABLES]; /* those that this processor can run, best first */
static size_t n_tables;
static bool is_avx2_first; /* although the processor has AVX-512 */
static pthread_once_t once = PTHREAD_ONCE_INIT;
static const nqm_kernels *_Atomic chosen; /* NULL: the best */

bool nqm_kernels_are_quicker(const nqm_kernels *kernels, const nqm_kernels *than,
                             double (*seconds)(const nqm_kernels *kernels)) {
    double best_s = INFINITY, than_s = INFINITY;
    for (size_t turn = 0; turn < N_TURNS; ++turn)
        best_s = fmin(best_s, seconds(kernels));
    for (size_t turn = 0; turn < N_TURNS; ++turn) /* last: AVX-512 may lower the clock for milliseconds */
        than_s = fmin(than_s, seconds(than));
    return best_s < gain * than_s;
}

#if defined __x86_64__
/* Processor time of products of floats in the L1 cache, about 0.1 ms. */
static double time_products(const nqm_kernels *kernels) {
    enum { ROWS = 2 * NQM_STRIP, WORDS = 96, N_PRODUCTS = 64 };
    _Alignas(64) float a[ROWS * WORDS] = {0}, b[WORDS * NQM_PANEL] = {0}, c[ROWS * NQM_PANEL];
    const double begin_s = nqm_thread_clock_s();
    for (size_t i = 0; i < N_PRODUCTS; ++i)
        kernels->product[NQM_PRECISION_F32](
            &(nqm_product){.m = ROWS, .words = WORDS, .a = a, .b = b, .c = c, .lda = WORDS, .ldc = NQM_PANEL});
    return nqm_thread_clock_s() - begin_s;
}
#endif

static void find_tables(void) {
#if defined __x86_64__
    __builtin_cpu_init();
    bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    const bool bf16 = avx512 && __builtin_cpu_supports("avx512bf16") && __builtin_cpu_supports("avx512vnni");
    if (bf16 && nqm_has_amx())
        tables[n_tables++] = nqm_kernels_amx();
    if (bf16)
        tables[n_tables++] = &nqm_kernels_avx512_bf16;
    /* On processors with one unit for AVX-512, or a lower clock while it is in use. Those with bfloat16 have two or keep their clock. */
    is_avx2_first = avx512 && !bf16 && nqm_kernels_are_quicker(&nqm_kernels_avx2, &nqm_kernels_avx512, time_products);
    if (is_avx2_first)
        tables[n_tables++] = &nqm_kernels_avx2;
    if (avx512)
        tables[n_tables++] = &nqm_kernels_avx512;
    if (!is_avx2_first && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
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

const char *nqm_kernels_reason(void) {
    (void)nqm_kernels_at(0);
    return is_avx2_first ? "measured: avx512 takes longer" : "the widest instructions";
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

const char *nqm_kernels_selected(void) {
    return nqm_kernels_get()->name;
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

const char *const nqm_precision_words[] = {"f32", "bf16", "int8", NULL};

const char *nqm_precision_name(nqm_precision precision) {
    return (unsigned)precision < NQM_PRECISION_COUNT ? nqm_precision_words[precision] : NULL;
}
