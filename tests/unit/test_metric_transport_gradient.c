/* SPDX-License-Identifier: MIT
 *
 * The estimate by light transport in double against the fast estimate and against plain loops, and its gradient against
 * central differences of these, for several numbers of points and scenes.
 */
#include "support/check.h"
#include "support/double_features.h"
#include "support/double_transport.h"
#include "support/predict.h"

#include <math.h>
#include <string.h>

enum { N = DOUBLE_N, N_VALUES = DOUBLE_VALUES, N_WEIGHTS = 7 };

/* Each member of a label alone, and all of them. */
static const nqm_label weights[N_WEIGHTS] = {
    {.delta_e = 1},  {.shift = {1, 0, 0}}, {.shift = {0, 1, 0}},         {.shift = {0, 0, 1}},
    {.contrast = 1}, {.structure = 1},     {1, {0.5, -2, 0.3}, 7, -1, 0}};

static double weigh(const nqm_label *w, const nqm_label *label) {
    double sum = w->delta_e * label->delta_e + w->contrast * label->contrast + w->structure * label->structure;
    for (size_t k = 0; k < 3; ++k)
        sum += w->shift[k] * label->shift[k];
    return sum;
}

/* What the library says of a pair. */
typedef struct estimated {
    nqm_label label;
    float gradient[N_WEIGHTS][N_VALUES];
} estimated;

static void estimate(const nqm_transport *t, const gradient_pair *p, const uint8_t *used, estimated *e) {
    const size_t n = 3 * t->n_points;
    double *block = nqm_alloc(4 * n, sizeof *block), *by_light = block + 3 * n;
    float *rounded = nqm_alloc(n, sizeof *rounded);
    const nqm_sample_pair pair = {p->ref, p->test, used};
    const nqm_seen_pair seen = {block, block + n, block + 2 * n};
    nqm_transport_see(t, 1, &pair, &seen);
    e->label = nqm_transport_label(t, seen.ref, seen.test);
    memset(e->gradient, 0, sizeof e->gradient);
    for (size_t w = 0; w < N_WEIGHTS; ++w) {
        nqm_transport_light_gradient(t, &weights[w], &seen, by_light);
        for (size_t i = 0; i < n; ++i)
            rounded[i] = (float)by_light[i];
        nqm_transport_gradient(t, 1, &pair, rounded, e->gradient[w]);
    }
    nqm_free(rounded);
    nqm_free(block);
}

static void assert_labels_near(const nqm_label *label, const nqm_label *expected, double tolerance) {
    double parts[NQM_LABEL_PARTS], expected_parts[NQM_LABEL_PARTS];
    nqm_label_get_parts(label, parts);
    nqm_label_get_parts(expected, expected_parts);
    assert_near(label->delta_e, expected->delta_e, tolerance);
    for (size_t k = 0; k < NQM_LABEL_PARTS; ++k)
        assert_near(parts[k], expected_parts[k], tolerance);
}

/* (N_WEIGHTS, N_VALUES) central differences of order 4. */
static void differentiate(const nqm_transport *t, const gradient_pair *p, const uint8_t *used,
                          double (*gradient)[N_VALUES]) {
    static const double steps[4] = {-2, -1, 1, 2};
    double f[N_VALUES], g[N_VALUES];
    to_double(p->ref, f);
    to_double(p->test, g);
    for (size_t i = 0; i < N_VALUES; ++i) {
        const double at = g[i], h = 5e-5 * (0.5 + at); /* of light, not of f: rounding counts */
        nqm_label label[4];
        for (size_t s = 0; s < 4; ++s) {
            g[i] = at + steps[s] * h;
            label[s] = double_label(t, f, g, used);
        }
        g[i] = at;
        for (size_t w = 0; w < N_WEIGHTS; ++w)
            gradient[w][i] = (8 * (weigh(&weights[w], &label[2]) - weigh(&weights[w], &label[1])) -
                              (weigh(&weights[w], &label[3]) - weigh(&weights[w], &label[0]))) /
                             (12 * h);
    }
}

