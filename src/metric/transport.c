/* SPDX-License-Identifier: MIT
 *
 * An estimate of the label of two sampled BRDFs without a network. In a scene with fixed light the radiance of every point is
 * linear in the BRDF (precomputed radiance transfer: Sloan et al. 2002, DOI 10.1145/566654.566612), so a matrix makes a picture
 * of few points from samples; the label of two such pictures is the estimate. nqm dataset makes the matrix
 * (label/transport.c); models correct the estimate.
 */
#include "kernel/kernel.h"
#include "metric/metric.h"
#include "percept/percept.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

/* Points and directions that are computed together: their pictures and their rows of the matrix stay in the L2 cache. */
enum { POINTS = NQM_TRANSPORT_BLOCK, DIRECTIONS = 64 };

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

/* y (3, n) = the sums of rows k of m times channels k of x (3, n). */
static void multiply_points(float m[3][3], size_t n, const float *x, float *y) {
    for (size_t i = 0; i < 3; ++i)
#pragma omp simd
        for (size_t p = 0; p < n; ++p)
            y[i * n + p] = m[0][i] * x[p] + m[1][i] * x[n + p] + m[2][i] * x[2 * n + p];
}

/* picture (3, n) of the points from `first` on, in: RGB radiance in cd/m2; out: ITP on the display, in units of Delta-E. */
static void see(const nqm_transport *t, size_t first, size_t n, float *picture) {
    float lms[3 * POINTS];
    for (size_t p = 0; p < n; ++p) {
        const float peak = (float)t->points[3 * (first + p) + 2];
        for (float *x = picture + p; x < picture + 3 * n; x += n)
            *x = *x < peak ? *x : peak;
    }
    multiply_points(lms_of, n, picture, lms);
    for (size_t i = 0; i < 3 * n; ++i)
        lms[i] = pq_signal(lms[i]);
    multiply_points(itp_of, n, lms, picture);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Directions [direction, direction + n_directions) and points [point, point + n_points) of a matrix. */
typedef struct block {
    size_t direction, n_directions, point, n_points;
} block;

/* The values of n directions from `first` on of which a picture is made: f (n, 3). */
static void read_samples(const nqm_transport_picture *picture, size_t first, size_t n, float *f) {
    const nqm_sample_pair *pair = picture->pair;
    const float *ref = pair->ref + 3 * first, *test = pair->test + 3 * first;
    const uint8_t *used = pair->used ? pair->used + first : NULL;
    if (picture->of == NQM_TRANSPORT_OF_DIFFERENCE)
        for (size_t i = 0; i < 3 * n; ++i)
            f[i] = test[i] - ref[i];
    else
        memcpy(f, picture->of == NQM_TRANSPORT_OF_REF ? ref : test, 3 * n * sizeof *f);
    for (size_t i = 0; used && picture->of != NQM_TRANSPORT_OF_REF && i < 3 * n; ++i)
        if (!used[i / 3])
            f[i] = picture->of == NQM_TRANSPORT_OF_TEST ? ref[i] : 0;
}

/* Add the light of a block to n pictures. */
static void add_light(const nqm_transport *t, block b, size_t n, const nqm_transport_picture *pictures, float *rgb) {
    const nqm_kernels *kernels = nqm_kernels_get();
    float f[NQM_TRANSPORT_MAX * 3 * DIRECTIONS];
    for (size_t i = 0; i < n; ++i)
        read_samples(&pictures[i], b.direction, b.n_directions, f + i * 3 * DIRECTIONS);
    for (size_t c = 0; c < 3; ++c)
        for (size_t p = 0; p < b.n_points; p += NQM_PANEL)
            kernels->strided_product(
                &(nqm_strided_product){.m = n,
                                       .k = b.n_directions,
                                       .add = b.direction > 0,
                                       .a = f + c,
                                       .lda = 3 * DIRECTIONS,
                                       .step = 3,
                                       .b = t->light + (3 * b.direction + c) * t->n_points + b.point + p,
                                       .ldb = 3 * t->n_points,
                                       .c = rgb + c * b.n_points + p,
                                       .ldc = 3 * b.n_points});
}

void nqm_transport_radiance(const nqm_transport *t, size_t first, size_t n_points, size_t n,
                            const nqm_transport_picture *pictures, float *rgb) {
    block b = {.point = first, .n_points = n_points};
    for (; b.direction < t->n_directions; b.direction += b.n_directions) {
        b.n_directions = nqm_smaller(t->n_directions - b.direction, DIRECTIONS);
        add_light(t, b, n, pictures, rgb);
    }
}

void nqm_transport_pictures(const nqm_transport *t, size_t first, size_t n_points, size_t n,
                            const nqm_transport_picture *pictures, float *itp) {
    pthread_once(&tables_once, fill_tables);
    nqm_transport_radiance(t, first, n_points, n, pictures, itp);
    for (size_t i = 0; i < n; ++i)
        see(t, first, n_points, itp + i * 3 * n_points);
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

bool nqm_transport_ends_scene(const nqm_transport *t, size_t point) {
    return point + 1 == t->n_points || t->points[3 * point + 4] > t->points[3 * point + 1];
}

double nqm_transport_share(const nqm_transport *t) {
    return 1 / (1 + t->points[3 * t->n_points - 2]);
}

/* Sums of the current scene of a pair, and the means over the scenes before it. */
typedef struct pair_sums {
    nqm_picture_sums sums;
    nqm_look_sums ref, test;
    nqm_label *mean;
    double *looks; /* NULL: not computed */
} pair_sums;

/* Add the points of two pictures from `first` on. */
static void add_points(const nqm_transport *t, size_t first, size_t n, const float *ref, const float *test,
                       pair_sums *to) {
    for (size_t p = 0; p < n; ++p) {
        const double a[3] = {(double)ref[p], (double)ref[n + p], (double)ref[2 * n + p]};
        const double b[3] = {(double)test[p], (double)test[n + p], (double)test[2 * n + p]};
        const double weight = t->points[3 * (first + p)];
        nqm_picture_sums_add(&to->sums, weight, a, b);
        if (to->looks) {
            nqm_look_add(&to->ref, weight, a);
            nqm_look_add(&to->test, weight, b);
        }
        if (nqm_transport_ends_scene(t, first + p)) {
            const nqm_label label = nqm_picture_sums_label(&to->sums);
            nqm_label_add(to->mean, nqm_transport_share(t), &label);
            if (to->looks)
                *to->looks += nqm_transport_share(t) * nqm_look_distance(&to->ref, &to->test, label.structure);
            *to = (pair_sums){.mean = to->mean, .looks = to->looks};
        }
    }
}

void nqm_transport_estimates(const nqm_transport *t, size_t n, const nqm_sample_pair *pairs, nqm_label *estimates,
                             double *looks) {
    nqm_transport_picture pictures[NQM_TRANSPORT_MAX];
    pair_sums sums[NQM_COMPARE_MAX];
    float itp[NQM_TRANSPORT_MAX * 3 * POINTS];
    size_t n_pictures = 0, ref_at[NQM_COMPARE_MAX], test_at[NQM_COMPARE_MAX]; /* pictures of pair i */
    for (size_t i = 0; i < n; ++i) {
        const bool is_shared = i > 0 && pairs[i].ref == pairs[i - 1].ref;
        ref_at[i] = is_shared ? ref_at[i - 1] : n_pictures;
        if (!is_shared)
            pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_REF};
        test_at[i] = n_pictures;
        pictures[n_pictures++] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_TEST};
        estimates[i] = (nqm_label){.delta_e = 0};
        sums[i] = (pair_sums){.mean = &estimates[i], .looks = looks ? &looks[i] : NULL};
        if (looks)
            looks[i] = 0;
    }
    for (size_t first = 0, n_points; first < t->n_points; first += n_points) {
        n_points = nqm_smaller(t->n_points - first, POINTS);
        nqm_transport_pictures(t, first, n_points, n_pictures, pictures, itp);
        for (size_t i = 0; i < n; ++i)
            add_points(t, first, n_points, itp + ref_at[i] * 3 * n_points, itp + test_at[i] * 3 * n_points, &sums[i]);
    }
}
