/* SPDX-License-Identifier: MIT
 *
 * Analytic BRDFs over a Lambertian base kd / pi; doc/brdf.md has the formulas and their sources.
 *
 * Values and derivatives come from the same functions: a lobe receives NULL instead of an array for its derivatives when
 * only the value is needed.
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

/* d (kd / pi) / d kd */
static const double PER_KD = 1 / NQM_PI;

/* ---- Lambert ----------------------------------------------------------------------------------------------------- */

typedef struct lambert {
    double f[3];
} lambert;

static void lambert_prepare(const nqm_values *values, void *state) {
    lambert *self = state;
    for (int c = 0; c < 3; ++c)
        self->f[c] = values->v[0][c] / NQM_PI;
}

/* jacobian: NULL, or receives the derivatives. */
INLINED void lambert_values(const lambert *self, size_t n, const double *wi, const double *wo, double *rgb,
                            double *jacobian) {
    (void)wi, (void)wo;
    for (size_t i = 0; i < 3 * n; ++i) {
        rgb[i] = self->f[i % 3];
        if (jacobian)
            jacobian[3 * i + i % 3] = PER_KD;
    }
}

NQM_EVAL_AND_JACOBIAN(lambert, lambert_values, state)

const nqm_analytic_model nqm_lambert_model = {
    .schema = &nqm_lambert_schema,
    .class_ =
        {.format = "lambert", .reciprocal = 1, .eval = lambert_eval, .jacobian = lambert_jacobian, .free = nqm_free},
    .state_size = sizeof(lambert),
    .prepare = lambert_prepare,
};

/* ---- GGX --------------------------------------------------------------------------------------------------------- */

typedef struct ggx {
    double diffuse[3]; /* kd / pi */
    double ks[3], f0[3];
    widths alpha2;
    double d_alpha2[2]; /* d alpha^2 / d alpha */
} ggx;

enum { GGX_KS = 3, GGX_ALPHA = 6, GGX_F0 = 8, GGX_N = 11 }; /* columns of the derivatives; kd begins at 0 */

static void ggx_prepare(const nqm_values *values, void *state) {
    ggx *self = state;
    for (int c = 0; c < 3; ++c) {
        self->diffuse[c] = values->v[0][c] / NQM_PI;
        self->ks[c] = values->v[1][c];
        self->f0[c] = values->v[3][c];
    }
    const double *alpha = values->v[2];
    self->alpha2 = (widths){alpha[0] * alpha[0], alpha[1] * alpha[1]};
    for (int k = 0; k < 2; ++k)
        self->d_alpha2[k] = 2 * alpha[k];
}

/* Add d log ggx_visibility() / d alpha^2 along both axes, from the visibility: the square root is 1 / visibility - cosine. */
static void add_visibility_slopes(const double *w, double visibility, double *slopes) {
    const double slope = -visibility * visibility * (1 - w[2] * w[2]) / (2 * (1 - w[2] * visibility));
    const azimuth a = azimuth_of(w[0], w[1]);
    slopes[0] += slope * a.cos2;
    slopes[1] += slope * a.sin2;
}

/* d log D / d alpha^2 along both axes; h2 is that along the half vector's azimuth a. */
static void distribution_slopes(widths alpha2, double tan2_h, double h2, azimuth a, double *slopes) {
    const double by_h2 = 2 * tan2_h * h2 / (tan2_h + h2);
    const double x = 1 / alpha2.x2, y = 1 / alpha2.y2;
    slopes[0] = by_h2 * a.cos2 * (x * x) - 0.5 * x;
    slopes[1] = by_h2 * a.sin2 * (y * y) - 0.5 * y;
}

