/* SPDX-License-Identifier: MIT
 *
 * Repeated use of a scorer: the same bits as nqm_score() for any batch, number of threads and kernels; no allocation
 * after the first run; samples from the caller; a new model used by several threads at once.
 */
#include "base/memory_test.h"
#include "kernel/kernel.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/tiny_model.h"

#include <nqm/metric.h>
#include <omp.h>
#include <pthread.h>

enum { N_DIRECTIONS = 30, N_TESTS = 40 };

static nqm_model *model;
static nqm_brdf *refs[2], *tests[N_TESTS];
static nqm_score_result expected[2][N_TESTS]; /* results of scoring each test alone */

static nqm_score_result score_alone(const nqm_brdf *ref, const nqm_brdf *test) {
    nqm_score_result result;
    assert_int_equal(nqm_score(model, ref, 1, &test, NULL, &result, NULL), NQM_OK);
    return result;
}

static int setup(void **state) {
    (void)state;
    if (make_tiny_model(N_DIRECTIONS, &model, NULL) != NQM_OK)
        return 1;
    refs[0] = must_open("ggx:kd=.2,.1,.05;alpha=.1");
    refs[1] = must_open("ward:kd=.05;ks=.4;alpha=.05");
    for (size_t i = 0; i < N_TESTS; ++i) {
        char spec[80];
        snprintf(spec, sizeof spec, "ggx:kd=.2,.1,.0%zu;alpha=.%zu", i % 9 + 1, 10 + i);
        tests[i] = must_open(spec);
    }
    for (size_t r = 0; r < 2; ++r)
        for (size_t i = 0; i < N_TESTS; ++i)
            expected[r][i] = score_alone(refs[r], tests[i]);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    for (size_t i = 0; i < N_TESTS; ++i)
        nqm_brdf_free(tests[i]);
    nqm_brdf_free(refs[0]);
    nqm_brdf_free(refs[1]);
    nqm_model_free(model);
    return 0;
}

static nqm_scorer *make_scorer(void) {
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, NULL), NQM_OK);
    return scorer;
}

static void run(nqm_scorer *scorer, size_t r, size_t first, size_t n, nqm_score_result *results) {
    assert_int_equal(nqm_scorer_run(scorer, refs[r], n, (const nqm_brdf *const *)tests + first, results, NULL), NQM_OK);
}

static void check_same(const nqm_score_result *actual, const nqm_score_result *wanted, size_t n) {
    for (size_t i = 0; i < n; ++i) {
        assert_int_equal(actual[i].status, NQM_OK);
        assert_memory_equal(&actual[i].jod, &wanted[i].jod, sizeof actual[i].jod);
        assert_memory_equal(&actual[i].delta_e, &wanted[i].delta_e, sizeof actual[i].delta_e);
        assert_memory_equal(actual[i].metrics, wanted[i].metrics, sizeof actual[i].metrics);
    }
}

/* Whether these kernels give the same bits: all with fused multiply-add do. */
static bool same_bits(const nqm_kernels *a, const nqm_kernels *b) {
    const nqm_kernels *const others[] = {&nqm_kernels_scalar, &nqm_kernels_generic};
    for (size_t i = 0; i < 2; ++i)
        if (a == others[i] || b == others[i])
            return a == b;
    return true;
}

TEST(the_same_bits) {
    static const size_t batches[] = {1, 2, 13, N_TESTS};
    const int threads = omp_get_max_threads();
    const nqm_kernels *chosen = nqm_kernels_get();
    nqm_score_result results[N_TESTS];
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        if (!same_bits(nqm_kernels_at(t), chosen))
            continue;
        nqm_kernels_use(nqm_kernels_at(t));
        for (size_t b = 0; b < sizeof batches / sizeof *batches; ++b) {
            omp_set_num_threads((int)(b + t) % 3 + 1);
            nqm_scorer *scorer = make_scorer();
            for (size_t r = 0; r < 4; ++r) { /* alternate the references, then repeat the last */
                for (size_t first = 0; first < N_TESTS; first += batches[b])
                    run(scorer, r % 2, first, nqm_smaller(batches[b], N_TESTS - first), results + first);
                check_same(results, expected[r % 2], N_TESTS);
            }
            run(scorer, 1, 3, 5, results);
            check_same(results, expected[1] + 3, 5);
            nqm_scorer_free(scorer);
        }
        omp_set_num_threads(threads);
    }
    use_chosen_kernels();
}

TEST(nothing_is_allocated) {
    nqm_score_result results[N_TESTS];
    nqm_scorer *scorer = make_scorer();
    run(scorer, 1, 0, N_TESTS, results);
    const long before = nqm_alloc_count();
    run(scorer, 0, 0, N_TESTS, results);
    run(scorer, 1, 0, 1, results);
    assert_int_equal(nqm_alloc_count() - before, 0);
    nqm_scorer_free(scorer);
    assert_true(before > 0);
}

