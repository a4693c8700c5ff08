/* SPDX-License-Identifier: MIT
 *
 * Directions as the nodes of a grid in half-vector coordinates, and the interpolation of a BRDF between them. theta_h is spaced
 * logarithmically down to the lobes of mirrors: the midpoint rule in log(theta_h) is exact to 1 % for lobes of any width, since
 * theta_h^2 f_r is a smooth function of it (Trefethen and Weideman 2014, DOI 10.1137/130932132). theta_d runs from 0 to the angle
 * at which light or viewer reaches the largest polar angle, and phi_d around the circle, so that both orders of light and viewer
 * and both sides of the plane of incidence are in the set.
 *
 * Between the nodes theta_h^2 cos(theta_i) cos(theta_o) f_r is interpolated: cubic in log(theta_h) and along theta_d, linear in phi_d.
 */
#include "sample/grid.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* From `narrowest` on, steps of a factor wide_step; at `visible`, which a light map begins to resolve, they become shorter. */
static const double narrowest = 2e-5, visible = 2e-3, widest = 80 * NQM_PI / 180, max_polar = 85 * NQM_PI / 180;

/* Theta_d relative to its largest value at the same theta_h and phi_d. */
static const double part_of_d[NQM_GRID_D] = {0.1, 0.32, 0.52, 0.7, 0.84, 0.94, 1};
static const double narrow_step = 1.9, wide_step = 1.5;

enum { FEW = 2, SOME = 4, MANY = 8 }; /* values of phi_d below 2 and below 12 degrees of theta_h, and above */

nqm_grid nqm_grid_make(void) {
    nqm_grid g = {.n_h = 0};
    const size_t n_narrow = (size_t)ceil(log(visible / narrowest) / log(narrow_step));
    const size_t n_wide = (size_t)ceil(log(widest / visible) / log(wide_step));
    g.n_h = n_narrow + n_wide + 1;
    for (size_t i = 0; i < g.n_h; ++i)
        g.log_h[i] = i < n_narrow ? log(narrowest) + log(visible / narrowest) * (double)i / (double)n_narrow
                                  : log(visible) + log(widest / visible) * (double)(i - n_narrow) / (double)n_wide;
    for (size_t i = 0; i < g.n_h; ++i)
        g.first[i + 1] = g.first[i] + NQM_GRID_D * nqm_grid_n_phi(&g, i);
    return g;
}

size_t nqm_grid_n_phi(const nqm_grid *g, size_t h) {
    const double degrees = exp(g->log_h[h]) * 180 / NQM_PI;
    return degrees < 2 ? FEW : degrees < 12 ? SOME : MANY;
}

/* The theta_d at which light or viewer has the polar angle max_polar: cos(theta_h) cos(x) - sin(theta_h) |cos(phi_d)| sin(x) =
 * cos(max_polar). */
static double most_theta_d(double theta_h, double phi_d) {
    const double a = cos(theta_h), b = sin(theta_h) * fabs(cos(phi_d));
    return fmax(acos(fmin(cos(max_polar) / hypot(a, b), 1)) - atan2(b, a), 1e-3);
}

static double phi_of(size_t n_phi, size_t k) {
    return 2 * NQM_PI * ((double)k + 0.5) / (double)n_phi;
}

void nqm_grid_node(const nqm_grid *g, size_t h, size_t d, size_t p, double hd[3]) {
    const size_t n_phi = nqm_grid_n_phi(g, h);
    hd[0] = exp(g->log_h[h]);
    hd[2] = phi_of(n_phi, p);
    hd[1] = part_of_d[d] * most_theta_d(hd[0], hd[2]);
}

/* Weights of the four nodes around x in Lagrange's cubic through them. Returns the first of the nodes; x is clamped to [at[0], at[n - 1]]. */
static size_t cubic(size_t n, const double *at, double x, double weight[4]) {
    size_t first = 0;
    x = fmin(fmax(x, at[0]), at[n - 1]);
    while (first + 4 < n && at[first + 2] < x)
        ++first;
    for (size_t i = 0; i < 4; ++i) {
        weight[i] = 1;
        for (size_t j = 0; j < 4; ++j)
            weight[i] *= j == i ? 1 : (x - at[first + j]) / (at[first + i] - at[first + j]);
    }
    return first;
}

