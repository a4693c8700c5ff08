/* SPDX-License-Identifier: MIT
 *
 * The implementation of scene.h.
 */
#include "nqm/label/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_SIDE = 4096 };

scene_args scene_args_begin(void) {
    scene_args a = {.scene = nqm_scene_options_default()};
    a.scene.n_points = 0;
    return a;
}

/* "256" or "320x200". */
static bool parse_size(const char *text, size_t *width, size_t *height) {
    char *end;
    size_t n_digits = strspn(text, "0123456789");
    bool good = n_digits > 0;
    *width = *height = strtoul(text, &end, 10);
    if (good && *end == 'x') {
        good = strspn(end + 1, "0123456789") > 0;
        *height = strtoul(end + 1, &end, 10);
    }
    return good && !*end && *width >= 1 && *width <= MAX_SIDE && *height >= 1 && *height <= MAX_SIDE;
}

void scene_args_end(scene_args *a) {
    nqm_scene_options *s = &a->scene;
    if (a->size && !parse_size(a->size, &s->width, &s->height))
        stop(EXIT_USAGE, "--size needs a size in pixels, '256' or '320x200', with sides of at most %d pixels, not '%s'",
             (int)MAX_SIDE, a->size);
    if (s->n_points)
        s->width = s->height = 0;
    else if (!a->size)
        s->n_points = nqm_scene_options_default().n_points;
    s->n_frames = nqm_scene_n_frames(s);
}

json_t *json_scene(const nqm_scene_options *s) {
    const double degree = 3.14159265358979323846 / 180;
    json_t *scene = json_pack(
        "{s:o,s:o,s:I,s:f,s:f,s:I,s:f,s:f,s:I,s:b,s:b,s:I}", "shape", json_name(s->shape ? s->shape : "sphere"),
        "light", json_name(s->light ? s->light : "sun"), "light_width", (json_int_t)s->light_width, "exposure_cdm2",
        s->exposure_cdm2, "peak_cdm2", s->peak_cdm2, "frames", (json_int_t)s->n_frames, "turn", s->turn_rad / degree,
        "elevation", s->elevation_rad / degree, "lights", (json_int_t)nqm_scene_n_lights(s), "shadows", s->shadows,
        "interreflection", s->interreflection, "seed", (json_int_t)s->seed);
    if (nqm_scene_is_standard(s)) {
        json_object_set_new(scene, "shape", json_string("standard"));
        json_object_set_new(scene, "light", json_string("standard"));
    }
    if (s->width) {
        json_object_set_new(scene, "width", json_integer((json_int_t)s->width));
        json_object_set_new(scene, "height", json_integer((json_int_t)s->height));
    } else {
        json_object_set_new(scene, "points", json_integer((json_int_t)s->n_points));
    }
    return scene;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

double *make_backdrop(const nqm_scene *scene, const nqm_scene_options *o, backdrop kind) {
    static const double white_cdm2 = 10000;
    size_t n = 3 * o->width * o->height;
    double *blank = allocate(n, sizeof *blank);
    if (kind == BACKDROP_LIGHT)
        nqm_scene_background(scene, 0, blank);
    for (size_t i = 0; kind == BACKDROP_WHITE && i < n; ++i)
        blank[i] = white_cdm2;
    return blank;
}

void frame_picture(const nqm_scene *scene, const nqm_scene_options *o, size_t frame, const double *blank,
                   const double *rgb_cdm2, double *picture) {
    size_t n = o->width * o->height;
    const size_t *pixel = nqm_scene_pixels(scene);
    memcpy(picture, blank, 3 * n * sizeof *picture);
    for (size_t i = 0; i < nqm_scene_count(scene); ++i)
        if (pixel[i] >= frame * n && pixel[i] < (frame + 1) * n)
            memcpy(picture + 3 * (pixel[i] - frame * n), rgb_cdm2 + 3 * i, 3 * sizeof *picture);
}

void frame_map(const nqm_scene *scene, const nqm_scene_options *o, size_t frame, const double *values, double *map) {
    size_t n = o->width * o->height;
    const size_t *pixel = nqm_scene_pixels(scene);
    for (size_t i = 0; i < n; ++i)
        map[i] = (double)NAN;
    for (size_t i = 0; i < nqm_scene_count(scene); ++i)
        if (pixel[i] >= frame * n && pixel[i] < (frame + 1) * n)
            map[pixel[i] - frame * n] = values[i];
}

nqm_status render_brdf(const nqm_scene *scene, const char *name, double *rgb_cdm2, nqm_error *err) {
    nqm_brdf *brdf;
    nqm_status status = nqm_brdf_open(name, &brdf, err);
    if (status == NQM_OK)
        status = nqm_scene_render(scene, brdf, rgb_cdm2, err);
    nqm_brdf_free(brdf);
    return status;
}

nqm_tone tone_of(const nqm_scene_options *o) {
    nqm_tone tone = nqm_tone_default();
    tone.white_cdm2 = 2 * o->exposure_cdm2;
    return tone;
}

void short_name(const char *argument, char *name, size_t n_name) {
    const char *colon = strchr(argument, ':'), *slash = strrchr(argument, '/');
    const char *begin = argument, *end = argument + strlen(argument);
    if (colon && strchr(colon, '=')) { /* a spec */
        end = colon;
    } else {
        begin = slash ? slash + 1 : argument;
        const char *dot = strrchr(begin, '.'), *material = slash || dot ? strrchr(begin, ':') : NULL;
        if (material)
            begin = material + 1;
        else if (dot && dot > begin)
            end = dot;
    }
    snprintf(name, n_name, "%.*s", (int)(end - begin), begin);
}
