/* SPDX-License-Identifier: MIT
 *
 * BRDFs from CSV files of directions and values. Grids: functions that are linear in the angles are interpolated exactly.
 * Scattered directions: pairs turned about the normal, and tilted by known angles.
 */
#include "base/base.h"
#include "io/io.h"
#include "math/math.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/damage.h"

#include <nqm/brdf.h>
#include <stdarg.h>

static const double degree = 3.14159265358979323846 / 180;
static const char header[] = "theta_h,theta_d,phi_d,r,g,b\n";

/* A file that is written line by line. */
typedef struct csv {
    char text[65536];
    size_t n;
} csv;

__attribute__((format(printf, 2, 3))) static void add(csv *file, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    file->n += (size_t)vsnprintf(file->text + file->n, sizeof file->text - file->n, format, arguments);
    va_end(arguments);
    assert_true(file->n < sizeof file->text);
}

static const char *save(const csv *file) {
    const char *path = scratch_path("list.csv");
    blob_save(&(blob){(unsigned char *)(uintptr_t)file->text, file->n}, path);
    return path;
}

static nqm_brdf *open_ok(const char *path, const char *suffix) {
    char argument[4200];
    snprintf(argument, sizeof argument, "%s%s", path, suffix);
    return must_open(argument);
}

static double plane(double theta_h, double theta_d) {
    return 2 + 0.5 * theta_h - 0.25 * theta_d;
}

/* Linear between phi = 0, 60, 120 degrees: 0, 1, 0.5; then 0 at 180 again. */
static double hat(double phi) {
    double x = fmod(phi / degree, 180) / 60;
    return x < 1 ? x : 1.5 - 0.5 * x;
}

TEST(grids_are_interpolated) {
    static const double theta_h[] = {0, 3, 20, 45, 80, 90}, theta_d[] = {0, 10, 25, 80, 85};
    csv file = {.n = 0};
    add(&file, "# measured\n\n%s", header);
    for (size_t p = 3; p-- > 0;) /* in any order */
        for (size_t h = 0; h < 6; ++h)
            for (size_t d = 0; d < 5; ++d)
                add(&file, "%g,%g,%zu,%.9g,%g,-1\n", theta_h[h], theta_d[d], 60 * p,
                    plane(theta_h[h] * degree, theta_d[d] * degree), hat((double)(60 * p) * degree));
    nqm_brdf *brdf = open_ok(save(&file), "");
    nqm_rng rng = nqm_rng_make(3, 0);
    size_t n_valid = 0;
    for (int i = 0; i < 1000; ++i) {
        const double hd[3] = {nqm_rng_uniform(&rng) * 40 * degree, nqm_rng_uniform(&rng) * 90 * degree,
                              nqm_rng_uniform(&rng) * 360 * degree};
        double rgb[3];
        uint8_t flag;
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, &flag);
        if (flag == NQM_VALUE_HORIZON)
            continue;
        if (hd[1] > 85 * degree)
            assert_int_equal(flag, NQM_VALUE_INVALID);
        if (hd[1] > 25 * degree) /* a neighbour may be below the horizon */
            continue;
        assert_int_equal(flag, NQM_VALUE_CLAMPED);
        ++n_valid;
        assert_near(rgb[0], plane(hd[0], hd[1]), 1e-6);
        assert_near(rgb[1], hat(hd[2]), 1e-6);
        assert_true(rgb[2] == 0);
    }
    assert_true(n_valid > 200);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "grid");
    assert_string_equal(info.layout,
                        "6 theta_h x 5 theta_d x 3 phi_d, linear between them, at most 35, 55 and 60 degrees apart");
    assert_int_equal(info.reciprocal, 1);
    assert_int_equal(info.n_bytes, file.n);
    nqm_brdf_free(brdf);
}

/* With phi_d beyond 180 degrees the light's side counts; nodes at both ends of the turn are one. */
TEST(full_turns_are_not_reciprocal) {
    csv file = {.n = 0};
    add(&file, "%s", header);
    for (int p = -180; p <= 180; p += 90)
        for (int h = 0; h < 40; h += 10)
            for (int d = 0; d < 40; d += 10)
                add(&file, "%d,%d,%d,%g,1,1\n", h, d, p, (p == -90 ? 3.0 : 1.0));
    nqm_brdf *brdf = open_ok(save(&file), "");
    const double hd[4][3] = {
        {0.2, 0.3, 270 * degree}, {0.2, 0.3, 90 * degree}, {0.2, 0.3, 225 * degree}, {0.2, 0.3, 0}};
    const double expected[4] = {3, 1, 2, 1};
    assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, 0);
    for (size_t i = 0; i < 4; ++i) {
        double rgb[3], wi[3], wo[3], by_vectors[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd[i], rgb, NULL);
        nqm_half_diff_to_directions(hd[i], wi, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, by_vectors, NULL);
        assert_near(rgb[0], expected[i], 1e-9);
        assert_near(by_vectors[0], expected[i], 1e-9);
    }
    nqm_brdf_free(brdf);
}

