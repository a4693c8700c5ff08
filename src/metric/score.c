/* SPDX-License-Identifier: MIT
 *
 * The score of approximations against one reference: sample, compare, predict, in batches of tests.
 */
#include "metric/metric.h"

#include <math.h>
#include <string.h>

/* Beyond this many standard deviations of the training references a value counts as unusual. */
static const float unusual_sigma = 6;

/* Everything one call works with; arrays of tests hold one batch. */
typedef struct scorer {
    const nqm_model *model;
    const nqm_directions *directions;
    nqm_score_options options;
    size_t batch;
    float *ref, *test;               /* (n_directions, 3), (batch, n_directions, 3) */
    uint8_t *ref_flag;               /* (n_directions) nqm_value_flag */
    uint8_t *used;                   /* (batch, n_directions) directions that count */
    double *jod, *delta_e, *novelty; /* (batch) */
    nqm_member ref_member;
    nqm_predictor *predictor;
    const nqm_brdf *const *tests; /* of this batch */
    nqm_score_result *results;    /* of this batch */
} scorer;

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

static bool has_value(uint8_t flag) {
    return flag == NQM_VALUE_OK || flag == NQM_VALUE_CLAMPED;
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
                         const nqm_member *test, bool with_metrics, uint8_t *used, nqm_score_result *result) {
    size_t n = model->n_directions;
    *result = nqm_no_score(test->status);
    result->n_clamped_ref = ref->report.n_clamped;
    result->n_invalid_ref = ref->report.n_invalid;
    result->n_unusual_ref = ref->n_unusual;
    result->n_clamped_test = test->report.n_clamped;
    result->n_invalid_test = test->report.n_invalid;
    bool equal = true;
    for (size_t k = 0; k < n; ++k) {
        bool valid = has_value(ref->flag[k]) && has_value(test->flag[k]);
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
    if (with_metrics)
        nqm_metrics_compute(model->directions, ref->rgb, test->rgb, used, result->metrics);
}

void nqm_score_settle(const nqm_model *model, nqm_score_result *result, double jod, double delta_e, double novelty) {
    if (result->status != NQM_OK)
        return;
    if (!isfinite(jod)) {
        *result = nqm_no_score(NQM_ERR_NUMERIC);
        return;
    }
    result->jod = jod;
    result->delta_e = delta_e;
    result->novelty = novelty;
    nqm_model_interval(model, jod, novelty, &result->jod_low, &result->jod_high);
    if (result->identical && model->interval) /* equal BRDFs make equal pictures */
        result->jod_low = result->jod_high = 10;
}

/* Sample test i of the batch and compare it with the reference, all but the JOD. */
static void compare(void *user, size_t i) {
    scorer *s = user;
    size_t n = s->directions->n;
    float *rgb = s->test + 3 * n * i;
    uint8_t *used = s->used + n * i; /* holds the test's flags first */
    nqm_member test = {.rgb = rgb, .flag = used};
    test.status = nqm_sample(s->tests[i], s->directions, s->options.invalid, rgb, used, &test.report, NULL);
    test.n_unusual = nqm_count_unusual(s->model, rgb);
    nqm_compare_members(s->model, &s->options, &s->ref_member, &test, true, used, &s->results[i]);
    if (s->results[i].status != NQM_OK) {
        memset(used, 0, n); /* the network sees a neutral pair; its answer is not used */
        memset(rgb, 0, 3 * n * sizeof *rgb);
    }
}

static void score_batch(scorer *s, size_t n) {
    if (n == 1)
        compare(s, 0);
    else
        nqm_parallel_for(n, compare, s);
    nqm_sampled_pairs pairs = {
        .n = n, .one_ref = true, .ref = s->ref, .test = s->test, .used = s->used, .novelty = s->novelty};
    nqm_predictor_run(s->predictor, &pairs, s->jod, s->delta_e);
    for (size_t i = 0; i < n; ++i)
        nqm_score_settle(s->model, &s->results[i], s->jod[i], s->delta_e[i], s->novelty[i]);
}

static nqm_status make_room(scorer *s, nqm_error *err) {
    size_t n = s->directions->n;
    s->ref = nqm_alloc(n, 3 * sizeof *s->ref);
    s->ref_flag = nqm_alloc(n, sizeof *s->ref_flag);
    s->test = nqm_alloc(s->batch, 3 * n * sizeof *s->test);
    s->used = nqm_alloc(s->batch, n * sizeof *s->used);
    s->jod = nqm_alloc(s->batch, sizeof *s->jod);
    s->delta_e = nqm_alloc(s->batch, sizeof *s->delta_e);
    s->novelty = nqm_alloc(s->batch, sizeof *s->novelty);
    if (!s->ref || !s->ref_flag || !s->test || !s->used || !s->jod || !s->delta_e || !s->novelty)
        return nqm_fail_nomem(err, (s->batch + 1) * n * (3 * sizeof(float) + 1));
    return nqm_predictor_create(s->model, s->options.precision, s->batch, &s->predictor, err);
}

static void release(scorer *s) {
    void *blocks[] = {s->ref, s->ref_flag, s->test, s->used, s->jod, s->delta_e, s->novelty};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
    nqm_predictor_free(s->predictor);
}

nqm_status nqm_score(const nqm_model *model, const nqm_brdf *ref, size_t n_tests, const nqm_brdf *const *tests,
                     const nqm_score_options *options, nqm_score_result *results, nqm_error *err) {
    scorer s = {.model = model,
                .directions = model->directions,
                .options = options ? *options : nqm_score_options_default(),
                .batch = n_tests < NQM_PREDICT_BATCH ? n_tests : NQM_PREDICT_BATCH};
    nqm_status status = nqm_score_options_check(&s.options, err);
    if (status != NQM_OK || n_tests == 0)
        return status;
    status = make_room(&s, err);
    if (status == NQM_OK)
        status = nqm_sample(ref, s.directions, s.options.invalid, s.ref, s.ref_flag, &s.ref_member.report, err);
    if (status == NQM_OK) {
        s.ref_member.rgb = s.ref;
        s.ref_member.flag = s.ref_flag;
        s.ref_member.n_unusual = nqm_count_unusual(model, s.ref);
    }
    for (size_t begin = 0; status == NQM_OK && begin < n_tests; begin += s.batch) {
        s.tests = tests + begin;
        s.results = results + begin;
        score_batch(&s, n_tests - begin < s.batch ? n_tests - begin : s.batch);
    }
    release(&s);
    return status;
}
