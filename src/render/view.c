/* SPDX-License-Identifier: MIT
 *
 * The visible points of all frames of the turntable with their local frames, either at the centres of pixels or distributed
 * over the pictures (spread.c).
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <string.h>

/* ---- axes -------------------------------------------------------------------------------------------------------- */

void nqm_view_axes(double elevation_rad, double *axes) {
    double s = sin(elevation_rad), c = cos(elevation_rad);
    const double rows[9] = {1, 0, 0, 0, c, -s, 0, s, c};
    memcpy(axes, rows, sizeof rows);
}

void nqm_world_from_local(const nqm_surface_point *point, const double *local, double *world) {
    for (int k = 0; k < 3; ++k)
        world[k] = local[0] * point->frame[k] + local[1] * point->frame[3 + k] + local[2] * point->frame[6 + k];
}

void nqm_local_from_world(const nqm_surface_point *point, const double *world, double *local) {
    for (int k = 0; k < 3; ++k)
        local[k] = nqm_dot3(point->frame + 3 * k, world);
}

void nqm_shape_from_world(const double *turn, const double *world, double *in_shape) {
    double x = turn[1] * world[0] - turn[0] * world[2], z = turn[0] * world[0] + turn[1] * world[2];
    in_shape[0] = x;
    in_shape[1] = world[1];
    in_shape[2] = z;
}

static void world_from_shape(const double *turn, const double *in_shape, double *world) {
    const double back[2] = {-turn[0], turn[1]};
    nqm_shape_from_world(back, in_shape, world);
}

/* ---- one point --------------------------------------------------------------------------------------------------- */

/* The component of v orthogonal to the unit vector n, normalised; returns its length. Any orthogonal direction if the length
 * is 0. */
static double orthogonal_part(const double *v, const double *n, double *across) {
    double along = nqm_dot3(v, n);
    for (int k = 0; k < 3; ++k)
        across[k] = v[k] - along * n[k];
    double length = sqrt(nqm_dot3(across, across));
    if (length < 1e-9) {
        const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
        nqm_cross3(fabs(n[0]) < 0.8 ? x : y, n, across);
        length = 0;
    }
    nqm_normalize3(across);
    return length;
}

static void limit_angle(const double *towards, double *normal) {
    const double limit = NQM_VIEW_MAX_DEG * NQM_PI / 180;
    if (nqm_dot3(normal, towards) >= cos(limit))
        return;
    double across[3];
    orthogonal_part(normal, towards, across);
    for (int k = 0; k < 3; ++k)
        normal[k] = cos(limit) * towards[k] + sin(limit) * across[k];
}

/* The surface's tangent in the local frame. */
static void find_tangent(nqm_surface_point *point) {
    const double *normal = point->frame + 6, length = hypot(normal[0], normal[2]);
    const bool is_vertical = length < 1e-9;
    const double tangent[3] = {is_vertical ? 1 : normal[2] / length, 0, is_vertical ? 0 : -normal[0] / length};
    point->tangent[0] = -nqm_dot3(tangent, point->frame + 3);
    point->tangent[1] = nqm_dot3(tangent, point->frame);
}

void nqm_surface_point_make(const nqm_hit *hit, const double *turn, const double *towards, nqm_surface_point *point) {
    double *tangent = point->frame, *bitangent = point->frame + 3, *normal = point->frame + 6;
    world_from_shape(turn, hit->normal, normal);
    limit_angle(towards, normal);
    point->wo[0] = orthogonal_part(towards, normal, tangent);
    point->wo[1] = 0;
    point->wo[2] = nqm_dot3(towards, normal);
    nqm_cross3(normal, tangent, bitangent);
    find_tangent(point);
    memcpy(point->origin, hit->origin, sizeof hit->origin);
    memcpy(point->turn, turn, sizeof point->turn);
}

/* ---- rays of the viewer ------------------------------------------------------------------------------------------ */

nqm_view nqm_view_make(const nqm_shape *shape, const nqm_scene_options *o, size_t frame) {
    nqm_view v = {.shape = shape, .distance = 4};
    double angle = o->turn_rad + 2 * NQM_PI * (double)frame / (double)o->n_frames;
    nqm_view_axes(o->elevation_rad, v.axes);
    v.turn[0] = sin(angle);
    v.turn[1] = cos(angle);
    if (o->width)
        v.distance *= (double)(o->width > o->height ? o->width : o->height) /
                      (double)(o->width < o->height ? o->width : o->height);
    return v;
}

