/* SPDX-License-Identifier: MIT
 *
 * pbrt-v4 scenes: what is read, what is refused and why, what is damaged, and files written and read back.
 */
#include "material/mitsuba.h"
#include "support/check.h"
#include "support/map_text.h"
#include "support/material_text.h"
#include "support/temp_file.h"

#define COPPER "eta=0.200437697,0.9240334304,1.1022119527;k=3.9129485033,2.4528477015,2.1421879552"

TEST(coats) {
    expect_same("pbrt-coated-diffuse:roughness=.123;reflectance=.1,.2,.3;eta=1.4;thickness=.02;maxdepth=7", "pbrt");
}

TEST(coated_conductors) {
    expect_same("pbrt-coated-conductor:interface.roughness=.123;interface.eta=1.4;conductor.roughness=0;"
                "conductor.eta=.1,.2,.3;conductor.k=3;thickness=.02;maxdepth=7",
                "pbrt");
}

TEST(scenes) {
    nqm_materials *materials =
        open_text("LookAt 0 0 5 0 0 0 0 1 0\nColorSpace \"srgb\"\nWorldBegin\nAttribute \"shape\" \"float radius\" 1\n"
                  "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [ .1 .2 .3 ]\n"
                  "Material \"diffuse\"\nShape \"sphere\" \"float radius\" [ 2 ] \"string name\" \"Material\"\n"
                  "MakeNamedMaterial \"b\" \"string filename\" [ \"x y.bsdf\" ] \"string type\" [ \"measured\" ]\n");
    static const char *const expected[][2] = {
        {"a", "lambert:kd=0.1,0.2,0.3"}, {"material2", "lambert:kd=0.5,0.5,0.5"}, {"b", "x y.bsdf"}};
    assert_int_equal(nqm_materials_count(materials), 3);
    for (size_t i = 0; i < 3; ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        assert_string_equal(info.name, expected[i][0]);
        assert_string_equal(info.spec, expected[i][1]);
        assert_true(info.byte_offset > 80);
    }
    nqm_materials_free(materials);
}

#define IMAGE(NAME, TYPE, FILE, MORE)                                                                                  \
    "Texture \"" NAME "\" \"" TYPE "\" \"imagemap\" \"string filename\" \"" FILE "\" " MORE " "
#define DIFFUSE "Material \"diffuse\" \"texture reflectance\" \"t\" "
#define ROUGH   "Material \"conductor\" \"texture roughness\" \"t\" "

TEST(colour_textures) {
    static const char a[] = "minimum(maximum(image(a.png srgb_texture repeat), 0), 1)";
    expect_map(IMAGE("t", "spectrum", "a.png", "") DIFFUSE, 0, "reflectance is of type 'texture'", "kd", a);
    expect_map(IMAGE("t", "float", "b.png", "") IMAGE("t", "spectrum", "a.png", "") DIFFUSE, 0, "", "kd", a);
    expect_map(IMAGE("t", "spectrum", "a.png", "\"string encoding\" \"linear\" \"string wrap\" \"black\"") DIFFUSE, 0,
               "", "kd", "minimum(maximum(image(a.png border), 0), 1)");
    expect_map(IMAGE("t", "spectrum", "a.jpg", "\"string encoding\" \"linear\" \"string wrap\" \"clamp\"") DIFFUSE, 0,
               "", "kd", "minimum(maximum(image(a.jpg srgb_texture clamp), 0), 1)"); /* as pbrt */
    expect_map(IMAGE("t", "spectrum", "a.exr", "\"string encoding\" \"sRGB\"") DIFFUSE, 0, "", "kd",
               "minimum(maximum(image(a.exr repeat), 0), 1)");
    expect_map(IMAGE("t", "spectrum", "a.png",
                     "\"string encoding\" \"gamma 2.5\" \"float scale\" 2 \"bool invert\" true") DIFFUSE,
               0, "", "kd",
               "minimum(maximum(maximum(subtract(1, multiply(power(image(a.png repeat), 2.5), 2)), 0), 0), 1)");
    expect_map(
        IMAGE("t", "spectrum", "a.png", "") "Material \"conductor\" \"float roughness\" .1 \"texture eta\" \"t\"", 0,
        "eta is", "eta", "image(a.png srgb_texture repeat)");
    expect_map(IMAGE("t", "spectrum", "a.exr",
                     "") "Material \"conductor\" \"float roughness\" .1 \"texture reflectance\" \"t\"",
               0, "reflectance is", "k",
               "multiply(power(divide(minimum(maximum(image(a.exr repeat), 0), 0.9999), subtract(1, "
               "minimum(maximum(image(a.exr repeat), 0), 0.9999))), 0.5), 2)");
    expect_map("Material \"diffuse\" \"string normalmap\" \"n.png\"", 0, "normalmap", "normal",
               "normal(image(n.png repeat), 1)");
}

