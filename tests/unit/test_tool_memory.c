/* SPDX-License-Identifier: MIT
 *
 * Memory of the readers of text: files of a few megabytes that consist of the smallest possible fields, values, elements or
 * corners. A reader takes at most ten times the bytes of the file, or refuses it and names the limit. Each reader runs in a
 * process of its own, whose largest resident set is compared with that of a process that reads nothing.
 */
#include "brdf/formats/format.h"
#include "io/xml.h"
#include "material/material.h"
#include "nqm/score/pair_list.h"
#include "support/check.h"

#include <sys/resource.h>
#include <sys/wait.h>

enum { MEGA = 1 << 20, MAX_RATIO = 10 };

/* A text: head, then `unit` until it has n bytes, then tail. */
typedef struct text_shape {
    const char *name, *head, *unit, *tail;
    size_t n;
    nqm_status (*read)(const nqm_map *map, nqm_error *err);
    nqm_status status;
    const char *message; /* a part of the error's */
} text_shape;

static nqm_status read_nothing(const nqm_map *map, nqm_error *err) {
    (void)map, (void)err;
    return NQM_OK;
}

static nqm_status read_list(const nqm_map *map, nqm_error *err) {
    nqm_pair_list *list;
    const nqm_status status = nqm_pair_list_parse((const char *)map->data, map->n_bytes, map->path, &list, err);
    nqm_pair_list_free(list);
    return status;
}

static nqm_status read_csv(const nqm_map *map, nqm_error *err) {
    nqm_csv *csv;
    const nqm_status status = nqm_csv_parse((const char *)map->data, map->n_bytes, map->path, &csv, err);
    nqm_csv_free(csv);
    return status;
}

static nqm_status read_directions(const nqm_map *map, nqm_error *err) {
    nqm_brdf *brdf;
    nqm_map own = *map; /* the BRDF would unmap it */
    const nqm_status status = nqm_listed_format.open(&own, &(nqm_brdf_argument){.name = map->path}, &brdf, err);
    return status;
}

static nqm_status read_mesh(const nqm_map *map, nqm_error *err) {
    nqm_mesh mesh;
    const nqm_status status = nqm_mesh_parse(map, &mesh, err);
    nqm_mesh_free(&mesh);
    return status;
}

/* The text is the header. */
static nqm_status read_safetensors(const nqm_map *map, nqm_error *err) {
    nqm_safetensors *st;
    unsigned char *data = malloc(map->n_bytes + 8);
    assert_non_null(data);
    nqm_store_u64(data, map->n_bytes);
    memcpy(data + 8, map->data, map->n_bytes);
    const nqm_status status = nqm_safetensors_parse(data, map->n_bytes + 8, map->path, &st, err);
    nqm_safetensors_free(st);
    free(data);
    return status;
}

static nqm_status read_materials(const nqm_map *map, nqm_error *err) {
    nqm_materials *materials;
    const nqm_status status = nqm_materials_read(map, &materials, err);
    nqm_materials_free(materials);
    return status;
}

static nqm_status read_xml(const nqm_map *map, nqm_error *err) {
    nqm_xml xml;
    const nqm_status status = nqm_xml_parse(map->data, map->n_bytes, map->path, &xml, err);
    nqm_xml_free(&xml);
    return status;
}

static char *make_text(const text_shape *s, size_t *n_ret) {
    const size_t n_head = strlen(s->head), n_unit = strlen(s->unit), n_tail = strlen(s->tail);
    const size_t n_units = (s->n - n_head - n_tail) / n_unit;
    char *text = malloc(n_head + n_units * n_unit + n_tail + 1);
    assert_non_null(text);
    memcpy(text, s->head, n_head);
    for (size_t i = 0; i < n_units; ++i)
        memcpy(text + n_head + i * n_unit, s->unit, n_unit);
    memcpy(text + n_head + n_units * n_unit, s->tail, n_tail + 1);
    *n_ret = n_head + n_units * n_unit + n_tail;
    return text;
}

static int read_and_compare(const text_shape *s, const nqm_map *map) {
    nqm_error err = {0};
    const nqm_status status = s->read(map, &err);
    if (status == s->status && (status == NQM_OK || strstr(err.message, s->message)))
        return 0;
    fprintf(stderr, "%s: status %d, '%s'\n", s->name, (int)status, err.message);
    return 1;
}

/* The largest resident set of a process that reads the text, bytes. */
static size_t measure(const text_shape *s, const nqm_map *map) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(read_and_compare(s, map));
    int status = 0;
    struct rusage usage;
    assert_int_equal(wait4(child, &status, 0, &usage), child);
    if (status != 0)
        fail_msg("%s: the reader ended with %d", s->name, status);
    return (size_t)usage.ru_maxrss * 1024;
}

