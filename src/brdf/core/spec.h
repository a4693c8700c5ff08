/* SPDX-License-Identifier: MIT
 *
 * spec.h - models in closed form: the schema of their keys, and the class that evaluates their values; BRDFs that contain others;
 * and how both are opened from their specs.
 */
#ifndef NQM_SRC_BRDF_SPEC_H
#define NQM_SRC_BRDF_SPEC_H

#include "brdf/brdf.h"
#include "schema/models.h"

/** For functions that models call for values and for values with derivatives: when inlined, a constant NULL for the
 *  derivatives removes their code. */
#define INLINED static inline __attribute__((always_inline))
/** Define NAME_eval() and NAME_jacobian() from such a function VALUES; the variadic arguments are its first ones, of
 *  which `state` is one. */
#define NQM_EVAL_AND_JACOBIAN(NAME, VALUES, ...)                                                                       \
    static void NAME##_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {            \
        VALUES(__VA_ARGS__, n, wi, wo, rgb, NULL);                                                                     \
    }                                                                                                                  \
    static void NAME##_jacobian(const void *state, size_t n, const double *wi, const double *wo, double *rgb,          \
                                double *jacobian) {                                                                    \
        VALUES(__VA_ARGS__, n, wi, wo, rgb, jacobian);                                                                 \
    }

/** A model in closed form. */
typedef struct nqm_analytic_model {
    const nqm_schema *schema;
    const char *doi; /**< NULL: none */
    nqm_brdf_class class_;
    size_t state_size;                                      /**< bytes of the state, which `prepare` fills */
    void (*prepare)(const nqm_values *values, void *state); /**< compute the constants of the evaluation */
} nqm_analytic_model;

/** First member of the state of models that have no derivatives in closed form; opening fills it. */
typedef struct nqm_spec_state {
    const nqm_analytic_model *model;
    nqm_values values;
} nqm_spec_state;
enum { NQM_SPEC_MAX_STATE = 8192 }; /* bytes of a state that begins so */

/** The `jacobian` of their classes: differences of evaluations at changed parameters, of second order; central ones inside the
 *  range of a parameter, one-sided ones at its ends. `prepare` is called twice for each parameter. */
void nqm_spec_jacobian(const void *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian);

/** Define the shading model of a schema, nqm_NAME_schema; IS_RECIPROCAL: 0 or 1. Its mistaken twin (core/mistakes.h) has another
 *  name. */
#ifdef NQM_WITH_MISTAKES
#define NQM_SHADING_NAME(NAME) nqm_##NAME##_model_mistaken
#else
#define NQM_SHADING_NAME(NAME) nqm_##NAME##_model
#endif
#define NQM_SHADING_MODEL(NAME, SPEC, STATE, PREPARE, EVAL, IS_RECIPROCAL)                                             \
    const nqm_analytic_model NQM_SHADING_NAME(NAME) = {                                                                \
        .schema = &nqm_##NAME##_schema,                                                                                \
        .class_ = {.format = (SPEC),                                                                                   \
                   .anisotropic = true,                                                                                \
                   .reciprocal = (IS_RECIPROCAL),                                                                      \
                   .eval = (EVAL),                                                                                     \
                   .jacobian = nqm_spec_jacobian,                                                                      \
                   .free = nqm_free},                                                                                  \
        .state_size = sizeof(STATE),                                                                                   \
        .prepare = (PREPARE),                                                                                          \
    }

/** Every analytic model. A new one is defined in models/analytic.c or a file of its own, and named here. */
#define NQM_ANALYTIC_MODELS(X)                                                                                         \
    X(nqm_lambert_model)                                                                                               \
    X(nqm_ggx_model)                                                                                                   \
    X(nqm_ward_model)                                                                                                  \
    X(nqm_sgd_model)                                                                                                   \
    X(nqm_ward_duer_model)                                                                                             \
    X(nqm_blinn_phong_model)                                                                                           \
    X(nqm_lafortune_model)                                                                                             \
    X(nqm_cook_torrance_model)                                                                                         \
    X(nqm_low_cook_torrance_model)                                                                                     \
    X(nqm_ashikhmin_shirley_model)                                                                                     \
    X(nqm_low_ashikhmin_shirley_model)                                                                                 \
    X(nqm_abc_model)                                                                                                   \
    X(nqm_smooth_model)

/** Those of shading models (schema/models.h) have states that begin with nqm_spec_state. */
#define NQM_DECLARE_ANALYTIC(NAME)     extern const nqm_analytic_model NAME;
#define NQM_DECLARE_SHADING(NAME, ...) extern const nqm_analytic_model nqm_##NAME##_model;
#define NQM_DECLARE_TWIN(NAME, ...)    extern const nqm_analytic_model nqm_##NAME##_model_mistaken;
NQM_ANALYTIC_MODELS(NQM_DECLARE_ANALYTIC)
NQM_SHADING_SCHEMAS(NQM_DECLARE_SHADING)
NQM_SLOW_SCHEMAS(NQM_DECLARE_SHADING)
NQM_SHADING_SCHEMAS(NQM_DECLARE_TWIN)

/** An analytic model or preset from a spec: nqm_spec_probe(spec) is true. `name` is that of its information. */
NQM_MUST_CHECK nqm_status nqm_spec_open(const char *spec, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
/** NQM_ERR_LIMIT: a spec contains too many wrappers. */
NQM_MUST_CHECK nqm_status nqm_spec_check_nesting(const char *spec, nqm_error *err);
/** The model of the first n characters of `name`; NULL when there is none. */
const nqm_analytic_model *nqm_analytic_model_find(const char *name, size_t n);

/** The length of the model's name in a text that lacks the colon of a spec, "ggx;alpha=.1", "ggx,alpha=.1" or "sgd;nickel"; 0: in
 *  any other text. */
size_t nqm_spec_lacks_colon(const char *text);
/** Offer the names of all models, tables of presets and wrappers. */
void nqm_spec_nearest(nqm_nearest *nearest);

/** A kind of BRDF that contains others. */
struct nqm_spec_wrapper {
    nqm_schema schema;     /**< its model is the word before the colon */
    uint64_t idle;         /**< bit k: key k alone changes nothing */
    bool has_with;         /**< whether it has two bases */
    const char *form;      /**< message for a text without its bases */
    nqm_brdf_class class_; /**< its states begin with nqm_between_bases, which the caller of create() fills */
    /** Create the state; `info` has the values that follow from the bases. */
    nqm_status (*create)(const nqm_values *values, const nqm_between_bases *bases, nqm_brdf_info *info,
                         void **state_ret, nqm_error *err);
};
extern const nqm_spec_wrapper nqm_perturb_wrapper, nqm_between_wrapper, nqm_rotate_wrapper, nqm_tilt_wrapper;
/** The `free` of their classes. */
void nqm_wrapper_free(void *state);

#endif
