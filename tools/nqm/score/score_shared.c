/* SPDX-License-Identifier: MIT
 *
 * Shared by the commands that score: scores of named pairs, remarks on their values, parsing of --metrics, and results in
 * CSV and JSON.
 */
#include "argument/argument.h"
#include "nqm/rows.h"
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- scores ------------------------------------------------------------------------------------------------------ */

nqm_pairs *expand_pairs(const nqm_pairs *pairs) {
    nqm_pairs *expanded;
    must(nqm_pairs_expand(pairs, ignored_words, &expanded, &fault));
    for (const char *const *text = expanded->left_out; *text; ++text)
        report(EXIT_OK, "%s", *text);
    return expanded;
}

void set_list_pairs(score_run *run, const nqm_pairs *pairs) {
    run->pairs = expand_pairs(pairs);
    run->n_rows = run->pairs->n;
    run->rows = allocate(run->n_rows, sizeof *run->rows);
    for (size_t i = 0; i < run->n_rows; ++i) {
        const nqm_named_pair *pair = &run->pairs->pairs[i];
        const char *name = run->pairs->names[i];
        run->rows[i] = (scored_pair){.pair = *pair, .name = name ? name : pair->test};
    }
}

void set_pairs(score_run *run, int n_arguments, char **arguments, const char *const *names) {
    const size_t n = (size_t)n_arguments - 1;
    nqm_named_pair *given = allocate(n, sizeof *given);
    for (size_t i = 0; i < n; ++i)
        given[i] = (nqm_named_pair){arguments[0], arguments[i + 1]};
    run->ref_path = arguments[0];
    run->ref_name = names && names[0] ? names[0] : arguments[0];
    set_list_pairs(run, &(nqm_pairs){.n = n, .pairs = given, .names = names ? names + 1 : NULL});
    free(given);
}

nqm_scorer *open_scorer(const nqm_model *model, const nqm_score_options *options) {
    nqm_scorer *scorer;
    must(nqm_scorer_create(model, options, &scorer, &fault));
    return scorer;
}

nqm_score_options plain_score_options(void) {
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    return options;
}

/* Score in blocks, so that Ctrl-C is noticed between them. */
void make_scores(score_run *run) {
    nqm_scorer *scorer = open_scorer(run->model, &run->options);
    run->terms = (remark_terms){run->model, run->options.invalid};
    for (size_t begin = 0, n; begin < run->n_rows; begin += n) {
        nqm_named_pair pairs[NQM_SCORE_BLOCK];
        nqm_score_result results[NQM_SCORE_BLOCK];
        nqm_error errors[NQM_SCORE_BLOCK];
        n = nqm_smaller(run->n_rows - begin, NQM_SCORE_BLOCK);
        step_progress("score", begin, run->n_rows);
        for (size_t i = 0; i < n; ++i)
            pairs[i] = run->rows[begin + i].pair;
        must(nqm_scorer_run_named(scorer, n, pairs, results, errors, &fault));
        for (size_t i = 0; i < n; ++i) {
            errors[i].status = results[i].status;
            run->rows[begin + i] =
                (scored_pair){pairs[i], run->rows[begin + i].name, results[i], errors[i], .order = begin + i};
        }
    }
    end_progress();
    nqm_scorer_free(scorer);
    score_textures(run);
}

void free_scores(score_run *run) {
    for (size_t i = 0; i < run->n_rows; ++i) {
        free((nqm_texture_result *)(uintptr_t)run->rows[i].texture);
        nqm_free(run->rows[i].heat);
    }
    free(run->rows);
    nqm_pairs_free(run->pairs);
    nqm_model_free(run->model);
}

int report_faults(const score_run *run) {
    int exit_code = EXIT_OK;
    for (size_t i = 0; i < run->n_rows; ++i)
        if (run->rows[i].err.status != NQM_OK) {
            int code = report_error(&run->rows[i].err);
            exit_code = exit_code == EXIT_OK ? code : exit_code;
        }
    return exit_code;
}

/* ---- remarks ----------------------------------------------------------------------------------------------------- */

json_t *json_remarks(const remark_terms *terms, const nqm_named_pair *pair, const char *ref, const char *test,
                     const nqm_score_result *r) {
    char text[NQM_REMARKS_TEXT];
    json_t *remarks = json_array();
    nqm_pairs_remarks(terms->model, terms->invalid, pair, ref, test, r, text);
    for (const char *at = text; *at; at += strlen(at) + 1)
        json_array_append_new(remarks, json_name(at));
    return remarks;
}

