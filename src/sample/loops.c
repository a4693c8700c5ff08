/* SPDX-License-Identifier: MIT
 *
 * Loops over samples that compilers vectorise (loops.h). Nothing in them is reordered or fused, so that every width of vectors
 * gives the same bits.
 */
#include "sample/loops.h"
#include "math/exp_log.h"

#include <math.h>

#define UNROLL _Pragma("GCC unroll 16")
#define INLINE static inline __attribute__((always_inline)) /* into each width's copy of a loop */

/* The cube root of x >= 1e-30 within 6 %: divides the exponent by 3 in the bits of x (Kahan 1991). */
INLINE float rough_cube_root(float x) {
    uint32_t bits;
    float root;
    memcpy(&bits, &x, sizeof bits);
    bits = (uint32_t)(int32_t)((float)(int32_t)bits * (1.0f / 3.0f)) + 709921077u;
    memcpy(&root, &bits, sizeof root);
    return root;
}

/* One step of Halley's iteration for the cube root: the error becomes 2/3 of its cube. */
#define CUBE_ROOT_STEP(root, x)                                                                                        \
    ((root) - (root) * (((root) * (root) * (root) - (x)) / (2 * (root) * (root) * (root) + (x))))

/* log(b / a) of positive a and b, whose difference is d. For b = 2^k a m, m in [2/3, 3/2]: log(b / a) = k log(2) + 2 artanh(s),
 * s = (b - 2^k a) / (b + 2^k a), |s| <= 1/5. k is the difference of the bits of a and b as integers, which are nearly
 * proportional to their logarithms, rounded. With k = 0, s has the relative error of d; otherwise b - 2^k a is exact. The first
 * term of the series that is left out is below 1e-8. */
INLINE float log_quotient(float a, float b, float d) {
    uint32_t from, to, difference, other;
    float scaled;
    memcpy(&from, &a, sizeof from);
    memcpy(&to, &b, sizeof to);
    const uint32_t power = (to - from + 0x400000) & 0xff800000; /* 2^23 k */
    from += power;
    memcpy(&scaled, &from, sizeof scaled);
    float far = b - scaled;
    memcpy(&difference, &far, sizeof difference);
    memcpy(&other, &d, sizeof other);
    const uint32_t is_far = (uint32_t) - (int32_t)(power != 0); /* a mask: for `power ? far : d` GCC divides twice */
    difference = (difference & is_far) | (other & ~is_far);
    memcpy(&d, &difference, sizeof d);
    float s = d / (b + scaled), z = s * s;
    float p = ((z * (1.0f / 9) + 1.0f / 7) * z + 1.0f / 5) * z + 1.0f / 3;
    s += s;
    return (float)(int32_t)power * (0.69314718f * 0x1p-23f) + (s + s * (z * p));
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_log_ratios(size_t n, const float *offset, const float *x, const float *y, float *ratio) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        ratio[i] = log_quotient(x[i] + offset[i], y[i] + offset[i], y[i] - x[i]);
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_limit(size_t n, float limit, const float *x, float *y) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        y[i] = x[i] < limit ? x[i] : limit;
}

/* With a = cbrt(x) and b = cbrt(y): b - a = (y - x) / (a a + a b + b b). Roots below 1e-10 are 0. */
NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_root_differences(size_t n, const float *scale, const float *x, const float *y, const float *root_x,
                                 const float *root_y, float *difference) {
    const float least = 1e-20f;
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        const float a = root_x[i], b = root_y[i], sum = a * a + a * b + b * b;
        difference[i] = scale[i] * (y[i] - x[i]) / (sum > least ? sum : least);
    }
}

/* Values per turn of the loops below. Several loops with short chains of operations take less time than one, which is bound by
 * the latency of its long chain. */
enum { ROOTS_AT_ONCE = 128 };

