/* SPDX-License-Identifier: MIT
 *
 * Textures of glTF as nodes and images, and folders and lists of maps: values of the nodes for an image of one colour,
 * positions in the image, bytes of embedded images, and what is refused.
 */
#include "base/base.h"
#include "base/memory_test.h"
#include "material/maps.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/rows.h"

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

static double texel[4] = {0.25, 0.5, 0.75, 0.4}; /* of every image */

static void compute(const nqm_map_node *node, double (*values)[4], double *v) {
    const double *a = values[node->in[0]], *b = values[node->in[1]];
    for (size_t c = 0; c < 4; ++c)
        switch (node->op) {
        case NQM_MAP_VALUE:
            v[c] = node->v[nqm_smaller(c, node->n - 1u)];
            break;
        case NQM_MAP_IMAGE:
            v[c] = texel[nqm_smaller(c, node->n - 1u)];
            break;
        case NQM_MAP_ADD:
            v[c] = a[c] + b[c];
            break;
        case NQM_MAP_SUBTRACT:
            v[c] = a[c] - b[c];
            break;
        case NQM_MAP_MULTIPLY:
            v[c] = a[c] * b[c];
            break;
        case NQM_MAP_CHANNEL:
            v[c] = a[(size_t)node->v[0]];
            break;
        case NQM_MAP_ANGLE:
            v[c] = atan2(a[c], b[c]);
            break;
        case NQM_MAP_NORMAL:
            v[c] = (2 * a[c] - 1) * (c < 2 ? b[c] : 1);
            break;
        default:
            fail_msg("operation %d", (int)node->op);
        }
}

static void evaluate(const nqm_textured *t, uint16_t wanted, double v[4]) {
    double values[64][4];
    assert_true(t->n_nodes <= 64 && wanted < t->n_nodes);
    for (size_t i = 0; i < t->n_nodes; ++i)
        compute(&t->nodes[i], values, values[i]);
    memcpy(v, values[wanted], sizeof values[wanted]);
}

static uint16_t output_of(const nqm_textured *t, const char *key) {
    for (size_t i = 0; i < t->n_outputs; ++i)
        if (strcmp(t->outputs[i].key, key) == 0)
            return t->outputs[i].node;
    return NQM_NO_NODE;
}

static void check_output(const nqm_textured *t, const char *key, double r, double g, double b) {
    double v[4];
    if (output_of(t, key) == NQM_NO_NODE)
        fail_msg("no output %s", key);
    evaluate(t, output_of(t, key), v);
    assert_near(v[0], r, 1e-12);
    if (g >= 0) {
        assert_near(v[1], g, 1e-12);
        assert_near(v[2], b, 1e-12);
    } else
        assert_int_equal(t->nodes[output_of(t, key)].n, 1);
}

/* The image below a node; fails if there is another one. */
static const nqm_map_node *image_of(const nqm_textured *t) {
    const nqm_map_node *found = NULL;
    for (size_t i = 0; i < t->n_nodes; ++i)
        if (t->nodes[i].op == NQM_MAP_IMAGE) {
            assert_null(found);
            found = &t->nodes[i];
        }
    assert_non_null(found);
    return found;
}

/* ---- glTF -------------------------------------------------------------------------------------------------------- */

static const char usual[] =
    "\"textures\": [{\"source\": 0}, {\"source\": 1, \"sampler\": 0}, {}, {\"source\": 9}, "
    "{\"extensions\": {\"KHR_texture_basisu\": {\"source\": 0}}}, "
    "{\"source\": 0, \"extensions\": {\"EXT_texture_webp\": {\"source\": 1}}}, {\"source\": 2}, {\"source\": 0, "
    "\"sampler\": 1}], "
    "\"samplers\": [{\"wrapS\": 33071, \"wrapT\": 33648, \"magFilter\": 9728}, {\"wrapS\": 3}], "
    "\"images\": [{\"uri\": \"a%20b.png\", \"mimeType\": \"image/png\"}, {\"uri\": \"c.jpg\"}, {\"uri\": "
    "\"https://x.org/d.png\"}]";

