/* SPDX-License-Identifier: MIT
 *
 * Files that a verb writes itself: base's atomic output files, with faults reported.
 */
#include "nqm/tool.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

static output_file *open_outputs; /* linked by `next` */

char *absolute_path(const char *path, const char *suffix) {
    const bool is_complete = *path == '/' || strcmp(path, "-") == 0;
    char *folder = is_complete ? strdup("") : getcwd(NULL, 0);
    if (!folder)
        stop(EXIT_OPEN, "the working folder has no path: %s", strerror(errno));
    const size_t n = strlen(folder) + strlen(path) + strlen(suffix) + 2;
    char *full = allocate(n, 1);
    snprintf(full, n, "%s%s%s%s", folder, is_complete ? "" : "/", path, suffix);
    free(folder);
    return full;
}

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

/* Whether the ending of the path is in the list. A single ending may be left out; several of them choose the format. A number after a
 * dot ("model-1.2") is part of a name. */
static bool has_ending(const char *path, const char *endings) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    if (dot && isdigit((unsigned char)dot[1]))
        dot = NULL;
    const size_t n_dot = dot ? strlen(dot) : 0;
    bool fits = !dot && !strstr(endings, "|.");
    for (const char *at = endings; *at; at += strspn(at, "|")) {
        const size_t n = strcspn(at, "|");
        fits = fits || (n == n_dot && strncasecmp(at, dot, n) == 0);
        at += n;
    }
    return fits;
}

void require_named_output(const char *name, const char *path, const char *endings) {
    const size_t n = strlen(path);
    if (strcmp(path, "-") == 0 || strncmp(path, "/dev/", 5) == 0)
        return;
    if (strstr(endings, "DIR/") && ((n && path[n - 1] == '/') || is_folder(path)))
        return;
    if (!has_ending(path, endings))
        stop(EXIT_USAGE, "%s writes FILE%s, and '%s' names another kind of file", name, endings, path);
    require_output(path);
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
