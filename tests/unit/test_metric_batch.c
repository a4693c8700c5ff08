/* SPDX-License-Identifier: MIT
 *
 * Named pairs: the same scores as nqm_score(), the same bits whatever was scored before and whichever pairs fail, the
 * number of times that BRDFs are opened, errors of single pairs, lack of memory; and JOD as preferences.
 */
#include "base/memory_test.h"
#include "metric/metric.h"
#include "metric/sample_cache.h"
#include "support/check.h"
#include "support/tiny_model.h"

enum { N_DIRECTIONS = 20, MANY = 2 * NQM_SCORE_BLOCK + 37 };

static nqm_model *model;

static int setup(void **state) {
    (void)state;
    return make_tiny_model(N_DIRECTIONS, &model, NULL) == NQM_OK ? 0 : 1;
}

static int teardown(void **state) {
    (void)state;
    nqm_model_free(model);
    return 0;
}

static const char *const names[] = {"ggx:kd=.2,.1,.05;alpha=.1", "ggx:kd=.2,.1,.05;alpha=.2", "lambert:kd=.5",
                                    "ward:kd=.05;ks=.4;alpha=.05", "perturb:tint=1.2,1,1;of=lambert:kd=.5"};
enum { N_NAMES = sizeof names / sizeof *names };

/* The list mixes references, repeats names and contains pairs of equal BRDFs. */
static nqm_named_pair pair_at(size_t i) {
    return (nqm_named_pair){names[i / 7 % N_NAMES], names[i % N_NAMES]};
}

static nqm_scorer *make_scorer(size_t cache_bytes) {
    nqm_score_options options = nqm_score_options_default();
    options.cache_bytes = cache_bytes;
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(model, &options, &scorer, NULL), NQM_OK);
    return scorer;
}

/* The results (MANY) of the list; free with nqm_free(). */
static nqm_score_result *score_many(nqm_scorer *scorer, const nqm_named_pair *pairs) {
    nqm_score_result *results = nqm_alloc(MANY, sizeof *results);
    assert_non_null(results);
    assert_int_equal(nqm_scorer_run_named(scorer, MANY, pairs, results, NULL, NULL), NQM_OK);
    return results;
}

TEST(test_like_nqm_score) {
    nqm_named_pair pairs[MANY];
    for (size_t i = 0; i < MANY; ++i)
        pairs[i] = pair_at(i);
    nqm_scorer *scorer = make_scorer(1 << 20);
    nqm_score_result *results = score_many(scorer, pairs);
    assert_int_equal(nqm_scorer_n_opened(scorer), N_NAMES);
    for (size_t i = 0; i < N_NAMES * 7; ++i) {
        nqm_brdf *ref = must_open(pairs[i].ref), *test = must_open(pairs[i].test);
        const nqm_brdf *tests[] = {test};
        nqm_score_result alone;
        assert_int_equal(nqm_score(model, ref, 1, tests, NULL, &alone, NULL), NQM_OK);
        assert_int_equal(results[i].status, NQM_OK);
        assert_true(results[i].jod == alone.jod);
        assert_true(results[i].delta_e == alone.delta_e);
        assert_int_equal(results[i].identical, strcmp(pairs[i].ref, pairs[i].test) == 0);
        assert_int_equal(results[i].n_valid, alone.n_valid);
        assert_memory_equal(results[i].metrics, alone.metrics, sizeof alone.metrics);
        nqm_brdf_free(ref);
        nqm_brdf_free(test);
    }
    nqm_free(results);
    nqm_scorer_free(scorer);
}

static bool same_bits(const nqm_score_result *a, const nqm_score_result *b) {
    return memcmp(&a->jod, &b->jod, sizeof a->jod) == 0 && memcmp(&a->delta_e, &b->delta_e, sizeof a->delta_e) == 0 &&
           memcmp(a->metrics, b->metrics, sizeof a->metrics) == 0 && a->identical == b->identical;
}

/* Resuming depends on this: a block gives the same bits alone, without a cache, and together with pairs that fail. */
TEST(test_same_bits) {
    nqm_named_pair pairs[MANY];
    for (size_t i = 0; i < MANY; ++i)
        pairs[i] = pair_at(i);
    nqm_scorer *kept = make_scorer(1 << 20), *forgetful = make_scorer(0);
    nqm_score_result *whole = score_many(kept, pairs), *again = score_many(kept, pairs);
    nqm_score_result *fresh = score_many(forgetful, pairs);
    assert_int_equal(nqm_scorer_n_opened(kept), N_NAMES);
    assert_int_equal(nqm_scorer_n_opened(forgetful), 3 * N_NAMES); /* once per block */
    pairs[NQM_SCORE_BLOCK + 3].test = "lambert:nonsense=1";
    pairs[NQM_SCORE_BLOCK + 9].ref = "nowhere.binary";
    nqm_score_result *beside = score_many(kept, pairs);
    nqm_score_result last[37];
    assert_int_equal(nqm_scorer_run_named(kept, 37, pairs + MANY - 37, last, NULL, NULL), NQM_OK);
    for (size_t i = 0; i < MANY; ++i) {
        bool faulty = i == NQM_SCORE_BLOCK + 3 || i == NQM_SCORE_BLOCK + 9;
        assert_true(same_bits(&whole[i], &again[i]));
        assert_true(same_bits(&whole[i], &fresh[i]));
        assert_int_equal(same_bits(&whole[i], &beside[i]), !faulty);
        assert_true(i < MANY - 37 || same_bits(&whole[i], &last[i - (MANY - 37)]));
    }
    nqm_score_result *all[] = {whole, again, fresh, beside};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        nqm_free(all[i]);
    nqm_scorer_free(kept);
    nqm_scorer_free(forgetful);
}