static nqm_materials *read_bytes(const void *data, size_t n, const char *path) {
    unsigned char *copy = malloc(n); /* exactly as long, for sanitizers */
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    assert_non_null(copy);
    memcpy(copy, data, n);
    const nqm_map map = {.data = copy, .n_bytes = n, .path = path};
    if (nqm_materials_read(&map, &materials, &err) != NQM_OK)
        fail_msg("%s", err.message);
    free(copy);
    return materials;
}

static nqm_materials *read_material(const char *members, const char *arrays) {
    char text[8192];
    snprintf(text, sizeof text, "{\"asset\": {\"version\": \"2.0\"},\n \"materials\": [{%s}], %s}", members, arrays);
    return read_bytes(text, strlen(text), "dir/x.gltf");
}

static const nqm_textured *maps_of(const nqm_materials *materials) {
    if (!nqm_materials_textured(materials, 0))
        fail_msg("no maps: %s", nqm_materials_get(materials, 0).refusal);
    return nqm_materials_textured(materials, 0);
}

static void check_refused(const char *members, const char *arrays, const char *words) {
    nqm_materials *materials = read_material(members, arrays);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    assert_null(nqm_materials_textured(materials, 0));
    if (!info.refusal || !strstr(info.refusal, words))
        fail_msg("%s: %s, not '%s'", members, info.refusal, words);
    nqm_materials_free(materials);
}

TEST(core_textures_are_nodes) {
    nqm_materials *materials = read_material(
        "\"normalTexture\": {\"index\": 1, \"scale\": 0.5}, \"pbrMetallicRoughness\": {\"baseColorTexture\": "
        "{\"index\": 0}, \"baseColorFactor\": [1, 0.5, 0, 1], \"metallicRoughnessTexture\": {\"index\": 0}, "
        "\"roughnessFactor\": 0.5}",
        usual);
    const nqm_textured *t = maps_of(materials);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    double v[4];
    check_output(t, "base_color", 0.25, 0.25, 0);
    check_output(t, "metallic", 0.75, -1, -1);
    check_output(t, "roughness", 0.25, -1, -1);
    assert_int_equal(t->n_outputs, 3);
    evaluate(t, t->normal, v);
    assert_near(v[0], -0.25, 1e-12);
    assert_near(v[1], 0, 1e-12);
    assert_near(v[2], 0.5, 1e-12);
    assert_int_equal(t->n_images, 3); /* one of them in two colour spaces */
    assert_int_equal(info.n_maps, 3);
    assert_string_equal(info.refusal,
                        "normalTexture: a texture varies over the surface, and a BRDF is that of one point");
    assert_string_equal(t->images[1].path, "dir/a b.png");
    assert_string_equal(t->images[t->nodes[output_of(t, "metallic")].op == NQM_MAP_CHANNEL ? 2 : 0].space, "");
    assert_string_equal(t->images[1].space, "srgb_texture");
    assert_string_equal(t->images[0].space, "");
    nqm_materials_free(materials);
}

