/* SPDX-License-Identifier: MIT
 *
 * Shared by the commands that score: scores of named pairs, remarks on their values, parsing of --metrics, and results in
 * CSV and JSON.
 */
#include "base/names.h"
#include "brdf/brdf.h"
#include "nqm/score/score.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- scores ------------------------------------------------------------------------------------------------------ */

static void take_expansion(score_run *run) {
    run->n_rows = run->expansion.n;
    run->rows = allocate(run->n_rows, sizeof *run->rows);
    for (size_t i = 0; i < run->n_rows; ++i) {
        const expanded_pair *p = &run->expansion.pairs[i];
        run->rows[i] = (scored_pair){.pair = p->pair, .name = p->name ? p->name : p->pair.test};
    }
}

void set_pairs(score_run *run, int n_arguments, char **arguments, const char *const *names) {
    const size_t n = (size_t)n_arguments - 1;
    nqm_named_pair *given = allocate(n, sizeof *given);
    for (size_t i = 0; i < n; ++i)
        given[i] = (nqm_named_pair){arguments[0], arguments[i + 1]};
    run->ref_path = arguments[0];
    run->ref_name = names && names[0] ? names[0] : arguments[0];
    expand_pairs(n, given, names ? names + 1 : NULL, &run->expansion);
    take_expansion(run);
    free(given);
}

void set_list_pairs(score_run *run, const nqm_pair_list *list, const char *const *names) {
    expand_pairs(list->n_rows, list->pair, names, &run->expansion);
    take_expansion(run);
}

static void check_list_names(const nqm_pair_list *list, const char *const *names, const char *list_name) {
    named_brdf *given = allocate(list->n_rows, sizeof *given);
    size_t n = 0;
    for (size_t row = 0; row < list->n_rows; ++row)
        if (names[row])
            given[n++] = (named_brdf){.row = row + 1, .reference = list->pair[row].ref, .name = names[row]};
    check_names(n, given, list_name);
    free(given);
}

const char **take_list_names(nqm_pair_list *list, const char *list_name) {
    size_t n_text = 0;
    for (size_t row = 0; row < list->n_rows; ++row)
        n_text += name_length(list->pair[row].test) + 1;
    const char **names = allocate(list->n_rows * sizeof *names + n_text, 1);
    char *text = (char *)(names + list->n_rows);
    for (size_t row = 0; row < list->n_rows; ++row) {
        const char **test = &list->pair[row].test;
        const size_t n = name_length(*test);
        if (n) {
            memcpy(text, *test, n);
            names[row] = text;
            text += n + 1;
            *test += n + 1;
        }
        for (size_t i = 0; i < nqm_pair_list_cells(list, row); ++i) {
            const nqm_list_cell cell = nqm_pair_list_cell(list, row, i);
            if (strcmp(list->column[cell.column], "name") == 0 && !cell.is_json && *cell.text)
                names[row] = cell.text;
        }
    }
    check_list_names(list, names, list_name);
    return names;
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
    run->terms.n_directions = nqm_directions_count(nqm_model_get_info(run->model).directions);
    run->terms.invalid = run->options.invalid;
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
        free(run->rows[i].texture);
        free(run->rows[i].heat);
    }
    free(run->rows);
    free_expansion(&run->expansion);
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

__attribute__((format(printf, 2, 3))) static void add_remark(json_t *remarks, const char *format, ...) {
    char text[600];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    json_array_append_new(remarks, json_string(text));
}