/* D V V. slopes: NULL, or (2) receives d log lobe / d alpha^2 along both axes. */
INLINED double ggx_lobe(widths alpha2, double tan2_h, const double *wi, const double *wo, double *slopes) {
    pair_widths a = pair_widths_of(alpha2, wi, wo);
    double visibility_i = ggx_visibility(wi[2], a.i2), visibility_o = ggx_visibility(wo[2], a.o2);
    double visibility =
        visibility_i * visibility_o; /* grouped so that exchanging light and viewer gives the same bits */
    if (slopes) {
        distribution_slopes(alpha2, tan2_h, a.h2, half_azimuth(wi, wo), slopes);
        add_visibility_slopes(wi, visibility_i, slopes);
        add_visibility_slopes(wo, visibility_o, slopes);
    }
    return ggx_distribution(tan2_h, a.h2) * a.density * visibility;
}

/* jacobian: NULL, or receives the derivatives. */
INLINED void ggx_values(const ggx *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian) {
    for (size_t i = 0; i < n; ++i) {
        half_angles h = half_angles_of(wi + 3 * i, wo + 3 * i);
        double slopes[2] = {0};
        double lobe = ggx_lobe(self->alpha2, h.tan2_h, wi + 3 * i, wo + 3 * i, jacobian ? slopes : NULL);
        double m = 1 - h.cos_d;
        double schlick = m * m * m * m * m;
        for (size_t c = 0; c < 3; ++c) {
            double fresnel = self->f0[c] + (1 - self->f0[c]) * schlick;
            rgb[3 * i + c] = self->diffuse[c] + self->ks[c] * lobe * fresnel;
            if (jacobian) {
                double *row = jacobian + (3 * i + c) * GGX_N;
                row[c] = PER_KD;
                row[GGX_KS + c] = lobe * fresnel;
                for (size_t k = 0; k < 2; ++k)
                    row[GGX_ALPHA + k] = self->ks[c] * fresnel * lobe * slopes[k] * self->d_alpha2[k];
                row[GGX_F0 + c] = self->ks[c] * lobe * (1 - schlick);
            }
        }
    }
}

NQM_EVAL_AND_JACOBIAN(ggx, ggx_values, state)

const nqm_analytic_model nqm_ggx_model = {
    .schema = &(const nqm_schema){.model = "ggx",
                                  .n_keys = 4,
                                  .keys = {{.name = "kd", .n = 3, .low = 0, .high = 10, .fallback = 0},
                                           {.name = "ks", .n = 3, .low = 0, .high = 1e6, .fallback = 1},
                                           {.name = "alpha", .n = 2, .low = 1e-4, .high = 10, .required = true},
                                           {.name = "f0", .n = 3, .low = 0, .high = 1, .fallback = 0.04}}},
    .doi = "10.2312/EGWR/EGSR07/195-206",
    .class_ = {.format = "ggx",
               .reciprocal = 1,
               .anisotropic = true,
               .eval = ggx_eval,
               .jacobian = ggx_jacobian,
               .free = nqm_free},
    .state_size = sizeof(ggx),
    .prepare = ggx_prepare,
};

/* ---- models of the form kd / pi + ks L: the lobe L is one function for all channels ------------------------------ */

enum { KD, KS, FIRST_SHAPE, MAX_SHAPE = 3 };
enum { LOBE_KS = 3, LOBE_SHAPE = 6 }; /* columns of the derivatives; kd begins at 0 */

/** A prepared model of the form kd / pi + ks L. */
typedef struct lobe {
    double diffuse[3];       /**< kd / pi */
    double specular[3];      /**< ks times the constant factors of L */
    double shape[MAX_SHAPE]; /**< shape of the lobe; its meaning depends on the model */

    /* For the derivatives by the parameters, the keys after kd and ks: */
    double factor;                        /**< the constant factors of L */
    double d_log_factor[MAX_SHAPE];       /**< d log factor / d parameter */
    double d_shape[MAX_SHAPE][MAX_SHAPE]; /**< d shape / d parameter: (shape, parameter) */
} lobe;

/** Fill the state from a schema that begins with kd, ks, whose other values become the shape; `factor` is the constant part
 *  of L. */
static lobe make_lobe(const nqm_values *values, double factor) {
    lobe made = {.factor = factor};
    for (size_t c = 0; c < 3; ++c) {
        made.diffuse[c] = values->v[KD][c] / NQM_PI;
        made.specular[c] = values->v[KS][c] * factor;
        made.shape[c] = values->v[FIRST_SHAPE + c][0];
        made.d_shape[c][c] = 1;
    }
    return made;
}

