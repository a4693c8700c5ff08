/* SPDX-License-Identifier: MIT
 *
 * Arguments that name datasets.
 */
#include "nqm/tool.h"

nqm_dataset *open_dataset(const char *path, const char *labels, nqm_split split) {
    nqm_dataset *dataset;
    nqm_error err = {0};
    const bool folder = is_folder(path);
    if (folder && !labels)
        stop(EXIT_USAGE, "%s: a folder (the authors' layout) needs its labels: --labels CSV", path);
    if (!folder && labels)
        stop(EXIT_USAGE, "%s: --labels is for a folder (the authors' layout), not for a dataset file", path);
    must(folder ? nqm_dataset_load_authors(path, input_path(labels), split, &dataset, &err)
                : nqm_dataset_load(path, &dataset, &err),
         &err);
    return dataset;
}
