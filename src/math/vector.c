/* SPDX-License-Identifier: MIT
 *
 * 3D vectors, and the half-vector coordinates of Rusinkiewicz (1998, DOI 10.1007/978-3-7091-6453-2_2).
 */
#include "math/math.h"

#include <math.h>

void nqm_cross3(const double *a, const double *b, double *c) {
    double x = a[1] * b[2] - a[2] * b[1];
    double y = a[2] * b[0] - a[0] * b[2];
    double z = a[0] * b[1] - a[1] * b[0];
    c[0] = x;
    c[1] = y;
    c[2] = z;
}

void nqm_normalize3(double *v) {
    double length = sqrt(nqm_dot3(v, v));
    if (!(length > 0)) {
        v[0] = v[1] = 0;
        v[2] = 1;
        return;
    }
    for (int k = 0; k < 3; ++k)
        v[k] /= length;
}

void nqm_spherical(double theta, double phi, double *v) {
    v[0] = sin(theta) * cos(phi);
    v[1] = sin(theta) * sin(phi);
    v[2] = cos(theta);
}

double nqm_luminance(const double *rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/* atan2 instead of acos, which loses half the digits near 0, where a highlight may be 0.2 degrees wide.
 * phi_d in [-pi, pi]. */
static void half_diff_signed(const double *wi, const double *wo, double *hd) {
    double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    nqm_normalize3(h);
    double sin_h = hypot(h[0], h[1]);
    double cos_phi = sin_h > 0 ? h[0] / sin_h : 1, sin_phi = sin_h > 0 ? h[1] / sin_h : 0;
    /* Rotate wi by -phi_h about z, then by -theta_h about y: the half vector becomes the z axis. */
    double x = cos_phi * wi[0] + sin_phi * wi[1];
    double y = cos_phi * wi[1] - sin_phi * wi[0];
    double d[3] = {h[2] * x - sin_h * wi[2], y, sin_h * x + h[2] * wi[2]};
    hd[0] = atan2(sin_h, h[2]);
    hd[1] = atan2(hypot(d[0], d[1]), d[2]);
    hd[2] = atan2(d[1], d[0]);
}

void nqm_half_diff_from_pair(const double *wi, const double *wo, double *hd) {
    half_diff_signed(wi, wo, hd);
    if (hd[2] < 0)
        hd[2] += NQM_PI;
    if (!(hd[2] < NQM_PI))
        hd[2] = 0;
}

void nqm_half_diff_full_from_pair(const double *wi, const double *wo, double *hd) {
    half_diff_signed(wi, wo, hd);
    if (hd[2] < 0)
        hd[2] += 2 * NQM_PI;
    if (!(hd[2] < 2 * NQM_PI))
        hd[2] = 0;
}

void nqm_turn3(const double *turn, const double *v, double *turned) {
    const double x = turn[1] * v[0] - turn[0] * v[1];
    turned[1] = turn[0] * v[0] + turn[1] * v[1];
    turned[0] = x;
    turned[2] = v[2];
}

void nqm_turn_pair(size_t i, double *wi, double *wo) {
    const double angle = (double)i * NQM_PI * (3 - sqrt(5)), turn[2] = {sin(angle), cos(angle)};
    nqm_turn3(turn, wi, wi);
    nqm_turn3(turn, wo, wo);
}

void nqm_half_diff_to_pair(const double *hd, double *wi, double *wo) {
    double sin_h = sin(hd[0]), cos_h = cos(hd[0]);
    double d[3];
    nqm_spherical(hd[1], hd[2], d);
    /* The rotation from the z axis to the half vector maps the difference vector d to wi, (-d.x, -d.y, d.z) to wo. */
    for (int side = 0; side < 2; ++side) {
        double x = side ? -d[0] : d[0], y = side ? -d[1] : d[1];
        double *w = side ? wo : wi;
        w[0] = cos_h * x + sin_h * d[2];
        w[1] = y;
        w[2] = cos_h * d[2] - sin_h * x;
    }
}

double nqm_radical_inverse(size_t i, size_t base) {
    double digit = 1, sum = 0;
    for (; i > 0; i /= base) {
        digit /= (double)base;
        sum += digit * (double)(i % base);
    }
    return sum;
}
