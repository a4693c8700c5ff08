/* SPDX-License-Identifier: MIT
 *
 * Constants of material files against their sources: inputs, types and defaults of MaterialX's surfaces against the project's own
 * definitions (shared data), defaults of the shading models against these tables, Mitsuba's names, and colour spaces against
 * their primaries.
 */
#include "io/xml.h"
#include "material/bsdf.h"
#include "material/gltf.h"
#include "material/material.h"
#include "material/materialx.h"
#include "support/check.h"
#include "support/material_text.h"
#include "support/rows.h"

/* ---- MaterialX --------------------------------------------------------------------------------------------------- */

/* The default definition of a node, and the one that it inherits from, or NULL. */
static void find_definitions(const nqm_xml *xml, const char *node, const nqm_xml_element *definitions[2]) {
    definitions[0] = definitions[1] = NULL;
    for (const nqm_xml_element *e = xml->root->first; e; e = e->next) {
        const char *name = nqm_xml_get(e, "node"), *version = nqm_xml_get(e, "version");
        if (strcmp(e->name, "nodedef") == 0 && strcmp(name, node) == 0 &&
            (!version || nqm_xml_get(e, "isdefaultversion")))
            definitions[0] = e;
    }
    assert_non_null(definitions[0]);
    const char *parent = nqm_xml_get(definitions[0], "inherit");
    for (const nqm_xml_element *e = xml->root->first; parent && e; e = e->next) {
        const char *name = nqm_xml_get(e, "name");
        if (name && strcmp(name, parent) == 0)
            definitions[1] = e;
    }
    assert_true(!parent || definitions[1]);
}

static const nqm_xml_element *find_input(const nqm_xml_element *const definitions[2], const char *name) {
    for (size_t d = 0; d < 2 && definitions[d]; ++d)
        for (const nqm_xml_element *e = definitions[d]->first; e; e = e->next)
            if (strcmp(e->name, "input") == 0 && strcmp(nqm_xml_get(e, "name"), name) == 0)
                return e;
    return NULL;
}

static void check_input(const char *node, const nqm_rule *input, const nqm_xml_element *e) {
    if (!e)
        fail_msg("%s: the definition has no input %s", node, input->name);
    if (!input->type)
        return;
    const char *type = nqm_xml_get(e, "type"), *text = nqm_xml_get(e, "value");
    if (strcmp(type, input->type) != 0)
        fail_msg("%s: %s has type %s, not %s", node, input->name, type, input->type);
    for (size_t c = 0; c < (strcmp(type, "color3") == 0 ? 3 : 1); ++c) {
        double v;
        text += strspn(text, " ,");
        /* of glTF's own specification; reading sets the definition's 100 */
        const bool is_other = strcmp(input->name, "iridescence_thickness") == 0 && input->value == 400;
        if (!nqm_parse_double(text, &text, &v) || (v != input->value && !is_other))
            fail_msg("%s: %s is %g by default, not %g", node, input->name, v, input->value);
    }
}

static void check_surface(const nqm_mtlx_surface *surface, const char *file) {
    nqm_map map;
    nqm_xml xml;
    nqm_error err = {0};
    const nqm_xml_element *definitions[2];
    char path[200];
    snprintf(path, sizeof path, "materials/definitions/%s", file);
    assert_int_equal(nqm_map_open(shared_data(path), &map, &err), NQM_OK);
    assert_int_equal(nqm_xml_parse(map.data, map.n_bytes, path, &xml, &err), NQM_OK);
    find_definitions(&xml, surface->node, definitions);
    for (const nqm_rule *input = surface->inputs; input->name; ++input) {
        char names[1000], *rest = names;
        snprintf(names, sizeof names, "%s", input->name);
        for (const char *name; (name = strtok_r(rest, " ", &rest));)
            if (strcmp(name, "specular_retroreflectivity") != 0) /* of newer versions */
                check_input(surface->node, input, find_input(definitions, name));
    }
    for (size_t d = 0; d < 2 && definitions[d]; ++d)
        for (const nqm_xml_element *e = definitions[d]->first; e; e = e->next)
            if (strcmp(e->name, "input") == 0 && !nqm_rule_find(surface->inputs, nqm_xml_get(e, "name")))
                fail_msg("%s: the input %s is not in the table", surface->node, nqm_xml_get(e, "name"));
    nqm_xml_free(&xml);
    nqm_map_close(&map);
}

