/* SPDX-License-Identifier: MIT
 *
 * USD as text: materials with constants, node graphs and maps, what is refused, what is damaged, and what other files of USD are.
 */
#include "material/maps.h"
#include "support/check.h"
#include "support/map_text.h"
#include "support/material_text.h"
#include "support/temp_file.h"

#define HEAD "#usda 1.0\n(\n    doc = \"\"\"a ) \"quoted\" layer\"\"\"\n)\n"
/* A material with one shader of an id and inputs. */
#define MATERIAL(ID, INPUTS)                                                                                           \
    HEAD "def Scope \"Looks\" (kind = \"x\") {\n def Material \"m\" {\n"                                               \
         "  float inputs:wide = 0.25\n  token outputs:surface.connect = </Looks/m/s.outputs:out>\n"                    \
         "  token outputs:displacement\n  def Shader \"s\" {\n   uniform token info:id = \"" ID "\"\n   " INPUTS       \
         "\n   token outputs:out\n  }\n }\n}\n"
#define PREVIEW(INPUTS)  MATERIAL("UsdPreviewSurface", INPUTS)
#define STANDARD(INPUTS) MATERIAL("ND_standard_surface_surfaceshader", INPUTS)

static void check_key(const char *text, const char *key, size_t n, double r, double g, double b) {
    nqm_materials *materials = open_text(text);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    nqm_shading shading;
    if (!info.spec)
        fail_msg("%s: %s", text, info.refusal);
    assert_int_equal(nqm_shading_parse(info.spec, &shading, NULL), NQM_OK);
    const nqm_property *p = nqm_shading_find(&shading, key);
    assert_non_null(p);
    assert_int_equal(p->n, n);
    assert_true(p->v[0] == r && p->v[1] == g && p->v[2] == b);
    assert_string_equal(info.name, "m");
    nqm_materials_free(materials);
}

TEST(constants_are_keys) {
    check_key(PREVIEW("color3f inputs:diffuseColor = (0.5, 0.25, 1) (doc = \"(\")"), "diffuseColor", 3, 0.5, 0.25, 1);
    check_key(PREVIEW("# float inputs:roughness = 1\n float inputs:roughness = .75 # more"), "roughness", 1, .75, .75,
              .75);
    check_key(PREVIEW("custom float inputs:roughness.connect = </Looks/m.inputs:wide>"), "roughness", 1, .25, .25, .25);
    check_key(PREVIEW("float inputs:roughness"), "roughness", 1, .5, .5, .5); /* declared, without a value */
    check_key(PREVIEW("int inputs:useSpecularWorkflow = 1;token inputs:opacityMode = 'x'"), "useSpecularWorkflow", 1, 1,
              1, 1);
    check_key(STANDARD("color3f inputs:base_color = (1, 0, 0)\n float inputs:thin_film_thickness = 300"),
              "thin_film_thickness", 1, 300, 300, 300);
    check_key(MATERIAL("ND_open_pbr_surface_surfaceshader", "float inputs:coat_weight = 0.5"), "coat_weight", 1, .5, .5,
              .5);
    check_key(MATERIAL("ND_gltf_pbr_surfaceshader", ""), "iridescence_thickness", 1, 100, 100, 100);
    check_key(MATERIAL("ND_standard_surface_surfaceshader_100", ""), "base", 1, .8, .8, .8);
}

TEST(other_prims_are_skipped) {
    check_key(HEAD "over \"x\" { }\ndef Mesh \"a\" (prepend references = @b.usda@</B>) {\n"
                   " float3[] extent = [(-1, -1, 0), (1, 1, 0)]\n rel material:binding = </M>\n"
                   " float x.timeSamples = { 0: 1, 1: 2 }\n reorder nameChildren = [\"b\"]\n"
                   " variantSet \"v\" = { \"a\" (doc = \"{\") { def Material \"hidden\" { } } \"b\" { } }\n"
                   " add rel r\n def Xform \"b\" { } }\n"
                   "def Material \"m\" {\n token outputs:surface.connect = </m/p.outputs:surface>\n"
                   " token outputs:mtlx:surface.connect = </m/s.outputs:surface>\n"
                   " def Shader \"p\" { uniform token info:id = \"UsdPreviewSurface\" token outputs:surface }\n"
                   " def Shader \"s\" { uniform token info:id = \"ND_disney_principled\" token outputs:surface } }\n",
              "specularTint", 1, 0, 0, 0);
}

