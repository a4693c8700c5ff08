/* SPDX-License-Identifier: MIT
 *
 * thin_film.h - the reflectance of a thin film on a surface: Belcour and Barla 2017, "A Practical Extension to
 * Microfacet Theory for the Modeling of Varying Iridescence" (DOI 10.1145/3072959.3073620), with the colour matching
 * functions as Gaussians. The outside is vacuum. MaterialX, glTF and Blender use the same sum with other reflectances
 * below the film, and turn it into RGB in other ways.
 */
#ifndef NQM_SRC_BRDF_THIN_FILM_H
#define NQM_SRC_BRDF_THIN_FILM_H

#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

/** A film: thickness in nm (0: none), index of refraction. */
typedef struct thin_film {
    double thickness, ior;
} thin_film;

/** Rules of the sum. */
typedef struct film_rules {
    int n_orders;
    double low, high; /**< range of the product of both reflectances */
    double to_rgb[3][3];
} film_rules;

/** Light inside the film. */
typedef struct film_light {
    double cosine; /**< with the normal; 0: it does not enter */
    double path;   /**< difference between two beams, in metres */
} film_light;

INLINED film_light film_enter(const thin_film *film, double cosine) {
    const double cos2 = 1 - (1 - cosine * cosine) / (film->ior * film->ior);
    const double inside = sqrt(fmax(0, cos2));
    return (film_light){inside, 2e-9 * film->ior * film->thickness * inside};
}

/** XYZ of cos(path, phase) over a constant spectrum; phase, xyz: (3). */
static inline void film_xyz(double path, const double *phase, double *xyz) {
    static const double value[4] = {5.4856e-13, 4.4201e-13, 5.2481e-13, 9.7470e-14};
    static const double position[4] = {1.6810e6, 1.7953e6, 2.2084e6, 2.2399e6};
    static const double variance[4] = {4.3278e9, 9.3046e9, 6.6121e9, 4.5282e9};
    const double w = 2 * NQM_PI * path;
    double lobe[4];
    for (size_t k = 0; k < 4; ++k)
        lobe[k] = value[k] * sqrt(2 * NQM_PI * variance[k]) * cos(position[k] * w + phase[k % 3]) *
                  exp(-variance[k] * w * w) / 1.0685e-7;
    xyz[0] = lobe[0] + lobe[3];
    xyz[1] = lobe[1];
    xyz[2] = lobe[2];
}

/** Add the terms of one polarisation. top, bottom (3): reflectances of both interfaces; phase (3): shift of both together; is_rgb:
 *  the colours of each term are RGB, else XYZ. */
static inline void film_add(const film_rules *rules, bool is_rgb, double path, double top, const double *bottom,
                            const double *phase, double *sum) {
    double amplitude[3], ratio[3];
    for (size_t c = 0; c < 3; ++c) {
        const double product = fmin(fmax(top * bottom[c], rules->low), rules->high), through = 1 - top;
        const double inner = product < 1 ? through * through * bottom[c] / (1 - product) : 0;
        sum[c] += top + inner;
        amplitude[c] = inner - through;
        ratio[c] = sqrt(product);
    }
    for (int order = 1; order <= rules->n_orders; ++order) {
        const double shift[3] = {order * phase[0], order * phase[1], order * phase[2]};
        double xyz[3];
        film_xyz(order * path, shift, xyz);
        for (size_t c = 0; c < 3; ++c) {
            amplitude[c] *= ratio[c];
            sum[c] += 2 * amplitude[c] * (is_rgb ? nqm_dot3(rules->to_rgb[c], xyz) : xyz[c]);
        }
    }
}

/* ---- polarised light: MaterialX 1.39, "Thin-Film Iridescence Model" of its specification; Blender ------------------------- */

/** MaterialX: to RGB with CIE's primaries, whose white is that of the sum, as in GLSL. */
static const film_rules film_rules_materialx = {
    2,
    0,
    1,
    {{2.3706743, -0.9000405, -0.4706338}, {-0.5138850, 1.4253036, 0.0885814}, {0.0052982, -0.0146949, 1.0093968}}};

