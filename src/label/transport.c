/* SPDX-License-Identifier: MIT
 *
 * The light of few points of a scene's pictures, for models that estimate labels: as linear functions of the samples of a BRDF at
 * the nodes of a grid (sample/node_grid.h), or by the slope of the half vector (sample/slopes.h).
 */
#include "label/label.h"
#include "math/math.h"
#include "metric/metric.h"
#include "sample/node_grid.h"

#include <string.h>

/* Light directions of a point: they cost nothing later. */
enum { N_LIGHTS = 1024, N_LIGHTS_BY_SLOPES = 65536 };

/* ---- points of a scene ------------------------------------------------------------------------------------------- */

/* What becomes of the light of each point, and where: (..., 3, n_points). Every point writes its own columns. */
typedef struct filling {
    void (*fill)(const struct filling *to, const nqm_surface_point *point, const double *wi, const double *light_cdm2,
                 size_t column);
    size_t n_points;
    nqm_node_grid grid;
    float *light;
    double *points, *wo;
} filling;

/* The points of a scene, which has a number in its set; `first`: the column of its first point. */
typedef struct scene_job {
    const filling *to;
    const nqm_scene *scene;
    size_t number, first;
} scene_job;

static void visit_point(void *user, size_t i) {
    const scene_job *job = user;
    const nqm_scene *scene = job->scene;
    const nqm_surface_point *seen = &scene->seen.point[i];
    const nqm_incident *incident = &scene->kept[i];
    const size_t column = job->first + i;
    double *point = job->to->points + 3 * column;
    point[0] = scene->seen.weight ? scene->seen.weight[i] : 1 / (double)scene->seen.n;
    point[1] = (double)job->number;
    point[2] = scene->options.peak_cdm2;
    if (job->to->wo)
        nqm_turn3(seen->tangent, seen->wo, job->to->wo + 3 * column);
    for (size_t j = 0; j < incident->n_rays; ++j) {
        double wi[3], light[3];
        nqm_ray_light(&incident->ray[j], scene->exposure, wi, light);
        job->to->fill(job->to, seen, wi, light, column);
    }
}

static nqm_status fill(const nqm_scene_options *scene_options, size_t n_lights, const filling *to, nqm_error *err) {
    nqm_scene_options options = *scene_options;
    options.width = options.height = 0;
    options.n_points = to->n_points;
    options.n_lights = options.n_lights ? options.n_lights : n_lights;
    options.interreflection = 0;
    nqm_scene *scene;
    nqm_status status = nqm_scene_create(&options, &scene, err);
    if (status != NQM_OK)
        return status;
    if (nqm_scene_get_info(scene).n_points != to->n_points)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu points instead of %zu", nqm_scene_get_info(scene).n_points,
                          to->n_points);
    for (size_t s = 0, first = 0; status == NQM_OK && s < scene->n_parts; first += scene->parts[s++]->seen.n) {
        scene_job job = {to, scene->parts[s], s, first};
        nqm_parallel_for(job.scene->seen.n, visit_point, &job);
    }
    nqm_scene_free(scene);
    return status;
}

/* ---- matrix and slopes ------------------------------------------------------------------------------------------- */

/* Distribute light to the nodes around its direction. */
static void add_to_nodes(const filling *to, const nqm_surface_point *point, const double *wi, const double *light_cdm2,
                         size_t column) {
    size_t node[NQM_GRID_NEAR];
    double weight[NQM_GRID_NEAR];
    nqm_node_grid_interpolate(&to->grid, wi, point->wo, node, weight);
    for (size_t i = 0; i < NQM_GRID_NEAR; ++i)
        for (size_t c = 0; c < 3; ++c)
            to->light[(3 * node[i] + c) * to->n_points + column] += (float)(light_cdm2[c] * weight[i]);
}

static void add_to_cell(const filling *to, const nqm_surface_point *point, const double *wi, const double *light_cdm2,
                        size_t column) {
    const double *out = to->wo + 3 * column;
    double in[3];
    nqm_turn3(point->tangent, wi, in);
    const size_t cell = nqm_slope_cell((in[0] + out[0]) / (in[2] + out[2]), (in[1] + out[1]) / (in[2] + out[2]));
    for (size_t c = 0; c < 3; ++c)
        to->light[(3 * cell + c) * to->n_points + column] += (float)light_cdm2[c];
}

nqm_status nqm_transport_fill(const nqm_scene_options *scene, size_t n_points, float *light, double *points,
                              nqm_error *err) {
    const filling to = {add_to_nodes, n_points, nqm_node_grid_make(), light, points, NULL};
    memset(light, 0, to.grid.n * 3 * n_points * sizeof *light);
    return fill(scene, N_LIGHTS, &to, err);
}

nqm_status nqm_transport_create(const nqm_scene_options *scene, int anisotropic, size_t n_points, const char *id,
                                nqm_model **model_ret, nqm_error *err) {
    NQM_MAKE(err, model_ret, id);
    const nqm_scene_options options = scene ? *scene : nqm_scene_options_default();
    if (anisotropic && (n_points < NQM_STANDARD_SCENES || n_points > NQM_TRANSPORT_MAX_POINTS))
        return nqm_fail(err, NQM_ERR_ARG, -1, "points: %zu; 4 to %d are possible", n_points, NQM_TRANSPORT_MAX_POINTS);
    if (!anisotropic && (n_points == 0 || n_points % NQM_TRANSPORT_STEP || n_points > NQM_TRANSPORT_MAX_POINTS))
        return nqm_fail(err, NQM_ERR_ARG, -1, "points: %zu is no multiple of %d up to %d", n_points, NQM_TRANSPORT_STEP,
                        NQM_TRANSPORT_MAX_POINTS);
    nqm_model *m;
    nqm_status status = nqm_model_of_light(id, anisotropic, n_points, &m, err);
    if (status != NQM_OK)
        return status;
    const filling slopes = {add_to_cell, n_points, {0}, m->slopes, m->slope_points, m->slope_wo};
    status = anisotropic ? fill(&options, N_LIGHTS_BY_SLOPES, &slopes, err)
                         : nqm_transport_fill(&options, n_points, m->transport, m->transport_points, err);
    if (status == NQM_OK)
        status = nqm_golden_make(m, &m->golden, err);
    if (status == NQM_OK)
        *model_ret = m;
    else
        nqm_model_free(m);
    return status;
}
