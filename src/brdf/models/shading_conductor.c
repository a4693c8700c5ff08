/* SPDX-License-Identifier: MIT
 *
 * Rough conductors of two renderers, D G F / (4 cos cos) with the exact Fresnel factor of eta + i k per channel: `rough-conductor` is
 * Mitsuba 3's `roughconductor`, `pbrt-conductor` is pbrt-v4's `conductor` (doc/materials.md).
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

typedef struct conductor {
    nqm_spec_state spec;
    bool is_ggx, is_correlated;
    widths widths;
    double eta[3], k[3], specular[3];
} conductor;

/* D G / (4 cos cos). */
static double lobe(const conductor *self, const half_angles *h, const double *wi, const double *wo) {
    const pair_widths a = pair_widths_of(self->widths, wi, wo);
    if (self->is_correlated)
        return correlated_ggx(h->tan2_h, wi[2], wo[2], a);
    return self->is_ggx ? separable_ggx(h->tan2_h, wi[2], wo[2], a) : separable_beckmann(h->tan2_h, wi[2], wo[2], a);
}

static void conductor_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const conductor *self = state;
    for (size_t i = 0; i < n; ++i) {
        const half_angles h = half_angles_of(wi + 3 * i, wo + 3 * i);
        const double f = lobe(self, &h, wi + 3 * i, wo + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = f * self->specular[c] * fresnel_conductor(self->eta[c], self->k[c], h.cos_d);
    }
}

static void set_index(conductor *self, const double *eta, const double *k, const double *specular) {
    for (size_t c = 0; c < 3; ++c) {
        self->eta[c] = eta[c];
        self->k[c] = k[c];
        self->specular[c] = specular ? specular[c] : 1;
    }
}

/* ---- Mitsuba 3 --------------------------------------------------------------------------------------------------- */

enum { NQM_ROUGH_CONDUCTOR_KEYS(NQM_KEY_INDEX) };

static void mitsuba_prepare(const nqm_values *values, void *state) {
    conductor *self = state;
    self->is_ggx = values->v[DISTRIBUTION][0] > 0.5;
    self->is_correlated = false;
    const double *alpha = values->v[ALPHA];
    self->widths = (widths){alpha[0] * alpha[0], alpha[1] * alpha[1]};
    set_index(self, values->v[ETA], values->v[K], values->v[SPECULAR_REFLECTANCE]);
}

NQM_SHADING_MODEL(rough_conductor, "rough-conductor", conductor, mitsuba_prepare, conductor_eval, 1);

/* ---- pbrt-v4 ----------------------------------------------------------------------------------------------------- */

/* Below a roughness of 1e-6, alpha is less than 0.001 and pbrt reflects as a perfect mirror (in both directions; in one, pbrt has
 * lobes down to an alpha of 1e-4, which are refused). The defaults are copper's, as in pbrt, of which a key can have one value
 * only: they are required. */
enum { NQM_PBRT_CONDUCTOR_KEYS(NQM_KEY_INDEX) };

static void pbrt_prepare(const nqm_values *values, void *state) {
    conductor *self = state;
    self->is_ggx = self->is_correlated = true;
    self->widths = (widths){values->v[PBRT_ROUGHNESS][0], values->v[PBRT_ROUGHNESS][1]};
    set_index(self, values->v[PBRT_ETA], values->v[PBRT_K], NULL);
}

NQM_SHADING_MODEL(pbrt_conductor, "pbrt-conductor", conductor, pbrt_prepare, conductor_eval, 1);
