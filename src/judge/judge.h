/* SPDX-License-Identifier: MIT
 *
 * judge.h - how well models and metrics agree with labels and with people's answers. doc/evaluation.md defines the
 * statistics.
 */
#ifndef NQM_SRC_JUDGE_JUDGE_H
#define NQM_SRC_JUDGE_JUDGE_H

#include "base/options.h"
#include "data/data.h"
#include "metric/metric.h"
#include "model/model.h"
#include <nqm/metric.h>

/** A statistic and its 95 % interval: the 2.5 and 97.5 percentiles over resamples of the material groups, drawn with
 *  replacement (Efron 1979, DOI 10.1214/aos/1176344552). NaN where the statistic is not defined; the interval is NaN without
 *  resamples and for fewer than 4 materials. */
typedef struct nqm_estimate {
    double value, ci95[2];
} nqm_estimate;

/** How well one predictor agrees with the labels. Correlations are signed so that higher is better. */
typedef struct nqm_agreement {
    const char *name;      /**< the model's id, nqm_metric_info.name, or "estimate" */
    size_t n, n_materials; /**< pairs and material groups */
    size_t n_ordered;      /**< pairs of tests of one material whose labels differ by more than order_margin */
    nqm_estimate spearman; /**< over all pairs */
    nqm_estimate spearman_mean_by_material; /**< mean over the groups with at least 3 pairs */
    nqm_estimate pearson, kendall;          /**< over all pairs; Kendall's tau-b */
    nqm_estimate mae, rmse, r2; /**< errors of the predicted JOD; NaN for metrics and for labels that are not JOD */
    nqm_estimate order; /**< fraction of the n_ordered that is predicted in the order of the labels; ties count half */
    int best_of_family; /**< 1: the metric has the higher `spearman` of its family (RMSE and MAE, CRWE, LogE, LogWE) */
    int best_baseline;  /**< 1: the highest `spearman` of the paper's eight baselines */
} nqm_agreement;

/** Which pairs to judge, and how. From nqm_eval_options_default(). */
typedef struct nqm_eval_options {
    nqm_split split;    /**< default NQM_SPLIT_ALL */
    const char *kind;   /**< only this kind of distortion; NULL: all */
    const char *family; /**< only kinds of this family; NULL: all */
    /** Only "near" (approximations of the reference: all known families but the next two), "far" or "rounding" (these
     *  families); or "unseen" (kinds that the dataset's manifest lists as missing in the training part of such corpora) or "seen"
     *  (the others, if it lists any). NULL: all. */
    const char *subset;
    const char *material_class; /**< only references of this class; NULL: all */
    const char *source;         /**< only references of this source, as in nqm_dataset_pair; NULL: all */
    double jod_from, jod_to;    /**< only labels in [from, to); default 0 and infinity */
    double order_margin;        /**< of nqm_agreement.order, in the unit of the labels; >= 0; default 0.25 */
    size_t n_bootstrap;         /**< resamples of the material groups; 0: no intervals; default 1000 */
    uint64_t seed;              /**< seed of the resampling; default 1 */
    int apart; /**< 1: judge models by the similarity (nqm_score_result) where they have it: for answers about
                                     materials that people did not see beside each other */
    nqm_progress_fn progress; /**< NULL: none */
    void *progress_user;
} nqm_eval_options;

/** The defaults above. */
nqm_eval_options nqm_eval_options_default(void);

/**
 * Predictions of models and of the nine scalar metrics for the pairs of a dataset: made once, judged on any number of
 * selections. Predictors are numbered: the n_models models in their order; the NQM_METRIC_COUNT metrics in the order of
 * nqm_metric; and, if the dataset has a transport matrix, "estimate", the label that it estimates from the samples alone.
 * Immutable; any thread.
 */
typedef struct nqm_evaluation nqm_evaluation;

