/* SPDX-License-Identifier: MIT
 *
 * Shadings and their specs, and the errors of material files of any format.
 */
#include "brdf/brdf.h"
#include "material/material.h"
#include "support/check.h"
#include "support/material_text.h"

TEST(specs_go_there_and_back) {
    const char *text = "some-model:base_color=.25,.5,1;roughness=.1;metalness=0;base_color=1,1,.5;alpha=.1,.3";
    nqm_shading shading;
    assert_int_equal(nqm_shading_parse(text, &shading, NULL), NQM_OK);
    assert_string_equal(shading.model, "some-model");
    assert_int_equal(shading.n, 4);
    assert_int_equal(nqm_shading_find(&shading, "roughness")->n, 1);
    assert_null(nqm_shading_find(&shading, "rough"));
    char *spec = nqm_shading_spec(&shading);
    assert_string_equal(spec, "some-model:base_color=1,1,0.5;roughness=0.1;metalness=0;alpha=0.1,0.3");
    nqm_free(spec);
}

TEST(other_texts_are_refused) {
    static const char *const texts[] = {
        "",      "model", "m:a",     "m:a=",        "m:a=1,",
        "m:a=x", "m:=",   "m:a=1 b", "m:a=1,2,3,4", "a-model-with-a-name-that-is-too-long:a=1"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        nqm_shading shading;
        nqm_error err;
        assert_int_equal(nqm_shading_parse(texts[i], &shading, &err), NQM_ERR_ARG);
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
