/* SPDX-License-Identifier: MIT
 *
 * OpenPBR Surface 1.1.1 as MaterialX 1.39 defines it (open_pbr_surface.mtlx, the node graph), opaque reflection only: fuzz over coat over
 * a mixture of metal and of a dielectric with a diffuse base. The keys are the inputs of the node. Colours above 1 are those
 * that a conversion to BT.709 can give.
 */
#include "brdf/models/closures.h"

enum {
    BASE_WEIGHT,
    BASE_COLOR,
    BASE_DIFFUSE_ROUGHNESS,
    BASE_METALNESS,
    SPECULAR_WEIGHT,
    SPECULAR_COLOR,
    SPECULAR_ROUGHNESS,
    SPECULAR_IOR,
    FUZZ_WEIGHT,
    FUZZ_COLOR,
    FUZZ_ROUGHNESS,
    COAT_WEIGHT,
    COAT_COLOR,
    COAT_ROUGHNESS,
    COAT_IOR,
    COAT_DARKENING,
    N_KEYS
};

typedef struct open_pbr {
    nqm_spec_state spec;
    double base_weight, base_color[3], diffuse_roughness, metalness;
    double specular_weight, specular_color[3], alpha, ior;
    double metal[3];
    double fuzz_weight, fuzz_color[3], fuzz_roughness;
    double coat_weight, coat_alpha, coat_ior, under_coat[3]; /* under_coat: darkening and colour */
} open_pbr;

static const double WHITE[3] = {1, 1, 1};

/* The index of the dielectric below the coat, modulated by specular_weight. */
static double modulated_ior(double weight, double ior, double coat_weight, double coat_ior) {
    const double ratio = ior / coat_ior;
    const double covered = ratio > 1 ? ratio : fmin(coat_ior / ior, 1e6);
    const double eta = coat_weight > 0 ? coat_weight * covered + (1 - coat_weight) * ior : ior;
    const double root = sqrt(fmin(weight * f0_of_ior(eta), 0.99999)), e = eta > 1 ? root : eta < 1 ? -root : 0;
    return (1 + e) / (1 - e);
}

/* What the coat lets through, beside its reflection: absorption, and darkening by inter-reflections below it. v: the keys
 * that are single numbers. */
static double under_coat(const double *v, double base, double coat_color) {
    const double coat = v[COAT_WEIGHT], ior = v[COAT_IOR];
    const double k = 1 - (1 - f0_of_ior(ior)) / (ior * ior);
    const double albedo = base * (1 + v[BASE_METALNESS] * (v[SPECULAR_WEIGHT] - 1));
    const double darkening = 1 + coat * v[COAT_DARKENING] * ((1 - k) / (1 - albedo * k) - 1);
    return clamp01(darkening) * clamp01(1 + coat * (coat_color - 1));
}

