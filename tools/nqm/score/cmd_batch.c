/* SPDX-License-Identifier: MIT
 *
 * nqm batch - scores the pairs of a list in the order of the list. The columns of the list come first, unchanged.
 * batch_pieces.c has the results, also those of an interrupted run; batch_summary.c what is made of all rows.
 */
#include "base/os.h"
#include "nqm/rows.h"
#include "nqm/score/batch.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

typedef enum batch_format { BATCH_CSV, BATCH_JSON_LINES, BATCH_JSON } batch_format;

/* How rows are written. */
typedef struct batch_form {
    batch_format format;
    const nqm_pairs *list;
    const nqm_model *model;
    bool metrics[NQM_METRIC_COUNT]; /* metrics to write */
    bool has_textures;              /* columns of textures, too */
    char *columns;                  /* of results, for print_csv_line(); owned */
    score_gate gate;
    remark_terms terms;
} batch_form;

/* Rows on their way to standard output, a device, or a file, which gets its name when it is complete. */
typedef struct batch_output {
    output_file file;
    FILE *rows; /* that of `file`, or a temporary file of rows that are sorted in the end */
    size_t n_rows, n_failed;
    batch_note *notes; /* (rows of the list) of the rows that are written; they live as long as the run */
} batch_output;

/* ---- columns ----------------------------------------------------------------------------------------------------- */