TEST(surfaces_have_the_inputs_of_their_definitions) {
    static const char *const files[NQM_MTLX_N_SURFACES] = {"open_pbr_surface.mtlx", "standard_surface.mtlx",
                                                           "gltf_pbr.mtlx", "usd_preview_surface.mtlx",
                                                           "disney_principled.mtlx"};
    if (!shared_data("materials/definitions"))
        skip();
    for (size_t s = 0; s < NQM_MTLX_N_SURFACES; ++s)
        check_surface(&nqm_mtlx_surfaces[s], files[s]);
}

/* A spec without keys has the canonical form of the spec with all keys at the defaults of the table. */
TEST(models_have_the_same_defaults) {
    for (size_t s = 0; s < NQM_MTLX_N_SURFACES; ++s) {
        const nqm_mtlx_surface *surface = &nqm_mtlx_surfaces[s];
        nqm_values values = nqm_values_of(nqm_schema_find(surface->model, strlen(surface->model)));
        char *bare = nqm_values_spec(&values);
        for (const nqm_rule *input = surface->inputs; input->name; ++input)
            if (input->key)
                nqm_values_set(&values, input->key, 1, &input->value);
        char *full = nqm_values_spec(&values);
        nqm_brdf *a = must_open(bare), *b = must_open(full);
        assert_string_equal(nqm_brdf_get_info(a).spec, nqm_brdf_get_info(b).spec);
        nqm_brdf_free(a);
        nqm_brdf_free(b);
        nqm_free(bare);
        nqm_free(full);
    }
}

/* Files of glTF have the defaults of gltf_pbr. */
TEST(gltf_files_have_the_same_defaults) {
    const nqm_mtlx_surface *surface = &nqm_mtlx_surfaces[2];
    assert_string_equal(surface->model, "gltf");
    for (size_t g = 0; g <= NQM_GLTF_N_EXTENSIONS; ++g) {
        const nqm_gltf_group *group = g ? &nqm_gltf_extensions[g - 1] : &nqm_gltf_core;
        for (const nqm_rule *p = group->rules; p->name; ++p) {
            const nqm_rule *input = nqm_rule_find(surface->inputs, p->key);
            if (p->key && (!input || input->value != p->value))
                fail_msg("%s.%s: %g", group->name, p->name, p->value);
        }
    }
}

/* Mitsuba 3's documentation of its plugins: "BSDFs"; a conductor is a mirror, plastic is polypropylene in air. */
TEST(mitsuba_models_have_their_defaults) {
    EVERY_ROW(row, "defaults of Mitsuba") {
        char bare[40];
        snprintf(bare, sizeof bare, "%.*s", (int)strcspn(row[0], ":") + 1, row[0]);
        nqm_brdf *brdf = must_open(bare);
        assert_string_equal(nqm_brdf_get_info(brdf).spec, row[0]);
        nqm_brdf_free(brdf);
    }
}

/* Mitsuba's include/mitsuba/render/ior.h; outside is air. */
TEST(indices_of_mitsuba_have_names) {
    EVERY_ROW(row, "refractive indices of Mitsuba") {
        for (int is_inner = 0; is_inner < 2; ++is_inner) {
            char text[300], spec[80], number[32];
            const double index = atof(row[1]), eta = is_inner ? index / 1.000277 : 2.5 / index;
            if (is_inner ? index < 1.1 : index > 2)
                continue;
            snprintf(text, sizeof text, "<bsdf type='roughplastic'><string name='%s_ior' value='%s'/>%s</bsdf>",
                     is_inner ? "int" : "ext", row[0], is_inner ? "" : "<float name='int_ior' value='2.5'/>");
            snprintf(spec, sizeof spec, "rough-plastic:eta=%s", nqm_format_double(number, sizeof number, eta));
            nqm_materials *materials = text_as_materials("x.xml", text);
            assert_string_equal(nqm_materials_get(materials, 0).spec, spec);
            nqm_materials_free(materials);
        }
    }
}

