/* SPDX-License-Identifier: MIT
 *
 * Mitsuba 3 scenes in XML and JSON: what is read, what is refused and why, what is damaged, and files written and read back.
 */
#include "material/mitsuba.h"
#include "support/check.h"
#include "support/map_text.h"
#include "support/material_text.h"
#include "support/rows.h"
#include "support/temp_file.h"

#define XML(TYPE, PROPERTIES) "<bsdf type=\"" TYPE "\">" PROPERTIES "</bsdf>"
#define FLOAT(NAME, VALUE)    "<float name=\"" NAME "\" value=\"" VALUE "\"/>"
#define STRING(NAME, VALUE)   "<string name=\"" NAME "\" value=\"" VALUE "\"/>"
#define RGB(NAME, VALUE)      "<rgb name=\"" NAME "\" value=\"" VALUE "\"/>"

/* Mitsuba's include/mitsuba/render/ior.h. */
TEST(named_indices) {
    char text[300], spec[80], number[32];
    EVERY_ROW(row, "refractive indices of Mitsuba") {
        snprintf(text, sizeof text, XML("roughplastic", STRING("ext_ior", "%s") FLOAT("int_ior", "2.5")), row[0]);
        snprintf(spec, sizeof spec, "rough-plastic:eta=%s",
                 nqm_format_double(number, sizeof number, 2.5 / atof(row[1])));
        if (atof(row[1]) < 2)
            expect_spec(text, spec);
        snprintf(text, sizeof text, XML("roughplastic", STRING("int_ior", "%s")), row[0]);
        snprintf(spec, sizeof spec, "rough-plastic:eta=%s",
                 nqm_format_double(number, sizeof number, atof(row[1]) / 1.000277)); /* in air */
        if (atof(row[1]) > 1.1)
            expect_spec(text, spec);
    }
}

/* Sums over the indices of the renderer Tungsten (src/core/bsdfs/ComplexIorData.hpp; negative ones are 0) with weights by name and
 * channel: a wrong digit changes one of them. */
TEST(metals_are_those_of_their_source) {
    char names[300], *save = NULL;
    double eta = 0, k = 0;
    size_t n = 0;
    nqm_metal_names(names, sizeof names);
    assert_string_equal(strtok_r(names, ", ", &save), "none");
    for (const char *name; (name = strtok_r(NULL, ", ", &save)); ++n)
        for (size_t c = 0; c < 3; ++c) {
            const double weight = (double)((size_t)name[0] + 256 * (size_t)name[1] + 1000 * strlen(name) + c);
            eta += weight * nqm_metal_find(name)->eta[c];
            k += weight * nqm_metal_find(name)->k[c];
        }
    assert_int_equal(n, 32);
    assert_near(eta, 5454669.317148253, 1e-5);
    assert_near(k, 6442084.853825048, 1e-5);
    assert_ptr_equal(nqm_metal_find("Au_palik"), nqm_metal_find("Au"));
    assert_ptr_not_equal(nqm_metal_find("Cu_palik"), nqm_metal_find("Cu"));
}

TEST(scenes) {
    nqm_materials *materials = open_text(
        "<?xml version=\"1.0\"?>\n<!-- > -->\n<scene version=\"3.0.0\">\n"
        "<default name=\"grey\" value=\"0.25\"/><integrator type=\"path\"><integer name=\"max_depth\" "
        "value=\"8\"/></integrator>\n"
        "<bsdf type=\"diffuse\" id=\"wall\"><float name=\"reflectance\" value=\"$grey\"/></bsdf>\n"
        "<bsdf type=\"twosided\" id=\"sheet\"><ref id=\"wall\"/></bsdf>\n"
        "<bsdf type=\"twosided\"><bsdf type=\"diffuse\" id=\"inner\"/></bsdf>\n"
        "<shape type=\"sphere\"><ref id=\"wall\"/></shape>\n"
        "<shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape>\n"
        "<bsdf type=\"twosided\" id=\"lost\"><ref id=\"nothing\"/></bsdf>\n"
        "<bsdf type=\"twosided\" id=\"two\"><ref id=\"wall\"/><bsdf type=\"diffuse\"/></bsdf>\n"
        "<bsdf type=\"measured\" id=\"file\"><string name=\"filename\" value=\"a b.bsdf\"/></bsdf>\n</scene>\n");
    static const char *const expected[][3] = {{"wall", "diffuse", "lambert:kd=0.25"},
                                              {"sheet", "diffuse", "lambert:kd=0.25"},
                                              {"inner", "diffuse", "lambert:kd=0.5"},
                                              {"material4", "diffuse", "lambert:kd=0.5"},
                                              {"lost", "twosided", NULL},
                                              {"two", "twosided", NULL},
                                              {"file", "measured", "a b.bsdf"}};
    assert_int_equal(nqm_materials_count(materials), sizeof expected / sizeof *expected);
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        assert_string_equal(info.name, expected[i][0]);
        assert_string_equal(info.surface, expected[i][1]);
        assert_true((info.spec == NULL) == (expected[i][2] == NULL));
        if (info.spec)
            assert_string_equal(info.spec, expected[i][2]);
        assert_true(info.byte_offset > 100);
    }
    nqm_materials_free(materials);
}

