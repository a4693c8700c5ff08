/* SPDX-License-Identifier: MIT
 *
 * Textures at positions: exact at the centres of texels and bilinear between them, ways to continue beyond edges, every
 * operation as its scalar reference, colour spaces, tiles, normals; facts and messages of textures that are opened.
 */
#include "io/raster.h"
#include "support/check.h"
#include "texture/texture.h"

static const float ramp[6] = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}; /* 3 x 2 */

static nqm_texture *create(size_t n, const nqm_texture_map *maps) {
    nqm_texture *texture;
    nqm_error err = {0};
    if (nqm_texture_create("gltf:metallic=0;base_color=.5,.5,.5", n, maps, &texture, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return texture;
}

static nqm_texture *make_ramp(void) {
    return create(1, &(nqm_texture_map){"roughness", 2, 3, 1, ramp});
}

/* The value in row k at a position. */
static double value_at(const nqm_texture *t, double u, double v, size_t k) {
    float *rows = nqm_alloc((size_t)t->n_rows * NQM_TEXEL_BLOCK, sizeof *rows);
    nqm_texture_evaluate(t, 1, &u, &v, rows);
    const double value = (double)rows[k * NQM_TEXEL_BLOCK];
    nqm_free(rows);
    return value;
}

TEST(centres_are_exact_and_the_rest_is_bilinear) {
    nqm_texture *t = make_ramp();
    for (size_t i = 0; i < 6; ++i) {
        const double u = ((double)(i % 3) + 0.5) / 3, v = ((double)(i / 3) + 0.5) / 2;
        assert_true((float)value_at(t, u, v, 0) == ramp[i]);
    }
    assert_near(value_at(t, 1 / 3.0, 0.25, 0), 0.15, 1e-6);
    assert_near(value_at(t, 0.5, 0.5, 0), 0.35, 1e-6);
    assert_near(value_at(t, 0, 0.25, 0), 0.2, 1e-6); /* it repeats */
    const nqm_texture_info info = nqm_texture_get_info(t, NULL);
    assert_int_equal(info.width, 3);
    assert_int_equal(info.height, 2);
    assert_int_equal(info.n_images, 1);
    assert_int_equal(info.n_bytes, 24);
    assert_string_equal(info.varying, "roughness");
    assert_string_equal(info.model, "gltf");
    nqm_texture_free(t);
}

TEST(edges_continue) {
    nqm_texture *t = make_ramp();
    nqm_map_node *node = &t->owned->nodes[0];
    static const struct {
        nqm_map_wrap wrap;
        double expected[2]; /* at u = -1/6 and 7/6 */
    } cases[] = {{NQM_MAP_REPEAT, {0.3, 0.1}},
                 {NQM_MAP_MIRROR, {0.1, 0.3}},
                 {NQM_MAP_CLAMP, {0.1, 0.3}},
                 {NQM_MAP_BORDER, {0.9, 0.9}}};
    node->v[0] = 0.9;
    for (size_t k = 0; k < 4; ++k) {
        node->wrap[0] = (uint8_t)cases[k].wrap;
        assert_near(value_at(t, -1 / 6.0, 0.25, 0), cases[k].expected[0], 1e-6);
        assert_near(value_at(t, 7 / 6.0, 0.25, 0), cases[k].expected[1], 1e-6);
        assert_true(isfinite(value_at(t, 1e300, NAN, 0)));
    }
    node->wrap[0] = NQM_MAP_MIRROR;
    assert_near(value_at(t, 1.5, 0.25, 0), 0.2, 1e-6);
    assert_near(value_at(t, 11 / 6.0, 0.25, 0), 0.1, 1e-6);
    nqm_texture_free(t);
}

TEST(tiles_are_compared_once) {
    nqm_texture *t = make_ramp(), *other = make_ramp();
    t->owned->nodes[0].uv[0][0] = 4;
    other->owned->nodes[0].uv[0][0] = 6;
    assert_int_equal(nqm_texture_get_info(t, NULL).width, 3);
    assert_int_equal(nqm_texture_get_info(other, NULL).width, 3);
    assert_int_equal(nqm_texture_get_info(t, other).width, 9); /* two periods of 1/2: 18 texels / 2 */
    t->owned->nodes[0].uv[0][0] = 2.5;
    assert_int_equal(nqm_texture_get_info(t, NULL).width, 8);
    nqm_texture_free(t);
    nqm_texture_free(other);
}

/* Every operation of a block is that of one texel. */
TEST(operations_are_those_of_the_reference) {
    nqm_texture *t = make_ramp();
    for (int op = NQM_MAP_ADD; op < NQM_MAP_OPS; ++op) {
        if (op == NQM_MAP_TEXCOORD)
            continue;
        nqm_textured *maps = nqm_textured_create();
        const uint8_t repeat[2] = {NQM_MAP_REPEAT, NQM_MAP_REPEAT};
        const double uv[2][3] = {{1, 0, 0}, {0, 1, 0}}, scale[3] = {0.7, 0.3, 0.5};
        size_t image;
        assert_true(
            nqm_graph_add_image(maps, (nqm_map_image){.data = nqm_alloc(1, 1), .name = nqm_strdup("map")}, &image));
        const uint16_t in = nqm_graph_image_at(maps, image, 3, uv, repeat), constant = nqm_graph_value(maps, 3, scale);
        const uint16_t sum = nqm_graph_compute(maps, NQM_MAP_MULTIPLY, 3, in, in, NQM_NO_NODE);
        nqm_map_node node = {.op = (nqm_map_op)op, .n = op == NQM_MAP_CHANNEL ? 1 : 3, .v = {1}};
        node.in[0] = in, node.in[1] = constant, node.in[2] = sum, node.in[3] = constant;
        const uint16_t last = nqm_graph_add(maps, node);
        nqm_graph_output_set(maps, "base_color", last);
        maps->values = nqm_values_of(&nqm_gltf_schema);
        nqm_texture other = {.name = t->name, .owned = maps, .maps = maps, .images = t->images};
        assert_int_equal(nqm_texture_prepare(&other, NULL), NQM_OK);
        /* Grey: all channels of the image are 0.2 at this position. */
        double values[8][4] = {{0}}, out[4];
        for (size_t c = 0; c < 4; ++c) {
            values[in][c] = (double)0.2f;
            values[sum][c] = (double)0.2f * (double)0.2f;
            values[constant][c] = scale[c < 3 ? c : 2];
        }
        nqm_graph_node_value(&node, (const double(*)[4])values, out);
        for (size_t c = 0; c < 3; ++c)
            assert_near(value_at(&other, 0.5, 0.25, (size_t)other.rows[last] + (node.n == 3 ? c : 0)), out[c], 1e-6);
        nqm_free(other.constants);
        nqm_textured_free(maps);
    }
    nqm_texture_free(t);
}

TEST(colours_are_decoded) {
    nqm_texels texels = {.raster = {.width = 2, .height = 1, .channels = 4}};
    assert_int_equal(nqm_texels_decode(&texels, "srgb_texture", NULL), NQM_OK);
    assert_near((double)texels.table[188], 0.5028865, 1e-6);
    assert_near((double)texels.table[256 + 188], 188 / 255.0, 1e-7); /* alpha */
    assert_false(texels.has_matrix);
    nqm_free(texels.table);
    texels.table = NULL;
    assert_int_equal(nqm_texels_decode(&texels, "acescg", NULL), NQM_OK);
    assert_true(texels.has_matrix);
    assert_near((double)texels.matrix[0][0], 1.705051, 1e-5);
    nqm_free(texels.table);
    texels.table = NULL;
    nqm_error err = {0};
    assert_int_equal(nqm_texels_decode(&texels, "nonsense", &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "nonsense"));
}

TEST(normals_have_length_one) {
    const float vectors[12] = {0, 0, 3, 3, 0, 4, 0, 0, 0, 1, 0, -1};
    static const double expected[4][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0, 0, 1}, {0.9975, 0, 0.0705}};
    nqm_texture *t = create(1, &(nqm_texture_map){"normal", 1, 4, 3, vectors});
    for (size_t i = 0; i < 4; ++i) {
        double normal[3];
        nqm_brdf *brdf;
        assert_int_equal(nqm_texture_at(t, ((double)i + 0.5) / 4 - 3, 0.5, &brdf, normal, NULL), NQM_OK);
        for (size_t c = 0; c < 3; ++c)
            assert_near(normal[c], expected[i][c], 1e-3);
        nqm_brdf_free(brdf);
    }
    assert_string_equal(nqm_texture_get_info(t, NULL).varying, "normal");
    assert_string_equal(
        nqm_texture_get_info(t, NULL).remark,
        "the normal map has no direction above the surface at 50 % of the surface: it is read as the steepest or "
        "as the normal of the surface");
    nqm_texture_free(t);
}

TEST(values_out_of_range_are_told) {
    const float rough[4] = {0.5f, 3e38f, 1, 0}, color[3] = {1.00001f, 0, -1};
    const nqm_texture_map maps[2] = {{"roughness", 1, 4, 1, rough}, {"base_color", 1, 1, 3, color}};
    nqm_texture *t = create(2, maps);
    const char *remark = nqm_texture_get_info(t, NULL).remark;
    assert_string_equal(
        remark, "base_color at 1e+02 % of the surface: it is moved into 0 to 1; roughness at 25 % of the surface: "
                "it is moved into 0 to 1");
    nqm_texture_free(t);
    t = make_ramp();
    assert_string_equal(nqm_texture_get_info(t, NULL).remark, "");
    nqm_texture_free(t);
}

TEST(wrong_maps_are_refused) {
    const float wrong[3] = {0.5f, NAN, 0.5f};
    const struct {
        const char *base;
        nqm_texture_map map;
        const char *text;
    } cases[] = {{"gltf:", {"roughness", 1, 3, 1, wrong}, "not finite at texel (0, 1)"},
                 {"gltf:", {"shininess", 1, 1, 1, wrong}, "shininess"},
                 {"gltf:", {"base_color", 1, 3, 1, wrong}, "shape"},
                 {"gltf:", {"normal", 3, 1, 1, wrong}, "shape"},
                 {"nonsense:", {"roughness", 1, 1, 1, wrong}, "nonsense"},
                 {"gltf", {"roughness", 1, 1, 1, wrong}, "gltf"},
                 {"gltf:sheen=2", {"roughness", 1, 1, 1, wrong}, "sheen"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        nqm_texture *texture;
        nqm_error err = {0};
        assert_int_equal(nqm_texture_create(cases[k].base, 1, &cases[k].map, &texture, &err), NQM_ERR_ARG);
        assert_null(texture);
        if (!strstr(err.message, cases[k].text))
            fail_msg("%zu: %s", k, err.message);
    }
    nqm_texture *texture;
    const nqm_texture_map large = {"roughness", 1, NQM_RASTER_MAX_SIDE + 1, 1, wrong};
    assert_int_equal(nqm_texture_create("gltf:", 1, &large, &texture, NULL), NQM_ERR_LIMIT);
    assert_int_equal(nqm_texture_open("no/such.gltf", NULL, NULL, &texture, NULL), NQM_ERR_IO);
}

TEST(brdfs_are_textures_of_one_texel) {
    static const char *const cases[][2] = {
        {"gltf:roughness=.5", "gltf"}, {"sgd:nickel", "sgd"}, {"tilt:deg=3;of=ggx:kd=.2;alpha=.2", "tilt"}};
    for (size_t k = 0; k < 3; ++k) {
        nqm_texture *t;
        nqm_error err = {0};
        if (nqm_texture_open(cases[k][0], NULL, NULL, &t, &err) != NQM_OK)
            fail_msg("%s", err.message);
        const nqm_texture_info info = nqm_texture_get_info(t, NULL);
        assert_string_equal(info.model, cases[k][1]);
        assert_string_equal(info.name, cases[k][0]);
        assert_string_equal(info.varying, "");
        assert_true(info.width == 1 && info.height == 1 && info.n_images == 0);
        nqm_texture_free(t);
    }
}