void print_remarks(const score_run *run) {
    const char *ref = run->ref_name;
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        if (i && !has_reference_of(row, row - 1))
            ref = row->pair.ref;
        json_t *remarks = json_remarks(&run->terms, &row->pair, ref, row->name, &row->result);
        for (size_t k = 0; k < json_array_size(remarks); ++k)
            report(EXIT_OK, "%s", json_string_value(json_array_get(remarks, k)));
        if (row->err.status == NQM_OK || json_array_size(remarks))
            ref = NULL;
        json_decref(remarks);
    }
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

static _Noreturn void stop_unknown_metric(const char *given, const char *word) {
    char names[256] = "", wrong[64];
    snprintf(wrong, sizeof wrong, "%.*s", (int)strcspn(word, ","), word);
    nqm_nearest nearest = nqm_nearest_begin(wrong);
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        nqm_nearest_add(&nearest, nqm_metric_get_info((nqm_metric)m).name);
        size_t n = strlen(names);
        snprintf(names + n, sizeof names - n, ", %s", nqm_metric_get_info((nqm_metric)m).name);
    }
    if (is_builtin(wrong))
        stop(EXIT_USAGE, "--metrics is a list with commas of all%s; '%s' is a model, which belongs to --model", names,
             wrong);
    stop(EXIT_USAGE, "--metrics is a list with commas of all%s; not '%s'%s", names, given, nearest.advice);
}

void choose_metrics(const char *text, bool *chosen) {
    memset(chosen, 0, NQM_METRIC_COUNT * sizeof *chosen);
    for (const char *word = text; *word;) {
        const size_t n = strcspn(word, ",");
        const bool is_all = n == 3 && memcmp(word, "all", n) == 0;
        bool is_known = false;
        for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
            const char *name = nqm_metric_get_info((nqm_metric)m).name;
            const bool is_named = is_all || (strlen(name) == n && memcmp(name, word, n) == 0);
            chosen[m] |= is_named;
            is_known |= is_named;
        }
        if (!is_known)
            stop_unknown_metric(text, word);
        word += n + (word[n] == ',');
    }
}

/* ---- gates ------------------------------------------------------------------------------------------------------- */

bool has_gate(const score_gate *gate) {
    return gate->jod > 0 || gate->jod_low > 0;
}

void check_gate(const score_gate *gate, const nqm_model *model) {
    const nqm_model_info info = nqm_model_get_info(model);
    if (gate->jod_low > 0 && !*info.calibration)
        stop(EXIT_INCOMPATIBLE, "--fail-under-low: the model '%s' has no intervals; use --fail-under, or another model",
             info.id);
}

bool fails_gate(const score_gate *gate, const nqm_score_result *result) {
    return result->status == NQM_OK && !result->identical &&
           (result->jod < gate->jod || result->jod_low < gate->jod_low); /* false for NaN */
}

const char *gate_mark(const score_gate *gate, const nqm_score_result *result) {
    return result->status != NQM_OK ? "" : fails_gate(gate, result) ? "FAIL" : "pass";
}

const char *gate_words(const score_gate *gate, char text[GATE_TEXT]) {
    int n = 0;
    *text = '\0';
    if (gate->jod > 0)
        n = snprintf(text, GATE_TEXT, "JOD below %g", gate->jod);
    if (gate->jod_low > 0)
        snprintf(text + n, GATE_TEXT - (size_t)n, "%slower end of the interval below %g", n ? " or " : "",
                 gate->jod_low);
    return text;
}

int report_gate(const score_gate *gate, size_t n_failed, size_t n_pairs, int exit_code) {
    char text[GATE_TEXT];
    if (has_gate(gate))
        report(EXIT_GATE, "%zu of %zu pairs FAIL: %s", n_failed, n_pairs, gate_words(gate, text));
    return exit_code == EXIT_OK && n_failed ? EXIT_GATE : exit_code;
}

