/* SPDX-License-Identifier: MIT
 *
 * closures.h - the reflection nodes of MaterialX ("MaterialX Physically Based Shading Nodes", version 1.39) from which its surface
 * shaders are graphs: microfacet lobes, diffuse and sheen, and their combination by layer and mix.
 *
 * The specification leaves directional albedos and the compensation for multiple scattering to the implementation. Here they are
 * those of the reference GLSL generator (libraries/pbrlib/genglsl/lib: rational fits of the albedos by Stephen Hill, compensation
 * of Turquin 2019 with the Fresnel factor at the half vector). doc/materials.md lists what follows. Layers use the albedo for the
 * viewer only, so layered surfaces are not reciprocal.
 */
#ifndef NQM_SRC_BRDF_CLOSURES_H
#define NQM_SRC_BRDF_CLOSURES_H

#include "brdf/core/spec.h"
#include "brdf/models/thin_film.h"

/** Roughnesses below sqrt of this are rendered with it; GLSL has 1e-6, where 500 directions never meet the lobe. */
static const double MIN_ALPHA = 1e-4;
static const double WHITE[3] = {1, 1, 1};

/** One pair of directions. */
typedef struct geometry {
    double cos_i, cos_o;  /**< cosines of light and viewer with the normal */
    double cos_io, cos_d; /**< between both; between each and the half vector */
    double tan2_h;
    const double *wi, *wo;
} geometry;

INLINED geometry geometry_of(const double *wi, const double *wo) {
    half_angles h = half_angles_of(wi, wo);
    return (geometry){.cos_i = wi[2],
                      .cos_o = wo[2],
                      .cos_io = wi[0] * wo[0] + wi[1] * wo[1] + wi[2] * wo[2],
                      .cos_d = h.cos_d,
                      .tan2_h = h.tan2_h,
                      .wi = wi,
                      .wo = wo};
}

/** What a node gives: f_r (1/sr), and the fraction of light that reaches a node below it. */
typedef struct closure {
    double f[3], pass[3];
} closure;

/* ---- combination ------------------------------------------------------------------------------------------------- */

INLINED closure closure_layer(closure top, closure base) {
    for (size_t c = 0; c < 3; ++c) {
        top.f[c] += top.pass[c] * base.f[c];
        top.pass[c] *= base.pass[c];
    }
    return top;
}

/** The same of the specular part over the diffuse one, and of the clear coat over both. */
INLINED closure specular_layer(closure top, closure base) {
    if (MISTAKEN(DIFFUSE_NOT_REDUCED))
        memcpy(top.pass, WHITE, sizeof top.pass);
    return closure_layer(top, base);
}

INLINED closure coat_layer(closure top, closure base) {
    if (MISTAKEN(COAT_NOT_REDUCING))
        memcpy(top.pass, WHITE, sizeof top.pass);
    return closure_layer(top, base);
}

/** `a` with weight w, `b` with 1 - w. */
INLINED closure closure_mix(closure a, closure b, double w) {
    for (size_t c = 0; c < 3; ++c) {
        a.f[c] = w * a.f[c] + (MISTAKEN(DIFFUSE_OF_METAL) ? 1 : 1 - w) * b.f[c];
        a.pass[c] = w * a.pass[c] + (1 - w) * b.pass[c];
    }
    return a;
}

/* ---- microfacet lobes -------------------------------------------------------------------------------------------- */

INLINED double clamp01(double v) {
    return fmin(fmax(v, 0), 1);
}

/** The widths of a lobe. */
typedef struct lobe_shape {
    turned_widths widths;
    double xy, mean; /**< alpha_x alpha_y, and its square root */
} lobe_shape;

/** The widths are moved into the range of alpha. Equal ones have their square as xy, to the last bit. */
INLINED lobe_shape lobe_of(double x, double y, double turn_rad) {
    const double ax = fmin(fmax(x, MIN_ALPHA), 1), ay = fmin(fmax(y, MIN_ALPHA), 1), xy = ax * ay;
    return (lobe_shape){turned_widths_of(ax * ax, ay * ay, turn_rad), xy, sqrt(xy)};
}

INLINED lobe_shape round_lobe(double roughness) {
    return lobe_of(roughness * roughness, roughness * roughness, 0);
}

