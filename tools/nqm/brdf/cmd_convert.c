/* SPDX-License-Identifier: MIT
 *
 * nqm convert - writes any BRDF as a table.
 */
#include "figures/picture.h"
#include "nqm/tool.h"

#include <string.h>

/* In the order of nqm_file_format. */
static const char *const formats[] = {"merl", "merl-360", "npy", NULL};
static const char *const layouts[] = {"90 x 90 x 180 cells", "90 x 90 x 360 cells", "nodes of a .npy array"};

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;
static const char *output, *format_name;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &output, "FILE.binary|.npy", "the table to write; - is standard output", 0, 0},
    {"format", 'f', OPTION_TEXT, &format_name, "FORMAT",
     "merl: 90 x 90 x 180 cells, 35 MB; merl-360: 90 x 90 x 360 cells, 70 MB, which distinguish light and viewer; npy:"
     " an array of NumPy, 90 x 46 x 24 nodes, times 48 azimuths if anisotropic; default: npy for FILE.npy, else merl",
     0, 0},
    {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "BRDF -o OUT.binary [options]",
    .about = "Write a BRDF (file, spec or preset) as a table in half-vector coordinates that other programs read. A "
             "MERL table has f_r at the centres of its cells, and -1 below the horizon or without data; an array of "
             "NumPy has f_r at nodes (doc/files.md), and NaN there. An existing file is replaced only when the new "
             "one is complete. All but merl-360 are reciprocal: of a material that is not, phi_d in [0, 180) degrees "
             "is kept.",
    .example = "nqm convert 'ggx:kd=.2,.1,.05;alpha=.1' -o ggx.binary\n"
               "nqm convert paint_rgb.bsdf --format merl-360 -o paint.binary\n"
               "nqm convert sgd:nickel -o nickel.npy",
    .options = options,
    .min_arguments = 1,
};

int cmd_convert(int argc, char **argv) {
    parse_arguments(&cmd, argc, argv);
    const bool is_npy_name = nqm_name_ends_in(output, ".npy");
    const int format = choose("format", formats, format_name ? format_name : is_npy_name ? "npy" : formats[0]);
    if (is_npy_name != (format == 2) && strcmp(output, "-") != 0)
        stop(EXIT_USAGE, "--format %s writes %s, and '%s' names another kind", formats[format],
             format == 2 ? ".npy files" : "MERL tables (.binary)", output);
    nqm_brdf *brdf = open_brdf(argv[0]);
    report_remark(brdf);
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    must(nqm_brdf_write(brdf, (nqm_file_format)format, NULL, output_path(output), show_progress, NULL, &fault));
    end_progress();
    if (json && strcmp(output, "-") != 0)
        print_document(json_row("brdf:s from:s output:s layout:s", info.name, info.format, output, layouts[format]));
    else if (strcmp(output, "-") != 0)
        printf("%s: %s as %s\n", shown(output), shown(info.name), layouts[format]);
    nqm_brdf_free(brdf);
    return EXIT_OK;
}