int apply_gate(const score_run *run, int exit_code) {
    size_t n_failed = 0;
    for (size_t i = 0; i < run->n_rows; ++i)
        n_failed += fails_gate(&run->gate, &run->rows[i].result);
    return report_gate(&run->gate, n_failed, run->n_rows, exit_code);
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

json_t *model_json(const nqm_model *model) {
    nqm_model_info info = nqm_model_get_info(model);
    return json_row("id:s sha256:s parameters:z", info.id, info.sha256, info.n_parameters);
}

void print_jod(const scored_pair *row, bool calibrated) {
    const nqm_score_result *r = &row->result;
    const bool scored = row->err.status == NQM_OK;
    char jod[16] = "-", interval[32] = "-";
    if (scored) {
        snprintf(jod, sizeof jod, "%.2f", r->jod);
        snprintf(interval, sizeof interval, "[%.2f, %.2f]", r->jod_low, r->jod_high);
    }
    printf("  %5s", jod);
    if (calibrated)
        printf("  %-14s", interval);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

void compare_rows(score_run *run) {
    if (!run->exact)
        return;
    if (run->format == FORMAT_CSV || run->format == FORMAT_QUIET)
        stop(EXIT_USAGE, "--exact prints text or --json");
    nqm_brdf *ref = NULL;
    for (size_t i = 0; i < run->n_rows; ++i) {
        scored_pair *row = &run->rows[i];
        if (i && !has_reference_of(row, row - 1)) {
            nqm_brdf_free(ref);
            ref = NULL;
        }
        if (row->err.status != NQM_OK || row->texture)
            continue;
        ref = ref ? ref : open_brdf(row->pair.ref);
        nqm_brdf *test = open_brdf(row->pair.test);
        must(nqm_brdf_compare(ref, test, run->tolerance, 1, &row->difference, &fault));
        nqm_brdf_free(test);
    }
    nqm_brdf_free(ref);
}

static double polar_deg(const double *direction) {
    return acos(fmin(direction[2], 1)) * 57.29577951308232;
}

void print_exact(const score_run *run, const scored_pair *row) {
    static const char *const channels[] = {"red", "green", "blue"};
    const nqm_brdf_difference *d = &row->difference;
    printf("         %s within %g: values differ by up to %.3g %%\n", d->is_equal ? "equal" : "NOT equal",
           run->tolerance, 100 * d->largest);
    if (d->is_equal)
        return;
    if (d->n_different)
        printf("         (%s %.4g, reference %.4g, at wi %.4f,%.4f,%.4f, wo %.4f,%.4f,%.4f:\n"
               "         light at %.1f, viewer at %.1f degrees); at %zu of %zu pairs of directions\n",
               channels[d->channel], d->test, d->ref, d->wi[0], d->wi[1], d->wi[2], d->wo[0], d->wo[1], d->wo[2],
               polar_deg(d->wi), polar_deg(d->wo), d->n_different, d->n_pairs);
    if (d->n_missing)
        printf("         only one of them has a value at %zu of %zu pairs of directions\n", d->n_missing, d->n_pairs);
}

static json_t *json_exact(const score_run *run, const scored_pair *row) {
    const nqm_brdf_difference *d = &row->difference;
    return json_row("equal:b tolerance:f largest:f wi:[fff] wo:[fff] channel:i reference:f test:f n_different:z "
                    "n_missing:z n_pairs:z",
                    d->is_equal, run->tolerance, d->largest, d->wi[0], d->wi[1], d->wi[2], d->wo[0], d->wo[1], d->wo[2],
                    d->channel, d->ref, d->test, d->n_different, d->n_missing, d->n_pairs);
}

bool report_unequal(const score_run *run) {
    size_t n = 0;
    for (size_t i = 0; i < run->n_rows; ++i)
        n += run->rows[i].err.status == NQM_OK && !run->rows[i].texture && !run->rows[i].difference.is_equal;
    if (n)
        report(EXIT_GATE, "%zu of %zu pairs are not equal within %g", n, run->n_rows, run->tolerance);
    return n > 0;
}

/* How the highlight of a BRDF is stretched. */
typedef struct anisotropy {
    double ratio, azimuth_deg; /* length by width; of the length, -90 to 90 */
} anisotropy;

static const double round_ratio = 1.1; /* below it a highlight is round */

static anisotropy anisotropy_of(const char *argument) {
    nqm_brdf *brdf = open_brdf(argument);
    const nqm_lobe lobe = nqm_lobe_measure(brdf);
    const double degrees = atan2(lobe.axes[2], lobe.axes[0]) * 57.29577951308232;
    const double ratio = lobe.axes[0] * lobe.axes[0] + lobe.axes[2] * lobe.axes[2], azimuth = remainder(degrees, 180);
    nqm_brdf_free(brdf);
    return (anisotropy){ratio, ratio < round_ratio ? 0 : azimuth < -89.5 ? azimuth + 180 : azimuth};
}

char *describe_anisotropy(const scored_pair *row, char text[ANISOTROPY_TEXT]) {
    static const double seen_rotation_deg = 2;
    const anisotropy a = anisotropy_of(row->pair.ref), b = anisotropy_of(row->pair.test);
    const double rotation = remainder(b.azimuth_deg - a.azimuth_deg, 180);
    int n = 0;
    *text = 0;
    if (b.ratio > round_ratio * a.ratio || a.ratio > round_ratio * b.ratio)
        n = snprintf(text, ANISOTROPY_TEXT, "; stretched %.1f times along %.0f degrees instead of %.1f", b.ratio,
                     b.ratio > round_ratio ? b.azimuth_deg : a.azimuth_deg, a.ratio);
    if (a.ratio > round_ratio && b.ratio > round_ratio && fabs(rotation) > seen_rotation_deg)
        snprintf(text + n, ANISOTROPY_TEXT - (size_t)n, "; rotated by %.0f degrees", rotation);
    return text;
}

json_t *json_result(const remark_terms *terms, const nqm_named_pair *pair, const bool *metrics, const score_gate *gate,
                    const nqm_score_result *r, const nqm_error *err) {
    const bool is_scored = r->status == NQM_OK;
    json_t *object = set_columns(json_object(), COLUMNS_SCORE, NULL, r, NULL);
    json_set(object, "metrics:o", json_object());
    set_columns(object, COLUMNS_METRICS | COLUMNS_PARTS | COLUMNS_SIMILARITY, metrics, r, NULL);
    return json_set(object, "gate:o warnings:o error:o",
                    has_gate(gate) && is_scored ? json_string(gate_mark(gate, r)) : NULL,
                    json_remarks(terms, pair, "reference", "test", r), is_scored ? NULL : json_name(err->message));
}

/* Without what only JSON has. */
static json_t *plain_json(const score_run *run, const scored_pair *row) {
    json_t *object = json_result(&run->terms, &row->pair, run->metrics, &run->gate, &row->result, &row->err);
    if (row->texture)
        set_texture(object, row);
    return object;
}

static json_t *row_json(const score_run *run, const scored_pair *row) {
    json_t *object = json_row("test:s name:s", row->pair.test, row->name);
    json_object_update_new(object, plain_json(run, row));
    if (row->result.anisotropy > 0) {
        const anisotropy a = anisotropy_of(row->pair.ref), b = anisotropy_of(row->pair.test);
        json_set(object, "anisotropy:f stretched:{ratio:[ff] azimuth_deg:[ff]}", row->result.anisotropy, a.ratio,
                 b.ratio, a.azimuth_deg, b.azimuth_deg);
    }
    if (!row->texture && run->exact && row->err.status == NQM_OK)
        json_object_set_new(object, "exact", json_exact(run, row));
    if (!has_reference_of(run->rows, &run->rows[run->n_rows - 1]))
        json_object_set_new(object, "reference", json_name(row->pair.ref));
    return object;
}

json_t *json_rows(const score_run *run, row_maker *make) {
    json_t *rows = json_array();
    for (size_t i = 0; i < run->n_rows; ++i)
        json_array_append_new(rows, make(run, &run->rows[i]));
    return rows;
}

void print_csv_rows(const score_run *run, char *columns, row_maker *make) {
    print_csv_line(stdout, columns, NULL, NULL);
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        const row_text texts[] = {{"reference", row->pair.ref},
                                  {"test", row->pair.test},
                                  {"name", row->name},
                                  {"error", row->err.status == NQM_OK ? "" : row->err.message},
                                  {0}};
        json_t *object = make(run, row);
        print_csv_line(stdout, columns, object, texts);
        json_decref(object);
    }
    free(columns);
}

void print_csv_scores(const score_run *run) {
    const bool is_textured = has_textures(run);
    char last[180];
    snprintf(last, sizeof last, "%s%s,name,warnings,error",
             is_textured
                 ? ",blame=texture.blame.0.property,blame_jod=texture.blame.0.jod,mistake=texture.blame.0.mistake"
                 : "",
             has_gate(&run->gate) ? ",gate" : "");
    const unsigned groups =
        score_groups(run->model) | COLUMNS_SCORE | COLUMNS_METRICS | (is_textured ? COLUMNS_TEXTURE : 0);
    print_csv_rows(run, list_columns("reference,test", groups, run->metrics, last), plain_json);
}

json_t *json_scores(const score_run *run) {
    return json_row("schema:i tool:o model:o reference:s results:o", 1, json_tool(), model_json(run->model),
                    run->ref_path, json_rows(run, row_json));
}
