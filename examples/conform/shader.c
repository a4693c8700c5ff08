/* SPDX-License-Identifier: MIT
 * A metallic-roughness shader of glTF as a C function, for `nqm conform`; it has one mistake (doc/conform.md).
 *   nqm conform gltf --keys base_color,metallic,roughness --shader kit.h
 *   cc -I. examples/conform/shader.c -lm -o shader && ./shader >values.csv
 *   nqm conform gltf values.csv --keys base_color,metallic,roughness */
#include "kit.h"

#include <math.h>

static float dot(const float *a, const float *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float visibility(float n_a, float n_b, float alpha) {
    return n_a * sqrtf(n_b * n_b * (1 - alpha * alpha) + alpha * alpha);
}

static void shade(const nqm_set *m, const float light[3], const float viewer[3], float rgb[3]) {
    const float pi = 3.14159265f, r = m->roughness * m->roughness, alpha = r * r;
    float h[3] = {light[0] + viewer[0], light[1] + viewer[1], light[2] + viewer[2]};
    const float length = sqrtf(dot(h, h)), n_h = h[2] / length, v_h = dot(h, viewer) / length;
    const float f = (h[0] * h[0] + h[1] * h[1]) / dot(h, h) + alpha * alpha * n_h * n_h,
                d = alpha * alpha / (pi * f * f);
    const float v = 0.5f / (visibility(light[2], viewer[2], alpha) + visibility(viewer[2], light[2], alpha));
    const float rise = powf(1 - v_h, 5), dielectric = 0.04f + 0.96f * rise;
    for (int c = 0; c < 3; ++c) {
        const float base = m->base_color[c], metal = base + (1 - base) * rise;
        const float plain = (1 - dielectric) * base / pi + dielectric * d * v;
        rgb[c] = plain + (metal * d * v - plain) * m->metallic;
    }
}

int main(void) {
    nqm_print_values(stdout, shade);
    return 0;
}
