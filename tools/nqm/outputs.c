/* SPDX-License-Identifier: MIT
 *
 * Files that a verb writes itself: under a temporary name in the same folder, renamed when complete.
 */
#include "nqm/tool.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int cannot_write(const char *verb, const char *path) {
    return report(verb, EXIT_OPEN, "%s: cannot write: %s", path, strerror(errno));
}

/* mkstemp() makes files that only the owner may read; others get what the umask leaves. */
static FILE *open_temporary(char *name) {
    int fd = mkstemp(name);
    if (fd < 0)
        return NULL;
    mode_t mask = umask(0);
    umask(mask);
    FILE *stream = fchmod(fd, 0666 & ~mask) == 0 ? fdopen(fd, "w") : NULL;
    if (!stream)
        close(fd);
    return stream;
}

int open_output(const char *verb, const char *path, output_file *out) {
    struct stat st;
    *out = (output_file){.path = path};
    if (strcmp(path, "-") == 0) {
        out->stream = stdout;
        return EXIT_OK;
    }
    if (stat(path, &st) == 0 && !S_ISREG(st.st_mode)) { /* a device or a pipe is written in place */
        out->stream = fopen(path, "w");
        return out->stream ? EXIT_OK : cannot_write(verb, path);
    }
    size_t n = strlen(path) + sizeof ".XXXXXX";
    out->temporary = malloc(n);
    if (!out->temporary)
        return report(verb, EXIT_LIMIT, "out of memory");
    snprintf(out->temporary, n, "%s.XXXXXX", path);
    out->stream = open_temporary(out->temporary);
    if (out->stream)
        return EXIT_OK;
    int exit_code = cannot_write(verb, path);
    free(out->temporary);
    *out = (output_file){0};
    return exit_code;
}

int close_output(const char *verb, output_file *out, bool keep) {
    if (!out->stream)
        return EXIT_OK;
    bool bad = fflush(out->stream) != 0 || ferror(out->stream);
    if (out->stream != stdout)
        bad = fclose(out->stream) != 0 || bad;
    if (!bad && keep && out->temporary)
        bad = rename(out->temporary, out->path) != 0;
    int exit_code = bad && keep ? cannot_write(verb, out->path) : EXIT_OK;
    if (out->temporary && (bad || !keep))
        unlink(out->temporary);
    free(out->temporary);
    *out = (output_file){0};
    return exit_code;
}
