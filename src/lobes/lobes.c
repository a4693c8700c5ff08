/* SPDX-License-Identifier: MIT
 *
 * The half vectors at which a BRDF is evaluated: a disc and rings that are even in the logarithm of the slope, in which
 * lobes are smooth. Near the lobe the rings have its centre and axes; far from it they become round, so that they cover
 * all slopes. Each half vector stands for the light of its surroundings.
 */
#include "lobes/lobes.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* Rings have these steps of the logarithm and these numbers of nodes: few within a lobe so narrow that light is
 * constant in it, and more where light varies. Nodes beyond a wide slope take up what the sum of all lacks to the light
 * of the point. */
enum { AROUND = 14, NARROW_AROUND = 4, MAX_RINGS = 64, BLOCK = 256 };
static const double step_of_light = 0.35, step_of_lobe = 0.5, narrow_slope = 0.02;
/* Parts of a node, as fine as the cells of the light. */
enum { PARTS_ALONG = 3, PARTS_AROUND = 4 };

typedef struct ring {
    double inner, outer; /* radii of circles of the same area */
    size_t n_nodes;
} ring;

/* The nodes of a BRDF. */
typedef struct nodes {
    size_t n;
    double (*half)[3]; /* unit vectors */
    float *light;      /* (n, 3, n_points) */
} nodes;

static void set_half(const double slope[2], double half[3]) {
    half[0] = slope[0];
    half[1] = slope[1];
    half[2] = 1;
    nqm_normalize3(half);
}

/* Rings of a lobe; returns their number. n_nodes_ret: with the disc within them. */
static size_t make_rings(const nqm_lobe *lobe, ring *rings, size_t *n_nodes_ret) {
    const double ratio = lobe->axes[0] * lobe->axes[0] + lobe->axes[2] * lobe->axes[2],
                 longer = sqrt(fmax(ratio, 1 / ratio));
    size_t n = 0;
    *n_nodes_ret = 1;
    for (double t = lobe->width / 8; t < NQM_SLOPE_MOST && n < MAX_RINGS; t = rings[n++].outer) {
        const bool is_narrow = t * longer < narrow_slope;
        rings[n] = (ring){t, fmin(t * exp(is_narrow ? step_of_lobe : step_of_light), NQM_SLOPE_MOST),
                          is_narrow ? NARROW_AROUND : AROUND};
        *n_nodes_ret += rings[n].n_nodes;
    }
    return n;
}

/* A ring in the plane of slopes: the circle of radius 1 becomes center + axes * (x, y). */
typedef struct circle {
    double center[2], axes[4];
} circle;

/* 0 up to `from`, 1 from `to` on, even in the logarithm of t. */
static double blend(double t, double from, double to) {
    return fmin(fmax(log(t / from) / log(to / from), 0), 1);
}

/* An ellipse with the centre and the ratio of axes of the lobe; far from it, a circle about the normal. Centres move less than
 * circles grow, so that ellipses do not cross. The matrix of the axes is symmetric: the azimuth of a nearly round lobe is
 * a matter of chance, and must not turn the nodes. */
static circle circle_at(const nqm_lobe *lobe, double t) {
    static const double round = 4;
    const double distance = hypot(lobe->center[0], lobe->center[1]);
    const double here = distance > 0 ? 1 - blend(t, 2 * distance, fmax(round, 6 * distance)) : 0;
    const double along = hypot(lobe->axes[0], lobe->axes[2]), c = lobe->axes[0] / along, s = lobe->axes[2] / along;
    const double from = fmin(3 * lobe->width, round * exp(-1.5 * fabs(log(along)) - 1));
    const double longer = t * pow(along, 1 - blend(t, from, round)), shorter = t * t / longer;
    return (circle){{here * lobe->center[0], here * lobe->center[1]},
                    {c * c * longer + s * s * shorter, c * s * (longer - shorter), c * s * (longer - shorter),
                     s * s * longer + c * c * shorter}};
}

static void slope_at(const circle *at, double x, double y, double slope[2]) {
    slope[0] = at->center[0] + at->axes[0] * x + at->axes[1] * y;
    slope[1] = at->center[1] + at->axes[2] * x + at->axes[3] * y;
}

/* Add the light of an area around a slope. */
static void add_light(const nqm_slope_light *l, const double slope[2], double area, float *light) {
    if (!(slope[0] * slope[0] + slope[1] * slope[1] < NQM_SLOPE_MOST * NQM_SLOPE_MOST))
        return;
    const size_t cell = nqm_slope_cell(slope[0], slope[1]), n = 3 * l->points.n;
    const float share = (float)(area / nqm_slope_area(cell)), *from = l->light + cell * n;
#pragma omp simd
    for (size_t i = 0; i < n; ++i)
        light[i] += share * from[i];
}

/* Circles of a ring: its middle, and those of its parts, also a little further inwards and outwards. */
typedef struct ring_circles {
    circle middle, part[PARTS_ALONG], inwards[PARTS_ALONG], outwards[PARTS_ALONG];
} ring_circles;
static const double little = 1e-4; /* of the logarithm */

