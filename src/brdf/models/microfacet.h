/* SPDX-License-Identifier: MIT
 *
 * microfacet.h - the factors of microfacet BRDFs, for every model that needs them: half vector, distribution and shadowing
 * of GGX and Beckmann, and Fresnel factors. Cosines are in (0, 1].
 */
#ifndef NQM_SRC_BRDF_MICROFACET_H
#define NQM_SRC_BRDF_MICROFACET_H

#include "math/math.h"

#include <math.h>

/* ---- half vector ------------------------------------------------------------------------------------------------- */

/* Angles of the half vector, computed without normalising it: |wi + wo| = 2 cos theta_d. There is no cancellation near
 * theta_h = 0, where lobes can be narrower than a degree. */
typedef struct half_angles {
    double tan2_h, cos_d;
    double x, y; /* of wi + wo */
} half_angles;

/* Inlined: otherwise the simple lobes take twice the time. */
static inline half_angles half_angles_of(const double *wi, const double *wo) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    double xy = x * x + y * y;
    return (half_angles){.tan2_h = xy / (z * z), .cos_d = fmin(1, 0.5 * sqrt(xy + z * z)), .x = x, .y = y};
}

/* ---- widths: an anisotropic lobe is isotropic at each azimuth (Heitz 2014, https://jcgt.org/published/0003/02/03/, 5.3) ---- */

/** The widths of a lobe along a tangent and across it. */
typedef struct lobe_widths {
    double x2, y2;             /**< alpha^2 */
    double xy, mean;           /**< alpha_x alpha_y; its square root */
    double cos_turn, sin_turn; /**< of the azimuth of the tangent */
} lobe_widths;

/** Squares of both widths, which may be equal: then xy is the same number. */
static inline lobe_widths lobe_widths_of(double x2, double y2, double turn_rad) {
    const double xy = sqrt(x2 * y2);
    return (lobe_widths){x2, y2, xy, sqrt(xy), cos(turn_rad), sin(turn_rad)};
}

/** Mean of two values that belong to the tangent and across it, at the azimuth of (x, y). */
static inline double mean_at(const lobe_widths *w, double along, double across, double x, double y) {
    const double u = w->cos_turn * x + w->sin_turn * y, v = w->cos_turn * y - w->sin_turn * x, r2 = u * u + v * v;
    return r2 > 0 ? (along * u * u + across * v * v) / r2 : along;
}

/** alpha^2 at the azimuth of the half vector. */
static inline double half_alpha2(const lobe_widths *w, double x, double y) {
    return w->x2 == w->y2 ? w->x2 : 1 / mean_at(w, 1 / w->x2, 1 / w->y2, x, y);
}

/** alpha^2 for one pair of directions: at the azimuths of half vector, light and viewer; the distribution for h2 is multiplied by
 *  `scale`. */
typedef struct lobe_alphas {
    double h2, i2, o2, scale;
} lobe_alphas;

static inline lobe_alphas round_lobe(double alpha2) {
    return (lobe_alphas){alpha2, alpha2, alpha2, 1};
}

static inline lobe_alphas lobe_alphas_of(const lobe_widths *w, const half_angles *h, const double *wi,
                                         const double *wo) {
    if (w->x2 == w->y2)
        return round_lobe(w->x2);
    const double h2 = half_alpha2(w, h->x, h->y);
    return (lobe_alphas){h2, mean_at(w, w->x2, w->y2, wi[0], wi[1]), mean_at(w, w->x2, w->y2, wo[0], wo[1]),
                         h2 / w->xy};
}

/* ---- GGX: Walter, Marschner, Li and Torrance 2007, DOI 10.2312/EGWR/EGSR07/195-206 --------------------------------- */

/** D(h), in 1/sr; alpha2 is alpha^2. */
static inline double ggx_distribution(double tan2_h, double alpha2) {
    double sec2_h = 1 + tan2_h;
    double spread = (1 + tan2_h / alpha2) / sec2_h; /* cos^2 theta_h (1 + tan^2 theta_h / alpha^2) */
    return 1 / (NQM_PI * alpha2 * spread * spread);
}

/** Smith's G1 = 2 cos / (cos + sqrt(cos^2 + alpha^2 sin^2)), divided by 2 cos: D times this for light and viewer is the lobe with
 *  separable shadowing, D G1 G1 / (4 cos cos). */
static inline double ggx_visibility(double cosine, double alpha2) {
    double cos2 = cosine * cosine;
    return 1 / (cosine + sqrt(cos2 + alpha2 * (1 - cos2)));
}

