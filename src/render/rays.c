/* SPDX-License-Identifier: MIT
 *
 * Random pictures of few points of a scene: points and light directions are new for every seed, while light, shape, BVH and
 * exposure are those of the scene.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>

/* Light directions per point: fewer make the pictures noisier, and with them Delta-E larger; more leave fewer points. */
enum { LIGHTS = 32, MIN_LIGHTS = 16, MAX_LIGHTS = 1 << 16 };

typedef struct drawing {
    const nqm_scene *scene; /* one part, with the number of light directions and the seed of the draw */
    size_t n;               /* points of the part */
    size_t *index;          /* (n) of the points in the scene */
    nqm_incident *incident; /* (n) */
    bool *failed;           /* (n) out of memory */
} drawing;

static double random_unit(const drawing *d, size_t counter) {
    return (double)(nqm_hash_u64(d->scene->options.seed, UINT64_MAX - counter) >> 11) * 0x1p-53;
}

/* Rotate about the normal. turn: sine and cosine. */
static void rotate(const double *turn, const double *v, double *rotated) {
    rotated[0] = turn[1] * v[0] - turn[0] * v[1];
    rotated[1] = turn[0] * v[0] + turn[1] * v[1];
    rotated[2] = v[2];
}

/* One point of each of n strata of the scene's points, which neighbour each other in their order. */
static size_t pick(const drawing *d, size_t i) {
    return nqm_smaller((size_t)(((double)i + random_unit(d, 2 * i + 1)) / (double)d->n * (double)d->scene->seen.n),
                       d->scene->seen.n - 1);
}

static void draw_point(void *user, size_t i) {
    const drawing *d = user;
    d->index[i] = pick(d, i);
    d->failed[i] = !nqm_incident_make(d->scene, d->index[i], &d->incident[i], NULL);
}

/* Append the points of one scene, whose number in its set is `number`. Frames get random azimuths: in those of the scene wo is in
 * one plane, and a network that is not isotropic would learn only that plane. */
static void add_points(const drawing *d, size_t number, nqm_rays *rays) {
    const nqm_seen *seen = &d->scene->seen;
    double sum = 0;
    for (size_t i = 0; i < d->n; ++i)
        sum += seen->weight ? seen->weight[d->index[i]] : 1;
    for (size_t i = 0; i < d->n; ++i, ++rays->n_points) {
        const nqm_incident *incident = &d->incident[i];
        const double turn[2] = {sin(2 * NQM_PI * random_unit(d, 2 * i)), cos(2 * NQM_PI * random_unit(d, 2 * i))};
        nqm_surface_point made;
        const double *wo = nqm_scene_point(d->scene, d->index[i], &made)->wo;
        double *point = rays->points + 3 * rays->n_points;
        point[0] = (seen->weight ? seen->weight[d->index[i]] : 1) / sum;
        point[1] = (double)number;
        point[2] = d->scene->options.peak_cdm2;
        for (size_t j = 0; j < incident->n_rays; ++j, ++rays->n) {
            double wi[3];
            for (size_t k = 0; k < 3; ++k) {
                wi[k] = (double)incident->ray[j].wi[k];
                rays->weight[3 * rays->n + k] = (double)incident->ray[j].weight[k] * d->scene->exposure;
            }
            nqm_normalize3(wi);
            rotate(turn, wi, rays->wi + 3 * rays->n);
            rotate(turn, wo, rays->wo + 3 * rays->n);
            rays->point[rays->n] = rays->n_points;
        }
    }
}

/* Draw d->n points of one scene with n_lights directions each. false: out of memory. */
static bool draw_part(const nqm_scene *part, size_t number, size_t n_lights, uint64_t seed, drawing *d,
                      nqm_rays *rays) {
    nqm_scene scene = *part; /* borrows everything but the options */
    scene.options.n_lights = n_lights;
    scene.options.interreflection = 0;
    scene.options.seed = nqm_hash_u64(seed, number);
    d->scene = &scene;
    nqm_parallel_for(d->n, draw_point, d);
    bool failed = false;
    for (size_t i = 0; i < d->n; ++i)
        failed |= d->failed[i];
    if (!failed)
        add_points(d, number, rays);
    for (size_t i = 0; i < d->n; ++i)
        nqm_free(d->incident[i].ray);
    return !failed;
}

/* Points of each scene for n rays of the whole set. */
static size_t n_points_of(const nqm_scene *scene, size_t n) {
    const size_t n_parts = scene->n_parts ? scene->n_parts : 1, n_points = n / LIGHTS / n_parts;
    size_t n_seen = scene->n_parts ? SIZE_MAX : scene->seen.n;
    for (size_t p = 0; p < scene->n_parts; ++p)
        n_seen = nqm_smaller(n_seen, scene->parts[p]->seen.n);
    return nqm_smaller(n_points ? n_points : 1, n_seen);
}

nqm_status nqm_rays_draw(const nqm_scene *scene, size_t n, uint64_t seed, nqm_rays *rays_ret, nqm_error *err) {
    const size_t n_parts = scene->n_parts ? scene->n_parts : 1, n_points = n_points_of(scene, n);
    const size_t n_lights = n / n_parts / n_points;
    nqm_rays rays = {.n = 0};
    drawing d = {.n = n_points};
    *rays_ret = rays;
    if (n_lights < MIN_LIGHTS || n_lights > MAX_LIGHTS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "rays: %zu; this scene needs %zu to %zu", n, n_parts * MIN_LIGHTS,
                        n_parts * n_points * MAX_LIGHTS);
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&rays.wi, n, 3 * sizeof(double)}, {&rays.wo, n, 3 * sizeof(double)},
                                    {&rays.weight, n, 3 * sizeof(double)}, {&rays.point, n, sizeof *rays.point},
                                    {&rays.points, n_parts * n_points, 3 * sizeof(double)}),
                         err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&d.index, n_points, sizeof *d.index},
                                             {&d.incident, n_points, sizeof *d.incident}, {&d.failed, n_points, 1}),
                                  err);
    for (size_t p = 0; status == NQM_OK && p < n_parts; ++p)
        if (!draw_part(scene->n_parts ? scene->parts[p] : scene, p, n_lights, seed, &d, &rays))
            status = nqm_fail_nomem(err, n * sizeof(nqm_ray));
    nqm_free(d.index);
    if (status == NQM_OK)
        *rays_ret = rays;
    else
        nqm_rays_clear(&rays);
    return status;
}

void nqm_rays_clear(nqm_rays *rays) {
    nqm_free(rays->wi);
    *rays = (nqm_rays){.n = 0};
}
