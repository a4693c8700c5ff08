/* SPDX-License-Identifier: MIT
 *
 * UsdPreviewSurface 2.6 of OpenUSD as MaterialX 1.39 defines it (usd_preview_surface.mtlx, the node graph), opaque reflection only:
 * clear coat over a mixture of metal and of a dielectric with a diffuse base, or over a specular colour with a diffuse base.
 */
#include "brdf/models/closures.h"

enum { NQM_USD_PREVIEW_KEYS(NQM_KEY_INDEX) N_KEYS };

/* What the keys make together; the others are read from the spec. */
typedef struct usd_preview {
    nqm_spec_state spec;
    lobe_shape base, coat;
    double metallic, f0[3], f90[3], metal_ior[3], metal_extinction[3], coat_f0[3];
} usd_preview;

static void prepare(const nqm_values *values, void *state) {
    usd_preview *self = state;
    const bool is_specular = values->v[USE_SPECULAR_WORKFLOW][0] > 0.5;
    const double metallic = is_specular ? 0 : values->v[METALLIC][0], f0 = f0_between(values->v[IOR][0], 1);
    self->metallic = metallic;
    self->base = round_lobe(values->v[ROUGHNESS][0]);
    self->coat = round_lobe(values->v[CLEARCOAT_ROUGHNESS][0]);
    for (size_t c = 0; c < 3; ++c) {
        const double diffuse = values->v[DIFFUSE_COLOR][c], tint = 1 + metallic * (diffuse - 1);
        self->f0[c] = is_specular ? values->v[SPECULAR_COLOR][c] : tint * (f0 + metallic * (1 - f0));
        self->f90[c] = tint;
        self->coat_f0[c] = MISTAKEN(COAT_F0_FIXED) ? 0.04 : MISTAKEN(COAT_F0_OF_BASE) ? self->f0[c] : f0;
        artistic_ior(diffuse, diffuse, &self->metal_ior[c], &self->metal_extinction[c]);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const usd_preview *self = state;
    const double(*v)[3] = self->spec.values.v;
    const microfacet m = microfacet_of(g, &self->base);
    closure result = oren_nayar_bsdf(g, 1 - self->metallic, v[DIFFUSE_COLOR], 0);
    result = specular_layer(generalized_schlick_bsdf(g, m, 1, self->f0, WHITE, self->f90, NULL), result);
    if (self->metallic > 0)
        result =
            closure_mix(conductor_bsdf(g, m, self->metal_ior, self->metal_extinction, NULL), result, self->metallic);
    if (v[CLEARCOAT][0] > 0) {
        const microfacet coat = microfacet_of(g, &self->coat);
        result = coat_layer(schlick_bsdf(g, coat, v[CLEARCOAT][0], self->coat_f0, WHITE), result);
    }
    return result;
}

CLOSURE_MODEL(usd_preview, "usd-preview", usd_preview);
