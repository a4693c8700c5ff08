/* SPDX-License-Identifier: MIT
 *
 * metric.h - private declarations of the metric module: features and predictions of sampled pairs, golden scores.
 */
#ifndef NQM_SRC_METRIC_H
#define NQM_SRC_METRIC_H

#include "base/options.h"
#include "model/model.h"
#include "sample/sample.h"
#include <nqm/metric.h>

enum { NQM_COMPARE_MAX = 16, NQM_TRANSPORT_MAX = 2 * NQM_COMPARE_MAX, NQM_TRANSPORT_BLOCK = 128 };

/** Samples of which a transport matrix makes a picture. */
typedef struct nqm_transport_samples {
    const float *rgb;     /* (n_directions, 3) f_r >= 0 */
    const float *instead; /* the values where `used` is 0 */
    const uint8_t *used;  /* (n_directions); NULL: all are used */
} nqm_transport_samples;
/** Copy the values of n directions from `first` on: f (n, 3). */
void nqm_transport_read(const nqm_transport_samples *samples, size_t first, size_t n, float *f);
/** The light of points [first, first + n_points), at most NQM_TRANSPORT_BLOCK, in n pictures, at most NQM_TRANSPORT_MAX: rgb
 *  (n, 3, n_points) cd/m2. first and n_points are multiples of NQM_PANEL. A picture does not depend on the others. */
void nqm_transport_radiance(const nqm_transport *transport, size_t first, size_t n_points, size_t n,
                            const nqm_transport_samples *samples, float *rgb);
/** The same as ITP on the display, in units of Delta-E (NQM_ITP_UNIT). */
void nqm_transport_pictures(const nqm_transport *transport, size_t first, size_t n_points, size_t n,
                            const nqm_transport_samples *samples, float *pictures);
/** Whether a point is the last of its scene; and the share of a scene in the label. */
bool nqm_transport_ends_scene(const nqm_transport *transport, size_t point);
double nqm_transport_share(const nqm_transport *transport);
/** Estimate the labels of n pairs of samples, at most NQM_COMPARE_MAX; arguments as in nqm_sampled_pairs. Where a direction is
 *  dropped, the test has the values of the reference. Consecutive pairs with the same `ref` pointer share its picture. */
void nqm_transport_estimates(const nqm_transport *transport, size_t n, const float *const *ref,
                             const float *const *test, const uint8_t *used, nqm_label *estimates);
/** The same for one pair. */
static inline nqm_label nqm_transport_estimate(const nqm_transport *transport, const float *ref, const float *test,
                                               const uint8_t *used) {
    nqm_label label;
    nqm_transport_estimates(transport, 1, &ref, &test, used, &label);
    return label;
}

/** Pictures like those of nqm_transport_estimates(), but in double and with a smooth PQ signal: rgb[i], the light in cd/m2, and itp[i],
 *  ITP on the display in units of Delta-E, of n >= 2 pictures: (3, n_points) each. A picture does not depend on the others. */
void nqm_transport_see(const nqm_transport *transport, size_t n, const nqm_transport_samples *samples,
                       double *const *rgb, double *const *itp);
/** The second half of it: `itp` of `rgb`. Only points and n_points of the transport are used, here and in the next two. */
void nqm_transport_show(const nqm_transport *transport, const double *rgb, double *itp);
/** The label of two such pictures. */
nqm_label nqm_transport_label(const nqm_transport *transport, const double *ref, const double *test);
/** The gradient of sum_k weights_k label_k, over the members of that label, by the light of the test, `rgb`: by_light (3, n_points)
 *  receives it. Points brighter than the display have no part in it. */
void nqm_transport_light_gradient(const nqm_transport *transport, const nqm_label *weights, const double *ref,
                                  const double *test, const double *rgb, double *by_light);
/** The same by the samples of the test: gradient (n_directions, 3) receives it; 0 where `used` is 0. scratch: (3, n_points). */
void nqm_transport_gradient(const nqm_transport *transport, const nqm_label *weights, const double *ref,
                            const double *test, const double *rgb, const uint8_t *used, double *scratch,
                            double *gradient);

/** Median and interquartile range of log(test / ref) less `sign` log(cos(theta_o)), in green, over the directions where both are
 *  above 0; both NaN where there are fewer than four. rgb (2, n_directions, 3): reference and test. scratch: (n_directions). */
