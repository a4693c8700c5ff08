/* SPDX-License-Identifier: MIT
 *
 * metric.h - private declarations of the metric module: features and predictions of sampled pairs, golden scores.
 */
#ifndef NQM_SRC_METRIC_H
#define NQM_SRC_METRIC_H

#include "argument/argument.h"
#include "base/options.h"
#include "model/model.h"
#include "sample/sample.h"
#include <nqm/metric.h>

/** Pairs that are computed together, and pictures of them (reference, test and difference). */
enum { NQM_COMPARE_MAX = 16, NQM_TRANSPORT_MAX = 3 * NQM_COMPARE_MAX };

/** Everything below takes pairs sampled at the directions of a model or dataset as nqm_sample_pair: f_r >= 0, and where
 *  `used` is 0 the direction is dropped. Consecutive pairs with the same `ref` pointer share the work that depends only
 *  on the reference. */

/** A picture that a transport matrix makes of samples; where a direction is dropped, the test has the values of the reference. */
typedef struct nqm_transport_picture {
    const nqm_sample_pair *pair;
    enum { NQM_TRANSPORT_OF_REF, NQM_TRANSPORT_OF_TEST, NQM_TRANSPORT_OF_DIFFERENCE } of; /* test minus reference */
} nqm_transport_picture;
/** The light of points [first, first + n_points), at most NQM_PICTURE_BLOCK, in n pictures, at most NQM_TRANSPORT_MAX: rgb
 *  (n, 3, n_points) cd/m2. first and n_points are multiples of NQM_PANEL. A picture does not depend on the others. */
void nqm_transport_radiance(const nqm_transport *transport, size_t first, size_t n_points, size_t n,
                            const nqm_transport_picture *pictures, float *rgb);
/** The same as ITP on the display, in units of Delta-E (NQM_ITP_UNIT). */
void nqm_transport_pictures(const nqm_transport *transport, size_t first, size_t n_points, size_t n,
                            const nqm_transport_picture *pictures, float *itp);
/** Estimate the labels of n pairs, at most NQM_COMPARE_MAX. looks: (n) receives the means over the scenes of nqm_look_distance();
 *  NULL: they are not computed. */
void nqm_transport_estimates(const nqm_transport *transport, size_t n, const nqm_sample_pair *pairs,
                             nqm_label *estimates, double *looks);

/** Sums over the points of a picture, for its look: of powers 1 to 4 of I, of T, P and T^2 + P^2. Zero before the first point. */
typedef struct nqm_look_sums {
    double power[4], t, p, chroma2;
} nqm_look_sums;
/** Add a point. weight: its fraction of the picture; itp: times NQM_ITP_UNIT. */
void nqm_look_add(nqm_look_sums *sums, double weight, const double itp[3]);
/** How differently two pictures look to people who see them apart, in units of Delta-E. structure: that of their label. */
double nqm_look_distance(const nqm_look_sums *ref, const nqm_look_sums *test, double structure);
/** The similarity of materials that are seen apart and both ends of its interval, JOD, by the weights of the model. */
void nqm_similarity(const nqm_model *model, const double apart[NQM_APART], double similarity[3]);

/** The pictures of n pairs, at most NQM_COMPARE_MAX, for gradients: as those of nqm_transport_estimates(), but with a smooth PQ
 *  signal, and with the accuracy of float relative to the difference of the pictures. */
void nqm_transport_see(const nqm_transport *transport, size_t n, const nqm_sample_pair *pairs,
                       const nqm_shown_pair *shown);
/** Add the gradients by the samples of n tests to gradient (n, n_directions, 3), from those by their light, by_light
 *  (n, 3, n_points); in float. */
void nqm_transport_gradient(const nqm_transport *transport, size_t n, const nqm_sample_pair *pairs,
                            const float *by_light, float *gradient);