/* Sums over the indices that presets/metals.txt has the sources of, with weights by name and channel: a wrong digit changes one of them. */
TEST(metals_are_those_of_their_source) {
    static const struct {
        bool is_pbrt;
        size_t n;
        double eta, k;
    } expected[] = {{false, 38, 7054876.778543148, 6874964.372475307}, {true, 7, 840851.336720197, 1830853.345936009}};
    for (size_t i = 0; i < 2; ++i) {
        const bool is_pbrt = expected[i].is_pbrt;
        char names[400], *save = NULL;
        double eta = 0, k = 0;
        size_t n = 0;
        nqm_metal_names(is_pbrt, names, sizeof names);
        for (const char *name = strtok_r(names, ", ", &save); name; name = strtok_r(NULL, ", ", &save)) {
            n += strcmp(name, "none") != 0;
            for (size_t c = 0; c < 3 && strcmp(name, "none") != 0; ++c) {
                const double weight = (double)((size_t)name[0] + 256 * (size_t)name[1] + 1000 * strlen(name) + c);
                eta += weight * nqm_metal_find(is_pbrt, name)->eta[c];
                k += weight * nqm_metal_find(is_pbrt, name)->k[c];
            }
        }
        assert_int_equal(n, expected[i].n);
        assert_near(eta, expected[i].eta, 1e-5);
        assert_near(k, expected[i].k, 1e-5);
    }
    assert_ptr_equal(nqm_metal_find(false, "Au_palik"), nqm_metal_find(false, "Au"));
    assert_ptr_not_equal(nqm_metal_find(false, "Cu_palik"), nqm_metal_find(false, "Cu"));
    assert_null(nqm_metal_find(false, "metal-Au"));
    assert_null(nqm_metal_find(false, "Ni")); /* Mitsuba has Ni_palik only */
    assert_null(nqm_metal_find(true, "metal-Cr"));
    assert_null(nqm_metal_find(true, "Au"));
}

/* ---- colour spaces ----------------------------------------------------------------------------------------------- */

static void multiply(double a[3][3], double b[3][3], double out[3][3]) {
    for (size_t i = 0; i < 3; ++i)
        for (size_t k = 0; k < 3; ++k)
            out[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
}

static void invert(double a[3][3], double out[3][3]) {
    double det = 0;
    for (size_t i = 0; i < 3; ++i)
        for (size_t k = 0; k < 3; ++k) {
            const size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            out[k][i] = a[i1][k1] * a[i2][k2] - a[i1][k2] * a[i2][k1];
        }
    for (size_t k = 0; k < 3; ++k)
        det += a[0][k] * out[k][0];
    for (size_t i = 0; i < 9; ++i)
        out[i / 3][i % 3] /= det;
}

static void xyz_of(const double xy[2], double xyz[3]) {
    xyz[0] = xy[0] / xy[1];
    xyz[1] = 1;
    xyz[2] = (1 - xy[0] - xy[1]) / xy[1];
}

/* Linear RGB to XYZ (SMPTE RP 177): chromaticities of red, green, blue and white. */
static void rgb_to_xyz(const double xy[4][2], double out[3][3]) {
    double primaries[3][3], inverse[3][3], white[3], column[3];
    for (size_t k = 0; k < 3; ++k) {
        xyz_of(xy[k], column);
        for (size_t i = 0; i < 3; ++i)
            primaries[i][k] = column[i];
    }
    xyz_of(xy[3], white);
    invert(primaries, inverse);
    for (size_t k = 0; k < 3; ++k) {
        const double scale = inverse[k][0] * white[0] + inverse[k][1] * white[1] + inverse[k][2] * white[2];
        for (size_t i = 0; i < 3; ++i)
            out[i][k] = primaries[i][k] * scale;
    }
}

/* Bradford's adaptation between two whites. */
static void adapt(const double from[2], const double to[2], double out[3][3]) {
    double cone[3][3] = {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};
    double inverse[3][3], scaled[3][3], a[3], b[3];
    xyz_of(from, a);
    xyz_of(to, b);
    for (size_t i = 0; i < 3; ++i) {
        const double *row = cone[i];
        const double ratio =
            (row[0] * b[0] + row[1] * b[1] + row[2] * b[2]) / (row[0] * a[0] + row[1] * a[1] + row[2] * a[2]);
        for (size_t k = 0; k < 3; ++k)
            scaled[i][k] = ratio * row[k];
    }
    invert(cone, inverse);
    multiply(inverse, scaled, out);
}

/* Curves and primaries of MaterialX 1.39 (libraries/cmlib), and of the names of the Color Interop Forum. */
enum { BT709, AP1, P3, ADOBE, AP0, REC2020, N_GAMUTS };
static const double chromaticities[N_GAMUTS][4][2] = {
    {{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.3127, 0.329}},
    {{0.713, 0.293}, {0.165, 0.83}, {0.128, 0.044}, {0.32168, 0.33767}},
    {{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}, {0.3127, 0.329}},
    {{0.64, 0.33}, {0.21, 0.71}, {0.15, 0.06}, {0.3127, 0.329}},
    {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.077}, {0.32168, 0.33767}},
    {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, {0.3127, 0.329}}};
