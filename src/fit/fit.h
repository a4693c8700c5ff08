/* SPDX-License-Identifier: MIT
 *
 * fit.h - fits of analytic and shading models. A space lists the free parameters of a model's schema with their bounds and
 * scales; a target is the reference at the directions of the fit under one loss; an objective is a weighted sum of losses.
 * Least squares (squares.c) minimise a target from several starts, and a quasi-Newton method (descend.c) minimises an
 * objective from their results.
 */
#ifndef NQM_SRC_FIT_H
#define NQM_SRC_FIT_H

#include "argument/argument.h"
#include "base/base.h"
#include "base/options.h"
#include "brdf/core/spec.h"
#include "encode/encode.h"
#include "math/values.h"
#include "schema/schema.h"
#include <nqm/brdf.h>
#include <nqm/fit.h>
#include <nqm/label.h>
#include <nqm/match.h>

extern const nqm_option_table nqm_fit_option_table;

/* ---- losses (target.c) ------------------------------------------------------------------------------------------- */

/** Indexed by nqm_fit_loss. */
extern const nqm_value_difference nqm_fit_losses[];
/** The words of nqm_fit_loss, NULL-terminated. */
extern const char *const nqm_fit_loss_words[];

/** The curve of a loss at weight f, and its derivative by f; f >= 0. */
double nqm_fit_transform(nqm_fit_loss loss, double weight, double f);
double nqm_fit_transform_slope(nqm_fit_loss loss, double weight, double f);

/* ---- the reference (target.c) ------------------------------------------------------------------------------------- */

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
/** About n directions of a target, evenly; nqm_free(thin->wi) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_target_thin(const nqm_fit_target *from, size_t n, nqm_fit_target *thin,
                                              nqm_error *err);
/** The target's loss of rgb (n, 3); gradient (n, 3) receives its derivatives, NULL: not computed. Where a difference of a
 *  mean absolute loss is 0 its derivative counts as 0; the derivative of cbrt(x) below x = 1e-6 is that at 1e-6. */
double nqm_fit_loss_value(const nqm_fit_target *target, const double *rgb, double *gradient);

/* ---- models (models.c) -------------------------------------------------------------------------------------------- */

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
    double low, high; /* range of the search */
    nqm_fit_scale scale;
} nqm_fit_shape;

/** A row of the list of models. An analytic model is f_r = kd D + ks L(shape). */
typedef struct nqm_fit_entry {
    const char *name;                       /* NULL: that of the schema */
    const struct nqm_analytic_model *model; /* NULL: an encoding */
    size_t n_shape;                         /* 0: a shading model */
    nqm_fit_shape shape[NQM_FIT_MAX_SHAPE];
    size_t n_start;                                           /* starting points per lobe width */
    void (*start)(double alpha, size_t which, double *shape); /* writes starting point `which` in [0, n_start) */
    nqm_encode_fn encode;                                     /* of an encoding */
    size_t n_code;                                            /* `n` and `step` of its options */
    float step;
} nqm_fit_entry;

/** By name. NQM_ERR_ARG lists the names. */
NQM_MUST_CHECK nqm_status nqm_fit_entry_find(const char *name, const nqm_fit_entry **entry_ret, nqm_error *err);
/** NULL: the entry has no shape with this key. */
const nqm_fit_shape *nqm_fit_find_shape(const nqm_fit_entry *entry, const char *key);

/* ---- the space (space.c) ------------------------------------------------------------------------------------------ */

enum { NQM_FIT_MAX_FREE = 96, NQM_FIT_ALL_CHANNELS = 3 };

/** A free parameter: one value of a key. The search sees x = units * log(|value - zero|), or units * value. */
typedef struct nqm_fit_parameter {
    size_t key, channel; /* NQM_FIT_ALL_CHANNELS: the same value in all */
    size_t layer;        /* key of the amount of the layer that it describes; itself: none */
    double low, high;    /* of the value */
    double units, zero;
    double ratio; /* of the other values to the first in a key with two values; 1: they are equal */
    bool is_log;
} nqm_fit_parameter;

typedef struct nqm_fit_space {
    const nqm_fit_entry *entry;
    const nqm_analytic_model *model;
    double turn[2];      /* sine and cosine of the turn (nqm_turn3) into the axes of the model */
    nqm_values defaults; /* with the values of fixed keys */
    size_t n;            /* free parameters */
    nqm_fit_parameter parameters[NQM_FIT_MAX_FREE];
} nqm_fit_space;

