/* SPDX-License-Identifier: MIT
 *
 * Incident light of one point: the sampled directions that the shape does not block. With interreflection, blocked
 * directions hold the light that falls on the blocking surface, so that any BRDF can reflect it twice.
 */
#include "math/math.h"
#include "render/render.h"

#include <string.h>

/* The outcome of a direction. */
enum { DARK = 0, LIT, BOUNCED };

/* Workspace of one point; set.wi owns the block of all arrays. */
typedef struct workspace {
    nqm_direction_set set;
    unsigned char *fate; /* (n_max) */
    nqm_bounce *bounce;  /* (n_max) with interreflection, else empty */
} workspace;

static bool open_workspace(size_t n, bool bounces, workspace *b) {
    *b = (workspace){.set = {.n_max = n}};
    return nqm_alloc_arrays(NQM_ARRAYS({&b->set.wi, n, 3 * sizeof(double)}, {&b->set.weight, n, 3 * sizeof(double)},
                                       {&b->set.extent, n, sizeof(double)}, {&b->fate, n, 1},
                                       {&b->bounce, bounces ? n : 0, sizeof *b->bounce}),
                            NULL) == NQM_OK;
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

/* Gather light at the part of the shape that is hit from `point` in direction `world`. */
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
    for (size_t k = 0; k < 2; ++k)
        bounce->tangent[k] = (float)met.tangent[k];
    for (size_t j = 0; j < set.n_used; ++j) {
        if (is_black(weight + 3 * j) || blocked(scene, &met, wi + 3 * j))
            continue;
        nqm_ray *ray = &bounce->ray[bounce->n_rays++];
        to_float(wi + 3 * j, ray->wi);
        to_float(weight + 3 * j, ray->weight);
    }
    return true;
}

/* Trace direction j; where it hits the shape, gather the light there. */
static bool follow(const nqm_scene *scene, const nqm_surface_point *point, uint64_t seed, size_t j, workspace *b) {
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

static bool decide(const nqm_scene *scene, const nqm_surface_point *point, uint64_t seed, workspace *b) {
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

/* Copy the directions with light. */
static bool pack(const workspace *b, nqm_incident *incident) {
    size_t count[3] = {0};
    for (size_t j = 0; j < b->set.n_used; ++j)
        ++count[b->fate[j]];
    if (nqm_alloc_arrays(NQM_ARRAYS({&incident->ray, count[LIT], sizeof *incident->ray},
                                    {&incident->bounce, count[BOUNCED], sizeof *incident->bounce}),
                         NULL) != NQM_OK)
        return false;
    for (size_t j = 0; j < b->set.n_used; ++j) {
        incident->n_first_rays += b->fate[j] == LIT && j < b->set.n_first;
        incident->n_first_bounces += b->fate[j] == BOUNCED && j < b->set.n_first;
        if (b->fate[j] == LIT) {
            nqm_ray *ray = &incident->ray[incident->n_rays++];
            to_float(b->set.wi + 3 * j, ray->wi);
            to_float(b->set.weight + 3 * j, ray->weight);
        } else if (b->fate[j] == BOUNCED)
            incident->bounce[incident->n_bounces++] = b->bounce[j];
    }
    return true;
}

bool nqm_incident_make(const nqm_scene *scene, size_t i, const nqm_lobe *lobe, nqm_incident *incident,
                       double *irradiance) {
    uint64_t seed = nqm_hash_u64(scene->options.seed, i);
    nqm_surface_point made;
    const nqm_surface_point *point = nqm_scene_point(scene, i, &made);
    workspace b;
    *incident = (nqm_incident){0};
    bool ok = open_workspace(scene->options.n_lights, scene->options.interreflection && scene->shape.tracer, &b) &&
              nqm_choose_directions(&scene->light, point, lobe, seed, &b.set) && decide(scene, point, seed, &b) &&
              pack(&b, incident);
    if (ok && irradiance)
        memcpy(irradiance, b.set.irradiance, sizeof b.set.irradiance);
    nqm_free(b.set.wi);
    return ok;
}
