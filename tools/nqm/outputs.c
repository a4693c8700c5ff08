/* SPDX-License-Identifier: MIT
 *
 * Files that a verb writes itself: base's atomic output files, with faults reported.
 */
#include "nqm/tool.h"

#include <string.h>

int open_output(const char *verb, const char *path, output_file *out) {
    nqm_error err = {0};
    *out = (output_file){0};
    if (strcmp(path, "-") == 0) {
        out->stream = stdout;
        return EXIT_OK;
    }
    if (nqm_outfile_open(path, &out->file, &err) != NQM_OK)
        return report_error(verb, &err);
    out->stream = out->file.stream;
    return EXIT_OK;
}

int close_output(const char *verb, output_file *out, bool keep) {
    nqm_error err = {0};
    nqm_status status = NQM_OK;
    if (out->stream == stdout)
        status = fflush(stdout) == 0 && !ferror(stdout)
                     ? NQM_OK
                     : nqm_fail(&err, NQM_ERR_IO, -1, "standard output: cannot write");
    else if (out->stream && keep)
        status = nqm_outfile_commit(&out->file, &err);
    else
        nqm_outfile_abort(&out->file);
    *out = (output_file){0};
    return status == NQM_OK || !keep ? EXIT_OK : report_error(verb, &err);
}