void nqm_log_ratio(const nqm_directions *directions, const float *rgb, double sign, double *scratch,
                   double median_range[2]);

/** Compute the scalar features of one sampled pair; arguments as in nqm_metrics_compute(). transport: NULL or without a matrix if
 *  there is none. scalars (NQM_SCALAR_COUNT) are finite for finite f_r >= 0, and NaN when no direction counts. */
void nqm_scalars_compute(const nqm_directions *directions, const nqm_transport *transport, const float *ref,
                         const float *test, const uint8_t *used, double *scalars);

/**
 * The derivatives of a weighted sum of scalar features by the samples of the test, sum_i weights[i] d scalars[i] / d test.
 * Features from NQM_SCALAR_ESTIMATE are the caller's: their weights are ignored. All arithmetic is double. Where a
 * derivative does not exist:
 * - abs(x) and sqrt(x) at 0, norms at 0: 0, so that equal pairs have finite derivatives; towards it, slopes of roots fall linearly
 *   (NQM_SMALL_ROOT, NQM_SMALL_MEAN);
 * - a maximum: that of the first direction that attains it;
 * - the cube root of c f (c = cos(theta_i) cos(theta_o)): as if c f were at least 1e-9 (NQM_CUBE_ROOT_FLOOR);
 * - test at 0: from the right.
 * Derivatives are 0 where a direction is not used, and everywhere if none is. Where the values are computed too,
 * metric/sums.h shares the first half of the work.
 *
 * @param ref, test, used  as in nqm_metrics_compute()
 * @param weights          (NQM_SCALAR_COUNT) finite
 * @param gradient         (n_directions, 3) receives them
 */
void nqm_scalars_gradient(const nqm_directions *directions, const float *ref, const float *test, const uint8_t *used,
                          const double *weights, double *gradient);
/** The same for the metrics; weights: (NQM_METRIC_COUNT). */
void nqm_metrics_gradient(const nqm_directions *directions, const float *ref, const float *test, const uint8_t *used,
                          const double *weights, double *gradient);

/** Comparison of one reference with n tests at the same directions. */
typedef struct nqm_comparison {
    const nqm_directions *directions;
    const float *ref;          /* (n_directions, 3) f_r >= 0 */
    size_t n;                  /* at most NQM_COMPARE_MAX */
    const float *const *test;  /* (n) of (n_directions, 3) */
    const uint8_t *used;       /* (n, n_directions) nonzero where the direction counts; NULL: all */
    const nqm_label *estimate; /* (n) estimated by transport; NULL: none */
} nqm_comparison;

/** Compute metrics (n, NQM_METRIC_COUNT) and scalar features (n, NQM_SCALAR_COUNT) in one pass; either may be NULL. */
void nqm_compare_samples(const nqm_comparison *comparison, double *metrics, double *scalars);

/** Pairs sampled at the model's directions. Consecutive pairs with the same `ref` pointer share the work that depends
 *  only on the reference. */
typedef struct nqm_sampled_pairs {
    size_t n;
    const float *const *ref, *const *test; /* (n) each of (n_directions, 3) f_r >= 0 */
    const uint8_t *used;                   /* (n, n_directions) 0: the direction is dropped; NULL: all are used */
    double *metrics;                       /* (n, NQM_METRIC_COUNT) receives the metrics; NULL: do not compute them */
    double *novelty;                       /* (n) receives the result of nqm_model_novelty(); NULL: do not compute it */
    double *spread;    /* (n) receives nqm_model_spread(), 0 without scalar features; NULL: not stored */
    nqm_label *labels; /* (n) receives the parts, NaN if the model predicts none; NULL: not stored */
    double *bound;     /* (n) receives nqm_delta_e_bound(); NULL: not stored */
} nqm_sampled_pairs;

enum { NQM_PREDICT_BATCH = 512 };

/** Workspace for predictions, for one thread at a time. The model must outlive it. */
typedef struct nqm_predictor nqm_predictor;

/** max_batch: largest number of pairs per call, 1..NQM_PREDICT_BATCH. */
NQM_MUST_CHECK nqm_status nqm_predictor_create(const nqm_model *model, nqm_precision precision, size_t max_batch,
                                               nqm_predictor **predictor_ret, nqm_error *err);
