/* SPDX-License-Identifier: MIT
 *
 * A picture of each of many BRDFs, by the transport matrix of a model, from which the Delta-E of any two follows without their
 * samples: of n BRDFs n products by the matrix, instead of one for each pair. The estimates are those of transport.c where both
 * BRDFs have all values; a model with a network corrects them (nqm_scorer_run_named()).
 */
#include "metric/sums.h"
#include "percept/percept.h"

#include <math.h>
#include <string.h>

struct nqm_gallery {
    const nqm_model *model;
    nqm_transport transport;
    const nqm_curve *curve;
    size_t n, n_scenes;
    float *weights;       /* (n_points) fractions of the picture */
    nqm_look_sums *looks; /* (n, n_scenes) */
    float *drawn;         /* (n, 3, n_points) ITP in units of Delta-E; NULL: the caller has them */
    const float *pictures;
};

static void add_looks(void *user, size_t i) {
    const nqm_gallery *g = user;
    const nqm_picture_points *points = &g->transport.points;
    const size_t n = points->n;
    const float *x = g->pictures + 3 * n * i;
    nqm_look_sums *look = g->looks + g->n_scenes * i;
    memset(look, 0, g->n_scenes * sizeof *look);
    for (size_t p = 0; p < n; ++p) {
        const double itp[3] = {(double)x[p], (double)x[n + p], (double)x[2 * n + p]};
        nqm_look_add(look + (size_t)points->at[3 * p + 1], points->at[3 * p], itp);
    }
}

nqm_status nqm_gallery_create(const nqm_model *model, size_t n, const float *pictures, nqm_gallery **gallery_ret,
                              nqm_error *err) {
    const nqm_transport t = nqm_model_transport(model);
    nqm_gallery *g;
    float *weights, *drawn;
    nqm_look_sums *looks;
    *gallery_ret = NULL;
    if (!t.light)
        return nqm_fail(err, NQM_ERR_MODEL, -1,
                        "model '%s' has no transport matrix, by which many materials are compared; use default or "
                        "transport",
                        model->id);
    const size_t n_scenes = 1 + (size_t)t.points.at[3 * t.points.n - 2];
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&g, 1, sizeof *g}, {&weights, t.points.n, sizeof *weights},
                                                    {&looks, n * n_scenes, sizeof *looks},
                                                    {&drawn, pictures ? 0 : n, 3 * t.points.n * sizeof *drawn}),
                                         err);
    if (status != NQM_OK)
        return status;
    for (size_t p = 0; p < t.points.n; ++p)
        weights[p] = (float)t.points.at[3 * p];
    const nqm_curve *curve = model->target == NQM_TARGET_LOG_DELTA_E ? &model->curve : &nqm_curve_published;
    *g = (nqm_gallery){model, t, curve, n, n_scenes, weights, looks, drawn, pictures ? pictures : drawn};
    if (pictures)
        nqm_parallel_for(n, add_looks, g);
    *gallery_ret = g;
    return NQM_OK;
}

void nqm_gallery_free(nqm_gallery *gallery) {
    nqm_free(gallery);
}

size_t nqm_gallery_size(const nqm_model *model) {
    return 3 * nqm_model_transport(model).points.n;
}

