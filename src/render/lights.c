/* SPDX-License-Identifier: MIT
 *
 * The built-in lights, which make labels possible without a file: a low sun in a clear sky, an overcast day, a photographer's
 * studio and a room with windows. Each is a background with round and rectangular sources. Contrast follows measured
 * lights (doc/labels.md has the comparison); variations with amplitude 1/frequency in log radiance replace the detail of
 * photographs (Dror, Willsky and Adelson 2004, DOI 10.1167/4.9.11).
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { WIDTH = 512, HEIGHT = 256, MAX_SOURCES = 4, OCTAVES = 5, WAVES = 4 * OCTAVES };

static const double degree = NQM_PI / 180;

/* Azimuth from the direction behind the viewer to the viewer's right; half the width and height of a rectangle, or the radius
 * of a disc (height 0); full radiance inside, smooth fall to 0 over `edge` outside. */
typedef struct source {
    double azimuth_deg, elevation_deg, half_width_deg, half_height_deg, edge_deg;
    double rgb[3];
} source;

/* Plane waves in random directions, four in each octave of frequency. */
typedef struct waves {
    double direction[WAVES][3], phase[WAVES];
} waves;

typedef struct light_model {
    const char *name;
    void (*background)(const double *w, const waves *v, double *rgb);
    source sources[MAX_SOURCES]; /* the first with half_width_deg 0 ends the list */
} light_model;

static double smooth_step(double low, double high, double x) {
    double t = fmin(fmax((x - low) / (high - low), 0), 1);
    return t * t * (3 - 2 * t);
}

static void blend(const double *a, const double *b, double t, double *rgb) {
    for (int k = 0; k < 3; ++k)
        rgb[k] = a[k] + (b[k] - a[k]) * t;
}

static void scale(double factor, double *rgb) {
    for (int k = 0; k < 3; ++k)
        rgb[k] *= factor;
}

/* exp of a sum of the waves with amplitudes inverse to their frequency. */
static double variation(const double *w, const waves *v, double amplitude) {
    double sum = 0, frequency = 3, height = 1;
    for (int octave = 0; octave < OCTAVES; ++octave, frequency *= 2, height /= 2)
        for (int i = octave * WAVES / OCTAVES; i < (octave + 1) * WAVES / OCTAVES; ++i)
            sum += height * cos(frequency * nqm_dot3(w, v->direction[i]) + v->phase[i]);
    return exp(amplitude * sum /
               sqrt(8.0 / 3)); /* four waves of mean square 1/2, and the geometric series of octaves */
}

static void make_waves(uint64_t seed, waves *v) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (int i = 0; i < WAVES; ++i) {
        for (int k = 0; k < 3; ++k)
            v->direction[i][k] = nqm_rng_normal(&rng);
        nqm_normalize3(v->direction[i]);
        v->phase[i] = 2 * NQM_PI * nqm_rng_uniform(&rng);
    }
}

/* ---- backgrounds ------------------------------------------------------------------------------------------------- */

static void clear_sky(const double *w, const waves *v, double *rgb) {
    static const double zenith[3] = {0.06, 0.09, 0.19}, horizon[3] = {0.72, 0.62, 0.56};
    static const double ground_far[3] = {0.20, 0.13, 0.085}, ground_near[3] = {0.26, 0.165, 0.105};
    double ground[3], sky = smooth_step(-0.02, 0.02, w[1]);
    blend(zenith, horizon, pow(1 - fmax(w[1], 0), 4), rgb);
    if (sky == 1)
        return;
    blend(ground_far, ground_near, fmax(-w[1], 0), ground);
    scale(variation(w, v, 0.25), ground);
    blend(ground, rgb, sky, rgb);
}

