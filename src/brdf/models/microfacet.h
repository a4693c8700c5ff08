/* SPDX-License-Identifier: MIT
 *
 * microfacet.h - the factors of microfacet BRDFs, for every model that needs them: half vector, distribution and shadowing
 * of GGX and Beckmann, and Fresnel factors. Cosines are in (0, 1]. Anisotropic lobes are isotropic ones whose width depends on the
 * azimuth.
 */
#ifndef NQM_SRC_BRDF_MICROFACET_H
#define NQM_SRC_BRDF_MICROFACET_H

#include "brdf/core/mistakes.h"
#include "math/math.h"

#include <math.h>

/** Of diffuse parts. */
#define DIFFUSE_PI (MISTAKEN(DIFFUSE_WITHOUT_PI) ? 1 : NQM_PI)

/** a with weight 1 - t, b with t. */
static inline double mix(double a, double b, double t) {
    return a + (b - a) * t;
}

/** The lower of the two nodes around x, 0 to 1, of n even ones; *t: the weight of the upper one. */
static inline size_t node_below(size_t n, double x, double *t) {
    const double at = fmin(x, 1) * (double)(n - 1);
    const size_t i = at < (double)(n - 2) ? (size_t)at : n - 2;
    *t = at - (double)i;
    return i;
}

/** The value of a table (n) there. */
static inline double look_up(const double *table, size_t n, double x) {
    double t;
    const size_t i = node_below(n, x, &t);
    return mix(table[i], table[i + 1], t);
}

/* ---- half vector ------------------------------------------------------------------------------------------------- */

/* Angles of the half vector, computed without normalising it: |wi + wo| = 2 cos theta_d. There is no cancellation near
 * theta_h = 0, where lobes can be narrower than a degree. */
typedef struct half_angles {
    double tan2_h, cos_d;
} half_angles;

#ifdef NQM_WITH_MISTAKES
/* 1 / |h|^4 of the pair that is evaluated: what D of the components of an h of another length is multiplied by. */
static _Thread_local double mistaken_components;

static inline half_angles mistaken_half(half_angles h, const double *wi, const double *wo) {
    const bool is_long =
        MISTAKEN(HALF_NOT_NORMALISED) || MISTAKEN(HALF_IN_COMPONENTS); /* 2 cos theta_d; else half of it */
    const double length = is_long ? 2 : 1, cos_h = fmin(1, 0.5 * length * (wi[2] + wo[2]));
    const double cos_d = h.cos_d, half = length * cos_d;
    mistaken_components = 1 / (half * half * half * half);
    if (MISTAKEN(HALF_NOT_NORMALISED) || MISTAKEN(HALF_AVERAGED))
        h.tan2_h = 1 / (cos_h * cos_h) - 1;
    if (is_long || MISTAKEN(HALF_AVERAGED) || MISTAKEN(HALF_AVERAGED_IN_COMPONENTS))
        h.cos_d = fmin(1, half * cos_d);
    h.cos_d = MISTAKEN(FRESNEL_CONSTANT)    ? 1
              : MISTAKEN(FRESNEL_AT_VIEWER) ? wo[2]
              : MISTAKEN(FRESNEL_AT_LIGHT)  ? wi[2]
              : MISTAKEN(FRESNEL_AT_HALF)   ? 1 / sqrt(1 + h.tan2_h)
                                            : h.cos_d;
    return h;
}
#endif

/* Inlined: otherwise the simple lobes take twice the time. */
static inline half_angles half_angles_of(const double *wi, const double *wo) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    double xy = x * x + y * y;
    half_angles h = {.tan2_h = xy / (z * z), .cos_d = fmin(1, 0.5 * sqrt(xy + z * z))};
    IF_MISTAKEN(h = mistaken_half(h, wi, wo);)
    return h;
}

/* ---- anisotropy: Heitz 2014, equation 80 (https://jcgt.org/published/0003/02/03/) ---------------------------------- */