/**
 * Predict all pairs of options->split; the other fields select among them later.
 *
 * @param dataset  owned by the caller, as are the models: they must outlive the evaluation
 * @param models   (n_models); n_models 0: metrics only
 * @param datasets (n_models) for models of different directions: the pairs of `dataset`, in its order, at the directions of
 *                 each model; they must outlive the evaluation. Metrics and the estimate are those of `dataset`. NULL: all
 *                 models have the directions of `dataset`
 * @return NQM_ERR_INCOMPATIBLE (a model has other directions than the dataset, or no pair is left), NQM_ERR_NUMERIC,
 *         NQM_ERR_CANCELLED, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_evaluation_create(const nqm_dataset *dataset, size_t n_models,
                                                const nqm_model *const *models, const nqm_dataset *const *datasets,
                                                const nqm_eval_options *options, nqm_evaluation **evaluation_ret,
                                                nqm_error *err);
/** Free an evaluation; NULL is allowed. */
void nqm_evaluation_free(nqm_evaluation *evaluation);
/** (n_pairs of the dataset) labels with parts by predictor i: a model that predicts parts, or the estimate; NULL for others. NaN
 *  for pairs outside the split. Owned by the evaluation. */
const nqm_label *nqm_evaluation_labels(const nqm_evaluation *evaluation, size_t i);
/** (n_pairs of the dataset) predictions of predictor i: JOD of a model or the estimate, distance of a metric; NaN for pairs
 *  outside the split. Owned by the evaluation. */
const double *nqm_evaluation_values(const nqm_evaluation *evaluation, size_t i);

/**
 * Judge every predictor on the pairs that `options` selects. All predictors see the same resamples.
 *
 * @param results  (n_predictors of the evaluation)
 * @return NQM_ERR_ARG (order_margin), NQM_ERR_INCOMPATIBLE (no pair is left), NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_evaluation_judge(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                               nqm_agreement *results, nqm_error *err);

/** A difference between two predictors. */
typedef struct nqm_difference {
    double value, ci95[2]; /**< as in nqm_estimate */
    double share_below_0;  /**< fraction of the resamples in which the first is worse; NaN without resamples */
} nqm_difference;

/** Which of two predictors agrees better with the labels. */
typedef struct nqm_contrast {
    size_t first, second;                                      /**< input: numbers of the predictors */
    nqm_difference spearman, spearman_mean_by_material, order; /**< out: the first minus the second */
} nqm_contrast;

/**
 * Compare predictors on the pairs that `options` selects: a paired bootstrap on the resamples of nqm_evaluation_judge().
 *
 * @param contrasts  (n_contrasts)
 * @return as nqm_evaluation_judge(); NQM_ERR_ARG also for a number that no predictor has
 */
NQM_MUST_CHECK nqm_status nqm_evaluation_contrast(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                                  size_t n_contrasts, nqm_contrast *contrasts, nqm_error *err);

/** The pairs with a predicted JOD from `from` up to the next range; the first range includes lower JODs. Fractions are NaN
 *  where n is 0. */
typedef struct nqm_coverage_range {
    double from; /**< JOD: 0, 4, 8, 9.5, 9.9 */
    size_t n;
    double inside;     /**< fraction of the labels inside their interval */
    double mean_width; /**< JOD */
} nqm_coverage_range;
enum { NQM_COVERAGE_RANGES = 5 };

/** How many labels lie inside a model's 95 % intervals. */
typedef struct nqm_coverage {
    size_t n, n_materials;
    nqm_estimate inside;         /**< fraction of the labels, over all pairs */
    nqm_estimate by_material;    /**< mean over materials */
    double lowest;               /**< fraction of the material where it is lowest */
    const char *lowest_material; /**< name of this material; owned by the dataset */
    double below, above;         /**< fractions of the labels below and above their interval */
    double mean_width;           /**< JOD */
    nqm_coverage_range ranges[NQM_COVERAGE_RANGES];
} nqm_coverage;

/**
 * Coverage of one model on the pairs that `options` selects, on the resamples of nqm_evaluation_judge().
 *
 * @param model    number of a predictor that is a model with intervals (nqm_model_info.calibration is not "")
 * @return NQM_ERR_ARG (no such model), NQM_ERR_INCOMPATIBLE (no pair is left, or labels are not JOD), NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_evaluation_coverage(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                                  size_t model, nqm_coverage *coverage_ret, nqm_error *err);

/** How well a model predicts one part of the labels (adapted_jod: nqm_label_adapted_jod()), beside two controls: Spearman
 *  correlations over all pairs. */
