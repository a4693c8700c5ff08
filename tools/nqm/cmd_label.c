/* SPDX-License-Identifier: MIT
 *
 * nqm label - Delta-E ITP and JOD of pairs of BRDFs by rendering them.
 */
#include "scene_args.h"

#include <math.h>
#include <stdlib.h>

typedef struct label_row {
    const char *name;
    double delta_e, jod; /* NaN where the test could not be rendered */
    nqm_error err;
} label_row;

typedef enum label_format { LABEL_TEXT, LABEL_JSON, LABEL_CSV, LABEL_QUIET } label_format;

typedef struct label_run {
    const char *ref_name;
    size_t n_rows;
    label_row *rows;
    nqm_scene *scene;
    double *ref_cdm2, *test_cdm2; /* (points, 3) */
} label_run;

static nqm_status render(const nqm_scene *scene, const char *name, double *rgb_cdm2, nqm_error *err) {
    nqm_brdf *brdf;
    nqm_status status = nqm_brdf_open(name, &brdf, err);
    if (status == NQM_OK)
        status = nqm_scene_render(scene, brdf, rgb_cdm2, err);
    nqm_brdf_free(brdf);
    return status;
}

static void label_test(label_run *run, label_row *row) {
    row->delta_e = row->jod = (double)NAN;
    if (render(run->scene, row->name, run->test_cdm2, &row->err) != NQM_OK)
        return;
    const nqm_curve curve = nqm_curve_default();
    row->delta_e = nqm_scene_delta_e(run->scene, run->ref_cdm2, run->test_cdm2);
    row->jod = nqm_curve_jod(&curve, row->delta_e);
}

static int print_rows_json(const label_run *run, const nqm_scene_options *o) {
    json_t *results = json_array();
    for (size_t i = 0; i < run->n_rows; ++i) {
        const label_row *row = &run->rows[i];
        json_t *result = json_pack("{s:o,s:o,s:o}", "test", json_name(row->name), "delta_e_itp",
                                   json_number(row->delta_e), "jod", json_number(row->jod));
        if (row->err.status != NQM_OK)
            json_object_set_new(result, "error", json_name(row->err.message));
        json_array_append_new(results, result);
    }
    return print_json(json_pack("{s:i,s:o,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "reference",
                                json_name(run->ref_name), "scene", json_scene(o), "results", results));
}

static void print_row(const label_row *row, label_format format) {
    bool good = row->err.status == NQM_OK;
    const char *words = !good ? "failed" : row->delta_e > 0 ? jod_words(row->jod) : "equal pictures";
    if (format == LABEL_QUIET) {
        printf("%.4f\n", row->jod);
    } else if (format == LABEL_TEXT) {
        printf("%9.3f  %6.2f  %-20s  %s\n", row->delta_e, row->jod, words, row->name);
    } else {
        print_csv_text(stdout, row->name);
        if (good)
            printf(",%.9g,%.9g,", row->delta_e, row->jod);
        else
            printf(",,,");
        print_csv_text(stdout, row->err.message);
        putchar('\n');
    }
}

static int print_rows(const label_run *run, const nqm_scene_options *o, label_format format) {
    end_progress();
    if (format == LABEL_JSON)
        return print_rows_json(run, o);
    if (format == LABEL_TEXT)
        printf("%9s  %6s  %-20s  test, rendered beside %s\n", "Delta-E", "JOD", "", run->ref_name);
    if (format == LABEL_CSV)
        puts("test,delta_e_itp,jod,error");
    for (size_t i = 0; i < run->n_rows; ++i)
        print_row(&run->rows[i], format);
    return fflush(stdout) == 0 ? EXIT_OK : EXIT_OPEN;
}

static int run_label(label_run *run, const nqm_scene_options *o, label_format format) {
    nqm_error err = {0};
    int exit_code = EXIT_OK;
    if (nqm_scene_create(o, &run->scene, &err) != NQM_OK)
        return report_error("label", &err);
    size_t n_points = nqm_scene_count(run->scene);
    run->ref_cdm2 = calloc(3 * n_points, sizeof *run->ref_cdm2);
    run->test_cdm2 = calloc(3 * n_points, sizeof *run->test_cdm2);
    if (!run->ref_cdm2 || !run->test_cdm2)
        return report("label", EXIT_LIMIT, "out of memory");
    if (render(run->scene, run->ref_name, run->ref_cdm2, &err) != NQM_OK)
        return report_error("label", &err);
    for (size_t i = 0; i < run->n_rows; ++i) {
        if (show_progress(NULL, "label", (double)i, (double)run->n_rows))
            return report("label", EXIT_INTERRUPTED, "interrupted");
        label_test(run, &run->rows[i]);
    }
    exit_code = print_rows(run, o, format);
    for (size_t i = 0; i < run->n_rows; ++i)
        if (run->rows[i].err.status != NQM_OK) {
            int code = report_error("label", &run->rows[i].err);
            exit_code = exit_code == EXIT_OK ? code : exit_code; /* the first fault decides */
        }
    return exit_code;
}

int cmd_label(int argc, char **argv) {
    bool json = false, csv = false, quiet = false;
    scene_args scene = scene_args_begin();
    option options[4 + N_SCENE_OPTIONS] = {
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {"csv", 0, OPTION_FLAG, &csv, NULL, "print CSV", 0, 0},
        {"quiet", 'q', OPTION_FLAG, &quiet, NULL, "print the JODs only, one a line", 0, 0},
    };
    scene_args_table(&scene, options);
    const command cmd = {
        .name = "label",
        .usage = "REF TEST... [options]",
        .about = "Render REF and each TEST on a sphere under a light map and compare the pictures: mean Delta-E ITP\n"
                 "(ITU-R BT.2124), and the JOD that the published curve gives for it. This is how training labels are\n"
                 "made; `nqm score` predicts them without rendering. Direct light, no shadows; doc/labels.md.",
        .example =
            "nqm label sgd:nickel ward:nickel\nnqm label measured.bsdf fit1.binary fit2.binary --light probe.exr "
            "--json",
        .options = options,
        .min_arguments = 2,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (json + csv + quiet > 1)
        return report("label", EXIT_USAGE, "--json, --csv and --quiet exclude each other");
    exit_code = scene_args_end("label", &scene);
    if (exit_code != EXIT_OK)
        return exit_code;
    label_run run = {.ref_name = argv[0], .n_rows = (size_t)n_arguments - 1};
    run.rows = calloc(run.n_rows, sizeof *run.rows);
    if (!run.rows)
        return report("label", EXIT_LIMIT, "out of memory");
    for (size_t i = 0; i < run.n_rows; ++i)
        run.rows[i].name = argv[i + 1];
    exit_code = run_label(&run, &scene.scene, json ? LABEL_JSON : csv ? LABEL_CSV : quiet ? LABEL_QUIET : LABEL_TEXT);
    nqm_scene_free(run.scene);
    free(run.ref_cdm2);
    free(run.test_cdm2);
    free(run.rows);
    return exit_code;
}
