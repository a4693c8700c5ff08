/* SPDX-License-Identifier: MIT
 *
 * Points distributed evenly over the visible surface: a sunflower pattern on the sphere; on meshes a stratified subset of
 * many visible points.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdlib.h>

/* A sunflower (Vogel 1979, DOI 10.1016/0025-5564(79)90080-4): even in area over the disc, for any number. */
void nqm_spread_sphere(const nqm_scene_options *o, nqm_surface_point *point) {
    const double golden_angle = NQM_PI * (3 - sqrt(5)), turn[2] = {0, 1};
    double start = 2 * NQM_PI * nqm_random_unit(o->seed, UINT64_MAX), axes[9];
    nqm_view_axes(o->elevation_rad, axes);
    for (size_t i = 0; i < o->n_points; ++i) {
        double r = sin(NQM_VIEW_MAX_DEG * NQM_PI / 180) * sqrt(((double)i + 0.5) / (double)o->n_points);
        double phi = start + golden_angle * (double)i, x = r * cos(phi), y = r * sin(phi), z = sqrt(1 - r * r);
        nqm_hit hit = {{0}, {0}};
        for (int k = 0; k < 3; ++k)
            hit.normal[k] = x * axes[k] + y * axes[3 + k] + z * axes[6 + k];
        nqm_surface_point_make(&hit, turn, axes + 6, &point[i]);
    }
}

/* A visible point, and the position of its normal on a space-filling curve. */
typedef struct candidate {
    nqm_surface_point point;
    double importance;
    uint32_t place;
    uint32_t order; /* index, which makes the sort unique */
} candidate;

enum { CURVE_BITS = 12 };

/* Position of a cell of a square grid along Hilbert's curve. */
static uint32_t hilbert(uint32_t x, uint32_t y) {
    uint32_t place = 0;
    for (uint32_t side = 1U << (CURVE_BITS - 1); side; side >>= 1) {
        uint32_t right = (x & side) != 0, up = (y & side) != 0;
        place += side * side * ((3 * right) ^ up);
        if (up)
            continue;
        if (right) {
            x = ~x;
            y = ~y;
        }
        uint32_t swap = x;
        x = y;
        y = swap;
    }
    return place;
}

static uint32_t place_of(const nqm_surface_point *point, const double *axes) {
    const double half = 1 << (CURVE_BITS - 1);
    const double *normal = point->frame + 6;
    return hilbert((uint32_t)((1 + nqm_dot3(normal, axes)) * (half - 0.5)),
                   (uint32_t)((1 + nqm_dot3(normal, axes + 3)) * (half - 0.5)));
}

static int by_place(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->place != y->place)
        return x->place < y->place ? -1 : 1;
    return (x->order > y->order) - (x->order < y->order);
}

/* Sample the pictures of all frames in turn, each with its own shift of the R2 sequence (multiples of the inverse powers of
 * the plastic number, Roberts 2018), until n samples hit the shape. */
static nqm_status find_candidates(const nqm_shape *shape, const nqm_scene_options *o, size_t n, candidate *hits,
                                  nqm_error *err) {
    const double plastic = 1.3247179572447460260;
    size_t k = 0, most = 1000 * (n + o->n_frames);
    for (size_t i = 0; k < n; ++i) {
        if (i == most)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the shape is hardly visible", o->shape);
        size_t frame = i % o->n_frames;
        /* NOLINTNEXTLINE(bugprone-integer-division): whole rounds of the frames */
        double step = (double)(i / o->n_frames + 1);
        double x = nqm_random_unit(o->seed, UINT64_MAX - 2 * frame) + step / plastic;
        double y = nqm_random_unit(o->seed, UINT64_MAX - 2 * frame - 1) + step / (plastic * plastic);
        nqm_view v = nqm_view_make(shape, o, frame);
        if (!nqm_view_look(&v, 2 * (x - floor(x)) - 1, 2 * (y - floor(y)) - 1, &hits[k].point))
            continue;
        hits[k].place = place_of(&hits[k].point, v.axes);
        hits[k].order = (uint32_t)k;
        ++k;
    }
    return NQM_OK;
}

/* Highlights cover a small part of the picture but contribute much to the difference between two BRDFs. So points are denser
 * where a mirror would reflect bright parts of the light (blurred to five degrees): half of the density is uniform over
 * the picture, half is proportional to the square root of that luminance. */
static void weigh(const nqm_light *glow, const double *towards, size_t n, candidate *hits) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
        const double *normal = hits[i].point.frame + 6;
        double mirror[3], rgb[3], cosine = nqm_dot3(normal, towards);
        for (int k = 0; k < 3; ++k)
            mirror[k] = 2 * cosine * normal[k] - towards[k];
        nqm_light_eval(glow, mirror, rgb);
        hits[i].importance = sqrt(nqm_luminance(rgb));
        sum += hits[i].importance;
    }
    double scale = sum > 0 ? (double)n / sum : 0;
    for (size_t i = 0; i < n; ++i)
        hits[i].importance = 1 + scale * hits[i].importance;
}

/* Stratified selection: one candidate for each of n equal intervals of the cumulative importance. */
static void draw_points(const candidate *hits, size_t n_found, double start, size_t n, nqm_surface_point *point,
                        double *weight) {
    double total = 0, passed = 0, sum = 0;
    size_t k = 0;
    for (size_t i = 0; i < n_found; ++i)
        total += hits[i].importance;
    for (size_t i = 0; i < n; ++i) {
        while (k + 1 < n_found && passed + hits[k].importance <= ((double)i + start) / (double)n * total)
            passed += hits[k++].importance;
        point[i] = hits[k].point;
        weight[i] = 1 / hits[k].importance;
        sum += weight[i];
    }
    for (size_t i = 0; i < n; ++i)
        weight[i] /= sum;
}

/* Apart from shadows, distant light on a point depends on its normal only. So many candidates are sorted by normal along a
 * space-filling curve and selected at even steps: the normals of the selection are distributed as those of the picture. */
static nqm_status spread_mesh(const nqm_shape *shape, const nqm_light *glow, const nqm_scene_options *o,
                              nqm_surface_point *point, double *weight, nqm_error *err) {
    enum { MANY = 1 << 15 };
    size_t n = o->n_points > MANY ? o->n_points : MANY;
    double axes[9];
    candidate *hits = nqm_alloc(n, sizeof *hits);
    if (!hits)
        return nqm_fail_nomem(err, n * sizeof *hits);
    nqm_view_axes(o->elevation_rad, axes);
    nqm_status status = find_candidates(shape, o, n, hits, err);
    if (status == NQM_OK) {
        qsort(hits, n, sizeof *hits, by_place);
        weigh(glow, axes + 6, n, hits);
        draw_points(hits, n, nqm_random_unit(o->seed, UINT64_MAX / 2), o->n_points, point, weight);
    }
    nqm_free(hits);
    return status;
}

nqm_status nqm_spread_points(const nqm_shape *shape, const nqm_light *glow, const nqm_scene_options *o, nqm_seen *seen,
                             nqm_error *err) {
    const size_t n = seen->n = o->n_points;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&seen->block, 0, 1}, {&seen->point, n, sizeof *seen->point},
                                                    {&seen->weight, shape->tracer ? n : 0, sizeof *seen->weight}),
                                         err);
    if (status == NQM_OK && shape->tracer)
        return spread_mesh(shape, glow, o, seen->point, seen->weight, err);
    seen->weight = NULL; /* points of a sphere are equal */
    if (status == NQM_OK)
        nqm_spread_sphere(o, seen->point);
    return status;
}