/** The first key has n_first values, 1 or 2, with which the shape begins: widths alpha; the shape has 1 / alpha^2, and `factor` is
 *  proportional to the square root of the product of both. */
static lobe make_lobe_of_width(const nqm_values *values, size_t n_first, double factor) {
    lobe made = make_lobe(values, factor);
    made.shape[n_first] = values->v[FIRST_SHAPE + 1][0];
    for (size_t k = 0; k < n_first; ++k) {
        const double alpha = values->v[FIRST_SHAPE][k];
        made.shape[k] = 1 / (alpha * alpha);
        made.d_shape[k][k] = -2 / (alpha * alpha * alpha);
        made.d_log_factor[k] = -2 / alpha / (double)n_first;
    }
    return made;
}

/** The same of exponents n of cos theta_h; the shape has -n / 2, and the factor is the geometric mean of n + offset,
 *  over divisor. */
static lobe make_lobe_of_exponent(const nqm_values *values, size_t n_first, double offset, double divisor) {
    const double *n = values->v[FIRST_SHAPE];
    lobe made = make_lobe(values, sqrt((n[0] + offset) * (n[1] + offset)) / divisor);
    made.shape[n_first] = values->v[FIRST_SHAPE + 1][0];
    for (size_t k = 0; k < n_first; ++k) {
        made.shape[k] = -0.5 * n[k];
        made.d_shape[k][k] = -0.5;
        made.d_log_factor[k] = 1 / (n[k] + offset) / (double)n_first;
    }
    return made;
}

/** Of two values of the shape, that along the azimuth of the half vector; of equal ones the same bits. */
INLINED double shape_along(const double *shape, const double *wi, const double *wo) {
    return shape[0] == shape[1] ? shape[0] : along(half_azimuth(wi, wo), shape[0], shape[1]);
}

/** Derivatives by both, from that by shape_along(). */
INLINED void split_slope(double slope, const double *wi, const double *wo, double *d) {
    const azimuth a = half_azimuth(wi, wo);
    d[0] = slope * a.cos2;
    d[1] = slope * a.sin2;
}

/** L without its constant factors. Written so that exchanging light and viewer gives the same bits. d: NULL, or receives
 *  the derivatives by the shape. */
typedef double (*lobe_fn)(const double *shape, const double *wi, const double *wo, double *d);

/** Derivatives of L, without its constant factors, by the parameters, from L and its derivatives by the shape. */
INLINED void chain_rule(const lobe *self, size_t n_shape, double value, const double *d, double *by_parameter) {
    for (size_t k = 0; k < n_shape; ++k) {
        by_parameter[k] = value * self->d_log_factor[k];
        for (size_t s = 0; s < n_shape; ++s)
            by_parameter[k] += d[s] * self->d_shape[s][k];
    }
}

/** The formula of a lobe and the number of its shape parameters. */
typedef struct lobe_kind {
    lobe_fn f;
    size_t n_shape;
} lobe_kind;

/** Evaluate n pairs. jacobian: NULL, or receives the derivatives. Inlined, so that the compiler can inline the formula too. */
INLINED void lobe_values(lobe_kind kind, const lobe *self, size_t n, const double *wi, const double *wo, double *rgb,
                         double *jacobian) {
    const size_t n_shape = kind.n_shape;
    for (size_t i = 0; i < n; ++i) {
        double d[MAX_SHAPE], by_parameter[MAX_SHAPE];
        double value = kind.f(self->shape, wi + 3 * i, wo + 3 * i, jacobian ? d : NULL);
        if (jacobian)
            chain_rule(self, n_shape, value, d, by_parameter);
        for (size_t c = 0; c < 3; ++c) {
            rgb[3 * i + c] = self->diffuse[c] + self->specular[c] * value;
            if (jacobian) {
                double *row = jacobian + (3 * i + c) * (LOBE_SHAPE + n_shape);
                row[c] = PER_KD;
                row[LOBE_KS + c] = self->factor * value;
                for (size_t k = 0; k < n_shape; ++k)
                    row[LOBE_SHAPE + k] = self->specular[c] * by_parameter[k];
            }
        }
    }
}