/** Pictures of n BRDFs by the transport matrix of a model, of which any two are compared without their samples. */
typedef struct nqm_gallery nqm_gallery;
/** pictures: those of another gallery of the model, which must outlive this one; NULL: they are drawn, first all 0.
 *  NQM_ERR_MODEL (the model, which must outlive it, has no transport matrix), NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_gallery_create(const nqm_model *model, size_t n, const float *pictures,
                                             nqm_gallery **gallery_ret, nqm_error *err);
void nqm_gallery_free(nqm_gallery *gallery);
/** Floats of a picture. */
size_t nqm_gallery_size(const nqm_model *model);
/** The pictures (n, nqm_gallery_size()). */
const float *nqm_gallery_pictures(const nqm_gallery *gallery);
/** Draw pictures [first, first + n) on all threads. samples: (n) of the directions of the model (n_directions, 3). */
void nqm_gallery_draw(nqm_gallery *gallery, size_t first, size_t n, const float *const *samples);
/** Let picture `at` be the mean of the n pictures of another gallery of the same model: of a material that varies. */
void nqm_gallery_average(nqm_gallery *gallery, size_t at, const nqm_gallery *of, size_t n);
/** Estimate the JODs (n) of picture a next to pictures [first, first + n) of a gallery of the same model, or, if they
 *  are seen apart, upper bounds of the similarity: the difference of the samples on a log scale is not known. Any
 *  thread. */
void nqm_gallery_jods(const nqm_gallery *gallery, size_t a, const nqm_gallery *with, size_t first, size_t n,
                      bool is_apart, float *jod);
/** Open, sample and draw n <= 2 NQM_SCORE_BLOCK BRDFs as pictures [first, first + n); the samples stay in the cache of
 *  the scorer. errors (n): of BRDFs that cannot be sampled, whose pictures mean nothing; else NQM_OK. Returns NQM_OK or
 *  NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_scorer_draw(nqm_scorer *scorer, size_t n, const nqm_subject *subjects,
                                          nqm_gallery *gallery, size_t first, nqm_error *errors, nqm_error *err);

/** The model that scores anisotropic pairs for a model whose directions have one azimuth: the built-in "anisotropic" for the built-in
 *  "default" and "transport". NULL in *anisotropic_ret, without an error: other models may predict labels of other scenes. */
NQM_MUST_CHECK nqm_status nqm_anisotropic_find(const nqm_model *model, nqm_model **anisotropic_ret, nqm_error *err);
/** The same for the model of a scorer, which owns it; the model itself if it is one of slopes. NULL: as above. */
NQM_MUST_CHECK nqm_status nqm_scorer_anisotropic(nqm_scorer *scorer, const nqm_model **anisotropic_ret, nqm_error *err);
/** Pairs as nqm_scorer_run_subjects() or nqm_scorer_run() takes them. */
typedef struct nqm_opened_pairs {
    const nqm_subject *subjects; /* (n, 2); NULL: the others */
    const nqm_brdf *ref;
    const nqm_brdf *const *tests;
} nqm_opened_pairs;
/** Whether a result of the model must be replaced by that of `anisotropic`; and replace those of n <= NQM_SCORE_BLOCK results.
 *  anisotropic NULL: they have no score (NQM_ERR_INCOMPATIBLE). */
bool nqm_anisotropic_is_needed(const nqm_model *model, const nqm_score_result *result);
NQM_MUST_CHECK nqm_status nqm_anisotropic_score(const nqm_model *anisotropic, const nqm_model *model, size_t n,
                                                const nqm_opened_pairs *pairs, nqm_score_result *results,
                                                nqm_error *err);

/** What depends only on the directions in sums over them, for many pairs. The directions must outlive it. Any thread. */
typedef struct nqm_sum_plan nqm_sum_plan;
NQM_MUST_CHECK nqm_status nqm_sum_plan_create(const nqm_directions *directions, nqm_sum_plan **plan_ret,
                                              nqm_error *err);
void nqm_sum_plan_free(nqm_sum_plan *plan);
/** Compute metrics (NQM_METRIC_COUNT), the estimate of the label, if there is a matrix, and scalar features (NQM_SCALAR_COUNT) of a
 *  pair; metrics and features may be NULL. They are NaN when no direction counts, and scalars are finite otherwise. */
void nqm_compare_samples(const nqm_sum_plan *plan, const nqm_transport *transport, const nqm_sample_pair *pair,
                         double *metrics, nqm_label *estimate, double *scalars);

enum { NQM_PREDICT_BATCH = 512 };