enum { N = 200 };

/* Scattered directions with the value 1 + row / 256; the last ones have none. hd: (N, 3), degrees. */
static const char *save_scattered(double (*hd)[3], bool full_turn) {
    static csv file;
    nqm_rng rng = nqm_rng_make(4, 0);
    file.n = 0;
    add(&file, "%s", header);
    for (int i = 0; i < N; ++i) {
        hd[i][0] = 40 * nqm_rng_uniform(&rng);
        hd[i][1] = 49 * nqm_rng_uniform(&rng);
        hd[i][2] = (full_turn ? 360 : 180) * nqm_rng_uniform(&rng);
        add(&file, i < N - 5 ? "%.9f,%.9f,%.9f,%.9g,1,2\n" : "%.9f,%.9f,%.9f,,,\n", hd[i][0], hd[i][1], hd[i][2],
            1 + i / 256.0);
    }
    return save(&file);
}

/* About the normal. */
static void rotate(double *w, double angle) {
    double x = w[0], y = w[1];
    w[0] = cos(angle) * x - sin(angle) * y;
    w[1] = sin(angle) * x + cos(angle) * y;
}

/* Away from the normal, which no rotation about it undoes. */
static void raise_angle(double *w, double angle) {
    double sin_theta = hypot(w[0], w[1]), theta = atan2(sin_theta, w[2]) + angle;
    w[0] *= sin(theta) / sin_theta;
    w[1] *= sin(theta) / sin_theta;
    w[2] = cos(theta);
}

TEST(scattered_directions_are_found) {
    double list[N][3];
    for (int full_turn = 0; full_turn < 2; ++full_turn) {
        nqm_brdf *brdf = open_ok(save_scattered(list, full_turn), ":0.2");
        for (int i = 0; i < N; ++i) {
            const double hd[3] = {list[i][0] * degree, list[i][1] * degree, list[i][2] * degree};
            double wi[3], wo[3], rgb[3];
            uint8_t flag;
            nqm_half_diff_to_directions(hd, wi, wo);
            rotate(wi, i);
            rotate(wo, i);
            nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
            assert_int_equal(flag, i < N - 5 ? NQM_VALUE_OK : NQM_VALUE_INVALID);
            assert_near(rgb[0], i < N - 5 ? 1 + i / 256.0 : 0, 1e-6);
            nqm_brdf_eval(brdf, 1, wo, wi, rgb, &flag);
            assert_int_equal(flag, i < N - 5 && !full_turn ? NQM_VALUE_OK : NQM_VALUE_INVALID);
            raise_angle(wi, 0.15 * degree);
            nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
            assert_int_equal(nqm_has_value(flag), i < N - 5);
            raise_angle(wi, 0.1 * degree);
            nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
            assert_false(nqm_has_value(flag));
        }
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_string_equal(info.format, "samples");
        assert_string_equal(info.layout, "195 directions, values within 0.2 degrees of them");
        assert_int_equal(info.n_values, 3 * 195);
        assert_int_equal(info.reciprocal, !full_turn);
        nqm_brdf_free(brdf);
    }
}

/* The nearest row is that of a search of all rows, where all have one of two lights and where all are nearly the same. */
TEST(nearest_rows_are_those_of_a_full_search) {
    enum { N_ROWS = 700, N_ASKED = 300 };
    static double w[N_ROWS][2][3];
    static const double light[] = {10, 50};
    for (int spread = 1; spread <= 80; spread += 79) {
        csv file = {.n = 0};
        nqm_rng rng = nqm_rng_make(5, (uint64_t)spread);
        add(&file, "theta_i,phi_i,theta_o,phi_o,r,g,b\n");
        for (int i = 0; i < N_ROWS; ++i) {
            const double at[4] = {light[i % 2], 20, nqm_rng_uniform(&rng) * spread, nqm_rng_uniform(&rng) * 360};
            add(&file, "%g,%g,%.9f,%.9f,%d,1,1\n", at[0], at[1], at[2], at[3], i);
            nqm_spherical(at[0] * degree, at[1] * degree, w[i][0]);
            nqm_spherical(at[2] * degree, at[3] * degree, w[i][1]);
        }
        nqm_brdf *brdf = open_ok(save(&file), ":20");
        for (int k = 0; k < N_ASKED; ++k) {
            double a[2][3], rgb[3], least = 2 * sin(10 * degree);
            int nearest = -1;
            nqm_spherical((light[k % 2] + 5 * nqm_rng_uniform(&rng)) * degree, 1, a[0]);
            nqm_spherical(nqm_rng_uniform(&rng) * spread * degree, nqm_rng_uniform(&rng) * 6, a[1]);
            for (int i = 0; i < N_ROWS; ++i) {
                double sum = 4, x = 0, y = 0;
                for (int d = 0; d < 2; ++d) {
                    sum -= 2 * a[d][2] * w[i][d][2];
                    x += a[d][0] * w[i][d][0] + a[d][1] * w[i][d][1];
                    y += a[d][1] * w[i][d][0] - a[d][0] * w[i][d][1];
                }
                const double distance = sqrt(fmax(sum - 2 * hypot(x, y), 0));
                nearest = distance < least ? i : nearest;
                least = fmin(least, distance);
            }
            uint8_t flag;
            nqm_brdf_eval(brdf, 1, a[0], a[1], rgb, &flag);
            assert_int_equal(nqm_has_value(flag), nearest >= 0);
            assert_true(nearest < 0 || rgb[0] == nearest);
        }
        nqm_brdf_free(brdf);
    }
}

