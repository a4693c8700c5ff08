/* SPDX-License-Identifier: MIT
 *
 * Physical plausibility of a BRDF: the largest directional albedo, reciprocity and isotropy over pairs of directions,
 * and the counts of clamped and missing values. The largest difference of two BRDFs over such pairs.
 */
#include "brdf/formats/listed.h"

#include <math.h>

enum { BLOCK = 128, N_PAIRS = 8192, N_ANGLES = 6 };
enum { CHECK_STREAM = 9, COMPARE_STREAM }; /* of random numbers; those below are of the albedo */

/* Draw a random pair: for even i, both directions are distributed like the cosine; for odd i, the half vector is near
 * the normal (theta_h = pi/2 u^2). in_plane: the azimuth of one of them is 0, which is enough for isotropic BRDFs. */
static void draw_pair(bool in_plane, nqm_rng *rng, size_t i, double max_polar_deg, double *wi, double *wo) {
    const double lowest = cos(max_polar_deg * NQM_PI / 180);
    do {
        double u = nqm_rng_uniform(rng), v = nqm_rng_uniform(rng), w = nqm_rng_uniform(rng);
        if (i % 2) {
            double hd[3] = {0.5 * NQM_PI * u * u, 0.5 * NQM_PI * v, NQM_PI * w};
            nqm_half_diff_to_pair(hd, wi, wo);
        } else {
            double r_i = sqrt(u), r_o = sqrt(v);
            memcpy(wi, (double[3]){r_i, 0, sqrt(1 - u)}, 3 * sizeof *wi);
            memcpy(wo, (double[3]){r_o * cos(2 * NQM_PI * w), r_o * sin(2 * NQM_PI * w), sqrt(1 - v)}, 3 * sizeof *wo);
        }
    } while (wi[2] < lowest || wo[2] < lowest);
    if (!in_plane)
        nqm_turn_pair(i, wi, wo);
}

double nqm_brdf_anisotropy(const nqm_brdf *brdf) {
    enum { N = 4 * BLOCK };
    static const double narrowest = 1e-4; /* theta_h; evenly from there on the logarithm */
    static const double rounding = 1e-5;  /* of BRDFs that are computed in float */
    double rgb[2][3 * BLOCK], wi[3 * BLOCK], wo[3 * BLOCK], sum = 0;
    uint8_t flag[2][BLOCK];
    size_t n_compared = 0;
    if (brdf->info.isotropic)
        return 0;
    for (size_t begin = 0; begin < N; begin += BLOCK) {
        for (size_t k = 0; k < 2; ++k) {
            for (size_t i = 0; i < BLOCK; ++i) {
                const double hd[3] = {narrowest * pow(NQM_PI / 2 / narrowest, ((double)(begin + i) + 0.5) / N),
                                      1.2 * nqm_radical_inverse(begin + i, 2),
                                      2 * NQM_PI * nqm_radical_inverse(begin + i, 3)};
                nqm_half_diff_to_pair(hd, wi + 3 * i, wo + 3 * i);
                nqm_turn_pair(2 * (begin + i) + k, wi + 3 * i, wo + 3 * i);
            }
            nqm_brdf_eval(brdf, BLOCK, wi, wo, rgb[k], flag[k]);
        }
        for (size_t i = 0; i < BLOCK; ++i) {
            const double a = nqm_luminance(rgb[0] + 3 * i), b = nqm_luminance(rgb[1] + 3 * i);
            if (!nqm_has_value(flag[0][i]) || !nqm_has_value(flag[1][i]))
                continue;
            ++n_compared;
            sum += a + b > 2e-6 ? 2 * fabs(a - b) / (a + b) : 0;
        }
    }
    if (n_compared == 0)
        return (double)NAN;
    const double mean = sum / (double)n_compared;
    return mean > rounding ? mean : 0;
}

