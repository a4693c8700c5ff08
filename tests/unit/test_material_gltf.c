/* SPDX-License-Identifier: MIT
 *
 * Materials of glTF: what is accepted, what is refused and where, broken files, and files that are written and read back.
 */
#include "base/base.h"
#include "brdf/core/spec.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/material_text.h"
#include "support/rows.h"

/* A file whose only material has these members. */
static const char *document(const char *members) {
    static char text[4096];
    snprintf(text, sizeof text, "{\"asset\": {\"version\": \"2.0\"},\n \"materials\": [{%s}]}", members);
    return text;
}

/* ---- accepted ---------------------------------------------------------------------------------------------------- */

TEST(occlusion_is_ignored_with_a_remark) {
    nqm_materials *materials = text_as_materials("x.gltf", document("\"occlusionTexture\": {\"index\": 0}"));
    const nqm_material_info info = nqm_materials_get(materials, 0);
    assert_string_equal(info.spec, "gltf:");
    assert_non_null(strstr(info.remark, "occlusion"));
    nqm_materials_free(materials);
    materials = text_as_materials("x.gltf", document("\"alphaCutoff\": 0.5"));
    assert_null(nqm_materials_get(materials, 0).remark);
    nqm_materials_free(materials);
}

/* ---- refused (most: vectors/materials.txt) ---------------------------------------------------------------------- */

/* What is not about materials, by its name, is ignored with a remark; what may be refuses them. */
TEST(requirements_concern_every_material) {
    nqm_materials *materials =
        text_as_materials("x.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": "
                                    "[\"KHR_draco_mesh_compression\", \"EXT_odd\"], "
                                    "\"materials\": [{\"name\": \"a\"}, {}]}");
    assert_int_equal(nqm_materials_count(materials), 2);
    for (size_t i = 0; i < 2; ++i)
        assert_string_equal(nqm_materials_get(materials, i).refusal, "extensionsRequired: EXT_odd is not known");
    nqm_materials_free(materials);
    materials =
        text_as_materials("x.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": "
                                    "[\"KHR_texture_transform\", \"EXT_structural_metadata\", \"KHR_materials_coat\"], "
                                    "\"materials\": [{\"normalTexture\": {}}, {\"occlusionTexture\": {}}]}");
    static const char remark[] =
        "not read: the required extension EXT_structural_metadata, which is not about materials";
    assert_string_equal(nqm_materials_get(materials, 0).remark, remark);
    assert_non_null(strstr(nqm_materials_get(materials, 1).remark, remark));
    assert_non_null(strstr(nqm_materials_get(materials, 1).remark, "occlusion"));
    assert_non_null(nqm_materials_get(materials, 1).spec);
    nqm_materials_free(materials);
}

/* Blanks before the text. */
TEST(positions_are_inside_of_the_file) {
    const char *text = "\n {\"asset\": {\"version\": \"2.0\"}, \"materials\": [{\"normalTexture\": 7}]}";
    nqm_materials *materials = text_as_materials("x.gltf", text);
    assert_int_equal(nqm_materials_get(materials, 0).byte_offset, strchr(text, '7') - text);
    nqm_materials_free(materials);
}

/* ---- broken files ------------------------------------------------------------------------------------------------ */

/* A binary file with a JSON chunk. */
static size_t make_glb(unsigned char *b) {
    static const char json[] = "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{}]}   ";
    const uint32_t n = sizeof json - 1, words[] = {0x46546C67, 2, 20 + n, n, 0x4E4F534A};
    for (size_t i = 0; i < 5; ++i)
        nqm_store_u32(b + 4 * i, words[i]);
    memcpy(b + 20, json, n);
    return 20 + n;
}

