/* SPDX-License-Identifier: MIT
 *
 * grid.h - measured values at any rising theta_h, theta_d and phi_d, with linear interpolation in the angles. The values may be
 * in a mapped file, in any order of the axes, with any number of channels that weights turn into RGB.
 */
#ifndef NQM_SRC_BRDF_GRID_H
#define NQM_SRC_BRDF_GRID_H

#include "base/base.h"

typedef struct nqm_grid {
    size_t n[3];           /**< nodes of theta_h, theta_d (both >= 2) and phi_d (>= 1) */
    const double *node[3]; /**< radians, rising; the last phi_d is at most the first plus `period` */
    double period;         /**< of phi_d: pi or 2 pi; between its last and first node, too, values are interpolated */
    bool extrapolates; /**< whether the lines through the first and last two theta_h and theta_d continue beyond them */
    const unsigned char *value;        /**< float32, little-endian */
    size_t stride[3];                  /**< bytes from a node to the next one along each axis */
    size_t n_channels, channel_stride; /**< values of a node, and bytes between them */
    const double *weights;             /**< (n_channels, 3): channel c of f_r is the sum of weights[3 k + c] value k */
} nqm_grid;

/** f_r of an nqm_grid at hd (n, 3). Nodes with a NaN are excluded from the interpolation; NaN where all neighbours are,
 *  and beyond the first and last theta_h and theta_d unless it extrapolates. */
void nqm_grid_eval(const void *grid, size_t n, const double *hd, double *rgb);
/** The same at one point (3), of a grid whose third coordinate is periodic over a turn, or of which the value at -x is that at x. */
void nqm_grid_eval_folded(const nqm_grid *grid, double *at, double *rgb);

/** The largest step between neighbouring nodes of coordinate k, in degrees. Wider steps of azimuths than NQM_GRID_WIDEST are no grid. */
double nqm_grid_gap(const nqm_grid *grid, size_t k);
#define NQM_GRID_WIDEST 45.001

#endif
