/* SPDX-License-Identifier: MIT
 *
 * eval.h - between the parts of `nqm eval`: what was judged, and its printing.
 */
#ifndef NQM_TOOL_EVAL_H
#define NQM_TOOL_EVAL_H

#include "judge/evaluate.h"
#include "nqm/score/score.h"

/** Each model is compared with two metrics. */
enum { RIVAL_BASELINE, RIVAL_LOG_DIFF, N_RIVALS };

/** The agreement of every predictor on one selection of pairs. */
typedef struct eval_table {
    const char *by;          /* "all", "family", "kind", "class" or "range" */
    char name[80];           /* "all", "ggx", "JOD >= 9.5" */
    nqm_agreement *results;  /* (n_predictors); NULL where no pair is selected */
    nqm_contrast *contrasts; /* (n_models, N_RIVALS); first and second equal: there is no such rival */
    nqm_coverage *coverage;  /* (n_models) of their intervals; n 0: there are none, or labels are no JOD */
} eval_table;

typedef struct eval_run {
    const char *dataset_path, *split_name;
    nqm_human *human;   /* answers of people; NULL: labels */
    nqm_dataset *owned; /* the dataset, unless it belongs to `human` */
    const nqm_dataset *dataset;
    size_t n_models, n_predictors, n_tables;
    nqm_model **models;
    nqm_evaluation *evaluation;
    nqm_precision precision;
    double order_margin;
    eval_table *tables; /* the first is over all pairs */
} eval_run;

/** Print all tables; returns an exit code. */
int print_evaluation(const eval_run *run, result_format format);
/** The same for choices of people, which it judges first. */
int evaluate_choices(const eval_run *run, const nqm_eval_options *options, result_format format);
/** Read run->dataset_path as a CSV of answers, looked at where the first model looks. As open_model(). */
int open_human(eval_run *run, const char *root);
/** Write label, predictions and scalar features of every pair that was judged, as CSV. */
int write_pairs(const eval_run *run, const char *path);

/** Count the labels inside the intervals of those models that have them. */
nqm_status judge_coverage(const eval_run *run, const nqm_eval_options *o, eval_table *table, nqm_error *err);
/** As text below a table; as JSON, null where there is none; as CSV, with commas before each, NULL: empty fields. */
void print_coverage(const eval_run *run, const eval_table *table);
json_t *coverage_json(const eval_table *table, size_t model);
extern const char coverage_columns[];
void print_csv_coverage(const nqm_coverage *coverage);

/** Id of a model or name of a metric. */
const char *predictor_name(const eval_run *run, size_t predictor);

/* Parts of what is printed. */
void print_interval(const nqm_estimate *estimate);
void print_number(double value);
void print_difference(const nqm_difference *difference);
enum { N_STATISTICS = 8 };
/** The i-th statistic of an agreement, i < N_STATISTICS. */
nqm_estimate *statistic_of(nqm_agreement *agreement, size_t i);
/** {"name","n","n_materials","n_ordered"} and all statistics with their intervals. */
json_t *agreement_json(const nqm_agreement *agreement);
json_t *interval_json(const double ci95[2]);
json_t *difference_json(const nqm_difference *difference);
json_t *models_json(const eval_run *run);
json_t *human_json(const nqm_human *human);
/** Commas before each; `rival` and `difference` NULL: empty fields. */
void print_csv_difference(const char *rival, const nqm_difference *difference);

#endif
