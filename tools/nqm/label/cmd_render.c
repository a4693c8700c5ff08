/* SPDX-License-Identifier: MIT
 *
 * nqm render - pictures of a BRDF on a lit shape.
 */
#include "nqm/label/scene.h"
#include "nqm/textured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PREVIEW_LIGHTS = 32 };

typedef struct render_run {
    const char *brdf, *output;
    nqm_scene_options scene;
    nqm_texture_view view; /* of a textured material */
    size_t supersample;
    backdrop backdrop;
    bool json;
    rendered made_of; /* of a BRDF, not a textured material */
    nqm_scene *made;
    double *rgb_cdm2; /* (points, 3) */
} render_run;

static const char *ending_of(const char *path) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    return dot && dot > (slash ? slash : path) ? dot : path + strlen(path);
}

/* The file of a frame, counted from 1: its number replaces "%d" or "%04d" in the name; without them "-0001" is inserted before
 * the ending if there are several frames. */
static void frame_path(const render_run *run, size_t frame, char *path, size_t n_path) {
    const char *mark = strchr(run->output, '%'), *ending = ending_of(run->output);
    size_t n_digits = mark ? strspn(mark + 1, "0123456789") : 0;
    int digits = 4;
    const char *rest = ending;
    if (mark && mark[1 + n_digits] == 'd') {
        digits = n_digits ? atoi(mark + 1) : 1;
        rest = mark + 2 + n_digits;
    } else if (run->scene.n_frames == 1) {
        snprintf(path, n_path, "%s", run->output);
        return;
    } else {
        mark = NULL;
    }
    snprintf(path, n_path, "%.*s%s%0*zu%s", (int)((mark ? mark : ending) - run->output), run->output, mark ? "" : "-",
             digits > 9 ? 9 : digits, frame, rest);
}

/* Mean and maximum of luminance over the pixels of the shape. */
static json_t *json_light(const render_run *run) {
    double sum = 0, most = 0;
    size_t n = nqm_scene_get_info(run->made).n_points;
    for (size_t i = 0; i < n; ++i) {
        const double *rgb = run->rgb_cdm2 + 3 * i;
        double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        sum += luminance;
        most = fmax(most, luminance);
    }
    return json_row("mean:f max:f", sum / (double)n, most);
}

static void write_frames(const render_run *run, json_t *files) {
    const nqm_tone tone = tone_of(&run->scene);
    for (size_t frame = 0; frame < run->scene.n_frames; ++frame) {
        char path[4096];
        const canvas c = one_frame(&run->scene, frame);
        frame_path(run, frame + 1, path, sizeof path);
        double *rgb = draw_picture(run->made, &c, run->backdrop, run->rgb_cdm2);
        const nqm_picture picture = {.width = run->scene.width, .height = run->scene.height, .rgb_cdm2 = rgb};
        must(nqm_picture_write(path, &picture, run->supersample, &tone, &fault));
        free(rgb);
        json_array_append_new(files, json_name(path));
    }
}