/** The first two keys of every such model. */
#define LOBE_KEYS                                                                                                      \
    {.name = "kd", .n = 3, .low = 0, .high = 10, .fallback = 0}, {                                                     \
        .name = "ks", .n = 3, .low = 0, .high = 1e6, .required = true                                                  \
    }

/** Define the model MODEL with the lobe function LOBE of N_SHAPE values; MADE is its state for `values`, and the
 *  variadic arguments are its keys after kd and ks. */
#define LOBE_MODEL(MODEL, NAME, DOI, LOBE, MADE, N_SHAPE, ...)                                                         \
    static void LOBE##_prepare(const nqm_values *values, void *state) {                                                \
        *(lobe *)state = MADE;                                                                                         \
    }                                                                                                                  \
    NQM_EVAL_AND_JACOBIAN(LOBE, lobe_values, (lobe_kind){LOBE, N_SHAPE}, state)                                        \
    const nqm_analytic_model MODEL = {                                                                                 \
        .schema =                                                                                                      \
            &(const nqm_schema){.model = NAME,                                                                         \
                                .n_keys = sizeof((nqm_schema_key[]){LOBE_KEYS, __VA_ARGS__}) / sizeof(nqm_schema_key), \
                                .keys = {LOBE_KEYS, __VA_ARGS__}},                                                     \
        .doi = DOI,                                                                                                    \
        .class_ = {.format = NAME,                                                                                     \
                   .reciprocal = 1,                                                                                    \
                   .anisotropic = true,                                                                                \
                   .eval = LOBE##_eval,                                                                                \
                   .jacobian = LOBE##_jacobian,                                                                        \
                   .free = nqm_free},                                                                                  \
        .state_size = sizeof(lobe),                                                                                    \
        .prepare = LOBE##_prepare,                                                                                     \
    }

/* ---- Ward -------------------------------------------------------------------------------------------------------- */

static lobe make_ward_duer(const nqm_values *values) {
    const double *alpha = values->v[FIRST_SHAPE];
    return make_lobe_of_width(values, 2, 1 / (4 * NQM_PI * alpha[0] * alpha[1]));
}

/* One division instead of a product with the factor: rounded as in earlier versions. */
static lobe make_ward(const nqm_values *values) {
    const double *alpha = values->v[FIRST_SHAPE];
    lobe made = make_ward_duer(values);
    for (size_t c = 0; c < 3; ++c)
        made.specular[c] = values->v[KS][c] / (4 * NQM_PI * alpha[0] * alpha[1]);
    return made;
}

/* exp(-tan^2 theta_h (cos^2 phi_h / alpha_x^2 + sin^2 phi_h / alpha_y^2)) / divisor */
INLINED double ward_lobe(const double *shape, double divisor, const double *wi, const double *wo, double *d) {
    double tan2_h = half_angles_of(wi, wo).tan2_h;
    double value = exp(-tan2_h * shape_along(shape, wi, wo)) / divisor;
    if (d)
        split_slope(-tan2_h * value, wi, wo, d);
    return value;
}

INLINED double ward(const double *shape, const double *wi, const double *wo, double *d) {
    return ward_lobe(shape, sqrt(wi[2] * wo[2]), wi, wo, d);
}

LOBE_MODEL(nqm_ward_model, "ward", "10.1145/142920.134078", ward, make_ward(values), 2,
           {.name = "alpha", .n = 2, .low = 1e-4, .high = 10, .required = true});

/* ---- Ward-Duer --------------------------------------------------------------------------------------------------- */

INLINED double ward_duer(const double *shape, const double *wi, const double *wo, double *d) {
    return ward_lobe(shape, wi[2] * wo[2], wi, wo, d);
}

