/* SPDX-License-Identifier: MIT
 *
 * nqm reproduce, the closing table: figures published with the paper, by its authors' notebook and in their data files,
 * beside ours, with the tolerance within which ours count as the same. doc/reproduce.md says where tolerances come from.
 */
#include "nqm/judge/reproduce.h"

#include <math.h>
#include <string.h>

/* What must be as it was for a figure to mean anything. */
enum { HUMAN_DATA = 1, TRAINING_DATA = 2, EPOCHS = 4, MACHINE = 8 };
enum { PAPER_EPOCHS = 100, PAPER_TEST_PAIRS = 180, PAPER_TEST_MATERIALS = 20, PAPER_TRAINING_ROWS = 3339 };

/* ---- values ------------------------------------------------------------------------------------------------------ */

double study_spearman(const study_training *t) {
    return t->result.spearman;
}
double study_spearman_by_material(const study_training *t) {
    return t->result.spearman_mean_by_material;
}
double study_mae(const study_training *t) {
    return t->result.mae;
}
double study_rmse(const study_training *t) {
    return t->result.rmse;
}
double study_r2(const study_training *t) {
    return t->result.r2;
}
double study_train_seconds(const study_training *t) {
    return t->seconds_per_epoch * (double)t->report.epochs;
}
double study_ms_per_pair(const study_training *t) {
    return t->ms_per_pair;
}

static double n_examples(const study_training *t) {
    return (double)t->report.n_train;
}
static double n_validation(const study_training *t) {
    return (double)t->report.n_validation;
}
static double whitening_mean(const study_training *t) {
    return nqm_model_get_info(t->model).whitening_mean[0];
}
static double whitening_std(const study_training *t) {
    return nqm_model_get_info(t->model).whitening_std[0];
}
static double target_mean(const study_training *t) {
    return nqm_model_get_info(t->model).target_mean;
}
static double target_std(const study_training *t) {
    return nqm_model_get_info(t->model).target_std;
}
static double n_parameters(const study_training *t) {
    return (double)nqm_model_get_info(t->model).n_parameters;
}
static double megabytes(const study_training *t) {
    return n_parameters(t) * sizeof(float) / (1 << 20);
}

study_mean study_mean_of(const study *s, const char *recipe, double (*value)(const study_training *t)) {
    study_mean m = {.mean = 0, .sd = (double)NAN};
    double squares = 0;
    for (size_t i = 0; i < s->n_trainings; ++i)
        if (strcmp(s->trainings[i].recipe, recipe) == 0) {
            m.mean += value(&s->trainings[i]);
            ++m.n;
        }
    m.mean = m.n ? m.mean / (double)m.n : (double)NAN;
    for (size_t i = 0; i < s->n_trainings; ++i)
        if (strcmp(s->trainings[i].recipe, recipe) == 0)
            squares += pow(value(&s->trainings[i]) - m.mean, 2);
    if (m.n > 1)
        m.sd = sqrt(squares / (double)(m.n - 1));
    return m;
}

/* ---- figures ----------------------------------------------------------------------------------------------------- */

