/* SPDX-License-Identifier: MIT
 *
 * Scores of pairs that are named: each block of pairs is looked up in the cache of samples, the missing BRDFs are
 * sampled, pairs are compared, and one forward pass predicts the block.
 */
#include "metric/sample_cache.h"

#include <math.h>
#include <nqm/metric.h>
#include <string.h>

_Static_assert((int)NQM_BATCH_BLOCK <= (int)NQM_PREDICT_BATCH, "a block is one forward pass");

struct nqm_batch {
    const nqm_model *model;
    nqm_batch_options options;
    nqm_sample_cache *cache;
    nqm_predictor *predictor;
    float *nothing;              /* (n_directions, 3) zeros: what the network sees of a pair that has a fault */
    size_t *order, *place;       /* (NQM_BATCH_BLOCK) pairs reference by reference; where each pair stands there */
    const float **refs, **tests; /* (NQM_BATCH_BLOCK) in that order, as the next five */
    uint8_t *used;               /* (NQM_BATCH_BLOCK, n_directions) */
    double *jod, *delta_e;       /* (NQM_BATCH_BLOCK) */
    double *novelty;             /* (NQM_BATCH_BLOCK) */
    double *metrics;             /* (NQM_BATCH_BLOCK, NQM_METRIC_COUNT) */
    nqm_cached **entries;        /* (NQM_BATCH_BLOCK, 2) of this block: reference, test */
    const nqm_named_pair *pairs; /* of this block, as the next two */
    nqm_score_result *results;
    nqm_error *errors; /* or NULL */
};

nqm_batch_options nqm_batch_options_default(void) {
    return (nqm_batch_options){.score = nqm_score_options_default(), .metrics = 1, .cache_bytes = (size_t)64 << 20};
}

static nqm_status make_room(nqm_batch *batch, nqm_error *err) {
    size_t n = batch->model->n_directions;
    batch->nothing = nqm_alloc(n, 3 * sizeof *batch->nothing);
    batch->order = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->order);
    batch->place = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->place);
    batch->refs = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->refs);
    batch->tests = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->tests);
    batch->used = nqm_alloc(NQM_BATCH_BLOCK, n * sizeof *batch->used);
    batch->jod = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->jod);
    batch->delta_e = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->delta_e);
    batch->novelty = nqm_alloc(NQM_BATCH_BLOCK, sizeof *batch->novelty);
    batch->metrics = nqm_alloc(NQM_BATCH_BLOCK, NQM_METRIC_COUNT * sizeof *batch->metrics);
    batch->entries = nqm_alloc(NQM_BATCH_BLOCK, 2 * sizeof(nqm_cached *));
    if (!batch->nothing || !batch->order || !batch->place || !batch->refs || !batch->tests || !batch->used ||
        !batch->jod || !batch->delta_e || !batch->novelty || !batch->metrics || !batch->entries)
        return nqm_fail_nomem(err, NQM_BATCH_BLOCK * n);
    nqm_status status =
        nqm_predictor_create(batch->model, batch->options.score.precision, NQM_BATCH_BLOCK, &batch->predictor, err);
    if (status == NQM_OK)
        status = nqm_sample_cache_create(batch->model, batch->options.score.invalid, &batch->cache, err);
    return status;
}

nqm_status nqm_batch_create(const nqm_model *model, const nqm_batch_options *options, nqm_batch **batch_ret,
                            nqm_error *err) {
    *batch_ret = NULL;
    nqm_batch *batch = nqm_alloc(1, sizeof *batch);
    if (!batch)
        return nqm_fail_nomem(err, sizeof *batch);
    batch->model = model;
    batch->options = options ? *options : nqm_batch_options_default();
    nqm_status status = nqm_score_options_check(&batch->options.score, err);
    if (status == NQM_OK)
        status = make_room(batch, err);
    if (status != NQM_OK) {
        nqm_batch_free(batch);
        return status;
    }
    *batch_ret = batch;
    return NQM_OK;
}

void nqm_batch_free(nqm_batch *batch) {
    if (!batch)
        return;
    void *blocks[] = {batch->nothing, batch->order,   batch->place,   batch->refs,    batch->tests,  batch->used,
                      batch->jod,     batch->delta_e, batch->novelty, batch->metrics, batch->entries};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
    nqm_predictor_free(batch->predictor);
    nqm_sample_cache_free(batch->cache);
    nqm_free(batch);
}

size_t nqm_batch_n_opened(const nqm_batch *batch) {
    return nqm_sample_cache_n_opened(batch->cache);
}