TEST(broken_binary_files_are_refused) {
    unsigned char b[256];
    const size_t n = make_glb(b);
    nqm_materials *materials = bytes_as_materials("x", b, n);
    assert_int_equal(nqm_materials_get(materials, 0).byte_offset, n - 5 - 2);
    nqm_materials_free(materials);
    refuse_cuts("x.gltf", (blob){b, n}, 1, read_materials);
    static const struct {
        size_t at;
        uint32_t value;
        const char *words;
    } cases[] = {{4, 1, "version 1"},         {8, 5, "5 bytes"},           {8, UINT32_MAX, "4294967295 bytes"},
                 {12, 1000, "1000 bytes"},    {12, UINT32_MAX, "a chunk"}, {12, 3, "invalid JSON"},
                 {16, 0x004E4942, "not JSON"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        make_glb(b);
        nqm_store_u32(b + cases[i].at, cases[i].value);
        refuse_bytes("x.gltf", b, n, NQM_ERR_FORMAT,
                     cases[i].at == 12 && cases[i].value == 3 ? -1 : (int64_t)cases[i].at, cases[i].words);
    }
    make_glb(b);
    nqm_store_u32(b + 8, (uint32_t)n - 4); /* the file ends before its JSON, although more bytes follow */
    refuse_bytes("x.gltf", b, n, NQM_ERR_FORMAT, 12, "a chunk");
}

/* ---- written and read back --------------------------------------------------------------------------------------- */

static char *file_text(const char *path) {
    static char text[8192];
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    text[fread(text, 1, sizeof text - 1, f)] = 0;
    fclose(f);
    return text;
}

static void check_round_trip(const char *argument, const char *name) {
    const char *path = scratch_path(name);
    nqm_brdf *brdf = must_open(argument);
    nqm_error err = {0};
    if (nqm_material_write(nqm_brdf_get_info(brdf).spec, "some name", path, &err) != NQM_OK)
        fail_msg("%s", err.message);
    nqm_brdf *again = must_open(path);
    assert_string_equal(nqm_brdf_get_info(again).spec, nqm_brdf_get_info(brdf).spec);
    nqm_brdf_free(again);
    nqm_brdf_free(brdf);
    remove(path);
}

TEST(files_give_back_the_same_bits) {
    nqm_rng rng = nqm_rng_make(14, 1);
    for (int i = 0; i < 40; ++i) {
        const nqm_schema *schema = &nqm_gltf_schema;
        nqm_values values = {.schema = schema, .given = i == 0 ? 0 : nqm_rng_u64(&rng)};
        for (size_t k = 0; k < schema->n_keys; ++k)
            for (size_t c = 0; c < 3; ++c)
                values.v[k][c] = c && schema->keys[k].n == 1
                                     ? values.v[k][0]
                                     : nqm_rng_uniform(&rng) + (strcmp(schema->keys[k].name, "ior") == 0);
        values.given |= 1;
        char *spec = nqm_values_spec(&values);
        assert_non_null(spec);
        check_round_trip(spec, i % 2 ? "x.gltf" : "x.GLB");
        nqm_free(spec);
    }
}

TEST(files_have_the_extensions_that_they_need) {
    const char *path = scratch_path("x.gltf");
    assert_int_equal(nqm_material_write("gltf:metallic=0;ior=1.5", "plain", path, NULL), NQM_OK);
    assert_null(strstr(file_text(path), "xtensions"));
    assert_int_equal(nqm_material_write("gltf:clearcoat=1;ior=1.4", "coated", path, NULL), NQM_OK);
    assert_non_null(
        strstr(file_text(path), "\"extensionsUsed\": [\"KHR_materials_ior\", \"KHR_materials_clearcoat\"]"));
    assert_null(strstr(file_text(path), "KHR_materials_sheen"));
    nqm_error err = {0};
    assert_int_equal(nqm_material_write("ggx:alpha=.1", "x", path, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, ".gltf .glb (gltf)"));
    remove(path);
}

/* What nqm_brdf_open() refuses as a spec is not written. */
TEST(specs_are_checked) {
    const char *path = scratch_path("x.gltf");
    EVERY_ROW(row, "specs that are not written") {
        nqm_error err = {0};
        assert_int_equal(nqm_material_write(row[0], "x", path, &err), NQM_ERR_ARG);
        assert_non_null(strstr(err.message, row[1]));
        assert_int_equal(access(path, F_OK), -1);
    }
}

/* Indices between 0 and 1 are not valid in a file; their reciprocal has the same Fresnel factor. */
TEST(files_have_valid_indices) {
    const char *path = scratch_path("x.gltf");
    assert_int_equal(nqm_material_write("gltf:ior=.5", "x", path, NULL), NQM_OK);
    nqm_brdf *brdf = must_open(path);
    assert_non_null(strstr(nqm_brdf_get_info(brdf).spec, "ior=2;"));
    nqm_brdf_free(brdf);
    remove(path);
}
