/* SPDX-License-Identifier: MIT
 *
 * compose.h - the inputs of a model's network for a batch of sampled pairs.
 */
#ifndef NQM_SRC_METRIC_COMPOSE_H
#define NQM_SRC_METRIC_COMPOSE_H

#include "metric/sums.h"

/** Workspace, and what is computed of a batch. Pairs are processed in tasks of at most NQM_COMPARE_MAX: enough to share the matrix
 *  of light transport, few enough for all threads. */
typedef struct nqm_composer {
    const nqm_model *model;
    size_t samples_width; /* number of inputs that come from samples */
    size_t stride;        /* floats from one row of x to the next */
    size_t n_threads;     /* when it was created: there are buffers for so many tasks */
    nqm_sum_plan *plan;
    float *t;            /* (tasks, 2, n_directions, 3) transformed reference and test: a task stays in the L2 cache */
    float *root;         /* (tasks, 1 + NQM_COMPARE_MAX, n_directions, 3) cube roots of a reference and its tests */
    float *x;            /* (max_batch, stride) network inputs; empty without a network */
    nqm_pair_sums *sums; /* (max_batch) */
    double *scalars;     /* (max_batch, NQM_SCALAR_COUNT), of models with scalar features */
    double *bound;       /* (max_batch) of nqm_delta_e_bound() */
    nqm_label *estimate; /* (max_batch) by transport, if the model has it: set by the caller, */
    double *looks;       /* (max_batch) and these */
} nqm_composer;

/** The model must outlive it. */
NQM_MUST_CHECK nqm_status nqm_composer_create(const nqm_model *model, size_t max_batch, nqm_composer **composer_ret,
                                              nqm_error *err);
void nqm_composer_free(nqm_composer *composer);
/** Pairs per task of a batch of n. */
size_t nqm_composer_task(const nqm_composer *composer, size_t n);
/** The cube roots of a task's reference and tests. */
float *nqm_composer_root(const nqm_composer *composer, size_t task);

/** Compute what does not depend on the estimate of pairs [first, first + n) of the batch: bound, inputs from samples,
 *  and sums if there are scalar features, a transport matrix or with_metrics. pairs: (n); consecutive ones with the
 *  same `ref` pointer share the work on it. */
void nqm_compose_samples(const nqm_composer *composer, size_t task, size_t first, size_t n,
                         const nqm_sample_pair *pairs, bool with_metrics);
/** Compute the scalar features and inputs of the same pairs from sums and estimates, and metrics (batch, NQM_METRIC_COUNT) unless
 *  they are NULL. */
void nqm_compose_scalars(const nqm_composer *composer, size_t first, size_t n, double *metrics);

#endif
