/* SPDX-License-Identifier: MIT
 *
 * Specs and presets: values and defaults, messages for every kind of error, the canonical form, which opens a BRDF with
 * the same bits, and the tables of presets.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "support/check.h"
#include "support/rows.h"

#include <locale.h>

static void assert_spec(const char *text, const char *canonical) {
    nqm_brdf *brdf = must_open(text);
    assert_string_equal(nqm_brdf_get_info(brdf).spec, canonical);
    assert_string_equal(nqm_brdf_get_info(brdf).name, text);
    nqm_brdf_free(brdf);
}

TEST(test_defaults_and_single_values) {
    assert_spec("lambert:kd=.5", "lambert:kd=0.5");
    assert_spec("lambert:kd=.5,.25,5e-1;", "lambert:kd=0.5,0.25,0.5");
    assert_spec("ggx:alpha=0.25", "ggx:kd=0;ks=1;alpha=0.25;f0=0.04");
    assert_spec("ggx:f0=.9,.8,.7;alpha=.1;ks=1,1,1;kd=.2,.1,.05", "ggx:kd=0.2,0.1,0.05;ks=1;alpha=0.1;f0=0.9,0.8,0.7");
    assert_spec("ggx:alpha=.1,.4", "ggx:kd=0;ks=1;alpha=0.1,0.4;f0=0.04");
    assert_spec("ggx:alpha=.4,.40", "ggx:kd=0;ks=1;alpha=0.4;f0=0.04");
    assert_spec("tilt:deg=5;of=rotate:deg=-30;of=ward:alpha=.1,1;ks=.2",
                "tilt:deg=5;of=rotate:deg=-30;of=ward:kd=0;ks=0.2;alpha=0.1,1");
    assert_spec("ward:alpha=.1;ks=.2", "ward:kd=0;ks=0.2;alpha=0.1");
    assert_spec("perturb:gloss=.5;of=ward:alpha=.1;ks=.2", "perturb:gloss=0.5;of=ward:kd=0;ks=0.2;alpha=0.1");
    assert_spec("perturb:tint=1,2,3;scale=.5;of=lambert:kd=.1", "perturb:tint=1,2,3;scale=0.5;of=lambert:kd=0.1");
}

/* Every invalid spec gives NQM_ERR_ARG and a message that contains these words. */
TEST(test_mistakes) {
    EVERY_ROW(row, "mistakes of specs") {
        nqm_brdf *brdf = (nqm_brdf *)&brdf;
        nqm_error err = {0};
        nqm_status status = nqm_brdf_open(row[0], &brdf, &err);
        if (status != NQM_ERR_ARG || err.status != NQM_ERR_ARG || brdf)
            fail_msg("%s: status %d", row[0], status);
        for (int w = 0; w < 2; ++w)
            if (!strstr(err.message, row[1 + w]))
                fail_msg("%s: no \"%s\" in: %s", row[0], row[1 + w], err.message);
        assert_int_equal(nqm_brdf_open(row[0], &brdf, NULL), NQM_ERR_ARG);
    }
}

TEST(test_long_nonsense) {
    char spec[4096] = "ggx:";
    memset(spec + 4, 'a', sizeof spec - 5);
    nqm_brdf *brdf;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_open(spec, &brdf, &err), NQM_ERR_ARG);
    spec[2000] = '=';
    assert_int_equal(nqm_brdf_open(spec, &brdf, &err), NQM_ERR_ARG);
    memcpy(spec, "ggx:alpha=", 10);
    assert_int_equal(nqm_brdf_open(spec, &brdf, &err), NQM_ERR_ARG);
    memcpy(spec, "sgd:", 4);
    assert_int_equal(nqm_brdf_open(spec, &brdf, &err), NQM_ERR_ARG);
}