/* Set the columns; stop when one of the list has the name of a result column or of another one of the list. */
static void set_batch_columns(batch_form *form) {
    const char *const *names = form->list->columns;
    char *added;
    size_t n_added;
    form->columns = list_columns("",
                                 score_groups(form->model) | COLUMNS_SCORE | COLUMNS_METRICS |
                                     (form->has_textures ? COLUMNS_BARE_TEXTURE : 0),
                                 form->metrics, has_gate(&form->gate) ? ",gate,warnings,error" : ",warnings,error");
    FILE *stream = open_text(&added, &n_added);
    fputs(nqm_model_has_parts(form->model) ? ",metrics,parts" : ",metrics", stream); /* members in JSON */
    print_csv_line(stream, form->columns, NULL, NULL);
    close_text(stream, &added, &n_added);
    *strchr(added, '\n') = ',';
    for (size_t i = 0; i < form->list->n_columns; ++i) {
        char *word = must_have(nqm_strdupf(",%s,", names[i]));
        if (!strchr(names[i], ',') && strstr(added, word))
            stop(EXIT_MALFORMED, "the list has a column '%s', which the results add: rename it", names[i]);
        nqm_free(word);
        for (size_t k = 0; k < i; ++k)
            if (strcmp(names[i], names[k]) == 0)
                stop(EXIT_MALFORMED, "the list has two columns '%s': rename one", names[i]);
    }
    free(added);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static json_t *row_json(const batch_form *form, size_t row, const nqm_score_result *r, const texture_numbers *texture,
                        const nqm_error *err) {
    json_t *object = json_result(&form->terms, &form->list->pairs[row], form->metrics, &form->gate, r, err);
    if (form->has_textures)
        set_texture_numbers(object, texture);
    return object;
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

/* Texts of the list, then the columns of a result, or the headings of both. */
static void print_csv_head(const batch_form *form, FILE *out) {
    for (size_t i = 0; i < form->list->n_columns; ++i) {
        fputs(i ? "," : "", out);
        print_csv_text(out, form->list->columns[i]);
    }
    print_csv_line(out, form->columns, NULL, NULL);
}

static void print_csv_cells(const batch_form *form, FILE *out, size_t row) {
    const char *texts[NQM_LIST_MAX_COLUMNS] = {NULL};
    nqm_pairs_cell cell;
    for (size_t i = 0; nqm_pairs_get_cell(form->list, row, i, &cell); ++i)
        texts[cell.column] = cell.text;
    for (size_t column = 0; column < form->list->n_columns; ++column) {
        fputs(column ? "," : "", out);
        print_csv_text(out, texts[column] ? texts[column] : "");
    }
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

/* Print `value` and release it. */
static void print_json_value(FILE *out, json_t *value) {
    json_dumpf(value, out, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
    json_decref(value);
}

static void print_json_cells(const batch_form *form, FILE *out, size_t row) {
    nqm_pairs_cell cell;
    for (size_t i = 0; nqm_pairs_get_cell(form->list, row, i, &cell); ++i) {
        print_json_value(out, json_name(form->list->columns[cell.column]));
        fputc(':', out);
        if (cell.is_json)
            fputs(cell.text, out);
        else
            print_json_value(out, json_name(cell.text));
        fputc(',', out);
    }
}

static void print_json_head(const batch_form *form, FILE *out) {
    fputs("{\"schema\":1,\"tool\":", out);
    print_json_value(out, json_tool());
    fputs(",\"model\":", out);
    print_json_value(out, model_json(form->model));
    fputs(",\"results\":[\n", out);
}

/* ---- any format -------------------------------------------------------------------------------------------------- */

static void print_batch_head(const batch_form *form, FILE *out) {
    if (form->format == BATCH_CSV)
        print_csv_head(form, out);
    else if (form->format == BATCH_JSON)
        print_json_head(form, out);
}

static void print_batch_row(const batch_form *form, FILE *out, size_t row, const nqm_score_result *result,
                            const texture_numbers *texture, const nqm_error *err) {
    json_t *object = row_json(form, row, result, texture, err);
    if (form->format == BATCH_CSV) {
        print_csv_cells(form, out, row);
        print_csv_line(out, form->columns, object,
                       (row_text[]){{"error", result->status == NQM_OK ? "" : err->message}, {0}});
    } else {
        char *text = must_have(json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(9)));
        fputc('{', out);
        print_json_cells(form, out, row);
        fputs(text + 1, out); /* without its brace */
        free(text);
    }
    json_decref(object);
    if (form->format == BATCH_JSON_LINES)
        fputc('\n', out);
}

/* The text before each row but the first. */
static const char *batch_separator(const batch_form *form) {
    return form->format == BATCH_JSON ? ",\n" : "";
}

/* ---- the output -------------------------------------------------------------------------------------------------- */

static _Noreturn void stop_write(const batch_output *out) {
    stop(EXIT_OPEN, "%s: cannot write: %s", out->file.file.path ? out->file.file.path : "standard output",
         strerror(errno));
}

/* Open, and print the text before the rows. path: absolute, or "-". */
static void open_batch_output(const char *path, const batch_form *form, bool is_sorted, batch_output *out) {
    char temporary[NQM_TEMPORARY_PATH];
    *out = (batch_output){.notes = allocate(form->list->n, sizeof *out->notes)};
    open_output(path, &out->file);
    out->rows = is_sorted ? nqm_os_temporary(temporary) : out->file.stream;
    if (!out->rows)
        stop(EXIT_OPEN, "there is no place for a temporary file: %s", strerror(errno));
    print_batch_head(form, out->file.stream);
}

/* Whether it is a file, of which nothing is seen until it is complete. */
static bool is_batch_file(const batch_output *out) {
    return out->file.file.temporary != NULL;
}

/* Write a row and its note. Returns false, and writes nothing, if the row fails and `keep_going` is not set. Rows whose materials are
 * refused alike do not count as failed. */
static bool write_batch_row(batch_output *out, const batch_form *form, const batch_pieces *pieces, size_t at,
                            bool keep_going) {
    const size_t row = out->n_rows;
    const bool is_sorted = out->rows != out->file.stream;
    batch_note *note = &out->notes[row];
    const nqm_named_pair *pair = &form->list->pairs[row];
    const char *name = form->list->names[row];
    *note = make_batch_note(&form->terms, pair, name ? name : pair->test, &pieces->results[at], &pieces->errors[at]);
    const bool is_failed = !note->is_scored && !note->is_skipped;
    if (is_failed && !keep_going) {
        free(note->remark);
        return false;
    }
    if (is_sorted)
        note->begin = ftell(out->rows);
    else
        fputs(row ? batch_separator(form) : "", out->rows);
    print_batch_row(form, out->rows, row, &pieces->results[at], &pieces->textures[at], &pieces->errors[at]);
    if (is_sorted)
        note->end = ftell(out->rows);
    out->n_failed += is_failed;
    ++out->n_rows;
    return true;
}

static void flush_batch_output(batch_output *out) {
    if (!is_batch_file(out))
        end_progress(); /* the progress line may be on the same terminal */
    if (fflush(out->rows) != 0 || ferror(out->rows))
        stop_write(out);
}

static void copy_row(const batch_output *out, const batch_note *note) {
    const size_t n = (size_t)(note->end - note->begin);
    char *text = allocate(n, 1);
    if (fseek(out->rows, note->begin, SEEK_SET) != 0 || fread(text, 1, n, out->rows) != n ||
        fwrite(text, 1, n, out->file.stream) != n)
        stop_write(out);
    free(text);
}

/* Write the end of the output and close it. order: (n) the rows of a sorted output; NULL: all are written. */
static void close_batch_output(batch_output *out, const batch_form *form, size_t n, const size_t *order) {
    for (size_t i = 0; order && i < n; ++i) {
        fputs(i ? batch_separator(form) : "", out->file.stream);
        copy_row(out, &out->notes[order[i]]);
    }
    if (form->format == BATCH_JSON)
        fputs("\n]}\n", out->file.stream);
    if (fflush(out->file.stream) != 0)
        stop_write(out);
    if (out->rows != out->file.stream)
        fclose(out->rows);
    close_output(&out->file);
}

/* ---- the run ----------------------------------------------------------------------------------------------------- */

typedef struct batch_run {
    nqm_score_options options;
    batch_form form;
    nqm_pairs *given, *list; /* as it is in the file; expanded */
    nqm_scorer *scorer;
    batch_pieces pieces;
    batch_output out;
    const char *list_name;
    char *path, *work, *junit, *markdown; /* absolute; NULL: not requested */
    bool keep_going, is_sorted, is_best, is_complete;
    uint64_t n_worst; /* rows of the output; 0: all */
} batch_run;

static batch_format choose_format(bool json, bool json_lines, const char *output) {
    if (json && json_lines)
        stop(EXIT_USAGE, "--json and --jsonl exclude each other");
    const char *name = output ? output : "";
    const bool names_lines = nqm_name_ends_in(name, ".jsonl") || nqm_name_ends_in(name, ".ndjson"),
               names_json = nqm_name_ends_in(name, ".json");
    if (!json && !json_lines)
        return names_lines ? BATCH_JSON_LINES : names_json ? BATCH_JSON : BATCH_CSV;
    if (nqm_name_ends_in(name, ".csv") || (json ? names_lines : names_json))
        stop(EXIT_USAGE, "--%s: '%s' names another kind of file", json ? "json" : "jsonl", name);
    return json ? BATCH_JSON : BATCH_JSON_LINES;
}

static void choose_order(batch_run *run, const char *word) {
    const int order = choose("sort", (const char *const[]){"list", "worst", "best", NULL}, word);
    if (order == 2 && run->n_worst)
        stop(EXIT_USAGE, "--worst N and --sort best exclude each other");
    run->is_sorted = order > 0 || run->n_worst > 0;
    run->is_best = order == 2;
}

/* Settings that determine results, in the folder where relative paths of the list begin. */
static json_t *score_terms(const batch_run *run) {
    nqm_model_info info = nqm_model_get_info(run->form.model);
    char *folder = nqm_os_real_path(".");
    json_t *terms = json_row("version of nqm:s list:s number of materials in its files:z model:s --root:s --invalid:s "
                             "--min-valid:f --metrics:s --ignore:s --textures:b",
                             nqm_version(), run->list->sha256, run->list->n, info.sha256, folder ? folder : "",
                             nqm_invalid_words[run->options.invalid], run->options.min_valid_fraction,
                             run->options.metrics ? "any" : "none", ignored_words ? ignored_words : "",
                             (int)run->form.has_textures);
    free(folder);
    return terms;
}

static int score_rows(batch_run *run) {
    batch_output *out = &run->out;
    for (size_t piece = 0, n; piece < run->pieces.n; ++piece) {
        if (show_batch_progress(&run->pieces, out->n_rows, run->list->n) || interrupted())
            return EXIT_INTERRUPTED;
        const int exit_code = get_batch_piece(&run->pieces, piece, &n);
        if (exit_code != EXIT_OK)
            return exit_code;
        size_t i = 0;
        while (i < n && write_batch_row(out, &run->form, &run->pieces, i, run->keep_going))
            ++i;
        flush_batch_output(out);
        if (i < n) {
            forget_batch_piece(&run->pieces, piece);
            return report(exit_code_of(run->pieces.results[i].status), "row %zu: %s", out->n_rows + 1,
                          run->pieces.errors[i].message);
        }
    }
    return EXIT_OK;
}

/* When the run ends early. Other outputs end with the rows that they have, as valid JSON. */
static void give_up_file(const batch_run *run, int exit_code) {
    const size_t n_kept = run->out.n_rows / run->pieces.size * run->pieces.size; /* rows of complete pieces */
    abandon_outputs();
    if (n_kept)
        report(exit_code, "%zu of %zu rows are in %s; --resume continues with them", n_kept, run->list->n,
               run->pieces.folder);
}

/* Close the output, report how many rows are written or failed, and return the exit code. */
static int conclude(batch_run *run, int exit_code) {
    end_progress();
    run->is_complete = exit_code == EXIT_OK;
    batch_summary summary =
        make_batch_summary(run->form.model, &run->form.gate, run->list_name, run->out.n_rows, run->out.notes);
    if (run->n_worst)
        summary.n_shown = nqm_smaller(summary.n_rows, (size_t)run->n_worst);
    if (run->is_complete) {
        write_batch_summary(&summary, run->junit, print_batch_junit);
        write_batch_summary(&summary, run->markdown, print_batch_markdown);
    }
    if (!run->is_complete && is_batch_file(&run->out)) {
        give_up_file(run, exit_code);
    } else {
        size_t *order = run->is_sorted ? order_batch_rows(summary.n_rows, summary.notes, run->is_best) : NULL;
        close_batch_output(&run->out, &run->form, summary.n_shown, order);
        free(order);
    }
    free(summary.order);
    if (!run->is_complete)
        return exit_code;
    if (run->out.n_failed)
        exit_code = report(EXIT_PARTIAL, "%zu of %zu rows have no score", run->out.n_failed, run->list->n);
    if (summary.n_skipped)
        report(EXIT_OK, "%zu of %zu rows are skipped: both materials are refused alike", summary.n_skipped,
               run->list->n);
    return report_gate(&run->form.gate, summary.n_gated, run->list->n, exit_code);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

typedef struct batch_arguments {
    const char *list, *output, *model, *metrics, *root, *junit, *markdown, *sort, *work;
    bool resume, json, json_lines;
} batch_arguments;

static bool is_standard(const char *path) {
    return path && strcmp(path, "-") == 0;
}

static void check_usage(const batch_arguments *a, ranks r) {
    if (a->work)
        require_folder_name("--work", a->work, ".csv|.jsonl|.json|.ndjson", "finished pieces of the list");
    if ((!a->output || is_standard(a->output)) + is_standard(a->junit) + is_standard(a->markdown) > 1)
        stop(EXIT_USAGE, "two results cannot both go to standard output: give -o FILE");
    if (r.count > 1 && !a->work)
        stop(EXIT_USAGE, "%zu processes need a shared folder: --work DIR", r.count);
    if (r.count > 1 && *stream_name(a->list, &(size_t){0}))
        stop(EXIT_USAGE, "%zu processes cannot read the list from standard input: give a file", r.count);
}

static void open_inputs(batch_run *run, const batch_arguments *a) {
    nqm_model *model = open_model(a->model);
    check_gate(&run->form.gate, model);
    must(nqm_pairs_read(a->list, &run->given, &fault));
    run->scorer = open_scorer(model, &run->options);
    const char *stream = stream_name(a->list, &(size_t){0});
    run->list_name = *stream ? stream : a->list;
    run->form.list = run->given;
    run->form.model = model;
    run->form.terms = (remark_terms){model, run->options.invalid};
    set_batch_columns(&run->form);
}

/* Paths of list and outputs are relative to the working folder, paths of BRDFs to the root, which becomes the working folder. */
static void enter_root(batch_run *run, const batch_arguments *a) {
    run->path = absolute_path(a->output ? a->output : "-", "");
    run->work = a->work ? absolute_path(a->work, "") : NULL;
    run->junit = a->junit ? absolute_path(a->junit, "") : NULL;
    run->markdown = a->markdown ? absolute_path(a->markdown, "") : NULL;
    enter_list_root(a->root, a->list);
}

/* Ranks above 0 have no outputs. */
static void open_outputs(batch_run *run, bool resume, ranks r) {
    json_t *terms = score_terms(run);
    batch_pieces *p = &run->pieces;
    *p = (batch_pieces){.list = run->list,
                        .scorer = run->scorer,
                        .model = run->form.model,
                        .near_only = !run->form.has_textures,
                        .folder = run->work,
                        .is_shared = run->work != NULL};
    if (r.rank == 0) {
        open_batch_output(run->path, &run->form, run->is_sorted, &run->out);
        if (resume && !is_batch_file(&run->out))
            stop(EXIT_USAGE, "--resume needs a file: -o FILE");
        if (!p->folder && is_batch_file(&run->out))
            p->folder = absolute_path(run->path, ".pieces");
    }
    open_batch_pieces(p, terms, resume);
    json_decref(terms);
}

static batch_run run;
static batch_arguments a = {.model = "default", .metrics = "", .sort = "list"};
static uint64_t cache_mb;

static const option options[] = {
    {"output", 'o', OPTION_TEXT, &a.output, "FILE.csv|.jsonl|.json|.ndjson", "instead of standard output", 0, 0},
    {"resume", 0, OPTION_FLAG, &a.resume, NULL, "continue what a stopped run has left of FILE", 0, 0},
    {"keep-going", 'k', OPTION_FLAG, &run.keep_going, NULL, "rows that fail do not end the run", 0, 0},
    OPTION_ROWS_GATE(&run.form.gate),
    {"junit", 0, OPTION_TEXT, &a.junit, "FILE.xml", "also write a JUnit report: one test case per pair", 0, 0},
    {"markdown", 0, OPTION_TEXT, &a.markdown, "FILE.md", "also write a table in Markdown, worst first; -: stdout", 0,
     0},
    {"sort", 0, OPTION_TEXT, &a.sort, "WORD", "order of the rows: list, worst or best", 0, 0},
    {"worst", 0, OPTION_COUNT, &run.n_worst, "N", "write the N worst rows only, worst first; 0: all", 0, 1e15},
    OPTION_ROWS_MODEL(&a.model),
    OPTION_ROW_IGNORE,
    {"textures", 0, OPTION_FLAG, &run.form.has_textures, NULL,
     "of pairs with image maps, the columns median_jod, worst_jod, below_9, below_8, far_jod, far_jod_low and "
     "far_jod_high, too",
     0, 0},
    {"metrics", 0, OPTION_TEXT, &a.metrics, "LIST", "scalar metrics to add: all, or names with commas", 0, 0},
    {"root", 0, OPTION_TEXT, &a.root, "DIR", "folder of relative paths in the list (default: the list's folder)", 0, 0},
    {"cache", 0, OPTION_COUNT, &cache_mb, "MB", "memory for BRDFs that may be needed again", 0, 1 << 20},
    {"json", 0, OPTION_FLAG, &a.json, NULL, "write one JSON document", 0, 0},
    {"jsonl", 0, OPTION_FLAG, &a.json_lines, NULL, "write JSON Lines", 0, 0},
    {"work", 0, OPTION_TEXT, &a.work, "DIR", "folder of finished pieces, which several processes share", 0, 0},
    {0}};

static const command cmd = {
    .usage = "LIST [options]",
    .about = "Score the pairs of LIST, in its order: CSV with the columns reference and test, or JSON Lines with "
             "these members, or - for standard input; further columns are copied. A test that is a file of several "
             "materials means all of them, and for such a reference those of the same names. Results are written "
             "while they are made. The first row that fails ends the run, unless --keep-going is given. --resume "
             "continues a run that was stopped, for whatever reason; the file is the same in the end. Started by "
             "mpirun or srun, all processes share the work; all of them need access to the --work folder.",
    .example = "nqm batch pairs.csv -o scores.csv\nnqm batch pairs.csv -o scores.csv --resume --keep-going\n"
               "find fits -name '*.binary' | awk 'BEGIN{print \"reference,test\"} {print \"nickel.binary,\" $0}' |\n"
               "    nqm batch - --jsonl",
    .options = options,
    .table = &nqm_score_option_table,
    .table_target = &run.options,
    .min_arguments = 1,
};

int cmd_batch(int argc, char **argv) {
    ranks r = my_ranks();
    run.options = nqm_score_options_default();
    cache_mb = run.options.cache_bytes >> 20;
    parse_arguments(&cmd, argc, argv);
    a.list = argv[0];
    check_usage(&a, r);
    if (r.rank > 0)
        set_progress(PROGRESS_NONE);
    run.form.format = choose_format(a.json, a.json_lines, a.output);
    run.options.cache_bytes = (size_t)cache_mb << 20;
    choose_order(&run, a.sort);
    choose_metrics(a.metrics, run.form.metrics);
    run.options.metrics = *a.metrics != 0;
    open_inputs(&run, &a);
    enter_root(&run, &a);
    run.form.list = run.list =
        expand_pairs(run.given); /* before the outputs are opened, which may hold rows of an earlier run */
    open_outputs(&run, a.resume, r);
    save_when_interrupted();
    int exit_code = run.pieces.is_shared ? share_batch_pieces(&run.pieces, r) : EXIT_OK;
    if (r.rank == 0)
        exit_code = conclude(&run, exit_code == EXIT_OK ? score_rows(&run) : exit_code);
    close_batch_pieces(&run.pieces, run.is_complete);
    nqm_scorer_free(run.scorer);
    nqm_pairs_free(run.list);
    nqm_pairs_free(run.given);
    nqm_model_free((nqm_model *)(uintptr_t)run.form.model);
    free(run.form.columns);
    free(run.path);
    free(run.junit);
    free(run.markdown);
    return exit_code;
}