typedef struct nqm_part_agreement {
    const char *part; /**< "shift_i", "shift_t", "shift_p", "contrast", "structure" or "adapted_jod" */
    size_t n, n_materials;
    nqm_estimate model;    /**< correlation of the part that the model predicts */
    nqm_estimate estimate; /**< correlation of the part estimated by light transport; NaN without a transport matrix */
    nqm_estimate scalar;   /**< correlation of the best of the scalar features that are closest to the part */
    const char *scalar_name; /**< its name */
    /** Whether words say what pictures show: the pairs whose label has a part above 3 Delta-E (contrast: 0.1) in size, and the
     *  fraction of them for which the model predicts a part of the same sign (structure: of 1 Delta-E or more). Similarity: 0 and
     *  NaN. */
    size_t n_plain;
    double same_sign; /**< NaN if n_plain is 0 */
} nqm_part_agreement;
enum { NQM_EVAL_PARTS = 6 };

/**
 * Judge the parts that one model predicts on the pairs that `options` selects, on the resamples of nqm_evaluation_judge().
 *
 * @param model    number of a predictor that is a model with parts: nqm_evaluation_labels() is not NULL
 * @param results  (NQM_EVAL_PARTS)
 * @return NQM_ERR_ARG (no such model), NQM_ERR_INCOMPATIBLE (no pair is left, or the labels have no parts), NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_evaluation_judge_parts(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                                     size_t model, nqm_part_agreement *results, nqm_error *err);

/* ---- choices of people ------------------------------------------------------------------------------------------- */

/** How well one predictor agrees with the choices. */
typedef struct nqm_choice_agreement {
    const char *name;       /**< as in nqm_agreement */
    nqm_estimate agreement; /**< fraction of the choices for the test that it finds better; ties count half */
    double majority;        /**< fraction of the triplets without a draw in which it agrees with the majority; ties
                                            count half */
    int best_of_family, best_baseline; /**< as in nqm_agreement, by `agreement` */
} nqm_choice_agreement;

/**
 * Judge every predictor of an evaluation of human->dataset on the choices.
 *
 * @param options  n_bootstrap and seed are used
 * @param results  (n_predictors of the evaluation)
 * @return NQM_ERR_ARG (scores, or an evaluation of another dataset), NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_human_judge_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                                  const nqm_eval_options *options, nqm_choice_agreement *results,
                                                  nqm_error *err);
/** `agreement` of predictor `first` minus that of `second`, on the same resamples; arguments and status as above. */
NQM_MUST_CHECK nqm_status nqm_human_contrast_choices(const nqm_human *human, const nqm_evaluation *evaluation,
                                                     const nqm_eval_options *options, size_t first, size_t second,
                                                     nqm_difference *difference_ret, nqm_error *err);

/* ---- weights from answers of people ------------------------------------------------------------------------------ */

/** A similarity fitted to answers, which are choices, or scores as choices between the tests of a material that differ. */
typedef struct nqm_readout {
    size_t n_triplets, n_materials; /**< with answers */
    double n_choices;
    double weight[NQM_APART],
        ci95[NQM_APART][2]; /**< of the distances of nqm_apart_distances(): a person chooses a with the probability
                                                       1 / (1 + exp(d_a - d_b)); interval over resamples of the materials */
    double half_width;      /**< 95 % half-width of the logarithm of the distance */
    double scale;           /**< times `weight`: the mean distance of the answers' pairs is the built-in one */
    double jod, similarity; /**< fraction of the choices that the model's scores agree with */
    double fitted;          /**< the same of weights that were fitted to the other four fifths of the materials */
    nqm_difference gain;    /**< `fitted` less the better of both */
} nqm_readout;
/**
 * Fit a readout. The answers were sampled at the directions of the model.
 *
 * @param options  n_bootstrap and seed are used
 * @return NQM_ERR_INCOMPATIBLE: the model has no transport matrix, or fewer than 5 materials have answers; NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_human_fit_readout(const nqm_human *human, const nqm_model *model,
                                                const nqm_eval_options *options, nqm_readout *readout_ret,
                                                nqm_error *err);
/** Give it to a model that is not shared yet. */
void nqm_readout_set(const nqm_readout *readout, nqm_model *model);
/** Names of the distances. */
extern const char *const nqm_apart_names[NQM_APART];

