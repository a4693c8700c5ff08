/* SPDX-License-Identifier: MIT
 *
 * MaterialX files with images and computed values: the value of each kind of node against NumPy, and positions in images. Other
 * textured materials are rows of vectors/materials.txt.
 */
#include "material/maps.h"
#include "support/check.h"
#include "support/material_text.h"

/* A document with a material M of standard_surface with these inputs, and other elements of the root. */
static nqm_materials *read_parts(const char *attributes, const char *inputs, const char *others) {
    static char text[8000];
    snprintf(text, sizeof text,
             "<?xml version='1.0'?><materialx version='1.39'%s>%s<standard_surface name='S' type='surfaceshader'>%s"
             "</standard_surface><surfacematerial name='M' type='material'><input name='surfaceshader' "
             "type='surfaceshader' nodename='S'/></surfacematerial></materialx>",
             attributes, others, inputs);
    return text_as_materials("folder/test.mtlx", text);
}

#define COLOR            "<input name='base_color' type='color3' nodename='n'/>"
#define ROUGHNESS        "<input name='specular_roughness' type='float' nodename='n'/>"
#define FILE_INPUT(NAME) "<input name='file' type='filename' value='" NAME "'/>"

/* The only material is textured, for this reason. */
static const nqm_textured *textured_of(const nqm_materials *materials, const char *why) {
    const nqm_material_info info = nqm_materials_get(materials, 0);
    const nqm_textured *t = nqm_materials_maps(materials, 0, 0);
    if (!t || !info.refusal || !strstr(info.refusal, why))
        fail_msg("'%s' instead of '%s'", info.refusal ? info.refusal : info.spec, why);
    return t;
}

static uint16_t output_of(const nqm_textured *t, const char *key) {
    size_t i = 0;
    while (i < t->n_outputs && strcmp(t->outputs[i].key, key) != 0)
        ++i;
    assert_true(i < t->n_outputs);
    return t->outputs[i].node;
}

TEST(values) {
    nqm_csv *csv;
    assert_int_equal(nqm_csv_load(test_vector("materialx_nodes.csv"), &csv, NULL), NQM_OK);
    assert_true(nqm_csv_rows(csv) > 190);
    for (size_t i = 0; i < nqm_csv_rows(csv); ++i) {
        const char *node = nqm_csv_text(csv, i, 0);
        nqm_materials *materials = read_parts("", COLOR, node);
        const nqm_material_info info = nqm_materials_get(materials, 0);
        double v[3]; /* beyond the range of the model, too */
        if (!info.spec)
            fail_msg("%s: %s", node, info.refusal);
        if (sscanf(strstr(info.spec, "base_color="), "base_color=%lf,%lf,%lf", &v[0], &v[1], &v[2]) == 1)
            v[1] = v[2] = v[0];
        for (size_t c = 0; c < 3; ++c)
            check_near(v[c], csv_number(csv, i, 1 + (int)c), 1e-12, node, __FILE__, __LINE__);
        nqm_materials_free(materials);
    }
    nqm_csv_free(csv);
}

/* Components beyond the last repeat it; what no node of MaterialX makes. */
TEST(single_nodes) {
    const double in[][4] = {{0.5, 0.25, 0.75, 0.75}, {-1, 2, 0, 0}, {0.5, 0.5, 0.5, 0.5}};
    double v[4];
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_ADD, .n = 2, .in = {0, 1}}, in, v);
    assert_true(v[0] == -0.5 && v[1] == 2.25 && v[2] == 2.25 && v[3] == 2.25);
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_LUMINANCE, .n = 3, .in = {0}}, in, v);
    assert_near(v[0], 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722 * 0.75, 1e-15);
    assert_true(v[2] == v[0]);
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_POWER, .n = 1, .in = {1, 0}}, in, v);
    assert_true(v[0] == 0); /* of a number below 0 */
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_ANGLE, .n = 1, .in = {0, 1}}, in, v);
    assert_near(v[0], atan2(0.5, -1), 1e-15);
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_CHANNEL, .n = 1, .in = {0}, .v = {2}}, in, v);
    assert_true(v[0] == 0.75 && v[3] == 0.75);
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_NORMAL, .n = 3, .in = {0, 2}}, in, v);
    assert_near(v[1] / v[2], -0.5, 1e-15); /* (0, -.5 * .5, .5) */
    assert_near(v[1] * v[1] + v[2] * v[2], 1, 1e-15);
    const double black[][4] = {{0, 0, 0, 0}, {1, 1, 1, 1}};
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_NORMAL, .n = 3, .in = {0, 1}}, black, v);
    assert_true(v[0] == 0 && v[1] == 0 && v[2] == 1);
    nqm_graph_node_value(&(nqm_map_node){.op = NQM_MAP_SMOOTHSTEP, .n = 1, .in = {1, 0, 0}}, in, v);
    assert_true(v[0] == 0); /* both edges are the same */
}

