/* SPDX-License-Identifier: MIT
 *
 * Loops that reach the peaks of the processor's units: multiply-adds on independent accumulators in registers, and sequential
 * reading of memory. Each is compiled for its instruction set, and runs only where the processor has it.
 */
#include "bench/bench.h"
#include "kernel/kernel.h"

#include <string.h>
#if defined __x86_64__
#include <immintrin.h>
#elif defined __aarch64__
#include <arm_neon.h>
#endif

#define UNROLL     _Pragma("GCC unroll 24")
#define FOR(ISA)   __attribute__((noinline, target(ISA)))
#define ANY_TARGET __attribute__((noinline))

/* NOLINTBEGIN(bugprone-macro-parentheses): types and attributes cannot be in parentheses */

/* SUMS accumulators: at least latency x throughput of the instruction, at most the number of registers. They start from
 * different values, so that the compiler cannot merge them. */
#define DEFINE_PEAK(NAME, ATTRIBUTE, SUMS, VECTOR, LOAD, STEP)                                                         \
    ATTRIBUTE static float NAME(size_t n, const uint32_t *seed) {                                                      \
        VECTOR sum[SUMS], stored[SUMS];                                                                                \
        UNROLL for (int i = 0; i < SUMS; ++i) sum[i] = LOAD(seed + i);                                                 \
        const VECTOR x = LOAD(seed), y = LOAD(seed + 16);                                                              \
        for (size_t k = 0; k < n; ++k)                                                                                 \
            UNROLL for (int i = 0; i < SUMS; ++i) sum[i] = STEP(sum[i], x, y);                                         \
        UNROLL for (int i = 0; i < SUMS; ++i) stored[i] = sum[i];                                                      \
        float total = 0;                                                                                               \
        for (size_t i = 0; i < sizeof stored / (sizeof(float)); ++i) {                                                 \
            float value;                                                                                               \
            memcpy(&value, (const char *)stored + i * sizeof value, sizeof value);                                     \
            total += value;                                                                                            \
        }                                                                                                              \
        return total;                                                                                                  \
    }

/* NOLINTEND(bugprone-macro-parentheses) */

typedef float vector_4f __attribute__((vector_size(16), may_alias, aligned(4)));
#define LOAD_128(p)         (*(const vector_4f *)(const void *)(p))
#define STEP_128(sum, x, y) ((sum) * (x) + (y))
DEFINE_PEAK(peak_f32_any, ANY_TARGET, 12, vector_4f, LOAD_128, STEP_128)

#if defined __x86_64__
#define LOAD_256(p)            _mm256_loadu_ps((const float *)(const void *)(p))
#define STEP_AVX2(sum, x, y)   _mm256_fmadd_ps(sum, x, y)
#define LOAD_512(p)            _mm512_loadu_ps(p)
#define STEP_AVX512(sum, x, y) _mm512_fmadd_ps(sum, x, y)
#define STEP_BF16(sum, x, y)   _mm512_dpbf16_ps(sum, (__m512bh)(x), (__m512bh)(y))
#define AVX512                 "avx512f,avx512bw,avx512dq,avx512vl"
DEFINE_PEAK(peak_f32_avx2, FOR("avx2,fma"), 12, __m256, LOAD_256, STEP_AVX2)
DEFINE_PEAK(peak_f32_avx512, FOR(AVX512), 24, __m512, LOAD_512, STEP_AVX512)
DEFINE_PEAK(peak_bf16_avx512, FOR(AVX512 ",avx512bf16"), 24, __m512, LOAD_512, STEP_BF16)
#elif defined __aarch64__
#define LOAD_NEON(p)         vld1q_f32((const float *)(const void *)(p))
#define STEP_NEON(sum, x, y) vfmaq_f32(y, sum, x)
DEFINE_PEAK(peak_f32_neon, ANY_TARGET, 24, float32x4_t, LOAD_NEON, STEP_NEON)
#endif

/* Operations of a step: 2 for each multiply-add, accumulators, lanes; a lane of a dot product has 2 factors. */
const nqm_bench_unit nqm_bench_units[] = {
    {"128-bit multiply, add", NQM_PRECISION_F32, &nqm_kernels_generic, peak_f32_any, 2 * 12 * 4},
#if defined __x86_64__
    {"AVX2 FMA", NQM_PRECISION_F32, &nqm_kernels_avx2, peak_f32_avx2, 2 * 12 * 8},
    {"AVX-512 FMA", NQM_PRECISION_F32, &nqm_kernels_avx512, peak_f32_avx512, 2 * 24 * 16},
    {"AVX512-BF16 VDPBF16PS", NQM_PRECISION_BF16, &nqm_kernels_avx512_bf16, peak_bf16_avx512, 2 * 24 * 32},
#elif defined __aarch64__
    {"NEON FMA", NQM_PRECISION_F32, &nqm_kernels_generic, peak_f32_neon, 2 * 24 * 4},
#endif
    {0},
};

bool nqm_bench_has_unit(const nqm_bench_unit *unit) {
    size_t i = 0;
    while (nqm_kernels_at(i) && nqm_kernels_at(i) != unit->kernels)
        ++i;
    return nqm_kernels_at(i) != NULL;
}

NQM_FOR_EACH_VECTOR_WIDTH
uint64_t nqm_bench_read(size_t n_bytes, const void *data) {
    typedef uint64_t vector __attribute__((vector_size(64), may_alias));
    enum { SUMS = 4, LANES = sizeof(vector) / sizeof(uint64_t) };
    const vector *from = data, *end = from + n_bytes / sizeof *from;
    vector sum[SUMS] = {{0}};
    for (; from < end; from += SUMS)
        UNROLL for (int i = 0; i < SUMS; ++i) sum[i] ^= from[i];
    sum[0] ^= sum[1] ^ sum[2] ^ sum[3];
    uint64_t total = 0;
    for (size_t i = 0; i < LANES; ++i)
        total ^= sum[0][i];
    return total;
}
