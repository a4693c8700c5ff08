/* SPDX-License-Identifier: MIT
 *
 * UTIA measurements: values against numpy (tests/vectors/brdf.py), broken files, and other files of the same size.
 */
#include "base/base.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/vectors.h"

#include <nqm/brdf.h>

enum { N_PAIRS = VECTOR_PAIRS };

static const char *save(blob b) {
    return blob_put(b, scratch_path("material.bin"));
}

TEST(agrees_with_numpy) {
    nqm_brdf *brdf = must_open(save(make_utia()));
    assert_true(check_brdf_values(brdf, N_PAIRS, pair_vector, rgb_vector("utia"), 1e-7) > 3);
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "utia");
    assert_string_equal(info.layout, "6 theta_i x 48 phi_i x 6 theta_v x 48 phi_v");
    assert_int_equal(info.n_values, UTIA_BYTES / 8);
    assert_int_equal(info.n_bytes, UTIA_BYTES);
    assert_int_equal(info.reciprocal + info.isotropic, 0);
    nqm_brdf_check_report report;
    assert_int_equal(nqm_brdf_check(brdf, 1, &report, NULL), NQM_OK);
    assert_true(report.anisotropy > 0.1);
    nqm_brdf_free(brdf);
}

/* A turn of the sample by a step of the azimuths moves the values of the file. */
TEST(azimuths_count_from_the_tangent) {
    blob b = make_utia(), turned = {.data = blob_load(save(make_utia())).data, .n_bytes = UTIA_BYTES};
    const size_t n = 48;
    for (size_t i = 0; i < UTIA_BYTES / 8; ++i) {
        const size_t pv = i % n, tv = i / n % 6, pi = i / n / 6 % n, rest = i / n / 6 / n;
        const size_t to = ((rest * n + (pi + 4) % n) * 6 + tv) * n + (pv + 4) % n;
        memcpy(turned.data + 8 * to, b.data + 8 * i, 8);
    }
    nqm_brdf *first = must_open(save(b));
    nqm_brdf *second = must_open(save(turned));
    for (size_t i = 4; i < N_PAIRS; ++i) {
        double a[3], c[3], w[6];
        for (size_t k = 0; k < 6; k += 3) { /* by 30 degrees */
            const double *v = pair_vector[i] + k;
            w[k] = sqrt(0.75) * v[0] - 0.5 * v[1];
            w[k + 1] = 0.5 * v[0] + sqrt(0.75) * v[1];
            w[k + 2] = v[2];
        }
        nqm_brdf_eval(first, 1, pair_vector[i], pair_vector[i] + 3, a, NULL);
        nqm_brdf_eval(second, 1, w, w + 3, c, NULL);
        assert_near(a[0], c[0], 1e-6);
    }
    nqm_brdf_free(first);
    nqm_brdf_free(second);
}

static void expect_refused(blob b, int64_t at, const char *words) {
    assert_int_equal(must_refuse(save(b), NQM_ERR_FORMAT, words).byte_offset, at);
}

TEST(refuses_other_files) {
    static const double bad[] = {NAN, INFINITY, -1e300};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        blob b = make_utia();
        nqm_store_f64(b.data + 80008, bad[i]);
        expect_refused(b, 80008, "value at byte 80008 is not finite");
    }
    for (int longer = -8; longer <= 8; longer += 16) { /* not recognised */
        blob b = make_utia();
        b.n_bytes = (size_t)(UTIA_BYTES + longer);
        const char *path = scratch_path("other.bin");
        blob_save_sparse(&(blob){b.data, UTIA_BYTES - 8}, b.n_bytes, path);
        nqm_brdf *brdf;
        assert_int_equal(nqm_brdf_open(path, &brdf, NULL), NQM_ERR_FORMAT);
        blob_free(&b);
    }
    blob text = make_utia(); /* of the right size, but it begins as a file of another kind */
    memcpy(text.data, "<?xml version='1.0'?>", 21);
    expect_refused(text, 0, "byte 0");
    assert_true(check_brdf_allocations(save(make_utia())) >= 2);
}

TEST_FILE(read_pair_vector, NULL)
