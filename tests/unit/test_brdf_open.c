/* SPDX-License-Identifier: MIT
 *
 * Common to all BRDFs: format detection, clamping and flags, evaluation in blocks, and the two coordinate systems.
 */
#include "base/memory_test.h"
#include "brdf/brdf.h"
#include "support/brdf_files.h"
#include "support/check.h"

#include <nqm/brdf.h>
#include <sys/stat.h>

static const double pi = 3.14159265358979323846;

/* ---- opening ----------------------------------------------------------------------------------------------------- */

static void expect_format(const char *argument, const char *format) {
    nqm_brdf *brdf = must_open(argument);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, format);
    assert_string_equal(info.name, argument);
    nqm_brdf_free(brdf);
}

/* The format is detected from the content, not from the name. */
TEST(finds_formats_by_bytes) {
    const char *path = scratch_path("file.txt");
    blob_put(make_rgl(NULL), path);
    expect_format(path, "rgl");
    blob_put(make_nbrdf(NBRDF_VALID), path);
    expect_format(path, "nbrdf");
    blob_put(make_merl(), path);
    expect_format(path, "merl");
    expect_format("lambert:kd=.5", "lambert");
}

TEST(refuses_what_is_no_brdf) {
    const char *path = scratch_path("file.binary");
    must_refuse(path, NQM_ERR_IO, path);
    must_refuse("/tmp", NQM_ERR_IO, "directory");
    must_refuse("", NQM_ERR_ARG, "empty");
    must_refuse("no such thing", NQM_ERR_IO, "no such thing");
    blob text = {(unsigned char[]){"what is this?"}, 13};
    for (size_t n = 1; n <= 13; ++n) {
        text.n_bytes = n;
        blob_save(&text, path);
        must_refuse(path, NQM_ERR_FORMAT, "byte 0");
    }
    text.n_bytes = 0;
    blob_save(&text, path);
    must_refuse(path, NQM_ERR_FORMAT, "empty");
    chmod(path, 0);
    if (access(path, R_OK) != 0) /* root can read any file */
        must_refuse(path, NQM_ERR_IO, path);
}

/* A colon separates a member only if the part before it is a file and the whole argument is not. */
TEST(splits_at_the_last_colon) {
    const char *path = scratch_path("a:b.bsdf");
    char argument[400];
    blob_put(make_rgl(NULL), path);
    expect_format(path, "rgl");
    snprintf(argument, sizeof argument, "%s:steel", path);
    must_refuse(argument, NQM_ERR_ARG, "'steel' is not an illuminant");
    snprintf(argument, sizeof argument, "%s:D65", path);
    must_refuse(argument, NQM_ERR_ARG, "contains RGB, not spectra");
    blob_put(make_nbrdf(NBRDF_VALID), path);
    snprintf(argument, sizeof argument, "%s:steel", path);
    must_refuse(argument, NQM_ERR_FORMAT, "neither a zip nor a decoder");
    must_refuse("nowhere.zip:steel", NQM_ERR_IO, "nowhere.zip:steel");
    blob network = make_nbrdf(NBRDF_VALID);
    path = scratch_path("c:d.zip");
    blob_put(make_zip("x/steel.h5", &network), path);
    blob_free(&network);
    snprintf(argument, sizeof argument, "%s:steel", path);
    expect_format(argument, "nbrdf");
}

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/* f_r = (wi.x, wo.y + 2, 1): red of either sign; NaN where wi.y > 0.5, infinite where wi.y < -0.5. */
static void ramp_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    size_t *n_most = *(size_t *const *)self;
    *n_most = n > *n_most ? n : *n_most;
    for (size_t i = 0; i < n; ++i) {
        assert_true(wi[3 * i + 2] > 0 && wo[3 * i + 2] > 0);
        rgb[3 * i] = wi[3 * i + 1] > 0.5 ? NAN : wi[3 * i];
        rgb[3 * i + 1] = wo[3 * i + 1] + 2;
        rgb[3 * i + 2] = wi[3 * i + 1] < -0.5 ? INFINITY : 1;
    }
}

static int n_freed;

static void ramp_free(void *self) {
    ++n_freed;
    nqm_free(self);
}

static const nqm_brdf_class ramp_class = {.format = "ramp", .eval = ramp_eval, .free = ramp_free};
static const nqm_brdf_info ramp_info = {.name = "ramp", .spec = "ramp:", .layout = "made up"};

static nqm_brdf *open_ramp(size_t *n_most) {
    size_t **self = nqm_alloc(1, sizeof *self);
    assert_non_null(self);
    *self = n_most;
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_wrap(&ramp_class, self, &ramp_info, &brdf, NULL), NQM_OK);
    return brdf;
}

enum { N = 1000 };

