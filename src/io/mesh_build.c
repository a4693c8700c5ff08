/* SPDX-License-Identifier: MIT
 *
 * What the readers of PLY and OBJ share: rows, sets of rows, words and triangles.
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
