/* SPDX-License-Identifier: MIT
 *
 * The evaluation of a distorted copy: first the place is changed where the base is read (shift, gloss, smooth), then the
 * value (the other settings, in the order of the keys in perturb.c). doc/brdf.md defines each setting.
 */
#include "brdf/perturb.h"
#include "math/math.h"

#include <math.h>

enum { MAX_ROWS = 9 * (NQM_SMOOTH_TAPS + 1) /* evaluations of the base in one call */ };

/* ---- where the base is read -------------------------------------------------------------------------------------- */

/* The theta_h at which light or viewer sinks to the horizon, for given theta_d and phi_d. */
static double largest_theta_h(const double *hd) {
    return atan2(cos(hd[1]), sin(hd[1]) * fabs(cos(hd[2])));
}

/* `shift` moves the lobe to a ring. `gloss` multiplies theta_h near 0 and leaves 0 and the horizon in place:
 * u -> g u / (1 + (g - 1) u) with u = theta_h over its largest value. */
static double warp(const nqm_perturbation *self, double theta_h, double largest) {
    double t = theta_h;
    if (self->shift_rad != 0) /* not nearer to the horizon than the pair itself, or 5 % of the way */
        t = fmin(fabs(theta_h - self->shift_rad), fmax(theta_h, 0.95 * largest));
    if (self->gloss != 1) {
        double u = t / largest;
        t = largest * self->gloss * u / (1 + (self->gloss - 1) * u);
    }
    return t;
}

/* exp(-|x|) I0(x), the modified Bessel function (Abramowitz and Stegun 1964, 9.8.1, 9.8.2; relative error < 2e-7). */
static double scaled_bessel_i0(double x) {
    if (x < 3.75) {
        double t = x / 3.75 * (x / 3.75);
        double i0 =
            1 + t * (3.5156229 + t * (3.0899424 + t * (1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813)))));
        return exp(-x) * i0;
    }
    double t = 3.75 / x;
    double s =
        0.39894228 +
        t * (0.01328592 +
             t * (0.00225319 +
                  t * (-0.00157565 +
                       t * (0.00916281 + t * (-0.02057706 + t * (0.02635537 + t * (-0.01647633 + t * 0.00392377)))))));
    return s / sqrt(x);
}

/* The places and weights over which `smooth` averages: a Gaussian over the plane of half vectors, whose integral over
 * the azimuth is Rice's density r / sigma^2 exp(-(r^2 + c^2) / 2 sigma^2) I0(r c / sigma^2) for the distance r from the
 * normal. The taps lie denser toward r = 0, where a sharp lobe is. */
static void smooth_taps(double centre, double sigma, double largest, double *theta_h, double *weight) {
    double from = fmax(0, centre - 4 * sigma), to = fmin(centre + 4 * sigma, largest), sum = 0;
    for (int k = 0; k < NQM_SMOOTH_TAPS; ++k) {
        double u = (k + 0.5) / NQM_SMOOTH_TAPS;
        double r = from + (to - from) * u * u, z = (r - centre) / sigma;
        theta_h[k] = r;
        weight[k] = u * r * exp(-0.5 * z * z) * scaled_bessel_i0(r * centre / (sigma * sigma));
        sum += weight[k];
    }
    for (int k = 0; k < NQM_SMOOTH_TAPS; ++k)
        weight[k] /= sum;
}

