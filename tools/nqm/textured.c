/* SPDX-License-Identifier: MIT
 *
 * The implementation of textured.h.
 */
#include "nqm/textured.h"

#include "material/maps.h"

#include <stdlib.h>
#include <string.h>

bool is_textured(const char *argument) {
    const char *name = member_name(argument);
    char *path = strdup(argument);
    if (!path)
        stop(EXIT_LIMIT, "out of memory");
    if (name)
        path[name - argument - 1] = 0;
    const nqm_materials *materials = is_file(path) ? parsed_materials(path) : NULL;
    size_t n_found = materials && nqm_materials_count(materials) == 1, first = 0;
    if (materials && name) {
        const size_t *found = nqm_materials_named(materials, name, &n_found);
        first = n_found == 1 ? found[0] : 0;
    }
    free(path);
    return nqm_maps_probe(argument) || (n_found == 1 && nqm_materials_get(materials, first).n_maps > 0);
}

nqm_status explain_texture(const char *argument, nqm_status status, nqm_error *err) {
    if (status != NQM_OK && is_textured(argument))
        snprintf(err->message, sizeof err->message,
                 "%.300s: a material with image maps; this verb needs the BRDF of one point. score, batch, rank, info, "
                 "label "
                 "and render take textures (doc/textures.md)",
                 argument);
    return status;
}

nqm_status open_textured(const char *argument, nqm_texture **texture_ret, nqm_error *err) {
    *texture_ret = NULL;
    return is_textured(argument) ? nqm_texture_open(argument, show_progress, NULL, texture_ret, err) : NQM_OK;
}

view_args view_args_begin(void) {
    const nqm_texture_view v = nqm_scene_texture_view_default();
    return (view_args){(uint64_t)v.tiles, v.n_samples};
}

nqm_texture_view view_of(const view_args *args) {
    nqm_texture_view v = nqm_scene_texture_view_default();
    v.tiles = (double)args->tiles;
    v.n_samples = (size_t)args->texels;
    return v;
}
