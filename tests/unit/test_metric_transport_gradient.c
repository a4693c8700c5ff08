/* SPDX-License-Identifier: MIT
 *
 * The estimate by light transport in double against the fast estimate and against PyTorch (tests/vectors/metric_torch.py), and
 * its gradient against PyTorch's, for several numbers of points and scenes.
 */
#include "support/check.h"
#include "support/predict.h"
#include "support/recorded.h"

enum { N = PAIR_N, N_VALUES = PAIR_VALUES, N_WEIGHTS = 7 };

/* Each member of a label alone, and all of them. */
static const nqm_label weights[N_WEIGHTS] = {
    {.delta_e = 1},  {.shift = {1, 0, 0}}, {.shift = {0, 1, 0}},         {.shift = {0, 0, 1}},
    {.contrast = 1}, {.structure = 1},     {1, {0.5, -2, 0.3}, 7, -1, 0}};

/* What the library says of a pair. */
typedef struct estimated {
    nqm_label label;
    float gradient[N_WEIGHTS][N_VALUES];
} estimated;

static void estimate(const nqm_transport *t, const gradient_pair *p, const uint8_t *used, estimated *e) {
    const size_t n = 3 * t->points.n;
    double *block = nqm_alloc(4 * n, sizeof *block), *by_light = block + 3 * n;
    float *rounded = nqm_alloc(n, sizeof *rounded);
    const nqm_sample_pair pair = {p->ref, p->test, used};
    const nqm_shown_pair shown = {block, block + n, block + 2 * n};
    nqm_transport_see(t, 1, &pair, &shown);
    e->label = nqm_picture_label(&t->points, shown.ref, shown.test);
    memset(e->gradient, 0, sizeof e->gradient);
    for (size_t w = 0; w < N_WEIGHTS; ++w) {
        nqm_picture_light_gradient(&t->points, &weights[w], &shown, by_light);
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

/* The recorded cases: a pair, the points, scenes and peak of a matrix. A picture that is above the peak in part is among them, and a
 * pair with dropped directions, and an equal pair, at which only signed members of the label have a gradient. */
TEST(as_pytorch) {
    enum { CASES = 11 };
    static estimated e;
    double cases[CASES][4], labels[CASES][N_WEIGHTS];
    static double slopes[CASES][N_WEIGHTS][N_WAYS];
    get_recorded("labels.cases", sizeof cases, cases);
    get_recorded("labels", sizeof labels, labels);
    get_recorded("labels.slopes", sizeof slopes, slopes);
    for (size_t k = 0; k < CASES; ++k) {
        const gradient_pair p = recorded_pair((size_t)cases[k][0]);
        nqm_transport t = make_transport((size_t)cases[k][1], (size_t)cases[k][2], cases[k][3]);
        const double *l = labels[k];
        const nqm_label exact = {l[0], {l[1], l[2], l[3]}, l[4], l[5], 0};
        assert_null(nqm_transport_fault(&t, true));
        estimate(&t, &p, p.used, &e);
        const nqm_label fast = transport_estimate(&t, p.ref, p.test, p.used);
        assert_labels_near(&e.label, &exact, 2e-6 * (1 + exact.delta_e));
        assert_labels_near(&fast, &exact, 1e-3 + 1e-4 * exact.delta_e); /* of its table (test_metric_transport.c) */
        for (size_t w = 0; w < N_WEIGHTS; ++w) {
            if (cases[k][0] == PAIR_EQUAL && (w == 0 || w > 4))
                continue;
            char what[64];
            snprintf(what, sizeof what, "case %zu, weights %zu", k, w);
            check_slopes(what, e.gradient[w], slopes[k][w], NULL, 1e-5);
        }
        drop_transport(&t);
    }
}

/* Rows [first, first + n) of a matrix as a matrix of one scene. */
static nqm_transport part_of(const nqm_transport *t, size_t first, size_t n) {
    nqm_transport part = make_transport(n, 1, 1e5);
    float *light = (float *)(uintptr_t)part.light;
    double *points = (double *)(uintptr_t)part.points.at;
    for (size_t i = 0; i < N_VALUES; ++i)
        memcpy(light + i * n, t->light + i * t->points.n + first, n * sizeof *light);
    memcpy(points, t->points.at + 3 * first, 3 * n * sizeof *points);
    for (size_t p = 0; p < n; ++p)
        points[3 * p + 1] = 0;
    return part;
}

/* More points than are computed together: the label is the mean of those of the scenes, each alone. */
TEST(sum_of_parts) {
    enum { POINTS = 288, SCENES = 3, PART = POINTS / SCENES };
    const gradient_pair p = recorded_pair(PAIR_02);
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
    const gradient_pair p = recorded_pair(PAIR_02);
    static estimated e;
    nqm_transport t = make_transport(64, 2, 1); /* all of them */
    estimate(&t, &p, NULL, &e);
    for (size_t i = 0; i < N_WEIGHTS * N_VALUES; ++i)
        assert_true(e.gradient[i / N_VALUES][i % N_VALUES] == 0);
    drop_transport(&t);
}

TEST(dropped_directions) {
    static estimated e, changed;
    gradient_pair p = recorded_pair(PAIR_UNUSED);
    nqm_transport t = make_transport(96, 2, 1e5);
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
    const gradient_pair p = recorded_pair(PAIR_EQUAL);
    nqm_transport t = make_transport(64, 2, 1e5);
    estimate(&t, &p, NULL, &e);
    assert_true(e.label.delta_e == 0 && e.label.structure == 0 && e.label.contrast == 0);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_true(e.gradient[0][i] == 0 && e.gradient[5][i] == 0);
    drop_transport(&t);
}

/* PQ has no limit of its derivative at 0: the gradient is finite, and points to more light for a brighter picture. */
TEST(black_test) {
    static estimated e;
    gradient_pair p = recorded_pair(PAIR_02);
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

TEST_FILE(make_recorded_directions, free_recorded_directions)