const float *nqm_gallery_pictures(const nqm_gallery *g) {
    return g->pictures;
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

typedef struct draw_job {
    nqm_gallery *gallery;
    size_t first, n;
    const float *const *samples;
} draw_job;

static void draw_group(void *user, size_t group) {
    const draw_job *job = user;
    nqm_gallery *g = job->gallery;
    const nqm_transport *t = &g->transport;
    const size_t begin = group * NQM_TRANSPORT_MAX, n = nqm_smaller(job->n - begin, NQM_TRANSPORT_MAX);
    nqm_sample_pair pairs[NQM_TRANSPORT_MAX];
    nqm_transport_picture pictures[NQM_TRANSPORT_MAX];
    float itp[NQM_TRANSPORT_MAX * 3 * NQM_PICTURE_BLOCK];
    for (size_t i = 0; i < n; ++i) {
        pairs[i] = (nqm_sample_pair){.ref = job->samples[begin + i]};
        pictures[i] = (nqm_transport_picture){&pairs[i], NQM_TRANSPORT_OF_REF};
    }
    for (size_t p = 0, n_points; p < t->points.n; p += n_points) {
        n_points = nqm_smaller(t->points.n - p, NQM_PICTURE_BLOCK);
        nqm_transport_pictures(t, p, n_points, n, pictures, itp);
        for (size_t i = 0; i < n; ++i)
            for (size_t c = 0; c < 3; ++c)
                memcpy(g->drawn + (3 * (job->first + begin + i) + c) * t->points.n + p, itp + (3 * i + c) * n_points,
                       n_points * sizeof *itp);
    }
    for (size_t i = 0; i < n; ++i)
        add_looks(g, job->first + begin + i);
}

void nqm_gallery_draw(nqm_gallery *g, size_t first, size_t n, const float *const *samples) {
    draw_job job = {g, first, n, samples};
    nqm_parallel_for(nqm_ceil_div(n, NQM_TRANSPORT_MAX), draw_group, &job);
}

void nqm_gallery_average(nqm_gallery *g, size_t at, const nqm_gallery *of, size_t n) {
    const size_t size = 3 * g->transport.points.n;
    float *mean = g->drawn + size * at;
    memset(mean, 0, size * sizeof *mean);
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < size; ++k)
            mean[k] += of->pictures[size * i + k] / (float)n;
    add_looks(g, at);
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

/* Weighted sums over the n points of a scene: of the lengths of the differences, and of their squares. */
static void compare_points(size_t n, size_t step, const float *w, const float *a, const float *b, double *lengths,
                           double *squares) {
    float sum = 0, sum2 = 0;
#pragma omp simd reduction(+ : sum, sum2)
    for (size_t p = 0; p < n; ++p) {
        const float x = a[p] - b[p], y = a[step + p] - b[step + p], z = a[2 * step + p] - b[2 * step + p];
        const float square = x * x + y * y + z * z;
        sum += w[p] * sqrtf(square);
        sum2 += w[p] * square;
    }
    *lengths = (double)sum;
    *squares = (double)sum2;
}

/* The label of two pictures; looks NULL: its Delta-E only. */
static nqm_label compare_pictures(const nqm_gallery *g, size_t a, const nqm_gallery *h, size_t b, double *looks) {
    const nqm_picture_points *points = &g->transport.points;
    const size_t step = points->n;
    const double share = nqm_picture_share(points);
    nqm_label label = {.delta_e = 0};
    for (size_t p = 0, end, scene = 0; p < step; p = end, ++scene) {
        const nqm_look_sums *x = &g->looks[a * g->n_scenes + scene], *y = &h->looks[b * h->n_scenes + scene];
        double lengths, squares;
        end = nqm_picture_scene_end(points, p);
        compare_points(end - p, step, g->weights + p, g->pictures + 3 * step * a + p, h->pictures + 3 * step * b + p,
                       &lengths, &squares);
        if (!looks) {
            label.delta_e += share * lengths;
            continue;
        }
        const nqm_picture_sums sums = {.delta_e = lengths,
                                       .squares = squares,
                                       .shift = {y->power[0] - x->power[0], y->t - x->t, y->p - x->p},
                                       .ref = x->power[0],
                                       .ref_squares = x->power[1],
                                       .test = y->power[0],
                                       .test_squares = y->power[1]};
        const nqm_label one = nqm_picture_sums_label(&sums);
        nqm_label_add(&label, share, &one);
        *looks += share * nqm_look_distance(x, y, one.structure);
    }
    return label;
}

void nqm_gallery_jods(const nqm_gallery *g, size_t a, const nqm_gallery *with, size_t first, size_t n, bool is_apart,
                      float *jod) {
    static const nqm_metric_sums no_log = {.n = 1};
    double distances[NQM_APART], similarity[3];
    for (size_t i = 0; i < n; ++i) {
        double looks = 0;
        const nqm_label label = compare_pictures(g, a, with, first + i, is_apart ? &looks : NULL);
        if (is_apart) {
            nqm_apart_distances(&label, looks, &no_log, distances);
            nqm_similarity(g->model, distances, similarity);
        }
        jod[i] = (float)(is_apart ? similarity[0] : nqm_curve_jod(g->curve, label.delta_e));
    }
}
