/* SPDX-License-Identifier: MIT
 *
 * The loops of every width (loops.h).
 */
#include "support/loops.h"
#include "sample/loops.h"

static const sample_loops chosen = {
    .logs = nqm_sample_logs,
    .scale = nqm_sample_scale,
    .log_ratios = nqm_sample_log_ratios,
    .root_differences = nqm_sample_root_differences,
    .limit = nqm_sample_limit,
    .differences = nqm_sample_differences,
    .sums = nqm_sample_sums,
    .whiten = nqm_sample_whiten,
    .nearest = nqm_sample_nearest,
};

const sample_loops *sample_loops_at(size_t i) {
    const sample_loops *all[4] = {&chosen, &loops_plain};
    size_t n = 2;
#if defined __x86_64__
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2"))
        all[n++] = &loops_avx2;
    if (__builtin_cpu_supports("avx512f"))
        all[n++] = &loops_avx512;
#endif
    return i < n ? all[i] : NULL;
}
