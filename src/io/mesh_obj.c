/* SPDX-License-Identifier: MIT
 *
 * Wavefront OBJ: statements v, vn and f with all forms of indices (v, v/vt, v//vn, v/vt/vn; counted from 1, or
 * negative: counted back from the latest one); a backslash at the end of a line continues it; everything else is
 * skipped. A face may refer only to vertices and normals that precede it in the file.
 */
#include "io/mesh_build.h"

#include <string.h>

static const uint32_t none = UINT32_MAX;

typedef struct obj_file {
    nqm_mesh_reader *r;
    nqm_mesh_rows normals;          /* normals of the vn statements */
    nqm_mesh_rows triangle_normals; /* (n_triangles, 3) indices into `normals`, or `none` */
    bool lacks_normals;             /* a corner has no normal */
} obj_file;

/* Read the next word of the statement. A backslash continues the statement on the next line. */
static bool next_word(nqm_mesh_reader *r, char word[NQM_MESH_TOKEN]) {
    while (nqm_mesh_word(r, word)) {
        if (strcmp(word, "\\") != 0)
            return true;
        if (!nqm_mesh_next_line(r))
            return false;
    }
    return false;
}

static nqm_status read_vector(nqm_mesh_reader *r, nqm_mesh_rows *rows, const char *what) {
    char word[NQM_MESH_TOKEN];
    double xyz[3];
    for (int k = 0; k < 3; ++k) {
        const char *end;
        if (!next_word(r, word))
            return nqm_mesh_fail(r, "a %s needs three numbers", what);
        if (!nqm_parse_double(word, &end, &xyz[k]) || *end)
            return nqm_mesh_fail(r, "'%.20s' in a %s is no finite number", word, what);
    }
    return nqm_mesh_add_vector(r, rows, xyz, what);
}

/* Parse a nonzero integer at *text and move *text past it. */
static bool parse_index(const char **text, int64_t *index) {
    const char *p = *text;
    bool negative = *p == '-';
    int64_t value = 0;
    p += negative || *p == '+';
    const char *digits = p;
    for (; *p >= '0' && *p <= '9' && p - digits < 12; ++p)
        value = 10 * value + (*p - '0');
    *text = p;
    *index = negative ? -value : value;
    return p != digits && value != 0;
}

/* Convert an index of OBJ to an index from 0; false when it is not one of the n entries read so far. */
static bool resolve(int64_t index, size_t n, uint32_t *resolved) {
    int64_t at = index > 0 ? index - 1 : (int64_t)n + index;
    *resolved = (uint32_t)at;
    return at >= 0 && at < (int64_t)n;
}

static nqm_status read_corner(obj_file *obj, const char *word, nqm_fan *fan) {
    nqm_mesh_reader *r = obj->r;
    const char *text = word;
    int64_t index, texture;
    uint32_t vertex = none, normal = none;
    bool good = parse_index(&text, &index);
    if (good && !resolve(index, r->vertices.n, &vertex))
        return nqm_mesh_fail(r, "corner '%.20s': there are %zu vertices so far", word, r->vertices.n);
    if (good && *text == '/') {
        ++text;
        good = *text == '/' || parse_index(&text, &texture);
        if (good && *text == '/') {
            ++text;
            good = parse_index(&text, &index);
            if (good && !resolve(index, obj->normals.n, &normal))
                return nqm_mesh_fail(r, "corner '%.20s': there are %zu normals so far", word, obj->normals.n);
        }
    }
    if (!good || *text)
        return nqm_mesh_fail(r, "'%.20s' is no corner of a face", word);
    obj->lacks_normals = obj->lacks_normals || normal == none;
    return nqm_fan_add(r, fan, vertex, normal, &obj->triangle_normals);
}

static nqm_status read_face(obj_file *obj) {
    char word[NQM_MESH_TOKEN];
    nqm_fan fan = {0};
    nqm_status status = NQM_OK;
    while (status == NQM_OK && next_word(obj->r, word))
        status = read_corner(obj, word, &fan);
    if (status == NQM_OK && fan.n_corners < 3)
        return nqm_mesh_fail(obj->r, "a face has %zu corners", fan.n_corners);
    return status;
}

static nqm_status read_statements(obj_file *obj) {
    nqm_mesh_reader *r = obj->r;
    nqm_status status = NQM_OK;
    char word[NQM_MESH_TOKEN];
    do {
        if (!next_word(r, word) || word[0] == '#')
            continue;
        if (strcmp(word, "v") == 0)
            status = read_vector(r, &r->vertices, "vertex");
        else if (strcmp(word, "vn") == 0)
            status = read_vector(r, &obj->normals, "normal");
        else if (strcmp(word, "f") == 0)
            status = read_face(obj);
    } while (status == NQM_OK && nqm_mesh_next_line(r));
    return status;
}

/* New vertices, one for each pair of position and normal. */
typedef struct joined {
    nqm_mesh_rows vertices, normals;
    nqm_mesh_set pairs; /* keys: old vertex, normal, 0 */
} joined;

static bool join(joined *j, const obj_file *obj, uint32_t vertex, uint32_t normal, uint32_t *index) {
    const uint32_t row[3] = {vertex, normal, 0};
    if (!nqm_mesh_set_add(&j->pairs, row, index))
        return false;
    if (*index < j->vertices.n)
        return true;
    const float(*position)[3] = obj->r->vertices.data, (*direction)[3] = obj->normals.data;
    return nqm_mesh_rows_add(&j->vertices, position[vertex]) && nqm_mesh_rows_add(&j->normals, direction[normal]);
}

/* Make one vertex for each pair of position and normal that the faces use. There are at most as many pairs as corners,
 * whose number is bounded. */
static nqm_status join_normals(obj_file *obj) {
    nqm_mesh_reader *r = obj->r;
    uint32_t(*triangle)[3] = r->triangles.data;
    const uint32_t(*normal)[3] = obj->triangle_normals.data;
    joined j = {0};
    bool good = normal != NULL;
    for (size_t t = 0; good && t < r->triangles.n; ++t)
        for (size_t k = 0; good && k < 3; ++k)
            good = join(&j, obj, triangle[t][k], normal[t][k], &triangle[t][k]);
    nqm_mesh_set_clear(&j.pairs);
    nqm_free(r->vertices.data);
    r->vertices = j.vertices;
    r->normals = j.normals;
    return good ? NQM_OK : nqm_fail_nomem(r->err, r->triangles.n * sizeof *triangle);
}

nqm_status nqm_mesh_read_obj(nqm_mesh_reader *r) {
    obj_file obj = {.r = r};
    r->format = "OBJ";
    nqm_status status = read_statements(&obj);
    if (status == NQM_OK && r->triangles.n && !obj.lacks_normals)
        status = join_normals(&obj);
    nqm_free(obj.normals.data);
    nqm_free(obj.triangle_normals.data);
    return status;
}
