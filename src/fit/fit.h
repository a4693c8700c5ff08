/* SPDX-License-Identifier: MIT
 *
 * fit.h - the parts of fitting an analytic model: the sampled reference, the model as a linear mix of two lobes, and
 * the search over lobe shapes. Every model that is fitted has the form f_r = kd D + ks L(shape), with D and L taken
 * from src/brdf by spec, so that no formula of a model is written twice.
 */
#ifndef NQM_SRC_FIT_H
#define NQM_SRC_FIT_H

#include "base/base.h"
#include <nqm/fit.h>

enum { NQM_FIT_MAX_SHAPE = 3 };

/** In what a parameter is searched. */
typedef enum nqm_fit_scale {
    NQM_FIT_SCALE_LINEAR,
    NQM_FIT_SCALE_LOG,
    NQM_FIT_SCALE_LOG_REST /* the logarithm of 1 - value */
} nqm_fit_scale;

/** One nonlinear parameter of a model. */
typedef struct nqm_fit_shape {
    const char *key;  /* in the spec */
    double low, high; /* open bounds */
    nqm_fit_scale scale;
} nqm_fit_shape;

/** A model that can be fitted. */
typedef struct nqm_fit_model {
    const char *name;
    size_t n_shape;
    nqm_fit_shape shape[NQM_FIT_MAX_SHAPE];
    size_t n_start;                                           /* starts a width */
    void (*start)(double alpha, size_t which, double *shape); /* shape of start `which` in [0, n_start) */
} nqm_fit_model;

/** By name, or NULL. */
const nqm_fit_model *nqm_fit_model_find(const char *name);
/** Narrow the model's bounds to those of the options. */
NQM_MUST_CHECK nqm_status nqm_fit_apply_bounds(const nqm_fit_options *options, nqm_fit_model *model, nqm_error *err);
/** Where a value lies between the bounds of its parameter, in the scale of the search: 0 to 1; and back. */
double nqm_fit_shape_place(const nqm_fit_shape *shape, double value);
double nqm_fit_shape_value(const nqm_fit_shape *shape, double place);

/** Options within their ranges? */
NQM_MUST_CHECK nqm_status nqm_fit_check_options(const nqm_fit_options *options, nqm_error *err);
/** nqm_fit() for an analytic model that exists. */
NQM_MUST_CHECK nqm_status nqm_fit_analytic(const nqm_brdf *ref, const char *model_name, const nqm_fit_options *options,
                                           nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err);

/** Values of a model's parameters. */
typedef struct nqm_fit_values {
    double shape[NQM_FIT_MAX_SHAPE];
    double kd[3], ks[3]; /* >= 0 */
} nqm_fit_values;

/** Round to six significant digits, so that the spec stays readable. */
void nqm_fit_round(const nqm_fit_model *model, nqm_fit_values *values);
/** The spec of `model` with exactly these values. */
void nqm_fit_write_spec(const nqm_fit_model *model, const nqm_fit_values *values, char spec[512]);

/** The reference at the directions of the fit. */
typedef struct nqm_fit_target {
    nqm_fit_loss loss;
    size_t n;
    double *wi, *wo; /* (n, 3) */
    double *weight;  /* (n) factor on f_r inside the loss: cos(theta_i) cos(theta_o), or 1 */
    double *rgb;     /* (n, 3) f_r of the reference */
    double *goal;    /* (n, 3) the same through the loss's transform */
} nqm_fit_target;

/** Draw the directions and sample `ref` there; free with nqm_fit_target_free() whatever the outcome. */
NQM_MUST_CHECK nqm_status nqm_fit_target_make(const nqm_brdf *ref, const nqm_fit_options *options,
                                              nqm_fit_target *target, nqm_error *err);
void nqm_fit_target_free(nqm_fit_target *target);

/** The transform inside the loss: log(1 + weight f), cbrt(f) or f; f >= 0. */
double nqm_fit_transform(nqm_fit_loss loss, double weight, double f);

/** Values of one channel of a spec at the target's directions: lobe (n). */
NQM_MUST_CHECK nqm_status nqm_fit_lobe(const nqm_fit_target *target, const char *spec, double *lobe, nqm_error *err);

/**
 * The best values of a model for a target.
 *
 * @param loss_ret   receives the root mean square residual
 * @param start_ret  receives the start that won
 */
NQM_MUST_CHECK nqm_status nqm_fit_solve(const nqm_fit_model *model, const nqm_fit_target *target,
                                        const nqm_fit_options *options, nqm_fit_values *values, size_t *start_ret,
                                        nqm_error *err);

/** Root mean square residual of a spec; NQM_ERR_NOMEM, or what opening it gives. */
NQM_MUST_CHECK nqm_status nqm_fit_loss_of_spec(const nqm_fit_target *target, const char *spec, double *loss_ret,
                                               nqm_error *err);

#endif
