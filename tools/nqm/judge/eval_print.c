/* SPDX-License-Identifier: MIT
 *
 * nqm eval - prints rows as text, JSON and CSV.
 */
#include "nqm/judge/eval.h"
#include "nqm/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *text_at(const json_t *json, const char *key) {
    const char *text = json_string_value(json_object_get(json, key));
    return text ? shown(text) : NULL;
}

/* Call `print` for every table: the results, then the selections. */
static void print_tables(const eval_run *run,
                         void (*print)(const eval_run *run, const char *by, const char *name, const json_t *rows)) {
    const char *by, *name;
    json_t *selections, *rows;
    print(run, "all", "all", run->results);
    json_object_foreach(run->selections, by, selections) {
        json_object_foreach(selections, name, rows) {
            print(run, by + strlen("by_"), name, rows);
        }
    }
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

typedef struct text_column {
    const char *heading, *key, *interval; /* interval NULL: a number */
} text_column;

static const text_column pair_text[] = {{"Spearman [95 %]", "spearman", "ci95"},
                                        {"mean by material", "spearman_mean_by_material", "ci95_mean_by_material"},
                                        {"Pearson", "pearson", NULL},
                                        {"Kendall", "kendall", NULL},
                                        {"MAE", "mae", NULL},
                                        {"RMSE", "rmse", NULL},
                                        {"R2", "r2", NULL},
                                        {"order", "order", NULL},
                                        {0}};
static const text_column choice_text[] = {
    {"agreement [95 %]", "agreement", "ci95"}, {"majority", "majority", NULL}, {0}};

/* "0.943 [0.921, 0.960]", with `factor` and `digits`; "-" for a value that does not exist. */
static const char *estimate_text(const json_t *row, const char *key, const char *interval, double factor,
                                 const char *unit, int digits, char text[64]) {
    const double value = factor * number_at(row, key);
    const json_t *ci95 = json_object_get(row, interval);
    if (!isfinite(value))
        return "-";
    if (json_is_array(ci95))
        snprintf(text, 64, "%.*f%s [%.*f, %.*f]", digits, value, unit, digits, factor * number_at(ci95, "0"), digits,
                 factor * number_at(ci95, "1"));
    else
        snprintf(text, 64, "%.*f%s", digits, value, unit);
    return text;
}

/* "+0.063 [+0.041, +0.088], below 0 in 0.1 % of the resamples" */
static void print_difference(const json_t *d) {
    const double value = number_at(d, "difference"), low = number_at(d, "ci95.0");
    if (!isfinite(value))
        printf("-");
    else if (!isfinite(low))
        printf("%+.3f", value);
    else
        printf("%+.3f [%+.3f, %+.3f], below 0 in %.1f %% of the resamples", value, low, number_at(d, "ci95.1"),
               100 * number_at(d, "share_below_0"));
}

/* The name of a row; the end of a long one, since paths of models begin alike. */
static const char *row_name(const json_t *row) {
    enum { N_SHOWN = 40 };
    const char *name = text_at(row, "name");
    const size_t n = strlen(name);
    return n > N_SHOWN ? name + n - N_SHOWN : name;
}

static void print_contrasts(const json_t *row) {
    const json_t *list = json_object_get(row, "contrasts");
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t *c = json_array_get(list, i), *agreement = json_object_get(c, "agreement");
        printf("%s less %s%s: ", row_name(row), text_at(c, "with"),
               json_is_true(json_object_get(c, "best_baseline")) ? ", best of the eight" : "");
        print_difference(agreement ? agreement : json_object_get(c, "spearman"));
        if (!agreement) {
            printf("; mean by material ");
            print_difference(json_object_get(c, "spearman_mean_by_material"));
        }
        putchar('\n');
    }
}

static const char *subset_text(const char *subset) {
    static const char *const texts[] = {"near pairs", "far pairs", "nearly equal pairs (rounding)",
                                        "kinds of distortion in training", "kinds of distortion not in training"};
    size_t i = 0;
    while (strcmp(subset_words[i], subset) != 0)
        ++i;
    return texts[i];
}

