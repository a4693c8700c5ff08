/* SPDX-License-Identifier: MIT
 *
 * eval.h - internal interface of `nqm eval`: judged results and functions that print them.
 */
#ifndef NQM_TOOL_EVAL_H
#define NQM_TOOL_EVAL_H

#include "judge/evaluate.h"
#include "nqm/score/score.h"

/** The two metrics with which each model is compared. */
enum { RIVAL_BASELINE, RIVAL_LOG_DIFF, N_RIVALS };

/** The agreement of every predictor on one selection of pairs. */
typedef struct eval_table {
    const char *by;          /* "all", "family", "kind", "class" or "range" */
    char name[80];           /* "all", "ggx", "JOD >= 9.5" */
    nqm_agreement *results;  /* (n_predictors); NULL if no pair is selected */
    nqm_contrast *contrasts; /* (n_models, N_RIVALS); first == second: no comparison */
    nqm_coverage *coverage;  /* (n_models); n == 0: no intervals, or labels are not JODs */
} eval_table;

typedef struct eval_run {
    const char *dataset_path, *split_name;
    nqm_human *human;   /* answers of people; NULL: labels */
    nqm_dataset *owned; /* the dataset; NULL if it belongs to `human` */
    const nqm_dataset *dataset;
    size_t n_models, n_predictors, n_tables;
    nqm_model **models;
    nqm_evaluation *evaluation;
    nqm_precision precision;
    double order_margin;
    eval_table *tables; /* the first table is over all pairs */
} eval_run;

/** Print all tables; returns an exit code. */
int print_evaluation(const eval_run *run, result_format format);
/** Judge and print choices of people; returns an exit code. */
int evaluate_choices(const eval_run *run, const nqm_eval_options *options, result_format format);
/** Read run->dataset_path as a CSV of answers and sample its BRDFs at the directions of the first model. Reports errors
 *  and returns an exit code, like open_model(). */
int open_human(eval_run *run, const char *root);
/** Write label, predictions and scalar features of every pair that was judged, as CSV. */
int write_pairs(const eval_run *run, const char *path);

/** Compute the coverage of the intervals, for models that have intervals. */
nqm_status judge_coverage(const eval_run *run, const nqm_eval_options *o, eval_table *table, nqm_error *err);
/** Print or return the coverage: text below a table; JSON, null if there is none; CSV fields, each after a comma (NULL:
 *  empty). */
void print_coverage(const eval_run *run, const eval_table *table);
json_t *coverage_json(const eval_table *table, size_t model);
extern const char coverage_columns[];
void print_csv_coverage(const nqm_coverage *coverage);

/** Id of a model or name of a metric. */
const char *predictor_name(const eval_run *run, size_t predictor);

/* Parts of the output. */
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
/** Print CSV fields, each after a comma; empty if `rival` and `difference` are NULL. */
void print_csv_difference(const char *rival, const nqm_difference *difference);

#endif
