/* SPDX-License-Identifier: MIT
 *
 * nqm/samples.h - the fixed set of directions at which BRDFs are compared, and the sampling of a BRDF at them.
 */
#ifndef NQM_SAMPLES_H
#define NQM_SAMPLES_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** An ordered, immutable list of pairs of directions to light and viewer, with an identity (a hash of its values). */
typedef struct nqm_directions nqm_directions;

/** How nqm_directions_create() chooses. Take the defaults from nqm_directions_options_default(). */
typedef struct nqm_directions_options {
    size_t n;             /**< directions to make; 1..100000; default 500 */
    uint64_t seed;        /**< default 1 */
    double max_polar_rad; /**< theta_i and theta_o stay at or below this; 1 to 90 degrees; default 75 degrees
                                   (grazing data are noisy) */
    double theta_h_power; /**< theta_h = max * u^power, u uniform: denser toward 0 for powers above 1; 0.1 to
                                   most 100; default 2 */
    int grid; /**< 1: instead, the nodes of the grid of light transport, which reaches from wide lobes to mirrors
                                   and holds both orders of light and viewer: the directions of the models "default" and
                                   "transport"; the other members and the references have no effect. Default 0 */
    double oversampling;      /**< candidates per kept direction when references are given; 1..100; default 4 */
    nqm_progress_fn progress; /**< NULL: silent */
    void *progress_user;
} nqm_directions_options;

/** The defaults above. */
NQM_API nqm_directions_options nqm_directions_options_default(void);

/**
 * Make directions (paper, section 3.1): theta_d and phi_d uniform, theta_h denser toward 0, both polar angles bounded.
 * Candidates are drawn with a probability proportional to the energy of the references: the mean over them of the
 * cube root of the luminance, each reference normalised. The draw is stratified in theta_h, which keeps the density
 * above. The set is ordered by theta_h; the same options and references give the same set.
 *
 * @param options NULL: the defaults
 * @param refs    (n_refs) BRDFs that decide what "significant energy" is; n_refs 0: every candidate is kept
 * @return NQM_ERR_ARG, NQM_ERR_NOMEM, NQM_ERR_CANCELLED
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_directions_create(const nqm_directions_options *options, size_t n_refs,
                                                        const nqm_brdf *const *refs, nqm_directions **directions_ret,
                                                        nqm_error *err);
/** From n rows of theta_h, theta_d, phi_d in degrees, hd_deg (n, 3), in their order. theta_h in [0,90], theta_d in
 *  [0,90], phi_d in [-360,360]. */
NQM_API NQM_MUST_CHECK nqm_status nqm_directions_from_degrees(size_t n, const double *hd_deg,
                                                              nqm_directions **directions_ret, nqm_error *err);
/** Read a CSV with a header line that names the columns theta_h, theta_d and phi_d (degrees;
 *  others are ignored). */
NQM_API NQM_MUST_CHECK nqm_status nqm_directions_load_csv(const char *path, nqm_directions **directions_ret,
                                                          nqm_error *err);
/** Write such a CSV; reading it back gives the same set with the same id. */
NQM_API NQM_MUST_CHECK nqm_status nqm_directions_save_csv(const nqm_directions *directions, const char *path,
                                                          nqm_error *err);
/** Free a set; NULL is allowed. */
NQM_API void nqm_directions_free(nqm_directions *directions);

/** A set; the arrays belong to the directions. */
typedef struct nqm_directions_info {
    size_t n;              /**< directions */
    const double *degrees; /**< (n, 3) theta_h, theta_d, phi_d in degrees */
    const double *wi,
        *wo; /**< (n, 3) unit vectors to the light, and to the viewer, in the convention of <nqm/brdf.h> */
} nqm_directions_info;

NQM_API nqm_directions_info nqm_directions_get_info(const nqm_directions *directions);
/** Identity: the first 16 hex digits of the SHA-256 of the little-endian doubles of nqm_directions_info.degrees; it belongs to the
 *  directions. Empty when out of memory. Any thread. */
NQM_API const char *nqm_directions_id(const nqm_directions *directions);

/** How a pair becomes the network's input, after t = log(cbrt(rho) + 1) and whitening. */
typedef enum nqm_layout {
    NQM_LAYOUT_REF_TEST = 0,    /**< reference, test: 6 n values (the paper) */
    NQM_LAYOUT_REF_DIFF_ABSDIFF /**< reference, s (test - reference), s |test - reference|: 9 n values */
} nqm_layout;

/** What happens at directions where a BRDF has no value. */
typedef enum nqm_invalid_policy {
    NQM_INVALID_DROP = 0, /**< leave the direction out: of both members of a pair, in every metric; the network sees no
                               difference there (both members get the mean of the training references) */
    NQM_INVALID_ZERO,     /**< use 0 */
    NQM_INVALID_NEAREST,  /**< use the value of the nearest valid direction of the set */
    NQM_INVALID_ERROR     /**< refuse: NQM_ERR_INCOMPATIBLE */
} nqm_invalid_policy;

/** Counts of a sampling. */
typedef struct nqm_sample_report {
    size_t n;         /**< directions */
    size_t n_clamped; /**< values with a negative channel, given as 0 */
    size_t n_invalid; /**< directions without a value (before the policy) */
} nqm_sample_report;

/**
 * Sample a BRDF at every direction.
 *
 * @param policy  how directions without a value are filled; with NQM_INVALID_DROP their rgb is 0 and flag says which
 * @param rgb     (n, 3) receives f_r in 1/sr, finite and >= 0
 * @param flag    (n) receives an nqm_value_flag each; NULL allowed
 * @param report  NULL allowed
 * @return NQM_ERR_INCOMPATIBLE under NQM_INVALID_ERROR, or when no direction is valid (flag and report are filled then,
 *         too); NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_sample(const nqm_brdf *brdf, const nqm_directions *directions,
                                             nqm_invalid_policy policy, float *rgb, uint8_t *flag,
                                             nqm_sample_report *report, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
