/* SPDX-License-Identifier: MIT
 *
 * fit.h - the list of models, and the parts of fitting an analytic one: the sampled reference, the model as a linear
 * combination of a diffuse and a specular lobe, and the search over the lobe's parameters. Every analytic model has the
 * form f_r = kd D + ks L(shape); D and L are evaluated through src/brdf by spec, so no formula is written twice.
 */
#ifndef NQM_SRC_FIT_H
#define NQM_SRC_FIT_H

#include "base/options.h"
#include "encode/encode.h"
#include "math/values.h"
#include <nqm/fit.h>

extern const nqm_option_table nqm_fit_option_table;

/* ---- losses ------------------------------------------------------------------------------------------------------ */

/** Indexed by nqm_fit_loss (fit_loss.c). */
extern const nqm_value_difference nqm_fit_losses[];
/** The words of nqm_fit_loss, NULL-terminated. The first NQM_FIT_N_CORPUS_LOSSES are those of the paths in corpora. */
extern const char *const nqm_fit_loss_words[];
enum { NQM_FIT_N_CORPUS_LOSSES = 4 };

/** The curve of a loss at weight f, and its derivative by f; f >= 0. */
double nqm_fit_transform(nqm_fit_loss loss, double weight, double f);
double nqm_fit_transform_slope(nqm_fit_loss loss, double weight, double f);

/* ---- models ------------------------------------------------------------------------------------------------------ */

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

/** A row of the list of models: an analytic model, a shading model, or an encoding. */
typedef struct nqm_fit_entry {
    const char *name;
    size_t n_shape;
    nqm_fit_shape shape[NQM_FIT_MAX_SHAPE];
    size_t n_start;                                           /* starting points per lobe width */
    void (*start)(double alpha, size_t which, double *shape); /* writes starting point `which` in [0, n_start) */
    nqm_encode_fn encode;                                     /* NULL: an analytic or shading model */
    size_t n_code;                                            /* `n` and `step` of its options */
    float step;
    const struct nqm_analytic_model *shading; /* a shading model, whose name is that of its schema; otherwise NULL */
} nqm_fit_entry;

/** By name. NQM_ERR_ARG lists the names. */
NQM_MUST_CHECK nqm_status nqm_fit_entry_find(const char *name, const nqm_fit_entry **entry_ret, nqm_error *err);
/** Narrow the model's ranges to the bounds of the options. */
NQM_MUST_CHECK nqm_status nqm_fit_apply_bounds(const nqm_fit_options *options, nqm_fit_entry *model, nqm_error *err);
/** Position of a value in its range, 0 to 1 in the scale of the search; and the inverse. */
double nqm_fit_shape_position(const nqm_fit_shape *shape, double value);
double nqm_fit_shape_value(const nqm_fit_shape *shape, double position);
/** The derivative of the value by the position. */
double nqm_fit_shape_derivative(const nqm_fit_shape *shape, double value);

/** Values of a model's parameters. */
typedef struct nqm_fit_values {
    double shape[NQM_FIT_MAX_SHAPE];
    double kd[3], ks[3]; /* >= 0 */
} nqm_fit_values;

/** The spec of `model` with exactly these values. */
void nqm_fit_write_spec(const nqm_fit_entry *model, const nqm_fit_values *values, char spec[512]);

/** The base with kd = 1 and the lobe with ks = 1 of a model at fixed directions. */
typedef struct nqm_fit_lobes {
    const nqm_fit_entry *model;
    size_t n;
    const double *wi, *wo;           /* (n, 3), borrowed */
    double *rgb;                     /* (n, 3) scratch; owns the block of the arrays below */
    double *diffuse, *lobe;          /* (n) */
    double shape[NQM_FIT_MAX_SHAPE]; /* of `lobe`; zeros: not evaluated yet */
} nqm_fit_lobes;

