/* SPDX-License-Identifier: MIT
 *
 * nqm diff - two versions of the materials of a file or folder: pairs of the same name, and of names that only one
 * version has those that look the same; how each pair looks, and which properties changed. Also as a program that git
 * calls for its differences.
 */
#include "nqm/library/library.h"
#include "nqm/score/batch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of GIT_EXTERNAL_DIFF: path, old file, its hash and mode, new file, its hash and mode; of a renamed file also its new path and what
 * git says of the two. */
enum { GIT_ARGUMENTS = 7, GIT_RENAME_ARGUMENTS = 9 };

/* The versions and what became of their members. */
typedef struct versions {
    library old, new;
    size_t *partner;    /* (old.n) number of the new one; SIZE_MAX: it is gone */
    bool *is_partner;   /* (new.n) */
    size_t n_pairs;     /* rows of the run */
    size_t *old_of_row; /* (n_pairs) */
    json_t **changes;   /* (n_pairs) of list_changes() */
} versions;

static score_run run;
static versions v;
static const char *model = "default", *junit, *markdown;
static char *old_path, *new_path;

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* The key of a member of the new version, given by its number. */
static int compare_key(const void *key, const void *number) {
    return strcmp(key, v.new.members[*(const size_t *)number].key);
}

static int by_key(const void *a, const void *b) {
    return compare_key(v.new.members[*(const size_t *)a].key, b);
}

static void pair_names(void) {
    if (v.old.n == 1 && v.new.n == 1 && !is_folder(v.old.path)) { /* files of one material, whatever it is called */
        v.partner[0] = 0;
        v.is_partner[0] = true;
        return;
    }
    size_t *order = allocate(v.new.n, sizeof *order);
    for (size_t i = 0; i < v.new.n; ++i)
        order[i] = i;
    qsort(order, v.new.n, sizeof *order, by_key);
    for (size_t i = 0; i < v.old.n; ++i) {
        const size_t *same = bsearch(v.old.members[i].key, order, v.new.n, sizeof *order, compare_key);
        v.partner[i] = same && !v.is_partner[*same] ? *same : SIZE_MAX;
        if (v.partner[i] != SIZE_MAX)
            v.is_partner[*same] = true;
    }
    free(order);
}

/* Whether only its version has a member. */
static bool is_single(bool is_new, size_t i) {
    return is_new ? !v.is_partner[i] : v.partner[i] == SIZE_MAX;
}

/* The members that only one version has, with pictures. from (n) receives their numbers. */
static library take_single(bool is_new, nqm_scorer *scorer, size_t *from) {
    const library *of = is_new ? &v.new : &v.old;
    library single = {.path = of->path, .members = must_have(nqm_alloc(of->n ? of->n : 1, sizeof(member)))};
    for (size_t i = 0; i < of->n; ++i)
        if (is_single(is_new, i) && !of->members[i].is_left_out) {
            from[single.n] = i;
            single.members[single.n++] = of->members[i];
        }
    must(nqm_gallery_create(run.model, single.n, NULL, &single.gallery, &fault));
    for (size_t i = 0; i < single.n; ++i) {
        nqm_error failure;
        step_progress("sample", i, single.n);
        draw_member(&single.members[i], run.model, scorer, single.gallery, i, &failure);
        single.members[i].is_left_out = failure.status != NQM_OK;
    }
    return single;
}

/* Of names that only one version has, those that look the same are the same material: the best estimates first,
 * confirmed by score. */
