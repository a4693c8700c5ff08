/* SPDX-License-Identifier: MIT
 *
 * nqm eval - the fraction of labels inside the 95 % intervals of the models.
 */
#include "nqm/judge/eval.h"

#include <math.h>
#include <stdlib.h>

static bool has_coverage(const eval_table *table, size_t predictor) {
    return table->coverage[predictor].n > 0;
}

nqm_status judge_coverage(const eval_run *run, const nqm_eval_options *o, eval_table *table, nqm_error *err) {
    nqm_status status = NQM_OK;
    bool in_jod = !run->human || nqm_human_get_info(run->human).kind == NQM_HUMAN_JOD;
    for (size_t i = 0; status == NQM_OK && in_jod && i < run->n_models; ++i)
        if (*nqm_model_get_info(run->models[i]).calibration)
            status = nqm_evaluation_coverage(run->evaluation, o, i, &table->coverage[i], err);
    return status;
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* "96.4 % [95.1, 97.6]" */
static void print_share(const nqm_estimate *share) {
    printf("%.1f %%", 100 * share->value);
    if (isfinite(share->ci95[0]))
        printf(" [%.1f, %.1f]", 100 * share->ci95[0], 100 * share->ci95[1]);
}

static void print_ranges(const nqm_coverage *c) {
    printf("  by predicted JOD:");
    for (const nqm_coverage_range *r = c->ranges; r < c->ranges + NQM_COVERAGE_RANGES; ++r)
        if (r->n)
            printf(" from %g: %.1f %% of %zu, width %.2g;", r->from, 100 * r->inside, r->n, r->mean_width);
    printf(" in all: width %.2f\n", c->mean_width);
}

void print_coverage(const eval_run *run, const eval_table *table) {
    for (size_t i = 0; i < run->n_models; ++i) {
        const nqm_coverage *c = &table->coverage[i];
        if (!has_coverage(table, i))
            continue;
        printf("%.40s, labels inside its 95 %% interval: ", predictor_name(run, i));
        print_share(&c->inside);
        printf("; mean by material ");
        print_share(&c->by_material);
        printf(", lowest %.1f %% (%.60s); %.1f %% below, %.1f %% above\n", 100 * c->lowest, c->lowest_material,
               100 * c->below, 100 * c->above);
        print_ranges(c);
    }
}

/* ---- JSON and CSV ------------------------------------------------------------------------------------------------ */

static json_t *ranges_json(const nqm_coverage *c) {
    json_t *ranges = json_array();
    for (const nqm_coverage_range *r = c->ranges; r < c->ranges + NQM_COVERAGE_RANGES; ++r)
        json_array_append_new(ranges, json_pack("{s:f,s:I,s:o,s:o}", "from", r->from, "n", (json_int_t)r->n, "inside",
                                                json_number(r->inside), "mean_width", json_number(r->mean_width)));
    return ranges;
}

json_t *coverage_json(const eval_table *table, size_t model) {
    const nqm_coverage *c = &table->coverage[model];
    if (!has_coverage(table, model))
        return json_null();
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "inside", json_number(c->inside.value), "ci95",
                     interval_json(c->inside.ci95), "by_material", json_number(c->by_material.value),
                     "ci95_by_material", interval_json(c->by_material.ci95), "lowest", json_number(c->lowest),
                     "lowest_material", json_name(c->lowest_material), "below", json_number(c->below), "above",
                     json_number(c->above), "mean_width", json_number(c->mean_width), "by_predicted_jod",
                     ranges_json(c));
}

const char coverage_columns[] = "coverage,coverage_low,coverage_high,coverage_by_material,coverage_by_material_low,"
                                "coverage_by_material_high,coverage_lowest,interval_width";

void print_csv_coverage(const nqm_coverage *c) {
    enum { N_COLUMNS = 8 };
    double numbers[N_COLUMNS] = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    if (c && c->n) {
        const double known[N_COLUMNS] = {
            c->inside.value,        c->inside.ci95[0],      c->inside.ci95[1], c->by_material.value,
            c->by_material.ci95[0], c->by_material.ci95[1], c->lowest,         c->mean_width};
        for (size_t i = 0; i < N_COLUMNS; ++i)
            numbers[i] = known[i];
    }
    print_csv_numbers(stdout, N_COLUMNS, numbers);
}