/** Allocate the arrays and evaluate the base; nqm_free(lobes->rgb) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_lobes_make(const nqm_fit_entry *model, size_t n, const double *wi, const double *wo,
                                             nqm_fit_lobes *lobes, nqm_error *err);
/** Evaluate the lobe, unless it already has this shape. */
NQM_MUST_CHECK nqm_status nqm_fit_lobes_set(nqm_fit_lobes *lobes, const double *shape, nqm_error *err);
/** slopes (n_shape, n): derivatives of the lobe by the positions of its shape in their ranges. */
NQM_MUST_CHECK nqm_status nqm_fit_lobes_slopes(nqm_fit_lobes *lobes, double *slopes, nqm_error *err);
/** rgb (n, 3): f_r with the albedos of `v`; the lobe must have its shape. */
void nqm_fit_lobes_combine(const nqm_fit_lobes *lobes, const nqm_fit_values *v, double *rgb);
/** f_r of a spec: rgb (n, 3). */
NQM_MUST_CHECK nqm_status nqm_fit_eval_spec(const char *spec, size_t n, const double *wi, const double *wo, double *rgb,
                                            nqm_error *err);

/** The reference at the directions of the fit. */
typedef struct nqm_fit_target {
    nqm_fit_loss loss;
    size_t n;
    double *wi, *wo; /* (n, 3); wi owns the block of all arrays */
    double *weight;  /* (n) factor of f_r inside the loss: c or 1 */
    double *rgb;     /* (n, 3) f_r of the reference */
    double *goal;    /* (n, 3) nqm_fit_transform() of it */
    double rounding; /* of the kinks of mean absolute losses: |r| becomes sqrt(r^2 + rounding^2) - rounding */
} nqm_fit_target;

/** Draw the directions and sample `ref` there; nqm_free(target->wi) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_target_make(const nqm_brdf *ref, const nqm_fit_options *options,
                                              nqm_fit_target *target, nqm_error *err);

/** The same directions under another loss. Borrows the directions and f_r; nqm_free(target->weight). */
NQM_MUST_CHECK nqm_status nqm_fit_target_under(const nqm_fit_target *from, nqm_fit_loss loss, nqm_fit_target *target,
                                               nqm_error *err);
/** The target's loss of rgb (n, 3); gradient (n, 3) receives its derivatives, NULL: not computed. Where a difference of a
 *  mean absolute loss is 0 its derivative counts as 0; nqm_value_slope(). */
double nqm_fit_loss_value(const nqm_fit_target *target, const double *rgb, double *gradient);

/* ---- least squares (fit_solve.c) ---------------------------------------------------------------------------------- */

enum { NQM_FIT_MAX_REFINED = 4 };
/* Within the ranges of the specs, beyond those of real surfaces. */
#define NQM_FIT_MAX_KD 10.0
#define NQM_FIT_MAX_KS 1e6

/** The workspace of a search under the root mean square of a target's differences. */
typedef struct nqm_fit_search {
    const nqm_fit_target *target;
    nqm_fit_lobes lobes;
    nqm_status failure; /* of the last evaluation of residuals; *err has the message */
    nqm_ticker *ticker; /* NULL: silent */
    double done, total; /* for the ticker */
    nqm_error *err;
} nqm_fit_search;

/** Values of a model and their loss. */
typedef struct nqm_fit_candidate {
    nqm_fit_values values;
    double loss;
    size_t start;
} nqm_fit_candidate;

/** nqm_fit_search_end() it also after a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_search_begin(const nqm_fit_entry *model, const nqm_fit_target *target,
                                               nqm_ticker *ticker, nqm_fit_search *search, nqm_error *err);
void nqm_fit_search_end(nqm_fit_search *search);
/** Refine the best of the starts of the options: best (NQM_FIT_MAX_REFINED), in no order. */
NQM_MUST_CHECK nqm_status nqm_fit_search_starts(nqm_fit_search *search, const nqm_fit_options *options,
                                                nqm_fit_candidate *best, size_t *n_best);
/** Replace the values by better ones by Levenberg-Marquardt; with_albedos: in turn with linear solutions of the albedos. */
NQM_MUST_CHECK nqm_status nqm_fit_search_refine(nqm_fit_search *search, nqm_fit_candidate *candidate,
                                                bool with_albedos);
