/* SPDX-License-Identifier: MIT
 *
 * Scalar features of a pair: statistics of how much two sampled BRDFs differ, where (highlight, flank, grazing), how
 * (level, shape, colour), and of the reference itself. They follow the samples in the network's input (recipe nqm) and
 * are the input of the boosted-trees control (models/control.py). doc/training.md has the table of formulas.
 *
 * An image averages reflectance over many directions, so that random differences between directions are less visible
 * than systematic ones. Therefore some features compare sums over zones of directions, others single directions.
 */
#include "math/math.h"
#include "metric/scaled.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- sums over directions ---------------------------------------------------------------------------------------- */

/* Upper ends of the zones of theta_h and theta_d, degrees. A cell is one theta_h zone and one theta_d zone. */
enum { N_ZONES_H = NQM_SCALAR_ZONES, N_ZONES_D = 3, N_CELLS = N_ZONES_H * N_ZONES_D };
static const double zone_h_end[N_ZONES_H - 1] = {2, 5, 15, 35}, zone_d_end[N_ZONES_D - 1] = {30, 60};

/* Upper limit of cos(theta_i) cos(theta_o) for grazing directions: theta_d = 60 degrees at theta_h = 0. */
static const double grazing_cosines = 0.25;

/* Sum of the reflectance of both members over a set of directions; n: number of directions, or sum of weights. */
typedef struct light {
    double n, ref[3], test[3];
} light;

/* Sums over directions. l: difference of log luminance; u, v: differences of the opponent channels of log f_r. */
typedef struct sums {
    double n, l, l2, l4, root_l, max_l, squares, u, v, uv2;
    double zone_l2[N_ZONES_H], grazing_n, grazing_l, grazing_l2;
    double ref_log, ref_log2, ref_colour2, peak_ref, peak_test;
    light cell[N_CELLS];
    light weighted; /* by cos(theta_i) cos(theta_o) */
} sums;

static size_t zone_of(double degrees, size_t n_ends, const double *ends) {
    size_t zone = 0;
    while (zone < n_ends && degrees >= ends[zone])
        ++zone;
    return zone;
}

static void add_light(light *to, double weight, const double *ref, const double *test) {
    to->n += weight;
    for (int k = 0; k < 3; ++k) {
        to->ref[k] += weight * ref[k];
        to->test[k] += weight * test[k];
    }
}

/* Add direction i of a stretch. */
static void add_direction(sums *s, const double *degrees, double cosines, const nqm_scaled *ref, const nqm_scaled *test,
                          size_t i) {
    const double *a = ref->scale[NQM_SCALE_LOG_F] + 3 * i, *b = test->scale[NQM_SCALE_LOG_F] + 3 * i;
    const double *f = ref->scale[NQM_SCALE_F] + 3 * i, *g = test->scale[NQM_SCALE_F] + 3 * i;
    double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    double ref_log = ref->log_luminance[i], l = test->log_luminance[i] - ref_log;
    double u = d[0] - d[1], v = d[2] - 0.5 * (d[0] + d[1]), ref_u = a[0] - a[1], ref_v = a[2] - 0.5 * (a[0] + a[1]);
    size_t zone_h = zone_of(degrees[0], N_ZONES_H - 1, zone_h_end);
    size_t zone_d = zone_of(degrees[1], N_ZONES_D - 1, zone_d_end);
    s->peak_ref = fmax(s->peak_ref, ref->luminance[i]);
    s->peak_test = fmax(s->peak_test, test->luminance[i]);
    s->n += 1;
    s->l += l;
    s->l2 += l * l;
    s->l4 += l * l * l * l;
    s->root_l += sqrt(fabs(l));
    s->max_l = fmax(s->max_l, fabs(l));
    s->squares += d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    s->u += u;
    s->v += v;
    s->uv2 += u * u + v * v;
    s->zone_l2[zone_h] += l * l;
    if (cosines < grazing_cosines) {
        s->grazing_n += 1;
        s->grazing_l += l;
        s->grazing_l2 += l * l;
    }
    s->ref_log += ref_log;
    s->ref_log2 += ref_log * ref_log;
    s->ref_colour2 += ref_u * ref_u + ref_v * ref_v;
    add_light(&s->cell[zone_h * N_ZONES_D + zone_d], 1, f, g);
    add_light(&s->weighted, cosines, f, g);
}

