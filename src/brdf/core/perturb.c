/* SPDX-License-Identifier: MIT
 *
 * Distorted copies of any BRDF; doc/brdf.md defines each setting. All work is done in half-vector coordinates at the azimuth phi_h of
 * the pair. shift, gloss and smooth change the coordinates at which the base is evaluated; the other settings then change the value,
 * in the order of the keys below.
 */
#include "brdf/core/spec.h"

#include <math.h>

enum { SHIFT, GLOSS, SMOOTH, FIRST_VALUE_KEY };
enum { CLAMP = FIRST_VALUE_KEY, PEAK, FRESNEL, MIX, DESATURATE, HUE, TINT, SCALE, LOPSIDED, RIPPLE };
enum { BANDS = RIPPLE + 1, NOISE, SEED, CELLS };
enum { QUANTISE = CELLS + 1, BITS, HALF, N_KEYS };

enum { SMOOTH_TAPS = 27 };

/** One distortion with its constants. */
typedef struct perturbation {
    nqm_between_bases bases;
    double v[N_KEYS];  /* settings (their first values); `shift` and `smooth` in radians */
    double ceiling;    /* upper limit of every channel of the base; HUGE_VAL: off */
    double hue[3];     /* first row of the circulant matrix that rotates colours about the grey axis; 1,0,0: off */
    double colour[3];  /* tint * scale */
    double lambert[3]; /* f_r of the Lambert BRDF that `mix` mixes in */
    size_t n_cells;    /* cells of the noise; 0: no noise */
    float *lattice;    /* (n_cells + 1, n_cells + 1, n_cells + 1, 3) standard normal draws, in the same block */
    size_t n_taps;     /* evaluations of the base that are averaged: 1, or SMOOTH_TAPS */
    size_t n_rows;     /* n_taps, and one off the highlight when `peak` is not 1 */
} perturbation;

enum { MAX_ROWS = 9 * (SMOOTH_TAPS + 1) /* evaluations of the base in one call */ };

/* ---- coordinates ------------------------------------------------------------------------------------------------- */

/* The theta_h at which light or viewer reaches the horizon, for given theta_d and phi_d. */
static double largest_theta_h(const double *hd) {
    return atan2(cos(hd[1]), sin(hd[1]) * fabs(cos(hd[2])));
}

/* `shift` moves the lobe to a ring. `gloss` multiplies theta_h near 0 and keeps 0 and the horizon fixed:
 * u -> g u / (1 + (g - 1) u) with u = theta_h over its largest value. */
static double warp(const perturbation *self, double theta_h, double largest) {
    double t = theta_h;
    if (self->v[SHIFT] != 0) /* at most the pair's own theta_h, or 95 % of the largest */
        t = fmin(fabs(theta_h - self->v[SHIFT]), fmax(theta_h, 0.95 * largest));
    if (self->v[GLOSS] != 1) {
        double u = t / largest;
        t = largest * self->v[GLOSS] * u / (1 + (self->v[GLOSS] - 1) * u);
    }
    return t;
}

static double polynomial(size_t n, const double *coefficients, double x) {
    double sum = 0;
    while (n-- > 0)
        sum = coefficients[n] + x * sum;
    return sum;
}

/* exp(-|x|) I0(x), the modified Bessel function (Abramowitz and Stegun 1964, 9.8.1, 9.8.2; relative error < 2e-7). */
static double scaled_bessel_i0(double x) {
    static const double small[] = {1, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813};
    static const double large[] = {0.39894228,  0.01328592, 0.00225319,  -0.00157565, 0.00916281,
                                   -0.02057706, 0.02635537, -0.01647633, 0.00392377};
    if (x < 3.75)
        return exp(-x) * polynomial(7, small, x / 3.75 * (x / 3.75));
    return polynomial(9, large, 3.75 / x) / sqrt(x);
}

/* Values of theta_h and their weights in the average of `smooth`: a Gaussian over the plane of half vectors. Its
 * integral over the azimuth is Rice's density r / sigma^2 exp(-(r^2 + c^2) / 2 sigma^2) I0(r c / sigma^2) for the
 * distance r from the normal. The taps are denser toward r = 0, where a sharp lobe is. */
static void smooth_taps(double centre, double sigma, double largest, double *theta_h, double *weight) {
    double from = fmax(0, centre - 4 * sigma), to = fmin(centre + 4 * sigma, largest), sum = 0;
    for (int k = 0; k < SMOOTH_TAPS; ++k) {
        double u = (k + 0.5) / SMOOTH_TAPS;
        double r = from + (to - from) * u * u, z = (r - centre) / sigma;
        theta_h[k] = r;
        weight[k] = u * r * exp(-0.5 * z * z) * scaled_bessel_i0(r * centre / (sigma * sigma));
        sum += weight[k];
    }
    for (int k = 0; k < SMOOTH_TAPS; ++k)
        weight[k] /= sum;
}

