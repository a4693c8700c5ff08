/* SPDX-License-Identifier: MIT
 *
 * shading.h - fits of the shading models of renderers: all continuous parameters at once. A search space lists the free
 * parameters with their bounds and scales; a target or an objective gives the loss; residuals are minimised by
 * Levenberg-Marquardt with bounds, sums of terms by a quasi-Newton method with bounds. Derivatives are forward differences.
 */
#ifndef NQM_SRC_FIT_SHADING_H
#define NQM_SRC_FIT_SHADING_H

#include "brdf/core/spec.h"
#include "fit/fit.h"

enum { NQM_SHADING_MAX_FREE = 96, NQM_SHADING_MAX_STARTS = 8, NQM_SHADING_STEPS = 40 };

/** A free parameter: one value of a key. The search sees x = units * log(value - low + offset), or units * (value - low) when
 *  offset is 0. */
typedef struct nqm_shading_parameter {
    size_t key, channel;
    size_t layer;     /* key of the amount of the layer that it describes; itself: none */
    double low, high; /* of the value */
    double units, offset;
} nqm_shading_parameter;

typedef struct nqm_shading_space {
    const nqm_analytic_model *model;
    nqm_spec_values defaults; /* with the values of fixed keys */
    size_t n;                 /* free parameters */
    nqm_shading_parameter parameters[NQM_SHADING_MAX_FREE];
} nqm_shading_space;

/** Values of a model and their loss. */
typedef struct nqm_shading_point {
    nqm_spec_values values;
    double loss;
    size_t start;
} nqm_shading_point;

/* ---- the space (shading_space.c) ---------------------------------------------------------------------------------- */

/** Whole-number keys are fixed at the values of options->start, or at their defaults; bounds of the options apply.
 *  NQM_ERR_ARG: a bound of an unknown key or outside its range, or a start of another model. */
NQM_MUST_CHECK nqm_status nqm_shading_space_make(const nqm_analytic_model *model, const nqm_fit_options *options,
                                                 nqm_shading_space *space, nqm_error *err);
/** The values of a spec, moved into the bounds. */
NQM_MUST_CHECK nqm_status nqm_shading_read_spec(const nqm_shading_space *space, const char *spec,
                                                nqm_spec_values *values, nqm_error *err);
/** The spec with rounded values, in which keys with their default are left out; the values become those of the spec.
 *  NQM_ERR_LIMIT: longer than `spec`. */
NQM_MUST_CHECK nqm_status nqm_shading_write_spec(const nqm_shading_space *space, nqm_spec_values *values, char *spec,
                                                 size_t n_spec, nqm_error *err);
/** The coordinates of the free parameters: x, and their bounds low and high (space->n). */
void nqm_shading_coordinates(const nqm_shading_space *space, const nqm_spec_values *values, double *x);
void nqm_shading_bounds(const nqm_shading_space *space, double *low, double *high);
/** The values at the coordinates x; keys that are not free are unchanged. */
void nqm_shading_values(const nqm_shading_space *space, const double *x, nqm_spec_values *values);
/** Whether a key is the amount of a layer over the base, 0 by default: a clear coat, sheen. */
bool nqm_shading_is_layer(const nqm_spec_key *key);
/** Whether a parameter has no effect because its layer is off. */
bool nqm_shading_is_idle(const nqm_shading_parameter *parameter, const nqm_spec_values *values);
/** Key of a name in the schema; n_keys: there is none. */
size_t nqm_shading_key(const nqm_spec_schema *schema, const char *name);
/** Fix a key at the value it has in `values`: its parameters leave the space. */
void nqm_shading_fix(nqm_shading_space *space, size_t key);

/** f_r in 1/sr: rgb (n, 3); zeros below the horizon. */
void nqm_shading_eval(const nqm_analytic_model *model, const nqm_spec_values *values, size_t n, const double *wi,
                      const double *wo, double *rgb);
/** Replace *values by generic start i: roughness, metal and base colour; other keys have their defaults. false: there are only
 *  i. diffuse: (3) base colour of a dielectric; albedo: (3) that of a metal. */
bool nqm_shading_start(const nqm_shading_space *space, size_t i, const double *diffuse, const double *albedo,
                       nqm_spec_values *values);
/** Turn on layer i, such as a clear coat, with a typical width; rough: over a base three times as rough. false: there are only
 *  i. */
bool nqm_shading_add_layer(const nqm_shading_space *space, size_t i, bool rough, nqm_spec_values *values);

/* ---- least squares (shading_squares.c) ---------------------------------------------------------------------------- */

/** Minimise the target's root mean square (or, of mean absolute losses, its reweighted squares) from point->values by at most
 *  n_steps steps. The point is replaced, never by a worse one. */
NQM_MUST_CHECK nqm_status nqm_shading_refine(const nqm_shading_space *space, const nqm_fit_target *target,
                                             size_t n_steps, nqm_ticker *ticker, nqm_shading_point *point,
                                             nqm_error *err);

/** The approximate second derivatives (space->n, space->n) of the target's loss by the coordinates. */
NQM_MUST_CHECK nqm_status nqm_shading_curvature(const nqm_shading_space *space, const nqm_fit_target *target,
                                                const nqm_spec_values *values, double *curvature, nqm_error *err);