/** The mean of both polarisations, s and p (2, 3). */
static inline void film_polarised(const film_rules *rules, const thin_film *film, double cosine, film_light light,
                                  const double (*bottom)[3], const double (*phase)[3], double *rgb) {
    const double brewster = 1 / sqrt(1 + film->ior * film->ior);
    const double shift[2] = {NQM_PI, cosine < brewster ? 0 : NQM_PI};
    double top[2], sum[3] = {0};
    fresnel_polarised(film->ior, 0, cosine, top);
    for (size_t p = 0; p < 2; ++p) {
        const double both[3] = {phase[p][0] + shift[p], phase[p][1] + shift[p], phase[p][2] + shift[p]};
        film_add(rules, false, light.path, light.cosine > 0 ? top[p] : 1, bottom[p], both, sum);
    }
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = fmin(fmax(0.5 * nqm_dot3(rules->to_rgb[c], sum), 0), 1);
}

/** On a surface of index eta + i k (3); indices of films below 1 count as 1. */
static inline void film_on_index(const film_rules *rules, thin_film film, double cosine, const double *eta,
                                 const double *k, double *rgb) {
    film.ior = fmax(film.ior, 1);
    const film_light light = film_enter(&film, cosine);
    const double n = film.ior, c = light.cosine;
    double bottom[2][3], phase[2][3];
    for (size_t i = 0; i < 3; ++i) {
        const double e2 = eta[i] * eta[i], k2 = k[i] * k[i], cross = 2 * eta[i] * k[i];
        const double a = e2 - k2 - n * n * (1 - c * c), b = sqrt(a * a + cross * cross);
        const double u = sqrt(fmax(0, (a + b) / 2)), v = sqrt(fmax(0, (b - a) / 2)), x = (e2 + k2) * c;
        double r[2];
        fresnel_polarised(eta[i] / n, k[i] / n, c, r);
        bottom[0][i] = r[0];
        bottom[1][i] = r[1];
        phase[0][i] = atan2(2 * n * v * c, u * u + v * v - n * n * c * c);
        phase[1][i] = atan2(2 * n * c * (cross * u - (e2 - k2) * v), x * x - n * n * (u * u + v * v));
    }
    film_polarised(rules, &film, cosine, light, (const double(*)[3])bottom, (const double(*)[3])phase, rgb);
}

/** On a base with Schlick's F0, F82 and F90 (RGB), as the specification says; MaterialX's GLSL halves the factor. */
static inline void film_on_schlick(thin_film film, double cosine, const double *f0, const double *f82,
                                   const double *f90, double *rgb) {
    film.ior = fmax(film.ior, 1);
    const film_light light = film_enter(&film, cosine);
    double bottom[2][3], phase[2][3];
    for (size_t i = 0; i < 3; ++i) {
        const double root = sqrt(fmin(fmax(f0[i], 0.01), 0.99)), eta = (1 + root) / (1 - root);
        bottom[0][i] = bottom[1][i] = fmin(fmax(schlick_f82(f0[i], f82[i], f90[i], light.cosine), 0), 1);
        phase[0][i] = phase[1][i] = eta < film.ior ? NQM_PI : 0;
    }
    film_polarised(&film_rules_materialx, &film, cosine, light, (const double(*)[3])bottom, (const double(*)[3])phase,
                   rgb);
}

/* ---- glTF: KHR_materials_iridescence ------------------------------------------------------------------------------- */

/** On a surface of reflectance f0 (3) at normal incidence, with Schlick's factors at both interfaces and no polarisation. */
static inline void film_on_gltf(const thin_film *film, double cosine, const double *f0, double *rgb) {
    static const film_rules rules = {
        2,
        1e-5,
        0.9999,
        {{3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}}};
    const film_light light = film_enter(film, cosine);
    double bottom[3], phase[3], sum[3] = {0};
    for (size_t i = 0; i < 3; ++i) {
        const double root = sqrt(fmin(f0[i], 0.9999)), eta = (1 + root) / (1 - root);
        bottom[i] = schlick_factor(f0_between(eta, film->ior), light.cosine);
        phase[i] = (film->ior < 1 ? 0 : NQM_PI) + (eta < film->ior ? NQM_PI : 0);
    }
    film_add(&rules, true, light.path, schlick_factor(f0_between(film->ior, 1), cosine), bottom, phase, sum);
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = light.cosine > 0 ? fmax(0, sum[c]) : 1;
}

#endif
