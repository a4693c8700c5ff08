/* SPDX-License-Identifier: MIT
 *
 * nqm rank - sorts approximations by their JOD.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- sorting ----------------------------------------------------------------------------------------------------- */

/* Scores that differ by less share a rank. The limit is ten times the rounding differences between groupings of
 * pairs. */
static const double tie_jod = 1e-4;

static bool has_score(const scored_pair *row) {
    return row->err.status == NQM_OK;
}

static int by_quality(const void *a, const void *b) {
    const scored_pair *x = a, *y = b;
    if (x->group != y->group)
        return x->group < y->group ? -1 : 1;
    if (has_score(x) != has_score(y))
        return has_score(x) ? -1 : 1;
    if (has_score(x) && isnan(x->quality) != isnan(y->quality))
        return isnan(x->quality) ? 1 : -1;
    if (has_score(x) && !isnan(x->quality) && x->quality != y->quality)
        return x->quality > y->quality ? -1 : 1;
    return x->order < y->order ? -1 : 1;
}

static int by_reference(const void *a, const void *b) {
    const scored_pair *x = a, *y = b;
    int difference = strcmp(x->pair.ref, y->pair.ref);
    return difference ? difference : x->order < y->order ? -1 : 1;
}

/* Number the references by their first appearance. */
static void number_groups(score_run *r) {
    qsort(r->rows, r->n_rows, sizeof *r->rows, by_reference);
    size_t first = 0;
    for (size_t i = 0; i < r->n_rows; ++i) {
        if (i == 0 || !has_reference_of(&r->rows[i], &r->rows[i - 1]))
            first = r->rows[i].order;
        r->rows[i].group = first; /* only the order of the numbers matters */
    }
}

static bool same_group(const score_run *r, size_t i, size_t k) {
    return k < r->n_rows && r->rows[i].group == r->rows[k].group;
}

void rank_rows(score_run *r, bool by_similarity) {
    for (size_t i = 0; i < r->n_rows; ++i)
        r->rows[i].quality = by_similarity ? r->rows[i].result.similarity[0] : r->rows[i].result.jod;
    number_groups(r);
    qsort(r->rows, r->n_rows, sizeof *r->rows, by_quality);
    size_t best = 0, leader = 0; /* first row of the reference; first row with an equal score */
    for (size_t i = 0; i < r->n_rows; ++i) {
        scored_pair *row = &r->rows[i];
        row->over_next = row->best_preferred = (double)NAN;
        if (i == 0 || !same_group(r, i - 1, i))
            best = leader = i;
        if (!has_score(row))
            continue;
        double quality = row->quality;
        if (r->rows[leader].quality - quality >= tie_jod)
            leader = i;
        row->rank = leader - best + 1;
        if (i != best)
            row->best_preferred = nqm_jod_preference(r->rows[best].quality, quality);
        if (same_group(r, i, i + 1) && has_score(&r->rows[i + 1]))
            row->over_next = nqm_jod_preference(quality, r->rows[i + 1].quality);
    }
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

static void print_percent(double share) {
    if (isfinite(share))
        printf("  %7.0f %%", 100 * share);
    else
        printf("  %9s", "-");
}

static void print_text(const score_run *run) {
    const nqm_model_info info = nqm_model_get_info(run->model);
    const bool calibrated = *info.calibration;
    printf("model      %s\n", shown(info.id));
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        if (i == 0 || row->group != row[-1].group)
            printf("%sreference  %s\n\n  rank    JOD%s  over next  best over%s  test\n", i ? "\n" : "",
                   shown(row->pair.ref), calibrated ? "  [95 %]        " : "",
                   isnan(row->result.similarity[0]) ? "" : "  seen apart");
        if (row->rank)
            printf("  %4zu", row->rank);
        else
            printf("  %4s", "-");
        print_jod(row, calibrated);
        print_percent(row->over_next);
        print_percent(row->best_preferred);
        if (!isnan(row->result.similarity[0]))
            printf("  %10.2f", row->result.similarity[0]);
        printf("  %s\n", shown(row->name));
    }
    puts("\nover next: people who would prefer it to the one below; best over: who would prefer the best to it\n"
         "(50 % is guessing; one JOD is 75 %).");
}

