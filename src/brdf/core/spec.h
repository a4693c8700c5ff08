/* SPDX-License-Identifier: MIT
 *
 * spec.h - the text form of BRDFs that are defined by parameters: `MODEL:key=value;key=value`, values separated by
 * commas for RGB. A model lists its keys with their ranges and defaults; parsing, messages and the canonical form come
 * from that list.
 */
#ifndef NQM_SRC_BRDF_SPEC_H
#define NQM_SRC_BRDF_SPEC_H

#include "base/names.h"
#include "brdf/brdf.h"
#include "material/surface_keys.h"

enum { NQM_SPEC_MAX_KEYS = 48 };

/** One key of a spec. */
typedef struct nqm_spec_key {
    const char *name;
    size_t n;         /**< values: 1, 2 along tangent and bitangent, or 3 for RGB; a single value means all */
    double low, high; /**< closed range of each value */
    bool required;
    bool whole;      /**< integers only */
    bool turns;      /**< a value that is not 0 makes the model anisotropic */
    double fallback; /**< default of an optional key */
} nqm_spec_key;

/** The keys of one model, in the order of the canonical form. */
typedef struct nqm_spec_schema {
    const char *model; /**< the word before the colon */
    size_t n_keys;
    nqm_spec_key keys[NQM_SPEC_MAX_KEYS];
} nqm_spec_schema;

/** Parsed values; a key with n < 3 repeats its last value. */
typedef struct nqm_spec_values {
    double v[NQM_SPEC_MAX_KEYS][3]; /**< (key, channel) */
    uint64_t given;                 /**< bit k: key k was in the text */
} nqm_spec_values;

/** Parse `key=value;...` (what follows the colon). NQM_ERR_ARG names the key at fault and its range. */
NQM_MUST_CHECK nqm_status nqm_spec_parse(const nqm_spec_schema *schema, const char *text, nqm_spec_values *values,
                                         nqm_error *err);
/** The canonical text, "MODEL:key=value;...", of the given keys; parses back to the same bits. nqm_free(); NULL when
 * out of memory. */
char *nqm_spec_format(const nqm_spec_schema *schema, const nqm_spec_values *values);

/** Whether f_r of a model with these values does not depend on the azimuth. */
bool nqm_spec_is_isotropic(const nqm_spec_schema *schema, const nqm_spec_values *values);

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
    nqm_spec_schema schema;
    const char *doi; /**< NULL: none */
    nqm_brdf_class class_;
    size_t state_size;                                           /**< bytes of the state, which `prepare` fills */
    void (*prepare)(const nqm_spec_values *values, void *state); /**< compute the constants of the evaluation */
} nqm_analytic_model;

/** First member of the state of models that have no derivatives in closed form; opening fills it. */
typedef struct nqm_spec_state {
    const nqm_analytic_model *model;
    nqm_spec_values values;
} nqm_spec_state;
enum { NQM_SPEC_MAX_STATE = 8192 }; /* bytes of a state that begins so */

/** The `jacobian` of their classes: differences of evaluations at changed parameters, of second order; central ones inside the
 *  range of a parameter, one-sided ones at its ends. `prepare` is called twice for each parameter. */
void nqm_spec_jacobian(const void *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian);

/** The index and the row in the schema of a key in a list X(INDEX, NAME, TYPE, LOW, HIGH, DEFAULT) as those of
 *  material/surface_keys.h. The type "float2" has two values; `.turns = true` may follow the default. */
#define NQM_KEY_INDEX(INDEX, ...) INDEX,
#define NQM_KEY_ROW(INDEX, NAME, TYPE, LOW, HIGH, ...)                                                                 \
    {.name = (NAME),                                                                                                   \
     .n = NQM_KEY_N(TYPE),                                                                                             \
     .low = (LOW),                                                                                                     \
     .high = (HIGH),                                                                                                   \
     .whole = sizeof(TYPE) == sizeof "integer",                                                                        \
     .fallback = __VA_ARGS__},
/** Define a shading model with such a list; IS_RECIPROCAL: 0 or 1. Its mistaken twin (core/mistakes.h) has another name. */
#ifdef NQM_WITH_MISTAKES
#define NQM_SHADING_NAME(MODEL) MODEL##_mistaken
#else
#define NQM_SHADING_NAME(MODEL) MODEL
#endif
#define NQM_SHADING_MODEL(MODEL, NAME, KEYS, STATE, PREPARE, EVAL, IS_RECIPROCAL)                                      \
    const nqm_analytic_model NQM_SHADING_NAME(MODEL) = {                                                               \
        .schema = {NAME, sizeof((nqm_spec_key[]){KEYS(NQM_KEY_ROW)}) / sizeof(nqm_spec_key), {KEYS(NQM_KEY_ROW)}},     \
        .class_ = {.format = NAME,                                                                                     \
                   .anisotropic = true,                                                                                \
                   .reciprocal = IS_RECIPROCAL,                                                                        \
                   .eval = EVAL,                                                                                       \
                   .jacobian = nqm_spec_jacobian,                                                                      \
                   .free = nqm_free},                                                                                  \
        .state_size = sizeof(STATE),                                                                                   \
        .prepare = PREPARE,                                                                                            \
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
/** The shading models of renderers (doc/materials.md), likewise. Their states begin with nqm_spec_state. */
#define NQM_SHADING_MODELS(X)                                                                                          \
    X(nqm_rough_plastic_model)                                                                                         \
    X(nqm_rough_conductor_model)                                                                                       \
    X(nqm_pbrt_conductor_model)                                                                                        \
    X(nqm_open_pbr_model)                                                                                              \
    X(nqm_gltf_model)                                                                                                  \
    X(nqm_usd_preview_model)                                                                                           \
    X(nqm_standard_surface_model)                                                                                      \
    X(nqm_disney_model)                                                                                                \
    X(nqm_principled_model)                                                                                            \
    X(nqm_blender_model)
/** Models whose opening or evaluation is so slow that nothing is fitted to them. Likewise. */
#define NQM_SLOW_MODELS(X) X(nqm_coated_model) X(nqm_coated_conductor_model)

#define NQM_DECLARE_MODEL(NAME) extern const nqm_analytic_model NAME;
#define NQM_DECLARE_TWIN(NAME)  extern const nqm_analytic_model NAME##_mistaken;
NQM_ANALYTIC_MODELS(NQM_DECLARE_MODEL)
NQM_SHADING_MODELS(NQM_DECLARE_MODEL)
NQM_SLOW_MODELS(NQM_DECLARE_MODEL)
NQM_SHADING_MODELS(NQM_DECLARE_TWIN)

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
    nqm_spec_schema schema; /**< its model is the word before the colon */
    uint64_t idle;          /**< bit k: key k alone changes nothing */
    bool has_with;          /**< whether it has two bases */
    const char *form;       /**< message for a text without its bases */
    nqm_brdf_class class_;  /**< its states begin with nqm_between_bases, which the caller of create() fills */
    /** Create the state; `info` has the values that follow from the bases. */
    nqm_status (*create)(const nqm_spec_values *values, const nqm_between_bases *bases, nqm_brdf_info *info,
                         void **state_ret, nqm_error *err);
};
extern const nqm_spec_wrapper nqm_perturb_wrapper, nqm_between_wrapper, nqm_rotate_wrapper, nqm_tilt_wrapper;
/** The `free` of their classes. */
void nqm_wrapper_free(void *state);

#endif
