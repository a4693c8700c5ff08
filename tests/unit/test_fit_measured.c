/* SPDX-License-Identifier: MIT
 *
 * Fits of the sharpest measured materials of the RGL database (lobes of 0.2 to 0.5 degrees half-width): the fit has the
 * highlight, and its base is not brighter to compensate for the tail of the lobe. Needs the shared data.
 */
#include "fit/fit.h"
#include "support/check.h"

#include <nqm/fit.h>

static const char *const sharp[] = {"cg_sunflower", "chm_light_blue", "chm_mint", "ilm_solo_m_68"};
enum { N_SHARP = sizeof sharp / sizeof *sharp };

static double green(const nqm_brdf *brdf, double theta_h_deg, double theta_d_deg) {
    const double deg = acos(-1) / 180;
    const double hd[3] = {theta_h_deg * deg, theta_d_deg * deg, 90 * deg};
    double rgb[3];
    nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
    return rgb[1];
}

/* Geometric mean of the mirror peak over theta_d, and mean of the base between 30 and 50 degrees. */
static void peak_and_base(const nqm_brdf *brdf, double *peak, double *base) {
    *peak = 0;
    *base = 0;
    for (int i = 1; i <= 4; ++i)
        *peak += log(green(brdf, 0, 10 * i) + 1e-9) / 4;
    for (int i = 0; i < 5; ++i)
        *base += green(brdf, 30 + 5 * i, 15) / 5;
    *peak = exp(*peak);
}

static void highlight_and_base_of(const char *material, const char *model) {
    char file[100];
    snprintf(file, sizeof file, "rgl/%s_rgb.bsdf", material);
    nqm_brdf *ref, *fitted;
    nqm_fit_report report;
    assert_int_equal(nqm_brdf_open(shared_data(file), &ref, NULL), NQM_OK);
    assert_int_equal(nqm_fit(ref, model, NULL, &report, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_open(report.spec, &fitted, NULL), NQM_OK);
    double peak[2], base[2];
    peak_and_base(ref, &peak[0], &base[0]);
    peak_and_base(fitted, &peak[1], &base[1]);
    printf("%-16s %-4s peak x %.2f, base %+.4f 1/sr\n", material, model, peak[1] / peak[0], base[1] - base[0]);
    assert_true(peak[1] > 0.4 * peak[0] && peak[1] < 2.5 * peak[0]);
    assert_true(fabs(base[1] - base[0]) < 0.05);
    nqm_brdf_free(fitted);
    nqm_brdf_free(ref);
}

TEST(sharp_materials) {
    for (int i = 0; i < N_SHARP; ++i) {
        highlight_and_base_of(sharp[i], "ward");
        highlight_and_base_of(sharp[i], "ggx");
    }
}

static bool has_data(void) {
    return shared_data("rgl/cg_sunflower_rgb.bsdf") != NULL;
}

TEST_FILE_NEEDS(has_data)