/* The canonical form of `name` opens a BRDF with the same canonical form and the same values. */
static void assert_reopens(const char *name) {
    nqm_brdf *brdf = must_open(name), *again = must_open(nqm_brdf_get_info(brdf).spec);
    assert_string_equal(nqm_brdf_get_info(brdf).spec, nqm_brdf_get_info(again).spec);
    nqm_rng rng = nqm_rng_make(1, 0);
    for (int i = 0; i < 20; ++i) {
        double u = nqm_rng_uniform(&rng);
        double hd[3] = {1.4 * u * u, 1.4 * nqm_rng_uniform(&rng), 3 * nqm_rng_uniform(&rng)}, a[3], b[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd, a, NULL);
        nqm_brdf_eval_half_diff(again, 1, hd, b, NULL);
        assert_memory_equal(a, b, sizeof a);
    }
    nqm_brdf_free(brdf);
    nqm_brdf_free(again);
}

TEST(test_canonical_form_reopens) {
    const uint64_t seed = 17;
    print_message("seed %d\n", (int)seed);
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (int i = 0; i < 50; ++i) {
        char spec[400];
        snprintf(spec, sizeof spec,
                 "perturb:noise=%.17g;peak=%.17g;of=ggx:kd=%.17g,%.17g,.3;ks=%.17g;alpha=%.17g;f0=%.17g",
                 nqm_rng_uniform(&rng), nqm_rng_uniform(&rng), nqm_rng_uniform(&rng), nqm_rng_uniform(&rng),
                 1e5 * nqm_rng_uniform(&rng), 1e-4 + nqm_rng_uniform(&rng), nqm_rng_uniform(&rng));
        assert_reopens(spec);
    }
}

/* The expected content of the preset tables. */
static const struct {
    const char *table, *model, *doi;
    size_t n_rows, n_values;
} tables[] = {
    {"sgd", "sgd", "10.1111/j.1467-8659.2012.03147.x", 100, 33},
    {"ward", "ward", "10.2312/EGWR/EGSR05/117-126", 86, 8},
    {"ward-duer", "ward-duer", "10.2312/EGWR/EGSR05/117-126", 86, 8},
    {"blinn-phong", "blinn-phong", "10.2312/EGWR/EGSR05/117-126", 86, 7},
    {"lafortune", "lafortune", "10.2312/EGWR/EGSR05/117-126", 86, 9},
    {"cook-torrance", "cook-torrance", "10.2312/EGWR/EGSR05/117-126", 86, 8},
    {"ashikhmin-shirley", "ashikhmin-shirley", "10.2312/EGWR/EGSR05/117-126", 86, 9},
    {"low-cook-torrance", "low-cook-torrance", "10.1145/2077341.2077350", 100, 8},
    {"low-cook-torrance-e1", "low-cook-torrance", "10.1145/2077341.2077350", 100, 8},
    {"low-ashikhmin-shirley", "low-ashikhmin-shirley", "10.1145/2077341.2077350", 100, 9},
    {"low-ashikhmin-shirley-e1", "low-ashikhmin-shirley", "10.1145/2077341.2077350", 100, 9},
    {"abc", "abc", "10.1145/2077341.2077350", 100, 9},
    {"smooth", "smooth", "10.1145/2077341.2077350", 100, 9},
    {"physical", "open-pbr", "", 110, 29},
};
enum { N_TABLES = sizeof tables / sizeof *tables };

static size_t table_of(const char *preset) {
    size_t t = 0, n = strcspn(preset, ":");
    while (t < N_TABLES && !(strncmp(tables[t].table, preset, n) == 0 && tables[t].table[n] == 0))
        ++t;
    return t;
}

TEST(test_presets) {
    size_t n_found[N_TABLES] = {0};
    for (size_t i = 0; nqm_brdf_preset_name(i); ++i) {
        const char *name = nqm_brdf_preset_name(i);
        assert_null(strchr(name, '='));
        size_t t = table_of(name);
        assert_true(t < N_TABLES);
        ++n_found[t];
        for (size_t j = 0; j < i; ++j)
            assert_string_not_equal(name, nqm_brdf_preset_name(j));
        nqm_brdf *brdf = must_open(name);
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_string_equal(info.name, name);
        assert_string_equal(info.format, tables[t].model);
        assert_string_equal(info.source_doi, tables[t].doi);
        assert_int_equal(info.n_values, tables[t].n_values);
        nqm_brdf_free(brdf);
        assert_reopens(name);
    }
    for (size_t t = 0; t < N_TABLES; ++t)
        assert_int_equal(n_found[t], tables[t].n_rows);
}

