/* SPDX-License-Identifier: MIT
 *
 * The light of a scene by the slopes of half vectors: for few points of its pictures, how much light is reflected by half
 * vectors of each cell (sample/slopes.h). A model of it estimates labels of any BRDF (metric/slopes.c).
 */
#include "label/label.h"
#include "math/math.h"
#include "metric/metric.h"
#include "model/model.h"
#include "render/render.h"
#include "sample/node_grid.h"

#include <string.h>

enum { N_LIGHTS = 65536 };

/* Every point writes its own columns. */
static void fill_point(void *user, const nqm_lit_point *point) {
    nqm_model *m = user;
    double *wo = m->slope_wo + 3 * point->column;
    nqm_turn3(point->seen->grain, point->seen->wo, wo);
    for (size_t j = 0; j < point->incident->n_rays; ++j) {
        double wi[3], light[3];
        nqm_lit_ray(point, j, wi, light);
        nqm_turn3(point->seen->grain, wi, wi);
        const size_t cell = nqm_slope_cell((wi[0] + wo[0]) / (wi[2] + wo[2]), (wi[1] + wo[1]) / (wi[2] + wo[2]));
        for (size_t c = 0; c < 3; ++c)
            m->slopes[(3 * cell + c) * m->n_slope_points + point->column] += (float)light[c];
    }
}

nqm_status nqm_slopes_fill(const nqm_scene_options *scene, size_t n_points, nqm_model *m, nqm_error *err) {
    m->slopes = nqm_alloc((size_t)NQM_SLOPE_CELLS, 3 * n_points * sizeof *m->slopes);
    m->slope_points = nqm_alloc(n_points, 3 * sizeof *m->slope_points);
    m->slope_wo = nqm_alloc(n_points, 3 * sizeof *m->slope_wo);
    if (!m->slopes || !m->slope_points || !m->slope_wo)
        return nqm_fail_nomem(err, NQM_SLOPE_CELLS * 3 * n_points * sizeof *m->slopes);
    m->n_slopes = NQM_SLOPE_CELLS;
    m->n_slope_points = m->n_slope_wo = n_points;
    return nqm_lit_points(scene, n_points, N_LIGHTS, fill_point, m, m->slope_points, err);
}
