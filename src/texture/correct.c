/* SPDX-License-Identifier: MIT
 *
 * The mean Delta-E of texels whose normals differ, from few of them: by a regression on what is cheap to know of many
 * (Cochran 1977, Sampling Techniques, chapter 12, double sampling): the Delta-E with equal normals, and the angle
 * between the normals.
 */
#include "texture/score.h"

#include <math.h>

enum { MORE = 4 }; /* texels whose covariates are known, for each that is scored */

typedef struct angles {
    const nqm_texture_job *job;
    nqm_covariates *next; /* of the next texel that is visited */
} angles;

static nqm_status find_angles(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                              nqm_error *err) {
    angles *to = user;
    (void)samples, (void)err;
    for (size_t i = 0; i < n; ++i, ++to->next) {
        double tilt[3];
        nqm_texels_tilt(to->job, rows, i, tilt);
        to->next->x[1] = atan2(hypot(tilt[0], tilt[1]), tilt[2]);
    }
    return NQM_OK;
}

/* samples: (n) are overwritten. */
static nqm_status find_covariates(nqm_texture_job *job, size_t n, nqm_texel_sample *samples, nqm_covariates *x,
                                  nqm_error *err) {
    nqm_status status = nqm_texels_score(job, "near", NQM_EXCHANGE_FLAT, n, samples, NULL, err);
    for (size_t i = 0; i < n; ++i)
        x[i].x[0] = samples[i].delta_e;
    return status == NQM_OK ? nqm_texels_visit(job, NULL, n, samples, find_angles, &(angles){job, x}, err) : status;
}

/* By the normal equations. */
void nqm_covariate_slopes(size_t n, const nqm_texel_sample *y, const nqm_covariates *x, double slope[2]) {
    double mean[3] = {0}, xx = 0, xz = 0, zz = 0, xy = 0, zy = 0;
    for (size_t i = 0; i < n; ++i) {
        mean[0] += x[i].x[0] / (double)n;
        mean[1] += x[i].x[1] / (double)n;
        mean[2] += y[i].delta_e / (double)n;
    }
    for (size_t i = 0; i < n; ++i) {
        const double a = x[i].x[0] - mean[0], b = x[i].x[1] - mean[1], c = y[i].delta_e - mean[2];
        xx += a * a;
        xz += a * b;
        zz += b * b;
        xy += a * c;
        zy += b * c;
    }
    const double determinant = xx * zz - xz * xz;
    const bool is_regular = determinant > 1e-9 * xx * zz;
    slope[0] = is_regular ? (zz * xy - xz * zy) / determinant : xx > 0 ? xy / xx : 0;
    slope[1] = is_regular ? (xx * zy - xz * xy) / determinant : xx > 0 || zz <= 0 ? 0 : zy / zz;
}

/* The variance of the mean of a stratified sample by the steps between neighbours; *mean receives that mean. y NULL: of
 * the regression, else of its residuals. */
static double variance(size_t n, const nqm_texel_sample *y, const nqm_covariates *x, const double slope[2],
                       double *mean) {
    double sum = 0, squares = 0, last = 0;
    for (size_t i = 0; i < n; ++i) {
        const double fit = slope[0] * x[i].x[0] + slope[1] * x[i].x[1], v = y ? y[i].delta_e - fit : fit;
        squares += i ? (v - last) * (v - last) / 2 : 0;
        sum += v;
        last = v;
    }
    *mean = sum / (double)n;
    return squares / (double)(n - 1) / (double)n;
}

nqm_status nqm_texels_correct(nqm_texture_job *job, size_t n, const nqm_texel_sample *samples, nqm_error *err) {
    const size_t n_more = nqm_smaller(MORE * n, job->order.n);
    double slope[2], residual, fit, mean = 0;
    nqm_covariates *few, *many;
    nqm_texel_sample *more;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&few, n, sizeof *few}, {&many, n_more, sizeof *many}, {&more, n_more, sizeof *more}), err);
    if (status != NQM_OK)
        return status;
    memcpy(more, samples, n * sizeof *more);
    status = find_covariates(job, n, more, few, err);
    if (status == NQM_OK) {
        const size_t n_chosen = nqm_texels_choose(&job->order, n_more, job->options.seed + 3, more);
        status = find_covariates(job, n_chosen, more, many, err);
    }
    for (size_t i = 0; i < n; ++i)
        mean += samples[i].delta_e / (double)n;
    if (status == NQM_OK) {
        nqm_covariate_slopes(n, samples, few, slope);
        job->error = sqrt(variance(n, samples, few, slope, &residual) + variance(n_more, NULL, many, slope, &fit));
        job->correction = residual + fit - mean;
    }
    nqm_free(few);
    return status;
}
