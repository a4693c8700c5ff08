/* SPDX-License-Identifier: MIT
 *
 * nqm/match.h - fits that look right: analytic and shading models fitted by the predicted difference of pictures, by
 * distances of BRDF values, or by sums of both. In libnqm-full only. Any thread. NQM_EXPERIMENTAL.
 */
#ifndef NQM_MATCH_H
#define NQM_MATCH_H

#include <nqm/fit.h>
#include <nqm/metric.h>
#include <nqm/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * What a match minimises. `text` is a sum "WEIGHT*WORD+WEIGHT*WORD..." of at most 8 terms; a weight that is left out is 1. The
 * words:
 *  - "nqm": the Delta-E ITP that `metric` predicts; 10 - JOD for a model that predicts none (both 0 for equal BRDFs);
 *  - "transport": the same of `transport`;
 *  - the losses of nqm_fit_loss: "log", "rmse", ..., "log_diff".
 *
 * "auto" or "auto:SUM" selects in two stages (after Bieron and Peers 2020, DOI 10.1111/cgf.14052): fits under the
 * losses "log", "log-cos", "rms_crwe" and "log_diff" are candidates, each (of shading models the best) is polished by
 * SUM (default: "100*ma_crwe+transport"), and of all the one with the smallest Delta-E on rays of `scene` is the
 * result: no step of a fit has seen these directions. nqm_fit_options.start is one of the starts. A reference with
 * values at fewer than 90 % of the directions of `transport`, as a grid of a goniometer that ends at 80 degrees or a
 * list whose rows are more than a degree away, is fitted by "ma_crwe" alone, which `selected` says. `transport` and not
 * `scene` compares lists. Of an anisotropic reference, "transport" is Delta-E on other rays of `scene`; without a scene
 * it is refused, and "auto" fits by "ma_crwe" alone. A shading model is fitted at half of the directions, and its
 * result is simplified (nqm_fit_options.simplify).
 */
typedef struct nqm_match_loss {
    const char *text;
    const nqm_model *metric;    /**< NULL: not needed by `text` */
    const nqm_model *transport; /**< NULL: not needed by `text` */
    const nqm_scene *scene; /**< scene that compares results, on 32768 rays (nqm_rays_draw); NULL: `transport` compares,
                                     at the directions of the fits */
} nqm_match_loss;

typedef struct nqm_match_report {
    nqm_fit_report fit; /**< report of the best fit; its `loss` is the value of the sum, or `difference` for "auto" */
    char selected[128]; /**< "auto": the steps that led to the result ("log-cos, then nqm"); otherwise "" */
    double
        difference; /**< Delta-E of the result on the rays of `scene`, without it by `transport`; NaN without both, and for
                           models that are not analytic */
} nqm_match_report;

/**
 * Fit `model` to `ref` by a loss. Levenberg-Marquardt with bounds over all continuous keys minimises the squares of the BRDF-space
 * term with the largest weight (without one: of NQM_FIT_LOG) from several starts. A loss that is not one root mean square is then
 * minimised from the best of them by a quasi-Newton method. The result is deterministic. Encodings have their own losses
 * (doc/encodings.md), and `loss` does not apply; "nbrdf" trains on 16 times `n_directions` directions, up to the horizon.
 *
 * Analytic models are one lobe with a specular RGB colour over a Lambert base. They start from `n_starts` lobe widths, each
 * with the albedos that are best for it. Shading models start from three roughnesses, without and with metal, and get layers
 * (coat, sheen) where they help; whole-number keys keep the value of `start` or their default; `bounds` apply to any key (low =
 * high fixes it). The spec of the result leaves out keys with their default.
 *
 * Of an anisotropic reference, keys with two values are both free, along the axes of its lobe, and keys of anisotropy
 * have the values of the lobe, which is measured; the result is a `rotate:` of the model, by the azimuth of the lobe,
 * unless a key of the model says that. A start keeps its own anisotropy.
 *
 * @param loss        NULL: the `loss` or the `terms` of the options
 * @param options     NULL: the defaults of nqm_fit_options_default(). Bounds and all about starts apply to analytic models
 * @param report_ret  receives the report
 * @param brdf_ret    NULL, or receives the result; free with nqm_brdf_free()
 * @return NQM_ERR_ARG (unknown model, options out of range, bounds that the model does not have, a fault in `text`, whose word the
 *         message names, a word without its model), NQM_ERR_INCOMPATIBLE (too few valid directions, or `ref` has values at too few
 *         directions of a model), NQM_ERR_MODEL (the build has no dictionary or hypernetwork), NQM_ERR_NUMERIC, NQM_ERR_CANCELLED,
 *         NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_match(const nqm_brdf *ref, const char *model, const nqm_match_loss *loss,
                                            const nqm_fit_options *options, nqm_match_report *report_ret,
                                            nqm_brdf **brdf_ret, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
