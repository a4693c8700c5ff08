/* SPDX-License-Identifier: MIT
 *
 * An estimate of the label of two sampled BRDFs without a network. In a scene with fixed light the radiance of every point is
 * linear in the BRDF (precomputed radiance transfer: Sloan et al. 2002, DOI 10.1145/566654.566612), so a matrix makes a picture
 * of few points from samples; the label of two such pictures is the estimate. label/transport.c makes the
 * matrix; models correct the estimate.
 */
#include "kernel/kernel.h"
#include "metric/metric.h"
#include "percept/percept.h"

#include <string.h>

/* Points and directions that are computed together: their pictures and their rows of the matrix stay in the L2 cache. */
enum { POINTS = NQM_PICTURE_BLOCK, DIRECTIONS = 64 };

_Static_assert(POINTS % NQM_PANEL == 0, "the kernel computes whole panels");

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
                                       .b = t->light + (3 * b.direction + c) * t->points.n + b.point + p,
                                       .ldb = 3 * t->points.n,
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
    nqm_transport_radiance(t, first, n_points, n, pictures, itp);
    for (size_t i = 0; i < n; ++i)
        nqm_picture_show_block(&t->points, first, n_points, itp + i * 3 * n_points);
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/* Sums of the current scene of a pair, and the means over the scenes before it. */
typedef struct pair_sums {
    nqm_picture_sums sums;
    nqm_look_sums ref, test;
    nqm_label *mean;
    double *looks; /* NULL: not computed */
} pair_sums;

/* Add the points of two pictures from `first` on. */
static void add_points(const nqm_picture_points *points, size_t first, size_t n, const float *ref, const float *test,
                       pair_sums *to) {
    size_t end = nqm_picture_scene_end(points, first);
    for (size_t p = 0; p < n; ++p) {
        const double a[3] = {(double)ref[p], (double)ref[n + p], (double)ref[2 * n + p]};
        const double b[3] = {(double)test[p], (double)test[n + p], (double)test[2 * n + p]};
        const double weight = points->at[3 * (first + p)];
        nqm_picture_sums_add(&to->sums, weight, a, b);
        if (to->looks) {
            nqm_look_add(&to->ref, weight, a);
            nqm_look_add(&to->test, weight, b);
        }
        if (first + p + 1 == end) {
            const nqm_label label = nqm_picture_sums_label(&to->sums);
            nqm_label_add(to->mean, nqm_picture_share(points), &label);
            if (to->looks)
                *to->looks += nqm_picture_share(points) * nqm_look_distance(&to->ref, &to->test, label.structure);
            *to = (pair_sums){.mean = to->mean, .looks = to->looks};
            end = nqm_picture_scene_end(points, end);
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
    for (size_t first = 0, n_points; first < t->points.n; first += n_points) {
        n_points = nqm_smaller(t->points.n - first, POINTS);
        nqm_transport_pictures(t, first, n_points, n_pictures, pictures, itp);
        for (size_t i = 0; i < n; ++i)
            add_points(&t->points, first, n_points, itp + ref_at[i] * 3 * n_points, itp + test_at[i] * 3 * n_points,
                       &sums[i]);
    }
}
