/* SPDX-License-Identifier: MIT
 *
 * Autodesk Standard Surface 1.0.1 as MaterialX 1.39 defines it (standard_surface.mtlx, the node graph), opaque reflection only: coat over a
 * mixture of metal and of a dielectric over sheen over a diffuse base. The keys are the inputs of the node.
 */
#include "brdf/models/closures.h"

enum {
    BASE,
    BASE_COLOR,
    DIFFUSE_ROUGHNESS,
    METALNESS,
    SPECULAR,
    SPECULAR_COLOR,
    SPECULAR_ROUGHNESS,
    SPECULAR_IOR,
    SHEEN,
    SHEEN_COLOR,
    SHEEN_ROUGHNESS,
    COAT,
    COAT_COLOR,
    COAT_ROUGHNESS,
    COAT_IOR,
    COAT_AFFECT_COLOR,
    COAT_AFFECT_ROUGHNESS,
    N_KEYS
};

typedef struct standard_surface {
    nqm_spec_state spec;
    double base, diffuse[3], diffuse_roughness, metalness;
    double specular, specular_color[3], alpha, ior;
    double metal_ior[3], metal_extinction[3];
    double sheen, sheen_color[3], sheen_roughness;
    double coat, coat_alpha, coat_ior, under_coat[3];
} standard_surface;

static const double WHITE[3] = {1, 1, 1};

static void prepare(const nqm_spec_values *values, void *state) {
    double v[N_KEYS];
    for (size_t k = 0; k < N_KEYS; ++k)
        v[k] = values->v[k][0];
    standard_surface *self = state;
    self->base = v[BASE];
    self->diffuse_roughness = v[DIFFUSE_ROUGHNESS];
    self->metalness = v[METALNESS];
    self->specular = v[SPECULAR];
    self->ior = v[SPECULAR_IOR];
    self->sheen = v[SHEEN];
    self->sheen_roughness = v[SHEEN_ROUGHNESS];
    self->coat = v[COAT];
    self->coat_alpha = alpha_of(v[COAT_ROUGHNESS]);
    self->coat_ior = v[COAT_IOR];
    const double affected = v[COAT_AFFECT_ROUGHNESS] * v[COAT] * v[COAT_ROUGHNESS];
    self->alpha = alpha_of(v[SPECULAR_ROUGHNESS] + affected * (1 - v[SPECULAR_ROUGHNESS]));
    for (size_t c = 0; c < 3; ++c) {
        const double base = values->v[BASE_COLOR][c];
        self->diffuse[c] = pow(base, 1 + v[COAT] * v[COAT_AFFECT_COLOR]);
        self->specular_color[c] = values->v[SPECULAR_COLOR][c];
        self->sheen_color[c] = values->v[SHEEN_COLOR][c];
        self->under_coat[c] = clamp01(1 + v[COAT] * (values->v[COAT_COLOR][c] - 1));
        artistic_ior(base * v[BASE], self->specular_color[c] * v[SPECULAR], &self->metal_ior[c],
                     &self->metal_extinction[c]);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const standard_surface *self = state;
    const microfacet m = microfacet_of(g, self->alpha);
    closure result = oren_nayar_bsdf(g, self->base, self->diffuse, self->diffuse_roughness);
    if (self->sheen > 0)
        result = closure_layer(conty_kulla_sheen(g, self->sheen, self->sheen_color, self->sheen_roughness), result);
    if (self->specular > 0)
        result = closure_layer(dielectric_bsdf(g, m, self->specular, self->specular_color, self->ior), result);
    if (self->metalness > 0)
        result = closure_mix(conductor_bsdf(g, m, self->metal_ior, self->metal_extinction), result, self->metalness);
    if (self->coat > 0) {
        for (size_t c = 0; c < 3; ++c)
            result.f[c] *= self->under_coat[c];
        const microfacet coat = microfacet_of(g, self->coat_alpha);
        result = closure_layer(dielectric_bsdf(g, coat, self->coat, WHITE, self->coat_ior), result);
    }
    return result;
}

static void eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    closure_eval(evaluate, state, n, wi, wo, rgb);
}

const nqm_analytic_model nqm_standard_surface_model = {
    .schema = {"standard-surface",
               N_KEYS,
               {[BASE] = {.name = "base", .n = 1, .low = 0, .high = 1, .fallback = 1},
                [BASE_COLOR] = {.name = "base_color", .n = 3, .low = 0, .high = 2, .fallback = 0.8},
                [DIFFUSE_ROUGHNESS] = {.name = "diffuse_roughness", .n = 1, .low = 0, .high = 1},
                [METALNESS] = {.name = "metalness", .n = 1, .low = 0, .high = 1},
                [SPECULAR] = {.name = "specular", .n = 1, .low = 0, .high = 1, .fallback = 1},
                [SPECULAR_COLOR] = {.name = "specular_color", .n = 3, .low = 0, .high = 2, .fallback = 1},
                [SPECULAR_ROUGHNESS] = {.name = "specular_roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.2},
                [SPECULAR_IOR] = {.name = "specular_IOR", .n = 1, .low = 0, .high = 100, .fallback = 1.5},
                [SHEEN] = {.name = "sheen", .n = 1, .low = 0, .high = 1},
                [SHEEN_COLOR] = {.name = "sheen_color", .n = 3, .low = 0, .high = 2, .fallback = 1},
                [SHEEN_ROUGHNESS] = {.name = "sheen_roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.3},
                [COAT] = {.name = "coat", .n = 1, .low = 0, .high = 1},
                [COAT_COLOR] = {.name = "coat_color", .n = 3, .low = 0, .high = 2, .fallback = 1},
                [COAT_ROUGHNESS] = {.name = "coat_roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.1},
                [COAT_IOR] = {.name = "coat_IOR", .n = 1, .low = 0, .high = 100, .fallback = 1.5},
                [COAT_AFFECT_COLOR] = {.name = "coat_affect_color", .n = 1, .low = 0, .high = 1},
                [COAT_AFFECT_ROUGHNESS] = {.name = "coat_affect_roughness", .n = 1, .low = 0, .high = 1}}},
    .class_ =
        {.format = "standard-surface", .reciprocal = 0, .eval = eval, .jacobian = nqm_spec_jacobian, .free = nqm_free},
    .state_size = sizeof(standard_surface),
    .prepare = prepare,
};