/* ---- from sums to features --------------------------------------------------------------------------------------- */

/* Logarithm of a size >= 0, which resolves small differences; the offset keeps it finite at 0. */
static double log_size(double size) {
    return log(size + 1e-3);
}

static double mean(double sum, double n) {
    return n > 0 ? sum / n : 0;
}

/* Difference of summed reflectance. l: log ratio of luminance; u, v: opponent channels of the log ratios of RGB. */
typedef struct contrast {
    double l, u, v;
} contrast;

static contrast compare_light(const light *sum) {
    double ratio[3], floor = NQM_DARK * sum->n;
    if (!(sum->n > 0))
        return (contrast){0};
    for (int k = 0; k < 3; ++k)
        ratio[k] = log((sum->test[k] + floor) / (sum->ref[k] + floor));
    return (contrast){.l = log((nqm_luminance(sum->test) + floor) / (nqm_luminance(sum->ref) + floor)),
                      .u = ratio[0] - ratio[1],
                      .v = ratio[2] - 0.5 * (ratio[0] + ratio[1])};
}

static light join(const light *parts, size_t n) {
    light whole = {0};
    for (size_t i = 0; i < n; ++i) {
        whole.n += parts[i].n;
        for (int k = 0; k < 3; ++k) {
            whole.ref[k] += parts[i].ref[k];
            whole.test[k] += parts[i].test[k];
        }
    }
    return whole;
}

static void zone_scalars(const sums *s, double *out) {
    for (size_t z = 0; z < N_ZONES_H; ++z) {
        light zone = join(s->cell + z * N_ZONES_D, N_ZONES_D);
        out[NQM_SCALAR_ZONE_BIAS + z] = compare_light(&zone).l;
        out[NQM_SCALAR_ZONE_RMS + z] = log_size(sqrt(mean(s->zone_l2[z], zone.n)));
    }
    light highlight = join(s->cell, 2 * N_ZONES_D), flank = join(s->cell + 2 * N_ZONES_D, N_CELLS - 2 * N_ZONES_D);
    out[NQM_SCALAR_WIDTH] = compare_light(&highlight).l - compare_light(&flank).l;
    out[NQM_SCALAR_GRAZING_BIAS] = mean(s->grazing_l, s->grazing_n);
    out[NQM_SCALAR_GRAZING_RMS] = log_size(sqrt(mean(s->grazing_l2, s->grazing_n)));
    double l2 = 0, uv2 = 0;
    for (size_t i = 0; i < N_CELLS; ++i) {
        contrast c = compare_light(&s->cell[i]);
        l2 += s->cell[i].n * c.l * c.l;
        uv2 += s->cell[i].n * (c.u * c.u + c.v * c.v);
    }
    out[NQM_SCALAR_SMOOTH] = log_size(sqrt(mean(l2, s->n)));
    out[NQM_SCALAR_SMOOTH_CHROMA] = log_size(sqrt(mean(uv2, s->n)));
}

static void whole_scalars(const sums *s, double *out) {
    double bias = mean(s->l, s->n), level = mean(s->ref_log, s->n);
    contrast energy = compare_light(&s->weighted);
    out[NQM_SCALAR_RMS] = log_size(sqrt(mean(s->squares, 3 * s->n)));
    out[NQM_SCALAR_MAX] = log_size(s->max_l);
    out[NQM_SCALAR_TAIL] = log_size(sqrt(sqrt(mean(s->l4, s->n))));
    out[NQM_SCALAR_BULK] = log_size(pow(mean(s->root_l, s->n), 2));
    out[NQM_SCALAR_BIAS] = bias;
    out[NQM_SCALAR_SHAPE] = log_size(sqrt(fmax(mean(s->l2, s->n) - bias * bias, 0)));
    out[NQM_SCALAR_CHROMA] = log_size(sqrt(mean(s->uv2, s->n)));
    out[NQM_SCALAR_CHROMA_RG] = mean(s->u, s->n);
    out[NQM_SCALAR_CHROMA_B] = mean(s->v, s->n);
    out[NQM_SCALAR_ENERGY] = energy.l;
    out[NQM_SCALAR_ENERGY_CHROMA] = log_size(hypot(energy.u, energy.v));
    out[NQM_SCALAR_PEAK] = log((s->peak_test + NQM_DARK) / (s->peak_ref + NQM_DARK));
    out[NQM_SCALAR_REF_LEVEL] = level;
    out[NQM_SCALAR_REF_ENERGY] = log(mean(nqm_luminance(s->weighted.ref), s->weighted.n) + NQM_DARK);
    out[NQM_SCALAR_REF_PEAK] = log(s->peak_ref + NQM_DARK) - level;
    out[NQM_SCALAR_REF_SPREAD] = sqrt(fmax(mean(s->ref_log2, s->n) - level * level, 0));
    out[NQM_SCALAR_REF_COLOUR] = sqrt(mean(s->ref_colour2, s->n));
}

