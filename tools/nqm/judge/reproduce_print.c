/* SPDX-License-Identifier: MIT
 *
 * nqm reproduce, what is told of the study: text, JSON, and the bar chart as CSV.
 */
#include "nqm/judge/reproduce.h"

#include <errno.h>
#include <math.h>
#include <string.h>

static const struct {
    const char *key, *title;
    double (*value)(const study_training *t);
} means[] = {
    {"spearman", "Spearman", study_spearman},
    {"spearman_mean_by_material", "by material", study_spearman_by_material},
    {"mae", "MAE", study_mae},
    {"rmse", "RMSE", study_rmse},
    {"r2", "R2", study_r2},
    {"training_seconds", "training s", study_train_seconds},
    {"ms_per_pair", "ms a pair", study_ms_per_pair},
};
enum { N_MEANS = sizeof means / sizeof means[0] };

/* ---- text -------------------------------------------------------------------------------------------------------- */

static void print_interval(double value, const double ci95[2]) {
    char text[64] = "-";
    if (isfinite(value) && isfinite(ci95[0]))
        snprintf(text, sizeof text, "%.3f [%.3f, %.3f]", value, ci95[0], ci95[1]);
    else if (isfinite(value))
        snprintf(text, sizeof text, "%.3f", value);
    printf("  %-22s", text);
}

static void print_cell(double value, int width, int decimals) {
    if (isfinite(value))
        printf(" %*.*f", width, decimals, value);
    else
        printf(" %*s", width, "-");
}

static void print_data(const study *s) {
    nqm_dataset_info train = nqm_dataset_get_info(s->train), test = nqm_dataset_get_info(s->test);
    const nqm_regress_report *r = &s->regression;
    printf("training  %s, %s: %zu rows of %zu materials\n", s->train_folder, s->train_labels, train.n_pairs,
           train.n_groups);
    printf("test      %s, %s: %zu human scores of %zu materials, %zu directions\n", s->test_folder, s->test_labels,
           test.n_pairs, test.n_groups, test.n_directions);
    printf("curve     b1 %.5f, b2 %.5f, b3 %.5f; RMSE %.4f JOD, Spearman of Delta-E with JOD %.4f, n %zu\n",
           r->curve.b1, r->curve.b2, r->curve.b3, r->rmse, r->spearman, r->n);
}

static void print_trainings(const study *s) {
    printf("\n%-12s %6s %9s %7s %10s  %-20s  %s\n", "training", "epochs", "examples", "loss", "validation",
           "whitening mean, R G B", "std");
    for (size_t i = 0; i < s->n_trainings; ++i) {
        const study_training *t = &s->trainings[i];
        nqm_model_info info = nqm_model_get_info(t->model);
        printf("%-12s %6zu %9zu %7.4f %10.4f ", t->id, t->report.epochs, t->report.n_train, t->report.train_loss,
               t->report.validation_loss);
        for (size_t k = 0; k < 6; ++k)
            printf("%s%.4f", k % 3 ? " " : "  ", k < 3 ? info.whitening_mean[k] : info.whitening_std[k - 3]);
        putchar('\n');
    }
}

static void print_agreement(const nqm_agreement *a, const char *mark) {
    printf("%-12s%-2s", a->name, mark);
    print_interval(a->spearman, a->spearman_ci95);
    print_interval(a->spearman_mean_by_material, a->spearman_mean_by_material_ci95);
    print_cell(a->mae, 7, 3);
    print_cell(a->rmse, 7, 3);
    print_cell(a->r2, 7, 3);
}

static void print_test(const study *s) {
    printf("\n%-14s  %-22s  %-22s %7s %7s %7s %10s %9s\n", "test", "Spearman [95 %]", "mean over materials", "MAE",
           "RMSE", "R2", "training s", "ms a pair");
    for (size_t i = 0; i < s->n_trainings; ++i) {
        const study_training *t = &s->trainings[i];
        print_agreement(&t->result, "");
        print_cell(study_train_seconds(t), 10, 1);
        print_cell(t->ms_per_pair, 9, 4);
        putchar('\n');
    }
    for (size_t i = 0; i < NQM_METRIC_COUNT; ++i) {
        print_agreement(&s->metrics[i], s->metrics[i].best_of_family ? "*" : "");
        putchar('\n');
    }
    puts("* best of its family");
}

static void print_means(const study *s) {
    printf("\n%-12s %5s", "mean (sd)", "seeds");
    for (size_t k = 0; k < N_MEANS; ++k)
        printf("  %-*s", k + 1 < N_MEANS ? 16 : 0, means[k].title);
    putchar('\n');
    for (size_t r = 0; r < s->options->n_recipes; ++r) {
        printf("%-12s %5zu", s->options->recipes[r], (size_t)s->options->n_seeds);
        for (size_t k = 0; k < N_MEANS; ++k) {
            study_mean m = study_mean_of(s, s->options->recipes[r], means[k].value);
            char text[48];
            snprintf(text, sizeof text, isfinite(m.sd) ? "%.4g (%.2g)" : "%.4g", m.mean, m.sd);
            printf("  %-*s", k + 1 < N_MEANS ? 16 : 0, isfinite(m.mean) ? text : "-");
        }
        putchar('\n');
    }
}

