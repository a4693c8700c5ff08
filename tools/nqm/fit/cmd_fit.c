/* SPDX-License-Identifier: MIT
 *
 * nqm fit - encode a BRDF: fit analytic models, train a network, use a learned dictionary or hypernetwork. The result is a
 * spec or a file.
 */
#include "base/os.h"
#include "fit/fit.h"
#include "nqm/rows.h"
#include "nqm/score/score.h"
#include "nqm/show/report.h"
#include "nqm/textured.h"
#include <nqm/match.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FIT_MAX_MODELS = 48, FIT_MAX_BOUNDS = 16 };

/* The models to fit, in the order of the command line. */
typedef struct fit_request {
    const char *models[FIT_MAX_MODELS]; /* names of the library */
    size_t n_models;
    char bound_keys[FIT_MAX_BOUNDS][48];
    nqm_fit_bound bounds[FIT_MAX_BOUNDS]; /* their keys are the texts above */
    size_t n_bounds;
} fit_request;

enum { FIT_MAX_PATH = 4096 };

/* The result of one model. */
typedef struct fitted {
    const char *model;
    nqm_error err; /* status NQM_OK, or the error of the model: then the fields below are not set */
    nqm_match_report match;
    double metrics[NQM_METRIC_COUNT];
    nqm_score_result score; /* by --metric */
    double seconds;
    char path[FIT_MAX_PATH]; /* path of the file; "" if the result is a spec or was not written */
    char before[2048];       /* spec of the fit under the loss "log", which the report shows; "": none */
} fitted;

/* ---- arguments --------------------------------------------------------------------------------------------------- */

static _Noreturn void stop_unknown(const char *name, size_t n_name) {
    char names[600] = "", wrong[41];
    size_t used = 0;
    snprintf(wrong, sizeof wrong, "%.*s", n_name < 40 ? (int)n_name : 40, name);
    nqm_nearest nearest = nqm_nearest_begin(wrong);
    for (size_t i = 0; nqm_fit_model(i) && used < sizeof names; ++i) {
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", nqm_fit_model(i));
        nqm_nearest_add(&nearest, nqm_fit_model(i));
    }
    stop(EXIT_USAGE, "cannot fit a model '%s'%s; there are all, encodings, shading, %s", wrong, nearest.advice, names);
}

static void add_model(fit_request *request, const char *name) {
    for (size_t i = 0; i < request->n_models; ++i)
        if (request->models[i] == name)
            return;
    if (request->n_models < FIT_MAX_MODELS)
        request->models[request->n_models++] = name;
}

/* A model, or all, the encodings, which are the first of the list, or those of renderers. */
static void add_word(const char *text, size_t n, fit_request *request) {
    const bool all = n == 3 && strncmp(text, "all", n) == 0, encodings = n == 9 && strncmp(text, "encodings", n) == 0;
    const bool shading = n == 7 && strncmp(text, "shading", n) == 0;
    size_t i = 0;
    const size_t end = encodings ? NQM_FIT_N_ENCODINGS : all ? NQM_FIT_FIRST_SHADING : SIZE_MAX;
    for (size_t k = shading ? NQM_FIT_FIRST_SHADING : 0; (all || encodings || shading) && k < end && nqm_fit_model(k);
         ++k)
        add_model(request, nqm_fit_model(k));
    if (all || encodings || shading)
        return;
    while (nqm_fit_model(i) && !(strncmp(nqm_fit_model(i), text, n) == 0 && nqm_fit_model(i)[n] == 0))
        ++i;
    if (!nqm_fit_model(i))
        stop_unknown(text, n);
    add_model(request, nqm_fit_model(i));
}

/* Names, "all", "encodings" and "shading", separated by commas. "all" is without shading models, whose fits take longer. */
static void choose_models(const char *text, fit_request *request) {
    for (;; ++text) {
        size_t n = strcspn(text, ",");
        add_word(text, n, request);
        text += n;
        if (!*text)
            return;
    }
}

