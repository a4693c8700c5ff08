/* SPDX-License-Identifier: MIT
 *
 * The temporary folder of scratch.h.
 */
#include "support/scratch.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/nqm-test-XXXXXX";
static pid_t owner; /* a forked process does not remove it */

static _Noreturn void give_up(const char *what) {
    perror(what);
    abort();
}

static int remove_one(const char *path, const struct stat *st, int type, struct FTW *at) {
    (void)st, (void)type, (void)at;
    return remove(path);
}

void remove_folder(const char *path) {
    (void)nftw(path, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static void remove_scratch(void) {
    if (getpid() == owner)
        remove_folder(folder);
}

const char *scratch_path(const char *name) {
    enum { MAX_PATHS = 64 };
    static char paths[MAX_PATHS][256];
    static size_t n_paths;
    char path[256];
    if (!owner) {
        if (!mkdtemp(folder))
            give_up(folder);
        owner = getpid();
        atexit(remove_scratch);
    }
    snprintf(path, sizeof path, "%s/%s", folder, name);
    for (size_t i = 0; i < n_paths; ++i)
        if (strcmp(paths[i], path) == 0)
            return paths[i];
    if (n_paths == MAX_PATHS)
        give_up("too many scratch files");
    return strcpy(paths[n_paths++], path);
}

const char *scratch_text(const char *name, const char *text) {
    const char *path = scratch_path(name);
    FILE *f = fopen(path, "w");
    if (!f || fputs(text, f) < 0 || fclose(f) != 0)
        give_up(path);
    return path;
}
