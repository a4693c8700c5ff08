/* SPDX-License-Identifier: MIT
 *
 * nqm_score_grad() for small models of each kind against PyTorch in double (tests/vectors/metric_torch.py); kinks, refusals, agreement with scores, the same bits for any batch and number of threads.
 */
#include "metric/metric.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/recorded.h"

#include <omp.h>

enum { N = PAIR_N, N_VALUES = PAIR_VALUES };

/* ---- models ------------------------------------------------------------------------------------------------------ */

static const char *const kinds[] = {"paper", "scalars", "all",
                                    "transport"}; /* all: with scalar features and transport */
enum { KINDS = sizeof kinds / sizeof *kinds, PAPER = 0, ALL = 2, TRANSPORT = 3 };

static nqm_model *make_estimator(void) {
    nqm_model *m = nqm_alloc(1, sizeof *m);
    m->target = NQM_TARGET_LOG_DELTA_E;
    m->output = (nqm_output_range){.std = 1, .lo = -1, .hi = 1};
    m->curve = nqm_curve_published;
    m->id = nqm_strdup(kinds[TRANSPORT]);
    assert_int_equal(nqm_directions_from_degrees(N, directions->degrees, &m->directions, NULL), NQM_OK);
    return m;
}

static nqm_model *make_model(size_t kind) {
    nqm_model *m;
    char file[64];
    nqm_transport t = make_transport(64, 2, 1500);
    snprintf(file, sizeof file, "small_%s.safetensors", kinds[kind]);
    if (kind == TRANSPORT)
        m = make_estimator();
    else
        assert_int_equal(nqm_model_load(test_vector(file), &m, NULL), NQM_OK);
    if (kind >= ALL)
        assert_int_equal(nqm_model_set_transport(m, &t, NULL), NQM_OK);
    drop_transport(&t);
    return m;
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

static nqm_scorer *make_scorer(const nqm_model *m) {
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(m, NULL, &scorer, NULL), NQM_OK);
    return scorer;
}

static double gradient_of(const nqm_model *m, nqm_score_quantity of, const gradient_pair *p, float *gradient) {
    const nqm_sample_pair pair = {p->ref, p->test, p->used};
    nqm_scorer *scorer = make_scorer(m);
    nqm_score_result result;
    double value;
    assert_int_equal(nqm_score_grad(scorer, of, 1, &pair, &value, gradient, NULL), NQM_OK);
    assert_int_equal(nqm_scorer_run_samples(scorer, 1, &pair, &result, NULL), NQM_OK);
    if (of == NQM_SCORE_JOD)
        assert_near(value, result.jod, 0.001);
    else
        assert_relative(value, result.delta_e, 0.001);
    nqm_scorer_free(scorer);
    return value;
}

static bool predicts(const nqm_model *m, nqm_score_quantity of) {
    return of == NQM_SCORE_JOD || m->target == NQM_TARGET_LOG_DELTA_E;
}

static const size_t recorded[] = {PAIR_005, PAIR_06, PAIR_ZEROS};
enum { RECORDED = sizeof recorded / sizeof *recorded };

/* Compare with what is recorded of a pair, but for the slopes where f_r is 0. The network computes in float. */
static void check_pair(const nqm_model *m, size_t which) {
    const gradient_pair p = recorded_pair(recorded[which]);
    for (nqm_score_quantity of = NQM_SCORE_JOD; of <= NQM_SCORE_DELTA_E; ++of) {
        double values[RECORDED], slopes[RECORDED][N_WAYS];
        float gradient[N_VALUES];
        char name[64];
        if (!predicts(m, of))
            continue;
        snprintf(name, sizeof name, "%s.%s", m->id, of == NQM_SCORE_JOD ? "jod" : "delta_e");
        get_recorded(name, sizeof values, values);
        assert_relative(gradient_of(m, of, &p, gradient), values[which], 1e-5);
        strcat(name, ".slopes");
        get_recorded(name, sizeof slopes, slopes);
        const double error =
            check_slopes(name, gradient, slopes[which], p.test, m->params.shape.n_layers ? 1e-5 : 1e-6);
        print_message("%s of %.4g: %.2g\n", name, values[which], error);
    }
}

