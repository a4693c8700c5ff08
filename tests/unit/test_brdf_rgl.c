/* SPDX-License-Identifier: MIT
 *
 * RGL materials: values against numpy (tests/vectors/brdf.py), and broken files of every kind.
 */
#include "base/base.h"
#include "io/io.h"
#include "math/math.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/vectors.h"

#include <nqm/brdf.h>

enum { N_PAIRS = VECTOR_PAIRS };

static const char *save(blob b) {
    return blob_put(b, scratch_path("material.bsdf"));
}

TEST(agrees_with_numpy) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_open(save(make_rgl(NULL)), &brdf, NULL), NQM_OK);
    const size_t n_clamped = check_brdf_values(brdf, N_PAIRS, pair_vector, rgb_vector("rgl"), 1e-11);
    assert_true(n_clamped > 3 && n_clamped < N_PAIRS - 3);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "rgl");
    assert_string_equal(info.layout, "4 angles of incidence x 5 x 7 samples, warp 6 x 8");
    assert_string_equal(info.source_doi, "10.1145/3272127.3275059");
    assert_int_equal(info.n_values, 420 + 192 + 18 + 14);
    assert_int_equal(info.reciprocal, 0);
    nqm_brdf_free(brdf);
}

/* Several phi_i: over a turn, and over a half and a quarter of it by symmetry; also spectra. */
TEST(anisotropic_files_agree_with_numpy) {
    static const struct {
        size_t reduction;
        bool is_spectral;
        const char *vector, *layout;
    } cases[] = {{1, false, "rgl_1", "5 azimuths x 4 angles of incidence x 5 x 7 samples, warp 6 x 8"},
                 {2, false, "rgl_2", "4 azimuths x 4 angles of incidence x 5 x 7 samples, warp 6 x 8"},
                 {4, false, "rgl_4", "3 azimuths x 4 angles of incidence x 5 x 7 samples, warp 6 x 8"},
                 {2, true, "rgl_2_d65",
                  "4 azimuths x 4 angles of incidence x 5 x 7 samples, warp 6 x 8, 9 wavelengths 360 to 1000 nm under "
                  "illuminant D65"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        const double tolerance = cases[k].is_spectral ? 1e-5 : 1e-11; /* values are stored as float32 */
        char argument[4200];
        snprintf(argument, sizeof argument, "%s%s",
                 save(make_anisotropic_rgl(cases[k].reduction, cases[k].is_spectral, NULL)),
                 cases[k].is_spectral ? ":D65" : "");
        nqm_brdf *brdf = must_open(argument);
        /* The first four are at the edges of the symmetries, where these data jump. */
        check_brdf_values(brdf, N_PAIRS - 4, pair_vector + 4, rgb_vector(cases[k].vector) + 4, tolerance);
        assert_string_equal(nqm_brdf_get_info(brdf).layout, cases[k].layout);
        assert_int_equal(nqm_brdf_get_info(brdf).isotropic, 0);
        nqm_brdf_free(brdf);
    }
}

/* Rotation about the normal does not change the value; half-vector coordinates distinguish light and viewer. */
TEST(is_isotropic) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_open(save(make_rgl(NULL)), &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_get_info(brdf).isotropic, 1);
    for (size_t i = 4; i < N_PAIRS; ++i) {
        double rgb[3], turned_rgb[3], hd[3], hd_rgb[3], turned[6];
        for (size_t k = 0; k < 6; k += 3) {
            turned[k] = 0.6 * pair_vector[i][k] - 0.8 * pair_vector[i][k + 1];
            turned[k + 1] = 0.8 * pair_vector[i][k] + 0.6 * pair_vector[i][k + 1];
            turned[k + 2] = pair_vector[i][k + 2];
        }
        nqm_brdf_eval(brdf, 1, pair_vector[i], pair_vector[i] + 3, rgb, NULL);
        nqm_brdf_eval(brdf, 1, turned, turned + 3, turned_rgb, NULL);
        /* The coordinates reduce phi_d by reciprocity, but measured data are not reciprocal: undo that with the
         * vectors. */
        double wi[3], wo[3];
        nqm_directions_to_half_diff(pair_vector[i], pair_vector[i] + 3, hd);
        nqm_half_diff_to_directions(hd, wi, wo);
        if (fabs(wi[2] - pair_vector[i][2]) > 1e-9)
            hd[2] += 3.14159265358979323846;
        nqm_brdf_eval_half_diff(brdf, 1, hd, hd_rgb, NULL);
        for (size_t c = 0; c < 3; ++c) {
            assert_near(turned_rgb[c], rgb[c], 1e-10 * (1 + rgb[c]));
            assert_near(hd_rgb[c], rgb[c], 1e-10 * (1 + rgb[c]));
        }
    }
    nqm_brdf_free(brdf);
}