/* The numbers of directions at which one BRDF (k: 0 reference, 1 test) gives cause for a remark. */
static void add_counts(json_t *remarks, const remark_terms *terms, const char *who, const nqm_score_result *r,
                       size_t k) {
    static const char *const remedy[] = {"left out", "taken as 0", "taken from the nearest direction", "refused"};
    if (*r->remark[k])
        add_remark(remarks, "%s: %s", who, r->remark[k]);
    if (r->n_clamped[k])
        add_remark(remarks, "%s: negative channel at %zu of %zu directions, taken as 0", who, r->n_clamped[k],
                   terms->n_directions);
    if (r->n_invalid[k])
        add_remark(remarks, "%s: no value at %zu of %zu directions, %s", who, r->n_invalid[k], terms->n_directions,
                   remedy[terms->invalid]);
    if (r->n_unusual[k])
        add_remark(remarks, "%s: at %zu of %zu directions far brighter than most BRDFs of the training", who,
                   r->n_unusual[k], terms->n_directions);
}

/* Faults of files that a low score shows. */
static void add_suspicions(json_t *remarks, const char *test, const nqm_score_result *r) {
    if (r->suspect_scale > 0 && fabs(log(r->suspect_scale)) < 2)
        add_remark(remarks, "%s: its reference %s pi at nearly all directions: a Lambertian f_r is its albedo / pi",
                   test, r->suspect_scale > 1 ? "times" : "divided by");
    else if (r->suspect_scale > 0)
        add_remark(
            remarks,
            "%s: about %.4g times its reference at most directions: is a scale missing in one of them? It is 1500, "
            "1304 and 904 in MERL files, 255 in values of 8 bits",
            test, r->suspect_scale);
    if (r->suspect_cosine != 0)
        add_remark(remarks, "%s: about its reference %s the cosine of light or viewer: f_r is without a cosine", test,
                   r->suspect_cosine > 0 ? "times" : "divided by");
}

