/* SPDX-License-Identifier: MIT
 *
 * The shifted gamma distribution BRDF of Bagher, Soler and Holzschuch (2012, DOI 10.1111/j.1467-8659.2012.03147.x); doc/brdf.md has
 * the formulas. Every parameter has one value per channel. F may be negative where the authors' fit is.
 */
#include "brdf/core/spec.h"
#include "brdf/models/microfacet.h"

enum { KD, KS, ALPHA, P, F0, F1, K_NORM, LAMBDA, C, K_POWER, THETA0, N_KEYS };

/* The shadowing of one channel. It is exactly 1 or 0 outside a band of angles; transcendental functions are evaluated
 * only inside the band. */
typedef struct shadowing {
    double cos_one;  /* G rounds to 1 at and above this cosine */
    double cos_zero; /* G is 0 at and below this cosine */
    double theta0, lambda, log_c, k;
} shadowing;

typedef struct sgd {
    double v[N_KEYS][3];             /* the keys */
    double diffuse[3];               /* kd / pi */
    double specular[3];              /* ks K / pi^2 */
    double per_ks[3], per_k_norm[3]; /* K / pi^2, ks / pi^2 */
    double inverse_alpha[3];
    shadowing g[3];
} sgd;

static double cosine_at(double theta) {
    return theta < NQM_PI ? cos(fmax(theta, 0)) : -1;
}

/* Find the limits of the band: 1 - G = lambda (exp(y) - 1) with y = c x^k is below the rounding error of 1 up to y_one,
 * and reaches 1 at y_zero. */
static shadowing make_shadowing(const nqm_values *values, int channel) {
    shadowing g = {.theta0 = values->v[THETA0][channel],
                   .lambda = values->v[LAMBDA][channel],
                   .log_c = log(values->v[C][channel]),
                   .k = values->v[K_POWER][channel]};
    double y_one = 1e-17 / g.lambda, y_zero = log1p(1 / g.lambda);
    g.cos_one = cosine_at(g.theta0 + exp((log(y_one) - g.log_c) / g.k));
    g.cos_zero = cosine_at(g.theta0 + exp((log(y_zero) - g.log_c) / g.k));
    return g;
}

/* G and its derivatives. */
typedef struct shadow {
    double g, by_lambda, by_c, by_k, by_theta0;
} shadow;

/* The derivatives are those of the branch; they are left out if not `slopes`. */
INLINED shadow shadow_at(const shadowing *s, double cosine, double theta, bool slopes) {
    if (cosine >= s->cos_one)
        return (shadow){.g = 1};
    if (cosine <= s->cos_zero)
        return (shadow){.g = 0};
    double x = theta - s->theta0;
    if (!(x > 0))
        return (shadow){.g = 1};
    double log_x = log(x), y = exp(s->log_c + s->k * log_x), growth = expm1(y);
    shadow at = {.g = fmax(0, 1 - s->lambda * growth)};
    if (slopes && at.g > 0) {
        double by_y = -s->lambda * (growth + 1);
        at.by_lambda = -growth;
        at.by_c = by_y * exp(s->k * log_x);
        at.by_k = by_y * y * log_x;
        at.by_theta0 = -by_y * s->k * y / x;
    }
    return at;
}

static void sgd_prepare(const nqm_values *values, void *state) {
    sgd *self = state;
    memcpy(self->v, values->v, sizeof self->v);
    for (int c = 0; c < 3; ++c) {
        self->diffuse[c] = values->v[KD][c] / NQM_PI;
        self->specular[c] = values->v[KS][c] * values->v[K_NORM][c] / (NQM_PI * NQM_PI);
        self->per_ks[c] = values->v[K_NORM][c] / (NQM_PI * NQM_PI);
        self->per_k_norm[c] = values->v[KS][c] / (NQM_PI * NQM_PI);
        self->inverse_alpha[c] = 1 / values->v[ALPHA][c];
        self->g[c] = make_shadowing(values, c);
    }
}

/* What the three channels of a pair have in common. */
typedef struct sgd_angles {
    double cos_i, cos_o, theta_i, theta_o, cos_d;
    double tan2_h, geometry; /* geometry: 1 / (cos^4 theta_h cos theta_i cos theta_o) */
    double schlick;          /* (1 - cos theta_d)^5 */
} sgd_angles;

