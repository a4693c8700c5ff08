/* SPDX-License-Identifier: MIT
 *
 * nqm eval - judges predictors and makes a row of each result.
 */
#include "nqm/judge/eval.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The predictors with which each model is compared. */
enum { RIVAL_BASELINE, RIVAL_LOG_DIFF, RIVAL_ESTIMATE, N_RIVALS };

const char *const subset_words[] = {"near", "far", "rounding", "seen", "unseen", NULL};

/* Name of a model or a metric, or "estimate". */
static const char *predictor_name(const eval_run *run, size_t predictor) {
    return predictor < run->n_models ? run->model_names[predictor] : run->evaluation->names[predictor];
}

/* ---- parts of a row ---------------------------------------------------------------------------------------------- */

static json_t *interval_json(const double ci95[2]) {
    return isfinite(ci95[0]) ? json_pack("[o,o]", json_number(ci95[0]), json_number(ci95[1])) : json_null();
}

static void set_estimate(json_t *row, const char *key, const char *interval_key, const nqm_estimate *e) {
    json_object_set_new(row, key, json_number(e->value));
    json_object_set_new(row, interval_key, interval_json(e->ci95));
}

static json_t *difference_json(const nqm_difference *d) {
    return json_row("difference:f ci95:o share_below_0:f", d->value, interval_json(d->ci95), d->share_below_0);
}

static void set_agreement(json_t *row, const nqm_agreement *a) {
    const struct {
        const char *key, *interval;
        const nqm_estimate *estimate;
    } statistics[] = {
        {"spearman", "ci95", &a->spearman},
        {"spearman_mean_by_material", "ci95_mean_by_material", &a->spearman_mean_by_material},
        {"pearson", "ci95_pearson", &a->pearson},
        {"kendall", "ci95_kendall", &a->kendall},
        {"mae", "ci95_mae", &a->mae},
        {"rmse", "ci95_rmse", &a->rmse},
        {"r2", "ci95_r2", &a->r2},
        {"order", "ci95_order", &a->order},
    };
    json_set(row, "n:z n_materials:z n_ordered:z", a->n, a->n_materials, a->n_ordered);
    for (size_t i = 0; i < sizeof statistics / sizeof *statistics; ++i)
        set_estimate(row, statistics[i].key, statistics[i].interval, statistics[i].estimate);
}

static json_t *coverage_json(const nqm_coverage *c) {
    json_t *json = json_row("n:z", c->n), *ranges = json_array();
    set_estimate(json, "inside", "ci95", &c->inside);
    set_estimate(json, "by_material", "ci95_by_material", &c->by_material);
    for (const nqm_coverage_range *r = c->ranges; r < c->ranges + NQM_COVERAGE_RANGES; ++r)
        json_array_append_new(ranges,
                              json_row("from:f n:z inside:f mean_width:f", r->from, r->n, r->inside, r->mean_width));
    json_set(json, "lowest:f lowest_material:s below:f above:f mean_width:f by_predicted_jod:o", c->lowest,
             c->lowest_material, c->below, c->above, c->mean_width, ranges);
    return json;
}

/* Number of the predictor that is the estimate by light transport; n_predictors if there is none. */
static size_t estimate_of(const eval_run *run) {
    return run->n_models + NQM_METRIC_COUNT;
}

/* Append a row with its name, its type and, of a metric, its marks; the caller adds the values. NULL: out of memory. */
static json_t *append_row(const eval_run *run, json_t *rows, int best_of_family, int best_baseline) {
    const size_t i = json_array_size(rows);
    const bool is_metric = i >= run->n_models && i < estimate_of(run);
    json_t *row = json_row("name:s type:s", predictor_name(run, i),
                           is_metric           ? "metric"
                           : i < run->n_models ? "model"
                                               : "estimate");
    if (is_metric)
        json_set(row, "best_of_family:b best_baseline:b", best_of_family, best_baseline);
    return json_array_append_new(rows, row) == 0 ? row : NULL;
}

/* The predictor with which contrast `i` of a model compares it; the model itself if there is none. */
static size_t rival_of(const eval_run *run, size_t model, size_t i, size_t best_baseline) {
    if (i == RIVAL_LOG_DIFF)
        return run->n_models + NQM_METRIC_LOG_DIFF;
    if (i == RIVAL_ESTIMATE)
        return estimate_of(run) < run->n_predictors ? estimate_of(run) : model;
    return best_baseline < run->n_predictors ? best_baseline : model;
}

/* ---- selections of pairs ----------------------------------------------------------------------------------------- */

