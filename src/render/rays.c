/* SPDX-License-Identifier: MIT
 *
 * Random pictures of few points of a scene: points and light directions are new for every seed, while light, shape, BVH and
 * exposure are those of the scene.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <string.h>

enum { MIN_LIGHTS = 16, MAX_LIGHTS = 1 << 16 };

/* A point of a draw; `scene` is one part, with the number of light directions and the seed of the draw. */
typedef struct drawn {
    const nqm_scene *scene;
    size_t number; /* number of the scene in its set */
    size_t index;  /* index of the point in the scene */
    nqm_incident incident;
    bool failed; /* out of memory */
} drawn;

typedef struct drawing {
    nqm_scene parts[NQM_STANDARD_SCENES]; /* borrow everything but the options */
    size_t n_parts, n_points;             /* n_points: points of each part */
    drawn *points;                        /* (n_parts, n_points); owns the block of both arrays */
    nqm_surface_point *sphere;            /* (n_parts, n_points) points of spheres */
} drawing;

/* The point is in one of n_points strata of the scene's points, which neighbour each other in their order. */
static void draw_point(void *user, size_t i) {
    const drawing *d = user;
    const size_t k = i % d->n_points;
    const nqm_scene *scene = &d->parts[i / d->n_points];
    const double n_seen = (double)scene->seen.n,
                 stratum = ((double)k + nqm_random_unit(scene->options.seed, UINT64_MAX - 2 * k)) / (double)d->n_points;
    drawn *p = &d->points[i];
    *p = (drawn){.scene = scene, .number = i / d->n_points};
    p->index = nqm_smaller((size_t)(stratum * n_seen), scene->seen.n - 1);
    p->failed = !nqm_incident_make(scene, p->index, NULL, &p->incident, NULL);
}

/* Points of a sphere are new as well: the pattern of the scene with another rotation, since a selection of it would not be even. */
static void spread(nqm_scene *part, size_t n, nqm_surface_point *point) {
    part->options.n_points = n;
    part->seen = (nqm_seen){.n = n, .point = point};
    nqm_spread_sphere(&part->options, point);
}

void nqm_ray_light(const nqm_ray *ray, double exposure, double wi[3], double light[3]) {
    for (size_t k = 0; k < 3; ++k) {
        wi[k] = (double)ray->wi[k];
        light[k] = (double)ray->weight[k] * exposure;
    }
    nqm_normalize3(wi);
}

static void append(const drawn *p, double weight, nqm_rays *rays) {
    const nqm_scene *scene = p->scene;
    const double point[3] = {weight, (double)p->number, scene->options.peak_cdm2};
    nqm_surface_point made;
    const nqm_surface_point *seen = nqm_scene_point(scene, p->index, &made);
    for (size_t j = 0; j < p->incident.n_rays; ++j, ++rays->n) {
        double wi[3];
        nqm_ray_light(&p->incident.ray[j], scene->exposure, wi, rays->weight + 3 * rays->n);
        nqm_turn3(seen->tangent, wi, rays->wi + 3 * rays->n);
        nqm_turn3(seen->tangent, seen->wo, rays->wo + 3 * rays->n);
        rays->point[rays->n] = rays->n_points;
    }
    memcpy(rays->points + 3 * rays->n_points++, point, sizeof point);
}

static double weight_of(const drawn *p) {
    return p->scene->seen.weight ? p->scene->seen.weight[p->index] : 1;
}

/* Draw all points and append them. false: out of memory. */
static bool draw(drawing *d, nqm_rays *rays) {
    const size_t n = d->n_parts * d->n_points;
    bool failed = false;
    nqm_parallel_for(n, draw_point, d);
    for (size_t i = 0; i < n; ++i)
        failed |= d->points[i].failed;
    for (size_t first = 0; first < n && !failed; first += d->n_points) {
        double sum = 0;
        for (size_t k = 0; k < d->n_points; ++k)
            sum += weight_of(&d->points[first + k]);
        for (size_t k = 0; k < d->n_points; ++k)
            append(&d->points[first + k], weight_of(&d->points[first + k]) / sum, rays);
    }
    for (size_t i = 0; i < n; ++i)
        nqm_free(d->points[i].incident.ray);
    return !failed;
}

/* Points of each scene for n rays of the whole set. The noise of a point makes Delta-E larger, which more directions per point
 * reduce; fewer points make it vary more between draws. Both errors vanish with growing n. */
static size_t n_points_of(const nqm_scene *scene, size_t n) {
    const double n_lights = fmax(0.5 * sqrt((double)n), MIN_LIGHTS);
    size_t n_points = (size_t)((double)(n / scene->n_parts) / n_lights);
    for (size_t p = 0; p < scene->n_parts; ++p)
        n_points = nqm_smaller(n_points, scene->parts[p]->seen.n);
    return n_points ? n_points : 1;
}

nqm_status nqm_rays_draw(const nqm_scene *scene, size_t n, uint64_t seed, nqm_rays *rays_ret, nqm_error *err) {
    NQM_REQUIRE(err, scene, rays_ret);
    drawing d = {.n_parts = scene->n_parts, .n_points = n_points_of(scene, n)};
    const size_t n_points = d.n_parts * d.n_points, n_lights = n / n_points;
    nqm_rays rays = {.n = 0};
    *rays_ret = rays;
    if (n_lights < MIN_LIGHTS || n_lights > MAX_LIGHTS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "rays: %zu; this scene needs %zu to %zu", n, d.n_parts * MIN_LIGHTS,
                        n_points * MAX_LIGHTS);
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&rays.wi, n, 3 * sizeof(double)}, {&rays.wo, n, 3 * sizeof(double)},
                                    {&rays.weight, n, 3 * sizeof(double)}, {&rays.point, n, sizeof *rays.point},
                                    {&rays.points, n_points, 3 * sizeof(double)}),
                         err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(
            NQM_ARRAYS({&d.points, n_points, sizeof *d.points}, {&d.sphere, n_points, sizeof *d.sphere}), err);
    for (size_t p = 0; p < d.n_parts && status == NQM_OK; ++p) {
        d.parts[p] = *scene->parts[p];
        d.parts[p].options.n_lights = n_lights;
        d.parts[p].options.interreflection = 0;
        d.parts[p].options.seed = nqm_hash_u64(seed, p);
        if (!d.parts[p].shape.tracer)
            spread(&d.parts[p], d.n_points, d.sphere + p * d.n_points);
    }
    if (status == NQM_OK && !draw(&d, &rays))
        status = nqm_fail_nomem(err, n * sizeof(nqm_ray));
    nqm_free(d.points);
    if (status == NQM_OK)
        *rays_ret = rays;
    else
        nqm_rays_clear(&rays);
    return status;
}

void nqm_rays_clear(nqm_rays *rays) {
    if (!rays)
        return;
    nqm_free(rays->wi);
    *rays = (nqm_rays){.n = 0};
}