/* "KEY=LOW:HIGH,..."; NULL: none. Each key must belong to one of the models. */
static void choose_bounds(const char *text, fit_request *request) {
    for (int n = 0; text && *text; text += n) {
        if (request->n_bounds == FIT_MAX_BOUNDS)
            stop(EXIT_USAGE, "at most %d bounds", FIT_MAX_BOUNDS);
        nqm_fit_bound *bound = &request->bounds[request->n_bounds];
        char *key = request->bound_keys[request->n_bounds++];
        n = 0; /* numbers in the "C" locale: the tool never calls setlocale() */
        if (sscanf(text, "%47[^=,]=%lf:%lf%n", key, &bound->low, &bound->high, &n) != 3 || (text[n] && text[n] != ','))
            stop(EXIT_USAGE, "--bounds takes KEY=LOW:HIGH,..., not '%.80s'", text);
        n += text[n] == ',';
        bound->key = key;
        bool known = false;
        for (size_t m = 0; m < request->n_models; ++m)
            known |= nqm_fit_model_has(request->models[m], key) != 0;
        if (!known)
            stop(
                EXIT_USAGE,
                "none of the models has a parameter '%s' to bound: of lobes these are the shapes (alpha, f0, ...), not "
                "kd and ks; of shading models (--model gltf) any key",
                key);
    }
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

/* The metrics of `test` against `ref`, at the directions where `ref` has values. */
static nqm_status measure(const nqm_brdf *ref, const nqm_brdf *test, const nqm_directions *directions, double *metrics,
                          nqm_error *err) {
    size_t n = nqm_directions_get_info(directions).n;
    float *rgb;
    uint8_t *used;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&rgb, n, 6 * sizeof(float)}, {&used, n, 1}), err);
    if (status != NQM_OK)
        return status;
    status = nqm_sample(ref, directions, NQM_INVALID_DROP, rgb, used, NULL, err);
    if (status == NQM_OK)
        status = nqm_sample(test, directions, NQM_INVALID_DROP, rgb + 3 * n, NULL, NULL, err);
    for (size_t i = 0; i < n; ++i)
        used[i] = nqm_has_value(used[i]);
    if (status == NQM_OK)
        status = nqm_metrics_compute(directions, rgb, rgb + 3 * n, used, metrics, err);
    nqm_free(rgb);
    return status;
}

/* Where results are written: a file, or a folder for several models and for paths that name one. */
typedef struct output {
    const char *path; /* NULL: results are not written */
    bool folder;
} output;

/* Create the folder, or check that the file can be created and that the only model writes one. */
static output prepare_output(const char *path, const fit_request *request) {
    output out = {.path = path};
    const nqm_fit_entry *first;
    size_t n = path ? strlen(path) : 0;
    out.folder = n > 0 && (request->n_models > 1 || path[n - 1] == '/' || nqm_os_is_folder(path));
    must(nqm_fit_entry_find(request->models[0], &first, &fault));
    if (path && request->n_models > 1)
        require_folder_name("-o", path, ".safetensors", "the results of several models");
    if (path && !out.folder && !first->encode)
        stop(EXIT_USAGE, "the result of %s is a spec, which is printed: -o %s would not be written", first->name, path);
    if (out.folder)
        make_folder(path);
    if (path && !out.folder)
        require_output(path);
    return out;
}

static nqm_status write_result(const nqm_brdf *brdf, const output *out, fitted *f, nqm_error *err) {
    size_t n = strlen(out->path);
    int used = out->folder ? snprintf(f->path, sizeof f->path, "%s%s%s.safetensors", out->path,
                                      n && out->path[n - 1] == '/' ? "" : "/", f->model)
                           : snprintf(f->path, sizeof f->path, "%s", out->path);
    if (used < 0 || (size_t)used >= sizeof f->path) {
        *err = (nqm_error){.status = NQM_ERR_LIMIT, .message = "the path of the output is too long"};
        return err->status;
    }
    return nqm_brdf_write(brdf, NQM_FILE_SAFETENSORS, NULL, output_path(f->path), NULL, NULL, err);
}

/* Arguments of all fits. */
typedef struct fit_terms {
    const nqm_brdf *ref;
    nqm_match_loss loss;
    const nqm_directions *directions; /* of the metrics */
    nqm_scorer *scorer;
    const output *out;
    bool with_before; /* for the report */
} fit_terms;