/* Spectra become RGB under the illuminant that the argument names, E by default. */
TEST(converts_spectra) {
    const char *path = save(make_spectral_rgl(NULL));
    const struct {
        const char *suffix, *layout, *vector;
    } cases[] = {{"", "under illuminant E", "rgl_e"},
                 {":E", "under illuminant E", "rgl_e"},
                 {":D65", "under illuminant D65", "rgl_d65"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        char argument[4200];
        nqm_brdf *brdf;
        snprintf(argument, sizeof argument, "%s%s", path, cases[k].suffix);
        assert_int_equal(nqm_brdf_open(argument, &brdf, NULL), NQM_OK);
        const double(*expected)[3] = rgb_vector(cases[k].vector);
        for (size_t i = 0; i < N_PAIRS; ++i) {
            double rgb[3];
            nqm_brdf_eval(brdf, 1, pair_vector[i], pair_vector[i] + 3, rgb, NULL);
            for (size_t c = 0; c < 3; ++c)
                assert_near(rgb[c], fmax(expected[i][c], 0), 2e-6 * (1 + fabs(expected[i][c])));
        }
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_string_equal(info.name, argument);
        assert_non_null(strstr(info.layout, "9 wavelengths 360 to 1000 nm"));
        assert_non_null(strstr(info.layout, cases[k].layout));
        assert_int_equal(info.n_values, 1260 + 192 + 18 + 14);
        nqm_brdf_free(brdf);
    }
}

/* Equal values at all wavelengths are grey under both illuminants, also with the 195 wavelengths of the database. */
TEST(keeps_white) {
    enum { MOST = 195 };
    for (size_t n = 2; n <= MOST; n = n == 2 ? 5 : n == 5 ? MOST : MOST + 1)
        for (int k = 0; k < 2; ++k) {
            float nm[MOST];
            double weights[3 * MOST], sum[3] = {0};
            for (size_t i = 0; i < n; ++i)
                nm[i] = 360 + 640 * (float)i / (float)(n - 1);
            assert_true(nqm_spectrum_is_visible(n, nm));
            nqm_spectrum_weights(k ? NQM_ILLUMINANT_D65 : NQM_ILLUMINANT_E, n, nm, weights);
            for (size_t i = 0; i < 3 * n; ++i)
                sum[i % 3] += weights[i];
            for (size_t c = 0; c < 3; ++c)
                assert_near(sum[c], 1, 1e-14);
        }
    assert_false(nqm_spectrum_is_visible(1, (float[]){550}));
    assert_false(nqm_spectrum_is_visible(3, (float[]){400, 400, 700}));
    assert_false(nqm_spectrum_is_visible(2, (float[]){0.4F, 0.7F}));
    assert_false(nqm_spectrum_is_visible(2, (float[]){510, 700}));
    assert_false(nqm_spectrum_is_visible(2, (float[]){400, NAN}));
}

TEST(refuses_unfit_spectra) {
    static float bad[1260];
    static const float micrometres[9] = {0.36F, 0.42F, 0.45F, 0.5F, 0.54F, 0.58F, 0.62F, 0.7F, 1};
    must_refuse(save(make_spectral_rgl(&(rgl_change){.name = "wavelengths", .omit = true})), NQM_ERR_FORMAT,
                "has no tensor 'wavelengths'");
    must_refuse(save(make_spectral_rgl(&(rgl_change){.name = "wavelengths", .type = 10, .n_dims = 1, .dims = {8}})),
                NQM_ERR_FORMAT, "one value for each of `wavelengths`");
    must_refuse(save(make_spectral_rgl(
                    &(rgl_change){.name = "wavelengths", .type = 10, .n_dims = 1, .dims = {9}, .values = micrometres})),
                NQM_ERR_FORMAT, "500 to at least 600 nm");
    must_refuse(
        save(make_spectral_rgl(&(rgl_change){.name = "spectra", .type = 10, .n_dims = 5, .dims = {1, 3, 9, 5, 7}})),
        NQM_ERR_FORMAT, "one value for each");
    bad[1000] = NAN;
    must_refuse(save(make_spectral_rgl(
                    &(rgl_change){.name = "spectra", .type = 10, .n_dims = 5, .dims = {1, 4, 9, 5, 7}, .values = bad})),
                NQM_ERR_FORMAT, "'spectra' contains nan");
}

TEST(refuses_unfit_tensors) {
    static const char *const needed[] = {"phi_i", "theta_i", "sigma", "ndf", "vndf", "rgb"};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; ++i) {
        must_refuse(save(make_rgl(&(rgl_change){.name = needed[i], .omit = true})), NQM_ERR_FORMAT, "has no tensor");
        must_refuse(save(make_rgl(&(rgl_change){.name = needed[i], .type = 1, .n_dims = 1, .dims = {4}})),
                    NQM_ERR_FORMAT, "type or shape");
        must_refuse(save(make_rgl(&(rgl_change){.name = needed[i], .type = 10, .n_dims = 3, .dims = {1, 1, 4}})),
                    NQM_ERR_FORMAT, "type or shape");
    }
    must_refuse(save(make_rgl(&(rgl_change){.name = "phi_i", .type = 10, .n_dims = 1, .dims = {8}})), NQM_ERR_FORMAT,
                "each phi_i");
    must_refuse(save(make_rgl(&(rgl_change){.name = "phi_i", .type = 10, .n_dims = 1, .dims = {0}})), NQM_ERR_FORMAT,
                "is empty");
    must_refuse(save(make_spectral_rgl(&(rgl_change){.name = "wavelengths", .type = 10, .n_dims = 1, .dims = {0}})),
                NQM_ERR_FORMAT, "is empty");
    must_refuse(save(make_rgl(&(rgl_change){.name = "theta_i", .type = 10, .n_dims = 1, .dims = {1}})), NQM_ERR_FORMAT,
                "two angles");
    must_refuse(save(make_rgl(&(rgl_change){.name = "theta_i", .type = 10, .n_dims = 1, .dims = {5}})), NQM_ERR_FORMAT,
                "phi_i and theta_i");
    must_refuse(save(make_rgl(&(rgl_change){.name = "sigma", .type = 10, .n_dims = 2, .dims = {1, 7}})), NQM_ERR_FORMAT,
                "2 x 2");
    must_refuse(save(make_rgl(&(rgl_change){.name = "ndf", .type = 10, .n_dims = 2, .dims = {9, 1}})), NQM_ERR_FORMAT,
                "2 x 2");
    must_refuse(save(make_rgl(&(rgl_change){.name = "vndf", .type = 10, .n_dims = 4, .dims = {1, 4, 6, 0}})),
                NQM_ERR_FORMAT, "2 x 2");
    must_refuse(save(make_rgl(&(rgl_change){.name = "vndf", .type = 10, .n_dims = 4, .dims = {1, 3, 6, 8}})),
                NQM_ERR_FORMAT, "phi_i and theta_i");
    must_refuse(save(make_rgl(&(rgl_change){.name = "rgb", .type = 10, .n_dims = 5, .dims = {1, 4, 1, 5, 7}})),
                NQM_ERR_FORMAT, "channels");
    must_refuse(save(make_rgl(&(rgl_change){.name = "rgb", .type = 10, .n_dims = 7, .dims = {1, 1, 1, 1, 1, 1, 1}})),
                NQM_ERR_FORMAT, "7 dim");
}

