/* SPDX-License-Identifier: MIT
 *
 * All RGL materials of the shared data: values are finite, clamped values are counted, the albedo does not exceed 1,
 * and values are close to the published NBRDF of the same material where that is accurate. Skipped without the data.
 */
#include "base/base.h"
#include "math/math.h"
#include "support/check.h"

#include <dirent.h>
#include <nqm/brdf.h>

static const double pi = 3.14159265358979323846;

/* The materials that the published networks reproduce well (README of the shared data). */
static const char *const well_kept[] = {"acrylic_felt_pink_rgb", "acrylic_felt_purple_rgb", "acrylic_felt_white_rgb",
                                        "aurora_white_rgb",      "cardboard_rgb",           "cg_sunflower_rgb",
                                        "cm_toxic_green_rgb",    "colodur_azure_4e_rgb",    "colodur_napoli_4f_rgb",
                                        "paper_blue_rgb",        "paper_white_rgb",         "colodur_connemara_4c_rgb",
                                        "ilm_l3_37_matte_rgb",   "satin_purple_rgb",        "satin_rosaline_rgb"};
enum { N_WELL_KEPT = sizeof well_kept / sizeof *well_kept };

static char folder[4096], archive[4096];

static nqm_brdf *open_ok(const char *format, const char *where, const char *name) {
    char argument[8192];
    snprintf(argument, sizeof argument, format, where, name);
    return must_open(argument);
}

static void check_material(const char *file_name) {
    nqm_brdf *brdf = open_ok("%s/%s", folder, file_name);
    nqm_brdf_check_report report;
    assert_int_equal(nqm_brdf_check(brdf, 1, &report, NULL), NQM_OK);
    double albedo = fmax(report.albedo_max[0], fmax(report.albedo_max[1], report.albedo_max[2]));
    print_message("%-32s albedo %.3f, clamped %5.2f %%, not reciprocal by %4.1f %% in the median\n", file_name, albedo,
                  100 * (double)report.n_clamped / (double)report.n_pairs, 100 * report.reciprocity_median);
    assert_int_equal(report.n_invalid, 0);
    assert_true(albedo > 0.05 && albedo <= 1.02);
    assert_true(report.reciprocity_median < 0.5);
    nqm_brdf_free(brdf);
}

TEST(all_are_plausible) {
    DIR *d = opendir(folder);
    assert_non_null(d);
    size_t n = 0;
    for (struct dirent *entry = readdir(d); entry; entry = readdir(d)) {
        if (!strstr(entry->d_name, ".bsdf"))
            continue;
        check_material(entry->d_name);
        ++n;
    }
    closedir(d);
    assert_int_equal(n, 26);
}

/* A direction, uniform over the cap of 75 degrees about the normal. */
static void draw_direction(nqm_rng *rng, double *w) {
    double lowest = cos(75 * pi / 180), z = lowest + (1 - lowest) * nqm_rng_uniform(rng);
    double phi = 2 * pi * nqm_rng_uniform(rng);
    w[0] = sqrt(1 - z * z) * cos(phi);
    w[1] = sqrt(1 - z * z) * sin(phi);
    w[2] = z;
}

/* The median over pairs off the highlight (half vector more than 15 degrees from the normal) and channels. */
static double median_difference(const nqm_brdf *measured, const nqm_brdf *network) {
    enum { N = 4000 };
    static double difference[3 * N];
    nqm_rng rng = nqm_rng_make(1, 0);
    size_t n = 0;
    while (n < 3 * N) {
        double wi[3], wo[3], hd[3], a[3], b[3];
        draw_direction(&rng, wi);
        draw_direction(&rng, wo);
        nqm_directions_to_half_diff(wi, wo, hd);
        if (hd[0] < 15 * pi / 180)
            continue;
        nqm_brdf_eval_half_diff(measured, 1, hd, a, NULL);
        nqm_brdf_eval_half_diff(network, 1, hd, b, NULL);
        for (size_t c = 0; c < 3; ++c)
            difference[n++] = a[c] > 0 ? fabs(a[c] - b[c]) / a[c] : 1;
    }
    qsort(difference, n, sizeof *difference, nqm_compare_doubles);
    return difference[n / 2];
}

TEST(well_kept_ones_agree_with_their_networks) {
    for (size_t i = 0; i < N_WELL_KEPT; ++i) {
        nqm_brdf *measured = open_ok("%s/%s.bsdf", folder, well_kept[i]);
        nqm_brdf *network = open_ok("%s:%s", archive, well_kept[i]);
        double difference = median_difference(measured, network);
        print_message("%-26s %.1f %% from its NBRDF\n", well_kept[i], 100 * difference);
        assert_true(difference <= 0.05);
        nqm_brdf_free(network);
        nqm_brdf_free(measured);
    }
}

static bool has_data(void) {
    const char *path = shared_data("rgl");
    if (!path)
        return false;
    snprintf(folder, sizeof folder, "%s", path);
    path = shared_data("nbrdf/rgl-isotropic_nbrdf.zip");
    if (!path)
        return false;
    snprintf(archive, sizeof archive, "%s", path);
    return true;
}

TEST_FILE_NEEDS(has_data)