/* A list may have no value at any of these directions, and then no score. */
static nqm_status score_fit(const fit_terms *terms, const nqm_brdf *brdf, fitted *f, nqm_error *err) {
    const nqm_status none = NQM_ERR_INCOMPATIBLE;
    f->score = (nqm_score_result){.status = none, .jod = NAN, .jod_low = NAN, .jod_high = NAN, .delta_e = NAN};
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        f->metrics[m] = NAN;
    nqm_status status = measure(terms->ref, brdf, terms->directions, f->metrics, err);
    if (status == NQM_OK)
        status = nqm_scorer_run(terms->scorer, terms->ref, 1, &brdf, &f->score, err);
    return status == none ? NQM_OK : status;
}

static nqm_status fit_one(const fit_terms *terms, const nqm_fit_options *options, fitted *f, nqm_error *err) {
    nqm_brdf *brdf = NULL;
    double begin = nqm_clock_s();
    nqm_status status = nqm_match(terms->ref, f->model, &terms->loss, options, &f->match, &brdf, err);
    const bool is_spec = status == NQM_OK && f->match.fit.spec[0];
    f->seconds = nqm_clock_s() - begin;
    if (status == NQM_OK && strcmp(f->match.selected, nqm_match_uncovered) == 0)
        report(EXIT_OK, "%s, %s: fitted by %s", nqm_brdf_get_info(terms->ref).name, f->model, nqm_match_uncovered);
    if (status == NQM_OK)
        status = score_fit(terms, brdf, f, err);
    if (status == NQM_OK && terms->out->path && !is_spec)
        status = write_result(brdf, terms->out, f, err);
    nqm_brdf_free(brdf);
    if (status == NQM_OK && is_spec && terms->with_before) {
        nqm_match_report before;
        status = nqm_match(terms->ref, f->model, NULL, options, &before, NULL, err);
        memcpy(f->before, before.fit.spec, sizeof f->before);
    }
    return status;
}

