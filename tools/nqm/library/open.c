/* SPDX-License-Identifier: MIT
 *
 * Libraries for `nqm diff`, `nqm dedup` and `nqm nearest`, and the pairs that they find as rows of a score.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>

nqm_library *open_library(size_t n, const char *const *where, const score_run *run, const char *index) {
    const nqm_library_options options = {.ignore = ignored_words,
                                         .index = index,
                                         .score = run ? &run->options : NULL,
                                         .progress = show_progress,
                                         .report = report_part};
    nqm_library *library;
    (void)ignored_set(); /* names the option in its refusal */
    must(nqm_library_open(n, where, run ? run->model : NULL, &options, &library, &fault));
    end_progress();
    return library;
}

void set_library_rows(score_run *run, size_t n, const nqm_library_pair *pairs, const nqm_library *tests) {
    run->terms = (remark_terms){run->model, run->options.invalid};
    run->n_rows = n;
    run->rows = allocate(n, sizeof *run->rows);
    for (size_t i = 0; i < n; ++i) {
        scored_pair *row = &run->rows[i];
        *row = (scored_pair){.pair = pairs[i].names, .name = tests->members[pairs[i].test].key, .order = i};
        row->result = pairs[i].result;
        row->err = pairs[i].error;
        row->heat_max = (double)NAN;
        row->texture = pairs[i].texture;
    }
}

void find_near(nqm_library *library, const nqm_library_query *query, score_run *run) {
    const nqm_library_pair *pairs;
    size_t n;
    must(nqm_library_near(library, query, &n, &pairs, &fault));
    end_progress();
    set_library_rows(run, n, pairs, library);
    for (size_t i = 0; query->to && i < n; ++i) /* as `nqm rank` names them */
        run->rows[i].name = run->rows[i].pair.test;
}

int conclude_near(nqm_library *library, score_run *run) {
    const int exit_code = report_faults(run);
    const size_t n_failed = library->n_failed;
    nqm_library_free(library);
    free(run->rows);
    nqm_model_free(run->model);
    return exit_code == EXIT_OK && n_failed ? EXIT_PARTIAL : exit_code;
}
