/* SPDX-License-Identifier: MIT
 *
 * The implementation of scene.h.
 */
#include "nqm/label/scene.h"
#include "base/os.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_SIDE = 4096 };

int show_scene_progress(void *user, const char *stage, double done, double total) {
    static double percent; /* percentage of the stage "light" */
    const bool is_light = strcmp(stage, "light") == 0;
    if (!is_light && strcmp(stage, "view") != 0)
        return show_progress(user, stage, done, total);
    if (is_light)
        percent = 100 * done / total;
    return show_progress(user, "light", percent, 100);
}

scene_args scene_args_begin(void) {
    scene_args a = {.scene = nqm_scene_options_default()};
    a.scene.progress = show_scene_progress;
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

/* A misspelt built-in name is not a missing file. names: built in, NULL-terminated. */
static void check_place(const char *option_name, const char *path, const char *const *names) {
    char known[80] = "";
    nqm_nearest nearest = nqm_nearest_begin(path ? path : "");
    for (size_t i = 0, n = 0; path && names[i]; ++i) {
        if (strcmp(names[i], path) == 0)
            return;
        nqm_nearest_add(&nearest, names[i]);
        n += (size_t)snprintf(known + n, sizeof known - n, "%s%s", i ? ", " : "", names[i]);
    }
    if (path && strcmp(path, "-") != 0 && !nqm_os_exists(path))
        stop(EXIT_OPEN, "%s: there is no file '%s'%s; built in are %s", option_name, path, nearest.advice, known);
}

void check_scene_files(const nqm_scene_options *s) {
    static const char *const shapes[] = {"sphere", "blob", NULL};
    static const char *const lights[] = {"sun", "overcast", "studio", "interior", NULL};
    check_place("--shape", s->shape, shapes);
    check_place("--light", s->light, lights);
}

void scene_args_end(scene_args *a) {
    nqm_scene_options *s = &a->scene;
    check_scene_files(s);
    if (a->size && !parse_size(a->size, &s->width, &s->height))
        stop(EXIT_USAGE, "--size needs a size in pixels, '256' or '320x200', with sides of at most %d pixels, not '%s'",
             (int)MAX_SIDE, a->size);
    s->n_frames = nqm_scene_n_frames(s);
    if (s->n_points)
        s->width = s->height = 0;
    else if (!a->size && a->side)
        s->width = s->height = a->side / all_frames(s).n_columns;
    else if (!a->size)
        s->n_points = nqm_scene_options_default().n_points;
}

json_t *json_scene(const nqm_scene_options *s) {
    const double degree = 3.14159265358979323846 / 180;
    const bool is_standard = nqm_scene_is_standard(s);
    const bool is_picture = s->width != 0;
    return json_row("shape:s light:s light_width:z exposure_cdm2:f peak_cdm2:f frames:z turn:f elevation:f lights:z "
                    "shadows:b interreflection:b seed:z width:o height:o points:o",
                    is_standard ? "standard"
                    : s->shape  ? s->shape
                                : "sphere",
                    is_standard ? "standard"
                    : s->light  ? s->light
                                : "sun",
                    s->light_width, s->exposure_cdm2, s->peak_cdm2, s->n_frames, s->turn_rad / degree,
                    s->elevation_rad / degree, nqm_scene_n_lights(s), s->shadows, s->interreflection, (size_t)s->seed,
                    is_picture ? json_integer((json_int_t)s->width) : NULL,
                    is_picture ? json_integer((json_int_t)s->height) : NULL,
                    is_picture ? NULL : json_integer((json_int_t)s->n_points));
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

canvas one_frame(const nqm_scene_options *o, size_t frame) {
    return (canvas){.first = frame, .n_columns = 1, .n_rows = 1, .width = o->width, .height = o->height};
}

canvas all_frames(const nqm_scene_options *o) {
    canvas c = one_frame(o, 0);
    const size_t n = nqm_scene_frames(o);
    while (c.n_columns * c.n_columns < n)
        ++c.n_columns;
    c.n_rows = (n + c.n_columns - 1) / c.n_columns;
    c.width *= c.n_columns;
    c.height *= c.n_rows;
    return c;
}

/* Index in the canvas of pixel i of the scene; SIZE_MAX if the canvas does not show it. */
static size_t place_of(const canvas *c, size_t pixel) {
    const size_t width = c->width / c->n_columns, height = c->height / c->n_rows, frame = pixel / (width * height);
    if (frame < c->first || frame - c->first >= c->n_columns * c->n_rows)
        return SIZE_MAX;
    const size_t cell = frame - c->first, x = pixel % width, y = pixel / width % height;
    return (cell / c->n_columns * height + y) * c->width + cell % c->n_columns * width + x;
}

static double *make_backdrop(const nqm_scene *scene, const canvas *c, backdrop kind) {
    static const double white_cdm2 = 10000;
    size_t n = 3 * c->width * c->height;
    double *blank = allocate(n, sizeof *blank);
    if (kind == BACKDROP_LIGHT)
        nqm_scene_background(scene, c->first, blank);
    for (size_t i = 0; kind == BACKDROP_WHITE && i < n; ++i)
        blank[i] = white_cdm2;
    return blank;
}

double *draw_picture(const nqm_scene *scene, const canvas *c, backdrop kind, const double *rgb_cdm2) {
    const size_t *pixel = nqm_scene_get_info(scene).pixels;
    double *picture = make_backdrop(scene, c, kind);
    for (size_t i = 0; i < nqm_scene_get_info(scene).n_points; ++i) {
        const size_t place = place_of(c, pixel[i]);
        if (place != SIZE_MAX)
            memcpy(picture + 3 * place, rgb_cdm2 + 3 * i, 3 * sizeof *picture);
    }
    return picture;
}

void draw_map(const nqm_scene *scene, const canvas *c, const double *values, double *map) {
    const size_t *pixel = nqm_scene_get_info(scene).pixels;
    for (size_t i = 0; i < c->width * c->height; ++i)
        map[i] = (double)NAN;
    for (size_t i = 0; i < nqm_scene_get_info(scene).n_points; ++i) {
        const size_t place = place_of(c, pixel[i]);
        if (place != SIZE_MAX)
            map[place] = values[i];
    }
}

nqm_status render_brdf(const nqm_scene *scene, nqm_argument *argument, bool with_halves, double *rgb_cdm2, rendered *r,
                       nqm_error *err) {
    static bool is_said;
    nqm_status status = nqm_argument_open(argument, &r->brdf, err);
    r->valid = 1;
    r->is_tabulated = status == NQM_OK && nqm_scene_tabulates(scene, r->brdf);
    if (r->is_tabulated && !is_said)
        report(EXIT_OK,
               "neural processes are evaluated once into a table, which the pictures interpolate (--exact: they "
               "are evaluated for every light direction)");
    is_said = is_said || r->is_tabulated;
    if (status != NQM_OK)
        return status;
    report_remark(r->brdf);
    return nqm_scene_render(scene, r->brdf, with_halves, rgb_cdm2, &r->valid, err);
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
