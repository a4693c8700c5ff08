/* SPDX-License-Identifier: MIT
 *
 * Files that a verb writes itself: base's atomic output files, with faults reported.
 */
#include "nqm/tool.h"

#include <string.h>

static output_file *open_outputs; /* linked by `next` */

void open_output(const char *path, output_file *out) {
    nqm_error err = {0};
    *out = (output_file){.stream = stdout};
    if (strcmp(path, "-") == 0)
        return;
    must(nqm_outfile_open(path, &out->file, &err), &err);
    out->stream = out->file.stream;
    out->next = open_outputs;
    open_outputs = out;
}

void require_output(const char *path) {
    nqm_error err = {0};
    nqm_outfile file;
    if (strcmp(path, "-") == 0)
        return;
    must(nqm_outfile_open(path, &file, &err), &err);
    nqm_outfile_abort(&file);
}

void close_output(output_file *out) {
    nqm_error err = {0};
    output_file **link = &open_outputs;
    while (*link && *link != out)
        link = &(*link)->next;
    if (*link) {
        *link = out->next;
        must(nqm_outfile_commit(&out->file, &err), &err);
    }
    *out = (output_file){0};
}

void abandon_outputs(void) {
    for (; open_outputs; open_outputs = open_outputs->next)
        nqm_outfile_abort(&open_outputs->file);
}