/* ---- agreement over grouped pairs (agreement.c) ------------------------------------------------------------------ */

/* Most statistics of a resample are computed from sums per group; only the rank correlations over all pairs require the individual
 * pairs. */

enum { NQM_MIN_PAIRS_OF_GROUP = 3 }; /* with fewer, the rank correlation of a group is not meaningful */

/** Predictions and labels of n pairs, sorted by group. Higher predictions must mean higher labels. */
typedef struct nqm_judgement {
    size_t n, n_groups, n_predictors;
    const size_t *group_begin; /* (n_groups + 1) pairs of group g: [group_begin[g], group_begin[g + 1]); not empty */
    const double *label;       /* (n) */
    const double *prediction;  /* (n_predictors, n) finite */
    double order_margin;       /* two pairs of a group have an order if their labels differ by more than this; >= 0 */
    bool without_kendall;      /* skip Kendall (NaN), the slowest statistic */
} nqm_judgement;

/** Compute results (n_predictors), except name and flags. The intervals are the 2.5 and 97.5 percentiles over
 * n_bootstrap resamples, with replacement, of the groups; NaN where nqm_bootstrap_count() is 0. All predictors use the
 * same resamples. */
NQM_MUST_CHECK nqm_status nqm_judge(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                    nqm_agreement *results, nqm_error *err);

/** Compute contrasts (n_contrasts) between their predictors `first` and `second`, with the same resamples as
 * nqm_judge() for this seed. */
NQM_MUST_CHECK nqm_status nqm_judge_contrasts(const nqm_judgement *judgement, size_t n_bootstrap, uint64_t seed,
                                              size_t n_contrasts, nqm_contrast *contrasts, nqm_error *err);

/** Set the flags best_of_family and best_baseline of metrics (NQM_METRIC_COUNT) according to `spearman`. */
void nqm_mark_best(nqm_agreement *metrics);

/** 2.5 and 97.5 percentiles of x (n), ignoring NaN; reorders x. */
void nqm_interval95(size_t n, double *x, double ci95[2]);
/** The number of resamples to draw: n_bootstrap, or 0 with fewer than 4 groups. A resample is n times the same group
 *  with probability n^-n for each group; where this exceeds 2.5 %, the ends of the interval would be statistics of
 *  single groups. */
size_t nqm_bootstrap_count(size_t n_groups, size_t n_bootstrap);
/** The sum of met (n_groups, stride) over that of all (n_groups); weight (n_groups): how often each group counts; NULL: once. */
double nqm_share_of(size_t n_groups, size_t stride, const double *met, const double *all, const double *weight);
/** Statistics of first - second over resamples (n, NaN ignored). value: difference without resampling; scratch (n). */
nqm_difference nqm_difference_of(double value, size_t n, const double *first, const double *second, double *scratch);

/* ---- resamples (bootstrap.c) ------------------------------------------------------------------------------------- */

/** Sums over the pairs of a group; x is the prediction and y the label, each minus a constant. */
enum {
    NQM_SUM_N,
    NQM_SUM_X,
    NQM_SUM_Y,
    NQM_SUM_XX,
    NQM_SUM_YY,
    NQM_SUM_XY,
    NQM_SUM_ABS_ERROR,
    NQM_SUM_SQUARED_ERROR,
    NQM_SUM_GROUPS_WITH_RHO,
    NQM_SUM_RHO,     /* Spearman within the group */
    NQM_SUM_ORDERED, /* pairs of pairs whose labels have an order */
    NQM_SUM_RIGHT,   /* pairs of tests predicted in the right order; ties count half */
    NQM_SUM_COUNT
};

enum {
    NQM_STATISTIC_SPEARMAN,
    NQM_STATISTIC_BY_GROUP,
    NQM_STATISTIC_PEARSON,
    NQM_STATISTIC_KENDALL,
    NQM_STATISTIC_MAE,
    NQM_STATISTIC_RMSE,
    NQM_STATISTIC_R2,
    NQM_STATISTIC_ORDER,
    NQM_STATISTIC_COUNT
};

