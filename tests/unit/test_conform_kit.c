/* SPDX-License-Identifier: MIT
 *
 * Kits of shading models: specs are what the parameters say, planted mistakes are found, and faults are told.
 */
#include "conform/conform.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scratch.h"
#include "support/tiny_model.h"

#include <string.h>

enum { N = 70 };

static nqm_model *metric;

static nqm_conform_kit *make_kit(const char *model, const char *keys) {
    nqm_conform_kit *kit = NULL;
    nqm_error err = {0};
    if (!metric)
        assert_int_equal(make_tiny_model(N, &metric, &err), NQM_OK);
    if (nqm_conform_kit_create(model, keys, metric, &kit, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return kit;
}

static void end_kit(nqm_conform_kit *kit, float *values) {
    nqm_free(values);
    nqm_conform_kit_free(kit);
    nqm_model_free(metric);
    metric = NULL;
}

/* The right values of a kit, times a factor; nqm_free(). */
static float *values_of(const nqm_conform_kit *kit, float factor) {
    const nqm_conform_suspect none = {0};
    float *values = nqm_alloc(3 * kit->n_sets * N, sizeof *values);
    for (size_t set = 0; set < kit->n_sets; ++set)
        nqm_conform_sample(kit, set, &none, 1, false, values + 3 * N * set);
    for (size_t i = 0; i < 3 * kit->n_sets * N; ++i)
        values[i] *= factor;
    return values;
}

/* The spec of a set at the directions of the metric has the values of its parameters at the directions of the set. */
TEST(specs_are_the_parameters) {
    for (size_t m = 0; nqm_schema_shading(m); ++m) {
        nqm_conform_kit *kit = make_kit(nqm_schema_shading(m)->model, NULL);
        const nqm_conform_info info = nqm_conform_kit_get_info(kit, 0);
        const nqm_directions *directions = nqm_model_get_info(metric).directions;
        float *values = values_of(kit, 1);
        assert_true(info.n_sets >= 64 && info.n_directions == N);
        for (size_t set = 0; set < info.n_sets; ++set) {
            const nqm_conform_info s = nqm_conform_kit_get_info(kit, set);
            double rgb[3 * N];
            nqm_brdf *brdf = must_open(s.spec);
            nqm_brdf_eval(brdf, N, nqm_directions_get_info(directions).wi, nqm_directions_get_info(directions).wo, rgb,
                          NULL);
            for (size_t i = 0; i < 3 * N; ++i)
                assert_near((double)values[3 * N * set + i], rgb[i], 1e-4 * (1 + rgb[i]));
            for (size_t c = 0; c < info.n_columns; ++c)
                assert_true(isfinite(s.values[c]));
            nqm_brdf_free(brdf);
        }
        assert_null(nqm_conform_kit_get_info(kit, info.n_sets).spec);
        end_kit(kit, values);
    }
}

TEST(mistakes_are_found) {
    static const struct {
        float factor;
        const char *text; /* NULL: none */
    } cases[] = {
        {1, NULL}, {3.14159265F, "the values are pi times too large"}, {0.318309886F, "the values are divided by pi"}};
    nqm_conform_kit *kit = make_kit("openpbr", "base_color,base_metalness,specular_roughness");
    nqm_score_result results[NQM_CONFORM_MAX_SETS];
    nqm_conform_report report;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        float *values = values_of(kit, cases[k].factor);
        assert_int_equal(nqm_conform_compare(kit, values, NULL, NULL, results, &report, NULL), NQM_OK);
        assert_int_equal(report.n_mistakes > 0, cases[k].text != NULL);
        assert_int_equal(report.n_passed == kit->n_sets, cases[k].text == NULL);
        assert_int_equal(*report.most != 0, cases[k].text != NULL);
        assert_string_equal(report.mistakes[0].text, cases[k].text ? cases[k].text : "");
        if (cases[k].text)
            assert_near(report.largest.value / report.largest.right, (double)cases[k].factor, 1e-5);
        nqm_free(values);
    }
    end_kit(kit, NULL);
}

TEST(values_that_do_not_count) {
    nqm_conform_kit *kit = make_kit("disney", "baseColor");
    float *values = values_of(kit, 1);
    nqm_score_result results[NQM_CONFORM_MAX_SETS];
    nqm_conform_report report;
    values[1] = NAN;
    values[3 * N + 5] = INFINITY;
    values[7] = -1;
    for (size_t i = 0; i < 3 * N; ++i)
        values[6 * N + i] = NAN;
    assert_int_equal(nqm_conform_compare(kit, values, NULL, NULL, results, &report, NULL), NQM_OK);
    assert_int_equal(results[0].n_invalid[1], 1);
    assert_int_equal(results[0].n_clamped[1], 1);
    assert_int_equal(results[1].n_invalid[1], 1);
    assert_int_equal(results[1].status, NQM_OK);
    assert_int_equal(results[2].status, NQM_ERR_INCOMPATIBLE);
    assert_true(isnan(results[2].jod));
    assert_true(report.n_passed < kit->n_sets && !report.is_named && isfinite(report.lowest_jod));
    for (size_t i = 0; i < 3 * N * kit->n_sets; ++i)
        values[i] = NAN;
    assert_int_equal(nqm_conform_compare(kit, values, NULL, NULL, results, &report, NULL), NQM_OK);
    assert_int_equal(report.n_passed, 0);
    assert_int_equal(report.n_mistakes, 0);
    assert_string_equal(report.most, "");
    end_kit(kit, values);
}

static int stop(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage, (void)done, (void)total;
    return 1;
}

TEST(faults_are_told) {
    static const struct {
        const char *model, *keys, *words;
    } cases[] = {{"ggx", NULL, "'ggx' is no shading model; there are rough-plastic"},
                 {"pbrt-coated-diffuse", NULL, "is no shading model"},
                 {"gltf", "roughness,gloss", "gltf has no 'gloss'; it has base_color, metallic"}};
    nqm_conform_kit *kit = make_kit("gltf", "roughness"), *other = kit;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        nqm_error err = {0};
        assert_int_equal(nqm_conform_kit_create(cases[k].model, cases[k].keys, metric, &other, &err), NQM_ERR_ARG);
        assert_null(other);
        assert_non_null(strstr(err.message, cases[k].words));
    }
    nqm_error err = {0};
    assert_int_equal(nqm_conform_kit_write(kit, NULL, scratch_path("kit.metal"), &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "csv, glsl, hlsl or h"));
    assert_int_equal(nqm_conform_kit_write(kit, "h", scratch_path("no/kit.h"), &err), NQM_ERR_IO);
    float *values = values_of(kit, 2);
    nqm_score_result results[NQM_CONFORM_MAX_SETS];
    nqm_conform_report report;
    nqm_conform_proof proof;
    assert_int_equal(nqm_conform_compare(kit, values, stop, NULL, results, &report, &err), NQM_ERR_CANCELLED);
    assert_int_equal(nqm_conform_prove(kit, stop, NULL, &proof, &err), NQM_ERR_CANCELLED);
    end_kit(kit, values);
}

TEST(allocations_may_fail) {
    nqm_conform_kit *kit = NULL;
    nqm_score_result results[NQM_CONFORM_MAX_SETS];
    nqm_conform_report report;
    nqm_conform_proof proof;
    nqm_status status = NQM_OK;
    nqm_conform_kit_free(make_kit("pbrt-conductor", NULL)); /* makes the metric */
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_conform_kit_free(kit);
        status = nqm_conform_kit_create("pbrt-conductor", NULL, metric, &kit, NULL);
    }
    float *values = values_of(kit, 2);
    n = -1;
    EVERY_ALLOCATION(n, status, 10) {
        status = nqm_conform_compare(kit, values, NULL, NULL, results, &report, NULL);
    }
    n = -1;
    EVERY_ALLOCATION(n, status, 10) {
        status = nqm_conform_prove(kit, NULL, NULL, &proof, NULL);
    }
    end_kit(kit, values);
}