TEST(layers_have_textures) {
    nqm_materials *materials = read_material(
        "\"extensions\": {\"KHR_materials_specular\": {\"specularTexture\": {\"index\": 0}, \"specularColorTexture\": "
        "{\"index\": 0}, \"specularColorFactor\": [2, 1, 1]}, \"KHR_materials_clearcoat\": {\"clearcoatFactor\": 0.5, "
        "\"clearcoatTexture\": {\"index\": 0}, \"clearcoatRoughnessFactor\": 1, \"clearcoatRoughnessTexture\": "
        "{\"index\": 0}}, \"KHR_materials_sheen\": {\"sheenColorFactor\": [1, 1, 1], \"sheenRoughnessFactor\": 0.5, "
        "\"sheenColorTexture\": {\"index\": 0}, \"sheenRoughnessTexture\": {\"index\": 0}}, "
        "\"KHR_materials_anisotropy\": {\"anisotropyStrength\": 0.8, \"anisotropyRotation\": 0.1, "
        "\"anisotropyTexture\": {\"index\": 0}}, \"KHR_materials_iridescence\": {\"iridescenceFactor\": 0.5, "
        "\"iridescenceThicknessMinimum\": 200, \"iridescenceTexture\": {\"index\": 0}, "
        "\"iridescenceThicknessTexture\": {\"index\": 0}}}",
        usual);
    const nqm_textured *t = maps_of(materials);
    check_output(t, "specular", 0.4, -1, -1);
    check_output(t, "specular_color", 0.5, 0.5, 0.75);
    check_output(t, "clearcoat", 0.125, -1, -1);
    check_output(t, "clearcoat_roughness", 0.5, -1, -1);
    check_output(t, "sheen_color", 0.25, 0.5, 0.75);
    check_output(t, "sheen_roughness", 0.2, -1, -1);
    check_output(t, "anisotropy_strength", 0.6, -1, -1);
    check_output(t, "anisotropy_rotation", acos(-1) + 0.1, -1, -1);
    check_output(t, "iridescence", 0.125, -1, -1);
    check_output(t, "iridescence_thickness", 300, -1, -1);
    nqm_materials_free(materials);
}

TEST(factors_of_zero_remove_textures) {
    nqm_materials *materials = read_material("\"pbrMetallicRoughness\": {\"metallicRoughnessTexture\": {\"index\": 0}, "
                                             "\"metallicFactor\": 0}",
                                             usual);
    assert_int_equal(maps_of(materials)->n_outputs, 1);
    assert_non_null(nqm_shading_find(&maps_of(materials)->shading, "metallic"));
    nqm_materials_free(materials);
    materials = read_material("\"pbrMetallicRoughness\": {\"metallicRoughnessTexture\": {\"index\": 0}, "
                              "\"metallicFactor\": 0, \"roughnessFactor\": 0}",
                              usual);
    assert_null(nqm_materials_textured(materials, 0));
    assert_string_equal(nqm_materials_get(materials, 0).spec, "gltf:metallic=0;roughness=0");
    nqm_materials_free(materials);
}

/* The examples of the specification of KHR_texture_transform: the lower left quadrant turned, and v upwards. */
TEST(positions_are_transformed) {
    nqm_materials *materials = read_material(
        "\"normalTexture\": {\"index\": 1, \"extensions\": {\"KHR_texture_transform\": {\"offset\": [0, 1], "
        "\"rotation\": 1.5707963267948966, \"scale\": [0.5, 0.25], \"texCoord\": 1}}}",
        usual);
    const double quadrant[2][3] = {{0, 0.25, 0}, {-0.5, 0, 1}}, flip[2][3] = {{1, 0, 0}, {0, -1, 1}};
    const nqm_map_node *node = image_of(maps_of(materials));
    for (size_t i = 0; i < 6; ++i)
        assert_near(node->uv[i / 3][i % 3], quadrant[i / 3][i % 3], 1e-12);
    assert_int_equal(node->wrap[0], NQM_MAP_CLAMP);
    assert_int_equal(node->wrap[1], NQM_MAP_MIRROR);
    assert_non_null(strstr(nqm_materials_get(materials, 0).remark, "texture coordinates"));
    nqm_materials_free(materials);
    materials = read_material("\"normalTexture\": {\"index\": 0, \"extensions\": {\"KHR_texture_transform\": "
                              "{\"offset\": [0, 1], \"scale\": [1, -1]}}}",
                              usual);
    node = image_of(maps_of(materials));
    for (size_t i = 0; i < 6; ++i)
        assert_near(node->uv[i / 3][i % 3], flip[i / 3][i % 3], 1e-12);
    assert_int_equal(node->wrap[0], NQM_MAP_REPEAT);
    assert_null(nqm_materials_get(materials, 0).remark);
    nqm_materials_free(materials);
}

