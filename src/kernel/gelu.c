/* SPDX-License-Identifier: MIT
 *
 * GELU (Hendrycks and Gimpel 2016, arXiv:1606.08415) and its slope, in float, written so that a compiler vectorises it.
 *
 * One exponential serves both: e = exp(-x^2/2) is the density phi up to a constant, and Abramowitz and Stegun 7.1.26
 * (1964, after Hastings 1955) gives erfc(u) = (a1 t + .. + a5 t^5) exp(-u^2), t = 1/(1 + p u), with an error
 * below 1.5e-7, where u = |x|/sqrt(2) makes exp(-u^2) that same e.
 */
#include "kernel/exp_log.h"
#include "kernel/kernel.h"

#include <math.h>

/* exp(x) for x <= 0; below -87 it stays at exp(-87) = 1.6e-38 rather than enter the denormals. */
static inline float exp_negative(float x) {
    return nqm_exp_core(x < -87.0f ? -87.0f : x);
}

typedef struct normal {
    float distribution, density; /* Phi(x), phi(x) */
} normal;

static inline normal normal_at(float x) {
    const float p = 0.3275911f * 0.70710678f;
    float e = exp_negative(-0.5f * x * x);
    float t = 1.0f / (1.0f + p * fabsf(x));
    float poly = 1.061405429f;
    poly = poly * t - 1.453152027f;
    poly = poly * t + 1.421413741f;
    poly = poly * t - 0.284496736f;
    poly = poly * t + 0.254829592f;
    float upper_tail = 0.5f * poly * t * e; /* 1 - Phi(|x|) */
    return (normal){x > 0.0f ? 1.0f - upper_tail : upper_tail, 0.398942280f * e};
}

void nqm_gelu(size_t n, const float *x, float *y, float *slope) {
    if (!slope) {
#pragma omp simd
        for (size_t i = 0; i < n; ++i)
            y[i] = x[i] * normal_at(x[i]).distribution;
        return;
    }
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        normal at = normal_at(x[i]);
        slope[i] = at.distribution + x[i] * at.density;
        y[i] = x[i] * at.distribution;
    }
}