INLINE void sample_log_stretch(size_t n, const float *rho, float *roots, float *t) {
    const float least = 1e-30f, most = 1e37f;
    float x[ROOTS_AT_ONCE], root[ROOTS_AT_ONCE];
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        x[i] = rho[i] < least ? least : rho[i];
        x[i] = x[i] > most ? most : x[i];
        root[i] = rough_cube_root(x[i]);
    }
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        root[i] = CUBE_ROOT_STEP(root[i], x[i]);
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        root[i] = CUBE_ROOT_STEP(root[i], x[i]);
        root[i] = rho[i] < least ? 0.0f : root[i];
    }
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        roots[i] = root[i];
        t[i] = log_quotient(1.0f, 1.0f + root[i], root[i]);
    }
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_logs(size_t n, const float *rho, float *roots, float *t) {
    size_t i = 0;
    for (; i + ROOTS_AT_ONCE <= n; i += ROOTS_AT_ONCE)
        sample_log_stretch(ROOTS_AT_ONCE, rho + i, roots + i, t + i);
    sample_log_stretch(n - i, rho + i, roots + i, t + i);
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_whiten(size_t n, const float *mean, const float *scale, const float *t, float *x) {
    for (size_t m; n > 0; n -= m, t += m, x += m) {
        m = nqm_smaller(n, NQM_WHITEN_PERIOD);
#pragma omp simd
        for (size_t i = 0; i < m; ++i)
            x[i] = (t[i] - mean[i]) * scale[i];
    }
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_differences(size_t n, float s, const float *a, const float *b, float *difference, float *magnitude) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float d = b[i] - a[i];
        difference[i] = s * d;
        magnitude[i] = s * fabsf(d);
    }
}

/* exp(x) for x <= 0; 0 below -80, since products with denormal results take three times as long. */
INLINE float exp_negative(float x) {
    float e = nqm_exp_core(x < -80.0f ? -80.0f : x);
    return x < -80.0f ? 0.0f : e;
}

/* With c = cbrt(f_r) and k = 1 + k1: log(k c + 1) = t + log(1 + k1 c / (c + 1)), where c / (c + 1) = 1 - exp(-t). Since
 * |k1| <= 0.018, four terms of the series of log(1 + a) have an error below 4e-10. */
NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_scale(size_t n, float k1, const float *t, float *scaled) {
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float a = k1 * (1.0f - exp_negative(-t[i]));
        scaled[i] = t[i] + a * (1.0f - a * (0.5f - a * (1.0f / 3.0f - a * 0.25f)));
    }
}

/* Vectors of 64 bytes, which compilers cut where registers are narrower: a type of GCC and Clang. */
typedef float lanes __attribute__((vector_size(64), aligned(4), may_alias));
typedef uint32_t lanes_of_bits __attribute__((vector_size(64)));
enum { LANES = 16, VECTORS = NQM_SAMPLE_LANES / LANES };
_Static_assert((int)LANES == (int)NQM_POINTS, "a vector of each block");

/* The sum of all partial sums, by halves. By a pointer: clang refuses arguments that are wider than the vectors of the baseline. */
INLINE float add_lanes(const lanes *sum) {
    float half[LANES];
    memcpy(half, sum, sizeof half);
    UNROLL for (size_t n = LANES / 2; n > 0; n /= 2) UNROLL for (size_t j = 0; j < n; ++j) half[j] += half[j + n];
    return half[0];
}

NQM_FOR_EACH_VECTOR_WIDTH
void nqm_sample_sums(size_t n, const float *x, float *magnitudes, float *squares) {
    lanes magnitude[VECTORS] = {{0}}, square[VECTORS] = {{0}};
    for (size_t i = 0; i < n; i += NQM_SAMPLE_LANES)
        for (size_t v = 0; v < VECTORS; ++v) {
            const lanes a = *(const lanes *)(x + i + v * LANES);
            magnitude[v] += (lanes)((lanes_of_bits)a & 0x7fffffffu);
            square[v] += a * a;
        }
    magnitude[0] += magnitude[1];
    square[0] += square[1];
    *magnitudes = add_lanes(&magnitude[0]);
    *squares = add_lanes(&square[0]);
}

NQM_FOR_EACH_VECTOR_WIDTH
float nqm_sample_nearest(size_t n, size_t n_blocks, const float *points, const float *y) {
    float least = INFINITY;
    for (size_t block = 0; block < n_blocks; ++block) {
        lanes sum = {0};
        float square[NQM_POINTS];
        for (size_t k = 0; k < n; ++k, points += NQM_POINTS) {
            const lanes d = *(const lanes *)points - y[k];
            sum += d * d;
        }
        memcpy(square, &sum, sizeof square);
        for (size_t i = 0; i < NQM_POINTS; ++i)
            least = square[i] < least ? square[i] : least;
    }
    return least;
}