/* ---- sums of terms (shading_objective.c) -------------------------------------------------------------------------- */

typedef struct nqm_shading_objective nqm_shading_objective;

/** `target` gives the directions of BRDF-space terms; it and the terms must outlive the objective. */
NQM_MUST_CHECK nqm_status nqm_shading_objective_make(const nqm_shading_space *space, const nqm_fit_target *target,
                                                     size_t n_terms, const nqm_fit_term *terms,
                                                     nqm_shading_objective **objective_ret, nqm_error *err);
void nqm_shading_objective_free(nqm_shading_objective *objective);
/** The sum at these values. NQM_ERR_NUMERIC: a term is not finite. */
NQM_MUST_CHECK nqm_status nqm_shading_objective_value(nqm_shading_objective *objective, const nqm_spec_values *values,
                                                      double *value, nqm_error *err);
/** The change of the sum, linear in f_r, from the values of the last nqm_shading_objective_value() to these near ones. */
double nqm_shading_objective_difference(nqm_shading_objective *objective, const nqm_spec_values *values);
/** Approximate second derivatives (space->n, space->n) at the values of the last evaluation; visual terms count like the
 *  others in proportion. Positive definite. */
NQM_MUST_CHECK nqm_status nqm_shading_objective_curvature(const nqm_shading_objective *objective,
                                                          const nqm_shading_space *space, const nqm_spec_values *values,
                                                          double *curvature, nqm_error *err);
/** Round the kinks of mean absolute losses over `fraction` of their last value (0: not). false: there are none. */
bool nqm_shading_objective_round(nqm_shading_objective *objective, double fraction);
/** The sum for a black surface. */
NQM_MUST_CHECK nqm_status nqm_shading_objective_black(nqm_shading_objective *objective, double *value, nqm_error *err);

/* ---- quasi-Newton steps with bounds (shading_descend.c) ----------------------------------------------------------- */

/** step (n) = - (curvature + damping * its diagonal)^-1 gradient for the entries that are not fixed, 0 for the others.
 *  curvature (n, n): symmetric; factor (n, n): scratch. */
void nqm_shading_solve(size_t n, const double *curvature, const bool *fixed, const double *gradient, double damping,
                       double *factor, double *step);
/** Minimise the objective from point->values over the free parameters of `space` by at most max_steps steps (under
 *  NQM_SHADING_STEPS: with kinks rounded once only); never replaced by a worse one. */
NQM_MUST_CHECK nqm_status nqm_shading_descend(nqm_shading_objective *objective, const nqm_shading_space *space,
                                              size_t max_steps, nqm_ticker *ticker, nqm_shading_point *point,
                                              nqm_error *err);

/* ---- stages (shading_fit.c) --------------------------------------------------------------------------------------- */

/** Least-squares fits under the target's loss from options->start and, unless only_start, from the generic starts: best
 *  (NQM_SHADING_MAX_STARTS) is also scratch and receives n_best of them, the smallest loss first. */
NQM_MUST_CHECK nqm_status nqm_shading_search(const nqm_shading_space *space, const nqm_brdf *ref,
                                             const nqm_fit_target *target, const nqm_fit_options *options,
                                             bool only_start, nqm_ticker *ticker, nqm_shading_point *best,
                                             size_t *n_best, nqm_error *err);
/** Set keys to their defaults where that raises the objective by at most `tolerance` (0: not done) times its value
 *  plus a twentieth of that of a black surface, in total; with short fits of the other parameters. `thin` and its target need
 *  fewer directions than the fit. The keys leave the space; a last descent is left to the caller. */
NQM_MUST_CHECK nqm_status nqm_shading_simplify(nqm_shading_objective *thin, const nqm_fit_target *target,
                                               nqm_shading_space *space, double tolerance, nqm_ticker *ticker,
                                               nqm_shading_point *point, nqm_error *err);
/** About n directions of a target, evenly; nqm_free(thin->wi) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_shading_thin(const nqm_fit_target *from, size_t n, nqm_fit_target *thin, nqm_error *err);
/** Simplify the point, then minimise `objective`, the sum of `terms` on `target`, without the keys that have become plain. */
NQM_MUST_CHECK nqm_status nqm_shading_finish(const nqm_shading_space *space, const nqm_fit_target *target,
                                             size_t n_terms, const nqm_fit_term *terms,
                                             nqm_shading_objective *objective, double tolerance, nqm_ticker *ticker,
                                             nqm_shading_point *point, nqm_error *err);
/** The rounded point as a report; the point becomes what the spec says. */
NQM_MUST_CHECK nqm_status nqm_shading_report(const nqm_shading_space *space, nqm_shading_objective *objective,
                                             size_t n_directions, nqm_shading_point *point, nqm_fit_report *report,
                                             nqm_error *err);
/** The whole fit. */
NQM_MUST_CHECK nqm_status nqm_fit_shading_model(const nqm_brdf *ref, const nqm_fit_entry *entry,
                                                const nqm_fit_options *options, nqm_fit_report *report,
                                                nqm_brdf **brdf_ret, nqm_error *err);

#endif
