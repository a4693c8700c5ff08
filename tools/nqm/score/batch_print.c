/* SPDX-License-Identifier: MIT
 *
 * Rows of `nqm batch` as CSV, as JSON Lines and as one JSON document (doc/cli.md). The columns of the list come first,
 * unchanged.
 */
#include "nqm/rows.h"
#include "nqm/score/batch.h"
#include "nqm/show/html.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- columns ----------------------------------------------------------------------------------------------------- */

void set_batch_columns(batch_form *form) {
    const char *const *names = form->list->column;
    char *added;
    size_t n_added;
    form->columns = score_columns("", form->model, form->metrics, form->has_textures ? "" : NULL,
                                  has_gate(&form->gate) ? ",gate,warnings,error" : ",warnings,error");
    FILE *stream = open_text(&added, &n_added);
    fputs(nqm_model_has_parts(form->model) ? ",metrics,parts" : ",metrics", stream); /* members in JSON */
    print_csv_line(stream, form->columns, NULL, NULL);
    fclose(stream);
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
    json_t *object = json_result(&form->terms, &form->list->pair[row], form->metrics, &form->gate, r, err);
    for (size_t i = 0; form->has_textures && i < TEXTURE_NUMBERS; ++i)
        json_object_set_new(object, texture_columns[i], json_number(texture->v[i]));
    return object;
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

/* Texts of the list, then the columns of a result, or the headings of both. */
static void print_csv_head(const batch_form *form, FILE *out) {
    for (size_t i = 0; i < form->list->n_columns; ++i) {
        fputs(i ? "," : "", out);
        print_csv_text(out, form->list->column[i]);
    }
    print_csv_line(out, form->columns, NULL, NULL);
}

static void print_csv_cells(const batch_form *form, FILE *out, size_t row) {
    const nqm_pair_list *list = form->list;
    const size_t n_cells = nqm_pair_list_cells(list, row);
    for (size_t column = 0; column < list->n_columns; ++column) {
        fputs(column ? "," : "", out);
        for (size_t i = list->csv ? column : 0; i < n_cells; ++i) { /* a row of a CSV has all columns */
            const nqm_list_cell cell = nqm_pair_list_cell(list, row, i);
            if (cell.column != column)
                continue;
            print_csv_text(out, cell.text);
            break;
        }
    }
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

/* Print `value` and release it. */
static void print_json_value(FILE *out, json_t *value) {
    json_dumpf(value, out, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
    json_decref(value);
}

static void print_json_cells(const batch_form *form, FILE *out, size_t row) {
    const nqm_pair_list *list = form->list;
    const size_t n_cells = nqm_pair_list_cells(list, row);
    for (size_t i = 0; i < n_cells; ++i) {
        const nqm_list_cell cell = nqm_pair_list_cell(list, row, i);
        print_json_value(out, json_name(list->column[cell.column]));
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

/* ---- notes ------------------------------------------------------------------------------------------------------- */

static batch_note make_batch_note(const batch_form *form, size_t row, const nqm_score_result *r, const nqm_error *err) {
    batch_note note = {r->jod, r->jod_low, r->jod_high, r->delta_e, r->novelty, .is_identical = r->identical};
    note.is_scored = r->status == NQM_OK;
    note.is_skipped = !note.is_scored && has_same_refusal(&form->list->pair[row]);
    json_t *remarks = json_remarks(&form->terms, &form->list->pair[row], "reference", "test", r);
    if (!note.is_scored)
        note.remark = strdup(err->message);
    else if (json_array_size(remarks))
        note.remark = join_texts(remarks);
    json_decref(remarks);
    return note;
}

/* The members of a result that a note has; the others are 0. */
static nqm_score_result noted_result(const batch_note *note) {
    nqm_score_result r = {.status = note->is_scored ? NQM_OK : NQM_ERR_NUMERIC, .identical = note->is_identical};
    r.jod = note->jod;
    r.jod_low = note->jod_low;
    r.jod_high = note->jod_high;
    r.delta_e = note->delta_e;
    r.novelty = note->novelty;
    return r;
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

static _Noreturn void stop_write(const batch_output *out) {
    stop(EXIT_OPEN, "%s: cannot write: %s", out->file.file.path ? out->file.file.path : "standard output",
         strerror(errno));
}

void open_batch_output(const char *path, const batch_form *form, bool is_sorted, batch_output *out) {
    *out = (batch_output){.max_rows = form->list->n_rows};
    open_output(path, &out->file);
    out->notes = allocate(out->max_rows, sizeof *out->notes);
    out->rows = is_sorted ? tmpfile() : out->file.stream;
    if (!out->rows)
        stop(EXIT_OPEN, "there is no place for a temporary file: %s", strerror(errno));
    print_batch_head(form, out->file.stream);
}

bool is_batch_file(const batch_output *out) {
    return out->file.file.temporary != NULL;
}

bool write_batch_row(batch_output *out, const batch_form *form, const batch_pieces *pieces, size_t at,
                     bool keep_going) {
    const size_t row = out->n_rows;
    const bool is_sorted = out->rows != out->file.stream;
    batch_note *note = &out->notes[row];
    *note = make_batch_note(form, row, &pieces->results[at], &pieces->errors[at]);
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

void flush_batch_output(batch_output *out) {
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

void close_batch_output(batch_output *out, const batch_form *form, size_t n, const size_t *order) {
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

extern const char batch_junit[], batch_markdown[]; /* junit.xml, markdown.txt (cmake/embed_text.cmake) */

size_t *order_batch_rows(size_t n, const batch_note *notes, bool is_best) {
    double *keys = allocate(n, sizeof *keys);
    for (size_t row = 0; row < n; ++row)
        keys[row] = notes[row].is_scored ? notes[row].jod : -(double)INFINITY;
    size_t *order = order_by(n, keys, is_best ? -1 : 1);
    free(keys);
    return order;
}

batch_summary make_batch_summary(const batch_form *form, const char *list_name, size_t n_rows,
                                 const batch_note *notes) {
    batch_summary s = {.form = form, .list_name = list_name, .n_rows = n_rows, .notes = notes};
    s.order = order_batch_rows(s.n_rows, s.notes, false);
    s.n_shown = s.n_rows;
    for (size_t row = 0; row < s.n_rows; ++row) {
        const nqm_score_result r = noted_result(&s.notes[row]);
        s.n_skipped += s.notes[row].is_skipped;
        s.n_unscored += !s.notes[row].is_scored && !s.notes[row].is_skipped;
        s.n_gated += fails_gate(&form->gate, &r);
    }
    return s;
}

void summarise_rows(const score_run *run, const char *list_name, size_t n_shown, row_summary *s) {
    const size_t n = run->n_rows;
    *s = (row_summary){.list.n_rows = n};
    s->list.pair = allocate(n, sizeof *s->list.pair);
    s->notes = allocate(n, sizeof *s->notes);
    s->form = (batch_form){.list = &s->list,
                           .names = allocate(n, sizeof *s->form.names),
                           .model = run->model,
                           .gate = run->gate,
                           .terms = run->terms};
    for (size_t i = 0; i < n; ++i) {
        s->list.pair[i] = run->rows[i].pair;
        s->form.names[i] = run->rows[i].name;
        s->notes[i] = make_batch_note(&s->form, i, &run->rows[i].result, &run->rows[i].err);
    }
    s->summary = make_batch_summary(&s->form, list_name, n, s->notes);
    s->summary.n_shown = nqm_smaller(n, n_shown);
}

void free_row_summary(row_summary *s) {
    for (size_t i = 0; i < s->list.n_rows; ++i)
        free(s->notes[i].remark);
    free(s->list.pair);
    free(s->notes);
    free(s->form.names);
    free(s->summary.order);
}

static const char *test_name(const batch_form *form, size_t row) {
    return form->names && form->names[row] ? form->names[row] : form->list->pair[row].test;
}

/* ---- JUnit and Markdown ------------------------------------------------------------------------------------------ */

static json_t *json_case(const void *user, size_t row) {
    const batch_summary *s = user;
    const batch_note *note = &s->notes[row];
    const nqm_score_result r = noted_result(note);
    const bool is_error = !note->is_scored && !note->is_skipped;
    char verdict[VERDICT_TEXT];
    return json_row("reference:s test:s remark:s jod:f jod_low:f jod_high:f delta_e:f novelty:f verdict:s mark:s "
                    "is_skipped:b is_error:b "
                    "is_scored:b is_failure:b",
                    s->form->list->pair[row].ref, test_name(s->form, row), note->remark ? note->remark : "", r.jod,
                    r.jod_low, r.jod_high, r.delta_e, r.novelty, verdict_words(&r, verdict),
                    note->is_skipped           ? "skipped"
                    : is_error                 ? "ERROR"
                    : has_gate(&s->form->gate) ? gate_mark(&s->form->gate, &r)
                                               : "",
                    note->is_skipped, is_error, note->is_scored, note->is_scored && fails_gate(&s->form->gate, &r));
}

static json_t *json_shown_case(const void *user, size_t i) {
    const batch_summary *s = user;
    return json_case(s, s->order[i]);
}

static json_t *summary_json(const batch_summary *s) {
    const nqm_model_info info = nqm_model_get_info(s->form->model);
    char gate[GATE_TEXT];
    return json_row(
        "verb:s tests:z failures:z errors:z has_errors:b skipped:z has_skipped:b list:s version:s model:s sha256:s "
        "gate:s shown:z hidden:o",
        verb_name(), s->n_rows, s->n_gated, s->n_unscored, s->n_unscored > 0, s->n_skipped, s->n_skipped > 0,
        s->list_name, nqm_version(), info.id, info.sha256, gate_words(&s->form->gate, gate), s->n_shown,
        s->n_shown < s->n_rows ? json_sprintf("%zu", s->n_rows - s->n_shown) : NULL);
}

void print_batch_junit(const batch_summary *s, FILE *out) {
    fill_template(out, batch_junit, html_escape, summary_json(s), json_case, s);
}

/* A cell of a Markdown table: punctuation that has a meaning is escaped, line ends become blanks. */
static void put_cell(FILE *out, const char *text) {
    for (const char *p = text; *p; ++p) {
        if (strchr("\\`*_[]<>|~#&", *p))
            fputc('\\', out);
        fputc((unsigned char)*p < ' ' ? ' ' : *p, out);
    }
}

void print_batch_markdown(const batch_summary *s, FILE *out) {
    fill_template(out, batch_markdown, put_cell, summary_json(s), json_shown_case, s);
}

void write_batch_summary(const batch_summary *summary, const char *path,
                         void (*print)(const batch_summary *summary, FILE *out)) {
    output_file out;
    if (!path)
        return;
    open_output(path, &out);
    print(summary, out.stream);
    close_output(&out);
}
