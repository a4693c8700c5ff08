/* SPDX-License-Identifier: MIT
 *
 * Scores of textures. Near scores: the mean Delta-E of texels that represent groups of alike pairs.
 */
#include "texture/score.h"

#include <math.h>
#include <stdlib.h>

nqm_texture_options nqm_texture_options_default(void) {
    return (nqm_texture_options){.n_texels = 2048, .texels_per_pixel = 1, .blame = 1, .far = 1, .seed = 1};
}

/* ---- summary ----------------------------------------------------------------------------------------------------- */

/* Sorts the samples. */
static void find_percentiles(size_t n, nqm_texel_sample *samples, nqm_texture_result *result) {
    qsort(samples, n, sizeof *samples, nqm_texels_compare_delta_e);
    result->median = result->worst = samples[n - 1].jod;
    double sum = 0; /* of the weights of worse samples; 1e-9: they are rounded */
    for (size_t i = n; i-- > 0;) {
        const nqm_texel_sample *s = &samples[i];
        result->below[0] += s->jod < 9 ? s->weight : 0;
        result->below[1] += s->jod < 8 ? s->weight : 0;
        if (sum < 0.05 - 1e-9)
            result->worst = s->jod;
        if (sum < 0.5 - 1e-9)
            result->median = s->jod;
        sum += s->weight;
    }
}

/* Neighbouring runs are about as different as texels of one run. */
static void find_means(const nqm_texture_job *job, size_t n, const nqm_texel_sample *samples,
                       nqm_texture_result *result) {
    const nqm_curve *curve = &job->model->curve;
    double low = job->correction, high = job->correction, squares = 0;
    result->delta_e = job->correction;
    for (size_t i = 0; i < n; ++i) {
        const double step = i ? samples[i].delta_e - samples[i - 1].delta_e : 0;
        squares += step * step / 2;
        result->delta_e += samples[i].weight * samples[i].delta_e;
        low += samples[i].weight * nqm_curve_delta_e(curve, samples[i].jod_low);
        high += samples[i].weight * nqm_curve_delta_e(curve, samples[i].jod_high);
    }
    const double of_runs = job->order.begin ? 0 : sqrt(squares / (double)(n - 1) / (double)n);
    const double error = job->error > 0 ? job->error : of_runs, spread = 1.96 * error;
    result->jod = n == 1 ? samples->jod : nqm_curve_jod(curve, result->delta_e);
    result->error = error * fabs(nqm_curve_slope(curve, result->delta_e));
    result->jod_low = n == 1 ? samples->jod_low : isnan(low) ? low : nqm_curve_jod(curve, low + spread);
    result->jod_high = n == 1 ? samples->jod_high : isnan(high) ? high : nqm_curve_jod(curve, high - spread);
}

static nqm_status score_near(nqm_texture_job *job, nqm_texture_result *result, float *delta_e, nqm_error *err) {
    const double enough = 0.01; /* JOD, so that 95 % of errors are below .02 */
    const nqm_texel_order *o = &job->order;
    nqm_texel_sample *samples = nqm_alloc(o->n_groups, sizeof *samples);
    if (!samples)
        return nqm_fail_nomem(err, o->n_groups * sizeof *samples);
    const size_t n = nqm_texels_choose(o, o->n_groups, job->options.seed, samples);
    nqm_status status = job->options.texels_per_pixel > 1
                            ? nqm_pixels_score(job, n, samples, &result->parts, err)
                            : nqm_texels_score(job, "near", NQM_EXCHANGE_ALL, n, samples, &result->parts, err);
    if (status == NQM_OK && !o->begin && job->options.texels_per_pixel == 1 && nqm_texels_differ(job, NQM_TILT, 0))
        status = nqm_texels_correct(job, n, samples, err);
    for (size_t k = 0; status == NQM_OK && delta_e && k < n; ++k)
        for (size_t i = nqm_texels_begin(o, n, k); i < nqm_texels_begin(o, n, k + 1); ++i)
            delta_e[o->texels[i]] = (float)samples[k].delta_e;
    if (status == NQM_OK) {
        find_means(job, n, samples, result);
        find_percentiles(n, samples, result);
    }
    nqm_free(samples);
    const size_t n_more = job->options.texels_per_pixel > 1 ? n : nqm_smaller(job->options.n_texels, o->n);
    if (status == NQM_OK && result->error > enough && n < n_more) {
        job->order.n_groups = n_more;
        result->parts = (nqm_label){0};
        memset(result->below, 0, sizeof result->below);
        return score_near(job, result, delta_e, err);
    }
    return status;
}

