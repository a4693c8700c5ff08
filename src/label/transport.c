/* SPDX-License-Identifier: MIT
 *
 * The transport matrix of a scene: few points of the scene's pictures as linear functions of the samples of a BRDF at
 * the nodes of a grid (sample/node_grid.h). Every light direction of a point is a half vector and a difference vector;
 * the BRDF there is interpolated between nodes, so the light from there is distributed to these. The matrix of a corpus
 * is stored in its dataset; a matrix with its directions is also a model without a network.
 */
#include "label/label.h"
#include "math/math.h"
#include "metric/metric.h"
#include "model/model.h"
#include "render/render.h"
#include "sample/node_grid.h"

#include <string.h>

enum { N_LIGHTS = 1024 }; /* per point: they cost nothing later */

/* ---- points of a scene ------------------------------------------------------------------------------------------- */

void nqm_lit_ray(const nqm_lit_point *point, size_t j, double *wi, double *light) {
    const nqm_ray *ray = &point->incident->ray[j];
    for (size_t k = 0; k < 3; ++k) {
        wi[k] = (double)ray->wi[k];
        light[k] = (double)ray->weight[k] * point->exposure;
    }
    nqm_normalize3(wi);
}

/* The points of a scene, which has a number in its set; `first`: the column of its first point. */
typedef struct scene_job {
    const nqm_scene *scene;
    size_t number, first;
    void (*fill)(void *user, const nqm_lit_point *point);
    void *user;
    double *points;
} scene_job;

static void visit_point(void *user, size_t i) {
    const scene_job *job = user;
    const nqm_scene *scene = job->scene;
    const nqm_lit_point point = {&scene->seen.point[i], &scene->kept[i], scene->exposure, job->first + i};
    double *to = job->points + 3 * point.column;
    to[0] = scene->seen.weight ? scene->seen.weight[i] : 1 / (double)scene->seen.n;
    to[1] = (double)job->number;
    to[2] = scene->options.peak_cdm2;
    job->fill(job->user, &point);
}

nqm_status nqm_lit_points(const nqm_scene_options *scene_options, size_t n_points, size_t n_lights,
                          void (*fill)(void *user, const nqm_lit_point *point), void *user, double *points,
                          nqm_error *err) {
    nqm_scene_options options = *scene_options;
    options.width = options.height = 0;
    options.n_points = n_points;
    options.n_lights = options.n_lights ? options.n_lights : n_lights;
    options.interreflection = 0;
    nqm_scene *scene;
    nqm_status status = nqm_scene_create(&options, &scene, err);
    if (status != NQM_OK)
        return status;
    if (nqm_scene_count(scene) != n_points)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu points instead of %zu", nqm_scene_count(scene), n_points);
    for (size_t s = 0, first = 0; status == NQM_OK && s < scene->n_parts; ++s) {
        const nqm_scene *part = scene->parts[s];
        scene_job job = {part, s, first, fill, user, points};
        nqm_parallel_for(part->seen.n, visit_point, &job);
        first += part->seen.n;
    }
    nqm_scene_free(scene);
    return status;
}

/* ---- the matrix -------------------------------------------------------------------------------------------------- */

typedef struct matrix {
    nqm_node_grid grid;
    size_t n_points;
    float *light;
} matrix;

/* Distribute the light of all rays to the nodes around their directions. Every point writes its own column. */
static void distribute(void *user, const nqm_lit_point *point) {
    const matrix *m = user;
    for (size_t j = 0; j < point->incident->n_rays; ++j) {
        size_t node[NQM_GRID_NEAR];
        double weight[NQM_GRID_NEAR], wi[3], light[3];
        nqm_lit_ray(point, j, wi, light);
        nqm_node_grid_interpolate(&m->grid, wi, point->seen->wo, node, weight);
        for (size_t i = 0; i < NQM_GRID_NEAR; ++i)
            for (size_t c = 0; c < 3; ++c)
                m->light[(3 * node[i] + c) * m->n_points + point->column] += (float)(light[c] * weight[i]);
    }
}

nqm_status nqm_transport_fill(const nqm_scene_options *scene, size_t n_points, float *light, double *points,
                              nqm_error *err) {
    matrix m = {.grid = nqm_node_grid_make(), .n_points = n_points, .light = light};
    memset(light, 0, m.grid.n * 3 * n_points * sizeof *light);
    return nqm_lit_points(scene, n_points, N_LIGHTS, distribute, &m, points, err);
}

/* ---- a model without a network ----------------------------------------------------------------------------------- */

static const char *const default_card = "Estimate by light transport, without a network: the Delta-E ITP and JOD of "
                                        "pictures of few points that a matrix makes of\n"
                                        "the samples. It has no intervals: nothing was trained or calibrated.\n";

static const char *const slopes_card =
    "Estimate by light transport for any BRDF, anisotropic or not, without a network: the Delta-E ITP and JOD of"
    "\npictures of few points, whose light is known by the slope of the half vector. The BRDF is evaluated at half"
    "\nvectors placed by its lobe. Nothing was trained.\n";

static nqm_status set_texts(nqm_model *m, const char *id, const char *card, nqm_error *err) {
    struct {
        char **to;
        const char *text;
    } texts[] = {{&m->id, id},     {&m->recipe, "transport"}, {&m->licence, "MIT"},
                 {&m->card, card}, {&m->training, "{}"},      {&m->manifest_sha256, ""}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        if (!(*texts[i].to = nqm_strdup(texts[i].text)))
            return nqm_fail_nomem(err, strlen(texts[i].text));
    return NQM_OK;
}

/* Ranges in which an output of 0 corrects nothing, and a whitening that finds no sample unusual. */
static void set_constants(nqm_model *m) {
    const nqm_output_range none = {.mean = 0, .std = 1, .lo = -1, .hi = 1};
    m->target = NQM_TARGET_LOG_DELTA_E;
    m->curve = nqm_curve_published;
    m->output = none;
    m->features.difference_scale = 1;
    for (size_t k = 0; k < NQM_LABEL_PARTS; ++k)
        m->parts[k] = none;
    for (size_t k = 0; k < 3; ++k)
        m->features.std[k] = 1;
}

static nqm_status fill_matrix(const nqm_scene_options *scene, size_t n_points, nqm_model *m, nqm_error *err) {
    const size_t n = nqm_node_grid_make().n;
    float *light;
    double *points;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&light, n, 3 * n_points * sizeof *light}, {&points, n_points, 3 * sizeof *points}), err);
    if (status != NQM_OK)
        return status;
    status = nqm_transport_fill(scene, n_points, light, points, err);
    if (status == NQM_OK)
        status = nqm_model_set_transport(m, &(nqm_transport){n, light, {n_points, points}}, err);
    nqm_free(light);
    return status;
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
    nqm_model *m = nqm_alloc(1, sizeof *m);
    nqm_status status = !m            ? nqm_fail_nomem(err, sizeof *m)
                        : anisotropic ? nqm_slopes_fill(&options, n_points, m, err)
                                      : fill_matrix(&options, n_points, m, err);
    if (status == NQM_OK)
        status = nqm_node_grid_directions(&m->directions, err); /* with slopes: of metrics and counts */
    if (status == NQM_OK)
        status = set_texts(m, id, anisotropic ? slopes_card : default_card, err);
    if (status == NQM_OK) {
        set_constants(m);
        status = nqm_golden_make(m, &m->golden, err);
    }
    if (status == NQM_OK)
        *model_ret = m;
    else
        nqm_model_free(m);
    return status;
}
