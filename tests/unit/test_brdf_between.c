/* SPDX-License-Identifier: MIT
 *
 * BRDFs between two others against their definition, computed here from both; their specs.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/rows.h"

static const char metal[] = "ggx:ks=1;alpha=.1;f0=.9,.7,.4", matte[] = "lambert:kd=.5,.1,0";
static const double places[][3] = {{0, 0, 0}, {0.01, 0.2, 0.3}, {0.2, 0.5, 1.5}, {0.6, 0.3, 2}, {0.1, 1.3, 1.6}};
enum { N_PLACES = sizeof places / sizeof *places };

static void values_of(const char *spec, double rgb[3 * N_PLACES]) {
    nqm_brdf *brdf = must_open(spec);
    nqm_brdf_eval_half_diff(brdf, N_PLACES, places[0], rgb, NULL);
    nqm_brdf_free(brdf);
}

TEST(means_are_those_of_both) {
    double of[3 * N_PLACES], with[3 * N_PLACES], rgb[3 * N_PLACES];
    values_of(metal, of);
    values_of(matte, with);
    for (int step = 0; step <= 4; ++step) {
        char spec[256];
        double t = 0.25 * step;
        snprintf(spec, sizeof spec, "between:t=%g;with=(%s);of=%s", t, matte, metal);
        values_of(spec, rgb);
        for (int i = 0; i < 3 * N_PLACES; ++i)
            assert_relative(rgb[i], (1 - t) * of[i] + t * with[i], 1e-14);
        snprintf(spec, sizeof spec, "between:t=%g;log=1;with=(%s);of=%s", t, matte, metal);
        values_of(spec, rgb);
        for (int i = 0; i < 3 * N_PLACES; ++i)
            assert_relative(rgb[i], pow(of[i], 1 - t) * pow(with[i], t), 1e-14);
    }
}

/* The order of light and viewer is that of both. */
TEST(orders_are_kept) {
    static const char coated[] = "gltf:metallic=0;roughness=.5;clearcoat=1;clearcoat_roughness=.3";
    char spec[256];
    snprintf(spec, sizeof spec, "between:t=.25;with=(%s);of=%s", coated, matte);
    nqm_brdf *a = must_open(matte), *b = must_open(coated), *mixed = must_open(spec);
    const double near_wi[3] = {0.1, 0.2, sqrt(0.95)}, far_wo[3] = {-0.9, 0.3, sqrt(0.1)};
    double of[3], with[2][3], rgb[2][3];
    for (int order = 0; order < 2; ++order) {
        const double *wi = order ? far_wo : near_wi, *wo = order ? near_wi : far_wo;
        nqm_brdf_eval(a, 1, wi, wo, of, NULL);
        nqm_brdf_eval(b, 1, wi, wo, with[order], NULL);
        nqm_brdf_eval(mixed, 1, wi, wo, rgb[order], NULL);
        for (int c = 0; c < 3; ++c)
            assert_relative(rgb[order][c], 0.75 * of[c] + 0.25 * with[order][c], 1e-12);
    }
    assert_true(fabs(with[1][0] / with[0][0] - 1) > 0.02);
    assert_int_equal(nqm_brdf_get_info(mixed).reciprocal, 0);
    nqm_brdf_free(a);
    nqm_brdf_free(b);
    nqm_brdf_free(mixed);
}

TEST(specs_open_again) {
    EVERY_ROW(row, "specs of between:") {
        nqm_brdf *brdf = must_open(row[0]);
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        double once[3 * N_PLACES], again[3 * N_PLACES];
        assert_string_equal(info.name, row[0]);
        assert_int_equal(info.reciprocal, 1);
        if (row[1])
            assert_string_equal(info.spec, row[1]);
        values_of(row[0], once);
        values_of(info.spec, again);
        assert_memory_equal(once, again, sizeof once);
        nqm_brdf_free(brdf);
    }
}

TEST(mistakes_are_named) {
    EVERY_ROW(row, "mistakes of between:") {
        nqm_brdf *brdf;
        nqm_error err = {0};
        assert_int_equal(nqm_brdf_open(row[0], &brdf, &err), status_of(row[2]));
        assert_null(brdf);
        if (!strstr(err.message, row[1]))
            fail_msg("%s: %s", row[0], err.message);
    }
}

/* No value where one of the two has none. */
TEST(gaps_of_both) {
    char spec[2][4096];
    const char *path = scratch_path("gaps.binary");
    blob_put(make_merl(), path);
    snprintf(spec[0], sizeof spec[0], "between:t=.5;with=(%s);of=lambert:kd=.1", path);
    snprintf(spec[1], sizeof spec[1], "between:t=.5;with=(lambert:kd=.1);of=%s", path);
    nqm_brdf *base = must_open(path);
    size_t n_gaps = 0;
    for (int k = 0; k < 2; ++k) {
        nqm_brdf *between = must_open(spec[k]);
        for (int i = 1; i < 80; ++i) {
            const double hd[3] = {i * NQM_PI / 180, NQM_PI / 4, NQM_PI / 2};
            double rgb[6];
            uint8_t flag[2];
            nqm_brdf_eval_half_diff(base, 1, hd, rgb, flag);
            nqm_brdf_eval_half_diff(between, 1, hd, rgb + 3, flag + 1);
            assert_int_equal(nqm_has_value(flag[0]), nqm_has_value(flag[1]));
            n_gaps += !nqm_has_value(flag[0]);
        }
        nqm_brdf_free(between);
    }
    assert_true(n_gaps > 10);
    nqm_brdf_free(base);
}

TEST(memory_runs_out) {
    assert_true(check_brdf_allocations("between:t=.5;with=(lambert:kd=.1);of=perturb:scale=2;of=lambert:kd=.2") >= 10);
}
