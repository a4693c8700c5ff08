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

static const char *test_name(const batch_form *form, size_t row) {
    return form->names && form->names[row] ? form->names[row] : form->list->pair[row].test;
}

/* ---- JUnit ------------------------------------------------------------------------------------------------------- */

static void put_property(FILE *out, const char *name, const char *value) {
    html(out, "<property name='%s' value='%s'/>\n", name, value);
}

static void put_properties(const batch_form *form, FILE *out) {
    const nqm_model_info info = nqm_model_get_info(form->model);
    char text[GATE_TEXT];
    fputs("<properties>\n", out);
    put_property(out, "nqm", nqm_version());
    put_property(out, "model", info.id);
    put_property(out, "model sha256", info.sha256);
    if (has_gate(&form->gate))
        put_property(out, "gate", gate_words(&form->gate, text));
    fputs("</properties>\n", out);
}

/* "JOD 8.12, 95 % interval 7.90 to 8.31, Delta-E ITP 3.1, novelty 0.88, visible" */
static void put_figures(FILE *out, const batch_note *note) {
    const nqm_score_result r = noted_result(note);
    char verdict[VERDICT_TEXT];
    html(out, "JOD %.2f", note->jod);
    if (isfinite(note->jod_low))
        html(out, ", 95 %% interval %.2f to %.2f", note->jod_low, note->jod_high);
    if (isfinite(note->delta_e))
        html(out, ", Delta-E ITP %.3g", note->delta_e);
    if (isfinite(note->novelty))
        html(out, ", novelty %.2f", note->novelty);
    html(out, ", %s", verdict_words(&r, verdict));
}

static void put_case(const batch_form *form, FILE *out, size_t row, const batch_note *note) {
    const nqm_score_result r = noted_result(note);
    char text[GATE_TEXT];
    html(out, "<testcase classname='%s' name='%s'>\n", form->list->pair[row].ref, test_name(form, row));
    if (note->is_skipped) {
        html(out, "<skipped message='both are refused: %s'/>\n", note->remark ? note->remark : "");
    } else if (!note->is_scored) {
        html(out, "<error type='no score' message='%s'/>\n", note->remark ? note->remark : "");
    } else if (fails_gate(&form->gate, &r)) {
        html(out, "<failure type='gate' message='JOD %.2f: %s'>", note->jod, gate_words(&form->gate, text));
        put_figures(out, note);
        fputs("</failure>\n", out);
    }
    if (note->is_scored) {
        fputs("<system-out>", out);
        put_figures(out, note);
        html(out, "%s%s</system-out>\n", note->remark ? "\n" : "", note->remark ? note->remark : "");
    }
    fputs("</testcase>\n", out);
}

void print_batch_junit(const batch_summary *s, FILE *out) {
    fputs("<?xml version='1.0' encoding='UTF-8'?>\n", out);
    html(out, "<testsuites name='nqm %s' tests='%zu' failures='%zu' errors='%zu' skipped='%zu'>\n", verb_name(),
         s->n_rows, s->n_gated, s->n_unscored, s->n_skipped);
    html(out, "<testsuite name='%s' tests='%zu' failures='%zu' errors='%zu' skipped='%zu'>\n", s->list_name, s->n_rows,
         s->n_gated, s->n_unscored, s->n_skipped);
    put_properties(s->form, out);
    for (size_t row = 0; row < s->n_rows; ++row)
        put_case(s->form, out, row, &s->notes[row]);
    fputs("</testsuite>\n</testsuites>\n", out);
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
