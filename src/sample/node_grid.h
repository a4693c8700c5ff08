/* SPDX-License-Identifier: MIT
 *
 * node_grid.h - the nodes of a grid in half-vector coordinates as sampling directions, and interpolation between them, for light
 * transport.
 */
#ifndef NQM_SRC_NODE_GRID_H
#define NQM_SRC_NODE_GRID_H

#include "sample/sample.h"

enum { NQM_GRID_MAX_H = 64, NQM_GRID_D = 6, NQM_GRID_PHI = 8, NQM_GRID_NEAR = 16 * NQM_GRID_PHI };

/** A grid. Node (h, d, p) of (n_h, NQM_GRID_D, NQM_GRID_PHI) has the index (h NQM_GRID_D + d) NQM_GRID_PHI + p. */
typedef struct nqm_node_grid {
    size_t n;                     /* nodes */
    size_t n_h;                   /* values of theta_h */
    double log_h[NQM_GRID_MAX_H]; /* (n_h) logarithms of theta_h, ascending */
} nqm_node_grid;

nqm_node_grid nqm_node_grid_make(void);
/** The NQM_GRID_NEAR nodes around a pair of unit vectors, and their weights in the interpolated f_r, some of which are negative.
 *  Outside the grid the value at its boundary counts. */
void nqm_node_grid_interpolate(const nqm_node_grid *grid, const double *wi, const double *wo,
                               size_t node[NQM_GRID_NEAR], double weight[NQM_GRID_NEAR]);

/** The nodes as directions; and whether a set is these. */
NQM_MUST_CHECK nqm_status nqm_node_grid_directions(nqm_directions **directions_ret, nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_node_grid_check(const nqm_directions *directions, bool *is_grid_ret, nqm_error *err);

#endif
