/* SPDX-License-Identifier: MIT
 *
 * A shape under a light map, seen from far away. The visible points, the light directions of every point, their weights
 * and what the shape blocks of them are found once, so that a rendering is one pass of BRDF evaluations; all BRDFs
 * share them, so equal BRDFs give equal pictures to the last bit, and differences are not drowned in noise.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdatomic.h>

enum { MIN_LIGHTS = 16, MAX_LIGHTS = 1 << 16, MAX_POINTS = 1 << 24, MAX_SIDE = 8192, MAX_FRAMES = 4096 };

static const double max_directions = 4294967296; /* some ten minutes */

/* Directions are kept while they fit; a quarter of them blocked is a common share. */
static const double max_kept_bytes = 512.0 * 1024 * 1024;

nqm_scene_options nqm_scene_options_default(void) {
    return (nqm_scene_options){.n_points = 3072,
                               .n_frames = 1,
                               .light_width = NQM_LIGHT_WIDTH,
                               .shadows = 1,
                               .exposure_cdm2 = 200,
                               .peak_cdm2 = 1000,
                               .seed = 1};
}

size_t nqm_scene_options_lights(const nqm_scene_options *options) {
    if (options->n_lights)
        return options->n_lights;
    return options->width ? 96 : 128;
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

static nqm_status check_size(const nqm_scene_options *o, nqm_error *err) {
    if (o->n_lights && (o->n_lights < MIN_LIGHTS || o->n_lights > MAX_LIGHTS))
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu light directions a point; %d to %d are possible", o->n_lights,
                        (int)MIN_LIGHTS, (int)MAX_LIGHTS);
    if (o->n_frames < 1 || o->n_frames > MAX_FRAMES)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu frames; 1 to %d are possible", o->n_frames, (int)MAX_FRAMES);
    if (!o->width && (o->n_points < 1 || o->n_points > MAX_POINTS))
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu points; 1 to %d are possible", o->n_points, (int)MAX_POINTS);
    if (o->width > MAX_SIDE || o->height > MAX_SIDE || !o->width != !o->height)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: a picture of %zu x %zu pixels; 1 x 1 to %d x %d are possible",
                        o->width, o->height, (int)MAX_SIDE, (int)MAX_SIDE);
    size_t n = o->width ? o->width * o->height : o->n_points, frames = o->width ? o->n_frames : 1;
    if (n > MAX_POINTS / frames || (double)n * (double)frames * (double)nqm_scene_options_lights(o) > max_directions)
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "scene: %zu points of %zu light directions; at most %d and %.0f in all are possible",
                        n * frames, nqm_scene_options_lights(o), (int)MAX_POINTS, max_directions);
    return NQM_OK;
}

static nqm_status check_options(const nqm_scene_options *o, nqm_error *err) {
    nqm_status status = check_size(o, err);
    if (status != NQM_OK)
        return status;
    if (o->light_width < NQM_LIGHT_STEP || o->light_width > NQM_LIGHT_MAX_WIDTH || o->light_width % NQM_LIGHT_STEP)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: a light map %zu wide; multiples of %d up to %d are possible",
                        o->light_width, (int)NQM_LIGHT_STEP, (int)NQM_LIGHT_MAX_WIDTH);
    if (!isfinite(o->turn_rad) || !(fabs(o->elevation_rad) <= NQM_PI / 2 + 1e-9))
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: the elevation must lie within 90 degrees, the turn be finite");
    if (o->interreflection && !o->shadows)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: interreflection needs shadows");
    if (!(o->exposure_cdm2 > 0 && o->exposure_cdm2 <= 10000) || !(o->peak_cdm2 > 0 && o->peak_cdm2 <= 10000))
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: exposure and peak must lie in (0, 10000] cd/m2");
    return NQM_OK;
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

static nqm_status load_lights(const nqm_scene_options *o, nqm_light *light_ret, nqm_light *glow_ret, nqm_error *err) {
    nqm_image image;
    nqm_status status = o->light ? nqm_image_load(o->light, &image, err) : nqm_sky_draw(&image, err);
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
    double *irradiance; /* (n_points, 3) */
    atomic_bool out_of_memory;
} creation;

