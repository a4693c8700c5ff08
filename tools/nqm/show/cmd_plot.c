/* SPDX-License-Identifier: MIT
 *
 * nqm plot - drawings of labels, evaluations, trainings, models and BRDFs.
 */
#include "figures/plot.h"
#include "nqm/tool.h"

#include <stdlib.h>

enum { MAX_INPUTS = 8 };

typedef struct plot_arguments {
    const char *output, *predictor;
    nqm_plot_options look;
    double theta_d_deg, phi_d_deg, azimuth_deg;
    int n;
    char **inputs; /* (n) */
} plot_arguments;

enum { CURVE, BARS, SCATTER, LOSS, DIRECTIONS, SLICE, ATTRIBUTION, NETWORK, SIZES };
static const choice drawings[] = {
    [CURVE] = {"curve", "LABELS.csv", "JOD against Delta-E ITP, with the fitted curve"},
    [BARS] = {"bars", "EVAL.json",
              "Spearman correlations, or predicted choices, with 95 % intervals, from `nqm eval --json`"},
    [SCATTER] = {"scatter", "PAIRS.csv", "predicted JOD against the label or human score, from `nqm eval --pairs`"},
    [LOSS] = {"loss", "LOG.csv...", "losses and learning rate, from `nqm train --log`"},
    [DIRECTIONS] = {"directions", "[MODEL|FILE.csv]", "the sampling directions"},
    [SLICE] = {"slice", "BRDF...", "slices and polar lobes of up to 8 BRDFs"},
    [ATTRIBUTION] = {"attribution", "REF TEST", "where two BRDFs differ, over (theta_h, theta_d)"},
    [NETWORK] = {"network", "[MODEL]", "the layers of a model"},
    [SIZES] = {"sizes", "SCORES.csv", "JOD over the column size, a line for each map, from `nqm batch`"},
    {0}};
static const struct {
    int min, max;
} n_inputs[] = {[CURVE] = {1, 1},         [BARS] = {1, 1},       [SCATTER] = {1, 1},
                [LOSS] = {1, MAX_INPUTS}, [DIRECTIONS] = {0, 1}, [SLICE] = {1, MAX_INPUTS},
                [ATTRIBUTION] = {2, 2},   [NETWORK] = {0, 1},    [SIZES] = {1, 1}};

/* Open what a drawing of this kind needs, and draw. */
static nqm_status draw(const plot_arguments *a, int kind, const char *const *paths, nqm_error *err) {
    const double degree = 0.017453292519943295;
    const bool has_brdfs = kind == SLICE || kind == ATTRIBUTION;
    const char *name = a->n ? a->inputs[0] : NULL;
    const char **names = has_brdfs ? take_names(a->n, a->inputs) : NULL;
    nqm_brdf **brdfs = has_brdfs ? open_brdfs(a->n, a->inputs) : NULL;
    nqm_directions *directions = kind == DIRECTIONS ? open_directions(name) : NULL;
    nqm_model *model = kind == NETWORK ? open_model(name) : NULL;
    nqm_status status = NQM_OK;
    switch (kind) {
    case CURVE:
        status = nqm_plot_curve(a->output, paths[0], &(nqm_regress_report[]){regress_csv(paths[0])}[0], &a->look, err);
        break;
    case BARS:
        status = nqm_plot_bars(a->output, paths[0], &a->look, err);
        break;
    case SCATTER:
        status = nqm_plot_predictions(a->output, paths[0], a->predictor, &a->look, err);
        break;
    case LOSS:
        status = nqm_plot_losses(a->output, (size_t)a->n, paths, &a->look, err);
        break;
    case DIRECTIONS:
        status = nqm_plot_directions(a->output, directions, &a->look, err);
        break;
    case NETWORK:
        status = nqm_plot_network(a->output, model, &a->look, err);
        break;
    case SIZES:
        status = nqm_plot_sizes(a->output, paths[0], &a->look, err);
        break;
    case SLICE:
        status = nqm_plot_slices(
            a->output, (size_t)a->n, (const nqm_brdf *const *)brdfs, names,
            &(nqm_slice_angles){a->theta_d_deg * degree, a->phi_d_deg * degree, a->azimuth_deg * degree}, &a->look,
            err);
        break;
    case ATTRIBUTION:
        status = nqm_plot_attribution(a->output, (const nqm_brdf *const *)brdfs, names, &a->look, err);
        break;
    }
    close_brdfs(has_brdfs ? a->n : 0, brdfs);
    nqm_directions_free(directions);
    nqm_model_free(model);
    free(names);
    return status;
}

