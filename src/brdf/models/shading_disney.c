/* SPDX-License-Identifier: MIT
 *
 * The Disney Principled surface as MaterialX 1.39 defines it (disney_principled.mtlx, the node graph), opaque reflection only: clear coat over
 * a mixture of metal and of a dielectric over sheen over Burley's diffuse. The keys are the inputs of the node.
 *
 * The graph gives the dielectric and the clear coat the constant reflectance 0.08 specular and 0.04 clearcoat (a Schlick factor
 * whose ends are both white), and weights the diffuse twice by 1 - metallic; so does this file.
 */
#include "brdf/models/closures.h"

enum {
    BASE_COLOR,
    METALLIC,
    ROUGHNESS,
    SPECULAR,
    SPECULAR_TINT,
    SHEEN,
    SHEEN_TINT,
    CLEARCOAT,
    CLEARCOAT_GLOSS,
    N_KEYS
};

typedef struct disney {
    nqm_spec_state spec;
    double base[3], metallic, roughness, alpha;
    double specular, specular_color[3];
    double sheen, sheen_color[3];
    double coat, coat_alpha;
} disney;

static const double WHITE[3] = {1, 1, 1}, SHEEN_ROUGHNESS = 0.3; /* the default of the node sheen_bsdf */

static void prepare(const nqm_spec_values *values, void *state) {
    disney *self = state;
    self->metallic = values->v[METALLIC][0];
    self->roughness = values->v[ROUGHNESS][0];
    self->alpha = alpha_of(self->roughness);
    self->specular = 0.08 * values->v[SPECULAR][0];
    self->sheen = values->v[SHEEN][0];
    self->coat = 0.04 * values->v[CLEARCOAT][0];
    self->coat_alpha = alpha_of(1 - values->v[CLEARCOAT_GLOSS][0]);
    for (size_t c = 0; c < 3; ++c) {
        const double base = values->v[BASE_COLOR][c];
        self->base[c] = base;
        self->specular_color[c] = 1 + values->v[SPECULAR_TINT][0] * (base - 1);
        self->sheen_color[c] = 1 + values->v[SHEEN_TINT][0] * (base - 1);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const disney *self = state;
    const microfacet m = microfacet_of(g, self->alpha);
    closure result = burley_bsdf(g, 1 - self->metallic, self->base, self->roughness);
    if (self->sheen > 0)
        result = closure_layer(conty_kulla_sheen(g, self->sheen, self->sheen_color, SHEEN_ROUGHNESS), result);
    result = closure_layer(schlick_bsdf(g, m, self->specular, self->specular_color, WHITE), result);
    result = closure_mix(schlick_bsdf(g, m, 1, self->base, WHITE), result, self->metallic);
    if (self->coat > 0)
        result = closure_layer(schlick_bsdf(g, microfacet_of(g, self->coat_alpha), self->coat, WHITE, WHITE), result);
    return result;
}

static void eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    closure_eval(evaluate, state, n, wi, wo, rgb);
}

const nqm_analytic_model nqm_disney_model = {
    .schema = {"disney",
               N_KEYS,
               {[BASE_COLOR] = {.name = "baseColor", .n = 3, .low = 0, .high = 2, .fallback = 0.16},
                [METALLIC] = {.name = "metallic", .n = 1, .low = 0, .high = 1},
                [ROUGHNESS] = {.name = "roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.5},
                [SPECULAR] = {.name = "specular", .n = 1, .low = 0, .high = 1, .fallback = 0.5},
                [SPECULAR_TINT] = {.name = "specularTint", .n = 1, .low = 0, .high = 1},
                [SHEEN] = {.name = "sheen", .n = 1, .low = 0, .high = 1},
                [SHEEN_TINT] = {.name = "sheenTint", .n = 1, .low = 0, .high = 1, .fallback = 0.5},
                [CLEARCOAT] = {.name = "clearcoat", .n = 1, .low = 0, .high = 1},
                [CLEARCOAT_GLOSS] = {.name = "clearcoatGloss", .n = 1, .low = 0, .high = 1, .fallback = 1}}},
    .class_ = {.format = "disney", .reciprocal = 0, .eval = eval, .jacobian = nqm_spec_jacobian, .free = nqm_free},
    .state_size = sizeof(disney),
    .prepare = prepare,
};
