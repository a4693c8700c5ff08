/* SPDX-License-Identifier: MIT
 *
 * Derivatives of metrics and scalar features against central differences, in double. The library reads float samples, too
 * coarse for differences, so the features are written here once more from the table of doc/training.md.
 */
#include "metric/scaled.h"
#include "metric/sums.h"
#include "support/check.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* More than two stretches, the last one incomplete. */
enum { N = 150, N_VALUES = 3 * N, N_FEATURES = NQM_SCALAR_ESTIMATE };

static nqm_directions *directions;

static int make_directions(void **state) {
    (void)state;
    double hd[3 * N];
    for (size_t i = 0; i < N; ++i) {
        hd[3 * i] = 80 * pow((double)(i % 30) / 30, 2);
        hd[3 * i + 1] = 85 * (double)(i / 30) / 5 + 0.1 * (double)(i % 7);
        hd[3 * i + 2] = (double)(i * 37 % 180);
    }
    assert_int_equal(nqm_directions_from_degrees(N, hd, &directions, NULL), NQM_OK);
    return 0;
}

static int free_directions(void **state) {
    (void)state;
    nqm_directions_free(directions);
    return 0;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

typedef struct gradient_pair {
    float ref[N_VALUES], test[N_VALUES];
    uint8_t used[N];
} gradient_pair;

static double random_unit(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) / 9007199254740992.0;
}

/* A diffuse part and a lobe; in no direction and channel equal to the test, and the luminance is not either, since
 * differences across a kink have no meaning. Direction `largest` differs most and is the brightest of the test. */
static gradient_pair make_pair(uint64_t seed, double strength, size_t largest) {
    gradient_pair p;
    for (size_t i = 0; i < N; ++i) {
        const double lobe = exp(-0.05 * directions->degrees[3 * i]), sign = random_unit(&seed) < 0.5 ? -1 : 1;
        for (size_t k = 0; k < 3; ++k) {
            const double f = 0.02 + 0.03 * (double)k + (1 + random_unit(&seed)) * lobe;
            /* Blue differs the other way in every fifth direction. */
            const double way = k == 2 && i % 5 == 0 ? -sign : sign;
            const double by = strength * way * (0.3 + random_unit(&seed));
            p.ref[3 * i + k] = (float)f;
            p.test[3 * i + k] = (float)(i == largest ? f * exp(4 * strength) + 3 : f * exp(by));
        }
        p.used[i] = 1;
    }
    return p;
}

/* ---- the features in plain double -------------------------------------------------------------------------------- */

