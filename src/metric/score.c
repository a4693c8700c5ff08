/* SPDX-License-Identifier: MIT
 *
 * Scores pairs. Opened BRDFs, names (paths and specs) and the caller's samples are all converted to pairs of members
 * (samples at the model's directions). A block of pairs is compared on all threads, then predicted in one forward pass.
 */
#include "brdf/brdf.h"
#include "brdf/formats/listed.h"
#include "kernel/kernel.h"
#include "math/math.h"
#include "metric/sample_cache.h"

#include <math.h>
#include <string.h>

_Static_assert((int)NQM_SCORE_BLOCK <= (int)NQM_PREDICT_BATCH, "a block is one forward pass");

/* Values more than this many standard deviations above the mean of the training references are unusual. */
static const float unusual_sigma = 6;
static const double suspicious_jod = 9;     /* below it a fault of a file is looked for */
static const size_t not_counted = SIZE_MAX; /* n_unusual of the caller's samples at first */

struct nqm_scorer {
    const nqm_model *model;
    nqm_score_options options;
    nqm_sample_cache *cache;  /* of nqm_scorer_run_named(), created by its first call */
    nqm_predictor *predictor; /* for batches of at most `room` pairs */
    nqm_model *anisotropic;   /* for anisotropic BRDFs, opened for the first; NULL: none was, or the model has none */
    nqm_gradients *gradients; /* of nqm_score_grad(), created by its first call */
    size_t gradient_room;     /* its largest batch */
    size_t room;              /* capacity of the arrays, pairs */
    nqm_member *member;       /* (room, 2) reference and test of each pair of the block; owns all arrays */
    size_t *place;            /* (room) index of each pair in the following arrays, which are grouped by reference */
    nqm_sample_pair *pairs;   /* (room) for the predictor */
    uint8_t *used;            /* (room, n_directions) of these */
    nqm_prediction *predictions; /* (room) */
    double *metrics;             /* (room, NQM_METRIC_COUNT) */
    /* Of nqm_scorer_run() only: */
    bool has_samples;             /* it was called: rgb and flag have room for samples */
    float *rgb;                   /* (1 + room, n_directions, 3) samples of the reference and the tests */
    uint8_t *flag;                /* (1 + room, n_directions) */
    const nqm_brdf *const *brdfs; /* tests of the block; NULL: the members are already sampled */
};

/* ---- options ----------------------------------------------------------------------------------------------------- */

#define FIELD(name) .key = #name, .offset = offsetof(nqm_score_options, name)

/* clang-format off */
static const nqm_option rows[] = {
    {FIELD(invalid), .kind = NQM_OPTION_ENUM, .metavar = "POLICY", .words = nqm_invalid_words, .values = {"drop"},
     .help = "for directions without a value"},
    {FIELD(min_valid_fraction), .name = "min-valid", .metavar = "F", .min = 0, .max = 1, .values = {"0.9"},
     .help = "smallest fraction of valid directions of a pair"},
    {FIELD(metrics), .name = "", .kind = NQM_OPTION_BOOL, .values = {"1"}},
    {FIELD(cache_bytes), .name = "", .kind = NQM_OPTION_SIZE, .min = 0, .max = 1e18, .values = {"67108864"}},
};
/* clang-format on */

const nqm_option_table nqm_score_option_table = {rows, sizeof rows / sizeof *rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_score_option, 0)

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* Grow the workspace for calls with n_pairs pairs. */
static nqm_status reserve(nqm_scorer *s, size_t n_pairs, bool with_samples, nqm_error *err) {
    const size_t n = nqm_larger(nqm_smaller(n_pairs, NQM_SCORE_BLOCK), s->room), n_directions = s->model->directions->n;
    if (n == s->room && (s->has_samples || !with_samples))
        return NQM_OK;
    s->has_samples = s->has_samples || with_samples;
    const size_t n_samples = s->has_samples ? 1 + n : 0;
    nqm_predictor_free(s->predictor);
    nqm_free(s->member);
    s->predictor = NULL;
    s->room = 0;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&s->member, n, 2 * sizeof *s->member}, {&s->place, n, sizeof *s->place},
                   {&s->pairs, n, sizeof *s->pairs}, {&s->used, n, n_directions},
                   {&s->predictions, n, sizeof *s->predictions},
                   {&s->metrics, n, NQM_METRIC_COUNT * sizeof *s->metrics},
                   {&s->rgb, n_samples, 3 * n_directions * sizeof *s->rgb}, {&s->flag, n_samples, n_directions}),
        err);
    if (status == NQM_OK)
        status = nqm_predictor_create(s->model, n, &s->predictor, err);
    if (status == NQM_OK)
        s->room = n;
    return status;
}

