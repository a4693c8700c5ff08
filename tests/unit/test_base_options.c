/* SPDX-License-Identifier: MIT
 *
 * Options described by a table: defaults of recipes, parsing of values, ranges, words, names, and JSON.
 */
#include "base/options.h"
#include "io/json.h"
#include "support/check.h"

typedef struct paint {
    double gloss;
    size_t n_layers;
    uint64_t seed;
    int is_metal, is_wet;
    enum { RED, DARK_GREEN, DARK_BLUE } colour;
    const char *name;
    size_t n_sizes, sizes[3];
} paint;

static const char *const recipes[] = {"matte", "shiny", NULL};
static const char *const colours[] = {"red", "dark_green", "light_blue", "", "rusty", NULL}, *const states[] = {
                                                                                                 "dry", "wet", NULL};
static const nqm_option rows[] = {
    {"gloss_level", .offset = offsetof(paint, gloss), .min = 0, .max = 1, .values = {"0.1", "0.9"}},
    {"layers", .offset = offsetof(paint, n_layers), .kind = NQM_OPTION_SIZE, .min = 1, .max = 9, .values = {"2"}},
    {"seed", .offset = offsetof(paint, seed), .kind = NQM_OPTION_U64, .storage = NQM_STORED_UNLESS_ZERO},
    {"metal", .offset = offsetof(paint, is_metal), .kind = NQM_OPTION_BOOL, .values = {"0", "1"}},
    {"wet", "state", .offset = offsetof(paint, is_wet), .kind = NQM_OPTION_BOOL, .words = states, .values = {"dry"}},
    {"colour", .offset = offsetof(paint, colour), .kind = NQM_OPTION_ENUM, .words = colours, .values = {"light_blue"}},
    {"name", .offset = offsetof(paint, name), .kind = NQM_OPTION_TEXT, .storage = NQM_NOT_STORED},
    {"sizes", .offset = offsetof(paint, n_sizes), .kind = NQM_OPTION_SIZES, .max_sizes = 3, .values = {"4,5"}},
};
static const nqm_option_table table = {rows, sizeof rows / sizeof rows[0], recipes};

static paint begin(const char *recipe) {
    paint p;
    memset(&p, 0x55, sizeof p);
    assert_int_equal(nqm_options_begin(&table, recipe, &p, NULL), NQM_OK);
    assert_int_equal(nqm_options_check(&table, &p, NULL), NQM_OK);
    return p;
}

static nqm_status set(paint *p, const char *name, const char *text, nqm_error *err) {
    bool is_off = false;
    const nqm_option *o = nqm_option_by_name(&table, name, strlen(name), &is_off);
    assert_non_null(o);
    assert_false(is_off);
    return nqm_option_set(o, p, text, err);
}

TEST(defaults) {
    paint matte = begin("matte"), shiny = begin("shiny"), first = begin(NULL);
    assert_memory_equal(&matte, &first, sizeof matte);
    assert_near(matte.gloss, 0.1, 0);
    assert_near(shiny.gloss, 0.9, 0);
    assert_int_equal(shiny.n_layers, 2);
    assert_true(!matte.is_metal && shiny.is_metal && !matte.is_wet);
    assert_int_equal(matte.colour, DARK_BLUE);
    assert_true(matte.seed == 0 && !matte.name && matte.n_sizes == 2 && matte.sizes[1] == 5);
    nqm_error err = {0};
    assert_int_equal(nqm_options_begin(&table, "satin", &matte, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "'satin'; give matte or shiny"));
}

TEST(from_text) {
    paint p = begin("matte");
    nqm_error err = {0};
    const char *const good[][2] = {{"gloss-level", "1"}, {"layers", "9"}, {"seed", "12345678901"}, {"state", "wet"},
                                   {"colour", "dark"},   {"name", "x"},   {"sizes", "7,8,9"}};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; ++i)
        assert_int_equal(set(&p, good[i][0], good[i][1], NULL), NQM_OK);
    assert_true(p.gloss == 1 && p.n_layers == 9 && p.seed == 12345678901u && p.is_wet && p.colour == DARK_GREEN);
    assert_int_equal(nqm_options_check(&table, &p, NULL), NQM_OK);
    assert_true(p.n_sizes == 3 && p.sizes[2] == 9 && strcmp(p.name, "x") == 0);
    const char *const bad[][2] = {
        {"gloss-level", "1.1"}, {"gloss-level", "nan"}, {"gloss-level", ""}, {"layers", "2.5"}, {"layers", "0"},
        {"layers", "3x"},       {"seed", "-1"},         {"state", "damp"},   {"colour", "d"},   {"colour", ""},
        {"sizes", "1;2"},       {"sizes", "1,,2"},      {"sizes", "1,2,3,4"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i)
        assert_int_equal(set(&p, bad[i][0], bad[i][1], &err), NQM_ERR_ARG);
    assert_int_equal(set(&p, "layers", "10", &err), NQM_ERR_ARG);
    assert_string_equal(err.message, "layers needs a whole number from 1 to 9, not '10'");
    assert_int_equal(set(&p, "colour", "blue", &err), NQM_ERR_ARG);
    assert_string_equal(err.message, "colour needs red, dark_green, light_blue or rusty, not 'blue'");
    assert_int_equal(set(&p, "colour", "rustu", &err), NQM_ERR_ARG);
    assert_string_equal(err.message,
                        "colour needs red, dark_green, light_blue or rusty, not 'rustu' (did you mean 'rusty'?)");
}

TEST(ranges) {
    nqm_error err = {0};
    paint p = begin("matte");
    p.gloss = NAN;
    assert_int_equal(nqm_options_check(&table, &p, &err), NQM_ERR_ARG);
    assert_string_equal(err.message, "option gloss_level is nan; it must be a number from 0 to 1");
    p = begin("matte");
    p.colour = 3; /* the empty word is no value */
    assert_int_equal(nqm_options_check(&table, &p, NULL), NQM_ERR_ARG);
    p = begin("matte");
    p.n_sizes = 4;
    assert_int_equal(nqm_options_check(&table, &p, NULL), NQM_ERR_ARG);
}

TEST(names) {
    bool is_off = false;
    assert_ptr_equal(nqm_option_by_name(&table, "no-metal=", 8, &is_off), &rows[3]);
    assert_true(is_off);
    assert_null(nqm_option_by_name(&table, "no-state", 8, &is_off));
    assert_null(nqm_option_by_name(&table, "wet", 3, &is_off));
    assert_ptr_equal(nqm_option_by_key(&table, "wet"), &rows[4]);
    assert_null(nqm_option_by_key(&table, "state"));
}

TEST(as_json) {
    paint p = begin("shiny");
    json_t *json = nqm_json_from_options(&table, &p);
    char *text = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(9));
    assert_string_equal(text,
                        "{\"gloss_level\":0.9,\"layers\":2,\"metal\":true,\"wet\":false,\"colour\":\"light_blue\","
                        "\"sizes\":[4,5]}");
    free(text);
    json_decref(json);
    p.seed = UINT64_MAX;
    json = nqm_json_from_options(&table, &p);
    assert_string_equal(json_string_value(json_object_get(json, "seed")), "18446744073709551615");
    json_decref(json);
}
