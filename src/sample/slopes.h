/* SPDX-License-Identifier: MIT
 *
 * slopes.h - cells of half vectors, in which the light of a scene is stored.
 */
#ifndef NQM_SRC_SAMPLE_SLOPES_H
#define NQM_SRC_SAMPLE_SLOPES_H

#include "percept/percept.h"

/** Cells of half vectors by their slope, h.xy / h.z: a disc, and rings of cells that are even in the logarithm of the slope. */
enum { NQM_SLOPE_RINGS = 38, NQM_SLOPE_AZIMUTHS = 48, NQM_SLOPE_CELLS = 1 + NQM_SLOPE_RINGS * NQM_SLOPE_AZIMUTHS };
#define NQM_SLOPE_LEAST 0.004 /**< radius of the disc, within which light is constant */
#define NQM_SLOPE_MOST  8.0   /**< the last ring ends here */
/** The cell of a slope; that of the last ring beyond it. */
size_t nqm_slope_cell(double x, double y);
/** Area of a cell in the plane of slopes. */
double nqm_slope_area(size_t cell);

/** The light that the points of a picture reflect at half vectors of each cell: of it the picture of any BRDF is made (lobes/lobes.h).
 *  The arrays are borrowed. */
typedef struct nqm_slope_light {
    const float *light; /* (NQM_SLOPE_CELLS, 3, n) cd/m2 times cosine times solid angle */
    const double *wo;   /* (n, 3) unit vectors to the viewer in the axes of the surface */
    nqm_picture_points points;
} nqm_slope_light;

#endif
