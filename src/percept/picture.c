/* SPDX-License-Identifier: MIT
 *
 * Few points of the pictures of scenes: what a display shows of their light, the label of two pictures, and its gradient.
 */
#include "base/os.h"
#include "percept/percept.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

size_t nqm_picture_scene_end(const nqm_picture_points *points, size_t first) {
    size_t end = first + 1;
    while (end < points->n && !(points->at[3 * end + 1] > points->at[3 * first + 1]))
        ++end;
    return end;
}

double nqm_picture_share(const nqm_picture_points *points) {
    return 1 / (1 + points->at[3 * points->n - 2]);
}

/* ---- in float ---------------------------------------------------------------------------------------------------- */

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

/* y (3, n) = the sums of rows k of m times channels k of x (3, n). */
static void multiply_points(float m[3][3], size_t n, const float *x, float *y) {
    for (size_t i = 0; i < 3; ++i)
#pragma omp simd
        for (size_t p = 0; p < n; ++p)
            y[i * n + p] = m[0][i] * x[p] + m[1][i] * x[n + p] + m[2][i] * x[2 * n + p];
}

void nqm_picture_show_block(const nqm_picture_points *points, size_t first, size_t n, float *picture) {
    float lms[3 * NQM_PICTURE_BLOCK];
    pthread_once(&tables_once, fill_tables);
    for (size_t p = 0; p < n; ++p) {
        const float peak = (float)points->at[3 * (first + p) + 2];
        for (float *x = picture + p; x < picture + 3 * n; x += n)
            *x = *x < peak ? *x : peak;
    }
    multiply_points(lms_of, n, picture, lms);
    for (size_t i = 0; i < 3 * n; ++i)
        lms[i] = pq_signal(lms[i]);
    multiply_points(itp_of, n, lms, picture);
}

/* ---- in double --------------------------------------------------------------------------------------------------- */

void nqm_picture_show(const nqm_picture_points *points, const double *rgb, double *itp) {
    const size_t n = points->n;
    for (size_t p = 0; p < n; ++p) {
        double shown[3], lms[3], point[3], slope;
        for (size_t k = 0; k < 3; ++k)
            shown[k] = fmin(rgb[k * n + p], points->at[3 * p + 2]);
        nqm_lms_from_rgb(shown, lms);
        for (size_t k = 0; k < 3; ++k)
            lms[k] = nqm_pq_interpolate(lms[k], &slope);
        nqm_itp_from_pq_lms(lms, point);
        for (size_t k = 0; k < 3; ++k)
            itp[k * n + p] = NQM_ITP_UNIT * point[k];
    }
}

static void point_of(const double *picture, size_t n, size_t p, double *point) {
    for (size_t k = 0; k < 3; ++k)
        point[k] = picture[k * n + p];
}

/* The sums of the scene that begins at point `first`; *end receives the point after it. */
static nqm_picture_sums sum_scene(const nqm_picture_points *points, size_t first, const double *ref, const double *test,
                                  size_t *end) {
    nqm_picture_sums sums = {0};
    *end = nqm_picture_scene_end(points, first);
    for (size_t p = first; p < *end; ++p) {
        double a[3], b[3];
        point_of(ref, points->n, p, a);
        point_of(test, points->n, p, b);
        nqm_picture_sums_add(&sums, points->at[3 * p], a, b);
    }
    return sums;
}

nqm_label nqm_picture_label(const nqm_picture_points *points, const double *ref, const double *test) {
    nqm_label mean = {.delta_e = 0};
    for (size_t first = 0, end; first < points->n; first = end) {
        const nqm_picture_sums sums = sum_scene(points, first, ref, test, &end);
        const nqm_label label = nqm_picture_sums_label(&sums);
        nqm_label_add(&mean, nqm_picture_share(points), &label);
    }
    return mean;
}

/* The gradient by the light (3) of point p. */
static void point_gradient(const nqm_picture_points *points, const nqm_picture_sums *sums, const nqm_label *weights,
                           size_t p, const nqm_shown_pair *pair, double *by_light) {
    const size_t n = points->n;
    const double peak = points->at[3 * p + 2], weight = points->at[3 * p] * nqm_picture_share(points) * NQM_ITP_UNIT;
    double a[3], b[3], by_itp[3], by_rgb[3], shown[3];
    point_of(pair->ref, n, p, a);
    point_of(pair->test, n, p, b);
    nqm_picture_gradient(sums, weights, weight, a, b, by_itp);
    for (size_t k = 0; k < 3; ++k)
        shown[k] = fmin(pair->light[k * n + p], peak);
    nqm_rgb_gradient(shown, by_itp, by_rgb);
    for (size_t k = 0; k < 3; ++k)
        by_light[k * n + p] = pair->light[k * n + p] < peak ? by_rgb[k] : 0;
}

void nqm_picture_light_gradient(const nqm_picture_points *points, const nqm_label *weights, const nqm_shown_pair *pair,
                                double *by_light) {
    for (size_t first = 0, end; first < points->n; first = end) {
        const nqm_picture_sums sums = sum_scene(points, first, pair->ref, pair->test, &end);
        for (size_t p = first; p < end; ++p)
            point_gradient(points, &sums, weights, p, pair, by_light);
    }
}
