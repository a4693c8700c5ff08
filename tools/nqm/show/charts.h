/* SPDX-License-Identifier: MIT
 *
 * charts.h - the values of the charts that web/charts.js draws, on the browser page and in reports.
 */
#ifndef NQM_TOOL_CHARTS_H
#define NQM_TOOL_CHARTS_H

#include <nqm/brdf.h>

enum { CHART_SLICES = 4, CHART_POINTS = 181, CHART_COLUMNS = 90, CHART_ROWS = 60 };

/** f_r rgb (CHART_SLICES, CHART_POINTS, 3) of four slices: over theta_h = 89.5 (i/180)^2 degrees at theta_d = 0; in the plane of incidence
 *  over theta_o from -89.5 to 89.5 degrees with the light at 10, 45 and 75 degrees at the other side (theta_o < 0). NaN: no value.
 *  phi_rad: azimuth of the plane. */
void chart_slices(const nqm_brdf *brdf, double phi_rad, double *rgb);
/** Mean |difference of log(f_r + 0.003)| over phi_d and channels: map (CHART_ROWS, CHART_COLUMNS) over theta_d and the root of theta_h, as
 *  `nqm.plot.attribution` draws it; NaN below the horizon. */
void chart_map(const nqm_brdf *ref, const nqm_brdf *test, double *map);

#endif
