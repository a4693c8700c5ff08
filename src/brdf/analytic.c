/* SPDX-License-Identifier: MIT
 *
 * Three analytic BRDFs over a Lambertian base kd / pi: Lambert alone; GGX (Walter, Marschner, Li and Torrance 2007, DOI
 * 10.2312/EGWR/EGSR07/195-206) with separable Smith shadowing and Schlick's Fresnel factor; and the isotropic lobe of
 * Ward (1992, DOI 10.1145/142920.134078). doc/brdf.md has the formulas. The other
 * models are in analytic_*.c and sgd.c.
 */
#include "brdf/analytic.h"

/* ---- Lambert ----------------------------------------------------------------------------------------------------- */

typedef struct lambert {
    double f[3];
} lambert;

static void lambert_prepare(const nqm_spec_values *values, void *state) {
    lambert *self = state;
    for (int c = 0; c < 3; ++c)
        self->f[c] = values->v[0][c] / NQM_PI;
}

static void lambert_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const lambert *self = state;
    (void)wi;
    (void)wo;
    for (size_t i = 0; i < n; ++i)
        for (int c = 0; c < 3; ++c)
            rgb[3 * i + (size_t)c] = self->f[c];
}

const nqm_analytic_model nqm_lambert_model = {
    .schema = {"lambert", 1, {{.name = "kd", .n = 3, .low = 0, .high = 10, .required = true}}},
    .class_ = {.format = "lambert", .reciprocal = 1, .eval = lambert_eval, .free = nqm_free},
    .state_size = sizeof(lambert),
    .prepare = lambert_prepare,
};

/* ---- GGX --------------------------------------------------------------------------------------------------------- */

typedef struct ggx {
    double diffuse[3]; /* kd / pi */
    double ks[3], f0[3];
    double alpha2;
} ggx;

static void ggx_prepare(const nqm_spec_values *values, void *state) {
    ggx *self = state;
    for (int c = 0; c < 3; ++c) {
        self->diffuse[c] = values->v[0][c] / NQM_PI;
        self->ks[c] = values->v[1][c];
        self->f0[c] = values->v[3][c];
    }
    self->alpha2 = values->v[2][0] * values->v[2][0];
}

/* Smith's G1 = 2 cos / (cos + sqrt(cos^2 + alpha^2 sin^2)), divided by 2 cos, so that the cosines in the denominator of
 * the BRDF cancel. */
static double ggx_visibility(double cosine, double alpha2) {
    double cos2 = cosine * cosine;
    return 1 / (cosine + sqrt(cos2 + alpha2 * (1 - cos2)));
}

static void ggx_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const ggx *self = state;
    for (size_t i = 0; i < n; ++i) {
        nqm_half_angles h = nqm_half_angles_of(wi + 3 * i, wo + 3 * i);
        double sec2_h = 1 + h.tan2_h;
        double spread = (1 + h.tan2_h / self->alpha2) / sec2_h; /* cos^2 theta_h (1 + tan^2 theta_h / alpha^2) */
        double d = 1 / (NQM_PI * self->alpha2 * spread * spread);
        double visibility = ggx_visibility(wi[3 * i + 2], self->alpha2) * ggx_visibility(wo[3 * i + 2], self->alpha2);
        double lobe = d * visibility; /* grouped so that exchanging light and viewer gives the same bits */
        double m = 1 - h.cos_d;
        double schlick = m * m * m * m * m;
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = self->diffuse[c] + self->ks[c] * lobe * (self->f0[c] + (1 - self->f0[c]) * schlick);
    }
}

const nqm_analytic_model nqm_ggx_model = {
    .schema = {"ggx",
               4,
               {{.name = "kd", .n = 3, .low = 0, .high = 10, .fallback = 0},
                {.name = "ks", .n = 3, .low = 0, .high = 1e6, .fallback = 1},
                {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true},
                {.name = "f0", .n = 3, .low = 0, .high = 1, .fallback = 0.04}}},
    .doi = "10.2312/EGWR/EGSR07/195-206",
    .class_ = {.format = "ggx", .reciprocal = 1, .eval = ggx_eval, .free = nqm_free},
    .state_size = sizeof(ggx),
    .prepare = ggx_prepare,
};

/* ---- Ward -------------------------------------------------------------------------------------------------------- */

typedef struct ward {
    double diffuse[3];  /* kd / pi */
    double specular[3]; /* ks / (4 pi alpha^2) */
    double inverse_alpha2;
} ward;

static void ward_prepare(const nqm_spec_values *values, void *state) {
    ward *self = state;
    double alpha = values->v[2][0];
    self->inverse_alpha2 = 1 / (alpha * alpha);
    for (int c = 0; c < 3; ++c) {
        self->diffuse[c] = values->v[0][c] / NQM_PI;
        self->specular[c] = values->v[1][c] / (4 * NQM_PI * alpha * alpha);
    }
}

static void ward_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const ward *self = state;
    for (size_t i = 0; i < n; ++i) {
        nqm_half_angles h = nqm_half_angles_of(wi + 3 * i, wo + 3 * i);
        double lobe = exp(-h.tan2_h * self->inverse_alpha2) / sqrt(wi[3 * i + 2] * wo[3 * i + 2]);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = self->diffuse[c] + self->specular[c] * lobe;
    }
}

const nqm_analytic_model nqm_ward_model = {
    .schema = {"ward",
               3,
               {{.name = "kd", .n = 3, .low = 0, .high = 10, .fallback = 0},
                {.name = "ks", .n = 3, .low = 0, .high = 1e6, .required = true},
                {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true}}},
    .doi = "10.1145/142920.134078",
    .class_ = {.format = "ward", .reciprocal = 1, .eval = ward_eval, .free = nqm_free},
    .state_size = sizeof(ward),
    .prepare = ward_prepare,
};
