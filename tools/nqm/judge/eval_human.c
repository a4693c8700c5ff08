/* SPDX-License-Identifier: MIT
 *
 * nqm eval --human - opens the answers of people and prints the tables of choices. Scores are judged and printed like
 * the labels of any other dataset.
 */
#include "nqm/judge/eval.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

int open_human(eval_run *run, const char *root) {
    nqm_error err = {0};
    nqm_human_options o = nqm_human_options_default();
    o.root = root;
    o.progress = show_progress;
    if (run->n_models)
        o.directions = nqm_model_get_info(run->models[0]).directions;
    if (nqm_human_load(run->dataset_path, &o, &run->human, &err) != NQM_OK) {
        end_progress();
        return report_error("eval", &err);
    }
    run->dataset = nqm_human_dataset(run->human);
    return EXIT_OK;
}

json_t *human_json(const nqm_human *human) {
    nqm_human_info info = nqm_human_get_info(human);
    json_t *json = json_pack("{s:s,s:I,s:I,s:I}", "kind", info.kind_name, "rows", (json_int_t)info.n_rows, "references",
                             (json_int_t)info.n_refs, "materials", (json_int_t)info.n_groups);
    if (info.kind == NQM_HUMAN_CHOICE)
        json_object_update_new(json, json_pack("{s:I,s:f,s:o,s:o}", "triplets", (json_int_t)info.n_triplets, "choices",
                                               info.n_choices, "ceiling", json_number(info.ceiling),
                                               "ceiling_other_people", json_number(info.ceiling_other_people)));
    return json;
}

/* ---- choices ----------------------------------------------------------------------------------------------------- */

/* The comparison of a model with a metric. */
typedef struct rivalry {
    size_t rival; /* predictor; the model itself: no comparison */
    nqm_difference difference;
} rivalry;

typedef struct choices_run {
    const eval_run *run;
    nqm_choice_agreement *results; /* (n_predictors) */
    rivalry *rivalries;            /* (n_models, N_RIVALS) */
} choices_run;

static nqm_status judge_choices(choices_run *c, const nqm_eval_options *o, nqm_error *err) {
    const eval_run *run = c->run;
    nqm_status status = nqm_human_judge_choices(run->human, run->evaluation, o, c->results, err);
    for (size_t i = 0; status == NQM_OK && i < run->n_models * N_RIVALS; ++i) {
        rivalry *r = &c->rivalries[i];
        r->rival = i % N_RIVALS == RIVAL_LOG_DIFF ? run->n_models + NQM_METRIC_LOG_DIFF : i / N_RIVALS;
        for (size_t m = run->n_models; i % N_RIVALS == RIVAL_BASELINE && m < run->n_predictors; ++m)
            if (c->results[m].best_baseline)
                r->rival = m;
        status =
            nqm_human_contrast_choices(run->human, run->evaluation, o, i / N_RIVALS, r->rival, &r->difference, err);
    }
    return status;
}

static bool exists(const rivalry *r, size_t model) {
    return r->rival != model;
}

static int print_choices_text(const choices_run *c) {
    const eval_run *run = c->run;
    nqm_human_info info = nqm_human_get_info(run->human);
    printf("choices  %s: %.0f between %zu pairs of tests, %zu references of %zu materials\n\n%-14s  %-22s %9s\n",
           run->dataset_path, info.n_choices, info.n_triplets, info.n_refs, info.n_groups, "", "agreement [95 %]",
           "majority");
    for (size_t i = 0; i < run->n_predictors; ++i) {
        const nqm_choice_agreement *r = &c->results[i];
        char name[48];
        snprintf(name, sizeof name, "%.40s%s", r->name, r->best_of_family ? " *" : "");
        printf("%-14s", name);
        print_interval(&r->agreement);
        printf("   ");
        print_number(r->majority);
        putchar('\n');
    }
    for (size_t i = 0; i < run->n_models * N_RIVALS; ++i) {
        const rivalry *r = &c->rivalries[i];
        if (!exists(r, i / N_RIVALS))
            continue;
        printf("%.40s less %s%s: ", c->results[i / N_RIVALS].name, c->results[r->rival].name,
               i % N_RIVALS == RIVAL_BASELINE ? ", best of the eight" : "");
        print_difference(&r->difference);
        putchar('\n');
    }
    printf("\nThe best possible predictor reaches %.3f; most of the other people predict a person in ", info.ceiling);
    if (isfinite(info.ceiling_other_people))
        printf("%.3f", info.ceiling_other_people);
    else
        printf("- (one choice each)");
    puts(" of the choices.\n"
         "Agreement: share of the choices for the test that the predictor finds better; ties count half, 0.5 is "
         "guessing.\n"
         "Majority: share of the pairs of tests in which it sides with most people. * best of its family.\n"
         "Intervals: bootstrap over materials.");
    return fflush(stdout) == 0 ? EXIT_OK : report("eval", EXIT_OPEN, "standard output: %s", strerror(errno));
}