/* Azimuths of light and viewer: any rotation about the normal is the same pair; light and viewer are not exchanged. */
TEST(lights_and_viewers_are_read) {
    csv file = {.n = 0};
    add(&file, "r,g,b,theta_i,phi_i,theta_o,phi_o\n1,2,3,30,0,40,150\n4,5,6,10,-20,60,340\n");
    nqm_brdf *brdf = open_ok(save(&file), "");
    assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, 0);
    static const double angles[3][4] = {
        {30, 77, 40, 227}, {10, 0, 60, 0}, {40, 150, 30, 0}}; /* theta_i, phi_i, theta_o, phi_o */
    static const double expected[3] = {1, 4, 0};
    for (int i = 0; i < 3; ++i) {
        double w[2][3], rgb[3];
        uint8_t flag;
        for (int k = 0; k < 2; ++k) {
            const double theta = angles[i][2 * k] * degree, phi = angles[i][2 * k + 1] * degree;
            w[k][0] = sin(theta) * cos(phi);
            w[k][1] = sin(theta) * sin(phi);
            w[k][2] = cos(theta);
        }
        nqm_brdf_eval(brdf, 1, w[0], w[1], rgb, &flag);
        assert_int_equal(flag, expected[i] > 0 ? NQM_VALUE_OK : NQM_VALUE_INVALID);
        assert_near(rgb[0], expected[i], 1e-12);
    }
    nqm_brdf_free(brdf);
}

/* theta_i x theta_o x phi of a goniometer, with the values of f: over half a turn of phi it is mirrored, over a full one not. */
static nqm_brdf *open_goniometer(int first_phi, int last_phi, int step) {
    static csv file;
    file.n = 0;
    add(&file, "theta_i,phi_i,theta_o,phi_o,r,g,b\n");
    for (int o = 10; o <= 80; o += 35)
        for (int p = first_phi; p <= last_phi; p += step)
            for (int i = 0; i <= 80; i += 20)
                add(&file, "%d,30,%d,%d,%.9g,%d,1\n", i, o, p + 30, 1 + i * degree + 2 * o * degree, abs(p));
    return open_ok(save(&file), "");
}

static bool eval_goniometer(const nqm_brdf *brdf, double theta_i, double theta_o, double phi, double *rgb) {
    const double wi[3] = {0, sin(theta_i * degree), cos(theta_i * degree)}; /* at azimuth 90 degrees */
    const double wo[3] = {-sin(theta_o * degree) * sin(phi * degree), sin(theta_o * degree) * cos(phi * degree),
                          cos(theta_o * degree)};
    uint8_t flag;
    nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
    return nqm_has_value(flag);
}