static json_t *row_json(const score_run *run, const scored_pair *row) {
    json_t *object = json_row("reference:s name:s rank:o test:s over_next:f best_preferred:f", row->pair.ref, row->name,
                              row->rank ? json_integer((json_int_t)row->rank) : json_null(), row->pair.test,
                              row->over_next, row->best_preferred);
    json_object_update_new(object,
                           json_result(&run->terms, &row->pair, run->metrics, &run->gate, &row->result, &row->err));
    return object;
}

void print_ranking(const score_run *run) {
    if (run->format == FORMAT_JSON)
        print_document(json_row("model:o results:o", model_json(run->model), json_rows(run, row_json)));
    else if (run->format == FORMAT_CSV)
        print_csv_rows(run,
                       list_columns("reference,rank,test,jod,jod_low,jod_high,over_next,best_preferred",
                                    score_groups(run->model), NULL, ",name,error"),
                       row_json);
    else if (run->format == FORMAT_TEXT)
        print_text(run);
    for (size_t i = 0; run->format == FORMAT_QUIET && i < run->n_rows; ++i)
        if (run->rows[i].rank)
            puts(run->rows[i].pair.test);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static score_run run;
static const char *model = "default", *list_path, *root, *by = "jod";

static const option options[] = {
    {"list", 'l', OPTION_TEXT, &list_path, "LIST", "pairs from a list as `nqm batch` takes it, - for stdin", 0, 0},
    OPTION_ROWS_MODEL(&model),
    OPTION_ROW_IGNORE,
    {"by", 0, OPTION_TEXT, &by, "WORD", "jod (seen beside each other) or similarity (seen apart)", 0, 0},
    {"root", 0, OPTION_TEXT, &root, "DIR", "folder of relative paths in the list (default: the list's folder)", 0, 0},
    {"json", 0, OPTION_FORMAT, &run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"csv", 0, OPTION_FORMAT, &run.format, NULL, "print CSV", FORMAT_CSV, 0},
    {"quiet", 'q', OPTION_FORMAT, &run.format, NULL, "print the names only, best first", FORMAT_QUIET, 0},
    {0}};

static const command cmd = {
    .usage = "REF TEST... | --list LIST [options]",
    .about = "Order approximations of a reference by their JOD, best first, and say how many people would prefer each"
             " to the next, and the best to each. Scores within 0.0001 JOD share a rank. A list may have several "
             "references: each gets a ranking of its own.",
    .example = "nqm rank sgd:nickel ward:nickel 'perturb:gloss=0.9;of=sgd:nickel'\nnqm rank nickel.binary "
               "fits/*.binary -q | head -1",
    .options = options,
    .table = &nqm_score_option_table,
    .table_target = &run.options,
    .max_arguments = -1,
};

int cmd_rank(int argc, char **argv) {
    const char **names = NULL;
    nqm_pairs *list = NULL;
    run.options = plain_score_options();
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    if (list_path ? n_arguments > 0 : n_arguments < 2)
        stop(EXIT_USAGE, "give a reference and its tests, or --list LIST");
    if (root && !list_path)
        stop(EXIT_USAGE, "--root needs --list");
    const bool by_similarity = strcmp(by, "similarity") == 0;
    if (!by_similarity && strcmp(by, "jod") != 0)
        stop(EXIT_USAGE, "--by is jod or similarity, not '%s'", by);
    run.model = open_model(model);
    if (list_path) {
        list_path = input_path(list_path);
        must(nqm_pairs_read(list_path, &list, &fault));
        enter_list_root(root, list_path);
        set_list_pairs(&run, list);
    } else {
        names = take_names(n_arguments, argv);
        set_pairs(&run, n_arguments, argv, names);
    }
    run.near_only = true;
    make_scores(&run);
    for (size_t i = 0; by_similarity && i < run.n_rows; ++i)
        if (has_score(&run.rows[i]) && isnan(run.rows[i].result.similarity[0]))
            stop(EXIT_MODEL, "--by similarity: the model '%s' does not predict it; doc/people.md says which do", model);
    rank_rows(&run, by_similarity);
    print_ranking(&run);
    if (run.format != FORMAT_JSON)
        print_remarks(&run);
    const int exit_code = report_faults(&run);
    free_scores(&run);
    nqm_pairs_free(list);
    free(names);
    return exit_code;
}