#define NORMAL(INDEX) "\"normalTexture\": {\"index\": " INDEX "}"

TEST(bad_textures_are_refused) {
    EVERY_ROW(row, "bad textures of glTF") {
        check_refused(row[0], usual, row[1]);
    }
}

TEST(what_is_not_evaluated_is_remarked) {
    EVERY_ROW(row, "what is not evaluated") {
        nqm_materials *materials = read_material(row[0], usual);
        maps_of(materials);
        if (!strstr(nqm_materials_get(materials, 0).remark, row[1]))
            fail_msg("%s", nqm_materials_get(materials, 0).remark);
        nqm_materials_free(materials);
    }
    nqm_materials *materials =
        read_material(NORMAL("0") ", \"extensions\": {\"KHR_materials_clearcoat\": {\"clearcoatFactor\": 1, "
                                  "\"clearcoatNormalTexture\": {\"index\": 0}}}",
                      usual);
    maps_of(materials);
    assert_null(nqm_materials_get(materials, 0).remark);
    nqm_materials_free(materials);
}

/* ---- embedded images --------------------------------------------------------------------------------------------- */

#define TEXTURE "\"textures\": [{\"source\": 0}], "
#define IN_VIEW TEXTURE "\"images\": [{\"bufferView\": 0}], "
#define BUFFER_OF_DATA                                                                                                 \
    ", \"buffers\": [{\"byteLength\": 10, \"uri\": \"data:application/octet-stream;base64,MDEyMzQ1Njc4OQ==\"}]"

static void check_data(const char *arrays, const char *expected) {
    nqm_materials *materials = read_material(NORMAL("0"), arrays);
    const nqm_map_image *image = &maps_of(materials)->images[0];
    assert_null(image->path);
    assert_int_equal(image->n_bytes, strlen(expected));
    assert_memory_equal(image->data, expected, strlen(expected));
    nqm_materials_free(materials);
}

TEST(data_uris_are_decoded) {
    check_data(TEXTURE "\"images\": [{\"uri\": \"data:image\\/png;base64,MDEyMzQ1Njc4OQ==\"}]", "0123456789");
    check_data(TEXTURE "\"images\": [{\"uri\": \"data:image/png;base64,MDEyMzQ1Njc4\"}]", "012345678");
    check_data(TEXTURE "\"images\": [{\"uri\": \"data:image/png;base64,Pz8+\"}]", "?\?>");
    check_data(IN_VIEW "\"bufferViews\": [{\"buffer\": 0, \"byteOffset\": 4, \"byteLength\": 5}]" BUFFER_OF_DATA,
               "45678");
    check_data(IN_VIEW "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 10}]" BUFFER_OF_DATA, "0123456789");
    EVERY_ROW(row, "bad images of glTF") {
        check_refused(NORMAL("0"), row[0], row[1]);
    }
}

TEST(buffers_of_files_are_parts_of_them) {
    nqm_materials *materials =
        read_material(NORMAL("0"), IN_VIEW "\"bufferViews\": [{\"buffer\": 0, \"byteOffset\": 7, \"byteLength\": 3}], "
                                           "\"buffers\": [{\"byteLength\": 10, \"uri\": \"b%2Ebin\"}]");
    const nqm_map_image *image = &maps_of(materials)->images[0];
    assert_string_equal(image->path, "dir/b.bin");
    assert_true(image->at == 7 && image->n_bytes == 3);
    nqm_materials_free(materials);
}

