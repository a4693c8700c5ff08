/* SPDX-License-Identifier: MIT
 *
 * An estimate of the label of two sampled BRDFs without a network. In a scene with fixed light the radiance of every point is
 * linear in the BRDF (precomputed radiance transfer: Sloan et al. 2002, DOI 10.1145/566654.566612), so a matrix makes a picture
 * of few points from samples; the label of two such pictures is the estimate. nqm dataset makes the matrix
 * (label/corpus_transport.c); models correct the estimate.
 */
#include "kernel/kernel.h"
#include "math/math.h"
#include "metric/metric.h"
#include "percept/percept.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

enum { POINTS = NQM_TRANSPORT_POINTS };

_Static_assert(POINTS % NQM_PANEL == 0, "the kernel computes whole panels");

/* ---- colours in float -------------------------------------------------------------------------------------------- */

/* Linear interpolation between 64 values an octave, within 4e-6 of the function, which takes two powers. Luminances below the
 * first octave have its signal, 6e-6. */
enum { FIRST_OCTAVE = -30, LAST_OCTAVE = 14, STEPS = 64, N_TABLE = (LAST_OCTAVE - FIRST_OCTAVE) * STEPS };
static float pq_table[N_TABLE + 1];
static float lms_of[3][3]; /* row k: LMS of 1 cd/m2 of channel k */
static float itp_of[3][3]; /* row k: ITP, in units of Delta-E, of a signal of 1 in channel k of LMS */
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

static void fill_tables(void) {
    for (int i = 0; i <= N_TABLE; ++i)
        pq_table[i] = (float)nqm_pq_from_luminance(ldexp(1 + (double)(i % STEPS) / STEPS, FIRST_OCTAVE + i / STEPS));
    for (int k = 0; k < 3; ++k) {
        const double unit[3] = {k == 0, k == 1, k == 2};
        double lms[3], itp[3];
        nqm_lms_from_rgb(unit, lms);
        nqm_itp_from_pq_lms(unit, itp);
        for (int i = 0; i < 3; ++i) {
            lms_of[k][i] = (float)lms[i];
            itp_of[k][i] = (float)(NQM_ITP_UNIT * itp[i]);
        }
    }
}

static float pq_signal(float luminance) {
    enum { MANTISSA_BITS = 23, STEP_BITS = 6, REST_BITS = MANTISSA_BITS - STEP_BITS };
    const float least = 0x1p-30F, most = 10000;
    uint32_t bits;
    luminance = luminance > least ? luminance < most ? luminance : most : least;
    memcpy(&bits, &luminance, sizeof bits);
    const uint32_t cell = (bits >> REST_BITS) - ((uint32_t)(127 + FIRST_OCTAVE) << STEP_BITS);
    const float t = (float)(bits & ((1U << REST_BITS) - 1)) * (1.0F / (float)(1U << REST_BITS));
    return pq_table[cell] + t * (pq_table[cell + 1] - pq_table[cell]);
}

/* y (3, POINTS) = the sums of rows k of m times channels k of x (3, POINTS). */
static void multiply_points(float m[3][3], const float *x, float *y) {
    for (size_t i = 0; i < 3; ++i)
#pragma omp simd
        for (size_t p = 0; p < POINTS; ++p)
            y[i * POINTS + p] = m[0][i] * x[p] + m[1][i] * x[POINTS + p] + m[2][i] * x[2 * POINTS + p];
}

