/* SPDX-License-Identifier: MIT
 *
 * Kinds of distortion that the training part of a corpus does not have, from the manifest.
 */
#include "data/data.h"

#include <jansson.h>
#include <string.h>

void nqm_dataset_unseen_kinds(const nqm_dataset *d, bool *unseen) {
    json_t *manifest = d->manifest ? json_loads(d->manifest, 0, NULL) : NULL;
    const json_t *names = json_object_get(manifest, "unseen_kinds");
    for (size_t kind = 0; kind < d->n_kinds; ++kind) {
        unseen[kind] = false;
        for (size_t i = 0; i < json_array_size(names); ++i) {
            const char *name = json_string_value(json_array_get(names, i));
            unseen[kind] = unseen[kind] || (name && strcmp(name, nqm_dataset_get_kind(d, kind).name) == 0);
        }
    }
    json_decref(manifest);
}