/** cos^2 and sin^2 of an azimuth. */
typedef struct azimuth {
    double cos2, sin2;
} azimuth;

/** The azimuth of (x, y); that of the tangent for (0, 0). */
static inline azimuth azimuth_of(double x, double y) {
    double x2 = x * x, y2 = y * y, xy = x2 + y2, inverse = 1 / xy;
    return xy > 1e-300 ? (azimuth){x2 * inverse, y2 * inverse} : (azimuth){1, 0};
}

static inline azimuth half_azimuth(const double *wi, const double *wo) {
    return azimuth_of(wi[0] + wo[0], wi[1] + wo[1]);
}

/** A quantity that is x along the tangent and y along the bitangent: x cos^2 + y sin^2. */
static inline double along(azimuth a, double x, double y) {
    return a.cos2 * x + a.sin2 * y;
}

/** alpha^2 along tangent and bitangent. */
typedef struct widths {
    double x2, y2;
} widths;

/** The alpha^2 with which isotropic functions have the values of anisotropic ones for a pair. */
typedef struct pair_widths {
    double h2;      /**< of the distribution, */
    double density; /**< whose value is to be multiplied by this */
    double i2, o2;  /**< of the shadowing of light and viewer */
} pair_widths;

static inline pair_widths equal_widths(double alpha2) {
    return (pair_widths){alpha2, 1, alpha2, alpha2};
}

/** Isotropic lobes keep their bits. */
static inline pair_widths pair_widths_of(widths a, const double *wi, const double *wo) {
    if (a.x2 == a.y2)
        return equal_widths(a.x2);
    if (MISTAKEN(AXES_EXCHANGED))
        a = (widths){a.y2, a.x2};
    double h2 = 1 / along(half_azimuth(wi, wo), 1 / a.x2, 1 / a.y2);
    if (MISTAKEN(SHADOWING_ISOTROPIC))
        return (pair_widths){h2, h2 / sqrt(a.x2 * a.y2), sqrt(a.x2 * a.y2), sqrt(a.x2 * a.y2)};
    return (pair_widths){.h2 = h2,
                         .density = h2 / sqrt(a.x2 * a.y2),
                         .i2 = along(azimuth_of(wi[0], wi[1]), a.x2, a.y2),
                         .o2 = along(azimuth_of(wo[0], wo[1]), a.x2, a.y2)};
}

/** Widths of a tangent that is turned about the normal. */
typedef struct turned_widths {
    widths widths;
    double cos_turn, sin_turn;
} turned_widths;

static inline turned_widths turned_widths_of(double x2, double y2, double turn_rad) {
    return (turned_widths){{x2, y2}, cos(turn_rad), sin(turn_rad)};
}

static inline pair_widths turned_pair_widths(const turned_widths *t, const double *wi, const double *wo) {
    if (t->widths.x2 == t->widths.y2)
        return equal_widths(t->widths.x2);
    const double c = t->cos_turn, s = t->sin_turn;
    const double in[2] = {c * wi[0] + s * wi[1], c * wi[1] - s * wi[0]};
    const double out[2] = {c * wo[0] + s * wo[1], c * wo[1] - s * wo[0]};
    return pair_widths_of(t->widths, in, out);
}

/* ---- Beckmann: Walter, Marschner, Li and Torrance 2007, DOI 10.2312/EGWR/EGSR07/195-206 ---------------------------- */

