/* SPDX-License-Identifier: MIT
 *
 * The score of approximations against one reference: sample, compare, predict, in batches of tests.
 */
#include "brdf/brdf.h"
#include "metric/metric.h"

#include <math.h>
#include <string.h>

/* Beyond this many standard deviations of the training references a value counts as unusual. */
static const float unusual_sigma = 6;

/* Arrays of tests hold one batch. */
struct nqm_scorer {
    const nqm_model *model;
    const nqm_directions *directions;
    nqm_score_options options;
    size_t max_batch;
    float *ref, *test;               /* (n_directions, 3), (max_batch, n_directions, 3) */
    const float **refs, **tests;     /* (max_batch) of each pair */
    uint8_t *ref_flag;               /* (n_directions) nqm_value_flag */
    uint8_t *used;                   /* (max_batch, n_directions) directions that count */
    double *jod, *delta_e, *novelty; /* (max_batch) */
    double *metrics;                 /* (max_batch, NQM_METRIC_COUNT) */
    nqm_member ref_member;
    nqm_predictor *predictor;
    const nqm_brdf *const *brdfs; /* of this batch */
    nqm_score_result *results;    /* of this batch */
};

nqm_score_options nqm_score_options_default(void) {
    return (nqm_score_options){.invalid = NQM_INVALID_DROP, .min_valid_fraction = 0.9};
}

nqm_status nqm_score_options_check(const nqm_score_options *options, nqm_error *err) {
    if (!(options->min_valid_fraction >= 0 && options->min_valid_fraction <= 1))
        return nqm_fail(err, NQM_ERR_ARG, -1, "fraction of valid directions: %g is outside 0..1",
                        options->min_valid_fraction);
    if (!nqm_precision_name(options->precision))
        return nqm_fail(err, NQM_ERR_ARG, -1, "precision: %d is none", (int)options->precision);
    return NQM_OK;
}

nqm_score_result nqm_no_score(nqm_status status) {
    nqm_score_result result = {
        .status = status, .jod = NAN, .delta_e = NAN, .jod_low = NAN, .jod_high = NAN, .novelty = NAN};
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        result.metrics[m] = NAN;
    return result;
}

size_t nqm_count_unusual(const nqm_model *model, const float *rgb) {
    float limit[3]; /* in reflectance: the transform is monotone, so nothing has to be transformed */
    for (size_t k = 0; k < 3; ++k) {
        float root = expm1f(model->mean[k] + unusual_sigma * model->std[k]);
        limit[k] = root * root * root;
    }
    size_t n_unusual = 0;
    for (size_t i = 0; i < model->n_directions; ++i, rgb += 3)
        n_unusual += rgb[0] > limit[0] || rgb[1] > limit[1] || rgb[2] > limit[2];
    return n_unusual;
}

void nqm_compare_members(const nqm_model *model, const nqm_score_options *options, const nqm_member *ref,
                         const nqm_member *test, uint8_t *used, nqm_score_result *result) {
    size_t n = model->n_directions;
    *result = nqm_no_score(test->status);
    result->n_clamped_ref = ref->report.n_clamped;
    result->n_invalid_ref = ref->report.n_invalid;
    result->n_unusual_ref = ref->n_unusual;
    result->n_clamped_test = test->report.n_clamped;
    result->n_invalid_test = test->report.n_invalid;
    bool equal = true;
    for (size_t k = 0; k < n; ++k) {
        bool valid = nqm_has_value(ref->flag[k]) && nqm_has_value(test->flag[k]);
        result->n_valid += valid;
        /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): the same bits are meant */
        equal = equal && (!valid || memcmp(ref->rgb + 3 * k, test->rgb + 3 * k, 3 * sizeof(float)) == 0);
        used[k] = valid || options->invalid != NQM_INVALID_DROP;
    }
    if (result->status == NQM_OK &&
        (result->n_valid == 0 || (double)result->n_valid < options->min_valid_fraction * (double)n))
        result->status = NQM_ERR_INCOMPATIBLE;
    if (result->status != NQM_OK)
        return;
    result->identical = equal;
    result->n_unusual_test = test->n_unusual;
}

void nqm_score_settle(const nqm_model *model, nqm_score_result *result, double jod, double delta_e, double novelty,
                      const double *metrics) {
    if (result->status != NQM_OK)
        return;
    if (!isfinite(jod)) {
        *result = nqm_no_score(NQM_ERR_NUMERIC);
        return;
    }
    result->jod = jod;
    result->delta_e = delta_e;
    if (metrics)
        memcpy(result->metrics, metrics, sizeof result->metrics);
    result->novelty = novelty;
    nqm_model_interval(model, jod, novelty, &result->jod_low, &result->jod_high);
    if (result->identical && model->interval) /* equal BRDFs make equal pictures */
        result->jod_low = result->jod_high = 10;
}

/* Sample test i of the batch and compare it with the reference, all but what the predictor says. */
static void compare(void *user, size_t i) {
    nqm_scorer *s = user;
    size_t n = s->directions->n;
    float *rgb = s->test + 3 * n * i;
    uint8_t *used = s->used + n * i; /* holds the test's flags first */
    nqm_member test = {.rgb = rgb, .flag = used};
    test.status = nqm_sample(s->brdfs[i], s->directions, s->options.invalid, rgb, used, &test.report, NULL);
    test.n_unusual = nqm_count_unusual(s->model, rgb);
    nqm_compare_members(s->model, &s->options, &s->ref_member, &test, used, &s->results[i]);
    s->refs[i] = s->ref;
    s->tests[i] = rgb;
    if (s->results[i].status != NQM_OK) { /* the network sees a pair without values; its answer is not used */
        memset(used, 0, n);
        s->tests[i] = s->ref;
    }
}

