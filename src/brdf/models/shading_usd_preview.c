/* SPDX-License-Identifier: MIT
 *
 * UsdPreviewSurface 2.6 of OpenUSD as MaterialX 1.39 defines it (usd_preview_surface.mtlx, the node graph), opaque reflection only: clear
 * coat over a mixture of metal and of a dielectric with a diffuse base, or over a specular colour with a diffuse base. The keys are
 * the inputs of the node.
 *
 * OpenUSD's specification gives the colours of the Fresnel factor and leaves the layers to renderers: its own Storm multiplies the diffuse
 * colour by 1 - F, adds the coat, and has no compensation for multiple scattering.
 */
#include "brdf/models/closures.h"

enum {
    DIFFUSE_COLOR,
    USE_SPECULAR_WORKFLOW,
    SPECULAR_COLOR,
    METALLIC,
    ROUGHNESS,
    CLEARCOAT,
    CLEARCOAT_ROUGHNESS,
    IOR,
    N_KEYS
};

typedef struct usd_preview {
    nqm_spec_state spec;
    double diffuse_weight, diffuse[3];
    double metallic, alpha;
    double f0[3], f90[3], metal_ior[3], metal_extinction[3];
    double coat, coat_alpha, coat_f0[3];
} usd_preview;

static const double WHITE[3] = {1, 1, 1};

static void prepare(const nqm_spec_values *values, void *state) {
    usd_preview *self = state;
    const bool is_specular = values->v[USE_SPECULAR_WORKFLOW][0] > 0.5;
    const double metallic = is_specular ? 0 : values->v[METALLIC][0], f0 = f0_of_ior(values->v[IOR][0]);
    self->metallic = metallic;
    self->diffuse_weight = 1 - metallic;
    self->alpha = alpha_of(values->v[ROUGHNESS][0]);
    self->coat = values->v[CLEARCOAT][0];
    self->coat_alpha = alpha_of(values->v[CLEARCOAT_ROUGHNESS][0]);
    for (size_t c = 0; c < 3; ++c) {
        const double diffuse = values->v[DIFFUSE_COLOR][c], tint = 1 + metallic * (diffuse - 1);
        self->diffuse[c] = diffuse;
        self->f0[c] = is_specular ? values->v[SPECULAR_COLOR][c] : tint * (f0 + metallic * (1 - f0));
        self->f90[c] = tint;
        self->coat_f0[c] = f0;
        artistic_ior(diffuse, diffuse, &self->metal_ior[c], &self->metal_extinction[c]);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const usd_preview *self = state;
    const microfacet m = microfacet_of(g, self->alpha);
    closure result = oren_nayar_bsdf(g, self->diffuse_weight, self->diffuse, 0);
    result = closure_layer(generalized_schlick_bsdf(g, m, 1, self->f0, WHITE, self->f90), result);
    if (self->metallic > 0)
        result = closure_mix(conductor_bsdf(g, m, self->metal_ior, self->metal_extinction), result, self->metallic);
    if (self->coat > 0) {
        const microfacet coat = microfacet_of(g, self->coat_alpha);
        result = closure_layer(schlick_bsdf(g, coat, self->coat, self->coat_f0, WHITE), result);
    }
    return result;
}

static void eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    closure_eval(evaluate, state, n, wi, wo, rgb);
}

const nqm_analytic_model nqm_usd_preview_model = {
    .schema = {"usd-preview",
               N_KEYS,
               {[DIFFUSE_COLOR] = {.name = "diffuseColor", .n = 3, .low = 0, .high = 1, .fallback = 0.18},
                [USE_SPECULAR_WORKFLOW] =
                    {.name = "useSpecularWorkflow", .n = 1, .low = 0, .high = 1, .whole = true, .fallback = 0},
                [SPECULAR_COLOR] = {.name = "specularColor", .n = 3, .low = 0, .high = 1},
                [METALLIC] = {.name = "metallic", .n = 1, .low = 0, .high = 1},
                [ROUGHNESS] = {.name = "roughness", .n = 1, .low = 0, .high = 1, .fallback = 0.5},
                [CLEARCOAT] = {.name = "clearcoat", .n = 1, .low = 0, .high = 1},
                [CLEARCOAT_ROUGHNESS] = {.name = "clearcoatRoughness", .n = 1, .low = 0, .high = 1, .fallback = 0.01},
                [IOR] = {.name = "ior", .n = 1, .low = 0, .high = 100, .fallback = 1.5}}},
    .class_ = {.format = "usd-preview", .reciprocal = 0, .eval = eval, .jacobian = nqm_spec_jacobian, .free = nqm_free},
    .state_size = sizeof(usd_preview),
    .prepare = prepare,
};