/* Fit all models; an error of one of several is reported and stored in its result. Returns the largest exit code. */
static int fit_all(const fit_terms *terms, const fit_request *request, const nqm_fit_options *common, fitted *f) {
    int worst = EXIT_OK;
    for (size_t i = 0; i < request->n_models; ++i) {
        f[i].model = request->models[i];
        nqm_fit_bound bounds[FIT_MAX_BOUNDS];
        nqm_fit_options options = *common;
        options.bounds = bounds;
        for (size_t b = 0; b < request->n_bounds; ++b)
            if (nqm_fit_model_has(f[i].model, request->bounds[b].key))
                bounds[options.n_bounds++] = request->bounds[b];
        note_progress("%s (%zu of %zu)", f[i].model, i + 1, request->n_models);
        nqm_error err = {0};
        if (fit_one(terms, &options, &f[i], &err) == NQM_OK)
            continue;
        f[i].err = err;
        int code = exit_code_of(err.status);
        if (code == EXIT_INTERRUPTED || request->n_models == 1)
            stop_error(&err);
        report(code, "%s: %s", f[i].model, err.message);
        worst = code > worst ? code : worst;
    }
    return worst;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

/* The BRDF argument of the result; NULL if the model failed, or its result is a network or table that was not written. */
static const char *fitted_argument(const fitted *f) {
    if (f->err.status != NQM_OK)
        return NULL;
    return f->match.fit.spec[0] ? f->match.fit.spec : f->path[0] ? f->path : NULL;
}

/* The loss of analytic models is an option; the other models have their own. */
static const char *loss_name(const fitted *f, const char *loss) {
    return f->match.fit.spec[0] ? loss : "own";
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static json_t *to_json(const fitted *f, const char *loss) {
    if (f->err.status != NQM_OK)
        return json_row("spec:s model:s error:s", NULL, f->model, f->err.message);
    const nqm_fit_report *fit = &f->match.fit;
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_get_info((nqm_metric)m).name, json_number(f->metrics[m]));
    const char *argument = fitted_argument(f);
    return json_row("spec:s model:s loss_name:s loss:f numbers:z directions:z seconds:f metrics:o jod:f jod_low:f "
                    "jod_high:f delta_e_itp:f selected:o note:o",
                    argument, f->model, loss_name(f, loss), fit->loss, fit->n_numbers, fit->n_directions, f->seconds,
                    metrics, f->score.jod, f->score.jod_low, f->score.jod_high, f->score.delta_e,
                    *f->match.selected ? json_name(f->match.selected) : NULL,
                    argument ? NULL : json_string("the result is a file: write it with -o FILE"));
}

static void print_fits_as_json(size_t n, const fitted *f, const char *loss) {
    json_t *results = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(results, to_json(&f[i], loss));
    print_document(n == 1 ? json_incref(json_array_get(results, 0)) : json_row("results:O", results));
    json_decref(results);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static void print_table_row(const fitted *f, bool calibrated) {
    const scored_pair score = {.result = f->score, .err = {.status = f->score.status}};
    const char *argument = fitted_argument(f);
    printf("%-18s ", f->model);
    if (f->err.status != NQM_OK) {
        printf("%7s  %9s  %5s  failed\n", "-", "-", "-");
        return;
    }
    printf("%7zu  %9.5f", f->match.fit.n_numbers, f->match.fit.loss);
    print_jod(&score, calibrated);
    printf("  %s\n", argument ? shown(argument) : "(not written: use -o)");
}

static void print_verbose(const fitted *f, const char *loss) {
    const nqm_fit_report *fit = &f->match.fit;
    const char *argument = fitted_argument(f);
    puts(f->model);
    if (f->err.status != NQM_OK) {
        printf("  %-10s %s\n", "failed", shown(f->err.message));
        return;
    }
    printf("  %-10s %s\n", "result", argument ? shown(argument) : "(not written: use -o)");
    printf("  %-10s %zu\n", "numbers", fit->n_numbers);
    printf("  %-10s %.5f (%s), %zu directions, start %zu, %.2f s\n", "loss", fit->loss, loss_name(f, loss),
           fit->n_directions, fit->best_start, f->seconds);
    if (f->match.selected[0])
        printf("  %-10s %s\n", "selected", f->match.selected);
    printf("  %-10s %.2f", "JOD", f->score.jod);
    if (!isnan(f->score.jod_low))
        printf(" [%.2f, %.2f]", f->score.jod_low, f->score.jod_high);
    putchar('\n');
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        printf("  %-10s %.5g\n", nqm_metric_get_info((nqm_metric)m).name, f->metrics[m]);
}

/* Best JOD first, those without one last, otherwise in the order of the models. */
static void print_sorted(size_t n, const fitted *f, bool verbose, const char *loss, bool calibrated) {
    double *jods = allocate(n, sizeof *jods);
    for (size_t i = 0; i < n; ++i)
        jods[i] = f[i].err.status == NQM_OK ? f[i].score.jod : (double)NAN;
    size_t *order = order_by(n, jods, -1);
    if (!verbose)
        printf("%-18s %7s  %9s  %5s%s  spec or file\n", "model", "numbers", "loss", "JOD",
               calibrated ? "  [95 %]        " : "");
    for (size_t i = 0; i < n; ++i) {
        if (verbose && i)
            putchar('\n');
        if (verbose)
            print_verbose(&f[order[i]], loss);
        else
            print_table_row(&f[order[i]], calibrated);
    }
    free(order);
    free(jods);
}

/* Tables with the best JOD first, JSON and arguments in the order of the models. loss: that of
 * the analytic fits; metric: the model that scored all of them. */
static void print_fits(size_t n, const fitted *f, result_format format, bool verbose, const char *loss,
                       const nqm_model *metric) {
    if (format == FORMAT_JSON)
        print_fits_as_json(n, f, loss);
    else if (format == FORMAT_TEXT)
        print_sorted(n, f, verbose, loss, *nqm_model_get_info(metric).calibration);
    for (size_t i = 0; format == FORMAT_QUIET && i < n; ++i)
        if (fitted_argument(&f[i]))
            puts(fitted_argument(&f[i]));
}

/* ---- the report -------------------------------------------------------------------------------------------------- */

/* Each analytic fit after the one under the loss "log", with names like "ggx, loss auto"; networks and tables that were written. */
static void write_fit_report(const char *ref, const fit_request *request, const fitted *f, const char *loss,
                             const char *metric, output_file *out) {
    page_item *items = allocate(1 + 2 * request->n_models, sizeof *items);
    char title[300], name[NAME_SIZE];
    int n = 1;
    items[0].argument = ref;
    for (size_t i = 0; i < request->n_models; ++i) {
        const char *argument = fitted_argument(&f[i]);
        if (f[i].before[0] && strcmp(f[i].before, argument) != 0) {
            snprintf(items[n].name, NAME_SIZE, "%s, loss log (before)", f[i].model);
            items[n++].argument = f[i].before;
        }
        if (!argument)
            continue;
        const bool is_spec = f[i].match.fit.spec[0];
        snprintf(items[n].name, NAME_SIZE, "%s%s%s", f[i].model, is_spec ? ", loss " : "", is_spec ? loss : "");
        items[n++].argument = argument;
    }
    if (n == 1)
        stop(EXIT_USAGE, "--report: there is no result to show; networks and tables need -o");
    short_name(ref, name, sizeof name);
    snprintf(title, sizeof title, "Fits to %s by the loss %.60s", name, loss);
    write_fit_page(title, n, items, metric, out);
    free(items);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static void warn_unwritten(const fit_request *request, const fitted *f) {
    for (size_t i = 0; i < request->n_models; ++i)
        if (f[i].err.status == NQM_OK && !fitted_argument(&f[i]))
            report(EXIT_OK, "%s: the result is a file, not a spec: write it with -o FILE", f[i].model);
}

/* The models that the loss needs; its faults are found before the work. */
static void open_loss(const char *text, const char *transport, nqm_model *metric, nqm_match_loss *loss) {
    nqm_match_sum sum;
    must(nqm_match_parse(text, &sum, &fault));
    bool needs_transport = sum.is_auto;
    for (size_t i = 0; i < sum.n; ++i)
        needs_transport |= sum.terms[i].kind == NQM_MATCH_TRANSPORT;
    *loss = (nqm_match_loss){text, metric, needs_transport ? open_model(transport) : NULL, open_judge(text, transport)};
}

static nqm_fit_options fit;
static const char *model = "ggx", *loss = "auto", *metric = "default", *transport = "transport";
static const char *directions_name, *bounds, *path, *page;
static bool verbose;
static result_format format;

static const option options[] = {
    {"model", 'm', OPTION_TEXT, &model, "NAME,...",
     "models, 'all' lobes and networks, 'encodings' (the nine of the paper), or 'shading' (of renderers)", 0, 0},
    {"loss", 0, OPTION_TEXT, &loss, "SUM|auto",
     "loss of analytic models: a sum like log_diff+0.2*nqm of nqm, transport, log, log-cos, cube-root, linear and "
     "scalar metrics; auto: the best of several",
     0, 0},
    {"metric", 0, OPTION_TEXT, &metric, "MODEL", "the model of the loss nqm and of the printed JOD", 0, 0},
    {"transport", 0, OPTION_TEXT, &transport, "MODEL",
     "the model of the loss transport (nqm transport make); other than 'transport', it also makes the choice of auto",
     0, 0},
    {"output", 'o', OPTION_TEXT, &path, "FILE.safetensors|DIR/",
     "file of a network or table (DIR/MODEL.safetensors for several models)", 0, 0},
    {"bounds", 0, OPTION_TEXT, &bounds, "KEY=LOW:HIGH,...", "narrower ranges of parameters (not of networks and codes)",
     0, 0},
    {"directions", 0, OPTION_TEXT, &directions_name, "WHERE",
     "directions of the metrics (default: those of `nqm score`)", 0, 0},
    {"report", 0, OPTION_TEXT, &page, "FILE.html", "write a page with pictures of the fits and of those by log", 0, 0},
    {"verbose", 0, OPTION_FLAG, &verbose, NULL, "print all results of each fit", 0, 0},
    {"quiet", 'q', OPTION_FORMAT, &format, NULL, "print specs and paths only", FORMAT_QUIET, 0},
    {"json", 0, OPTION_FORMAT, &format, NULL, "print the result as JSON", FORMAT_JSON, 0},
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "REF|FOLDER [options]",
    .about =
        "Encode a BRDF. The result of an analytic model (an RGB lobe over a Lambert base) is a spec; networks "
        "and coded tables are files, written with -o. Every other verb takes the printed spec or path as a BRDF. Of a "
        "folder each BRDF is fitted.",
    .example = "nqm fit sgd:nickel --model ward\n"
               "nqm fit measured.bsdf --model ggx --report ggx.html\n"
               "nqm fit measured.bsdf --model all -o fits/\n"
               "nqm score measured.bsdf \"$(nqm fit measured.bsdf --model ggx -q)\"",
    .options = options,
    .table = &nqm_fit_option_table,
    .table_target = &fit,
    .min_arguments = 1,
};

/* Fit one reference, which is freed, and print; shown_as NULL: the only one. */
static int fit_reference(nqm_brdf *ref, const char *argument, const char *shown_as, const fit_request *request,
                         fit_terms *terms) {
    fitted *results = allocate(request->n_models, sizeof *results);
    report_remark(ref);
    report_distance(argument, ref, terms->directions);
    terms->ref = ref;
    output_file page_file = {0};
    if (page)
        open_page("--report", page, &page_file);
    const int exit_code = fit_all(terms, request, &fit, results);
    end_progress();
    if (format == FORMAT_QUIET || request->n_models == 1) /* otherwise the table says it */
        warn_unwritten(request, results);
    if (page)
        write_fit_report(argument, request, results, loss, metric, &page_file);
    if (shown_as && format == FORMAT_TEXT)
        printf("reference  %s\n", shown(shown_as));
    print_fits(request->n_models, results, format, verbose, loss, terms->loss.metric);
    nqm_brdf_free(ref);
    free(results);
    return exit_code;
}

/* Each BRDF of a folder; those that cannot be opened are named. */
static int fit_folder(const char *folder, const fit_request *request, fit_terms *terms) {
    int exit_code = EXIT_OK;
    if (path || page || format == FORMAT_JSON)
        stop(EXIT_USAGE,
             "%s is a folder: its fits are printed as text or with --quiet, without -o, --report and --json", folder);
    nqm_library *of = open_library(1, &folder, NULL, NULL);
    for (size_t i = 0; i < of->n; ++i) {
        const nqm_library_member *m = &of->members[i];
        nqm_brdf *ref = NULL;
        nqm_error err = {0};
        const nqm_status status = nqm_brdf_open(m->argument, &ref, &err);
        const int code =
            status == NQM_OK ? fit_reference(ref, m->argument, m->key, request, terms) : exit_code_of(status);
        if (status != NQM_OK)
            report(code, "%s", err.message);
        exit_code = exit_code == EXIT_OK ? code : exit_code;
    }
    nqm_library_free(of);
    return exit_code;
}

int cmd_fit(int argc, char **argv) {
    fit = nqm_fit_options_default();
    fit.progress = show_progress;
    parse_arguments(&cmd, argc, argv);
    fit_request request = {0};
    choose_models(model, &request);
    choose_bounds(bounds, &request);
    nqm_model *metric_model = open_model(metric);
    const nqm_score_options score_options = plain_score_options();
    fit_terms terms = {.with_before = page};
    open_loss(loss, transport, metric_model, &terms.loss);
    terms.scorer = open_scorer(metric_model, &score_options);
    nqm_directions *directions = open_directions(directions_name);
    const output out = prepare_output(path, &request);
    terms.directions = directions;
    terms.out = &out;
    const int exit_code = (is_library(argv[0]) ? fit_folder(argv[0], &request, &terms)
                                               : fit_reference(open_brdf(argv[0]), argv[0], NULL, &request, &terms));
    nqm_scorer_free(terms.scorer);
    nqm_model_free((nqm_model *)(uintptr_t)terms.loss.transport);
    nqm_scene_free((nqm_scene *)(uintptr_t)terms.loss.scene);
    nqm_model_free(metric_model);
    nqm_directions_free(directions);
    return exit_code;
}
