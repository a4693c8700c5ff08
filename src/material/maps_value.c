/* SPDX-License-Identifier: MIT
 *
 * The value of a node of a textured material at one position: the reference of what each operation computes. HSV as in MaterialX
 * (libraries/stdlib/genglsl/lib/mx_hsv.glsl, after Foley and van Dam).
 */
#include "material/maps.h"

#include <math.h>
#include <string.h>

static void rgb_to_hsv(const double rgb[4], double hsv[4]) {
    const double high = fmax(fmax(rgb[0], rgb[1]), rgb[2]), low = fmin(fmin(rgb[0], rgb[1]), rgb[2]);
    const double range = high - low, saturation = high > 0 ? range / high : 0;
    double hue = 0;
    if (saturation > 0) {
        hue = rgb[0] >= high   ? (rgb[1] - rgb[2]) / range
              : rgb[1] >= high ? 2 + (rgb[2] - rgb[0]) / range
                               : 4 + (rgb[0] - rgb[1]) / range;
        hue = hue < 0 ? hue / 6 + 1 : hue / 6;
    }
    hsv[0] = hue;
    hsv[1] = saturation;
    hsv[2] = high;
}

static void hsv_to_rgb(const double hsv[4], double rgb[4]) {
    /* The channels of the six sectors of the hue: 0 value, 1 low, 2 falling, 3 rising. */
    static const unsigned char sectors[6][3] = {{0, 3, 1}, {2, 0, 1}, {1, 0, 3}, {1, 2, 0}, {3, 1, 0}, {0, 1, 2}};
    const double saturation = hsv[1] < 0.0001 ? 0 : hsv[1], value = hsv[2];
    const double hue = isfinite(hsv[0]) ? 6 * (hsv[0] - floor(hsv[0])) : 0;
    const size_t sector = nqm_smaller((size_t)hue, 5);
    const double fraction = hue - (double)sector;
    const double levels[4] = {value, value * (1 - saturation), value * (1 - saturation * fraction),
                              value * (1 - saturation * (1 - fraction))};
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = levels[sectors[sector][c]];
}

static double smoothstep(double x, double low, double high) {
    if (x <= low || x >= high)
        return x > low;
    const double t = (x - low) / (high - low);
    return t * t * (3 - 2 * t);
}

#define COMPONENT(NAME, N, VALUE)                                                                                      \
    case NQM_MAP_##NAME:                                                                                               \
        return VALUE;
static double component(nqm_map_op op, double a, double b, double c, double d) {
    switch (op) {
        NQM_MAP_COMPONENT_OPS(COMPONENT)
    default:
        return 0;
    }
}

/* 2 a - 1 with x and y scaled, as a unit vector; (0, 0, 1) if it has no length, or where a is black. */
static void normal(const double a[4], const double scale[4], double out[4]) {
    const bool has_value = a[0] != 0 || a[1] != 0 || a[2] != 0;
    for (size_t c = 0; c < 3; ++c)
        out[c] = (2 * a[c] - 1) * (c < 2 ? scale[c] : 1);
    const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    for (size_t c = 0; c < 3; ++c)
        out[c] = length > 0 && has_value ? out[c] / length : c == 2;
}

void nqm_map_node_value(const nqm_map_node *node, const double (*values)[4], double out[4]) {
    static const double zero[4];
    const size_t n_operands = nqm_map_operands(node->op, node->n), n = node->n;
    const double *in[4] = {zero, zero, zero, zero};
    for (size_t i = 0; i < n_operands; ++i)
        in[i] = values[node->in[i]];
    switch (node->op) {
    case NQM_MAP_VALUE:
        memcpy(out, node->v, sizeof node->v);
        break;
    case NQM_MAP_CHANNEL:
        out[0] = in[0][(size_t)node->v[0] & 3];
        break;
    case NQM_MAP_COMBINE:
        for (size_t c = 0; c < n; ++c)
            out[c] = in[c][0];
        break;
    case NQM_MAP_LUMINANCE:
        for (size_t c = 0; c < n; ++c)
            out[c] = 0.2126 * in[0][0] + 0.7152 * in[0][1] + 0.0722 * in[0][2];
        break;
    case NQM_MAP_RGB_TO_HSV:
        rgb_to_hsv(in[0], out);
        break;
    case NQM_MAP_HSV_TO_RGB:
        hsv_to_rgb(in[0], out);
        break;
    case NQM_MAP_NORMAL:
        normal(in[0], in[1], out);
        break;
    default:
        for (size_t c = 0; c < n; ++c)
            out[c] = component(node->op, in[0][c], in[1][c], in[2][c], in[3][c]);
    }
    if ((node->op == NQM_MAP_RGB_TO_HSV || node->op == NQM_MAP_HSV_TO_RGB) && n == 4)
        out[3] = in[0][3]; /* alpha */
    for (size_t c = n; c < 4; ++c)
        out[c] = out[n - 1];
}
