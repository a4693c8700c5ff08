/* SPDX-License-Identifier: MIT
 *
 * nqm/fit.h - fit an analytic model to any BRDF. In libnqm-full only.
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

typedef struct nqm_fit_options {
    nqm_fit_loss loss;         /**< default NQM_FIT_LOG */
    size_t n_directions;       /**< direction pairs; default 6000 */
    double max_polar_rad;      /**< both directions stay below it; default 80 degrees */
    double highlight_fraction; /**< share of the pairs with theta_h = max u^2, theta_d and phi_d uniform (u uniform):
                                    dense around the mirror direction, so that the sharpest lobes count; the others
                                    are uniform by solid angle; 0..1; default 0.05: more brighten metals' dark base */
    size_t n_starts;           /**< starting values of the lobe width, spaced evenly in its logarithm; default 12 */
    uint64_t seed;             /**< default 1 */
    nqm_progress_fn progress;  /**< NULL: silent */
    void *progress_user;
} nqm_fit_options;

/** The defaults above. */
NQM_API nqm_fit_options nqm_fit_options_default(void);
/** "log", "log-cos", "cube-root" or "linear"; 0 when `text` is none of them. */
NQM_API int nqm_fit_loss_parse(const char *text, nqm_fit_loss *loss_ret);
/** The word for a loss; static storage. */
NQM_API const char *nqm_fit_loss_name(nqm_fit_loss loss);

typedef struct nqm_fit_report {
    char spec[512];      /**< the result, as nqm_brdf_open() takes it */
    double loss;         /**< root mean square of the loss's residuals */
    size_t n_directions; /**< that counted */
    size_t best_start;   /**< which start won */
} nqm_fit_report;

/**
 * Fit `model` ("ward", "ggx") to `ref`: one lobe with a specular RGB colour over a Lambert base. From each start the
 * albedos are solved linearly, the best starts are refined by Levenberg-Marquardt over all parameters. Deterministic.
 *
 * @param options  NULL: the defaults
 * @return NQM_ERR_ARG (unknown model), NQM_ERR_INCOMPATIBLE (too few valid directions), NQM_ERR_NUMERIC,
 *         NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_fit(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                          nqm_fit_report *report_ret, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
