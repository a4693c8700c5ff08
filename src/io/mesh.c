/* SPDX-License-Identifier: MIT
 *
 * Triangle meshes: detects the file format, computes missing normals, and implements mesh_build.h, which the readers of
 * PLY and OBJ share.
 */
#include "io/mesh_build.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

enum { ROW_BYTES = 12 };

bool nqm_mesh_rows_add(nqm_mesh_rows *rows, const void *row) {
    void *data = nqm_grow(rows->data, &rows->max_n, rows->n + 1, ROW_BYTES);
    if (!data)
        return false;
    rows->data = data;
    memcpy((unsigned char *)data + rows->n++ * ROW_BYTES, row, ROW_BYTES);
    return true;
}

/* The slot of a row: the one that has it, or the free one where it belongs. */
static uint32_t *find_slot(const nqm_mesh_set *set, const uint32_t row[3]) {
    const uint32_t(*rows)[3] = set->rows.data;
    size_t at = nqm_hash_u64((uint64_t)row[0] << 32 | row[1], row[2]) & (set->n_slots - 1);
    while (set->slot[at] && memcmp(rows[set->slot[at] - 1], row, ROW_BYTES) != 0)
        at = (at + 1) & (set->n_slots - 1);
    return &set->slot[at];
}

/* Make a table that is at most half full with one more row. */
static bool enlarge(nqm_mesh_set *set) {
    enum { MIN_SLOTS = 256 };
    if (2 * (set->rows.n + 1) <= set->n_slots)
        return true;
    nqm_mesh_set larger = {.rows = set->rows, .n_slots = nqm_larger(2 * set->n_slots, MIN_SLOTS)};
    larger.slot = nqm_alloc(larger.n_slots, sizeof *larger.slot);
    if (!larger.slot)
        return false;
    const uint32_t(*rows)[3] = set->rows.data;
    for (size_t i = 0; i < set->rows.n; ++i)
        *find_slot(&larger, rows[i]) = (uint32_t)i + 1;
    nqm_free(set->slot);
    *set = larger;
    return true;
}

bool nqm_mesh_set_add(nqm_mesh_set *set, const uint32_t row[3], uint32_t *index_ret) {
    if (!enlarge(set))
        return false;
    uint32_t *slot = find_slot(set, row);
    if (!*slot) {
        if (!nqm_mesh_rows_add(&set->rows, row))
            return false;
        *slot = (uint32_t)set->rows.n;
    }
    *index_ret = *slot - 1;
    return true;
}

void nqm_mesh_set_clear(nqm_mesh_set *set) {
    nqm_free(set->slot);
    nqm_free(set->rows.data);
    *set = (nqm_mesh_set){0};
}

static nqm_status fail_room(const nqm_mesh_reader *r, const nqm_mesh_rows *rows) {
    return nqm_fail_nomem(r->err, 2 * rows->n * ROW_BYTES);
}

nqm_status nqm_mesh_fail(const nqm_mesh_reader *r, const char *format, ...) {
    char message[200];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    return nqm_fail(r->err, NQM_ERR_FORMAT, (int64_t)r->position, "%s: %s %s %zu: %s", r->map->path, r->format,
                    r->line ? "in line" : "at byte", r->line ? r->line : r->position, message);
}

bool nqm_mesh_word(nqm_mesh_reader *r, char word[NQM_MESH_TOKEN]) {
    const unsigned char *data = r->map->data;
    size_t end = r->map->n_bytes, at = r->position, n = 0;
    while (at < end && (data[at] == ' ' || data[at] == '\t' || data[at] == '\r'))
        ++at;
    if (at >= end || data[at] == '\n')
        return false;
    for (; at < end && data[at] > ' '; ++at)
        if (n < NQM_MESH_TOKEN - 1)
            word[n++] = (char)data[at];
        else
            word[n - 1] = '~'; /* too long for a number: the prefix must not parse as one */
    if (n == 0)                /* some other control character: an unknown word */
        word[n++] = (char)data[at++];
    word[n] = 0;
    r->position = at;
    return true;
}

