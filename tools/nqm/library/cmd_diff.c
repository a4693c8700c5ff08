/* SPDX-License-Identifier: MIT
 *
 * nqm diff - two versions of the materials of a file or folder: pairs of the same name, and of names that only one
 * version has those that look the same; how each pair looks, and which properties changed. Also as a program that git
 * calls for its differences.
 */
#include "nqm/score/batch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of GIT_EXTERNAL_DIFF: path, old file, its hash and mode, new file, its hash and mode; of a renamed file also its new path and what
 * git says of the two. */
enum { GIT_ARGUMENTS = 7, GIT_RENAME_ARGUMENTS = 9 };

static score_run run;
static nqm_library *before, *after;
static const nqm_library_pair *pairs; /* those with both versions first: the rows of the run */
static size_t n_found;
static const char *model = "default", *junit, *markdown;
static char *old_path, *new_path;

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static const char *old_key(size_t row) {
    return before->members[pairs[row].ref].key;
}

static bool is_renamed(size_t row) {
    return strcmp(old_key(row), run.rows[row].name) != 0;
}

/* Whether the material looks different, or a property changed that is not seen. Another name is no change. */
static bool is_changed(size_t row) {
    const scored_pair *r = &run.rows[row];
    return !pairs[row].is_refused_alike &&
           (r->err.status != NQM_OK || !r->result.identical || pairs[row].n_changes > 0);
}

static size_t count_changed(void) {
    size_t n = 0;
    for (size_t i = 0; i < run.n_rows; ++i)
        n += is_changed(i);
    return n;
}

