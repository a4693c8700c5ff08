/* SPDX-License-Identifier: MIT
 *
 * nqm fit - encode a BRDF: fit analytic models, train a network, use a learned dictionary or hypernetwork. The result is a
 * spec or a file.
 */
#include "fit/fit.h"
#include "nqm/tool.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FIT_MAX_MODELS = 32, FIT_MAX_BOUNDS = 8, FIT_MAX_PATH = 4096 };

/* The models to fit, in the order of the command line. */
typedef struct fit_request {
    const char *models[FIT_MAX_MODELS]; /* names of the library */
    size_t n_models;
    char bound_keys[FIT_MAX_BOUNDS][16];
    nqm_fit_bound bounds[FIT_MAX_BOUNDS]; /* their keys are the texts above */
    size_t n_bounds;
} fit_request;

/* The result of one model. */
typedef struct fitted {
    const char *model;
    nqm_error err; /* status NQM_OK, or the error of the model: then the fields below are not set */
    nqm_fit_report fit;
    double metrics[NQM_METRIC_COUNT];
    double seconds;
    char path[FIT_MAX_PATH]; /* of the file written; "" if the result is a spec or was not written */
} fitted;

/* ---- arguments --------------------------------------------------------------------------------------------------- */

static _Noreturn void stop_unknown(const char *name, size_t n_name) {
    char names[600] = "";
    size_t used = 0;
    for (size_t i = 0; nqm_fit_model(i) && used < sizeof names; ++i)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", nqm_fit_model(i));
    stop(EXIT_USAGE, "cannot fit a model '%.*s'; there are all, encodings, %s", n_name < 40 ? (int)n_name : 40, name,
         names);
}

static void add_model(fit_request *request, const char *name) {
    for (size_t i = 0; i < request->n_models; ++i)
        if (request->models[i] == name)
            return;
    if (request->n_models < FIT_MAX_MODELS)
        request->models[request->n_models++] = name;
}

