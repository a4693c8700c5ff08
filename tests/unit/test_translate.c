/* SPDX-License-Identifier: MIT
 *
 * Shared properties of shading models: units that come back, indices of refraction below 1, colours of numbers, what is dropped.
 */
#include "support/check.h"
#include "translate/translate.h"

static nqm_values values_of(const char *spec) {
    nqm_values values;
    nqm_error err = {0};
    if (nqm_values_parse_spec(spec, &values, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return values;
}

/* The value (3) of a key after a translation, and what is dropped. */
static void assert_translated(const char *spec, const char *model, const char *key, const double expected[3],
                              const char *dropped) {
    const nqm_values from = values_of(spec);
    nqm_values to = nqm_values_of(nqm_schema_find(model, strlen(model)));
    char text[300] = "";
    nqm_translate_values(&from, &to);
    const double *v = nqm_values_given(&to, key);
    assert_non_null(v);
    for (int c = 0; c < 3; ++c)
        assert_near(v[c], expected[c], 1e-12);
    nqm_translate_list_dropped(&from, to.schema, text, sizeof text);
    assert_string_equal(text, dropped);
}

TEST(test_units_come_back) {
    static const nqm_unit units[][2] = {{NQM_UNIT_PLAIN, NQM_UNIT_ALPHA},
                                        {NQM_UNIT_PLAIN, NQM_UNIT_ALPHA_SQUARED},
                                        {NQM_UNIT_PLAIN, NQM_UNIT_GLOSS},
                                        {NQM_UNIT_RADIANS, NQM_UNIT_TURNS},
                                        {NQM_UNIT_RADIANS, NQM_UNIT_TURNS_CLOCKWISE},
                                        {NQM_UNIT_NANOMETRES, NQM_UNIT_MICROMETRES}};
    static const double to[] = {0.09, 0.0081, 0.7, 0.3 / 6.283185307179586, -0.3 / 6.283185307179586, 0.0003};
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i) {
        const double v = nqm_schema_convert(0.3, units[i][0], units[i][1]);
        assert_near(v, to[i], 1e-15);
        assert_near(nqm_schema_convert(v, units[i][1], units[i][0]), 0.3, 1e-15);
        assert_true(nqm_schema_convert(0.3, units[i][0], units[i][0]) == 0.3);
    }
}

/* ((n - 1) / (n + 1))^2 is the same of n and 1 / n, and glTF's 0 is a mirror. */
TEST(test_ior_below_1) {
    assert_translated("gltf:ior=1.7", "principled", "eta", (double[]){1.7, 1.7, 1.7}, "");
    assert_translated("gltf:ior=0.5", "principled", "eta", (double[]){2, 2, 2}, "");
    assert_translated("gltf:ior=0", "principled", "eta", (double[]){4, 4, 4}, "");
    assert_translated("gltf:ior=0.5", "usd-preview", "ior", (double[]){0.5, 0.5, 0.5}, "");
}

TEST(test_colours_and_numbers) {
    assert_translated("open-pbr:base_color=.1,.2,.6;base_metalness=1", "gltf", "base_color", (double[]){.1, .2, .6},
                      "");
    assert_translated("open-pbr:specular_roughness=.4;fuzz_weight=.5", "usd-preview", "roughness",
                      (double[]){.4, .4, .4}, "fuzz_weight");
}