/* The largest error relative to the largest entry. */
static double check_gradients(const estimated *e, double (*expected)[N_VALUES]) {
    double worst = 0;
    for (size_t w = 0; w < N_WEIGHTS; ++w) {
        double largest = 0, error = 0;
        for (size_t i = 0; i < N_VALUES; ++i) {
            largest = fmax(largest, fabs(expected[w][i]));
            error = fmax(error, fabs((double)e->gradient[w][i] - expected[w][i]));
        }
        if (!(error <= 1e-5 * largest))
            fail_msg("weights %zu: error %g of %g", w, error, largest);
        worst = fmax(worst, error / largest);
    }
    return worst;
}

static void check_pair(const nqm_transport *t, const gradient_pair *p, const uint8_t *used) {
    static estimated e;
    static double expected[N_WEIGHTS][N_VALUES];
    double f[N_VALUES], g[N_VALUES];
    to_double(p->ref, f);
    to_double(p->test, g);
    estimate(t, p, used, &e);
    const nqm_label plain = double_label(t, f, g, used), fast = transport_estimate(t, p->ref, p->test, used);
    assert_labels_near(&e.label, &plain, 2e-6 * (1 + plain.delta_e));
    assert_labels_near(&fast, &plain,
                       1e-3 + 1e-4 * plain.delta_e); /* the error of its table (test_metric_transport.c) */
    differentiate(t, p, used, expected);
    const double worst = check_gradients(&e, expected);
    print_message("%zu points, Delta-E %.3g: %.2g\n", t->n_points, plain.delta_e, worst);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

TEST(ordinary_pairs) {
    static const double strengths[] = {0.002, 0.1, 1};
    nqm_transport t = make_transport(128, 1, 100000);
    for (size_t k = 0; k < 3; ++k) {
        const gradient_pair p = make_pair(k + 1, strengths[k], 40 + 30 * k);
        check_pair(&t, &p, NULL);
    }
    drop_transport(&t);
}

TEST(points_and_scenes) {
    static const size_t shapes[][2] = {{32, 1}, {32, 3}, {160, 1}, {160, 7}, {288, 2}};
    const gradient_pair p = make_pair(4, 0.2, 70);
    for (size_t k = 0; k < 5; ++k) {
        nqm_transport t = make_transport(shapes[k][0], shapes[k][1], 1e5);
        assert_null(nqm_transport_fault(&t, true));
        check_pair(&t, &p, NULL);
        drop_transport(&t);
    }
}

/* Rows [first, first + n) of a matrix as a matrix of one scene. */
static nqm_transport part_of(const nqm_transport *t, size_t first, size_t n) {
    nqm_transport part = make_transport(n, 1, 1e5);
    float *light = (float *)(uintptr_t)part.light;
    double *points = (double *)(uintptr_t)part.points;
    for (size_t i = 0; i < N_VALUES; ++i)
        memcpy(light + i * n, t->light + i * t->n_points + first, n * sizeof *light);
    memcpy(points, t->points + 3 * first, 3 * n * sizeof *points);
    for (size_t p = 0; p < n; ++p)
        points[3 * p + 1] = 0;
    return part;
}

/* More points than are computed together: the label is the mean of those of the scenes, each alone. */
TEST(sum_of_parts) {
    enum { POINTS = 288, SCENES = 3, PART = POINTS / SCENES };
    const gradient_pair p = make_pair(9, 0.2, 70);
    static estimated all, part;
    nqm_transport t = make_transport(POINTS, SCENES, 900);
    nqm_label fast = {.delta_e = 0}, exact = {.delta_e = 0};
    double sum[N_VALUES] = {0};
    for (size_t s = 0; s < SCENES; ++s) {
        nqm_transport one = part_of(&t, s * PART, PART);
        const nqm_label label = transport_estimate(&one, p.ref, p.test, NULL);
        estimate(&one, &p, NULL, &part);
        nqm_label_add(&fast, 1.0 / SCENES, &label);
        nqm_label_add(&exact, 1.0 / SCENES, &part.label);
        for (size_t i = 0; i < N_VALUES; ++i)
            sum[i] += (double)part.gradient[N_WEIGHTS - 1][i] / SCENES;
        drop_transport(&one);
    }
    const nqm_label whole = transport_estimate(&t, p.ref, p.test, NULL);
    estimate(&t, &p, NULL, &all);
    assert_labels_near(&whole, &fast, 1e-12);
    assert_labels_near(&all.label, &exact, 1e-12);
    double largest = 0;
    for (size_t i = 0; i < N_VALUES; ++i)
        largest = fmax(largest, fabs(sum[i]));
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_near((double)all.gradient[N_WEIGHTS - 1][i], sum[i], 2e-6 * largest);
    drop_transport(&t);
}

/* Channels above the peak have no influence. */
TEST(above_the_peak) {
    gradient_pair p = make_pair(5, 0.3, 10);
    nqm_transport t = make_transport(64, 2, 300);
    check_pair(&t, &p, NULL);
    drop_transport(&t);
    static estimated e;
    t = make_transport(64, 2, 1); /* all of them */
    estimate(&t, &p, NULL, &e);
    for (size_t i = 0; i < N_WEIGHTS * N_VALUES; ++i)
        assert_true(e.gradient[i / N_VALUES][i % N_VALUES] == 0);
    drop_transport(&t);
}

TEST(dropped_directions) {
    static estimated e, changed;
    gradient_pair p = make_pair(6, 0.3, 10);
    nqm_transport t = make_transport(96, 2, 1e5);
    for (size_t k = 0; k < N; ++k)
        p.used[k] = k % 3 != 0;
    check_pair(&t, &p, p.used);
    estimate(&t, &p, p.used, &e);
    for (size_t i = 0; i < N_VALUES; ++i)
        if (!p.used[i / 3]) {
            assert_true(e.gradient[N_WEIGHTS - 1][i] == 0);
            p.test[i] += 5;
        }
    estimate(&t, &p, p.used, &changed);
    assert_memory_equal(&e, &changed, sizeof e);
    drop_transport(&t);
}

/* Only signed members of the label have a gradient there. */
TEST(equal_pair) {
    static estimated e;
    static double expected[N_WEIGHTS][N_VALUES];
    gradient_pair p = make_pair(7, 0.3, 10);
    nqm_transport t = make_transport(64, 2, 1e5);
    memcpy(p.test, p.ref, sizeof p.test);
    estimate(&t, &p, NULL, &e);
    assert_true(e.label.delta_e == 0 && e.label.structure == 0 && e.label.contrast == 0);
    differentiate(&t, &p, NULL, expected);
    for (size_t i = 0; i < N_VALUES; ++i) {
        assert_true(e.gradient[0][i] == 0 && e.gradient[5][i] == 0);
        e.gradient[6][i] = 0;
        expected[0][i] = expected[5][i] = expected[6][i] = 0;
    }
    (void)check_gradients(&e, expected);
    drop_transport(&t);
}

/* PQ has no limit of its derivative at 0: the gradient is finite, and points to more light for a brighter picture. */
TEST(black_test) {
    static estimated e;
    gradient_pair p = make_pair(8, 0.3, 10);
    nqm_transport t = make_transport(64, 2, 1e5);
    memset(p.test, 0, sizeof p.test);
    estimate(&t, &p, NULL, &e);
    for (size_t i = 0; i < N_VALUES; ++i) {
        for (size_t w = 0; w < N_WEIGHTS; ++w)
            assert_true(isfinite(e.gradient[w][i]));
        assert_true(e.gradient[1][i] > 0 && e.gradient[0][i] < 0);
    }
    drop_transport(&t);
}

TEST_FILE(make_double_directions, free_double_directions)
