/* SPDX-License-Identifier: MIT
 *
 * eval.h - internal interface of `nqm eval`. The result of a predictor on a selection of pairs is a JSON object, a
 * "row"; the text and the CSV are printed from it.
 */
#ifndef NQM_TOOL_EVAL_H
#define NQM_TOOL_EVAL_H

#include "judge/judge.h"
#include "nqm/score/score.h"

/** The values of nqm_eval_options.subset, NULL-terminated. */
extern const char *const subset_words[];

typedef struct eval_run {
    const char *dataset_path, *split_name;
    nqm_human *human;   /* answers of people; NULL: labels */
    nqm_human **humans; /* (n_models) answers sampled at each model's directions, NULL where another has them */
    const nqm_dataset **datasets; /* (n_models) datasets of the answers for each model; NULL: labels */
    nqm_dataset *owned;           /* the dataset; NULL if it belongs to `human` */
    const nqm_dataset *dataset;
    size_t n_models, n_predictors;
    nqm_model **models;
    const char **model_names; /* (n_models) ids, or the words of `model_list` where ids are equal */
    char *model_list;
    nqm_evaluation *evaluation;
    bool is_jod, is_choice; /* labels are JODs; they are choices */
    double order_margin;
    json_t *results;    /* rows over all pairs */
    json_t *selections; /* {"by_kind": {"ggx": rows, ..}, ..}; a selection without pairs has no rows */
} eval_run;

/** Judge every predictor on the pairs that `options` selects, or on choices, and append the rows to `rows`. A selection
 *  without pairs adds none, and is an error for run->results. */
void judge_pairs(const eval_run *run, const nqm_eval_options *options, json_t *rows);
void judge_choices(const eval_run *run, const nqm_eval_options *options, json_t *rows);

/** Print results and selections. */
void print_evaluation(const eval_run *run, result_format format);
/** Write label, predictions and scalar features of every pair that was judged, as CSV. */
void write_pairs(const eval_run *run, const char *path);

#endif