/** The node roughness_anisotropy. */
INLINED lobe_shape roughness_anisotropy(double roughness, double anisotropy, double turn_rad) {
    const double alpha = fmin(fmax(roughness * roughness, MIN_ALPHA), 1), aspect = sqrt(1 - fmin(anisotropy, 0.98));
    return lobe_of(alpha / aspect, alpha * aspect, turn_rad);
}

/** The common factors of the microfacet nodes. */
typedef struct microfacet {
    double f;         /**< D G / (4 cos cos) */
    double albedo[2]; /**< directional albedo is albedo[0] F0 + albedo[1] F90 */
    double scatter;   /**< (1 - E) / E with E = albedo[0] + albedo[1] */
} microfacet;

/** As the specification says, shadowing and albedos of an anisotropic lobe are those of its mean width. */
INLINED microfacet microfacet_of(const geometry *g, const lobe_shape *lobe) {
    const double x = g->cos_o, y = lobe->mean, x2 = x * x, y2 = y * y;
    const double terms[9] = {1, x, y, x * y, x2, y2, x2 * y, x * y2, x2 * y2};
    static const double fit[9][4] = {
        /* two numerators, two denominators */
        {0.1003, 0.9345, 1, 1},          {-0.6303, -2.323, -1.765, 0.2281}, {9.748, 2.229, 8.263, 15.94},
        {-2.038, -3.748, 11.53, -55.83}, {29.34, 1.424, 28.96, 13.08},      {-8.245, -0.7684, -7.507, 41.26},
        {-26.44, 1.436, -36.11, 54.9},   {19.99, 0.2913, 15.86, 300.2},     {-5.448, 0.6286, 33.37, -285.1},
    };
    double sum[4] = {0};
    for (size_t t = 0; t < 9; ++t)
        for (size_t r = 0; r < 4; ++r)
            sum[r] += fit[t][r] * terms[t];
    pair_widths a = turned_pair_widths(&lobe->widths, g->wi, g->wo);
    a.i2 = a.o2 = lobe->xy;
    microfacet m = {.f = correlated_ggx(g->tan2_h, g->cos_i, g->cos_o, a),
                    .albedo = {clamp01(sum[0] / sum[2]), clamp01(sum[1] / sum[3])}};
    double e = m.albedo[0] + m.albedo[1];
    m.scatter = MISTAKEN(COMPENSATION_LEFT_OUT) ? 0 : (1 - e) / e;
    return m;
}

INLINED bool is_film(const thin_film *film) {
    return film && film->thickness > 0;
}

/** film: on the surface, or NULL. The albedo is that without it, as in GLSL. */
INLINED closure dielectric_bsdf(const geometry *g, microfacet m, double weight, const double *tint, double ior,
                                const thin_film *film) {
    const double single = is_film(film) ? 0 : fresnel_dielectric(ior, g->cos_d);
    double fresnel[3] = {single, single, single};
    closure result;
    if (is_film(film))
        film_on_index(&film_rules_materialx, *film, g->cos_d, (const double[3]){ior, ior, ior}, (const double[3]){0},
                      fresnel);
    for (size_t c = 0; c < 3; ++c) {
        const double compensation = 1 + fresnel[c] * m.scatter;
        const double albedo = (m.albedo[0] * f0_between(ior, 1) + m.albedo[1]) * compensation;
        result.f[c] = weight * m.f * fresnel[c] * compensation * tint[c];
        result.pass[c] = 1 - weight * albedo;
    }
    return result;
}

/** The exponent is 5. */
INLINED closure generalized_schlick_bsdf(const geometry *g, microfacet m, double weight, const double *color0,
                                         const double *color82, const double *color90, const thin_film *film) {
    double albedo = 0, covered[3];
    closure result;
    if (is_film(film))
        film_on_schlick(*film, g->cos_d, color0, color82, color90, covered);
    for (size_t c = 0; c < 3; ++c) {
        const double fresnel =
            is_film(film) ? covered[c] : fmax(0, schlick_f82(color0[c], color82[c], color90[c], g->cos_d));
        const double compensation = 1 + fresnel * m.scatter;
        albedo += (m.albedo[0] * color0[c] + m.albedo[1] * color90[c]) * compensation / 3;
        result.f[c] = weight * m.f * fresnel * compensation;
    }
    for (size_t c = 0; c < 3; ++c)
        result.pass[c] = 1 - weight * albedo;
    return result;
}