TEST(images) {
    const char *both = "<input name='base_color' type='color3' nodename='c'/>" ROUGHNESS;
    nqm_materials *materials =
        read_parts(" fileprefix='maps/' colorspace='acescg'", both,
                   "<image name='c' type='color3'>" FILE_INPUT(
                       "c.png") "</image><tiledimage name='n' type='float' fileprefix='other/'><input name='file' "
                                "type='filename' value='r.png' colorspace='srgb_texture'/><input name='uvtiling' "
                                "type='vector2' value='4,2'/><input name='uvoffset' type='vector2' "
                                "value='.25,.5'/></tiledimage>");
    const nqm_textured *t = textured_of(materials, "base_color reads the texture of node 'c'; only constants are read");
    assert_int_equal(t->n_outputs, 2);
    assert_int_equal(t->n_nodes, 2);
    assert_int_equal(t->n_images, 2);
    assert_true(t->normal == NQM_NO_NODE);
    const nqm_map_node *c = &t->nodes[output_of(t, "base_color")], *n = &t->nodes[output_of(t, "specular_roughness")];
    assert_true(c->op == NQM_MAP_IMAGE && c->n == 3 && n->op == NQM_MAP_IMAGE && n->n == 1);
    assert_string_equal(t->images[c->image].path, "folder/maps/c.png");
    assert_string_equal(t->images[c->image].space, "acescg");
    assert_string_equal(t->images[n->image].path, "folder/other/r.png");
    assert_string_equal(t->images[n->image].space, ""); /* a number is no color */
    const double same[2][3] = {{1, 0, 0}, {0, 1, 0}};
    /* x = 4 u - .25; with v upwards y = 2 v - .5, so downwards 1 - (2 (1 - v) - .5) */
    const double tiled[2][3] = {{4, 0, -0.25}, {0, 2, -0.5}};
    for (size_t i = 0; i < 6; ++i) {
        assert_near(c->uv[i / 3][i % 3], same[i / 3][i % 3], 1e-15);
        assert_near(n->uv[i / 3][i % 3], tiled[i / 3][i % 3], 1e-15);
    }
    assert_true(c->wrap[0] == NQM_MAP_REPEAT && c->wrap[1] == NQM_MAP_REPEAT);
    assert_non_null(nqm_values_given(&t->values, "base")); /* with the constants */
    nqm_materials_free(materials);
}

