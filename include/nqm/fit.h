/* SPDX-License-Identifier: MIT
 *
 * nqm/fit.h - encode any BRDF: fit an analytic model, train a small network, compute a sparse code in a learned
 * dictionary, or predict a network by a learned hypernetwork; and learn the dictionary and the hypernetwork. In
 * libnqm-full only. The functions may be called from several threads.
 */
#ifndef NQM_FIT_H
#define NQM_FIT_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The loss of a fit: a mean over directions and channels. c = cos(theta_i) cos(theta_o), f_r in 1/sr. */
typedef enum nqm_fit_loss {
    NQM_FIT_LOG = 0,   /**< squared difference of log(1 + f_r); the default */
    NQM_FIT_LOG_COS,   /**< squared difference of log(1 + c f_r) */
    NQM_FIT_CUBE_ROOT, /**< squared difference of cbrt(f_r) */
    NQM_FIT_LINEAR     /**< squared difference of f_r */
} nqm_fit_loss;

/** A narrower range for one parameter of an analytic model's lobe. */
typedef struct nqm_fit_bound {
    const char *key;  /**< as in the model's spec: "alpha", "f0", "n", ... */
    double low, high; /**< within the model's own range, in the units of the spec */
} nqm_fit_bound;

typedef struct nqm_fit_options {
    nqm_fit_loss loss;    /**< of analytic models; default NQM_FIT_LOG */
    size_t n_directions;  /**< direction pairs, 200 to 1000000; default 6000 */
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
    uint64_t seed;               /**< of the direction pairs; default 1 */
    nqm_progress_fn progress;    /**< NULL: silent */
    void *progress_user;
} nqm_fit_options;

/** The defaults above. */
NQM_API nqm_fit_options nqm_fit_options_default(void);

typedef struct nqm_fit_report {
    char spec[512]; /**< analytic models: the result as a spec for nqm_brdf_open(); otherwise "": nqm_brdf_save() it */
    double loss;    /**< analytic models: root mean square residual of the loss; networks: mean absolute difference of
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
 * "smooth" (their smooth-surface model).
 */
NQM_API const char *nqm_fit_model(size_t i);
enum { NQM_FIT_N_ENCODINGS = 9 };
/** 1 if `key` is a lobe parameter of the analytic model `name`, which nqm_fit_options.bounds can restrict; otherwise 0. */
NQM_API int nqm_fit_model_has(const char *name, const char *key);

/**
 * Fit `model` to `ref`. Analytic models are one lobe with a specular RGB colour over a Lambert base: each start solves the
 * albedos by linear least squares, and the best starts are refined by Levenberg-Marquardt over all parameters. The result
 * is deterministic.
 *
 * @param options   NULL: the defaults. `loss`, `n_starts` and `bounds` apply to analytic models; networks and sparse codes
 *                  have their own losses (doc/encodings.md). "nbrdf" trains on 16 times `n_directions` directions, up to the
 *                  horizon
 * @param brdf_ret  NULL, or receives the result; free with nqm_brdf_free()
 * @return NQM_ERR_ARG (unknown model, options out of range, bounds that the model does not have), NQM_ERR_INCOMPATIBLE (too
 *         few valid directions), NQM_ERR_MODEL (the build has no dictionary or hypernetwork), NQM_ERR_NUMERIC,
 *         NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_fit(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                          nqm_fit_report *report_ret, nqm_brdf **brdf_ret, nqm_error *err);

/* ---- learned encoders --------------------------------------------------------------------------------------------- */

/** What can be learned from a set of BRDFs. The library embeds one of each, learned from training materials only. */
typedef enum nqm_encoder {
    NQM_ENCODER_SPARSE = 0, /**< the dictionary of "sparse-*" */
    NQM_ENCODER_HYPER       /**< the hypernetwork of "hyper-*" */
} nqm_encoder;

typedef struct nqm_learn_options {
    size_t n_steps; /**< steps of the optimiser; 0 (default): 40 for the dictionary, 16000 for the hypernetwork */
    uint64_t seed;  /**< default 1 */
    nqm_progress_fn progress; /**< NULL: silent */
    void *progress_user;
} nqm_learn_options;

/** The defaults above. */
NQM_API nqm_learn_options nqm_learn_options_default(void);

/**
 * Learn an encoder from BRDFs and write it as a safetensors file. Deterministic: the same bytes for any number of threads.
 *
 * @param n      number of BRDFs
 * @param refs   (n)
 * @param names  (n) UTF-8, stored in the file's metadata "references" (a JSON list): the record of what it has been learned
 *               from
 * @return NQM_ERR_ARG (n = 0, a name is not UTF-8), NQM_ERR_INCOMPATIBLE (a BRDF has too few values), NQM_ERR_NUMERIC,
 *         NQM_ERR_CANCELLED, NQM_ERR_IO, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_learn(nqm_encoder what, size_t n, const nqm_brdf *const *refs,
                                            const char *const *names, const nqm_learn_options *options,
                                            const char *path, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