INLINED closure schlick_bsdf(const geometry *g, microfacet m, double weight, const double *color0,
                             const double *color82) {
    return generalized_schlick_bsdf(g, m, weight, color0, color82, WHITE, NULL);
}

/** The node artistic_ior, Gulbrandsen 2014 (https://jcgt.org/published/0003/04/03/); the reflectivity ends at 0.99 as in GLSL. */
INLINED void artistic_ior(double reflectivity, double edge, double *ior, double *extinction) {
    const double r = fmin(fmax(reflectivity, 0), 0.99), g = clamp01(edge), root = sqrt(r);
    *ior = g * (1 - r) / (1 + r) + (1 - g) * (1 + root) / (1 - root);
    const double up = *ior + 1, down = *ior - 1;
    *extinction = sqrt(fmax(0, (up * up * r - down * down) / (1 - r)));
}

INLINED closure conductor_bsdf(const geometry *g, microfacet m, const double *ior, const double *extinction,
                               const thin_film *film) {
    closure result = {.pass = {0}};
    double covered[3];
    if (is_film(film))
        film_on_index(&film_rules_materialx, *film, g->cos_d, ior, extinction, covered);
    for (size_t c = 0; c < 3; ++c) {
        const double fresnel = is_film(film) ? covered[c] : fresnel_conductor(ior[c], extinction[c], g->cos_d);
        result.f[c] = m.f * fresnel * (1 + fresnel * m.scatter);
    }
    return result;
}

/* ---- diffuse ----------------------------------------------------------------------------------------------------- */

/** (cos_io - cos_i cos_o) divided by the larger cosine where it is positive; `below` multiplies it elsewhere. */
INLINED double retro_reflection(const geometry *g, double below) {
    double s = g->cos_io - g->cos_i * g->cos_o;
    return s > 0 ? s / fmax(g->cos_i, g->cos_o) : below * s;
}

INLINED closure diffuse_closure(double weight, const double *color, double factor) {
    closure result = {.pass = {0}};
    for (size_t c = 0; c < 3; ++c)
        result.f[c] = weight * color[c] * factor / DIFFUSE_PI;
    return result;
}

/** The qualitative model of Oren and Nayar 1994. */
INLINED closure oren_nayar_bsdf(const geometry *g, double weight, const double *color, double roughness) {
    const double s2 = roughness * roughness;
    const double factor = 1 - 0.5 * s2 / (s2 + 0.33) + 0.45 * s2 / (s2 + 0.09) * retro_reflection(g, 0);
    return diffuse_closure(weight, color, factor);
}

/** G(theta) of Fujii's model, without a difference of almost equal numbers at grazing angles. */
INLINED double fujii_g(double cosine) {
    const double s = sqrt(fmax(0, 1 - cosine * cosine));
    return s * (acos(fmin(1, cosine)) - s * cosine) + 2.0 / 3 * (s * cosine * (1 + s + s * s) / (1 + s) - s);
}

/** Energy-preserving Oren-Nayar (Portsmouth, Kutz and Hill 2025, https://jcgt.org/published/0014/01/06/): single and multiple
 *  scattering, and the mean albedo of the former. 1 - E, which vanishes with the roughness, is divided by it in closed form. */
typedef struct eon_terms {
    double single, multiple, mean;
} eon_terms;

INLINED eon_terms eon_terms_of(const geometry *g, double roughness) {
    const double c1 = 0.5 - 2 / (3 * NQM_PI), c2 = 2.0 / 3 - 28 / (15 * NQM_PI);
    const double a = 1 / (1 + c1 * roughness);
    eon_terms t = {.single = a * (1 + roughness * retro_reflection(g, 1)), .mean = a * (1 + c2 * roughness)};
    if (roughness > 0)
        t.multiple = roughness * a * (c1 - fujii_g(g->cos_i) / NQM_PI) * (c1 - fujii_g(g->cos_o) / NQM_PI) / (c1 - c2);
    return t;
}

INLINED double eon_bounced(const eon_terms *t, double color) {
    return color * color * t->mean / (1 - color * (1 - t->mean));
}

