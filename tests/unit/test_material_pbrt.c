/* SPDX-License-Identifier: MIT
 *
 * pbrt-v4 scenes: what is read, what is refused and why, what is damaged, and files written and read back.
 */
#include "material/mitsuba.h"
#include "support/check.h"
#include "support/material_text.h"
#include "support/temp_file.h"

#define COPPER "eta=0.200437697,0.9240334304,1.1022119527;k=3.9129485033,2.4528477015,2.1421879552"

static void conductors(void **state) {
    (void)state;
    expect_spec("Material \"conductor\" \"float roughness\" 0.25", "pbrt-conductor:roughness=0.25;" COPPER);
    expect_spec("Material \"conductor\" \"float roughness\" [ 0.5 ] \"bool remaproughness\" false",
                "pbrt-conductor:roughness=0.25;" COPPER);
    expect_spec("Material \"conductor\" \"float roughness\" .5 \"float vroughness\" .25 \"bool remaproughness\" false",
                "pbrt-conductor:roughness=0.25,0.0625;" COPPER);
    expect_spec("# a comment \"Material\n Material \"conductor\"\"float uroughness\"[.1]\"float vroughness\"[.1]"
                "\"rgb eta\" [1 2 3] # more\n \"spectrum k\" \"metal-Al-k\"\nShape \"sphere\"",
                "pbrt-conductor:roughness=0.1;eta=1,2,3;k=9.2238691996,6.2695232477,4.8370012281");
    expect_spec("Material \"conductor\" \"rgb reflectance\" [0 0.5 0.8] \"float roughness\" 0.1",
                "pbrt-conductor:roughness=0.1;eta=1,1,1;k=0,2,4");
    expect_spec("Material \"conductor\" \"rgb reflectance\" [-1 1 0.99991] \"float roughness\" 0.1",
                "pbrt-conductor:roughness=0.1;eta=1,1,1;k=0,199.9899997499985,199.9899997499985"); /* 2 sqrt(9999) */
    expect_spec("Material \"diffuse\" \"rgb reflectance\" [-1 0.5 2]", "lambert:kd=0,0.5,1");
}

static void refused_materials(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"Material \"conductor\"", "smooth"},
        {"Material \"conductor\" \"float roughness\" 1e-7", "smooth"},
        {"Material \"conductor\" \"float uroughness\" .1 \"float vroughness\" 0", "smooth"},
        {"Material \"conductor\" \"float uroughness\" .1 \"float vroughness\" -.2", "negative"},
        {"Material \"conductor\" \"float roughness\" .1 \"string vroughness\" \".2\"", "needs a number"},
        {"Material \"conductor\" \"float roughness\" .1 \"spectrum eta\" \"metal-Xx-eta\"", "Au, Be"},
        {"Material \"conductor\" \"float roughness\" .1 \"spectrum eta\" \"metal-Au-k\"", "not known"},
        {"Material \"conductor\" \"float roughness\" .1 \"spectrum eta\" [ 400 1 700 2 ]", "wavelength"},
        {"Material \"conductor\" \"texture roughness\" \"t\"", "texture"},
        {"Material \"conductor\" \"float roughness\" .1 \"texture displacement\" \"t\"", "texture"},
        {"Material \"conductor\" \"float roughness\" .1 \"float displacement\" 1", "displacement"},
        {"Material \"conductor\" \"rgb roughness\" [.1 .2 .3]", "needs a number"},
        {"Material \"conductor\" \"float roughness\" .1 \"rgb eta\" [ 1 2 ]", "three numbers"},
        {"Material \"conductor\" \"float roughness\" .1 \"rgb eta\" [ 1 1 1 ] \"rgb reflectance\" [ 1 1 1 ]",
         "as well as"},
        {"Material \"conductor\" \"float roughness\" .1 \"string remaproughness\" \"no\"", "true or false"},
        {"Material \"conductor\" \"float roughness\" .1 \"bool remaproughness\" \"maybe\"", "true or false"},
        {"Material \"conductor\" \"float roughness\" -.1 \"bool remaproughness\" false", "negative"},
        {"Material \"conductor\" \"float roughness\" .1 \"float roughness\" .2", "given twice"},
        {"Material \"conductor\" \"float roughness\" true", "needs a number"},
        {"Material \"diffuse\" \"rgb reflectance\" [ true false true ]", "three numbers"},
        {"Material \"diffuse\" \"rgb reflectance\" [ \".1\" \".2\" \".3\" ]", "three numbers"},
        {"MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"string type\" \"conductor\"", "type"},
        {"Material \"coateddiffuse\"", "random walks"},
        {"Material \"coatedconductor\"", "random walks"},
        {"Material \"dielectric\"", "transmission"},
        {"Material \"mix\" \"string materials\" [ \"a\" \"b\" ]", "mixtures"},
        {"Material \"uber\"", "not known"},
        {"Material \"measured\"", "filename"},
        {"ColorSpace \"rec2020\" Material \"diffuse\"", "colour space"},
        {"Attribute \"material\" \"rgb reflectance\" [1 0 0] Material \"diffuse\"", "Attribute"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        expect_refusal(cases[i][0], cases[i][1]);
}

static void scenes(void **state) {
    (void)state;
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

static void damaged_files(void **state) {
    (void)state;
    expect_error("Material \"conductor", NQM_ERR_FORMAT, "closing quote (byte 9)");
    expect_error("Material", NQM_ERR_FORMAT, "not a material file");
    expect_error("Material ", NQM_ERR_FORMAT, "without the type");
    expect_error("MakeNamedMaterial 3", NQM_ERR_FORMAT, "without the name");
    expect_error("Material \"diffuse\" \"reflectance\" 1", NQM_ERR_FORMAT, "type name");
    expect_error("Material \"diffuse\" \"rgb reflectance\" [ 1 2", NQM_ERR_FORMAT, "closing bracket");
    expect_error("Material \"diffuse\" \"rgb reflectance\" [ 1 x ]", NQM_ERR_FORMAT, "not a number");
    expect_error("WorldBegin\n", NQM_ERR_FORMAT, "no material");
    expect_error("Include \"a.pbrt\"\n", NQM_ERR_FORMAT, "included files");
}

static void files_go_there_and_back(void **state) {
    (void)state;
    expect_same("pbrt-conductor:roughness=0.123456789012345;eta=.1,.2,.3;k=3.3333333333333335,2,1e-17", "pbrt");
    expect_same("pbrt-conductor:roughness=1e-6;eta=1;k=200", "pbrt");
    expect_same("pbrt-conductor:roughness=.1,.333333333333333333;eta=1;k=2", "pbrt");
    expect_same("lambert:kd=0.1,0.30000000000000004,1", "pbrt");
    expect_same("lambert:kd=0.5", "pbrt");
}

static void no_memory(void **state) {
    (void)state;
    expect_survives_no_memory(
        "Material \"conductor\" \"float roughness\" 1 Material \"measured\" \"string filename\" \"a\" "
        "Material \"mix\"");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(conductors),    cmocka_unit_test(refused_materials),       cmocka_unit_test(scenes),
        cmocka_unit_test(damaged_files), cmocka_unit_test(files_go_there_and_back), cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, make_temp_file, remove_temp_file);
}
