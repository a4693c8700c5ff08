/* SPDX-License-Identifier: MIT
 *
 * Indices of refraction of conductors by name; presets/metals.txt says where they come from.
 */
#include "material/mitsuba.h"

static const nqm_metal metals[] = {
#include "metals_table.h" /* generated from presets/metals.txt */
};
enum { N_METALS = sizeof metals / sizeof *metals };

/* Whether row i is one of pbrt's spectra, or else of Mitsuba's materials. */
static bool is_of(bool is_pbrt, size_t i) {
    return is_pbrt == (strncmp(metals[i].name, "metal-", 6) == 0);
}

/* "Au_palik" is "Au" unless it has a row of its own, which comes later. */
const nqm_metal *nqm_metal_find(bool is_pbrt, const char *name) {
    const size_t n = strlen(name), n_suffix = strlen("_palik");
    const bool has_suffix = n > n_suffix && strcmp(name + n - n_suffix, "_palik") == 0;
    const nqm_metal *found = NULL;
    for (size_t i = 0; i < N_METALS; ++i)
        if (is_of(is_pbrt, i) &&
            (strcmp(metals[i].name, name) == 0 || (has_suffix && strlen(metals[i].name) == n - n_suffix &&
                                                   strncmp(metals[i].name, name, n - n_suffix) == 0)))
            found = &metals[i];
    return found;
}

void nqm_metal_names(bool is_pbrt, char *text, size_t n_text) {
    size_t used = 0;
    *text = 0;
    for (size_t i = 0; i < N_METALS && used < n_text; ++i)
        if (is_of(is_pbrt, i))
            used += (size_t)snprintf(text + used, n_text - used, "%s%s", used ? ", " : "", metals[i].name);
}
