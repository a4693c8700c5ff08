/* SPDX-License-Identifier: MIT
 *
 * Pictures of the points of a scene, and short names for captions and files.
 */
#include "nqm/label/frames.h"
#include "render/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double *make_backdrop(const nqm_scene *scene, const nqm_scene_options *o, backdrop kind) {
    static const double white_cdm2 = 10000;
    size_t n = 3 * o->width * o->height;
    double *blank = allocate(n, sizeof *blank);
    if (kind == BACKDROP_LIGHT)
        nqm_scene_background(scene, blank);
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