/* Count clamped and invalid values at n pairs, and write |f(a,b) - f(b,a)| / mean of the luminances to `difference` (n). */
static void compare(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo, double *difference,
                    nqm_brdf_check_report *report) {
    double forward[3 * BLOCK], backward[3 * BLOCK];
    uint8_t flag[BLOCK], flag_back[BLOCK];
    size_t n_differences = 0;
    *report = (nqm_brdf_check_report){.n_pairs = n, .reciprocity_median = NAN, .reciprocity_p95 = NAN};
    for (size_t begin = 0, m; begin < n; begin += m) {
        m = nqm_smaller(n - begin, BLOCK);
        nqm_brdf_eval(brdf, m, wi + 3 * begin, wo + 3 * begin, forward, flag);
        nqm_brdf_eval(brdf, m, wo + 3 * begin, wi + 3 * begin, backward, flag_back);
        for (size_t i = 0; i < m; ++i) {
            report->n_clamped += flag[i] == NQM_VALUE_CLAMPED;
            report->n_invalid += flag[i] == NQM_VALUE_INVALID;
            double a = nqm_luminance(forward + 3 * i), b = nqm_luminance(backward + 3 * i), mean = 0.5 * (a + b);
            if (flag[i] == NQM_VALUE_INVALID || flag_back[i] == NQM_VALUE_INVALID)
                continue;
            report->reciprocity_median = report->reciprocity_p95 = 0;
            if (mean > 1e-4)
                difference[n_differences++] = fabs(a - b) / mean;
        }
    }
    if (n_differences == 0)
        return;
    report->reciprocity_median = nqm_quantile(n_differences, difference, 0.5);
    report->reciprocity_p95 = nqm_quantile(n_differences, difference, 0.95);
}

static void find_largest_albedo(const nqm_brdf *brdf, uint64_t seed, nqm_brdf_check_report *report) {
    double largest = -1;
    for (int k = 0; k < N_ANGLES; ++k) {
        double theta = k * 15 * NQM_PI / 180, rgb[3];
        nqm_brdf_albedo(brdf, theta, seed, rgb);
        for (int c = 0; c < 3; ++c) {
            report->albedo_max[c] = fmax(report->albedo_max[c], rgb[c]);
            if (rgb[c] > largest) {
                largest = rgb[c];
                report->albedo_max_theta_rad = theta;
            }
        }
    }
}

nqm_status nqm_brdf_check(const nqm_brdf *brdf, uint64_t seed, nqm_brdf_check_report *report_ret, nqm_error *err) {
    NQM_REQUIRE(err, brdf, report_ret);
    const size_t n_rows = nqm_scattered_rows(brdf, NULL, NULL), n_most = nqm_larger(n_rows, N_PAIRS);
    nqm_brdf_check_report report;
    double *wi, *wo, *difference;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&wi, n_most, 3 * sizeof *wi}, {&wo, n_most, 3 * sizeof *wo},
                                                    {&difference, n_most, sizeof *difference}),
                                         err);
    if (status != NQM_OK)
        return status;
    nqm_rng rng = nqm_rng_make(seed, CHECK_STREAM);
    for (size_t i = 0; i < N_PAIRS; ++i)
        draw_pair(brdf->info.isotropic, &rng, i, 85, wi + 3 * i, wo + 3 * i);
    compare(brdf, N_PAIRS, wi, wo, difference, &report);
    if (n_rows && 2 * report.n_invalid > report.n_pairs) { /* a list of measured directions: these are tested */
        nqm_scattered_rows(brdf, wi, wo);
        compare(brdf, n_rows, wi, wo, difference, &report);
        report.albedo_max[0] = report.albedo_max[1] = report.albedo_max[2] = report.albedo_max_theta_rad = NAN;
    } else {
        find_largest_albedo(brdf, seed, &report);
    }
    report.anisotropy = nqm_brdf_anisotropy(brdf);
    nqm_free(wi);
    *report_ret = report;
    return NQM_OK;
}

/* ---- difference -------------------------------------------------------------------------------------------------- */