static void pair_looks(void) {
    static const double same = 9.5;
    size_t n_paired = 0;
    for (size_t i = 0; i < v.old.n; ++i)
        n_paired += v.partner[i] != SIZE_MAX;
    if (n_paired == v.old.n || n_paired == v.new.n || nqm_gallery_size(run.model) == 0)
        return;
    size_t *old_from = allocate(v.old.n, sizeof *old_from), *new_from = allocate(v.new.n, sizeof *new_from);
    nqm_scorer *scorer = open_scorer(run.model, &run.options);
    library old = take_single(false, scorer, old_from);
    library new = take_single(true, scorer, new_from);
    float *jod = allocate(new.n, sizeof *jod);
    for (size_t i = 0; i < old.n; ++i) {
        size_t best = SIZE_MAX;
        step_progress("compare", i, old.n);
        if (old.members[i].is_left_out)
            continue;
        nqm_gallery_jods(old.gallery, i, new.gallery, 0, new.n, false, jod);
        for (size_t k = 0; k < new.n; ++k)
            if (!new.members[k].is_left_out && !v.is_partner[new_from[k]] && (best == SIZE_MAX || jod[k] > jod[best]))
                best = k;
        if (best == SIZE_MAX || (double)jod[best] < least_estimate(same))
            continue;
        const nqm_named_pair pair = {old.members[i].argument, new.members[best].argument};
        nqm_score_result r;
        if (old.members[i].is_textured || new.members[best].is_textured)
            r.jod = score_textured(&pair, run.model);
        else
            must(nqm_scorer_run_named(scorer, 1, &pair, &r, NULL, &fault));
        if (!(r.jod >= same))
            continue;
        v.partner[old_from[i]] = new_from[best];
        v.is_partner[new_from[best]] = true;
    }
    end_progress();
    free(jod);
    free(old_from);
    free(new_from);
    nqm_gallery_free(old.gallery); /* the texts are those of the versions */
    nqm_gallery_free(new.gallery);
    nqm_free(old.members);
    nqm_free(new.members);
    nqm_scorer_free(scorer);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static int worst_first(const void *a, const void *b) {
    const scored_pair *x = a, *y = b;
    const bool has_x = x->err.status == NQM_OK, has_y = y->err.status == NQM_OK;
    if (has_x != has_y)
        return has_x ? 1 : -1;
    if (has_x && x->result.jod != y->result.jod)
        return x->result.jod < y->result.jod ? -1 : 1;
    return x->order < y->order ? -1 : 1;
}

static void score_versions(void) {
    size_t n = 0, *old_of_pair = allocate(v.old.n, sizeof *old_of_pair);
    begin_rows(&run, v.old.n);
    for (size_t i = 0; i < v.old.n; ++i)
        if (v.partner[i] != SIZE_MAX) {
            const member *new = &v.new.members[v.partner[i]];
            run.rows[n] = (scored_pair){.pair = {v.old.members[i].argument, new->argument}, .name = new->key};
            old_of_pair[n++] = i;
        }
    run.n_rows = n;
    make_scores(&run);
    qsort(run.rows, n, sizeof *run.rows, worst_first);
    v.n_pairs = n;
    v.old_of_row = allocate(n, sizeof *v.old_of_row);
    v.changes = allocate(n, sizeof *v.changes);
    for (size_t i = 0; i < n; ++i) {
        v.old_of_row[i] = old_of_pair[run.rows[i].order];
        v.changes[i] = list_changes(&run.rows[i].pair);
    }
    free(old_of_pair);
}

static const char *old_key(size_t row) {
    return v.old.members[v.old_of_row[row]].key;
}

static bool is_renamed(size_t row) {
    return strcmp(old_key(row), run.rows[row].name) != 0;
}

/* Both versions are refused for the same property, value and reason. */
static bool is_skipped(size_t row) {
    return run.rows[row].err.status != NQM_OK && has_same_refusal(&run.rows[row].pair);
}

/* Whether the material looks different, or a property changed that is not seen. Another name is no change. */
static bool is_changed(size_t row) {
    const scored_pair *r = &run.rows[row];
    return !is_skipped(row) && (r->err.status != NQM_OK || !r->result.identical || json_array_size(v.changes[row]));
}

static size_t count_changed(void) {
    size_t n = 0;
    for (size_t i = 0; i < v.n_pairs; ++i)
        n += is_changed(i);
    return n;
}

/* Rows that have another name only. */
static size_t count_renamed(void) {
    size_t n = 0;
    for (size_t i = 0; i < v.n_pairs; ++i)
        n += is_renamed(i) && !is_changed(i);
    return n;
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

/* Call print with each member that only one version has. */
static size_t each_single(bool is_added, void (*print)(void *user, const char *key), void *user) {
    const library *of = is_added ? &v.new : &v.old;
    size_t n = 0;
    for (size_t i = 0; i < of->n; ++i)
        if (is_single(is_added, i)) {
            print(user, of->members[i].key);
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

/* What changed of a row: words of its look, properties, the old name. free() it. */
static char *describe_row(size_t i) {
    const scored_pair *row = &run.rows[i];
    char words[NQM_LABEL_TEXT] = "", *text;
    size_t n;
    FILE *to = open_text(&text, &n);
    if (row->err.status == NQM_OK && !row->result.identical && !isnan(row->result.parts.structure))
        nqm_label_describe(&row->result.parts, words);
    fputs(words, to);
    json_t *change;
    size_t k;
    json_array_foreach(v.changes[i], k, change) {
        fprintf(to, "%s%s ", k ? ", " : *words ? "; " : "", json_string_value(json_object_get(change, "property")));
        print_value(json_object_get(change, "old"), to);
        fputs(" -> ", to);
        print_value(json_object_get(change, "new"), to);
    }
    if (is_renamed(i))
        fprintf(to, "%swas %s", *words || k ? "; " : "", shown(old_key(i)));
    fclose(to);
    return text;
}

static void print_text(void) {
    const bool is_calibrated = *nqm_model_get_info(run.model).calibration;
    char verdict[NQM_VERDICT_TEXT];
    printf("old    %s\nnew    %s\nmodel  %s\n\n", shown(old_path), shown(new_path),
           shown(nqm_model_get_info(run.model).id));
    for (size_t i = 0; i < v.n_pairs; ++i) {
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
           v.n_pairs - n_changed - n_renamed);
}

static void print_diff_json(void) {
    run.ref_path = old_path;
    json_t *document = json_scores(&run), *row, *added = json_array(), *removed = json_array();
    size_t i;
    json_array_foreach(json_object_get(document, "results"), i, row) {
        json_set(row, "changed:b properties:O was:s", is_changed(i), v.changes[i], is_renamed(i) ? old_key(i) : NULL);
    }
    each_single(true, append_key, added);
    each_single(false, append_key, removed);
    print_json(json_set(document, "new:s added:o removed:o", new_path, added, removed));
}

/* The summary files of `nqm batch`, of the same rows. */
static void write_summaries(void) {
    row_summary s;
    summarise_rows(&run, new_path, v.n_pairs, &s);
    for (size_t i = 0; i < v.n_pairs; ++i) {
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
    for (size_t i = 0; run.format == FORMAT_QUIET && i < v.n_pairs; ++i)
        if (is_changed(i))
            puts(shown(run.rows[i].name));
}

/* Report faults and the gate. Returns the exit code. */
static int conclude(void) {
    int exit_code = EXIT_OK;
    size_t n_skipped = 0;
    for (size_t i = 0; i < run.n_rows; ++i) {
        n_skipped += is_skipped(i);
        if (run.rows[i].err.status == NQM_OK || is_skipped(i))
            continue;
        const int code = report_error(&run.rows[i].err);
        exit_code = exit_code == EXIT_OK ? code : exit_code;
    }
    if (n_skipped)
        report(EXIT_OK, "%zu material%s refused in both versions for the same reason; `nqm info` says why", n_skipped,
               n_skipped > 1 ? "s are" : " is");
    if (exit_code == EXIT_OK && v.old.n_failed + v.new.n_failed > 0)
        exit_code = EXIT_PARTIAL;
    return apply_gate(&run, exit_code);
}

static void free_versions(void) {
    for (size_t i = 0; i < v.n_pairs; ++i)
        json_decref(v.changes[i]);
    free(v.changes);
    free(v.old_of_row);
    free(v.partner);
    free(v.is_partner);
    free_library(&v.old);
    free_library(&v.new);
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
    list_library(old_path, &v.old);
    list_library(new_path, &v.new);
    v.partner = allocate(v.old.n, sizeof *v.partner);
    v.is_partner = allocate(v.new.n, sizeof *v.is_partner);
    if (is_git) { /* the files are copies without the name of the path */
        old_path = argv[0];
        new_path = argv[is_renamed ? 7 : 0];
    }
    pair_names();
    pair_looks();
    score_versions();
    print_results();
    if (junit || markdown)
        write_summaries();
    const int exit_code = conclude();
    free_versions();
    free_scores(&run);
    return is_git ? EXIT_OK : exit_code; /* git stops at another one */
}