/** Random values: shapes uniform in the scale of the search, the albedos that are best for them times factors log-uniform
 *  in [1/20, 20]. */
NQM_MUST_CHECK nqm_status nqm_fit_search_random(nqm_fit_search *search, nqm_rng *rng, nqm_fit_values *values);
/** Report progress; true: the caller must stop with nqm_fit_cancelled(). */
bool nqm_fit_tick(nqm_fit_search *search);
nqm_status nqm_fit_cancelled(nqm_error *err);

/** A point on the path of the optimiser: n_steps (up to 1000) steps of Levenberg-Marquardt from nqm_fit_search_random()
 *  under the target's loss, a function of the seed. */
NQM_MUST_CHECK nqm_status nqm_fit_follow(const nqm_fit_entry *model, const nqm_fit_target *target, uint64_t seed,
                                         size_t n_steps, nqm_fit_values *values, nqm_error *err);
/** The same for a model's name; spec receives the point. NQM_ERR_ARG: the model is not analytic. */
NQM_MUST_CHECK nqm_status nqm_fit_path(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                       uint64_t seed, size_t n_steps, char spec[512], nqm_error *err);

/* ---- weighted sums ------------------------------------------------------------------------------------------------ */

/** One term at its directions. */
typedef struct nqm_fit_part {
    nqm_fit_term term;
    nqm_fit_target target; /* of a BRDF-space term */
    nqm_fit_lobes lobes;
    double *rgb, *gradient; /* (n, 3) f_r, and the derivatives of the term by it; rgb owns the block */
    double *slopes;         /* (n_shape, n) */
    double value;           /* of the last evaluation */
} nqm_fit_part;

/** A weighted sum of terms as a function of the values of a model. */
typedef struct nqm_fit_objective {
    const nqm_fit_entry *model;
    size_t n;
    nqm_fit_part *parts; /* (n) */
} nqm_fit_objective;

/** Prepare the terms; `target` gives the directions of BRDF-space terms and must outlive the objective. Free it also after
 *  a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_objective_make(const nqm_fit_entry *model, const nqm_fit_target *target,
                                                 size_t n_terms, const nqm_fit_term *terms,
                                                 nqm_fit_objective *objective, nqm_error *err);
void nqm_fit_objective_free(nqm_fit_objective *objective);
/** The sum (visual: with the visual terms) and its gradient (NULL: not computed), in which `shape` has the derivatives by
 *  the positions in the ranges. NQM_ERR_NUMERIC: a term is not finite. */
NQM_MUST_CHECK nqm_status nqm_fit_objective_eval(nqm_fit_objective *objective, bool visual, const nqm_fit_values *v,
                                                 double *value, nqm_fit_values *gradient, nqm_error *err);
/** Minimise it from candidate->values (fit_descend.c); they and the loss are replaced, never by worse ones. */
NQM_MUST_CHECK nqm_status nqm_fit_descend(nqm_fit_objective *objective, bool visual, nqm_ticker *ticker,
                                          nqm_fit_candidate *candidate, nqm_error *err);
/** The best values under the loss of the options (fit_minimise.c); candidate->start is the index of their start.
 *  `target` is one of the options. */
NQM_MUST_CHECK nqm_status nqm_fit_minimise(const nqm_fit_entry *model, const nqm_fit_target *target,
                                           const nqm_fit_options *options, nqm_fit_candidate *candidate,
                                           nqm_error *err);
/** The loss by whose squares a fit of these options begins: that of the BRDF-space term with the largest weight. */
nqm_fit_loss nqm_fit_first_loss(const nqm_fit_options *options);
/** Values of a spec of the model, inside its ranges. NQM_ERR_ARG: another model, or a faulty spec. */
NQM_MUST_CHECK nqm_status nqm_fit_read_spec(const nqm_fit_entry *model, const char *spec, nqm_fit_values *values,
                                            nqm_error *err);

/** Loss of a spec; NQM_ERR_NOMEM, or what opening it gives. */
NQM_MUST_CHECK nqm_status nqm_fit_loss_of_spec(const nqm_fit_target *target, const char *spec, double *loss_ret,
                                               nqm_error *err);

#endif