#define MEAN                                                                                                           \
    "multiply(add(add(channel(image(r.exr repeat) 0), channel(image(r.exr repeat) 1)), channel(image(r.exr repeat) "   \
    "2)), 0.3333333333333333)"

TEST(roughness_textures) {
    expect_map(IMAGE("t", "float", "r.exr", "") ROUGH, 0, "roughness is", "roughness", "maximum(" MEAN ", 1e-06)");
    expect_map(IMAGE("t", "float", "r.exr", "") ROUGH "\"bool remaproughness\" false", 0, "roughness is", "roughness",
               "maximum(multiply(" MEAN ", " MEAN "), 1e-06)");
    expect_map(IMAGE("t", "float", "r.exr", "") "Material \"coatedconductor\" \"texture conductor.roughness\" \"t\"", 0,
               "conductor.roughness is", "conductor.roughness", MEAN);
    expect_map(IMAGE("t", "float", "r.exr", "") ROUGH "\"float vroughness\" .2", 0, "roughness is", "roughness",
               "maximum(combine(" MEAN ", 0.2), 1e-06)");
}

TEST(computed_textures) {
    expect_map(IMAGE("a", "spectrum", "a.exr", "")
                   IMAGE("r", "float", "r.exr", "") "Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"a\" \"rgb "
                                                    "tex2\" [ .1 .2 .3 ] \"texture amount\" "
                                                    "\"r\" " DIFFUSE,
               0, "", "kd", "minimum(maximum(mix(image(a.exr repeat), 0.1 0.2 0.3, " MEAN "), 0), 1)");
    expect_map(IMAGE("a", "spectrum", "a.exr",
                     "") "Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"float scale\" .5 " DIFFUSE,
               0, "", "kd", "minimum(maximum(multiply(image(a.exr repeat), 0.5), 0), 1)");
}

/* Textures that name the one before twice: 2^40 paths. */
TEST(nested_textures) {
    char text[8000] = "Texture \"t0\" \"spectrum\" \"constant\" ";
    for (int i = 1; i <= 40; ++i)
        snprintf(text + strlen(text), sizeof text - strlen(text),
                 "Texture \"t%d\" \"spectrum\" \"mix\" \"texture tex1\" \"t%d\" \"texture tex2\" \"t%d\" ", i, i - 1,
                 i - 1);
    strcat(text, "Material \"diffuse\" \"texture reflectance\" \"t40\"");
    expect_refusal(text, "more than 256 textures");
}

/* src/pbrt/textures.cpp: st = (uscale u + udelta, vscale v + vdelta), then t = 1 - t, from the first row; pbrt's v is 1 - that of
 * nqm. */
TEST(corners_of_images) {
    static const char plain[] = IMAGE("t", "spectrum", "a.png", "") DIFFUSE;
    expect_position(plain, 0, 1, 0, 1); /* pbrt's (0, 0): the lower left corner */
    expect_position(plain, 1, 0, 1, 0); /* (1, 1): the upper right one */
    static const char moved[] =
        IMAGE("t", "spectrum", "a.png",
              "\"float uscale\" 2 \"float udelta\" .25 \"float vscale\" 3 \"float vdelta\" .125") DIFFUSE;
    expect_position(moved, 0, 1, 0.25, 0.875);
    expect_position(moved, 1, 0, 2.25, -2.125);
}

TEST(files_go_there_and_back) {
    expect_same("pbrt-conductor:roughness=0.123456789012345;eta=.1,.2,.3;k=3.3333333333333335,2,1e-17", "pbrt");
    expect_same("pbrt-conductor:roughness=1e-6;eta=1;k=200", "pbrt");
    expect_same("pbrt-conductor:roughness=.1,.333333333333333333;eta=1;k=2", "pbrt");
    expect_same("lambert:kd=0.1,0.30000000000000004,1", "pbrt");
    expect_same("lambert:kd=0.5", "pbrt");
}

TEST(no_memory) {
    expect_survives_no_memory(IMAGE("t", "float", "a.png", "") ROUGH
                              "\"rgb reflectance\" [ .1 .1 .1 ] \"string normalmap\" \"n.png\"");
    expect_survives_no_memory(
        "Material \"conductor\" \"float roughness\" 1 Material \"measured\" \"string filename\" \"a\" "
        "Material \"mix\"");
}

TEST_FILE(make_temp_file, remove_temp_file)