TEST(graphs_are_computed) {
    check_key(HEAD
              "def Material \"m\" { token outputs:surface.connect = </m/s.outputs:out>\n"
              "def Shader \"s\" { uniform token info:id = \"ND_standard_surface_surfaceshader\"\n"
              "color3f inputs:base_color.connect = </m/g.outputs:c> token outputs:out }\n"
              "def NodeGraph \"g\" { color3f inputs:c = (1, 2, 4) color3f outputs:c.connect = </m/g/x.outputs:out>\n"
              "def Shader \"x\" { uniform token info:id = \"ND_multiply_color3FA\" float inputs:in2 = 0.25\n"
              "color3f inputs:in1.connect = </m/g.inputs:c> color3f outputs:out } } }",
              "base_color", 3, .25, .5, 1);
}

#define TEXTURE(INPUT)                                                                                                 \
    HEAD "def Material \"m\" { token outputs:surface.connect = </m/s.outputs:out>\n"                                   \
         "def Shader \"s\" { uniform token info:id = \"UsdPreviewSurface\"\n"                                          \
         "color3f inputs:diffuseColor.connect = </m/t.outputs:rgb> token outputs:out }\n"                              \
         "def Shader \"t\" { uniform token info:id = \"UsdUVTexture\" asset inputs:file = " INPUT "\n"                 \
         "float2 inputs:st.connect = </m/u.outputs:result>\n float3 outputs:rgb float outputs:r }\n"                   \
         "def Shader \"u\" { uniform token info:id = \"UsdPrimvarReader_float2\"\n"                                    \
         "string inputs:varname = \"st\" float2 outputs:result } }"

TEST(maps_have_their_colour_space) {
    static const char *const cases[][2] = {
        {TEXTURE("@./a.png@ token inputs:sourceColorSpace = \"raw\""), "image(./a.png repeat)"},
        {TEXTURE("@./a.png@ token inputs:sourceColorSpace = \"auto\""), "image(./a.png srgb_texture repeat)"},
        {TEXTURE("@@@./a.png@@@"), "image(./a.png srgb_texture repeat)"},
        {TEXTURE("@./a.png@ (colorSpace = \"raw\")"), "image(./a.png none repeat)"},
        {TEXTURE("@./a.exr@"), "image(./a.exr none repeat)"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        expect_map(cases[i][0], 0, "diffuseColor reads the texture of node '/m/t'", "diffuseColor", cases[i][1]);
}

TEST(damaged_files) {
    static const char whole[] = PREVIEW("color3f inputs:diffuseColor = (0.5, 0.25, 1) asset inputs:a = @x@");
    for (size_t n = 6; n < sizeof whole - 1; ++n) { /* cut anywhere */
        const nqm_map map = {.data = (const unsigned char *)whole, .n_bytes = n, .path = "cut.usda"};
        nqm_materials *materials;
        nqm_error err = {0};
        if (nqm_materials_read(&map, &materials, &err) == NQM_OK)
            nqm_materials_free(materials);
        else
            assert_true(err.byte_offset >= 0 && (size_t)err.byte_offset <= n);
    }
    expect_survives_no_memory(whole);
}

TEST(binary_files_are_named) {
    expect_error("PXR-USDC\1\2", NQM_ERR_FORMAT, "usdcat IN.usdc -o OUT.usda");
    static const unsigned char zip[] = "PK\3\4\n\0\0\0\0\0!\0!\0\0\0\0\0\0\0\0\0\0\0\0\0\6\0\0\0a.usdc";
    const nqm_map map = {.data = zip, .n_bytes = sizeof zip - 1, .path = "a.usdz"};
    nqm_materials *materials;
    nqm_error err = {0};
    assert_int_equal(nqm_materials_read(&map, &materials, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "unzip"));
}

TEST_FILE(make_temp_file, remove_temp_file)