/** D(h), in 1/sr; alpha2 is alpha^2. */
static inline double beckmann_distribution(double tan2_h, double alpha2) {
    double sec2_h = 1 + tan2_h;
    if (MISTAKEN(DISTRIBUTION_WITHOUT_PI))
        return exp(-tan2_h / alpha2) * sec2_h * sec2_h / alpha2;
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

/* ---- GGX: the same paper ------------------------------------------------------------------------------------------- */

/** D(h), in 1/sr; alpha2 is alpha^2. */
static inline double ggx_distribution(double tan2_h, double alpha2) {
    double sec2_h = 1 + tan2_h;
    double spread = (1 + tan2_h / alpha2) / sec2_h; /* cos^2 theta_h (1 + tan^2 theta_h / alpha^2) */
    if (MISTAKEN(DISTRIBUTION_BECKMANN))
        return beckmann_distribution(tan2_h, alpha2);
    if (MISTAKEN(DISTRIBUTION_WITHOUT_PI))
        return 1 / (alpha2 * spread * spread);
    if (MISTAKEN(DISTRIBUTION_NOT_SQUARED))
        return 1 / (NQM_PI * alpha2 * spread);
    return 1 / (NQM_PI * alpha2 * spread * spread);
}

/** Smith's G1 = 2 cos / (cos + sqrt(cos^2 + alpha^2 sin^2)), divided by 2 cos: D times this for light and viewer is the lobe with
 *  separable shadowing, D G1 G1 / (4 cos cos). */
static inline double ggx_visibility(double cosine, double alpha2) {
    double cos2 = cosine * cosine;
    return 1 / (cosine + sqrt(cos2 + alpha2 * (1 - cos2)));
}

/** Smith's Lambda. */
static inline double smith_lambda(double alpha2, double cosine) {
    return 0.5 * (sqrt(mix(cosine * cosine, 1, alpha2)) / cosine - 1);
}

/** The visible normal of w at a point (x, y, sqrt(1 - x^2)) of the disk of Heitz 2018
 *  (https://jcgt.org/published/0007/04/01/), whose x is across w. */
static inline void ggx_visible_normal(double alpha, const double *w, const double *point, double *h) {
    const double x = alpha * w[0], y = alpha * w[1], xy2 = x * x + y * y, xy = sqrt(xy2);
    const double scale = 1 / sqrt(xy2 + w[2] * w[2]), vz = w[2] * scale, v = xy * scale;
    const double turn = xy > 1e-12 ? 1 / xy : 0, cos_turn = xy > 1e-12 ? x * turn : 1, sin_turn = y * turn;
    const double along_disk = mix(point[2], point[1], 0.5 * (1 + vz));
    const double up2 = point[2] * point[2] - along_disk * along_disk, up = sqrt(up2 > 0 ? up2 : 0);
    const double out = alpha * (up * v - along_disk * vz), side = alpha * point[0];
    const double height = up * vz + along_disk * v, z = height > 1e-6 ? height : 1e-6,
                 norm = 1 / sqrt(out * out + side * side + z * z);
    h[0] = norm * (out * cos_turn - side * sin_turn);
    h[1] = norm * (out * sin_turn + side * cos_turn);
    h[2] = norm * z;
}

#ifdef NQM_WITH_MISTAKES
/** Widths of the shadowing that a mistake changes. */
static inline pair_widths mistaken_widths(pair_widths a) {
    if (MISTAKEN(SHADOWING_ALPHA))
        a.i2 = sqrt(a.i2), a.o2 = sqrt(a.o2);
    return a;
}

/** The factor by which a mistake changes v = G / (4 cos cos); 1: there is none. g_i, g_o: Smith's G1. */
static inline double visibility_mistake(double v, double g_i, double g_o, double cos_i, double cos_o, pair_widths a) {
    const double whole = 1 / (4 * cos_i * cos_o);
    if (MISTAKEN(SHADOWING_SCHLICK) || MISTAKEN(SHADOWING_POINT_LIGHTS)) {
        const double i = sqrt(a.i2), o = sqrt(a.o2), r = 1 + sqrt(sqrt(i * o));
        const double ki = MISTAKEN(SHADOWING_SCHLICK) ? i / 2 : r * r / 8,
                     ko = MISTAKEN(SHADOWING_SCHLICK) ? o / 2 : ki;
        return 0.25 / ((cos_i * (1 - ki) + ki) * (cos_o * (1 - ko) + ko)) / v;
    }
    return MISTAKEN(SHADOWING_LEFT_OUT)                                            ? whole / v
           : MISTAKEN(SHADOWING_SEPARABLE)                                         ? whole * g_i * g_o / v
           : MISTAKEN(SHADOWING_CORRELATED)                                        ? whole / (1 / g_i + 1 / g_o - 1) / v
           : MISTAKEN(FOUR_COSINES_LEFT_OUT)                                       ? 1 / whole
           : MISTAKEN(FOUR_COSINES_TWICE)                                          ? whole
           : MISTAKEN(FOUR_LEFT_OUT)                                               ? 4
           : MISTAKEN(FOUR_IS_PI)                                                  ? 4 / NQM_PI
           : MISTAKEN(HALF_IN_COMPONENTS) || MISTAKEN(HALF_AVERAGED_IN_COMPONENTS) ? mistaken_components
                                                                                   : 1;
}

static inline double ggx_mistake(double v, double cos_i, double cos_o, pair_widths a) {
    return visibility_mistake(v, 2 * cos_i * ggx_visibility(cos_i, a.i2), 2 * cos_o * ggx_visibility(cos_o, a.o2),
                              cos_i, cos_o, a);
}

static inline double beckmann_mistake(double cos_i, double cos_o, pair_widths a) {
    const double i = beckmann_g1(cos_i, a.i2), o = beckmann_g1(cos_o, a.o2);
    return visibility_mistake(i * o / (4 * cos_i * cos_o), i, o, cos_i, cos_o, a);
}
#endif

/** D G / (4 cos cos) with height-correlated shadowing: Heitz 2014, equation 99. */
static inline double correlated_ggx(double tan2_h, double cos_i, double cos_o, pair_widths a) {
    IF_MISTAKEN(a = mistaken_widths(a);)
    double i = cos_i * sqrt(cos_o * cos_o + a.o2 * (1 - cos_o * cos_o));
    double o = cos_o * sqrt(cos_i * cos_i + a.i2 * (1 - cos_i * cos_i));
    return TIMES_MISTAKE(ggx_distribution(tan2_h, a.h2) * a.density * (0.5 / (i + o)),
                         ggx_mistake(0.5 / (i + o), cos_i, cos_o, a));
}

/** D G1 G1 / (4 cos cos). */
static inline double separable_ggx(double tan2_h, double cos_i, double cos_o, pair_widths a) {
    IF_MISTAKEN(a = mistaken_widths(a);)
    return TIMES_MISTAKE(ggx_distribution(tan2_h, a.h2) * a.density * ggx_visibility(cos_i, a.i2) *
                             ggx_visibility(cos_o, a.o2),
                         ggx_mistake(ggx_visibility(cos_i, a.i2) * ggx_visibility(cos_o, a.o2), cos_i, cos_o, a));
}

/** D G1 G1 / (4 cos cos). */
static inline double separable_beckmann(double tan2_h, double cos_i, double cos_o, pair_widths a) {
    IF_MISTAKEN(a = mistaken_widths(a);)
    if (MISTAKEN(DISTRIBUTION_GGX))
        return ggx_distribution(tan2_h, a.h2) * a.density * beckmann_g1(cos_i, a.i2) * beckmann_g1(cos_o, a.o2) /
               (4 * cos_i * cos_o);
    return TIMES_MISTAKE(beckmann_distribution(tan2_h, a.h2) * a.density * beckmann_g1(cos_i, a.i2) *
                             beckmann_g1(cos_o, a.o2) / (4 * cos_i * cos_o),
                         beckmann_mistake(cos_i, cos_o, a));
}

/* ---- Fresnel factors --------------------------------------------------------------------------------------------- */

static inline double power5(double x) {
    double x2 = x * x;
    IF_MISTAKEN(if (MISTAKEN(SCHLICK_EXPONENT)) return pow(x, nqm_mistakes_made.amount);)
    return x2 * x2 * x;
}

/** Reflectance at normal incidence, of the indices of both sides. */
static inline double f0_between(double inside, double outside) {
    const double r = (inside - outside) / (inside + outside);
    return r * r;
}

/** Of every Fresnel factor. */
static inline double fresnel_mistake(double f) {
    return MISTAKEN(FRESNEL_LEFT_OUT) ? 1 : MISTAKEN(FRESNEL_TWICE) ? f * f : f;
}

/** Schlick 1994 (DOI 10.1111/1467-8659.1330233). */
static inline double schlick_factor(double f0, double cosine) {
    double m = 1 - cosine;
    IF_MISTAKEN(if (MISTAKEN(SCHLICK_EXPONENT)) return fresnel_mistake(f0 + (1 - f0) * power5(m));)
    return fresnel_mistake(f0 + (1 - f0) * m * m * m * m * m);
}

static inline double plain_schlick(double f0, double f90, double cosine) {
    return f0 + (f90 - f0) * power5(1 - cosine);
}

/** Schlick's factor with the colours f0 at normal and f90 at grazing incidence. */
static inline double schlick_between(double f0, double f90, double cosine) {
    return fresnel_mistake(plain_schlick(f0, MISTAKEN(F90_ONE) ? 1 : f90, cosine));
}

/** Reflectance of unpolarised light at a dielectric, eta = n_transmitted / n_incident; 1 at total reflection. The form of
 *  Cook and Torrance 1982 (DOI 10.1145/357290.357293). */
static inline double fresnel_dielectric(double eta, double cosine) {
    if (MISTAKEN(FRESNEL_SCHLICK))
        return schlick_factor((eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)), cosine);
    double g2 = eta * eta + cosine * cosine - 1;
    if (g2 < 0)
        return 1;
    double g = sqrt(g2);
    double a = (g - cosine) / (g + cosine), b = ((g + cosine) * cosine - 1) / ((g - cosine) * cosine + 1);
    return fresnel_mistake(0.5 * a * a * (1 + b * b));
}