/** Compute all statistics except NQM_STATISTIC_SPEARMAN and NQM_STATISTIC_KENDALL, which become NaN, from sums
 *  (n_groups, NQM_SUM_COUNT); weight (n_groups): how often each group counts; NULL: once. NaN if a statistic is undefined.
 *  Returns the total of NQM_SUM_ORDERED. */
double nqm_statistics_of_sums(size_t n_groups, const double *sums, const double *weight,
                              double statistics[NQM_STATISTIC_COUNT]);

/** Resampling of one judgement. */
typedef struct nqm_bootstrap {
    const nqm_judgement *judgement;
    uint64_t seed;
    size_t n_resamples;
    double *sums;       /* (n_predictors, n_groups, NQM_SUM_COUNT); owns the block of all three */
    double *statistics; /* (n_predictors, NQM_STATISTIC_COUNT, n_resamples) */
    double *scratch;    /* (n_resamples) */
} nqm_bootstrap;

/** Draw resample `index`: sets weight (n_groups) to how often each group is drawn. */
void nqm_bootstrap_draw(uint64_t seed, size_t index, size_t n_groups, double *weight);

/** Compute the statistics from the judgement and the sums. The result does not depend on the number of threads. */
NQM_MUST_CHECK nqm_status nqm_bootstrap_run(const nqm_bootstrap *bootstrap, nqm_error *err);

/* ---- predictions for the pairs of a dataset (evaluate.c) --------------------------------------------------------- */

struct nqm_evaluation {
    const nqm_dataset *dataset;
    const nqm_dataset *const
        *datasets; /* (n_models) the same pairs at the directions of each model; NULL: `dataset` has them */
    size_t n_models;
    size_t n_predictors; /* n_models + NQM_METRIC_COUNT, and 1 more if the dataset has a transport matrix */
    const nqm_model *const *models;
    nqm_split split;
    double *values; /* (n_predictors, n_pairs of the dataset) NaN if not predicted */
    nqm_prediction
        *predictions;  /* (n_models, n_pairs of the dataset) undefined where not predicted; `jod` as `values` */
    nqm_label *labels; /* (n_models, n_pairs of the dataset) with parts; NaN likewise, and if the model predicts none */
    nqm_label *estimates; /* (n_pairs of the dataset) by light transport; NaN likewise; NULL: there is no matrix */
    double *scalars;      /* (n_pairs of the dataset, NQM_SCALAR_COUNT) scalar features; NaN if not predicted */
    size_t *ref_class;    /* (n_refs) */
    bool has_unseen;      /* of any kind */
    bool *unseen;         /* (n_kinds) nqm_dataset_unseen_kinds() */
    const char **names;   /* (n_predictors) */
};

/** The pairs at the directions of a model. */
static inline const nqm_dataset *nqm_evaluation_samples(const nqm_evaluation *ev, size_t model) {
    return ev->datasets ? ev->datasets[model] : ev->dataset;
}

/** The pairs selected by options, sorted by material group; groups without such pairs are left out. */
typedef struct nqm_selection {
    size_t n, n_groups;
    size_t *
        group_begin; /* (n_groups + 1) pairs of group g: [group_begin[g], group_begin[g + 1]); owns the block of all arrays */
    size_t *pairs;      /* (n) */
    double *label;      /* (n), for the caller to fill */
    double *prediction; /* (n_predictors, n), likewise */
} nqm_selection;

/** Select pairs, with room for n_predictors. NQM_ERR_INCOMPATIBLE: no pair matches; NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_selection_create(const nqm_evaluation *evaluation, const nqm_eval_options *options,
                                               size_t n_predictors, nqm_selection *selection_ret, nqm_error *err);
void nqm_selection_free(nqm_selection *selection);

static inline bool nqm_evaluation_in_split(const nqm_dataset *d, size_t pair, nqm_split split) {
    return split == NQM_SPLIT_ALL || nqm_dataset_pair_split(d, pair) == split;
}

/** The words of nqm_split by value, NULL-terminated. */
extern const char *const nqm_split_words[];
/** The options of nqm_eval_options; kind, family, class and JOD range are not among them. */
extern const nqm_option_table nqm_eval_option_table;

#endif