nqm_status nqm_scorer_create(const nqm_model *model, const nqm_score_options *options, nqm_scorer **scorer_ret,
                             nqm_error *err) {
    NQM_MAKE(err, scorer_ret, model);
    const nqm_score_options o = options ? *options : nqm_score_options_default();
    nqm_status status = nqm_options_check(&nqm_score_option_table, &o, err);
    if (status != NQM_OK)
        return status;
    nqm_scorer *s = nqm_alloc(1, sizeof *s);
    if (!s)
        return nqm_fail_nomem(err, sizeof *s);
    s->model = model;
    s->options = o;
    *scorer_ret = s;
    return NQM_OK;
}

void nqm_scorer_free(nqm_scorer *scorer) {
    if (!scorer)
        return;
    nqm_sample_cache_free(scorer->cache);
    nqm_predictor_free(scorer->predictor);
    nqm_gradients_free(scorer->gradients);
    nqm_model_free(scorer->anisotropic);
    nqm_free(scorer->member);
    nqm_free(scorer);
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

static size_t count_unusual(const nqm_model *model, const float *rgb) {
    float limit[3]; /* limits in reflectance: the transform is monotone, so the samples need not be transformed */
    for (size_t k = 0; k < 3; ++k) {
        float root = expm1f(model->features.mean[k] + unusual_sigma * model->features.std[k]);
        limit[k] = root * root * root;
    }
    size_t n_unusual = 0;
    for (size_t i = 0; i < model->directions->n; ++i, rgb += 3)
        n_unusual += rgb[0] > limit[0] || rgb[1] > limit[1] || rgb[2] > limit[2];
    return n_unusual;
}

nqm_member nqm_sample_member(const nqm_model *model, const nqm_brdf *brdf, nqm_invalid_policy policy, float *rgb,
                             uint8_t *flag, nqm_error *err) {
    nqm_member member = {.rgb = rgb, .flag = flag};
    const nqm_directions *d = model->directions;
    member.status = nqm_sample(brdf, d, policy, rgb, flag, &member.report, err);
    if (member.status != NQM_ERR_NOMEM && nqm_scattered_rows(brdf, NULL, NULL) &&
        nqm_scattered_distances(brdf, d->n, d->wi, d->wo, member.distance_deg, err) != NQM_OK)
        member.status = NQM_ERR_NOMEM;
    if (brdf->info.remark)
        nqm_remark_add(member.remark, sizeof member.remark, "%s", brdf->info.remark);
    if (member.status == NQM_OK)
        member.n_unusual = count_unusual(model, rgb);
    if (member.status == NQM_OK)
        member.anisotropy = nqm_brdf_anisotropy(brdf);
    return member;
}

static bool has_value(const nqm_member *member, size_t direction) {
    return !member->flag || nqm_has_value(member->flag[direction]);
}

/* Set `used` and the parts of the result that need no network: counts, equality, status. */
static nqm_score_result compare_members(const nqm_scorer *s, const nqm_member *ref, const nqm_member *test,
                                        uint8_t *used) {
    const size_t n = s->model->directions->n;
    nqm_score_result result = nqm_no_score(ref->status != NQM_OK ? ref->status : test->status);
    memcpy(result.distance_deg, ref->distance_deg, sizeof result.distance_deg);
    memcpy(result.remark[0], ref->remark, sizeof ref->remark);
    memcpy(result.remark[1], test->remark, sizeof test->remark);
    if (ref->status != NQM_OK)
        return result;
    result.n_clamped[0] = ref->report.n_clamped;
    result.n_invalid[0] = ref->report.n_invalid;
    result.n_unusual[0] = ref->n_unusual;
    result.n_clamped[1] = test->report.n_clamped;
    result.n_invalid[1] = test->report.n_invalid;
    if (test->status != NQM_OK && !test->flag)
        return result;
    bool equal = true;
    for (size_t k = 0; k < n; ++k) {
        const bool included = !test->mask || test->mask[k];
        const bool valid = included && has_value(ref, k) && has_value(test, k);
        result.n_valid += valid;
        /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): equality of bits is intended */
        equal = equal && (!valid || memcmp(ref->rgb + 3 * k, test->rgb + 3 * k, 3 * sizeof(float)) == 0);
        used[k] = valid || (included && s->options.invalid != NQM_INVALID_DROP);
    }
    if (result.status != NQM_OK)
        return result;
    if (result.n_valid == 0 || (double)result.n_valid < s->options.min_valid_fraction * (double)n) {
        result.status = NQM_ERR_INCOMPATIBLE;
        return result;
    }
    result.identical = equal;
    result.anisotropy = fmax(ref->anisotropy, test->anisotropy);
    result.n_unusual[1] = test->n_unusual;
    return result;
}