/* Parameters as printed in the publications (Ngan's: green and blue times the colour scale). */
TEST(test_published_numbers) {
    nqm_brdf *gold = must_open("open-pbr:base_color=1.059,.773,.307;base_metalness=1;specular_color=.971,1.018,.994;"
                               "specular_roughness=0;specular_ior=1.5");
    assert_spec("physical:gold", nqm_brdf_get_info(gold).spec);
    nqm_brdf_free(gold);
    assert_spec("ward:nickel", "ward:kd=0.0221,0.02047,0.017762;ks=0.204,0.1771,0.157036;alpha=0.0432");
    assert_spec("blinn-phong:blue-acrylic",
                "blinn-phong:kd=0.0147,0.03818,0.10624;ks=0.0016,0.0013225,0.00117694;n=13700");
    assert_spec("low-cook-torrance-e1:alum-bronze",
                "low-cook-torrance:kd=0.1063,0.0816,0.0557;ks=0.05872,0.04367,0.05223;alpha=0.017044;eta=1.46492");
    assert_spec("abc:alum-bronze",
                "abc:kd=0.0245,0.0223,0.0162;ks=51.7146,37.9327,27.3731;B=10482.1;C=0.816737;eta=2.23652");
    assert_spec("sgd:chrome", "sgd:kd=0.00697189,0.00655268,0.0101854;ks=0.0930656,0.041946,0.104558;"
                              "alpha=0.000155335,0.000156872,7.39851e-05;p=0.353854,0.3327,0.300437;"
                              "f0=0.256314,0.819565,3.22085e-13;f1=-0.743686,-0.180435,-1;K=4642.1,4726.66,10421.9;"
                              "lambda=3.8545,4.44817,5.40959;c=5.30781e-08,1.04045e-07,1.79834e+66;"
                              "k=354.965,349.356,272.736;theta0=0.526796,0.528469,1.00293");
}

/* Strings composed of pieces of specs: each opens and can be evaluated, or is refused with a message. */
TEST(test_random_texts) {
    size_t n_pieces;
    const table_row *pieces = table_rows("pieces of specs", &n_pieces);
    const uint64_t seed = 23;
    print_message("seed %d\n", (int)seed);
    nqm_rng rng = nqm_rng_make(seed, 0);
    size_t n_opened = 0;
    for (int i = 0; i < 20000; ++i) {
        char text[256];
        size_t used = (size_t)snprintf(text, sizeof text, "%s", pieces[nqm_rng_below(&rng, 8)][0]);
        for (uint64_t n = 1 + nqm_rng_below(&rng, 4); n > 0; --n)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s", pieces[nqm_rng_below(&rng, n_pieces)][0]);
        nqm_brdf *brdf;
        nqm_error err = {0};
        nqm_status status = nqm_brdf_open(text, &brdf, &err);
        if (status != NQM_OK) {
            assert_null(brdf);
            assert_true(err.status == status && err.message[0]);
            continue;
        }
        const double hd[3] = {0.1, 0.7, 1};
        double rgb[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        assert_true(rgb[0] >= 0 && rgb[0] < 1e300);
        nqm_brdf_free(brdf);
        ++n_opened;
    }
    print_message("%zu opened\n", n_opened);
    assert_true(n_opened > 100);
}

TEST(test_decimal_comma_locale) {
    if (!setlocale(LC_ALL, "de_DE.UTF-8"))
        skip();
    assert_spec("lambert:kd=.5,.25,.125", "lambert:kd=0.5,0.25,0.125");
    setlocale(LC_ALL, "C");
}
