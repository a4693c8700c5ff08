/* SPDX-License-Identifier: MIT
 *
 * The light that reaches one point: the chosen directions, without those that the shape blocks; where interreflection is
 * wanted, in their place the light that falls on what blocks them, so that any BRDF can reflect it twice.
 */
#include "math/math.h"
#include "render/render.h"

#include <string.h>

/* What becomes of a direction. */
enum { DARK = 0, LIT, BOUNCED };

/* Room for one point's directions. */
typedef struct bench {
    nqm_direction_set set;
    unsigned char *fate; /* (n_max) */
    nqm_bounce *bounce;  /* (n_max), or NULL without interreflection */
} bench;

static bool open_bench(size_t n, bool bounces, bench *b) {
    *b = (bench){.set = {.n_max = n}};
    b->set.wi = nqm_alloc(n, 7 * sizeof(double));
    b->fate = nqm_alloc(n, 1);
    b->bounce = bounces ? nqm_alloc(n, sizeof *b->bounce) : NULL;
    if (!b->set.wi || !b->fate || (bounces && !b->bounce))
        return false;
    b->set.weight = b->set.wi + 3 * n;
    b->set.extent = b->set.wi + 6 * n;
    return true;
}

static void close_bench(bench *b) {
    nqm_free(b->set.wi);
    nqm_free(b->fate);
    nqm_free(b->bounce);
}

static void to_float(const double *v, float *f) {
    for (int k = 0; k < 3; ++k)
        f[k] = (float)v[k];
}

static bool is_black(const double *rgb) {
    return !(rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0);
}

static bool blocked(const nqm_scene *scene, const nqm_surface_point *point, const double *wi) {
    double world[3], direction[3];
    nqm_world_from_local(point, wi, world);
    nqm_shape_from_world(point->turn, world, direction);
    return nqm_shape_blocked(&scene->shape, point->origin, direction);
}

/* Gather light at a part of the shape, met from `point` in direction wi. */
static bool fill_bounce(const nqm_scene *scene, const nqm_surface_point *point, const nqm_hit *hit, const double *world,
                        uint64_t seed, nqm_bounce *bounce) {
    double wi[3 * NQM_BOUNCE_LIGHTS], weight[3 * NQM_BOUNCE_LIGHTS];
    nqm_direction_set set = {.n_max = NQM_BOUNCE_LIGHTS, .wi = wi, .weight = weight};
    const double back[3] = {-world[0], -world[1], -world[2]};
    nqm_surface_point met;
    nqm_surface_point_make(hit, point->turn, back, &met);
    if (!nqm_choose_few_directions(&scene->light, &met, seed, &set))
        return false;
    bounce->n_rays = 0;
    to_float(met.wo, bounce->wo);
    for (size_t j = 0; j < set.n_used; ++j) {
        if (is_black(weight + 3 * j) || blocked(scene, &met, wi + 3 * j))
            continue;
        nqm_ray *ray = &bounce->ray[bounce->n_rays++];
        to_float(wi + 3 * j, ray->wi);
        to_float(weight + 3 * j, ray->weight);
    }
    return true;
}

/* Follow direction j until it meets the shape. */
static bool follow(const nqm_scene *scene, const nqm_surface_point *point, uint64_t seed, size_t j, bench *b) {
    double world[3], direction[3];
    nqm_hit hit;
    nqm_bounce *bounce = &b->bounce[j];
    nqm_world_from_local(point, b->set.wi + 3 * j, world);
    nqm_shape_from_world(point->turn, world, direction);
    b->fate[j] = LIT;
    if (!nqm_shape_hit(&scene->shape, point->origin, direction, &hit))
        return true;
    if (!fill_bounce(scene, point, &hit, world, nqm_hash_u64(seed, 1024 + j), bounce))
        return false;
    to_float(b->set.wi + 3 * j, bounce->wi);
    bounce->extent = (float)b->set.extent[j];
    b->fate[j] = bounce->n_rays ? BOUNCED : DARK;
    return true;
}

static bool decide(const nqm_scene *scene, const nqm_surface_point *point, uint64_t seed, bench *b) {
    for (size_t j = 0; j < b->set.n_used; ++j) {
        if (scene->options.interreflection && scene->shape.tracer) {
            if (!follow(scene, point, seed, j, b))
                return false;
        } else if (!is_black(b->set.weight + 3 * j))
            b->fate[j] = scene->options.shadows && blocked(scene, point, b->set.wi + 3 * j) ? DARK : LIT;
        if (b->fate[j] == LIT && is_black(b->set.weight + 3 * j))
            b->fate[j] = DARK;
    }
    return true;
}

/* Copy what is not dark. */
static bool pack(const bench *b, nqm_incident *incident) {
    size_t count[3] = {0};
    for (size_t j = 0; j < b->set.n_used; ++j)
        ++count[b->fate[j]];
    incident->ray = nqm_alloc(count[LIT], sizeof *incident->ray);
    incident->bounce = count[BOUNCED] ? nqm_alloc(count[BOUNCED], sizeof *incident->bounce) : NULL;
    if (!incident->ray || (count[BOUNCED] && !incident->bounce))
        return false;
    for (size_t j = 0; j < b->set.n_used; ++j) {
        if (b->fate[j] == LIT) {
            nqm_ray *ray = &incident->ray[incident->n_rays++];
            to_float(b->set.wi + 3 * j, ray->wi);
            to_float(b->set.weight + 3 * j, ray->weight);
        } else if (b->fate[j] == BOUNCED)
            incident->bounce[incident->n_bounces++] = b->bounce[j];
    }
    return true;
}

bool nqm_incident_make(const nqm_scene *scene, size_t i, nqm_incident *incident, double *irradiance) {
    uint64_t seed = nqm_hash_u64(scene->options.seed, i);
    const nqm_surface_point *point = &scene->seen.point[i];
    bench b;
    *incident = (nqm_incident){0};
    bool ok = open_bench(scene->options.n_lights, scene->options.interreflection && scene->shape.tracer, &b) &&
              nqm_choose_directions(&scene->light, point, seed, &b.set) && decide(scene, point, seed, &b) &&
              pack(&b, incident);
    if (ok && irradiance)
        memcpy(irradiance, b.set.irradiance, sizeof b.set.irradiance);
    if (!ok)
        nqm_incident_clear(incident);
    close_bench(&b);
    return ok;
}

void nqm_incident_clear(nqm_incident *incident) {
    nqm_free(incident->ray);
    nqm_free(incident->bounce);
    *incident = (nqm_incident){0};
}