static void print_coverage(const json_t *row) {
    const json_t *c = json_object_get(row, "interval"), *ranges = json_object_get(c, "by_predicted_jod");
    const json_t *subsets = json_object_get(c, "by_subset");
    char inside[64], by_material[64];
    if (!json_is_object(c))
        return;
    printf("%s, labels inside its 95 %% interval: %s; mean by material %s, lowest %.1f %% (%.60s); %.1f %% below, "
           "%.1f %% above\n  by predicted JOD:",
           row_name(row), estimate_text(c, "inside", "ci95", 100, " %", 1, inside),
           estimate_text(c, "by_material", "ci95_by_material", 100, " %", 1, by_material), 100 * number_at(c, "lowest"),
           text_at(c, "lowest_material"), 100 * number_at(c, "below"), 100 * number_at(c, "above"));
    for (size_t i = 0; i < json_array_size(ranges); ++i) {
        const json_t *r = json_array_get(ranges, i);
        if (number_at(r, "n") > 0)
            printf(" from %g: %.1f %% of %.0f, width %.2g;", number_at(r, "from"), 100 * number_at(r, "inside"),
                   number_at(r, "n"), number_at(r, "mean_width"));
    }
    printf(" in all: width %.2f\n", number_at(c, "mean_width"));
    for (size_t i = 0; i < json_array_size(subsets); ++i) {
        const json_t *s = json_array_get(subsets, i);
        printf("  %-39s  %s of %.0f, width %.2f\n", subset_text(text_at(s, "subset")),
               estimate_text(s, "inside", "ci95", 100, " %", 1, inside), number_at(s, "n"), number_at(s, "mean_width"));
    }
}

static void print_cell(const text_column *column, const char *text) {
    if (column->interval)
        printf("  %-22s", text);
    else
        printf(" %*s", (int)nqm_larger(7, strlen(column->heading)), text);
}

enum { NAME_TEXT = 64 };

/* The name of a row, with its mark. */
static const char *name_text(const json_t *row, char text[NAME_TEXT]) {
    snprintf(text, NAME_TEXT, "%s%s", row_name(row), json_is_true(json_object_get(row, "best_of_family")) ? " *" : "");
    return text;
}

static void print_rows(const json_t *rows, const text_column *columns) {
    char name[NAME_TEXT];
    int n_name = 14;
    for (size_t i = 0; i < json_array_size(rows); ++i) {
        const int n = (int)strlen(name_text(json_array_get(rows, i), name));
        n_name = n > n_name ? n : n_name;
    }
    printf("%*s", n_name, "");
    for (const text_column *c = columns; c->heading; ++c)
        print_cell(c, c->heading);
    putchar('\n');
    for (size_t i = 0; i < json_array_size(rows); ++i) {
        const json_t *row = json_array_get(rows, i);
        char text[64];
        printf("%-*s", n_name, name_text(row, name));
        for (const text_column *c = columns; c->heading; ++c)
            print_cell(c, estimate_text(row, c->key, c->interval, 1, "", 3, text));
        putchar('\n');
    }
    for (size_t i = 0; i < json_array_size(rows); ++i)
        print_contrasts(json_array_get(rows, i));
    for (size_t i = 0; i < json_array_size(rows); ++i)
        print_coverage(json_array_get(rows, i));
}

static void print_pairs_table(const eval_run *run, const char *by, const char *name, const json_t *rows) {
    (void)run, (void)by;
    const json_t *first = json_array_get(rows, 0);
    name = shown(name);
    if (!first) {
        printf("\n%s: no pairs\n", name);
        return;
    }
    printf("\n%s: %.0f pairs of %.0f materials\n", name, number_at(first, "n"), number_at(first, "n_materials"));
    print_rows(rows, pair_text);
}

static void print_parts(const eval_run *run, const char *by, const char *name, const json_t *rows) {
    (void)run, (void)by;
    for (size_t i = 0; i < json_array_size(rows); ++i) {
        const json_t *row = json_array_get(rows, i), *parts = json_object_get(row, "parts");
        if (!json_array_size(parts))
            continue;
        printf("\nParts of the label, %s: Spearman of the parts that %s predicts, %.0f pairs of %.0f materials\n",
               shown(name), row_name(row), number_at(row, "n"), number_at(row, "n_materials"));
        printf("%-12s  %-22s  %-22s  %-38s  %s\n", "", "predicted [95 %]", "estimate", "scalar feature", "same sign");
        for (size_t k = 0; k < json_array_size(parts); ++k) {
            const json_t *part = json_array_get(parts, k), *scalar = json_object_get(part, "scalar");
            char predicted[64], estimate[64], control[64], same[64];
            printf("%-12s  %-22s  %-22s  %-22s %s", text_at(part, "part"),
                   estimate_text(part, "spearman", "ci95", 1, "", 3, predicted),
                   estimate_text(json_object_get(part, "estimate"), "spearman", "ci95", 1, "", 3, estimate),
                   estimate_text(scalar, "spearman", "ci95", 1, "", 3, control), text_at(scalar, "name"));
            if (number_at(part, "n_plain") > 0)
                printf("%*s  %s of %.0f", 15 - (int)strlen(text_at(scalar, "name")), "",
                       estimate_text(part, "same_sign", "", 100, " %", 1, same), number_at(part, "n_plain"));
            putchar('\n');
        }
    }
}

