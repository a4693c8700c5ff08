/* SPDX-License-Identifier: MIT
 *
 * BRDFs made by the caller: callbacks give the same bits and scores as specs, tables in memory survive saving, the
 * thread rule, ownership, invalid arguments and failing allocations.
 */
#include "base/memory_test.h"
#include "brdf/brdf.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/tiny_model.h"

#include <nqm/metric.h>
#include <pthread.h>
#include <stdatomic.h>

enum { H = 9, D = 7, P = 6, N = H * D * P };

/* Evaluate the BRDF `user` through the public interface. */
static void eval_of_brdf(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    nqm_brdf_eval(user, n, wi, wo, rgb, NULL);
}

static void eval_lambert(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    const double *kd = user;
    (void)wi, (void)wo;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = kd[i % 3] / 3.14159265358979323846;
}

static nqm_brdf *create(const nqm_brdf_callbacks *callbacks) {
    nqm_brdf *brdf;
    nqm_error err = {0};
    if (nqm_brdf_create(callbacks, &brdf, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return brdf;
}

static void same_score(nqm_brdf *by_spec, nqm_brdf *by_callback) {
    nqm_model *model;
    nqm_brdf *test = must_open("ggx:kd=.3;ks=.5;alpha=.2;f0=.04");
    nqm_score_result expected, result;
    assert_int_equal(make_tiny_model(30, &model, NULL), NQM_OK);
    assert_int_equal(nqm_score(model, by_spec, 1, (const nqm_brdf *const[]){test}, NULL, &expected, NULL), NQM_OK);
    assert_int_equal(nqm_score(model, by_callback, 1, (const nqm_brdf *const[]){test}, NULL, &result, NULL), NQM_OK);
    assert_int_equal(expected.status, NQM_OK);
    assert_memory_equal(&result.jod, &expected.jod, sizeof result.jod);
    assert_memory_equal(result.metrics, expected.metrics, sizeof result.metrics);
    assert_int_equal(nqm_score(model, by_spec, 1, (const nqm_brdf *const *)&by_callback, NULL, &result, NULL), NQM_OK);
    assert_true(result.identical);
    nqm_brdf_free(test);
    nqm_model_free(model);
}

TEST(scores_like_the_spec) {
    double kd[3] = {0.5, 0.25, 0.75};
    nqm_brdf *lambert = must_open("lambert:kd=.5,.25,.75"), *ggx = must_open("ggx:kd=.1;ks=1;alpha=.05;f0=.5");
    nqm_brdf *mine[] = {
        create(&(nqm_brdf_callbacks){.eval = eval_lambert, .user = kd, .name = "mine", .reciprocal = 1}),
        create(&(nqm_brdf_callbacks){.eval = eval_of_brdf, .user = ggx, .serialize = 1})};
    same_score(lambert, mine[0]);
    same_score(ggx, mine[1]);
    nqm_brdf_info info = nqm_brdf_get_info(mine[0]);
    assert_string_equal(info.format, "callback");
    assert_string_equal(info.name, "mine");
    assert_true(info.reciprocal == 1 && info.n_values == 0 && !info.spec && !info.layout && !info.source_doi);
    assert_string_equal(nqm_brdf_get_info(mine[1]).name, "callback");
    assert_int_equal(nqm_brdf_get_info(mine[1]).reciprocal, 0);
    for (size_t i = 0; i < 2; ++i)
        nqm_brdf_free(mine[i]);
    nqm_brdf_free(lambert);
    nqm_brdf_free(ggx);
}

/* Red is negative for wi.x < 0, NaN for wi.y > 0.5, infinite for wi.y < -0.5. */
static void eval_faulty(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    (void)user;
    assert_in_range(n, 1, 512);
    for (size_t i = 0; i < n; ++i) {
        const double *l = wi + 3 * i;
        assert_true(l[2] > 0 && wo[3 * i + 2] > 0);
        rgb[3 * i] = l[1] > 0.5 ? NAN : l[1] < -0.5 ? INFINITY : l[0];
        rgb[3 * i + 1] = rgb[3 * i + 2] = 2;
    }
}

TEST(flags_like_loaders) {
    static const double wi[] = {.6, 0, .8, -.6, 0, .8, 0, .6, .8, 0, -.6, .8, 0, .6, -.8}, up[] = {0, 0, 1};
    static const uint8_t expected[] = {NQM_VALUE_OK, NQM_VALUE_CLAMPED, NQM_VALUE_INVALID, NQM_VALUE_INVALID,
                                       NQM_VALUE_HORIZON};
    nqm_brdf *brdf = create(&(nqm_brdf_callbacks){.eval = eval_faulty});
    for (size_t i = 0; i < sizeof expected; ++i) {
        double rgb[3];
        uint8_t flag;
        nqm_brdf_eval(brdf, 1, wi + 3 * i, up, rgb, &flag);
        assert_int_equal(flag, expected[i]);
        assert_true(rgb[0] == (i == 0 ? .6 : 0) && rgb[1] == (i < 2 ? 2 : 0));
    }
    nqm_brdf_free(brdf);
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

typedef struct counter {
    atomic_int inside, most_inside, calls;
} counter;

static void eval_counting(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    counter *c = user;
    double kd[3] = {.5, .5, .5};
    int inside = atomic_fetch_add(&c->inside, 1) + 1;
    if (inside > atomic_load(&c->most_inside))
        atomic_store(&c->most_inside, inside);
    eval_lambert(kd, n, wi, wo, rgb);
    atomic_fetch_add(&c->calls, 1);
    atomic_fetch_sub(&c->inside, 1);
}

static void *evaluate_many(void *brdf) {
    static const double up[] = {0, 0, 1};
    double rgb[3];
    for (int i = 0; i < 20000; ++i) {
        nqm_brdf_eval(brdf, 1, up, up, rgb, NULL);
        if (!(rgb[0] > 0.159 && rgb[0] < 0.16))
            return NULL;
    }
    return brdf;
}

TEST(two_threads) {
    for (int serialize = 0; serialize < 2; ++serialize) {
        counter c = {0};
        nqm_brdf *brdf = create(&(nqm_brdf_callbacks){.eval = eval_counting, .user = &c, .serialize = serialize});
        pthread_t thread[2];
        for (size_t i = 0; i < 2; ++i)
            assert_int_equal(pthread_create(&thread[i], NULL, evaluate_many, brdf), 0);
        for (size_t i = 0; i < 2; ++i) {
            void *returned;
            assert_int_equal(pthread_join(thread[i], &returned), 0);
            assert_ptr_equal(returned, brdf);
        }
        assert_int_equal(atomic_load(&c.calls), 40000);
        assert_true(atomic_load(&c.most_inside) <= (serialize ? 1 : 2));
        nqm_brdf_free(brdf);
    }
}

/* ---- ownership --------------------------------------------------------------------------------------------------- */

static void count_free(void *user) {
    ++*(int *)user;
}

TEST(user_is_freed_once) {
    int n_freed = 0;
    const nqm_brdf_callbacks good = {.eval = eval_of_brdf, .free = count_free, .user = &n_freed};
    nqm_brdf *brdf = (nqm_brdf *)&n_freed;
    nqm_error err = {0};
    for (int n = 0; n < 2; ++n) { /* on failure the caller keeps `user` */
        nqm_alloc_fail_after(n);
        assert_int_equal(nqm_brdf_create(&good, &brdf, &err), NQM_ERR_NOMEM);
        nqm_alloc_fail_after(-1);
        assert_null(brdf);
        assert_int_equal(n_freed, 0);
    }
    nqm_brdf_free(create(&good));
    assert_int_equal(n_freed, 1);
    assert_int_equal(nqm_brdf_create(NULL, &brdf, &err), NQM_ERR_ARG);
    assert_string_equal(err.message, "nqm_brdf_create: the argument callbacks is NULL");
    assert_int_equal(nqm_brdf_create(&(nqm_brdf_callbacks){.free = count_free}, &brdf, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "eval"));
    assert_null(brdf);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static void fill(float *rgb) {
    for (uint32_t i = 0; i < 3 * N; ++i)
        rgb[i] = 0.01f * (float)((i * 37u) % 101u) - 0.02f; /* some values are negative */
    rgb[3 * 40] = NAN;
}

TEST(table_equals_saved_table) {
    float rgb[3 * N];
    fill(rgb);
    nqm_brdf *table;
    assert_int_equal(nqm_brdf_create_table(H, D, P, rgb, NULL, &table, NULL), NQM_OK);
    memset(rgb, 0, sizeof rgb); /* the table must own a copy */
    const char *path = scratch_path("table.safetensors");
    assert_int_equal(nqm_brdf_save(table, path, NULL), NQM_OK);
    nqm_brdf *again = must_open(path);
    assert_string_equal(nqm_brdf_get_info(table).format, "table");
    assert_string_equal(nqm_brdf_get_info(table).name, "table");
    assert_string_equal(nqm_brdf_get_info(again).layout, nqm_brdf_get_info(table).layout);
    size_t n_of[4] = {0};
    for (size_t i = 0; i < 500; ++i) {
        const double x = (double)i / 500, hd[3] = {1.5 * x * x, 1.5 * fmod(7 * x, 1), 3 * fmod(13 * x, 1)};
        double a[3], b[3];
        uint8_t flag_a, flag_b;
        nqm_brdf_eval_half_diff(table, 1, hd, a, &flag_a);
        nqm_brdf_eval_half_diff(again, 1, hd, b, &flag_b);
        assert_memory_equal(a, b, sizeof a);
        assert_int_equal(flag_a, flag_b);
        ++n_of[flag_a];
    }
    assert_true(n_of[NQM_VALUE_OK] > 100 && n_of[NQM_VALUE_CLAMPED] > 0);
    nqm_brdf_free(table);
    nqm_brdf_free(again);
}

static void refuse_table(size_t h, size_t d, size_t p, const float *rgb, nqm_status status, const char *words) {
    nqm_brdf *brdf = (nqm_brdf *)&status;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_create_table(h, d, p, rgb, "mine", &brdf, &err), status);
    assert_null(brdf);
    if (!strstr(err.message, "mine") || !strstr(err.message, words))
        fail_msg("message: %s", err.message);
}

TEST(bad_tables) {
    float rgb[3 * N];
    fill(rgb);
    nqm_brdf *brdf = (nqm_brdf *)rgb;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_create_table(H, D, P, NULL, "mine", &brdf, &err), NQM_ERR_ARG);
    assert_string_equal(err.message, "nqm_brdf_create_table: the argument rgb is NULL");
    assert_null(brdf);
    refuse_table(0, D, P, rgb, NQM_ERR_LIMIT, "nodes");
    refuse_table(H, 1, P, rgb, NQM_ERR_LIMIT, "nodes");
    refuse_table(H, D, 0, rgb, NQM_ERR_LIMIT, "nodes");
    refuse_table(SIZE_MAX / 2, SIZE_MAX / 2, 4, rgb, NQM_ERR_LIMIT, "nodes");
    rgb[3 * 5 + 2] = INFINITY;
    refuse_table(H, D, P, rgb, NQM_ERR_ARG, "channel 2 of node 5");
    rgb[3 * 5 + 2] = NAN;
    refuse_table(H, D, P, rgb, NQM_ERR_ARG, "channel 2 of node 5");
    fill(rgb);
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        status = nqm_brdf_create_table(H, D, P, rgb, "mine", &brdf, NULL);
        assert_true((status == NQM_OK) == (brdf != NULL));
    }
    assert_true(n > 1);
    nqm_brdf_free(brdf);
}
