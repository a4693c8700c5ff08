/* SPDX-License-Identifier: MIT
 *
 * eval.h - between the parts of `nqm eval`: what was judged, and its printing.
 */
#ifndef NQM_TOOL_EVAL_H
#define NQM_TOOL_EVAL_H

#include "tool.h"

/** The agreement of every predictor on one selection of pairs. */
typedef struct eval_table {
    const char *by;         /* "all", "family", "kind", "class" or "range" */
    char name[80];          /* "all", "ggx", "JOD >= 9.5" */
    nqm_agreement *results; /* (n_predictors); NULL where no pair is selected */
} eval_table;

typedef struct eval_run {
    const char *dataset_path, *split_name;
    nqm_dataset *dataset;
    size_t n_models, n_predictors, n_tables;
    nqm_model **models;
    nqm_evaluation *evaluation;
    eval_table *tables; /* the first is over all pairs */
} eval_run;

typedef enum eval_format { EVAL_TEXT, EVAL_JSON, EVAL_CSV } eval_format;

/** Print all tables; returns an exit code. */
int print_evaluation(const eval_run *run, eval_format format);
/** Write label, predictions and scalar features of every pair that was judged, as CSV. */
int write_pairs(const eval_run *run, const char *path);

#endif
