/* SPDX-License-Identifier: MIT
 *
 * `blender-principled` is the Principled BSDF of Blender 4 (version 2 of the node) as its renderer Cycles evaluates it
 * at one point (intern/cycles/kernel/svm/closure.h, closure/bsdf_microfacet.h): sheen over coat over a mixture of metal
 * and of a dielectric over a diffuse base. A layer takes the albedo for the viewer from the weight of all below it.
 * Diffuse roughness is that of 4.3, the thin film that of 4.2, on dielectrics only, with the Gaussians of thin_film.h.
 *
 * Cycles keeps the energy of its lobes by tables, which presets/principled_energy.txt has as converged integrals. Its
 * table of the sheen of Zeltner et al. is presets/sheen_ltc.txt, measured from its pictures.
 */
#include "brdf/models/closures.h"
#include "principled_energy_table.h" /* generated from presets/principled_energy.txt */
#include "sheen_ltc_table.h"         /* generated from presets/sheen_ltc.txt */

enum { NQM_BLENDER_KEYS(NQM_KEY_INDEX) N_KEYS };

enum { N_E = 32, N_S = 16 };

/* A GGX lobe; its albedos at the cosine of the viewer. */
typedef struct ggx_lobe {
    turned_widths widths;
    double eta, e_mean, e[N_E], s[N_S];
} ggx_lobe;

typedef struct blender {
    nqm_spec_state spec;
    ggx_lobe base;
    turned_widths coat;
    double sheen[3][N_E];      /* albedo, a and -b at the cosine of the viewer */
    double f0, specular_f0[3]; /* of the dielectric, without and with tint */
} blender;

/* ---- tables ------------------------------------------------------------------------------------------------------- */

static void prepare_lobe(ggx_lobe *lobe, double x, double y, double turn_rad, double eta) {
    const double ax = fmin(fmax(x, MIN_ALPHA), 1), ay = fmin(fmax(y, MIN_ALPHA), 1);
    const double roughness = sqrt(sqrt(ax * ay));
    double t, u;
    size_t i = node_below(N_E, roughness, &t);
    const uint16_t *e = principled_energy + i * N_E, *mean = principled_energy + N_E * N_E + i,
                   *s = principled_energy + (N_E + 1) * N_E;
    *lobe = (ggx_lobe){.widths = turned_widths_of(ax * ax, ay * ay, turn_rad), .eta = eta};
    lobe->e_mean = 1e-4 * mix(mean[0], mean[1], t);
    for (size_t j = 0; j < N_E; ++j)
        lobe->e[j] = 1e-4 * mix(e[j], e[N_E + j], t);
    i = node_below(N_S, roughness, &t);
    const size_t z = node_below(N_S, sqrt(fabs((eta - 1) / (eta + 1))), &u);
    for (size_t j = 0; j < N_S; ++j) {
        const uint16_t *a = s + (z * N_S + i) * N_S + j, *b = a + N_S * N_S;
        lobe->s[j] = 1e-4 * mix(mix(a[0], a[N_S], t), mix(b[0], b[N_S], t), u);
    }
}

static void prepare_sheen(blender *self, double roughness) {
    double t;
    const size_t i = node_below(N_E, fmax(roughness, 1e-3), &t);
    for (size_t k = 0; k < 3; ++k)
        for (size_t j = 0; j < N_E; ++j) {
            const uint16_t *at = sheen_ltc + (k * N_E + i) * N_E + j;
            self->sheen[k][j] = mix(at[0], at[N_E], t) / 50000;
        }
}

/* ---- reflectances ------------------------------------------------------------------------------------------------- */

/* The mean reflectance of a dielectric over the hemisphere: fits of Kulla and Conty 2017. */
static double mean_fresnel(double eta) {
    return eta < 1 ? 0.997118 + eta * (0.1014 - eta * (0.965241 + eta * 0.130607))
                   : (eta - 1) / (4.08567 + 1.00071 * eta);
}

/* How far a reflectance is from that at normal incidence to 1. */
static double between(double eta, double reflectance) {
    const double f0 = f0_between(eta, 1);
    return f0 < 1 ? clamp01((reflectance - f0) / (1 - f0)) : 0;
}