/* Rows that have another name only. */
static size_t count_renamed(void) {
    size_t n = 0;
    for (size_t i = 0; i < run.n_rows; ++i)
        n += is_renamed(i) && !is_changed(i);
    return n;
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

/* Call print with each member that only one version has. */
static size_t each_single(bool is_added, void (*print)(void *user, const char *key), void *user) {
    size_t n = 0;
    for (size_t i = run.n_rows; i < n_found; ++i)
        if ((pairs[i].ref == SIZE_MAX) == is_added) {
            print(user, is_added ? after->members[pairs[i].test].key : before->members[pairs[i].ref].key);
            ++n;
        }
    return n;
}

static void append_key(void *list, const char *key) {
    json_array_append_new(list, json_name(key));
}

static void print_added(void *word, const char *key) {
    printf("  %-7s %s\n", (const char *)word, shown(key));
}

static void print_value(const nqm_library_value *value, FILE *to) {
    if (value->text || value->n == 0)
        fputs(value->text ? shown(value->text) : "default", to);
    for (size_t c = 0; !value->text && c < value->n; ++c)
        fprintf(to, "%s%.4g", c ? "," : "", value->v[c]);
}

static json_t *json_value(const nqm_library_value *value) {
    if (value->text || value->n == 0)
        return value->text ? json_name(value->text) : json_null();
    json_t *list = json_array();
    for (size_t c = 0; c < value->n; ++c)
        json_array_append_new(list, json_number(value->v[c]));
    json_t *first = value->n == 1 ? json_incref(json_array_get(list, 0)) : NULL;
    if (first)
        json_decref(list);
    return first ? first : list;
}

static json_t *json_changes(const nqm_library_pair *pair) {
    json_t *list = json_array();
    for (size_t k = 0; k < pair->n_changes; ++k)
        json_array_append_new(list,
                              json_row("property:s old:o new:o", pair->changes[k].property,
                                       json_value(&pair->changes[k].before), json_value(&pair->changes[k].after)));
    return list;
}

/* What changed of a row: words of its look, properties, the old name. free() it. */
static char *describe_row(size_t i) {
    const scored_pair *row = &run.rows[i];
    const nqm_label_info info = nqm_label_get_info(&row->result.parts);
    const bool differs = row->err.status == NQM_OK && !row->result.identical && !isnan(row->result.parts.structure);
    const char *words = differs ? info.words : "";
    char *text;
    size_t n;
    FILE *to = open_text(&text, &n);
    fputs(words, to);
    for (size_t k = 0; k < pairs[i].n_changes; ++k) {
        const nqm_library_change *change = &pairs[i].changes[k];
        fprintf(to, "%s%s ", k ? ", " : *words ? "; " : "", change->property);
        print_value(&change->before, to);
        fputs(" -> ", to);
        print_value(&change->after, to);
    }
    if (is_renamed(i))
        fprintf(to, "%swas %s", *words || pairs[i].n_changes ? "; " : "", shown(old_key(i)));
    close_text(to, &text, &n);
    return text;
}

static void print_text(void) {
    const bool is_calibrated = *nqm_model_get_info(run.model).calibration;
    char verdict[NQM_VERDICT_TEXT];
    printf("old    %s\nnew    %s\nmodel  %s\n\n", shown(old_path), shown(new_path),
           shown(nqm_model_get_info(run.model).id));
    for (size_t i = 0; i < run.n_rows; ++i) {
        const scored_pair *row = &run.rows[i];
        if (!is_changed(i) && !is_renamed(i))
            continue;
        print_jod(row, is_calibrated);
        printf("  %s  %s\n", shown(row->name),
               row->err.status == NQM_OK ? nqm_verdict(&row->result, verdict) : "no score");
        char *text = describe_row(i);
        if (*text)
            print_phrases(text);
        free(text);
        if (row->texture)
            print_texture(row);
    }
    const size_t n_added = each_single(true, print_added, (void *)(uintptr_t) "added");
    const size_t n_removed = each_single(false, print_added, (void *)(uintptr_t) "removed");
    const size_t n_changed = count_changed(), n_renamed = count_renamed();
    printf("%s%zu changed, %zu added, %zu removed, %zu renamed, %zu unchanged\n",
           n_changed + n_added + n_removed + n_renamed ? "\n" : "", n_changed, n_added, n_removed, n_renamed,
           run.n_rows - n_changed - n_renamed);
}

static void print_diff_json(void) {
    run.ref_path = old_path;
    json_t *document = json_scores(&run), *row, *added = json_array(), *removed = json_array();
    size_t i;
    json_array_foreach(json_object_get(document, "results"), i, row) {
        json_set(row, "changed:b properties:o was:s", is_changed(i), json_changes(&pairs[i]),
                 is_renamed(i) ? old_key(i) : NULL);
    }
    each_single(true, append_key, added);
    each_single(false, append_key, removed);
    print_json(json_set(document, "new:s added:o removed:o", new_path, added, removed));
}

/* The summary files of `nqm batch`, of the same rows. */
static void write_summaries(void) {
    row_summary s;
    summarise_rows(&run, new_path, run.n_rows, &s);
    for (size_t i = 0; i < run.n_rows; ++i) {
        char *text = describe_row(i), *remark = s.notes[i].remark;
        const size_t n_text = strlen(text) + (remark ? strlen(remark) : 0) + 3;
        s.notes[i].remark = allocate(n_text, 1);
        snprintf(s.notes[i].remark, n_text, "%s%s%s", text, remark && *text ? "; " : "", remark ? remark : "");
        free(text);
        free(remark);
    }
    s.summary.n_shown = count_changed() + s.summary.n_skipped;
    write_batch_summary(&s.summary, junit, print_batch_junit);
    write_batch_summary(&s.summary, markdown, print_batch_markdown);
    free_row_summary(&s);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const option options[] = {
    OPTION_ROWS_GATE(&run.gate),
    {"junit", 0, OPTION_TEXT, &junit, "FILE.xml", "also write a JUnit report: one test case per material", 0, 0},
    {"markdown", 0, OPTION_TEXT, &markdown, "FILE.md", "also write a table in Markdown, worst first", 0, 0},
    OPTION_ROWS_MODEL(&model),
    OPTION_ROW_IGNORE,
    {"json", 0, OPTION_FORMAT, &run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"quiet", 'q', OPTION_FORMAT, &run.format, NULL, "print the names of changed materials only", FORMAT_QUIET, 0},
    {0}};

static const command cmd = {
    .usage = "OLD NEW [options]",
    .about = "How the materials of a file or folder changed: pairs of the same name, worst first, with JOD, words and"
             " the properties that changed; added and removed ones; and renamed ones, which look the same (JOD 9.5). "
             "OLD or NEW may be /dev/null. git can call it for its differences (doc/ci.md): the seven arguments of "
             "GIT_EXTERNAL_DIFF, and nine for a renamed file, are understood.",
    .example = "nqm diff old.gltf new.gltf\nnqm diff before/materials materials --fail-under 9 --junit junit.xml\n"
               "nqm diff scene.glb /dev/null --json",
    .options = options,
    .table = &nqm_score_option_table,
    .table_target = &run.options,
    .min_arguments = 2,
    .max_arguments = GIT_RENAME_ARGUMENTS,
};

static void print_results(void) {
    if (run.format == FORMAT_JSON)
        print_diff_json();
    else if (run.format == FORMAT_TEXT)
        print_text();
    for (size_t i = 0; run.format == FORMAT_QUIET && i < run.n_rows; ++i)
        if (is_changed(i))
            puts(shown(run.rows[i].name));
}

/* Report faults and the gate. Returns the exit code. */
static int conclude(void) {
    int exit_code = EXIT_OK;
    size_t n_skipped = 0;
    for (size_t i = 0; i < run.n_rows; ++i) {
        n_skipped += (size_t)pairs[i].is_refused_alike;
        if (run.rows[i].err.status == NQM_OK || pairs[i].is_refused_alike)
            continue;
        const int code = report_error(&run.rows[i].err);
        exit_code = exit_code == EXIT_OK ? code : exit_code;
    }
    if (n_skipped)
        report(EXIT_OK, "%zu material%s refused in both versions for the same reason; `nqm info` says why", n_skipped,
               n_skipped > 1 ? "s are" : " is");
    if (exit_code == EXIT_OK && before->n_failed + after->n_failed > 0)
        exit_code = EXIT_PARTIAL;
    return apply_gate(&run, exit_code);
}

static void find_pairs(const char *old, const char *new) {
    size_t n = 0;
    before = open_library(1, &old, &run, NULL);
    after = open_library(1, &new, &run, NULL);
    must(nqm_library_diff(before, after, &n_found, &pairs, &fault));
    end_progress();
    while (n < n_found && pairs[n].ref != SIZE_MAX && pairs[n].test != SIZE_MAX)
        ++n;
    set_library_rows(&run, n, pairs, after);
}

int cmd_diff(int argc, char **argv) {
    run.options = plain_score_options();
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    const bool is_renamed = n_arguments == GIT_RENAME_ARGUMENTS, is_git = is_renamed || n_arguments == GIT_ARGUMENTS;
    if (n_arguments != 2 && !is_git)
        stop(EXIT_USAGE, "give two files or folders, or the %d or %d arguments of GIT_EXTERNAL_DIFF", GIT_ARGUMENTS,
             GIT_RENAME_ARGUMENTS);
    old_path = argv[is_git ? 1 : 0];
    new_path = argv[is_git ? 4 : 1];
    run.model = open_model(model);
    check_gate(&run.gate, run.model);
    find_pairs(old_path, new_path);
    if (is_git) { /* the files are copies without the name of the path */
        old_path = argv[0];
        new_path = argv[is_renamed ? 7 : 0];
    }
    print_results();
    if (junit || markdown)
        write_summaries();
    const int exit_code = conclude();
    nqm_library_free(before);
    nqm_library_free(after);
    free(run.rows);
    nqm_model_free(run.model);
    return is_git ? EXIT_OK : exit_code; /* git stops at another one */
}
