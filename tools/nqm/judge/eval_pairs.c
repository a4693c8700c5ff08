/* SPDX-License-Identifier: MIT
 *
 * nqm eval --pairs - writes label, predictions and scalar features of every judged pair as CSV, for plots and for
 * models/control.py, which fits a control model to the features.
 */
#include "nqm/judge/eval.h"

#include <math.h>

static void write_head(const eval_run *run, FILE *out) {
    fputs("ref,material,test,kind,split,delta_e,jod", out);
    for (size_t i = 0; i < run->n_predictors; ++i) {
        fputc(',', out);
        print_csv_text(out, predictor_name(run, i));
    }
    fputs(",family,class", out);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        fprintf(out, ",scalar:%s", nqm_scalar_name(i));
    fputc('\n', out);
}

static void write_pair(const eval_run *run, size_t pair, FILE *out) {
    nqm_dataset_pair p = nqm_dataset_get_pair(run->dataset, pair);
    const char *const texts[] = {p.ref, p.group, p.test, p.kind, nqm_split_words[p.split]};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; ++k) {
        print_csv_text(out, texts[k]);
        fputc(',', out);
    }
    print_csv_number(out, p.delta_e);
    fputc(',', out);
    print_csv_number(out, p.jod);
    for (size_t i = 0; i < run->n_predictors; ++i) {
        fputc(',', out);
        print_csv_number(out, nqm_evaluation_values(run->evaluation, i)[pair]);
    }
    fputc(',', out);
    print_csv_text(out, p.family);
    fputc(',', out);
    print_csv_text(out, p.material_class);
    const double *scalars = nqm_evaluation_scalars(run->evaluation, pair);
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i) {
        fputc(',', out);
        print_csv_number(out, scalars[i]);
    }
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
