/* SPDX-License-Identifier: MIT
 *
 * Indices of refraction of conductors by name; presets/metals.txt says where they come from.
 */
#include "material/mitsuba.h"

static const nqm_metal metals[] = {
#include "metals_table.h" /* generated from presets/metals.txt */
};
enum { N_METALS = sizeof metals / sizeof *metals };

/* "Au_palik" is "Au" unless it has a row of its own, which comes later. */
const nqm_metal *nqm_metal_find(const char *name) {
    const size_t n = strlen(name), n_suffix = strlen("_palik");
    const bool has_suffix = n > n_suffix && strcmp(name + n - n_suffix, "_palik") == 0;
    const nqm_metal *found = NULL;
    for (size_t i = 0; i < N_METALS; ++i)
        if (strcmp(metals[i].name, name) == 0 ||
            (has_suffix && strlen(metals[i].name) == n - n_suffix && strncmp(metals[i].name, name, n - n_suffix) == 0))
            found = &metals[i];
    return found;
}

void nqm_metal_names(char *text, size_t n_text) {
    size_t used = 0;
    *text = 0;
    for (size_t i = 0; i < N_METALS && used < n_text; ++i)
        used += (size_t)snprintf(text + used, n_text - used, "%s%s", i ? ", " : "", metals[i].name);
}