/* A binary file with n_bin bytes after its JSON. */
static size_t make_glb(unsigned char *b, const char *arrays, size_t n_bin) {
    char json[1024];
    const size_t n = (size_t)snprintf(
        json, sizeof json, "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"normalTexture\":{\"index\":0}}],%s}",
        arrays);
    const uint32_t words[] = {0x46546C67, 2, (uint32_t)(28 + n + n_bin), (uint32_t)n, 0x4E4F534A};
    for (size_t i = 0; i < 5; ++i)
        nqm_store_u32(b + 4 * i, words[i]);
    memcpy(b + 20, json, n);
    nqm_store_u32(b + 20 + n, (uint32_t)n_bin);
    nqm_store_u32(b + 24 + n, 0x004E4942);
    memset(b + 28 + n, 'x', n_bin);
    return 28 + n;
}

TEST(binary_chunks_are_found) {
    static const char arrays[] = IN_VIEW
        "\"bufferViews\": [{\"buffer\": 0, \"byteOffset\": 8, \"byteLength\": 4}], \"buffers\": [{\"byteLength\": 12}]";
    unsigned char b[2048];
    const size_t bin = make_glb(b, arrays, 12);
    nqm_materials *materials = read_bytes(b, bin + 12, "y.glb");
    const nqm_map_image *image = &maps_of(materials)->images[0];
    assert_string_equal(image->path, "y.glb");
    assert_true(image->at == bin + 8 && image->n_bytes == 4);
    nqm_materials_free(materials);
    const size_t sizes[] = {8, 0};
    for (size_t i = 0; i < 2; ++i) { /* the chunk is shorter than the buffer */
        make_glb(b, arrays, sizes[i]);
        materials = read_bytes(b, bin + sizes[i], "y.glb");
        assert_null(nqm_materials_textured(materials, 0));
        assert_non_null(strstr(nqm_materials_get(materials, 0).refusal, "are not in buffers[0]"));
        nqm_materials_free(materials);
    }
    make_glb(b, arrays, 12);
    nqm_store_u32(b + bin - 8, 1 << 30); /* the chunk says that it is longer than the file */
    materials = read_bytes(b, bin + 12, "y.glb");
    maps_of(materials);
    nqm_materials_free(materials);
}

/* Many materials with the same image in the text take no more memory than a multiple of the file. */
TEST(decoded_images_are_bounded) {
    enum { N = 200000, MATERIALS = 40 };
    char *text = malloc(N + 100 + 100 * MATERIALS);
    assert_non_null(text);
    size_t n =
        (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"}," TEXTURE "\"images\":[{\"uri\":\"data:;base64,");
    memset(text + n, 'A', N);
    n += N;
    n += (size_t)sprintf(text + n, "\"}],\"materials\":[");
    for (size_t i = 0; i < MATERIALS; ++i)
        n += (size_t)sprintf(text + n, "%s{" NORMAL("0") "}", i ? "," : "");
    n += (size_t)sprintf(text + n, "]}");
    nqm_materials *materials = read_bytes(text, n, "x.gltf");
    assert_non_null(nqm_materials_textured(materials, 9));
    assert_null(nqm_materials_textured(materials, MATERIALS - 1));
    assert_non_null(strstr(nqm_materials_get(materials, MATERIALS - 1).refusal, "store the file as .glb"));
    nqm_materials_free(materials);
    free(text);
}

