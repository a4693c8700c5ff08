/* SPDX-License-Identifier: MIT
 *
 * The fit of intervals to residuals of a known distribution with random effects of materials: coverage on new materials
 * over many repetitions, the coverage that the fit reports, and the shape of its table.
 */
#include "support/check.h"
#include "support/vectors.h"
#include "train/train.h"

enum { N_MATERIALS = 24, PAIRS_EACH = 40, MAX = N_MATERIALS * PAIRS_EACH };

/* Residuals in logit(JOD / 10): wider in the middle of the range than at the top, skewed, with a random bias and spread
 * per material. */
typedef struct material {
    double bias, spread;
} material;

static material draw_material(nqm_rng *rng) {
    return (material){0.6 * nqm_rng_normal(rng), exp(0.4 * nqm_rng_normal(rng))};
}

static double logit_jod(double x) {
    return 10 / (1 + exp(-x));
}

static void draw_pair(const material *m, nqm_rng *rng, double *predicted, double *label) {
    double x = 5.5 * nqm_rng_uniform(rng), scale = 0.25 + 0.1 * (5.5 - x);
    double e = m->bias + m->spread * nqm_rng_normal(rng);
    *predicted = logit_jod(x);
    *label = logit_jod(x + scale * (e > 0 ? e : 2 * e));
}

static double predicted[MAX], label[MAX];
static uint32_t group[MAX];
static nqm_residuals residuals = {
    .n = MAX, .n_groups = N_MATERIALS, .predicted = predicted, .label = label, .group = group};

static void draw_residuals(nqm_rng *rng) {
    for (size_t g = 0; g < N_MATERIALS; ++g) {
        material m = draw_material(rng);
        for (size_t i = g * PAIRS_EACH; i < (g + 1) * PAIRS_EACH; ++i) {
            draw_pair(&m, rng, &predicted[i], &label[i]);
            group[i] = (uint32_t)g;
        }
    }
}

/* Coverage of new pairs, one per material, for predictions below 9.5 JOD and above. */
enum { N_ZONES = 2, N_FRESH = 4000 };

static double fresh_coverage(const double *table, nqm_rng *rng, double inside[N_ZONES], double n[N_ZONES]) {
    double all = 0;
    for (size_t i = 0; i < N_FRESH; ++i) {
        material m = draw_material(rng);
        double jod, truth, low, high;
        draw_pair(&m, rng, &jod, &truth);
        nqm_interval_at(NQM_INTERVAL_ROWS, table, jod, &low, &high);
        size_t zone = jod >= 9.5;
        inside[zone] += truth >= low && truth <= high;
        n[zone] += 1;
        all += truth >= low && truth <= high;
    }
    return all / N_FRESH;
}

TEST(new_materials_are_covered) {
    enum { N_REPEATS = 40 };
    double mean = 0, said = 0, inside[N_ZONES] = {0}, n[N_ZONES] = {0}, table[3 * NQM_INTERVAL_ROWS];
    int n_short = 0;
    for (uint64_t repeat = 0; repeat < N_REPEATS; ++repeat) {
        nqm_rng rng = nqm_rng_make(7, repeat);
        nqm_calibration c;
        draw_residuals(&rng);
        assert_int_equal(nqm_interval_fit(&residuals, table, &c, NULL), NQM_OK);
        assert_null(nqm_interval_table_fault(NQM_INTERVAL_ROWS, table));
        double coverage = fresh_coverage(table, &rng, inside, n);
        mean += coverage / N_REPEATS;
        said += c.coverage / N_REPEATS;
        n_short += coverage < 0.95;
    }
    /* The limit has 95 % confidence: at most 1 calibration in 20 (2 of 40) should fall short; allow three more by
     * chance. */
    assert_in_range(n_short, 0, 5);
    assert_true(mean > 0.95 && mean < 0.985);
    assert_near(said, mean, 0.01);
    for (size_t z = 0; z < N_ZONES; ++z)
        assert_near(inside[z] / n[z], mean, 0.02);
}

