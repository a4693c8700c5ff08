/* SPDX-License-Identifier: MIT
 *
 * Lobes with a Fresnel term. Cook-Torrance and Ashikhmin-Shirley, each in the two forms that were fitted to the MERL
 * materials: with Schlick's reflectance f0 (Ngan, Durand and Matusik 2005, DOI 10.2312/EGWR/EGSR05/117-126) and with an
 * index of refraction (Low, Kronander, Ynnerman and Unger 2012, DOI 10.1145/2077341.2077350); and the two models of Low
 * et al., whose tails are those of the ABC power spectrum. doc/brdf.md has the formulas.
 */
#include "brdf/analytic.h"

enum { KD, KS, FIRST_SHAPE };

/* Reflectance of unpolarised light at a dielectric, as Cook and Torrance 1982 write it. */
static double dielectric(double eta, double cosine) {
    double g = sqrt(fmax(0, eta * eta + cosine * cosine - 1));
    double a = (g - cosine) / (g + cosine);
    double b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
    return 0.5 * a * a * (1 + b * b);
}

/* Shadowing and masking of V-grooves (Torrance and Sparrow 1967), divided by cos theta_i cos theta_o. */
static double grooves(nqm_half_angles h, const double *wi, const double *wo) {
    double cos_h = 1 / sqrt(1 + h.tan2_h);
    return fmin(1, 2 * cos_h * fmin(wi[2], wo[2]) / h.cos_d) / (wi[2] * wo[2]);
}

/* ---- Cook-Torrance ----------------------------------------------------------------------------------------------- */

/* Beckmann's distribution without its constant 1 / (pi alpha^2), multiplied by grooves(). */
static double beckmann_grooves(nqm_half_angles h, double inverse_alpha2, const double *wi, const double *wo) {
    double sec2_h = 1 + h.tan2_h;
    return exp(-h.tan2_h * inverse_alpha2) * sec2_h * sec2_h * grooves(h, wi, wo);
}

static void prepare_beckmann(const nqm_spec_values *values, double factor, nqm_lobe *self) {
    double alpha = values->v[FIRST_SHAPE][0];
    *self = nqm_lobe_make(values, factor / (alpha * alpha));
    self->shape[0] = 1 / (alpha * alpha);
    self->shape[1] = values->v[FIRST_SHAPE + 1][0];
}

static void cook_torrance_prepare(const nqm_spec_values *values, void *state) {
    prepare_beckmann(values, 1 / (NQM_PI * NQM_PI), state);
}

static double cook_torrance(const double *shape, const double *wi, const double *wo) {
    nqm_half_angles h = nqm_half_angles_of(wi, wo);
    return beckmann_grooves(h, shape[0], wi, wo) * nqm_schlick(shape[1], h.cos_d);
}

NQM_LOBE_MODEL(nqm_cook_torrance_model, "cook-torrance", "10.1145/357290.357293", cook_torrance, cook_torrance_prepare,
               4, {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true},
               {.name = "f0", .n = 1, .low = 0, .high = 1, .required = true});

/* The distribution of Cook and Torrance 1982 itself, which lacks 1 / pi. */
static void low_cook_torrance_prepare(const nqm_spec_values *values, void *state) {
    prepare_beckmann(values, 1 / NQM_PI, state);
}

static double low_cook_torrance(const double *shape, const double *wi, const double *wo) {
    nqm_half_angles h = nqm_half_angles_of(wi, wo);
    return beckmann_grooves(h, shape[0], wi, wo) * dielectric(shape[1], h.cos_d);
}

NQM_LOBE_MODEL(nqm_low_cook_torrance_model, "low-cook-torrance", "10.1145/357290.357293", low_cook_torrance,
               low_cook_torrance_prepare, 4, {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true},
               {.name = "eta", .n = 1, .low = 1, .high = 1000, .required = true});

/* ---- Ashikhmin-Shirley ------------------------------------------------------------------------------------------- */

static void ashikhmin_prepare(const nqm_spec_values *values, void *state) {
    double n = values->v[FIRST_SHAPE][0];
    nqm_lobe *self = state;
    *self = nqm_lobe_make(values, (n + 1) / (8 * NQM_PI));
    self->shape[0] = -0.5 * n;
    self->shape[1] = values->v[FIRST_SHAPE + 1][0];
}

