/* SPDX-License-Identifier: MIT
 *
 * nqm eval --pairs - writes label, predictions, scalar features and parts of every judged pair as CSV, for plots and for
 * studies/control.py, which fits a control model to the features.
 */
#include "nqm/judge/eval.h"

#include <math.h>

/* Columns of the parts of a label. prefix: of their names. */
static void write_part_names(FILE *out, const char *prefix) {
    for (size_t k = 0; k < LABEL_COLUMNS; ++k) {
        char name[200];
        snprintf(name, sizeof name, "%.150s%s%s", prefix, *prefix ? ":" : "", label_columns[k]);
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
        print_csv_label(out, &label, NULL);
    }
    for (size_t i = 0; i < run->n_predictors; ++i)
        if (nqm_evaluation_labels(run->evaluation, i))
            print_csv_label(out, &nqm_evaluation_labels(run->evaluation, i)[pair], NULL);
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
