/* SPDX-License-Identifier: MIT
 *
 * `rough-plastic` is Mitsuba 3's plugin `roughplastic`: a diffuse base under a rough dielectric interface,
 *
 *   f = specular F D G / (4 cos cos) + d / (pi eta^2) T(cos_i) T(cos_o),   d = diffuse / (1 - R), or diffuse / (1 - R diffuse)
 *
 * with Beckmann or GGX and separable shadowing; the second form of d, `nonlinear`, has the colour shift of light that is reflected
 * inside several times. T and R come from a table of Mitsuba's integrals (presets/rough_plastic.txt). As in Mitsuba, T is linear
 * between 64 cosines.
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"
#include "rough_plastic_table.h" /* generated from presets/rough_plastic.txt */

enum { NQM_ROUGH_PLASTIC_KEYS(NQM_KEY_INDEX) N_KEYS };

static const double table_scale[2] = {0.009950330853168083, 4.61512051684126};  /* of log(1 + 100 alpha) */
static const double table_log_eta[2] = {-2.99573227355399, 0.6931471805599453}; /* of log(eta - 1) */

typedef struct plastic {
    nqm_spec_state spec;
    bool is_ggx;
    double alpha2, eta;
    double diffuse[3], specular[3];
    double transmittance[TABLE_MU];
} plastic;

/* Weights of the values at n <= 32 Chebyshev nodes of [range[0], range[1]], of the polynomial through them at x: the barycentric
 * formula (Berrut and Trefethen 2004, DOI 10.1137/S0036144502417715). */
static void interpolation_weights(size_t n, const double range[2], double x, double *weights) {
    const double y = (2 * x - range[0] - range[1]) / (range[1] - range[0]);
    double sum = 0;
    for (size_t j = 0; j < n; ++j) {
        const double angle = NQM_PI * ((double)j + 0.5) / (double)n, distance = y - cos(angle);
        if (distance == 0) {
            for (size_t k = 0; k < n; ++k)
                weights[k] = k == j;
            return;
        }
        weights[j] = (j % 2 ? -1 : 1) * sin(angle) / distance;
        sum += weights[j];
    }
    for (size_t j = 0; j < n; ++j)
        weights[j] /= sum;
}

/* The transmittances, and the internal reflectance behind them: out (TABLE_MU + 1). */
static void find_transmittances(bool is_ggx, double alpha, double eta, double *out) {
    double by_alpha[TABLE_ALPHA], by_eta[TABLE_ETA], core[TABLE_RANK] = {0};
    interpolation_weights(TABLE_ALPHA, table_scale, log1p(100 * alpha), by_alpha);
    interpolation_weights(TABLE_ETA, table_log_eta, log(eta - 1), by_eta);
    const float *at = table_core[is_ggx];
    for (size_t a = 0; a < TABLE_ALPHA; ++a)
        for (size_t e = 0; e < TABLE_ETA; ++e)
            for (size_t r = 0; r < TABLE_RANK; ++r)
                core[r] += by_alpha[a] * by_eta[e] * (double)*at++;
    for (size_t i = 0; i <= TABLE_MU; ++i)
        out[i] = 0;
    for (size_t r = 0; r < TABLE_RANK; ++r)
        for (size_t i = 0; i <= TABLE_MU; ++i)
            out[i] += core[r] * (double)table_vectors[is_ggx][r * (TABLE_MU + 1) + i];
}

static void plastic_prepare(const nqm_values *values, void *state) {
    plastic *self = state;
    double table[TABLE_MU + 1];
    const double alpha = values->v[ALPHA][0];
    self->is_ggx = values->v[DISTRIBUTION][0] > 0.5;
    self->alpha2 = alpha * alpha;
    self->eta = values->v[ETA][0];
    find_transmittances(self->is_ggx, alpha, self->eta, table);
    memcpy(self->transmittance, table, sizeof self->transmittance);
    for (size_t c = 0; c < 3; ++c) {
        const double d = values->v[DIFFUSE_REFLECTANCE][c], r = MISTAKEN(INTERNAL_REFLECTION) ? 0 : table[TABLE_MU];
        const double eta = MISTAKEN(ETA_SQUARED) ? 1 : self->eta;
        self->diffuse[c] = d / (1 - (values->v[NONLINEAR][0] > 0.5 ? d * r : r)) / (DIFFUSE_PI * eta * eta);
        self->specular[c] = values->v[SPECULAR_REFLECTANCE][c];
    }
}

static void plastic_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const plastic *self = state;
    for (size_t i = 0; i < n; ++i) {
        const half_angles h = half_angles_of(wi + 3 * i, wo + 3 * i);
        const double cos_i = wi[3 * i + 2], cos_o = wo[3 * i + 2];
        const pair_widths a = equal_widths(self->alpha2);
        const double lobe =
            self->is_ggx ? separable_ggx(h.tan2_h, cos_i, cos_o, a) : separable_beckmann(h.tan2_h, cos_i, cos_o, a);
        const double f = lobe * fresnel_dielectric(self->eta, h.cos_d);
        const double inside = MISTAKEN(DIFFUSE_NOT_REDUCED) ? 1
                                                            : look_up(self->transmittance, TABLE_MU, cos_i) *
                                                                  look_up(self->transmittance, TABLE_MU, cos_o);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = f * self->specular[c] + self->diffuse[c] * inside;
    }
}

NQM_SHADING_MODEL(rough_plastic, "rough-plastic", plastic, plastic_prepare, plastic_eval, 1);