static json_t *contrasts_json(const eval_run *run, const nqm_contrast *contrasts) {
    json_t *list = json_array();
    for (size_t i = 0; i < N_RIVALS; ++i) {
        const nqm_contrast *c = &contrasts[i];
        if (c->first != c->second)
            json_array_append_new(
                list, json_row("with:s best_baseline:b spearman:o spearman_mean_by_material:o order:o",
                               predictor_name(run, c->second), i == RIVAL_BASELINE, difference_json(&c->spearman),
                               difference_json(&c->spearman_mean_by_material), difference_json(&c->order)));
    }
    return list;
}

/* The coverage in each subset that has pairs. */
static json_t *subset_coverage_json(const eval_run *run, nqm_eval_options o, size_t model) {
    json_t *list = json_array();
    for (size_t i = 0; subset_words[i]; ++i) {
        nqm_coverage c;
        o.subset = subset_words[i];
        const nqm_status status = nqm_evaluation_coverage(run->evaluation, &o, model, &c, &fault);
        if (status == NQM_ERR_INCOMPATIBLE) /* no pair */
            continue;
        must(status);
        json_t *entry = json_row("subset:s n:z n_materials:z", o.subset, c.n, c.n_materials);
        set_estimate(entry, "inside", "ci95", &c.inside);
        json_object_set_new(entry, "mean_width", json_number(c.mean_width));
        json_array_append_new(list, entry);
    }
    return list;
}

/* The coverage of a model's intervals, over all pairs also by subset; null if it has none, or if labels are not JODs. */
static json_t *model_coverage_json(const eval_run *run, const nqm_eval_options *o, size_t model, bool with_subsets) {
    nqm_coverage coverage;
    if (!run->is_jod || !*nqm_model_get_info(run->models[model]).calibration)
        return json_null();
    must(nqm_evaluation_coverage(run->evaluation, o, model, &coverage, &fault));
    json_t *json = coverage_json(&coverage);
    if (with_subsets)
        json_object_set_new(json, "by_subset", subset_coverage_json(run, *o, model));
    return json;
}

static json_t *spearman_json(const nqm_estimate *e) {
    json_t *json = json_object();
    set_estimate(json, "spearman", "ci95", e);
    return json;
}

/* How well a model predicts the parts of labels; null if either has no parts. */
static json_t *parts_json(const eval_run *run, const nqm_eval_options *o, size_t model) {
    nqm_part_agreement parts[NQM_EVAL_PARTS];
    if (!run->evaluation->dataset->parts || !nqm_evaluation_labels(run->evaluation, model))
        return json_null();
    must(nqm_evaluation_judge_parts(run->evaluation, o, model, parts, &fault));
    json_t *list = json_array();
    for (const nqm_part_agreement *p = parts; p < parts + NQM_EVAL_PARTS; ++p) {
        json_t *scalar = spearman_json(&p->scalar), *entry;
        json_set(scalar, "name:s", p->scalar_name);
        entry = json_row("part:s n:z n_materials:z estimate:o scalar:o", p->part, p->n, p->n_materials,
                         spearman_json(&p->estimate), scalar);
        set_estimate(entry, "spearman", "ci95", &p->model);
        json_set(entry, "n_plain:z same_sign:f", p->n_plain, p->same_sign);
        json_array_append_new(list, entry);
    }
    return list;
}

void judge_pairs(const eval_run *run, const nqm_eval_options *o, json_t *rows) {
    const size_t n_contrasts = run->n_models * N_RIVALS;
    size_t best = run->n_predictors;
    nqm_agreement *results = allocate(run->n_predictors, sizeof *results);
    nqm_contrast *contrasts = allocate(n_contrasts + 1, sizeof *contrasts);
    const nqm_status status = nqm_evaluation_judge(run->evaluation, o, results, &fault);
    const bool is_whole = rows == run->results, is_empty = status == NQM_ERR_INCOMPATIBLE && !is_whole;
    if (!is_empty)
        must(status);
    for (size_t i = run->n_models; i < run->n_predictors; ++i)
        if (results[i].best_baseline)
            best = i;
    for (size_t i = 0; i < n_contrasts; ++i) {
        contrasts[i].first = i / N_RIVALS;
        contrasts[i].second = rival_of(run, i / N_RIVALS, i % N_RIVALS, best);
    }
    if (n_contrasts && !is_empty)
        must(nqm_evaluation_contrast(run->evaluation, o, n_contrasts, contrasts, &fault));
    for (size_t i = 0; i < run->n_predictors && !is_empty; ++i) {
        json_t *row = append_row(run, rows, results[i].best_of_family, results[i].best_baseline);
        set_agreement(row, &results[i]);
        if (i < run->n_models) {
            json_object_set_new(row, "contrasts", contrasts_json(run, contrasts + i * N_RIVALS));
            json_object_set_new(row, "interval", model_coverage_json(run, o, i, is_whole));
            if (is_whole || o->subset)
                json_object_set_new(row, "parts", parts_json(run, o, i));
        }
    }
    free(results);
    free(contrasts);
}

/* ---- choices ----------------------------------------------------------------------------------------------------- */

