/* SPDX-License-Identifier: MIT
 *
 * A sphere under a light map, seen from far away: each visible point stands for a pixel. The light directions of every
 * point and their weights are chosen once, so that a rendering is one pass of BRDF evaluations; all BRDFs share them,
 * so equal BRDFs give equal pictures to the last bit, and differences are not drowned in noise. Direct light only.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

static const double max_view_deg = 85; /* the outermost ring of the sphere is left out: less than 1 % of the picture */

enum { MAX_PAIRS = 1 << 24, MIN_LIGHTS = 16, MAX_LIGHTS = 1 << 16, BLOCK = 256 };

nqm_scene_options nqm_scene_options_default(void) {
    return (nqm_scene_options){.n_points = 1024, .n_lights = 384, .exposure_cdm2 = 200, .peak_cdm2 = 1000, .seed = 1};
}

static nqm_status check_options(const nqm_scene_options *o, nqm_error *err) {
    if (o->n_lights < MIN_LIGHTS || o->n_lights > MAX_LIGHTS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu light directions a point; %d to %d are possible", o->n_lights,
                        (int)MIN_LIGHTS, (int)MAX_LIGHTS);
    if (o->n_points < 1 || o->n_points > MAX_PAIRS / o->n_lights)
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu points of %zu light directions; 1 to %d pairs are possible",
                        o->n_points, o->n_lights, (int)MAX_PAIRS);
    if (!(o->exposure_cdm2 > 0 && o->exposure_cdm2 <= 10000) || !(o->peak_cdm2 > 0 && o->peak_cdm2 <= 10000))
        return nqm_fail(err, NQM_ERR_ARG, -1, "scene: exposure and peak must lie in (0, 10000] cd/m2");
    return NQM_OK;
}

/* Points of a sunflower (Vogel 1979, DOI 10.1016/0025-5564(79)90080-4): even in area over the disc, for any number. */
static void place_point(size_t i, size_t n, double turn, nqm_surface_point *point) {
    const double golden_angle = NQM_PI * (3 - sqrt(5));
    double r = sin(max_view_deg * NQM_PI / 180) * sqrt(((double)i + 0.5) / (double)n);
    double phi = turn + golden_angle * (double)i;
    double *tangent = point->frame, *bitangent = point->frame + 3, *normal = point->frame + 6;
    double cos_view = sqrt(1 - r * r);
    /* The viewer is +z = cos_view normal + r tangent. */
    const double n_[3] = {r * cos(phi), r * sin(phi), cos_view};
    const double t_[3] = {-cos_view * cos(phi), -cos_view * sin(phi), r};
    memcpy(normal, n_, sizeof n_);
    memcpy(tangent, t_, sizeof t_);
    nqm_cross3(normal, tangent, bitangent);
    point->wo[0] = r;
    point->wo[1] = 0;
    point->wo[2] = cos_view;
}

typedef struct creation {
    nqm_scene *scene;
    const nqm_light *light;
    uint64_t seed;
    double *irradiance; /* (n_points, 3) */
    atomic_bool out_of_memory;
} creation;

static void create_point(void *user, size_t i) {
    creation *c = user;
    nqm_scene *scene = c->scene;
    double turn = 2 * NQM_PI * (double)(nqm_hash_u64(c->seed, UINT64_MAX) >> 11) * 0x1p-53;
    place_point(i, scene->n_points, turn, &scene->point[i]);
    nqm_direction_set set = {.n_max = scene->n_lights,
                             .wi = scene->wi + 3 * i * scene->n_lights,
                             .weight = scene->weight + 3 * i * scene->n_lights};
    if (!nqm_choose_directions(c->light, &scene->point[i], nqm_hash_u64(c->seed, i), &set))
        atomic_store(&c->out_of_memory, true);
    scene->n_used[i] = set.n_used;
    memcpy(c->irradiance + 3 * i, set.irradiance, sizeof set.irradiance);
}

/* Scale the weights so that a white Lambert surface (f_r = 1/pi) shows at exposure_cdm2 on average. */
static nqm_status expose(nqm_scene *scene, const double *irradiance, const nqm_scene_options *o, nqm_error *err) {
    double sum = 0;
    for (size_t i = 0; i < scene->n_points; ++i)
        sum += nqm_luminance(irradiance + 3 * i) / NQM_PI;
    double mean = sum / (double)scene->n_points;
    if (!(mean > 0) || !isfinite(mean))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the light is black where the shape could see it",
                        o->light ? o->light : "scene");
    for (size_t i = 0; i < 3 * scene->n_points * scene->n_lights; ++i)
        scene->weight[i] *= o->exposure_cdm2 / mean;
    return NQM_OK;
}