static void make_circles(const nqm_lobe *lobe, const ring *r, ring_circles *to) {
    const double step = log(r->outer / r->inner);
    to->middle = circle_at(lobe, sqrt(r->inner * r->outer));
    for (size_t i = 0; i < PARTS_ALONG; ++i) {
        const double t = r->inner * exp(step * ((double)i + 0.5) / PARTS_ALONG);
        to->part[i] = circle_at(lobe, t);
        to->inwards[i] = circle_at(lobe, t * exp(-little));
        to->outwards[i] = circle_at(lobe, t * exp(little));
    }
}

/* Slope of a part at the azimuth phi, and its area for one of the logarithm and one of phi. */
static double part_at(const ring_circles *circles, size_t i, double phi, double slope[2]) {
    const double x = cos(phi), y = sin(phi), *axes = circles->part[i].axes;
    const double by_phi[2] = {axes[1] * x - axes[0] * y, axes[3] * x - axes[2] * y};
    double in[2], out[2];
    slope_at(&circles->part[i], x, y, slope);
    slope_at(&circles->inwards[i], x, y, in);
    slope_at(&circles->outwards[i], x, y, out);
    return fabs((out[0] - in[0]) * by_phi[1] - (out[1] - in[1]) * by_phi[0]) / (2 * little);
}

/* A node of a ring. The midpoint rule on the logarithm gives it the weight step t^2 at its middle, less than its area, which is
 * sinh(step) t^2. */
static void add_node(const nqm_slope_light *l, const ring *r, const ring_circles *circles, double phi, nodes *to) {
    const double step = log(r->outer / r->inner), angle = 2 * NQM_PI / (double)r->n_nodes;
    const double share = step / sinh(step) * step / PARTS_ALONG * angle / PARTS_AROUND;
    double slope[2];
    slope_at(&circles->middle, cos(phi), sin(phi), slope);
    set_half(slope, to->half[to->n]);
    for (size_t i = 0; i < PARTS_ALONG; ++i)
        for (size_t j = 0; j < PARTS_AROUND; ++j) {
            const double area = part_at(circles, i, phi + angle * (((double)j + 0.5) / PARTS_AROUND - 0.5), slope);
            add_light(l, slope, share * area, to->light + to->n * 3 * l->points.n);
        }
    ++to->n;
}

static void add_nodes(const nqm_slope_light *l, const nqm_lobe *lobe, size_t n_rings, const ring *rings, nodes *to) {
    ring_circles circles;
    set_half(lobe->center, to->half[0]);
    add_light(l, lobe->center, NQM_PI * rings[0].inner * rings[0].inner, to->light);
    to->n = 1;
    for (size_t k = 0; k < n_rings; ++k) {
        make_circles(lobe, &rings[k], &circles);
        for (size_t j = 0; j < rings[k].n_nodes; ++j)
            add_node(l, &rings[k], &circles,
                     2 * NQM_PI / (double)rings[k].n_nodes * ((double)j + 0.5 * (double)(k % 2)), to);
    }
}

static bool is_wide(const nodes *of, size_t k) {
    static const double wide_slope = 0.3;
    return of->half[k][2] * of->half[k][2] * (1 + wide_slope * wide_slope) < 1;
}

/* Let the wide nodes have the light that all lack: totals (3, n_points). Nodes below the horizon have none. Two rows of
 * `light` follow those of the nodes, for the sums. */
static void complete(const nqm_slope_light *l, const float *totals, nodes *to) {
    const size_t n_points = l->points.n, n = 3 * n_points;
    float *all = to->light + to->n * n, *wide = all + n;
    for (size_t k = 0; k < to->n; ++k) {
        float *light = to->light + k * n;
        const double *h = to->half[k];
        for (size_t p = 0; p < n_points; ++p) {
            const double *wo = l->wo + 3 * p;
            const float lit = 2 * nqm_dot3(wo, h) * h[2] > wo[2];
            for (size_t c = 0; c < 3; ++c)
                light[c * n_points + p] *= lit;
        }
        for (size_t i = 0; i < n; ++i)
            all[i] += light[i];
        for (size_t i = 0, end = is_wide(to, k) ? n : 0; i < end; ++i)
            wide[i] += light[i];
    }
    for (size_t i = 0; i < n; ++i)
        wide[i] = wide[i] > 0 ? fmaxf(1 + (totals[i] - all[i]) / wide[i], 0) : 1;
    for (size_t k = 0; k < to->n; ++k)
        for (size_t i = 0, end = is_wide(to, k) ? n : 0; i < end; ++i)
            to->light[k * n + i] *= wide[i];
}

/* Add the reflection of one node at `count` points to rgb (3, n_points). */
static void add_reflection(const nqm_slope_light *l, const nqm_brdf *brdf, const double h[3], const float *light,
                           size_t first, size_t count, double *rgb) {
    const double *wo = l->wo + 3 * first;
    double wi[3 * BLOCK], f[3 * BLOCK];
    for (size_t i = 0; i < count; ++i) {
        const double d = 2 * nqm_dot3(wo + 3 * i, h);
        for (size_t k = 0; k < 3; ++k)
            wi[3 * i + k] = d * h[k] - wo[3 * i + k];
    }
    nqm_brdf_eval(brdf, count, wi, wo, f, NULL);
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < count; ++i)
            rgb[c * l->points.n + first + i] += f[3 * i + c] * (double)light[c * l->points.n + first + i];
}

