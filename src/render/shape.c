/* SPDX-License-Identifier: MIT
 *
 * The shape on the turntable: an analytic sphere, or a mesh with interpolated normals, centred and scaled so that it fills
 * nine tenths of the picture during a whole turn.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <string.h>

static const double filled = 0.9; /* part of the picture that the shape fills */
static const double above = 1e-4; /* offset of ray origins from the surface, in units of half the picture */

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* Extent of a mesh on the turntable, whose axis passes through the centre of the mesh: largest distance from the axis, and half
 * the height in the picture. */
typedef struct extent {
    double centre[3], radius, half_height;
} extent;

static void find_centre(const nqm_mesh *mesh, double *centre) {
    for (size_t k = 0; k < 3; ++k) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < mesh->n_vertices; ++i) {
            low = fmin(low, (double)mesh->position[3 * i + k]);
            high = fmax(high, (double)mesh->position[3 * i + k]);
        }
        centre[k] = (low + high) / 2;
    }
}

/* During a turn a vertex at height y and distance r from the axis appears at y cos(elevation) -+ r sin(elevation). */
static extent find_extent(const nqm_mesh *mesh, double elevation_rad) {
    extent e = {.radius = 0};
    double sine = fabs(sin(elevation_rad)), cosine = cos(elevation_rad), low = INFINITY, high = -INFINITY;
    find_centre(mesh, e.centre);
    for (size_t i = 0; i < mesh->n_vertices; ++i) {
        const float *p = mesh->position + 3 * i;
        double r = hypot((double)p[0] - e.centre[0], (double)p[2] - e.centre[2]);
        double y = ((double)p[1] - e.centre[1]) * cosine;
        e.radius = fmax(e.radius, r);
        low = fmin(low, y - r * sine);
        high = fmax(high, y + r * sine);
    }
    if (cosine > 0.1)
        e.centre[1] += (low + high) / 2 / cosine;
    e.half_height = cosine > 0.1 ? (high - low) / 2 : fmax(high, -low);
    return e;
}

static nqm_status fit_mesh(nqm_mesh *mesh, double elevation_rad, double half_width, double half_height,
                           nqm_error *err) {
    extent e = find_extent(mesh, elevation_rad);
    double scale = filled * fmin(half_width / e.radius, half_height / e.half_height);
    if (!(e.radius > 0) || !isfinite(scale))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "scene: the mesh has no extent");
    for (size_t i = 0; i < 3 * mesh->n_vertices; ++i)
        mesh->position[i] = (float)(((double)mesh->position[i] - e.centre[i % 3]) * scale);
    return NQM_OK;
}

nqm_status nqm_shape_create(const char *name, double elevation_rad, double half_width, double half_height,
                            nqm_shape *shape_ret, nqm_error *err) {
    nqm_shape shape = {.radius = 0};
    *shape_ret = shape;
    if (!name || strcmp(name, "sphere") == 0) {
        shape_ret->radius = filled * fmin(half_width, half_height);
        return NQM_OK;
    }
    nqm_status status =
        strcmp(name, "blob") == 0 ? nqm_blob_create(&shape.mesh, err) : nqm_mesh_load(name, &shape.mesh, err);
    if (status == NQM_OK)
        status = fit_mesh(&shape.mesh, elevation_rad, half_width, half_height, err);
    if (status == NQM_OK)
        status = nqm_tracer_create(&shape.mesh, &shape.tracer, err);
    if (status == NQM_OK)
        *shape_ret = shape;
    else
        nqm_shape_clear(&shape);
    return status;
}

void nqm_shape_clear(nqm_shape *shape) {
    nqm_tracer_free(shape->tracer);
    nqm_mesh_free(&shape->mesh);
    *shape = (nqm_shape){0};
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

static bool hit_sphere(double radius, const double *origin, const double *direction, nqm_hit *hit) {
    double b = nqm_dot3(origin, direction), c = nqm_dot3(origin, origin) - radius * radius;
    double square = b * b - c;
    if (!(square > 0) || b > 0)
        return false;
    double t = -b - sqrt(square);
    for (int k = 0; k < 3; ++k) {
        hit->origin[k] = origin[k] + t * direction[k];
        hit->normal[k] = hit->origin[k];
    }
    nqm_normalize3(hit->normal);
    return true;
}

/* Corners of a triangle. */
typedef struct corners {
    double position[3][3], normal[3][3];
} corners;

static corners get_corners(const nqm_mesh *mesh, size_t triangle) {
    corners c;
    for (size_t i = 0; i < 3; ++i) {
        size_t vertex = mesh->triangle[3 * triangle + i];
        for (size_t k = 0; k < 3; ++k) {
            c.position[i][k] = (double)mesh->position[3 * vertex + k];
            c.normal[i][k] = (double)mesh->normal[3 * vertex + k];
        }
    }
    return c;
}

static void face_normal(const corners *c, double *normal) {
    double a[3], b[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = c->position[1][k] - c->position[0][k];
        b[k] = c->position[2][k] - c->position[0][k];
    }
    nqm_cross3(a, b, normal);
    nqm_normalize3(normal);
}

static void mix(const double v[3][3], const double *weight, double *sum) {
    for (int k = 0; k < 3; ++k)
        sum[k] = weight[0] * v[0][k] + weight[1] * v[1][k] + weight[2] * v[2][k];
}

static void negate(double *v) {
    for (int k = 0; k < 3; ++k)
        v[k] = -v[k];
}

/* Neighbouring triangles would shadow rays that start on a flat triangle, and the edge of the shadow would show the triangles.
 * So rays start on the smooth surface (Hanika 2021, DOI 10.1007/978-1-4842-7185-8_4). */
static void lift(const corners *c, const double *weight, double side, double *origin) {
    double moved[3][3];
    for (int i = 0; i < 3; ++i) {
        double d[3];
        for (int k = 0; k < 3; ++k)
            d[k] = origin[k] - c->position[i][k];
        double below = fmin(side * nqm_dot3(d, c->normal[i]), 0);
        for (int k = 0; k < 3; ++k)
            moved[i][k] = origin[k] - below * side * c->normal[i][k];
    }
    mix((const double(*)[3])moved, weight, origin);
}

static void hit_triangle(const nqm_mesh *mesh, size_t triangle, const double *weight, const double *direction,
                         nqm_hit *hit) {
    corners c = get_corners(mesh, triangle);
    double face[3];
    face_normal(&c, face);
    mix((const double(*)[3])c.position, weight, hit->origin);
    mix((const double(*)[3])c.normal, weight, hit->normal);
    nqm_normalize3(hit->normal);
    if (nqm_dot3(face, direction) > 0)
        negate(face);
    double side = 1; /* -1: the ray hits the back side with respect to the normals of the file */
    if (nqm_dot3(face, hit->normal) < 0) {
        negate(hit->normal);
        side = -1;
    }
    lift(&c, weight, side, hit->origin);
    for (int k = 0; k < 3; ++k)
        hit->origin[k] += above * face[k];
}

bool nqm_shape_hit(const nqm_shape *shape, const double *origin, const double *direction, nqm_hit *hit) {
    size_t triangle;
    double weight[3];
    if (!shape->tracer)
        return hit_sphere(shape->radius, origin, direction, hit);
    if (!nqm_tracer_hit(shape->tracer, origin, direction, &triangle, weight))
        return false;
    hit_triangle(&shape->mesh, triangle, weight, direction, hit);
    return true;
}

bool nqm_shape_blocked(const nqm_shape *shape, const double *origin, const double *direction) {
    return shape->tracer && nqm_tracer_blocked(shape->tracer, origin, direction); /* a sphere is convex */
}
