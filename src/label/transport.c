/* SPDX-License-Identifier: MIT
 *
 * The transport matrix of a scene: few points of the scene's pictures as linear functions of the samples of a BRDF. Every
 * light direction of a point is a half vector and a difference vector; the BRDF there is interpolated between the sampling
 * directions, so the light from there is distributed to these. The matrix of a corpus is stored in its dataset; a matrix with
 * its directions is also a model without a network.
 */
#include "label/corpus.h"
#include "math/math.h"
#include "metric/metric.h"
#include "model/model.h"
#include "render/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Settings that ranked pairs like their labels in a trial (doc/notes.md). The light directions cost nothing later. */
enum { N_NEAREST = 3, N_LIGHTS = 512 };
static const double theta_d_scale = 0.2; /* of theta_d / 90 degrees, relative to the rank of theta_h in [0, 1] */

typedef struct interpolation {
    size_t n, n_points;
    double softness;  /* distance that is added to all distances; about that of neighbours */
    double *theta_h;  /* (n) ascending */
    double *position; /* (n, 2) of the directions in the plane where the nearest are searched */
    float *light;
    double *points;
} interpolation;

/* Rank of theta_h among the sampling directions, which are denser where BRDFs change faster. */
static double rank_of(const interpolation *p, double theta_h) {
    size_t low = 0, high = p->n - 1;
    if (p->n < 2 || theta_h <= p->theta_h[0])
        return 0;
    if (theta_h >= p->theta_h[high])
        return 1;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        *(p->theta_h[middle] <= theta_h ? &low : &high) = middle;
    }
    const double width = p->theta_h[high] - p->theta_h[low];
    return ((double)low + (width > 0 ? (theta_h - p->theta_h[low]) / width : 0)) / (double)(p->n - 1);
}

static void place(const interpolation *p, const double *half_diff, double *position) {
    position[0] = rank_of(p, half_diff[0]);
    position[1] = theta_d_scale * half_diff[1] / (NQM_PI / 2);
}

static nqm_status open_interpolation(const nqm_directions *directions, interpolation *p, nqm_error *err) {
    const double *degrees = nqm_directions_degrees(directions);
    p->n = nqm_directions_count(directions);
    p->softness = 0.02 * sqrt(500 / (double)p->n);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&p->theta_h, p->n, sizeof *p->theta_h}, {&p->position, p->n, 2 * sizeof *p->position}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < p->n; ++i)
        p->theta_h[i] = degrees[3 * i] * NQM_PI / 180;
    qsort(p->theta_h, p->n, sizeof *p->theta_h, nqm_compare_doubles);
    for (size_t i = 0; i < p->n; ++i) {
        const double half_diff[2] = {degrees[3 * i] * NQM_PI / 180, degrees[3 * i + 1] * NQM_PI / 180};
        place(p, half_diff, p->position + 2 * i);
    }
    return NQM_OK;
}

/* Distribute the light of a ray (3) to the nearest directions, by inverse square distance. */
static void distribute(const interpolation *p, size_t point, const double *half_diff, const double *light) {
    size_t nearest[N_NEAREST] = {0}, n = 0;
    double square[N_NEAREST], at[2], sum = 0;
    place(p, half_diff, at);
    for (size_t i = 0; i < p->n; ++i) {
        const double x = p->position[2 * i] - at[0], y = p->position[2 * i + 1] - at[1], d = x * x + y * y;
        if (n == N_NEAREST && d >= square[n - 1])
            continue;
        n += n < N_NEAREST;
        size_t k = n - 1;
        for (; k > 0 && square[k - 1] > d; --k) {
            square[k] = square[k - 1];
            nearest[k] = nearest[k - 1];
        }
        square[k] = d;
        nearest[k] = i;
    }
    double share[N_NEAREST];
    for (size_t k = 0; k < n; ++k)
        sum += share[k] = pow(sqrt(square[k]) + p->softness, -2);
    for (size_t k = 0; k < n; ++k)
        for (size_t c = 0; c < 3; ++c)
            p->light[(3 * nearest[k] + c) * p->n_points + point] += (float)(light[c] * share[k] / sum);
}

/* The points of a scene, which has a number in its set; `first`: its first column of the matrix. */
typedef struct scene_job {
    const interpolation *to;
    const nqm_scene *scene;
    size_t number, first;
} scene_job;

