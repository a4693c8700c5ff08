/* SPDX-License-Identifier: MIT
 *
 * Plots of several BRDFs: slices in half-vector coordinates, polar lobes, and the plane of incidence.
 */
#include "brdf/brdf.h"
#include "figures/sheet.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { MAX_BRDFS = 8, N_POINTS = 361, N_PANELS = 6, OVER_THETA_H = 0, OVER_THETA_D, LOBES, INCIDENT };

/* Angles of the light; the lobes have the second one. */
static const double theta_i_rad[3] = {15 * NQM_PI / 180, 45 * NQM_PI / 180, 70 * NQM_PI / 180};

typedef struct slicing {
    nqm_slice_angles angles;
    double turn[2]; /* sine and cosine of its azimuth */
    nqm_chart charts[N_PANELS];
    char titles[N_PANELS][80], names[MAX_BRDFS][64];
    nqm_series series[N_PANELS][MAX_BRDFS];
    double x[N_PANELS][N_POINTS];
    double y[N_PANELS][MAX_BRDFS][N_POINTS]; /* luminance of f_r, 1/sr; NaN where there is no value */
} slicing;

void nqm_plot_brdf_name(const nqm_brdf *brdf, const char *given, char name[64]) {
    const char *full = nqm_brdf_get_info(brdf).name, *slash = strrchr(full, '/');
    bool is_path = slash && !strchr(full, ';');
    const char *first = is_path ? slash + 1 : full, *dot = is_path ? strrchr(first, '.') : NULL;
    size_t n = dot && dot > first && !strchr(dot, ':') ? (size_t)(dot - first) : strlen(first);
    if (given)
        snprintf(name, 64, "%.60s", given);
    else
        snprintf(name, 64, "%.*s%s", (int)(n > 57 ? 57 : n), first, n > 57 ? "..." : "");
}