/** Values of a model and their loss. */
typedef struct nqm_fit_point {
    nqm_values values;
    double loss;
    size_t start;
} nqm_fit_point;

/** Keys of whole numbers and of anisotropy are fixed at the values of options->start, or at their defaults; bounds of
 *  the options apply. NQM_ERR_ARG: a bound of an unknown key or outside its range, or a start of another model. */
NQM_MUST_CHECK nqm_status nqm_fit_space_make(const nqm_fit_entry *entry, const nqm_fit_options *options,
                                             nqm_fit_space *space, nqm_error *err);
/** Free both values of keys with two, which are otherwise tied. Returns whether there are any. */
bool nqm_fit_split(nqm_fit_space *space);
/** The values of a spec, moved into the bounds. */
NQM_MUST_CHECK nqm_status nqm_fit_read_spec(const nqm_fit_space *space, const char *spec, nqm_values *values,
                                            nqm_error *err);
/** The spec with rounded values, of shading models without keys that have their default; the values become those of the spec.
 *  NQM_ERR_LIMIT: longer than `spec`. */
NQM_MUST_CHECK nqm_status nqm_fit_write_spec(const nqm_fit_space *space, nqm_values *values, char *spec, size_t n_spec,
                                             nqm_error *err);
/** The coordinates of the free parameters: x, and their bounds low and high (space->n). */
void nqm_fit_coordinates(const nqm_fit_space *space, const nqm_values *values, double *x);
void nqm_fit_bounds(const nqm_fit_space *space, double *low, double *high);
/** The values at the coordinates x; keys that are not free are unchanged. */
void nqm_fit_values(const nqm_fit_space *space, const double *x, nqm_values *values);
/** Set the value of a free key within its bounds; a key that is fixed or not there (n_keys) is left alone. */
void nqm_fit_set(const nqm_fit_space *space, nqm_values *values, size_t key, const double v[3]);
/** Fix a key at the value it has: its parameters leave the space. */
void nqm_fit_fix(nqm_fit_space *space, size_t key);

/** f_r in 1/sr: rgb (n, 3); zeros below the horizon. The model is turned by `turn` of the space. */
void nqm_fit_eval(const nqm_fit_space *space, const nqm_values *values, size_t n, const double *wi, const double *wo,
                  double *rgb);
/** columns (space->n, n, 3): derivatives of f_r by the coordinates; rgb (n, 3) is f_r of the values. */
void nqm_fit_slopes(const nqm_fit_space *space, const nqm_values *values, size_t n, const double *wi, const double *wo,
                    const double *rgb, double *columns);

/* ---- starts (starts.c) ------------------------------------------------------------------------------------------- */

/** Bounds and scale of a key of a shading model, and the layer that it describes. */
nqm_fit_parameter nqm_fit_describe(const nqm_schema *schema, size_t key);
/** The default of a key; of required keys, that of other models. */
double nqm_fit_default(const nqm_schema_key *key);
/** Whether fits keep the value of the start: whole numbers, anisotropy, thin films, what the index of refraction sets, too. */
bool nqm_fit_is_kept(const nqm_schema_key *key);
/** Replace *values by start i of an analytic model: n_widths lobe widths, spaced evenly in their logarithm, each with the
 *  starting points of the model; albedos are 0. Of a shading model: roughness, metal and base colour; other keys have their
 *  defaults. diffuse: (3) base colour of a dielectric; albedo: (3) that of a metal. false: there are only i. */
bool nqm_fit_start(const nqm_fit_space *space, size_t i, size_t n_widths, const double *diffuse, const double *albedo,
                   nqm_values *values);
/** The two colours of nqm_fit_start(): that of a Lambert BRDF with the median f_r of the target, and the albedo at
 *  normal incidence. */
NQM_MUST_CHECK nqm_status nqm_fit_measure_albedos(const nqm_brdf *ref, const nqm_fit_target *target, double *diffuse,
                                                  double *albedo, nqm_error *err);
/** Turn on layer i, such as a clear coat, with a typical width; rough: over a base three times as rough. false: there are only
 *  i. */