/* Pairs of a material are not independent, because materials are biased: few materials must widen the interval. */
TEST(materials_are_the_sample) {
    enum { N_REPEATS = 20 };
    double table[3 * NQM_INTERVAL_ROWS], width_together = 0, width_apart = 0;
    nqm_calibration together, apart;
    static uint32_t own[MAX];
    for (size_t i = 0; i < MAX; ++i) /* pairs of all materials in each of many groups */
        own[i] = (uint32_t)(i % (MAX / 4));
    nqm_residuals scattered = residuals;
    scattered.group = own;
    scattered.n_groups = MAX / 4;
    for (uint64_t repeat = 0; repeat < N_REPEATS; ++repeat) {
        nqm_rng rng = nqm_rng_make(8, repeat);
        draw_residuals(&rng);
        assert_int_equal(nqm_interval_fit(&residuals, table, &together, NULL), NQM_OK);
        assert_int_equal(nqm_interval_fit(&scattered, table, &apart, NULL), NQM_OK);
        width_together += together.mean_width;
        width_apart += apart.mean_width;
    }
    assert_int_equal(together.n_materials, N_MATERIALS);
    assert_int_equal(apart.n_materials, MAX / 4);
    assert_true(together.coverage_lowest <= together.coverage);
    assert_true(width_together > 1.04 * width_apart);
}

TEST(tables_keep_their_promises) {
    nqm_rng rng = nqm_rng_make(9, 0);
    double table[3 * NQM_INTERVAL_ROWS], again[3 * NQM_INTERVAL_ROWS], last_low = 0, last_high = 0;
    nqm_calibration c;
    draw_residuals(&rng);
    label[0] = 10.3; /* human labels can exceed 10 */
    predicted[1] = 0;
    label[2] = 0;
    assert_int_equal(nqm_interval_fit(&residuals, table, &c, NULL), NQM_OK);
    assert_int_equal(nqm_interval_fit(&residuals, again, &c, NULL), NQM_OK);
    assert_memory_equal(table, again, sizeof table);
    assert_true(table[0] == 0 && table[3 * NQM_INTERVAL_ROWS - 3] == 10);
    for (int i = -10; i <= 1100; ++i) {
        double jod = i / 100.0, low, high;
        nqm_interval_at(NQM_INTERVAL_ROWS, table, jod, &low, &high);
        assert_true(low <= jod && jod <= high);
        if (jod >= 0 && jod <= 10)
            assert_true(low >= 0 && high <= 10 && low >= last_low && high >= last_high);
        last_low = low, last_high = high;
    }
    double low, high;
    nqm_interval_at(NQM_INTERVAL_ROWS, table, 10, &low, &high);
    assert_true(high == 10 && low > 9.9);
}

TEST(right_predictions_have_narrow_intervals) {
    nqm_rng rng = nqm_rng_make(10, 0);
    double table[3 * NQM_INTERVAL_ROWS];
    nqm_calibration c;
    draw_residuals(&rng);
    for (size_t i = 0; i < MAX; ++i)
        label[i] = predicted[i];
    assert_int_equal(nqm_interval_fit(&residuals, table, &c, NULL), NQM_OK);
    assert_true(c.mean_width < 0.3 && c.coverage_lowest == 1);
    assert_near(c.coverage, 1, 1e-12);
    for (size_t i = 0; i < MAX; ++i) /* a network with constant output has a wide interval */
        predicted[i] = 8;
    assert_int_equal(nqm_interval_fit(&residuals, table, &c, NULL), NQM_OK);
    assert_true(c.mean_width > 4 && c.coverage > 0.9);
}

/* ---- novelty ----------------------------------------------------------------------------------------------------- */

static double novelty[MAX];

/* Residuals whose deviation is proportional to exp(true_growth novelty). */
static void draw_novel_residuals(nqm_rng *rng, double true_growth) {
    for (size_t i = 0; i < MAX; ++i) {
        group[i] = (uint32_t)(i / PAIRS_EACH);
        novelty[i] = 0.2 + 0.8 * nqm_rng_uniform(rng) * nqm_rng_uniform(rng) + (i % 10 == 0);
        double x = 5.5 * nqm_rng_uniform(rng), e = 0.2 * exp(true_growth * novelty[i]) * nqm_rng_normal(rng);
        predicted[i] = logit_jod(x);
        label[i] = logit_jod(x + e);
    }
}

/* Coverage of new pairs from the same distribution, for novelty <= 1 and > 1. */
static void novel_coverage(const double *table, double growth, double true_growth, nqm_rng *rng, double inside[2]) {
    double n[2] = {0};
    inside[0] = inside[1] = 0;
    for (size_t repeat = 0; repeat < 10; ++repeat) {
        draw_novel_residuals(rng, true_growth);
        for (size_t i = 0; i < MAX; ++i) {
            double low, high;
            nqm_interval_at(NQM_INTERVAL_ROWS, table, predicted[i], &low, &high);
            nqm_interval_widen(exp(growth * novelty[i]), predicted[i], &low, &high);
            inside[novelty[i] > 1] += label[i] >= low && label[i] <= high;
            n[novelty[i] > 1] += 1;
        }
    }
    inside[0] /= n[0], inside[1] /= n[1];
}

