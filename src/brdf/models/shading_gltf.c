/* SPDX-License-Identifier: MIT
 *
 * `gltf`, the material of glTF 2.0: Appendix B of the specification and its extensions; doc/materials.md has the formulas.
 */
#include "brdf/core/spec.h"
#include "brdf/models/thin_film.h"
#include "sheen_albedo_table.h" /* generated from presets/sheen_albedo.txt */

enum { NQM_GLTF_KEYS(NQM_KEY_INDEX) N_KEYS };

/** Narrower lobes are mirrors in the specification, which have no value. */
static const double MIN_ALPHA = 1e-4, MIN_SHEEN_ROUGHNESS = 1e-3;
static const double COAT_F0 = 0.04;

/** The sheen lobe at one roughness. */
typedef struct sheen {
    double color[3], max_color; /**< 0: no sheen */
    double inverse_alpha;
    double shape[5];        /**< constants of the shadowing */
    double shape_half;      /**< exponent at a cosine of one half */
    double albedo[SHEEN_N]; /**< at the square root of the cosine j / (SHEEN_N - 1) */
} sheen;

typedef struct gltf {
    nqm_spec_state spec;
    double diffuse[3]; /**< f_r of the base without Fresnel factor */
    double f0[3], f90; /**< of the dielectric part */
    turned_widths base;
    double coat_alpha2;
    sheen sheen;
} gltf;

/* ---- sheen: Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF" ---------------------------------- */

/** Catmull-Rom interpolation of equidistant samples at i + t. */
static double cubic(double before, double a, double b, double after, double t) {
    return a + 0.5 * t * (b - before + t * (2 * before - 5 * a + 4 * b - after + t * (3 * (a - b) + after - before)));
}

enum { LAST = SHEEN_N - 1 };

static double table_value(double roughness_index, size_t column) {
    const size_t i = (size_t)fmin(roughness_index, LAST - 1);
    const uint16_t *before = sheen_table[i ? i - 1 : 0], *a = sheen_table[i], *b = sheen_table[i + 1],
                   *after = sheen_table[i + 2 > LAST ? LAST : i + 2];
    return 1e-4 * cubic(before[column], a[column], b[column], after[column], roughness_index - (double)i);
}

static double sheen_albedo(const sheen *self, double cosine) {
    const double x = LAST * sqrt(cosine);
    const size_t j = (size_t)fmin(x, LAST - 1);
    const double *e = self->albedo;
    return fmin(1, fmax(0, cubic(e[j ? j - 1 : 0], e[j], e[j + 1], e[j + 2 > LAST ? LAST : j + 2], x - (double)j)));
}

/** The function l of the paper. */
static double shadowing_exponent(const double *shape, double x) {
    return shape[0] / (1 + shape[1] * pow(x, shape[2])) + shape[3] * x + shape[4];
}

static double sheen_shadowing(const sheen *self, double cosine) {
    return exp(cosine < 0.5 ? shadowing_exponent(self->shape, cosine)
                            : 2 * self->shape_half - shadowing_exponent(self->shape, fmax(0, 1 - cosine)));
}

