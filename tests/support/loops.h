/* SPDX-License-Identifier: MIT
 *
 * loops.h - the loops of sample/loops.c as the library selects them, and compiled again for each width of vectors.
 */
#ifndef NQM_TESTS_LOOPS_H
#define NQM_TESTS_LOOPS_H

#include "base/base.h"

/** The functions nqm_sample_*() of one width. */
typedef struct sample_loops {
    void (*logs)(size_t n, const float *rho, float *root, float *t);
    void (*scale)(size_t n, float k1, const float *t, float *scaled);
    void (*log_ratios)(size_t n, const float *offset, const float *x, const float *y, float *ratio);
    void (*root_differences)(size_t n, const float *scale, const float *x, const float *y, const float *root_x,
                             const float *root_y, float *difference);
    void (*limit)(size_t n, float limit, const float *x, float *y);
    void (*differences)(size_t n, float s, const float *a, const float *b, float *difference, float *magnitude);
    void (*sums)(size_t n, const float *x, float *magnitudes, float *squares);
    void (*whiten)(size_t n, const float *mean, const float *scale, const float *t, float *x);
    float (*nearest)(size_t n, size_t n_blocks, const float *points, const float *y);
} sample_loops;
extern const sample_loops loops_plain, loops_avx2, loops_avx512;

/** Those that the library uses, then those of each width that this processor has; NULL beyond. */
const sample_loops *sample_loops_at(size_t i);

#endif