/* A block of n pairs. */
typedef struct score_job {
    nqm_scorer *scorer;
    nqm_score_result *results; /* (n) */
} score_job;

/* Compare pair i of the block. A failed pair stays in the batch without used directions; its prediction is ignored. */
static void compare(void *user, size_t i) {
    const score_job *job = user;
    nqm_scorer *s = job->scorer;
    nqm_member *ref = &s->member[2 * i], *test = &s->member[2 * i + 1];
    const size_t n = s->model->directions->n, place = s->place[i];
    uint8_t *used = s->used + n * place;
    if (s->brdfs)
        *test = nqm_sample_member(s->model, s->brdfs[i], s->options.invalid, s->rgb + 3 * n * (1 + i),
                                  s->flag + n * (1 + i), NULL);
    if (ref->n_unusual == not_counted) { /* here, by all threads */
        ref->n_unusual = count_unusual(s->model, ref->rgb);
        test->n_unusual = count_unusual(s->model, test->rgb);
    }
    job->results[i] = compare_members(s, ref, test, used);
    const bool failed = job->results[i].status != NQM_OK;
    if (failed)
        memset(used, 0, n);
    s->pairs[place] = (nqm_sample_pair){ref->rgb, failed ? ref->rgb : test->rgb, used};
}

/* ---- blocks ------------------------------------------------------------------------------------------------------ */

/* Make pairs with the same reference adjacent, so that the predictor processes the reference once. */
static void group_by_reference(nqm_scorer *s, size_t n) {
    bool is_placed[NQM_SCORE_BLOCK] = {false};
    size_t n_placed = 0;
    for (size_t first = 0; first < n; ++first) {
        if (is_placed[first])
            continue;
        for (size_t i = first; i < n; ++i)
            if (s->member[2 * i].rgb == s->member[2 * first].rgb) {
                is_placed[i] = true;
                s->place[i] = n_placed++;
            }
    }
}

static void finish_result(void *user, size_t i) {
    const score_job *job = user;
    const nqm_scorer *s = job->scorer;
    nqm_score_result *result = &job->results[i];
    const size_t place = s->place[i];
    const nqm_prediction *p = &s->predictions[place];
    if (result->status != NQM_OK)
        return;
    if (!isfinite(p->jod)) {
        *result = nqm_no_score(NQM_ERR_NUMERIC);
        return;
    }
    result->jod = p->jod;
    result->delta_e = p->delta_e;
    result->novelty = p->novelty;
    result->parts = p->label;
    if (result->identical && nqm_model_has_parts(s->model))
        result->parts = (nqm_label){.delta_e = 0};
    memcpy(result->similarity, p->similarity, sizeof result->similarity);
    if (s->options.metrics)
        memcpy(result->metrics, s->metrics + place * NQM_METRIC_COUNT, sizeof result->metrics);
    nqm_bounded_interval(s->model, p, &result->jod_low, &result->jod_high);
    if (result->identical && s->model->interval) /* equal BRDFs give equal images: the interval is exact */
        result->jod_low = result->jod_high = 10;
    if (p->jod < suspicious_jod && s->member[2 * i].flag) /* the caller's samples are no file */
        nqm_suspect(s->model->directions, s->pairs[place].ref, s->pairs[place].test, result);
}

/* Score the n pairs in s->member. */
static void score_members(nqm_scorer *s, size_t n, nqm_score_result *results) {
    score_job job = {s, results};
    group_by_reference(s, n);
    nqm_parallel_for(n, compare, &job);
    nqm_predictor_run(s->predictor, n, s->pairs, s->predictions, s->options.metrics ? s->metrics : NULL);
    nqm_parallel_for(n, finish_result, &job);
}