/* The dielectric, with its film; the film's colours are scaled as far as they are near that at normal incidence. */
static void dielectric_factor(const blender *self, double cosine, double *f) {
    /* XYZ of equal energy to BT.709, whose white is that of the sum */
    static const film_rules rules = {3,
                                     0,
                                     1,
                                     {{3.2404542 * 0.95047, -1.5371385, -0.4985314 * 1.08883},
                                      {-0.9692660 * 0.95047, 1.8760108, 0.0415560 * 1.08883},
                                      {0.0556434 * 0.95047, -0.2040259, 1.0572252 * 1.08883}}};
    const double(*v)[3] = self->spec.values.v, eta = self->base.eta, f0 = f0_between(eta, 1);
    const double thickness = v[THIN_FILM_THICKNESS][0], thin = clamp01(thickness / 30);
    const thin_film film = {thickness, mix(1, v[THIN_FILM_IOR][0], thin * thin * (3 - 2 * thin))};
    if (thickness > 0.1)
        film_on_index(&rules, film, cosine, (const double[3]){eta, eta, eta}, (const double[3]){0}, f);
    const double s = between(eta, fresnel_dielectric(eta, cosine));
    for (size_t c = 0; c < 3; ++c)
        if (thickness <= 0.1)
            f[c] = mix(self->specular_f0[c], 1, s);
        else if (f0 > 1e-5)
            f[c] *= mix(1, self->specular_f0[c] / f0, clamp01((f[c] - 1) / (f0 - 1)));
}

/* ---- layers ------------------------------------------------------------------------------------------------------- */

/* What is above the layer that follows: its sum, and what is left for layers below. */
typedef struct stack {
    const geometry *g;
    bool is_compensated;
    double f[3], weight[3];
} stack;

/* Keep 1 - the largest albedo (3). */
static void cover(stack *s, const double *albedo) {
    double largest = 0;
    for (size_t c = 0; c < 3; ++c)
        largest = s->weight[c] > 0 ? fmax(largest, albedo[c]) : largest;
    for (size_t c = 0; c < 3; ++c)
        s->weight[c] *= clamp01(1 - largest);
}

/* Add a lobe with a factor, its mean over the hemisphere, and its mean for the viewer. estimate (3) receives the
 * albedo; NULL: metal, which covers nothing. */
static void add_lobe(stack *s, const ggx_lobe *lobe, double amount, const double *factor, const double *mean,
                     double *estimate) {
    const geometry *g = s->g;
    const double e = look_up(lobe->e, N_E, g->cos_o), missing = (1 - e) / e;
    const double f = correlated_ggx(g->tan2_h, g->cos_i, g->cos_o, turned_pair_widths(&lobe->widths, g->wi, g->wo));
    for (size_t c = 0; c < 3; ++c) {
        const double bounced = mean[c] * lobe->e_mean / (1 - mean[c] * (1 - lobe->e_mean));
        const double gain = s->is_compensated ? 1 + bounced * missing : 1;
        s->f[c] += amount * s->weight[c] * f * factor[c] * gain;
        if (estimate)
            estimate[c] *= amount * gain * (s->is_compensated ? e : 1);
    }
}

static void add_sheen(stack *s, const blender *self) {
    const double(*v)[3] = self->spec.values.v;
    const double cos_o = s->g->cos_o;
    const closure sheen = transformed_sheen(s->g, 1, WHITE, look_up(self->sheen[0], N_E, cos_o),
                                            look_up(self->sheen[1], N_E, cos_o), -look_up(self->sheen[2], N_E, cos_o));
    double albedo[3];
    for (size_t c = 0; c < 3; ++c) {
        const double amount = v[SHEEN_WEIGHT][0] * v[SHEEN_TINT][c];
        s->f[c] += amount * sheen.f[c];
        albedo[c] = amount * (1 - sheen.pass[c]);
    }
    cover(s, albedo);
}

/* The coat has no energy compensation; its albedo is that of a smooth one. Its colour is absorbed along the viewer's
 * refracted ray. */
static void add_coat(stack *s, const blender *self) {
    const double(*v)[3] = self->spec.values.v, amount = v[COAT_WEIGHT][0], ior = v[COAT_IOR][0], cos_o = s->g->cos_o;
    const double fresnel = fresnel_dielectric(ior, s->g->cos_d), albedo = amount * fresnel_dielectric(ior, cos_o);
    const double depth = 1 / sqrt(1 - (1 - cos_o * cos_o) / (ior * ior));
    const double f =
        fresnel * correlated_ggx(s->g->tan2_h, s->g->cos_i, cos_o, turned_pair_widths(&self->coat, s->g->wi, s->g->wo));
    for (size_t c = 0; c < 3; ++c)
        s->f[c] += amount * s->weight[c] * f;
    cover(s, (const double[3]){albedo, albedo, albedo});
    for (size_t c = 0; c < 3; ++c)
        s->weight[c] *= mix(1, pow(v[COAT_TINT][c], depth), amount);
}

