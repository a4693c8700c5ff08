/* SPDX-License-Identifier: MIT
 *
 * Meshes: the same square pyramid as text and as bytes of either order, as PLY and OBJ, with polygons, other properties
 * and all forms of indices; normals; broken files are refused with file and place.
 */
#include "io/io.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/rows.h"

/* A square pyramid: four base vertices and the apex; the base is a quadrilateral, the sides are triangles. */
static const float pyramid[5][3] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 0.5F}};
static const unsigned sides[4][3] = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};

static const char ply_text[] = "ply\nformat ascii 1.0\ncomment made by hand\nobj_info none\nelement vertex 5\n"
                               "property uchar red\nproperty float x\nproperty float y\nproperty double z\n"
                               "element extra 2\nproperty list uchar short numbers\nproperty int8 last\n"
                               "element face 5\nproperty list uchar int vertex_indices\nproperty float quality\n"
                               "end_header\n"
                               "255 1 0 0\n0 0 1 0\n0 -1 0 0\n0 0 -1 0\n7 0 0 0.5\n"
                               "3 1 2 3 -1\n0 4\n"
                               "4 3 2 1 0 nan\n3 0 1 4 1\n3 1 2 4 1\n3 2 3 4 1\n3 3 0 4 1";
static const char obj_text[] = "# a pyramid\nmtllib none.mtl\no pyramid\n"
                               "v 1 0 0\nv 0 1 0 1.0\r\nv -1 0 0 \\\n 1 .5 .5 .5\nv 0 -1 0\nv\t0 0 .5\nvt 0 0\ns off\n"
                               "f 4 3 2 1\nf 1/1 2/1 5/1\nf -4 -3 -1\nf 3/1 4/1 5/1\nf 4 1 \\\n 5\n";

typedef struct bytes {
    unsigned char data[2048];
    size_t n;
} bytes;

static void put_number(bytes *b, uint64_t value, size_t n, bool big) {
    for (size_t i = 0; i < n; ++i)
        b->data[b->n++] = (unsigned char)(value >> 8 * (big ? n - 1 - i : i));
}

static void put_float(bytes *b, float value, bool big) {
    unsigned char little[4];
    nqm_store_f32(little, value);
    put_number(b, nqm_load_u32(little), 4, big);
}

/* The pyramid as binary PLY; `normals` adds one normal per vertex, equal to its position, so not of unit length. */
static bytes make_binary(bool big, bool normals) {
    bytes b = {0};
    b.n = (size_t)snprintf((char *)b.data, sizeof b.data,
                           "ply\r\nformat binary_%s_endian 1.0\r\nelement vertex 5\r\nproperty float32 x\r\n"
                           "property float32 y\r\nproperty float32 z\r\nproperty ushort mark\r\n%s"
                           "element face 5\r\nproperty list int16 uint8 other\r\n"
                           "property list uint8 uint32 vertex_index\r\nend_header\r\n",
                           big ? "big" : "little",
                           normals ? "property float nx\r\nproperty float ny\r\nproperty float nz\r\n" : "");
    for (size_t i = 0; i < 5; ++i) {
        for (size_t k = 0; k < 3; ++k)
            put_float(&b, pyramid[i][k], big);
        put_number(&b, 0x1234, 2, big);
        for (size_t k = 0; normals && k < 3; ++k)
            put_float(&b, i == 1 ? 0 : 2 * pyramid[i][k], big);
    }
    for (size_t i = 0; i < 5; ++i) {
        put_number(&b, i, 2, big);
        for (size_t k = 0; k < i; ++k)
            put_number(&b, 99, 1, big);
        put_number(&b, i ? 3 : 4, 1, big);
        for (size_t k = 0; k < (i ? 3 : 4); ++k)
            put_number(&b, i ? sides[i - 1][k] : 3 - k, 4, big);
    }
    return b;
}

static nqm_status parse(const void *data, size_t n_bytes, nqm_mesh *mesh, nqm_error *err) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "some.mesh"};
    *err = (nqm_error){0};
    nqm_status status = nqm_mesh_parse(&map, mesh, err);
    if (status != NQM_OK) {
        assert_null(mesh->position);
        assert_null(mesh->triangle);
        assert_null(mesh->normal);
        assert_int_equal(err->status, status);
        assert_non_null(strstr(err->message, status == NQM_ERR_NOMEM ? "memory" : "some.mesh"));
    }
    return status;
}