nqm_status nqm_scorer_anisotropic(nqm_scorer *s, const nqm_model **anisotropic_ret, nqm_error *err) {
    const bool is_open = s->model->slopes || s->anisotropic;
    const nqm_status status = is_open ? NQM_OK : nqm_anisotropic_find(s->model, &s->anisotropic, err);
    *anisotropic_ret = s->model->slopes ? s->model : s->anisotropic;
    return status;
}

/* The same; those with an anisotropic BRDF at all azimuths. */
static nqm_status score_block(nqm_scorer *s, size_t n, const nqm_opened_pairs *pairs, nqm_score_result *results,
                              nqm_error *err) {
    const nqm_model *anisotropic;
    bool is_needed = false;
    score_members(s, n, results);
    for (size_t i = 0; i < n; ++i)
        is_needed |= nqm_anisotropic_is_needed(s->model, &results[i]);
    if (!is_needed)
        return NQM_OK;
    nqm_status status = nqm_scorer_anisotropic(s, &anisotropic, err);
    return status == NQM_OK ? nqm_anisotropic_score(anisotropic, s->model, n, pairs, results, err) : status;
}

/* ---- opened BRDFs ------------------------------------------------------------------------------------------------ */

nqm_status nqm_scorer_run(nqm_scorer *scorer, const nqm_brdf *ref, size_t n_tests, const nqm_brdf *const *tests,
                          nqm_score_result *results, nqm_error *err) {
    NQM_REQUIRE(err, scorer, ref);
    NQM_REQUIRE_IF(n_tests, err, tests, results);
    if (n_tests == 0)
        return NQM_OK;
    nqm_status status = reserve(scorer, n_tests, true, err);
    if (status != NQM_OK)
        return status;
    const nqm_member member =
        nqm_sample_member(scorer->model, ref, scorer->options.invalid, scorer->rgb, scorer->flag, err);
    if (member.status != NQM_OK)
        return member.status;
    for (size_t begin = 0, n; status == NQM_OK && begin < n_tests; begin += n) {
        n = nqm_smaller(n_tests - begin, NQM_SCORE_BLOCK);
        for (size_t i = 0; i < n; ++i)
            scorer->member[2 * i] = member;
        scorer->brdfs = tests + begin;
        status = score_block(scorer, n, &(nqm_opened_pairs){.ref = ref, .tests = tests + begin}, results + begin, err);
    }
    scorer->brdfs = NULL;
    return status;
}

nqm_status nqm_score(const nqm_model *model, const nqm_brdf *ref, size_t n_tests, const nqm_brdf *const *tests,
                     const nqm_score_options *options, nqm_score_result *results, nqm_error *err) {
    NQM_REQUIRE(err, model, ref);
    nqm_scorer *scorer;
    nqm_status status = nqm_scorer_create(model, options, &scorer, err);
    if (status == NQM_OK)
        status = nqm_scorer_run(scorer, ref, n_tests, tests, results, err);
    nqm_scorer_free(scorer);
    return status;
}

/* ---- named BRDFs ------------------------------------------------------------------------------------------------- */

size_t nqm_scorer_n_opened(const nqm_scorer *scorer) {
    return scorer->cache ? nqm_sample_cache_n_opened(scorer->cache) : 0;
}

/* The error of a pair without a score; entry: (2) its reference and test. */
static nqm_error explain(const nqm_scorer *s, nqm_cached *const *entry, const nqm_score_result *result) {
    const nqm_subject *subject = &entry[1]->subject;
    const char *test = subject->name ? subject->name : subject->values->schema->model;
    nqm_error why = {.status = result->status, .byte_offset = -1};
    if (entry[0]->member.status != NQM_OK)
        return entry[0]->err;
    if (entry[1]->member.status != NQM_OK)
        return entry[1]->err;
    const double anisotropy = fmax(entry[0]->member.anisotropy, entry[1]->member.anisotropy);
    if (result->status == NQM_ERR_INCOMPATIBLE && anisotropy > 0)
        (void)nqm_fail(&why, result->status, -1,
                       "%s: it or its reference is anisotropic (turning changes it by %.2g %%), which the directions "
                       "of model '%s' do not see: use the models default or anisotropic, or one that 'nqm transport "
                       "make --anisotropic' makes for the scene",
                       test, 100 * anisotropy, s->model->id);
    else if (result->status == NQM_ERR_INCOMPATIBLE)
        (void)nqm_fail(
            &why, result->status, -1,
            "%s: it and its reference both have a value at only %zu of %zu directions (at least %.0f are needed; "
            "--min-valid, min_valid_fraction)",
            test, result->n_valid, s->model->directions->n,
            ceil(s->options.min_valid_fraction * (double)s->model->directions->n));
    else if (result->status != NQM_OK)
        (void)nqm_fail(&why, result->status, -1, "%s: %s", test, nqm_status_text(result->status));
    return why;
}