/* Every point writes its own column, so that points may be computed in any order. */
static void distribute_point(void *user, size_t i) {
    const scene_job *job = user;
    const interpolation *p = job->to;
    const nqm_scene *scene = job->scene;
    const size_t point = job->first + i;
    const double *wo = scene->seen.point[i].wo;
    const nqm_incident *incident = &scene->kept[i];
    for (size_t j = 0; j < incident->n_rays; ++j) {
        const nqm_ray *ray = &incident->ray[j];
        double wi[3], half_diff[3], light[3];
        for (size_t k = 0; k < 3; ++k) {
            wi[k] = (double)ray->wi[k];
            light[k] = (double)ray->weight[k] * scene->exposure;
        }
        nqm_normalize3(wi);
        nqm_directions_to_half_diff(wi, wo, half_diff);
        distribute(p, point, half_diff, light);
    }
    p->points[3 * point] = scene->seen.weight ? scene->seen.weight[i] : 1 / (double)scene->seen.n;
    p->points[3 * point + 1] = (double)job->number;
    p->points[3 * point + 2] = scene->options.peak_cdm2;
}

nqm_status nqm_transport_fill(const nqm_scene_options *scene_options, const nqm_directions *directions, size_t n_points,
                              float *light, double *points, nqm_error *err) {
    nqm_scene_options options = *scene_options;
    options.width = options.height = 0;
    options.n_points = n_points;
    options.n_lights = options.n_lights ? options.n_lights : N_LIGHTS;
    options.interreflection = 0;
    interpolation p = {.n_points = n_points, .light = light, .points = points};
    nqm_scene *scene;
    nqm_status status = nqm_scene_create(&options, &scene, err);
    if (status != NQM_OK)
        return status;
    status = open_interpolation(directions, &p, err);
    const nqm_scene *const *parts =
        scene->n_parts ? (const nqm_scene *const *)scene->parts : (const nqm_scene *const *)&scene;
    size_t n_parts = scene->n_parts ? scene->n_parts : 1, first = 0;
    memset(light, 0, p.n * 3 * n_points * sizeof *light);
    if (status == NQM_OK && nqm_scene_count(scene) != n_points)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "scene: %zu points instead of %zu for its transport matrix",
                          nqm_scene_count(scene), n_points);
    for (size_t s = 0; status == NQM_OK && s < n_parts; ++s) {
        scene_job job = {.to = &p, .scene = parts[s], .number = s, .first = first};
        nqm_parallel_for(parts[s]->seen.n, distribute_point, &job);
        first += parts[s]->seen.n;
    }
    nqm_free(p.theta_h);
    nqm_scene_free(scene);
    return status;
}

/* ---- a model without a network ----------------------------------------------------------------------------------- */

static const char *const default_card = "Estimate by light transport, without a network: the Delta-E ITP and JOD of "
                                        "pictures of few points that a matrix makes of\n"
                                        "the samples. It has no intervals: nothing was trained or calibrated.\n";

static nqm_status set_texts(nqm_model *m, const char *id, nqm_error *err) {
    struct {
        char **to;
        const char *text;
    } texts[] = {{&m->id, id},         {&m->recipe, "transport"}, {&m->licence, "MIT"}, {&m->card, default_card},
                 {&m->training, "{}"}, {&m->manifest_sha256, ""}};
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

nqm_status nqm_transport_create(const nqm_scene_options *scene, const nqm_directions *directions, size_t n_points,
                                const char *id, nqm_model **model_ret, nqm_error *err) {
    const nqm_scene_options options = scene ? *scene : nqm_scene_options_default();
    const size_t n = nqm_directions_count(directions);
    *model_ret = NULL;
    if (n_points == 0 || n_points % NQM_TRANSPORT_STEP || n_points > NQM_TRANSPORT_MAX_POINTS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "points: %zu is no multiple of %d up to %d", n_points, NQM_TRANSPORT_STEP,
                        NQM_TRANSPORT_MAX_POINTS);
    nqm_model *m = nqm_alloc(1, sizeof *m);
    float *light = nqm_alloc(n, 3 * n_points * sizeof *light);
    double *points = nqm_alloc(n_points, 3 * sizeof *points);
    nqm_status status = m && light && points ? NQM_OK : nqm_fail_nomem(err, n * 3 * n_points * sizeof *light);
    if (status == NQM_OK)
        status = nqm_transport_fill(&options, directions, n_points, light, points, err);
    if (status == NQM_OK)
        status = nqm_model_set_transport(m, &(nqm_transport){n, n_points, light, points}, err);
    if (status == NQM_OK)
        status = nqm_directions_from_degrees(n, nqm_directions_degrees(directions), &m->directions, err);
    if (status == NQM_OK)
        status = set_texts(m, id, err);
    if (status == NQM_OK) {
        set_constants(m);
        status = nqm_golden_make(m, &m->golden, err);
    }
    nqm_free(light);
    nqm_free(points);
    if (status == NQM_OK)
        *model_ret = m;
    else
        nqm_model_free(m);
    return status;
}