TEST(goniometer_grids_are_interpolated) {
    double rgb[3];
    for (int turn = 0; turn < 3; ++turn) { /* half a turn to either side, and a full one */
        nqm_brdf *brdf = turn == 0   ? open_goniometer(0, 180, 30)
                         : turn == 1 ? open_goniometer(-180, 0, 30)
                                     : open_goniometer(-180, 150, 30);
        const nqm_brdf_info info = nqm_brdf_get_info(brdf);
        char expected[200];
        snprintf(expected, sizeof expected,
                 "5 theta_i x 3 theta_o x %d phi, linear between them, at most 20, 35 and 30 degrees apart",
                 turn < 2 ? 7 : 12);
        assert_string_equal(info.layout, expected);
        assert_string_equal(info.format, "grid");
        assert_int_equal(info.reciprocal, 0);
        for (int phi = -179; phi < 180; phi += 7) {
            assert_true(eval_goniometer(brdf, 33, 47, phi, rgb));
            assert_near(rgb[0], 1 + 33 * degree + 2 * 47 * degree, 1e-6);
            assert_near(rgb[1], abs(phi), 1e-4);
        }
        assert_false(eval_goniometer(brdf, 33, 9.9, 20, rgb) || eval_goniometer(brdf, 80.1, 40, 20, rgb));
        nqm_brdf_free(brdf);
    }
    nqm_brdf *brdf = open_goniometer(30, 120, 30); /* nothing is known beyond */
    assert_true(eval_goniometer(brdf, 33, 47, -119, rgb));
    assert_false(eval_goniometer(brdf, 33, 47, 121, rgb) || eval_goniometer(brdf, 33, 47, 29, rgb));
    nqm_brdf_free(brdf);
    brdf = open_goniometer(0, 180, 180); /* the plane of incidence alone */
    assert_string_equal(nqm_brdf_get_info(brdf).format, "samples");
    nqm_brdf_free(brdf);
}

/* theta 0 given once, at any azimuth, for light and viewer; of the other rows each `every`th is missing (0: none). */
static nqm_brdf *open_sparse_goniometer(int first_phi, int normal_phi, int every, const char *suffix) {
    static csv file;
    int n = 0;
    file.n = 0;
    add(&file, "theta_i,phi_i,theta_o,phi_o,r,g,b\n");
    for (int i = 0; i <= 80; i += 20)
        for (int o = 0; o <= 80; o += 20)
            for (int p = first_phi; p <= first_phi + 180; p += 30) {
                const bool is_normal = i == 0 || o == 0;
                if (is_normal ? p > first_phi : every && ++n % every == 0)
                    continue;
                add(&file, "%d,0,%d,%d,%.9g,1,1\n", i, o, is_normal ? normal_phi : p, 1 + i * degree + 2 * o * degree);
            }
    return open_ok(save(&file), suffix);
}

TEST(goniometer_grids_may_lack_rows) {
    static const struct {
        int first_phi, normal_phi, every;
        const char *missing;
    } cases[] = {{0, 0, 0, ""},
                 {0, 17, 0, ""},
                 {180, 0, 0, ""},
                 {0, 0, 9, "; 12 of 175 nodes have no row"},
                 {0, 0, 4, "; 28 of 175 nodes have no row"}};
    double rgb[3];
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        nqm_brdf *brdf = open_sparse_goniometer(cases[k].first_phi, cases[k].normal_phi, cases[k].every, "");
        char expected[200];
        snprintf(expected, sizeof expected,
                 "5 theta_i x 5 theta_o x 7 phi, linear between them, at most 20, 20 and 30 degrees apart%s",
                 cases[k].missing);
        assert_string_equal(nqm_brdf_get_info(brdf).layout, expected);
        for (int phi = -179; phi < 180; phi += 7) {
            assert_true(eval_goniometer(brdf, 13, 7, phi, rgb));
            assert_near(rgb[0], 1 + 13 * degree + 2 * 7 * degree, cases[k].every ? 0.4 : 1e-6);
        }
        assert_int_equal(eval_goniometer(brdf, 20, 40, cases[k].first_phi + 30, rgb), cases[k].every != 9);
        assert_true(eval_goniometer(brdf, 0, 0, 0, rgb));
        assert_near(rgb[0], 1, 1e-6);
        nqm_brdf_free(brdf);
    }
    nqm_brdf *brdf = open_sparse_goniometer(0, 0, 3, ""); /* more than a quarter is missing */
    assert_string_equal(nqm_brdf_get_info(brdf).format, "samples");
    nqm_brdf_free(brdf);
    brdf = open_sparse_goniometer(0, 0, 9, ":5"); /* the rows alone are asked for */
    assert_string_equal(nqm_brdf_get_info(brdf).format, "samples");
    nqm_brdf_free(brdf);
}

/* A sample measured at six azimuths, whose values differ by `contrast`; each pair also at theta 0. */
static nqm_brdf *open_turned(double contrast, const char *suffix) {
    static csv file;
    file.n = 0;
    add(&file, "theta_i,phi_i,theta_o,phi_o,r,g,b\n");
    for (int turn = 0; turn < 360; turn += 60)
        for (int i = 0; i <= 60; i += 20)
            for (int p = 0; p < 360; p += 90)
                add(&file, "%d,%d,40,%d,%.9g,0,0\n", i, turn, (turn + p) % 360,
                    (1 + p / 360.0) * (1 + contrast * turn / 300));
    return open_ok(save(&file), suffix);
}

