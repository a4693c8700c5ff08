/* SPDX-License-Identifier: MIT
 *
 * The scene options of the command line: the size of the picture, and the scene in JSON.
 */
#include "nqm/label/scene_args.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_SIDE = 4096 };

scene_args scene_args_begin(void) {
    scene_args a = {.scene = nqm_scene_options_default(), .size = "256"};
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
}

json_t *json_scene(const nqm_scene_options *s) {
    const double degree = 3.14159265358979323846 / 180;
    json_t *scene = json_pack(
        "{s:o,s:o,s:I,s:f,s:f,s:I,s:f,s:f,s:I,s:b,s:b,s:I}", "shape", json_name(s->shape ? s->shape : "sphere"),
        "light", json_name(s->light ? s->light : "built-in sky"), "light_width", (json_int_t)s->light_width,
        "exposure_cdm2", s->exposure_cdm2, "peak_cdm2", s->peak_cdm2, "frames", (json_int_t)s->n_frames, "turn",
        s->turn_rad / degree, "elevation", s->elevation_rad / degree, "lights", (json_int_t)nqm_scene_n_lights(s),
        "shadows", s->shadows, "interreflection", s->interreflection, "seed", (json_int_t)s->seed);
    if (s->width) {
        json_object_set_new(scene, "width", json_integer((json_int_t)s->width));
        json_object_set_new(scene, "height", json_integer((json_int_t)s->height));
    } else {
        json_object_set_new(scene, "points", json_integer((json_int_t)s->n_points));
    }
    return scene;
}