TEST(refuses_unfit_numbers) {
    static const float falling[4] = {0, 1.1F, 0.6F, 1.5F};
    static const float flat_sigma[4] = {1, 1, 0, 1}, negative_ndf[4] = {1, 1, 1, -1};
    static const float no_density[4 * 4] = {1, 1, 1, 1, 1, 1, 1, 1};
    const float not_finite[4] = {1, NAN, 1, 1}, infinite[4] = {1, INFINITY, 1, 1};
    static const float third[4] = {0, 0.5F, 1, 2.0943951F}, unordered[4] = {0, 2, 1, 3.1415927F};
    must_refuse(save(make_rgl(&(rgl_change){"theta_i", false, 10, 1, {4}, falling})), NQM_ERR_FORMAT, "rise");
    must_refuse(save(make_anisotropic_rgl(2, false, &(rgl_change){"phi_i", false, 10, 1, {4}, unordered})),
                NQM_ERR_FORMAT, "rise");
    must_refuse(save(make_anisotropic_rgl(2, true, &(rgl_change){"phi_i", false, 10, 1, {4}, third})), NQM_ERR_FORMAT,
                "does not cover 360, 180 or 90 degrees");
    must_refuse(save(make_rgl(&(rgl_change){"sigma", false, 10, 2, {2, 2}, flat_sigma})), NQM_ERR_FORMAT, "contains 0");
    must_refuse(save(make_rgl(&(rgl_change){"ndf", false, 10, 2, {2, 2}, negative_ndf})), NQM_ERR_FORMAT,
                "contains -1");
    must_refuse(save(make_rgl(&(rgl_change){"ndf", false, 10, 2, {2, 2}, not_finite})), NQM_ERR_FORMAT, "nan");
    must_refuse(save(make_rgl(&(rgl_change){"sigma", false, 10, 2, {2, 2}, infinite})), NQM_ERR_FORMAT, "inf");
    must_refuse(save(make_rgl(&(rgl_change){"vndf", false, 10, 4, {1, 4, 2, 2}, no_density})), NQM_ERR_FORMAT,
                "without any density");
}