static int print_choices_json(const choices_run *c) {
    const eval_run *run = c->run;
    json_t *results = json_array();
    for (size_t i = 0; i < run->n_predictors; ++i) {
        const nqm_choice_agreement *r = &c->results[i];
        bool model = i < run->n_models;
        json_t *row = json_pack("{s:s,s:s,s:o,s:o,s:o}", "name", r->name, "type", model ? "model" : "metric",
                                "agreement", json_number(r->agreement.value), "ci95", interval_json(r->agreement.ci95),
                                "majority", json_number(r->majority));
        json_t *contrasts = json_array();
        for (size_t k = 0; model && k < N_RIVALS; ++k) {
            const rivalry *v = &c->rivalries[i * N_RIVALS + k];
            if (exists(v, i))
                json_array_append_new(contrasts,
                                      json_pack("{s:s,s:b,s:o}", "with", c->results[v->rival].name, "best_baseline",
                                                k == RIVAL_BASELINE, "agreement", difference_json(&v->difference)));
        }
        if (model)
            json_object_set(row, "contrasts", contrasts);
        else
            json_object_update_new(
                row, json_pack("{s:b,s:b}", "best_of_family", r->best_of_family, "best_baseline", r->best_baseline));
        json_decref(contrasts);
        json_array_append_new(results, row);
    }
    return print_json(json_pack("{s:i,s:o,s:{s:o,s:s},s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "dataset",
                                "path", json_name(run->dataset_path), "sha256",
                                nqm_dataset_get_info(run->dataset).sha256, "human", human_json(run->human), "models",
                                models_json(run), "results", results));
}

static int print_choices_csv(const choices_run *c) {
    const eval_run *run = c->run;
    nqm_human_info info = nqm_human_get_info(run->human);
    puts("name,type,triplets,choices,agreement,ci95_low,ci95_high,majority,ceiling,ceiling_other_people,best_of_family,"
         "best_baseline,rival,difference,difference_low,difference_high,share_below_0,rival_2,difference_2,"
         "difference_2_low,difference_2_high,share_2_below_0");
    for (size_t i = 0; i < run->n_predictors; ++i) {
        const nqm_choice_agreement *r = &c->results[i];
        bool model = i < run->n_models;
        print_csv_text(stdout, r->name);
        printf(",%s,%zu,%.0f", model ? "model" : "metric", info.n_triplets, info.n_choices);
        print_csv_numbers(stdout, 6,
                          (const double[]){r->agreement.value, r->agreement.ci95[0], r->agreement.ci95[1], r->majority,
                                           info.ceiling, info.ceiling_other_people});
        printf(",%d,%d", r->best_of_family, r->best_baseline);
        for (size_t k = 0; k < N_RIVALS; ++k) {
            const rivalry *v = model ? &c->rivalries[i * N_RIVALS + k] : NULL;
            bool there = v && exists(v, i);
            print_csv_difference(there ? c->results[v->rival].name : NULL, there ? &v->difference : NULL);
        }
        putchar('\n');
    }
    return fflush(stdout) == 0 ? EXIT_OK : report("eval", EXIT_OPEN, "standard output: %s", strerror(errno));
}

int evaluate_choices(const eval_run *run, const nqm_eval_options *o, result_format format) {
    nqm_error err = {0};
    choices_run c = {.run = run,
                     .results = calloc(run->n_predictors, sizeof *c.results),
                     .rivalries = calloc(run->n_models * N_RIVALS + 1, sizeof *c.rivalries)};
    int exit_code = EXIT_OK;
    if (!c.results || !c.rivalries)
        exit_code = report("eval", EXIT_LIMIT, "out of memory");
    else if (judge_choices(&c, o, &err) != NQM_OK)
        exit_code = report_error("eval", &err);
    end_progress();
    if (exit_code == EXIT_OK)
        exit_code = format == FORMAT_JSON  ? print_choices_json(&c)
                    : format == FORMAT_CSV ? print_choices_csv(&c)
                                           : print_choices_text(&c);
    free(c.results);
    free(c.rivalries);
    return exit_code;
}
