/* SPDX-License-Identifier: MIT
 *
 * The implementation of charts.h.
 */
#include "nqm/show/charts.h"


#include <math.h>

enum { N_PHI = 6 };

static const double pi = 3.14159265358979323846;

/* The direction at an angle from the normal, in the plane of azimuth phi; below 0: at the other side. */
static void set_direction(double theta_rad, double phi_rad, double *w) {
    w[0] = sin(theta_rad) * cos(phi_rad);
    w[1] = sin(theta_rad) * sin(phi_rad);
    w[2] = cos(theta_rad);
}

void chart_slices(const nqm_brdf *brdf, double phi_rad, double *rgb) {
    static const double light_deg[CHART_SLICES] = {0, 10, 45, 75};
    const double deg = pi / 180;
    for (size_t i = 0; i < CHART_SLICES * CHART_POINTS; ++i) {
        const size_t k = i / CHART_POINTS;
        const double t = (double)(i % CHART_POINTS) / (CHART_POINTS - 1), h = 89.5 * deg * t * t;
        const double in = k ? light_deg[k] * deg : h, out = k ? 89.5 * deg * (2 * t - 1) : h;
        double wi[3], wo[3];
        uint8_t flag;
        set_direction(-in, phi_rad, wi);
        set_direction(out, phi_rad, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, rgb + 3 * i, &flag);
        for (size_t c = 0; c < 3 && !nqm_has_value(flag); ++c)
            rgb[3 * i + c] = (double)NAN;
    }
}

void chart_map(const nqm_brdf *ref, const nqm_brdf *test, double *map) {
    for (size_t cell = 0; cell < CHART_ROWS * CHART_COLUMNS; ++cell) {
        const double root = ((double)(cell % CHART_COLUMNS) + 0.5) / CHART_COLUMNS;
        double hd[N_PHI][3], a[N_PHI][3], b[N_PHI][3], sum = 0;
        uint8_t flag_a[N_PHI], flag_b[N_PHI];
        size_t n = 0;
        for (size_t i = 0; i < N_PHI; ++i) {
            hd[i][0] = pi / 2 * root * root;
            hd[i][1] = pi / 2 * ((double)(cell / CHART_COLUMNS) + 0.5) / CHART_ROWS;
            hd[i][2] = pi * ((double)i + 0.5) / N_PHI;
        }
        nqm_brdf_eval_half_diff(ref, N_PHI, hd[0], a[0], flag_a);
        nqm_brdf_eval_half_diff(test, N_PHI, hd[0], b[0], flag_b);
        for (size_t i = 0; i < N_PHI; ++i)
            for (size_t k = 0; k < 3 && nqm_has_value(flag_a[i]) && nqm_has_value(flag_b[i]); ++k, ++n)
                sum += fabs(log(a[i][k] + 0.003) - log(b[i][k] + 0.003));
        map[cell] = sum / (double)n; /* NaN: none has a value */
    }
}
