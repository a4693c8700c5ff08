/* SPDX-License-Identifier: MIT
 *
 * `pbrt-coated-diffuse` is pbrt-v4's `coateddiffuse` (Pharr, Jakob and Humphreys, Physically Based Rendering, 4th
 * edition, 14.3): a diffuse base under a rough dielectric interface with an absorbing gap. pbrt estimates its value by
 * random walks; this is their mean,
 *
 *   f = F D G / (4 cos cos) + d / (pi eta^2) T(cos_o) X(cos_i) (1 + d r + (d r)^2 + ...),   one term for two of `maxdepth`,
 *
 * with the transmittance T of interface and gap, and the fraction r of diffuse light that returns to the base. X is T
 * with the weights of the two strategies by which pbrt finds the light (LayeredBxDF::f), which do not sum to one (doc/materials.md).
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

enum { NQM_COATED_KEYS(NQM_KEY_INDEX) };

enum { N_COSINES = 96, N_RADII = 40, N_AZIMUTHS = 12, N_RETURNS = 96 };

typedef struct coated {
    nqm_spec_state spec;
    double diffuse[3];                         /* d / (pi eta^2) times the series */
    double enter[N_COSINES], leave[N_COSINES]; /* T and X at cosines (j / (N_COSINES - 1))^2 */
} coated;

typedef enum way { ENTER, LEAVE, RETURN } way;

/* The sum of the weights of both strategies for light of this cosine, refracted to -z by a normal with this cosine and height. */
static double weights(double alpha2, double eta, double cosine, double c, double refracted, double z, double h_z) {
    const double d = ggx_distribution(1 / (h_z * h_z) - 1, alpha2), jacobian = c / eta - refracted;
    const double common = d * c * refracted / (jacobian * jacobian), base = z / NQM_PI;
    const double inside = common / (cosine * (1 + smith_lambda(alpha2, cosine)));
    const double outside = common / (eta * eta * z * (1 + smith_lambda(alpha2, z)));
    return inside * inside / (inside * inside + base * base) + base * base / (base * base + outside * outside);
}

/* The mean over the visible normals of what goes on through the interface, or is reflected by it, and across the gap;
 * eta: beyond the interface relative to the side of the light. */
static double pass(const nqm_values *values, double cosine, double eta, way leg) {
    const double alpha2 = values->v[ROUGHNESS][0], alpha = sqrt(alpha2), gap = values->v[THICKNESS][0];
    const double wo[3] = {sqrt(fmax(0, 1 - cosine * cosine)), 0, cosine}, hidden = 1 + smith_lambda(alpha2, cosine);
    double sum = 0;
    for (size_t i = 0; i < N_RADII; ++i)
        for (size_t j = 0; j < N_AZIMUTHS; ++j) {
            /* dense at the edge, where normals are steep; azimuths of one half */
            const double t = ((double)i + 0.5) / N_RADII, turn = NQM_PI * (((double)j + 0.5) / N_AZIMUTHS - 0.5);
            const double r = sqrt(1 - t * t * t), across = r * cos(turn);
            double h[3];
            ggx_visible_normal(alpha, wo, (const double[]){across, r * sin(turn), sqrt(1 - across * across)}, h);
            const double c = fmin(1, wo[0] * h[0] + wo[2] * h[2]), f = fresnel_dielectric(eta, c);
            const double refracted = sqrt(fmax(0, 1 - (1 - c * c) / (eta * eta)));
            const double z = leg == RETURN ? 2 * c * h[2] - cosine : cosine / eta - (c / eta - refracted) * h[2];
            if (z <= 0)
                continue;
            const double weight = leg == LEAVE ? weights(alpha2, eta, cosine, c, refracted, z, h[2]) : 1;
            sum += 3 * t * t * (leg == RETURN ? f : 1 - f) * hidden / (hidden + smith_lambda(alpha2, z)) *
                   exp(-gap / z) * weight;
        }
    return sum / (N_RADII * N_AZIMUTHS);
}

static void coated_prepare(const nqm_values *values, void *state) {
    coated *self = state;
    const double eta = values->v[ETA][0], n_bounces = floor((values->v[MAX_DEPTH][0] + 1) / 2);
    double returned = 0;
    for (size_t j = 0; j < N_COSINES; ++j) {
        const double x = (double)j / (N_COSINES - 1), cosine = fmax(x * x, 1e-6);
        self->enter[j] = pass(values, cosine, eta, ENTER);
        self->leave[j] = pass(values, cosine, eta, LEAVE);
    }
    for (size_t j = 0; j < N_RETURNS; ++j) {
        const double cosine = sqrt(((double)j + 0.5) / N_RETURNS);
        returned += exp(-values->v[THICKNESS][0] / cosine) * pass(values, cosine, 1 / eta, RETURN) / N_RETURNS;
    }
    for (size_t c = 0; c < 3; ++c) {
        const double d = values->v[REFLECTANCE][c];
        self->diffuse[c] = d / (NQM_PI * eta * eta) * (1 - pow(d * returned, n_bounces)) / (1 - d * returned);
    }
}

static void coated_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const coated *self = state;
    const double(*v)[3] = self->spec.values.v;
    for (size_t i = 0; i < n; ++i) {
        const half_angles h = half_angles_of(wi + 3 * i, wo + 3 * i);
        const double cos_i = wi[3 * i + 2], cos_o = wo[3 * i + 2];
        const double top = correlated_ggx(h.tan2_h, cos_i, cos_o, equal_widths(v[ROUGHNESS][0])) *
                           fresnel_dielectric(v[ETA][0], h.cos_d);
        const double inside =
            look_up(self->enter, N_COSINES, sqrt(cos_o)) * look_up(self->leave, N_COSINES, sqrt(cos_i));
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = top + self->diffuse[c] * inside;
    }
}

NQM_SHADING_MODEL(coated, "pbrt-coated-diffuse", coated, coated_prepare, coated_eval, 0);