LOBE_MODEL(nqm_ward_duer_model, "ward-duer", "10.1080/2151237X.2006.10129215", ward_duer, make_ward_duer(values), 2,
           {.name = "alpha", .n = 2, .low = 1e-4, .high = 10, .required = true});

/* ---- Blinn-Phong ------------------------------------------------------------------------------------------------- */

/* cos^n theta_h = (1 + tan^2 theta_h)^(-n / 2) */
INLINED double blinn_phong(const double *shape, const double *wi, const double *wo, double *d) {
    double log_sec2_h = log1p(half_angles_of(wi, wo).tan2_h);
    double value = exp(shape[0] * log_sec2_h);
    if (d)
        d[0] = log_sec2_h * value;
    return value;
}

LOBE_MODEL(nqm_blinn_phong_model, "blinn-phong", "10.1145/563858.563893", blinn_phong,
           make_lobe_of_exponent(values, 1, 2, 2 * NQM_PI), 1,
           {.name = "n", .n = 1, .low = 0, .high = 1e8, .required = true});

/* ---- Lafortune --------------------------------------------------------------------------------------------------- */

enum { CXY = FIRST_SHAPE, CZ, EXPONENT };

/* Only the ratio of the coefficients matters: they are scaled so that the larger is 1. The shape of the larger is always 0,
 * so its derivatives are 0. */
static lobe make_lafortune(const nqm_values *values) {
    double cxy = values->v[CXY][0], cz = values->v[CZ][0], n = values->v[EXPONENT][0];
    double largest = fmax(-cxy, cz);
    lobe made = make_lobe(values, (n + 2) / (2 * NQM_PI));
    made.shape[0] = (largest + cxy) / largest;
    made.shape[1] = (largest - cz) / largest;
    made.d_log_factor[EXPONENT - FIRST_SHAPE] = 1 / (n + 2);
    made.d_shape[0][0] = made.d_shape[1][1] = 0;
    if (-cxy >= cz) { /* shape[1] = 1 + cz / cxy */
        made.d_shape[1][0] = -cz / (cxy * cxy);
        made.d_shape[1][1] = 1 / cxy;
    } else { /* shape[0] = 1 + cxy / cz */
        made.d_shape[0][0] = 1 / cz;
        made.d_shape[0][1] = -cxy / (cz * cz);
    }
    return made;
}

/* The generalised cosine is cos(alpha) - a (-xy) - b z with a = 1 - |cxy|, b = 1 - cz (scaled), cos(alpha) between
 * viewer and mirrored light; 1 - cos(alpha) is half the squared distance between these two unit vectors, which loses no
 * precision for narrow lobes. */
INLINED double lafortune(const double *shape, const double *wi, const double *wo, double *d) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], dz = wi[2] - wo[2];
    double deficit = 0.5 * (x * x + y * y + dz * dz); /* 1 - cos(alpha) */
    double xy = wi[0] * wo[0] + wi[1] * wo[1], z = wi[2] * wo[2];
    deficit += shape[1] * z - shape[0] * xy;
    double log_cosine = deficit < 1 ? log1p(-deficit) : 0;
    double value = deficit < 1 ? exp(shape[2] * log_cosine) : 0;
    if (d) {
        double by_deficit = value > 0 ? -shape[2] * value / (1 - deficit) : 0;
        d[0] = -by_deficit * xy;
        d[1] = by_deficit * z;
        d[2] = log_cosine * value;
    }
    return value;
}

LOBE_MODEL(nqm_lafortune_model, "lafortune", "10.1145/258734.258801", lafortune, make_lafortune(values), 3,
           {.name = "cxy", .n = 1, .low = -10, .high = -0.01, .fallback = -1},
           {.name = "cz", .n = 1, .low = 0, .high = 10, .required = true},
           {.name = "n", .n = 1, .low = 0, .high = 1e8, .required = true});

/* ---- Fresnel terms and shadowing --------------------------------------------------------------------------------- */

/* A reflectance and its derivative by its parameter. */
typedef struct reflectance {
    double value, slope;
} reflectance;
typedef reflectance (*fresnel_fn)(double parameter, double cosine);