/* theta_h^2 cos(theta_i) cos(theta_o), which makes lobes smooth. */
static double scale_at(const double hd[3]) {
    const double a = cos(hd[0]) * cos(hd[1]), b = sin(hd[0]) * sin(hd[1]) * cos(hd[2]);
    return hd[0] * hd[0] * fmax(a * a - b * b, 1e-6);
}

void nqm_grid_interpolate(const nqm_grid *g, const double hd[3], size_t node[NQM_GRID_NEAR],
                          double weight[NQM_GRID_NEAR]) {
    double by_h[4], by_d[4];
    const double log_h = fmin(fmax(log(fmax(hd[0], 1e-12)), g->log_h[0]), g->log_h[g->n_h - 1]), theta_h = exp(log_h);
    const double part = fmin(fmax(hd[1] / most_theta_d(theta_h, hd[2]), part_of_d[0]), 1);
    const size_t h = cubic(g->n_h, g->log_h, log_h, by_h), d = cubic(NQM_GRID_D, part_of_d, part, by_d);
    for (size_t i = 0, n = 0; i < 4; ++i) {
        const size_t n_phi = nqm_grid_n_phi(g, h + i);
        const double turn = hd[2] / (2 * NQM_PI) * (double)n_phi - 0.5, low = floor(turn);
        for (size_t side = 0; side < 2; ++side) {
            const size_t p = (size_t)(low + (double)(n_phi + side)) % n_phi;
            const double phi = phi_of(n_phi, p), by_p = side ? turn - low : 1 - (turn - low);
            const double scale = scale_at((double[]){theta_h, part * most_theta_d(theta_h, phi), phi});
            for (size_t j = 0; j < 4; ++j, ++n) {
                double there[3];
                nqm_grid_node(g, h + i, d + j, p, there);
                node[n] = g->first[h + i] + (d + j) * n_phi + p;
                weight[n] = by_h[i] * by_p * by_d[j] * scale_at(there) / scale;
            }
        }
    }
}

/* ---- as directions ----------------------------------------------------------------------------------------------- */

/* Angles of all nodes in degrees (n, 3), cut to 1e-9: the identity of the set does not depend on the last bit of exp(). */
static void fill_degrees(const nqm_grid *g, double *degrees) {
    for (size_t h = 0; h < g->n_h; ++h)
        for (size_t d = 0; d < NQM_GRID_D; ++d)
            for (size_t p = 0; p < nqm_grid_n_phi(g, h); ++p, degrees += 3) {
                double hd[3];
                nqm_grid_node(g, h, d, p, hd);
                for (int k = 0; k < 3; ++k)
                    degrees[k] = floor(hd[k] * (180 / NQM_PI) * 1e9 + 0.5) / 1e9;
            }
}

nqm_status nqm_grid_directions(nqm_directions **directions_ret, nqm_error *err) {
    const nqm_grid grid = nqm_grid_make();
    const size_t n = nqm_grid_count(&grid);
    double *degrees = nqm_alloc(n, 3 * sizeof *degrees);
    *directions_ret = NULL;
    if (!degrees)
        return nqm_fail_nomem(err, 3 * n * sizeof *degrees);
    fill_degrees(&grid, degrees);
    const nqm_status status = nqm_directions_from_degrees(n, degrees, directions_ret, err);
    nqm_free(degrees);
    return status;
}

nqm_status nqm_grid_check(const nqm_directions *directions, bool *is_grid_ret, nqm_error *err) {
    nqm_directions *grid;
    const nqm_status status = nqm_grid_directions(&grid, err);
    *is_grid_ret = status == NQM_OK && directions->n == grid->n &&
                   memcmp(directions->degrees, grid->degrees, 3 * grid->n * sizeof *grid->degrees) == 0;
    nqm_directions_free(grid);
    return status;
}