/* Every allocation fails once: no material is complete without what it needed, and nothing leaks. */
TEST(failed_allocations_are_told) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"normalTexture\":{\"index\":0},\"pbrMetallicRoughness\":"
        "{\"baseColorTexture\":{\"index\":1},\"roughnessFactor\":0.5,\"metallicRoughnessTexture\":{\"index\":2}}}],"
        "\"textures\":[{\"source\":0},{\"source\":1},{\"source\":2}],\"images\":[{\"uri\":\"a.png\"},"
        "{\"uri\":\"data:;base64,MDEy\"},{\"bufferView\":0}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":3}],"
        "\"buffers\":[{\"byteLength\":3,\"uri\":\"b.bin\"}]}";
    const nqm_map map = {.data = (const unsigned char *)text, .n_bytes = sizeof text - 1, .path = "x.gltf"};
    const nqm_textured *t = NULL;
    for (long n = 0; !t && n < 1000; ++n) {
        nqm_materials *materials = NULL;
        nqm_error err = {0};
        nqm_alloc_fail_after(n);
        const nqm_status status = nqm_materials_read(&map, &materials, &err);
        nqm_alloc_fail_after(-1);
        t = status == NQM_OK ? nqm_materials_textured(materials, 0) : NULL;
        assert_true(status == NQM_OK || (status == NQM_ERR_NOMEM && !materials));
        if (t)
            assert_true(t->n_images == 3 && t->n_outputs == 3 && t->normal != NQM_NO_NODE);
        else if (status == NQM_OK)
            assert_non_null(strstr(nqm_materials_get(materials, 0).refusal, "out of memory"));
        nqm_materials_free(materials);
    }
    assert_non_null(t);
    nqm_textured *list = NULL;
    nqm_status status = NQM_OK;
    long rounds = -1;
    EVERY_ALLOCATION(rounds, status, 0) {
        status = nqm_maps_open("maps:base_color=a.png;roughness=b.png:g;normal=c.png:dx", &list, NULL);
        assert_true((status == NQM_OK) == (list != NULL));
    }
    assert_int_equal(list->n_outputs, 2);
    nqm_textured_free(list);
}

/* ---- lists of maps ----------------------------------------------------------------------------------------------- */

