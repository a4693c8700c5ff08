/* SPDX-License-Identifier: MIT
 *
 * The shifted gamma distribution BRDF of Bagher, Soler and Holzschuch (2012, DOI 10.1111/j.1467-8659.2012.03147.x):
 *
 *     f = kd / pi + ks / pi  D(theta_h) F(theta_d) G(theta_i) G(theta_o) / (cos theta_i cos theta_o)
 *     D = K exp(-t) / (pi t^p cos^4 theta_h),  t = alpha + tan^2 theta_h / alpha
 *     F = f0 - f1 cos theta_d + (1 - f0) (1 - cos theta_d)^5
 *     G = 1 + lambda (1 - exp(c (theta - theta0)^k)) above theta0, kept within [0, 1]; 1 below
 *
 * Every parameter has one value per channel. F may be negative where the authors' fit is.
 */
#include "brdf/spec.h"
#include "math/math.h"

#include <math.h>

enum { KD, KS, ALPHA, P, F0, F1, K_NORM, LAMBDA, C, K_POWER, THETA0, N_KEYS };

/* The shadowing of one channel. It is exactly 1 or 0 outside a band of angles; transcendental functions are evaluated
 * only inside the band. */
typedef struct shadowing {
    double cos_one;  /* G rounds to 1 at and above this cosine */
    double cos_zero; /* G is 0 at and below this cosine */
    double theta0, lambda, log_c, k;
} shadowing;

typedef struct sgd {
    double diffuse[3];  /* kd / pi */
    double specular[3]; /* ks K / pi^2 */
    double alpha[3], inverse_alpha[3], p[3], f0[3], f1[3];
    shadowing g[3];
} sgd;

static double cosine_at(double theta) {
    return theta < NQM_PI ? cos(fmax(theta, 0)) : -1;
}

/* Find the limits of the band: 1 - G = lambda (exp(y) - 1) with y = c x^k is below the rounding error of 1 up to y_one,
 * and reaches 1 at y_zero. */
static shadowing make_shadowing(const nqm_spec_values *values, int channel) {
    shadowing g = {.theta0 = values->v[THETA0][channel],
                   .lambda = values->v[LAMBDA][channel],
                   .log_c = log(values->v[C][channel]),
                   .k = values->v[K_POWER][channel]};
    double y_one = 1e-17 / g.lambda, y_zero = log1p(1 / g.lambda);
    g.cos_one = cosine_at(g.theta0 + exp((log(y_one) - g.log_c) / g.k));
    g.cos_zero = cosine_at(g.theta0 + exp((log(y_zero) - g.log_c) / g.k));
    return g;
}

static double shadow(const shadowing *g, double cosine, double theta) {
    if (cosine >= g->cos_one)
        return 1;
    if (cosine <= g->cos_zero)
        return 0;
    double x = theta - g->theta0;
    return x > 0 ? fmax(0, 1 - g->lambda * expm1(exp(g->log_c + g->k * log(x)))) : 1;
}

static void sgd_prepare(const nqm_spec_values *values, void *state) {
    sgd *self = state;
    for (int c = 0; c < 3; ++c) {
        self->diffuse[c] = values->v[KD][c] / NQM_PI;
        self->specular[c] = values->v[KS][c] * values->v[K_NORM][c] / (NQM_PI * NQM_PI);
        self->alpha[c] = values->v[ALPHA][c];
        self->inverse_alpha[c] = 1 / values->v[ALPHA][c];
        self->p[c] = values->v[P][c];
        self->f0[c] = values->v[F0][c];
        self->f1[c] = values->v[F1][c];
        self->g[c] = make_shadowing(values, c);
    }
}

static void sgd_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const sgd *self = state;
    for (size_t i = 0; i < n; ++i) {
        const double *in = wi + 3 * i, *out = wo + 3 * i;
        double x = in[0] + out[0], y = in[1] + out[1], z = in[2] + out[2];
        double xy = x * x + y * y;
        double tan2_h = xy / (z * z), sec2_h = 1 + tan2_h;
        double cos_d = fmin(1, 0.5 * sqrt(xy + z * z)); /* |wi + wo| = 2 cos theta_d */
        double m = 1 - cos_d;
        double schlick = m * m * m * m * m;
        double geometry = sec2_h * sec2_h / (in[2] * out[2]);
        double theta_i = acos(fmin(1, in[2])), theta_o = acos(fmin(1, out[2]));
        for (size_t c = 0; c < 3; ++c) {
            double t = self->alpha[c] + tan2_h * self->inverse_alpha[c];
            double g = shadow(&self->g[c], in[2], theta_i) * shadow(&self->g[c], out[2], theta_o);
            double fresnel = self->f0[c] - self->f1[c] * cos_d + (1 - self->f0[c]) * schlick;
            double d = exp(-t - self->p[c] * log(t));
            rgb[3 * i + c] = self->diffuse[c] + self->specular[c] * d * geometry * g * fresnel;
        }
    }
}

const nqm_analytic_model nqm_sgd_model = {
    .schema = {"sgd",
               N_KEYS,
               {[KD] = {.name = "kd", .n = 3, .low = 0, .high = 10, .required = true},
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
    .class_ = {.format = "sgd", .reciprocal = 1, .eval = sgd_eval, .free = nqm_free},
    .state_size = sizeof(sgd),
    .prepare = sgd_prepare,
};
