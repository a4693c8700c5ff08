/* SPDX-License-Identifier: MIT
 *
 * An estimate of the label of two sampled BRDFs without a network. In a scene with fixed light the radiance of every point is
 * linear in the BRDF (precomputed radiance transfer: Sloan et al. 2002, DOI 10.1145/566654.566612), so a matrix makes a picture
 * of few points from samples; the label of two such pictures is the estimate. nqm dataset makes the matrix
 * (label/corpus_transport.c); models correct the estimate.
 */
#include "math/math.h"
#include "metric/metric.h"
#include "percept/percept.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

enum { POINTS = NQM_TRANSPORT_POINTS };

/* ---- the PQ signal from a table ---------------------------------------------------------------------------------- */

/* Linear interpolation between 64 values an octave, within 4e-6 of the function, which takes two powers. */
enum { FIRST_OCTAVE = -20, LAST_OCTAVE = 14, STEPS = 64, N_TABLE = (LAST_OCTAVE - FIRST_OCTAVE) * STEPS };
static float pq_table[N_TABLE + 1];
static pthread_once_t pq_once = PTHREAD_ONCE_INIT;

static void fill_pq_table(void) {
    for (int i = 0; i <= N_TABLE; ++i)
        pq_table[i] = (float)nqm_pq_from_luminance(ldexp(1 + (double)(i % STEPS) / STEPS, FIRST_OCTAVE + i / STEPS));
}

static float pq_signal(float luminance) {
    enum { MANTISSA_BITS = 23, STEP_BITS = 6, REST_BITS = MANTISSA_BITS - STEP_BITS };
    const float least = 0x1p-20F, most = 10000;
    uint32_t bits;
    luminance = luminance > least ? luminance < most ? luminance : most : least;
    memcpy(&bits, &luminance, sizeof bits);
    const uint32_t cell = (bits >> REST_BITS) - ((uint32_t)(127 + FIRST_OCTAVE) << STEP_BITS);
    const float t = (float)(bits & ((1U << REST_BITS) - 1)) * (1.0F / (float)(1U << REST_BITS));
    return pq_table[cell] + t * (pq_table[cell + 1] - pq_table[cell]);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Points of one task of the matrix product: as many as vector registers hold. */
enum { AT_ONCE = 32 };

/* One channel of points [first, first + AT_ONCE). f: (n_directions, 3). */
static void transport_points(const nqm_transport *t, size_t channel, size_t first, const float *f, float *radiance) {
    float sum[AT_ONCE] = {0};
    const float *row = t->light + channel * POINTS + first;
    for (size_t k = 0; k < t->n_directions; ++k, row += 3 * POINTS)
        for (size_t p = 0; p < AT_ONCE; ++p)
            sum[p] += f[3 * k + channel] * row[p];
    memcpy(radiance + channel * POINTS + first, sum, sizeof sum);
}

void nqm_transport_picture(const nqm_transport *t, const float *rgb, const float *instead, const uint8_t *used,
                           double *itp) {
    enum { BLOCK = 64 };
    float radiance[3 * POINTS] = {0};
    pthread_once(&pq_once, fill_pq_table);
    for (size_t first = 0; first < t->n_directions; first += BLOCK) {
        const size_t n = nqm_smaller(t->n_directions - first, BLOCK);
        float f[3 * BLOCK], part[3 * POINTS];
        for (size_t k = 0; k < 3 * n; ++k)
            f[k] = !used || used[first + k / 3] ? rgb[3 * first + k] : instead[3 * first + k];
        const nqm_transport stretch = {n, t->light + first * 3 * POINTS, NULL};
        for (size_t channel = 0; channel < 3; ++channel)
            for (size_t p = 0; p < POINTS; p += AT_ONCE)
                transport_points(&stretch, channel, p, f, part);
        for (size_t i = 0; i < 3 * POINTS; ++i)
            radiance[i] += part[i];
    }
    for (size_t p = 0; p < POINTS; ++p) {
        const float peak = (float)t->points[3 * p + 2];
        double shown[3], lms[3];
        for (size_t channel = 0; channel < 3; ++channel)
            shown[channel] = (double)fminf(radiance[channel * POINTS + p], peak);
        nqm_lms_from_rgb(shown, lms);
        for (size_t k = 0; k < 3; ++k)
            lms[k] = NQM_ITP_UNIT * (double)pq_signal((float)lms[k]);
        nqm_itp_from_pq_lms(lms, itp + 3 * p);
    }
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

nqm_label nqm_transport_compare(const nqm_transport *t, const double *ref_itp, const double *test_itp) {
    nqm_label mean = {.delta_e = 0};
    const double share = 1 / (1 + t->points[3 * POINTS - 2]); /* one over the number of scenes */
    for (size_t p = 0; p < POINTS;) {
        nqm_picture_sums sums = {0};
        const double scene = t->points[3 * p + 1];
        for (; p < POINTS && t->points[3 * p + 1] <= scene; ++p)
            nqm_picture_sums_add(&sums, t->points[3 * p], ref_itp + 3 * p, test_itp + 3 * p);
        const nqm_label label = nqm_picture_sums_label(&sums);
        nqm_label_add(&mean, share, &label);
    }
    return mean;
}

nqm_label nqm_transport_estimate(const nqm_transport *t, const float *ref, const float *test, const uint8_t *used) {
    double ref_itp[3 * POINTS], test_itp[3 * POINTS];
    nqm_transport_picture(t, ref, ref, NULL, ref_itp);
    nqm_transport_picture(t, test, ref, used, test_itp);
    return nqm_transport_compare(t, ref_itp, test_itp);
}