static void on_every_kind(void (*test)(const nqm_model *m)) {
    for (size_t k = 0; k < KINDS; ++k) {
        nqm_model *m = make_model(k);
        test(m);
        nqm_model_free(m);
    }
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void ordinary(const nqm_model *m) {
    gradient_pair p = recorded_pair(PAIR_06);
    check_pair(m, 0);
    check_pair(m, 1);
    float gradient[N_VALUES], changed[N_VALUES];
    (void)gradient_of(m, NQM_SCORE_JOD, &p, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        if (!p.used[i / 3]) {
            assert_true(gradient[i] == 0);
            p.test[i] = 1e3f;
        }
    (void)gradient_of(m, NQM_SCORE_JOD, &p, changed);
    assert_memory_equal(gradient, changed, sizeof gradient);
}

TEST(against_differences) {
    on_every_kind(ordinary);
}

/* Where f_r is 0 the gradient is that at 1e-6 or finite; elsewhere as ever. */
static void zeros(const nqm_model *m) {
    gradient_pair p = recorded_pair(PAIR_ZEROS);
    float at_zero[N_VALUES], near_zero[N_VALUES];
    check_pair(m, 2);
    (void)gradient_of(m, NQM_SCORE_JOD, &p, at_zero);
    for (size_t i = 0; i < N_VALUES; ++i)
        p.test[i] = fmaxf(p.test[i], 1e-24f);
    (void)gradient_of(m, NQM_SCORE_JOD, &p, near_zero);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_near((double)at_zero[i], (double)near_zero[i], 1e-3 * fabs((double)near_zero[i]) + 1e-6);
    memset(p.test, 0, sizeof p.test);
    (void)gradient_of(m, NQM_SCORE_JOD, &p, at_zero);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_true(isfinite(at_zero[i]));
}

TEST(zero_reflectance) {
    on_every_kind(zeros);
}

static void equal(const nqm_model *m) {
    gradient_pair p = recorded_pair(PAIR_ZEROS);
    float gradient[N_VALUES];
    memcpy(p.test, p.ref, sizeof p.test);
    for (nqm_score_quantity of = NQM_SCORE_JOD; of <= NQM_SCORE_DELTA_E; ++of) {
        if (!predicts(m, of))
            continue;
        const double value = gradient_of(m, of, &p, gradient);
        const bool is_bounded = m->target == NQM_TARGET_LOG_DELTA_E;
        assert_true(!is_bounded || value == (of == NQM_SCORE_JOD ? 10 : 0));
        for (size_t i = 0; i < N_VALUES; ++i)
            assert_true(is_bounded ? gradient[i] == 0 : isfinite(gradient[i]));
    }
}

TEST(equal_pair) {
    on_every_kind(equal);
}

/* The bound on Delta-E is active: 165 times the largest difference of log(f + 5e-6). */
static void nearly_equal(const nqm_model *m) {
    static const double factors[] = {1.0001, 0.9999};
    if (m->target != NQM_TARGET_LOG_DELTA_E)
        return;
    for (size_t k = 0; k < 2; ++k) {
        gradient_pair p = recorded_pair(PAIR_02);
        float gradient[N_VALUES];
        memcpy(p.test, p.ref, sizeof p.test);
        const size_t at = 17;
        p.test[at + 9] = (float)((double)p.ref[at + 9] * (1 + (factors[k] - 1) / 10)); /* not the largest */
        p.test[at] = (float)((double)p.ref[at] * factors[k]);
        p.test[0] = 2 * p.ref[0];
        p.used[0] = 0;
        const double a = (double)p.ref[at] + 5e-6, b = (double)p.test[at] + 5e-6, bound = 165 * fabs(log(b / a));
        const double slope = (b > a ? 165 : -165) / b, h = 1e-6 * bound;
        assert_relative(gradient_of(m, NQM_SCORE_DELTA_E, &p, gradient), bound, 2e-3); /* ratios of floats */
        assert_relative((double)gradient[at], slope, 1e-6);
        for (size_t i = 0; i < N_VALUES; ++i)
            assert_true(i == at || gradient[i] == 0);
        (void)gradient_of(m, NQM_SCORE_JOD, &p, gradient);
        const double by_bound = (nqm_curve_jod(&m->curve, bound + h) - nqm_curve_jod(&m->curve, bound - h)) / (2 * h);
        assert_near((double)gradient[at], slope * by_bound, 1e-2 * fabs(slope * by_bound) + 1e-4);
    }
}

TEST(nearly_equal_pair) {
    on_every_kind(nearly_equal);
}

/* ---- steps ------------------------------------------------------------------------------------------------------- */

static float *sample_spec(const nqm_model *m, const char *spec) {
    nqm_brdf *brdf;
    float *rgb = nqm_alloc(3 * m->directions->n, sizeof *rgb);
    assert_int_equal(nqm_brdf_open(spec, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_sample(brdf, m->directions, NQM_INVALID_ERROR, rgb, NULL, NULL, NULL), NQM_OK);
    nqm_brdf_free(brdf);
    return rgb;
}

typedef enum direction { BY_GRADIENT, BY_LEVEL, TO_REFERENCE } direction;
static const char *const direction_words[] = {"along the gradient", "of level", "to the reference"};

/* What a step does to Delta-E, relative to what the gradient says. `step`: the largest relative change of f_r + 0.003, the relative
 * change of f_r, or the part of the way to the reference. */
static double step_ratio(const nqm_model *m, const float *ref, const float *test, double step, direction to) {
    const size_t n = 3 * m->directions->n;
    float *g = nqm_alloc(5 * n, sizeof *g), *up = g + n, *down = g + 2 * n;
    const nqm_sample_pair at = {ref, test, NULL}, pairs[2] = {{ref, up, NULL}, {ref, down, NULL}};
    nqm_scorer *scorer = make_scorer(m);
    double value, values[2], largest = 0, predicted = 0;
    assert_int_equal(nqm_score_grad(scorer, NQM_SCORE_DELTA_E, 1, &at, &value, g, NULL), NQM_OK);
    for (size_t i = 0; i < n; ++i)
        largest = fmax(largest, fabs((double)g[i]) / ((double)test[i] + 0.003));
    for (size_t i = 0; i < n; ++i) {
        const double by = step * (to == BY_LEVEL      ? (double)test[i]
                                  : to == BY_GRADIENT ? (double)g[i] / largest
                                                      : (double)ref[i] - (double)test[i]);
        up[i] = (float)fmax((double)test[i] + by, 0);
        down[i] = (float)fmax((double)test[i] - by, 0);
        predicted += (double)g[i] * ((double)up[i] - (double)down[i]);
    }
    assert_int_equal(nqm_score_grad(scorer, NQM_SCORE_DELTA_E, 2, pairs, values, g + 3 * n, NULL), NQM_OK);
    nqm_scorer_free(scorer);
    nqm_free(g);
    return (values[0] - values[1]) / predicted;
}

typedef struct step_case {
    double step;
    direction to;
} step_case;

/* The tests are glossier copies of four materials, which equal them, but for rounding, at half of the directions. */
static void check_steps(const char *gloss, size_t n, const step_case *cases) {
    static const char *const names[] = {"nickel", "alum-bronze", "gold-metallic-paint", "chrome"};
    nqm_model *m;
    assert_int_equal(nqm_model_builtin("default", &m, NULL), NQM_OK);
    for (size_t k = 0; k < 4; ++k) {
        char spec[64], copy[96];
        snprintf(spec, sizeof spec, "sgd:%s", names[k]);
        snprintf(copy, sizeof copy, "perturb:gloss=%s;of=%s", gloss, spec);
        float *ref = sample_spec(m, spec), *test = sample_spec(m, copy);
        for (size_t i = 0; i < n; ++i) {
            const double ratio = step_ratio(m, ref, test, cases[i].step, cases[i].to);
            if (!(fabs(ratio - 1) <= 0.05))
                fail_msg("%s, step %g %s: %.3f of what the gradient says", copy, cases[i].step,
                         direction_words[cases[i].to], ratio);
        }
        nqm_free(ref);
        nqm_free(test);
    }
    nqm_model_free(m);
}

TEST(steps_along_the_gradient) {
    static const step_case cases[] = {{1e-4, BY_GRADIENT}, {1e-4, BY_LEVEL},    {1e-3, BY_GRADIENT},
                                      {1e-3, BY_LEVEL},    {1e-2, BY_GRADIENT}, {1e-2, BY_LEVEL}};
    check_steps("1.05", sizeof cases / sizeof *cases, cases);
    check_steps("1.2", sizeof cases / sizeof *cases, cases);
}

/* Delta-E of 0.1 to 0.2. Larger steps along the gradient change the picture by as much as the difference is, and pass beyond the
 * reference, where the distance is least: there the finite difference says nothing about a slope. Towards the reference a step
 * of any part of the difference does what the gradient says. */
TEST(steps_of_small_differences) {
    static const step_case cases[] = {{1e-4, BY_GRADIENT},  {1e-4, BY_LEVEL},     {1e-4, TO_REFERENCE},
                                      {1e-3, TO_REFERENCE}, {1e-2, TO_REFERENCE}, {1e-1, TO_REFERENCE}};
    check_steps("1.002", sizeof cases / sizeof *cases, cases);
}

static void refuse(nqm_scorer *scorer, nqm_score_quantity of, const nqm_sample_pair *pairs, nqm_status status,
                   const char *words) {
    float gradients[2 * N_VALUES] = {42};
    double values[2] = {42, 42};
    nqm_error err = {0};
    assert_int_equal(nqm_score_grad(scorer, of, 2, pairs, values, gradients, &err), status);
    if (!strstr(err.message, words))
        fail_msg("'%s' lacks '%s'", err.message, words);
    assert_true(values[0] == 42 && values[1] == 42 && gradients[0] == 42);
}

TEST(refusals) {
    nqm_model *m = make_model(PAPER);
    nqm_scorer *scorer = make_scorer(m);
    gradient_pair p = recorded_pair(PAIR_02), bad = p;
    nqm_sample_pair pairs[2] = {{p.ref, p.test, NULL}, {p.ref, bad.test, NULL}};
    bad.test[100] = NAN;
    refuse(scorer, NQM_SCORE_JOD, pairs, NQM_ERR_ARG, "pair 1");
    bad.test[100] = -1;
    refuse(scorer, NQM_SCORE_JOD, pairs, NQM_ERR_ARG, "direction 33");
    bad.test[100] = INFINITY;
    refuse(scorer, NQM_SCORE_JOD, pairs, NQM_ERR_ARG, "test");
    bad = p;
    for (size_t i = 0; i < N; ++i)
        bad.used[i] = i % 5 != 0;
    pairs[1].used = bad.used;
    refuse(scorer, NQM_SCORE_JOD, pairs, NQM_ERR_INCOMPATIBLE, "pair 1: 120 of 150 directions are used");
    memset(bad.used, 1, N);
    refuse(scorer, NQM_SCORE_DELTA_E, pairs, NQM_ERR_ARG, "'paper' predicts no Delta-E");
    assert_int_equal(nqm_score_grad(scorer, NQM_SCORE_JOD, 0, NULL, NULL, NULL, NULL), NQM_OK);
    nqm_scorer_free(scorer);
    nqm_model_free(m);
}

enum { MANY = NQM_SCORE_BLOCK + 30 };

/* MANY pairs, `batch` in a call. */
static void run(const nqm_model *m, const nqm_sample_pair *pairs, size_t batch, double *values, float *gradients) {
    nqm_scorer *scorer = make_scorer(m);
    for (size_t first = 0; first < MANY; first += batch)
        assert_int_equal(nqm_score_grad(scorer, NQM_SCORE_DELTA_E, nqm_smaller(batch, MANY - first), pairs + first,
                                        values + first, gradients + first * N_VALUES, NULL),
                         NQM_OK);
    nqm_scorer_free(scorer);
}

TEST(the_same_bits) {
    enum { DISTINCT = 9 };
    static gradient_pair p[DISTINCT];
    static nqm_sample_pair pairs[MANY];
    static float all[MANY * N_VALUES], gradients[MANY * N_VALUES];
    static const size_t batches[] = {MANY, 1, 2, 50};
    double all_values[MANY], values[MANY];
    const int threads = omp_get_max_threads();
    nqm_model *m = make_model(ALL);
    for (size_t i = 0; i < DISTINCT; ++i) {
        p[i] = recorded_pair(i);
        memset(p[i].used, 1, N);
        memset(p[i].used + 7 * i, 0, i % 3 ? 7 : 0);
    }
    for (size_t i = 0; i < MANY; ++i) /* pairs of one reference, with and without dropped directions */
        pairs[i] = (nqm_sample_pair){p[i / 6 % DISTINCT].ref, p[(i * i + i) % DISTINCT].test,
                                     i % 7 < 3 ? NULL : p[i % DISTINCT].used};
    omp_set_num_threads(1);
    run(m, pairs, 7, all_values, all);
    for (size_t b = 0; b < 8; ++b) {
        omp_set_num_threads((int)(b % 2 + 1));
        run(m, pairs, batches[b / 2], values, gradients);
        assert_memory_equal(values, all_values, sizeof values);
        assert_memory_equal(gradients, all, sizeof gradients);
    }
    omp_set_num_threads(threads);
    nqm_model_free(m);
}

/* A call that ran out of memory may be repeated. */
TEST(out_of_memory) {
    nqm_model *m = make_model(ALL);
    nqm_scorer *scorer = make_scorer(m);
    const gradient_pair p = recorded_pair(PAIR_02);
    const nqm_sample_pair pairs[2] = {{p.ref, p.test, NULL}, {p.ref, p.test, NULL}};
    float gradients[2 * N_VALUES];
    double values[2];
    for (size_t n_pairs = 1; n_pairs <= 2; ++n_pairs) {
        nqm_status status = NQM_OK;
        long n = -1;
        EVERY_ALLOCATION(n, status, 0)
        status = nqm_score_grad(scorer, NQM_SCORE_JOD, n_pairs, pairs, values, gradients, NULL);
        assert_true(n < 40);
    }
    nqm_scorer_free(scorer);
    nqm_model_free(m);
}

TEST_FILE(make_recorded_directions, free_recorded_directions)
