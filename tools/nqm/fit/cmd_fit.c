/* SPDX-License-Identifier: MIT
 *
 * nqm fit - encode a BRDF: fit analytic models, train a network, code it with what was learned; the result is a spec or
 * a file that every other verb takes.
 */
#include "nqm/fit/fit_tool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The metrics of `test` against `ref`, where `ref` has values. */
static nqm_status measure(const nqm_brdf *ref, const nqm_brdf *test, const nqm_directions *directions, double *metrics,
                          nqm_error *err) {
    size_t n = nqm_directions_count(directions);
    float *rgb = calloc(6 * n, sizeof *rgb);
    uint8_t *flag = calloc(n, 1), *used = calloc(n, 1);
    nqm_status status = NQM_ERR_NOMEM;
    if (rgb && flag && used) {
        status = nqm_sample(ref, directions, NQM_INVALID_DROP, rgb, flag, NULL, err);
        if (status == NQM_OK)
            status = nqm_sample(test, directions, NQM_INVALID_DROP, rgb + 3 * n, NULL, NULL, err);
        for (size_t i = 0; i < n; ++i)
            used[i] = flag[i] == NQM_VALUE_OK || flag[i] == NQM_VALUE_CLAMPED;
        if (status == NQM_OK)
            nqm_metrics_compute(directions, rgb, rgb + 3 * n, used, metrics);
    } else
        *err = (nqm_error){.status = status, .message = "out of memory"};
    free(rgb);
    free(flag);
    free(used);
    return status;
}

/* ---- files of results -------------------------------------------------------------------------------------------- */

