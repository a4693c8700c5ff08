/* SPDX-License-Identifier: MIT
 *
 * The implementation of textured.h.
 */
#include "nqm/textured.h"

#include "material/maps.h"

bool is_textured(const char *argument) {
    nqm_material_info info;
    return nqm_maps_probe(argument) || (find_material(argument, &info) && info.n_maps > 0);
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
