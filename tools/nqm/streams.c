/* SPDX-License-Identifier: MIT
 *
 * "-" as a file name. The library opens paths only: standard input is copied to an anonymous file and read from there, and
 * what a verb writes to "-" goes to an anonymous file that is copied to standard output at the end. This works whatever the
 * streams are (pipe, socket, file, terminal).
 */
#include "nqm/tool.h"

#include <string.h>

enum { N_NAME = 32 };

static FILE *input, *output;
static char input_name[N_NAME], output_name[N_NAME];

/* Open the file once; `fallback` when there is no place for temporary files. */
static const char *path_of(FILE **file, char *name, const char *fallback) {
    if (!*file)
        *file = tmpfile();
    if (!*file)
        return fallback;
    snprintf(name, N_NAME, "/dev/fd/%d", fileno(*file));
    return name;
}

static bool copy(FILE *from, FILE *to) {
    char block[1 << 16];
    size_t n;
    while ((n = fread(block, 1, sizeof block, from)) > 0)
        if (fwrite(block, 1, n, to) != n)
            break;
    return !ferror(from) && fflush(to) == 0 && !ferror(to);
}

const char *input_path(const char *path) {
    bool is_read = input != NULL;
    if (!path || strcmp(path, "-") != 0)
        return path;
    const char *name = path_of(&input, input_name, "/dev/stdin");
    const bool is_copied = !input || is_read || copy(stdin, input);
    if (interrupted())
        stop(EXIT_INTERRUPTED, "interrupted");
    return is_copied ? name : "/dev/stdin";
}

const char *output_path(const char *path) {
    return path && strcmp(path, "-") == 0 ? path_of(&output, output_name, "/dev/stdout") : path;
}

bool flush_output_path(void) {
    if (!output)
        return true;
    rewind(output);
    return copy(output, stdout);
}

const char *stream_name(const char *message, size_t *n_prefix) {
    const char *const names[] = {input_name, output_name};
    for (size_t i = 0; i < 2; ++i) {
        *n_prefix = strlen(names[i]);
        if (*n_prefix && strncmp(message, names[i], *n_prefix) == 0)
            return i ? "standard output" : "standard input";
    }
    *n_prefix = 0;
    return "";
}