/* What is not used: columns and rows. */
TEST(what_is_not_used_is_named) {
    csv file = {.n = 0};
    add(&file, "sample,theta_h,theta_d,phi_d,r,g,b,sigma\n"
               "a,20,40,90,1,2,3,9\na,80,80,0,1,2,3,9\nb,21,30,10,nan,nan,nan,9\n");
    nqm_brdf *brdf = open_ok(save(&file), "");
    assert_string_equal(nqm_brdf_get_info(brdf).remark,
                        "column 'sample' is not used; column 'sigma' is not used; rows without a value: 1; "
                        "rows at the horizon or below it: 1");
    nqm_brdf *wrapped = NULL;
    char spec[600];
    snprintf(spec, sizeof spec, "perturb:scale=2;of=%s", nqm_brdf_get_info(brdf).name);
    assert_int_equal(nqm_brdf_open(spec, &wrapped, NULL), NQM_OK);
    assert_string_equal(nqm_brdf_get_info(wrapped).remark, nqm_brdf_get_info(brdf).remark);
    nqm_brdf_free(wrapped);
    nqm_brdf_free(brdf);
}

/* Pairs that recur at other azimuths with other values keep them; without other values, or with those of noise, they do not. */
TEST(azimuths_of_anisotropic_lists_are_kept) {
    static const double contrast[] = {0, 0.1, 0.3};
    for (size_t k = 0; k < sizeof contrast / sizeof *contrast; ++k) {
        nqm_brdf *brdf = open_turned(contrast[k], "");
        const nqm_brdf_info info = nqm_brdf_get_info(brdf);
        const bool is_anisotropic = k == 2;
        assert_int_equal(info.isotropic, !is_anisotropic);
        assert_string_equal(info.format, "samples");
        assert_string_equal(info.layout, is_anisotropic
                                             ? "96 directions with azimuths, values within 0.1 degrees of them"
                                             : "13 directions, values within 0.1 degrees of them");
        if (is_anisotropic)
            assert_null(info.remark);
        else
            assert_string_equal(info.remark, "rows that give a direction again: 83 (their mean counts)");
        for (int turn = 0; turn < 360; turn += 30) {
            double w[2][3], rgb[3];
            uint8_t flag;
            for (int a = 0; a < 2; ++a) { /* theta_i 20, theta_o 40, phi 90 */
                const double theta = (a ? 40 : 20) * degree, phi = (turn + 90 * a) * degree;
                w[a][0] = sin(theta) * cos(phi);
                w[a][1] = sin(theta) * sin(phi);
                w[a][2] = cos(theta);
            }
            nqm_brdf_eval(brdf, 1, w[0], w[1], rgb, &flag);
            assert_int_equal(nqm_has_value(flag), !is_anisotropic || turn % 60 == 0);
            if (is_anisotropic && turn % 60 == 0)
                assert_near(rgb[0], 1.25 * (1 + contrast[k] * turn / 300), 1e-6);
            nqm_brdf_eval(brdf, 1, w[1], w[0], rgb, &flag); /* light and viewer are not exchanged */
            assert_true(!nqm_has_value(flag));
        }
        nqm_brdf_free(brdf);
    }
    nqm_brdf *brdf = open_turned(0.3, ":20"); /* constant around each row, also in the azimuth */
    const double wi[3] = {sin(20 * degree) * cos(70 * degree), sin(20 * degree) * sin(70 * degree), cos(20 * degree)};
    const double wo[3] = {-sin(40 * degree) * sin(70 * degree), sin(40 * degree) * cos(70 * degree), cos(40 * degree)};
    double rgb[3];
    nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
    assert_near(rgb[0], 1.25 * (1 + 0.3 * 60 / 300), 1e-6);
    nqm_brdf_free(brdf);
}

/* A scan of 30 directions near the normal, in radians or in degrees, over azimuths or in one plane. */
static const char *save_scan(const char *names, double phi_step) {
    csv file = {.n = 0};
    char text[4096];
    size_t n = (size_t)snprintf(text, sizeof text, "%s,r,g,b\n", names);
    for (int i = 0; i < 30; ++i)
        n += (size_t)snprintf(text + n, sizeof text - n, "%g,%g,%g,1,1,1\n", 0.05 * i, 1.5 - 0.03 * i, phi_step * i);
    add(&file, "%s", text);
    return save(&file);
}