static void draw_pairs(double *wi, double *wo) {
    for (uint32_t i = 0; i < N; ++i) {
        for (uint32_t side = 0; side < 2; ++side) {
            double *w = (side ? wo : wi) + 3 * i;
            double z = 1.2 * noise(i, 2 * side) - 0.2, phi = 2 * pi * noise(i, 2 * side + 1); /* a sixth has z < 0 */
            w[0] = sqrt(1 - z * z) * cos(phi);
            w[1] = sqrt(1 - z * z) * sin(phi);
            w[2] = z;
        }
    }
}

TEST(clamps_and_flags) {
    static double wi[3 * N], wo[3 * N], rgb[3 * N], unflagged[3 * N];
    static uint8_t flag[N];
    size_t n_most = 0, n_of[4] = {0};
    draw_pairs(wi, wo);
    wi[2] = 0;
    wi[3 + 2] = NAN;
    wo[6 + 2] = -0.0;
    nqm_brdf *brdf = open_ramp(&n_most);
    nqm_brdf_eval(brdf, N, wi, wo, rgb, flag);
    for (size_t i = 0; i < N; ++i) {
        const double *l = wi + 3 * i, *v = wo + 3 * i, *f = rgb + 3 * i;
        bool above = l[2] > 0 && v[2] > 0, valid = above && fabs(l[1]) <= 0.5;
        nqm_value_flag expected = !above ? NQM_VALUE_HORIZON : !valid ? NQM_VALUE_INVALID : NQM_VALUE_OK;
        if (valid && l[0] < 0)
            expected = NQM_VALUE_CLAMPED;
        assert_int_equal(flag[i], expected);
        assert_true(f[0] == (valid ? fmax(l[0], 0) : 0));
        assert_true(f[1] == (valid ? v[1] + 2 : 0));
        assert_true(f[2] == (valid ? 1 : 0));
        ++n_of[expected];
    }
    assert_true(n_of[0] > 50 && n_of[1] > 50 && n_of[2] > 50 && n_of[3] > 50);
    assert_true(n_most > 10 && n_most < N); /* evaluated in blocks */
    nqm_brdf_eval(brdf, N, wi, wo, unflagged, NULL);
    assert_memory_equal(unflagged, rgb, sizeof rgb);
    nqm_brdf_eval(brdf, 0, NULL, NULL, NULL, NULL);
    nqm_brdf_free(brdf);
}

/* Half-vector coordinates distinguish light and viewer for phi_d in [0, 2 pi). */
TEST(evaluates_half_vector_coordinates) {
    size_t n_most = 0;
    nqm_brdf *brdf = open_ramp(&n_most);
    static double hd[3 * N], wi[3 * N], wo[3 * N], rgb[3 * N], expected[3 * N];
    static uint8_t flag[N], expected_flag[N];
    for (uint32_t i = 0; i < N; ++i) {
        hd[3 * i] = noise(i, 1) * pi / 2;
        hd[3 * i + 1] = noise(i, 2) * pi / 2;
        hd[3 * i + 2] = (noise(i, 3) - 0.5) * 6 * pi;
        nqm_half_diff_to_directions(hd + 3 * i, wi + 3 * i, wo + 3 * i);
    }
    nqm_brdf_eval_half_diff(brdf, N, hd, rgb, flag);
    nqm_brdf_eval(brdf, N, wi, wo, expected, expected_flag);
    assert_memory_equal(rgb, expected, sizeof rgb);
    assert_memory_equal(flag, expected_flag, sizeof flag);
    for (size_t i = 0; i < N; ++i) {
        double again[3];
        nqm_directions_to_half_diff(wi + 3 * i, wo + 3 * i, again);
        double turns = (hd[3 * i + 2] - again[2]) / pi;
        assert_near(again[0], hd[3 * i], 1e-9);
        assert_near(again[1], hd[3 * i + 1], 1e-9);
        assert_near(turns, round(turns), 1e-6 / sin(hd[3 * i + 1]));
        assert_true(again[2] >= 0 && again[2] < pi);
    }
    nqm_brdf_free(brdf);
}

/* self is freed exactly once, also on failure. */
TEST(wrap_owns_self) {
    size_t n_most = 0;
    n_freed = 0;
    nqm_brdf_free(open_ramp(&n_most));
    assert_int_equal(n_freed, 1);
    void *self = nqm_alloc(1, sizeof(size_t *));
    nqm_brdf *brdf;
    nqm_alloc_fail_after(0);
    nqm_status status = nqm_brdf_wrap(&ramp_class, self, &ramp_info, &brdf, NULL);
    nqm_alloc_fail_after(-1);
    assert_int_equal(status, NQM_ERR_NOMEM);
    assert_null(brdf);
    assert_int_equal(n_freed, 2);
    nqm_brdf_free(NULL);
}