bool nqm_mesh_next_line(nqm_mesh_reader *r) {
    size_t left = r->map->n_bytes - r->position;
    const unsigned char *begin = r->map->data + r->position;
    const unsigned char *end = left ? memchr(begin, '\n', left) : NULL;
    r->position = end ? r->position + (size_t)(end - begin) + 1 : r->map->n_bytes;
    r->line += end != NULL;
    return r->position < r->map->n_bytes;
}

nqm_status nqm_mesh_add_vector(nqm_mesh_reader *r, nqm_mesh_rows *rows, const double *xyz, const char *what) {
    float row[3];
    for (int k = 0; k < 3; ++k)
        row[k] = (float)xyz[k];
    if (!isfinite(row[0]) || !isfinite(row[1]) || !isfinite(row[2]))
        return nqm_mesh_fail(r, "a %s is not finite", what);
    if (rows->n >= NQM_MESH_MAX_VERTICES)
        return nqm_fail(r->err, NQM_ERR_LIMIT, (int64_t)r->position, "%s: more than %d vertices", r->map->path,
                        (int)NQM_MESH_MAX_VERTICES);
    return nqm_mesh_rows_add(rows, row) ? NQM_OK : fail_room(r, rows);
}

/* Whether the triangle is one of those left out; otherwise it is one of those seen now. */
static nqm_status see_triangle(nqm_mesh_reader *r, const uint32_t v[3], bool *is_new_ret) {
    *is_new_ret = false;
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
        return NQM_OK;
    const size_t k = v[0] < v[1] && v[0] < v[2] ? 0 : v[1] < v[2] ? 1 : 2, n = r->seen.rows.n;
    const uint32_t turned[3] = {v[k], v[(k + 1) % 3], v[(k + 2) % 3]};
    uint32_t index;
    if (!nqm_mesh_set_add(&r->seen, turned, &index))
        return fail_room(r, &r->triangles);
    *is_new_ret = index == n;
    return NQM_OK;
}

/* A triangle takes about 120 bytes here and in the tracer, and 12 bytes or more of the file of a large mesh. */
static size_t max_triangles(const nqm_mesh_reader *r) {
    enum { FREE_TRIANGLES = 1 << 18, BYTES_PER_TRIANGLE = 12 };
    return nqm_smaller(FREE_TRIANGLES + r->map->n_bytes / BYTES_PER_TRIANGLE, NQM_MESH_MAX_TRIANGLES);
}

nqm_status nqm_fan_add(nqm_mesh_reader *r, nqm_fan *fan, uint32_t vertex, uint32_t normal, nqm_mesh_rows *normals) {
    const uint32_t corner[2] = {vertex, normal};
    if (fan->n_corners >= 2) {
        const uint32_t vertices[3] = {fan->first[0], fan->last[0], vertex};
        const uint32_t normals_of[3] = {fan->first[1], fan->last[1], normal};
        bool is_new;
        const nqm_status status = see_triangle(r, vertices, &is_new);
        if (status != NQM_OK)
            return status;
        if (is_new && r->triangles.n >= max_triangles(r))
            return nqm_fail(r->err, NQM_ERR_LIMIT, (int64_t)r->position,
                            "%s: more than %zu triangles at byte %zu, the limit for a file of %zu bytes", r->map->path,
                            max_triangles(r), r->position, r->map->n_bytes);
        if (is_new &&
            (!nqm_mesh_rows_add(&r->triangles, vertices) || (normals && !nqm_mesh_rows_add(normals, normals_of))))
            return fail_room(r, &r->triangles);
    }
    if (fan->n_corners++ == 0)
        memcpy(fan->first, corner, sizeof corner);
    memcpy(fan->last, corner, sizeof corner);
    return NQM_OK;
}

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