bool nqm_fit_add_layer(const nqm_fit_space *space, size_t i, bool rough, nqm_values *values);

/* ---- least squares (squares.c) ------------------------------------------------------------------------------------ */

/** Report progress. NQM_ERR_CANCELLED: stopped. */
NQM_MUST_CHECK nqm_status nqm_fit_tick(nqm_ticker *ticker, const char *stage, double done, double total,
                                       nqm_error *err);
/** step (n) = - (curvature + damping * its diagonal)^-1 gradient for the entries that are not fixed, 0 for the others.
 *  curvature (n, n): symmetric; factor (n, n): scratch. */
void nqm_fit_solve(size_t n, const double *curvature, const bool *fixed, const double *gradient, double damping,
                   double *factor, double *step);
/** Minimise the target's root mean square (or, of mean absolute losses, its reweighted squares) from point->values by at most
 *  n_steps steps. The point is replaced, never by a worse one. */
NQM_MUST_CHECK nqm_status nqm_fit_refine(const nqm_fit_space *space, const nqm_fit_target *target, size_t n_steps,
                                         nqm_ticker *ticker, nqm_fit_point *point, nqm_error *err);
/** The approximate second derivatives (space->n, space->n) of the target's loss by the coordinates. */
NQM_MUST_CHECK nqm_status nqm_fit_curvature(const nqm_fit_space *space, const nqm_fit_target *target,
                                            const nqm_values *values, double *curvature, nqm_error *err);
/** The albedos kd, ks of an analytic model that are best for the shape in *values, by linear least squares (albedos.c). */
NQM_MUST_CHECK nqm_status nqm_fit_solve_albedos(const nqm_fit_space *space, const nqm_fit_target *target,
                                                nqm_values *values, nqm_error *err);

/* ---- sums of terms (objective.c) ---------------------------------------------------------------------------------- */

typedef struct nqm_fit_objective nqm_fit_objective;

/** `target` gives the directions of BRDF-space terms; it and the terms must outlive the objective. */
NQM_MUST_CHECK nqm_status nqm_fit_objective_make(const nqm_fit_space *space, const nqm_fit_target *target,
                                                 size_t n_terms, const nqm_fit_term *terms,
                                                 nqm_fit_objective **objective_ret, nqm_error *err);
void nqm_fit_objective_free(nqm_fit_objective *objective);
/** The sum at these values. NQM_ERR_NUMERIC: a term is not finite. */
NQM_MUST_CHECK nqm_status nqm_fit_objective_value(nqm_fit_objective *objective, const nqm_values *values, double *value,
                                                  nqm_error *err);
/** The gradient (space->n) by the coordinates at the values of the last nqm_fit_objective_value(). */
NQM_MUST_CHECK nqm_status nqm_fit_objective_gradient(nqm_fit_objective *objective, const nqm_fit_space *space,
                                                     const nqm_values *values, double *gradient, nqm_error *err);
/** Approximate second derivatives (space->n, space->n) at the values of the last evaluation; visual terms count like the
 *  others in proportion. Positive definite. */
NQM_MUST_CHECK nqm_status nqm_fit_objective_curvature(const nqm_fit_objective *objective, const nqm_fit_space *space,
                                                      const nqm_values *values, double *curvature, nqm_error *err);
/** Round the kinks of mean absolute losses over `fraction` of their last value (0: not). false: there are none. */
bool nqm_fit_objective_round(nqm_fit_objective *objective, double fraction);
/** The sum for a black surface. */
NQM_MUST_CHECK nqm_status nqm_fit_objective_black(nqm_fit_objective *objective, double *value, nqm_error *err);

/* ---- quasi-Newton steps (descend.c) ------------------------------------------------------------------------------- */

enum { NQM_FIT_STEPS = 40 };
/** Minimise the objective from point->values over the free parameters of `space` by at most max_steps steps (under
 *  NQM_FIT_STEPS: with kinks rounded once only); never replaced by a worse one. */
NQM_MUST_CHECK nqm_status nqm_fit_descend(nqm_fit_objective *objective, const nqm_fit_space *space, size_t max_steps,
                                          nqm_ticker *ticker, nqm_fit_point *point, nqm_error *err);

/* ---- stages (search.c, simplify.c, fit.c, select.c) --------------------------------------------------------------- */