/* Coordinates at which the base is evaluated for the value at hd. rows: (n_rows, 3); weight: (n_taps). */
static void place_rows(const perturbation *self, const double *hd, double *rows, double *weight) {
    double theta_h[SMOOTH_TAPS + 1];
    bool moves = self->n_rows > 1 || self->v[SHIFT] != 0 || self->v[GLOSS] != 1;
    double largest = moves ? largest_theta_h(hd) : 0;
    if (self->n_taps > 1) {
        smooth_taps(hd[0], self->v[SMOOTH], largest, theta_h, weight);
    } else {
        theta_h[0] = hd[0];
        weight[0] = 1;
    }
    for (size_t k = 0; k < self->n_taps; ++k)
        theta_h[k] = warp(self, theta_h[k], largest);
    theta_h[self->n_taps] = 0.7 * largest; /* off the highlight */
    for (size_t k = 0; k < self->n_rows; ++k) {
        /* NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Assign): n_rows is at most n_taps + 1 */
        rows[3 * k] = theta_h[k];
        rows[3 * k + 1] = hd[1];
        rows[3 * k + 2] = hd[2];
    }
}

/* Weighted mean over the taps that have a value; false when there is none. */
static bool average_taps(size_t n, const double *weight, const double *rgb, const uint8_t *flag, double *mean) {
    double sum = 0;
    mean[0] = mean[1] = mean[2] = 0;
    for (size_t k = 0; k < n; ++k) {
        if (!nqm_has_value(flag[k]))
            continue;
        sum += weight[k];
        for (size_t c = 0; c < 3; ++c)
            mean[c] += weight[k] * rgb[3 * k + c];
    }
    for (size_t c = 0; c < 3 && sum > 0; ++c)
        mean[c] /= sum;
    return sum > 0;
}

/* ---- value ------------------------------------------------------------------------------------------------------- */

/* Value noise of unit variance at hd, one field per channel. The third coordinate is 0 where phi_d is undefined
 * (theta_h = 0 or theta_d = 0), so that the field is continuous over pairs. */
static void noise_at(const perturbation *self, const double *hd, double z[3]) {
    double place[3] = {sqrt(hd[0] / (0.5 * NQM_PI)), hd[1] / (0.5 * NQM_PI),
                       fabs(cos(hd[2])) * sqrt(sin(hd[0]) * sin(hd[1]))};
    size_t cell[3];
    double part[3];
    for (int a = 0; a < 3; ++a) {
        double x = fmin(fmax(place[a], 0), 1) * (double)self->n_cells;
        cell[a] = x < (double)self->n_cells ? (size_t)x : self->n_cells - 1;
        part[a] = x - (double)cell[a];
    }
    double sum_squares = 0;
    z[0] = z[1] = z[2] = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        size_t node = 0;
        double w = 1;
        for (unsigned a = 0; a < 3; ++a) {
            unsigned upper = corner >> a & 1;
            node = node * (self->n_cells + 1) + cell[a] + upper;
            w *= upper ? part[a] : 1 - part[a];
        }
        sum_squares += w * w;
        for (size_t c = 0; c < 3; ++c)
            z[c] += w * (double)self->lattice[3 * node + c];
    }
    for (size_t c = 0; c < 3; ++c)
        z[c] /= sqrt(sum_squares); /* restores the unit variance that interpolation reduces */
}

/* A rotation about the grey axis: a circulant matrix, whose rows sum to 1. */
static void turn_hue(const double *row, double *rgb) {
    const double r = rgb[0], g = rgb[1], b = rgb[2];
    rgb[0] = fmax(0, row[0] * r + row[1] * g + row[2] * b);
    rgb[1] = fmax(0, row[2] * r + row[0] * g + row[1] * b);
    rgb[2] = fmax(0, row[1] * r + row[2] * g + row[0] * b);
}

/* Round x >= 0 to `bits` significant bits, and to a multiple of 2^least. */
static double round_bits(double x, int bits, int least) {
    int exponent;
    (void)frexp(x, &exponent);
    int unit = exponent - bits > least ? exponent - bits : least;
    return ldexp(nearbyint(ldexp(x, -unit)), unit);
}

/* IEEE 754 binary16: 11 significant bits, multiples of 2^-24, at most 65504. */
static double round_half(double x) {
    return fmin(round_bits(x, 11, -24), 65504);
}

/* Apply the settings that change the value. rgb: the averaged base, changed in place; off: the base off the highlight,
 * or NULL when there is no such value. */
