/* SPDX-License-Identifier: MIT
 *
 * evaluate.h - internals of an evaluation: predictions for the pairs of a dataset.
 */
#ifndef NQM_SRC_JUDGE_EVALUATE_H
#define NQM_SRC_JUDGE_EVALUATE_H

#include "base/options.h"
#include "data/data.h"
#include "judge/judge.h"
#include "metric/metric.h"

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