/* schlick_factor() is linear in f0. */
INLINED reflectance schlick(double f0, double cosine) {
    return (reflectance){schlick_factor(f0, cosine), 1 - schlick_factor(0, cosine)};
}

/* Reflectance of unpolarised light at a dielectric, as Cook and Torrance 1982 write it. */
INLINED reflectance dielectric(double eta, double cosine) {
    double g = sqrt(fmax(0, eta * eta + cosine * cosine - 1));
    double a = (g - cosine) / (g + cosine), d_a = 2 * cosine / ((g + cosine) * (g + cosine));
    double q = cosine * (g - cosine) + 1;
    double b = (cosine * (g + cosine) - 1) / q, d_b = 2 * cosine * (1 - cosine * cosine) / (q * q);
    double d_g = g > 0 ? eta / g : 0;
    return (reflectance){0.5 * a * a * (1 + b * b), (a * (1 + b * b) * d_a + a * a * b * d_b) * d_g};
}

/* Shadowing and masking of V-grooves (Torrance and Sparrow 1967), divided by cos theta_i cos theta_o. */
INLINED double grooves(half_angles h, const double *wi, const double *wo) {
    double cos_h = 1 / sqrt(1 + h.tan2_h);
    return fmin(1, 2 * cos_h * fmin(wi[2], wo[2]) / h.cos_d) / (wi[2] * wo[2]);
}

/* ---- Cook-Torrance ----------------------------------------------------------------------------------------------- */

/* Beckmann's distribution without its constant 1 / (pi alpha^2), multiplied by grooves() and f. */
INLINED double beckmann_lobe(const double *shape, fresnel_fn fresnel, const double *wi, const double *wo, double *d) {
    half_angles h = half_angles_of(wi, wo);
    reflectance f = fresnel(shape[1], h.cos_d);
    double sec2_h = 1 + h.tan2_h;
    double value = exp(-h.tan2_h * shape[0]) * sec2_h * sec2_h * grooves(h, wi, wo);
    if (d) {
        d[0] = -h.tan2_h * value * f.value;
        d[1] = value * f.slope;
    }
    return value * f.value;
}

static lobe make_cook_torrance(const nqm_values *values, double factor) {
    double alpha = values->v[FIRST_SHAPE][0];
    return make_lobe_of_width(values, 1, factor / (alpha * alpha));
}

INLINED double cook_torrance(const double *shape, const double *wi, const double *wo, double *d) {
    return beckmann_lobe(shape, schlick, wi, wo, d);
}

LOBE_MODEL(nqm_cook_torrance_model, "cook-torrance", "10.1145/357290.357293", cook_torrance,
           make_cook_torrance(values, 1 / (NQM_PI * NQM_PI)), 2,
           {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true},
           {.name = "f0", .n = 1, .low = 0, .high = 1, .required = true});

INLINED double low_cook_torrance(const double *shape, const double *wi, const double *wo, double *d) {
    return beckmann_lobe(shape, dielectric, wi, wo, d);
}

/* The distribution is that of Cook and Torrance 1982 itself, which lacks 1 / pi. */
LOBE_MODEL(nqm_low_cook_torrance_model, "low-cook-torrance", "10.1145/357290.357293", low_cook_torrance,
           make_cook_torrance(values, 1 / NQM_PI), 2,
           {.name = "alpha", .n = 1, .low = 1e-4, .high = 10, .required = true},
           {.name = "eta", .n = 1, .low = 1, .high = 1000, .required = true});

/* ---- Ashikhmin-Shirley ------------------------------------------------------------------------------------------- */

INLINED double ashikhmin_lobe(const double *shape, fresnel_fn fresnel, const double *wi, const double *wo, double *d) {
    half_angles h = half_angles_of(wi, wo);
    reflectance f = fresnel(shape[2], h.cos_d);
    double log_sec2_h = log1p(h.tan2_h);
    double value = exp(shape_along(shape, wi, wo) * log_sec2_h) / (h.cos_d * fmax(wi[2], wo[2]));
    if (d) {
        split_slope(log_sec2_h * value * f.value, wi, wo, d);
        d[2] = value * f.slope;
    }
    return value * f.value;
}

