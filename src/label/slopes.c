/* SPDX-License-Identifier: MIT
 *
 * The light of a scene by the slopes of half vectors: for few points of its pictures, how much light is reflected by half vectors of each
 * cell (model/model.h). A model of it estimates labels of any BRDF (metric/slopes.c).
 */
#include "label/label.h"
#include "math/math.h"
#include "metric/metric.h"
#include "model/model.h"
#include "render/render.h"
#include "sample/node_grid.h"

#include <string.h>

enum { N_LIGHTS = 8192 };

static const char *const slopes_card =
    "Estimate by light transport for any BRDF, anisotropic or not, without a network: the Delta-E ITP and JOD of"
    "\npictures of few points, whose light is known by the slope of the half vector. The BRDF is evaluated at half"
    "\nvectors placed by its lobe. Nothing was trained.\n";

typedef struct slope_job {
    nqm_model *to;
    const nqm_scene *scene;
    size_t number, first; /* the scene in its set, and its first point */
} slope_job;

/* Every point writes its own columns, so that points may be computed in any order. */
static void fill_point(void *user, size_t i) {
    const slope_job *job = user;
    const nqm_scene *scene = job->scene;
    const nqm_surface_point *p = &scene->seen.point[i];
    const nqm_incident *incident = &scene->kept[i];
    const size_t n = job->to->n_slope_points, point = job->first + i;
    double *wo = job->to->slope_wo + 3 * point, *to = job->to->slope_points + 3 * point;
    nqm_turn3(p->grain, p->wo, wo);
    for (size_t j = 0; j < incident->n_rays; ++j) {
        const nqm_ray *ray = &incident->ray[j];
        double wi[3] = {(double)ray->wi[0], (double)ray->wi[1], (double)ray->wi[2]};
        nqm_normalize3(wi);
        nqm_turn3(p->grain, wi, wi);
        const size_t cell = nqm_slope_cell((wi[0] + wo[0]) / (wi[2] + wo[2]), (wi[1] + wo[1]) / (wi[2] + wo[2]));
        for (size_t c = 0; c < 3; ++c)
            job->to->slopes[(3 * cell + c) * n + point] += (float)((double)ray->weight[c] * scene->exposure);
    }
    to[0] = scene->seen.weight ? scene->seen.weight[i] : 1 / (double)scene->seen.n;
    to[1] = (double)job->number;
    to[2] = scene->options.peak_cdm2;
}

static nqm_status fill(nqm_model *m, nqm_scene_options options, size_t n_points, nqm_error *err) {
    nqm_scene *scene;
    options.width = options.height = 0;
    options.n_points = n_points;
    options.n_lights = options.n_lights ? options.n_lights : N_LIGHTS;
    options.interreflection = 0;
    m->slopes = nqm_alloc((size_t)NQM_SLOPE_CELLS, 3 * n_points * sizeof *m->slopes);
    m->slope_points = nqm_alloc(n_points, 3 * sizeof *m->slope_points);
    m->slope_wo = nqm_alloc(n_points, 3 * sizeof *m->slope_wo);
    if (!m->slopes || !m->slope_points || !m->slope_wo)
        return nqm_fail_nomem(err, NQM_SLOPE_CELLS * 3 * n_points * sizeof *m->slopes);
    m->n_slopes = NQM_SLOPE_CELLS;
    m->n_slope_points = m->n_slope_wo = n_points;
    nqm_status status = nqm_scene_create(&options, &scene, err);
    if (status != NQM_OK)
        return status;
    const nqm_scene *const *parts =
        scene->n_parts ? (const nqm_scene *const *)scene->parts : (const nqm_scene *const *)&scene;
    const size_t n_parts = scene->n_parts ? scene->n_parts : 1;
    for (size_t s = 0, first = 0; s < n_parts; first += parts[s++]->seen.n) {
        slope_job job = {.to = m, .scene = parts[s], .number = s, .first = first};
        nqm_parallel_for(parts[s]->seen.n, fill_point, &job);
    }
    nqm_scene_free(scene);
    return NQM_OK;
}

nqm_status nqm_slopes_create(const nqm_scene_options *scene, size_t n_points, const char *id, nqm_model **model_ret,
                             nqm_error *err) {
    NQM_MAKE(err, model_ret, id);
    if (n_points < NQM_STANDARD_SCENES || n_points > NQM_TRANSPORT_MAX_POINTS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "points: %zu; 4 to %d are possible", n_points, NQM_TRANSPORT_MAX_POINTS);
    nqm_model *m = nqm_alloc(1, sizeof *m);
    nqm_status status = m ? NQM_OK : nqm_fail_nomem(err, sizeof *m);
    if (status == NQM_OK)
        status = fill(m, scene ? *scene : nqm_scene_options_default(), n_points, err);
    if (status == NQM_OK)
        status = nqm_node_grid_directions(&m->directions, err); /* of metrics and counts */
    if (status == NQM_OK)
        status = nqm_untrained_finish(m, id, slopes_card, err);
    if (status == NQM_OK)
        *model_ret = m;
    else
        nqm_model_free(m);
    return status;
}