/* Find or sample n BRDFs; entry (n) receives their cache entries. */
static nqm_status look_up(nqm_scorer *s, size_t n, const nqm_subject *subjects, nqm_cached **entry, nqm_error *err) {
    nqm_status status = s->cache ? NQM_OK : nqm_sample_cache_create(s->model, s->options.invalid, &s->cache, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        entry[i] = nqm_sample_cache_get(s->cache, &subjects[i]);
        if (!entry[i])
            status = nqm_fail_nomem(err, 3 * s->model->directions->n * sizeof(float));
    }
    return status == NQM_OK ? nqm_sample_cache_fill(s->cache, n, entry, err) : status;
}

nqm_status nqm_scorer_draw(nqm_scorer *s, size_t n, const nqm_subject *subjects, nqm_gallery *gallery, size_t first,
                           nqm_error *errors, nqm_error *err) {
    nqm_cached *entry[2 * NQM_SCORE_BLOCK];
    const float *samples[2 * NQM_SCORE_BLOCK];
    nqm_status status = look_up(s, n, subjects, entry, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n; ++i) {
        samples[i] = entry[i]->rgb;
        errors[i] = entry[i]->err;
    }
    nqm_gallery_draw(gallery, first, n, samples);
    nqm_sample_cache_trim(s->cache, s->options.cache_bytes);
    return NQM_OK;
}

nqm_status nqm_scorer_run_subjects(nqm_scorer *scorer, size_t n, const nqm_subject *subjects, nqm_score_result *results,
                                   nqm_error *errors, nqm_error *err) {
    nqm_cached *entry[2 * NQM_SCORE_BLOCK];
    nqm_status status = n ? reserve(scorer, n, false, err) : NQM_OK;
    if (status == NQM_OK)
        status = look_up(scorer, 2 * n, subjects, entry, err);
    for (size_t i = 0; status == NQM_OK && i < 2 * n; ++i)
        scorer->member[i] = entry[i]->member;
    if (status == NQM_OK)
        status = score_block(scorer, n, &(nqm_opened_pairs){.subjects = subjects}, results, err);
    for (size_t i = 0; status == NQM_OK && errors && i < n; ++i)
        errors[i] = explain(scorer, entry + 2 * i, &results[i]);
    if (scorer->cache)
        nqm_sample_cache_trim(scorer->cache, scorer->options.cache_bytes);
    return status;
}

nqm_status nqm_scorer_run_named(nqm_scorer *scorer, size_t n_pairs, const nqm_named_pair *pairs,
                                nqm_score_result *results, nqm_error *errors, nqm_error *err) {
    NQM_REQUIRE(err, scorer);
    NQM_REQUIRE_IF(n_pairs, err, pairs, results);
    nqm_subject subjects[2 * NQM_SCORE_BLOCK];
    nqm_status status = NQM_OK;
    for (size_t begin = 0, n; status == NQM_OK && begin < n_pairs; begin += n) {
        n = nqm_smaller(n_pairs - begin, NQM_SCORE_BLOCK);
        for (size_t i = 0; i < 2 * n; ++i)
            subjects[i] = (nqm_subject){.name = i % 2 ? pairs[begin + i / 2].test : pairs[begin + i / 2].ref};
        status = nqm_scorer_run_subjects(scorer, n, subjects, results + begin, errors ? errors + begin : NULL, err);
    }
    return status;
}

/* ---- samples of the caller --------------------------------------------------------------------------------------- */

static nqm_status check_samples(const nqm_model *model, size_t pair, const char *member, const float *rgb,
                                nqm_error *err) {
    const size_t n = 3 * model->directions->n, i = nqm_first_outside(n, rgb, 0);
    if (i == n)
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_ARG, -1,
                    "pair %zu: the %s is %g at direction %zu (from 0): samples must be finite and not negative", pair,
                    member, (double)rgb[i], i / 3);
}

