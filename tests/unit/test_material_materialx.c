/* SPDX-License-Identifier: MIT
 *
 * MaterialX files: constants however they are connected, colour spaces, refusals, and round trips of what is written.
 */
#include "brdf/brdf.h"
#include "material/color_space.h"
#include "material/material.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/rows.h"

static nqm_status read_text(const char *text, nqm_materials **materials, nqm_error *err) {
    const nqm_map map = {.data = (const unsigned char *)text, .n_bytes = strlen(text), .path = "test.mtlx"};
    return nqm_materials_read(&map, materials, err);
}

/* A document with a material M of standard_surface with these inputs, and other elements of the root. */
static const char *document(const char *attributes, const char *inputs, const char *others) {
    static char text[4000];
    snprintf(text, sizeof text,
             "<?xml version=\"1.0\"?><materialx version=\"1.39\"%s>%s<standard_surface name=\"S\" "
             "type=\"surfaceshader\">%s</standard_surface><surfacematerial name=\"M\" type=\"material\"><input "
             "name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/></surfacematerial></materialx>",
             attributes, others, inputs);
    return text;
}

/* The value of a key of the only material, which must be accepted. */
static nqm_property value_of(const char *text, const char *key) {
    nqm_materials *materials;
    nqm_error err = {0};
    nqm_shading shading;
    if (read_text(text, &materials, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_int_equal(nqm_materials_count(materials), 1);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    if (info.refusal)
        fail_msg("%s", info.refusal);
    assert_string_equal(info.name, "M");
    assert_string_equal(info.surface, "standard_surface");
    nqm_brdf_free(must_open(info.spec));
    assert_int_equal(nqm_shading_parse(info.spec, &shading, NULL), NQM_OK);
    const nqm_property *property = nqm_shading_find(&shading, key);
    assert_non_null(property);
    const nqm_property copy = *property;
    nqm_materials_free(materials);
    return copy;
}

TEST(constants) {
    const char *red = "<input name=\"base_color\" type=\"color3\" value=\"1, .5,0\"/>";
    const nqm_property color = value_of(document("", red, ""), "base_color");
    assert_true(color.n == 3 && color.v[0] == 1 && color.v[1] == 0.5 && color.v[2] == 0);
    assert_true(value_of(document("", red, ""), "specular_roughness").v[0] == 0.2);
    assert_true(value_of(document("", "<input name=\"coat\" type=\"float\"/>", ""), "coat").v[0] == 0);

    /* shader <- output of a graph <- dot <- constant <- input of the graph <- node of the root */
    const char *inputs = "<input name=\"metalness\" type=\"float\" nodegraph=\"G\" output=\"o\"/>";
    const char *graph =
        "<nodegraph name=\"G\"><input name=\"i\" type=\"float\" nodename=\"C\"/><constant name=\"c\" "
        "type=\"float\"><input "
        "name=\"value\" type=\"float\" interfacename=\"i\"/></constant><dot name=\"d\" type=\"float\"><input "
        "name=\"in\" "
        "type=\"float\" nodename=\"c\"/></dot><output name=\"o\" type=\"float\" nodename=\"d\"/></nodegraph><constant "
        "name=\"C\" type=\"float\"><input name=\"value\" type=\"float\" value=\"0.75\"/></constant>";
    assert_true(value_of(document("", inputs, graph), "metalness").v[0] == 0.75);

    const char *neutral =
        "<input name=\"transmission\" type=\"float\" value=\"0\"/><input name=\"transmission_color\" type=\"color3\" "
        "nodename=\"nowhere\"/><input name=\"opacity\" type=\"color3\" value=\"1,1,1\"/><input name=\"tangent\" "
        "type=\"vector3\" nodename=\"nowhere\"/><input name=\"normal\" type=\"vector3\" value=\"0, 0, 1\"/>";
    value_of(document("", neutral, ""), "base");
    const char *brushed =
        "<input name=\"coat_anisotropy\" type=\"float\" value=\".5\"/><input name=\"specular_rotation\" "
        "type=\"float\" value=\"-.25\"/>";
    assert_true(value_of(document("", brushed, ""), "coat_anisotropy").v[0] == 0.5);
    assert_true(value_of(document("", brushed, ""), "specular_rotation").v[0] == -0.25);
}

TEST(color_spaces) {
    const char *grey = "<input name=\"base_color\" type=\"color3\" value=\".5,.5,.5\"/>";
    const char *own = "<input name=\"base_color\" type=\"color3\" value=\".5,.5,.5\" colorspace=\"g22_rec709\"/>";
    assert_near(value_of(document(" colorspace=\"srgb_texture\"", grey, ""), "base_color").v[1], 0.21404114, 1e-8);
    assert_near(value_of(document(" colorspace=\"srgb_texture\"", own, ""), "base_color").v[1], pow(0.5, 2.2), 1e-15);
    const char *untyped = "<input name=\"base_color\" value=\".5,.5,.5\"/>";
    assert_near(value_of(document(" colorspace=\"srgb_texture\"", untyped, ""), "base_color").v[1], 0.21404114, 1e-8);
    static const char *const spaces[] = {"acescg", "lin_displayp3", "lin_adobergb", "lin_rec709"};
    for (size_t i = 0; i < 4; ++i) {
        double rgb[3] = {0.5, 0.5, 0.5};
        assert_true(nqm_color_to_rec709(spaces[i], rgb));
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], 0.5, 1e-7); /* white stays white */
    }
    /* the space is that of the element that has the value */
    const char *far = "<input name=\"base_color\" type=\"color3\" nodename=\"c\"/>";
    const char *constant = "<constant name=\"c\" type=\"color3\"><input name=\"value\" type=\"color3\" "
                           "value=\".5,.5,.5\" colorspace=\"g18_rec709\"/></constant>";
    assert_near(value_of(document("", far, constant), "base_color").v[1], pow(0.5, 1.8), 1e-15);
    /* rounding below 0 becomes 0 */
    const char *edge = "<input name=\"base_color\" type=\"color3\" value=\".5,-.0009,.5\"/>";
    assert_true(value_of(document("", edge, ""), "base_color").v[1] == 0);
    double rgb[3] = {1, 0, 0};
    assert_false(nqm_color_to_rec709("lin_unknown", rgb));
    for (double v = 0; v <= 1; v += 0.01) {
        const double linear = nqm_srgb_to_linear(v);
        assert_near(linear <= 0.0031308 ? linear * 12.92 : 1.055 * pow(linear, 1 / 2.4) - 0.055, v, 1e-7);
    }
}