/* "all", "encodings", or names separated by commas. */
static void choose_models(const char *text, fit_request *request) {
    size_t n = strcmp(text, "all") == 0 ? FIT_MAX_MODELS : strcmp(text, "encodings") == 0 ? NQM_FIT_N_ENCODINGS : 0;
    for (size_t i = 0; i < n && nqm_fit_model(i); ++i)
        add_model(request, nqm_fit_model(i));
    for (size_t n_name = 0; n == 0; text += n_name + 1) {
        size_t i = 0;
        n_name = strcspn(text, ",");
        while (nqm_fit_model(i) && !(strncmp(nqm_fit_model(i), text, n_name) == 0 && nqm_fit_model(i)[n_name] == 0))
            ++i;
        if (!nqm_fit_model(i))
            stop_unknown(text, n_name);
        add_model(request, nqm_fit_model(i));
        if (!text[n_name])
            break;
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
        if (sscanf(text, "%15[^=,]=%lf:%lf%n", key, &bound->low, &bound->high, &n) != 3 || (text[n] && text[n] != ','))
            stop(EXIT_USAGE, "--bounds takes KEY=LOW:HIGH,..., not '%.80s'", text);
        n += text[n] == ',';
        bound->key = key;
        bool known = false;
        for (size_t m = 0; m < request->n_models; ++m)
            known |= nqm_fit_model_has(request->models[m], key) != 0;
        if (!known)
            stop(EXIT_USAGE, "none of the models has a lobe parameter '%s'", key);
    }
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

/* The metrics of `test` against `ref`, at the directions where `ref` has values. */
static nqm_status measure(const nqm_brdf *ref, const nqm_brdf *test, const nqm_directions *directions, double *metrics,
                          nqm_error *err) {
    size_t n = nqm_directions_count(directions);
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
        nqm_metrics_compute(directions, rgb, rgb + 3 * n, used, metrics);
    nqm_free(rgb);
    return status;
}

/* Where results are written: a file, or a folder for several models and for paths that name one. */
typedef struct output {
    const char *path; /* NULL: results are not written */
    bool folder;
} output;

static output prepare_output(const char *path, size_t n_models) {
    output out = {.path = path};
    size_t n = path ? strlen(path) : 0;
    out.folder = n > 0 && (n_models > 1 || path[n - 1] == '/' || is_folder(path));
    if (out.folder && !is_folder(path) && mkdir(path, 0777) != 0)
        stop(EXIT_OPEN, "%s: cannot create this folder", path);
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
    return nqm_brdf_save(brdf, output_path(f->path), err);
}

static nqm_status fit_one(const nqm_brdf *ref, const nqm_fit_options *options, const nqm_directions *directions,
                          const output *out, fitted *f, nqm_error *err) {
    nqm_brdf *brdf = NULL;
    double begin = nqm_clock_s();
    nqm_status status = nqm_fit(ref, f->model, options, &f->fit, &brdf, err);
    f->seconds = nqm_clock_s() - begin;
    if (status == NQM_OK)
        status = measure(ref, brdf, directions, f->metrics, err);
    if (status == NQM_OK && out->path && !f->fit.spec[0])
        status = write_result(brdf, out, f, err);
    nqm_brdf_free(brdf);
    return status;
}

/* Fit all models; an error of one of several is reported and stored in its result. Returns the largest exit code. */
static int fit_all(const nqm_brdf *ref, const fit_request *request, const nqm_fit_options *common,
                   const nqm_directions *directions, const output *out, fitted *f) {
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
        if (fit_one(ref, &options, directions, out, &f[i], &err) == NQM_OK)
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

/* ---- output ------------------------------------------------------------------------------------------------------ */

/* The BRDF argument of the result; NULL if the model failed, or its result is a network or table that was not written. */
static const char *fitted_argument(const fitted *f) {
    if (f->err.status != NQM_OK)
        return NULL;
    return f->fit.spec[0] ? f->fit.spec : f->path[0] ? f->path : NULL;
}

/* The loss of analytic models is an option; the other models have their own. */
static const char *loss_name(const fitted *f, nqm_fit_loss loss) {
    return f->fit.spec[0] ? nqm_fit_loss_words[loss] : "own";
}

static json_t *to_json(const fitted *f, nqm_fit_loss loss) {
    if (f->err.status != NQM_OK)
        return json_pack("{s:n,s:s,s:o}", "spec", "model", f->model, "error", json_name(f->err.message));
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), json_number(f->metrics[m]));
    const char *argument = fitted_argument(f);
    json_t *row = json_pack("{s:o,s:s,s:s,s:o,s:I,s:I,s:o,s:o}", "spec", argument ? json_name(argument) : json_null(),
                            "model", f->model, "loss_name", loss_name(f, loss), "loss", json_number(f->fit.loss),
                            "numbers", (json_int_t)f->fit.n_numbers, "directions", (json_int_t)f->fit.n_directions,
                            "seconds", json_number(f->seconds), "metrics", metrics);
    if (!argument)
        json_object_set_new(row, "note", json_string("the result is a file: write it with -o FILE"));
    return row;
}

static void print_fits_as_json(size_t n, const fitted *f, nqm_fit_loss loss) {
    json_t *results = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(results, to_json(&f[i], loss));
    print_document(n == 1 ? json_incref(json_array_get(results, 0)) : json_pack("{s:O}", "results", results));
    json_decref(results);
}

static void print_fits_as_table(size_t n, const fitted *f) {
    printf("%-18s %8s %9s %9s  %s\n", "model", "numbers", "loss", "ma_crwe", "spec or file");
    for (size_t i = 0; i < n; ++i) {
        const char *argument = fitted_argument(&f[i]);
        if (f[i].err.status != NQM_OK)
            printf("%-18s %8s %9s %9s  failed\n", f[i].model, "-", "-", "-");
        else
            printf("%-18s %8zu %9.5f %9.5f  %s\n", f[i].model, f[i].fit.n_numbers, f[i].fit.loss,
                   f[i].metrics[NQM_METRIC_MA_CRWE], argument ? argument : "(not written: use -o)");
    }
}