/* picture (3, POINTS), in: RGB radiance in cd/m2; out: ITP on the display, in units of Delta-E. */
static void see(const nqm_transport *t, float *picture) {
    float lms[3 * POINTS];
    for (size_t p = 0; p < POINTS; ++p) {
        const float peak = (float)t->points[3 * p + 2];
        for (float *x = picture + p; x < picture + 3 * POINTS; x += POINTS)
            *x = *x < peak ? *x : peak;
    }
    multiply_points(lms_of, picture, lms);
    for (size_t i = 0; i < 3 * POINTS; ++i)
        lms[i] = pq_signal(lms[i]);
    multiply_points(itp_of, lms, picture);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Directions of one pass over the pictures: their rows of the matrix stay in the L2 cache. */
enum { BLOCK = 64 };

/* Add the light of directions [first, first + n_block) to n pictures. */
static void add_directions(const nqm_transport *t, size_t first, size_t n_block, size_t n,
                           const nqm_transport_samples *samples, float *pictures) {
    const nqm_kernels *kernels = nqm_kernels_get();
    float f[NQM_TRANSPORT_MAX * 3 * BLOCK];
    for (size_t i = 0; i < n; ++i) {
        const nqm_transport_samples *s = &samples[i];
        memcpy(f + i * 3 * BLOCK, s->rgb + 3 * first, 3 * n_block * sizeof *f);
        for (size_t k = 0; s->used && k < n_block; ++k)
            if (!s->used[first + k])
                memcpy(f + 3 * (i * BLOCK + k), s->instead + 3 * (first + k), 3 * sizeof *f);
    }
    for (size_t column = 0; column < 3 * POINTS; column += NQM_PANEL)
        kernels->strided_product(&(nqm_strided_product){.m = n,
                                                        .k = n_block,
                                                        .add = first > 0,
                                                        .a = f + column / POINTS,
                                                        .lda = 3 * BLOCK,
                                                        .step = 3,
                                                        .b = t->light + first * 3 * POINTS + column,
                                                        .ldb = 3 * POINTS,
                                                        .c = pictures + column,
                                                        .ldc = 3 * POINTS});
}

void nqm_transport_pictures(const nqm_transport *t, size_t n, const nqm_transport_samples *samples, float *pictures) {
    pthread_once(&tables_once, fill_tables);
    for (size_t first = 0; first < t->n_directions; first += BLOCK)
        add_directions(t, first, nqm_smaller(t->n_directions - first, BLOCK), n, samples, pictures);
    for (size_t i = 0; i < n; ++i)
        see(t, pictures + i * 3 * POINTS);
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

nqm_label nqm_transport_compare(const nqm_transport *t, const float *ref, const float *test) {
    nqm_label mean = {.delta_e = 0};
    const double share = 1 / (1 + t->points[3 * POINTS - 2]); /* one over the number of scenes */
    for (size_t p = 0; p < POINTS;) {
        nqm_picture_sums sums = {0};
        const double scene = t->points[3 * p + 1];
        for (; p < POINTS && t->points[3 * p + 1] <= scene; ++p) {
            const double a[3] = {(double)ref[p], (double)ref[POINTS + p], (double)ref[2 * POINTS + p]};
            const double b[3] = {(double)test[p], (double)test[POINTS + p], (double)test[2 * POINTS + p]};
            nqm_picture_sums_add(&sums, t->points[3 * p], a, b);
        }
        const nqm_label label = nqm_picture_sums_label(&sums);
        nqm_label_add(&mean, share, &label);
    }
    return mean;
}

void nqm_transport_estimates(const nqm_transport *t, size_t n, const float *const *ref, const float *const *test,
                             const uint8_t *used, nqm_label *estimates) {
    nqm_transport_samples samples[NQM_TRANSPORT_MAX] = {{0}};
    float pictures[NQM_TRANSPORT_MAX * 3 * POINTS];
    size_t n_pictures = 0, ref_at[NQM_COMPARE_MAX], test_at[NQM_COMPARE_MAX]; /* pictures of pair i */
    for (size_t i = 0; i < n; ++i) {
        const bool is_shared = i > 0 && ref[i] == ref[i - 1];
        ref_at[i] = is_shared ? ref_at[i - 1] : n_pictures;
        if (!is_shared)
            samples[n_pictures++] = (nqm_transport_samples){.rgb = ref[i]};
        test_at[i] = n_pictures;
        samples[n_pictures++] = (nqm_transport_samples){
            .rgb = test[i], .instead = ref[i], .used = used ? used + i * t->n_directions : NULL};
    }
    nqm_transport_pictures(t, n_pictures, samples, pictures);
    for (size_t i = 0; i < n; ++i)
        estimates[i] = nqm_transport_compare(t, pictures + ref_at[i] * 3 * POINTS, pictures + test_at[i] * 3 * POINTS);
}
