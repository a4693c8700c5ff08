/* SPDX-License-Identifier: MIT
 *
 * The Disney Principled surface as MaterialX 1.39 defines it (disney_principled.mtlx, the node graph), opaque reflection only:
 * clear coat over a mixture of metal and of a dielectric over sheen over Burley's diffuse.
 *
 * The graph gives the dielectric and the clear coat the constant reflectance 0.08 specular and 0.04 clearcoat (a Schlick factor
 * whose ends are both white), and weights the diffuse twice by 1 - metallic; so does this file.
 */
#include "brdf/models/closures.h"

enum { NQM_DISNEY_KEYS(NQM_KEY_INDEX) N_KEYS };

/* What the keys make together; the others are read from the spec. */
typedef struct disney {
    nqm_spec_state spec;
    lobe_shape base, coat;
    double specular_color[3], sheen_color[3];
} disney;

static const double SHEEN_ROUGHNESS = 0.3; /* the default of the node sheen_bsdf */

static void prepare(const nqm_values *values, void *state) {
    disney *self = state;
    self->base = roughness_anisotropy(values->v[ROUGHNESS][0], values->v[ANISOTROPIC][0], 0);
    self->coat = round_lobe(1 - values->v[CLEARCOAT_GLOSS][0]);
    for (size_t c = 0; c < 3; ++c) {
        const double base = values->v[BASE_COLOR][c];
        self->specular_color[c] = 1 + values->v[SPECULAR_TINT][0] * (base - 1);
        self->sheen_color[c] = 1 + values->v[SHEEN_TINT][0] * (base - 1);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const disney *self = state;
    const double(*v)[3] = self->spec.values.v, metallic = v[METALLIC][0], sheen = v[SHEEN][0],
          coat = (MISTAKEN(COAT_F0_OF_BASE) ? 0.08 * v[SPECULAR][0] : 0.04) * v[CLEARCOAT][0];
    const microfacet m = microfacet_of(g, &self->base);
    closure result = burley_bsdf(g, 1 - metallic, v[BASE_COLOR], v[ROUGHNESS][0]);
    if (sheen > 0)
        result = closure_layer(conty_kulla_sheen(g, sheen, self->sheen_color, SHEEN_ROUGHNESS), result);
    result = specular_layer(schlick_bsdf(g, m, 0.08 * v[SPECULAR][0], self->specular_color, WHITE), result);
    result = closure_mix(schlick_bsdf(g, m, 1, v[BASE_COLOR], WHITE), result, metallic);
    if (coat > 0)
        result = coat_layer(schlick_bsdf(g, microfacet_of(g, &self->coat), coat, WHITE, WHITE), result);
    return result;
}

CLOSURE_MODEL(disney, "disney", disney);
