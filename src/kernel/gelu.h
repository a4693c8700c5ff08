/* SPDX-License-Identifier: MIT
 *
 * gelu.h - GELU (Hendrycks and Gimpel 2016, arXiv:1606.08415) for one instruction set, written so that compilers
 * vectorise the loops that it is inlined into; included by isa_rows.h.
 *
 * With the tail t(a) = 1 - Phi(a) of the normal distribution at a = |x|, GELU is max(x, 0) - a t and its slope is
 * 1/2 +- (1/2 - t w), w(a) = 1 - a phi(a) / t(a). log2(t) and w are smooth: polynomials of degree 8 give t within 1e-8 and
 * t w within 6e-8, one of degree 5 a power of two within 1e-7 relative (gelu_fit.py). There is no division, no
 * branch but the minimum of two integers, and little loss by rounding.
 */
#include "kernel/multiply_add.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A polynomial with coefficients c (n), the constant first. Even and odd powers are two chains: half the latency of one. */
#define POLYNOMIAL(x, c) polynomial(x, c, sizeof(c) / sizeof *(c))
static inline __attribute__((always_inline)) float polynomial(float x, const float *c, size_t n) {
    const float square = x * x;
    float last = c[n - 1], before = c[n - 2];
#pragma GCC unroll 8
    for (size_t i = n - 2; i-- > 0;) {
        float next = nqm_multiply_add(last, square, c[i]);
        last = before;
        before = next;
    }
    return nqm_multiply_add(last, x, before);
}

static const float log2_tail[] = {-9.999999783e-01f, -1.151105724e+00f, -4.592049073e-01f,
                                  -5.250502851e-02f, 7.075471423e-03f,  -1.458698044e-04f,
                                  -1.825477657e-04f, 3.862078767e-05f,  -2.772053057e-06f};
static const float power_of_2[] = {
    1.0f, 6.931469776e-01f, 2.402224208e-01f, 5.550733744e-02f, 9.671512661e-03f, 1.326472690e-03f};
static const float slope_of_tail[] = {1.0f,
                                      -7.978902255e-01f,
                                      -6.365370444e-01f,
                                      -1.094041442e-01f,
                                      2.001794219e-02f,
                                      -8.737779471e-04f,
                                      -5.806268996e-04f,
                                      1.441940931e-04f,
                                      -1.128838868e-05f};

static inline int32_t bits_of(float x) {
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline float float_of(int32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* 2^x for -250 <= x <= 100; 0 below the range of float. */
static inline float power_of_two(float x) {
    const float round_magic = 0x1.8p23f; /* adding it leaves the nearest integer in the low bits */
    const float shifted = x + round_magic;
    const float power = POLYNOMIAL(x - (shifted - round_magic), power_of_2);
    const int32_t bits = (int32_t)((uint32_t)bits_of(power) + ((uint32_t)bits_of(shifted) << 23)); /* to the exponent */
    return float_of(bits > 0 ? bits : 0);
}

/* The bits of positive floats have the same order as the floats, and integers compare faster. Beyond 10.5 the tail is 0. */
static inline float gelu_of(float x, float *slope) {
    const float a = fabsf(x);
    const int32_t end = 0x41280000;
    const float inside = float_of(bits_of(a) < end ? bits_of(a) : end);
    const float t = power_of_two(POLYNOMIAL(inside, log2_tail));
    if (slope) {
        const float centre = nqm_multiply_add(x, 0.0f, 0.5f); /* keeps a NaN */
        *slope = centre + copysignf(0.5f - t * POLYNOMIAL(inside, slope_of_tail), x);
    }
    return nqm_multiply_add(-a, t, float_of(bits_of(x) > 0 ? bits_of(x) : 0));
}

/* n values, fastest for a multiple of the vector width. */
static inline void gelu_stretch(size_t n, const float *x, float *y, float *slope) {
    if (!slope) {
#pragma omp simd
        for (size_t i = 0; i < n; ++i)
            y[i] = gelu_of(x[i], NULL);
        return;
    }
#pragma omp simd
    for (size_t i = 0; i < n; ++i) {
        float slope_here;
        y[i] = gelu_of(x[i], &slope_here);
        slope[i] = slope_here;
    }
}

enum { STRETCH = 16 };

/* The last values are filled up to whole vectors, since a scalar loop over 15 of them takes as long as hundreds. */
static void gelu(size_t n, const float *x, float *y, float *slope) {
    const size_t whole = n / STRETCH * STRETCH, left = n - whole;
    gelu_stretch(whole, x, y, slope);
    if (left == 0)
        return;
    float last_x[STRETCH] = {0}, last_y[STRETCH], last_slope[STRETCH];
    memcpy(last_x, x + whole, left * sizeof *x);
    gelu_stretch(STRETCH, last_x, last_y, slope ? last_slope : NULL);
    memcpy(y + whole, last_y, left * sizeof *y);
    if (slope)
        memcpy(slope + whole, last_slope, left * sizeof *slope);
}
