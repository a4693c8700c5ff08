/* SPDX-License-Identifier: MIT
 *
 * Arguments that name datasets, and options whose values are words.
 */
#include "nqm/tool.h"

#include <string.h>
#include <sys/stat.h>

nqm_dataset *open_dataset(const char *path, const char *labels, nqm_split split) {
    nqm_dataset *dataset;
    nqm_error err = {0};
    struct stat st;
    bool folder = stat(path, &st) == 0 && S_ISDIR(st.st_mode);
    if (folder && !labels)
        stop(EXIT_USAGE, "%s: a folder (the authors' layout) needs its labels: --labels CSV", path);
    if (!folder && labels)
        stop(EXIT_USAGE, "%s: --labels is for a folder (the authors' layout), not for a dataset file", path);
    must(folder ? nqm_dataset_load_authors(path, input_path(labels), split, &dataset, &err)
                : nqm_dataset_load(path, &dataset, &err),
         &err);
    return dataset;
}

int choose(const char *option_name, const choice *choices, const char *word) {
    char known[200] = "";
    for (const choice *c = choices; c->name; ++c) {
        if (strcmp(c->name, word) == 0)
            return c->value;
        size_t n = strlen(known);
        snprintf(known + n, sizeof known - n, "%s%s", n ? ", " : "", c->name);
    }
    stop(EXIT_USAGE, "--%s is one of %s; not '%s'", option_name, known, word);
}

const char *choice_name(const choice *choices, int value) {
    const char *name = "";
    for (const choice *c = choices; c->name; ++c)
        if (c->value == value)
            name = c->name;
    return name;
}