enum { SRGB = -1 }; /* else the exponent */
static const struct {
    const char *name;
    int gamut;
    double curve;
} spaces[] = {{"lin_rec709", BT709, 1},
              {"lin_rec709_scene", BT709, 1},
              {"lin_srgb", BT709, 1},
              {"none", BT709, 1},
              {"raw", BT709, 1},
              {"srgb_texture", BT709, SRGB},
              {"srgb_rec709_scene", BT709, SRGB},
              {"g18_rec709", BT709, 1.8},
              {"g22_rec709", BT709, 2.2},
              {"g22_rec709_scene", BT709, 2.2},
              {"rec709_display", BT709, 2.4},
              {"acescg", AP1, 1},
              {"lin_ap1", AP1, 1},
              {"lin_ap1_scene", AP1, 1},
              {"g22_ap1", AP1, 2.2},
              {"g22_ap1_scene", AP1, 2.2},
              {"lin_displayp3", P3, 1},
              {"lin_p3d65_scene", P3, 1},
              {"srgb_displayp3", P3, SRGB},
              {"srgb_p3d65_scene", P3, SRGB},
              {"lin_adobergb", ADOBE, 1},
              {"adobergb", ADOBE, 563.0 / 256},
              {"data", BT709, 1},
              {"srgb_rec709_display", BT709, SRGB},
              {"sRGB", BT709, SRGB},
              {"g18_rec709_scene", BT709, 1.8},
              {"g22_rec709_display", BT709, 2.2},
              {"g24_rec709_display", BT709, 2.4},
              {"srgb_ap1_scene", AP1, SRGB},
              {"g18_ap1", AP1, 1.8},
              {"lin_ap0_scene", AP0, 1},
              {"ACES2065-1", AP0, 1},
              {"lin_rec2020_scene", REC2020, 1},
              {"srgb_p3d65_display", P3, SRGB},
              {"g26_p3d65_display", P3, 2.6},
              {"lin_adobergb_scene", ADOBE, 1},
              {"g22_adobergb_scene", ADOBE, 563.0 / 256}};

static double decoded(double curve, double v) {
    if (curve == SRGB)
        return v > 0.04045 ? pow((v + 0.055) / 1.055, 2.4) : v / 12.92;
    return curve == 1 ? v : pow(fmax(v, 0), curve);
}

TEST(colour_spaces_have_their_primaries_and_curves) {
    static const double values[] = {1, 0.5, 0.03, -0.1};
    double rec709[3][3], from_xyz[3][3];
    rgb_to_xyz(chromaticities[BT709], rec709);
    invert(rec709, from_xyz);
    for (size_t s = 0; s < sizeof spaces / sizeof *spaces; ++s) {
        const double(*xy)[2] = chromaticities[spaces[s].gamut];
        double to_xyz[3][3], white[3][3], adapted[3][3], expected[3][3];
        rgb_to_xyz(xy, to_xyz);
        adapt(xy[3], chromaticities[BT709][3], white);
        multiply(white, to_xyz, adapted);
        multiply(from_xyz, adapted, expected);
        for (size_t k = 0; k < 12; ++k) {
            double v = values[k / 3], rgb[3] = {0, 0, 0};
            rgb[k % 3] = v;
            assert_true(nqm_color_to_rec709(spaces[s].name, rgb));
            for (size_t i = 0; i < 3; ++i)
                if (!(fabs(rgb[i] - expected[i][k % 3] * decoded(spaces[s].curve, v)) < 1e-8))
                    fail_msg("%s, channel %zu of %g in channel %zu: %.9f, not %.9f", spaces[s].name, i, v, k % 3,
                             rgb[i], expected[i][k % 3] * decoded(spaces[s].curve, v));
        }
    }
}

TEST(white_stays_white) {
    for (size_t s = 0; s < sizeof spaces / sizeof *spaces; ++s) {
        double rgb[3] = {1, 1, 1};
        assert_true(nqm_color_to_rec709(spaces[s].name, rgb));
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], 1, 1e-7);
    }
    double rgb[3] = {1, 0, 0}, white[3] = {0.3127 / 0.329, 1, (1 - 0.3127 - 0.329) / 0.329}; /* CIE XYZ */
    assert_false(nqm_color_to_rec709("lin_unknown", rgb));
    assert_true(nqm_color_to_rec709("lin_ciexyzd65_scene", white));
    for (size_t c = 0; c < 3; ++c)
        assert_near(white[c], 1, 1e-7);
}

TEST(srgb_is_decoded) {
    for (double v = 0; v <= 1; v += 0.01)
        assert_near(nqm_srgb_to_linear(v), decoded(SRGB, v), 1e-12);
}