/** One fit: what all its stages share. */
typedef struct nqm_fit_run {
    const nqm_brdf *ref;
    bool is_turned;  /* the model is in the axes of the reference's lobe */
    double turn_deg; /* the result is turned by it */
    const nqm_fit_options *options;
    nqm_fit_space space;
    nqm_fit_target target; /* under the first loss */
    size_t n_terms;
    const nqm_fit_term *terms; /* what is minimised in the end */
    nqm_fit_term only;         /* options->loss as a term */
    nqm_fit_objective *objective;
    nqm_ticker ticker;
    nqm_error *err;
} nqm_fit_run;

enum { NQM_FIT_MAX_POINTS = 4, NQM_FIT_N_WIDTHS = 3 }; /* widths: of a start of a shading model */
/** Least-squares fits under the target's loss from the starts of the model: points (NQM_FIT_MAX_POINTS) receives n of them,
 *  the smallest loss first. */
NQM_MUST_CHECK nqm_status nqm_fit_search(nqm_fit_run *run, nqm_fit_point *points, size_t *n);
/** Random values: shapes uniform in the scale of the search, the albedos that are best for them times factors log-uniform
 *  in [1/20, 20]. Analytic models. */
NQM_MUST_CHECK nqm_status nqm_fit_random(const nqm_fit_space *space, const nqm_fit_target *target, nqm_rng *rng,
                                         nqm_values *values, nqm_error *err);
/** Of a shading model, set keys to their defaults where that raises the objective by at most `simplify` of the options (0: not
 *  done) times its value plus a twentieth of that of a black surface, in total; then minimise it over the others. */
NQM_MUST_CHECK nqm_status nqm_fit_simplify(nqm_fit_run *run, nqm_fit_point *point);

/** loss: the first that is minimised, by least squares. End the run also after a failure. */
NQM_MUST_CHECK nqm_status nqm_fit_begin(nqm_fit_run *run, const nqm_brdf *ref, const nqm_fit_entry *entry,
                                        const nqm_fit_options *options, nqm_fit_loss loss, nqm_error *err);
void nqm_fit_end(nqm_fit_run *run);
/** The rounded point as a report, except its loss; the point becomes what the spec says. */
NQM_MUST_CHECK nqm_status nqm_fit_write_report(nqm_fit_run *run, nqm_fit_point *point, nqm_fit_report *report);

/** What nqm_fit_select() chose. */
typedef struct nqm_fit_choice {
    nqm_fit_report report; /* its loss is that of the judge */
    nqm_fit_loss loss;     /* under which it was fitted */
    bool polished;         /* by the terms of the options */
} nqm_fit_choice;

/** The best by `judge` among fits under several losses and the best of these polished by the terms of the options (select.c). */
NQM_MUST_CHECK nqm_status nqm_fit_select(const nqm_brdf *ref, const nqm_fit_entry *entry,
                                         const nqm_fit_options *options, const nqm_fit_visual *judge,
                                         nqm_fit_choice *choice, nqm_error *err);

/** A point on the path of the optimiser: n_steps (up to 1000) steps of Levenberg-Marquardt from nqm_fit_random() under the loss
 *  of the options, a function of the seed. NQM_ERR_ARG: the model is not analytic. */
NQM_MUST_CHECK nqm_status nqm_fit_path(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                       uint64_t seed, size_t n_steps, char spec[512], nqm_error *err);

/** 1 if `key` is a lobe parameter of the analytic model `name` or a key of the shading model `name`, which
 *  nqm_fit_options.bounds can restrict; otherwise 0. */
int nqm_fit_model_has(const char *name, const char *key);

/** nqm_match() by the loss or the terms of the options. */
NQM_MUST_CHECK nqm_status nqm_fit(const nqm_brdf *ref, const char *model, const nqm_fit_options *options,
                                  nqm_fit_report *report_ret, nqm_brdf **brdf_ret, nqm_error *err);

/* ---- the anisotropic lobe of the base of shading models, in their own keys (anisotropy.c) ------------------------ */

/** Whether a model has anisotropic lobes, and a key of their azimuth. */
bool nqm_fit_can_be_anisotropic(const nqm_schema *schema, bool needs_azimuth);
/** Set the keys of `to` so that the lobe of its base has the anisotropy of that of `from`, which is a canonical spec;
 *  keys that say how are 0 where the model of `to` cannot have it. */
