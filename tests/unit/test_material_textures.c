/* SPDX-License-Identifier: MIT
 *
 * Textures of glTF that are refused or embedded, and folders and lists of maps.
 */
#include "base/base.h"
#include "material/maps.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/map_text.h"
#include "support/material_text.h"
#include "support/rows.h"

/* ---- glTF -------------------------------------------------------------------------------------------------------- */

static const char usual[] =
    "\"textures\": [{\"source\": 0}, {\"source\": 1, \"sampler\": 0}, {}, {\"source\": 9}, "
    "{\"extensions\": {\"KHR_texture_basisu\": {\"source\": 0}}}, "
    "{\"source\": 0, \"extensions\": {\"EXT_texture_webp\": {\"source\": 1}}}, {\"source\": 2}, {\"source\": 0, "
    "\"sampler\": 1}, {\"source\": 1}, {\"source\": 0, \"extensions\": {\"EXT_texture_webp\": {\"source\": 7}}}, "
    "{\"source\": 0, \"extensions\": {\"EXT_texture_webp\": {}}}, {\"extensions\": {\"EXT_texture_avif\": {\"source\": "
    "0}}}], "
    "\"samplers\": [{\"wrapS\": 33071, \"wrapT\": 33648, \"magFilter\": 9728}, {\"wrapS\": 3}], "
    "\"images\": [{\"uri\": \"a%20b.png\", \"mimeType\": \"image/png\"}, {\"uri\": \"c.jpg\"}, {\"uri\": "
    "\"https://x.org/d.png\"}]";

static nqm_materials *read_material(const char *members, const char *arrays) {
    char text[8192];
    snprintf(text, sizeof text, "{\"asset\": {\"version\": \"2.0\"},\n \"materials\": [{%s}], %s}", members, arrays);
    return text_as_materials("dir/x.gltf", text);
}

static const nqm_textured *maps_of(const nqm_materials *materials) {
    if (!nqm_materials_maps(materials, 0, 0))
        fail_msg("no maps: %s", nqm_materials_get(materials, 0).refusal);
    return nqm_materials_maps(materials, 0, 0);
}

static void check_refused(const char *members, const char *arrays, const char *words) {
    nqm_materials *materials = read_material(members, arrays);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    assert_null(nqm_materials_maps(materials, 0, 0));
    if (!info.refusal || !strstr(info.refusal, words))
        fail_msg("%s: %s, not '%s'", members, info.refusal, words);
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
    nqm_materials *materials = bytes_as_materials("y.glb", b, bin + 12);
    const nqm_map_image *image = &maps_of(materials)->images[0];
    assert_string_equal(image->path, "y.glb");
    assert_true(image->at == bin + 8 && image->n_bytes == 4);
    nqm_materials_free(materials);
    const size_t sizes[] = {8, 0};
    for (size_t i = 0; i < 2; ++i) { /* the chunk is shorter than the buffer */
        make_glb(b, arrays, sizes[i]);
        materials = bytes_as_materials("y.glb", b, bin + sizes[i]);
        assert_null(nqm_materials_maps(materials, 0, 0));
        assert_non_null(strstr(nqm_materials_get(materials, 0).refusal, "are not in buffers[0]"));
        nqm_materials_free(materials);
    }
    make_glb(b, arrays, 12);
    nqm_store_u32(b + bin - 8, 1 << 30); /* the chunk says that it is longer than the file */
    materials = bytes_as_materials("y.glb", b, bin + 12);
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
    nqm_materials *materials = bytes_as_materials("x.gltf", text, n);
    assert_non_null(nqm_materials_maps(materials, 9, 0));
    assert_null(nqm_materials_maps(materials, MATERIALS - 1, 0));
    assert_non_null(strstr(nqm_materials_get(materials, MATERIALS - 1).refusal, "store the file as .glb"));
    nqm_materials_free(materials);
    free(text);
}

/* ---- lists of maps ----------------------------------------------------------------------------------------------- */

