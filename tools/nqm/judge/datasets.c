/* SPDX-License-Identifier: MIT
 *
 * Arguments that name datasets.
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