/* The valid material with one byte changed. */
static blob with_byte(size_t at, unsigned char value) {
    blob b = make_rgl(NULL);
    b.data[at] = value;
    return b;
}

TEST(refuses_a_broken_container) {
    must_refuse(save(with_byte(5, 'X')), NQM_ERR_FORMAT, "byte 0");
    must_refuse(save(with_byte(12, 2)), NQM_ERR_FORMAT, "version 2");
    must_refuse(save(with_byte(16, 1)), NQM_ERR_FORMAT, "65545 fields");
    must_refuse(save(with_byte(14, 200)), NQM_ERR_FORMAT, "byte"); /* too many fields: data are parsed as entries */
    must_refuse(save(with_byte(18, 200)), NQM_ERR_FORMAT, "200 bytes of name");
    const size_t first = 18 + 2 + strlen("description");
    must_refuse(save(with_byte(first, 9)), NQM_ERR_FORMAT, "9 dimensions");
    must_refuse(save(with_byte(first + 2, 0)), NQM_ERR_FORMAT, "type 0");
    must_refuse(save(with_byte(first + 2, 12)), NQM_ERR_FORMAT, "type 12");
    must_refuse(save(with_byte(first + 3 + 7, 0x80)), NQM_ERR_FORMAT, "ends at byte"); /* an offset of 2^63 */
    must_refuse(save(with_byte(first + 11 + 7, 0x80)), NQM_ERR_FORMAT, "ends at byte");
    blob b = make_rgl(NULL); /* two dimensions of 2^31 and more: their product is beyond 64 bits */
    const unsigned char name[] = "\5\0phi_i";
    unsigned char *entry = b.data + 18;
    while (memcmp(entry, name, 7) != 0)
        ++entry;
    nqm_store_u64(entry + 7 + 11, UINT64_MAX / 2);
    must_refuse(save(b), NQM_ERR_FORMAT, "impossible");
}

TEST(refuses_truncated_files) {
    for (int k = 0; k < 2; ++k) {
        blob b = k ? make_anisotropic_rgl(4, false, NULL) : make_rgl(NULL);
        refuse_cuts(scratch_path("short.bsdf"), b, 17, read_brdf_ends); /* the table of contents ends before byte 500 */
        blob_free(&b);
    }
}

TEST(survives_failing_allocations) {
    assert_int_equal(check_brdf_allocations(save(make_rgl(NULL))), 4);
}

TEST_FILE(read_pair_vector, NULL)
