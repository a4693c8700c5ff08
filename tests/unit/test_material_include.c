/* SPDX-License-Identifier: MIT
 *
 * Files that scenes of Mitsuba and pbrt include, and spectra in files beside them.
 */
#include "material/bsdf.h"
#include "support/check.h"
#include "support/material_text.h"
#include "support/scratch.h"

static nqm_materials *must_read(const char *path) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (nqm_materials_open(path, &materials, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return materials;
}

static void expect_error(const char *path, nqm_status status, const char *words) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    assert_int_equal(nqm_materials_open(path, &materials, &err), status);
    if (!strstr(err.message, words))
        fail_msg("'%s' is not in '%s'", words, err.message);
}

static void expect(const nqm_materials *materials, size_t i, const char *name, const char *spec, const char *remark) {
    const nqm_material_info info = nqm_materials_get(materials, i);
    assert_string_equal(info.name, name);
    assert_string_equal(info.spec ? info.spec : info.refusal, spec);
    assert_true(remark ? info.remark && strstr(info.remark, remark) : !info.remark);
}

TEST(names_inside_of_a_folder) {
    static const char *const inside[] = {"a", "a/b.xml", "./a", "..a/b..", "a/...", "a//b"};
    static const char *const outside[] = {"", "/", "/a", "..", "../a", "a/..", "a/../b", "./../a"};
    for (size_t i = 0; i < sizeof inside / sizeof *inside; ++i)
        assert_true(nqm_include_is_inside(inside[i]));
    for (size_t i = 0; i < sizeof outside / sizeof *outside; ++i)
        assert_false(nqm_include_is_inside(outside[i]));
}

/* Materials and textures of an included file, in the order of the text; positions are those of the scene only. */
TEST(pbrt_reads_included_files) {
    (void)scratch_text("textures.pbrt",
                       "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [ .1 .2 .3 ]\n"
                       "MakeNamedMaterial \"in\" \"string type\" \"diffuse\" \"texture reflectance\" \"t\"");
    nqm_materials *materials = must_read(scratch_text(
        "scene.pbrt",
        "Include \"textures.pbrt\" Material \"diffuse\" \"texture reflectance\" \"t\" Import \"lost.pbrt\"\n"
        "MakeNamedMaterial \"mix\" \"string type\" \"mix\" \"string materials\" [ \"in\" \"in\" ]"));
    assert_int_equal(nqm_materials_count(materials), 3);
    expect(materials, 0, "in", "lambert:kd=0.1,0.2,0.3", "lost.pbrt: No such file");
    expect(materials, 1, "material2", "lambert:kd=0.1,0.2,0.3", "lost.pbrt: No such file");
    expect(materials, 2, "mix", "between:t=0.5;with=(lambert:kd=0.1,0.2,0.3);of=lambert:kd=0.1,0.2,0.3", "lost.pbrt");
    assert_int_equal(nqm_materials_get(materials, 0).byte_offset, -1);
    assert_int_equal(nqm_materials_get(materials, 1).byte_offset, 24);
    nqm_materials_free(materials);
}

/* What is set in an included file lasts, and what is after the directive is read after it. */
TEST(settings_of_included_files_last) {
    (void)scratch_text("space.pbrt", "ColorSpace \"rec2020\"");
    nqm_materials *materials =
        must_read(scratch_text("set.pbrt", "Material \"diffuse\" Include \"space.pbrt\" Material \"diffuse\""));
    assert_non_null(nqm_materials_get(materials, 0).spec);
    assert_non_null(strstr(nqm_materials_get(materials, 1).refusal, "colour space"));
    nqm_materials_free(materials);
}

TEST(mitsuba_reads_included_files) {
    (void)scratch_text("parts.xml",
                       "<scene version='3.0.0'><default name='grey' value='0.25'/>"
                       "<bsdf type='diffuse' id='wall'><float name='reflectance' value='$grey'/></bsdf></scene>");
    (void)scratch_text("one.xml", "<bsdf type='diffuse' id='one'/>");
    nqm_materials *materials = must_read(scratch_text(
        "scene.xml", "<scene version='3.0.0'><default name='file' value='one.xml'/><include filename='parts.xml'/>"
                     "<bsdf type='twosided' id='sheet'><ref id='wall'/></bsdf><include filename='$file'/>"
                     "<include filename='lost.xml'/><bsdf type='twosided' id='in'><include filename='one.xml'/></bsdf>"
                     "</scene>"));
    assert_int_equal(nqm_materials_count(materials), 4);
    expect(materials, 0, "wall", "lambert:kd=0.25", "lost.xml: No such file");
    expect(materials, 1, "sheet", "lambert:kd=0.25", "lost.xml: No such file");
    expect(materials, 2, "one", "lambert:kd=0.5", "lost.xml: No such file");
    expect(materials, 3, "in", "lambert:kd=0.5", "lost.xml: No such file");
    nqm_materials_free(materials);
}

