/* SPDX-License-Identifier: MIT
 *
 * nqm score - predicts how good approximations look compared with their reference.
 */
#include "nqm/score/score.h"
#include "nqm/textured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int metric_width(int m) {
    int n = (int)strlen(nqm_metric_get_info((nqm_metric)m).name);
    return n > 9 ? n : 9;
}

/* The line of a test, and those below it that say what differs. */
static void print_row(const score_run *run, const scored_pair *row, bool calibrated, int n_verdict) {
    const nqm_score_result *r = &row->result;
    const bool scored = row->err.status == NQM_OK;
    char verdict[NQM_VERDICT_TEXT];
    print_jod(row, calibrated);
    if (scored)
        printf("  %8.0f %%  %-*s", 100 * nqm_verdict_preference(r), n_verdict, nqm_verdict(r, verdict));
    else
        printf("  %10s  %-*s", "-", n_verdict, "no score");
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        if (run->metrics[m] && scored)
            printf("  %*.4g", metric_width(m), r->metrics[m]);
        else if (run->metrics[m])
            printf("  %*s", metric_width(m), "-");
    }
    if (has_gate(&run->gate))
        printf("  %-4s", gate_mark(&run->gate, r));
    printf("  %s\n", shown(row->name));
    if (scored && !isnan(r->parts.structure)) {
        char phrases[NQM_LABEL_TEXT + ANISOTROPY_TEXT + 80], changes[ANISOTROPY_TEXT], apart[40] = "";
        if (!isnan(r->similarity[0]))
            snprintf(apart, sizeof apart, "; seen apart %.2f", r->similarity[0]);
        snprintf(phrases, sizeof phrases, "%s%s%s%s", nqm_label_get_info(&r->parts).words, apart,
                 r->anisotropy > 0 ? "; anisotropic" : "", r->anisotropy > 0 ? describe_anisotropy(row, changes) : "");
        print_phrases(phrases);
    }
    if (row->texture)
        print_texture(row);
    else if (run->exact && scored)
        print_exact(run, row);
}

static void print_text(const score_run *run) {
    const nqm_model_info info = nqm_model_get_info(run->model);
    const bool calibrated = *info.calibration;
    char verdict[NQM_VERDICT_TEXT];
    size_t n_scored = 0;
    bool has_similarity = false;
    int n_verdict = 20;
    for (size_t i = 0; i < run->n_rows; ++i) {
        int n = (int)strlen(nqm_verdict(&run->rows[i].result, verdict));
        n_verdict = n > n_verdict ? n : n_verdict;
    }
    printf("reference  %s\nmodel      %s\n\n    JOD%s  %10s  %-*s", shown(run->ref_name), shown(info.id),
           calibrated ? "  [95 %]        " : "", "prefer ref", n_verdict, "verdict");
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        if (run->metrics[m])
            printf("  %*s", metric_width(m), nqm_metric_get_info((nqm_metric)m).name);
    puts(has_gate(&run->gate) ? "  gate  test" : "  test");
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        const nqm_score_result *r = &row->result;
        n_scored += row->err.status == NQM_OK;
        has_similarity |= !isnan(r->parts.structure) && !isnan(r->similarity[0]);
        print_row(run, row, calibrated, n_verdict);
    }
    if (n_scored == 0)
        return;
    puts("\nJOD 10: no visible difference; from 9.5: practically the same; at 9,\n"
         "75 % of people prefer the reference. prefer ref: people who would say that the\n"
         "reference looks better than the test (50 %: they guess).");
    if (has_similarity)
        puts("seen apart: how similar people find the two materials when they do not see both\n"
             "at once, as a JOD; fitted to answers of people (doc/people.md).");
    if (calibrated)
        puts("[95 %]: contains the JOD of rendered pictures for 95 % of pairs, if the material\n"
             "is new to the model and the kind of distortion is not. The verdict is about this\n"
             "interval: where its ends have different words, it is between them.");
}

static void print_scores(const score_run *run) {
    if (run->format == FORMAT_JSON) { /* the document contains the remarks */
        print_json(json_scores(run));
        return;
    }
    if (run->format == FORMAT_CSV)
        print_csv_scores(run);
    else if (run->format == FORMAT_TEXT)
        print_text(run);
    for (size_t i = 0; run->format == FORMAT_QUIET && i < run->n_rows; ++i)
        printf("%.4f\n", run->rows[i].result.jod); /* "nan" without a score */
    print_remarks(run);
}

/* Say how many textures have worse texels than they may; whether there are any. */
static bool report_worst(const score_run *run) {
    size_t n = 0, n_failed = 0;
    for (size_t i = 0; i < run->n_rows; ++i) {
        n += run->rows[i].texture != NULL;
        n_failed += run->rows[i].texture && run->rows[i].texture->worst < run->worst;
    }
    if (run->worst > 0)
        report(EXIT_GATE, "%zu of %zu textures FAIL: JOD of the worst 5 %% of texels below %g", n_failed, n,
               run->worst);
    return n_failed > 0;
}

/* ---- --samples --------------------------------------------------------------------------------------------------- */

/* Say how the values of a CSV get to the directions of the model; returns the number of directions that have none. A file of
 * another kind is refused; one that cannot be opened is a fault of its row. */
