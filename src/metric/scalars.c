/* SPDX-License-Identifier: MIT
 *
 * Scalar features of a pair: statistics of how much two sampled BRDFs differ, where (highlight, flank, grazing), how
 * (level, shape, colour), and of the reference itself. They follow the samples in the network's input (recipe nqm) and
 * are the input of the boosted-trees control (studies/control.py). doc/training.md has the table of formulas.
 */
#include "math/math.h"
#include "metric/sums.h"

#include <math.h>
#include <string.h>

/* ---- sums of reflectance ----------------------------------------------------------------------------------------- */

nqm_light_ratio nqm_light_contrast(const nqm_light_sum *sum) {
    double ratio[3], floor = NQM_DARK * sum->n;
    if (!(sum->n > 0))
        return (nqm_light_ratio){0};
    for (int k = 0; k < 3; ++k)
        ratio[k] = log((sum->test[k] + floor) / (sum->ref[k] + floor));
    return (nqm_light_ratio){.l = log((nqm_luminance(sum->test) + floor) / (nqm_luminance(sum->ref) + floor)),
                             .u = ratio[0] - ratio[1],
                             .v = ratio[2] - 0.5 * (ratio[0] + ratio[1])};
}

nqm_light_sum nqm_lights_join(const nqm_light_sum *parts, size_t n) {
    nqm_light_sum whole = {0};
    for (size_t i = 0; i < n; ++i) {
        whole.n += parts[i].n;
        for (int k = 0; k < 3; ++k) {
            whole.ref[k] += parts[i].ref[k];
            whole.test[k] += parts[i].test[k];
        }
    }
    return whole;
}

/* ---- from sums to features --------------------------------------------------------------------------------------- */

/* Logarithm of a size >= 0, which resolves small differences. */
static double log_size(double size) {
    return log(size + NQM_SIZE_OFFSET);
}

static double mean(double sum, double n) {
    return n > 0 ? sum / n : 0;
}

static void zone_scalars(const nqm_scalar_sums *s, double *out) {
    for (size_t z = 0; z < NQM_ZONES_H; ++z) {
        nqm_light_sum zone = nqm_lights_join(s->cell + z * NQM_ZONES_D, NQM_ZONES_D);
        out[NQM_SCALAR_ZONE_BIAS + z] = nqm_light_contrast(&zone).l;
        out[NQM_SCALAR_ZONE_RMS + z] = log_size(sqrt(mean(s->zone_l2[z], zone.n)));
    }
    nqm_light_sum highlight = nqm_lights_join(s->cell, NQM_HIGHLIGHT_CELLS),
                  flank = nqm_lights_join(s->cell + NQM_HIGHLIGHT_CELLS, NQM_CELLS - NQM_HIGHLIGHT_CELLS);
    out[NQM_SCALAR_WIDTH] = nqm_light_contrast(&highlight).l - nqm_light_contrast(&flank).l;
    out[NQM_SCALAR_GRAZING_BIAS] = mean(s->grazing_l, s->grazing_n);
    out[NQM_SCALAR_GRAZING_RMS] = log_size(sqrt(mean(s->grazing_l2, s->grazing_n)));
    double l2 = 0, uv2 = 0;
    for (size_t i = 0; i < NQM_CELLS; ++i) {
        nqm_light_ratio c = nqm_light_contrast(&s->cell[i]);
        l2 += s->cell[i].n * c.l * c.l;
        uv2 += s->cell[i].n * (c.u * c.u + c.v * c.v);
    }
    out[NQM_SCALAR_SMOOTH] = log_size(sqrt(mean(l2, s->n)));
    out[NQM_SCALAR_SMOOTH_CHROMA] = log_size(sqrt(mean(uv2, s->n)));
}

static void whole_scalars(const nqm_scalar_sums *s, double *out) {
    double bias = mean(s->l, s->n), level = mean(s->ref_log, s->n);
    nqm_light_ratio energy = nqm_light_contrast(&s->weighted);
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

static void finish_scalars(const nqm_scalar_sums *s, const double *metrics, const nqm_label *estimate,
                           double *scalars) {
    nqm_estimate_targets(estimate, scalars + NQM_SCALAR_ESTIMATE);
    for (size_t m = 0; m < NQM_SCALAR_RMS; ++m)
        scalars[NQM_SCALAR_METRICS + m] = log(metrics[m] + NQM_LOG_METRIC_OFFSET);
    whole_scalars(s, scalars);
    zone_scalars(s, scalars);
    for (size_t i = 0; !(s->n > 0) && i < NQM_SCALAR_COUNT; ++i)
        scalars[i] = NAN;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

void nqm_compare_finish(const nqm_pair_sums *sums, const nqm_label *estimate, double *metrics, double *scalars) {
    double own[NQM_METRIC_COUNT];
    nqm_metric_sums_finish(&sums->metrics, own);
    if (metrics)
        memcpy(metrics, own, sizeof own);
    if (scalars)
        finish_scalars(&sums->scalars, own, estimate, scalars);
}

void nqm_compare_samples(const nqm_sum_plan *plan, const nqm_transport *transport, const nqm_sample_pair *pair,
                         double *metrics, nqm_label *estimate, double *scalars) {
    nqm_pair_sums sums;
    if (transport->light)
        nqm_transport_estimates(transport, 1, pair, estimate, NULL);
    nqm_compare_sums(plan, 1, pair, NULL, scalars != NULL, &sums);
    nqm_compare_finish(&sums, transport->light ? estimate : NULL, metrics, scalars);
}

nqm_status nqm_metrics_compute(const nqm_directions *directions, const float *ref, const float *test,
                               const uint8_t *used, double *metrics, nqm_error *err) {
    NQM_REQUIRE(err, directions, ref, test, metrics);
    nqm_sum_plan *plan;
    const nqm_status status = nqm_sum_plan_create(directions, &plan, err);
    if (status == NQM_OK)
        nqm_compare_samples(plan, &(nqm_transport){0}, &(nqm_sample_pair){ref, test, used}, metrics, NULL, NULL);
    nqm_sum_plan_free(plan);
    return status;
}