/* place2d of the specification and rotate2d of its implementations, in another way: by a point of the surface. */
TEST(coordinates) {
    const char *graph =
        "<place2d name='p' type='vector2'><input name='texcoord' type='vector2' nodename='t'/><input name='pivot' "
        "type='vector2' value='.5,.5'/><input name='scale' type='vector2' value='.5,2'/><input name='rotate' "
        "type='float' value='30'/><input name='offset' type='vector2' value='.1,.2'/><input name='operationorder' "
        "type='integer' value='%d'/></place2d><%s name='t' type='vector2'>%s</%s><image name='n' type='color3'>"
        "<input name='texcoord' type='vector2' nodename='p'/><input name='uaddressmode' type='string' value='clamp'/>"
        "<input name='vaddressmode' type='string' value='constant'/><input name='default' type='color3' "
        "value='.1,.2,.3'/>" FILE_INPUT("a.png") "</image>";
    char others[2000];
    for (int order = 0; order < 2; ++order) {
        snprintf(others, sizeof others, graph, order, order ? "texcoord" : "geompropvalue",
                 order ? "" : "<input name='geomprop' type='string' value='UV0'/>",
                 order ? "texcoord" : "geompropvalue");
        nqm_materials *materials = read_parts("", COLOR, others);
        const nqm_textured *t = textured_of(materials, "reads the texture of node 'n'");
        const nqm_map_node *n = &t->nodes[output_of(t, "base_color")];
        assert_int_equal(t->n_nodes, 1);
        const double u = 0.3, v = 0.9, co = cos(acos(-1) / 6), si = 0.5, x = u - 0.5, y = (1 - v) - 0.5;
        double s, q;
        if (order) {
            s = (co * (x - 0.1) + si * (y - 0.2)) / 0.5;
            q = (co * (y - 0.2) - si * (x - 0.1)) / 2;
        } else {
            s = co * x / 0.5 + si * y / 2 - 0.1;
            q = co * y / 2 - si * x / 0.5 - 0.2;
        }
        assert_near(n->uv[0][0] * u + n->uv[0][1] * v + n->uv[0][2], s + 0.5, 1e-14);
        assert_near(n->uv[1][0] * u + n->uv[1][1] * v + n->uv[1][2], 1 - (q + 0.5), 1e-14);
        assert_true(n->wrap[0] == NQM_MAP_CLAMP && n->wrap[1] == NQM_MAP_BORDER);
        assert_true(n->v[0] == 0.1 && n->v[1] == 0.2 && n->v[2] == 0.3);
        nqm_materials_free(materials);
    }
}

/* Only the names of the first set of texture coordinates are known. */
TEST(other_sets_of_coordinates_are_refused) {
    static const char *const names[] = {"UV0", "st", "UV1", "ST", ""};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char others[1000], input[200] = "";
        if (*names[i])
            snprintf(input, sizeof input, "<input name='geomprop' type='string' value='%s'/>", names[i]);
        snprintf(others, sizeof others,
                 "<geompropvalue name='t' type='vector2'>%s</geompropvalue><image name='n' type='color3'>"
                 "<input name='texcoord' type='vector2' nodename='t'/>" FILE_INPUT("a.png") "</image>",
                 input);
        nqm_materials *materials = read_parts("", COLOR, others);
        assert_true((nqm_materials_get(materials, 0).n_maps > 0) == (i < 2));
        nqm_materials_free(materials);
    }
}

/* Every sum has its predecessor twice: each is evaluated once. */
TEST(shared_nodes) {
    char others[7000] = "<image name='n0' type='float'>" FILE_INPUT("a.png") "</image>";
    for (int i = 1; i < 50; ++i)
        snprintf(
            others + strlen(others), sizeof others - strlen(others),
            "<add name='n%d' type='float'><input name='in1' nodename='n%d'/><input name='in2' nodename='n%d'/></add>",
            i, i - 1, i - 1);
    nqm_materials *materials = read_parts("", "<input name='specular_roughness' type='float' nodename='n49'/>", others);
    const nqm_textured *t = textured_of(materials, "'n49' (add)");
    assert_int_equal(t->n_nodes, 50);
    nqm_materials_free(materials);
}

/* Two materials with one shader have the same maps. */
TEST(shared_shaders) {
    nqm_materials *materials = text_as_materials(
        "x.mtlx", "<materialx><image name='n' type='color3'>" FILE_INPUT(
                      "a.png") "</image><standard_surface name='S' type='surfaceshader'>" COLOR
                               "</standard_surface><surfacematerial name='A'><input name='surfaceshader' nodename='S'/>"
                               "</surfacematerial><surfacematerial name='B'><input name='surfaceshader' nodename='S'/>"
                               "</surfacematerial></materialx>");
    assert_int_equal(nqm_materials_count(materials), 2);
    assert_non_null(nqm_materials_maps(materials, 0, 0));
    assert_ptr_equal(nqm_materials_maps(materials, 0, 0), nqm_materials_maps(materials, 1, 0));
    assert_string_equal(nqm_materials_get(materials, 1).name, "B");
    nqm_materials_free(materials);
}