void nqm_predictor_free(nqm_predictor *predictor);
/**
 * Predict pairs->n (at most max_batch) pairs. The JOD of a pair does not depend on the other pairs, and the Delta-E of
 * models that predict it keeps to nqm_delta_e_bound().
 *
 * @param jod      (n)
 * @param delta_e  (n) NULL allowed; NaN where the model has no curve
 */
void nqm_predictor_run(nqm_predictor *predictor, const nqm_sampled_pairs *pairs, double *jod, double *delta_e);

/** A bound on the Delta-E ITP of the pictures of two BRDFs whose samples hardly differ; INFINITY: no bound. It makes the
 *  scores of pairs certain that differ by rounding only, whatever the network says. ref, test: (n_directions, 3) f_r >= 0;
 *  used: (n_directions) as in nqm_sampled_pairs. */
double nqm_delta_e_bound(size_t n_directions, const float *ref, const float *test, const uint8_t *used);

/** Raise the lower end of an interval (NaN: there is none) to the JOD at that bound plus 1.5 Delta-E, for what BRDFs do between
 *  the sampled directions. */
void nqm_raise_low(double delta_e_bound, double *jod_low);

/** The factor in that bound of the channel with the largest ratio: the gradient of the bound by f_r is `slope` at *at_ret, an
 *  index into (n_directions, 3), and 0 elsewhere; 0 without a bound, and for equal samples. */
double nqm_delta_e_bound_slope(size_t n_directions, const float *ref, const float *test, const uint8_t *used,
                               size_t *at_ret);

/** Workspace for scores with gradients, for one thread at a time; in float, whatever the precision of scores. The model must
 *  outlive it. */
typedef struct nqm_gradients nqm_gradients;
NQM_MUST_CHECK nqm_status nqm_gradients_create(const nqm_model *model, size_t max_batch, nqm_gradients **gradients_ret,
                                               nqm_error *err);
void nqm_gradients_free(nqm_gradients *gradients);
/** Compute values (n) and gradients (n, n_directions, 3) as nqm_score_grad(); n at most max_batch. */
void nqm_gradients_run(nqm_gradients *gradients, nqm_score_quantity of, size_t n, const nqm_sample_pair *pairs,
                       double *values, float *out);

/** One BRDF of a pair, sampled at the model's directions. */
typedef struct nqm_member {
    nqm_status status;   /* of sampling it */
    const float *rgb;    /* (n_directions, 3) f_r */
    const uint8_t *flag; /* (n_directions) nqm_value_flag; NULL: all have a value, or sampling failed */
    const uint8_t *mask; /* tests: (n_directions) 0 where the caller excludes the direction; NULL: nowhere */
    nqm_sample_report report;
    size_t n_unusual; /* as n_unusual_test in nqm_score_result */
} nqm_member;

/** Sample a BRDF into rgb (n_directions, 3) and flag (n_directions), which must outlive the member. */
nqm_member nqm_member_sample(const nqm_model *model, const nqm_brdf *brdf, nqm_invalid_policy policy, float *rgb,
                             uint8_t *flag, nqm_error *err);
/** Number of BRDFs that nqm_scorer_run_named() has opened so far, including failures and reopened ones. */
size_t nqm_scorer_n_opened(const nqm_scorer *scorer);

/**
 * Compute golden scores: the JODs of a few pairs of analytic specs, as JSON for the model file. They depend on all
 * stages (evaluation, sampling, features, network, curve), so that another build or machine can check that it
 * reproduces the results of the build that created the model.
 *
 * @param json_ret  receives the text; free with nqm_free()
 */
NQM_MUST_CHECK nqm_status nqm_golden_make(const nqm_model *model, char **json_ret, nqm_error *err);
/** Score the pairs again and compare: NQM_ERR_NUMERIC when a JOD differs by more than 0.001 from the stored one,
 *  NQM_ERR_MODEL when the model has no golden scores or they cannot be read. */
NQM_MUST_CHECK nqm_status nqm_golden_check(const nqm_model *model, nqm_error *err);

/** The options of nqm_score_options. */
extern const nqm_option_table nqm_score_option_table;

#endif
