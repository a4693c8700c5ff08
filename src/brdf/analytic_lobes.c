/* SPDX-License-Identifier: MIT
 *
 * Lobes without a Fresnel term, as Ngan, Durand and Matusik (2005, DOI 10.2312/EGWR/EGSR05/117-126) fitted them: Ward
 * in the normalisation of Duer, Blinn-Phong, and one lobe of Lafortune. doc/brdf.md has the formulas.
 */
#include "brdf/analytic.h"

/* ---- Ward-Duer --------------------------------------------------------------------------------------------------- */

enum { KD, KS, FIRST_SHAPE };

static void ward_duer_prepare(const nqm_spec_values *values, void *state) {
    double alpha = values->v[FIRST_SHAPE][0];
    nqm_lobe *self = state;
    *self = nqm_lobe_make(values, 1 / (4 * NQM_PI * alpha * alpha));
    self->shape[0] = 1 / (alpha * alpha);
}

static double ward_duer(const double *shape, const double *wi, const double *wo) {
    return exp(-nqm_half_angles_of(wi, wo).tan2_h * shape[0]) / (wi[2] * wo[2]);
}

NQM_LOBE_MODEL(nqm_ward_duer_model, "ward-duer", "10.1080/2151237X.2006.10129215", ward_duer, ward_duer_prepare, 3,
               {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true});

/* ---- Blinn-Phong ------------------------------------------------------------------------------------------------- */

static void blinn_phong_prepare(const nqm_spec_values *values, void *state) {
    double n = values->v[FIRST_SHAPE][0];
    nqm_lobe *self = state;
    *self = nqm_lobe_make(values, (n + 2) / (2 * NQM_PI));
    self->shape[0] = -0.5 * n;
}

/* cos^n theta_h = (1 + tan^2 theta_h)^(-n / 2) */
static double blinn_phong(const double *shape, const double *wi, const double *wo) {
    return exp(shape[0] * log1p(nqm_half_angles_of(wi, wo).tan2_h));
}

NQM_LOBE_MODEL(nqm_blinn_phong_model, "blinn-phong", "10.1145/563858.563893", blinn_phong, blinn_phong_prepare, 3,
               {.name = "n", .n = 1, .low = 0, .high = 1e8, .required = true});

/* ---- Lafortune --------------------------------------------------------------------------------------------------- */

enum { CXY = FIRST_SHAPE, CZ, EXPONENT };

/* Only the ratio of the coefficients matters: they are scaled so that the larger is 1. */
static void lafortune_prepare(const nqm_spec_values *values, void *state) {
    double cxy = values->v[CXY][0], cz = values->v[CZ][0], n = values->v[EXPONENT][0];
    double largest = fmax(-cxy, cz);
    nqm_lobe *self = state;
    *self = nqm_lobe_make(values, (n + 2) / (2 * NQM_PI));
    self->shape[0] = (largest + cxy) / largest;
    self->shape[1] = (largest - cz) / largest;
    self->shape[2] = n;
}

/* The generalised cosine is cos(alpha) - a (-xy) - b z with a = 1 - |cxy|, b = 1 - cz (scaled), cos(alpha) between
 * viewer and mirrored light; 1 - cos(alpha) is half the squared distance between these two unit vectors, which loses no
 * precision for narrow lobes. */
static double lafortune(const double *shape, const double *wi, const double *wo) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], dz = wi[2] - wo[2];
    double deficit = 0.5 * (x * x + y * y + dz * dz); /* 1 - cos(alpha) */
    double xy = wi[0] * wo[0] + wi[1] * wo[1], z = wi[2] * wo[2];
    deficit += shape[1] * z - shape[0] * xy;
    return deficit < 1 ? exp(shape[2] * log1p(-deficit)) : 0;
}

NQM_LOBE_MODEL(nqm_lafortune_model, "lafortune", "10.1145/258734.258801", lafortune, lafortune_prepare, 5,
               {.name = "cxy", .n = 1, .low = -10, .high = -0.01, .fallback = -1},
               {.name = "cz", .n = 1, .low = 0, .high = 10, .required = true},
               {.name = "n", .n = 1, .low = 0, .high = 1e8, .required = true});