/* Without a unit they are refused; with one the numbers are what it says. */
TEST(radians_are_refused_unless_they_are_named) {
    static const char names[] = "theta_h,theta_d,phi_d", degrees[] = "theta_h [deg],theta_d (degrees),phi_d_deg",
                      radians[] = "theta_h [rad],theta_d (radians),phi_d_rad";
    for (int k = 0; k < 2; ++k) {
        nqm_error err = {0};
        nqm_brdf *brdf;
        assert_int_equal(nqm_brdf_open(save_scan(names, 0.1 * k), &brdf, &err), NQM_ERR_FORMAT);
        assert_non_null(
            strstr(err.message, "list.csv: the polar angles of all rows (from byte 0 on) are at most 1.5: "));
        assert_non_null(strstr(err.message, "these are radians, and degrees are read unless"));
        for (int unit = 0; unit < 2; ++unit) {
            const double scale = unit ? 1 : degree, hd[3] = {0.1 * scale, 1.44 * scale, 0.2 * k * scale};
            double rgb[3];
            uint8_t flag;
            brdf = open_ok(save_scan(unit ? radians : degrees, 0.1 * k), "");
            nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, &flag);
            assert_int_equal(flag, NQM_VALUE_OK);
            nqm_brdf_eval_half_diff(brdf, 1, (const double[3]){hd[0], hd[1] + 0.5 * degree, hd[2]}, rgb, &flag);
            assert_int_equal(flag, NQM_VALUE_INVALID);
            nqm_brdf_free(brdf);
        }
    }
}

/* Names of columns as instruments and programs write them, with the pair theta_i 30, theta_o 40, phi 150 degrees. */
TEST(columns_have_other_names) {
    static const struct {
        const char *text;
        double rgb[3];
    } cases[] = {
        {"theta_i,phi_i,theta_r,phi_r,r,g,b\n30,0,40,150,1,2,3\n", {1, 2, 3}},
        {"theta_i,phi_i,theta_s,phi_s,r,g,b\n30,0,40,150,1,2,3\n", {1, 2, 3}},
        {"theta_s,phi_s,theta_v,phi_v,r,g,b\n30,0,40,150,1,2,3\n", {1, 2, 3}},
        {"theta_l,phi_l,theta_v,phi_v,r,g,b\n30,0,40,150,1,2,3\n", {1, 2, 3}},
        {"Theta In;Phi In;Theta Out;Phi Out;R;G;B\n30;0;40;150;1;2;3\n", {1, 2, 3}},
        {"theta_i [deg],phi_i [deg],theta_o [deg],phi_o [deg],r,g,b\n30,0,40,150,1,2,3\n", {1, 2, 3}},
        {"thetaI(\xc2\xb0),phiI(\xc2\xb0),thetaO(\xc2\xb0),phiO(\xc2\xb0),red,green,blue [1/sr]\n30,0,40,150,1,2,3\n",
         {1, 2, 3}},
        {"\xce\xb8_i,\xcf\x86_i,\xce\xb8_r,\xcf\x86_r,r,g,b\n30,0,40,150,1,2,3\n", {1, 2, 3}},
        {"theta_i_rad,phi_i_rad,theta_r_rad,phi_r_rad,r,g,b\n0.523598776,0,0.698131701,2.617993878,1,2,3\n", {1, 2, 3}},
        {"theta_i,phi_i,theta_o,phi_o,brdf\n30,0,40,150,2\n", {2, 2, 2}},
        {"theta_i,phi_i,theta_o,phi_o,BRDF [sr^-1]\n30,0,40,150,2\n", {2, 2, 2}},
        {"theta_i,phi_i,theta_o,phi_o,f_r\n30,0,40,150,2\n", {2, 2, 2}},
        {"theta_i,phi_i,theta_o,phi_o,r\n30,0,40,150,2\n", {2, 2, 2}},
        {"theta_i,phi_i,theta_o,phi_o,y,sigma\n30,0,40,150,2,7\n", {2, 2, 2}},
        {"theta_i,phi_i,theta_o,phi_o,X,Y,Z\n30,0,40,150,0.95047,1,1.08883\n", {1, 1, 1}},
        {"theta_i,phi_i,theta_o,phi_o,633nm\n30,0,40,150,2\n", {2, 2, 2}},
        {"theta_i,phi_i,theta_o,phi_o,400nm,500 nm,600,700 (nm)\n30,0,40,150,2,2,2,2\n", {2, 2, 2}},
        {"theta_h,theta_d,phi_d,value\n41.2046,53.7104,180,nan\n0,35,0,2\n", {0, 0, 0}},
        {"theta_i,phi_i,theta_o,phi_o,r,g,b\n30,0,-40,-30,1,2,3\n", {1, 2, 3}},
        {"theta_i,phi_i,theta_o,phi_o,r,g,b\n-30,180,40,150,1,2,3\n", {1, 2, 3}},
        {"theta_i,phi_i,theta_o,phi_o,r,g,b\n30,0,40,150,1,NaN,3\n60,0,5,0,1,2,3\n", {0, 0, 0}},
        {"ASTM E1392-96(2002)\n7 lines, of text\nNUM_POINTS 1\nVARS theta_i,phi_i,theta_r,phi_r,R,G,B\r\n"
         "0.523598776,0,0.698131701,2.617993878,1,2,3\r\n",
         {1, 2, 3}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        csv file = {.n = 0};
        double rgb[3];
        add(&file, "%s", cases[i].text);
        nqm_brdf *brdf = open_ok(save(&file), "");
        assert_int_equal(eval_goniometer(brdf, 30, 40, 150, rgb), cases[i].rgb[0] > 0);
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], cases[i].rgb[c], 1e-5);
        nqm_brdf_free(brdf);
    }
}