/* Add the values of a pair at one direction. */
static void add_difference(const double *wi, const double *wo, const double *ref, const double *test, double tolerance,
                           nqm_brdf_difference *d) {
    static const double nothing = 1e-9; /* 1/sr; below it rounding decides */
    bool differs = false;
    for (size_t c = 0; c < 3; ++c) {
        const double larger = fmax(ref[c], test[c]), relative = fabs(ref[c] - test[c]) / fmax(larger, nothing);
        differs |= relative > tolerance;
        if (relative <= d->largest)
            continue;
        d->largest = relative;
        d->channel = (int)c;
        d->ref = ref[c];
        d->test = test[c];
        memcpy(d->wi, wi, sizeof d->wi);
        memcpy(d->wo, wo, sizeof d->wo);
    }
    d->n_different += differs;
}

static void compare_brdfs(const nqm_brdf *const brdfs[2], size_t n, const double *wi, const double *wo,
                          double tolerance, nqm_brdf_difference *d) {
    double rgb[2][3 * BLOCK];
    uint8_t flag[2][BLOCK];
    for (size_t begin = 0, m; begin < n; begin += m) {
        m = nqm_smaller(n - begin, BLOCK);
        for (size_t k = 0; k < 2; ++k)
            nqm_brdf_eval(brdfs[k], m, wi + 3 * begin, wo + 3 * begin, rgb[k], flag[k]);
        for (size_t i = 0; i < m; ++i) {
            const bool has_ref = nqm_has_value(flag[0][i]), has_test = nqm_has_value(flag[1][i]);
            const size_t at = 3 * (begin + i);
            d->n_pairs += has_ref || has_test;
            d->n_missing += has_ref != has_test;
            if (has_ref && has_test)
                add_difference(wi + at, wo + at, rgb[0] + 3 * i, rgb[1] + 3 * i, tolerance, d);
        }
    }
    d->is_equal = d->n_pairs > 0 && d->n_different + d->n_missing == 0;
}

nqm_status nqm_brdf_compare(const nqm_brdf *ref, const nqm_brdf *test, double tolerance, uint64_t seed,
                            nqm_brdf_difference *difference_ret, nqm_error *err) {
    NQM_REQUIRE(err, ref, test, difference_ret);
    if (!(tolerance >= 0))
        return nqm_fail(err, NQM_ERR_ARG, -1, "the tolerance of a comparison must not be below 0; it is %g", tolerance);
    const nqm_brdf *const brdfs[] = {ref, test};
    const size_t n_ref = nqm_scattered_rows(ref, NULL, NULL), n_test = nqm_scattered_rows(test, NULL, NULL);
    const size_t n = N_PAIRS + n_ref + n_test;
    nqm_brdf_difference difference = {0};
    double *wi, *wo;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&wi, n, 3 * sizeof *wi}, {&wo, n, 3 * sizeof *wo}), err);
    if (status != NQM_OK)
        return status;
    nqm_rng rng = nqm_rng_make(seed, COMPARE_STREAM);
    for (size_t i = 0; i < N_PAIRS; ++i)
        draw_pair(ref->info.isotropic && test->info.isotropic, &rng, i, 89, wi + 3 * i, wo + 3 * i);
    if (n_ref)
        nqm_scattered_rows(ref, wi + (size_t)3 * N_PAIRS, wo + (size_t)3 * N_PAIRS);
    if (n_test)
        nqm_scattered_rows(test, wi + 3 * (N_PAIRS + n_ref), wo + 3 * (N_PAIRS + n_ref));
    compare_brdfs(brdfs, n, wi, wo, tolerance, &difference);
    nqm_free(wi);
    if (difference.n_pairs == difference.n_missing)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s and %s: there is no direction where both have a value",
                        nqm_brdf_get_info(ref).name, nqm_brdf_get_info(test).name);
    *difference_ret = difference;
    return NQM_OK;
}