/** Reflectances of light that is polarised at right angles (s) and parallel (p) to the plane of incidence, at a conductor of index
 *  eta + i k relative to the outside; exact, Born and Wolf, Principles of Optics, 14.4. sp: (2) */
static inline void fresnel_polarised(double eta, double k, double cosine, double *sp) {
    double cos2 = cosine * cosine, sin2 = 1 - cos2, eta2 = eta * eta, k2 = k * k;
    double t = eta2 - k2 - sin2;
    double a2_b2 = sqrt(t * t + 4 * eta2 * k2);
    double a = sqrt(fmax(0, 0.5 * (a2_b2 + t)));
    double rs = (a2_b2 + cos2 - 2 * a * cosine) / (a2_b2 + cos2 + 2 * a * cosine);
    double p = cos2 * a2_b2 + sin2 * sin2, q = 2 * a * cosine * sin2;
    sp[0] = rs;
    sp[1] = rs * ((p - q) / (p + q));
}

/** The same for unpolarised light. */
static inline double fresnel_conductor(double eta, double k, double cosine) {
    double sp[2];
    if (MISTAKEN(FRESNEL_SCHLICK))
        return schlick_factor(((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k), cosine);
    fresnel_polarised(eta, k, cosine, sp);
    return fresnel_mistake(0.5 * (sp[0] + sp[1]));
}

/** Schlick's factor with the tint f82 at 82 degrees (cosine 1/7), relative to Schlick's own value there: Kutz, Hasan and
 *  Edmondson 2021, "Novel aspects of the Adobe Standard Material". */
static inline double schlick_f82(double f0, double f82, double f90, double cosine) {
    const double at = 1.0 / 7, m = 1 - at;
    IF_MISTAKEN(f90 = MISTAKEN(F90_ONE) ? 1 : f90;)
    double schlick_82 = plain_schlick(f0, f90, at);
    double b = schlick_82 * (1 - f82) / (at * m * power5(m));
    double c = 1 - cosine;
    return fresnel_mistake(plain_schlick(f0, f90, cosine) - b * cosine * c * power5(c));
}

#endif
