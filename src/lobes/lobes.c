/* SPDX-License-Identifier: MIT
 *
 * Pictures of many BRDFs in parallel. BRDFs with similar lobes have the same half vectors, so that the light of a small source
 * falls on the same ones, and BRDFs that hardly differ have pictures that hardly differ.
 */
#include "lobes/lobes.h"

#include <math.h>

typedef struct pictures_job {
    const nqm_slope_light *light;
    nqm_lobe_picture *pictures;
    float *totals; /* (3, n) */
} pictures_job;

static void measure(void *user, size_t i) {
    nqm_lobe_picture *p = &((const pictures_job *)user)->pictures[i];
    p->status = p->subject ? nqm_subject_open(p->subject, NULL, &p->opened, NULL) : NQM_OK;
    p->brdf = p->subject ? p->opened : p->brdf;
    if (p->status == NQM_OK)
        p->lobe = nqm_lobe_measure(p->brdf);
}

/* Whether half vectors for one lobe suit the other: sizes and distance within a third. A lobe that is zeroed is like none. */
static bool is_like(const nqm_lobe *a, const nqm_lobe *b) {
    static const double most = 0.3;
    const double distance = hypot(a->center[0] - b->center[0], a->center[1] - b->center[1]);
    double shape = 0; /* difference of axes times their transpose, in which a round lobe has no azimuth */
    for (size_t i = 0; i < 2; ++i)
        for (size_t j = 0; j < 2; ++j)
            shape = fmax(shape, fabs(a->axes[2 * i] * a->axes[2 * j] + a->axes[2 * i + 1] * a->axes[2 * j + 1] -
                                     b->axes[2 * i] * b->axes[2 * j] - b->axes[2 * i + 1] * b->axes[2 * j + 1]));
    return fabs(log(a->width / b->width)) < most && distance < most * a->width && shape < most;
}

static void make_picture(void *user, size_t i) {
    const pictures_job *job = user;
    nqm_lobe_picture *p = &job->pictures[i];
    const nqm_lobe *own = &p->lobe, *of_ref = p->ref == SIZE_MAX ? own : &job->pictures[p->ref].lobe;
    const nqm_lobe *lobe = is_like(of_ref, own) ? of_ref : own;
    if (p->status == NQM_OK && !nqm_lobes_light(job->light, job->totals, p->brdf, lobe, p->light))
        p->status = NQM_ERR_NOMEM;
}

nqm_status nqm_lobes_pictures(const nqm_slope_light *light, size_t n, nqm_lobe_picture *pictures, nqm_ticker *ticker,
                              nqm_error *err) {
    const size_t n_totals = 3 * light->points.n;
    pictures_job job = {light, pictures, nqm_alloc(n_totals, sizeof *job.totals)};
    if (!job.totals)
        return nqm_fail_nomem(err, n_totals * sizeof *job.totals);
    for (size_t cell = 0; cell < NQM_SLOPE_CELLS; ++cell)
        for (size_t i = 0; i < n_totals; ++i)
            job.totals[i] += light->light[cell * n_totals + i];
    nqm_parallel_for(n, measure, &job);
    const bool is_stopped = nqm_parallel_ticking(ticker, "far", n, make_picture, &job);
    for (size_t i = 0; i < n; ++i)
        nqm_brdf_free(pictures[i].opened);
    nqm_free(job.totals);
    return is_stopped ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled") : NQM_OK;
}