void nqm_fit_copy_anisotropy(const nqm_values *from, nqm_values *to);
/** A spec with the anisotropy of the lobe of a BRDF, along the axes of the model if that is turned by other means; nqm_free() it.
 *  NULL: the BRDF is isotropic, or the model has no anisotropic lobes. */
char *nqm_fit_measure_anisotropy(const nqm_brdf *ref, const nqm_schema *schema, bool is_turned);

/* ---- BRDF arguments that are fitted when they are opened (open.c) ------------------------------------------------ */

/* "fit:model=ggx;of=BRDF", also within "perturb:" and "between:" (doc/brdf.md). A caller that has some of the BRDFs already, or wants
 * to keep fits, opens the bases itself. */

/** What the caller contributes; NULL or zeros: nothing. */
typedef struct nqm_fit_context {
    /** Opens the BRDF that follows "of=" or "with=(". NULL: nqm_fit_open(). */
    nqm_base_opener *open;
    void *user;
    size_t n_own;
    const double *own_deg; /* (n_own, 3) half-vector coordinates, degrees: the directions of the key `own` */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_fit_context;

/** nqm_brdf_open() for arguments that may contain "fit:". NQM_ERR_ARG: a setting; otherwise as nqm_brdf_open() and nqm_fit(). */
NQM_MUST_CHECK nqm_status nqm_fit_open(const char *argument, const nqm_fit_context *context, nqm_brdf **brdf_ret,
                                       nqm_error *err);

/* ---- matches: the text of a loss, and metrics as differentiable losses (match.c) --------------------------------- */

enum { NQM_MATCH_MAX_TERMS = 8 };

/** What a term of a sum is. */
typedef enum nqm_match_kind { NQM_MATCH_VALUES, NQM_MATCH_METRIC, NQM_MATCH_TRANSPORT } nqm_match_kind;

typedef struct nqm_match_term {
    double weight;
    nqm_match_kind kind;
    nqm_fit_loss loss; /* of NQM_MATCH_VALUES */
} nqm_match_term;

typedef struct nqm_match_sum {
    bool is_auto;
    size_t n;
    nqm_match_term terms[NQM_MATCH_MAX_TERMS]; /* of "auto": those of the polish */
} nqm_match_sum;

/** The sum of "auto". */
extern const char *const nqm_match_polish;
/** nqm_match_report.selected where "auto" has no perceptual terms: the reference is anisotropic, or a list of few directions. */
extern const char *const nqm_match_uncovered;
/** NQM_ERR_ARG names the word at fault. */
NQM_MUST_CHECK nqm_status nqm_match_parse(const char *text, nqm_match_sum *sum, nqm_error *err);

/** A difference from one reference, as a loss of a fit: a metric, or Delta-E on rays of a scene. Used by one thread at
 *  a time; it must not be moved. */
typedef struct nqm_match_visual {
    nqm_fit_visual visual;
    nqm_error failure; /* of the last evaluation */
    /* of a metric: */
    nqm_scorer *scorer;
    nqm_score_quantity quantity; /* NQM_SCORE_JOD: the loss is 10 minus it */
    float *ref, *test, *slopes;  /* (n, 3); ref owns the block of the arrays */
    uint8_t *used;               /* (n) */
    /* of a scene: */
    nqm_rays rays;
    double *ref_rgb; /* (rays.n, 3) */
} nqm_match_visual;

/** NQM_ERR_INCOMPATIBLE: too few directions have a value, or the reference is anisotropic. Free it also after a failure. */
NQM_MUST_CHECK nqm_status nqm_match_visual_make(const nqm_model *model, const nqm_brdf *ref, nqm_match_visual *visual,
                                                nqm_error *err);
/** Delta-E on n random rays of a scene. It judges fits, by a seed of which no step of an optimiser has seen the rays,
 *  and is the loss 'transport' of anisotropic references. Free it also after a failure. */
NQM_MUST_CHECK nqm_status nqm_match_rays_make(const nqm_scene *scene, const nqm_brdf *ref, size_t n, uint64_t seed,
                                              nqm_match_visual *visual, nqm_error *err);
void nqm_match_visual_free(nqm_match_visual *visual);

#endif