INLINED double ashikhmin_shirley(const double *shape, const double *wi, const double *wo, double *d) {
    return ashikhmin_lobe(shape, schlick, wi, wo, d);
}

LOBE_MODEL(nqm_ashikhmin_shirley_model, "ashikhmin-shirley", "10.1080/10867651.2000.10487522", ashikhmin_shirley,
           make_lobe_of_exponent(values, 2, 1, 8 * NQM_PI), 3,
           {.name = "n", .n = 2, .low = 0, .high = 1e8, .required = true},
           {.name = "f0", .n = 1, .low = 0, .high = 1, .required = true});

INLINED double low_ashikhmin_shirley(const double *shape, const double *wi, const double *wo, double *d) {
    return ashikhmin_lobe(shape, dielectric, wi, wo, d);
}

LOBE_MODEL(nqm_low_ashikhmin_shirley_model, "low-ashikhmin-shirley", "10.1080/10867651.2000.10487522",
           low_ashikhmin_shirley, make_lobe_of_exponent(values, 2, 1, 8 * NQM_PI), 3,
           {.name = "n", .n = 2, .low = 0, .high = 1e8, .required = true},
           {.name = "eta", .n = 1, .low = 1, .high = 1000, .required = true});

/* ---- the two models of Low et al. -------------------------------------------------------------------------------- */

static lobe make_abc(const nqm_values *values, double factor) {
    lobe made = make_lobe(values, factor);
    made.shape[1] = -made.shape[1];
    made.d_shape[1][1] = -1;
    return made;
}

/* (1 + B x)^-C geometry f; the shape is B, -C, eta. */
INLINED double abc_lobe(const double *shape, double x, double geometry, reflectance f, double *d) {
    double log_base = log1p(shape[0] * x);
    double value = exp(shape[1] * log_base) * geometry;
    if (d) {
        d[0] = shape[1] * x / (1 + shape[0] * x) * value * f.value;
        d[1] = log_base * value * f.value;
        d[2] = value * f.slope;
    }
    return value * f.value;
}

INLINED double abc(const double *shape, const double *wi, const double *wo, double *d) {
    half_angles h = half_angles_of(wi, wo);
    double sec_h = sqrt(1 + h.tan2_h);
    double one_minus_cos_h = h.tan2_h / (sec_h * (sec_h + 1));
    return abc_lobe(shape, one_minus_cos_h, grooves(h, wi, wo), dielectric(shape[2], h.cos_d), d);
}

#define ABC_KEYS                                                                                                       \
    {.name = "B", .n = 1, .low = 0, .high = 1e9, .required = true},                                                    \
        {.name = "C", .n = 1, .low = 0, .high = 100, .required = true}, {                                              \
        .name = "eta", .n = 1, .low = 1, .high = 1000, .required = true                                                \
    }

/* The published amplitudes are for a model with the factor 1 / pi. */
LOBE_MODEL(nqm_abc_model, "abc", "10.1145/2077341.2077350", abc, make_abc(values, 1 / NQM_PI), 3, ABC_KEYS);

/* In the plane of projected directions, the sum of both directions is the deviation from the mirror direction, and half
 * the length of their difference is the sine of the angle at which the Fresnel term is evaluated (equation 14). */
INLINED double smooth(const double *shape, const double *wi, const double *wo, double *d) {
    double x = wi[0] + wo[0], y = wi[1] + wo[1], dx = wi[0] - wo[0], dy = wi[1] - wo[1];
    double deviation2 = x * x + y * y;
    double cosine = sqrt(fmax(0, 1 - 0.25 * (dx * dx + dy * dy)));
    return abc_lobe(shape, deviation2, 1, dielectric(shape[2], cosine), d);
}

LOBE_MODEL(nqm_smooth_model, "smooth", "10.1145/2077341.2077350", smooth, make_abc(values, 1), 3, ABC_KEYS);