/* "640x480" */
static void read_size(const char *text, nqm_plot_options *look) {
    char rest;
    if (text && (sscanf(text, "%lfx%lf%c", &look->width, &look->height, &rest) != 2 || !(look->width > 0) ||
                 !(look->height > 0)))
        stop(EXIT_USAGE, "--size needs WIDTHxHEIGHT, not '%s'", text);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;
static const char *size;
static plot_arguments a;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &a.output, "FILE.svg|.pdf|.png", "the drawing", 0, 0},
    {"title", 0, OPTION_TEXT, &a.look.title, "TEXT", "title, instead of the automatic one; '': none", 0, 0},
    {"size", 0, OPTION_TEXT, &size, "WxH", "CSS pixels (1/96 inch), 200 to 4000 each", 0, 0},
    {"scale", 0, OPTION_NUMBER, &a.look.scale, "S", "pixels of a .png per CSS pixel", 0.5, 8},
    {"predictor", 0, OPTION_TEXT, &a.predictor, "NAME", "scatter: column to draw [default: the first model]", 0, 0},
    {"theta-d", 0, OPTION_NUMBER, &a.theta_d_deg, "DEG", "slice: theta_d of the slice over theta_h", 0, 89},
    {"phi-d", 0, OPTION_NUMBER, &a.phi_d_deg, "DEG", "slice: phi_d of the slice over theta_h", -360, 360},
    {"azimuth", 0, OPTION_NUMBER, &a.azimuth_deg, "DEG", "slice: of the light from the tangent, for anisotropic BRDFs",
     -360, 360},
    {"json", 0, OPTION_FLAG, &json, NULL, "print the kind and the file of the drawing as JSON", 0, 0},
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "WHAT INPUT... -o FILE [options]",
    .about = "Draw, in colours chosen for colour-blind readers. The same input gives the same bytes on one "
             "machine; files\n"
             "contain no date. WHAT is one of:",
    .example = "nqm plot curve labels_real.csv -o curve.svg\n"
               "nqm eval corpus.safetensors --json | nqm plot bars - -o bars.pdf\n"
               "nqm plot slice sgd:nickel ward:nickel -o nickel.png",
    .options = options,
    .choices = drawings,
    .min_arguments = 1,
    .max_arguments = -1,
};

int cmd_plot(int argc, char **argv) {
    a = (plot_arguments){.look = nqm_plot_options_default(), .phi_d_deg = 90};
    a.n = parse_arguments(&cmd, argc, argv) - 1;
    a.inputs = argv + 1;
    const int kind = (int)choose_first(&cmd, argv[0]);
    if (a.n < n_inputs[kind].min || a.n > n_inputs[kind].max)
        stop(EXIT_USAGE, "%s needs %s", drawings[kind].name, drawings[kind].arguments);
    read_size(size, &a.look);
    const char *paths[MAX_INPUTS];
    for (int i = 0; i < a.n; ++i)
        paths[i] = input_path(a.inputs[i]);
    nqm_error err = {0};
    must(draw(&a, kind, paths, &err), &err);
    if (json)
        print_document(json_pack("{s:s,s:o}", "drawing", drawings[kind].name, "file", json_name(a.output)));
    return EXIT_OK;
}