bool nqm_view_look(const nqm_view *v, double x, double y, nqm_surface_point *point) {
    double origin[3], direction[3];
    const double *towards = v->axes + 6;
    nqm_hit hit;
    for (int k = 0; k < 3; ++k) {
        origin[k] = x * v->axes[k] + y * v->axes[3 + k] + v->distance * towards[k];
        direction[k] = -towards[k];
    }
    nqm_shape_from_world(v->turn, origin, origin);
    nqm_shape_from_world(v->turn, direction, direction);
    if (!nqm_shape_hit(v->shape, origin, direction, &hit))
        return false;
    nqm_surface_point_make(&hit, v->turn, towards, point);
    return true;
}

/* ---- pixels ------------------------------------------------------------------------------------------------------ */

/* A point has 152 bytes. To compute one again costs far less than its light directions, so that large pictures store only the
 * pixels. */
enum { MAX_STORED = 1 << 19 };

/* Rows of all frames are traced twice in parallel: first to count the visible points, then to store them. */
typedef struct raster {
    const nqm_shape *shape;
    const nqm_scene_options *options;
    size_t *first; /* (n_frames * height + 1) first point of each row */
    nqm_seen *seen;
} raster;

static bool look_at_pixel(const nqm_scene_options *o, const nqm_view *v, size_t row, size_t x,
                          nqm_surface_point *point) {
    double width = (double)o->width, height = (double)o->height, half = fmin(width, height) / 2;
    double y = (double)(row % o->height);
    return nqm_view_look(v, ((double)x + 0.5 - width / 2) / half, (height / 2 - y - 0.5) / half, point);
}

static void count_row(void *user, size_t row) {
    const raster *r = user;
    nqm_view v = nqm_view_make(r->shape, r->options, row / r->options->height);
    nqm_surface_point point;
    for (size_t x = 0; x < r->options->width; ++x)
        r->first[row + 1] += look_at_pixel(r->options, &v, row, x, &point);
}

static void keep_row(void *user, size_t row) {
    const raster *r = user;
    nqm_view v = nqm_view_make(r->shape, r->options, row / r->options->height);
    nqm_surface_point point;
    size_t i = r->first[row];
    for (size_t x = 0; x < r->options->width; ++x)
        if (look_at_pixel(r->options, &v, row, x, &point)) {
            if (r->seen->point)
                r->seen->point[i] = point;
            r->seen->pixel[i++] = row * r->options->width + x;
        }
}

static nqm_status alloc_pixels(nqm_seen *seen, nqm_error *err) {
    const bool stores = seen->n <= MAX_STORED;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&seen->block, 0, 1}, {&seen->pixel, seen->n, sizeof *seen->pixel},
                                                    {&seen->point, stores ? seen->n : 0, sizeof *seen->point}),
                                         err);
    seen->point = stores ? seen->point : NULL;
    return status;
}

nqm_status nqm_view_pixels(const nqm_shape *shape, const nqm_scene_options *o, nqm_seen *seen, nqm_error *err) {
    const size_t n_rows = o->n_frames * o->height;
    raster r = {.shape = shape, .options = o, .first = nqm_alloc(n_rows + 1, sizeof *r.first), .seen = seen};
    if (!r.first)
        return nqm_fail_nomem(err, n_rows * sizeof *r.first);
    nqm_ticker ticker = {.fn = o->progress, .user = o->progress_user};
    bool stopped = nqm_parallel_ticking(&ticker, "view", n_rows, count_row, &r);
    for (size_t row = 0; row < n_rows; ++row)
        r.first[row + 1] += r.first[row];
    seen->n = r.first[n_rows];
    nqm_status status = stopped ? NQM_OK : alloc_pixels(seen, err);
    if (status == NQM_OK && !stopped)
        stopped = nqm_parallel_ticking(&ticker, "view", n_rows, keep_row, &r);
    nqm_free(r.first);
    return status == NQM_OK && stopped ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted") : status;
}

const nqm_surface_point *nqm_scene_point(const nqm_scene *scene, size_t i, nqm_surface_point *made) {
    if (scene->seen.point)
        return &scene->seen.point[i];
    const nqm_scene_options *o = &scene->options;
    const size_t row = scene->seen.pixel[i] / o->width, x = scene->seen.pixel[i] % o->width;
    const nqm_view v = nqm_view_make(&scene->shape, o, row / o->height);
    (void)look_at_pixel(o, &v, row, x, made); /* the ray hits the shape, as before */
    return made;
}
