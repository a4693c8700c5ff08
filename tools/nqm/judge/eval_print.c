/* SPDX-License-Identifier: MIT
 *
 * The tables of `nqm eval` as text, JSON and CSV.
 */
#include "nqm/judge/eval.h"

#include <errno.h>
#include <math.h>
#include <string.h>

static bool is_model(const eval_run *run, size_t predictor) {
    return predictor < run->n_models;
}

const char *predictor_name(const eval_run *run, size_t predictor) {
    return is_model(run, predictor) ? nqm_model_get_info(run->models[predictor]).id
                                    : nqm_metric_name((nqm_metric)(predictor - run->n_models));
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* "0.943 [0.921, 0.960]", or "-" for NaN. */
void print_interval(const nqm_estimate *e) {
    char text[64] = "-";
    if (isfinite(e->value) && isfinite(e->ci95[0]))
        snprintf(text, sizeof text, "%.3f [%.3f, %.3f]", e->value, e->ci95[0], e->ci95[1]);
    else if (isfinite(e->value))
        snprintf(text, sizeof text, "%.3f", e->value);
    printf("  %-22s", text);
}

void print_number(double value) {
    if (isfinite(value))
        printf(" %7.3f", value);
    else
        printf(" %7s", "-");
}

/* "+0.063 [+0.041, +0.088], below 0 in 0.1 % of the resamples" */
void print_difference(const nqm_difference *d) {
    if (!isfinite(d->value))
        printf("-");
    else if (!isfinite(d->ci95[0]))
        printf("%+.3f", d->value);
    else
        printf("%+.3f [%+.3f, %+.3f], below 0 in %.1f %% of the resamples", d->value, d->ci95[0], d->ci95[1],
               100 * d->share_below_0);
}

static void print_contrasts(const eval_run *run, const eval_table *table) {
    for (size_t i = 0; i < run->n_models * N_RIVALS; ++i) {
        const nqm_contrast *c = &table->contrasts[i];
        if (c->first == c->second)
            continue;
        printf("%.40s less %s%s: ", predictor_name(run, c->first), predictor_name(run, c->second),
               i % N_RIVALS == RIVAL_BASELINE ? ", best of the eight" : "");
        print_difference(&c->spearman);
        printf("; mean by material ");
        print_difference(&c->spearman_mean_by_material);
        putchar('\n');
    }
}

static void print_table(const eval_run *run, const eval_table *table) {
    const nqm_agreement *first = table->results;
    if (!first) {
        printf("\n%s: no pairs\n", table->name);
        return;
    }
    printf("\n%s: %zu pairs of %zu materials\n", table->name, first->n, first->n_materials);
    printf("%-14s  %-22s  %-22s %7s %7s %7s %7s %7s %7s\n", "", "Spearman [95 %]", "mean by material", "Pearson",
           "Kendall", "MAE", "RMSE", "R2", "order");
    for (size_t i = 0; i < run->n_predictors; ++i) {
        const nqm_agreement *a = &table->results[i];
        char name[48];
        snprintf(name, sizeof name, "%.40s%s", a->name, a->best_of_family ? " *" : "");
        printf("%-14s", name);
        print_interval(&a->spearman);
        print_interval(&a->spearman_mean_by_material);
        print_number(a->pearson.value);
        print_number(a->kendall.value);
        print_number(a->mae.value);
        print_number(a->rmse.value);
        print_number(a->r2.value);
        print_number(a->order.value);
        putchar('\n');
    }
    print_contrasts(run, table);
    print_coverage(run, table);
}

static int print_text(const eval_run *run) {
    end_progress();
    const char *label = run->human ? nqm_human_get_info(run->human).kind_name : "JOD";
    if (run->human)
        printf("human    %s, column: %s\n", run->dataset_path, label);
    else
        printf("dataset  %s, split: %s\n", run->dataset_path, run->split_name);
    for (size_t i = 0; i < run->n_tables; ++i)
        print_table(run, &run->tables[i]);
    printf(
        "\nCorrelations with the labels (%s), signed so that higher is better. Intervals: bootstrap over materials.\n"
        "The mean by material counts materials with at least 3 pairs. MAE, RMSE in JOD. * best of its family.\n"
        "Order: share in the right order of the tests of one material whose labels differ by more than %g.\n",
        label, run->order_margin);
    return fflush(stdout) == 0 ? EXIT_OK : report("eval", EXIT_OPEN, "standard output: %s", strerror(errno));
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

json_t *interval_json(const double ci95[2]) {
    return isfinite(ci95[0]) ? json_pack("[o,o]", json_number(ci95[0]), json_number(ci95[1])) : json_null();
}

json_t *difference_json(const nqm_difference *d) {
    return json_pack("{s:o,s:o,s:o}", "difference", json_number(d->value), "ci95", interval_json(d->ci95),
                     "share_below_0", json_number(d->share_below_0));
}

static json_t *contrasts_json(const eval_run *run, const nqm_contrast *contrasts) {
    json_t *list = json_array();
    for (size_t i = 0; i < N_RIVALS; ++i) {
        const nqm_contrast *c = &contrasts[i];
        if (c->first != c->second)
            json_array_append_new(list, json_pack("{s:s,s:b,s:o,s:o,s:o}", "with", predictor_name(run, c->second),
                                                  "best_baseline", i == RIVAL_BASELINE, "spearman",
                                                  difference_json(&c->spearman), "spearman_mean_by_material",
                                                  difference_json(&c->spearman_mean_by_material), "order",
                                                  difference_json(&c->order)));
    }
    return list;
}

static const struct {
    const char *name, *interval;
    size_t offset; /* of the nqm_estimate in nqm_agreement */
} statistics[N_STATISTICS] = {
    {"spearman", "ci95", offsetof(nqm_agreement, spearman)},
    {"spearman_mean_by_material", "ci95_mean_by_material", offsetof(nqm_agreement, spearman_mean_by_material)},
    {"pearson", "ci95_pearson", offsetof(nqm_agreement, pearson)},
    {"kendall", "ci95_kendall", offsetof(nqm_agreement, kendall)},
    {"mae", "ci95_mae", offsetof(nqm_agreement, mae)},
    {"rmse", "ci95_rmse", offsetof(nqm_agreement, rmse)},
    {"r2", "ci95_r2", offsetof(nqm_agreement, r2)},
    {"order", "ci95_order", offsetof(nqm_agreement, order)},
};

nqm_estimate *statistic_of(nqm_agreement *a, size_t i) {
    return (nqm_estimate *)((char *)a + statistics[i].offset);
}

json_t *agreement_json(const nqm_agreement *a) {
    json_t *row = json_pack("{s:s,s:I,s:I,s:I}", "name", a->name, "n", (json_int_t)a->n, "n_materials",
                            (json_int_t)a->n_materials, "n_ordered", (json_int_t)a->n_ordered);
    for (size_t i = 0; i < N_STATISTICS; ++i) {
        const nqm_estimate *e = (const nqm_estimate *)((const char *)a + statistics[i].offset);
        json_object_set_new(row, statistics[i].name, json_number(e->value));
        json_object_set_new(row, statistics[i].interval, interval_json(e->ci95));
    }
    return row;
}

static json_t *row_json(const eval_run *run, const eval_table *table, size_t predictor) {
    const nqm_agreement *a = &table->results[predictor];
    json_t *row = agreement_json(a);
    json_object_set_new(row, "type", json_string(is_model(run, predictor) ? "model" : "metric"));
    if (is_model(run, predictor)) {
        json_object_set_new(row, "contrasts", contrasts_json(run, table->contrasts + predictor * N_RIVALS));
        json_object_set_new(row, "interval", coverage_json(table, predictor));
    } else {
        json_object_set_new(row, "best_of_family", json_boolean(a->best_of_family));
        json_object_set_new(row, "best_baseline", json_boolean(a->best_baseline));
    }
    return row;
}

static json_t *table_json(const eval_run *run, const eval_table *table) {
    json_t *list = json_array();
    for (size_t i = 0; table->results && i < run->n_predictors; ++i)
        json_array_append_new(list, row_json(run, table, i));
    return list;
}

json_t *models_json(const eval_run *run) {
    json_t *models = json_array();
    for (size_t i = 0; i < run->n_models; ++i)
        json_array_append_new(models, model_json(run->models[i], run->precision));
    return models;
}

static int print_json_tables(const eval_run *run) {
    json_t *selections = json_object(); /* "by_kind": {"ggx": [..], ..} */
    for (size_t i = 1; i < run->n_tables; ++i) {
        const eval_table *table = &run->tables[i];
        char key[24];
        snprintf(key, sizeof key, "by_%s", table->by);
        if (!json_object_get(selections, key))
            json_object_set_new(selections, key, json_object());
        json_object_set_new(json_object_get(selections, key), table->name, table_json(run, table));
    }
    nqm_dataset_info info = nqm_dataset_get_info(run->dataset);
    json_t *json =
        json_pack("{s:i,s:o,s:{s:o,s:s,s:s},s:f,s:o,s:o}", "schema", 1, "tool", json_tool(), "dataset", "path",
                  json_name(run->dataset_path), "sha256", info.sha256, "split", run->split_name, "order_margin",
                  run->order_margin, "models", models_json(run), "results", table_json(run, &run->tables[0]));
    if (run->human)
        json_object_set_new(json, "human", human_json(run->human));
    json_object_update(json, selections);
    json_decref(selections);
    return print_json(json);
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

void print_csv_difference(const char *rival, const nqm_difference *difference) {
    nqm_difference d = {NAN, {NAN, NAN}, NAN};
    if (difference)
        d = *difference;
    printf(",%s", rival ? rival : "");
    print_csv_numbers(stdout, 4, (const double[]){d.value, d.ci95[0], d.ci95[1], d.share_below_0});
}

static void print_csv_row(const eval_run *run, const eval_table *table, size_t predictor) {
    const nqm_agreement *a = &table->results[predictor];
    const nqm_contrast *contrasts = is_model(run, predictor) ? table->contrasts + predictor * N_RIVALS : NULL;
    print_csv_agreement(stdout, table->by, table->name, is_model(run, predictor) ? "model" : "metric", a);
    const double numbers[] = {a->pearson.ci95[0], a->pearson.ci95[1], a->kendall.ci95[0], a->kendall.ci95[1],
                              a->mae.ci95[0],     a->mae.ci95[1],     a->rmse.ci95[0],    a->rmse.ci95[1],
                              a->r2.ci95[0],      a->r2.ci95[1],      a->order.value,     a->order.ci95[0],
                              a->order.ci95[1]};
    print_csv_numbers(stdout, sizeof numbers / sizeof *numbers, numbers);
    printf(",%zu,%d,%d", a->n_ordered, a->best_of_family, a->best_baseline);
    for (size_t i = 0; i < N_RIVALS; ++i) {
        const nqm_contrast *c = contrasts ? &contrasts[i] : NULL;
        bool there = c && c->first != c->second;
        print_csv_difference(there ? predictor_name(run, c->second) : NULL, there ? &c->spearman : NULL);
    }
    print_csv_coverage(is_model(run, predictor) ? &table->coverage[predictor] : NULL);
    putchar('\n');
}

static int print_csv(const eval_run *run) {
    end_progress();
    printf("%s,pearson_low,pearson_high,kendall_low,kendall_high,mae_low,"
           "mae_high,rmse_low,rmse_high,r2_low,r2_high,order,order_low,order_high,n_ordered,best_of_family,"
           "best_baseline,rival,difference,difference_low,difference_high,share_below_0,rival_2,difference_2,"
           "difference_2_low,difference_2_high,share_2_below_0,%s\n",
           agreement_columns, coverage_columns);
    for (size_t i = 0; i < run->n_tables * run->n_predictors; ++i)
        if (run->tables[i / run->n_predictors].results)
            print_csv_row(run, &run->tables[i / run->n_predictors], i % run->n_predictors);
    return fflush(stdout) == 0 ? EXIT_OK : report("eval", EXIT_OPEN, "standard output: %s", strerror(errno));
}

int print_evaluation(const eval_run *run, result_format format) {
    return format == FORMAT_JSON ? print_json_tables(run) : format == FORMAT_CSV ? print_csv(run) : print_text(run);
}