/* Room for two BRDFs: the one that was used last but two is opened again. */
TEST(test_size_of_the_cache) {
    const size_t entry = sizeof(nqm_cached) + 13 * nqm_directions_get_info(nqm_model_get_info(model).directions).n;
    static const size_t steps[][3] = {{0, 1, 2}, {2, 2, 3}, {2, 1, 3}, {0, 0, 4}, {1, 1, 4}, {2, 2, 5}};
    nqm_scorer *scorer = make_scorer(2 * entry + entry / 2);
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i) {
        const nqm_named_pair pair = {names[steps[i][0]], names[steps[i][1]]};
        nqm_score_result result;
        assert_int_equal(nqm_scorer_run_named(scorer, 1, &pair, &result, NULL, NULL), NQM_OK);
        assert_int_equal(nqm_scorer_n_opened(scorer), steps[i][2]);
    }
    nqm_scorer_free(scorer);
}

TEST(test_faults) {
    const nqm_named_pair pairs[] = {{names[0], names[1]},
                                    {"nowhere.binary", names[1]},
                                    {names[0], "lambert:nonsense=1"},
                                    {"nowhere.binary", "lambert:nonsense=1"}};
    nqm_score_result results[4];
    nqm_error errors[4], err = {0};
    nqm_scorer *scorer = make_scorer(1 << 20);
    assert_int_equal(nqm_scorer_run_named(scorer, 4, pairs, results, errors, NULL), NQM_OK);
    const nqm_status expected[] = {NQM_OK, NQM_ERR_IO, NQM_ERR_ARG, NQM_ERR_IO};
    for (size_t i = 0; i < 4; ++i) {
        assert_int_equal(results[i].status, expected[i]);
        assert_int_equal(errors[i].status, expected[i]);
        assert_int_equal(isnan(results[i].jod) != 0, expected[i] != NQM_OK);
    }
    assert_non_null(strstr(errors[1].message, "nowhere.binary"));
    assert_non_null(strstr(errors[2].message, "nonsense"));
    assert_int_equal(nqm_scorer_n_opened(scorer), 4);
    assert_int_equal(nqm_scorer_run_named(scorer, 0, NULL, NULL, NULL, NULL), NQM_OK);
    nqm_scorer_free(scorer);
    nqm_score_options options = nqm_score_options_default();
    options.min_valid_fraction = -1;
    assert_int_equal(nqm_scorer_create(model, &options, &scorer, &err), NQM_ERR_ARG);
    assert_null(scorer);
}

TEST(test_without_metrics) {
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(model, &options, &scorer, NULL), NQM_OK);
    const nqm_named_pair pair = {names[0], names[1]};
    nqm_score_result result;
    assert_int_equal(nqm_scorer_run_named(scorer, 1, &pair, &result, NULL, NULL), NQM_OK);
    assert_int_equal(result.status, NQM_OK);
    assert_true(isfinite(result.jod));
    assert_true(isnan(result.metrics[NQM_METRIC_RMSE]));
    nqm_scorer_free(scorer);
}

TEST(test_out_of_memory) {
    const nqm_named_pair pairs[] = {{names[0], names[1]}, {names[2], names[1]}};
    bool scored = false;
    for (long n = 0; !scored; ++n) {
        nqm_scorer *scorer = NULL;
        nqm_score_result results[2];
        nqm_alloc_fail_after(n);
        nqm_status status = nqm_scorer_create(model, NULL, &scorer, NULL);
        if (status == NQM_OK)
            status = nqm_scorer_run_named(scorer, 2, pairs, results, NULL, NULL);
        nqm_alloc_fail_after(-1);
        scored = status == NQM_OK && results[0].status == NQM_OK && results[1].status == NQM_OK;
        assert_true(status == NQM_OK || status == NQM_ERR_NOMEM);
        if (scorer) { /* pairs that failed for lack of memory are retried */
            assert_int_equal(nqm_scorer_run_named(scorer, 2, pairs, results, NULL, NULL), NQM_OK);
            assert_int_equal(results[0].status, NQM_OK);
            assert_int_equal(results[1].status, NQM_OK);
        }
        nqm_scorer_free(scorer);
        assert_true(n < 100);
    }
}

TEST(test_preference) {
    assert_near(nqm_jod_preference(7, 7), 0.5, 0);
    assert_near(nqm_jod_preference(9, 8), 0.75, 1e-15);
    assert_near(nqm_jod_preference(8, 9), 0.25, 1e-15);
    assert_near(nqm_jod_preference(10, 8), 0.911328224673824, 1e-14); /* scipy.stats.norm.cdf(2 norm.ppf(.75)) */
    assert_near(nqm_jod_preference(10, -50), 1, 1e-15);
}

TEST_FILE(setup, teardown)