static void run_render(render_run *run) {
    nqm_texture *texture = NULL;
    nqm_argument *argument = parse_argument(run->brdf);
    if (nqm_argument_is_textured(argument))
        must(open_texture(argument, &texture, &fault));
    must(nqm_scene_create(&run->scene, &run->made, &fault));
    run->rgb_cdm2 = allocate((texture ? 9 : 3) * nqm_scene_get_info(run->made).n_points, sizeof *run->rgb_cdm2);
    must(texture ? nqm_scene_render_texture(run->made, texture, &run->view, run->rgb_cdm2, &fault)
                 : render_brdf(run->made, argument, false, run->rgb_cdm2, &run->made_of, &fault));
    nqm_texture_free(texture);
    nqm_argument_free(argument);
    nqm_brdf_free(run->made_of.brdf);
    if (run->made_of.valid < 1)
        report(EXIT_OK, "%s has no value for directions of %.3g %% of the light, which is missing in the picture",
               shown(run->brdf), 100 * (1 - run->made_of.valid));
    end_progress();
    json_t *files = json_array();
    write_frames(run, files);
    if (run->json)
        print_document(json_row("brdf:s tabulated:b valid:f scene:o supersample:z luminance_cdm2:o files:O", run->brdf,
                                run->made_of.is_tabulated, run->made_of.valid, json_scene(&run->scene),
                                run->supersample, json_light(run), files));
    json_decref(files);
    nqm_scene_free(run->made);
    free(run->rgb_cdm2);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static render_run run = {.made_of = {.valid = 1}};
static scene_args scene;
static view_args view;
static const char *background;
static bool quality;
static uint64_t supersample;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &run.output, "FILE.png|.exr|.hdr",
     "tone-mapped, or (.exr, .hdr) cd/m2; several frames: %d or -0001", 0, 0},
    {"background", 0, OPTION_TEXT, &background, "WHAT", "white (for .png), black (for the others) or light", 0, 0},
    {"supersample", 0, OPTION_COUNT, &supersample, "N", "N x N points per pixel (0: 1, or 2 with --quality)", 0, 16},
    {"quality", 0, OPTION_FLAG, &quality, NULL,
     "2 x 2 points per pixel and 96 light directions per point, instead of 1 and 32: ten times the work", 0, 0},
    {"json", 0, OPTION_FLAG, &run.json, NULL, "print JSON", 0, 0},
    OPTION_ROW_TILES(&view),
    OPTION_ROW_TEXELS(&view),
    OPTION_ROW_SIZE(&scene, "pixels of a frame"),
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "BRDF -o FILE [options]",
    .about = "Render a BRDF on a shape under a light map. Linear cd/m2 go to OpenEXR or Radiance HDR; a PNG shows "
             "twice the exposure as white and compresses highlights smoothly. The default is a preview of a second or"
             " two; --quality has less noise. doc/labels.md describes the scene.",
    .example = "nqm render sgd:nickel -o nickel.png\n"
               "nqm render measured.bsdf -o turn-%03d.png --shape bunny.ply --light probe.exr --frames 36 "
               "--elevation 15\n"
               "nqm render 'ggx:kd=.1,.1,.1;alpha=.2' -o blob.exr --shape blob --interreflection --size 640x480",
    .options = options,
    .table = &nqm_scene_option_table,
    .table_target = &scene.scene,
    .min_arguments = 1,
};

int cmd_render(int argc, char **argv) {
    scene = scene_args_begin();
    view = view_args_begin();
    scene.size = "256";
    static const char *const backdrops[] = {
        [BACKDROP_WHITE] = "white", [BACKDROP_BLACK] = "black", [BACKDROP_LIGHT] = "light", NULL};
    parse_arguments(&cmd, argc, argv);
    scene_args_end(&scene);
    if (!scene.scene.width)
        stop(EXIT_USAGE, "--points renders no picture");
    /* Default background: white in PNGs, black in pictures of cd/m2. */
    const char *usual = strcmp(ending_of(run.output), ".png") == 0 ? "white" : "black";
    run.backdrop = (backdrop)choose("background", backdrops, background ? background : usual);
    refuse_model_name(argv[0]);
    run.brdf = argv[0];
    run.scene = scene.scene;
    run.view = view_of(&view);
    if (nqm_scene_is_standard(&run.scene))
        run.scene.light = "sun"; /* one picture rather than four */
    run.supersample = supersample ? (size_t)supersample : quality ? 2 : 1;
    if (!quality && !run.scene.n_lights)
        run.scene.n_lights = PREVIEW_LIGHTS;
    run.scene.width *= run.supersample;
    run.scene.height *= run.supersample;
    if (run.scene.width > 8192 || run.scene.height > 4096)
        stop(EXIT_USAGE, "--size with %zu x %zu points per pixel (--supersample): at most %zu x %zu pixels",
             run.supersample, run.supersample, 8192 / run.supersample, 4096 / run.supersample);
    run_render(&run);
    return EXIT_OK;
}