static void check_pyramid(const nqm_mesh *mesh) {
    assert_int_equal(mesh->n_vertices, 5);
    assert_int_equal(mesh->n_triangles, 6);
    assert_memory_equal(mesh->position, pyramid, sizeof pyramid);
    static const uint32_t base[2][3] = {{3, 2, 1}, {3, 1, 0}};
    assert_memory_equal(mesh->triangle, base, sizeof base);
    assert_memory_equal(mesh->triangle + 6, sides, sizeof sides);
}

static void check_normal(const nqm_mesh *mesh, size_t i, double x, double y, double z) {
    double length = sqrt(x * x + y * y + z * z);
    assert_near((double)mesh->normal[3 * i], x / length, 1e-6);
    assert_near((double)mesh->normal[3 * i + 1], y / length, 1e-6);
    assert_near((double)mesh->normal[3 * i + 2], z / length, 1e-6);
}

/* Cross products: (1, 1, 2)/2 up to signs for a side, (0, 0, -2) for each base triangle. Vertices 1 and 3 are in
 * both. */
static void check_area_weighted(const nqm_mesh *mesh) {
    check_normal(mesh, 0, 1, 0, 2 - 2);
    check_normal(mesh, 1, 0, 1, 2 - 4);
    check_normal(mesh, 2, -1, 0, 2 - 2);
    check_normal(mesh, 3, 0, -1, 2 - 4);
    check_normal(mesh, 4, 0, 0, 1);
}

TEST(pyramids) {
    nqm_mesh mesh;
    nqm_error err;
    const bytes little = make_binary(false, false), big = make_binary(true, false);
    const struct {
        const void *data;
        size_t n;
    } files[] = {
        {ply_text, sizeof ply_text - 1}, {obj_text, sizeof obj_text - 1}, {little.data, little.n}, {big.data, big.n}};
    for (size_t i = 0; i < 4; ++i) {
        if (parse(files[i].data, files[i].n, &mesh, &err) != NQM_OK)
            fail_msg("file %zu: %s", i, err.message);
        check_pyramid(&mesh);
        check_area_weighted(&mesh);
        nqm_mesh_free(&mesh);
    }
}

TEST(normals_of_ply) {
    nqm_mesh mesh;
    nqm_error err;
    for (int big = 0; big < 2; ++big) {
        const bytes b = make_binary(big, true);
        assert_int_equal(parse(b.data, b.n, &mesh, &err), NQM_OK);
        check_pyramid(&mesh);
        check_normal(&mesh, 0, 1, 0, 0);
        check_normal(&mesh, 1, 0, 1, -2); /* the file says 0 0 0 */
        check_normal(&mesh, 4, 0, 0, 1);
        nqm_mesh_free(&mesh);
    }
}

/* Two triangles with a common edge: its vertices are duplicated where the normals differ and shared where they
 * agree. */
TEST(normals_of_obj) {
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nv 9 9 9\nvn 0 0 3\nvn 1 0 0\nvn 0 -1 0\n"
                               "f 1//1 2//1 3/7/1\nf 3//-3 2//2 4//-1\n";
    nqm_mesh mesh;
    nqm_error err;
    assert_int_equal(parse(text, sizeof text - 1, &mesh, &err), NQM_OK);
    assert_int_equal(mesh.n_triangles, 2);
    assert_int_equal(mesh.n_vertices, 5); /* 1//1 2//1 3//1 2//2 4//3; the last v is not used */
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {2, 3, 4}};
    assert_memory_equal(mesh.triangle, triangles, sizeof triangles);
    check_normal(&mesh, 1, 0, 0, 1);
    check_normal(&mesh, 3, 1, 0, 0);
    check_normal(&mesh, 4, 0, -1, 0);
    assert_true(mesh.position[9] == 1 && mesh.position[14] == 1);
    nqm_mesh_free(&mesh);
    /* If one corner has no normal, all normals are computed. */
    static const char mixed[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3\n";
    assert_int_equal(parse(mixed, sizeof mixed - 1, &mesh, &err), NQM_OK);
    check_normal(&mesh, 0, 0, 0, 1);
    nqm_mesh_free(&mesh);
}