static void finish_scalars(const sums *s, const double *metrics, const nqm_label *estimate, double *scalars) {
    nqm_estimate_targets(estimate, scalars + NQM_SCALAR_ESTIMATE);
    for (size_t m = 0; m < NQM_SCALAR_RMS; ++m)
        scalars[NQM_SCALAR_METRICS + m] = log(metrics[m] + 1e-4);
    whole_scalars(s, scalars);
    zone_scalars(s, scalars);
    for (size_t i = 0; !(s->n > 0) && i < NQM_SCALAR_COUNT; ++i)
        scalars[i] = NAN;
}

/* ---- comparisons ------------------------------------------------------------------------------------------------- */

/* Sums of one test and its reference. */
typedef struct pair_sums {
    nqm_metric_sums metrics;
    sums scalars;
} pair_sums;

/* Add one stretch of test k. */
static void add_stretch(const nqm_comparison *c, size_t k, size_t stretch, const nqm_scaled *ref, bool with_scalars,
                        pair_sums *to) {
    const nqm_directions *directions = c->directions;
    const size_t first = stretch * NQM_STRETCH, n = nqm_stretch_size(directions->n, stretch);
    const uint8_t *used = c->used ? c->used + k * directions->n + first : NULL;
    nqm_scaled test;
    double weight[3 * NQM_STRETCH] = {0};
    nqm_scale_stretch(directions, stretch, c->test[k], &test);
    for (size_t i = 0; i < 3 * n; ++i)
        weight[i] = !used || used[i / 3];
    nqm_metric_sums_add(&to->metrics, ref, &test, weight);
    for (size_t i = 0; with_scalars && i < n; ++i)
        if (weight[3 * i] > 0)
            add_direction(&to->scalars, directions->degrees + 3 * (first + i), directions->cosines[first + i], ref,
                          &test, i);
}

void nqm_compare_samples(const nqm_comparison *c, double *metrics, double *scalars) {
    pair_sums pair[NQM_COMPARE_MAX] = {0};
    for (size_t stretch = 0; stretch * NQM_STRETCH < c->directions->n; ++stretch) {
        nqm_scaled ref;
        nqm_scale_stretch(c->directions, stretch, c->ref, &ref);
        for (size_t k = 0; k < c->n; ++k)
            add_stretch(c, k, stretch, &ref, scalars != NULL, &pair[k]);
    }
    for (size_t k = 0; k < c->n; ++k) {
        double m[NQM_METRIC_COUNT];
        nqm_metric_sums_finish(&pair[k].metrics, m);
        if (metrics)
            memcpy(metrics + k * NQM_METRIC_COUNT, m, sizeof m);
        if (scalars)
            finish_scalars(&pair[k].scalars, m, c->estimate ? &c->estimate[k] : NULL, scalars + k * NQM_SCALAR_COUNT);
    }
}

void nqm_metrics_compute(const nqm_directions *directions, const float *ref, const float *test, const uint8_t *used,
                         double *metrics) {
    nqm_compare_samples(&(nqm_comparison){directions, ref, 1, &test, used, NULL}, metrics, NULL);
}

void nqm_scalars_compute(const nqm_directions *directions, const nqm_transport *transport, const float *ref,
                         const float *test, const uint8_t *used, double *scalars) {
    nqm_label estimate;
    const bool has_estimate = transport && transport->light;
    if (has_estimate)
        estimate = nqm_transport_estimate(transport, ref, test, used);
    nqm_compare_samples(&(nqm_comparison){directions, ref, 1, &test, used, has_estimate ? &estimate : NULL}, NULL,
                        scalars);
}
