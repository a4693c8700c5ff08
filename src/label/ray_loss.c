/* SPDX-License-Identifier: MIT
 *
 * Delta-E of the random pictures of two BRDFs (nqm_rays_draw), and its gradient by the values of the test.
 */
#include "base/base.h"
#include "percept/percept.h"
#include <nqm/label.h>

#include <math.h>

/* Light of the points (3, n_points). Rays without a finite value: NQM_ERR_NUMERIC. */
static nqm_status add_light(const nqm_rays *rays, const double *values, const char *whose, double *rgb,
                            nqm_error *err) {
    for (size_t i = 0; i < 3 * rays->n; ++i) {
        if (!isfinite(values[i]))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "the %s has no finite value at ray %zu", whose, i / 3);
        rgb[i % 3 * rays->n_points + rays->point[i / 3]] += rays->weight[i] * values[i];
    }
    return NQM_OK;
}

nqm_status nqm_rays_compare(const nqm_rays *rays, const double *ref, const double *test, nqm_label *label_ret,
                            double *gradient, nqm_error *err) {
    NQM_REQUIRE(err, rays, ref, test, label_ret);
    static const nqm_label delta_e = {.delta_e = 1};
    const size_t n = rays->n_points;
    const nqm_picture_points points = {n, rays->points};
    double *rgb[2], *itp[2];
    *label_ret = (nqm_label){.delta_e = NAN};
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&rgb[0], n, 3 * sizeof(double)}, {&rgb[1], n, 3 * sizeof(double)},
                                                    {&itp[0], n, 3 * sizeof(double)}, {&itp[1], n, 3 * sizeof(double)}),
                                         err);
    if (status != NQM_OK)
        return status;
    status = add_light(rays, ref, "reference", rgb[0], err);
    if (status == NQM_OK)
        status = add_light(rays, test, "test", rgb[1], err);
    if (status == NQM_OK) {
        for (size_t i = 0; i < 2; ++i)
            nqm_picture_show(&points, rgb[i], itp[i]);
        *label_ret = nqm_picture_label(&points, itp[0], itp[1]);
    }
    if (status == NQM_OK && gradient) {
        double *by_light = rgb[0]; /* the light of the reference is not needed any more */
        nqm_picture_light_gradient(&points, &delta_e, &(nqm_shown_pair){itp[0], itp[1], rgb[1]}, by_light);
        for (size_t i = 0; i < 3 * rays->n; ++i)
            gradient[i] = rays->weight[i] * by_light[i % 3 * n + rays->point[i / 3]];
    }
    nqm_free(rgb[0]);
    return status;
}