static void print_fit_report(size_t n, const fitted *f, nqm_fit_loss loss) {
    for (size_t i = 0; i < n; ++i) {
        const fitted *one = &f[i];
        const char *argument = fitted_argument(one);
        printf("%s%s\n", i ? "\n" : "", one->model);
        if (one->err.status != NQM_OK) {
            printf("  %-10s %s\n", "failed", one->err.message);
            continue;
        }
        printf("  %-10s %s\n", "result", argument ? argument : "(not written: use -o)");
        printf("  %-10s %zu\n", "numbers", one->fit.n_numbers);
        printf("  %-10s %.5f (%s), %zu directions, start %zu, %.2f s\n", "loss", one->fit.loss, loss_name(one, loss),
               one->fit.n_directions, one->fit.best_start, one->seconds);
        for (int m = 0; m < NQM_METRIC_COUNT; ++m)
            printf("  %-10s %.5g\n", nqm_metric_name((nqm_metric)m), one->metrics[m]);
    }
}

static void print_arguments(size_t n, const fitted *f) {
    for (size_t i = 0; i < n; ++i)
        if (fitted_argument(&f[i]))
            puts(fitted_argument(&f[i]));
}

static void warn_unwritten(const fit_request *request, const output *out, const fitted *f) {
    for (size_t i = 0; i < request->n_models; ++i)
        if (f[i].err.status == NQM_OK && !fitted_argument(&f[i]))
            report(EXIT_OK, "%s: the result is a file, not a spec: write it with -o FILE", f[i].model);
    if (out->path && !out->folder && f[0].fit.spec[0])
        report(EXIT_OK, "the result is a spec: %s is not written", out->path);
}

int cmd_fit(int argc, char **argv) {
    nqm_fit_options fit = nqm_fit_options_default();
    fit.progress = show_progress;
    const char *model = "ggx", *directions_name = NULL, *bounds = NULL, *path = NULL;
    bool json = false, quiet = false, full = false;
    const option options[] = {
        {"model", 'm', OPTION_TEXT, &model, "NAME,...", "models, 'all', or 'encodings' (the nine of the paper)", 0, 0},
        {"output", 'o', OPTION_TEXT, &path, "FILE|DIR/",
         "file of a network or table (DIR/MODEL.safetensors for several models)", 0, 0},
        {"bounds", 0, OPTION_TEXT, &bounds, "KEY=LOW:HIGH,...", "narrower ranges of lobe parameters (analytic models)",
         0, 0},
        {"directions", 0, OPTION_TEXT, &directions_name, "WHERE",
         "directions of the metrics (default: those of `nqm score`)", 0, 0},
        {"report", 0, OPTION_FLAG, &full, NULL, "print all results of each fit", 0, 0},
        {"quiet", 'q', OPTION_FLAG, &quiet, NULL, "print specs and paths only", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print the result as JSON", 0, 0},
        {0}};
    const command cmd = {
        .usage = "REF [options]",
        .about =
            "Encode a BRDF. The result of an analytic model (an RGB lobe over a Lambert base) is a spec; networks and\n"
            "coded tables are files, written with -o. Every other verb takes the printed spec or path as a BRDF.",
        .example = "nqm fit sgd:nickel --model ward\n"
                   "nqm fit measured.bsdf --model all -o fits/\n"
                   "nqm score measured.bsdf \"$(nqm fit measured.bsdf --model ggx -q)\"",
        .options = options,
        .table = &nqm_fit_option_table,
        .table_target = &fit,
        .min_arguments = 1,
    };
    parse_arguments(&cmd, argc, argv);
    fit_request request = {0};
    choose_models(model, &request);
    choose_bounds(bounds, &request);
    fitted *results = allocate(request.n_models, sizeof *results);
    nqm_directions *directions = open_directions(directions_name);
    nqm_brdf *ref = open_brdf(argv[0]);
    const output out = prepare_output(path, request.n_models);
    const int exit_code = fit_all(ref, &request, &fit, directions, &out, results);
    end_progress();
    warn_unwritten(&request, &out, results);
    if (json)
        print_fits_as_json(request.n_models, results, fit.loss);
    else if (quiet)
        print_arguments(request.n_models, results);
    else if (full)
        print_fit_report(request.n_models, results, fit.loss);
    else
        print_fits_as_table(request.n_models, results);
    nqm_brdf_free(ref);
    nqm_directions_free(directions);
    free(results);
    return exit_code;
}