static double luminance(const nqm_brdf *brdf, const double *turn, bool half_diff, double *at) {
    double rgb[3];
    uint8_t flag;
    if (half_diff) {
        nqm_brdf_eval_turned(brdf, 1, at, turn, rgb, &flag);
    } else {
        double wi[3], wo[3];
        nqm_turn3(turn, at, wi);
        nqm_turn3(turn, at + 3, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
    }
    return nqm_has_value(flag) ? nqm_luminance(rgb) : (double)NAN;
}

static double light_of(size_t panel) {
    return theta_i_rad[panel == LOBES ? 1 : panel - INCIDENT];
}

/* The point at x (degrees) of a panel: (theta_h, theta_d, phi_d) if true, else the directions of light and viewer. */
static bool locate(const slicing *s, size_t panel, double x_deg, double at[6]) {
    double x = x_deg * NQM_PI / 180;
    if (panel == OVER_THETA_H || panel == OVER_THETA_D) {
        bool over_h = panel == OVER_THETA_H;
        at[0] = over_h ? x : 0;
        at[1] = over_h ? s->angles.theta_d_rad : x;
        at[2] = s->angles.phi_d_rad;
        return true;
    }
    nqm_spherical(light_of(panel), NQM_PI, at); /* the light is at the left, its mirror direction at the right */
    nqm_spherical(fabs(x), x < 0 ? NQM_PI : 0, at + 3);
    return false;
}

static void evaluate(slicing *s, size_t panel, size_t n, const nqm_brdf *const *brdfs) {
    bool has_both_sides = panel >= LOBES; /* both sides of the normal */
    for (size_t i = 0; i < N_POINTS; ++i) {
        double t = (double)i / (N_POINTS - 1), at[6];
        /* Quadratic in theta_h, because highlights are narrow; without the horizon. */
        s->x[panel][i] = has_both_sides ? -89.5 + 179 * t : 89.5 * (panel == OVER_THETA_H ? t * t : t);
        bool half_diff = locate(s, panel, s->x[panel][i], at);
        for (size_t k = 0; k < n; ++k)
            s->y[panel][k][i] = luminance(brdfs[k], s->turn, half_diff, at);
    }
}

static void describe(slicing *s, size_t panel) {
    static const char *const labels[N_PANELS] = {
        NQM_THETA "_{h} (" NQM_DEG ")", NQM_THETA "_{d} (" NQM_DEG ")", NULL,
        NQM_THETA "_{o} (" NQM_DEG ")", NQM_THETA "_{o} (" NQM_DEG ")", NQM_THETA "_{o} (" NQM_DEG ")"};
    const double deg = 180 / NQM_PI;
    nqm_chart *chart = &s->charts[panel];
    char *title = s->titles[panel];
    bool has_both_sides = panel >= LOBES;
    double theta_i = has_both_sides ? light_of(panel) * deg : 0;
    if (panel == OVER_THETA_H)
        snprintf(title, 80, NQM_THETA "_{d} = %.3g" NQM_DEG ", " NQM_PHI "_{d} = %.3g" NQM_DEG,
                 s->angles.theta_d_rad * deg, s->angles.phi_d_rad * deg);
    else if (panel == OVER_THETA_D)
        snprintf(title, 80, "mirror direction, " NQM_THETA "_{h} = 0");
    else
        snprintf(title, 80, "%s, " NQM_THETA "_{i} = %.3g" NQM_DEG, panel == LOBES ? "lobes" : "plane of incidence",
                 theta_i);
    *chart =
        (nqm_chart){.title = title,
                    .x = {.label = labels[panel],
                          .scale = panel == OVER_THETA_H ? NQM_SQRT : NQM_LINEAR,
                          .min = has_both_sides ? -90 : 0,
                          .max = 90,
                          .step = has_both_sides ? 30 : 15},
                    .y = nqm_axis_make(panel == LOBES ? "radius: f_{r} (1/sr), logarithmic" : "f_{r} (1/sr)", NQM_LOG),
                    .polar = panel == LOBES,
                    .light_deg = -theta_i,
                    .series = s->series[panel]};
}

/* The lowest 2 % of the values, most of them near the horizon, would take most of the axis: they are cut. */
static nqm_status set_axis_range(nqm_chart *chart, nqm_error *err) {
    double *values = nqm_alloc(chart->n_series * N_POINTS, sizeof *values);
    if (!values)
        return nqm_fail_nomem(err, chart->n_series * N_POINTS * sizeof *values);
    size_t n = 0;
    for (size_t k = 0; k < chart->n_series; ++k)
        for (size_t i = 0; i < N_POINTS; ++i)
            if (chart->series[k].y[i] > 0)
                values[n++] = chart->series[k].y[i];
    nqm_axis_include(&chart->y, n, values);
    if (n > 0)
        chart->y.min = nqm_quantile(n, values, 0.02);
    nqm_free(values);
    nqm_axis_round(&chart->y, 5);
    if (chart->polar) /* leave a gap between the smallest value and the centre */
        chart->y.min /= 10;
    return NQM_OK;
}

/* Whether any panel shows a line of BRDF k: the axes are logarithmic. */
static bool is_visible(const slicing *s, size_t k) {
    for (size_t panel = 0; panel < N_PANELS; ++panel)
        for (size_t i = 0; i < N_POINTS; ++i)
            if (s->y[panel][k][i] > 0)
                return true;
    return false;
}

static bool has_anisotropic(size_t n, const nqm_brdf *const *brdfs) {
    for (size_t k = 0; k < n; ++k)
        if (nqm_brdf_anisotropy(brdfs[k]) > 0)
            return true;
    return false;
}

static nqm_status slice(slicing *s, const char *path, size_t n, const nqm_brdf *const *brdfs,
                        const nqm_plot_options *options, nqm_error *err) {
    nqm_sheet_panel panels[N_PANELS];
    nqm_status status = NQM_OK;
    for (size_t panel = 0; status == NQM_OK && panel < N_PANELS; ++panel) {
        evaluate(s, panel, n, brdfs);
        describe(s, panel);
        for (size_t k = 0; k < n; ++k)
            s->series[panel][k] = (nqm_series){.name = s->names[k],
                                               .style = k,
                                               .dash = k % NQM_DASHES,
                                               .n = N_POINTS,
                                               .x = s->x[panel],
                                               .y = s->y[panel][k]};
        s->charts[panel].n_series = n;
        status = set_axis_range(&s->charts[panel], err);
        panels[panel] = (nqm_sheet_panel){.chart = &s->charts[panel]};
    }
    size_t n_visible = 0;
    for (size_t k = 0; status == NQM_OK && k < n; ++k) {
        const size_t used = strlen(s->names[k]);
        n_visible += is_visible(s, k);
        if (is_visible(s, k))
            continue;
        snprintf(s->names[k] + used, sizeof s->names[k] - used, " (0)");
        for (size_t panel = 0; panel < N_PANELS; ++panel)
            s->series[panel][k].mark = NQM_MARK_NONE;
    }
    if (status == NQM_OK && !n_visible)
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s: no BRDF has a value above 0 in any slice: nothing to draw",
                        path);
    char note[200], azimuth[60] = "";
    if (has_anisotropic(n, brdfs))
        snprintf(azimuth, sizeof azimuth, "; %.3g" NQM_DEG " from the tangent", s->angles.azimuth_rad * 180 / NQM_PI);
    snprintf(note, sizeof note,
             "luminance of f_{r}, without the cosine; the light is at " NQM_THETA
             "_{i} on the left (negative " NQM_THETA "_{o}), its mirror direction on the right%s",
             azimuth);
    const nqm_sheet sheet = {.title = "Slices of BRDFs",
                             .note = note,
                             .width = 960,
                             .height = 640,
                             .n_rows = 2,
                             .n_columns = 3,
                             .panels = panels};
    return status == NQM_OK ? nqm_sheet_write(path, &sheet, options, err) : status;
}

nqm_status nqm_plot_slices(const char *path, size_t n, const nqm_brdf *const *brdfs, const char *const *names,
                           const nqm_slice_angles *angles, const nqm_plot_options *options, nqm_error *err) {
    if (n < 1 || n > MAX_BRDFS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: 1 to %d BRDFs can be drawn, not %zu", path, (int)MAX_BRDFS, n);
    if (!(angles->theta_d_rad >= 0 && angles->theta_d_rad < NQM_PI / 2 && isfinite(angles->phi_d_rad) &&
          isfinite(angles->azimuth_rad)))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: theta_d of slices must be 0 to below 90 degrees", path);
    slicing *s = nqm_alloc(1, sizeof *s);
    if (!s)
        return nqm_fail_nomem(err, sizeof *s);
    s->angles = *angles;
    s->turn[0] = sin(angles->azimuth_rad);
    s->turn[1] = cos(angles->azimuth_rad);
    for (size_t k = 0; k < n; ++k)
        nqm_plot_brdf_name(brdfs[k], names ? names[k] : NULL, s->names[k]);
    nqm_status status = slice(s, path, n, brdfs, options, err);
    nqm_free(s);
    return status;
}