TEST(intervals_grow_with_novelty) {
    double table[3 * NQM_INTERVAL_ROWS], inside[2];
    nqm_calibration with, without;
    nqm_residuals r = residuals;
    nqm_rng rng = nqm_rng_make(12, 0);
    draw_novel_residuals(&rng, 1.25);
    assert_int_equal(nqm_interval_fit(&r, table, &without, NULL), NQM_OK);
    r.novelty = novelty;
    assert_true(without.novelty_growth == 0);
    nqm_rng same = rng;
    novel_coverage(table, 0, 1.25, &same, inside);
    assert_true(inside[1] < 0.85); /* otherwise there is nothing to correct */
    rng = nqm_rng_make(12, 0);
    draw_novel_residuals(&rng, 1.25);
    assert_int_equal(nqm_interval_fit(&r, table, &with, NULL), NQM_OK);
    assert_null(nqm_interval_table_fault(NQM_INTERVAL_ROWS, table));
    assert_near(with.novelty_growth, 1.25, 0.5);
    assert_true(with.mean_width < 0.95 * without.mean_width && with.coverage > 0.94);
    novel_coverage(table, with.novelty_growth, 1.25, &rng, inside);
    assert_true(inside[0] > 0.94 && inside[1] > 0.9);
}

/* A quarter of the pairs is novel, and one pair in 40 has its label far away. Coverage allows that: widths are least
 * without a growth, which pays 40 times the distance of these labels from the interval. */
TEST(labels_outside_count_by_their_distance) {
    double table[3 * NQM_INTERVAL_ROWS];
    nqm_calibration c;
    nqm_residuals r = residuals;
    nqm_rng rng = nqm_rng_make(15, 0);
    r.novelty = novelty;
    for (size_t i = 0; i < MAX; ++i) {
        group[i] = (uint32_t)(i / PAIRS_EACH);
        novelty[i] = i % 4 == 0;
        predicted[i] = 5;
        label[i] = logit_jod(i % PAIRS_EACH ? 0.1 * nqm_rng_normal(&rng) : i / PAIRS_EACH % 2 ? 3 : -3);
    }
    assert_int_equal(nqm_interval_fit(&r, table, &c, NULL), NQM_OK);
    assert_near(c.novelty_growth, 3, 0);
}

TEST(novelty_without_effect_has_none) {
    double table[3 * NQM_INTERVAL_ROWS];
    nqm_calibration with, without;
    nqm_residuals r = residuals;
    nqm_rng rng = nqm_rng_make(13, 0);
    draw_novel_residuals(&rng, 0);
    assert_int_equal(nqm_interval_fit(&r, table, &without, NULL), NQM_OK);
    r.novelty = novelty;
    assert_int_equal(nqm_interval_fit(&r, table, &with, NULL), NQM_OK);
    assert_true(with.novelty_growth <= 0.25);
    assert_true(with.mean_width < 1.03 * without.mean_width);
}

/* Features whose growths are known; the first says nothing about the errors. */
TEST(intervals_grow_with_features) {
    static double spread[MAX * NQM_SPREAD_FEATURES];
    double table[3 * NQM_INTERVAL_ROWS];
    nqm_calibration with, without;
    nqm_residuals r = residuals;
    nqm_rng rng = nqm_rng_make(14, 0);
    for (size_t i = 0; i < MAX; ++i) {
        double *f = spread + i * NQM_SPREAD_FEATURES, x = 5.5 * nqm_rng_uniform(&rng);
        f[NQM_SPREAD_DISAGREEMENT] = 2 * nqm_rng_uniform(&rng);
        f[NQM_SPREAD_PEAK] = i % 4 ? 0 : 2 * nqm_rng_uniform(&rng);
        predicted[i] = logit_jod(x);
        label[i] = logit_jod(x + 0.1 * exp(f[NQM_SPREAD_PEAK]) * nqm_rng_normal(&rng));
    }
    assert_int_equal(nqm_interval_fit(&r, table, &without, NULL), NQM_OK);
    assert_true(without.peak_growth == 0 && without.disagreement_growth == 0);
    r.spread = spread;
    assert_int_equal(nqm_interval_fit(&r, table, &with, NULL), NQM_OK);
    assert_near(with.peak_growth, 1, 0);
    assert_near(with.disagreement_growth, 0, 0);
    assert_true(with.novelty_growth == 0 && with.mean_width < 0.9 * without.mean_width);
}

