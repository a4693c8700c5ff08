/* SPDX-License-Identifier: MIT
 *
 * perturb.h - the state of one distortion (doc/brdf.md defines each setting) and its evaluation, which lie in files of
 * their own beside the reading of its spec.
 */
#ifndef NQM_SRC_BRDF_PERTURB_H
#define NQM_SRC_BRDF_PERTURB_H

#include "brdf/brdf.h"

enum { NQM_SMOOTH_TAPS = 27 };

/** One distortion with its constants. */
typedef struct nqm_perturbation {
    nqm_brdf *base;
    double shift_rad, gloss, smooth_rad, peak, fresnel, mix, desaturate;
    double ceiling;    /* no channel of the base passes it; HUGE_VAL: off */
    double hue[3];     /* first row of the circulant matrix that turns colours about grey; 1,0,0: off */
    double colour[3];  /* tint * scale */
    double lambert[3]; /* f_r of the Lambert BRDF that `mix` mixes in */
    double ripple, bands;
    double quantise; /* steps per decade; 0: off */
    double sigma;    /* of log f_r */
    size_t n_cells;
    float *lattice; /* (n_cells + 1, n_cells + 1, n_cells + 1, 3) standard normal draws; NULL without noise */
    size_t n_taps;  /* rows of the base that are averaged: 1, or NQM_SMOOTH_TAPS */
    size_t n_rows;  /* and one off the highlight where `peak` needs it */
} nqm_perturbation;

/** nqm_brdf_class.eval_half_diff for a perturbation. */
void nqm_perturbation_eval(const void *perturbation, size_t n, const double *hd, double *rgb);

#endif
