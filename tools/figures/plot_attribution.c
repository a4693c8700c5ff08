/* SPDX-License-Identifier: MIT
 *
 * A map of where two BRDFs differ, over (theta_h, theta_d).
 */
#include "brdf/brdf.h"
#include "figures/plot_shared.h"
#include "math/math.h"

#include <math.h>

enum { N_THETA_H = 90, N_THETA_D = 60, N_PHI_D = 18, N_AZIMUTHS = 12 };

typedef struct differing {
    const nqm_brdf *const *brdfs; /* reference, test */
    const char *const *names;
    size_t n_azimuths; /* of the half vector: 1 if both are isotropic */
    double *map;       /* (N_THETA_D, N_THETA_H) */
} differing;

/* The sum of |difference of log(f_r + 0.003)| over phi_d, means over the channels; *n: their number. */
static double sum_differences(const differing *d, const double *hd, const double *turn, size_t *n) {
    double a[N_PHI_D][3], b[N_PHI_D][3], turns[N_PHI_D][2], sum = 0;
    uint8_t flag_a[N_PHI_D], flag_b[N_PHI_D];
    for (size_t i = 0; i < N_PHI_D; ++i)
        turns[i][0] = turn[0], turns[i][1] = turn[1];
    nqm_brdf_eval_turned(d->brdfs[0], N_PHI_D, hd, turns[0], a[0], flag_a);
    nqm_brdf_eval_turned(d->brdfs[1], N_PHI_D, hd, turns[0], b[0], flag_b);
    for (size_t i = 0; i < N_PHI_D; ++i) {
        if (!nqm_has_value(flag_a[i]) || !nqm_has_value(flag_b[i]))
            continue;
        ++*n;
        for (size_t k = 0; k < 3; ++k)
            sum += fabs(log(a[i][k] + 0.003) - log(b[i][k] + 0.003)) / 3;
    }
    return sum;
}

/* Mean absolute difference of log(f_r + 0.003) over phi_d, azimuths and channels in the middle of a cell; NaN: no values. The
 * columns are equal steps of sqrt(theta_h), as in MERL tables. */
static double difference(const differing *d, size_t row, size_t column) {
    double hd[N_PHI_D][3], sum = 0;
    const double root = ((double)column + 0.5) / N_THETA_H;
    size_t n = 0;
    for (size_t i = 0; i < N_PHI_D; ++i) {
        hd[i][0] = NQM_PI / 2 * root * root;
        hd[i][1] = NQM_PI / 2 * ((double)row + 0.5) / N_THETA_D;
        hd[i][2] = NQM_PI * ((double)i + 0.5) / N_PHI_D;
    }
    for (size_t k = 0; k < d->n_azimuths; ++k) {
        const double azimuth = 2 * NQM_PI * (double)k / (double)d->n_azimuths;
        sum += sum_differences(d, hd[0], (double[2]){sin(azimuth), cos(azimuth)}, &n);
    }
    return sum / (double)n; /* NaN: none has a value */
}

static void fill_row(void *user, size_t row) {
    const differing *d = user;
    for (size_t column = 0; column < N_THETA_H; ++column)
        d->map[row * N_THETA_H + column] = difference(d, row, column);
}

static nqm_status draw(const char *path, const differing *d, const nqm_plot_options *options, nqm_error *err) {
    char names[2][64], title[160];
    nqm_heat heat = {.x = {.label = NQM_THETA "_{h} (" NQM_DEG ", square-root scale)", .scale = NQM_SQRT, .max = 90},
                     .y = {.label = NQM_THETA "_{d} (" NQM_DEG ")", .max = 90, .step = 15},
                     .value = nqm_axis_make("mean |difference of log(f_{r} + 0.003)|", NQM_LINEAR),
                     .n_columns = N_THETA_H,
                     .n_rows = N_THETA_D,
                     .values = d->map};
    nqm_axis_include(&heat.value, N_THETA_H * N_THETA_D, d->map);
    if (heat.value.min > heat.value.max)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: there is no direction where both BRDFs have a value", path);
    nqm_axis_include(&heat.value, 2, (double[]){0, 0.01}); /* rounding errors must not look like a difference */
    nqm_axis_round(&heat.value, 6);
    for (size_t i = 0; i < 2; ++i)
        nqm_plot_brdf_name(d->brdfs[i], d->names ? d->names[i] : NULL, names[i]);
    snprintf(title, sizeof title, "Where %s differs from %s", names[1], names[0]);
    static const char form[] =
        "mean over " NQM_PHI "_{d}%s and the channels of the BRDFs themselves; no model is involved; "
        "white: light or viewer below the horizon\n"
        "a difference of 0.1 is about 10 %%, one of 0.7 a factor of 2";
    char note[sizeof form + 20];
    snprintf(note, sizeof note, form, d->n_azimuths > 1 ? ", azimuths" : "");
    return nqm_panel_write(path, (nqm_sheet_panel){.heat = &heat}, 620, 480, title, note, options, err);
}

nqm_status nqm_plot_attribution(const char *path, const nqm_brdf *const brdfs[2], const char *const *names,
                                const nqm_plot_options *options, nqm_error *err) {
    const bool is_anisotropic = nqm_brdf_anisotropy(brdfs[0]) > 0 || nqm_brdf_anisotropy(brdfs[1]) > 0;
    differing d = {brdfs, names, is_anisotropic ? N_AZIMUTHS : 1, nqm_alloc(N_THETA_H * N_THETA_D, sizeof *d.map)};
    if (!d.map)
        return nqm_fail_nomem(err, N_THETA_H * N_THETA_D * sizeof *d.map);
    nqm_parallel_for(N_THETA_D, fill_row, &d);
    nqm_status status = draw(path, &d, options, err);
    nqm_free(d.map);
    return status;
}