static void distort_value(const perturbation *self, const double *hd, const double *off, double *rgb) {
    double m = 1 - cos(hd[1]), grazing = 1 + (self->v[FRESNEL] - 1) * (m * m * m * m * m);
    for (size_t c = 0; c < 3; ++c) {
        rgb[c] = fmin(rgb[c], self->ceiling);
        if (off)
            rgb[c] += (self->v[PEAK] - 1) * fmax(0, rgb[c] - fmin(off[c], self->ceiling));
        rgb[c] *= grazing;
        rgb[c] += self->v[MIX] * (self->lambert[c] - rgb[c]);
    }
    double grey = nqm_luminance(rgb);
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = fmax(0, rgb[c] + self->v[DESATURATE] * (grey - rgb[c]));
    if (self->hue[0] != 1)
        turn_hue(self->hue, rgb);
    double z[3] = {0, 0, 0}, wave = 1;
    if (self->v[LOPSIDED] != 0)
        wave = exp(self->v[LOPSIDED] * sin(hd[2]));
    if (self->n_cells)
        noise_at(self, hd, z);
    if (self->v[RIPPLE] > 0)
        wave *= 1 + self->v[RIPPLE] * sin(2 * NQM_PI * self->v[BANDS] * sqrt(hd[0] / (0.5 * NQM_PI)));
    for (size_t c = 0; c < 3; ++c) {
        rgb[c] *= self->colour[c] * wave;
        if (self->n_cells)
            rgb[c] *= exp(self->v[NOISE] * z[c]);
        if (self->v[QUANTISE] > 0 && rgb[c] > 0)
            rgb[c] = pow(10, nearbyint(log10(rgb[c]) * self->v[QUANTISE]) / self->v[QUANTISE]);
        if (self->v[BITS] < 53)
            rgb[c] = round_bits(rgb[c], (int)self->v[BITS], -1022);
        if (self->v[HALF] > 0)
            rgb[c] = round_half(rgb[c]);
    }
}

static void perturb_eval(const void *state, size_t n, const double *hd, const double *turn, double *rgb) {
    const perturbation *self = state;
    double rows[3 * MAX_ROWS], turns[2 * MAX_ROWS], values[3 * MAX_ROWS], weight[MAX_ROWS];
    uint8_t flag[MAX_ROWS];
    size_t n_rows = self->n_rows, n_block = MAX_ROWS / n_rows;
    for (size_t first = 0; first < n; first += n_block) {
        size_t m = n - first < n_block ? n - first : n_block;
        for (size_t i = 0; i < m; ++i)
            place_rows(self, hd + 3 * (first + i), rows + 3 * n_rows * i, weight + n_rows * i);
        for (size_t k = 0; k < 2 * m * n_rows && turn; ++k)
            turns[k] = turn[2 * (first + k / (2 * n_rows)) + k % 2];
        nqm_brdf_eval_turned(self->bases.of, m * n_rows, rows, turn ? turns : NULL, values, flag);
        for (size_t i = 0; i < m; ++i) {
            double *out = rgb + 3 * (first + i);
            size_t row = n_rows * i, off = row + self->n_taps;
            bool has_off = n_rows > self->n_taps && nqm_has_value(flag[off]);
            if (average_taps(self->n_taps, weight + row, values + 3 * row, flag + row, out))
                distort_value(self, hd + 3 * (first + i), has_off ? values + 3 * off : NULL, out);
            else
                out[0] = NAN;
        }
    }
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Reference value of `clamp`: the largest channel of the base in the mirror direction for theta_d = 0 to 60 degrees. */
static double mirror_maximum(const nqm_brdf *base) {
    enum { N = 13 };
    double hd[3 * N] = {0}, rgb[3 * N], largest = 0;
    uint8_t flag[N];
    for (size_t i = 0; i < N; ++i)
        hd[3 * i + 1] = 5 * (double)i * NQM_PI / 180;
    nqm_brdf_eval_half_diff(base, N, hd, rgb, flag); /* 0 where there is no value */
    for (size_t i = 0; i < 3 * N; ++i)
        largest = fmax(largest, rgb[i]);
    return largest;
}

/* First row of the rotation by `angle` about (1, 1, 1). */
static void hue_row(double angle, double row[3]) {
    double c = cos(angle), s = sin(angle) / sqrt(3);
    row[0] = c + (1 - c) / 3;
    row[1] = (1 - c) / 3 - s;
    row[2] = (1 - c) / 3 + s;
}

static nqm_status create(const nqm_values *values, const nqm_between_bases *bases, nqm_brdf_info *info, void **self_ret,
                         nqm_error *err) {
    const double degree = NQM_PI / 180;
    const size_t n_cells = values->v[NOISE][0] > 0 ? (size_t)values->v[CELLS][0] : 0;
    const size_t n_lattice = n_cells ? 3 * (n_cells + 1) * (n_cells + 1) * (n_cells + 1) : 0;
    float *lattice;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({self_ret, 1, sizeof(perturbation)}, {&lattice, n_lattice, sizeof *lattice}), err);
    if (status != NQM_OK)
        return status;
    perturbation *self = *self_ret;
    info->reciprocal = info->reciprocal && values->v[LOPSIDED][0] == 0;
    for (size_t k = 0; k < N_KEYS; ++k)
        self->v[k] = values->v[k][0];
    self->v[SHIFT] *= degree;
    self->v[SMOOTH] *= degree;
    self->n_taps = self->v[SMOOTH] > 0 ? SMOOTH_TAPS : 1;
    self->n_rows = self->n_taps + (self->v[PEAK] != 1);
    double largest = self->v[CLAMP] > 0 ? mirror_maximum(bases->of) : 0;
    self->ceiling = largest > 0 ? self->v[CLAMP] * largest : HUGE_VAL;
    hue_row(self->v[HUE] * degree, self->hue);
    if (self->v[MIX] > 0) /* 45 degrees halves the hemisphere's projected solid angle */
        nqm_brdf_albedo(bases->of, NQM_PI / 4, 1, self->lambert);
    for (size_t c = 0; c < 3; ++c) {
        self->lambert[c] /= NQM_PI;
        self->colour[c] = values->v[TINT][c] * self->v[SCALE];
    }
    self->n_cells = n_cells;
    self->lattice = lattice;
    nqm_rng rng = nqm_rng_make((uint64_t)self->v[SEED], 0);
    for (size_t i = 0; i < n_lattice; ++i)
        lattice[i] = (float)nqm_rng_normal(&rng);
    return NQM_OK;
}

