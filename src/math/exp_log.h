/* SPDX-License-Identifier: MIT
 *
 * exp_log.h - exp and log in float, written so that compilers vectorise the loops that they are inlined into.
 */
#ifndef NQM_SRC_MATH_EXP_LOG_H
#define NQM_SRC_MATH_EXP_LOG_H

#include <stdint.h>
#include <string.h>

/** exp(x) within 3e-7 relative for -87 <= x <= 87; undefined beyond. */
static inline float nqm_exp_core(float x) {
    const float log2_e = 1.44269504f, ln2_high = 0.693359375f, ln2_low = -2.12194440e-4f; /* Cody and Waite 1980 */
    const float round_magic = 0x1.8p23f; /* adding it leaves the nearest integer in the low bits */
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

/** log(x) of a normal, positive, finite x, within 1e-7 (absolute or relative, whichever is more). The polynomial and the
 *  split of ln 2 are those of logf in Cephes (Moshier 1989). */
static inline float nqm_log_core(float x) {
    static const float tail[] = {-1.1514610310e-1f, 1.1676998740e-1f, -1.2420140846e-1f, 1.4249322787e-1f,
                                 -1.6668057665e-1f, 2.0000714765e-1f, -2.4999993993e-1f, 3.3333331174e-1f};
    const uint32_t sqrt_half = 0x3f3504f3; /* for a mantissa m in [sqrt(1/2), sqrt(2)) */
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int32_t exponent = (int32_t)(bits - sqrt_half) >> 23;
    bits -= (uint32_t)exponent << 23;
    float m, n = (float)exponent;
    memcpy(&m, &bits, sizeof m);
    float t = m - 1.0f, square = t * t;
    float p = 7.0376836292e-2f;
    for (int i = 0; i < 8; ++i)
        p = p * t + tail[i];
    p = p * t * square - 2.12194440e-4f * n - 0.5f * square;
    return t + p + 0.693359375f * n;
}

#endif