static bool is_folder(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

/* Where the results go: a file, or a folder when there are several models or it is written as one. */
typedef struct output {
    const char *path; /* NULL: nowhere */
    bool folder;
} output;

static int prepare_output(const char *path, size_t n_models, output *out) {
    *out = (output){.path = path};
    if (!path)
        return EXIT_OK;
    size_t n = strlen(path);
    out->folder = n_models > 1 || (n && path[n - 1] == '/') || is_folder(path);
    if (out->folder && !is_folder(path) && mkdir(path, 0777) != 0)
        return report("fit", EXIT_OPEN, "%s: cannot make this folder", path);
    return EXIT_OK;
}

static nqm_status keep(const nqm_brdf *brdf, const output *out, fitted *f, nqm_error *err) {
    size_t n = strlen(out->path);
    int used = out->folder ? snprintf(f->path, sizeof f->path, "%s%s%s.safetensors", out->path,
                                      n && out->path[n - 1] == '/' ? "" : "/", f->model)
                           : snprintf(f->path, sizeof f->path, "%s", out->path);
    if (used < 0 || (size_t)used >= sizeof f->path) {
        *err = (nqm_error){.status = NQM_ERR_LIMIT, .message = "the path of the output is too long"};
        return err->status;
    }
    return nqm_brdf_save(brdf, f->path, err);
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

static nqm_status fit_one(const nqm_brdf *ref, const nqm_fit_options *options, const nqm_directions *directions,
                          const output *out, fitted *f, nqm_error *err) {
    nqm_brdf *brdf = NULL;
    double begin = now_s();
    nqm_status status = nqm_fit(ref, f->model, options, &f->fit, &brdf, err);
    f->seconds = now_s() - begin;
    if (status == NQM_OK)
        status = measure(ref, brdf, directions, f->metrics, err);
    if (status == NQM_OK && out->path && !f->fit.spec[0])
        status = keep(brdf, out, f, err);
    nqm_brdf_free(brdf);
    return status;
}

/* Fit all; faults of single models are told and kept. Returns the worst exit code. */
static int fit_all(const nqm_brdf *ref, const fit_wishes *wishes, const nqm_fit_options *common,
                   const nqm_directions *directions, const output *out, fitted *f) {
    int worst = EXIT_OK;
    for (size_t i = 0; i < wishes->n_models; ++i) {
        f[i].model = wishes->models[i];
        nqm_fit_bound bounds[FIT_MAX_BOUNDS];
        nqm_fit_options options = *common;
        options.bounds = bounds;
        for (size_t b = 0; b < wishes->n_bounds; ++b)
            if (nqm_fit_model_has(f[i].model, wishes->bounds[b].key))
                bounds[options.n_bounds++] = wishes->bounds[b];
        note_progress("%s (%zu of %zu)", f[i].model, i + 1, wishes->n_models);
        nqm_error err = {0};
        if (fit_one(ref, &options, directions, out, &f[i], &err) == NQM_OK)
            continue;
        f[i].err = err;
        int code = exit_code_of(err.status);
        if (code == EXIT_INTERRUPTED || wishes->n_models == 1)
            return report_error("fit", &err);
        report("fit", code, "%s: %s", f[i].model, err.message);
        worst = code > worst ? code : worst;
    }
    return worst;
}

static void print_arguments(size_t n, const fitted *f) {
    for (size_t i = 0; i < n; ++i)
        if (fitted_argument(&f[i]))
            puts(fitted_argument(&f[i]));
}

static void tell_what_is_lost(const fit_wishes *wishes, const output *out, const fitted *f) {
    for (size_t i = 0; i < wishes->n_models; ++i)
        if (f[i].err.status == NQM_OK && !fitted_argument(&f[i]))
            fprintf(stderr, "nqm fit: %s: the result is a file, not a spec: -o FILE keeps it\n", f[i].model);
    if (out->path && !out->folder && f[0].fit.spec[0])
        fprintf(stderr, "nqm fit: the result is a spec: %s is not written\n", out->path);
}

int cmd_fit(int argc, char **argv) {
    nqm_fit_options fit = nqm_fit_options_default();
    fit.progress = show_progress;
    const char *model = "ggx", *loss = nqm_fit_loss_name(fit.loss), *directions_name = NULL, *bounds = NULL,
               *path = NULL;
    bool json = false, quiet = false, full = false;
    uint64_t n_directions = fit.n_directions, n_starts = fit.n_starts;
    double max_polar_deg = 80;
    const option options[] = {
        {.name = "model",
         .letter = 'm',
         .kind = OPTION_TEXT,
         .target = &model,
         .metavar = "NAME,...",
         .help = "models, or all, or encodings (the nine of the paper)"},
        {.name = "output",
         .letter = 'o',
         .kind = OPTION_TEXT,
         .target = &path,
         .metavar = "FILE|DIR/",
         .help = "where a network or table goes (DIR/MODEL.safetensors for several)"},
        {.name = "loss",
         .kind = OPTION_TEXT,
         .target = &loss,
         .metavar = "NAME",
         .help = "log, log-cos, cube-root or linear (analytic models)"},
        {.name = "bounds",
         .kind = OPTION_TEXT,
         .target = &bounds,
         .metavar = "KEY=LOW:HIGH,...",
         .help = "narrower ranges of lobe parameters (analytic models)"},
        {.name = "starts",
         .kind = OPTION_COUNT,
         .target = &n_starts,
         .metavar = "N",
         .help = "lobe widths to start from (analytic models)",
         .min = 1,
         .max = 100},
        {.name = "samples",
         .kind = OPTION_COUNT,
         .target = &n_directions,
         .metavar = "N",
         .help = "direction pairs of the fit",
         .min = 200,
         .max = 1000000},
        {.name = "max-polar",
         .kind = OPTION_NUMBER,
         .target = &max_polar_deg,
         .metavar = "DEG",
         .help = "largest polar angle of the fit",
         .min = 10,
         .max = 89.9},
        {.name = "seed", .kind = OPTION_COUNT, .target = &fit.seed, .metavar = "N", .help = "of the direction pairs"},
        {.name = "directions",
         .kind = OPTION_TEXT,
         .target = &directions_name,
         .metavar = "WHERE",
         .help = "where the metrics are taken (default: as `nqm score`)"},
        {.name = "report", .kind = OPTION_FLAG, .target = &full, .help = "print everything about each fit"},
        {.name = "quiet", .letter = 'q', .kind = OPTION_FLAG, .target = &quiet, .help = "print specs and paths only"},
        {.name = "json", .kind = OPTION_FLAG, .target = &json, .help = "print the result as JSON"},
        {0}};
    const command cmd = {
        .name = "fit",
        .usage = "REF [options]",
        .about =
            "Encode a BRDF. Analytic models (an RGB lobe over a Lambert base) become specs; networks and coded tables\n"
            "become files with -o. What is printed for a model is what every other verb takes.",
        .example = "nqm fit sgd:nickel --model ward\n"
                   "nqm fit measured.bsdf --model all -o fits/\n"
                   "nqm score measured.bsdf \"$(nqm fit measured.bsdf --model ggx -q)\"",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (!nqm_fit_loss_parse(loss, &fit.loss))
        return report("fit", EXIT_USAGE, "there is no loss '%s'; there are log, log-cos, cube-root and linear", loss);
    fit.n_directions = (size_t)n_directions;
    fit.n_starts = (size_t)n_starts;
    fit.max_polar_rad = max_polar_deg * acos(-1) / 180;
    fit_wishes wishes = {0};
    exit_code = choose_models(model, &wishes);
    if (exit_code == EXIT_OK)
        exit_code = choose_bounds(bounds, &wishes);
    if (exit_code != EXIT_OK)
        return exit_code;

    nqm_directions *directions = NULL;
    nqm_brdf **ref = NULL;
    output out = {0};
    fitted *results = calloc(wishes.n_models, sizeof *results);
    if (!results)
        return report("fit", EXIT_LIMIT, "out of memory");
    exit_code = open_directions("fit", directions_name, &directions);
    if (exit_code == EXIT_OK)
        exit_code = open_brdfs("fit", 1, argv, &ref);
    if (exit_code == EXIT_OK)
        exit_code = prepare_output(path, wishes.n_models, &out);
    if (exit_code != EXIT_OK)
        goto done;
    exit_code = fit_all(*ref, &wishes, &fit, directions, &out, results);
    end_progress();
    if (exit_code == EXIT_INTERRUPTED || (exit_code != EXIT_OK && wishes.n_models == 1))
        goto done;
    tell_what_is_lost(&wishes, &out, results);
    if (json) {
        int printed = print_fits_as_json(wishes.n_models, results, fit.loss);
        exit_code = exit_code == EXIT_OK ? printed : exit_code;
    } else if (quiet)
        print_arguments(wishes.n_models, results);
    else if (full)
        print_fit_report(wishes.n_models, results, fit.loss);
    else
        print_fits_as_table(wishes.n_models, results);
done:
    if (ref)
        close_brdfs(1, ref);
    nqm_directions_free(directions);
    free(results);
    return exit_code;
}
