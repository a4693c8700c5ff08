/* SPDX-License-Identifier: MIT
 *
 * The implementation of textured.h.
 */
#include "nqm/textured.h"

#include "library/library.h"
#include "material/maps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool is_textured(const char *argument) {
    nqm_material_info info;
    return nqm_maps_probe(argument) || (find_material(argument, &info) && info.n_maps > 0);
}

bool is_library(const char *argument) {
    nqm_textured *maps = NULL;
    const bool is = is_folder(argument) && nqm_maps_probe(argument) && nqm_maps_open(argument, &maps, NULL) != NQM_OK;
    nqm_textured_free(maps);
    return is;
}

nqm_status explain_texture(const char *argument, nqm_status status, nqm_error *err) {
    if (status != NQM_OK && is_library(argument))
        snprintf(err->message, sizeof err->message,
                 "%.300s: a folder of files; this verb needs one BRDF: name one of them, or translate the folder",
                 argument);
    else if (status != NQM_OK && is_textured(argument))
        snprintf(
            err->message, sizeof err->message,
            "%.300s: a material with image maps; this verb needs the BRDF of one point. score, batch, rank, report, "
            "info, check, label, render and translate take textures (doc/textures.md)",
            argument);
    return status;
}

nqm_status open_texture(const char *argument, nqm_texture **texture_ret, nqm_error *err) {
    const nqm_library_terms terms = {.progress = show_progress, .report = report_part};
    return nqm_library_open_texture(&terms, argument, texture_ret, err);
}

nqm_status open_textured(const char *argument, nqm_texture **texture_ret, nqm_error *err) {
    *texture_ret = NULL;
    return is_textured(argument) ? open_texture(argument, texture_ret, err) : NQM_OK;
}

void keep_maps(const char *argument) {
    nqm_library_maps found;
    (void)!nqm_library_find_maps(argument, &found, NULL);
    for (size_t i = 0; found.maps && i < found.maps->n_images; ++i) {
        const char *path = found.maps->images[i].path;
        struct stat st;
        if (path && stat(path, &st) == 0)
            (void)!nqm_role_input(&st, path, NULL);
    }
    nqm_library_free_maps(&found);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

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