static size_t describe_samples(const nqm_directions *directions, const char *path) {
    nqm_sample_report counts = {0};
    nqm_brdf *brdf;
    if (nqm_brdf_open(path, &brdf, &fault) != NQM_OK)
        return 0;
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    const bool is_grid = strcmp(info.format, "grid") == 0;
    if (!is_grid && strcmp(info.format, "samples") != 0)
        stop(EXIT_USAGE, "--samples: %s is no CSV of directions and values (its format is %s)", path, info.format);
    const size_t n = nqm_directions_get_info(directions).n;
    float *rgb = allocate(3 * n, sizeof *rgb);
    uint8_t *flag = allocate(n, 1);
    must(nqm_sample(brdf, directions, NQM_INVALID_DROP, rgb, flag, &counts, &fault));
    if (is_grid || counts.n_invalid)
        report(EXIT_OK, "%s: values at %zu of the %zu directions of the model, %s (%s)", path, n - counts.n_invalid, n,
               is_grid ? "interpolated" : "measured", info.layout);
    free(rgb);
    free(flag);
    nqm_brdf_free(brdf);
    return counts.n_invalid;
}

/* Without a reference there are no results; of a file of several materials, each row has its own. */
static void check_reference(const score_run *run, const char *path) {
    if (strcmp(run->rows->pair.ref, path) != 0 || is_textured(path))
        return;
    nqm_brdf_free(open_brdf(path));
}

static void check_samples(const score_run *run, const char *model, int n, char **paths) {
    const nqm_directions *directions = nqm_model_get_info(run->model).directions;
    const double n_most = (1 - run->options.min_valid_fraction) * (double)nqm_directions_get_info(directions).n;
    bool is_short = false;
    for (int i = 0; i < n; ++i)
        is_short = (double)describe_samples(directions, paths[i]) > n_most || is_short;
    if (is_short)
        report(EXIT_OK, "`nqm directions show %s --pairs -o to-measure.csv` writes the directions that the model needs",
               model);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static score_run run = {.tolerance = 1e-4, .texels_per_pixel = 1};
static bool is_samples;
static const char *metrics, *model = "default";

static const option options[] = {
    OPTION_ROWS_MODEL(&model),
    OPTION_ROW_IGNORE,
    {"metrics", 0, OPTION_TEXT, &metrics, "LIST", "scalar metrics to add: all, or names with commas (rmse,log_diff)", 0,
     0},
    {"samples", 0, OPTION_FLAG, &is_samples, NULL,
     "REF and TEST are CSVs of measured values at the model's directions (`nqm directions show default --pairs` "
     "writes them); nothing is interpolated but complete grids",
     0, 0},
    {"exact", 0, OPTION_FLAG, &run.exact, NULL,
     "compare the values, too: the largest relative difference, and where; exit code 1 above the tolerance. Of "
     "textures: score every different pair of texels, not a selection",
     0, 0},
    {"tolerance", 0, OPTION_NUMBER, &run.tolerance, "R", "--exact: relative difference of equal values", 0, 1},
    OPTION_ROWS_GATE(&run.gate),
    {"fail-under-worst", 0, OPTION_NUMBER, &run.worst, "JOD",
     "exit with 1 when the worst 5 % of the texels of a texture are below this", 0, 10},
    {"texels-per-pixel", 0, OPTION_COUNT, &run.texels_per_pixel, "N",
     "of textures: as they are seen from where a pixel has N x N texels", 1, 16384},
    {"map", 0, OPTION_TEXT, &run.map, "FILE.png|.exr", "of one textured TEST: Delta-E of its texels, as a picture", 0,
     0},
    {"json", 0, OPTION_FORMAT, &run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"csv", 0, OPTION_FORMAT, &run.format, NULL, "print CSV", FORMAT_CSV, 0},
    {"quiet", 'q', OPTION_FORMAT, &run.format, NULL, "print the JODs only, one a line", FORMAT_QUIET, 0},
    {0}};

static const command cmd = {
    .usage = "REF TEST... [options]",
    .about = "Predict how good each TEST looks compared with REF, in JOD: 10 is no visible difference, and one less "
             "means that 75 % of people see that it is worse. REF and TEST are BRDF files (MERL, RGL, NBRDF), specs, "
             "presets, or materials with image maps (doc/textures.md); NAME=TEST shows it under another name. A TEST "
             "that is a file of several materials means all of them, and for a REF of several materials those of the "
             "same names. REF is the ground truth: exchanged with a TEST, the score changes a little (median 0.02 "
             "JOD; --model paper: 0.5; --model transport: not at all). A TEST that cannot be scored does not stop the"
             " others; the exit code is that of the first fault.",
    .example = "nqm score sgd:nickel ward:nickel\nnqm score nickel.binary fit1.binary fit2.binary --json\n"
               "nqm score old.binary new.binary --fail-under 9.5 -q\n"
               "nqm sample sgd:nickel >ref.csv && nqm sample ward:nickel >test.csv && nqm score --samples ref.csv "
               "test.csv",
    .options = options,
    .table = &nqm_score_option_table,
    .table_target = &run.options,
    .min_arguments = 2,
    .max_arguments = -1,
};

int cmd_score(int argc, char **argv) {
    run.options = nqm_score_options_default();
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    const char **names = take_names(n_arguments, argv);
    const bool all = run.format == FORMAT_JSON || run.format == FORMAT_CSV;
    choose_metrics(metrics ? metrics : all ? "all" : "", run.metrics);
    run.model = open_model(model);
    check_gate(&run.gate, run.model);
    set_pairs(&run, n_arguments, argv, names);
    check_reference(&run, argv[0]);
    if (is_samples)
        check_samples(&run, model, n_arguments, argv);
    if (run.map && run.n_rows != 1)
        stop(EXIT_USAGE, "--map draws one TEST, and there are %zu", run.n_rows);
    make_scores(&run);
    compare_rows(&run);
    print_scores(&run);
    const int exit_code = apply_gate(&run, report_faults(&run));
    const bool is_unequal = run.exact && report_unequal(&run);
    const bool is_bad = report_worst(&run);
    free_scores(&run);
    free(names);
    return exit_code == EXIT_OK && (is_unequal || is_bad) ? EXIT_GATE : exit_code;
}