/** D G / (4 cos cos) with height-correlated shadowing: Heitz 2014, equation 99. */
static inline double correlated_ggx(double tan2_h, double cos_i, double cos_o, const lobe_alphas *a) {
    double i = cos_i * sqrt(cos_o * cos_o + a->o2 * (1 - cos_o * cos_o));
    double o = cos_o * sqrt(cos_i * cos_i + a->i2 * (1 - cos_i * cos_i));
    return a->scale * ggx_distribution(tan2_h, a->h2) * (0.5 / (i + o));
}

/** D G1 G1 / (4 cos cos). */
static inline double separable_ggx(double tan2_h, double cos_i, double cos_o, const lobe_alphas *a) {
    return a->scale * ggx_distribution(tan2_h, a->h2) * ggx_visibility(cos_i, a->i2) * ggx_visibility(cos_o, a->o2);
}

/* ---- Beckmann: the same paper -------------------------------------------------------------------------------------- */

/** D(h), in 1/sr; alpha2 is alpha^2. */
static inline double beckmann_distribution(double tan2_h, double alpha2) {
    double sec2_h = 1 + tan2_h;
    return exp(-tan2_h / alpha2) * sec2_h * sec2_h / (NQM_PI * alpha2);
}

/** The rational approximation of Smith's G1, which is 1 where alpha tan theta < 1 / 1.6. */
static inline double beckmann_g1(double cosine, double alpha2) {
    double cos2 = cosine * cosine, a2 = cos2 / (alpha2 * (1 - cos2));
    if (!(a2 < 1.6 * 1.6))
        return 1;
    double a = sqrt(a2);
    return (3.535 * a + 2.181 * a2) / (1 + 2.276 * a + 2.577 * a2);
}

/** D G1 G1 / (4 cos cos). */
static inline double separable_beckmann(double tan2_h, double cos_i, double cos_o, const lobe_alphas *a) {
    return a->scale * beckmann_distribution(tan2_h, a->h2) * beckmann_g1(cos_i, a->i2) * beckmann_g1(cos_o, a->o2) /
           (4 * cos_i * cos_o);
}

/* ---- Fresnel factors --------------------------------------------------------------------------------------------- */

/** a with weight 1 - t, b with t. */
static inline double mix(double a, double b, double t) {
    return a + (b - a) * t;
}

static inline double power5(double x) {
    double x2 = x * x;
    return x2 * x2 * x;
}

/** Schlick 1994 (DOI 10.1111/1467-8659.1330233). */
static inline double schlick_factor(double f0, double cosine) {
    double m = 1 - cosine;
    return f0 + (1 - f0) * m * m * m * m * m;
}

/** Schlick's factor with the colours f0 at normal and f90 at grazing incidence. */
static inline double schlick_between(double f0, double f90, double cosine) {
    return f0 + (f90 - f0) * power5(1 - cosine);
}

/** Reflectance of unpolarised light at a dielectric, eta = n_transmitted / n_incident; 1 at total reflection. The form of
 *  Cook and Torrance 1982 (DOI 10.1145/357290.357293). */
static inline double fresnel_dielectric(double eta, double cosine) {
    double g2 = eta * eta + cosine * cosine - 1;
    if (g2 < 0)
        return 1;
    double g = sqrt(g2);
    double a = (g - cosine) / (g + cosine), b = ((g + cosine) * cosine - 1) / ((g - cosine) * cosine + 1);
    return 0.5 * a * a * (1 + b * b);
}

/** Reflectance of unpolarised light at a conductor of index eta + i k, from air; exact, Born and Wolf, Principles of Optics,
 *  14.4. */
static inline double fresnel_conductor(double eta, double k, double cosine) {
    double cos2 = cosine * cosine, sin2 = 1 - cos2, eta2 = eta * eta, k2 = k * k;
    double t = eta2 - k2 - sin2;
    double a2_b2 = sqrt(t * t + 4 * eta2 * k2);
    double a = sqrt(fmax(0, 0.5 * (a2_b2 + t)));
    double rs = (a2_b2 + cos2 - 2 * a * cosine) / (a2_b2 + cos2 + 2 * a * cosine);
    double p = cos2 * a2_b2 + sin2 * sin2, q = 2 * a * cosine * sin2;
    return 0.5 * (rs + rs * ((p - q) / (p + q)));
}

/** Schlick's factor with the tint f82 at 82 degrees (cosine 1/7), relative to Schlick's own value there: Kutz, Hasan and
 *  Edmondson 2021, "Novel aspects of the Adobe Standard Material". */
static inline double schlick_f82(double f0, double f82, double f90, double cosine) {
    const double at = 1.0 / 7, m = 1 - at;
    double schlick_82 = schlick_between(f0, f90, at);
    double b = schlick_82 * (1 - f82) / (at * m * power5(m));
    double c = 1 - cosine;
    return schlick_between(f0, f90, cosine) - b * cosine * c * power5(c);
}

#endif
