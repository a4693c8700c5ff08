/* SPDX-License-Identifier: MIT
 *
 * nqm fit - encode a BRDF: fit analytic models, train a network, use a learned dictionary or hypernetwork. The result is a
 * spec or a file.
 */
#include "fit/fit.h"
#include "nqm/fit/fit_tool.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

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

/* ---- files of results -------------------------------------------------------------------------------------------- */

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

/* ---- fits -------------------------------------------------------------------------------------------------------- */

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
