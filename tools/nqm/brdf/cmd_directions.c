/* SPDX-License-Identifier: MIT
 *
 * nqm directions - makes the directions at which BRDFs are compared, or prints those of a model or file.
 */
#include "nqm/tool.h"
#include "sample/sample.h"

#include <math.h>
#include <string.h>

/* Columns theta_h, theta_d, phi_d, and the directions of light and viewer, turned so that the light is at azimuth 0. */
static void write_pairs(const nqm_directions *directions, const char *path) {
    const double *degrees = nqm_directions_get_info(directions).degrees, degree = 3.14159265358979323846 / 180;
    const double *wi = nqm_directions_get_info(directions).wi, *wo = nqm_directions_get_info(directions).wo;
    output_file out;
    open_output(path, &out);
    fputs("theta_h,theta_d,phi_d,theta_i,phi_i,theta_o,phi_o\n", out.stream);
    for (size_t i = 0; i < nqm_directions_get_info(directions).n; ++i, degrees += 3, wi += 3, wo += 3) {
        const double turn = atan2(wo[1], wo[0]) - atan2(wi[1], wi[0]);
        for (size_t k = 0; k < 3; ++k) { /* digits that read back as the same direction */
            char text[32];
            fprintf(out.stream, "%s,", nqm_format_double(text, sizeof text, degrees[k]));
        }
        fprintf(out.stream, "%.9g,0,%.9g,%.9g\n", atan2(hypot(wi[0], wi[1]), wi[2]) / degree,
                atan2(hypot(wo[0], wo[1]), wo[2]) / degree, (turn < 0 ? turn + 360 * degree : turn) / degree);
    }
    close_output(&out);
}

static void print_directions(const nqm_directions *directions) {
    const double *degrees = nqm_directions_get_info(directions).degrees;
    size_t n = nqm_directions_get_info(directions).n;
    json_t *rows = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(rows, json_pack("[f,f,f]", degrees[3 * i], degrees[3 * i + 1], degrees[3 * i + 2]));
    print_document(json_row("id:s n:z columns:[sss] degrees:o", nqm_directions_id(directions), n, "theta_h", "theta_d",
                            "phi_d", rows));
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json, pairs;
static const char *path = "-";
static nqm_directions_options make;
static uint64_t n;

static const option options[] = {
    {"number", 'n', OPTION_COUNT, &n, "N", "number of directions", 1, 100000},
    {"output", 'o', OPTION_TEXT, &path, "FILE.csv", "where to write the CSV", 0, 0},
    {"pairs", 0, OPTION_FLAG, &pairs, NULL,
     "also write theta_i, phi_i (light, at azimuth 0) and theta_o, phi_o (viewer), to measure at", 0, 0},
    {"json", 0, OPTION_FLAG, &json, NULL, "print JSON on standard output instead", 0, 0},
    {0}};

static const command cmd = {
    .usage = "[REF...] [options] | directions show MODEL|FILE [options]",
    .about = "Make directions: theta_d and phi_d uniform, theta_h denser toward 0. With reference BRDFs, directions "
             "at which these are bright are favoured. `show` prints the directions of a built-in model, a model file "
             "or a CSV. Columns theta_h, theta_d, phi_d, in degrees. A model works with its own directions only: new "
             "ones are for new datasets.",
    .example = "nqm directions -n 500 materials/*.bsdf -o my-directions.csv\nnqm directions show default --json\n"
               "nqm directions show default --pairs -o to-measure.csv",
    .options = options,
    .table = &nqm_directions_option_table,
    .table_target = &make,
    .max_arguments = -1,
};

int cmd_directions(int argc, char **argv) {
    make = nqm_directions_options_default();
    n = make.n;
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    if (json && pairs)
        stop(EXIT_USAGE, "--json and --pairs exclude each other");
    nqm_directions *directions;
    if (n_arguments > 0 && strcmp(argv[0], "show") == 0) {
        if (n_arguments != 2)
            stop(EXIT_USAGE, "show needs one model or file");
        directions = open_directions(argv[1]);
    } else {
        if (n_arguments > 0)
            refuse_near_word(argv[0], "show");
        make.n = (size_t)n;
        make.progress = show_progress;
        nqm_brdf **refs = open_brdfs(n_arguments, argv);
        must(nqm_directions_create(&make, (size_t)n_arguments, (const nqm_brdf *const *)refs, &directions, &fault));
        close_brdfs(n_arguments, refs);
        end_progress();
    }
    if (json)
        print_directions(directions);
    else if (pairs)
        write_pairs(directions, path);
    else
        must(nqm_directions_save_csv(directions, output_path(path), &fault));
    if (!json && strcmp(path, "-") != 0)
        report(EXIT_OK, "%s: %zu directions, id %s", path, nqm_directions_get_info(directions).n,
               nqm_directions_id(directions));
    nqm_directions_free(directions);
    return EXIT_OK;
}
