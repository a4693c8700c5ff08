/* SPDX-License-Identifier: MIT
 *
 * nqm convert - writes any BRDF as a MERL .binary table.
 */
#include "nqm/tool.h"

#include <string.h>

int cmd_convert(int argc, char **argv) {
    bool json = false;
    const char *output = NULL;
    const option options[] = {
        {"output", 'o', OPTION_NEEDED, &output, "FILE", "the table to write, 35 MB; - is standard output", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {0}};
    const command cmd = {
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
    };
    parse_arguments(&cmd, argc, argv);
    nqm_error err = {0};
    nqm_brdf *brdf = open_brdf(argv[0]);
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    must(nqm_brdf_write_merl(brdf, output_path(output), show_progress, NULL, &err), &err);
    end_progress();
    if (json && strcmp(output, "-") != 0)
        print_document(json_pack("{s:s,s:s,s:s,s:s}", "brdf", info.name, "from", info.format, "output", output,
                                 "layout", "90 x 90 x 180 cells"));
    else if (strcmp(output, "-") != 0)
        printf("%s: %s as 90 x 90 x 180 cells\n", output, info.name);
    nqm_brdf_free(brdf);
    return EXIT_OK;
}