static void add_metal(stack *s, const blender *self) {
    const double(*v)[3] = self->spec.values.v, *f0 = v[BASE_COLOR], metallic = v[METALLIC][0], at = 1.0 / 7, m = 1 - at;
    double factor[3], mean[3];
    for (size_t c = 0; c < 3; ++c) {
        const double tint = fmin(v[SPECULAR_TINT][c], 1);
        const double dip = schlick_between(f0[c], 1, at) * (1 - tint) / (at * m * power5(m));
        factor[c] = clamp01(schlick_f82(f0[c], tint, 1, s->g->cos_d));
        mean[c] = mix(f0[c], 1, 1.0 / 21) - dip / 126;
    }
    add_lobe(s, &self->base, metallic, factor, mean, NULL);
    for (size_t c = 0; c < 3; ++c)
        s->weight[c] *= 1 - metallic;
}

static void add_dielectric(stack *s, const blender *self) {
    const double(*v)[3] = self->spec.values.v, eta = self->base.eta, cos_o = s->g->cos_o;
    const double middle = between(eta, mean_fresnel(eta)), seen = look_up(self->base.s, N_S, cos_o);
    double factor[3], mean[3], albedo[3];
    if (eta == 1 && v[THIN_FILM_THICKNESS][0] <= 0.1)
        return;
    dielectric_factor(self, s->g->cos_d, factor);
    dielectric_factor(self, cos_o, albedo); /* with a film, the albedo is that of a smooth surface */
    for (size_t c = 0; c < 3; ++c) {
        mean[c] = mix(self->specular_f0[c], 1, middle);
        if (v[THIN_FILM_THICKNESS][0] <= 0.1)
            albedo[c] = mix(self->specular_f0[c], 1, seen);
    }
    add_lobe(s, &self->base, 1, factor, mean, albedo);
    cover(s, albedo);
}

static void prepare(const nqm_values *values, void *state) {
    blender *self = state;
    const double(*v)[3] = values->v, roughness2 = v[ROUGHNESS][0] * v[ROUGHNESS][0], ior = v[IOR][0];
    const double aspect = sqrt(1 - 0.9 * v[ANISOTROPIC][0]), level = v[SPECULAR_IOR_LEVEL][0];
    const double coat2 = fmin(fmax(v[COAT_ROUGHNESS][0] * v[COAT_ROUGHNESS][0], MIN_ALPHA), 1);
    double eta = ior;
    self->f0 = f0_between(ior, 1);
    if (level != 0.5) {
        self->f0 *= 2 * level;
        const double root = sqrt(fmin(self->f0, 0.99)), above = (1 + root) / (1 - root);
        eta = ior < 1 ? 1 / above : above;
    }
    for (size_t c = 0; c < 3; ++c)
        self->specular_f0[c] = clamp01(self->f0 * v[SPECULAR_TINT][c]);
    prepare_lobe(&self->base, roughness2 / aspect, roughness2 * aspect, 2 * NQM_PI * v[ANISOTROPIC_ROTATION][0], eta);
    prepare_sheen(self, v[SHEEN_ROUGHNESS][0]);
    self->coat = turned_widths_of(coat2 * coat2, coat2 * coat2, 0);
}

static closure evaluate(const void *state, const geometry *g) {
    const blender *self = state;
    const double(*v)[3] = self->spec.values.v;
    const eon_terms diffuse = eon_terms_of(g, v[DIFFUSE_ROUGHNESS][0]);
    stack s = {.g = g, .is_compensated = v[MULTISCATTER][0] > 0.5, .weight = {1, 1, 1}};
    closure result = {.pass = {0}};
    if (v[SHEEN_WEIGHT][0] > 0)
        add_sheen(&s, self);
    if (v[COAT_WEIGHT][0] > 0)
        add_coat(&s, self);
    if (v[METALLIC][0] > 0)
        add_metal(&s, self);
    if (v[METALLIC][0] < 1)
        add_dielectric(&s, self);
    for (size_t c = 0; c < 3;
         ++c) { /* Cycles multiplies light that is scattered more than once by the colour once more */
        const double color = v[BASE_COLOR][c], many = eon_bounced(&diffuse, color) * diffuse.multiple;
        result.f[c] = s.f[c] + s.weight[c] * color * (diffuse.single + many) / NQM_PI;
    }
    return result;
}

CLOSURE_MODEL(blender, "blender-principled", blender);
