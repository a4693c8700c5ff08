/* SPDX-License-Identifier: MIT
 *
 * Near scores: texels that represent groups of alike pairs are scored as specs, and their Delta-E is averaged. Where normals differ
 * the test is tilted, and the pair anisotropic, which takes 15 times as long: then a quarter as many texels are scored.
 */
#include "texture/score.h"

#include <math.h>
#include <stdlib.h>

enum { BLOCK = NQM_TEXEL_BLOCK };
_Static_assert((int)BLOCK == (int)NQM_SCORE_BLOCK, "texels are scored in blocks");

nqm_texture_options nqm_texture_options_default(void) {
    return (nqm_texture_options){.n_texels = 2048, .blame = 1, .far = 1, .seed = 1};
}

/* ---- choice ------------------------------------------------------------------------------------------------------ */

size_t nqm_texels_choose(const nqm_texel_groups *g, size_t max_n, bool of_runs, uint64_t seed,
                         nqm_texel_choice *choices) {
    const bool of_groups = !of_runs && g->n_groups <= max_n;
    const size_t n = of_groups ? g->n_groups : nqm_smaller(max_n, g->n);
    for (size_t k = 0; k < n; ++k) {
        const size_t begin = of_groups ? g->begin[k] : g->n * k / n,
                     end = of_groups ? g->begin[k + 1] : g->n * (k + 1) / n;
        const size_t at = begin + nqm_hash_u64(seed, k) % (end - begin);
        choices[k] = (nqm_texel_choice){g->order[at], (double)(end - begin) / (double)g->n};
    }
    return n;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* The specs of a block of pairs. */
typedef struct block {
    char *ref[BLOCK], *test[BLOCK];
    nqm_named_pair pairs[BLOCK]; /* those that differ */
    nqm_score_result results[BLOCK];
    nqm_error errors[BLOCK];
} block;

/* The reference with one property of the test. A property that varies in the test only has to get a place. */
static char *exchange_property(const nqm_texel_pair *pair, const nqm_pair_property *p, size_t i,
                               const float *const values[2]) {
    const nqm_texture *ref = pair->side[0];
    nqm_texture exchanged = *ref;
    double v[3];
    for (size_t c = 0; c < p->n; ++c)
        v[c] = (double)nqm_texel_pair_value(p, 1, values[1], c, i);
    exchanged.n_varying = 0;
    for (size_t k = 0; k < ref->n_varying; ++k)
        if (strcmp(ref->varying[k].key, p->key) != 0)
            exchanged.varying[exchanged.n_varying++] = ref->varying[k];
    nqm_shading_set(&exchanged.shading, p->key, p->n, v);
    return nqm_texture_spec(&exchanged, values[0] + i, BLOCK);
}

static bool make_pair(const nqm_texel_pair *pair, int exchange, size_t i, const float *const values[2], block *b) {
    double normal[2][3], tilt[3];
    b->ref[i] = nqm_texture_spec(pair->side[0], values[0] + i, BLOCK);
    if (exchange == NQM_EXCHANGE_ALL)
        b->test[i] = nqm_texture_spec(pair->side[1], values[1] + i, BLOCK);
    else if (exchange == NQM_EXCHANGE_NORMAL)
        b->test[i] = b->ref[i] ? nqm_strdup(b->ref[i]) : NULL;
    else
        b->test[i] = exchange_property(pair, &pair->properties[exchange], i, values);
    if (pair->has_normals && exchange < 0) {
        for (size_t s = 0; s < 2; ++s)
            nqm_texel_pair_normal(pair, s, values[s], i, normal[s]);
        nqm_texel_pair_tilt(normal[0], normal[1], tilt);
        b->test[i] = nqm_texture_tilt(b->test[i], tilt);
    }
    return b->ref[i] && b->test[i];
}

static nqm_status fail_texel(const nqm_texture_job *job, uint32_t texel, const nqm_error *why, nqm_error *err) {
    const size_t width = job->pair.width;
    const nqm_status status = why->status == NQM_ERR_NOMEM ? NQM_ERR_NOMEM : NQM_ERR_INCOMPATIBLE;
    return nqm_fail(err, status, -1, "texel (%zu, %zu) of %s and %s: %.300s", texel % width, texel / width,
                    job->pair.side[0]->name, job->pair.side[1]->name, why->message);
}

static nqm_status score_block(nqm_texture_job *job, int exchange, size_t n, const nqm_texel_choice *choices, block *b,
                              nqm_texel_score *scores, nqm_error *err) {
    uint32_t texels[BLOCK];
    size_t n_pairs = 0, at[BLOCK];
    const float *values[2];
    const double same = job->model->interval ? 10 : NAN;
    for (size_t i = 0; i < n; ++i)
        texels[i] = choices[i].texel;
    nqm_texel_pair_evaluate(&job->pair, n, texels, 0, job->workspace, values);
    for (size_t i = 0; i < n; ++i) {
        if (!make_pair(&job->pair, exchange, i, values, b))
            return nqm_fail_nomem(err, sizeof(nqm_shading));
        scores[i] = (nqm_texel_score){.jod = 10, .jod_low = same, .jod_high = same};
        if (strcmp(b->ref[i], b->test[i]) != 0) {
            at[n_pairs] = i;
            b->pairs[n_pairs++] = (nqm_named_pair){b->ref[i], b->test[i]};
        }
    }
    nqm_status status = nqm_scorer_run_named(job->scorer, n_pairs, b->pairs, b->results, b->errors, err);
    for (size_t i = 0; status == NQM_OK && i < n_pairs; ++i) {
        const nqm_score_result *r = &b->results[i];
        scores[at[i]] = (nqm_texel_score){r->delta_e, r->jod, r->jod_low, r->jod_high, r->parts};
        if (r->status != NQM_OK)
            status = fail_texel(job, texels[at[i]], &b->errors[i], err);
    }
    return status;
}

nqm_status nqm_texels_score(nqm_texture_job *job, const char *stage, int exchange, size_t n,
                            const nqm_texel_choice *choices, nqm_texel_score *scores, nqm_error *err) {
    block *b = nqm_alloc(1, sizeof *b);
    nqm_status status = b ? NQM_OK : nqm_fail_nomem(err, sizeof *b);
    for (size_t first = 0, n_block; status == NQM_OK && first < n; first += n_block) {
        n_block = nqm_smaller(n - first, BLOCK);
        if (nqm_tick(&job->ticker, stage, (double)first, (double)n))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
        else
            status = score_block(job, exchange, n_block, choices + first, b, scores + first, err);
        for (size_t i = 0; i < n_block; ++i) {
            nqm_free(b->ref[i]);
            nqm_free(b->test[i]);
            b->ref[i] = b->test[i] = NULL;
        }
    }
    nqm_free(b);
    return status;
}

/* ---- summary ----------------------------------------------------------------------------------------------------- */

/* The inverse of nqm_curve_jod(). The worst JODs of a model lie beyond the largest Delta-E that colours have. */
static double delta_e_of(const nqm_curve *curve, double jod) {
    enum { MOST = 1000 };
    if (!(jod < 10))
        return jod >= 10 ? 0 : NAN;
    const double power = -log(fmax(jod, 1e-9) / (10 - jod)) / curve->b1 - curve->b2;
    return power > 0 ? fmin(pow(power, 1 / curve->b3), MOST) : MOST;
}

/* A texel's score with its weight, for sorting. */
typedef struct ranked {
    double delta_e, jod, weight;
} ranked;

static int compare_ranked(const void *a, const void *b) {
    const double x = ((const ranked *)a)->delta_e, y = ((const ranked *)b)->delta_e;
    return (x > y) - (x < y);
}

static nqm_status rank(size_t n, const nqm_texel_choice *choices, const nqm_texel_score *scores,
                       nqm_texture_result *result, nqm_error *err) {
    static const double level[2] = {9, 8};
    ranked *list = nqm_alloc(n, sizeof *list);
    if (!list)
        return nqm_fail_nomem(err, n * sizeof *list);
    for (size_t i = 0; i < n; ++i) {
        list[i] = (ranked){scores[i].delta_e, scores[i].jod, choices[i].weight};
        for (size_t k = 0; k < 2; ++k)
            result->below[k] += scores[i].jod < level[k] ? choices[i].weight : 0;
    }
    qsort(list, n, sizeof *list, compare_ranked);
    double sum = 0;
    result->median = result->worst = list[n - 1].jod;
    for (size_t i = n; i-- > 0;) { /* from the worst; 1e-9: sums of weights are rounded */
        sum += list[i].weight;
        if (sum - list[i].weight < 0.05 - 1e-9)
            result->worst = list[i].jod;
        if (sum - list[i].weight < 0.5 - 1e-9)
            result->median = list[i].jod;
    }
    nqm_free(list);
    return NQM_OK;
}

/* Neighbouring runs are about as different as texels of one run. */
static double sampling_error(size_t n, const nqm_texel_score *scores) {
    double squares = 0;
    for (size_t i = 1; i < n; ++i)
        squares += (scores[i].delta_e - scores[i - 1].delta_e) * (scores[i].delta_e - scores[i - 1].delta_e) / 2;
    return n > 1 ? sqrt(squares / (double)(n - 1) / (double)n) : 0;
}

static void summarise(const nqm_texture_job *job, size_t n, const nqm_texel_choice *choices,
                      const nqm_texel_score *scores, nqm_texture_result *result) {
    const nqm_curve *curve = &job->model->curve;
    const double error = job->groups.is_sample ? sampling_error(n, scores) : 0, spread = 1.96 * error;
    double delta_e = 0, low = 0, high = 0;
    for (size_t i = 0; i < n; ++i) {
        const double weight = choices[i].weight;
        delta_e += weight * scores[i].delta_e;
        low += weight * delta_e_of(curve, scores[i].jod_low);
        high += weight * delta_e_of(curve, scores[i].jod_high);
        nqm_label_add(&result->parts, weight, &scores[i].parts);
    }
    result->delta_e = delta_e;
    result->jod = n == 1 ? scores->jod : nqm_curve_jod(curve, delta_e);
    result->error = error * fabs(nqm_curve_slope(curve, delta_e));
    result->jod_low = n == 1 ? scores->jod_low : isnan(low) ? low : nqm_curve_jod(curve, low + spread);
    result->jod_high = n == 1 ? scores->jod_high : isnan(high) ? high : nqm_curve_jod(curve, high - spread);
}

static nqm_status score_near(nqm_texture_job *job, nqm_texture_result *result, float *delta_e, nqm_error *err) {
    const nqm_texel_groups *g = &job->groups;
    nqm_texel_choice *choices;
    nqm_texel_score *scores;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&choices, g->n_groups, sizeof *choices}, {&scores, g->n_groups, sizeof *scores}), err);
    if (status != NQM_OK)
        return status;
    const size_t n = nqm_texels_choose(g, g->n_groups, false, job->options.seed, choices);
    status = nqm_texels_score(job, "near", NQM_EXCHANGE_ALL, n, choices, scores, err);
    if (status == NQM_OK) {
        summarise(job, n, choices, scores, result);
        status = rank(n, choices, scores, result, err);
    }
    for (size_t k = 0; status == NQM_OK && delta_e && k < n; ++k)
        for (size_t i = g->begin[k]; i < g->begin[k + 1]; ++i)
            delta_e[g->order[i]] = (float)scores[k].delta_e;
    nqm_free(choices);
    return status;
}