/* The luminance of the CIE standard overcast sky behind clouds, with trees or houses along the horizon. */
static void overcast_sky(const double *w, const waves *v, double *rgb) {
    static const double sky[3] = {0.94, 1.0, 1.1}, ground[3] = {0.20, 0.19, 0.15}, trees[3] = {0.045, 0.055, 0.035};
    double azimuth = atan2(w[0], w[2]), elevation = asin(w[1]) / degree, near[3];
    double skyline = 9 + 5 * sin(2 * azimuth + 1) + 3 * sin(5 * azimuth) + 2 * sin(13 * azimuth + 2);
    double above = smooth_step(skyline - 1, skyline + 1, elevation);
    memcpy(rgb, sky, sizeof sky);
    if (above > 0)
        scale((1 + 2 * fmax(w[1], 0)) / 3 * variation(w, v, 0.2), rgb);
    if (above == 1)
        return;
    blend(ground, trees, smooth_step(-6, 0, elevation), near);
    scale(variation(w, v, 0.35), near);
    blend(near, rgb, above, rgb);
}

static void studio(const double *w, const waves *v, double *rgb) {
    static const double dark[3] = {0.035, 0.035, 0.04}, floor_light[3] = {0.30, 0.29, 0.28};
    blend(dark, floor_light, smooth_step(0.1, -0.7, w[1]), rgb);
    scale(variation(w, v, 0.2), rgb);
}

/* A box around the shape: the walls are lit from the windows in the left wall and by a lamp under the ceiling. */
static void room(const double *w, const waves *v, double *rgb) {
    static const double half[3] = {2.6, 1.3, 3.4};
    static const double walls[3][2][3] = {{{0.55, 0.52, 0.48}, {0.62, 0.50, 0.36}},  /* -x, +x */
                                          {{0.30, 0.19, 0.11}, {0.75, 0.74, 0.72}},  /* floor, ceiling */
                                          {{0.60, 0.58, 0.55}, {0.42, 0.47, 0.52}}}; /* behind the shape, the viewer */
    static const double sky[3] = {15, 17, 20}, garden[3] = {3.2, 3.6, 1.9};
    size_t axis = 0;
    double nearest = INFINITY, at[3];
    for (size_t k = 0; k < 3; ++k)
        if (half[k] < nearest * fabs(w[k])) {
            nearest = half[k] / fabs(w[k]);
            axis = k;
        }
    for (size_t k = 0; k < 3; ++k)
        at[k] = nearest * w[k];
    memcpy(rgb, walls[axis][w[axis] > 0], 3 * sizeof *rgb);
    double from_window = hypot(at[0] + half[0], at[2]), from_lamp = hypot(at[0] - 1, at[2] + 1.4);
    scale(variation(w, v, 0.25) * (0.12 + 0.9 / (1 + from_window * from_window) + 0.2 / (1 + from_lamp * from_lamp)),
          rgb);
    if (axis == 0 && w[0] < 0) { /* two windows, each of four panes */
        double x = fmod(fabs(at[2]), 1.9) - 1, y = at[1] - 0.25, pane[3];
        bool inside = fabs(x) < 0.65 && fabs(y) < 0.8 && fabs(x) > 0.035 && fabs(y) > 0.035 && fabs(at[2]) < 1.9;
        blend(garden, sky, smooth_step(-0.25, 0.1, y), pane);
        if (inside)
            memcpy(rgb, pane, sizeof pane);
    }
}

static const light_model lights[] = {
    {"sun", clear_sky, {{-55, 24, 2, 0, 1, {360, 288, 195}}, {-55, 24, 3, 0, 25, {1.6, 1.35, 1.0}}}},
    {.name = "overcast", .background = overcast_sky},
    {"studio",
     studio,
     {{-50, 42, 17, 17, 2, {15, 14.6, 14}},
      {75, 15, 28, 20, 8, {1.1, 1.2, 1.35}},
      {150, 20, 5, 28, 1.5, {12, 12.6, 14}}}},
    {"interior", room, {{140, 44, 5, 0, 1, {110, 84, 52}}}},
};

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* A source and its axes in world coordinates. */
typedef struct placed_source {
    const source *source;
    double centre[3], right[3], up[3];
} placed_source;

