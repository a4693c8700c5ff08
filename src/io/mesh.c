/* SPDX-License-Identifier: MIT
 *
 * Triangle meshes: detects the file format and computes missing normals.
 */
#include "io/mesh_build.h"

#include <math.h>
#include <string.h>

/* Add the normal of each triangle to the sums of its corners; the length of the normal is twice the triangle's area.
 * sum: (n_vertices, 3). */
static void sum_normals(const nqm_mesh *mesh, double *sum) {
    for (size_t t = 0; t < mesh->n_triangles; ++t) {
        const uint32_t *corner = mesh->triangle + 3 * t;
        double edge[2][3];
        for (size_t e = 0; e < 2; ++e)
            for (size_t k = 0; k < 3; ++k)
                edge[e][k] = (double)mesh->position[3 * (size_t)corner[e + 1] + k] -
                             (double)mesh->position[3 * (size_t)corner[0] + k];
        for (size_t k = 0; k < 3; ++k) {
            size_t a = (k + 1) % 3, b = (k + 2) % 3;
            double area = edge[0][a] * edge[1][b] - edge[0][b] * edge[1][a];
            for (size_t c = 0; c < 3; ++c)
                sum[3 * (size_t)corner[c] + k] += area;
        }
    }
}

/* Normalise the normals of the file. Normals that are missing or 0 become the area-weighted mean of the triangles'
 * normals; a vertex for which this is 0 too gets +z. */
static nqm_status complete_normals(nqm_mesh *mesh, nqm_error *err) {
    bool given = mesh->normal != NULL;
    double *sum = nqm_alloc(mesh->n_vertices, 3 * sizeof *sum);
    if (sum && !given)
        mesh->normal = nqm_alloc(mesh->n_vertices, 3 * sizeof *mesh->normal);
    if (!sum || !mesh->normal) {
        nqm_free(sum);
        return nqm_fail_nomem(err, mesh->n_vertices * 3 * sizeof *sum);
    }
    sum_normals(mesh, sum);
    for (size_t i = 0; i < mesh->n_vertices; ++i) {
        float *normal = mesh->normal + 3 * i;
        const double from_file[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
        const double *n = from_file[0] != 0 || from_file[1] != 0 || from_file[2] != 0 ? from_file : sum + 3 * i;
        double length = hypot(hypot(n[0], n[1]), n[2]);
        for (size_t k = 0; k < 3; ++k)
            normal[k] = length > 0 ? (float)(n[k] / length) : k == 2 ? 1.0f : 0.0f;
    }
    nqm_free(sum);
    return NQM_OK;
}

/* true when the first word of the text, comments skipped, is an OBJ statement. */
static bool looks_like_obj(const nqm_map *map) {
    static const char *const words[] = {"v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"};
    nqm_mesh_reader r = {.map = map, .line = 1};
    char word[NQM_MESH_TOKEN];
    do {
        if (!nqm_mesh_word(&r, word) || word[0] == '#')
            continue;
        for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
            if (strcmp(word, words[i]) == 0)
                return true;
        return false;
    } while (nqm_mesh_next_line(&r));
    return false;
}

static nqm_status read_any(nqm_mesh_reader *r) {
    const nqm_map *map = r->map;
    if (map->n_bytes >= 4 && memcmp(map->data, "ply", 3) == 0 && (map->data[3] == '\n' || map->data[3] == '\r'))
        return nqm_mesh_read_ply(r);
    if (looks_like_obj(map))
        return nqm_mesh_read_obj(r);
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    return nqm_fail(r->err, NQM_ERR_FORMAT, 0, "%s: neither a PLY nor an OBJ mesh%s%s (byte 0)", map->path,
                    kind ? " but " : "", kind ? kind : "");
}

nqm_status nqm_mesh_parse(const nqm_map *map, nqm_mesh *mesh_ret, nqm_error *err) {
    nqm_mesh_reader r = {.map = map, .line = 1, .err = err};
    *mesh_ret = (nqm_mesh){0};
    nqm_status status = read_any(&r);
    nqm_mesh_set_clear(&r.seen);
    if (status == NQM_OK && r.triangles.n == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the mesh has no faces", map->path);
    nqm_mesh mesh = {.n_vertices = r.vertices.n,
                     .n_triangles = r.triangles.n,
                     .position = r.vertices.data,
                     .triangle = r.triangles.data,
                     .normal = r.normals.data};
    if (status == NQM_OK)
        status = complete_normals(&mesh, err);
    if (status == NQM_OK)
        *mesh_ret = mesh;
    else
        nqm_mesh_free(&mesh);
    return status;
}

nqm_status nqm_mesh_load(const char *path, nqm_mesh *mesh_ret, nqm_error *err) {
    nqm_map map;
    *mesh_ret = (nqm_mesh){0};
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_mesh_parse(&map, mesh_ret, err);
    nqm_map_close(&map);
    return status;
}

void nqm_mesh_free(nqm_mesh *mesh) {
    nqm_free(mesh->position);
    nqm_free(mesh->triangle);
    nqm_free(mesh->normal);
    *mesh = (nqm_mesh){0};
}
