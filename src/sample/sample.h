/* SPDX-License-Identifier: MIT
 *
 * sample.h - the fields of a direction set, and the conversion of sampled reflectance to input features of the network:
 * transform, whitening, layout (paper, section 3.1).
 */
#ifndef NQM_SRC_SAMPLE_H
#define NQM_SRC_SAMPLE_H

#include "base/options.h"
#include <nqm/samples.h>

/** Allocated as one block. */
struct nqm_directions {
    size_t n;
    double *degrees; /* (n, 3) theta_h, theta_d, phi_d */
    double *wi, *wo; /* (n, 3) unit vectors to light and viewer; the azimuth of the half vector is 0 */
    double *cosines; /* (n) cos(theta_i) cos(theta_o), 0 for a direction below the horizon */
    uint32_t *twin;  /* (n) an earlier direction with light and viewer exchanged; itself if there is none */
    char id[17];     /* nqm_directions_id(); empty: not computed yet */
};

/** Conversion of a pair to the network's input. */
typedef struct nqm_features {
    nqm_layout layout;
    double difference_scale; /* factor of the differences; used by layout 1 */
    float mean[3], std[3];   /* mean and deviation of t, per channel; whitening is (t - mean) / std */
} nqm_features;

/** t = log(cbrt(rho) + 1) for n values; rho >= 0. In place is allowed. */
void nqm_features_transform(size_t n, const float *rho, float *t);
/** Inverse of nqm_features_transform(): rho = (exp(t) - 1)^3. In place is allowed. */
void nqm_features_restore(size_t n, const float *t, float *rho);
/** Number of input features that come from samples: 6 n_directions (layout 0) or 9 n_directions (layout 1). */
size_t nqm_features_width(nqm_layout layout, size_t n_directions);
/**
 * Compute the input vector of one pair. Differences are taken after whitening.
 *
 * @param ref_t, test_t  (n_directions, 3) transformed, not whitened; may be x and x + 3 n_directions
 * @param used           (n_directions) 0 where the direction is dropped: both members get the mean, so its features
 *                       are 0; NULL: all directions are used
 * @param x              (nqm_features_width) receives the input
 */
void nqm_features_compose(const nqm_features *features, size_t n_directions, const float *ref_t, const float *test_t,
                          const uint8_t *used, float *x);

/** Set `gradient` (n_directions, 3) to that of sum dx x by the test's f_r, whose cube roots are `root`; other arguments
 *  as above, x and dx as the network has them. 0 where `used` is 0, or a difference of samples is 0 whose magnitude
 *  counts. The transform has no derivative at 0: below NQM_LEAST_F, the value there. */
void nqm_features_gradient(const nqm_features *features, size_t n_directions, const float *root, const uint8_t *used,
                           const float *x, const float *dx, float *gradient);
#define NQM_LEAST_F 1e-6 /**< 1/sr */

/** The words of nqm_invalid_policy by value, NULL-terminated. */
extern const char *const nqm_invalid_words[];
/** The options of nqm_directions_options. */
extern const nqm_option_table nqm_directions_option_table;

/**
 * Write samples as the paper's authors store them: a MAT v5 file with r, g, b (n x 1) and random_locations (n x 3:
 * theta_h, theta_d, phi_d in degrees). Equal samples make equal files.
 *
 * @param rgb   (n, 3) f_r in 1/sr, finite
 * @param path  the file appears under its name only when complete
 * @return NQM_ERR_ARG (a value is not finite), NQM_ERR_IO, NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_samples_save_mat(const nqm_directions *directions, const float *rgb, const char *path,
                                               nqm_error *err);

#endif
