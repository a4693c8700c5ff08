/* SPDX-License-Identifier: MIT
 *
 * nqm convert - writes any BRDF as a MERL .binary table.
 */
#include "nqm/tool.h"

#include <string.h>

static int print_result(const nqm_brdf_info *info, const char *output, bool json) {
    if (json) {
        json_t *root = json_pack("{s:i,s:o,s:s,s:s,s:s,s:s}", "schema", 1, "tool", json_tool(), "brdf", info->name,
                                 "from", info->format, "output", output, "layout", "90 x 90 x 180 cells");
        return print_json(root);
    }
    printf("%s: %s as 90 x 90 x 180 cells\n", output, info->name);
    return EXIT_OK;
}

int cmd_convert(int argc, char **argv) {
    bool json = false;
    const char *output = NULL;
    const option options[] = {
        {.name = "output",
         .letter = 'o',
         .kind = OPTION_TEXT,
         .target = &output,
         .metavar = "FILE",
         .help = "the table to write, 35 MB; - is standard output (required)"},
        {.name = "json", .kind = OPTION_FLAG, .target = &json, .help = "print the result as JSON"},
        {0}};
    const command cmd = {
        .name = "convert",
        .usage = "BRDF -o OUT.binary [options]",
        .about =
            "Write a BRDF (file, spec or preset) as a MERL table: f_r at the centres of 90 x 90 x 180 cells in "
            "half-vector\n"
            "coordinates, cells below the horizon or without data as -1. An existing file is replaced only when the "
            "new\n"
            "one is complete. A table is reciprocal: of a material that is not, phi_d in [0, 180) degrees is kept.",
        .example = "nqm convert 'ggx:kd=.2,.1,.05;alpha=.1' -o ggx.binary",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (!output)
        return report("convert", EXIT_USAGE, "-o FILE is missing: where shall the table go?");
    nqm_error err = {0};
    nqm_brdf *brdf;
    if (nqm_brdf_open(argv[0], &brdf, &err) != NQM_OK)
        return report_error("convert", &err);
    if (nqm_brdf_write_merl(brdf, output_path(output), show_progress, NULL, &err) == NQM_OK) {
        end_progress();
        nqm_brdf_info info = nqm_brdf_get_info(brdf);
        exit_code = strcmp(output, "-") == 0 ? EXIT_OK : print_result(&info, output, json);
    } else {
        exit_code = report_error("convert", &err);
    }
    nqm_brdf_free(brdf);
    return exit_code;
}