static const double luminance_of[3] = {0.2126, 0.7152, 0.0722}, channel[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const double dark = 0.003;

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double size(double x) {
    return log(x + 0.001);
}

/* Weighted mean of abs(x)^power, 0 for no direction. */
static double mean_power(const double *weight, const double *x, double power) {
    double sum = 0, n = 0;
    for (size_t i = 0; i < N; ++i) {
        sum += weight[i] * pow(fabs(x[i]), power);
        n += weight[i];
    }
    return n > 0 ? sum / n : 0;
}

static double mean(const double *weight, const double *x) {
    double sum = 0, n = 0;
    for (size_t i = 0; i < N; ++i) {
        sum += weight[i] * x[i];
        n += weight[i];
    }
    return n > 0 ? sum / n : 0;
}

/* Log ratio of the weighted means of `of` . f_r. */
static double ratio(const double *weight, const double *of, const double *f, const double *g) {
    double a[N], b[N];
    for (size_t i = 0; i < N; ++i) {
        a[i] = dot(of, f + 3 * i);
        b[i] = dot(of, g + 3 * i);
    }
    return log((mean(weight, b) + dark) / (mean(weight, a) + dark));
}

static void opponents(const double *d, double *u, double *v) {
    *u = d[0] - d[1];
    *v = d[2] - (d[0] + d[1]) / 2;
}

static void opponents_of_ratio(const double *weight, const double *f, const double *g, double *u, double *v) {
    double d[3];
    for (size_t k = 0; k < 3; ++k)
        d[k] = ratio(weight, channel[k], f, g);
    opponents(d, u, v);
}

static void metrics_of(const double *f, const double *g, const uint8_t *used, double *metrics) {
    double sum[NQM_METRIC_COUNT] = {0}, n = 0;
    for (size_t i = 0; i < N_VALUES; ++i) {
        if (!used[i / 3])
            continue;
        const double c = directions->cosines[i / 3], a = f[i], b = g[i];
        const double by[5] = {b - a, cbrt(c * b) - cbrt(c * a), log1p(b) - log1p(a), log1p(c * b) - log1p(c * a),
                              log(b + dark) - log(a + dark)};
        for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
            sum[m] += m % 2 == 0 && m < 8 ? by[m / 2] * by[m / 2] : fabs(by[m / 2]);
        n += 1;
    }
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        metrics[m] = m % 2 == 0 && m < 8 ? sqrt(sum[m] / n) : sum[m] / n;
}

/* Weights of the directions with theta_h and theta_d in a range. */
static void select_directions(const uint8_t *used, const double *h, const double *d, double *weight) {
    for (size_t i = 0; i < N; ++i) {
        const double *at = directions->degrees + 3 * i;
        weight[i] = used[i] && at[0] >= h[0] && at[0] < h[1] && at[1] >= d[0] && at[1] < d[1];
    }
}

static void zones_of(const double *f, const double *g, const uint8_t *used, const double *l, double *x) {
    static const double h[] = {0, 2, 5, 15, 35, 91}, d[] = {0, 30, 60, 91}, all[] = {0, 91};
    double weight[N], n_all = 0, l2 = 0, uv2 = 0;
    for (size_t z = 0; z < 5; ++z) {
        select_directions(used, h + z, all, weight);
        x[NQM_SCALAR_ZONE_BIAS + z] = ratio(weight, luminance_of, f, g);
        x[NQM_SCALAR_ZONE_RMS + z] = size(sqrt(mean_power(weight, l, 2)));
        for (size_t y = 0; y < 3; ++y) {
            double n = 0, u, v;
            select_directions(used, h + z, d + y, weight);
            for (size_t i = 0; i < N; ++i)
                n += weight[i];
            opponents_of_ratio(weight, f, g, &u, &v);
            l2 += n * pow(ratio(weight, luminance_of, f, g), 2);
            uv2 += n * (u * u + v * v);
            n_all += n;
        }
    }
    x[NQM_SCALAR_SMOOTH] = size(sqrt(l2 / n_all));
    x[NQM_SCALAR_SMOOTH_CHROMA] = size(sqrt(uv2 / n_all));
    select_directions(used, (const double[]){0, 5}, all, weight);
    x[NQM_SCALAR_WIDTH] = ratio(weight, luminance_of, f, g);
    select_directions(used, (const double[]){5, 91}, all, weight);
    x[NQM_SCALAR_WIDTH] -= ratio(weight, luminance_of, f, g);
}

static void reference_of(const double *f, const double *weight, const double *cosines, double *x) {
    double log_y[N], y[N], chroma[N], peak = 0, u, v;
    for (size_t i = 0; i < N; ++i) {
        y[i] = dot(luminance_of, f + 3 * i);
        log_y[i] = log(y[i] + dark);
        opponents((const double[]){log(f[3 * i] + dark), log(f[3 * i + 1] + dark), log(f[3 * i + 2] + dark)}, &u, &v);
        chroma[i] = hypot(u, v);
        peak = fmax(peak, weight[i] * y[i]);
    }
    const double level = mean(weight, log_y);
    x[NQM_SCALAR_REF_LEVEL] = level;
    x[NQM_SCALAR_REF_ENERGY] = log(mean(cosines, y) + dark);
    x[NQM_SCALAR_REF_PEAK] = log(peak + dark) - level;
    x[NQM_SCALAR_REF_SPREAD] = sqrt(mean_power(weight, log_y, 2) - level * level);
    x[NQM_SCALAR_REF_COLOUR] = sqrt(mean_power(weight, chroma, 2));
}

/* x (N_FEATURES) */
static void features_of(const double *f, const double *g, const uint8_t *used, double *x) {
    double weight[N], grazing[N], cosines[N], l[N], of_l[N], d2[N], u[N], v[N], chroma[N];
    double metrics[NQM_METRIC_COUNT], largest = 0, peak[2] = {0}, energy_u, energy_v;
    for (size_t i = 0; i < N; ++i) {
        double d[3];
        for (size_t k = 0; k < 3; ++k)
            d[k] = log(g[3 * i + k] + dark) - log(f[3 * i + k] + dark);
        const double y[2] = {dot(luminance_of, f + 3 * i), dot(luminance_of, g + 3 * i)};
        weight[i] = used[i];
        grazing[i] = used[i] && directions->cosines[i] < 0.25;
        cosines[i] = used[i] ? directions->cosines[i] : 0;
        l[i] = log(y[1] + dark) - log(y[0] + dark);
        d2[i] = dot(d, d) / 3;
        opponents(d, &u[i], &v[i]);
        chroma[i] = hypot(u[i], v[i]);
        largest = fmax(largest, weight[i] * fabs(l[i]));
        for (size_t k = 0; k < 2; ++k)
            peak[k] = fmax(peak[k], weight[i] * y[k]);
    }
    metrics_of(f, g, used, metrics);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        x[m] = log(metrics[m] + 0.0001);
    const double bias = mean(weight, l);
    for (size_t i = 0; i < N; ++i)
        of_l[i] = l[i] - bias;
    x[NQM_SCALAR_RMS] = size(sqrt(mean(weight, d2)));
    x[NQM_SCALAR_MAX] = size(largest);
    x[NQM_SCALAR_TAIL] = size(pow(mean_power(weight, l, 4), 0.25));
    x[NQM_SCALAR_BULK] = size(pow(mean_power(weight, l, 0.5), 2));
    x[NQM_SCALAR_BIAS] = bias;
    x[NQM_SCALAR_SHAPE] = size(sqrt(mean_power(weight, of_l, 2)));
    x[NQM_SCALAR_GRAZING_BIAS] = mean(grazing, l);
    x[NQM_SCALAR_GRAZING_RMS] = size(sqrt(mean_power(grazing, l, 2)));
    x[NQM_SCALAR_CHROMA] = size(sqrt(mean_power(weight, chroma, 2)));
    x[NQM_SCALAR_CHROMA_RG] = mean(weight, u);
    x[NQM_SCALAR_CHROMA_B] = mean(weight, v);
    opponents_of_ratio(cosines, f, g, &energy_u, &energy_v);
    x[NQM_SCALAR_ENERGY] = ratio(cosines, luminance_of, f, g);
    x[NQM_SCALAR_ENERGY_CHROMA] = size(hypot(energy_u, energy_v));
    x[NQM_SCALAR_PEAK] = log((peak[1] + dark) / (peak[0] + dark));
    zones_of(f, g, used, l, x);
    reference_of(f, weight, cosines, x);
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

static void to_double(const float *from, double *to) {
    for (size_t i = 0; i < N_VALUES; ++i)
        to[i] = (double)from[i];
}

/* (N_FEATURES, N_VALUES) */
typedef double feature_gradients[N_FEATURES][N_VALUES];

/* Central differences of order 4. */
static void differentiate(const gradient_pair *p, feature_gradients gradients) {
    double f[N_VALUES], g[N_VALUES], x[4][N_FEATURES];
    static const double steps[4] = {-2, -1, 1, 2};
    to_double(p->ref, f);
    to_double(p->test, g);
    for (size_t i = 0; i < N_VALUES; ++i) {
        const double at = g[i], h = 1e-4 * (at + dark);
        for (size_t k = 0; k < 4; ++k) {
            g[i] = at + steps[k] * h;
            features_of(f, g, p->used, x[k]);
        }
        for (size_t j = 0; j < N_FEATURES; ++j)
            gradients[j][i] = (8 * (x[2][j] - x[1][j]) - (x[3][j] - x[0][j])) / (12 * h);
        g[i] = at;
    }
}

static void one_gradient(const gradient_pair *p, size_t feature, double *gradient) {
    double weights[NQM_SCALAR_COUNT] = {0};
    weights[feature] = 1;
    nqm_scalars_gradient(directions, p->ref, p->test, p->used, weights, gradient);
}

/* Within 1e-6 of the largest entry. */
static void assert_gradient(const double *gradient, const double *expected, const char *name) {
    double largest = 0;
    for (size_t i = 0; i < N_VALUES; ++i)
        largest = fmax(largest, fabs(expected[i]));
    for (size_t i = 0; i < N_VALUES; ++i)
        if (!(fabs(gradient[i] - expected[i]) <= 1e-6 * largest))
            fail_msg("%s by %zu: %.12g, not %.12g; largest %g", name, i, gradient[i], expected[i], largest);
}

static void check_pair(const gradient_pair *p) {
    static feature_gradients expected;
    double f[N_VALUES], g[N_VALUES], x[N_FEATURES], scalars[NQM_SCALAR_COUNT], gradient[N_VALUES];
    to_double(p->ref, f);
    to_double(p->test, g);
    features_of(f, g, p->used, x);
    nqm_scalars_compute(directions, NULL, p->ref, p->test, p->used, scalars);
    for (size_t j = 0; j < N_FEATURES; ++j)
        check_near(scalars[j], x[j], 1e-10, nqm_scalar_name(j), __FILE__, __LINE__);
    differentiate(p, expected);
    for (size_t j = 0; j < N_FEATURES; ++j) {
        one_gradient(p, j, gradient);
        assert_gradient(gradient, expected[j], nqm_scalar_name(j));
    }
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) { /* d metric = (metric + 0.0001) d log(metric + 0.0001) */
        double weights[NQM_METRIC_COUNT] = {0};
        weights[m] = 1 / exp(x[m]);
        nqm_metrics_gradient(directions, p->ref, p->test, p->used, weights, gradient);
        assert_gradient(gradient, expected[m], nqm_metric_name((nqm_metric)m));
    }
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void ordinary_pairs(void **state) {
    (void)state;
    static const double strengths[] = {0.02, 0.2, 1};
    for (size_t k = 0; k < 3; ++k) {
        const gradient_pair p = make_pair(k + 1, strengths[k], 40 + 30 * k);
        check_pair(&p);
    }
}

static void unused_directions(void **state) {
    (void)state;
    gradient_pair p = make_pair(4, 0.3, 70);
    for (size_t i = 0; i < N; ++i)
        p.used[i] = i % 3 != 0 && directions->degrees[3 * i] >= 2; /* the first zone is empty */
    check_pair(&p);
    double weights[NQM_SCALAR_COUNT], gradient[N_VALUES], changed[N_VALUES];
    for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = 1;
    nqm_scalars_gradient(directions, p.ref, p.test, p.used, weights, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        if (!p.used[i / 3]) {
            assert_true(gradient[i] == 0);
            p.test[i] = 1e6f;
        }
    nqm_scalars_gradient(directions, p.ref, p.test, p.used, weights, changed);
    assert_memory_equal(gradient, changed, sizeof gradient);
    memset(p.used, 0, sizeof p.used);
    nqm_scalars_gradient(directions, p.ref, p.test, p.used, weights, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_true(gradient[i] == 0);
}

/* All features but those of cube roots continue smoothly below 0, so that differences around 0 are those from the right. */
static void zero_reflectance(void **state) {
    (void)state;
    static feature_gradients expected;
    gradient_pair p = make_pair(5, 0.4, 20);
    for (size_t i = 0; i < N; i += 4)
        for (size_t k = 0; k < 1 + i % 3; ++k)
            p.test[3 * i + k] = 0;
    differentiate(&p, expected);
    double gradient[N_VALUES], metrics[NQM_METRIC_COUNT], n = N_VALUES;
    for (size_t j = 0; j < N_FEATURES; ++j) {
        if (j == NQM_METRIC_RMS_CRWE || j == NQM_METRIC_MA_CRWE)
            continue;
        one_gradient(&p, j, gradient);
        assert_gradient(gradient, expected[j], nqm_scalar_name(j));
    }
    nqm_metrics_compute(directions, p.ref, p.test, p.used, metrics);
    for (size_t m = NQM_METRIC_RMS_CRWE; m <= NQM_METRIC_MA_CRWE; ++m) {
        double weights[NQM_METRIC_COUNT] = {0};
        weights[m] = 1;
        nqm_metrics_gradient(directions, p.ref, p.test, p.used, weights, gradient);
        for (size_t i = 0; i < N_VALUES; ++i) {
            const double c = directions->cosines[i / 3], slope = c / (3 * 1e-6); /* of the cube root at 1e-9 */
            const double by = m == NQM_METRIC_MA_CRWE ? -1 / n : -cbrt(c * (double)p.ref[i]) / (n * metrics[m]);
            if (p.test[i] <= 0)
                assert_relative(gradient[i], by * slope, 1e-12);
        }
    }
}

/* Signed features have derivatives at equal pairs; those of sizes are 0. */
static void equal_pair(void **state) {
    (void)state;
    static feature_gradients expected;
    gradient_pair p = make_pair(6, 0.4, 20);
    p.test[60] *= 1.1f;
    memcpy(p.ref, p.test, sizeof p.ref);
    differentiate(&p, expected);
    double gradient[N_VALUES];
    for (size_t j = 0; j < N_FEATURES; ++j) {
        const bool is_signed = j == NQM_SCALAR_BIAS || j == NQM_SCALAR_GRAZING_BIAS || j == NQM_SCALAR_WIDTH ||
                               j == NQM_SCALAR_CHROMA_RG || j == NQM_SCALAR_CHROMA_B || j == NQM_SCALAR_ENERGY ||
                               j == NQM_SCALAR_PEAK || (j >= NQM_SCALAR_ZONE_BIAS && j < NQM_SCALAR_ZONE_RMS);
        one_gradient(&p, j, gradient);
        if (is_signed)
            assert_gradient(gradient, expected[j], nqm_scalar_name(j));
        else
            for (size_t i = 0; i < N_VALUES; ++i)
                assert_true(gradient[i] == 0);
    }
}

/* Which directions have derivatives of a maximum. */
static void assert_only_direction(const gradient_pair *p, size_t feature, size_t direction) {
    double gradient[N_VALUES];
    one_gradient(p, feature, gradient);
    for (size_t i = 0; i < N_VALUES; ++i)
        assert_true((gradient[i] != 0) == (i / 3 == direction));
}

static void maxima(void **state) {
    (void)state;
    gradient_pair p = make_pair(7, 0.1, 100);
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 100);
    for (size_t k = 0; k < 3; ++k) { /* a second direction attains both, in an earlier stretch */
        p.ref[3 * 10 + k] = p.ref[3 * 100 + k];
        p.test[3 * 10 + k] = p.test[3 * 100 + k];
    }
    assert_only_direction(&p, NQM_SCALAR_MAX, 10);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 10);
    p.used[10] = 0;
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    p.used[10] = 1;
    for (size_t k = 0; k < 3; ++k)
        p.test[3 * 10 + k] *= 1.01f;
    check_pair(&p);
    for (size_t k = 0; k < 3; ++k)
        p.test[3 * 10 + k] *= 0.98f; /* the maximum switches */
    assert_only_direction(&p, NQM_SCALAR_MAX, 100);
    check_pair(&p);
    memset(p.test, 0, sizeof p.test);
    assert_only_direction(&p, NQM_SCALAR_PEAK, 0);
}

static void extremes(void **state) {
    (void)state;
    static const float values[] = {0, FLT_TRUE_MIN, 1e-20f, 1e-9f, 1, 1e20f, FLT_MAX};
    gradient_pair p = make_pair(8, 0.1, 100);
    double weights[NQM_SCALAR_COUNT], gradient[N_VALUES];
    for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
        weights[j] = 1;
    for (size_t k = 0; k < 49; ++k) {
        for (size_t i = 0; i < N_VALUES; ++i) {
            p.ref[i] = values[k / 7];
            p.test[i] = i % 2 ? values[k % 7] : values[k / 7];
        }
        nqm_scalars_gradient(directions, p.ref, p.test, p.used, weights, gradient);
        for (size_t i = 0; i < N_VALUES; ++i)
            if (!isfinite(gradient[i]))
                fail_msg("%g at %g: %g", (double)p.test[i], (double)p.ref[i], gradient[i]);
    }
}

/* One call for several tests gives what one call each gives, and features of the caller do not matter. */
static void several_tests(void **state) {
    (void)state;
    enum { N_TESTS = 3 };
    gradient_pair p[N_TESTS];
    const float *tests[N_TESTS];
    uint8_t used[N_TESTS][N];
    double weights[N_TESTS][NQM_SCALAR_COUNT], together[N_TESTS][N_VALUES], alone[N_VALUES];
    uint64_t seed = 9;
    for (size_t k = 0; k < N_TESTS; ++k) {
        p[k] = make_pair(10 + k, 0.2, k);
        p[k].used[50 + k] = 0;
        tests[k] = p[k].test;
        memcpy(used[k], p[k].used, N);
        for (size_t j = 0; j < NQM_SCALAR_COUNT; ++j)
            weights[k][j] = random_unit(&seed) - 0.5;
    }
    const nqm_comparison comparison = {directions, p[0].ref, N_TESTS, tests, used[0], NULL};
    nqm_pair_sums sums[N_TESTS];
    nqm_compare_sums(&comparison, true, sums);
    nqm_compare_gradient(&comparison, sums, NULL, weights[0], together[0]);
    for (size_t k = 0; k < N_TESTS; ++k) {
        for (size_t j = NQM_SCALAR_ESTIMATE; j < NQM_SCALAR_COUNT; ++j)
            weights[k][j] = 1e6;
        memset(alone, 0xff, sizeof alone);
        nqm_scalars_gradient(directions, p[0].ref, tests[k], used[k], weights[k], alone);
        assert_memory_equal(alone, together[k], sizeof alone);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ordinary_pairs),   cmocka_unit_test(unused_directions),
        cmocka_unit_test(zero_reflectance), cmocka_unit_test(equal_pair),
        cmocka_unit_test(maxima),           cmocka_unit_test(extremes),
        cmocka_unit_test(several_tests),
    };
    return cmocka_run_group_tests(tests, make_directions, free_directions);
}