/** What a model predicts of a pair, and what its interval depends on. */
typedef struct nqm_prediction {
    double jod;
    double delta_e;          /* NaN where the model has no curve */
    double novelty;          /* of nqm_model_novelty(); NaN: none */
    double spread;           /* of nqm_model_spread(); 0 without scalar features */
    double bound;            /* of nqm_delta_e_bound() */
    nqm_label label;         /* parts; NaN if the model predicts none */
    double apart[NQM_APART]; /* of nqm_apart_distances(), and */
    double similarity[3];    /* nqm_similarity(); NaN without a transport matrix */
} nqm_prediction;

/** Workspace for predictions, for one thread at a time. The model must outlive it. */
typedef struct nqm_predictor nqm_predictor;

/** max_batch: largest number of pairs per call, 1..NQM_PREDICT_BATCH. */
NQM_MUST_CHECK nqm_status nqm_predictor_create(const nqm_model *model, size_t max_batch, nqm_predictor **predictor_ret,
                                               nqm_error *err);
void nqm_predictor_free(nqm_predictor *predictor);
/** Predict n (at most max_batch) pairs. The prediction of a pair does not depend on the other pairs, and the Delta-E of models that
 *  predict it keeps to nqm_delta_e_bound(). metrics: (n, NQM_METRIC_COUNT); NULL: they are not computed. */
void nqm_predictor_run(nqm_predictor *predictor, size_t n, const nqm_sample_pair *pairs, nqm_prediction *to,
                       double *metrics);

/** A bound on the Delta-E ITP of the pictures of two BRDFs whose samples hardly differ; INFINITY: no bound. It makes the
 *  scores of pairs certain that differ by rounding only, whatever the network says. */
double nqm_delta_e_bound(size_t n_directions, const nqm_sample_pair *pair);
/** The factor in that bound of the channel with the largest ratio: the gradient of the bound by f_r is the result at *at_ret, an
 *  index into (n_directions, 3), and 0 elsewhere; 0 for equal samples. */
double nqm_delta_e_bound_slope(size_t n_directions, const nqm_sample_pair *pair, size_t *at_ret);
/** Lower a predicted Delta-E to the bound, and set the JOD to match. Returns whether the bound was lower. */
bool nqm_bound_score(const nqm_model *model, double bound, double *jod, double *delta_e);
/** nqm_model_interval() with the lower end raised to the JOD at the bound plus 1.5 Delta-E, for what BRDFs do between the sampled
 *  directions. */
void nqm_bounded_interval(const nqm_model *model, const nqm_prediction *prediction, double *low, double *high);

/** Workspace for scores with gradients, for one thread at a time. Gradients are within 1e-5 of their largest component. The model
 *  must outlive it. */
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
    double anisotropy;      /* of the BRDF, if the model's directions have one azimuth; 0: none, or not of a BRDF */
    size_t n_unusual;       /* as n_unusual[1] in nqm_score_result */
    double distance_deg[2]; /* as in nqm_score_result */
    char remark[NQM_REMARK_TEXT];
} nqm_member;

/** The result of a pair without a score. */
nqm_score_result nqm_no_score(nqm_status status);
/** Set the suspicions of a result. ref, test: (n_directions, 3) f_r. */
void nqm_suspect(const nqm_directions *directions, const float *ref, const float *test, nqm_score_result *result);
/** As nqm_scorer_run_named(), of n <= NQM_SCORE_BLOCK pairs (n, 2) of references and tests. */
NQM_MUST_CHECK nqm_status nqm_scorer_run_subjects(nqm_scorer *scorer, size_t n, const nqm_subject *subjects,
                                                  nqm_score_result *results, nqm_error *errors, nqm_error *err);
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

/**
 * The scalar metrics of one sampled pair, within 1e-6 relative. Any thread.
 *
 * @param ref, test  (n, 3) f_r in 1/sr at `directions`; finite and >= 0; above 1e15 they count as 1e15
 * @param used       (n) nonzero where the direction counts; NULL: all
 * @param metrics    (NQM_METRIC_COUNT) receives them; NaN when no direction counts
 */
NQM_MUST_CHECK nqm_status nqm_metrics_compute(const nqm_directions *directions, const float *ref, const float *test,
                                              const uint8_t *used, double *metrics, nqm_error *err);

#endif
