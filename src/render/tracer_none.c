/* SPDX-License-Identifier: MIT
 *
 * Replaces tracer_embree.c in builds without Embree (NQM_EMBREE off), which have no meshes.
 */
#include "render/render.h"

const char *nqm_tracer_version(void) {
    return NULL;
}

bool nqm_tracer_available(void) {
    return false;
}

nqm_status nqm_tracer_create(const nqm_mesh *mesh, nqm_tracer **tracer_ret, nqm_error *err) {
    (void)mesh;
    *tracer_ret = NULL;
    return nqm_fail(err, NQM_ERR_ARG, -1, "scene: this build of nqm has no Embree, so 'sphere' is its only shape");
}

void nqm_tracer_free(nqm_tracer *tracer) {
    (void)tracer;
}

bool nqm_tracer_hit(const nqm_tracer *tracer, const double *origin, const double *direction, size_t *triangle,
                    double *corner_weight) {
    (void)tracer, (void)origin, (void)direction, (void)triangle, (void)corner_weight;
    return false;
}

bool nqm_tracer_blocked(const nqm_tracer *tracer, const double *origin, const double *direction) {
    (void)tracer, (void)origin, (void)direction;
    return false;
}
