/* SPDX-License-Identifier: MIT
 *
 * JOD, scalar features and estimate of pairs that a test has sampled itself.
 */
#ifndef NQM_TEST_PREDICT_H
#define NQM_TEST_PREDICT_H

#include "metric/metric.h"
#include "support/check.h"

#include <nqm/metric.h>
#include <stdlib.h>

/** ref, test: (n, n_directions, 3); jod: (n). */
static inline void predict_jod(const nqm_model *model, size_t n, const float *ref, const float *test, double *jod) {
    const size_t width = 3 * nqm_directions_get_info(nqm_model_get_info(model).directions).n;
    nqm_sample_pair *pairs = calloc(n, sizeof *pairs);
    nqm_score_result *results = calloc(n, sizeof *results);
    nqm_scorer *scorer;
    for (size_t i = 0; i < n; ++i)
        pairs[i] = (nqm_sample_pair){.ref = ref + width * i, .test = test + width * i};
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, NULL), NQM_OK);
    assert_int_equal(nqm_scorer_run_samples(scorer, n, pairs, results, NULL), NQM_OK);
    for (size_t i = 0; i < n; ++i) {
        assert_int_equal(results[i].status, NQM_OK);
        jod[i] = results[i].jod;
    }
    nqm_scorer_free(scorer);
    free(pairs);
    free(results);
}

static inline nqm_label transport_estimate(const nqm_transport *transport, const float *ref, const float *test,
                                           const uint8_t *used) {
    nqm_label label;
    nqm_transport_estimates(transport, 1, &(nqm_sample_pair){ref, test, used}, &label, NULL);
    return label;
}

/** The scalar features of a pair; transport: NULL if there is none. */
static inline void compute_scalars(const nqm_directions *at, const nqm_transport *transport, const float *ref,
                                   const float *test, const uint8_t *used, double *scalars) {
    const nqm_transport none = {0};
    nqm_sum_plan *plan;
    nqm_label estimate;
    assert_int_equal(nqm_sum_plan_create(at, &plan, NULL), NQM_OK);
    nqm_compare_samples(plan, transport ? transport : &none, &(nqm_sample_pair){ref, test, used}, NULL, &estimate,
                        scalars);
    nqm_sum_plan_free(plan);
}

#endif