static void check_shape(const text_shape *s, size_t room) {
    size_t n;
    char *text = make_text(s, &n);
    const nqm_map map = {.data = (const unsigned char *)text, .n_bytes = n, .path = s->name};
    const text_shape baseline = {.name = "nothing", .read = read_nothing};
    const size_t base = measure(&baseline, &map), peak = measure(s, &map), extra = peak > base ? peak - base : 0;
    print_message("%-28s %5.1f MB: %6.1f MB, %4.1f times\n", s->name, (double)n / MEGA, (double)extra / MEGA,
                  (double)extra / (double)n);
    /* Sanitizers keep freed memory and copies of their own. */
    if (!getenv("NQM_SANITIZE") && extra > nqm_larger(MAX_RATIO * n, room))
        fail_msg("%s: %zu bytes of memory for a file of %zu", s->name, extra, n);
    free(text);
}

#define LIST "{\"reference\":\"a\",\"test\":\"b\""
#define PLY                                                                                                            \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"  \
    "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"

static const text_shape lists[] = {
    {"CSV, columns", "reference,test", ",a", "\n", 3 * MEGA, read_list, NQM_ERR_LIMIT, "at most 16384"},
    {"CSV, empty columns", "reference,test", ",", "\n", 3 * MEGA, read_csv, NQM_ERR_LIMIT, "columns (byte 0)"},
    {"CSV, short rows", "reference,test\n", "a,b\n", "", 3 * MEGA, read_list, NQM_OK, ""},
    {"CSV, empty fields", "a,b,c,d,e,f,g,h\n", ",,,,,,,\n", "", 3 * MEGA, read_csv, NQM_OK, ""},
    {"CSV, one column", "a\n", "1\n", "", 3 * MEGA, read_csv, NQM_OK, ""},
    {"CSV, blank lines", "a\n", "\n", "", 3 * MEGA, read_csv, NQM_OK, ""},
    {"CSV, equal directions", "theta_h,theta_d,phi_d,r,g,b\n", "9.0,9.0,9.0,1,1,1\n", "", 3 * MEGA, read_directions,
     NQM_OK, ""},
    {"JSON Lines", "", LIST "}\n", "", 3 * MEGA, read_list, NQM_OK, ""},
    {"JSON Lines, blank lines", LIST "}\n", "\n", "", 3 * MEGA, read_list, NQM_OK, ""},
    {"JSON Lines, colons", LIST "}\n", LIST ",\"c\":\":::::::::::::::::\"}\n", "", 3 * MEGA, read_list, NQM_OK, ""},
    {"JSON Lines, many members", "", LIST ",\"c\":1,\"d\":2,\"e\":3,\"f\":4,\"g\":5,\"h\":6}\n", "", 3 * MEGA,
     read_list, NQM_OK, ""},
    {"JSON Lines, empty arrays", LIST ",\"c\":[", "[],", "[]]}\n", 3 * MEGA, read_list, NQM_ERR_LIMIT, "limit for"},
    {"JSON Lines, numbers", LIST ",\"c\":[", "12345678,", "0]}\n", 3 * MEGA, read_list, NQM_OK, ""},
};

static const text_shape trees[] = {
    {"safetensors, empty arrays", "{\"x\":[", "[],", "[]]}", 3 * MEGA, read_safetensors, NQM_ERR_LIMIT, "limit for"},
    {"safetensors, numbers", "{\"x\":[", "0,", "0]}", 3 * MEGA, read_safetensors, NQM_ERR_LIMIT, "limit for"},
    {"glTF, empty objects", "{\"asset\":{\"version\":\"2.0\"},\"materials\":[", "{},", "{}]}", 3 * MEGA, read_materials,
     NQM_ERR_LIMIT, "limit for"},
    {"glTF, many materials", "{\"asset\":{\"version\":\"2.0\"},\"materials\":[",
     "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1250,0.1250,0.1250,1.0000]},\"doubleSided\":false,\"name\":"
     "\"0\"},\n",
     "{}]}", 3 * MEGA, read_materials, NQM_ERR_LIMIT, "more than 16384 materials"},
    {"glTF, minified materials", "{\"asset\":{\"version\":\"2.0\"},\"materials\":[",
     "{\"name\":\"a\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.5,1],\"roughnessFactor\":0.5}},", "{}]}",
     MEGA, read_materials, NQM_OK, ""},
    {"glTF, minified accessors", "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"name\":\"a\"}],\"accessors\":[",
     "{\"bufferView\":12,\"componentType\":5126,\"count\":1024,\"max\":[1.5,2,3],\"min\":[-1,-2,0],\"type\":\"VEC3\"},",
     "{}]}", 6 * MEGA, read_materials, NQM_OK, ""},
    {"Mitsuba JSON", "{\"type\":\"scene\",\"a\":[", "{},", "0]}", 3 * MEGA, read_materials, NQM_ERR_LIMIT, "limit for"},
    {"XML, empty elements", "<scene>", "<a/>", "</scene>", 3 * MEGA, read_xml, NQM_ERR_LIMIT, "elements at byte"},
    {"XML, short elements", "<scene>", "<bsdf type=\"diffuse\"/>", "</scene>", 3 * MEGA, read_xml, NQM_OK, ""},
    {"XML, attributes", "<scene>", "<a a=\"\" b=\"\" c=\"\" d=\"\" e=\"\" f=\"\"/>", "</scene>", 3 * MEGA, read_xml,
     NQM_OK, ""},
    {"Mitsuba XML, defaults", "<scene>", "<default name=\"a\" value=\"1\"/>", "</scene>", 3 * MEGA, read_materials,
     NQM_ERR_LIMIT, "more than 1000 defaults"},
    {"pbrt, materials", "", "Material \"diffuse\"\n", "", 3 * MEGA, read_materials, NQM_ERR_LIMIT,
     "more than 16384 materials"},
    {"pbrt, values", "Material \"diffuse\" \"float a\" [", " 1", "]\n", 3 * MEGA, read_materials, NQM_OK, ""},
};

