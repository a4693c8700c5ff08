/* SPDX-License-Identifier: MIT
 *
 * Values and their specs, and the errors of material files of any format.
 */
#include "brdf/brdf.h"
#include "material/maps.h"
#include "schema/models.h"
#include "support/check.h"
#include "support/material_text.h"
#include "support/scratch.h"

#include <stdarg.h>

TEST(specs_go_there_and_back) {
    const char *text = "rough-conductor:k=1,1,.5;alpha=.1,.3;eta=2";
    nqm_values values;
    assert_int_equal(nqm_values_parse_spec(text, &values, NULL), NQM_OK);
    assert_ptr_equal(values.schema, &nqm_rough_conductor_schema);
    assert_near(nqm_values_given(&values, "eta")[2], 2, 0);
    assert_null(nqm_values_given(&values, "distribution"));
    assert_near(values.v[nqm_schema_key_named(values.schema, "specular_reflectance", 20)][1], 1, 0);
    char *spec = nqm_values_spec(&values);
    assert_string_equal(spec, "rough-conductor:alpha=0.1,0.3;eta=2;k=1,1,0.5");
    nqm_free(spec);
}

TEST(other_texts_are_refused) {
    static const char *const texts[] = {"",
                                        "gltf",
                                        "gltf:ior",
                                        "gltf:ior=",
                                        "gltf:ior=1,",
                                        "gltf:ior=x",
                                        "gltf:=",
                                        "gltf:ior=1 b",
                                        "gltf:base_color=1,1,1,1",
                                        "gltf:base_color=1,1",
                                        "gltf:ior=1;ior=1",
                                        "no-model:a=1",
                                        "pbrt-conductor:k=1"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        nqm_values values;
        nqm_error err;
        assert_int_equal(nqm_values_parse_spec(texts[i], &values, &err), NQM_ERR_ARG);
    }
}

TEST(files_without_a_format_are_refused) {
    nqm_materials *materials;
    nqm_error err;
    assert_int_equal(nqm_materials_open("/dev/null/no", &materials, &err), NQM_ERR_IO);
    assert_null(materials);
    assert_int_equal(nqm_material_write("no-such-model:a=1", "name", "x.unknown", &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "no-such-model"));
}

/* pbrt refuses numbers of the other type. */
TEST(pbrt_files_have_the_types_of_pbrt) {
    static const char spec[] = "pbrt-coated-diffuse:roughness=0.3;reflectance=0.5;eta=1.5;thickness=0.02;maxdepth=7";
    const char *path = scratch_text("coated.pbrt", "");
    nqm_map map = {0};
    assert_int_equal(nqm_material_write(spec, "m", path, NULL), NQM_OK);
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    assert_true(nqm_material_probe_text(&map, map.n_bytes, "\"integer maxdepth\" [ 7 ]"));
    assert_true(nqm_material_probe_text(&map, map.n_bytes, "\"float thickness\" [ 0.02 ]"));
    nqm_map_close(&map);
}

TEST(files_of_usd_that_are_no_text_are_named) {
    static const char binary[] = "PXR-USDC\1\2",
                      zip[] = "PK\3\4\n\0\0\0\0\0!\0!\0\0\0\0\0\0\0\0\0\0\0\0\0\6\0\0\0a.usdc";
    refuse_bytes("a.usdc", binary, sizeof binary - 1, NQM_ERR_FORMAT, 0, "usdcat IN.usdc -o OUT.usda");
    refuse_bytes("a.usdz", zip, sizeof zip - 1, NQM_ERR_FORMAT, -1, "unzip");
}

TEST(deep_files_are_refused) {
    char deep[1200] = "";
    for (int i = 0; i < 100; ++i)
        strcat(deep, "<scene>");
    refuse_bytes("x.xml", deep, strlen(deep), NQM_ERR_LIMIT, -1, "nested");
}

/* A text that is made piece by piece. */
typedef struct pieces {
    size_t n;
    char text[1 << 20];
} pieces;

__attribute__((format(printf, 2, 3))) static void add(pieces *p, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int n = vsnprintf(p->text + p->n, sizeof p->text - p->n, format, arguments);
    va_end(arguments);
    assert_true(n >= 0 && (size_t)n < sizeof p->text - p->n);
    p->n += (size_t)n;
}

/* 200 materials share a graph of 60 images, whose names have 4,000 characters: 94 MB of copies for a file of .3 MB. */
TEST(maps_of_a_file_have_a_limit) {
    enum { N_IMAGES = 60, N_NAME = 4000, N_MATERIALS = 200 };
    pieces *p = calloc(1, sizeof *p);
    nqm_materials *materials = NULL;
    size_t n_maps = 0;
    assert_non_null(p);
    add(p, "<materialx version='1.39'><constant name='n0' type='float'><input name='value' type='float' "
           "value='1'/></constant>");
    for (int i = 1; i <= N_IMAGES; ++i)
        add(p,
            "<image name='i%d' type='float'><input name='file' type='filename' value='%0*d'/></image><add name='n%d' "
            "type='float'><input name='in1' type='float' nodename='i%d'/><input name='in2' type='float' "
            "nodename='n%d'/></add>",
            i, N_NAME, i, i, i, i - 1);
    for (int i = 0; i < N_MATERIALS; ++i)
        add(p,
            "<standard_surface name='s%d' type='surfaceshader'><input name='base' type='float' "
            "nodename='n%d'/></standard_surface>",
            i, N_IMAGES);
    add(p, "</materialx>");
    const nqm_map map = {.data = (const unsigned char *)p->text, .n_bytes = p->n, .path = "x.mtlx"};
    assert_int_equal(nqm_materials_read(&map, &materials, NULL), NQM_OK);
    while (n_maps < N_MATERIALS && nqm_materials_maps(materials, n_maps, 0))
        ++n_maps;
    assert_in_range(n_maps, 128, N_MATERIALS - 1);
    for (size_t i = n_maps; i < N_MATERIALS; ++i)
        assert_non_null(strstr(nqm_materials_get(materials, i).refusal, "more memory than a file of this size may"));
    nqm_materials_free(materials);
    free(p);
}

/* Classes with two copies each of the one before; classes that each inherit the next. */
TEST(composition_of_usd_has_limits) {
    pieces *p = calloc(1, sizeof *p);
    assert_non_null(p);
    add(p, "#usda 1.0\nclass \"c0\" { def Shader \"s\" { } }\n");
    for (int i = 1; i <= 40; ++i)
        add(p, "class \"c%d\" { def \"a\" (inherits = </c%d>) { } def \"b\" (inherits = </c%d>) { } }\n", i, i - 1,
            i - 1);
    refuse_bytes("x.usda", p->text, p->n, NQM_ERR_LIMIT, -1, "more than");
    p->n = 0;
    add(p, "#usda 1.0\n");
    for (int i = 0; i <= 200; ++i)
        add(p, "class \"c%d\" (inherits = </c%d>) { }\n", i, i + 1);
    refuse_bytes("x.usda", p->text, p->n, NQM_ERR_FORMAT, -1, "nested too deeply");
    free(p);
}