/* Pairs of one reference side by side: the predictor then computes once what the reference makes it compute. */
static void group_by_reference(nqm_batch *batch, size_t n) {
    bool done[NQM_BATCH_BLOCK] = {false};
    size_t n_done = 0;
    for (size_t first = 0; first < n; ++first) {
        const bool fresh = !done[first];
        for (size_t i = first; fresh && i < n; ++i)
            if (batch->entries[2 * i] == batch->entries[2 * first]) {
                done[i] = true;
                batch->place[i] = n_done;
                batch->order[n_done++] = i;
            }
    }
}

/* Compare pair i of the block, and lay out its samples for the network. */
static void compare(void *user, size_t i) {
    nqm_batch *batch = user;
    const nqm_cached *ref = batch->entries[2 * i], *test = batch->entries[2 * i + 1];
    const size_t n = batch->model->n_directions, place = batch->place[i];
    nqm_score_result *result = &batch->results[i];
    uint8_t *used = batch->used + n * place;
    if (ref->member.status == NQM_OK && test->member.status == NQM_OK)
        nqm_compare_members(batch->model, &batch->options.score, &ref->member, &test->member, used, result);
    else
        *result = nqm_no_score(ref->member.status != NQM_OK ? ref->member.status : test->member.status);
    const bool fault = result->status != NQM_OK;
    if (fault)
        memset(used, 0, n);
    batch->refs[place] = fault ? batch->nothing : ref->rgb;
    batch->tests[place] = fault ? batch->nothing : test->rgb;
}

/* Why pair i of the block has no score. */
static void explain(const nqm_batch *batch, size_t i, nqm_error *why) {
    const nqm_cached *ref = batch->entries[2 * i], *test = batch->entries[2 * i + 1];
    const nqm_score_result *result = &batch->results[i];
    size_t n = batch->model->n_directions;
    *why = (nqm_error){.status = result->status, .byte_offset = -1};
    if (ref->member.status != NQM_OK)
        *why = ref->err;
    else if (test->member.status != NQM_OK)
        *why = test->err;
    else if (result->status == NQM_ERR_INCOMPATIBLE)
        (void)nqm_fail(why, result->status, -1,
                       "%s: only at %zu of %zu directions have it and its reference a value (at least %.0f must)",
                       batch->pairs[i].test, result->n_valid, n,
                       ceil(batch->options.score.min_valid_fraction * (double)n));
    else if (result->status != NQM_OK)
        (void)nqm_fail(why, result->status, -1, "%s: %s", batch->pairs[i].test, nqm_status_text(result->status));
}

static nqm_status look_up(nqm_batch *batch, size_t n, nqm_error *err) {
    for (size_t i = 0; i < n; ++i) {
        batch->entries[2 * i] = nqm_sample_cache_get(batch->cache, batch->pairs[i].ref);
        batch->entries[2 * i + 1] = nqm_sample_cache_get(batch->cache, batch->pairs[i].test);
        if (!batch->entries[2 * i] || !batch->entries[2 * i + 1])
            return nqm_fail_nomem(err, 3 * batch->model->n_directions * sizeof(float));
    }
    return nqm_sample_cache_fill(batch->cache, 2 * n, batch->entries, err);
}

static void score_block(nqm_batch *batch, size_t n) {
    group_by_reference(batch, n);
    if (n == 1)
        compare(batch, 0);
    else
        nqm_parallel_for(n, compare, batch);
    double *metrics = batch->options.metrics ? batch->metrics : NULL;
    const nqm_sampled_pairs sampled = {.n = n,
                                       .ref = batch->refs,
                                       .test = batch->tests,
                                       .used = batch->used,
                                       .metrics = metrics,
                                       .novelty = batch->novelty};
    nqm_predictor_run(batch->predictor, &sampled, batch->jod, batch->delta_e);
    for (size_t k = 0; k < n; ++k) {
        const size_t i = batch->order[k];
        nqm_score_settle(batch->model, &batch->results[i], batch->jod[k], batch->delta_e[k], batch->novelty[k],
                         metrics ? metrics + k * NQM_METRIC_COUNT : NULL);
        if (batch->errors)
            explain(batch, i, &batch->errors[i]);
    }
}

nqm_status nqm_batch_score(nqm_batch *batch, size_t n_pairs, const nqm_named_pair *pairs, nqm_score_result *results,
                           nqm_error *errors, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t begin = 0; status == NQM_OK && begin < n_pairs; begin += NQM_BATCH_BLOCK) {
        size_t n = n_pairs - begin < NQM_BATCH_BLOCK ? n_pairs - begin : NQM_BATCH_BLOCK;
        batch->pairs = pairs + begin;
        batch->results = results + begin;
        batch->errors = errors ? errors + begin : NULL;
        status = look_up(batch, n, err);
        if (status == NQM_OK)
            score_block(batch, n);
        nqm_sample_cache_trim(batch->cache, batch->options.cache_bytes);
    }
    return status;
}