static nqm_textured *open_maps(const char *argument) {
    nqm_textured *t;
    nqm_error err = {0};
    if (nqm_maps_open(argument, &t, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return t;
}

static void check_key(const nqm_textured *t, const char *key, const char *value) {
    char found[MAP_TEXT];
    describe_map(t, key, found);
    assert_string_equal(found, value);
}

TEST(lists_have_maps_and_numbers) {
    nqm_textured *t = open_maps("maps:base_color=d/a.JPG;roughness=orm.png:g;metallic=1;ior=1.4;normal=n.png;");
    assert_string_equal(t->values.schema->model, "gltf");
    check_key(t, "base_color", "image(d/a.JPG srgb_texture repeat)");
    check_key(t, "roughness", "channel(image(orm.png repeat) 1)");
    check_key(t, "normal", "normal(image(n.png repeat), 1 1)");
    assert_int_equal(t->n_outputs, 2);
    assert_near(nqm_values_given(&t->values, "metallic")[0], 1, 0);
    assert_string_equal(t->images[0].path, "d/a.JPG");
    assert_string_equal(t->images[1].path, "orm.png");
    nqm_textured_free(t);
    t = open_maps("maps:model=disney;baseColor=1,0,0.5;roughness=r.exr:a");
    assert_string_equal(t->values.schema->model, "disney");
    check_key(t, "roughness", "channel(image(r.exr repeat) 3)");
    nqm_textured_free(t);
    t = open_maps("maps:base_color=linear.exr;normal=n.png:dx");
    check_key(t, "base_color", "image(linear.exr repeat)");
    nqm_textured_free(t);
}

TEST(failed_allocations_are_told) {
    nqm_status status = NQM_OK;
    long rounds = -1;
    EVERY_ALLOCATION(rounds, status, 0) {
        nqm_textured *list = NULL;
        status = nqm_maps_open("maps:base_color=a.png;roughness=b.png:g;normal=c.png:dx", &list, NULL);
        assert_true((status == NQM_OK) == (list != NULL));
        nqm_textured_free(list);
    }
}

TEST(remarks_are_said_once) {
    char remark[40] = "";
    nqm_remark_add(remark, sizeof remark, "coat_rough is 1");
    nqm_remark_add(remark, sizeof remark, "rough is 1"); /* a part of the other */
    nqm_remark_add(remark, sizeof remark, "coat_rough is 1");
    nqm_remark_add(remark, sizeof remark, "rough is 1");
    assert_string_equal(remark, "coat_rough is 1; rough is 1");
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
    char text[512] = "", found[MAP_TEXT];
    with_files(names, create_file);
    nqm_textured *t = open_maps(folder);
    for (size_t i = 0; i < t->n_images; ++i)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s", i ? " " : "", t->images[i].name);
    assert_string_equal(text, expected);
    const bool has_metal = strstr(expected, "etal") || strstr(expected, "arm");
    describe_map(t, "metallic", found);
    assert_true(has_metal == (*found != 0) && has_metal == !nqm_values_given(&t->values, "metallic"));
    snprintf(text, sizeof text, "normal(image(%s repeat), %s)", strrchr(expected, ' ') + 1,
             strstr(expected, "dx") ? "1 -1" : "1 1");
    check_key(t, "normal", text);
    nqm_textured_free(t);
    with_files(names, remove_file);
}

TEST(names_of_three_sites_are_known) {
    assert_non_null(mkdtemp(folder));
    check_folder("Wood_Color_1K-WEBP.webp Wood_Metalness_1K-WEBP.webp Wood_NormalGL_1K-WEBP.webp",
                 "Wood_Color_1K-WEBP.webp Wood_Metalness_1K-WEBP.webp Wood_NormalGL_1K-WEBP.webp");
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

/* What each key is computed from, and what is said of the rest. */
TEST(names_of_libraries_and_exporters_are_known) {
    static const struct {
        const char *files, *base_color, *roughness, *metallic, *normal, *remark;
    } rows[] = {
        {"H_M_baseColor.png H_M_normal.png H_M_occlusionRoughnessMetallic.png",
         "image(H_M_baseColor.png srgb_texture repeat)", "channel(image(H_M_occlusionRoughnessMetallic.png repeat) 1)",
         "channel(image(H_M_occlusionRoughnessMetallic.png repeat) 2)", "normal(image(H_M_normal.png repeat), 1 1)",
         ""},
        {"W_AlbedoTransparency.png W_MetallicSmoothness.png W_Normal.png",
         "image(W_AlbedoTransparency.png srgb_texture repeat)",
         "subtract(1, channel(image(W_MetallicSmoothness.png repeat) 3))",
         "channel(image(W_MetallicSmoothness.png repeat) 0)", "normal(image(W_Normal.png repeat), 1 1)", ""},
        {"T_R_BC.png T_R_N.png T_R_ORM.png", "image(T_R_BC.png srgb_texture repeat)",
         "channel(image(T_R_ORM.png repeat) 1)", "channel(image(T_R_ORM.png repeat) 2)",
         "normal(image(T_R_N.png repeat), 1 -1)", ""},
        {"B_COL_VAR1_3K.png B_GLOSS_3K.png B_NRM_3K.png B_REFL_3K.png", "image(B_COL_VAR1_3K.png srgb_texture repeat)",
         "subtract(1, channel(image(B_GLOSS_3K.png repeat) 0))", "", "normal(image(B_NRM_3K.png repeat), 1 1)",
         "not used: B_REFL_3K.png; metallic is 0, as nothing gives it"},
        {"m_diff_8k.png m_Nor_8k.png m_rough_8k.png m_AO_8k.png", "image(m_diff_8k.png srgb_texture repeat)",
         "channel(image(m_rough_8k.png repeat) 0)", "", "normal(image(m_Nor_8k.png repeat), 1 1)",
         "not used: m_AO_8k.png; metallic is 0, as nothing gives it"},
        {"x_diffuse.png x_normals.png x_roughness.png x_specular.png", "image(x_diffuse.png srgb_texture repeat)",
         "channel(image(x_roughness.png repeat) 0)", "", "normal(image(x_normals.png repeat), 1 1)",
         "metallic is 0, as nothing gives it"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        char found[MAP_TEXT];
        with_files(rows[i].files, create_file);
        nqm_textured *t = open_maps(folder);
        const char *const keys[] = {"base_color", "roughness", "metallic", "normal"}, *const expected[] = {
                                                                                          rows[i].base_color,
                                                                                          rows[i].roughness,
                                                                                          rows[i].metallic,
                                                                                          rows[i].normal};
        for (size_t k = 0; k < 4; ++k) {
            describe_map(t, keys[k], found);
            assert_string_equal(found, expected[k]);
        }
        assert_string_equal(t->remark, rows[i].remark);
        describe_map(t, "specular_color", found); /* F0 where the index of refraction is infinite */
        const double *ior = nqm_values_given(&t->values, "ior");
        assert_true(*found ? i == 5 && ior && *ior > 1e6 : i < 5 && !ior);
        nqm_textured_free(t);
        with_files(rows[i].files, remove_file);
    }
}

TEST(pictures_without_room_in_the_remark_are_counted) {
    char names[1000] = "a_color.png";
    for (int i = 0; i < 40; ++i)
        snprintf(names + strlen(names), sizeof names - strlen(names), " long_name_%02d.png", i);
    with_files(names, create_file);
    nqm_textured *t = open_maps(folder);
    const char *more = strstr(t->remark, " and ");
    assert_non_null(more);
    size_t n_named = 0;
    for (const char *at = t->remark; (at = strstr(at, "long_name_")); ++at)
        ++n_named;
    assert_true(n_named > 20 && n_named + strtoul(more + 5, NULL, 10) == 40);
    assert_non_null(strstr(more, " more; metallic is 0, as nothing gives it"));
    nqm_textured_free(t);
    with_files(names, remove_file);
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
}