static void print_figures(const study *s) {
    printf("\n%-30s %-9s %-15s %10s %9s %10s  %s\n", "published figure", "recipe", "source", "published", "tolerance",
           "here", "verdict");
    for (size_t i = 0; i < study_figure_count(); ++i) {
        const study_figure *f = study_figure_at(i);
        study_mean ours = study_figure_value(s, i);
        char published[24], tolerance[24] = "", here[24] = "-", text[40];
        snprintf(published, sizeof published, f->at_least ? "> %g" : "%.7g", f->published);
        if (f->tolerance > 0)
            snprintf(tolerance, sizeof tolerance, "%g", f->tolerance);
        if (isfinite(ours.mean))
            snprintf(here, sizeof here, fabs(ours.mean) >= 1e4 ? "%.0f" : "%.6g", ours.mean);
        printf("%-30s %-9s %-15s %10s %9s %10s  %s\n", f->name, f->recipe, f->source, published, tolerance, here,
               study_figure_verdict(s, i, text));
    }
}

int study_print(const study *s) {
    end_progress();
    print_data(s);
    print_trainings(s);
    print_test(s);
    print_means(s);
    print_figures(s);
    printf("\n%s: models, losses, bars.csv, reproduce.json\n", s->options->output);
    return fflush(stdout) == 0 ? EXIT_OK : report("reproduce", EXIT_OPEN, "standard output: %s", strerror(errno));
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static json_t *interval_json(const double ci95[2]) {
    return isfinite(ci95[0]) ? json_pack("[o,o]", json_number(ci95[0]), json_number(ci95[1])) : json_null();
}

static json_t *agreement_json(const nqm_agreement *a) {
    return json_pack(
        "{s:s,s:I,s:I,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "name", a->name, "n", (json_int_t)a->n, "n_materials",
        (json_int_t)a->n_materials, "spearman", json_number(a->spearman), "ci95", interval_json(a->spearman_ci95),
        "spearman_mean_by_material", json_number(a->spearman_mean_by_material), "ci95_mean_by_material",
        interval_json(a->spearman_mean_by_material_ci95), "pearson", json_number(a->pearson), "kendall",
        json_number(a->kendall), "mae", json_number(a->mae), "rmse", json_number(a->rmse), "r2", json_number(a->r2));
}

static json_t *channels_json(const double value[3]) {
    return json_pack("[o,o,o]", json_number(value[0]), json_number(value[1]), json_number(value[2]));
}

/* The bar of a recipe: every number is the mean over the seeds, the ends of the intervals, too. */
static nqm_agreement recipe_bar(const study *s, const char *recipe) {
    nqm_agreement bar = {.name = recipe};
    double n = (double)s->options->n_seeds;
    for (size_t i = 0; i < s->n_trainings; ++i) {
        const nqm_agreement *a = &s->trainings[i].result;
        if (strcmp(s->trainings[i].recipe, recipe) != 0)
            continue;
        bar.n = a->n;
        bar.n_materials = a->n_materials;
        bar.spearman += a->spearman / n;
        bar.spearman_mean_by_material += a->spearman_mean_by_material / n;
        for (size_t k = 0; k < 2; ++k) {
            bar.spearman_ci95[k] += a->spearman_ci95[k] / n;
            bar.spearman_mean_by_material_ci95[k] += a->spearman_mean_by_material_ci95[k] / n;
        }
        bar.pearson += a->pearson / n;
        bar.kendall += a->kendall / n;
        bar.mae += a->mae / n;
        bar.rmse += a->rmse / n;
        bar.r2 += a->r2 / n;
    }
    return bar;
}

/* One bar, as a row of `nqm eval --json`. */
static json_t *bar_json(const char *type, const nqm_agreement *a) {
    json_t *json = agreement_json(a);
    json_object_set_new(json, "type", json_string(type));
    json_object_set_new(json, "best_of_family", json_boolean(a->best_of_family));
    return json;
}

static json_t *training_json(const study_training *t) {
    nqm_model_info info = nqm_model_get_info(t->model);
    const nqm_train_report *r = &t->report;
    json_t *json = json_pack(
        "{s:s,s:s,s:I,s:{s:o,s:s,s:I},s:I,s:I,s:I,s:I,s:o,s:o,s:o,s:o,s:o}", "id", t->id, "recipe", t->recipe, "seed",
        (json_int_t)t->seed, "model", "path", json_name(t->model_path), "sha256", info.sha256, "parameters",
        (json_int_t)info.n_parameters, "epochs", (json_int_t)r->epochs, "steps", (json_int_t)r->n_steps, "n_train",
        (json_int_t)r->n_train, "n_validation", (json_int_t)r->n_validation, "train_loss", json_number(r->train_loss),
        "validation_loss", json_number(r->validation_loss), "validation_spearman", json_number(r->validation_spearman),
        "training_seconds", json_number(study_train_seconds(t)), "ms_per_pair", json_number(t->ms_per_pair));
    json_object_set_new(
        json, "whitening",
        json_pack("{s:o,s:o}", "mean", channels_json(info.whitening_mean), "std", channels_json(info.whitening_std)));
    json_object_set_new(json, "targets",
                        json_pack("{s:o,s:o,s:o,s:o}", "mean", json_number(info.target_mean), "std",
                                  json_number(info.target_std), "jod_min", json_number(info.jod_min), "jod_max",
                                  json_number(info.jod_max)));
    json_object_set_new(json, "test", agreement_json(&t->result));
    return json;
}

static json_t *recipe_json(const study *s, const char *recipe) {
    json_t *json = json_pack("{s:s,s:I}", "recipe", recipe, "seeds", (json_int_t)s->options->n_seeds);
    for (size_t k = 0; k < N_MEANS; ++k) {
        study_mean m = study_mean_of(s, recipe, means[k].value);
        json_object_set_new(json, means[k].key,
                            json_pack("{s:o,s:o}", "mean", json_number(m.mean), "sd", json_number(m.sd)));
    }
    return json;
}

static json_t *figure_json(const study *s, size_t i) {
    const study_figure *f = study_figure_at(i);
    study_mean ours = study_figure_value(s, i);
    char text[40];
    return json_pack("{s:s,s:s,s:s,s:o,s:o,s:b,s:o,s:o,s:s}", "name", f->name, "recipe", f->recipe, "source", f->source,
                     "published", json_number(f->published), "tolerance", json_number(f->tolerance), "at_least",
                     f->at_least, "here", json_number(ours.mean), "sd", json_number(ours.sd), "verdict",
                     study_figure_verdict(s, i, text));
}

json_t *study_json(const study *s) {
    const nqm_regress_report *r = &s->regression;
    nqm_dataset_info train = nqm_dataset_get_info(s->train), test = nqm_dataset_get_info(s->test);
    json_t *trainings = json_array(), *recipes = json_array(), *results = json_array(), *all = json_array();
    for (size_t i = 0; i < s->n_trainings; ++i)
        json_array_append_new(trainings, training_json(&s->trainings[i]));
    for (size_t i = 0; i < s->options->n_recipes; ++i)
        json_array_append_new(recipes, recipe_json(s, s->options->recipes[i]));
    for (size_t i = 0; i < s->options->n_recipes; ++i) {
        nqm_agreement bar = recipe_bar(s, s->options->recipes[i]);
        json_array_append_new(results, bar_json("model", &bar));
    }
    for (size_t i = 0; i < NQM_METRIC_COUNT; ++i)
        json_array_append_new(results, bar_json("metric", &s->metrics[i]));
    for (size_t i = 0; i < study_figure_count(); ++i)
        json_array_append_new(all, figure_json(s, i));
    json_t *json = json_pack(
        "{s:i,s:o,s:{s:o,s:o,s:I,s:I,s:s},s:{s:o,s:o,s:I,s:I,s:s},s:{s:o,s:o,s:o,s:o,s:o,s:I}}", "schema", 1, "tool",
        json_tool(), "train", "path", json_name(s->train_folder), "labels", json_name(s->train_labels), "n",
        (json_int_t)train.n_pairs, "n_materials", (json_int_t)train.n_groups, "sha256", train.sha256, "test", "path",
        json_name(s->test_folder), "labels", json_name(s->test_labels), "n", (json_int_t)test.n_pairs, "n_materials",
        (json_int_t)test.n_groups, "sha256", test.sha256, "regression", "b1", json_number(r->curve.b1), "b2",
        json_number(r->curve.b2), "b3", json_number(r->curve.b3), "rmse", json_number(r->rmse), "spearman",
        json_number(r->spearman), "n", (json_int_t)r->n);
    json_object_set_new(json, "trainings", trainings);
    json_object_set_new(json, "recipes", recipes);
    json_object_set_new(json, "results", results);
    json_object_set_new(json, "figures", all);
    return json;
}

/* ---- bars -------------------------------------------------------------------------------------------------------- */

static void write_bar(const char *type, const nqm_agreement *a, FILE *out) {
    print_csv_agreement(out, "all", "all", type, a);
    fprintf(out, ",%d\n", a->best_of_family);
}

void study_write_bars(const study *s, FILE *out) {
    fprintf(out, "%s,best_of_family\n", agreement_columns);
    for (size_t i = 0; i < s->options->n_recipes; ++i) {
        nqm_agreement bar = recipe_bar(s, s->options->recipes[i]);
        write_bar("model", &bar, out);
    }
    for (size_t i = 0; i < NQM_METRIC_COUNT; ++i)
        write_bar("metric", &s->metrics[i], out);
}