/* Intervals of a model are those of tests/vectors/interval.py. */
TEST(intervals_by_the_formula) {
    enum { ROWS = 3, CASES = 24 };
    static struct { double curve[3], growth[3], table[3 * ROWS], floor[NQM_INTERVAL_KNOTS]; } vector;
    struct {
        double jod, novelty, log_estimate, ref_peak, disagreement, peak, low, high;
    } cases[CASES];
    static float light;
    static nqm_model model;
    get_vector("interval.safetensors", "model", sizeof vector, &vector);
    get_vector("interval.safetensors", "cases", sizeof cases, cases);
    model.interval = vector.table;
    model.n_interval = ROWS;
    model.n_novelty = 1;
    model.transport = &light;
    model.curve = (nqm_curve){vector.curve[0], vector.curve[1], vector.curve[2]};
    model.novelty_growth = vector.growth[0];
    memcpy(model.spread_growth, vector.growth + 1, sizeof model.spread_growth);
    memcpy(model.interval_floor, vector.floor, sizeof model.interval_floor);
    assert_true(nqm_model_has_spread(&model));
    for (size_t i = 0; i < CASES; ++i) {
        double f[NQM_SPREAD_FEATURES], low, high;
        nqm_spread_features(&model, cases[i].jod, cases[i].log_estimate, cases[i].ref_peak, f);
        assert_near(f[NQM_SPREAD_DISAGREEMENT], cases[i].disagreement, 1e-12);
        assert_near(f[NQM_SPREAD_PEAK], cases[i].peak, 1e-12);
        nqm_model_interval(&model, cases[i].jod, cases[i].novelty, nqm_model_spread(&model, f), &low, &high);
        assert_near(low, cases[i].low, 1e-9);
        assert_near(high, cases[i].high, 1e-9);
    }
    model.transport = NULL; /* no estimate, nothing to disagree with */
    double f[NQM_SPREAD_FEATURES];
    nqm_spread_features(&model, 5, 1, NAN, f);
    assert_true(f[NQM_SPREAD_DISAGREEMENT] == 0 && f[NQM_SPREAD_PEAK] == 0);
}

/* The least half-width is 1.96 label errors where labels have errors, and 0.001 JOD elsewhere. */
TEST(intervals_have_a_least_width) {
    enum { N_PAIRS = 40 };
    double least[NQM_INTERVAL_KNOTS], noise[N_PAIRS], jod[N_PAIRS];
    const nqm_residuals r = {.n = N_PAIRS, .predicted = jod, .noise = noise};
    for (size_t i = 0; i < N_PAIRS; ++i) {
        jod[i] = nqm_interval_jod(nqm_interval_knot(10) + 0.01 * (double)(i + 1));
        noise[i] = 0.25;
    }
    nqm_interval_find_floor(&r, least);
    assert_near(least[10], 0.49, 1e-12);
    assert_near(least[11], 0.49, 1e-12); /* within one step */
    for (size_t k = 0; k < NQM_INTERVAL_KNOTS; ++k) {
        const double top = fmax(0.001, nqm_interval_jod(nqm_interval_knot(k)));
        if (k != 10 && k != 11)
            assert_near(nqm_interval_jod(nqm_interval_y(top) - least[k]), top - 0.001, 1e-9);
    }
}

TEST(tables_are_interpolated) {
    static const double table[9] = {0, 0, 1, 4, 2, 5, 8, 7, 10};
    double low, high;
    nqm_interval_at(3, table, 6, &low, &high);
    assert_near(low, 4.5, 1e-12);
    assert_near(high, 7.5, 1e-12);
    nqm_interval_at(3, table, 1, &low, &high);
    assert_near(low, 0.5, 1e-12);
    assert_near(high, 2, 1e-12);
}