static double ashikhmin(nqm_half_angles h, double exponent, const double *wi, const double *wo) {
    return exp(exponent * log1p(h.tan2_h)) / (h.cos_d * fmax(wi[2], wo[2]));
}

static double ashikhmin_shirley(const double *shape, const double *wi, const double *wo) {
    nqm_half_angles h = nqm_half_angles_of(wi, wo);
    return ashikhmin(h, shape[0], wi, wo) * nqm_schlick(shape[1], h.cos_d);
}

NQM_LOBE_MODEL(nqm_ashikhmin_shirley_model, "ashikhmin-shirley", "10.1080/10867651.2000.10487522", ashikhmin_shirley,
               ashikhmin_prepare, 4, {.name = "n", .n = 1, .low = 0, .high = 1e8, .required = true},
               {.name = "f0", .n = 1, .low = 0, .high = 1, .required = true});

static double low_ashikhmin_shirley(const double *shape, const double *wi, const double *wo) {
    nqm_half_angles h = nqm_half_angles_of(wi, wo);
    return ashikhmin(h, shape[0], wi, wo) * dielectric(shape[1], h.cos_d);
}

NQM_LOBE_MODEL(nqm_low_ashikhmin_shirley_model, "low-ashikhmin-shirley", "10.1080/10867651.2000.10487522",
               low_ashikhmin_shirley, ashikhmin_prepare, 4,
               {.name = "n", .n = 1, .low = 0, .high = 1e8, .required = true},
               {.name = "eta", .n = 1, .low = 1, .high = 1000, .required = true});

/* ---- the two models of Low et al. -------------------------------------------------------------------------------- */

static void prepare_abc(const nqm_spec_values *values, double factor, nqm_lobe *self) {
    *self = nqm_lobe_make(values, factor);
    self->shape[0] = values->v[FIRST_SHAPE][0];
    self->shape[1] = -values->v[FIRST_SHAPE + 1][0];
    self->shape[2] = values->v[FIRST_SHAPE + 2][0];
}

static void abc_prepare(const nqm_spec_values *values, void *state) {
    prepare_abc(values, 1 / NQM_PI, state); /* the published amplitudes are for a model with this factor */
}

static double abc(const double *shape, const double *wi, const double *wo) {
    nqm_half_angles h = nqm_half_angles_of(wi, wo);
    double sec_h = sqrt(1 + h.tan2_h);
    double one_minus_cos_h = h.tan2_h / (sec_h * (sec_h + 1));
    return exp(shape[1] * log1p(shape[0] * one_minus_cos_h)) * grooves(h, wi, wo) * dielectric(shape[2], h.cos_d);
}

#define ABC_KEYS                                                                                                       \
    {.name = "B", .n = 1, .low = 0, .high = 1e9, .required = true},                                                    \
        {.name = "C", .n = 1, .low = 0, .high = 100, .required = true}, {                                              \
        .name = "eta", .n = 1, .low = 1, .high = 1000, .required = true                                                \
    }

NQM_LOBE_MODEL(nqm_abc_model, "abc", "10.1145/2077341.2077350", abc, abc_prepare, 5, ABC_KEYS);

static void smooth_prepare(const nqm_spec_values *values, void *state) {
    prepare_abc(values, 1, state);
}

/* In the plane of projected directions, the sum of both directions is the deviation from the mirror direction, and half
 * the length of their difference is the sine of the angle at which the Fresnel term is evaluated (equation 14). */
static double smooth(const double *shape, const double *wi, const double *wo) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], dx = wi[0] - wo[0], dy = wi[1] - wo[1];
    double deviation2 = x * x + y * y;
    double cosine = sqrt(fmax(0, 1 - 0.25 * (dx * dx + dy * dy)));
    return exp(shape[1] * log1p(shape[0] * deviation2)) * dielectric(shape[2], cosine);
}

NQM_LOBE_MODEL(nqm_smooth_model, "smooth", "10.1145/2077341.2077350", smooth, smooth_prepare, 5, ABC_KEYS);
