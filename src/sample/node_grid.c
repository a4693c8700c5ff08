/* SPDX-License-Identifier: MIT
 *
 * Directions as the nodes of a grid in half-vector coordinates, and the interpolation of a BRDF between them. theta_h is spaced
 * logarithmically down to the lobes of mirrors: the midpoint rule in log(theta_h) is exact to 1 % for lobes of any width, since
 * theta_h^2 f_r is a smooth function of it (Trefethen and Weideman 2014, DOI 10.1137/130932132). theta_d runs from 0 to the angle
 * at which light or viewer reaches the largest polar angle, and phi_d around the circle, so that both orders of light and viewer
 * and both sides of the plane of incidence are in the set. A quarter of a step turns the circle: most BRDFs are symmetric about
 * that plane, and no two values of phi_d are then mirror images, which would see the same.
 *
 * Between the nodes theta_h^2 cos(theta_i) cos(theta_o) f_r is interpolated: cubic in log(theta_h) and along theta_d,
 * trigonometric in phi_d, of which all have the same values.
 */
#include "sample/node_grid.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* From `narrowest` on, steps of a factor wide_step; at `visible`, which a light map begins to resolve, they become shorter. */
static const double narrowest = 2e-5, visible = 2e-3, widest = 80 * NQM_PI / 180, max_polar = 85 * NQM_PI / 180;

/* Theta_d relative to its largest value at the same theta_h and phi_d. Before the nodes comes the first one again, seen
 * from the other side: (-theta_d, phi_d) is the direction (theta_d, phi_d + pi). */
static const double part_of_d[1 + NQM_GRID_D] = {-0.12, 0.12, 0.4, 0.65, 0.84, 0.95, 1};
static const double narrow_step = 1.9, wide_step = 1.25;

nqm_node_grid nqm_node_grid_make(void) {
    nqm_node_grid g = {.n_h = 0};
    const size_t n_narrow = (size_t)ceil(log(visible / narrowest) / log(narrow_step));
    const size_t n_wide = (size_t)ceil(log(widest / visible) / log(wide_step));
    g.n_h = n_narrow + n_wide + 1;
    g.n = g.n_h * NQM_GRID_D * NQM_GRID_PHI;
    for (size_t i = 0; i < g.n_h; ++i)
        g.log_h[i] = i < n_narrow ? log(narrowest) + log(visible / narrowest) * (double)i / (double)n_narrow
                                  : log(visible) + log(widest / visible) * (double)(i - n_narrow) / (double)n_wide;
    return g;
}

/* The theta_d at which light or viewer has the polar angle max_polar: cos(theta_h) cos(x) - sin(theta_h) |cos(phi_d)| sin(x) =
 * cos(max_polar). */
static double most_theta_d(double theta_h, double phi_d) {
    const double a = cos(theta_h), b = sin(theta_h) * fabs(cos(phi_d));
    return fmax(acos(fmin(cos(max_polar) / hypot(a, b), 1)) - atan2(b, a), 1e-3);
}

static double phi_of(size_t p) {
    return 2 * NQM_PI * ((double)p + 0.25) / NQM_GRID_PHI;
}

static size_t node_at(size_t h, size_t d, size_t p) {
    return (h * NQM_GRID_D + d) * NQM_GRID_PHI + p;
}

/* Coordinates of a node in radians. */
static void place_node(const nqm_node_grid *g, size_t h, size_t d, size_t p, double hd[3]) {
    hd[0] = exp(g->log_h[h]);
    hd[2] = phi_of(p);
    hd[1] = part_of_d[1 + d] * most_theta_d(hd[0], hd[2]);
}

/* The first of the four nodes around x. */
static size_t stencil(size_t n, const double *at, double x) {
    size_t first = 0;
    while (first + 4 < n && at[first + 2] < x)
        ++first;
    return first;
}

/* Weight of node k of four in Lagrange's cubic through them. */
static double cubic(const double at[4], size_t k, double x) {
    double weight = 1;
    for (size_t j = 0; j < 4; ++j)
        weight *= j == k ? 1 : (x - at[j]) / (at[k] - at[j]);
    return weight;
}