/* Say how the intervals of the table were computed. */
static const char *interval_source(const eval_run *run) {
    return json_is_array(json_object_get(json_array_get(run->results, 0), "ci95"))
               ? "Intervals: bootstrap over materials."
               : "No intervals: they need --bootstrap above 0 and at least 4 materials.";
}

static void print_pairs_text(const eval_run *run) {
    const char *label = run->human ? nqm_human_get_info(run->human).kind_name : "JOD", *path = shown(run->dataset_path);
    if (run->human)
        printf("human    %s, column: %s\n", path, label);
    else
        printf("dataset  %s, split: %s\n", path, run->split_name);
    print_tables(run, print_pairs_table);
    print_tables(run, print_parts);
    printf("\nCorrelations with the labels (%s), signed so that higher is better. %s\n"
           "The mean by material counts materials with at least 3 pairs. MAE, RMSE in JOD. * best of its family.\n"
           "Same sign: of the parts above 3 Delta-E (contrast: 10 %%) in size; structure: of 1 Delta-E or more "
           "predicted.\n"
           "Order: share in the right order of the tests of one material whose labels differ by more than %g.\n",
           label, interval_source(run), run->order_margin);
    if (run->human && isfinite(nqm_human_get_info(run->human).ceiling))
        printf(
            "The answers are noisy: their true means are expected to have a Pearson correlation of %.3f with them.\n",
            nqm_human_get_info(run->human).ceiling);
    if (run->n_predictors > run->n_models + NQM_METRIC_COUNT)
        puts(
            "Estimate: the label that the light transport of the scene estimates from the samples, without a network.");
}

