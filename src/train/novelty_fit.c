/* SPDX-License-Identifier: MIT
 *
 * Chooses the subset of the training pairs (novelty points) to which a model compares a pair to compute its novelty.
 * Each point is the candidate that is farthest from the points already chosen (Gonzalez 1985,
 * DOI 10.1016/0304-3975(85)90224-5; core-sets: Sener and Savarese 2018, arXiv:1708.00489), so that the points cover the
 * training pairs evenly, independent of their density.
 */
#include "math/math.h"
#include "train/calibrate.h"

#include <math.h>
#include <string.h>

/* Compare pairs (n) as predictions of the model do. Free *compared_ret with nqm_free(). */
static nqm_status compare(const struct nqm_model *model, const nqm_dataset *d, size_t n, const size_t *pairs,
                          nqm_comparison **compared_ret, nqm_error *err) {
    const nqm_transport transport = nqm_model_transport(model);
    *compared_ret = nqm_alloc(n, sizeof **compared_ret);
    return *compared_ret ? nqm_dataset_compare(d, &transport, n, pairs, *compared_ret, err)
                         : nqm_fail_nomem(err, n * sizeof **compared_ret);
}

/* ---- farthest-point selection ------------------------------------------------------------------------------------ */

/* Candidates and their distances to the points chosen so far. */
typedef struct spread {
    size_t n, last;  /* last: the candidate chosen last */
    size_t width;    /* features */
    const float *x;  /* (n, width) */
    double *nearest; /* (n) squared distance to the nearest point */
} spread;

static double square_distance(size_t width, const float *a, const float *b) {
    float sum[4] = {0}; /* four independent accumulators hide the latency of the additions */
    size_t k = 0;
    for (; k + 4 <= width; k += 4)
        for (size_t j = 0; j < 4; ++j)
            sum[j] += (a[k + j] - b[k + j]) * (a[k + j] - b[k + j]);
    for (; k < width; ++k)
        sum[0] += (a[k] - b[k]) * (a[k] - b[k]);
    return (double)sum[0] + (double)sum[1] + (double)sum[2] + (double)sum[3];
}

enum { SPREAD_PIECE = 512 };

static void update_piece(void *user, size_t piece) {
    const spread *s = user;
    size_t end = nqm_smaller((piece + 1) * SPREAD_PIECE, s->n);
    for (size_t i = piece * SPREAD_PIECE; i < end; ++i) {
        double d = square_distance(s->width, s->x + i * s->width, s->x + s->last * s->width);
        s->nearest[i] = fmin(s->nearest[i], d);
    }
}

static size_t farthest(const spread *s) {
    size_t best = 0;
    for (size_t i = 1; i < s->n; ++i)
        if (s->nearest[i] > s->nearest[best])
            best = i;
    return best;
}

/* The first point is the candidate nearest to the origin, because the features have a mean of about 0. */
static size_t middle(const spread *s) {
    const float zero[NQM_SCALAR_COUNT] = {0};
    size_t best = 0;
    for (size_t i = 0; i < s->n; ++i) {
        s->nearest[i] = square_distance(s->width, s->x + i * s->width, zero);
        if (s->nearest[i] < s->nearest[best])
            best = i;
    }
    return best;
}

static void choose_points(spread *s, size_t n_points, float *points) {
    s->last = middle(s);
    for (size_t i = 0; i < s->n; ++i)
        s->nearest[i] = INFINITY;
    for (size_t p = 0; p < n_points; ++p) {
        float *block = points + p / NQM_NOVELTY_BLOCK * NQM_NOVELTY_BLOCK * s->width;
        for (size_t k = 0; k < s->width; ++k)
            block[k * NQM_NOVELTY_BLOCK + p % NQM_NOVELTY_BLOCK] = s->x[s->last * s->width + k];
        nqm_parallel_for((s->n + SPREAD_PIECE - 1) / SPREAD_PIECE, update_piece, s);
        s->last = farthest(s);
    }
}

/* ---- points of a model ------------------------------------------------------------------------------------------- */

static void forget_points(struct nqm_model *model) {
    nqm_free(model->novelty_points);
    model->novelty_points = NULL;
    model->n_novelty = 0;
}

/* Added to the variances, which are about 1 for uncorrelated features: a smaller variance in training is treated as
 * noise. */
static const double least_variance = 0.01;

/* Compute the linear map from the candidates' whitened features x to uncorrelated features of variance about 1. */
static void find_map(struct nqm_model *model, size_t n, const float *x) {
    enum { MOST = NQM_SCALAR_COUNT };
    const size_t width = model->scalars.n;
    double mean[MOST] = {0}, covariance[MOST * MOST] = {0}, values[MOST], vectors[MOST * MOST];
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < width; ++k)
            mean[k] += (double)x[i * width + k] / (double)n;
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < width; ++k)
            for (size_t l = 0; l < width; ++l)
                covariance[k * width + l] +=
                    ((double)x[i * width + k] - mean[k]) * ((double)x[i * width + l] - mean[l]) / (double)n;
    nqm_eigen_symmetric(width, covariance, values, vectors);
    for (size_t k = 0; k < width; ++k)
        for (size_t l = 0; l < width; ++l)
            model->novelty_map[k * width + l] =
                (float)(vectors[l * width + k] / sqrt(fmax(values[l], 0) + least_variance));
}