/* The rows of the base that the value at hd needs. rows: (n_rows, 3); weight: (n_taps). */
static void place_rows(const nqm_perturbation *self, const double *hd, double *rows, double *weight) {
    double theta_h[NQM_SMOOTH_TAPS + 1];
    bool moves = self->n_rows > 1 || self->shift_rad != 0 || self->gloss != 1;
    double largest = moves ? largest_theta_h(hd) : 0;
    if (self->n_taps > 1) {
        smooth_taps(hd[0], self->smooth_rad, largest, theta_h, weight);
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

/* The mean over the valid taps; false when there is none. */
static bool average_taps(size_t n, const double *weight, const double *rgb, const uint8_t *flag, double *mean) {
    double sum = 0;
    mean[0] = mean[1] = mean[2] = 0;
    for (size_t k = 0; k < n; ++k) {
        if (flag[k] >= NQM_VALUE_INVALID)
            continue;
        sum += weight[k];
        for (size_t c = 0; c < 3; ++c)
            mean[c] += weight[k] * rgb[3 * k + c];
    }
    for (size_t c = 0; c < 3 && sum > 0; ++c)
        mean[c] /= sum;
    return sum > 0;
}

/* ---- what is done to the value ----------------------------------------------------------------------------------- */

/* Value noise of unit variance at hd, one field a channel. The third coordinate vanishes where phi_d has no meaning (at
 * theta_h = 0 and theta_d = 0), so that the field is continuous over pairs. */
static void noise_at(const nqm_perturbation *self, const double *hd, double z[3]) {
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
        z[c] /= sqrt(sum_squares); /* interpolation between nodes would flatten the field */
}

/* A rotation about the grey axis: a circulant matrix, whose rows sum to 1. */
static void turn_hue(const double *row, double *rgb) {
    const double r = rgb[0], g = rgb[1], b = rgb[2];
    rgb[0] = fmax(0, row[0] * r + row[1] * g + row[2] * b);
    rgb[1] = fmax(0, row[2] * r + row[0] * g + row[1] * b);
    rgb[2] = fmax(0, row[1] * r + row[2] * g + row[0] * b);
}

/* rgb: the averaged base, changed in place; off: the base off the highlight, or NULL where it has no value. */
static void distort_value(const nqm_perturbation *self, const double *hd, const double *off, double *rgb) {
    double m = 1 - cos(hd[1]), grazing = 1 + (self->fresnel - 1) * (m * m * m * m * m);
    for (size_t c = 0; c < 3; ++c) {
        rgb[c] = fmin(rgb[c], self->ceiling);
        if (off)
            rgb[c] += (self->peak - 1) * fmax(0, rgb[c] - fmin(off[c], self->ceiling));
        rgb[c] *= grazing;
        rgb[c] += self->mix * (self->lambert[c] - rgb[c]);
    }
    double grey = nqm_luminance(rgb);
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = fmax(0, rgb[c] + self->desaturate * (grey - rgb[c]));
    if (self->hue[0] != 1)
        turn_hue(self->hue, rgb);
    double z[3] = {0, 0, 0}, wave = 1;
    if (self->lattice)
        noise_at(self, hd, z);
    if (self->ripple > 0)
        wave += self->ripple * sin(2 * NQM_PI * self->bands * sqrt(hd[0] / (0.5 * NQM_PI)));
    for (size_t c = 0; c < 3; ++c) {
        rgb[c] *= self->colour[c] * wave;
        if (self->lattice)
            rgb[c] *= exp(self->sigma * z[c]);
        if (self->quantise > 0 && rgb[c] > 0)
            rgb[c] = pow(10, nearbyint(log10(rgb[c]) * self->quantise) / self->quantise);
    }
}

void nqm_perturbation_eval(const void *perturbation, size_t n, const double *hd, double *rgb) {
    const nqm_perturbation *self = perturbation;
    double rows[3 * MAX_ROWS], values[3 * MAX_ROWS], weight[MAX_ROWS];
    uint8_t flag[MAX_ROWS];
    size_t n_rows = self->n_rows, n_block = MAX_ROWS / n_rows;
    for (size_t first = 0; first < n; first += n_block) {
        size_t m = n - first < n_block ? n - first : n_block;
        for (size_t i = 0; i < m; ++i)
            place_rows(self, hd + 3 * (first + i), rows + 3 * n_rows * i, weight + n_rows * i);
        nqm_brdf_eval_half_diff(self->base, m * n_rows, rows, values, flag);
        for (size_t i = 0; i < m; ++i) {
            double *out = rgb + 3 * (first + i);
            size_t row = n_rows * i, off = row + self->n_taps;
            bool has_off = n_rows > self->n_taps && flag[off] < NQM_VALUE_INVALID;
            if (average_taps(self->n_taps, weight + row, values + 3 * row, flag + row, out))
                distort_value(self, hd + 3 * (first + i), has_off ? values + 3 * off : NULL, out);
            else
                out[0] = NAN;
        }
    }
}