/* rgb (3, n_points): the sum over the nodes. */
static void sum_nodes(const nqm_slope_light *l, const nqm_brdf *brdf, const nodes *from, double *rgb) {
    const size_t n_points = l->points.n;
    memset(rgb, 0, 3 * n_points * sizeof *rgb);
    for (size_t k = 0; k < from->n; ++k)
        for (size_t first = 0; first < n_points; first += BLOCK)
            add_reflection(l, brdf, from->half[k], from->light + k * 3 * n_points, first,
                           nqm_smaller(n_points - first, BLOCK), rgb);
}

/* The light (3, n) of the points for a BRDF, by half vectors that suit a lobe. totals: (3, n) the light of all slopes. false: out
 * of memory. */
static bool make_light(const nqm_slope_light *l, const float *totals, const nqm_brdf *brdf, const nqm_lobe *lobe,
                       double *rgb) {
    ring rings[MAX_RINGS] = {{0, 0, 0}};
    nodes made = {.n = 0};
    size_t n_nodes;
    const size_t n_rings = make_rings(lobe, rings, &n_nodes);
    if (nqm_alloc_arrays(NQM_ARRAYS({&made.half, n_nodes, sizeof *made.half},
                                    {&made.light, n_nodes + 2, 3 * l->points.n * sizeof *made.light}),
                         NULL) != NQM_OK)
        return false;
    add_nodes(l, lobe, n_rings, rings, &made);
    complete(l, totals, &made);
    sum_nodes(l, brdf, &made, rgb);
    nqm_free(made.half);
    return true;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* BRDFs with similar lobes have the same half vectors, so that the light of a small source falls on the same ones, and BRDFs
 * that hardly differ have pictures that hardly differ. */
typedef struct pictures_job {
    const nqm_slope_light *light;
    nqm_lobe_picture *pictures;
    float *totals; /* (3, n) */
} pictures_job;

static void measure(void *user, size_t i) {
    nqm_lobe_picture *p = &((const pictures_job *)user)->pictures[i];
    p->status = p->subject ? nqm_subject_open(p->subject, NULL, &p->opened, NULL) : NQM_OK;
    p->brdf = p->subject ? p->opened : p->brdf;
    if (p->status == NQM_OK)
        p->lobe = nqm_lobe_measure(p->brdf);
}

/* Whether half vectors for one lobe suit the other: sizes and distance within a third. A lobe that is zeroed is like none. */
static bool is_like(const nqm_lobe *a, const nqm_lobe *b) {
    static const double most = 0.3;
    const double distance = hypot(a->center[0] - b->center[0], a->center[1] - b->center[1]);
    double shape = 0; /* difference of axes times their transpose, in which a round lobe has no azimuth */
    for (size_t i = 0; i < 2; ++i)
        for (size_t j = 0; j < 2; ++j)
            shape = fmax(shape, fabs(a->axes[2 * i] * a->axes[2 * j] + a->axes[2 * i + 1] * a->axes[2 * j + 1] -
                                     b->axes[2 * i] * b->axes[2 * j] - b->axes[2 * i + 1] * b->axes[2 * j + 1]));
    return fabs(log(a->width / b->width)) < most && distance < most * a->width && shape < most;
}

static void make_picture(void *user, size_t i) {
    const pictures_job *job = user;
    nqm_lobe_picture *p = &job->pictures[i];
    const nqm_lobe *own = &p->lobe, *of_ref = p->ref == SIZE_MAX ? own : &job->pictures[p->ref].lobe;
    const nqm_lobe *lobe = is_like(of_ref, own) ? of_ref : own;
    if (p->status == NQM_OK && !make_light(job->light, job->totals, p->brdf, lobe, p->light))
        p->status = NQM_ERR_NOMEM;
}

nqm_status nqm_lobes_pictures(const nqm_slope_light *light, size_t n, nqm_lobe_picture *pictures, nqm_ticker *ticker,
                              nqm_error *err) {
    const size_t n_totals = 3 * light->points.n;
    pictures_job job = {light, pictures, nqm_alloc(n_totals, sizeof *job.totals)};
    if (!job.totals)
        return nqm_fail_nomem(err, n_totals * sizeof *job.totals);
    for (size_t cell = 0; cell < NQM_SLOPE_CELLS; ++cell)
        for (size_t i = 0; i < n_totals; ++i)
            job.totals[i] += light->light[cell * n_totals + i];
    nqm_parallel_for(n, measure, &job);
    const bool is_stopped = nqm_parallel_ticking(ticker, "far", n, make_picture, &job);
    for (size_t i = 0; i < n; ++i)
        nqm_brdf_free(pictures[i].opened);
    nqm_free(job.totals);
    return is_stopped ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled") : NQM_OK;
}
