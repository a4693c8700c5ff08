/* SPDX-License-Identifier: MIT
 *
 * Rows of `nqm batch` as CSV, as JSON Lines and as one JSON document (doc/cli.md). The columns of the list come first,
 * unchanged.
 */
#include "nqm/score/batch.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- columns ----------------------------------------------------------------------------------------------------- */

/* The names of the columns that the results add, each after a comma. */
static void print_csv_added(const batch_form *form, FILE *out) {
    print_csv_score_names(out, form->model, form->metrics);
    for (size_t i = 0; form->has_textures && i < TEXTURE_NUMBERS; ++i)
        fprintf(out, ",%s", texture_columns[i]);
    fputs(has_gate(&form->gate) ? ",gate,warnings,error" : ",warnings,error", out);
}

void check_batch_columns(const batch_form *form) {
    const char *const *names = form->list->column;
    char *added = NULL;
    size_t n_added;
    FILE *stream = open_text(&added, &n_added);
    print_csv_added(form, stream);
    fputs(nqm_model_has_parts(form->model) ? ",metrics,parts," : ",metrics,", stream); /* members in JSON */
    fclose(stream);
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

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

static void print_csv_head(const batch_form *form, FILE *out) {
    for (size_t i = 0; i < form->list->n_columns; ++i) {
        fputs(i ? "," : "", out);
        print_csv_text(out, form->list->column[i]);
    }
    print_csv_added(form, out);
    fputc('\n', out);
}

static void print_csv_row(const batch_form *form, FILE *out, size_t row, const nqm_score_result *r,
                          const texture_numbers *texture, const nqm_error *err, const json_t *warnings) {
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
    print_csv_score(out, form->model, form->metrics, r);
    if (form->has_textures)
        print_csv_numbers(out, TEXTURE_NUMBERS, texture->v);
    if (has_gate(&form->gate))
        fprintf(out, ",%s", gate_mark(&form->gate, r));
    print_csv_remarks(out, warnings);
    print_csv_field(out, r->status == NQM_OK ? "" : err->message);
    fputc('\n', out);
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

/* Print `value` and release it. */
static void print_json_value(FILE *out, json_t *value) {
    json_dumpf(value, out, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
    json_decref(value);
}

static void print_json_number(FILE *out, const char *comma, const char *key, double value) {
    fprintf(out, "%s\"%s\":", comma, key);
    if (isfinite(value))
        fprintf(out, "%.9g", value);
    else
        fputs("null", out);
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

static void print_json_row(const batch_form *form, FILE *out, size_t row, const nqm_score_result *r,
                           const texture_numbers *texture, const nqm_error *err, json_t *warnings) {
    char verdict[VERDICT_TEXT];
    fputc('{', out);
    print_json_cells(form, out, row);
    print_json_number(out, "", "jod", r->jod);
    print_json_number(out, ",", "jod_low", r->jod_low);
    print_json_number(out, ",", "jod_high", r->jod_high);
    print_json_number(out, ",", "delta_e_itp", r->delta_e);
    print_json_number(out, ",", "novelty", r->novelty);
    for (size_t i = 0; form->has_textures && i < TEXTURE_NUMBERS; ++i)
        print_json_number(out, ",", texture_columns[i], texture->v[i]);
    if (r->status == NQM_OK)
        fprintf(out, ",\"identical\":%s,\"n_valid\":%zu", r->identical ? "true" : "false", r->n_valid);
    else
        fputs(",\"identical\":null,\"n_valid\":null", out);
    fprintf(out, ",\"verdict\":\"%s\",\"metrics\":{", verdict_words(r, verdict));
    const char *comma = "";
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (form->metrics[m]) {
            print_json_number(out, comma, nqm_metric_name((nqm_metric)m), r->metrics[m]);
            comma = ",";
        }
    fputs("},", out);
    if (!isnan(r->parts.structure)) {
        fputs("\"parts\":", out);
        print_json_value(out, json_label_parts(&r->parts, r->similarity));
        fputc(',', out);
    }
    if (has_gate(&form->gate) && r->status == NQM_OK)
        fprintf(out, "\"gate\":\"%s\",", gate_mark(&form->gate, r));
    fputs("\"warnings\":", out);
    print_json_value(out, json_incref(warnings));
    if (r->status != NQM_OK) {
        fputs(",\"error\":", out);
        print_json_value(out, json_name(err->message));
    }
    fputc('}', out);
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
    json_t *warnings = json_remarks(&form->terms, &form->list->pair[row], "reference", "test", result);
    if (form->format == BATCH_CSV)
        print_csv_row(form, out, row, result, texture, err, warnings);
    else
        print_json_row(form, out, row, result, texture, err, warnings);
    if (form->format == BATCH_JSON_LINES)
        fputc('\n', out);
    json_decref(warnings);
}

/* The text before each row but the first. */
static const char *batch_separator(const batch_form *form) {
    return form->format == BATCH_JSON ? ",\n" : "";
}

static void print_batch_tail(const batch_form *form, FILE *out) {
    if (form->format == BATCH_JSON)
        fputs("\n]}\n", out);
}

/* ---- notes ------------------------------------------------------------------------------------------------------- */

batch_note make_batch_note(const batch_form *form, size_t row, const nqm_score_result *r, const nqm_error *err) {
    batch_note note = {r->jod, r->jod_low, r->jod_high, r->delta_e, r->novelty, .is_identical = r->identical};
    note.is_scored = r->status == NQM_OK;
    note.is_skipped = !note.is_scored && has_same_refusal(&form->list->pair[row]);
    json_t *remarks = json_remarks(&form->terms, &form->list->pair[row], "reference", "test", r);
    if (!note.is_scored)
        note.remark = strdup(err->message);
    else if (json_array_size(remarks))
        note.remark = join_remarks(remarks);
    json_decref(remarks);
    return note;
}

nqm_score_result noted_result(const batch_note *note) {
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
    print_batch_tail(form, out->file.stream);
    if (fflush(out->file.stream) != 0)
        stop_write(out);
    if (out->rows != out->file.stream)
        fclose(out->rows);
    close_output(&out->file);
}