TEST(widening_keeps_its_promises) {
    for (int i = 0; i <= 20; ++i) {
        double jod = i / 2.0, low = fmax(0, jod - 0.4), high = fmin(10, jod + 0.3), l = low, h = high;
        nqm_interval_widen(1, jod, &l, &h);
        assert_near(l, low, 1e-9);
        assert_near(h, high, 1e-9);
        for (double times = 1.5, last_l = l, last_h = h; times < 1e9; times *= 10) {
            l = low, h = high;
            nqm_interval_widen(times, jod, &l, &h);
            assert_true(l <= last_l && h >= last_h && l >= 0 && h <= 10);
            last_l = l, last_h = h;
        }
        assert_true((l == 0 || low == jod) && (h == 10 || high == jod));
    }
    double l = 5, h = 5;
    nqm_interval_widen(7, 5, &l, &h);
    assert_true(l == 5 && h == 5);
    l = 5, h = 8;
    nqm_interval_widen(2, 5, &l, &h);
    assert_near(h, 10 * 16 / 17.0, 1e-3); /* odds 4 become 16 */
}

/* The factor is the smallest for which the lower end of Student's one-sided 95 % interval of the mean coverage of materials reaches
 * 95 %. 1.7139 is the quantile of 23 degrees of freedom. The table's own margin is 0.0137 larger, because its scales know the
 * materials that the factor was found without; with the quantile of 90 % it is 0.0102. */
TEST(the_margin_is_students) {
    enum { N_REPEATS = 40 };
    double table[3 * NQM_INTERVAL_ROWS], mean_margin = 0;
    for (uint64_t repeat = 0; repeat < N_REPEATS; ++repeat) {
        nqm_rng rng = nqm_rng_make(13, repeat);
        nqm_calibration c;
        double inside[N_MATERIALS] = {0}, mean = 0, squares = 0;
        draw_residuals(&rng);
        assert_int_equal(nqm_interval_fit(&residuals, table, &c, NULL), NQM_OK);
        for (size_t i = 0; i < MAX; ++i) {
            double low, high;
            nqm_interval_at(NQM_INTERVAL_ROWS, table, predicted[i], &low, &high);
            inside[group[i]] += (double)(label[i] >= low && label[i] <= high) / PAIRS_EACH;
        }
        for (size_t g = 0; g < N_MATERIALS; ++g)
            mean += inside[g] / N_MATERIALS;
        for (size_t g = 0; g < N_MATERIALS; ++g)
            squares += pow(inside[g] - mean, 2);
        mean_margin += (mean - 1.7139 * sqrt(squares / (N_MATERIALS * (N_MATERIALS - 1.0))) - 0.95) / N_REPEATS;
    }
    assert_near(mean_margin, 0.0137, 0.0015);
}

/* A material that no other resembles: without it the factor is small, and it is outside. With it the factor must
 * include most of it: 23 of 24 materials are not enough. */
TEST(coverage_leaves_the_material_out) {
    nqm_rng rng = nqm_rng_make(14, 0);
    double table[3 * NQM_INTERVAL_ROWS], n_inside = 0;
    nqm_calibration c;
    draw_residuals(&rng);
    for (size_t i = 0; i < PAIRS_EACH; ++i) {
        predicted[i] = 9.5 + 0.4 * (double)i / PAIRS_EACH;
        label[i] = 0;
    }
    assert_int_equal(nqm_interval_fit(&residuals, table, &c, NULL), NQM_OK);
    for (size_t i = 0; i < PAIRS_EACH; ++i) {
        double low, high;
        nqm_interval_at(NQM_INTERVAL_ROWS, table, predicted[i], &low, &high);
        n_inside += label[i] >= low && label[i] <= high;
    }
    assert_true(c.coverage_lowest == 0 && n_inside > 0.5 * PAIRS_EACH);
}

TEST(few_are_refused) {
    nqm_rng rng = nqm_rng_make(11, 0);
    double table[3 * NQM_INTERVAL_ROWS];
    nqm_calibration c;
    size_t n_materials;
    draw_residuals(&rng);
    nqm_residuals few = residuals;
    few.n = (NQM_CALIBRATION_MIN_MATERIALS - 1) * PAIRS_EACH;
    assert_false(nqm_residuals_suffice(&few, &n_materials));
    assert_int_equal(n_materials, NQM_CALIBRATION_MIN_MATERIALS - 1);
    assert_int_equal(nqm_interval_fit(&few, table, &c, NULL), NQM_ERR_INCOMPATIBLE);
    few.n = NQM_CALIBRATION_MIN_MATERIALS * PAIRS_EACH;
    assert_int_equal(nqm_interval_fit(&few, table, &c, NULL), NQM_OK);
}
