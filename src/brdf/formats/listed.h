/* SPDX-License-Identifier: MIT
 *
 * listed.h - a BRDF as a list of directions and values, of a CSV (listed_columns.c) or another file of rows. "FILE:DEGREES" sets the
 * tolerance of a list that is no complete grid.
 */
#ifndef NQM_SRC_BRDF_LISTED_H
#define NQM_SRC_BRDF_LISTED_H

#include "brdf/formats/format.h"

/** One direction, in radians, and f_r in 1/sr; NaN in channel 0: no value. */
typedef struct nqm_listed {
    double at[3]; /* theta_h, theta_d, phi_d; or theta_i, theta_o, phi = phi_o - phi_i */
    double phi_i; /* of the light, if both directions are listed and azimuths count; else 0 */
    float rgb[3];
} nqm_listed;

/** A file of directions and values. */
typedef struct nqm_list {
    const char *path;
    size_t n;
    nqm_listed *rows;             /* (n) */
    size_t n_repeated;            /* rows of the file that gave a direction again: the mean is in `rows` */
    char remark[NQM_REMARK_SIZE]; /* what of the file is not used */
    bool has_unit;                /* the file says in which unit its angles are */
    bool is_reciprocal;           /* each row also counts with light and viewer exchanged */
    bool has_pairs;               /* rows are light and viewer */
    bool is_anisotropic;          /* their azimuths count; only if has_pairs */
    bool is_half_turn; /* all phi are in one half of the turn, so that in a grid the value at -phi is that at phi */
} nqm_list;

/** Weights of X, Y and Z, relative to the white of D65, that make linear BT.709 RGB, as of nqm_spectrum_weights(). */
static const double nqm_xyz_weights[9] = {3.2404542,  -0.9692660, 0.0556434, -1.5371385, 1.8760108,
                                          -0.2040259, -0.4985314, 0.0415560, 1.0572252};

/** The remark on such rows, and their number. */
#define NQM_REPEATED_ROWS "rows that give a direction again: %zu (their mean counts)"

/** Create the BRDF of a list, whose rows it sorts and merges: a grid, or scattered rows. Set are path, n, rows, has_unit,
 *  is_reciprocal and has_pairs. n_bytes: of the file. */
NQM_MUST_CHECK nqm_status nqm_listed_create(nqm_list *list, size_t n_bytes, const nqm_brdf_argument *argument,
                                            nqm_brdf **brdf_ret, nqm_error *err);

/** How many rows that are no grid a file of n_bytes may have. */
size_t nqm_listed_most(size_t n_bytes);

/** Light and viewer of a row: unit vectors (3). */
void nqm_listed_pair(const nqm_list *list, const nqm_listed *row, double *wi, double *wo);

/** A BRDF with values only within `tolerance` (radians) of the listed directions: the value of the nearest one. The
 *  distance of two pairs is the root of the summed squares of the angles (as chords) between their lights and between
 *  their viewers, of an isotropic list after the rotation about the normal that makes it smallest. Rows without a value
 *  or below the horizon are ignored. The rows are copied. NQM_ERR_FORMAT: no row is left. */
NQM_MUST_CHECK nqm_status nqm_scattered_create(const nqm_list *list, double tolerance, const char *name,
                                               nqm_brdf **brdf_ret, nqm_error *err);

/** The directions of such a BRDF, without repeated ones: wi, wo (n, 3) receive them unless NULL. Returns n; 0 for other BRDFs. */
size_t nqm_scattered_rows(const nqm_brdf *brdf, double *wi, double *wo);
/** Distance of a pair to the nearest of them in radians; 0 for other BRDFs. */
double nqm_scattered_distance(const nqm_brdf *brdf, const double *wi, const double *wo);

/** The median and the 95 % quantile of these distances of n pairs, in degrees. */
NQM_MUST_CHECK nqm_status nqm_scattered_distances(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo,
                                                  double quantile_deg[2], nqm_error *err);

/** For an interpolated grid, replace pairs by its nearest nodes, which have measured values; other BRDFs: nothing. */
void nqm_listed_snap(const nqm_brdf *brdf, size_t n, double *wi, double *wo);

#endif
