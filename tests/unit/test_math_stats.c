/* SPDX-License-Identifier: MIT
 *
 * Ranks, correlations and quantiles against SciPy and NumPy (tests/vectors/stats.py; ties included), against the
 * definition of Kendall's tau over all pairs, and for input without variance.
 */
#include "io/io.h"
#include "math/math.h"
#include "support/check.h"

enum { MAX_POINTS = 2000 };

static double x[MAX_POINTS], y[MAX_POINTS], expected_rank[MAX_POINTS];

static double number(const nqm_csv *csv, size_t row, const char *column_name) {
    int column = nqm_csv_column(csv, column_name);
    assert_true(column >= 0);
    if (!*nqm_csv_text(csv, row, column))
        return NAN;
    double value;
    assert_int_equal(nqm_csv_number(csv, row, column, &value, NULL), NQM_OK);
    return value;
}

static size_t read_case(const nqm_csv *data, const char *name) {
    size_t n = 0;
    for (size_t row = 0; row < nqm_csv_rows(data); ++row) {
        if (strcmp(nqm_csv_text(data, row, 0), name) != 0)
            continue;
        assert_true(n < MAX_POINTS);
        x[n] = number(data, row, "x");
        y[n] = number(data, row, "y");
        expected_rank[n++] = number(data, row, "rank_x");
    }
    assert_true(n > 0);
    return n;
}

static void agree(double actual, double expected, const char *name) {
    if (isnan(actual) && isnan(expected))
        return;
    if (!(fabs(actual - expected) <= 1e-12 * fmax(1, fabs(expected))))
        fail_msg("%s: %.17g, expected %.17g", name, actual, expected);
}

TEST(test_against_scipy) {
    nqm_csv *data, *expected;
    assert_int_equal(nqm_csv_load(test_vector("stats_data.csv"), &data, NULL), NQM_OK);
    assert_int_equal(nqm_csv_load(test_vector("stats_expected.csv"), &expected, NULL), NQM_OK);
    assert_int_equal(nqm_csv_rows(expected), 10);
    for (size_t row = 0; row < nqm_csv_rows(expected); ++row) {
        const char *name = nqm_csv_text(expected, row, 0);
        size_t n = read_case(data, name);
        static double rank[MAX_POINTS];
        static nqm_indexed order[MAX_POINTS];
        nqm_ranks(n, x, rank, order);
        for (size_t i = 0; i < n; ++i)
            assert_near(rank[i], expected_rank[i], 0);
        agree(nqm_pearson(n, x, y), number(expected, row, "pearson"), name);
        agree(nqm_spearman(n, x, y), number(expected, row, "spearman"), name);
        agree(nqm_kendall(n, x, y), number(expected, row, "kendall"), name);
        agree(nqm_mean(n, x), number(expected, row, "mean_x"), name);
        agree(nqm_quantile(n, x, 0.025), number(expected, row, "q025_x"), name);
        agree(nqm_quantile(n, x, 0.5), number(expected, row, "q500_x"), name);
        agree(nqm_quantile(n, x, 0.9), number(expected, row, "q900_x"), name);
    }
    nqm_csv_free(data);
    nqm_csv_free(expected);
}

/* tau-b by its definition, over all pairs. */
static double kendall_by_pairs(size_t n) {
    double s = 0, n_x = 0, n_y = 0;
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < i; ++j) {
            double dx = (x[i] > x[j]) - (x[i] < x[j]), dy = (y[i] > y[j]) - (y[i] < y[j]);
            s += dx * dy;
            n_x += dx * dx;
            n_y += dy * dy;
        }
    return s / sqrt(n_x * n_y);
}

TEST(test_kendall_by_definition) {
    const uint64_t seed = 42;
    nqm_rng rng = nqm_rng_make(seed, 0);
    print_message("seed %d\n", (int)seed);
    for (size_t n = 3; n < 90; ++n) {
        for (size_t i = 0; i < n; ++i) {
            x[i] = (double)nqm_rng_below(&rng, 1 + n / 2);
            y[i] = n % 2 ? nqm_rng_uniform(&rng) : (double)nqm_rng_below(&rng, 4);
        }
        agree(nqm_kendall(n, x, y), kendall_by_pairs(n), "random");
    }
}

TEST(test_monotone_maps_keep_ranks) {
    nqm_rng rng = nqm_rng_make(3, 0);
    for (size_t i = 0; i < 500; ++i) {
        x[i] = nqm_rng_normal(&rng);
        y[i] = exp(x[i]);
    }
    assert_near(nqm_spearman(500, x, y), 1, 1e-15);
    assert_near(nqm_kendall(500, x, y), 1, 1e-15);
    assert_true(nqm_pearson(500, x, y) < 0.9);
}

TEST(test_nothing_to_correlate) {
    double same[4] = {0.1, 0.1, 0.1, 0.1}, some[4] = {1, 2, 3, 5}, hole[4] = {1, NAN, 3, 4};
    double (*const functions[])(size_t, const double *, const double *) = {nqm_pearson, nqm_spearman, nqm_kendall};
    for (size_t k = 0; k < 3; ++k) {
        assert_true(isnan(functions[k](4, same, some)));
        assert_true(isnan(functions[k](4, some, same)));
        assert_true(isnan(functions[k](4, some, hole)));
        assert_true(isnan(functions[k](1, some, some)));
        assert_true(isnan(functions[k](0, some, some)));
        assert_near(functions[k](4, some, some), 1, 1e-15);
    }
    assert_true(isnan(nqm_mean(0, some)));
    assert_true(isnan(nqm_quantile(0, some, 0.5)));
    assert_near(nqm_quantile(4, some, 1), 5, 0);
    assert_near(nqm_quantile(4, some, 0), 1, 0);
}

/* 5, 7, 11, 23 and 100 degrees of freedom: scipy.stats.t.ppf(.95, n). */
TEST(test_student) {
    assert_near(nqm_student95(5), 2.0150484, 0.01);
    assert_near(nqm_student95(7), 1.8945786, 0.0035);
    assert_near(nqm_student95(11), 1.7958848, 0.001);
    assert_near(nqm_student95(23), 1.7138715, 1e-4);
    assert_near(nqm_student95(100), 1.6602343, 2e-6);
}
