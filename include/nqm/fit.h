/* SPDX-License-Identifier: MIT
 *
 * nqm/fit.h - encode any BRDF: fit an analytic model, train a small network, code it sparsely in a learned dictionary,
 * or let a learned hypernetwork write the network; and the learning of the last two. In libnqm-full only.
 */
#ifndef NQM_FIT_H
#define NQM_FIT_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What a fit minimises: a mean over directions and channels; c = cos(theta_i) cos(theta_o). */
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
    nqm_fit_loss loss;         /**< default NQM_FIT_LOG */
    size_t n_directions;       /**< direction pairs; default 6000 */
    double max_polar_rad;      /**< both directions stay below it; default 80 degrees */
    double highlight_fraction; /**< share of the pairs with theta_h = max u^2, theta_d and phi_d uniform (u uniform):
                                    dense around the mirror direction, so that the sharpest lobes count; the others
                                    are uniform by solid angle; 0..1; default 0.05: more brighten metals' dark base */
    size_t n_starts;           /**< starting values of the lobe width, spaced evenly in its logarithm; default 12; each
                                    with all combinations of a few values of the model's other shape parameters */
    const nqm_fit_bound *bounds; /**< (n_bounds) of analytic models; lent for the call; default NULL */
    size_t n_bounds;             /**< default 0 */
    uint64_t seed;               /**< default 1 */
    nqm_progress_fn progress;    /**< NULL: silent */
    void *progress_user;
} nqm_fit_options;

/** The defaults above. */
NQM_API nqm_fit_options nqm_fit_options_default(void);
/** "log", "log-cos", "cube-root" or "linear"; 0 when `text` is none of them. */
NQM_API int nqm_fit_loss_parse(const char *text, nqm_fit_loss *loss_ret);
/** The word for a loss; static storage. */
NQM_API const char *nqm_fit_loss_name(nqm_fit_loss loss);

typedef struct nqm_fit_report {
    char spec[512];      /**< analytic models: the result, as nqm_brdf_open() takes it; else "": nqm_brdf_save() it */
    double loss;         /**< analytic models: root mean square of the loss's residuals; networks: the mean absolute
                              difference of log(1 + cos(theta_i) f_r); codes: of log(1 + c f_r) */
    size_t n_directions; /**< that counted */
    size_t best_start;   /**< which start won; 0 where there is one */
    size_t n_numbers;    /**< numbers that the encoding keeps: parameters, weights, or indices and coefficients */
} nqm_fit_report;

/**
 * The models that a BRDF can be fitted with, in a fixed order. First the nine encodings of the paper: "ward", "ggx",
 * "nbrdf" (a network of 6-21-21-3: Sztrajman et al. 2021), "sparse-low", "sparse-mid", "sparse-high" (sparse codes in a
 * learned dictionary, after Tongbuasirilai et al. 2022), "hyper-low", "hyper-mid", "hyper-high" (a hypernetwork that
 * reads a few, some or many samples, after Gokbudak et al. 2024); then the further analytic models: "ward-duer",
 * "blinn-phong", "lafortune", "cook-torrance", "ashikhmin-shirley", "abc" (the microfacet model of Low et al. 2012),
 * "smooth" (their smooth-surface model).
 */
NQM_API size_t nqm_fit_model_count(void);
/** Name of model i in [0, count); static storage. */
NQM_API const char *nqm_fit_model_name(size_t i);
/** One line on it: formula or budget and source; static storage. */
NQM_API const char *nqm_fit_model_summary(size_t i);
/** 1 when `key` is a lobe parameter of the analytic model `name`, for which bounds can be given; else 0. */
NQM_API int nqm_fit_model_has(const char *name, const char *key);
/** How many of them, from the first, are the paper's encodings. */
enum { NQM_FIT_N_ENCODINGS = 9 };

/**
 * Fit `model` to `ref`. Analytic models are one lobe with a specular RGB colour over a Lambert base: from each start the
 * albedos are solved linearly, the best starts are refined by Levenberg-Marquardt over all parameters. Deterministic.
 *
 * @param options   NULL: the defaults; of these, `loss` and `n_starts` are for analytic models, the networks and codes
 *                  have losses of their own (doc/encodings.md). "nbrdf" trains up to the horizon, on 16 directions for
 *                  each of `n_directions`
 * @param brdf_ret  NULL, or receives the result; free with nqm_brdf_free()
 * @return NQM_ERR_ARG (unknown model, bounds for what it does not have), NQM_ERR_INCOMPATIBLE (too few valid directions), NQM_ERR_NUMERIC,
 *         NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_fit(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                          nqm_fit_report *report_ret, nqm_brdf **brdf_ret, nqm_error *err);

/* ---- what the learned encodings lean on --------------------------------------------------------------------------- */

/** What can be learned from a set of BRDFs. The library embeds one of each, learned from training materials only. */
typedef enum nqm_encoder {
    NQM_ENCODER_SPARSE = 0, /**< the dictionary of "sparse-*" */
    NQM_ENCODER_HYPER       /**< the hypernetwork of "hyper-*" */
} nqm_encoder;

typedef struct nqm_learn_options {
    size_t n_steps;           /**< of the optimiser; 0: the encoder's own default */
    uint64_t seed;            /**< default 1 */
    nqm_progress_fn progress; /**< NULL: silent */
    void *progress_user;
} nqm_learn_options;

/** The defaults above. */
NQM_API nqm_learn_options nqm_learn_options_default(void);

/**
 * Learn an encoder from BRDFs and write it as a safetensors file. Deterministic: the same bits for any number of threads.
 *
 * @param n      number of BRDFs
 * @param refs   (n)
 * @param names  (n) kept in the file's metadata "references" (a JSON list), so that a reader can prove what it has seen
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_learn(nqm_encoder what, size_t n, const nqm_brdf *const *refs,
                                            const char *const *names, const nqm_learn_options *options,
                                            const char *path, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