TEST(dictionaries) {
    expect_map("{\"type\": \"diffuse\", \"reflectance\": {\"type\": \"bitmap\", \"filename\": \"a.png\"}}", 0,
               "'bitmap'", "kd", "image(a.png srgb_texture repeat)");
    nqm_materials *materials = open_text(
        "{\"type\": \"scene\", \"i\": {\"type\": \"path\"}, \"a\": {\"type\": \"diffuse\"}, \"ball\": {\"type\": "
        "\"sphere\", \"b\": {\"type\": \"diffuse\"}}, \"c\": {\"type\": \"diffuse\", \"id\": \"d\"}, \"e\": "
        "{\"type\": \"twosided\", \"f\": {\"type\": \"ref\", \"id\": \"a\"}}}");
    static const char *const names[] = {"a", "ball", "d", "e"};
    assert_int_equal(nqm_materials_count(materials), 4);
    for (size_t i = 0; i < 4; ++i) {
        assert_string_equal(nqm_materials_get(materials, i).name, names[i]);
        assert_string_equal(nqm_materials_get(materials, i).spec, "lambert:kd=0.5");
    }
    nqm_materials_free(materials);
}

#define BITMAP(NAME, FILE, MORE)                                                                                       \
    "<texture type=\"bitmap\" name=\"" NAME "\">" STRING("filename", FILE) MORE "</texture>"
#define RAW          "<boolean name=\"raw\" value=\"true\"/>"
#define TO_UV(STEPS) "<transform name=\"to_uv\">" STEPS "</transform>"

TEST(textures_of_xml) {
    expect_map(XML("diffuse", BITMAP("reflectance", "a.png", "")), 0, "reflectance is of type 'bitmap'", "kd",
               "image(a.png srgb_texture repeat)");
    expect_map(XML("diffuse", BITMAP("reflectance", "a.png", STRING("wrap_mode", "mirror") RAW)), 0, "bitmap", "kd",
               "image(a.png mirror)");
    expect_map(XML("diffuse", BITMAP("reflectance", "a.EXR", STRING("wrap_mode", "clamp"))), 0, "bitmap", "kd",
               "image(a.EXR clamp)");
    static const char rough[] = XML("principled", BITMAP("roughness", "r.png", RAW) BITMAP("base_color", "c.jpg", ""));
    expect_map(rough, 0, "roughness is", "roughness", "luminance(image(r.png repeat))");
    expect_map(rough, 0, "roughness is", "base_color", "image(c.jpg srgb_texture repeat)");
    expect_map(XML("roughconductor", BITMAP("alpha", "r.png", RAW)), 0, "alpha is", "alpha",
               "maximum(luminance(image(r.png repeat)), 0.0001)");
    expect_map(XML("roughconductor", FLOAT("alpha_u", ".2") BITMAP("alpha_v", "r.png", RAW)), 0, "alpha_v is", "alpha",
               "maximum(combine(0.2, luminance(image(r.png repeat))), 0.0001)");
    expect_map(XML("roughconductor", FLOAT("alpha_v", "0") BITMAP("alpha_u", "r.png", RAW)), 0, "alpha_u is", "alpha",
               "maximum(combine(luminance(image(r.png repeat)), 0.0001), 0.0001)");
    static const char scene[] = "<scene>" BITMAP("", "no.png", "") "<texture type=\"bitmap\" id=\"t\">" STRING(
        "filename", "x/a.png") "</texture><bsdf type=\"twosided\" id=\"m\"><bsdf type=\"diffuse\"><ref "
                               "name=\"reflectance\" id=\"t\"/></bsdf></bsdf></scene>";
    expect_map(scene, 0, "refers to the object 't'", "kd", "image(x/a.png srgb_texture repeat)");
}