/* ---- score ------------------------------------------------------------------------------------------------------- */

static nqm_status prepare(nqm_texture_job *job, nqm_error *err) {
    enum { TILTED = 4, LEAST = 16 };
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    nqm_status status = nqm_scorer_create(job->model, &options, &job->scorer, err);
    job->workspace = nqm_alloc(nqm_texel_pair_workspace(&job->pair), sizeof *job->workspace);
    if (status == NQM_OK && !job->workspace)
        status = nqm_fail_nomem(err, nqm_texel_pair_workspace(&job->pair) * sizeof *job->workspace);
    if (status == NQM_OK)
        status = nqm_texel_pair_measure(&job->pair, &job->ticker, err);
    if (status != NQM_OK)
        return status;
    const size_t n = job->options.n_texels;
    return nqm_texel_groups_find(&job->pair, nqm_texel_pair_tilts(&job->pair) ? nqm_larger(n / TILTED, LEAST) : n,
                                 job->options.exact, &job->ticker, &job->groups, err);
}

nqm_status nqm_texture_score(const nqm_model *model, const nqm_texture *ref, const nqm_texture *test,
                             const nqm_texture_options *options, nqm_texture_result *result_ret, float *delta_e,
                             nqm_error *err) {
    NQM_REQUIRE(err, model, ref, test, result_ret);
    nqm_texture_result result = {.far_jod = {NAN, NAN, NAN}, .far_delta_e = NAN};
    nqm_texture_job *job = nqm_alloc(1, sizeof *job);
    if (!job)
        return nqm_fail_nomem(err, sizeof *job);
    job->model = model;
    job->options = options ? *options : nqm_texture_options_default();
    job->ticker = (nqm_ticker){.fn = job->options.progress, .user = job->options.progress_user};
    nqm_status status = NQM_OK;
    if (model->target != NQM_TARGET_LOG_DELTA_E)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "model '%s' predicts no Delta-E, of which textures need the mean",
                          model->id);
    else if (job->options.n_texels < 16 || job->options.n_texels > 1000000)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "n_texels is %zu: 16 to 1000000 are allowed", job->options.n_texels);
    nqm_texel_pair_begin(ref, test, &job->pair);
    if (status == NQM_OK)
        status = prepare(job, err);
    if (status == NQM_OK)
        status = score_near(job, &result, delta_e, err);
    if (status == NQM_OK && job->options.blame && job->pair.is_same_model)
        status = nqm_texture_blame_find(job, &result, err);
    if (status == NQM_OK && job->options.far)
        status = nqm_texture_score_far(job, &result, err);
    result.width = job->pair.width;
    result.height = job->pair.height;
    result.n_different = job->groups.n_different;
    result.n_scored = job->groups.n_groups;
    if (status == NQM_OK)
        *result_ret = result;
    nqm_texel_groups_free(&job->groups);
    nqm_scorer_free(job->scorer);
    nqm_free(job->workspace);
    nqm_free(job);
    return status;
}
