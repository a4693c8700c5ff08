/* SPDX-License-Identifier: MIT
 *
 * nqm directions - makes the directions at which BRDFs are compared, or prints those of a model or file.
 */
#include "nqm/tool.h"
#include "sample/sample.h"

#include <string.h>

static int make_directions(const nqm_directions_options *options, int n_refs, char **names,
                           nqm_directions **directions) {
    nqm_error err = {0};
    nqm_brdf **refs;
    int exit_code = open_brdfs("directions", n_refs, names, &refs);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (nqm_directions_create(options, (size_t)n_refs, (const nqm_brdf *const *)refs, directions, &err) != NQM_OK)
        exit_code = report_error("directions", &err);
    close_brdfs(n_refs, refs);
    return exit_code;
}

static int print_directions_json(const nqm_directions *directions) {
    const double *degrees = nqm_directions_degrees(directions);
    size_t n = nqm_directions_count(directions);
    json_t *rows = json_array();
    for (size_t i = 0; i < n; ++i)
        json_array_append_new(rows, json_pack("[f,f,f]", degrees[3 * i], degrees[3 * i + 1], degrees[3 * i + 2]));
    return print_json(json_pack("{s:i,s:o,s:s,s:I,s:[s,s,s],s:o}", "schema", 1, "tool", json_tool(), "id",
                                nqm_directions_id(directions), "n", (json_int_t)n, "columns", "theta_h", "theta_d",
                                "phi_d", "degrees", rows));
}

static int put_out(const nqm_directions *directions, const char *path, bool json) {
    if (json)
        return print_directions_json(directions);
    nqm_error err = {0};
    if (nqm_directions_save_csv(directions, output_path(path), &err) != NQM_OK)
        return report_error("directions", &err);
    if (strcmp(path, "-") != 0)
        fprintf(stderr, "nqm directions: %s: %zu directions, id %s\n", path, nqm_directions_count(directions),
                nqm_directions_id(directions));
    return EXIT_OK;
}

int cmd_directions(int argc, char **argv) {
    bool json = false;
    const char *path = "-";
    nqm_directions_options make = nqm_directions_options_default();
    uint64_t n = make.n;
    const option options[] = {{"number", 'n', OPTION_COUNT, &n, "N", "number of directions", 1, 100000},
                              {"output", 'o', OPTION_TEXT, &path, "FILE.csv", "where to write the CSV", 0, 0},
                              {"json", 0, OPTION_FLAG, &json, NULL, "print JSON on standard output instead", 0, 0},
                              {0}};
    const command cmd = {
        .name = "directions",
        .usage = "[REF...] [options] | directions show MODEL|FILE [options]",
        .about =
            "Make directions: theta_d and phi_d uniform, theta_h denser toward 0. With reference BRDFs, directions\n"
            "at which these are bright are favoured. `show` prints the directions of a built-in model, a model file\n"
            "or a CSV. Columns theta_h, theta_d, phi_d, in degrees. A model works with its own directions only: new\n"
            "ones are for new datasets.",
        .example = "nqm directions -n 500 materials/*.bsdf -o my-directions.csv\nnqm directions show default --json",
        .options = options,
        .table = &nqm_directions_option_table,
        .table_target = &make,
        .min_arguments = 0,
        .max_arguments = -1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    nqm_directions *directions = NULL;
    if (n_arguments > 0 && strcmp(argv[0], "show") == 0) {
        if (n_arguments != 2)
            return report("directions", EXIT_USAGE, "show needs one model or file");
        exit_code = open_directions("directions", argv[1], &directions);
    } else {
        make.n = (size_t)n;
        make.progress = show_progress;
        exit_code = make_directions(&make, n_arguments, argv, &directions);
        end_progress();
    }
    if (exit_code == EXIT_OK)
        exit_code = put_out(directions, path, json);
    nqm_directions_free(directions);
    return exit_code;
}
