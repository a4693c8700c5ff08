/* SPDX-License-Identifier: MIT
 *
 * analytic.h - shared by the analytic models: the angles of the half vector, and models of the form kd / pi + ks L,
 * where the lobe L is one function for all channels.
 */
#ifndef NQM_SRC_BRDF_ANALYTIC_H
#define NQM_SRC_BRDF_ANALYTIC_H

#include "brdf/spec.h"
#include "math/math.h"

#include <math.h>

/* Angles of the half vector, computed without normalising it: |wi + wo| = 2 cos theta_d. There is no cancellation near
 * theta_h = 0, where lobes can be narrower than a degree. */
typedef struct nqm_half_angles {
    double tan2_h, cos_d;
} nqm_half_angles;

static inline nqm_half_angles nqm_half_angles_of(const double *wi, const double *wo) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    double xy = x * x + y * y;
    return (nqm_half_angles){.tan2_h = xy / (z * z), .cos_d = fmin(1, 0.5 * sqrt(xy + z * z))};
}

/** Schlick 1994 (DOI 10.1111/1467-8659.1330233). */
static inline double nqm_schlick(double f0, double cosine) {
    double m = 1 - cosine;
    return f0 + (1 - f0) * m * m * m * m * m;
}

enum { NQM_LOBE_MAX_SHAPE = 3 };

/** A prepared model of the form kd / pi + ks L. */
typedef struct nqm_lobe {
    double diffuse[3];                /**< kd / pi */
    double specular[3];               /**< ks times the constant factors of L */
    double shape[NQM_LOBE_MAX_SHAPE]; /**< parameters of the lobe; their meaning depends on the model */
} nqm_lobe;

/** Fill the state from a schema that begins with kd, ks; `factor` is the constant part of L. */
static inline nqm_lobe nqm_lobe_make(const nqm_spec_values *values, double factor) {
    nqm_lobe lobe = {{0}, {0}, {0}};
    for (int c = 0; c < 3; ++c) {
        lobe.diffuse[c] = values->v[0][c] / NQM_PI;
        lobe.specular[c] = values->v[1][c] * factor;
    }
    return lobe;
}

/** L without its constant factors. Written so that exchanging light and viewer gives the same bits. */
typedef double (*nqm_lobe_fn)(const double *shape, const double *wi, const double *wo);

/** Evaluate n pairs. Inlined, so that the compiler can inline `f` too. */
static inline void nqm_lobe_eval(const nqm_lobe *self, nqm_lobe_fn f, size_t n, const double *wi, const double *wo,
                                 double *rgb) {
    for (size_t i = 0; i < n; ++i) {
        double value = f(self->shape, wi + 3 * i, wo + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = self->diffuse[c] + self->specular[c] * value;
    }
}

/** The first two keys of every such model. */
#define NQM_LOBE_KEYS                                                                                                  \
    {.name = "kd", .n = 3, .low = 0, .high = 10, .fallback = 0}, {                                                     \
        .name = "ks", .n = 3, .low = 0, .high = 1e6, .required = true                                                  \
    }

/** Define the model MODEL with the lobe function LOBE; the variadic arguments are its keys after kd and ks. */
#define NQM_LOBE_MODEL(MODEL, NAME, DOI, LOBE, PREPARE, N_KEYS, ...)                                                   \
    static void LOBE##_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {            \
        nqm_lobe_eval(state, LOBE, n, wi, wo, rgb);                                                                    \
    }                                                                                                                  \
    const nqm_analytic_model MODEL = {                                                                                 \
        .schema = {NAME, N_KEYS, {NQM_LOBE_KEYS, __VA_ARGS__}},                                                        \
        .doi = DOI,                                                                                                    \
        .class_ = {.format = NAME, .reciprocal = 1, .eval = LOBE##_eval, .free = nqm_free},                            \
        .state_size = sizeof(nqm_lobe),                                                                                \
        .prepare = PREPARE,                                                                                            \
    }

#endif
