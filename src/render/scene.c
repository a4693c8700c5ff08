/* SPDX-License-Identifier: MIT
 *
 * A shape under a light map, seen by an orthographic viewer. The visible points, the light directions of every point, their
 * weights and their visibility are computed once, so that a rendering is one pass of BRDF evaluations. All BRDFs use the
 * same directions: equal BRDFs give bit-identical pictures, and sampling noise cancels in differences.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdatomic.h>

enum { MIN_LIGHTS = 16, MAX_POINTS = 1 << 24, MAX_SIDE = 8192 };

static const double max_directions = 4294967296; /* limit for all points together: about ten minutes of work */

/* Incident light is stored between renderings up to this size, assuming that a quarter of the directions are blocked. */
static const double max_kept_bytes = 512.0 * 1024 * 1024;

/* ---- options ----------------------------------------------------------------------------------------------------- */

#define FIELD(name) .key = #name, .offset = offsetof(nqm_scene_options, name)

static const char *const scene_words[] = {"standard", "paper", NULL};

/* clang-format off */
static const nqm_option rows[] = {
    {FIELD(scene), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = scene_words,
     .help = "'paper' is the paper's scene, 8 views of the bunny; it needs --shape bunny.ply and --light pixar_campus_rgbe.png"},
    {FIELD(shape), .kind = NQM_OPTION_TEXT, .metavar = "SHAPE",
     .help = "'sphere', 'blob', or a mesh: PLY or OBJ (default: without --light the standard set of scenes, else 'sphere')"},
    {FIELD(light), .kind = NQM_OPTION_TEXT, .metavar = "LIGHT",
     .help = "'sun', 'overcast', 'studio', 'interior', or a latitude-longitude map: OpenEXR, Radiance HDR or RGBE in a PNG "
             "(default: without --shape the standard set of scenes, else 'sun')"},
    {FIELD(width), .name = "", .kind = NQM_OPTION_SIZE, .min = 0, .max = MAX_SIDE},
    {FIELD(height), .name = "", .kind = NQM_OPTION_SIZE, .min = 0, .max = MAX_SIDE},
    {FIELD(n_points), .name = "points", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1e7,
     .values = {"3072"}, .help = "quick mode: surface points instead of a picture (0: the picture)"},
    {FIELD(n_frames), .name = "frames", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 4096,
     .help = "views of the turntable, evenly over 360 degrees (0: 1, or 8 for the paper's scene)"},
    {FIELD(turn_rad), .name = "turn", .metavar = "DEG", .scale = NQM_PI / 180,
     .help = "angle of the turntable in the first frame"},
    {FIELD(elevation_rad), .name = "elevation", .metavar = "DEG", .scale = NQM_PI / 180, .min = -90,
     .max = 90, .help = "elevation of the viewer above the horizon"},
    {FIELD(n_lights), .name = "lights", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1 << 16,
     .help = "light directions per point (0: 128; in a picture 96, in a preview of render 32)"},
    {FIELD(light_width), .kind = NQM_OPTION_SIZE, .metavar = "N", .min = NQM_LIGHT_STEP, .max = NQM_LIGHT_MAX_WIDTH,
     .values = {"256"}, .help = "width of the filtered light map in cells, a multiple of 16"},
    {FIELD(shadows), .kind = NQM_OPTION_BOOL, .values = {"1"}, .help = "cast shadows of the shape on itself"},
    {FIELD(interreflection), .kind = NQM_OPTION_BOOL, .help = "add light that the shape reflects once onto itself"},
    {FIELD(exposure_cdm2), .name = "exposure", .metavar = "CD/M2", .min = 0.01, .max = 10000,
     .values = {"200"}, .help = "mean luminance of a white Lambert surface"},
    {FIELD(peak_cdm2), .name = "peak", .metavar = "CD/M2", .min = 0.01, .max = 10000, .values = {"1000"},
     .help = "peak luminance of the display, where pictures are clipped"},
    {FIELD(min_valid), .name = "min-valid", .metavar = "F", .min = 0, .max = 1, .values = {"0.9"},
     .help = "least fraction of the light that falls at directions where a BRDF has a value"},
    {FIELD(seed), .kind = NQM_OPTION_U64, .metavar = "N", .values = {"1"}, .help = "seed of points and light directions"},
    {FIELD(exact), .kind = NQM_OPTION_BOOL,
     .help = "evaluate neural processes for every light direction instead of interpolating a table of their values"},
};
/* clang-format on */