static const struct {
    study_figure figure;
    double (*value)(const study_training *t); /* NULL: study_figure_value() knows */
} figures[] = {
    {{"JOD curve, b1", "", "label files", -14.11197, 0.005, 0, HUMAN_DATA}, NULL},
    {{"JOD curve, b2", "", "label files", -0.47364, 0.0005, 0, HUMAN_DATA}, NULL},
    {{"JOD curve, b3", "", "label files", -0.21480, 0.0005, 0, HUMAN_DATA}, NULL},
    {{"training examples", "paper", "paper", 5344, 2, 0, TRAINING_DATA}, n_examples},
    {{"validation examples", "paper", "paper", 668, 1, 0, TRAINING_DATA}, n_validation},
    {{"whitening, mean", "notebook", "train_info.mat", 0.69127, 0.05, 0, TRAINING_DATA}, whitening_mean},
    {{"whitening, std", "notebook", "train_info.mat", 0.55376, 0.05, 0, TRAINING_DATA}, whitening_std},
    {{"training labels, mean", "notebook", "train_info.mat", 6.67318, 0.1, 0, TRAINING_DATA}, target_mean},
    {{"training labels, std", "notebook", "train_info.mat", 1.96393, 0.1, 0, TRAINING_DATA}, target_std},
    {{"parameters", "paper", "paper", 4171125, 0, 0, 0}, n_parameters},
    {{"model size, MB", "paper", "paper", 15.91, 0.005, 0, 0}, megabytes},
    {{"Spearman, mean over materials", "paper", "paper", 0.67, 0.03, 0, HUMAN_DATA | TRAINING_DATA | EPOCHS},
     study_spearman_by_material},
    {{"Spearman, all pairs", "paper", "paper", 0.67, 0.03, 0, HUMAN_DATA | TRAINING_DATA | EPOCHS}, study_spearman},
    {{"lead over the best of the 8", "paper", "paper", 0, 0, 1, HUMAN_DATA | TRAINING_DATA | EPOCHS}, NULL},
    {{"MAE, JOD", "notebook", "notebook", 1.137, 0.1, 0, HUMAN_DATA | TRAINING_DATA | EPOCHS}, study_mae},
    {{"RMSE, JOD", "notebook", "notebook", 1.575, 0.1, 0, HUMAN_DATA | TRAINING_DATA | EPOCHS}, study_rmse},
    {{"R2", "notebook", "notebook", 0.326, 0.1, 0, HUMAN_DATA | TRAINING_DATA | EPOCHS}, study_r2},
    {{"training, s", "paper", "paper", 36, 0, 0, MACHINE}, study_train_seconds},
    {{"score, ms a pair", "paper", "paper", 0.04, 0, 0, MACHINE}, study_ms_per_pair},
};
enum { FIGURE_B1 = 0, FIGURE_B2 = 1, FIGURE_B3 = 2 };

size_t study_figure_count(void) {
    return sizeof figures / sizeof figures[0];
}

const study_figure *study_figure_at(size_t i) {
    return &figures[i].figure;
}

study_mean study_figure_value(const study *s, size_t i) {
    if (figures[i].value)
        return study_mean_of(s, figures[i].figure.recipe, figures[i].value);
    if (i > FIGURE_B3) { /* the lead over the baselines */
        study_mean m = study_mean_of(s, figures[i].figure.recipe, study_spearman_by_material);
        double best = -1;
        for (size_t k = 0; k < NQM_METRIC_COUNT; ++k)
            if (nqm_metric_get_info((nqm_metric)k).is_baseline)
                best = fmax(best, s->metrics[k].spearman_mean_by_material);
        m.mean -= best;
        return m;
    }
    const nqm_curve *curve = &s->regression.curve;
    double b = i == FIGURE_B1 ? curve->b1 : i == FIGURE_B2 ? curve->b2 : curve->b3;
    return (study_mean){.n = 1, .mean = b, .sd = (double)NAN};
}

const char *study_figure_verdict(const study *s, size_t i, char text[40]) {
    const study_figure *f = &figures[i].figure;
    study_mean ours = study_figure_value(s, i);
    nqm_dataset_info train = nqm_dataset_get_info(s->train);
    if (ours.n == 0)
        return "not run";
    if (f->needs & MACHINE)
        return "not comparable: other machine";
    if ((f->needs & HUMAN_DATA) && (nqm_dataset_get_info(s->test).n_pairs != PAPER_TEST_PAIRS ||
                                    nqm_dataset_get_info(s->test).n_groups != PAPER_TEST_MATERIALS))
        return "not comparable: other data";
    if ((f->needs & TRAINING_DATA) && train.n_pairs != PAPER_TRAINING_ROWS)
        return "not comparable: other data";
    if ((f->needs & EPOCHS) && s->options->epochs != PAPER_EPOCHS) {
        snprintf(text, 40, "not comparable: %d epochs", (int)s->options->epochs);
        return text;
    }
    bool same = f->at_least ? ours.mean > f->published : fabs(ours.mean - f->published) <= f->tolerance;
    return same ? "reproduced" : "not reproduced";
}