/* ---- score ------------------------------------------------------------------------------------------------------- */

static nqm_status score(nqm_texture_job *job, nqm_texture_result *result, float *delta_e, nqm_error *err) {
    enum { N_PIXELS = 256, N_PIXELS_TILTED = 48, LEAST = 16 };
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    for (size_t axis = 0; axis < 2; ++axis)
        job->period[axis] =
            1 / (double)nqm_texture_tiles(job->side[0], job->side[1], axis, axis ? &job->height : &job->width);
    nqm_status status = nqm_scorer_create(job->model, &options, &job->scorer, err);
    if (status == NQM_OK)
        status = nqm_texels_compare(job, err);
    if (status == NQM_OK && job->options.texels_per_pixel > 1) {
        job->order.begin = NULL; /* runs, one pixel of each */
        job->order.n_groups = nqm_smaller(job->order.n, job->has_normals ? N_PIXELS_TILTED : N_PIXELS);
    } else if (status == NQM_OK && !job->order.begin) { /* half, unless their error is too large */
        job->order.n_groups = nqm_smaller(job->order.n_groups, nqm_larger(job->options.n_texels / 2, LEAST));
    }
    result->texels_per_pixel = job->options.texels_per_pixel;
    result->width = job->width;
    result->height = job->height;
    result->n_different = job->n_different;
    if (status == NQM_OK)
        status = score_near(job, result, delta_e, err);
    result->n_scored = job->order.n_groups;
    if (status == NQM_OK && job->options.blame && job->is_same_model && job->options.texels_per_pixel == 1)
        status = nqm_texture_blame_find(job, result, err);
    if (status == NQM_OK && job->options.far)
        status = nqm_texture_score_far(job, result, err);
    return status;
}

nqm_status nqm_texture_score(const nqm_model *model, const nqm_texture *ref, const nqm_texture *test,
                             const nqm_texture_options *options, nqm_texture_result *result_ret, float *delta_e,
                             nqm_error *err) {
    NQM_REQUIRE(err, model, ref, test, result_ret);
    const nqm_texture_options o = options ? *options : nqm_texture_options_default();
    nqm_texture_result result = {.far_jod = {NAN, NAN, NAN}, .far_delta_e = NAN};
    if (model->target != NQM_TARGET_LOG_DELTA_E)
        return nqm_fail(err, NQM_ERR_ARG, -1, "model '%s' predicts no Delta-E, of which textures need the mean",
                        model->id);
    if (o.n_texels < 16 || o.n_texels > 1000000)
        return nqm_fail(err, NQM_ERR_ARG, -1, "n_texels is %zu: 16 to 1000000 are allowed", o.n_texels);
    if (o.texels_per_pixel < 1 || o.texels_per_pixel > NQM_RASTER_MAX_SIDE)
        return nqm_fail(err, NQM_ERR_ARG, -1, "texels_per_pixel is %zu: 1 to %d are allowed", o.texels_per_pixel,
                        (int)NQM_RASTER_MAX_SIDE);
    nqm_texture_job *job = nqm_alloc(1, sizeof *job);
    if (!job)
        return nqm_fail_nomem(err, sizeof *job);
    job->model = model;
    job->options = o;
    job->ticker = (nqm_ticker){.fn = o.progress, .user = o.progress_user};
    job->side[0] = ref;
    job->side[1] = test;
    job->has_normals = ref->normal != NQM_NO_NODE || test->normal != NQM_NO_NODE;
    nqm_status status = score(job, &result, delta_e, err);
    if (status == NQM_OK)
        *result_ret = result;
    nqm_free(job->order.texels);
    nqm_scorer_free(job->scorer);
    nqm_free(job);
    return status;
}