json_t *json_remarks(const remark_terms *terms, const nqm_named_pair *pair, const char *ref, const char *test,
                     const nqm_score_result *r) {
    json_t *remarks = json_array();
    char distance[400], ignored[200];
    if (ref && describe_distance(ref, r->distance_deg, sizeof distance, distance))
        add_remark(remarks, "%s", distance);
    if (r->status != NQM_OK)
        return remarks;
    if (ref && describe_ignored(pair->ref, ignored, sizeof ignored))
        add_remark(remarks, "%s: %s", ref, ignored);
    if (describe_ignored(pair->test, ignored, sizeof ignored))
        add_remark(remarks, "%s: %s", test, ignored);
    if (ref)
        add_counts(remarks, terms, ref, r, 0);
    add_counts(remarks, terms, test, r, 1);
    if (r->novelty > 1 && r->jod_high - r->jod_low > 0.1) /* false for NaN */
        add_remark(remarks,
                   "%s: unlike the training pairs: novelty %.2f, where 95 %% of pairs of new materials are below 1",
                   test, r->novelty);
    add_suspicions(remarks, test, r);
    return remarks;
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

static _Noreturn void stop_unknown_metric(const char *given, const char *word) {
    char names[256] = "", wrong[64];
    snprintf(wrong, sizeof wrong, "%.*s", (int)strcspn(word, ","), word);
    nqm_nearest nearest = nqm_nearest_begin(wrong);
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        nqm_nearest_add(&nearest, nqm_metric_name((nqm_metric)m));
        size_t n = strlen(names);
        snprintf(names + n, sizeof names - n, ", %s", nqm_metric_name((nqm_metric)m));
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
            const char *name = nqm_metric_name((nqm_metric)m);
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
    return json_pack("{s:s,s:s,s:I}", "id", info.id, "sha256", info.sha256, "parameters",
                     (json_int_t)info.n_parameters);
}

void print_csv_part_names(FILE *out, const nqm_model *model) {
    if (!nqm_model_has_parts(model))
        return;
    for (size_t i = 0; i + 1 < LABEL_COLUMNS; ++i)
        fprintf(out, ",%s", label_columns[i]);
    fprintf(out, ",%s,words", similarity_column);
}

void print_csv_parts(FILE *out, const nqm_model *model, const nqm_score_result *r) {
    char words[NQM_LABEL_TEXT] = "";
    if (!nqm_model_has_parts(model))
        return;
    print_csv_label(out, &r->parts, r->similarity);
    print_csv_field(out, isnan(r->parts.structure) ? "" : nqm_label_describe(&r->parts, words));
}

void print_csv_score_names(FILE *out, const nqm_model *model, const bool *metrics) {
    fputs(",jod,jod_low,jod_high,delta_e_itp,identical,n_valid,novelty,verdict", out);
    print_csv_part_names(out, model);
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (metrics[m])
            fprintf(out, ",%s", nqm_metric_name((nqm_metric)m));
}

void print_csv_score(FILE *out, const nqm_model *model, const bool *metrics, const nqm_score_result *r) {
    char verdict[VERDICT_TEXT];
    print_csv_numbers(out, 4, (double[]){r->jod, r->jod_low, r->jod_high, r->delta_e});
    if (r->status == NQM_OK)
        fprintf(out, ",%d,%zu", r->identical, r->n_valid);
    else
        fputs(",,", out);
    print_csv_numbers(out, 1, &r->novelty);
    print_csv_field(out, verdict_words(r, verdict));
    print_csv_parts(out, model, r);
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (metrics[m])
            print_csv_numbers(out, 1, &r->metrics[m]);
}

char *join_remarks(const json_t *remarks) {
    size_t n = 1;
    for (size_t i = 0; i < json_array_size(remarks); ++i)
        n += json_string_length(json_array_get(remarks, i)) + 2;
    char *text = allocate(n, 1);
    for (size_t i = 0, at = 0; i < json_array_size(remarks); ++i)
        at += (size_t)snprintf(text + at, n - at, "%s%s", i ? "; " : "", json_string_value(json_array_get(remarks, i)));
    return text;
}

void print_csv_remarks(FILE *out, json_t *remarks) {
    char *text = join_remarks(remarks);
    print_csv_field(out, text);
    free(text);
    json_decref(remarks);
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

double preference_share(const nqm_score_result *result) {
    return result->identical ? 0.5 : nqm_jod_preference(fmax(10, result->jod), result->jod);
}

const char *jod_words(double jod) {
    if (jod >= 9.5)
        return "practically the same";
    if (jod >= 9)
        return "hardly visible";
    if (jod >= 8)
        return "visible";
    return jod >= 6 ? "clearly visible" : "very different";
}

const char *verdict_words(const nqm_score_result *result, char text[VERDICT_TEXT]) {
    if (result->status != NQM_OK)
        return "";
    if (result->identical)
        return "identical";
    if (isnan(result->jod_low))
        return jod_words(result->jod);
    const char *best = jod_words(result->jod_high), *worst = jod_words(result->jod_low);
    if (best == worst)
        return best;
    snprintf(text, VERDICT_TEXT, "between %s and %s", best, worst);
    return text;
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
    return json_pack("{s:b,s:f,s:f,s:[f,f,f],s:[f,f,f],s:i,s:f,s:f,s:I,s:I,s:I}", "equal", d->is_equal, "tolerance",
                     run->tolerance, "largest", d->largest, "wi", d->wi[0], d->wi[1], d->wi[2], "wo", d->wo[0],
                     d->wo[1], d->wo[2], "channel", d->channel, "reference", d->ref, "test", d->test, "n_different",
                     (json_int_t)d->n_different, "n_missing", (json_int_t)d->n_missing, "n_pairs",
                     (json_int_t)d->n_pairs);
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
typedef struct grain {
    double ratio, azimuth_deg; /* length by width; of the length, -90 to 90 */
} grain;

static const double round_ratio = 1.1; /* below it a highlight is round */

static grain grain_of(const char *argument) {
    nqm_brdf *brdf = open_brdf(argument);
    const nqm_lobe lobe = nqm_lobe_measure(brdf);
    const double degrees = atan2(lobe.axes[2], lobe.axes[0]) * 57.29577951308232;
    const double ratio = lobe.axes[0] * lobe.axes[0] + lobe.axes[2] * lobe.axes[2], azimuth = remainder(degrees, 180);
    nqm_brdf_free(brdf);
    return (grain){ratio, ratio < round_ratio ? 0 : azimuth < -89.5 ? azimuth + 180 : azimuth};
}

char *describe_grain(const scored_pair *row, char text[GRAIN_TEXT]) {
    static const double seen_turn_deg = 2;
    const grain a = grain_of(row->pair.ref), b = grain_of(row->pair.test);
    const double turn = remainder(b.azimuth_deg - a.azimuth_deg, 180);
    int n = 0;
    *text = 0;
    if (b.ratio > round_ratio * a.ratio || a.ratio > round_ratio * b.ratio)
        n = snprintf(text, GRAIN_TEXT, "; stretched %.1f times along %.0f degrees instead of %.1f", b.ratio,
                     b.ratio > round_ratio ? b.azimuth_deg : a.azimuth_deg, a.ratio);
    if (a.ratio > round_ratio && b.ratio > round_ratio && fabs(turn) > seen_turn_deg)
        snprintf(text + n, GRAIN_TEXT - (size_t)n, "; rotated by %.0f degrees", turn);
    return text;
}

json_t *json_result(const remark_terms *terms, const nqm_named_pair *pair, const bool *chosen, const score_gate *gate,
                    const nqm_score_result *r, const nqm_error *err) {
    char verdict[VERDICT_TEXT];
    const bool is_scored = r->status == NQM_OK;
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (chosen[m])
            json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), json_number(r->metrics[m]));
    json_t *object =
        json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:s,s:o}", "jod", json_number(r->jod), "jod_low",
                  json_number(r->jod_low), "jod_high", json_number(r->jod_high), "delta_e_itp", json_number(r->delta_e),
                  "novelty", json_number(r->novelty), "identical", is_scored ? json_boolean(r->identical) : json_null(),
                  "n_valid", is_scored ? json_integer((json_int_t)r->n_valid) : json_null(), "verdict",
                  verdict_words(r, verdict), "metrics", metrics);
    if (!isnan(r->parts.structure))
        json_object_set_new(object, "parts", json_label_parts(&r->parts, r->similarity));
    if (has_gate(gate) && is_scored)
        json_object_set_new(object, "gate", json_string(gate_mark(gate, r)));
    json_object_set_new(object, "warnings", json_remarks(terms, pair, "reference", "test", r));
    if (!is_scored)
        json_object_set_new(object, "error", json_name(err->message));
    return object;
}

