/* SPDX-License-Identifier: MIT
 *
 * The built-in blob: a closed smooth shape with ears that cast shadows and with hollows, so that shadows and
 * interreflection occur without a mesh file. Its radius is a function of the direction, r(w) = r0 + sum of
 * a exp(k (w . d - 1)); the normals are exact, along w - grad r / r.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdlib.h>

enum { STEPS = 64, SIDE = STEPS + 1, N_FACES = 6 };

/* A bump (a > 0) or hollow (a < 0) around a direction. */
typedef struct bump {
    double direction[3], amplitude, sharpness;
} bump;

static const double base_radius = 0.62;
static const bump bumps[] = {
    {{0.45, 0.88, 0.10}, 0.55, 14},  {{-0.35, 0.90, -0.25}, 0.50, 12}, {{0.20, -0.10, 0.97}, 0.33, 6},
    {{-0.62, 0.15, 0.77}, -0.30, 9}, {{0.30, 0.20, -0.93}, -0.34, 7},  {{0.98, -0.10, 0.15}, -0.28, 8},
    {{-0.60, -0.77, 0.20}, 0.40, 7}, {{-0.91, 0.10, -0.40}, 0.30, 5},  {{0.30, -0.93, -0.20}, 0.25, 4},
};

/* Position and normal in unit direction w. */
static void place_vertex(const double *w, float *position, float *normal) {
    double r = base_radius, slope[3] = {0};
    for (size_t i = 0; i < sizeof bumps / sizeof *bumps; ++i) {
        const bump *s = &bumps[i];
        double d[3] = {s->direction[0], s->direction[1], s->direction[2]};
        nqm_normalize3(d);
        double value = s->amplitude * exp(s->sharpness * (nqm_dot3(w, d) - 1));
        r += value;
        for (int k = 0; k < 3; ++k)
            slope[k] += s->sharpness * value * d[k];
    }
    double along = nqm_dot3(slope, w), n[3];
    for (int k = 0; k < 3; ++k)
        n[k] = w[k] - (slope[k] - along * w[k]) / r;
    nqm_normalize3(n);
    for (int k = 0; k < 3; ++k) {
        position[k] = (float)(r * w[k]);
        normal[k] = (float)n[k];
    }
}

/* Coordinate of a grid line on one face of the cube, warped so that cells have similar size on the sphere. It is exactly odd in
 * the step, so that the faces join without gaps. */
static double warp(size_t step) {
    int from_middle = 2 * (int)step - STEPS;
    double value = tan(NQM_PI / 4 * abs(from_middle) / STEPS);
    value = from_middle == STEPS || from_middle == -STEPS ? 1 : value;
    return from_middle < 0 ? -value : value;
}

static void cube_direction(size_t face, size_t row, size_t column, double *w) {
    size_t axis = face / 2;
    double sign = face % 2 ? -1 : 1;
    w[axis] = sign;
    w[(axis + 1) % 3] =
        sign * warp(column); /* mirrored with the face, so that all triangles have the same orientation */
    w[(axis + 2) % 3] = warp(row);
    double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    for (int k = 0; k < 3; ++k)
        w[k] /= length;
}

static void fill_face(size_t face, nqm_mesh *mesh) {
    size_t first = face * SIDE * SIDE;
    uint32_t *triangle = mesh->triangle + face * 6 * STEPS * STEPS;
    for (size_t row = 0; row < SIDE; ++row)
        for (size_t column = 0; column < SIDE; ++column) {
            size_t vertex = first + row * SIDE + column;
            double w[3];
            cube_direction(face, row, column, w);
            place_vertex(w, mesh->position + 3 * vertex, mesh->normal + 3 * vertex);
            if (row == STEPS || column == STEPS)
                continue;
            const size_t corner[6] = {vertex, vertex + 1, vertex + SIDE + 1, vertex, vertex + SIDE + 1, vertex + SIDE};
            for (size_t i = 0; i < 6; ++i)
                *triangle++ = (uint32_t)corner[i];
        }
}

nqm_status nqm_blob_create(nqm_mesh *mesh_ret, nqm_error *err) {
    nqm_mesh mesh = {.n_vertices = N_FACES * SIDE * SIDE, .n_triangles = N_FACES * 2 * STEPS * STEPS};
    *mesh_ret = (nqm_mesh){0};
    mesh.position = nqm_alloc(mesh.n_vertices, 3 * sizeof *mesh.position);
    mesh.normal = nqm_alloc(mesh.n_vertices, 3 * sizeof *mesh.normal);
    mesh.triangle = nqm_alloc(mesh.n_triangles, 3 * sizeof *mesh.triangle);
    if (!mesh.position || !mesh.normal || !mesh.triangle) {
        nqm_mesh_free(&mesh);
        return nqm_fail_nomem(err, mesh.n_vertices * 6 * sizeof(float) + mesh.n_triangles * 3 * sizeof(uint32_t));
    }
    for (size_t face = 0; face < N_FACES; ++face)
        fill_face(face, &mesh);
    *mesh_ret = mesh;
    return NQM_OK;
}