static nqm_status load_light(const char *path, nqm_light *light_ret, nqm_error *err) {
    nqm_image image;
    *light_ret = (nqm_light){0};
    nqm_status status = path ? nqm_image_load(path, &image, err) : nqm_sky_draw(&image, err);
    if (status != NQM_OK)
        return status;
    status = nqm_light_create(&image, light_ret, err);
    nqm_free(image.rgb);
    return status;
}

static nqm_status alloc_scene(const nqm_scene_options *o, nqm_scene **scene_ret, nqm_error *err) {
    size_t n_pairs = o->n_points * o->n_lights;
    nqm_scene *scene = nqm_alloc(1, sizeof *scene);
    if (scene) {
        scene->n_points = o->n_points;
        scene->n_lights = o->n_lights;
        scene->peak_cdm2 = o->peak_cdm2;
        scene->point = nqm_alloc(o->n_points, sizeof *scene->point);
        scene->n_used = nqm_alloc(o->n_points, sizeof *scene->n_used);
        scene->wi = nqm_alloc(n_pairs, 3 * sizeof *scene->wi);
        scene->weight = nqm_alloc(n_pairs, 3 * sizeof *scene->weight);
    }
    if (!scene || !scene->point || !scene->n_used || !scene->wi || !scene->weight) {
        nqm_scene_free(scene);
        return nqm_fail_nomem(err, n_pairs * 6 * sizeof(double));
    }
    *scene_ret = scene;
    return NQM_OK;
}

nqm_status nqm_scene_create(const nqm_scene_options *options, nqm_scene **scene_ret, nqm_error *err) {
    nqm_scene_options defaults = nqm_scene_options_default();
    const nqm_scene_options *o = options ? options : &defaults;
    nqm_light light = {0};
    creation c = {.light = &light, .seed = o->seed};
    *scene_ret = NULL;
    nqm_status status = check_options(o, err);
    if (status == NQM_OK)
        status = load_light(o->light, &light, err);
    if (status == NQM_OK)
        status = alloc_scene(o, &c.scene, err);
    if (status != NQM_OK)
        goto fail;
    c.irradiance = nqm_alloc(o->n_points, 3 * sizeof *c.irradiance);
    if (!c.irradiance) {
        status = nqm_fail_nomem(err, o->n_points * 3 * sizeof *c.irradiance);
        goto fail;
    }
    nqm_parallel_for(o->n_points, create_point, &c);
    status = atomic_load(&c.out_of_memory) ? nqm_fail_nomem(err, NQM_LIGHT_CELLS * sizeof(double))
                                           : expose(c.scene, c.irradiance, o, err);
fail:
    if (status == NQM_OK)
        *scene_ret = c.scene;
    else
        nqm_scene_free(c.scene);
    nqm_free(c.irradiance);
    nqm_light_clear(&light);
    return status;
}

void nqm_scene_free(nqm_scene *scene) {
    if (!scene)
        return;
    nqm_free(scene->point);
    nqm_free(scene->n_used);
    nqm_free(scene->wi);
    nqm_free(scene->weight);
    nqm_free(scene);
}

size_t nqm_scene_count(const nqm_scene *scene) {
    return scene->n_points;
}

typedef struct rendering {
    const nqm_scene *scene;
    const nqm_brdf *brdf;
    double *rgb_cdm2;
} rendering;

static void render_point(void *user, size_t i) {
    const rendering *r = user;
    const nqm_scene *scene = r->scene;
    const double *wi = scene->wi + 3 * i * scene->n_lights, *weight = scene->weight + 3 * i * scene->n_lights;
    double wo[3 * BLOCK], f[3 * BLOCK], sum[3] = {0};
    for (size_t j = 0; j < BLOCK; ++j)
        memcpy(wo + 3 * j, scene->point[i].wo, sizeof scene->point[i].wo);
    for (size_t first = 0; first < scene->n_used[i]; first += BLOCK) {
        size_t left = scene->n_used[i] - first, n = left < BLOCK ? left : BLOCK;
        nqm_brdf_eval(r->brdf, n, wi + 3 * first, wo, f, NULL);
        for (size_t j = 0; j < n; ++j)
            for (size_t k = 0; k < 3; ++k)
                sum[k] += f[3 * j + k] * weight[3 * (first + j) + k];
    }
    memcpy(r->rgb_cdm2 + 3 * i, sum, sizeof sum);
}

nqm_status nqm_scene_render(const nqm_scene *scene, const nqm_brdf *brdf, double *rgb_cdm2, nqm_error *err) {
    rendering r = {.scene = scene, .brdf = brdf, .rgb_cdm2 = rgb_cdm2};
    nqm_parallel_for(scene->n_points, render_point, &r);
    for (size_t i = 0; i < 3 * scene->n_points; ++i)
        if (!isfinite(rgb_cdm2[i]))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s: the picture is not finite", nqm_brdf_get_info(brdf).name);
    return NQM_OK;
}
