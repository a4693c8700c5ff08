/* SPDX-License-Identifier: MIT
 *
 * The scratch folder of corpus_files.h.
 */
#include "support/corpus_files.h"
#include "support/check.h"

#include <dirent.h>

static char folder[] = "/tmp/nqm-test-XXXXXX";

const char *in_folder(const char *name) {
    static char path[2][256];
    static int which;
    which = !which;
    snprintf(path[which], sizeof path[which], "%s/%s", folder, name);
    return path[which];
}

const char *write_text(const char *name, const char *text) {
    const char *path = in_folder(name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
    return path;
}

void remove_folder(const char *path) {
    DIR *dir = opendir(path);
    for (struct dirent *entry; dir && (entry = readdir(dir)) != NULL;) {
        char file[512];
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        remove(file);
    }
    if (dir)
        closedir(dir);
    rmdir(path);
}

int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

int remove_made_folder(void **state) {
    (void)state;
    remove_folder(folder);
    return 0;
}
