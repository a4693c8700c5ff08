/* SPDX-License-Identifier: MIT
 *
 * The tables of `nqm eval` as text, JSON and CSV, and the predictions pair by pair.
 */
#include "eval.h"

#include <errno.h>
#include <math.h>
#include <string.h>

static bool is_model(const eval_run *run, size_t predictor) {
    return predictor < run->n_models;
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* "0.943 [0.921, 0.960]", or "-" where there is no such number. */
static void print_interval(double value, const double ci95[2]) {
    char text[64] = "-";
    if (isfinite(value) && isfinite(ci95[0]))
        snprintf(text, sizeof text, "%.3f [%.3f, %.3f]", value, ci95[0], ci95[1]);
    else if (isfinite(value))
        snprintf(text, sizeof text, "%.3f", value);
    printf("  %-22s", text);
}

static void print_number(double value) {
    if (isfinite(value))
        printf(" %7.3f", value);
    else
        printf(" %7s", "-");
}

static void print_table(const eval_run *run, const eval_table *table) {
    const nqm_agreement *first = table->results;
    if (!first) {
        printf("\n%s: no pairs\n", table->name);
        return;
    }
    printf("\n%s: %zu pairs of %zu materials\n", table->name, first->n, first->n_materials);
    printf("%-14s  %-22s  %-22s %7s %7s %7s %7s %7s\n", "", "Spearman [95 %]", "mean by material", "Pearson", "Kendall",
           "MAE", "RMSE", "R2");
    for (size_t i = 0; i < run->n_predictors; ++i) {
        const nqm_agreement *a = &table->results[i];
        printf("%-14.40s", a->name);
        print_interval(a->spearman, a->spearman_ci95);
        print_interval(a->spearman_mean_by_material, a->spearman_mean_by_material_ci95);
        print_number(a->pearson);
        print_number(a->kendall);
        print_number(a->mae);
        print_number(a->rmse);
        print_number(a->r2);
        putchar('\n');
    }
}

static int print_text(const eval_run *run) {
    end_progress();
    printf("dataset  %s, split: %s\n", run->dataset_path, run->split_name);
    for (size_t i = 0; i < run->n_tables; ++i)
        print_table(run, &run->tables[i]);
    puts("\nCorrelations with the labels (JOD), signed so that higher is better. Intervals: bootstrap over materials.\n"
         "The mean by material counts materials with at least 3 pairs. MAE, RMSE in JOD.");
    return fflush(stdout) == 0 ? EXIT_OK : report("eval", EXIT_OPEN, "standard output: %s", strerror(errno));
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static json_t *interval_json(const double ci95[2]) {
    return isfinite(ci95[0]) ? json_pack("[o,o]", json_number(ci95[0]), json_number(ci95[1])) : json_null();
}

static json_t *table_json(const eval_run *run, const eval_table *table) {
    json_t *list = json_array();
    for (size_t i = 0; table->results && i < run->n_predictors; ++i) {
        const nqm_agreement *a = &table->results[i];
        json_array_append_new(list,
                              json_pack("{s:s,s:s,s:I,s:I,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "name", a->name,
                                        "type", is_model(run, i) ? "model" : "metric", "n", (json_int_t)a->n,
                                        "n_materials", (json_int_t)a->n_materials, "spearman", json_number(a->spearman),
                                        "ci95", interval_json(a->spearman_ci95), "spearman_mean_by_material",
                                        json_number(a->spearman_mean_by_material), "ci95_mean_by_material",
                                        interval_json(a->spearman_mean_by_material_ci95), "pearson",
                                        json_number(a->pearson), "kendall", json_number(a->kendall), "mae",
                                        json_number(a->mae), "rmse", json_number(a->rmse), "r2", json_number(a->r2)));
    }
    return list;
}

static int print_json_tables(const eval_run *run) {
    json_t *models = json_array(), *selections = json_object(); /* "by_kind": {"ggx": [..], ..} */
    for (size_t i = 0; i < run->n_models; ++i) {
        nqm_model_info info = nqm_model_get_info(run->models[i]);
        json_array_append_new(models, json_pack("{s:s,s:s,s:I}", "id", info.id, "sha256", info.sha256, "parameters",
                                                (json_int_t)info.n_parameters));
    }
    for (size_t i = 1; i < run->n_tables; ++i) {
        const eval_table *table = &run->tables[i];
        char key[24];
        snprintf(key, sizeof key, "by_%s", table->by);
        if (!json_object_get(selections, key))
            json_object_set_new(selections, key, json_object());
        json_object_set_new(json_object_get(selections, key), table->name, table_json(run, table));
    }
    nqm_dataset_info info = nqm_dataset_get_info(run->dataset);
    json_t *json = json_pack("{s:i,s:o,s:{s:s,s:s,s:s},s:o,s:o}", "schema", 1, "tool", json_tool(), "dataset", "path",
                             run->dataset_path, "sha256", info.sha256, "split", run->split_name, "models", models,
                             "results", table_json(run, &run->tables[0]));
    json_object_update(json, selections);
    json_decref(selections);
    return print_json(json);
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

static int print_csv(const eval_run *run) {
    end_progress();
    puts("by,selection,name,type,n,n_materials,spearman,ci95_low,ci95_high,spearman_mean_by_material,mean_ci95_low,"
         "mean_ci95_high,pearson,kendall,mae,rmse,r2");
    for (size_t i = 0; i < run->n_tables * run->n_predictors; ++i) {
        const eval_table *table = &run->tables[i / run->n_predictors];
        size_t predictor = i % run->n_predictors;
        if (!table->results)
            continue;
        const nqm_agreement *a = &table->results[predictor];
        printf("%s,", table->by);
        print_csv_text(stdout, table->name);
        putchar(',');
        print_csv_text(stdout, a->name);
        printf(",%s,%zu,%zu", is_model(run, predictor) ? "model" : "metric", a->n, a->n_materials);
        const double numbers[] = {a->spearman,
                                  a->spearman_ci95[0],
                                  a->spearman_ci95[1],
                                  a->spearman_mean_by_material,
                                  a->spearman_mean_by_material_ci95[0],
                                  a->spearman_mean_by_material_ci95[1],
                                  a->pearson,
                                  a->kendall,
                                  a->mae,
                                  a->rmse,
                                  a->r2};
        for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; ++k) {
            putchar(',');
            print_csv_number(stdout, numbers[k]);
        }
        putchar('\n');
    }
    return fflush(stdout) == 0 ? EXIT_OK : report("eval", EXIT_OPEN, "standard output: %s", strerror(errno));
}

int print_evaluation(const eval_run *run, eval_format format) {
    return format == EVAL_JSON ? print_json_tables(run) : format == EVAL_CSV ? print_csv(run) : print_text(run);
}