static const text_shape meshes[] = {
    {"OBJ, one face", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf", " 1 2 3", "\n", 3 * MEGA, read_mesh, NQM_OK, ""},
    {"OBJ, one face, normals", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf", " 1//1 2//1 3//1", "\n", 3 * MEGA, read_mesh,
     NQM_OK, ""},
    {"OBJ, one triangle", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "f 1 2 3\n", "", 3 * MEGA, read_mesh, NQM_OK, ""},
    {"OBJ, vertices", "", "v 0 0 0\n", "f 1 2 3\n", 3 * MEGA, read_mesh, NQM_OK, ""},
    {"PLY, one face", PLY "500001", " 0 1 2", "\n", 3 * MEGA, read_mesh, NQM_OK, ""},
};

/* room: bytes that every file may take. */
static void check_shapes(size_t n, const text_shape *shapes, size_t room) {
    for (size_t i = 0; i < n; ++i)
        check_shape(&shapes[i], room);
}

TEST(memory_of_lists) {
    check_shapes(sizeof lists / sizeof *lists, lists, 0);
}

TEST(memory_of_trees) {
    check_shapes(sizeof trees / sizeof *trees, trees, NQM_JSON_ROOM);
}

TEST(memory_of_meshes) {
    check_shapes(sizeof meshes / sizeof *meshes, meshes, 0);
}

/* Coincident triangles: a ray would meet all of them. Both windings of a triangle stay. */
TEST(equal_triangles_are_left_out) {
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 1\nf 1 2 2\nf 3 2 1\nf 1 2 3 1 2 3\nf 2 4 3\n";
    const nqm_map map = {.data = (const unsigned char *)text, .n_bytes = sizeof text - 1, .path = "text"};
    nqm_mesh mesh;
    assert_int_equal(nqm_mesh_parse(&map, &mesh, NULL), NQM_OK);
    const uint32_t expected[3][3] = {{0, 1, 2}, {2, 1, 0}, {1, 3, 2}};
    assert_int_equal(mesh.n_triangles, 3);
    assert_memory_equal(mesh.triangle, expected, sizeof expected);
    nqm_mesh_free(&mesh);
}

/* A large mesh has 12 bytes or more for each triangle; these polygons have four. */
TEST(too_many_triangles) {
    enum { N = 1000, FACES = 300, CORNERS = 2000 };
    char *text = malloc(8 * MEGA);
    assert_non_null(text);
    size_t n = 0;
    for (size_t i = 0; i < N; ++i)
        n += (size_t)snprintf(text + n, 32, "v %zu 0 0\n", i);
    for (size_t face = 0; face < FACES; ++face) {
        n += (size_t)snprintf(text + n, 32, "f");
        for (size_t i = 0; i < CORNERS; ++i)
            n += (size_t)snprintf(text + n, 32, " %zu", (size_t)(nqm_hash_u64(face, i) % N) + 1);
        text[n++] = '\n';
    }
    const nqm_map map = {.data = (const unsigned char *)text, .n_bytes = n, .path = "text"};
    nqm_mesh mesh;
    nqm_error err = {0};
    assert_int_equal(nqm_mesh_parse(&map, &mesh, &err), NQM_ERR_LIMIT);
    assert_non_null(strstr(err.message, "the limit for a file of"));
    nqm_mesh_free(&mesh);
    free(text);
}