static void create_point(void *user, size_t i) {
    creation *c = user;
    nqm_scene *scene = c->scene;
    double *irradiance = c->irradiance + 3 * i;
    bool ok = scene->kept ? nqm_incident_make(scene, i, &scene->kept[i], irradiance)
                          : nqm_irradiance(&scene->light, &scene->seen.point[i], irradiance);
    if (!ok)
        atomic_store(&c->out_of_memory, true);
}

/* A white Lambert surface (f_r = 1/pi) without shadows is to show at exposure_cdm2 on average. */
static nqm_status expose(nqm_scene *scene, const double *irradiance, const nqm_scene_options *o, nqm_error *err) {
    double mean = 0;
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double share = scene->seen.share ? scene->seen.share[i] : 1 / (double)scene->seen.n;
        mean += share * nqm_luminance(irradiance + 3 * i) / NQM_PI;
    }
    if (!(mean > 0) || !isfinite(mean))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the light is black where the shape could see it",
                        o->light ? o->light : "scene");
    scene->exposure = o->exposure_cdm2 / mean;
    return NQM_OK;
}

static bool can_keep(const nqm_scene *scene) {
    double a_direction = sizeof(nqm_ray) + (scene->options.interreflection ? sizeof(nqm_bounce) / 4.0 : 0);
    return (double)scene->seen.n * (double)scene->options.n_lights * a_direction <= max_kept_bytes;
}

static nqm_status light_points(nqm_scene *scene, const nqm_scene_options *o, nqm_error *err) {
    creation c = {.scene = scene, .irradiance = nqm_alloc(scene->seen.n, 3 * sizeof(double))};
    if (can_keep(scene)) {
        scene->kept = nqm_alloc(scene->seen.n, sizeof *scene->kept);
        if (!scene->kept)
            atomic_store(&c.out_of_memory, true);
    }
    if (!c.irradiance || atomic_load(&c.out_of_memory)) {
        nqm_free(c.irradiance);
        return nqm_fail_nomem(err, scene->seen.n * (3 * sizeof(double) + sizeof *scene->kept));
    }
    nqm_parallel_for(scene->seen.n, create_point, &c);
    nqm_status status = atomic_load(&c.out_of_memory)
                            ? nqm_fail_nomem(err, scene->seen.n * scene->options.n_lights * sizeof(nqm_ray))
                            : expose(scene, c.irradiance, o, err);
    nqm_free(c.irradiance);
    return status;
}

static nqm_status fill_scene(nqm_scene *scene, const nqm_scene_options *o, nqm_error *err) {
    scene->options = *o;
    scene->options.light = scene->options.shape = NULL;
    scene->options.n_lights = nqm_scene_options_lights(o);
    nqm_light glow = {0};
    nqm_status status = load_lights(o, &scene->light, &glow, err);
    if (status == NQM_OK)
        status = load_shape(o, &scene->shape, err);
    if (status == NQM_OK)
        status = nqm_view_points(&scene->shape, &glow, o, &scene->seen, err);
    if (status == NQM_OK && !scene->seen.n)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "scene: no pixel of %zu x %zu shows the shape", o->width, o->height);
    nqm_light_clear(&glow);
    return status == NQM_OK ? light_points(scene, o, err) : status;
}

nqm_status nqm_scene_create(const nqm_scene_options *options, nqm_scene **scene_ret, nqm_error *err) {
    nqm_scene_options defaults = nqm_scene_options_default();
    const nqm_scene_options *o = options ? options : &defaults;
    *scene_ret = NULL;
    nqm_status status = check_options(o, err);
    if (status != NQM_OK)
        return status;
    nqm_scene *scene = nqm_alloc(1, sizeof *scene);
    if (!scene)
        return nqm_fail_nomem(err, sizeof *scene);
    status = fill_scene(scene, o, err);
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
        nqm_incident_clear(&scene->kept[i]);
    nqm_free(scene->kept);
    nqm_seen_clear(&scene->seen);
    nqm_shape_clear(&scene->shape);
    nqm_light_clear(&scene->light);
    nqm_free(scene);
}

size_t nqm_scene_count(const nqm_scene *scene) {
    return scene->seen.n;
}

const size_t *nqm_scene_pixels(const nqm_scene *scene) {
    return scene->seen.pixel;
}

const double *nqm_scene_shares(const nqm_scene *scene) {
    return scene->seen.share;
}
