/* SPDX-License-Identifier: MIT
 *
 * sample.h - the inside of a direction set, and the way from sampled reflectance to the numbers that the network sees:
 * transform, whitening, layout (paper, section 3.1).
 */
#ifndef NQM_SRC_SAMPLE_H
#define NQM_SRC_SAMPLE_H

#include "base/options.h"
#include <nqm/samples.h>

struct nqm_directions {
    size_t n;
    double *degrees; /* (n, 3) theta_h, theta_d, phi_d */
    double *hd;      /* (n, 3) the same in radians */
    double *cosines; /* (n) cos(theta_i) cos(theta_o), 0 for a direction below the horizon */
    char id[17];     /* nqm_directions_id(); empty: not asked for yet */
};

/** How a pair becomes the network's input. */
typedef struct nqm_features {
    nqm_layout layout;
    double difference_scale; /* s; used by layout 1 */
    float mean[3], std[3];   /* whitening of t, per channel */
} nqm_features;

/** t = log(cbrt(rho) + 1) for n values; rho >= 0. In place is allowed. */
void nqm_features_transform(size_t n, const float *rho, float *t);
/** The way back: rho = (exp(t) - 1)^3. In place is allowed. */
void nqm_features_restore(size_t n, const float *t, float *rho);
/** Width of the samples' part of the network's input: 6 n_directions (layout 0) or 9 n_directions (layout 1). */
size_t nqm_features_width(nqm_layout layout, size_t n_directions);
/**
 * The input vector of one pair, differences taken after whitening.
 *
 * @param ref_t, test_t  (n_directions, 3) transformed, not whitened; may lie in x itself, at x and x + 3 n_directions
 * @param used           (n_directions) 0 where the direction is dropped (both members become the mean: whitened 0);
 *                       NULL: all
 * @param x              (nqm_features_width) receives the input
 */
void nqm_features_compose(const nqm_features *features, size_t n_directions, const float *ref_t, const float *test_t,
                          const uint8_t *used, float *x);

/** The words of nqm_invalid_policy by value, NULL-terminated. */
extern const char *const nqm_invalid_words[];
/** The options of nqm_directions_options. */
extern const nqm_option_table nqm_directions_option_table;

#endif