const nqm_option_table nqm_scene_option_table = {rows, sizeof rows / sizeof *rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_scene_option, .scene = NQM_SCENE_STANDARD)

size_t nqm_scene_n_lights(const nqm_scene_options *options) {
    if (options->n_lights)
        return options->n_lights;
    return options->width ? 96 : 128;
}

size_t nqm_scene_n_frames(const nqm_scene_options *options) {
    enum { PAPER_FRAMES = 8 };
    if (options->n_frames)
        return options->n_frames;
    return options->scene == NQM_SCENE_PAPER ? PAPER_FRAMES : 1;
}

static nqm_status check_options(const nqm_scene_options *o, nqm_error *err) {
    nqm_status status = nqm_options_check(&nqm_scene_option_table, o, err);
    if (status != NQM_OK)
        return status;
    if (o->scene == NQM_SCENE_PAPER && (!o->shape || !o->light))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "the paper's scene needs both a shape and a light: --shape bunny.ply and --light "
                        "pixar_campus_rgbe.png");
    if (o->n_lights && o->n_lights < MIN_LIGHTS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu light directions per point; at least %d are needed",
                        o->n_lights, (int)MIN_LIGHTS);
    if (!o->width != !o->height || !(o->width || o->n_points >= (nqm_scene_is_standard(o) ? NQM_STANDARD_SCENES : 1)))
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: a picture of %zu x %zu pixels and %zu points", o->width,
                        o->height, o->n_points);
    size_t n = o->width ? o->width * o->height : o->n_points, frames = o->width ? nqm_scene_frames(o) : 1;
    if (n > MAX_POINTS / frames || (double)n * (double)frames * (double)nqm_scene_n_lights(o) > max_directions)
        return nqm_fail(
            err, NQM_ERR_ARG, -1,
            "scene: %zu points with %zu light directions each; the limits are %d points and %.0f directions",
            n * frames, nqm_scene_n_lights(o), (int)MAX_POINTS, max_directions);
    if (o->light_width % NQM_LIGHT_STEP)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: the width %zu of the light map is not a multiple of %d",
                        o->light_width, (int)NQM_LIGHT_STEP);
    if (o->interreflection && !o->shadows)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: interreflection needs shadows");
    return NQM_OK;
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

static nqm_status load_lights(const nqm_scene_options *o, nqm_light *light_ret, nqm_light *glow_ret, nqm_error *err) {
    nqm_image image;
    const char *name = o->light ? o->light : "sun";
    nqm_status status =
        nqm_light_is_builtin(name) ? nqm_light_draw(name, &image, err) : nqm_image_load(name, &image, err);
    if (status != NQM_OK)
        return status;
    status = nqm_light_create(&image, o->light_width, light_ret, err);
    if (status == NQM_OK)
        status = nqm_light_create(&image, NQM_GLOW_WIDTH, glow_ret, err);
    nqm_free(image.rgb);
    return status;
}

static nqm_status load_shape(const nqm_scene_options *o, nqm_shape *shape_ret, nqm_error *err) {
    double shorter = o->width < o->height ? (double)o->width : (double)o->height;
    double half_width = o->width ? (double)o->width / shorter : 1,
           half_height = o->width ? (double)o->height / shorter : 1;
    return nqm_shape_create(o->shape, o->elevation_rad, half_width, half_height, shape_ret, err);
}

typedef struct creation {
    nqm_scene *scene;
    double *luminance; /* (n_points) of the irradiance */
    atomic_bool out_of_memory;
} creation;