static void print_choices_text(const eval_run *run) {
    nqm_human_info info = nqm_human_get_info(run->human);
    printf("choices  %s: %.0f between %zu pairs of tests, %zu references of %zu materials\n\n",
           shown(run->dataset_path), info.n_choices, info.n_triplets, info.n_refs, info.n_groups);
    print_rows(run->results, choice_text);
    printf("\nThe best possible predictor reaches %.3f; most of the other people predict a person in ", info.ceiling);
    if (isfinite(info.ceiling_other_people))
        printf("%.3f", info.ceiling_other_people);
    else
        printf("- (one choice each)");
    puts(" of the choices.\n"
         "Agreement: share of the choices for the test that the predictor finds better; ties count half, 0.5 is "
         "guessing.\n"
         "Majority: share of the pairs of tests in which it sides with most people. * best of its family.");
    puts(interval_source(run));
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static json_t *human_json(const nqm_human *human) {
    nqm_human_info info = nqm_human_get_info(human);
    json_t *json = json_row("kind:s rows:z references:z materials:z ceiling:f", info.kind_name, info.n_rows,
                            info.n_refs, info.n_groups, info.ceiling);
    if (info.kind == NQM_HUMAN_CHOICE)
        json_set(json, "triplets:z choices:f ceiling_other_people:f", info.n_triplets, info.n_choices,
                 info.ceiling_other_people);
    return json;
}

static void print_json_results(const eval_run *run) {
    json_t *models = json_array();
    for (size_t i = 0; i < run->n_models; ++i)
        json_array_append_new(models, model_json(run->models[i]));
    json_t *json = json_row(
        "schema:i tool:o dataset:{path:s sha256:s split:o} order_margin:o models:o results:O human:o", 1, json_tool(),
        run->dataset_path, nqm_dataset_get_info(run->dataset).sha256,
        run->is_choice ? NULL : json_string(run->split_name), run->is_choice ? NULL : json_number(run->order_margin),
        models, run->results, run->human ? human_json(run->human) : NULL);
    json_object_update(json, run->selections);
    print_json(json);
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

static const char pair_columns[] =
    "by,selection,name,type,n,n_materials,spearman,ci95_low=ci95.0,ci95_high=ci95.1,spearman_mean_by_material,"
    "mean_ci95_low=ci95_mean_by_material.0,mean_ci95_high=ci95_mean_by_material.1,pearson,kendall,mae,rmse,r2,"
    "pearson_low=ci95_pearson.0,pearson_high=ci95_pearson.1,kendall_low=ci95_kendall.0,kendall_high=ci95_kendall.1,"
    "mae_low=ci95_mae.0,mae_high=ci95_mae.1,rmse_low=ci95_rmse.0,rmse_high=ci95_rmse.1,r2_low=ci95_r2.0,"
    "r2_high=ci95_r2.1,order,order_low=ci95_order.0,order_high=ci95_order.1,n_ordered,best_of_family,best_baseline,"
    "rival=contrasts.best_baseline.with,difference=contrasts.best_baseline.spearman.difference,"
    "difference_low=contrasts.best_baseline.spearman.ci95.0,difference_high=contrasts.best_baseline.spearman.ci95.1,"
    "share_below_0=contrasts.best_baseline.spearman.share_below_0,"
    "rival_2=contrasts.log_diff.with,difference_2=contrasts.log_diff.spearman.difference,"
    "difference_2_low=contrasts.log_diff.spearman.ci95.0,difference_2_high=contrasts.log_diff.spearman.ci95.1,"
    "share_2_below_0=contrasts.log_diff.spearman.share_below_0,"
    "coverage=interval.inside,coverage_low=interval.ci95.0,coverage_high=interval.ci95.1,"
    "coverage_by_material=interval.by_material,coverage_by_material_low=interval.ci95_by_material.0,"
    "coverage_by_material_high=interval.ci95_by_material.1,coverage_lowest=interval.lowest,"
    "interval_width=interval.mean_width,"
    "rival_3=contrasts.estimate.with,difference_3=contrasts.estimate.spearman.difference,"
    "difference_3_low=contrasts.estimate.spearman.ci95.0,difference_3_high=contrasts.estimate.spearman.ci95.1,"
    "share_3_below_0=contrasts.estimate.spearman.share_below_0,"
    "part,estimate=estimate.spearman,estimate_low=estimate.ci95.0,estimate_high=estimate.ci95.1,"
    "scalar=scalar.name,scalar_spearman=scalar.spearman,scalar_low=scalar.ci95.0,scalar_high=scalar.ci95.1,"
    "n_plain,same_sign";
static const char choice_columns[] =
    "name,type,triplets,choices,agreement,ci95_low=ci95.0,ci95_high=ci95.1,majority,ceiling,ceiling_other_people,"
    "best_of_family,best_baseline,"
    "rival=contrasts.best_baseline.with,difference=contrasts.best_baseline.agreement.difference,"
    "difference_low=contrasts.best_baseline.agreement.ci95.0,difference_high=contrasts.best_baseline.agreement.ci95.1,"
    "share_below_0=contrasts.best_baseline.agreement.share_below_0,"
    "rival_2=contrasts.log_diff.with,difference_2=contrasts.log_diff.agreement.difference,"
    "difference_2_low=contrasts.log_diff.agreement.ci95.0,difference_2_high=contrasts.log_diff.agreement.ci95.1,"
    "share_2_below_0=contrasts.log_diff.agreement.share_below_0";

/* A line of values, from `row` or else from `facts`. */
static void print_csv_facts(const char *columns, json_t *row, json_t *facts) {
    json_t *line = json_copy(row);
    json_object_update_missing(line, facts);
    print_csv_line(stdout, columns, line, NULL);
    json_decref(line);
}

/* The lines of a model besides that of its row: coverage by subset, and parts. `facts` are changed. */
static void print_csv_details(const json_t *row, json_t *facts) {
    const json_t *parts = json_object_get(row, "parts"), *subsets = value_at(row, "interval.by_subset");
    json_object_del(facts, "best_of_family");
    json_object_del(facts, "best_baseline");
    json_object_set(facts, "name", json_object_get(row, "name"));
    json_object_set_new(facts, "type", json_string("part"));
    for (size_t i = 0; i < json_array_size(parts); ++i)
        print_csv_facts(pair_columns, json_array_get(parts, i), facts);
    json_set(facts, "type:s by:s", "coverage", "subset");
    for (size_t i = 0; i < json_array_size(subsets); ++i) {
        json_t *s = json_array_get(subsets, i);
        json_t *line = json_row("selection:O n:O n_materials:O interval:O", json_object_get(s, "subset"),
                                json_object_get(s, "n"), json_object_get(s, "n_materials"), s);
        print_csv_facts(pair_columns, line, facts);
        json_decref(line);
    }
}

static void print_csv_table(const eval_run *run, const char *by, const char *name, const json_t *rows) {
    json_t *facts = json_row("by:s selection:s best_of_family:b best_baseline:b", by, name, 0, 0);
    if (run->human)
        json_object_update_new(facts, human_json(run->human));
    for (size_t i = 0; i < json_array_size(rows); ++i)
        print_csv_facts(run->is_choice ? choice_columns : pair_columns, json_array_get(rows, i), facts);
    for (size_t i = 0; i < json_array_size(rows) && !run->is_choice; ++i)
        print_csv_details(json_array_get(rows, i), facts);
    json_decref(facts);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

void print_evaluation(const eval_run *run, result_format format) {
    end_progress();
    if (format == FORMAT_JSON) {
        print_json_results(run);
    } else if (format == FORMAT_CSV) {
        print_csv_line(stdout, run->is_choice ? choice_columns : pair_columns, NULL, NULL);
        print_tables(run, print_csv_table);
    } else if (run->is_choice) {
        print_choices_text(run);
    } else {
        print_pairs_text(run);
    }
}