static void expect_refused(const char *text, const char *suffix, nqm_status status, const char *words) {
    csv file = {.n = 0};
    char argument[4200];
    add(&file, "%s", text);
    snprintf(argument, sizeof argument, "%s%s", save(&file), suffix);
    must_refuse(argument, status, words);
}

/* Rows of one direction count by their mean, in any order, also beside rows without a value and where exchange makes them one. */
TEST(repeated_directions_are_means) {
    static const char *const rows[] = {"20,0,40,90,1,2,3\n", "20,0,40,90,3,2,1\n", "20,0,40,90,,,\n",
                                       "20,30,40,-240,5,0.6,0.6\n"};
    static const double mean[] = {3, 4.6 / 3, 4.6 / 3}; /* of azimuths, too, which differ like noise */
    double rgb[3];
    for (size_t order = 0; order < 4; ++order) {
        csv file = {.n = 0};
        add(&file, "theta_i,phi_i,theta_o,phi_o,r,g,b\n");
        for (size_t i = 0; i < 4; ++i)
            add(&file, "%s", rows[(i + order) % 4]);
        nqm_brdf *brdf = open_ok(save(&file), "");
        const nqm_brdf_info info = nqm_brdf_get_info(brdf);
        assert_true(eval_goniometer(brdf, 20, 40, 90, rgb));
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], mean[c], 1e-6);
        assert_string_equal(info.remark,
                            "rows without a value: 1; rows that give a direction again: 3 (their mean counts)");
        assert_non_null(strstr(info.layout, "1 directions, values"));
        nqm_brdf_free(brdf);
    }
    csv file = {.n = 0}; /* phi_d 0 and 180 of a reciprocal list: light and viewer are exchanged */
    add(&file, "theta_h,theta_d,phi_d,r,g,b\n5,30,0,1,1,1\n5,30,180,3,3,3\n");
    nqm_brdf *brdf = open_ok(save(&file), "");
    for (int k = 0; k < 2; ++k) {
        const double hd[3] = {5 * degree, 30 * degree, k * 180 * degree};
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        assert_near(rgb[0], 2, 1e-6);
    }
    nqm_brdf_free(brdf);
}

/* The layout of the paper's authors. */
TEST(mat_files_of_the_authors_are_lists) {
    double at[] = {0, 10, 0, 5, 40, 90, 30, 20, 250}, r[] = {1, 2, 3}, g[] = {4, 5, 6}, b[] = {7, 8, -9};
    const nqm_mat_variable all[] = {{"r", 3, 1, r}, {"g", 1, 3, g}, {"b", 3, 1, b}, {"random_locations", 3, 3, at}};
    const char *path = scratch_path("material.mat");
    assert_int_equal(nqm_mat_write(path, 4, all, NULL), NQM_OK);
    nqm_brdf *brdf = open_ok(path, "");
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.layout, "3 directions, values within 0.1 degrees of them");
    assert_int_equal(info.reciprocal, 0);
    for (size_t i = 0; i < 3; ++i) {
        const double hd[3] = {at[3 * i] * degree, at[3 * i + 1] * degree, at[3 * i + 2] * degree};
        double rgb[3];
        uint8_t flag;
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, &flag);
        assert_int_equal(flag, i == 2 ? NQM_VALUE_CLAMPED : NQM_VALUE_OK);
        assert_true(rgb[0] == r[i] && rgb[1] == g[i] && rgb[2] == fmax(b[i], 0));
    }
    nqm_brdf_free(brdf);
    assert_true(check_brdf_allocations(path) >= 5);
    blob whole = blob_load(path);
    refuse_cuts(path, whole, 7, read_brdf);
    blob_free(&whole);
    at[8] = 170;
    assert_int_equal(nqm_mat_write(path, 4, all, NULL), NQM_OK);
    brdf = open_ok(path, "");
    assert_int_equal(nqm_brdf_get_info(brdf).reciprocal, 1);
    nqm_brdf_free(brdf);
    assert_int_equal(nqm_mat_write(path, 3, all, NULL), NQM_OK);
    must_refuse(path, NQM_ERR_FORMAT, "no numeric variable 'random_locations'");
    at[4] = 91;
    assert_int_equal(nqm_mat_write(path, 4, all, NULL), NQM_OK);
    must_refuse(path, NQM_ERR_FORMAT, "random_locations at row 2: 91 is not within 0 to 90 degrees");
}