static void create_point(void *user, size_t i) {
    creation *c = user;
    nqm_scene *scene = c->scene;
    nqm_surface_point point;
    double irradiance[3] = {0};
    bool ok = scene->kept ? nqm_incident_make(scene, i, NULL, &scene->kept[i], irradiance)
                          : nqm_irradiance(&scene->light, nqm_scene_point(scene, i, &point), irradiance);
    c->luminance[i] = nqm_luminance(irradiance);
    if (!ok)
        atomic_store(&c->out_of_memory, true);
}

/* Set the exposure so that a white Lambert surface (f_r = 1/pi) without shadows has the mean luminance exposure_cdm2. */
static nqm_status expose(nqm_scene *scene, const double *luminance, const nqm_scene_options *o, nqm_error *err) {
    double mean = 0;
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double weight = scene->seen.weight ? scene->seen.weight[i] : 1 / (double)scene->seen.n;
        mean += weight * luminance[i] / NQM_PI;
    }
    if (!(mean > 0) || !isfinite(mean))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the light is black in all directions that light the shape",
                        o->light ? o->light : "scene");
    scene->exposure = o->exposure_cdm2 / mean;
    return NQM_OK;
}

static bool can_keep(const nqm_scene *scene) {
    double bytes_per_direction = sizeof(nqm_ray) + (scene->options.interreflection ? sizeof(nqm_bounce) / 4.0 : 0);
    return (double)scene->seen.n * (double)scene->options.n_lights * bytes_per_direction <= max_kept_bytes;
}

static nqm_status light_points(nqm_scene *scene, const nqm_scene_options *o, nqm_error *err) {
    size_t n = scene->seen.n;
    creation c = {.scene = scene, .luminance = nqm_alloc(n, sizeof *c.luminance)};
    if (can_keep(scene))
        scene->kept = nqm_alloc(n, sizeof *scene->kept);
    if (!c.luminance || (can_keep(scene) && !scene->kept)) {
        nqm_free(c.luminance);
        return nqm_fail_nomem(err, n * (sizeof *c.luminance + sizeof *scene->kept));
    }
    nqm_ticker ticker = {.fn = o->progress, .user = o->progress_user};
    const bool stopped = nqm_parallel_ticking(&ticker, "light", n, create_point, &c);
    nqm_status status = stopped ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted")
                        : atomic_load(&c.out_of_memory)
                            ? nqm_fail_nomem(err, n * scene->options.n_lights * sizeof(nqm_ray))
                            : expose(scene, c.luminance, o, err);
    nqm_free(c.luminance);
    return status;
}

static nqm_status fill_scene(nqm_scene *scene, const nqm_scene_options *o, nqm_error *err) {
    scene->n_parts = 1;
    scene->parts[0] = scene;
    scene->options = *o;
    scene->options.light = scene->options.shape = NULL;
    scene->options.n_lights = nqm_scene_n_lights(o);
    nqm_light glow = {0};
    nqm_status status = load_lights(o, &scene->light, &glow, err);
    if (status == NQM_OK)
        status = load_shape(o, &scene->shape, err);
    if (status == NQM_OK)
        status = o->width ? nqm_view_pixels(&scene->shape, o, &scene->seen, err)
                          : nqm_spread_points(&scene->shape, &glow, o, &scene->seen, err);
    if (status == NQM_OK && !scene->seen.n)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "scene: no pixel of %zu x %zu shows the shape", o->width, o->height);
    nqm_free(glow.rgb);
    return status == NQM_OK ? light_points(scene, o, err) : status;
}

/* ---- the standard set -------------------------------------------------------------------------------------------- */

static const struct {
    const char *light, *shape;
} standard[NQM_STANDARD_SCENES] = {{"sun", "blob"}, {"overcast", "sphere"}, {"studio", "sphere"}, {"interior", "blob"}};

bool nqm_scene_is_standard(const nqm_scene_options *options) {
    return !options->light && !options->shape;
}

size_t nqm_scene_frames(const nqm_scene_options *options) {
    return nqm_scene_n_frames(options) * (nqm_scene_is_standard(options) ? NQM_STANDARD_SCENES : 1);
}