INLINED sgd_angles sgd_angles_of(const double *in, const double *out) {
    const half_angles h = half_angles_of(in, out);
    double sec2_h = 1 + h.tan2_h, m = 1 - h.cos_d;
    return (sgd_angles){.cos_i = in[2],
                        .cos_o = out[2],
                        .theta_i = acos(fmin(1, in[2])),
                        .theta_o = acos(fmin(1, out[2])),
                        .cos_d = h.cos_d,
                        .tan2_h = h.tan2_h,
                        .geometry = sec2_h * sec2_h / (in[2] * out[2]),
                        .schlick = m * m * m * m * m};
}

/* f of channel c. row: NULL, or receives the derivatives. */
INLINED double sgd_value(const sgd *self, const sgd_angles *a, size_t c, double *row) {
    shadow in = shadow_at(&self->g[c], a->cos_i, a->theta_i, row != NULL);
    shadow out = shadow_at(&self->g[c], a->cos_o, a->theta_o, row != NULL);
    double t = self->v[ALPHA][c] + a->tan2_h * self->inverse_alpha[c], log_t = log(t);
    double g = in.g * out.g;
    double fresnel = self->v[F0][c] - self->v[F1][c] * a->cos_d + (1 - self->v[F0][c]) * a->schlick;
    double d = exp(-t - self->v[P][c] * log_t);
    double facets = self->specular[c] * d * a->geometry, specular = facets * g * fresnel;
    if (row) {
        double tan2_over_alpha2 = a->tan2_h * self->inverse_alpha[c] * self->inverse_alpha[c];
        double by_g = facets * fresnel, by_fresnel = facets * g;
        row[3 * KD + c] = 1 / NQM_PI;
        row[3 * KS + c] = self->per_ks[c] * d * a->geometry * g * fresnel;
        row[3 * ALPHA + c] = -specular * (1 + self->v[P][c] / t) * (1 - tan2_over_alpha2);
        row[3 * P + c] = -specular * log_t;
        row[3 * F0 + c] = by_fresnel * (1 - a->schlick);
        row[3 * F1 + c] = -by_fresnel * a->cos_d;
        row[3 * K_NORM + c] = self->per_k_norm[c] * d * a->geometry * g * fresnel;
        row[3 * LAMBDA + c] = by_g * (in.by_lambda * out.g + in.g * out.by_lambda);
        row[3 * C + c] = by_g * (in.by_c * out.g + in.g * out.by_c);
        row[3 * K_POWER + c] = by_g * (in.by_k * out.g + in.g * out.by_k);
        row[3 * THETA0 + c] = by_g * (in.by_theta0 * out.g + in.g * out.by_theta0);
    }
    return self->diffuse[c] + specular;
}

/* jacobian: NULL, or receives the derivatives. */
INLINED void sgd_values(const sgd *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian) {
    for (size_t i = 0; i < n; ++i) {
        const sgd_angles angles = sgd_angles_of(wi + 3 * i, wo + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = sgd_value(self, &angles, c, jacobian ? jacobian + (3 * i + c) * 3 * N_KEYS : NULL);
    }
}

NQM_EVAL_AND_JACOBIAN(sgd, sgd_values, state)

const nqm_analytic_model nqm_sgd_model = {
    .schema = &(
        const nqm_schema){.model = "sgd",
                          .n_keys = N_KEYS,
                          .keys = {[KD] = {.name = "kd", .n = 3, .low = 0, .high = 10, .required = true},
                                   [KS] = {.name = "ks", .n = 3, .low = 0, .high = 1e6, .required = true},
                                   [ALPHA] = {.name = "alpha", .n = 3, .low = 1e-6, .high = 10, .required = true},
                                   [P] = {.name = "p", .n = 3, .low = 0, .high = 10, .required = true},
                                   [F0] = {.name = "f0", .n = 3, .low = 0, .high = 100, .required = true},
                                   [F1] = {.name = "f1", .n = 3, .low = -100, .high = 100, .required = true},
                                   [K_NORM] = {.name = "K", .n = 3, .low = 0, .high = 1e9, .required = true},
                                   [LAMBDA] = {.name = "lambda", .n = 3, .low = 1e-12, .high = 1e12, .required = true},
                                   [C] = {.name = "c", .n = 3, .low = 1e-300, .high = 1e300, .required = true},
                                   [K_POWER] = {.name = "k", .n = 3, .low = 0.1, .high = 1e4, .required = true},
                                   [THETA0] = {.name = "theta0", .n = 3, .low = -4, .high = 4, .required = true}}},
    .doi = "10.1111/j.1467-8659.2012.03147.x",
    .class_ = {.format = "sgd", .reciprocal = 1, .eval = sgd_eval, .jacobian = sgd_jacobian, .free = nqm_free},
    .state_size = sizeof(sgd),
    .prepare = sgd_prepare,
};
