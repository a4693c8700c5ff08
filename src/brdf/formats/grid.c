/* SPDX-License-Identifier: MIT
 *
 * Linear interpolation between measured values at any rising theta_h, theta_d and phi_d.
 */
#include "brdf/formats/grid.h"

#include "math/math.h"
#include <math.h>

/* The two nodes around a point of an axis, and the weight of the second. */
typedef struct span {
    size_t node[2];
    double t;
} span;

/* false: x is outside the nodes by more than the rounding of angles in float32. */
static bool find_theta(const nqm_grid *g, size_t axis, double x, span *s) {
    const double *node = g->node[axis], slack = 1e-6;
    const size_t n = g->n[axis];
    if (!g->extrapolates && !(x >= node[0] - slack && x <= node[n - 1] + slack))
        return false;
    size_t i = nqm_last_not_above(node, n, fmax(x, node[0]));
    i = i < n - 1 ? i : n - 2;
    const double t = (x - node[i]) / (node[i + 1] - node[i]);
    *s = (span){{i, i + 1}, g->extrapolates ? t : fmin(fmax(t, 0), 1)};
    return true;
}

static span find_phi(const nqm_grid *g, double x) {
    const double *node = g->node[2], first = node[0], last = node[g->n[2] - 1];
    while (x < first)
        x += g->period;
    while (x > last && x - g->period >= first)
        x -= g->period;
    size_t i = nqm_last_not_above(node, g->n[2], x);
    bool wraps = i == g->n[2] - 1;
    double next = wraps ? first + g->period : node[i + 1];
    return (span){{i, wraps ? 0 : i + 1}, next > node[i] ? (x - node[i]) / (next - node[i]) : 0};
}

/* false: a value of the node is NaN. */
static bool read_node(const nqm_grid *g, size_t offset, double *rgb) {
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (size_t k = 0; k < g->n_channels; ++k) {
        double value = (double)nqm_load_f32(g->value + offset + k * g->channel_stride);
        if (isnan(value))
            return false;
        for (size_t c = 0; c < 3; ++c)
            rgb[c] += g->weights[3 * k + c] * value;
    }
    return true;
}

static void interpolate(const nqm_grid *g, const span *s, double *rgb) {
    double total = 0, sum[3] = {0}, at_node[3];
    for (size_t corner = 0; corner < 8; ++corner) {
        double weight = 1;
        size_t offset = 0;
        for (size_t axis = 0; axis < 3; ++axis) {
            size_t upper = corner >> axis & 1;
            weight *= upper ? s[axis].t : 1 - s[axis].t;
            offset += s[axis].node[upper] * g->stride[axis];
        }
        if (weight == 0 || !read_node(g, offset, at_node))
            continue;
        total += weight;
        for (size_t c = 0; c < 3; ++c)
            sum[c] += weight * at_node[c];
    }
    /* A total of about 0: only rounding errors gave the neighbours of a node without a value a weight. */
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = total > 1e-6 ? sum[c] / total : NAN;
}

void nqm_grid_eval(const void *self, size_t n, const double *hd, double *rgb) {
    const nqm_grid *grid = self;
    for (size_t i = 0; i < n; ++i) {
        span s[3];
        if (find_theta(grid, 0, hd[3 * i], s) && find_theta(grid, 1, hd[3 * i + 1], s + 1)) {
            s[2] = find_phi(grid, hd[3 * i + 2]);
            interpolate(grid, s, rgb + 3 * i);
        } else {
            rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = NAN;
        }
    }
}

void nqm_grid_eval_folded(const nqm_grid *g, double *at, double *rgb) {
    const double first = g->node[2][0], last = g->node[2][g->n[2] - 1], slack = 1e-6;
    if (g->period < 2 * NQM_PI) {
        at[2] = fabs(at[2]);
        if (at[2] < first - slack || at[2] > last + slack)
            at[0] = NAN;
        at[2] = fmin(fmax(at[2], first), last);
    }
    nqm_grid_eval(g, 1, at, rgb);
}

double nqm_grid_gap(const nqm_grid *g, size_t k) {
    const double *node = g->node[k];
    const size_t n = g->n[k];
    double gap = k == 2 ? node[0] + g->period - node[n - 1] : 0;
    for (size_t i = 1; i < n; ++i)
        gap = fmax(gap, node[i] - node[i - 1]);
    return gap * 180 / NQM_PI;
}