TEST(files_that_include_themselves_are_refused) {
    expect_error(scratch_text("self.pbrt", "Material \"diffuse\" Include \"self.pbrt\" Include \"self.pbrt\""),
                 NQM_ERR_FORMAT, "includes itself");
    (void)scratch_text("b.xml", "<scene><include filename='a.xml'/></scene>");
    expect_error(scratch_text("a.xml", "<scene><include filename='b.xml'/></scene>"), NQM_ERR_FORMAT,
                 "includes itself");
}

/* 20 files that each include the next one twice would be a million. */
TEST(included_files_have_a_limit) {
    char name[40], text[100];
    for (int i = 0; i < 15; ++i) {
        snprintf(name, sizeof name, "tree%d.pbrt", i);
        snprintf(text, sizeof text, "Include \"tree%d.pbrt\" Include \"tree%d.pbrt\"", i + 1, i + 1);
        (void)scratch_text(name, i < 14 ? text : "WorldBegin Material \"diffuse\"");
    }
    expect_error(scratch_path("tree0.pbrt"), NQM_ERR_LIMIT, "more than 10000 included files");
}

TEST(damaged_included_files_are_errors) {
    (void)scratch_text("broken.pbrt", "Material");
    expect_error(scratch_text("outer.pbrt", "Material \"diffuse\" Include \"broken.pbrt\""), NQM_ERR_FORMAT,
                 "broken.pbrt");
    (void)scratch_text("broken.xml", "<scene>");
    expect_error(scratch_text("outer.xml", "<scene><bsdf type='diffuse'/><include filename='broken.xml'/></scene>"),
                 NQM_ERR_FORMAT, "broken.xml");
}

/* ---- spectra ----------------------------------------------------------------------------------------------------- */

static void expect_colour(nqm_materials *materials, const char *key, const double expected[3]) {
    nqm_values values;
    const char *spec = nqm_materials_get(materials, 0).spec;
    if (!spec)
        fail_msg("%s", nqm_materials_get(materials, 0).refusal);
    assert_int_equal(nqm_values_parse_spec(spec, &values, NULL), NQM_OK);
    const double *p = nqm_values_given(&values, key);
    assert_non_null(p);
    for (size_t c = 0; c < 3; ++c)
        assert_near(p[c], expected[c], 2.5e-3 * (1 + expected[c]));
    nqm_materials_free(materials);
}

/* Expected: sums over CIE's 1931 table and D65 at 1 nm, without the spectrum beyond its ends; the fits of the curves are within 0.0025. */
TEST(spectra_are_those_of_the_cie_tables) {
    static const double red[3] = {0.69054548, 0.2499578, 0.00757693}, grey[3] = {0.5, 0.5, 0.5},
                        ramp[3] = {1.80176111, 1.47779063, 1.13285908};
    (void)scratch_text("red.spd", "# nm value\n400 0.04\n500 0.046 # blue\n\n600 0.55\r\n700 0.65");
    (void)scratch_text("ramp.spd", "400 1\n700 2\n");
    expect_colour(text_as_materials("x.xml",
                                    "<bsdf type='diffuse'><spectrum name='reflectance' value='400:0.04, 500:0.046, "
                                    "600:0.55, 700:0.65'/></bsdf>"),
                  "kd", red);
    expect_colour(
        text_as_materials("x.xml", "<bsdf type='diffuse'><spectrum name='reflectance' value='300:.5, 900:.5'/></bsdf>"),
        "kd", grey);
    expect_colour(must_read(scratch_text(
                      "f.xml", "<bsdf type='diffuse'><spectrum name='reflectance' filename='red.spd'/></bsdf>")),
                  "kd", red);
    expect_colour(must_read(scratch_text(
                      "f.xml", "<bsdf type='roughconductor'><spectrum name='eta' filename='ramp.spd'/></bsdf>")),
                  "eta", ramp);
    expect_colour(text_as_materials("x.json",
                                    "{\"type\": \"diffuse\", \"reflectance\": {\"type\": \"spectrum\", \"value\": "
                                    "[[400, 0.04], [500, 0.046], [600, 0.55], [700, 0.65]]}}"),
                  "kd", red);
    expect_colour(
        must_read(scratch_text(
            "f.json", "{\"type\": \"diffuse\", \"reflectance\": {\"type\": \"spectrum\", \"filename\": \"red.spd\"}}")),
        "kd", red);
    expect_colour(must_read(scratch_text("f.pbrt", "Material \"diffuse\" \"spectrum reflectance\" \"red.spd\"")), "kd",
                  red);
    expect_colour(text_as_materials("x.pbrt", "Material \"conductor\" \"spectrum k\" [ 400 1 700 2 ]"), "k", ramp);
    expect_colour(
        must_read(scratch_text("f.pbrt", "Material \"coatedconductor\" \"spectrum conductor.eta\" \"ramp.spd\"")),
        "conductor.eta", ramp);
}