static nqm_textured *open_maps(const char *argument) {
    nqm_textured *t;
    nqm_error err = {0};
    if (nqm_maps_open(argument, &t, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return t;
}

TEST(lists_have_maps_and_numbers) {
    assert_true(nqm_maps_probe("maps:base_color=a.png") && !nqm_maps_probe("gltf:metallic=1"));
    nqm_textured *t = open_maps("maps:base_color=d/a.JPG;roughness=orm.png:g;metallic=1;ior=1.4;normal=n.png;");
    double v[4];
    assert_string_equal(t->shading.model, "gltf");
    check_output(t, "base_color", 0.25, 0.5, 0.75);
    check_output(t, "roughness", 0.5, -1, -1);
    assert_int_equal(t->n_outputs, 2);
    assert_near(nqm_shading_find(&t->shading, "metallic")->v[0], 1, 0);
    assert_string_equal(t->images[0].path, "d/a.JPG");
    assert_string_equal(t->images[0].space, "srgb_texture");
    assert_string_equal(t->images[1].path, "orm.png");
    assert_string_equal(t->images[1].space, "");
    evaluate(t, t->normal, v);
    assert_near(v[0], -0.5, 1e-12);
    assert_near(v[2], 0.5, 1e-12);
    nqm_textured_free(t);
    t = open_maps("maps:model=disney;baseColor=1,0,0.5;roughness=r.exr:a");
    assert_string_equal(t->shading.model, "disney");
    check_output(t, "roughness", 0.4, -1, -1);
    nqm_textured_free(t);
    t = open_maps("maps:base_color=linear.exr;normal=n.png:dx");
    assert_string_equal(t->images[0].space, "");
    nqm_textured_free(t);
}

TEST(bad_lists_are_refused) {
    EVERY_ROW(row, "bad lists of maps") {
        nqm_textured *t;
        nqm_error err = {0};
        assert_int_equal(nqm_maps_open(row[0], &t, &err), NQM_ERR_ARG);
        assert_null(t);
        if (!strstr(err.message, row[1]))
            fail_msg("%s: %s", row[0], err.message);
    }
}

/* ---- folders ----------------------------------------------------------------------------------------------------- */

static char folder[] = "/tmp/nqm_maps_XXXXXX";

static void with_files(const char *names, void (*make)(const char *path)) {
    char text[1024], path[1200], *rest = text, *name;
    snprintf(text, sizeof text, "%s", names);
    while ((name = strsep(&rest, " "))) {
        snprintf(path, sizeof path, "%s/%s", folder, name);
        make(path);
    }
}

static void create_file(const char *path) {
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fclose(f);
}

static void remove_file(const char *path) {
    assert_int_equal(remove(path), 0);
}

/* The files, and which of them are the maps in the order base colour, roughness, metallic, normal. */
static void check_folder(const char *names, const char *expected) {
    char text[512] = "";
    with_files(names, create_file);
    nqm_textured *t = open_maps(folder);
    for (size_t i = 0; i < t->n_images; ++i)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s", i ? " " : "", t->images[i].name);
    assert_string_equal(text, expected);
    assert_true((strstr(expected, "etal") || strstr(expected, "arm")) == (output_of(t, "metallic") != NQM_NO_NODE));
    assert_true((output_of(t, "metallic") == NQM_NO_NODE) == (nqm_shading_find(&t->shading, "metallic") != NULL));
    double v[4];
    texel[1] = 0.7;
    evaluate(t, t->normal, v);
    texel[1] = 0.5;
    assert_near(v[0], -0.5, 1e-12);
    assert_near(v[1], strstr(expected, "dx") ? -0.4 : 0.4, 1e-12);
    assert_near(v[2], 0.5, 1e-12);
    nqm_textured_free(t);
    with_files(names, remove_file);
}

TEST(names_of_three_sites_are_known) {
    assert_non_null(mkdtemp(folder));
    assert_true(nqm_maps_probe(folder));
    check_folder("metal_plate_ao_2k.jpg metal_plate_diff_2k.jpg metal_plate_disp_2k.png metal_plate_metal_2k.exr "
                 "metal_plate_nor_dx_2k.exr metal_plate_nor_gl_2k.exr metal_plate_rough_2k.jpg",
                 "metal_plate_diff_2k.jpg metal_plate_rough_2k.jpg metal_plate_metal_2k.exr metal_plate_nor_gl_2k.exr");
    check_folder("Bricks001.png Bricks001_2K-PNG_AmbientOcclusion.png Bricks001_2K-PNG_Color.png "
                 "Bricks001_2K-PNG_NormalDX.png Bricks001_2K-PNG_NormalGL.png Bricks001_2K-PNG_Roughness.png",
                 "Bricks001_2K-PNG_Color.png Bricks001_2K-PNG_Roughness.png Bricks001_2K-PNG_NormalGL.png");
    check_folder("basecolor.png diffuse.png displacement.png height.png metallic.png normal.png opacity.png "
                 "roughness.png specular.png basecolor.txt",
                 "basecolor.png roughness.png metallic.png normal.png");
    check_folder("x_arm_4k.jpg x_diff_4k.jpg x_nor_dx_4k.jpg", "x_diff_4k.jpg x_arm_4k.jpg x_nor_dx_4k.jpg");
}

static void check_folder_error(const char *names, nqm_status expected, const char *words) {
    nqm_textured *t;
    nqm_error err = {0};
    with_files(names, create_file);
    assert_int_equal(nqm_maps_open(folder, &t, &err), expected);
    assert_null(t);
    if (!strstr(err.message, words))
        fail_msg("%s", err.message);
    with_files(names, remove_file);
}

TEST(folders_that_are_unclear_are_refused) {
    check_folder_error("a_color.png b_color.png", NQM_ERR_ARG, "two maps of base_color: a_color.png and b_color.png");
    check_folder_error("a.png b.txt", NQM_ERR_IO, "no file of this folder is named like a map");
    assert_int_equal(rmdir(folder), 0);
    nqm_textured *t;
    assert_int_equal(nqm_maps_open(folder, &t, NULL), NQM_ERR_IO);
    assert_false(nqm_maps_probe(folder));
}
