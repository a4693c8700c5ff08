/* SPDX-License-Identifier: MIT
 *
 * All rows of `nqm batch` for other programs: a JUnit report, as continuous-integration systems read it
 * (https://github.com/testmoapp/junitxml describes the elements), and a table in Markdown.
 */
#include "nqm/score/batch.h"
#include "nqm/show/html.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

extern const char batch_junit[]; /* the text of junit.xml (cmake/embed_text.cmake) */

typedef struct placed_row {
    double jod;
    size_t row;
} placed_row;

static int by_jod(const void *a, const void *b) {
    const placed_row *x = a, *y = b;
    if (x->jod != y->jod)
        return x->jod < y->jod ? -1 : 1;
    return x->row < y->row ? -1 : 1;
}

size_t *order_batch_rows(size_t n, const batch_note *notes, bool is_best) {
    placed_row *placed = allocate(n, sizeof *placed);
    size_t *order = allocate(n, sizeof *order);
    const double sign = is_best ? -1 : 1;
    for (size_t row = 0; row < n; ++row)
        placed[row] = (placed_row){notes[row].is_scored ? sign * notes[row].jod : -sign * (double)INFINITY, row};
    qsort(placed, n, sizeof *placed, by_jod);
    for (size_t i = 0; i < n; ++i)
        order[i] = placed[i].row;
    free(placed);
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

/* ---- JUnit ------------------------------------------------------------------------------------------------------- */

/* "JOD 8.12, 95 % interval 7.90 to 8.31, Delta-E ITP 3.1, novelty 0.88, visible" */
static json_t *json_figures(const batch_note *note) {
    const nqm_score_result r = noted_result(note);
    char verdict[VERDICT_TEXT], *text;
    size_t n;
    FILE *out = open_text(&text, &n);
    fprintf(out, "JOD %.2f", note->jod);
    if (isfinite(note->jod_low))
        fprintf(out, ", 95 %% interval %.2f to %.2f", note->jod_low, note->jod_high);
    if (isfinite(note->delta_e))
        fprintf(out, ", Delta-E ITP %.3g", note->delta_e);
    if (isfinite(note->novelty))
        fprintf(out, ", novelty %.2f", note->novelty);
    fprintf(out, ", %s", verdict_words(&r, verdict));
    return html_text(out, &text);
}

static json_t *json_case(const void *user, size_t row) {
    const batch_summary *s = user;
    const batch_note *note = &s->notes[row];
    const nqm_score_result r = noted_result(note);
    return json_pack("{s:o,s:o,s:o,s:o,s:b,s:b,s:b,s:o}", "reference", json_name(s->form->list->pair[row].ref), "test",
                     json_name(test_name(s->form, row)), "remark", json_name(note->remark ? note->remark : ""), "jod",
                     html_number(note->jod, 2, 'f'), "is_skipped", note->is_skipped, "is_error",
                     !note->is_scored && !note->is_skipped, "is_failure",
                     note->is_scored && fails_gate(&s->form->gate, &r), "figures",
                     note->is_scored ? json_figures(note) : json_null());
}

void print_batch_junit(const batch_summary *s, FILE *out) {
    const nqm_model_info info = nqm_model_get_info(s->form->model);
    char gate[GATE_TEXT];
    html_fill(out, batch_junit,
              json_pack("{s:s,s:I,s:I,s:I,s:I,s:o,s:s,s:o,s:s,s:s}", "verb", verb_name(), "tests",
                        (json_int_t)s->n_rows, "failures", (json_int_t)s->n_gated, "errors", (json_int_t)s->n_unscored,
                        "skipped", (json_int_t)s->n_skipped, "list", json_name(s->list_name), "version", nqm_version(),
                        "model", json_name(info.id), "sha256", info.sha256, "gate", gate_words(&s->form->gate, gate)),
              json_case, s);
}

/* ---- Markdown ---------------------------------------------------------------------------------------------------- */

/* Write a cell of a Markdown table: escape punctuation that has a meaning, replace line ends by blanks. */
static void put_cell(FILE *out, const char *text) {
    json_t *utf8 = json_name(text);
    for (const char *p = utf8 ? json_string_value(utf8) : ""; *p; ++p) {
        if (strchr("\\`*_[]<>|~#&", *p))
            fputc('\\', out);
        fputc((unsigned char)*p < ' ' ? ' ' : *p, out);
    }
    json_decref(utf8);
}

static void put_heading(const batch_summary *s, FILE *out) {
    char text[GATE_TEXT];
    const bool is_gated = has_gate(&s->form->gate);
    fputs("### nqm: ", out);
    if (is_gated)
        fprintf(out, "%zu of ", s->n_gated);
    fprintf(out, "%zu pairs%s", s->n_rows, is_gated ? " FAIL" : "");
    if (s->n_unscored)
        fprintf(out, ", %zu without a score", s->n_unscored);
    if (s->n_skipped)
        fprintf(out, ", %zu skipped", s->n_skipped);
    fputs("\n\n", out);
    if (is_gated)
        fprintf(out, "Gate: %s. ", gate_words(&s->form->gate, text));
    fputs("Model: ", out);
    put_cell(out, nqm_model_get_info(s->form->model).id);
    fprintf(out, ", nqm %s. JOD 10: no visible difference.\n\n", nqm_version());
}

static void put_row(const batch_form *form, FILE *out, size_t row, const batch_note *note) {
    const nqm_score_result r = noted_result(note);
    char verdict[VERDICT_TEXT];
    fprintf(out, "| %s |",
            note->is_skipped        ? "skipped"
            : !note->is_scored      ? "ERROR"
            : has_gate(&form->gate) ? gate_mark(&form->gate, &r)
                                    : "");
    if (note->is_scored)
        fprintf(out, " %.2f", note->jod);
    fputs(" |", out);
    if (isfinite(note->jod_low))
        fprintf(out, " %.2f to %.2f", note->jod_low, note->jod_high);
    fprintf(out, " | %s | ", verdict_words(&r, verdict));
    put_cell(out, form->list->pair[row].ref);
    fputs(" | ", out);
    put_cell(out, test_name(form, row));
    fputs(" | ", out);
    put_cell(out, note->remark ? note->remark : "");
    fputs(" |\n", out);
}

void print_batch_markdown(const batch_summary *s, FILE *out) {
    put_heading(s, out);
    fputs("| | JOD | 95 % interval | verdict | reference | test | remarks |\n|---|---:|---|---|---|---|---|\n", out);
    for (size_t i = 0; i < s->n_shown; ++i)
        put_row(s->form, out, s->order[i], &s->notes[s->order[i]]);
    if (s->n_shown < s->n_rows)
        fprintf(out, "\n%zu more pairs are not shown.\n", s->n_rows - s->n_shown);
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