/* Replace the first `what` of a text by `with`; parsing must fail with a message that contains `place`. */
static void refuse(const char *text, const char *what, const char *with, const char *place) {
    char changed[1024];
    const char *at = strstr(text, what);
    assert_non_null(at);
    snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, with, at + strlen(what));
    nqm_mesh mesh;
    nqm_error err;
    nqm_status status = parse(changed, strlen(changed), &mesh, &err);
    if (status == NQM_OK)
        fail_msg("'%s' for '%s' was accepted", with, what);
    if (status != NQM_ERR_FORMAT || !strstr(err.message, place))
        fail_msg("'%s' for '%s': %s", with, what, err.message);
}

TEST(refusals) {
    EVERY_ROW(row, "changes that spoil a PLY mesh") {
        refuse(ply_text, row[0], row[1], row[2]);
    }
    EVERY_ROW(row, "changes that spoil an OBJ mesh") {
        refuse(obj_text, row[0], row[1], row[2]);
    }
    nqm_mesh mesh;
    nqm_error err;
    assert_int_equal(parse("v 0 0 0\n", 8, &mesh, &err), NQM_ERR_FORMAT);
    assert_int_equal(parse(NULL, 0, &mesh, &err), NQM_ERR_FORMAT);
    static const char dots[] =
        "v 0 0 0\nv 0.0000000000000000000000000000000000000000000000000000000000000000001e66 0 0\n";
    assert_int_equal(parse(dots, sizeof dots - 1, &mesh, &err), NQM_ERR_FORMAT); /* must not be parsed as 0 */
    assert_non_null(strstr(err.message, "line 2"));
}

TEST(broken_binary) {
    bytes b = make_binary(false, true);
    nqm_mesh mesh;
    nqm_error err;
    refuse_cuts("some.mesh", (blob){b.data, b.n}, 1, read_mesh);
    size_t body = (size_t)(strstr((const char *)b.data, "end_header") - (const char *)b.data) + 12;
    nqm_store_u32(b.data + body + 14, 0x7fc00000); /* nx of the first vertex is NaN */
    assert_int_equal(parse(b.data, b.n, &mesh, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "at byte"));
    assert_true(err.byte_offset == (int64_t)body + 26);
}

TEST(out_of_memory) {
    static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n";
    const bytes b = make_binary(true, true);
    for (int i = 0; i < 2; ++i) {
        nqm_status status = NQM_OK;
        nqm_mesh mesh;
        nqm_error err;
        long n = -1;
        EVERY_ALLOCATION(n, status, 0)
        status = i ? parse(b.data, b.n, &mesh, &err) : parse(obj, sizeof obj - 1, &mesh, &err);
        assert_true(n < 12);
        nqm_mesh_free(&mesh);
    }
}

/* The Stanford bunny is closed except for holes in its base, so almost all normals point away from its centre. */
TEST(bunny) {
    const char *path = shared_data("scene/bunny.ply");
    if (!path)
        skip();
    nqm_mesh mesh;
    nqm_error err = {0};
    if (nqm_mesh_load(path, &mesh, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_int_equal(mesh.n_vertices, 35947);
    assert_int_equal(mesh.n_triangles, 69451);
    double middle[3] = {0};
    for (size_t i = 0; i < 3 * mesh.n_vertices; ++i)
        middle[i % 3] += (double)mesh.position[i] / (double)mesh.n_vertices;
    size_t n_outward = 0;
    for (size_t i = 0; i < mesh.n_vertices; ++i) {
        double dot = 0, length = 0;
        for (size_t k = 0; k < 3; ++k) {
            double n = (double)mesh.normal[3 * i + k];
            dot += n * ((double)mesh.position[3 * i + k] - middle[k]);
            length += n * n;
        }
        assert_near(length, 1, 1e-6);
        n_outward += dot > 0;
    }
    assert_true((double)n_outward > 0.8 * (double)mesh.n_vertices);
    nqm_mesh_free(&mesh);
}

TEST(missing_file) {
    nqm_mesh mesh;
    nqm_error err = {0};
    assert_int_equal(nqm_mesh_load("/nonexistent.ply", &mesh, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "/nonexistent.ply"));
    assert_null(mesh.position);
}
