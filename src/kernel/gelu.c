/* SPDX-License-Identifier: MIT
 *
 * GELU (Hendrycks and Gimpel 2016, arXiv:1606.08415) and its slope, in float, written so that a compiler vectorises it.
 *
 * One exponential serves both: e = exp(-x^2/2) is the density phi up to a constant, and Abramowitz and Stegun 7.1.26
 * (1964, after Hastings 1955) gives erfc(u) = (a1 t + .. + a5 t^5) exp(-u^2), t = 1/(1 + p u), with an error
 * below 1.5e-7, where u = |x|/sqrt(2) makes exp(-u^2) that same e.
 */
#include "kernel/kernel.h"

#include <math.h>
#include <string.h>

/* exp(x) for x <= 0, within 1.5 ulp; below -87 it stays at exp(-87) = 1.6e-38 rather than enter the denormals. */
static inline float exp_negative(float x) {
    const float log2_e = 1.44269504f, ln2_high = 0.693359375f, ln2_low = -2.12194440e-4f; /* Cody and Waite 1980 */
    const float round_magic = 0x1.8p23f; /* adding it leaves the nearest integer in the low bits */
    x = x < -87.0f ? -87.0f : x;
    float shifted = x * log2_e + round_magic;
    float n = shifted - round_magic;
    float r = (x - n * ln2_high) - n * ln2_low; /* |r| <= ln(2)/2 */
    float p = 1.0f / 720.0f;                    /* the Taylor series to r^6: its remainder is 1.2e-7 relative */
    p = p * r + 1.0f / 120.0f;
    p = p * r + 1.0f / 24.0f;
    p = p * r + 1.0f / 6.0f;
    p = p * r + 0.5f;
    p = p * r + 1.0f;
    p = p * r + 1.0f;
    uint32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 127) << 23; /* 2^n: the integer in the low bits becomes the exponent */
    float scale;
    memcpy(&scale, &bits, sizeof scale);
    return p * scale;
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