INLINED closure eon_bsdf(const geometry *g, double weight, const double *color, double roughness) {
    const eon_terms t = eon_terms_of(g, roughness);
    closure result = {.pass = {0}};
    for (size_t c = 0; c < 3; ++c)
        result.f[c] = weight * (color[c] * t.single + eon_bounced(&t, color[c]) * t.multiple) / DIFFUSE_PI;
    return result;
}

/** The diffuse component of Burley 2012. */
INLINED closure burley_bsdf(const geometry *g, double weight, const double *color, double roughness) {
    const double f90 = 0.5 + 2 * roughness * g->cos_d * g->cos_d;
    const double factor = plain_schlick(1, f90, g->cos_i) * plain_schlick(1, f90, g->cos_o);
    return diffuse_closure(weight, color, MISTAKEN(DIFFUSE_LAMBERT) ? 1 : factor);
}

/* ---- sheen ------------------------------------------------------------------------------------------------------- */

INLINED closure sheen_closure(double weight, const double *color, double f, double albedo) {
    closure result;
    for (size_t c = 0; c < 3; ++c) {
        result.f[c] = weight * color[c] * f;
        result.pass[c] = MISTAKEN(SHEEN_NOT_SCALED) ? 1 : 1 - weight * albedo;
    }
    return result;
}

/** Estevez and Kulla 2017, with GLSL's lower bound of the roughness. */
INLINED closure conty_kulla_sheen(const geometry *g, double weight, const double *color, double roughness) {
    const double x = g->cos_o, r = roughness, inverse = 1 / fmax(r, 0.005);
    const double sin2_h = g->tan2_h / (1 + g->tan2_h);
    const double d = (2 + inverse) * pow(sin2_h, 0.5 * inverse) / (2 * NQM_PI);
    const double f = d / (4 * (g->cos_i + g->cos_o - g->cos_i * g->cos_o));
    const double p =
        13.67300 - 68.78018 * x + 799.08825 * r - 905.00061 * x * r + 60.28956 * x * x + 1086.96473 * r * r;
    const double q = 1 + 61.57746 * x + 442.78211 * r + 2597.49308 * x * r + 121.81241 * x * x + 3045.55075 * r * r;
    return sheen_closure(weight, color, f, clamp01(p / q));
}

/** Zeltner, Burley and Chiang 2022: a clamped cosine, linearly transformed by a and b in the plane of the viewer. */
INLINED closure transformed_sheen(const geometry *g, double weight, const double *color, double albedo, double a,
                                  double b) {
    const double x = g->cos_o, sin_o = sqrt(fmax(0, 1 - x * x)), sin2_i = fmax(0, 1 - g->cos_i * g->cos_i);
    const double light_x = sin_o > 0 ? (g->cos_io - g->cos_i * x) / sin_o : 0; /* b = 0 where it matters not */
    const double u = a * light_x + b * g->cos_i;
    const double norm2 = u * u + a * a * fmax(0, sin2_i - light_x * light_x) + g->cos_i * g->cos_i;
    return sheen_closure(weight, color, albedo * a * a / (NQM_PI * norm2 * norm2), albedo);
}

/** With the fits of MaterialX. */
INLINED closure zeltner_sheen(const geometry *g, double weight, const double *color, double roughness) {
    const double x = g->cos_o, y = fmin(fmax(roughness, 0.01), 1);
    const double s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
    const double m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
    const double o = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y));
    const double away = (x - m) / s, albedo = exp(-0.5 * away * away) / (s * sqrt(2 * NQM_PI)) + o;
    const double a = (2.58126 * x + 0.813703 * y) * y / (1 + 0.310327 * x * x + 2.60994 * x * y);
    const double b =
        sqrt(fmax(0, 1 - x)) * (y - 1) * y * y * y / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
    return transformed_sheen(g, weight, color, albedo, a, b);
}

/** Define a shading model whose value at one pair of directions is evaluate() of its file. */
#define CLOSURE_MODEL(NAME, SPEC, STATE)                                                                               \
    static void eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {                   \
        for (size_t i = 0; i < n; ++i) {                                                                               \
            const geometry g = geometry_of(wi + 3 * i, wo + 3 * i);                                                    \
            const closure result = evaluate(state, &g);                                                                \
            memcpy(rgb + 3 * i, result.f, sizeof result.f);                                                            \
        }                                                                                                              \
    }                                                                                                                  \
    NQM_SHADING_MODEL(NAME, SPEC, STATE, prepare, eval, 0)

#endif