static void score_batch(nqm_scorer *s, size_t n) {
    if (n == 1)
        compare(s, 0);
    else
        nqm_parallel_for(n, compare, s);
    const nqm_sampled_pairs pairs = {
        .n = n, .ref = s->refs, .test = s->tests, .used = s->used, .metrics = s->metrics, .novelty = s->novelty};
    nqm_predictor_run(s->predictor, &pairs, s->jod, s->delta_e);
    for (size_t i = 0; i < n; ++i)
        nqm_score_settle(s->model, &s->results[i], s->jod[i], s->delta_e[i], s->novelty[i],
                         s->metrics + i * NQM_METRIC_COUNT);
}

static nqm_status make_room(nqm_scorer *s, nqm_error *err) {
    size_t n = s->directions->n;
    s->ref = nqm_alloc(n, 3 * sizeof *s->ref);
    s->ref_flag = nqm_alloc(n, sizeof *s->ref_flag);
    s->test = nqm_alloc(s->max_batch, 3 * n * sizeof *s->test);
    s->refs = nqm_alloc(s->max_batch, sizeof *s->refs);
    s->tests = nqm_alloc(s->max_batch, sizeof *s->tests);
    s->used = nqm_alloc(s->max_batch, n * sizeof *s->used);
    s->jod = nqm_alloc(s->max_batch, sizeof *s->jod);
    s->delta_e = nqm_alloc(s->max_batch, sizeof *s->delta_e);
    s->novelty = nqm_alloc(s->max_batch, sizeof *s->novelty);
    s->metrics = nqm_alloc(s->max_batch, NQM_METRIC_COUNT * sizeof *s->metrics);
    if (!s->ref || !s->ref_flag || !s->test || !s->refs || !s->tests || !s->used || !s->jod || !s->delta_e ||
        !s->novelty || !s->metrics)
        return nqm_fail_nomem(err, (s->max_batch + 1) * n * (3 * sizeof(float) + 1));
    return nqm_predictor_create(s->model, s->options.precision, s->max_batch, &s->predictor, err);
}

nqm_status nqm_scorer_create(const nqm_model *model, const nqm_score_options *options, size_t max_batch,
                             nqm_scorer **scorer_ret, nqm_error *err) {
    *scorer_ret = NULL;
    const nqm_score_options o = options ? *options : nqm_score_options_default();
    nqm_status status = nqm_score_options_check(&o, err);
    if (status != NQM_OK)
        return status;
    if (max_batch < 1)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a scorer of batches of 0 tests");
    nqm_scorer *s = nqm_alloc(1, sizeof *s);
    if (!s)
        return nqm_fail_nomem(err, sizeof *s);
    *s = (nqm_scorer){.model = model,
                      .directions = model->directions,
                      .options = o,
                      .max_batch = max_batch < NQM_PREDICT_BATCH ? max_batch : NQM_PREDICT_BATCH};
    status = make_room(s, err);
    if (status == NQM_OK)
        *scorer_ret = s;
    else
        nqm_scorer_free(s);
    return status;
}

void nqm_scorer_free(nqm_scorer *scorer) {
    if (!scorer)
        return;
    void *blocks[] = {scorer->ref,  scorer->ref_flag, scorer->test,    scorer->refs,    scorer->tests,
                      scorer->used, scorer->jod,      scorer->delta_e, scorer->novelty, scorer->metrics};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
    nqm_predictor_free(scorer->predictor);
    nqm_free(scorer);
}

nqm_status nqm_scorer_run(nqm_scorer *s, const nqm_brdf *ref, size_t n_tests, const nqm_brdf *const *tests,
                          nqm_score_result *results, nqm_error *err) {
    if (n_tests == 0)
        return NQM_OK;
    s->ref_member = (nqm_member){.rgb = s->ref, .flag = s->ref_flag};
    nqm_status status =
        nqm_sample(ref, s->directions, s->options.invalid, s->ref, s->ref_flag, &s->ref_member.report, err);
    if (status != NQM_OK)
        return status;
    s->ref_member.n_unusual = nqm_count_unusual(s->model, s->ref);
    for (size_t begin = 0; begin < n_tests; begin += s->max_batch) {
        s->brdfs = tests + begin;
        s->results = results + begin;
        score_batch(s, n_tests - begin < s->max_batch ? n_tests - begin : s->max_batch);
    }
    return NQM_OK;
}

nqm_status nqm_score(const nqm_model *model, const nqm_brdf *ref, size_t n_tests, const nqm_brdf *const *tests,
                     const nqm_score_options *options, nqm_score_result *results, nqm_error *err) {
    nqm_scorer *scorer;
    nqm_status status = nqm_scorer_create(model, options, n_tests ? n_tests : 1, &scorer, err);
    if (status == NQM_OK)
        status = nqm_scorer_run(scorer, ref, n_tests, tests, results, err);
    nqm_scorer_free(scorer);
    return status;
}