TEST(normal_maps_of_xml) {
    static const char normal[] = "normal(image(n.png repeat), 1)";
    expect_map(XML("normalmap", BITMAP("normalmap", "n.png", RAW) XML("diffuse", "")), 0, "combinations", "normal",
               normal);
    expect_map(XML("twosided", XML("normalmap", BITMAP("normalmap", "n.png", RAW) XML("diffuse", ""))), 0,
               "combinations", "normal", normal);
    expect_map(XML("normalmap", BITMAP("normalmap", "n.png", RAW) XML("twosided", XML("diffuse", ""))), 0,
               "combinations", "normal", normal);
    static const char scene[] =
        "<scene><bsdf type=\"normalmap\" id=\"a\"><ref name=\"normalmap\" id=\"t\"/><ref id=\"b\"/></bsdf>"
        "<bsdf type=\"diffuse\" id=\"b\"/><texture type=\"bitmap\" id=\"t\">" STRING("filename", "n.png") RAW
        "</texture></scene>";
    expect_map(scene, 0, "combinations", "normal", normal);
}

/* src/textures/bitmap.cpp: the position is to_uv (u, v), and v = 0 is in the first row. */
TEST(corners_of_bitmaps) {
    static const char plain[] = XML("diffuse", BITMAP("reflectance", "a.png", ""));
    expect_position(plain, 0, 0, 0, 0);
    expect_position(plain, 0.25, 1, 0.25, 1);
    expect_position(XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<scale x=\"2\" y=\"3\"/>"))), 1, 1, 2, 3);
    expect_position(XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<scale value=\"2\"/>"))), 1, 1, 2, 2);
    expect_position(XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<scale x=\"2\"/><translate y=\".5\"/>"))), 1,
                    1, 2, 1.5);
    expect_position(XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<translate x=\".5\"/><scale x=\"2\"/>"))), 1,
                    1, 3, 1);
    expect_position(XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<rotate z=\"1\" angle=\"90\"/>"))), 1, 0, 0,
                    1);
    expect_position(XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<rotate z=\"-1\" angle=\"90\"/>"))), 1, 0, 0,
                    -1);
    expect_position(
        XML("diffuse", BITMAP("reflectance", "a.png", TO_UV("<matrix value=\"1 2 0 3 4 5 0 6 0 0 1 0 0 0 0 1\"/>"))),
        10, 100, 213, 546);
}

TEST(textures_of_dictionaries) {
    static const char scene[] = "{\"type\": \"scene\", \"tex\": {\"type\": \"bitmap\", \"filename\": \"a.png\", "
                                "\"raw\": true}, \"m\": {\"type\": "
                                "\"diffuse\", \"reflectance\": {\"type\": \"ref\", \"id\": \"tex\"}}, \"n\": "
                                "{\"type\": \"normalmap\", \"normalmap\": "
                                "{\"type\": \"bitmap\", \"raw\": true, \"filename\": \"n.png\"}, \"inner\": {\"type\": "
                                "\"ref\", \"id\": \"m\"}}}";
    expect_map(scene, 0, "refers to", "kd", "image(a.png repeat)");
    expect_map(scene, 1, "combinations", "kd", "image(a.png repeat)");
    expect_map(scene, 1, "combinations", "normal", "normal(image(n.png repeat), 1)");
}

TEST(deep_files) {
    char deep[1200] = "";
    for (int i = 0; i < 100; ++i)
        strcat(deep, "<scene>");
    expect_error(deep, NQM_ERR_LIMIT, "nested");
}

/* Files that are cut anywhere are an error, never a shorter list. */
TEST(cut_files) {
    static const char text[] = "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"a\"><rgb name=\"reflectance\" "
                               "value=\"0.1 0.2 0.3\"/></bsdf></scene>";
    char cut[sizeof text];
    for (size_t n = 1; n + 1 < sizeof text; ++n) {
        memcpy(cut, text, n);
        cut[n] = 0;
        expect_error(cut, NQM_ERR_FORMAT, temp_file);
    }
}

TEST(files_go_there_and_back) {
    EVERY_ROW(row, "round trips of Mitsuba") {
        expect_same(row[0], "xml");
        expect_same(row[0], "json");
    }
}

TEST(no_memory) {
    expect_survives_no_memory(
        "<scene><default name=\"a\" value=\"1\"/><bsdf type=\"diffuse\" id=\"$a\"><float name=\"reflectance\" "
        "value=\"$a\"/></bsdf><bsdf type=\"mask\"/></scene>");
    expect_survives_no_memory(XML("mask", BITMAP("opacity", "a.png", RAW) XML("roughdielectric", "")));
    expect_survives_no_memory(XML("normalmap",
                                  BITMAP("normalmap", "n.png", RAW)
                                      XML("roughconductor", FLOAT("alpha_u", ".1") BITMAP("alpha_v", "a.png", ""))));
    expect_survives_no_memory(
        "{\"type\": \"scene\", \"a\": {\"type\": \"measured\", \"filename\": \"a\"}, \"b\": {\"type\": \"diffuse\"}}");
}

TEST_FILE(make_temp_file, remove_temp_file)
