/* SPDX-License-Identifier: MIT
 *
 * Reflectance spectra to linear RGB with BT.709 primaries, as they look under an illuminant after adaptation to its white:
 * a spectrum that is 1 everywhere becomes (1, 1, 1).
 *
 * Colour matching functions: the multi-lobe fits of the CIE 1931 2-degree observer by Wyman, Sloan and Shirley 2013 (Journal
 * of Computer Graphics Techniques 2(2)). D65: the table of CIE 15 at 10 nm, linear in between, as CIE defines its values in
 * steps of 5 nm. Adaptation: von Kries in the cone space of Bradford (Lam 1985).
 */
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { FIRST_NM = 380, LAST_NM = 780 };

/* scale exp(-(steepness (x - centre))^2 / 2), with a steepness on each side of the centre. */
typedef struct lobe {
    int axis; /* X, Y or Z */
    double scale, centre, below, above;
} lobe;

static const lobe lobes[] = {{0, 0.362, 442.0, 0.0624, 0.0374},  {0, 1.056, 599.8, 0.0264, 0.0323},
                             {0, -0.065, 501.1, 0.0490, 0.0382}, {1, 0.821, 568.8, 0.0213, 0.0247},
                             {1, 0.286, 530.9, 0.0613, 0.0322},  {2, 1.217, 437.0, 0.0845, 0.0278},
                             {2, 0.681, 459.0, 0.0385, 0.0725}};

static void match_colour(double nm, double *xyz) {
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (size_t i = 0; i < sizeof lobes / sizeof *lobes; ++i) {
        const lobe *l = lobes + i;
        double t = (nm - l->centre) * (nm < l->centre ? l->below : l->above);
        xyz[l->axis] += l->scale * exp(-0.5 * t * t);
    }
}

/* From FIRST_NM in steps of 10 nm. */
static const double d65[] = {49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812,
                             114.861, 115.923, 108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046,
                             100.000, 96.3342, 95.7880, 88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992,
                             80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.3490, 61.6040, 69.8856,
                             75.0870, 63.5927, 46.4182, 66.8054, 63.3828};

static double emitted(nqm_illuminant illuminant, int nm) {
    const int at = (nm - FIRST_NM) / 10, rest = (nm - FIRST_NM) % 10;
    if (illuminant == NQM_ILLUMINANT_E)
        return 1;
    return rest ? d65[at] + 0.1 * rest * (d65[at + 1] - d65[at]) : d65[at];
}

static const double cone_from_xyz[3][3] = {
    {0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};
/* From cone responses relative to the white: xyz_to_rgb cone_from_xyz^-1 diag(cone_from_xyz w), w the white of BT.709, x =
 * 0.3127, y = 0.3290. The rows sum to 1. */
static const double rgb_from_cone[3][3] = {{2.3896420707, -1.3457863245, -0.0438557462},
                                           {-0.1374417039, 1.1617745788, -0.0243328749},
                                           {-0.0398093965, -0.0744849134, 1.1142943099}};

static void multiply(const double m[3][3], const double *v, double *out) {
    for (size_t i = 0; i < 3; ++i)
        out[i] = nqm_dot3(m[i], v);
}

bool nqm_illuminant_find(const char *name, nqm_illuminant *illuminant_ret) {
    const bool is_e = strcmp(name, "E") == 0, is_d65 = strcmp(name, "D65") == 0;
    *illuminant_ret = is_d65 ? NQM_ILLUMINANT_D65 : NQM_ILLUMINANT_E;
    return is_e || is_d65;
}

const char *nqm_illuminant_name(nqm_illuminant illuminant) {
    return illuminant == NQM_ILLUMINANT_E ? "E" : "D65";
}

bool nqm_spectrum_is_visible(size_t n, const float *nm) {
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(nm[i]) || (i && !(nm[i] > nm[i - 1])))
            return false;
    return n >= 2 && nm[0] <= 500 && nm[n - 1] >= 600;
}

/* X, Y, Z of the hat function of each wavelength: 1 there, falling linearly to 0 at its neighbours. xyz: (n, 3). */
static void integrate_hats(nqm_illuminant illuminant, size_t n, const float *nm, double *xyz) {
    memset(xyz, 0, 3 * n * sizeof *xyz);
    size_t k = 0;
    for (int at = FIRST_NM; at <= LAST_NM; ++at) {
        while (k + 2 < n && at >= (double)nm[k + 1])
            ++k;
        double t = (at - (double)nm[k]) / ((double)nm[k + 1] - (double)nm[k]), match[3];
        t = fmin(fmax(t, 0), 1); /* constant beyond both ends */
        match_colour(at, match);
        for (size_t c = 0; c < 3; ++c) {
            double value = emitted(illuminant, at) * match[c];
            xyz[3 * k + c] += (1 - t) * value;
            xyz[3 * (k + 1) + c] += t * value;
        }
    }
}

void nqm_spectrum_weights(nqm_illuminant illuminant, size_t n, const float *nm, double *rgb) {
    integrate_hats(illuminant, n, nm, rgb);
    double white[3] = {0}, white_cone[3], sum[3] = {0};
    for (size_t k = 0; k < 3 * n; ++k)
        white[k % 3] += rgb[k];
    multiply(cone_from_xyz, white, white_cone);
    for (size_t k = 0; k < n; ++k) {
        double cone[3];
        multiply(cone_from_xyz, rgb + 3 * k, cone);
        for (size_t c = 0; c < 3; ++c)
            cone[c] /= white_cone[c];
        multiply(rgb_from_cone, cone, rgb + 3 * k);
        for (size_t c = 0; c < 3; ++c)
            sum[c] += rgb[3 * k + c];
    }
    for (size_t k = 0; k < 3 * n; ++k)
        rgb[k] /= sum[k % 3]; /* from 1 +- 1e-9 of the rounded coefficients */
}
