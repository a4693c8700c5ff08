/* SPDX-License-Identifier: MIT
 *
 * Sums over the directions of pairs (sums.h), in double.
 *
 * An image averages reflectance over many directions, so that random differences between directions are less visible
 * than systematic ones. Therefore some features compare sums over zones of directions, others single directions.
 */
#include "metric/sums.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* ---- sets of directions ------------------------------------------------------------------------------------------ */

/* Upper ends of the zones, degrees. */
static const double zone_h_end[NQM_ZONES_H - 1] = {2, 5, 15, 35}, zone_d_end[NQM_ZONES_D - 1] = {30, 60};

static size_t zone_of(double degrees, size_t n_ends, const double *ends) {
    size_t zone = 0;
    while (zone < n_ends && degrees >= ends[zone])
        ++zone;
    return zone;
}

size_t nqm_cell_of(const double *degrees) {
    return zone_of(degrees[0], NQM_ZONES_H - 1, zone_h_end) * NQM_ZONES_D +
           zone_of(degrees[1], NQM_ZONES_D - 1, zone_d_end);
}

/* The limit is theta_d = 60 degrees at theta_h = 0. */
bool nqm_is_grazing(double cosines) {
    return cosines < 0.25;
}

/* ---- sums of reflectance ----------------------------------------------------------------------------------------- */

static void add_light(nqm_light_sum *to, double weight, const double *ref, const double *test) {
    to->n += weight;
    for (int k = 0; k < 3; ++k) {
        to->ref[k] += weight * ref[k];
        to->test[k] += weight * test[k];
    }
}

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

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* Opponent channels of a logarithm of f_r. */
static double opponent_u(const double *d) {
    return d[0] - d[1];
}

static double opponent_v(const double *d) {
    return d[2] - 0.5 * (d[0] + d[1]);
}

/* Add direction i of a stretch. */
static void add_direction(nqm_scalar_sums *s, const double *degrees, double cosines, const nqm_scaled *ref,
                          const nqm_scaled *test, size_t i) {
    const double *a = ref->scale[NQM_SCALE_LOG_F] + 3 * i, *b = test->scale[NQM_SCALE_LOG_F] + 3 * i;
    const double *f = ref->scale[NQM_SCALE_F] + 3 * i, *g = test->scale[NQM_SCALE_F] + 3 * i;
    const double ref_log = ref->log_luminance[i], l = test->log_luminance[i] - ref_log;
    const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, u = opponent_u(d), v = opponent_v(d);
    const size_t cell = nqm_cell_of(degrees);
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
    s->zone_l2[cell / NQM_ZONES_D] += l * l;
    if (nqm_is_grazing(cosines)) {
        s->grazing_n += 1;
        s->grazing_l += l;
        s->grazing_l2 += l * l;
    }
    s->ref_log += ref_log;
    s->ref_log2 += ref_log * ref_log;
    s->ref_colour2 += opponent_u(a) * opponent_u(a) + opponent_v(a) * opponent_v(a);
    add_light(&s->cell[cell], 1, f, g);
    add_light(&s->weighted, cosines, f, g);
}

void nqm_compare_sums(const nqm_directions *directions, const nqm_sample_pair *pair, bool with_scalars,
                      nqm_pair_sums *sums) {
    memset(sums, 0, sizeof *sums);
    for (size_t stretch = 0; stretch * NQM_STRETCH < directions->n; ++stretch) {
        const size_t first = stretch * NQM_STRETCH, n = nqm_stretch_size(directions->n, stretch);
        nqm_scaled ref, test;
        double weight[3 * NQM_STRETCH] = {0};
        nqm_scale_stretch(directions, stretch, pair->ref, &ref);
        nqm_scale_stretch(directions, stretch, pair->test, &test);
        for (size_t i = 0; i < 3 * n; ++i)
            weight[i] = !pair->used || pair->used[first + i / 3];
        nqm_metric_sums_add(&sums->metrics, &ref, &test, weight);
        for (size_t i = 0; with_scalars && i < n; ++i)
            if (weight[3 * i] > 0)
                add_direction(&sums->scalars, directions->degrees + 3 * (first + i), directions->cosines[first + i],
                              &ref, &test, i);
    }
}
