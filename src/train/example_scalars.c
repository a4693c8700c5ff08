/* SPDX-License-Identifier: MIT
 *
 * The estimated labels of the pairs, and the scalar features of the examples of a training, including scaled and noisy
 * copies. Both are computed once; the features are whitened with the moments of the training examples. The transformed
 * samples are converted back to f_r first, so that the features of a copy match the samples that the network receives
 * with them.
 */
#include "metric/metric.h"
#include "train/train.h"

#include <math.h>

typedef struct estimate_job {
    const nqm_examples *e;
    size_t first;
} estimate_job;

static void estimate_pair(void *user, size_t r) {
    const estimate_job *job = user;
    const nqm_dataset *d = job->e->dataset;
    const nqm_transport transport = nqm_dataset_transport(d);
    const size_t n = 3 * d->n_directions, pair = job->first + r;
    const uint8_t *used = nqm_dataset_pair_used(d, pair, job->e->used_scratch + r * d->n_directions);
    job->e->estimate[pair] =
        nqm_transport_estimate(&transport, d->ref_rgb + d->pair_ref[pair] * n, d->test_rgb + pair * n, used);
}

void nqm_examples_estimate(nqm_examples *e) {
    for (estimate_job job = {.e = e}; job.first < e->dataset->n_pairs; job.first += e->max_batch)
        nqm_parallel_for(nqm_smaller(e->dataset->n_pairs - job.first, e->max_batch), estimate_pair, &job);
}

typedef struct scalar_job {
    const nqm_examples *e;
    nqm_transport transport; /* only if the model gets it: predictions must compute the same features */
    size_t first;
    double *scalars; /* (n_train + n_validation, NQM_SCALAR_COUNT) */
} scalar_job;

static void example_scalars(void *user, size_t r) {
    const scalar_job *job = user;
    const nqm_examples *e = job->e;
    const size_t i = job->first + r, n = 3 * e->dataset->n_directions;
    float *rho = e->scratch + r * 2 * n;
    const float *ref_t, *test_t;
    const uint8_t *used = nqm_examples_at(e, i, r, rho, &ref_t, &test_t);
    nqm_features_restore(n, ref_t, rho);
    nqm_features_restore(n, test_t, rho + n);
    nqm_scalars_compute(e->dataset->directions, &job->transport, rho, rho + n, used,
                        job->scalars + i * NQM_SCALAR_COUNT);
}

/* Mean and standard deviation over the training examples. A constant feature gets the standard deviation 1, so that its
 * whitened value is 0. */
static void find_moments(nqm_examples *e, const double *scalars) {
    double n = (double)e->n_train;
    (void)!nqm_scalars_select(NULL, &e->scalar_whitening, NULL); /* all: cannot fail */
    for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k) {
        double sum = 0, squares = 0;
        for (size_t i = 0; i < e->n_train; ++i)
            sum += scalars[i * NQM_SCALAR_COUNT + k];
        for (size_t i = 0; i < e->n_train; ++i)
            squares += pow(scalars[i * NQM_SCALAR_COUNT + k] - sum / n, 2);
        double std = sqrt(squares / n);
        e->scalar_whitening.mean[k] = (float)(sum / n);
        e->scalar_whitening.std[k] = std > 1e-6 ? (float)std : 1;
    }
}

nqm_status nqm_examples_find_scalars(nqm_examples *e, nqm_error *err) {
    size_t n = e->n_train + e->rows.n_validation;
    double *scalars = nqm_alloc(n, NQM_SCALAR_COUNT * sizeof *scalars);
    if (!scalars)
        return nqm_fail_nomem(err, n * NQM_SCALAR_COUNT * sizeof *scalars);
    for (size_t first = 0; first < n; first += e->max_batch) {
        scalar_job job = {.e = e, .first = first, .scalars = scalars};
        if (e->estimate)
            job.transport = nqm_dataset_transport(e->dataset);
        nqm_parallel_for(nqm_smaller(n - first, e->max_batch), example_scalars, &job);
    }
    find_moments(e, scalars);
    e->scalar_whitening.scale = e->options->input.scalar_scale;
    for (size_t i = 0; i < n; ++i)
        nqm_scalars_whiten(&e->scalar_whitening, scalars + i * NQM_SCALAR_COUNT, e->scalars + i * NQM_SCALAR_COUNT);
    nqm_free(scalars);
    return NQM_OK;
}
