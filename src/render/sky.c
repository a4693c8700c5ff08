/* SPDX-License-Identifier: MIT
 *
 * The built-in light, which makes labels possible without a file: a low sun in a clear evening sky over reddish ground, and
 * two soft boxes. Its contrast follows a measured outdoor probe with a low sun (Pixar Campus): the sun's disc has about a
 * thousand times the mean radiance and two fifths of the power; the rest spans three decades.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>

enum { WIDTH = 512, HEIGHT = 256 };

/* A round source: azimuth from the direction behind the viewer to the viewer's right, elevation, widths in degrees. */
typedef struct source {
    double azimuth_deg, elevation_deg;
    double radius_deg, edge_deg; /* full radiance up to `radius`, smooth fall to 0 at `radius + edge` */
    double rgb[3];
} source;

static const source sources[] = {
    {-55, 24, 2.0, 1.0, {520, 415, 280}}, /* the sun */
    {70, 35, 6, 14, {3.4, 3.7, 4.2}},     /* a cool soft box to the right */
    {-150, 12, 4, 18, {2.4, 1.9, 1.3}},   /* a warm one at the left, behind the shape */
};

static double smooth_step(double low, double high, double x) {
    double t = fmin(fmax((x - low) / (high - low), 0), 1);
    return t * t * (3 - 2 * t);
}

static void blend(const double *a, const double *b, double t, double *rgb) {
    for (int k = 0; k < 3; ++k)
        rgb[k] = a[k] + (b[k] - a[k]) * t;
}

static void add_source(const source *s, const double *w, double *rgb) {
    const double degree = NQM_PI / 180;
    double elevation = s->elevation_deg * degree, azimuth = s->azimuth_deg * degree;
    const double centre[3] = {cos(elevation) * sin(azimuth), sin(elevation), cos(elevation) * cos(azimuth)};
    double angle_deg = acos(fmin(fmax(nqm_dot3(centre, w), -1), 1)) / degree;
    double strength = 1 - smooth_step(s->radius_deg, s->radius_deg + s->edge_deg, angle_deg);
    for (int k = 0; k < 3; ++k)
        rgb[k] += strength * s->rgb[k];
}

static void radiance(const double *w, double *rgb) {
    static const double zenith[3] = {0.06, 0.09, 0.19}, horizon[3] = {0.72, 0.62, 0.56};
    static const double ground_far[3] = {0.20, 0.13, 0.085}, ground_near[3] = {0.26, 0.165, 0.105};
    double sky[3], ground[3];
    blend(zenith, horizon, pow(1 - fmax(w[1], 0), 4), sky);
    blend(ground_far, ground_near, fmax(-w[1], 0), ground);
    for (size_t i = 0; i < sizeof sources / sizeof *sources; ++i)
        add_source(&sources[i], w, sky);
    blend(ground, sky, smooth_step(-0.02, 0.02, w[1]), rgb);
}

nqm_status nqm_sky_draw(nqm_image *image_ret, nqm_error *err) {
    *image_ret = (nqm_image){0};
    float *rgb = nqm_alloc((size_t)WIDTH * HEIGHT, 3 * sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, (size_t)WIDTH * HEIGHT * 3 * sizeof *rgb);
    for (size_t y = 0; y < HEIGHT; ++y)
        for (size_t x = 0; x < WIDTH; ++x) {
            double w[3], value[3];
            nqm_map_direction(((double)x + 0.5) / WIDTH, ((double)y + 0.5) / HEIGHT, w);
            radiance(w, value);
            for (size_t k = 0; k < 3; ++k)
                rgb[3 * (y * WIDTH + x) + k] = (float)value[k];
        }
    *image_ret = (nqm_image){.width = WIDTH, .height = HEIGHT, .rgb = rgb};
    return NQM_OK;
}