const nqm_spec_wrapper nqm_perturb_wrapper = {
    .schema = {"perturb",
               N_KEYS,
               {[SHIFT] = {.name = "shift", .n = 1, .low = -45, .high = 45, .fallback = 0},
                [GLOSS] = {.name = "gloss", .n = 1, .low = 0.05, .high = 20, .fallback = 1},
                [SMOOTH] = {.name = "smooth", .n = 1, .low = 0.01, .high = 30, .fallback = 0},
                [CLAMP] = {.name = "clamp", .n = 1, .low = 0, .high = 1, .fallback = 0},
                [PEAK] = {.name = "peak", .n = 1, .low = 0, .high = 100, .fallback = 1},
                [FRESNEL] = {.name = "fresnel", .n = 1, .low = 0, .high = 100, .fallback = 1},
                [MIX] = {.name = "mix", .n = 1, .low = 0, .high = 1, .fallback = 0},
                [DESATURATE] = {.name = "desaturate", .n = 1, .low = -1, .high = 1, .fallback = 0},
                [HUE] = {.name = "hue", .n = 1, .low = -180, .high = 180, .fallback = 0},
                [TINT] = {.name = "tint", .n = 3, .low = 0, .high = 100, .fallback = 1},
                [SCALE] = {.name = "scale", .n = 1, .low = 0, .high = 1000, .fallback = 1},
                [LOPSIDED] = {.name = "lopsided", .n = 1, .low = -2, .high = 2, .fallback = 0},
                [RIPPLE] = {.name = "ripple", .n = 1, .low = 0, .high = 1, .fallback = 0},
                [BANDS] = {.name = "bands", .n = 1, .low = 1, .high = 1000, .fallback = 12},
                [NOISE] = {.name = "noise", .n = 1, .low = 0, .high = 5, .fallback = 0},
                [SEED] = {.name = "seed", .n = 1, .low = 0, .high = 9007199254740992.0, .whole = true, .fallback = 1},
                [CELLS] = {.name = "cells", .n = 1, .low = 1, .high = 64, .whole = true, .fallback = 16},
                [QUANTISE] = {.name = "quantise", .n = 1, .low = 0, .high = 1000, .fallback = 0},
                [BITS] = {.name = "bits", .n = 1, .low = 1, .high = 53, .whole = true, .fallback = 53},
                [HALF] = {.name = "half", .n = 1, .low = 0, .high = 1, .whole = true, .fallback = 0}}},
    .idle = UINT64_C(1) << BANDS | UINT64_C(1) << SEED | UINT64_C(1) << CELLS,
    .form = "perturb: 'of=' and a BRDF are missing at the end (perturb:scale=2;of=BRDF)",
    .class_ = {.format = "perturb", .anisotropic = true, .eval_turned = perturb_eval, .free = nqm_wrapper_free},
    .create = create,
};