static json_t *row_json(const score_run *run, const scored_pair *row) {
    const nqm_score_result *r = &row->result;
    json_t *object = json_pack("{s:o,s:o}", "test", json_name(row->pair.test), "name", json_name(row->name));
    json_object_update_new(object, json_result(&run->terms, &row->pair, run->metrics, &run->gate, r, &row->err));
    if (r->anisotropy > 0) {
        const grain a = grain_of(row->pair.ref), b = grain_of(row->pair.test);
        json_object_set_new(object, "anisotropy", json_number(r->anisotropy));
        json_object_set_new(
            object, "stretched",
            json_pack("{s:[f,f],s:[f,f]}", "ratio", a.ratio, b.ratio, "azimuth_deg", a.azimuth_deg, b.azimuth_deg));
    }
    if (row->texture)
        json_object_set_new(object, "texture", json_texture(row));
    else if (run->exact && row->err.status == NQM_OK)
        json_object_set_new(object, "exact", json_exact(run, row));
    if (!has_reference_of(run->rows, &run->rows[run->n_rows - 1]))
        json_object_set_new(object, "reference", json_name(row->pair.ref));
    return object;
}

json_t *json_scores(const score_run *run) {
    json_t *results = json_array();
    for (size_t i = 0; i < run->n_rows; ++i)
        json_array_append_new(results, row_json(run, &run->rows[i]));
    return json_pack("{s:i,s:o,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "model", model_json(run->model),
                     "reference", json_name(run->ref_path), "results", results);
}
