/* SPDX-License-Identifier: MIT
 *
 * What is made of all rows of `nqm batch`, and of other verbs with many rows: their order, counts, JUnit and Markdown.
 */
#include "nqm/rows.h"
#include "nqm/score/batch.h"
#include "nqm/template.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

extern const char batch_junit[], batch_markdown[]; /* junit.xml, markdown.txt (cmake/embed_text.cmake) */

batch_note make_batch_note(const remark_terms *terms, const nqm_named_pair *pair, const char *name,
                           const nqm_score_result *r, const nqm_error *err) {
    batch_note note = {pair,        name,       r->jod,     r->jod_low,
                       r->jod_high, r->delta_e, r->novelty, .is_identical = r->identical};
    note.is_scored = r->status == NQM_OK;
    note.is_skipped = !note.is_scored && has_same_refusal(pair);
    json_t *remarks = json_remarks(terms, pair, "reference", "test", r);
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

size_t *order_batch_rows(size_t n, const batch_note *notes, bool is_best) {
    double *keys = allocate(n, sizeof *keys);
    for (size_t row = 0; row < n; ++row)
        keys[row] = notes[row].is_scored ? notes[row].jod : -(double)INFINITY;
    size_t *order = order_by(n, keys, is_best ? -1 : 1);
    free(keys);
    return order;
}

batch_summary make_batch_summary(const nqm_model *model, const score_gate *gate, const char *list_name, size_t n_rows,
                                 const batch_note *notes) {
    batch_summary s = {model, gate, list_name, .n_rows = n_rows, .n_shown = n_rows, .notes = notes};
    s.order = order_batch_rows(n_rows, notes, false);
    for (size_t row = 0; row < n_rows; ++row) {
        const nqm_score_result r = noted_result(&notes[row]);
        s.n_skipped += notes[row].is_skipped;
        s.n_unscored += !notes[row].is_scored && !notes[row].is_skipped;
        s.n_gated += fails_gate(gate, &r);
    }
    return s;
}

void summarise_rows(const score_run *run, const char *list_name, size_t n_shown, row_summary *s) {
    s->notes = allocate(run->n_rows, sizeof *s->notes);
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        s->notes[i] = make_batch_note(&run->terms, &row->pair, row->name, &row->result, &row->err);
    }
    s->summary = make_batch_summary(run->model, &run->gate, list_name, run->n_rows, s->notes);
    s->summary.n_shown = nqm_smaller(run->n_rows, n_shown);
}

void free_row_summary(row_summary *s) {
    for (size_t i = 0; i < s->summary.n_rows; ++i)
        free(s->notes[i].remark);
    free(s->notes);
    free(s->summary.order);
}

/* ---- JUnit and Markdown ------------------------------------------------------------------------------------------ */

static json_t *json_case(const void *user, size_t row) {
    const batch_summary *s = user;
    const batch_note *note = &s->notes[row];
    const nqm_score_result r = noted_result(note);
    const bool is_error = !note->is_scored && !note->is_skipped;
    char verdict[NQM_VERDICT_TEXT];
    return json_row("reference:s test:s remark:s jod:f jod_low:f jod_high:f delta_e:f novelty:f verdict:s mark:s "
                    "is_skipped:b is_error:b "
                    "is_scored:b is_failure:b",
                    note->pair->ref, note->name, note->remark ? note->remark : "", r.jod, r.jod_low, r.jod_high,
                    r.delta_e, r.novelty, nqm_verdict(&r, verdict),
                    note->is_skipped    ? "skipped"
                    : is_error          ? "ERROR"
                    : has_gate(s->gate) ? gate_mark(s->gate, &r)
                                        : "",
                    note->is_skipped, is_error, note->is_scored, note->is_scored && fails_gate(s->gate, &r));
}

static json_t *json_shown_case(const void *user, size_t i) {
    const batch_summary *s = user;
    return json_case(s, s->order[i]);
}

static json_t *summary_json(const batch_summary *s) {
    const nqm_model_info info = nqm_model_get_info(s->model);
    char gate[GATE_TEXT];
    return json_row(
        "verb:s tests:z failures:z errors:z has_errors:b skipped:z has_skipped:b list:s version:s model:s sha256:s "
        "gate:s shown:z hidden:o",
        verb_name(), s->n_rows, s->n_gated, s->n_unscored, s->n_unscored > 0, s->n_skipped, s->n_skipped > 0,
        s->list_name, nqm_version(), info.id, info.sha256, gate_words(s->gate, gate), s->n_shown,
        s->n_shown < s->n_rows ? json_sprintf("%zu", s->n_rows - s->n_shown) : NULL);
}

void print_batch_junit(const batch_summary *s, FILE *out) {
    fill_template(out, batch_junit, escape_xml, summary_json(s), json_case, s);
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
