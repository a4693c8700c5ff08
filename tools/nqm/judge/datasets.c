/* SPDX-License-Identifier: MIT
 *
 * Arguments that name datasets, and options whose values are words.
 */
#include "nqm/tool.h"

#include <string.h>
#include <sys/stat.h>

int open_dataset(const char *verb, const char *path, const char *labels, nqm_split split, nqm_dataset **dataset_ret) {
    *dataset_ret = NULL;
    nqm_error err = {0};
    struct stat st;
    bool folder = stat(path, &st) == 0 && S_ISDIR(st.st_mode);
    if (folder && !labels)
        return report(verb, EXIT_USAGE, "%s: a folder (the authors' layout) needs its labels: --labels CSV", path);
    if (!folder && labels)
        return report(verb, EXIT_USAGE,
                      "%s: --labels goes with a folder (the authors' layout), not with a dataset file", path);
    nqm_status status = folder ? nqm_dataset_load_authors(path, input_path(labels), split, dataset_ret, &err)
                               : nqm_dataset_load(path, dataset_ret, &err);
    return status == NQM_OK ? EXIT_OK : report_error(verb, &err);
}

int choose(const char *verb, const char *option_name, const choice *choices, const char *word, int *value_ret) {
    char known[200] = "";
    for (const choice *c = choices; c->name; ++c) {
        if (strcmp(c->name, word) == 0) {
            *value_ret = c->value;
            return EXIT_OK;
        }
        size_t n = strlen(known);
        snprintf(known + n, sizeof known - n, "%s%s", n ? ", " : "", c->name);
    }
    return report(verb, EXIT_USAGE, "--%s is one of %s; not '%s'", option_name, known, word);
}

int choose_result_format(const char *verb, bool json, bool csv, bool quiet, result_format *format_ret) {
    if (json + csv + quiet > 1)
        return report(verb, EXIT_USAGE, "--json, --csv and --quiet exclude each other");
    *format_ret = json ? FORMAT_JSON : csv ? FORMAT_CSV : quiet ? FORMAT_QUIET : FORMAT_TEXT;
    return EXIT_OK;
}

const char *choice_name(const choice *choices, int value) {
    const char *name = "";
    for (const choice *c = choices; c->name; ++c)
        if (c->value == value)
            name = c->name;
    return name;
}
