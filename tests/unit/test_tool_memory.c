/* SPDX-License-Identifier: MIT
 *
 * Memory of the readers of text: files of a few megabytes that consist of the smallest possible fields, values, elements or
 * corners. A reader takes at most ten times the bytes of the file, or refuses it and names the limit. Each reader runs in a
 * process of its own, whose largest resident set is compared with that of a process that reads nothing.
 */
#include "brdf/formats/format.h"
#include "io/json.h"
#include "io/xml.h"
#include "pairs/pairs.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/rows.h"

#include <sys/resource.h>
#include <sys/wait.h>

enum { MEGA = 1 << 20, MAX_RATIO = 10 };

static nqm_status read_nothing(const nqm_map *map, nqm_error *err) {
    (void)map, (void)err;
    return NQM_OK;
}

static nqm_status read_list(const nqm_map *map, nqm_error *err) {
    nqm_pairs *list;
    const nqm_status status = nqm_pairs_parse((const char *)map->data, map->n_bytes, map->path, &list, err);
    nqm_pairs_free(list);
    return status;
}

static nqm_status read_directions(const nqm_map *map, nqm_error *err) {
    nqm_brdf *brdf;
    nqm_map own = *map; /* the BRDF would unmap it */
    const nqm_status status = nqm_listed_format.open(&own, &(nqm_brdf_argument){.name = map->path}, &brdf, err);
    return status;
}

/* The text is the header of a safetensors file. */
static nqm_status read_header(const nqm_map *map, nqm_error *err) {
    unsigned char *data = malloc(map->n_bytes + 8);
    assert_non_null(data);
    nqm_store_u64(data, map->n_bytes);
    memcpy(data + 8, map->data, map->n_bytes);
    const nqm_status status =
        read_safetensors(&(nqm_map){.data = data, .n_bytes = map->n_bytes + 8, .path = map->path}, err);
    free(data);
    return status;
}

static nqm_status read_xml(const nqm_map *map, nqm_error *err) {
    nqm_xml xml;
    const nqm_status status = nqm_xml_parse(map->data, map->n_bytes, map->path, &xml, err);
    nqm_xml_free(&xml);
    return status;
}

static byte_reader reader_of(const char *name) {
    static const struct {
        const char *name;
        byte_reader read;
    } readers[] = {{"list", read_list},
                   {"csv", read_csv},
                   {"directions", read_directions},
                   {"mesh", read_mesh},
                   {"safetensors", read_header},
                   {"materials", read_materials},
                   {"xml", read_xml}};
    size_t i = 0;
    while (strcmp(readers[i].name, name) != 0)
        assert_true(++i < sizeof readers / sizeof *readers);
    return readers[i].read;
}

/* `head`, then `unit` until it has n bytes, then `tail`. */
static blob make_text(const char *head, const char *unit, const char *tail, size_t n) {
    const size_t n_head = strlen(head), n_unit = strlen(unit), n_tail = strlen(tail);
    const size_t n_units = (n - n_head - n_tail) / n_unit;
    blob b = {malloc(n), n_head + n_units * n_unit + n_tail};
    assert_non_null(b.data);
    memcpy(b.data, head, n_head);
    for (size_t i = 0; i < n_units; ++i)
        memcpy(b.data + n_head + i * n_unit, unit, n_unit);
    memcpy(b.data + n_head + n_units * n_unit, tail, n_tail);
    return b;
}

static int read_and_compare(const nqm_map *map, byte_reader read, nqm_status expected, const char *words) {
    nqm_error err = {0};
    const nqm_status status = read(map, &err);
    if (status == expected && (status == NQM_OK || strstr(err.message, words)))
        return 0;
    fprintf(stderr, "%s: status %d, '%s'\n", map->path, (int)status, err.message);
    return 1;
}

/* The largest resident set of a process that reads the text, bytes. */
static size_t measure(const nqm_map *map, byte_reader read, nqm_status expected, const char *words) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        _exit(read_and_compare(map, read, expected, words));
    int status = 0;
    struct rusage usage;
    assert_int_equal(wait4(child, &status, 0, &usage), child);
    if (status != 0)
        fail_msg("%s: the reader ended with %d", map->path, status);
    return (size_t)usage.ru_maxrss * 1024;
}

/* Rows: name, reader, megabytes, head, unit, tail, status, words of the message. room: bytes that every file may take. */
static void check_memory(const char *table, size_t room) {
    EVERY_ROW(row, table) {
        blob b = make_text(row[3], row[4], row[5], (size_t)atoi(row[2]) * MEGA);
        const nqm_map map = {.data = b.data, .n_bytes = b.n_bytes, .path = row[0]};
        const size_t base = measure(&map, read_nothing, NQM_OK, "");
        const size_t peak = measure(&map, reader_of(row[1]), status_of(row[6]), row[7]);
        const size_t extra = peak > base ? peak - base : 0;
        print_message("%-28s %5.1f MB: %6.1f MB, %4.1f times\n", row[0], (double)b.n_bytes / MEGA, (double)extra / MEGA,
                      (double)extra / (double)b.n_bytes);
        /* Sanitizers keep freed memory and copies of their own. */
        if (!getenv("NQM_SANITIZE") && extra > nqm_larger(MAX_RATIO * b.n_bytes, room))
            fail_msg("%s: %zu bytes of memory for a file of %zu", row[0], extra, b.n_bytes);
        blob_free(&b);
    }
}

TEST(memory_of_lists) {
    check_memory("memory of lists", 0);
}

TEST(memory_of_trees) {
    check_memory("memory of trees", NQM_JSON_ROOM);
}

TEST(memory_of_meshes) {
    check_memory("memory of meshes", 0);
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
