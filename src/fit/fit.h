/* SPDX-License-Identifier: MIT
 *
 * fit.h - the list of models, and the parts of fitting an analytic one: the sampled reference, the model as a linear
 * combination of a diffuse and a specular lobe, and the search over the lobe's parameters. Every analytic model has the
 * form f_r = kd D + ks L(shape); D and L are evaluated through src/brdf by spec, so no formula is written twice.
 */
#ifndef NQM_SRC_FIT_H
#define NQM_SRC_FIT_H

#include "base/options.h"
#include "fit/encoders.h"

extern const nqm_option_table nqm_fit_option_table;
/** The words of nqm_fit_loss, NULL-terminated. */
extern const char *const nqm_fit_loss_words[];

enum { NQM_FIT_MAX_SHAPE = 3 };

/** The scale in which a parameter is searched. */
typedef enum nqm_fit_scale {
    NQM_FIT_SCALE_LINEAR,
    NQM_FIT_SCALE_LOG,
    NQM_FIT_SCALE_LOG_REST /* the logarithm of 1 - value */
} nqm_fit_scale;

/** One nonlinear parameter of an analytic model. */
typedef struct nqm_fit_shape {
    const char *key;  /* in the spec */
    double low, high; /* range of the search, ends excluded */
    nqm_fit_scale scale;
} nqm_fit_shape;

struct nqm_fit_entry;
typedef nqm_status (*nqm_encode_fn)(const nqm_brdf *ref, const struct nqm_fit_entry *entry,
                                    const nqm_fit_options *options, nqm_fit_report *report, nqm_brdf **brdf_ret,
                                    nqm_error *err);

/** A row of the list of models: an analytic model, or an encoding with its own function. */
typedef struct nqm_fit_entry {
    const char *name;
    size_t n_shape;
    nqm_fit_shape shape[NQM_FIT_MAX_SHAPE];
    size_t n_start;                                           /* starting points per lobe width */
    void (*start)(double alpha, size_t which, double *shape); /* writes starting point `which` in [0, n_start) */
    nqm_encode_fn encode;                                     /* NULL: analytic */
    nqm_code code;                                            /* of a learned encoder */
} nqm_fit_entry;

/** By name. NQM_ERR_ARG lists the names. */
NQM_MUST_CHECK nqm_status nqm_fit_entry_find(const char *name, const nqm_fit_entry **entry_ret, nqm_error *err);
/** Narrow the model's ranges to the bounds of the options. */
NQM_MUST_CHECK nqm_status nqm_fit_apply_bounds(const nqm_fit_options *options, nqm_fit_entry *model, nqm_error *err);
/** Position of a value in its range, 0 to 1 in the scale of the search; and the inverse. */
double nqm_fit_shape_position(const nqm_fit_shape *shape, double value);
double nqm_fit_shape_value(const nqm_fit_shape *shape, double position);

/** Values of a model's parameters. */
typedef struct nqm_fit_values {
    double shape[NQM_FIT_MAX_SHAPE];
    double kd[3], ks[3]; /* >= 0 */
} nqm_fit_values;

/** The spec of `model` with exactly these values. */
void nqm_fit_write_spec(const nqm_fit_entry *model, const nqm_fit_values *values, char spec[512]);

/** The reference at the directions of the fit. */
typedef struct nqm_fit_target {
    nqm_fit_loss loss;
    size_t n;
    double *wi, *wo; /* (n, 3); wi owns the block of all arrays */
    double *weight;  /* (n) factor of f_r inside the loss: cos(theta_i) cos(theta_o), or 1 */
    double *rgb;     /* (n, 3) f_r of the reference */
    double *goal;    /* (n, 3) nqm_fit_transform() of it */
} nqm_fit_target;

/** Draw the directions and sample `ref` there; nqm_free(target->wi) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_target_make(const nqm_brdf *ref, const nqm_fit_options *options,
                                              nqm_fit_target *target, nqm_error *err);

/** The transform inside the loss: log(1 + weight f), cbrt(f) or f; f >= 0. */
double nqm_fit_transform(nqm_fit_loss loss, double weight, double f);

/** f_r of a spec at the target's directions: rgb (n, 3). */
NQM_MUST_CHECK nqm_status nqm_fit_eval_spec(const nqm_fit_target *target, const char *spec, double *rgb,
                                            nqm_error *err);

/** Find the best values of a model for a target; *start_ret receives the index of the start that led to them. */
NQM_MUST_CHECK nqm_status nqm_fit_solve(const nqm_fit_entry *model, const nqm_fit_target *target,
                                        const nqm_fit_options *options, nqm_fit_values *values, size_t *start_ret,
                                        nqm_error *err);

/** A point on the path of the optimiser: n_steps (up to 1000) steps of Levenberg-Marquardt from random values, which are a
 *  function of the seed: shapes uniform in the scale of the search, the albedos that are best for them times random factors. */
NQM_MUST_CHECK nqm_status nqm_fit_follow(const nqm_fit_entry *model, const nqm_fit_target *target, uint64_t seed,
                                         size_t n_steps, nqm_fit_values *values, nqm_error *err);
/** The same for a model's name; spec receives the point. NQM_ERR_ARG: the model is not analytic. */
NQM_MUST_CHECK nqm_status nqm_fit_path(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                       uint64_t seed, size_t n_steps, char spec[512], nqm_error *err);

/** Root mean square residual of a spec; NQM_ERR_NOMEM, or what opening it gives. */
NQM_MUST_CHECK nqm_status nqm_fit_loss_of_spec(const nqm_fit_target *target, const char *spec, double *loss_ret,
                                               nqm_error *err);

#endif