/* Without a surfacematerial, the shaders are the materials; version 1.0.0 of standard_surface has other defaults. */
TEST(lone_shaders) {
    nqm_materials *materials;
    assert_int_equal(
        read_text("<materialx><gltf_pbr name=\"a\"/><standard_surface name=\"b\" version=\"1.0.0\"/></materialx>",
                  &materials, NULL),
        NQM_OK);
    assert_int_equal(nqm_materials_count(materials), 2);
    assert_string_equal(nqm_materials_get(materials, 0).surface, "gltf_pbr");
    assert_non_null(strstr(nqm_materials_get(materials, 1).spec, "base=0.8;base_color=1,1,1;"));
    nqm_materials_free(materials);
    assert_int_equal(read_text("<materialx><open_pbr_surface name=\"c\"><input name=\"specular_ior\" type=\"float\" "
                               "value=\"0\"/></open_pbr_surface></materialx>",
                               &materials, NULL),
                     NQM_OK);
    assert_non_null(strstr(nqm_materials_get(materials, 0).refusal, "an index of refraction is above 0"));
    nqm_materials_free(materials);
}

TEST(round_trips) {
    char path[] = "/tmp/nqm_XXXXXX.mtlx", argument[64];
    const int fd = mkstemps(path, 5);
    assert_true(fd >= 0);
    close(fd);
    EVERY_ROW(row, "round trips of MaterialX") {
        nqm_brdf *before = must_open(row[0]);
        nqm_error err = {0};
        if (nqm_material_write(nqm_brdf_get_info(before).spec, "Gold leaf", path, &err) != NQM_OK)
            fail_msg("%s", err.message);
        snprintf(argument, sizeof argument, "%s:Gold_leaf", path);
        nqm_brdf *after = must_open(argument);
        assert_string_equal(nqm_brdf_get_info(after).spec, nqm_brdf_get_info(before).spec);
        nqm_brdf_free(before);
        nqm_brdf_free(after);
    }
    unlink(path);
}

/* Every allocation of a reading fails once: no crash, no leak (under ASan), nothing returned. */
TEST(memory_runs_out) {
    const char *red = "<input name=\"base_color\" type=\"color3\" value=\"1, .5,0\"/>";
    nqm_materials *materials = NULL;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_error err = {0};
        status = read_text(document("", red, ""), &materials, &err);
        assert_true(status == NQM_OK || (!materials && err.message[0]));
    }
    assert_true(n >= 5);
    nqm_materials_free(materials);
}
