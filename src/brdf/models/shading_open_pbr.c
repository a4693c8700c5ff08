/* SPDX-License-Identifier: MIT
 *
 * OpenPBR Surface 1.1.1 as MaterialX 1.39 defines it (open_pbr_surface.mtlx, the node graph), opaque reflection only:
 * fuzz over coat over a mixture of metal and of a dielectric with a diffuse base.
 */
#include "brdf/models/closures.h"

enum { NQM_OPEN_PBR_KEYS(NQM_KEY_INDEX) N_KEYS };

/* What the keys make together; the others are read from the spec. */
typedef struct open_pbr {
    nqm_spec_state spec;
    lobe_shape base, coat;
    double ior, metal[3], under_coat[3]; /* under_coat: darkening and colour */
} open_pbr;

/* The node open_pbr_anisotropy. */
static lobe_shape anisotropic(double roughness, double anisotropy) {
    const double ratio = 1 - anisotropy, x = roughness * roughness * sqrt(2 / (1 + ratio * ratio));
    return lobe_of(x, ratio * x, 0);
}

/* The index of the dielectric below the coat, modulated by specular_weight. */
static double modulated_ior(double weight, double ior, double coat_weight, double coat_ior) {
    const double ratio = ior / coat_ior;
    const double covered = ratio > 1 ? ratio : fmin(coat_ior / ior, 1e6);
    const double eta = coat_weight > 0 ? coat_weight * covered + (1 - coat_weight) * ior : ior;
    const double root = sqrt(fmin(weight * f0_between(eta, 1), 0.99999)), e = eta > 1 ? root : eta < 1 ? -root : 0;
    return (1 + e) / (1 - e);
}

/* What the coat lets through, beside its reflection: absorption, and darkening by inter-reflections below it. v: the keys
 * that are single numbers. */
static double under_coat(const double *v, double base, double coat_color) {
    const double coat = v[COAT_WEIGHT], ior = v[COAT_IOR];
    const double k = 1 - (1 - f0_between(ior, 1)) / (ior * ior);
    const double albedo = base * (1 + v[BASE_METALNESS] * (v[SPECULAR_WEIGHT] - 1));
    const double darkening = 1 + coat * v[COAT_DARKENING] * ((1 - k) / (1 - albedo * k) - 1);
    return clamp01(darkening) * clamp01(1 + coat * (coat_color - 1));
}

static void prepare(const nqm_values *values, void *state) {
    double v[N_KEYS];
    for (size_t k = 0; k < N_KEYS; ++k)
        v[k] = values->v[k][0];
    open_pbr *self = state;
    self->coat = anisotropic(v[COAT_ROUGHNESS], v[COAT_ANISOTROPY]);
    self->ior = modulated_ior(v[SPECULAR_WEIGHT], v[SPECULAR_IOR], v[COAT_WEIGHT], v[COAT_IOR]);
    const double rough4 = v[SPECULAR_ROUGHNESS] * v[SPECULAR_ROUGHNESS] * v[SPECULAR_ROUGHNESS] * v[SPECULAR_ROUGHNESS];
    const double coat4 = v[COAT_ROUGHNESS] * v[COAT_ROUGHNESS] * v[COAT_ROUGHNESS] * v[COAT_ROUGHNESS];
    const double widened = sqrt(sqrt(fmin(1, rough4 + 2 * coat4)));
    self->base =
        anisotropic(v[SPECULAR_ROUGHNESS] + v[COAT_WEIGHT] * (widened - v[SPECULAR_ROUGHNESS]), v[SPECULAR_ANISOTROPY]);
    for (size_t c = 0; c < 3; ++c) {
        const double base = values->v[BASE_COLOR][c];
        self->metal[c] = base * v[BASE_WEIGHT];
        self->under_coat[c] = under_coat(v, base, values->v[COAT_COLOR][c]);
    }
}

/* The graph mixes lobes with and without the film. */
static thin_film film_of(const open_pbr *self) {
    return (thin_film){1000 * self->spec.values.v[THIN_FILM_THICKNESS][0], self->spec.values.v[THIN_FILM_IOR][0]};
}

static closure dielectric(const open_pbr *self, const geometry *g, microfacet m) {
    const double(*v)[3] = self->spec.values.v, weight = v[THIN_FILM_WEIGHT][0];
    const thin_film film = film_of(self);
    closure result = dielectric_bsdf(g, m, 1, v[SPECULAR_COLOR], self->ior, NULL);
    if (weight > 0)
        result = closure_mix(dielectric_bsdf(g, m, 1, v[SPECULAR_COLOR], self->ior, &film), result, weight);
    return result;
}

static closure metal(const open_pbr *self, const geometry *g, microfacet m) {
    const double(*v)[3] = self->spec.values.v, amount = v[SPECULAR_WEIGHT][0], weight = v[THIN_FILM_WEIGHT][0];
    const thin_film film = film_of(self);
    closure result = schlick_bsdf(g, m, amount, self->metal, v[SPECULAR_COLOR]);
    if (weight > 0) {
        const closure on = generalized_schlick_bsdf(g, m, amount, self->metal, v[SPECULAR_COLOR], WHITE, &film);
        result = closure_mix(on, result, weight);
    }
    return result;
}

static closure evaluate(const void *state, const geometry *g) {
    const open_pbr *self = state;
    const double(*v)[3] = self->spec.values.v, metalness = v[BASE_METALNESS][0];
    const microfacet m = microfacet_of(g, &self->base);
    closure result = eon_bsdf(g, v[BASE_WEIGHT][0], v[BASE_COLOR], v[BASE_DIFFUSE_ROUGHNESS][0]);
    if (metalness < 1)
        result = specular_layer(dielectric(self, g, m), result);
    if (metalness > 0)
        result = closure_mix(metal(self, g, m), result, metalness);
    if (v[COAT_WEIGHT][0] > 0) {
        for (size_t c = 0; c < 3; ++c)
            result.f[c] *= self->under_coat[c];
        const microfacet coat = microfacet_of(g, &self->coat);
        const double ior = MISTAKEN(COAT_F0_FIXED) ? 1.5 : v[MISTAKEN(COAT_F0_OF_INDEX) ? SPECULAR_IOR : COAT_IOR][0];
        result = coat_layer(dielectric_bsdf(g, coat, v[COAT_WEIGHT][0], WHITE, ior, NULL), result);
    }
    if (v[FUZZ_WEIGHT][0] > 0)
        result = closure_layer(zeltner_sheen(g, v[FUZZ_WEIGHT][0], v[FUZZ_COLOR], v[FUZZ_ROUGHNESS][0]), result);
    return result;
}

CLOSURE_MODEL(open_pbr, "open-pbr", open_pbr);