static void choose_points_of(struct nqm_model *model, spread *s, size_t n_points, const nqm_comparison *compared,
                             float *x) {
    nqm_scalar_whitening whitening = model->scalars;
    whitening.scale = 1;
    for (size_t i = 0; i < s->n; ++i)
        nqm_scalars_whiten(&whitening, compared[i].scalars, x + i * s->width);
    find_map(model, s->n, x);
    for (size_t i = 0; i < s->n; ++i)
        nqm_novelty_features(model, compared[i].scalars, x + i * s->width);
    choose_points(s, n_points, model->novelty_points);
}

static nqm_status choose_among(struct nqm_model *model, const nqm_dataset *d, size_t n, const size_t *pairs,
                               nqm_error *err) {
    const size_t n_blocks = nqm_smaller(n, NQM_NOVELTY_MAX_POINTS) / NQM_NOVELTY_BLOCK, width = model->scalars.n;
    nqm_comparison *compared;
    double *nearest = NULL;
    float *x;
    model->novelty_points = nqm_alloc(n_blocks, width * NQM_NOVELTY_BLOCK * sizeof *model->novelty_points);
    nqm_status status = compare(model, d, n, pairs, &compared, err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&nearest, n, sizeof *nearest}, {&x, n, width * sizeof *x}), err);
    if (status == NQM_OK && !model->novelty_points)
        status = nqm_fail_nomem(err, n * width * sizeof *x);
    if (status == NQM_OK) {
        choose_points_of(model, &(spread){.n = n, .width = width, .x = x, .nearest = nearest},
                         n_blocks * NQM_NOVELTY_BLOCK, compared, x);
        model->n_novelty = n_blocks;
        model->novelty_unit = 1;
        model->novelty_growth = 0;
    } else {
        forget_points(model);
    }
    nqm_free(compared);
    nqm_free(nearest);
    return status;
}

nqm_status nqm_novelty_choose(struct nqm_model *model, const nqm_dataset *d, nqm_error *err) {
    forget_points(model);
    if (model->scalars.n == 0)
        return NQM_OK;
    size_t n = 0, *pairs = nqm_alloc(d->n_pairs, sizeof *pairs);
    if (!pairs)
        return nqm_fail_nomem(err, d->n_pairs * sizeof *pairs);
    for (size_t i = 0; i < d->n_pairs; ++i)
        if (nqm_dataset_pair_split(d, i) == NQM_SPLIT_TRAIN)
            pairs[n++] = i;
    nqm_status status = n < NQM_NOVELTY_BLOCK ? NQM_OK : choose_among(model, d, n, pairs, err);
    nqm_free(pairs);
    return status;
}

/* Set r->novelty and the model's unit. sorted: (n) scratch. */
static void measure_novelty(struct nqm_model *model, const nqm_comparison *compared, double *novelty, double *sorted,
                            nqm_residuals *r) {
    model->novelty_unit = 1;
    for (size_t i = 0; i < r->n; ++i)
        novelty[i] = sorted[i] = nqm_model_novelty(model, compared[i].scalars);
    model->novelty_unit = nqm_quantile(r->n, sorted, 0.95);
    if (model->novelty_unit > 0)
        r->novelty = novelty;
    else
        forget_points(model);
    for (size_t i = 0; r->novelty && i < r->n; ++i)
        novelty[i] /= model->novelty_unit;
}

nqm_status nqm_novelty_measure(struct nqm_model *model, const nqm_dataset *d, nqm_residuals *r, nqm_error *err) {
    double *novelty = r->novelty, *features = r->spread;
    r->novelty = r->spread = NULL;
    if (model->scalars.n == 0)
        return NQM_OK;
    nqm_comparison *compared;
    double *sorted = nqm_alloc(r->n, sizeof *sorted);
    nqm_status status = compare(model, d, r->n, r->pairs, &compared, err);
    if (status == NQM_OK && !sorted)
        status = nqm_fail_nomem(err, r->n * sizeof *sorted);
    if (status == NQM_OK) {
        r->spread = features;
        for (size_t i = 0; i < r->n; ++i) {
            const double *own = compared[i].scalars;
            nqm_spread_features(model, r->predicted[i], own[NQM_SCALAR_ESTIMATE], own[NQM_SCALAR_REF_PEAK],
                                features + i * NQM_SPREAD_FEATURES);
        }
        if (model->n_novelty > 0)
            measure_novelty(model, compared, novelty, sorted, r);
    }
    nqm_free(compared);
    nqm_free(sorted);
    return status;
}
