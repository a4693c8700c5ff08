/* SPDX-License-Identifier: MIT
 *
 * The options of a scene: their table, and from degrees and sizes as text to what the library takes.
 */
#include "nqm/label/scene_args.h"

#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

enum { MAX_SIDE = 4096 };

scene_args scene_args_begin(void) {
    nqm_scene_options scene = nqm_scene_options_default();
    return (scene_args){.scene = scene,
                        .size = "256",
                        .n_frames = scene.n_frames,
                        .n_lights = scene.n_lights,
                        .light_width = scene.light_width};
}

void scene_args_table(scene_args *a, option *table) {
    nqm_scene_options *s = &a->scene;
    const option options[] = {
        {"shape", 0, OPTION_TEXT, &s->shape, "SHAPE", "'sphere' (default), 'blob', or a mesh: PLY or OBJ", 0, 0},
        {"light", 0, OPTION_TEXT, &s->light, "FILE",
         "latitude-longitude map: OpenEXR, Radiance HDR or RGBE in a PNG; else a built-in sky", 0, 0},
        {"size", 0, OPTION_TEXT, &a->size, "N|WxH", "picture in pixels", 0, 0},
        {"points", 0, OPTION_COUNT, &a->n_points, "N",
         "quick mode: so many points of the shape instead of a picture (0: the picture)", 0, 1 << 20},
        {"frames", 0, OPTION_COUNT, &a->n_frames, "N", "views of the turntable, evenly over 360 degrees", 1, 3600},
        {"turn", 0, OPTION_NUMBER, &a->turn_deg, "DEG", "angle of the turntable in the first frame", -3600, 3600},
        {"elevation", 0, OPTION_NUMBER, &a->elevation_deg, "DEG", "of the viewer above the horizon", -90, 90},
        {"lights", 0, OPTION_COUNT, &a->n_lights, "N", "light directions a point (0: 128, or 96 in a picture)", 0,
         1 << 16},
        {"light-width", 0, OPTION_COUNT, &a->light_width, "N", "cells across the light map, once filtered", 16, 4096},
        {"no-shadows", 0, OPTION_FLAG, &a->no_shadows, NULL, "the shape keeps no light from itself", 0, 0},
        {"interreflection", 0, OPTION_FLAG, &a->interreflection, NULL, "add light that the shape reflects onto itself",
         0, 0},
        {"exposure", 0, OPTION_NUMBER, &s->exposure_cdm2, "CD/M2",
         "how bright a white Lambert surface shows on average", 0.01, 10000},
        {"peak", 0, OPTION_NUMBER, &s->peak_cdm2, "CD/M2", "peak of the display; brighter is clipped", 0.01, 10000},
        {"seed", 0, OPTION_COUNT, &s->seed, "N", "of the light directions", 0, 0},
        {0}};
    _Static_assert(sizeof options / sizeof *options == N_SCENE_OPTIONS + 1, "the count in the header");
    while (table->name)
        ++table;
    memcpy(table, options, sizeof options);
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

int scene_args_end(const char *verb, scene_args *a) {
    nqm_scene_options *s = &a->scene;
    if (!parse_size(a->size, &s->width, &s->height))
        return report(verb, EXIT_USAGE,
                      "--size needs a size in pixels, '256' or '320x200', at most %d a side, not '%s'", (int)MAX_SIDE,
                      a->size);
    if (a->n_points) {
        s->width = s->height = 0;
        s->n_points = (size_t)a->n_points;
    }
    s->n_frames = (size_t)a->n_frames;
    s->n_lights = (size_t)a->n_lights;
    s->light_width = (size_t)a->light_width;
    s->turn_rad = a->turn_deg * degree;
    s->elevation_rad = a->elevation_deg * degree;
    s->shadows = !a->no_shadows;
    s->interreflection = a->interreflection;
    return EXIT_OK;
}

json_t *json_scene(const nqm_scene_options *s) {
    json_t *scene = json_pack(
        "{s:o,s:o,s:I,s:f,s:f,s:I,s:f,s:f,s:I,s:b,s:b,s:I}", "shape", json_name(s->shape ? s->shape : "sphere"),
        "light", json_name(s->light ? s->light : "built-in sky"), "light_width", (json_int_t)s->light_width,
        "exposure_cdm2", s->exposure_cdm2, "peak_cdm2", s->peak_cdm2, "frames", (json_int_t)s->n_frames, "turn",
        s->turn_rad / degree, "elevation", s->elevation_rad / degree, "lights", (json_int_t)nqm_scene_options_lights(s),
        "shadows", s->shadows, "interreflection", s->interreflection, "seed", (json_int_t)s->seed);
    if (s->width) {
        json_object_set_new(scene, "width", json_integer((json_int_t)s->width));
        json_object_set_new(scene, "height", json_integer((json_int_t)s->height));
    } else {
        json_object_set_new(scene, "points", json_integer((json_int_t)s->n_points));
    }
    return scene;
}