static void sheen_prepare(sheen *self, const double *color, double roughness) {
    static const double rough[5] = {21.5473, 3.82987, 0.19823, -1.97760, -4.32054},
                        smooth[5] = {25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
    for (size_t c = 0; c < 3; ++c)
        self->color[c] = color[c];
    self->max_color = fmax(color[0], fmax(color[1], color[2]));
    if (self->max_color == 0)
        return;
    roughness = fmax(roughness, MIN_SHEEN_ROUGHNESS);
    const double alpha = MISTAKEN(SHEEN_ALPHA) ? roughness : roughness * roughness;
    self->inverse_alpha = 1 / alpha;
    for (size_t k = 0; k < 5; ++k)
        self->shape[k] = mix(rough[k], smooth[k], (1 - alpha) * (1 - alpha));
    self->shape_half = shadowing_exponent(self->shape, 0.5);
    for (size_t j = 0; j < SHEEN_N; ++j)
        self->albedo[j] = table_value(LAST * roughness, j);
}

/** Cover the values of one pair with the layer. */
static void add_sheen(const sheen *self, const half_angles *h, double cos_i, double cos_o, double *rgb) {
    const double sin_h = sqrt(h->tan2_h / (1 + h->tan2_h));
    const double distribution = (2 + self->inverse_alpha) * pow(sin_h, self->inverse_alpha) / (2 * NQM_PI);
    const double shadowing = 1 + (sheen_shadowing(self, cos_i) + sheen_shadowing(self, cos_o));
    const double lobe = distribution / (MISTAKEN(SHEEN_VISIBILITY) ? 4 * (cos_i + cos_o - cos_i * cos_o)
                                                                   : shadowing * 4 * (cos_i * cos_o));
    const double passed = MISTAKEN(SHEEN_NOT_SCALED)
                              ? 1
                              : 1 - self->max_color * fmax(sheen_albedo(self, cos_i), sheen_albedo(self, cos_o));
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = self->color[c] * lobe + passed * rgb[c];
}

/* ---- the material ------------------------------------------------------------------------------------------------ */

static void gltf_prepare(const nqm_values *values, void *state) {
    gltf *self = state;
    const double ior = values->v[IOR][0], r = (ior - 1) / (ior + 1), specular = values->v[SPECULAR][0];
    const double alpha = fmax(MIN_ALPHA, values->v[ROUGHNESS][0] * values->v[ROUGHNESS][0]);
    const double coat_alpha = fmax(MIN_ALPHA, values->v[CLEARCOAT_ROUGHNESS][0] * values->v[CLEARCOAT_ROUGHNESS][0]);
    const double strength = values->v[ANISOTROPY_STRENGTH][0], along = mix(alpha, 1, strength * strength);
    for (size_t c = 0; c < 3; ++c) {
        self->diffuse[c] = values->v[BASE_COLOR][c] / DIFFUSE_PI;
        self->f0[c] = fmin(1, r * r * values->v[SPECULAR_COLOR][c]) * specular;
    }
    self->f90 = specular;
    self->base = turned_widths_of(along * along, alpha * alpha, values->v[ANISOTROPY_ROTATION][0]);
    self->coat_alpha2 = coat_alpha * coat_alpha;
    sheen_prepare(&self->sheen, values->v[SHEEN_COLOR], values->v[SHEEN_ROUGHNESS][0]);
}

/** Mix the factor of a film on a surface of reflectance f0 (3) into the factor f (3). */
static void add_film(const gltf *self, double strength, double cosine, const double *f0, double *f) {
    const double(*v)[3] = self->spec.values.v;
    double covered[3];
    film_on_gltf(&(thin_film){v[IRIDESCENCE_THICKNESS][0], v[IRIDESCENCE_IOR][0]}, cosine, f0, covered);
    for (size_t c = 0; c < 3; ++c)
        f[c] = mix(f[c], covered[c], strength);
}

/** Metallic-roughness without layers. */
static void base_material(const gltf *self, const half_angles *h, const double *wi, const double *wo, double *rgb) {
    const pair_widths a = turned_pair_widths(&self->base, wi, wo);
    const double lobe = correlated_ggx(h->tan2_h, wi[2], wo[2], a), (*v)[3] = self->spec.values.v;
    const double strength = v[IRIDESCENCE][0], *color = v[BASE_COLOR];
    double f[3], metal[3];
    for (size_t c = 0; c < 3; ++c) {
        f[c] = schlick_between(self->f0[c], self->f90, h->cos_d);
        metal[c] = schlick_factor(color[c], h->cos_d);
    }
    if (strength > 0 && v[IRIDESCENCE_THICKNESS][0] > 0) {
        add_film(self, strength, h->cos_d, self->f0, f);
        add_film(self, strength, h->cos_d, color, metal);
    }
    const double most = fmax(f[0], fmax(f[1], f[2]));
    for (size_t c = 0; c < 3; ++c) {
        const double left = MISTAKEN(DIFFUSE_NOT_REDUCED) ? 1 : 1 - (MISTAKEN(DIFFUSE_BY_CHANNEL) ? f[c] : most);
        rgb[c] = mix(f[c] * lobe + left * self->diffuse[c], metal[c] * lobe, v[METALLIC][0]);
        if (MISTAKEN(DIFFUSE_OF_METAL))
            rgb[c] += v[METALLIC][0] * left * self->diffuse[c];
    }
}

static double coat_f0(const gltf *self, size_t c) {
    return MISTAKEN(COAT_F0_OF_BASE)    ? self->f0[c]
           : MISTAKEN(COAT_F0_OF_INDEX) ? f0_between(self->spec.values.v[IOR][0], 1)
                                        : COAT_F0;
}

static void gltf_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const gltf *self = state;
    const double clearcoat = self->spec.values.v[CLEARCOAT][0];
    for (size_t i = 0; i < n; ++i) {
        const half_angles h = half_angles_of(wi + 3 * i, wo + 3 * i);
        const double cos_i = wi[3 * i + 2], cos_o = wo[3 * i + 2];
        base_material(self, &h, wi + 3 * i, wo + 3 * i, rgb + 3 * i);
        if (self->sheen.max_color > 0)
            add_sheen(&self->sheen, &h, cos_i, cos_o, rgb + 3 * i);
        if (clearcoat > 0) {
            const double lobe = correlated_ggx(h.tan2_h, cos_i, cos_o, equal_widths(self->coat_alpha2));
            const double cosine = MISTAKEN(COAT_FRESNEL_AT_HALF) ? h.cos_d : cos_o;
            for (size_t c = 0; c < 3; ++c) {
                const double weight = clearcoat * schlick_factor(coat_f0(self, c), cosine);
                rgb[3 * i + c] =
                    MISTAKEN(COAT_NOT_REDUCING) ? rgb[3 * i + c] + weight * lobe : mix(rgb[3 * i + c], lobe, weight);
            }
        }
    }
}

/* An index of 0 means a Fresnel factor of 1, as in the specification; the formula gives that. */
NQM_SHADING_MODEL(gltf, "gltf", gltf, gltf_prepare, gltf_eval, 0);
