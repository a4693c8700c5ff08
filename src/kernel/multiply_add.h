/* SPDX-License-Identifier: MIT
 *
 * multiply_add.h - a b + c, rounded once on every instruction set, so that rows of hidden layers have the same bits on all of
 * them. Loops that it is inlined into are vectorised by compilers.
 */
#ifndef NQM_SRC_KERNEL_MULTIPLY_ADD_H
#define NQM_SRC_KERNEL_MULTIPLY_ADD_H

#include <stdint.h>
#include <string.h>

#if defined __FMA__ || defined __aarch64__
#define nqm_multiply_add(a, b, c) __builtin_fmaf(a, b, c)
#else
/** In double the product is exact. The sum is rounded to odd, using its rounding error (Knuth 1969); rounding that to float
 *  gives the same result as rounding once (Boldo and Melquiond 2008, DOI 10.1109/TC.2007.70819). */
static inline float nqm_multiply_add(float a, float b, float c) {
    double product = (double)a * (double)b, sum = product + (double)c;
    double rest = sum - product, error = (product - (sum - rest)) + ((double)c - rest);
    int64_t bits;
    memcpy(&bits, &sum, sizeof bits);
    int64_t away = (error > 0) == (sum > 0) ? 1 : -1;
    bits += (error > 0 || error < 0) && bits % 2 == 0 ? away : 0; /* false for a NaN: infinite sums are kept */
    memcpy(&sum, &bits, sizeof sum);
    return (float)sum;
}
#endif

#endif