static void prepare(const nqm_spec_values *values, void *state) {
    double v[N_KEYS];
    for (size_t k = 0; k < N_KEYS; ++k)
        v[k] = values->v[k][0];
    open_pbr *self = state;
    self->base_weight = v[BASE_WEIGHT];
    self->diffuse_roughness = v[BASE_DIFFUSE_ROUGHNESS];
    self->metalness = v[BASE_METALNESS];
    self->specular_weight = v[SPECULAR_WEIGHT];
    self->fuzz_weight = v[FUZZ_WEIGHT];
    self->fuzz_roughness = v[FUZZ_ROUGHNESS];
    self->coat_weight = v[COAT_WEIGHT];
    self->coat_alpha = alpha_of(v[COAT_ROUGHNESS]);
    self->coat_ior = v[COAT_IOR];
    self->ior = modulated_ior(v[SPECULAR_WEIGHT], v[SPECULAR_IOR], v[COAT_WEIGHT], v[COAT_IOR]);
    const double rough4 = v[SPECULAR_ROUGHNESS] * v[SPECULAR_ROUGHNESS] * v[SPECULAR_ROUGHNESS] * v[SPECULAR_ROUGHNESS];
    const double coat4 = v[COAT_ROUGHNESS] * v[COAT_ROUGHNESS] * v[COAT_ROUGHNESS] * v[COAT_ROUGHNESS];
    const double widened = sqrt(sqrt(fmin(1, rough4 + 2 * coat4)));
    self->alpha = alpha_of(v[SPECULAR_ROUGHNESS] + v[COAT_WEIGHT] * (widened - v[SPECULAR_ROUGHNESS]));
    for (size_t c = 0; c < 3; ++c) {
        const double base = values->v[BASE_COLOR][c];
        self->base_color[c] = base;
        self->metal[c] = base * v[BASE_WEIGHT];
        self->specular_color[c] = values->v[SPECULAR_COLOR][c];
        self->fuzz_color[c] = values->v[FUZZ_COLOR][c];
        self->under_coat[c] = under_coat(v, base, values->v[COAT_COLOR][c]);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const open_pbr *self = state;
    const microfacet m = microfacet_of(g, self->alpha);
    closure result = eon_bsdf(g, self->base_weight, self->base_color, self->diffuse_roughness);
    if (self->metalness < 1)
        result = closure_layer(dielectric_bsdf(g, m, 1, self->specular_color, self->ior), result);
    if (self->metalness > 0)
        result = closure_mix(schlick_bsdf(g, m, self->specular_weight, self->metal, self->specular_color), result,
                             self->metalness);
    if (self->coat_weight > 0) {
        for (size_t c = 0; c < 3; ++c)
            result.f[c] *= self->under_coat[c];
        const microfacet coat = microfacet_of(g, self->coat_alpha);
        result = closure_layer(dielectric_bsdf(g, coat, self->coat_weight, WHITE, self->coat_ior), result);
    }
    if (self->fuzz_weight > 0)
        result = closure_layer(zeltner_sheen(g, self->fuzz_weight, self->fuzz_color, self->fuzz_roughness), result);
    return result;
}

static void eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    closure_eval(evaluate, state, n, wi, wo, rgb);
}

const nqm_analytic_model nqm_open_pbr_model = {
    .schema = {"open-pbr",
               N_KEYS,
               {[BASE_WEIGHT] = {.name = "base_weight", .n = 1, .low = 0, .high = 1, .fallback = 1},
                [BASE_COLOR] = {.name = "base_color", .n = 3, .low = 0, .high = 2, .fallback = 0.8},
                [BASE_DIFFUSE_ROUGHNESS] = {.name = "base_diffuse_roughness", .n = 1, .low = 0, .high = 1},
                [BASE_METALNESS] = {.name = "base_metalness", .n = 1, .low = 0, .high = 1},
                [SPECULAR_WEIGHT] = {.name = "specular_weight", .n = 1, .low = 0, .high = 10, .fallback = 1},
                [SPECULAR_COLOR] = {.name = "specular_color", .n = 3, .low = 0, .high = 2, .fallback = 1},
                [SPECULAR_ROUGHNESS] = {.name = "specular_roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.3},
                [SPECULAR_IOR] = {.name = "specular_ior", .n = 1, .low = 0, .high = 100, .fallback = 1.5},
                [FUZZ_WEIGHT] = {.name = "fuzz_weight", .n = 1, .low = 0, .high = 1},
                [FUZZ_COLOR] = {.name = "fuzz_color", .n = 3, .low = 0, .high = 2, .fallback = 1},
                [FUZZ_ROUGHNESS] = {.name = "fuzz_roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.5},
                [COAT_WEIGHT] = {.name = "coat_weight", .n = 1, .low = 0, .high = 1},
                [COAT_COLOR] = {.name = "coat_color", .n = 3, .low = 0, .high = 2, .fallback = 1},
                [COAT_ROUGHNESS] = {.name = "coat_roughness", .n = 1, .low = 0, .high = 1},
                [COAT_IOR] = {.name = "coat_ior", .n = 1, .low = 0.01, .high = 100, .fallback = 1.6},
                [COAT_DARKENING] = {.name = "coat_darkening", .n = 1, .low = 0, .high = 1, .fallback = 1}}},
    .class_ = {.format = "open-pbr", .reciprocal = 0, .eval = eval, .jacobian = nqm_spec_jacobian, .free = nqm_free},
    .state_size = sizeof(open_pbr),
    .prepare = prepare,
};
