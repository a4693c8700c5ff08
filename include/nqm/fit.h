/* SPDX-License-Identifier: MIT
 *
 * nqm/fit.h - encode any BRDF: fit an analytic model, train a small network, compute a sparse code in a learned
 * dictionary, or predict a network by a learned hypernetwork. In libnqm-full only. The functions may be called from several
 * threads.
 */
#ifndef NQM_FIT_H
#define NQM_FIT_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The loss of a fit: root mean square or mean absolute difference over directions and channels. c = cos(theta_i)
 *  cos(theta_o), f_r in 1/sr. The first four have names of their own, the others those of the scalar metrics. */
typedef enum nqm_fit_loss {
    NQM_FIT_LOG = 0, /**< "log": root mean square difference of log(1 + f_r); the default; equal to NQM_FIT_RMS_LOGE */
    NQM_FIT_LOG_COS, /**< "log-cos": equal to NQM_FIT_RMS_LOGWE */
    NQM_FIT_CUBE_ROOT, /**< "cube-root": root mean square difference of cbrt(f_r) */
    NQM_FIT_LINEAR,    /**< "linear": equal to NQM_FIT_RMSE */
    NQM_FIT_RMSE,      /**< root mean square difference of f_r */
    NQM_FIT_MAE,       /**< mean absolute difference of f_r */
    NQM_FIT_RMS_CRWE,  /**< root mean square difference of cbrt(c f_r) */
    NQM_FIT_MA_CRWE,   /**< mean absolute difference of cbrt(c f_r) */
    NQM_FIT_RMS_LOGE,  /**< root mean square difference of log(1 + f_r) */
    NQM_FIT_MA_LOGE,   /**< mean absolute difference of log(1 + f_r) */
    NQM_FIT_RMS_LOGWE, /**< root mean square difference of log(1 + c f_r) */
    NQM_FIT_MA_LOGWE,  /**< mean absolute difference of log(1 + c f_r) */
    NQM_FIT_LOG_DIFF,  /**< mean absolute difference of log(f_r + 0.003) */
    NQM_FIT_N_LOSSES
} nqm_fit_loss;

/** A differentiable loss of the caller: a function of f_r at fixed directions. The arrays belong to the caller. */
typedef struct nqm_fit_visual {
    size_t n;              /**< direction pairs, > 0 */
    const double *wi, *wo; /**< (n, 3) unit vectors above the horizon */
    /** The loss at rgb (n, 3), f_r in 1/sr; gradient (n, 3) receives its derivatives by rgb. NaN ends the fit with
     *  NQM_ERR_NUMERIC. Called by one thread at a time. */
    double (*eval)(void *user, const double *rgb, double *gradient);
    void *user; /**< passed to `eval` */
} nqm_fit_visual;

/** One term of a loss that is a weighted sum. */
typedef struct nqm_fit_term {
    double weight;                /**< > 0 */
    nqm_fit_loss loss;            /**< unless `visual` */
    const nqm_fit_visual *visual; /**< NULL: `loss` */
} nqm_fit_term;

/** A narrower range for one parameter of an analytic model's lobe. */
typedef struct nqm_fit_bound {
    const char *key;  /**< key of the model's spec: "alpha", "f0", "n", ... */
    double low, high; /**< within the model's own range, in the units of the spec */
} nqm_fit_bound;

typedef struct nqm_fit_options {
    nqm_fit_loss loss; /**< loss of analytic models; default NQM_FIT_LOG */
    const nqm_fit_term
        *terms;     /**< (n_terms) of analytic models: their sum replaces `loss`; owned by the caller; default
                                  NULL */
    size_t n_terms; /**< 0 to 8; default 0 */
    /** Direction pairs, 200 to 1000000; default 6000. Analytic and shading models are fitted to a list of measured
     *  directions at all of these, and to a goniometer's grid at its nodes. */
    size_t n_directions;
    double max_polar_rad; /**< largest polar angle of both directions, 0.1 to 89.9 degrees; default 80 degrees */
    double
        highlight_fraction; /**< fraction of the pairs that are dense around the mirror direction (theta_h = max u^2 with
                                      uniform u; theta_d and phi_d uniform), so that narrow lobes influence the loss; the
                                      other pairs are uniform by solid angle; 0 to 1; default 0.05. Larger fractions
                                      make the dark base of metals too bright */
    size_t n_starts;        /**< lobe widths to start from, spaced evenly in their logarithm, 1 to 100; default 12; each
                                      is combined with a few values of the model's other parameters */
    const nqm_fit_bound *bounds; /**< (n_bounds) for analytic models; owned by the caller; default NULL */
    size_t n_bounds;             /**< default 0 */
    uint64_t seed;               /**< seed of the direction pairs; default 1 */
    const char
        *start; /**< a spec of the model ("ggx:kd=..."), from which the loss is minimised; of RGB lobe parameters of
                          analytic models the red value counts; default NULL: from the starts above */
    double
        simplify; /**< of shading models: keys get their defaults, and metals 0 or 1, where that raises the loss in total by at
                          most this fraction of itself plus a twentieth of the loss of a black surface; layers are removed
                          with a fit of the other keys; 0 (not done) to 1; default 0.01 */
    nqm_progress_fn progress; /**< NULL: silent. Called by the calling thread */
    void *progress_user;
} nqm_fit_options;

/** The defaults above. */
NQM_API nqm_fit_options nqm_fit_options_default(void);

typedef struct nqm_fit_report {
    char spec
        [2048]; /**< analytic and shading models: the result as a spec for nqm_brdf_open(); otherwise "": NQM_FILE_SAFETENSORS */
    double
        loss; /**< analytic models: value of the loss, or of the sum of the terms; networks: mean absolute difference of
                              log(1 + cos(theta_i) f_r); sparse codes: mean absolute difference of log(1 + c f_r) */
    size_t n_directions; /**< direction pairs in that loss */
    size_t best_start;   /**< index of the start that gave the result; 0 if there is only one */
    size_t n_numbers;    /**< numbers stored by the encoding: parameters, weights, or indices and coefficients */
} nqm_fit_report;

/**
 * Name of model i, NULL after the last; static storage. The NQM_FIT_N_ENCODINGS encodings of the paper come first: "ward",
 * "ggx", "nbrdf" (a network of 6-21-21-3: Sztrajman et al. 2021), "sparse-0" to "sparse-2" (sparse codes in a learned
 * dictionary, after Tongbuasirilai et al. 2022), "hyper-0" to "hyper-2" (a hypernetwork, after Gokbudak et al. 2024), with
 * the levels of the authors' files: 0 is the finest. Further ones follow: "sparse-low", "sparse-mid", "sparse-high" (4, 8
 * and 32 atoms), "hyper-low", "hyper-mid", "hyper-high" (12, 64 and 400 samples), and the analytic models "ward-duer",
 * "blinn-phong", "lafortune", "cook-torrance", "ashikhmin-shirley", "abc" (the microfacet model of Low et al. 2012),
 * "smooth" (their smooth-surface model). The shading models of renderers' materials (doc/materials.md) are the last ones.
 */
NQM_API const char *nqm_fit_model(size_t i);
enum { NQM_FIT_N_ENCODINGS = 9, NQM_FIT_FIRST_SHADING = 22 };

#ifdef __cplusplus
}
#endif
#endif
