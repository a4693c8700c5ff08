/* SPDX-License-Identifier: MIT
 *
 * Cells of half vectors by their slope: even in its logarithm and in azimuth.
 */
#include "sample/slopes.h"
#include "math/math.h"

#include <math.h>

static double ring_step(void) {
    return log(NQM_SLOPE_MOST / NQM_SLOPE_LEAST) / NQM_SLOPE_RINGS;
}

size_t nqm_slope_cell(double x, double y) {
    const double t = hypot(x, y), turn = atan2(y, x) / (2 * NQM_PI);
    if (!(t > NQM_SLOPE_LEAST))
        return 0;
    const size_t ring = nqm_smaller((size_t)(log(t / NQM_SLOPE_LEAST) / ring_step()), NQM_SLOPE_RINGS - 1);
    return 1 + ring * NQM_SLOPE_AZIMUTHS + (size_t)((turn + 1) * NQM_SLOPE_AZIMUTHS) % NQM_SLOPE_AZIMUTHS;
}

double nqm_slope_area(size_t cell) {
    const double inner = NQM_SLOPE_LEAST * exp(ring_step() * (double)((cell - 1) / NQM_SLOPE_AZIMUTHS));
    if (cell == 0)
        return NQM_PI * NQM_SLOPE_LEAST * NQM_SLOPE_LEAST;
    return NQM_PI * inner * inner * expm1(2 * ring_step()) / NQM_SLOPE_AZIMUTHS;
}
