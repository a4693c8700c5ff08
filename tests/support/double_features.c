/* SPDX-License-Identifier: MIT
 *
 * The features are written here once more, from the table of doc/training.md.
 */
#include "support/double_features.h"
#include "metric/sums.h"
#include "support/check.h"

#include <math.h>
#include <string.h>

enum { N = DOUBLE_N, MOST = 320 };

nqm_directions *directions;

int make_double_directions(void **state) {
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

int free_double_directions(void **state) {
    (void)state;
    nqm_directions_free(directions);
    return 0;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

double random_unit(uint64_t *seed) {
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) / 9007199254740992.0;
}

gradient_pair make_pair(uint64_t seed, double strength, size_t largest) {
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
    for (size_t i = 0; i < directions->n; ++i) {
        sum += weight[i] * pow(fabs(x[i]), power);
        n += weight[i];
    }
    return n > 0 ? sum / n : 0;
}

static double mean(const double *weight, const double *x) {
    double sum = 0, n = 0;
    for (size_t i = 0; i < directions->n; ++i) {
        sum += weight[i] * x[i];
        n += weight[i];
    }
    return n > 0 ? sum / n : 0;
}

/* Log ratio of the weighted means of `of` . f_r. */
static double ratio(const double *weight, const double *of, const double *f, const double *g) {
    double a[MOST], b[MOST];
    for (size_t i = 0; i < directions->n; ++i) {
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
    for (size_t i = 0; i < 3 * directions->n; ++i) {
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
    for (size_t i = 0; i < directions->n; ++i) {
        const double *at = directions->degrees + 3 * i;
        weight[i] = used[i] && at[0] >= h[0] && at[0] < h[1] && at[1] >= d[0] && at[1] < d[1];
    }
}

static void zones_of(const double *f, const double *g, const uint8_t *used, const double *l, double *x) {
    static const double h[] = {0, 2, 5, 15, 35, 91}, d[] = {0, 30, 60, 91}, all[] = {0, 91};
    double weight[MOST], n_all = 0, l2 = 0, uv2 = 0;
    for (size_t z = 0; z < 5; ++z) {
        select_directions(used, h + z, all, weight);
        x[NQM_SCALAR_ZONE_BIAS + z] = ratio(weight, luminance_of, f, g);
        x[NQM_SCALAR_ZONE_RMS + z] = size(sqrt(mean_power(weight, l, 2)));
        for (size_t y = 0; y < 3; ++y) {
            double n = 0, u, v;
            select_directions(used, h + z, d + y, weight);
            for (size_t i = 0; i < directions->n; ++i)
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
    double log_y[MOST], y[MOST], chroma[MOST], peak = 0, u, v;
    for (size_t i = 0; i < directions->n; ++i) {
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

void features_of(const double *f, const double *g, const uint8_t *used, double *x) {
    double weight[MOST], grazing[MOST], cosines[MOST], l[MOST], of_l[MOST], d2[MOST], u[MOST], v[MOST], chroma[MOST];
    double metrics[NQM_METRIC_COUNT], largest = 0, peak[2] = {0}, energy_u, energy_v;
    for (size_t i = 0; i < directions->n; ++i) {
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
    for (size_t i = 0; i < directions->n; ++i)
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

void to_double(const float *from, double *to) {
    for (size_t i = 0; i < 3 * directions->n; ++i)
        to[i] = (double)from[i];
}
