/* SPDX-License-Identifier: MIT
 *
 * nqm fit - fit analytic models to a BRDF; the result is a spec that every other verb takes.
 */
#include "tool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const model_names[] = {"ward", "ggx"};
enum { N_MODELS = sizeof model_names / sizeof *model_names };

typedef struct fitted {
    const char *model;
    nqm_fit_report fit;
    double metrics[NQM_METRIC_COUNT];
} fitted;

static nqm_status measure(const nqm_brdf *ref, const nqm_directions *directions, fitted *f, nqm_error *err) {
    size_t n = nqm_directions_count(directions);
    nqm_brdf *test = NULL;
    float *rgb = calloc(6 * n, sizeof *rgb);
    uint8_t *flag = calloc(n, 1), *used = calloc(n, 1);
    nqm_status status = NQM_ERR_NOMEM;
    if (!rgb || !flag || !used) {
        snprintf(err->message, sizeof err->message, "out of memory");
        err->status = status;
        goto done;
    }
    status = nqm_brdf_open(f->fit.spec, &test, err);
    if (status == NQM_OK)
        status = nqm_sample(ref, directions, NQM_INVALID_DROP, rgb, flag, NULL, err);
    if (status == NQM_OK)
        status = nqm_sample(test, directions, NQM_INVALID_DROP, rgb + 3 * n, NULL, NULL, err);
    if (status != NQM_OK)
        goto done;
    for (size_t i = 0; i < n; ++i)
        used[i] = flag[i] == NQM_VALUE_OK || flag[i] == NQM_VALUE_CLAMPED;
    nqm_metrics_compute(directions, rgb, rgb + 3 * n, used, f->metrics);
done:
    free(rgb);
    free(flag);
    free(used);
    nqm_brdf_free(test);
    return status;
}

static json_t *to_json(const fitted *f, nqm_fit_loss loss) {
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), json_number(f->metrics[m]));
    return json_pack("{s:s,s:s,s:s,s:o,s:o}", "spec", f->fit.spec, "model", f->model, "loss_name",
                     nqm_fit_loss_name(loss), "loss", json_number(f->fit.loss), "metrics", metrics);
}

static int print_as_json(size_t n, const fitted *f, nqm_fit_loss loss) {
    json_t *root = json_pack("{s:i,s:o}", "schema", 1, "tool", json_tool());
    if (n == 1) {
        json_object_update_new(root, to_json(f, loss));
        return print_json(root);
    }
    json_t *results = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(results, to_json(&f[i], loss));
    json_object_set_new(root, "results", results);
    return print_json(root);
}

static void print_as_text(size_t n, const fitted *f, nqm_fit_loss loss, bool quiet) {
    for (size_t i = 0; i < n; ++i) {
        puts(f[i].fit.spec);
        if (quiet)
            continue;
        printf("  %-10s %.5f  RMS residual of the '%s' loss, %zu directions\n", "loss", f[i].fit.loss,
               nqm_fit_loss_name(loss), f[i].fit.n_directions);
        for (int m = 0; m < NQM_METRIC_COUNT; ++m)
            printf("  %-10s %.5g\n", nqm_metric_name((nqm_metric)m), f[i].metrics[m]);
    }
}

/* Fit all models that `which` names; *n_ret of them. */
static nqm_status fit_models(const nqm_brdf *ref, const char *which, const nqm_fit_options *options,
                             const nqm_directions *directions, fitted *f, size_t *n_ret, nqm_error *err) {
    bool all = strcmp(which, "all") == 0;
    size_t n = all ? N_MODELS : 1;
    for (size_t i = 0; i < n; ++i) {
        f[i].model = all ? model_names[i] : which;
        nqm_status status = nqm_fit(ref, f[i].model, options, &f[i].fit, NULL, err);
        if (status == NQM_OK)
            status = measure(ref, directions, &f[i], err);
        if (status != NQM_OK)
            return status;
    }
    *n_ret = n;
    return NQM_OK;
}

int cmd_fit(int argc, char **argv) {
    nqm_fit_options fit = nqm_fit_options_default();
    fit.progress = show_progress;
    const char *model = "ggx", *loss = nqm_fit_loss_name(fit.loss), *directions_name = NULL;
    bool json = false, quiet = false;
    uint64_t n_directions = fit.n_directions;
    double max_polar_deg = 80;
    const option options[] = {
        {.name = "model",
         .letter = 'm',
         .kind = OPTION_TEXT,
         .target = &model,
         .metavar = "NAME",
         .help = "ward, ggx or all"},
        {.name = "loss",
         .kind = OPTION_TEXT,
         .target = &loss,
         .metavar = "NAME",
         .help = "log, log-cos, cube-root or linear"},
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
        {.name = "quiet", .letter = 'q', .kind = OPTION_FLAG, .target = &quiet, .help = "print the spec only"},
        {.name = "json", .kind = OPTION_FLAG, .target = &json, .help = "print the result as JSON"},
        {0}};
    const command cmd = {
        .name = "fit",
        .usage = "REF [options]",
        .about =
            "Fit an analytic model to a BRDF: an RGB lobe over a Lambert base. Some of the direction pairs lie dense\n"
            "around the mirror direction, so that sharp highlights are kept. The result is a spec for every other "
            "verb.",
        .example = "nqm fit sgd:nickel --model ward\n"
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
    fit.max_polar_rad = max_polar_deg * acos(-1) / 180;

    nqm_error err = {0};
    nqm_brdf *ref = NULL;
    nqm_directions *directions = NULL;
    fitted results[N_MODELS] = {0};
    size_t n = 0;
    exit_code = open_directions("fit", directions_name, &directions);
    if (exit_code != EXIT_OK)
        return exit_code;
    nqm_status status = nqm_brdf_open(argv[0], &ref, &err);
    if (status == NQM_OK)
        status = fit_models(ref, model, &fit, directions, results, &n, &err);
    nqm_directions_free(directions);
    nqm_brdf_free(ref);
    if (status != NQM_OK)
        return report_error("fit", &err);
    if (json)
        return print_as_json(n, results, fit.loss);
    end_progress();
    print_as_text(n, results, fit.loss, quiet);
    return EXIT_OK;
}
