/* SPDX-License-Identifier: MIT
 *
 * Polarimetric materials: values against numpy (tests/vectors/brdf.py), and broken files.
 */
#include "base/base.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/vectors.h"

#include <nqm/brdf.h>

enum { N_PAIRS = VECTOR_PAIRS };

static const char *save(blob b) {
    return blob_put(b, scratch_path("material.pbsdf"));
}

static nqm_brdf *open_under(const char *path, const char *suffix) {
    char argument[4200];
    snprintf(argument, sizeof argument, "%s%s", path, suffix);
    return must_open(argument);
}

TEST(agrees_with_numpy) {
    const char *path = save(make_pbsdf(NULL));
    for (int k = 0; k < 2; ++k) {
        nqm_brdf *brdf = open_under(path, k ? ":D65" : "");
        const double(*expected)[3] = k ? rgb_vector("pbsdf_d65") : rgb_vector("pbsdf");
        size_t n_valid = 0;
        for (size_t i = 0; i < N_PAIRS; ++i) {
            double rgb[3];
            uint8_t flag;
            nqm_brdf_eval(brdf, 1, pair_vector[i], pair_vector[i] + 3, rgb, &flag);
            bool valid = isfinite(expected[i][0]) != 0;
            assert_int_equal(nqm_has_value(flag), valid);
            n_valid += valid;
            for (size_t c = 0; valid && c < 3; ++c)
                assert_near(rgb[c], fmax(expected[i][c], 0), 2e-6);
        }
        assert_true(n_valid > N_PAIRS - 10);
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_string_equal(info.format, "pbsdf");
        assert_string_equal(info.source_doi, "10.1145/3386569.3392387");
        assert_non_null(strstr(info.layout, "5 theta_h x 4 theta_d x 6 phi_d, 5 wavelengths 450 to 650 nm"));
        assert_non_null(strstr(info.layout, k ? "illuminant D65" : "illuminant E"));
        assert_int_equal(info.n_values, 6 * 4 * 5 * 5);
        assert_int_equal(info.reciprocal, 0);
        nqm_brdf_free(brdf);
    }
}

TEST(refuses_unfit_tensors) {
    static const char *const needed[] = {"theta_h", "theta_d", "phi_d", "wvls"};
    static const float falling[5] = {0, 0.5F, 0.25F, 1, 1.5F}, degrees[4] = {0, 30, 60, 90};
    static const float infrared[5] = {700, 750, 800, 850, 900};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; ++i) {
        must_refuse(save(make_pbsdf(&(rgl_change){.name = needed[i], .omit = true})), NQM_ERR_FORMAT, "has no tensor");
        must_refuse(save(make_pbsdf(&(rgl_change){.name = needed[i], .type = 1, .n_dims = 1, .dims = {4}})),
                    NQM_ERR_FORMAT, "type");
    }
    must_refuse(save(make_pbsdf(&(rgl_change){"theta_h", false, 10, 1, {5}, falling})), NQM_ERR_FORMAT,
                "does not rise");
    must_refuse(save(make_pbsdf(&(rgl_change){"theta_d", false, 10, 1, {4}, degrees})), NQM_ERR_FORMAT, "radians");
    must_refuse(save(make_pbsdf(&(rgl_change){"theta_d", false, 10, 1, {3}, degrees})), NQM_ERR_FORMAT,
                "one angle for each");
    must_refuse(save(make_pbsdf(&(rgl_change){"wvls", false, 3, 1, {4}, infrared})), NQM_ERR_FORMAT,
                "each of two or more");
    must_refuse(save(make_pbsdf(&(rgl_change){"wvls", false, 3, 1, {5}, infrared})), NQM_ERR_FORMAT,
                "500 to at least 600");
    must_refuse(save(make_pbsdf(&(rgl_change){"M", false, 10, 6, {6, 4, 5, 5, 4, 3}, NULL})), NQM_ERR_FORMAT, "4 x 4");
    must_refuse(save(make_pbsdf(&(rgl_change){"M", false, 10, 5, {6, 4, 5, 5, 16}, NULL})), NQM_ERR_FORMAT, "4 x 4");
    must_refuse(save(make_pbsdf(&(rgl_change){"M", false, 1, 6, {6, 4, 5, 5, 4, 4}, NULL})), NQM_ERR_FORMAT, "type");
}

TEST_FILE(read_pair_vector, NULL)