TEST(refuses_unfit_lists) {
    static const char grid[] = "theta_h,theta_d,phi_d,r,g,b\n0,0,0,1,1,1\n0,9,0,1,1,1\n9,0,0,1,1,1\n9,9,0,1,1,1\n";
    expect_refused("theta_h,theta_d,phi_d,r,g\n1,2,3,4,5\n", "", NQM_ERR_FORMAT, "no column 'b'");
    expect_refused("theta_i,phi_i,theta_o,phi_o,r,g\n1,2,3,4,5,6\n", "", NQM_ERR_FORMAT, "no column 'b'");
    expect_refused("theta_i,phi_i,theta_o,phi_o,r,g,b\n1,2,90.5,4,5,6,7\n", "", NQM_ERR_FORMAT, "theta_o 90.5");
    expect_refused("theta_i,phi_i,theta_r,phi_r,r,g,b\n1,2,-91,4,5,6,7\n", "", NQM_ERR_FORMAT, "theta_r -91");
    expect_refused("theta_i,theta_o,r,g,b\n1,2,5,6,7\n", "", NQM_ERR_FORMAT, "no column 'phi_o'");
    expect_refused("theta_i phi_i theta_o phi_o brdf\n1 2 3 4 5\n", "", NQM_ERR_FORMAT, ", separated by commas");
    expect_refused("theta_i [grad],phi_i,theta_o,phi_o,r,g,b\n1,2,3,4,5,6,7\n", "", NQM_ERR_FORMAT,
                   "the unit of column 'theta_i [grad]' (header at byte 0) is not degrees (deg) or radians (rad)");
    expect_refused("theta_i,phi_i,theta_o,phi_o,brdf [%]\n1,2,3,4,5\n", "", NQM_ERR_FORMAT, "is not 1/sr");
    expect_refused("theta_i,phi_i,theta_o,phi_o,intensity\n1,2,3,4,5\n", "", NQM_ERR_FORMAT, "no column 'r'");
    expect_refused("theta_i,phi_i,theta_o,phi_o,500nm,520nm\n1,2,3,4,5,6\n", "", NQM_ERR_FORMAT,
                   "the wavelengths of its 2 columns of values (header at byte 0) do not rise");
    expect_refused("x\nVARS theta_i,phi_i,theta_r,phi_r,R,G,B\n30,0,0.7,0,1,1,1\n", "", NQM_ERR_FORMAT,
                   "theta_i 30 radians at byte 41 is not within -90 to 90 degrees");
    expect_refused(header, "", NQM_ERR_FORMAT, "without a direction");
    expect_refused("theta_h,theta_d,phi_d,r,g,b\n91,2,3,4,5,6\n", "", NQM_ERR_FORMAT, "theta_h 91");
    expect_refused("theta_h,theta_d,phi_d,r,g,b\n1,2,-181,4,5,6\n", "", NQM_ERR_FORMAT, "phi_d -181");
    expect_refused("theta_h,theta_d,phi_d,r,g,b\n1,2,3,4,,6\n", "", NQM_ERR_FORMAT, "needs a finite number");
    expect_refused("theta_h;theta_d;phi_d;r;g;b\n1;2;3;4,5;6;7\n", "", NQM_ERR_FORMAT,
                   "with a decimal point, not '4,5'");
    expect_refused("theta_h,theta_d,phi_d,r,g,b\n1,2,3,,,\n", "", NQM_ERR_FORMAT, "has a value");
    expect_refused("theta_h,theta_d,phi_d,r,g,b\n1,2,3,4,5,6\n", ":zero", NQM_ERR_ARG, "'zero'");
    expect_refused("theta_h,theta_d,phi_d,r,g,b\n1,2,3,4,5,6\n", ":50", NQM_ERR_ARG, "up to 45");
    expect_refused(grid, ":1", NQM_ERR_ARG, "complete grid");
    expect_refused("theta_h,theta_d,phi_d,r,g,b,R\n1,2,3,4,5,6,7\n", "", NQM_ERR_FORMAT,
                   "two columns are 'R' (header at byte 0)");
    csv file = {.n = 0};
    add(&file, "%s9,9,0,1,1,1\n", grid); /* a node that occurs twice is no other grid */
    nqm_brdf *brdf = open_ok(save(&file), "");
    assert_string_equal(nqm_brdf_get_info(brdf).format, "grid");
    assert_string_equal(nqm_brdf_get_info(brdf).remark, "rows that give a direction again: 1 (their mean counts)");
    nqm_brdf_free(brdf);
    double list[N][3];
    assert_true(check_brdf_allocations(save_scattered(list, false)) >= 6);
}