static nqm_status check_pairs(const nqm_model *model, size_t n, const nqm_sample_pair *pairs, nqm_error *err) {
    nqm_status status = NQM_OK;
    if (model->slopes)
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "model '%s' evaluates BRDFs at directions of its own: it has no score of samples", model->id);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        if (i == 0 || pairs[i].ref != pairs[i - 1].ref)
            status = check_samples(model, i, "reference", pairs[i].ref, err);
        if (status == NQM_OK)
            status = check_samples(model, i, "test", pairs[i].test, err);
    }
    return status;
}

nqm_status nqm_scorer_run_samples(nqm_scorer *scorer, size_t n_pairs, const nqm_sample_pair *pairs,
                                  nqm_score_result *results, nqm_error *err) {
    NQM_REQUIRE(err, scorer);
    NQM_REQUIRE_IF(n_pairs, err, pairs, results);
    nqm_status status = n_pairs ? reserve(scorer, n_pairs, false, err) : NQM_OK;
    if (status == NQM_OK)
        status = check_pairs(scorer->model, n_pairs, pairs, err);
    for (size_t begin = 0, n; status == NQM_OK && begin < n_pairs; begin += n) {
        n = nqm_smaller(n_pairs - begin, NQM_SCORE_BLOCK);
        for (size_t i = 0; i < n; ++i) {
            const nqm_sample_pair *p = &pairs[begin + i];
            scorer->member[2 * i] = (nqm_member){.rgb = p->ref, .n_unusual = not_counted};
            scorer->member[2 * i + 1] = (nqm_member){.rgb = p->test, .mask = p->used, .n_unusual = not_counted};
        }
        score_members(scorer, n, results + begin);
    }
    return status;
}

/* ---- gradients --------------------------------------------------------------------------------------------------- */

static nqm_status check_used(const nqm_scorer *s, size_t n, const nqm_sample_pair *pairs, nqm_error *err) {
    const size_t n_directions = s->model->directions->n;
    for (size_t i = 0; i < n; ++i) {
        size_t n_used = 0;
        for (size_t k = 0; k < n_directions; ++k)
            n_used += !pairs[i].used || pairs[i].used[k];
        if (n_used == 0 || (double)n_used < s->options.min_valid_fraction * (double)n_directions)
            return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                            "pair %zu: %zu of %zu directions are used, at least %.0f needed", i, n_used, n_directions,
                            ceil(s->options.min_valid_fraction * (double)n_directions));
    }
    return NQM_OK;
}

static nqm_status reserve_gradients(nqm_scorer *s, size_t n_pairs, nqm_error *err) {
    const size_t n = nqm_smaller(n_pairs, NQM_SCORE_BLOCK);
    if (n <= s->gradient_room)
        return NQM_OK;
    nqm_gradients_free(s->gradients);
    s->gradient_room = 0;
    nqm_status status = nqm_gradients_create(s->model, n, &s->gradients, err);
    s->gradient_room = status == NQM_OK ? n : 0;
    return status;
}

nqm_status nqm_score_grad(nqm_scorer *scorer, nqm_score_quantity of, size_t n_pairs, const nqm_sample_pair *pairs,
                          double *values, float *gradients, nqm_error *err) {
    NQM_REQUIRE(err, scorer);
    NQM_REQUIRE_IF(n_pairs, err, pairs, values, gradients);
    if (of == NQM_SCORE_DELTA_E && scorer->model->target != NQM_TARGET_LOG_DELTA_E)
        return nqm_fail(err, NQM_ERR_ARG, -1, "model '%s' predicts no Delta-E", scorer->model->id);
    nqm_status status = reserve_gradients(scorer, n_pairs, err);
    if (status == NQM_OK)
        status = check_pairs(scorer->model, n_pairs, pairs, err);
    if (status == NQM_OK)
        status = check_used(scorer, n_pairs, pairs, err);
    for (size_t begin = 0, n; status == NQM_OK && begin < n_pairs; begin += n) {
        n = nqm_smaller(n_pairs - begin, NQM_SCORE_BLOCK);
        nqm_gradients_run(scorer->gradients, of, n, pairs + begin, values + begin,
                          gradients + 3 * scorer->model->directions->n * begin);
    }
    return status;
}

/* ---- preference -------------------------------------------------------------------------------------------------- */

double nqm_jod_preference(double jod, double other_jod) {
    const double z75 = 0.6744897501960817; /* Phi(z75) = 0.75 */
    return 0.5 * erfc(-z75 * (jod - other_jod) / sqrt(2));
}