static json_t *choice_contrasts_json(const eval_run *run, const nqm_eval_options *o, size_t model, size_t best) {
    json_t *list = json_array();
    for (size_t k = 0; k < N_RIVALS; ++k) {
        const size_t rival = rival_of(run, model, k, best);
        nqm_difference difference;
        if (rival == model)
            continue;
        must(nqm_human_contrast_choices(run->human, run->evaluation, o, model, rival, &difference, &fault));
        json_array_append_new(list, json_row("with:s best_baseline:b agreement:o", predictor_name(run, rival),
                                             k == RIVAL_BASELINE, difference_json(&difference)));
    }
    return list;
}

void judge_choices(const eval_run *run, const nqm_eval_options *o, json_t *rows) {
    size_t best = run->n_predictors;
    nqm_choice_agreement *results = allocate(run->n_predictors, sizeof *results);
    must(nqm_human_judge_choices(run->human, run->evaluation, o, results, &fault));
    for (size_t i = run->n_models; i < run->n_predictors; ++i)
        if (results[i].best_baseline)
            best = i;
    for (size_t i = 0; i < run->n_predictors; ++i) {
        json_t *row = append_row(run, rows, results[i].best_of_family, results[i].best_baseline);
        set_estimate(row, "agreement", "ci95", &results[i].agreement);
        json_object_set_new(row, "majority", json_number(results[i].majority));
        if (i < run->n_models)
            json_object_set_new(row, "contrasts", choice_contrasts_json(run, o, i, best));
    }
    free(results);
}

/* ---- --pairs ----------------------------------------------------------------------------------------------------- */

enum { PARTS = 6 };
static const char *const part_names[PARTS] = {"shift_i", "shift_t", "shift_p", "contrast", "structure", "adapted_jod"};

static void write_parts(FILE *out, const nqm_label *l) {
    print_csv_numbers(out, PARTS,
                      (double[]){l->shift[0], l->shift[1], l->shift[2], l->contrast, l->structure,
                                 nqm_label_get_info(l).adapted_jod});
}

/* Columns of the parts of a label. prefix: of their names. */
static void write_part_names(FILE *out, const char *prefix) {
    for (size_t k = 0; k < PARTS; ++k) {
        char name[200];
        snprintf(name, sizeof name, "%.150s%s%s", prefix, *prefix ? ":" : "", part_names[k]);
        print_csv_field(out, name);
    }
}

static void write_head(const eval_run *run, FILE *out) {
    fputs("ref,material,test,kind,split,delta_e,jod", out);
    for (size_t i = 0; i < run->n_predictors; ++i)
        print_csv_field(out, predictor_name(run, i));
    fputs(",family,class", out);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        fprintf(out, ",scalar:%s", nqm_scalar_name(i));
    if (run->dataset->parts)
        write_part_names(out, "");
    for (size_t i = 0; i < run->n_predictors; ++i)
        if (nqm_evaluation_labels(run->evaluation, i))
            write_part_names(out, predictor_name(run, i));
    fputc('\n', out);
}

static void write_pair(const eval_run *run, size_t pair, FILE *out) {
    nqm_dataset_pair p = nqm_dataset_get_pair(run->dataset, pair);
    print_csv_text(out, p.ref);
    print_csv_field(out, p.group);
    print_csv_field(out, p.test);
    print_csv_field(out, p.kind);
    print_csv_field(out, nqm_split_words[p.split]);
    print_csv_numbers(out, 2, (double[]){p.delta_e, p.jod});
    for (size_t i = 0; i < run->n_predictors; ++i)
        print_csv_numbers(out, 1, &nqm_evaluation_values(run->evaluation, i)[pair]);
    print_csv_field(out, p.family);
    print_csv_field(out, p.material_class);
    print_csv_numbers(out, NQM_SCALAR_COUNT, run->evaluation->scalars + pair * NQM_SCALAR_COUNT);
    if (run->dataset->parts) {
        nqm_label label = {.delta_e = p.delta_e};
        nqm_label_set_parts(&label, run->dataset->parts + pair * NQM_LABEL_PARTS);
        write_parts(out, &label);
    }
    for (size_t i = 0; i < run->n_predictors; ++i)
        if (nqm_evaluation_labels(run->evaluation, i))
            write_parts(out, &nqm_evaluation_labels(run->evaluation, i)[pair]);
    fputc('\n', out);
}

void write_pairs(const eval_run *run, const char *path) {
    output_file out;
    open_output(path, &out);
    write_head(run, out.stream);
    size_t n_pairs = nqm_dataset_get_info(run->dataset).n_pairs;
    for (size_t pair = 0; pair < n_pairs; ++pair)
        if (!isnan(nqm_evaluation_values(run->evaluation, run->n_models)[pair]))
            write_pair(run, pair, out.stream);
    close_output(&out);
}