/* theta_h^2 cos(theta_i) cos(theta_o), which makes lobes smooth. */
static double scale_at(const double hd[3]) {
    const double a = cos(hd[0]) * cos(hd[1]), b = sin(hd[0]) * sin(hd[1]) * cos(hd[2]);
    return hd[0] * hd[0] * fmax(a * a - b * b, 1e-6);
}

/* theta_d relative to its largest value, within the grid. */
static double part_at(double theta_h, double theta_d, double phi_d) {
    return fmin(theta_d / most_theta_d(theta_h, phi_d), 1);
}

/* Weight of a node at the angle x from the ray in the trigonometric polynomial through the nodes around the circle. */
static double trigonometric(double x) {
    const double n = NQM_GRID_PHI, half = sin(x / 2);
    return fabs(half) < 1e-9 ? 1 : sin(n * x / 2) * cos(x / 2) / (n * half);
}

void nqm_node_grid_interpolate(const nqm_node_grid *g, const double *wi, const double *wo, size_t node[NQM_GRID_NEAR],
                               double weight[NQM_GRID_NEAR]) {
    double hd[3];
    nqm_half_diff_full_from_pair(wi, wo, hd);
    const double log_h = fmin(fmax(log(fmax(hd[0], 1e-12)), g->log_h[0]), g->log_h[g->n_h - 1]), theta_h = exp(log_h);
    const size_t h = stencil(g->n_h, g->log_h, log_h);
    const size_t d = stencil(1 + NQM_GRID_D, part_of_d, part_at(theta_h, hd[1], hd[2]));
    size_t n = 0;
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j) {
            const bool is_behind = d + j == 0;
            const size_t node_d = is_behind ? 0 : d + j - 1;
            for (size_t p = 0; p < NQM_GRID_PHI; ++p, ++n) {
                const double phi = phi_of(p), part = part_at(theta_h, hd[1], phi);
                const double here[3] = {theta_h, part * most_theta_d(theta_h, phi), phi};
                const size_t at = is_behind ? (p + NQM_GRID_PHI / 2) % NQM_GRID_PHI : p;
                double there[3];
                place_node(g, h + i, node_d, at, there);
                node[n] = node_at(h + i, node_d, at);
                weight[n] = cubic(g->log_h + h, i, log_h) * cubic(part_of_d + d, j, part) * trigonometric(hd[2] - phi) *
                            scale_at(there) / scale_at(here);
            }
        }
}

/* ---- as directions ----------------------------------------------------------------------------------------------- */

/* Angles of all nodes in degrees (n, 3), cut to 1e-9: the identity of the set does not depend on the last bit of exp(). */
static void fill_degrees(const nqm_node_grid *g, double *degrees) {
    for (size_t h = 0; h < g->n_h; ++h)
        for (size_t d = 0; d < NQM_GRID_D; ++d)
            for (size_t p = 0; p < NQM_GRID_PHI; ++p, degrees += 3) {
                double hd[3];
                place_node(g, h, d, p, hd);
                for (int k = 0; k < 3; ++k)
                    degrees[k] = floor(hd[k] * (180 / NQM_PI) * 1e9 + 0.5) / 1e9;
            }
}

nqm_status nqm_node_grid_directions(nqm_directions **directions_ret, nqm_error *err) {
    const nqm_node_grid grid = nqm_node_grid_make();
    const size_t n = grid.n;
    double *degrees = nqm_alloc(n, 3 * sizeof *degrees);
    *directions_ret = NULL;
    if (!degrees)
        return nqm_fail_nomem(err, 3 * n * sizeof *degrees);
    fill_degrees(&grid, degrees);
    const nqm_status status = nqm_directions_from_degrees(n, degrees, directions_ret, err);
    nqm_free(degrees);
    return status;
}

nqm_status nqm_node_grid_check(const nqm_directions *directions, bool *is_grid_ret, nqm_error *err) {
    nqm_directions *grid;
    const nqm_status status = nqm_node_grid_directions(&grid, err);
    *is_grid_ret = status == NQM_OK && directions->n == grid->n &&
                   memcmp(directions->degrees, grid->degrees, 3 * grid->n * sizeof *grid->degrees) == 0;
    nqm_directions_free(grid);
    return status;
}
