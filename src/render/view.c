/* SPDX-License-Identifier: MIT
 *
 * What the viewer sees: the visible points of all frames of the turntable, either at the centres of pixels or spread
 * evenly over the pictures by a low-discrepancy sequence, with their local frames.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <string.h>

static const double max_view_deg = 85; /* BRDFs are hardly known beyond; less than 1 % of a sphere's picture */

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

/* The part of v across the unit vector n, scaled to unit length; its length is returned. Any direction across when there
 * is none. */
static double part_across(const double *v, const double *n, double *across) {
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

static void bend(const double *towards, double *normal) {
    const double limit = max_view_deg * NQM_PI / 180;
    if (nqm_dot3(normal, towards) >= cos(limit))
        return;
    double across[3];
    part_across(normal, towards, across);
    for (int k = 0; k < 3; ++k)
        normal[k] = cos(limit) * towards[k] + sin(limit) * across[k];
}

void nqm_surface_point_make(const nqm_hit *hit, const double *turn, const double *towards, nqm_surface_point *point) {
    double *tangent = point->frame, *bitangent = point->frame + 3, *normal = point->frame + 6;
    world_from_shape(turn, hit->normal, normal);
    bend(towards, normal);
    point->wo[0] = part_across(towards, normal, tangent);
    point->wo[1] = 0;
    point->wo[2] = nqm_dot3(towards, normal);
    nqm_cross3(normal, tangent, bitangent);
    memcpy(point->origin, hit->origin, sizeof hit->origin);
    memcpy(point->turn, turn, sizeof point->turn);
}

/* ---- rays of the viewer ------------------------------------------------------------------------------------------ */

/* The viewer and one frame of the turntable. */
typedef struct view {
    const nqm_shape *shape;
    double axes[9];
    double distance; /* of the rays' origins: beyond the shape */
    double turn[2];
} view;

static view make_view(const nqm_shape *shape, const nqm_scene_options *o, size_t frame) {
    view v = {.shape = shape, .distance = 4};
    double angle = o->turn_rad + 2 * NQM_PI * (double)frame / (double)o->n_frames;
    nqm_view_axes(o->elevation_rad, v.axes);
    v.turn[0] = sin(angle);
    v.turn[1] = cos(angle);
    if (o->width)
        v.distance *= (double)(o->width > o->height ? o->width : o->height) /
                      (double)(o->width < o->height ? o->width : o->height);
    return v;
}

/* The point that shows at (x, y), in halves of the picture's shorter side from its middle to the right and up. */
static bool look(const view *v, double x, double y, nqm_surface_point *point) {
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

/* Rows of all frames, looked at in parallel: once to count, once to keep. */
typedef struct raster {
    const nqm_shape *shape;
    const nqm_scene_options *options;
    size_t *first; /* (n_frames * height + 1) first point of each row */
    nqm_surface_point *point;
    size_t *pixel;
} raster;

static bool look_at_pixel(const raster *r, const view *v, size_t row, size_t x, nqm_surface_point *point) {
    double width = (double)r->options->width, height = (double)r->options->height, half = fmin(width, height) / 2;
    double y = (double)(row % r->options->height);
    return look(v, ((double)x + 0.5 - width / 2) / half, (height / 2 - y - 0.5) / half, point);
}

static void count_row(void *user, size_t row) {
    const raster *r = user;
    view v = make_view(r->shape, r->options, row / r->options->height);
    nqm_surface_point point;
    for (size_t x = 0; x < r->options->width; ++x)
        r->first[row + 1] += look_at_pixel(r, &v, row, x, &point);
}

static void keep_row(void *user, size_t row) {
    const raster *r = user;
    view v = make_view(r->shape, r->options, row / r->options->height);
    nqm_surface_point point;
    size_t i = r->first[row];
    for (size_t x = 0; x < r->options->width; ++x)
        if (look_at_pixel(r, &v, row, x, &point)) {
            r->point[i] = point;
            r->pixel[i++] = row * r->options->width + x;
        }
}

static nqm_status see_pixels(raster *r, size_t *n_ret, nqm_error *err) {
    size_t n_rows = r->options->n_frames * r->options->height;
    r->first = nqm_alloc(n_rows + 1, sizeof *r->first);
    if (!r->first)
        return nqm_fail_nomem(err, n_rows * sizeof *r->first);
    nqm_parallel_for(n_rows, count_row, r);
    for (size_t row = 0; row < n_rows; ++row)
        r->first[row + 1] += r->first[row];
    *n_ret = r->first[n_rows];
    r->point = nqm_alloc(*n_ret, sizeof *r->point);
    r->pixel = nqm_alloc(*n_ret, sizeof *r->pixel);
    if (!r->point || !r->pixel)
        return nqm_fail_nomem(err, *n_ret * (sizeof *r->point + sizeof *r->pixel));
    nqm_parallel_for(n_rows, keep_row, r);
    return NQM_OK;
}

/* ---- points spread evenly ---------------------------------------------------------------------------------------- */

static double random_unit(uint64_t seed, uint64_t counter) {
    return (double)(nqm_hash_u64(seed, counter) >> 11) * 0x1p-53;
}

/* A sunflower (Vogel 1979, DOI 10.1016/0025-5564(79)90080-4): even in area over the disc, for any number. */
static void see_sphere(const nqm_scene_options *o, nqm_surface_point *point) {
    const double golden_angle = NQM_PI * (3 - sqrt(5)), turn[2] = {0, 1};
    double start = 2 * NQM_PI * random_unit(o->seed, UINT64_MAX), axes[9];
    nqm_view_axes(o->elevation_rad, axes);
    for (size_t i = 0; i < o->n_points; ++i) {
        double r = sin(max_view_deg * NQM_PI / 180) * sqrt(((double)i + 0.5) / (double)o->n_points);
        double phi = start + golden_angle * (double)i, x = r * cos(phi), y = r * sin(phi), z = sqrt(1 - r * r);
        nqm_hit hit = {{0}, {0}};
        for (int k = 0; k < 3; ++k)
            hit.normal[k] = x * axes[k] + y * axes[3 + k] + z * axes[6 + k];
        nqm_surface_point_make(&hit, turn, axes + 6, &point[i]);
    }
}

/* Places in all pictures by turns, each picture with its own shift of the R2 sequence (multiples of the inverse powers of
 * the plastic number, Roberts 2018), until enough of them show the shape. */
static nqm_status see_mesh(const nqm_shape *shape, const nqm_scene_options *o, nqm_surface_point *point,
                           nqm_error *err) {
    const double plastic = 1.3247179572447460260;
    size_t n = 0, most = 1000 * (o->n_points + o->n_frames);
    for (size_t i = 0; n < o->n_points; ++i) {
        if (i == most)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: hardly anything of the shape can be seen", o->shape);
        size_t frame = i % o->n_frames;
        double step = (double)(i / o->n_frames + 1);
        double x = random_unit(o->seed, UINT64_MAX - 2 * frame) + step / plastic;
        double y = random_unit(o->seed, UINT64_MAX - 2 * frame - 1) + step / (plastic * plastic);
        view v = make_view(shape, o, frame);
        n += look(&v, 2 * (x - floor(x)) - 1, 2 * (y - floor(y)) - 1, &point[n]);
    }
    return NQM_OK;
}

nqm_status nqm_view_points(const nqm_shape *shape, const nqm_scene_options *options, nqm_surface_point **point_ret,
                           size_t **pixel_ret, size_t *n_ret, nqm_error *err) {
    raster r = {.shape = shape, .options = options};
    nqm_status status = NQM_OK;
    size_t n = options->n_points;
    if (options->width)
        status = see_pixels(&r, &n, err);
    else if (!(r.point = nqm_alloc(n, sizeof *r.point)))
        status = nqm_fail_nomem(err, n * sizeof *r.point);
    else if (shape->tracer)
        status = see_mesh(shape, options, r.point, err);
    else
        see_sphere(options, r.point);
    nqm_free(r.first);
    if (status != NQM_OK) {
        nqm_free(r.point);
        nqm_free(r.pixel);
        r.point = NULL, r.pixel = NULL, n = 0;
    }
    *point_ret = r.point;
    *pixel_ret = r.pixel;
    *n_ret = n;
    return status;
}
