/* SPDX-License-Identifier: MIT
 *
 * reproduce.h - between the parts of `nqm reproduce`: the study while it is done, and what is told of it.
 */
#ifndef NQM_TOOL_REPRODUCE_H
#define NQM_TOOL_REPRODUCE_H

#include "nqm/tool.h"

enum { STUDY_PATH_BYTES = 4096, STUDY_MAX_RECIPES = 3, STUDY_MAX_SEEDS = 20 };

/** What the command line asks for. */
typedef struct study_options {
    const char *root, *output;               /* the authors' folder; where results go */
    const char *train_folder, *train_labels; /* NULL: found in root */
    const char *test_folder, *test_labels;   /* likewise */
    uint64_t n_seeds, epochs;                /* seeds 1..n_seeds */
    size_t n_recipes;
    const char *recipes[STUDY_MAX_RECIPES];
} study_options;

/** One training: a recipe and a seed. */
typedef struct study_training {
    const char *recipe;
    uint64_t seed;
    char id[40];                       /* "paper-1": the model's id, and how its files in the output folder begin */
    char model_path[STUDY_PATH_BYTES]; /* OUTPUT/ID.safetensors */
    nqm_model *model;
    nqm_train_report report;
    double seconds_per_epoch; /* NaN when every epoch came from a checkpoint */
    double ms_per_pair;       /* of scoring, at the size of the test set */
    nqm_agreement result;     /* on the human scores */
} study_training;

typedef struct study {
    const study_options *options;
    char train_folder[STUDY_PATH_BYTES], train_labels[STUDY_PATH_BYTES];
    char test_folder[STUDY_PATH_BYTES], test_labels[STUDY_PATH_BYTES];
    nqm_regress_report regression; /* of the curve on the human scores */
    nqm_dataset *train, *test;
    size_t n_trainings;
    study_training trainings[STUDY_MAX_RECIPES * STUDY_MAX_SEEDS]; /* recipe by recipe */
    nqm_agreement metrics[NQM_METRIC_COUNT];
} study;

/** Find the parts of the authors' folder; every missing one is named. EXIT_OK, or reported. */
int study_find(study *s);

/** Train, or go on from a checkpoint, or load what a former run has finished. EXIT_OK, or reported. */
int study_train(study *s, study_training *t);

/** Mean and standard deviation (n - 1; NaN for one) over the seeds of a recipe. */
typedef struct study_mean {
    size_t n;
    double mean, sd;
} study_mean;
study_mean study_mean_of(const study *s, const char *recipe, double (*value)(const study_training *t));
/** Values to average. */
double study_spearman(const study_training *t);
double study_spearman_by_material(const study_training *t);
double study_mae(const study_training *t);
double study_rmse(const study_training *t);
double study_r2(const study_training *t);
double study_train_seconds(const study_training *t); /* of all epochs */
double study_ms_per_pair(const study_training *t);

/** One published figure beside ours. */
typedef struct study_figure {
    const char *name, *recipe, *source; /* recipe: "" where none is needed */
    double published, tolerance;
    int at_least; /* 1: reproduced when ours is not below */
    int needs;    /* FIGURE_... */
} study_figure;
size_t study_figure_count(void);
const study_figure *study_figure_at(size_t i);
/** Our value (a mean over seeds) of figure i. */
study_mean study_figure_value(const study *s, size_t i);
/** "reproduced", "not reproduced", "not run", or "not comparable: ..."; `text` (40 bytes) may be used. */
const char *study_figure_verdict(const study *s, size_t i, char text[40]);

/** Print the study as text. */
int study_print(const study *s);
/** The study as JSON, for OUTPUT/reproduce.json and --json. */
json_t *study_json(const study *s);
/** The bar chart as CSV, in columns of `nqm eval --csv`: one bar a recipe, one a metric. */
void study_write_bars(const study *s, FILE *out);

#endif
