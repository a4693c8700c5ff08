/* SPDX-License-Identifier: MIT
 *
 * Colour difference for high dynamic range: Delta-E ITP of ITU-R BT.2124 on the ICtCp encoding of ITU-R BT.2100 with
 * the PQ curve of SMPTE ST 2084. BT.709 input is converted to BT.2020 primaries with the matrix of ITU-R BT.2087. All
 * matrices have the values printed in the recommendations; their row sums make T = P = 0 for greys.
 */
#include "base/os.h"
#include "math/math.h"
#include "percept/percept.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static const double bt2020_from_bt709[3][3] = {
    {0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0114}, {0.0164, 0.0880, 0.8956}};

/* Times 4096. */
static const double lms_from_bt2020[3][3] = {{1688, 2146, 262}, {683, 2951, 462}, {99, 309, 3688}};

/* Times 4096; the second row is T = Ct / 2. */
static const double itp_from_pq_lms[3][3] = {{2048, 2048, 0}, {3305, -6806.5, 3501.5}, {17933, -17390, -543}};

static void multiply(const double m[3][3], const double *x, double scale, double *y) {
    for (int i = 0; i < 3; ++i)
        y[i] = (m[i][0] * x[0] + m[i][1] * x[1] + m[i][2] * x[2]) * scale;
}

/* Constants of SMPTE ST 2084. */
static const double m1 = 2610.0 / 16384, m2 = 2523.0 / 4096 * 128;
static const double c1 = 3424.0 / 4096, c2 = 2413.0 / 4096 * 32, c3 = 2392.0 / 4096 * 32;

double nqm_pq_from_luminance(double luminance_cdm2) {
    double y = pow(fmin(fmax(luminance_cdm2, 0), 10000) / 10000, m1);
    return pow((c1 + c2 * y) / (1 + c3 * y), m2);
}

double nqm_pq_slope(double luminance_cdm2) {
    if (luminance_cdm2 >= 10000)
        return 0;
    const double x = fmax(luminance_cdm2, 0x1p-30) / 10000, y = pow(x, m1);
    const double top = c1 + c2 * y, bottom = 1 + c3 * y, inner = (c2 - c1 * c3) / (bottom * bottom) * m1 * y / x;
    return m2 * pow(top / bottom, m2 - 1) * inner / 10000;
}

/* Cubic pieces between 128 nodes an octave, each with the signal and the slope times the distance to the next node. */
enum { FIRST_OCTAVE = -30, LAST_OCTAVE = 13, STEPS = 128, N_NODES = (LAST_OCTAVE - FIRST_OCTAVE) * STEPS + 1 };
static double nodes[N_NODES][2];
static pthread_once_t nodes_once = PTHREAD_ONCE_INIT;

static void fill_nodes(void) {
    for (int i = 0; i < N_NODES; ++i) {
        const double octave = ldexp(1, FIRST_OCTAVE + i / STEPS), at = octave * (1 + (double)(i % STEPS) / STEPS);
        nodes[i][0] = nqm_pq_from_luminance(at);
        nodes[i][1] = nqm_pq_slope(at) * octave / STEPS;
    }
}

double nqm_pq_interpolate(double luminance_cdm2, double *slope) {
    enum { MANTISSA_BITS = 52, STEP_BITS = 7, REST_BITS = MANTISSA_BITS - STEP_BITS };
    if (!(luminance_cdm2 >= 0x1p-30 && luminance_cdm2 < 0x1p13)) {
        *slope = nqm_pq_slope(luminance_cdm2);
        return nqm_pq_from_luminance(luminance_cdm2);
    }
    pthread_once(&nodes_once, fill_nodes);
    uint64_t bits;
    memcpy(&bits, &luminance_cdm2, sizeof bits);
    const uint64_t inverse_bits = (2 * UINT64_C(1023) - (bits >> MANTISSA_BITS)) << MANTISSA_BITS;
    double per_octave; /* 1 / the power of 2 below */
    memcpy(&per_octave, &inverse_bits, sizeof per_octave);
    const size_t cell = (size_t)(bits >> REST_BITS) - ((size_t)(1023 + FIRST_OCTAVE) << STEP_BITS);
    const double *a = nodes[cell], *b = nodes[cell + 1];
    const double t = (double)(bits & ((UINT64_C(1) << REST_BITS) - 1)) * 0x1p-45, rise = b[0] - a[0];
    /* At the end of an octave the next node's distance is twice as long. */
    const double end = (cell + 1) % STEPS ? b[1] : 0.5 * b[1];
    const double quadratic = 3 * rise - 2 * a[1] - end, cubic = a[1] + end - 2 * rise;
    *slope = (a[1] + t * (2 * quadratic + t * 3 * cubic)) * STEPS * per_octave;
    return a[0] + t * (a[1] + t * (quadratic + t * cubic));
}

void nqm_lms_from_rgb(const double *rgb_cdm2, double *lms) {
    double rgb[3];
    for (int k = 0; k < 3; ++k)
        rgb[k] = fmin(fmax(rgb_cdm2[k], 0), 10000);
    double rgb2020[3];
    multiply(bt2020_from_bt709, rgb, 1, rgb2020);
    multiply(lms_from_bt2020, rgb2020, 1.0 / 4096, lms);
}

void nqm_itp_from_pq_lms(const double *pq_lms, double *itp) {
    multiply(itp_from_pq_lms, pq_lms, 1.0 / 4096, itp);
}

void nqm_itp_from_rgb(const double *rgb_cdm2, double *itp) {
    assert(rgb_cdm2 && itp);
    double lms[3];
    nqm_lms_from_rgb(rgb_cdm2, lms);
    for (int k = 0; k < 3; ++k)
        lms[k] = nqm_pq_from_luminance(lms[k]);
    nqm_itp_from_pq_lms(lms, itp);
}

/* y = the transpose of m times x. */
static void multiply_transposed(const double m[3][3], const double *x, double scale, double *y) {
    for (int i = 0; i < 3; ++i)
        y[i] = (m[0][i] * x[0] + m[1][i] * x[1] + m[2][i] * x[2]) * scale;
}

void nqm_rgb_gradient(const double *rgb_cdm2, const double *by_itp, double *by_rgb) {
    double lms[3], by_lms[3], by_rgb2020[3];
    nqm_lms_from_rgb(rgb_cdm2, lms);
    multiply_transposed(itp_from_pq_lms, by_itp, 1.0 / 4096, by_lms);
    for (int k = 0; k < 3; ++k) {
        double slope;
        (void)nqm_pq_interpolate(lms[k], &slope);
        by_lms[k] *= slope;
    }
    multiply_transposed(lms_from_bt2020, by_lms, 1.0 / 4096, by_rgb2020);
    multiply_transposed(bt2020_from_bt709, by_rgb2020, 1, by_rgb);
    for (int k = 0; k < 3; ++k)
        if (!(rgb_cdm2[k] >= 0 && rgb_cdm2[k] < 10000))
            by_rgb[k] = 0;
}

double nqm_delta_e_itp(const double *rgb_a_cdm2, const double *rgb_b_cdm2) {
    assert(rgb_a_cdm2 && rgb_b_cdm2);
    double a[3], b[3];
    nqm_itp_from_rgb(rgb_a_cdm2, a);
    nqm_itp_from_rgb(rgb_b_cdm2, b);
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return 720 * sqrt(nqm_dot3(d, d));
}