static placed_source place_source(const source *s) {
    double elevation = s->elevation_deg * degree, azimuth = s->azimuth_deg * degree;
    placed_source p = {.source = s,
                       .centre = {cos(elevation) * sin(azimuth), sin(elevation), cos(elevation) * cos(azimuth)},
                       .right = {cos(azimuth), 0, -sin(azimuth)}};
    nqm_cross3(p.centre, p.right, p.up);
    return p;
}

/* The fraction of a source's radiance in direction w. */
static double strength(const placed_source *p, const double *w) {
    const source *s = p->source;
    double along = nqm_dot3(p->centre, w);
    if (s->half_height_deg == 0) {
        double angle_deg = acos(fmin(fmax(along, -1), 1)) / degree;
        return 1 - smooth_step(s->half_width_deg, s->half_width_deg + s->edge_deg, angle_deg);
    }
    double x_deg = fabs(atan2(nqm_dot3(p->right, w), along)) / degree,
           y_deg = fabs(atan2(nqm_dot3(p->up, w), along)) / degree;
    return (1 - smooth_step(s->half_width_deg, s->half_width_deg + s->edge_deg, x_deg)) *
           (1 - smooth_step(s->half_height_deg, s->half_height_deg + s->edge_deg, y_deg));
}

typedef struct drawing {
    const light_model *model;
    waves waves;
    size_t n_sources;
    placed_source sources[MAX_SOURCES];
    float *rgb;
} drawing;

static void draw_row(void *user, size_t y) {
    const drawing *d = user;
    for (size_t x = 0; x < WIDTH; ++x) {
        double w[3], rgb[3];
        nqm_map_direction(((double)x + 0.5) / WIDTH, ((double)y + 0.5) / HEIGHT, w);
        d->model->background(w, &d->waves, rgb);
        for (const placed_source *s = d->sources; s < d->sources + d->n_sources; ++s) {
            double part = strength(s, w);
            for (int k = 0; k < 3; ++k)
                rgb[k] += part * s->source->rgb[k];
        }
        for (size_t k = 0; k < 3; ++k)
            d->rgb[3 * (y * WIDTH + x) + k] = (float)rgb[k];
    }
}

static const light_model *find_light(const char *name) {
    for (size_t i = 0; i < sizeof lights / sizeof *lights; ++i)
        if (strcmp(lights[i].name, name) == 0)
            return &lights[i];
    return NULL;
}

bool nqm_light_is_builtin(const char *name) {
    return find_light(name) != NULL;
}

/* Drawn maps, which take a quarter of the time of a simple label, are kept until the process ends. */
static _Atomic(float *) kept[sizeof lights / sizeof *lights];

static void draw(const light_model *model, float *rgb) {
    drawing d = {.model = model, .rgb = rgb};
    make_waves((uint64_t)(model - lights), &d.waves);
    for (const source *s = model->sources; s < model->sources + MAX_SOURCES && s->half_width_deg > 0; ++s)
        d.sources[d.n_sources++] = place_source(s);
    nqm_parallel_for(HEIGHT, draw_row, &d);
}

nqm_status nqm_light_draw(const char *name, nqm_image *image_ret, nqm_error *err) {
    const size_t size = (size_t)WIDTH * HEIGHT * 3 * sizeof(float);
    const light_model *model = find_light(name);
    float *known = atomic_load(&kept[model - lights]), *none = NULL, *rgb = nqm_alloc(size, 1);
    float *drawn = known ? known : nqm_alloc(size, 1);
    *image_ret = (nqm_image){0};
    if (!rgb || !drawn) {
        nqm_free(rgb);
        nqm_free(known ? NULL : drawn);
        return nqm_fail_nomem(err, size);
    }
    if (!known)
        draw(model, drawn);
    memcpy(rgb, drawn, size);
    if (!known && !atomic_compare_exchange_strong(&kept[model - lights], &none, drawn))
        nqm_free(drawn); /* another thread drew it, too */
    *image_ret = (nqm_image){.width = WIDTH, .height = HEIGHT, .rgb = rgb};
    return NQM_OK;
}
