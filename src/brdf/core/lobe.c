/* SPDX-License-Identifier: MIT
 *
 * The lobe of an anisotropic BRDF: where its peak is and how it is stretched. Half vectors that are even in the logarithm
 * of the slope suit round lobes only: those of a lobe that is long, or does not surround the normal, are stretched and moved like it.
 */
#include "brdf/brdf.h"

#include <math.h>

/* Luminance that f_r(h, h) reflects from an area of slopes, which ends toward the horizon; 0 where a peak is not looked
 * for: towards the horizon f_r may rise without end. */
static double value_at(const nqm_brdf *brdf, double x, double y) {
    static const double steepest = 4.5;
    if (!(hypot(x, y) < steepest))
        return 0;
    double h[3] = {x, y, 1}, rgb[3];
    nqm_normalize3(h);
    nqm_brdf_eval(brdf, 1, h, h, rgb, NULL);
    return nqm_luminance(rgb) * h[2] * h[2] * h[2] * h[2];
}

/* The normal of its frame, if that is tilted: the lobe there may be narrower than any grid. Else climb to the peak from the
 * brightest of a grid of slopes; the normal, unless the peak is brighter. Returns the value. */
static double find_peak(const nqm_brdf *brdf, double center[2]) {
    enum { GRID = 16 };
    static const double reach = 1, least_step = 1e-5, much = 1.1;
    const double at_normal = value_at(brdf, 0, 0);
    double normal[3], best = at_normal, x = 0, y = 0;
    nqm_brdf_frame_normal(brdf, normal);
    center[0] = normal[0] / normal[2];
    center[1] = normal[1] / normal[2];
    if (center[0] != 0 || center[1] != 0)
        return value_at(brdf, center[0], center[1]);
    for (int i = -GRID; i <= GRID; ++i)
        for (int j = -GRID; j <= GRID; ++j) {
            const double value = value_at(brdf, reach * i / GRID, reach * j / GRID);
            if (value > best)
                best = value, x = reach * i / GRID, y = reach * j / GRID;
        }
    for (double step = reach / GRID; step > least_step;) {
        const double from = best, at_x = x, at_y = y;
        for (int k = 0; k < 8; ++k) {
            const double to_x = at_x + step * cos(k * NQM_PI / 4), to_y = at_y + step * sin(k * NQM_PI / 4);
            const double value = value_at(brdf, to_x, to_y);
            if (value > best)
                best = value, x = to_x, y = to_y;
        }
        step *= best > 1.001 * from ? 1 : 0.5;
    }
    if (!(best > much * at_normal))
        return at_normal;
    center[0] = x;
    center[1] = y;
    return best;
}

/* The slope at which the value along an azimuth has fallen halfway to that at a slope of 4. */
static double half_width(const nqm_brdf *brdf, const double center[2], double peak, double phi) {
    static const double narrowest = 1e-5, widest = 4, step = 1.15;
    const double c = cos(phi), s = sin(phi), floor = value_at(brdf, center[0] + widest * c, center[1] + widest * s);
    const double half = (peak + floor) / 2;
    double t = narrowest, before = peak, value = peak;
    while (t < widest && value > half) {
        before = value;
        t *= step;
        value = value_at(brdf, center[0] + t * c, center[1] + t * s);
    }
    return value < before ? t * pow(step, (before - half) / (before - value) - 1) : t;
}

nqm_lobe nqm_lobe_measure(const nqm_brdf *brdf) {
    enum { AZIMUTHS = 24 };
    static const double most = 30;
    double center[2], even = 0, odd = 0;
    const double peak = find_peak(brdf, center);
    for (size_t k = 0; k < AZIMUTHS; ++k) { /* of an ellipse, 1 / width^2 is a constant and this harmonic */
        const double phi = 2 * NQM_PI * (double)k / AZIMUTHS, width = half_width(brdf, center, peak, phi);
        even -= cos(2 * phi) / (width * width);
        odd -= sin(2 * phi) / (width * width);
    }
    const double phi = 0.5 * atan2(odd, even), c = cos(phi), s = sin(phi);
    const double longest = half_width(brdf, center, peak, phi);
    const double shortest = half_width(brdf, center, peak, phi + NQM_PI / 2);
    const double longer = sqrt(fmin(fmax(longest / shortest, 1), most)), shorter = 1 / longer;
    return (nqm_lobe){.center = {center[0], center[1]},
                      .axes = {c * longer, -s * shorter, s * longer, c * shorter},
                      .width = longest / longer};
}
