/* SPDX-License-Identifier: MIT
 *
 * Autodesk Standard Surface 1.0.1 as MaterialX 1.39 defines it (standard_surface.mtlx, the node graph), opaque
 * reflection only: coat over a mixture of metal and of a dielectric over sheen over a diffuse base.
 */
#include "brdf/models/closures.h"

enum { NQM_STANDARD_SURFACE_KEYS(NQM_KEY_INDEX) N_KEYS };

/* What the keys make together; the others are read from the spec. */
typedef struct standard_surface {
    nqm_spec_state spec;
    lobe_shape base, coat;
    double diffuse[3], metal_ior[3], metal_extinction[3], under_coat[3];
} standard_surface;

/* The node rotate3d multiplies a row vector by the matrix: one turn is -360 degrees. */
static const double TURN = -2 * NQM_PI;

static void prepare(const nqm_values *values, void *state) {
    double v[N_KEYS];
    for (size_t k = 0; k < N_KEYS; ++k)
        v[k] = values->v[k][0];
    standard_surface *self = state;
    self->coat = roughness_anisotropy(v[COAT_ROUGHNESS], v[COAT_ANISOTROPY], TURN * v[COAT_ROTATION]);
    const double affected = v[COAT_AFFECT_ROUGHNESS] * v[COAT] * v[COAT_ROUGHNESS];
    self->base = roughness_anisotropy(v[SPECULAR_ROUGHNESS] + affected * (1 - v[SPECULAR_ROUGHNESS]),
                                      v[SPECULAR_ANISOTROPY], TURN * v[SPECULAR_ROTATION]);
    for (size_t c = 0; c < 3; ++c) {
        const double base = values->v[BASE_COLOR][c];
        self->diffuse[c] = pow(base, 1 + v[COAT] * v[COAT_AFFECT_COLOR]);
        self->under_coat[c] = clamp01(1 + v[COAT] * (values->v[COAT_COLOR][c] - 1));
        artistic_ior(base * v[BASE], values->v[SPECULAR_COLOR][c] * v[SPECULAR], &self->metal_ior[c],
                     &self->metal_extinction[c]);
    }
}

static closure evaluate(const void *state, const geometry *g) {
    const standard_surface *self = state;
    const double(*v)[3] = self->spec.values.v;
    const microfacet m = microfacet_of(g, &self->base);
    const thin_film film = {v[THIN_FILM_THICKNESS][0], v[THIN_FILM_IOR][0]};
    closure result = oren_nayar_bsdf(g, v[BASE][0], self->diffuse, v[DIFFUSE_ROUGHNESS][0]);
    if (v[SHEEN][0] > 0)
        result = closure_layer(conty_kulla_sheen(g, v[SHEEN][0], v[SHEEN_COLOR], v[SHEEN_ROUGHNESS][0]), result);
    if (v[SPECULAR][0] > 0)
        result =
            specular_layer(dielectric_bsdf(g, m, v[SPECULAR][0], v[SPECULAR_COLOR], v[SPECULAR_IOR][0], &film), result);
    if (v[METALNESS][0] > 0)
        result =
            closure_mix(conductor_bsdf(g, m, self->metal_ior, self->metal_extinction, &film), result, v[METALNESS][0]);
    if (v[COAT][0] > 0) {
        for (size_t c = 0; c < 3; ++c)
            result.f[c] *= self->under_coat[c];
        const microfacet coat = microfacet_of(g, &self->coat);
        result = coat_layer(dielectric_bsdf(g, coat, v[COAT][0], WHITE,
                                            v[MISTAKEN(COAT_F0_OF_INDEX) ? SPECULAR_IOR : COAT_IOR][0], NULL),
                            result);
    }
    return result;
}

CLOSURE_MODEL(standard_surface, "standard-surface", standard_surface);