static void sample(const nqm_brdf *brdf, float rgb[3 * N_DIRECTIONS]) {
    assert_int_equal(nqm_sample(brdf, nqm_model_get_info(model).directions, NQM_INVALID_ERROR, rgb, NULL, NULL, NULL),
                     NQM_OK);
}

/* Samples from the caller give the same complete result as the BRDF, for both references, in any order. */
TEST(samples_of_the_caller) {
    static float ref[2][3 * N_DIRECTIONS], test[N_TESTS][3 * N_DIRECTIONS];
    nqm_sample_pair pairs[2 * N_TESTS];
    nqm_score_result results[2 * N_TESTS];
    nqm_scorer *scorer = make_scorer();
    sample(refs[0], ref[0]);
    sample(refs[1], ref[1]);
    for (size_t i = 0; i < 2 * N_TESTS; ++i) {
        sample(tests[i / 2], test[i / 2]);
        pairs[i] = (nqm_sample_pair){.ref = ref[i % 2], .test = test[i / 2]};
    }
    assert_int_equal(nqm_scorer_run_samples(scorer, 2 * N_TESTS, pairs, results, NULL), NQM_OK);
    for (size_t i = 0; i < 2 * N_TESTS; ++i) {
        const nqm_score_result *wanted = &expected[i % 2][i / 2];
        check_same(&results[i], wanted, 1);
        assert_int_equal(results[i].n_valid, N_DIRECTIONS);
        assert_int_equal(results[i].n_unusual[1], wanted->n_unusual[1]);
        assert_int_equal(results[i].identical, 0);
    }
    uint8_t used[N_DIRECTIONS];
    memset(used, 1, sizeof used);
    used[7] = 0;
    memcpy(test[0], ref[0], sizeof ref[0]);
    test[0][3 * 7] += 1; /* at an unused direction */
    pairs[0].used = used;
    assert_int_equal(nqm_scorer_run_samples(scorer, 1, pairs, results, NULL), NQM_OK);
    assert_int_equal(results[0].identical, 1);
    assert_int_equal(results[0].n_valid, N_DIRECTIONS - 1);
    memset(used, 0, N_DIRECTIONS / 2);
    assert_int_equal(nqm_scorer_run_samples(scorer, 1, pairs, results, NULL), NQM_OK);
    assert_int_equal(results[0].status, NQM_ERR_INCOMPATIBLE);
    assert_true(isnan(results[0].jod));
    nqm_scorer_free(scorer);
}

TEST(impossible_samples) {
    static const float bad[] = {NAN, INFINITY, -1e-6f};
    float ref[3 * N_DIRECTIONS], test[3 * N_DIRECTIONS];
    nqm_scorer *scorer = make_scorer();
    sample(refs[0], ref);
    sample(tests[0], test);
    const nqm_sample_pair pairs[] = {{ref, ref, NULL}, {ref, test, NULL}};
    for (size_t k = 0; k < 2; ++k)
        for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
            float *place = k ? &test[3 * 4 + 1] : &ref[3 * 4 + 1];
            const float before = *place;
            nqm_error err = {0};
            nqm_score_result results[2] = {{.jod = 3}, {.jod = 3}};
            *place = bad[i];
            assert_int_equal(nqm_scorer_run_samples(scorer, 2, pairs, results, &err), NQM_ERR_ARG);
            assert_non_null(strstr(err.message, k ? "pair 1: the test" : "pair 0: the reference"));
            assert_non_null(strstr(err.message, "direction 4"));
            assert_true(results[0].jod == 3);
            *place = before;
        }
    nqm_scorer_free(scorer);
}

typedef struct beginner {
    const nqm_model *model;
    double jod;
} beginner;

static void *score_once(void *user) {
    beginner *b = user;
    nqm_score_result result;
    const nqm_brdf *test = tests[3];
    b->jod = nqm_score(b->model, refs[0], 1, &test, NULL, &result, NULL) == NQM_OK ? result.jod : (double)NAN;
    return NULL;
}

TEST(a_fresh_model_in_many_threads) {
    enum { N_THREADS = 8 };
    nqm_model *fresh;
    assert_int_equal(make_tiny_model(N_DIRECTIONS, &fresh, NULL), NQM_OK);
    pthread_t thread[N_THREADS];
    beginner beginners[N_THREADS];
    for (size_t i = 0; i < N_THREADS; ++i) {
        beginners[i] = (beginner){.model = fresh};
        assert_int_equal(pthread_create(&thread[i], NULL, score_once, &beginners[i]), 0);
    }
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_int_equal(pthread_join(thread[i], NULL), 0);
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_true(beginners[i].jod == expected[0][3].jod);
    nqm_model_free(fresh);
}

TEST_FILE(setup, teardown)
