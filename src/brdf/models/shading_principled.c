/* SPDX-License-Identifier: MIT
 *
 * `principled` is Mitsuba 3's plugin of this name without transmission, after Burley, "Physically Based Shading at Disney" (2012)
 * and "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering" (2015). doc/materials.md has where it differs.
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

enum { NQM_PRINCIPLED_KEYS(NQM_KEY_INDEX) N_KEYS };

typedef struct principled {
    nqm_spec_state spec;
    widths widths;
    double coat_alpha2;
    double dielectric; /* weight of the exact Fresnel factor */
    double tint[3],
        tint_weight; /* reflectance at normal incidence of the tinted Schlick factor; the metal's is the base colour */
    double diffuse[3], sheen[3];
} principled;

static void principled_prepare(const nqm_values *values, void *state) {
    principled *self = state;
    const double *base = values->v[BASE_COLOR];
    const double metallic = values->v[METALLIC][0], spec_tint = values->v[SPEC_TINT][0];
    const double luminance = 0.212671 * base[0] + 0.715160 * base[1] + 0.072169 * base[2];
    const double roughness2 = values->v[ROUGHNESS][0] * values->v[ROUGHNESS][0];
    const double aspect = sqrt(1 - 0.9 * values->v[ANISOTROPIC][0]);
    const double x = fmax(0.001, roughness2 / aspect), y = fmax(0.001, roughness2 * aspect);
    const double coat_alpha = mix(0.1, 0.001, values->v[CLEARCOAT_GLOSS][0]);
    self->widths = (widths){x * x, y * y};
    self->coat_alpha2 = coat_alpha * coat_alpha;
    self->dielectric = (1 - metallic) * (1 - spec_tint);
    self->tint_weight = (1 - metallic) * spec_tint;
    const double r0 = (values->v[ETA][0] - 1) / (values->v[ETA][0] + 1);
    for (size_t c = 0; c < 3; ++c) {
        const double tint = luminance > 0 ? base[c] / luminance : 1;
        self->tint[c] = tint * r0 * r0;
        self->diffuse[c] = (MISTAKEN(DIFFUSE_OF_METAL) ? 1 : 1 - metallic) * base[c] / DIFFUSE_PI;
        self->sheen[c] = (1 - metallic) * values->v[SHEEN][0] * mix(1, tint, values->v[SHEEN_TINT][0]);
    }
}

/* The diffuse and retro-reflective lobes, and the one that imitates subsurface scattering; times pi / base colour. */
static double diffuse_shape(const double (*v)[3], double cos_i, double cos_o, double cos_d) {
    const double fi = power5(1 - cos_i), fo = power5(1 - cos_o), rr = 2 * v[ROUGHNESS][0] * cos_d * cos_d;
    const double diffuse = (1 - 0.5 * fi) * (1 - 0.5 * fo), retro = rr * (fo + fi + fo * fi * (rr - 1));
    if (MISTAKEN(DIFFUSE_LAMBERT))
        return 1;
    const double ss = mix(1, 0.5 * rr, fo) * mix(1, 0.5 * rr, fi);
    const double flat = 1.25 * (ss * (1 / (cos_o + cos_i) - 0.5) + 0.5);
    return mix(diffuse + retro, flat, v[FLATNESS][0]);
}

static double coat(const principled *self, double tan2_h, double cos_i, double cos_o, double cos_d) {
    const double a2 = self->coat_alpha2, roughness2 = 0.25 * 0.25;
    const double d = (a2 - 1) / (NQM_PI * log(a2) * (1 + (a2 - 1) / (1 + tan2_h)));
    const double g = 4 * cos_i * cos_o * ggx_visibility(cos_i, roughness2) * ggx_visibility(cos_o, roughness2);
    const double eta = self->spec.values.v[ETA][0], r = (eta - 1) / (eta + 1);
    const double f0 = MISTAKEN(COAT_F0_OF_INDEX) ? r * r : 0.04;
    return 0.25 * self->spec.values.v[CLEARCOAT][0] * schlick_factor(f0, cos_d) * d * g;
}

static void principled_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const principled *self = state;
    const double(*v)[3] = self->spec.values.v, eta = v[ETA][0];
    for (size_t i = 0; i < n; ++i) {
        const half_angles h = half_angles_of(wi + 3 * i, wo + 3 * i);
        const double cos_i = wi[3 * i + 2], cos_o = wo[3 * i + 2], weight = power5(1 - h.cos_d);
        const pair_widths a = pair_widths_of(self->widths, wi + 3 * i, wo + 3 * i);
        const double lobe = eta == 1 ? 0 : separable_ggx(h.tan2_h, cos_i, cos_o, a);
        const double f = self->dielectric * fresnel_dielectric(eta, h.cos_d);
        const double shape = diffuse_shape(v, cos_i, cos_o, h.cos_d);
        const double clear = v[CLEARCOAT][0] > 0 ? coat(self, h.tan2_h, cos_i, cos_o, h.cos_d) : 0;
        for (size_t c = 0; c < 3; ++c) {
            const double fresnel = f + v[METALLIC][0] * mix(v[BASE_COLOR][c], 1, weight) +
                                   self->tint_weight * mix(self->tint[c], 1, weight);
            rgb[3 * i + c] = lobe * fresnel + clear + self->diffuse[c] * shape + self->sheen[c] * weight;
        }
    }
}

NQM_SHADING_MODEL(principled, "principled", principled, principled_prepare, principled_eval, 1);