/* Concatenate the weights and pixels of the parts; each part has the same total weight. */
static nqm_status join_parts(nqm_scene *scene, nqm_error *err) {
    const nqm_scene_options *o = &scene->options;
    nqm_seen *all = &scene->seen;
    for (size_t p = 0; p < scene->n_parts; ++p)
        all->n += scene->parts[p]->seen.n;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&all->block, 0, 1}, {&all->weight, all->n, sizeof *all->weight},
                                                    {&all->pixel, o->width ? all->n : 0, sizeof *all->pixel}),
                                         err);
    all->pixel = o->width ? all->pixel : NULL;
    for (size_t p = 0, at = 0; status == NQM_OK && p < scene->n_parts; ++p) {
        const nqm_seen *part = &scene->parts[p]->seen;
        for (size_t i = 0; i < part->n; ++i, ++at) {
            all->weight[at] = (part->weight ? part->weight[i] : 1 / (double)part->n) / (double)scene->n_parts;
            if (o->width)
                all->pixel[at] = part->pixel[i] + p * o->n_frames * o->width * o->height;
        }
    }
    return status;
}

static int report_part(void *user, const char *stage, double done, double total) {
    const nqm_scene_part *part = user;
    const nqm_scene_options *o = part->options;
    if (part->n == 1)
        return o->progress(o->progress_user, stage, done, total);
    return o->progress(o->progress_user, stage, 100 * ((double)part->index + done / total) / (double)part->n, 100);
}

nqm_ticker nqm_scene_part_ticker(nqm_scene_part *part) {
    return (nqm_ticker){.fn = part->options->progress ? report_part : NULL, .user = part};
}

static nqm_status fill_parts(nqm_scene *scene, const nqm_scene_options *o, nqm_error *err) {
    nqm_status status = NQM_OK;
    scene->options = *o;
    scene->options.n_lights = nqm_scene_n_lights(o);
    for (size_t p = 0; status == NQM_OK && p < NQM_STANDARD_SCENES; ++p) {
        nqm_scene_options part = *o;
        part.light = standard[p].light;
        part.shape = standard[p].shape;
        part.n_points = (o->n_points + p) / NQM_STANDARD_SCENES;
        nqm_scene_part place = {o, p, NQM_STANDARD_SCENES};
        const nqm_ticker ticker = nqm_scene_part_ticker(&place);
        part.progress = ticker.fn;
        part.progress_user = ticker.user;
        status = nqm_scene_create(&part, &scene->parts[p], err);
        scene->n_parts += status == NQM_OK;
    }
    return status == NQM_OK ? join_parts(scene, err) : status;
}

/* ---- entry -------------------------------------------------------------------------------------------------------- */

nqm_status nqm_scene_create(const nqm_scene_options *options, nqm_scene **scene_ret, nqm_error *err) {
    NQM_REQUIRE(err, scene_ret);
    *scene_ret = NULL;
    nqm_scene_options o = options ? *options : nqm_scene_options_default();
    nqm_status status = check_options(&o, err);
    if (status != NQM_OK)
        return status;
    nqm_scene *scene = nqm_alloc(1, sizeof *scene);
    if (!scene)
        return nqm_fail_nomem(err, sizeof *scene);
    o.n_frames = nqm_scene_n_frames(&o);
    status = nqm_scene_is_standard(&o) ? fill_parts(scene, &o, err) : fill_scene(scene, &o, err);
    if (status == NQM_OK)
        *scene_ret = scene;
    else
        nqm_scene_free(scene);
    return status;
}

void nqm_scene_free(nqm_scene *scene) {
    if (!scene)
        return;
    for (size_t i = 0; scene->kept && i < scene->seen.n; ++i)
        nqm_free(scene->kept[i].ray);
    nqm_free(scene->kept);
    nqm_free(scene->seen.block);
    nqm_shape_clear(&scene->shape);
    nqm_free(scene->light.rgb);
    for (size_t i = 0; i < scene->n_parts && scene->parts[i] != scene; ++i)
        nqm_scene_free(scene->parts[i]);
    nqm_free(scene);
}

nqm_scene_info nqm_scene_get_info(const nqm_scene *scene) {
    assert(scene);
    return (nqm_scene_info){scene->seen.n, scene->seen.weight, scene->seen.pixel};
}
