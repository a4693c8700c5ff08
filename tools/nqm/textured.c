/* SPDX-License-Identifier: MIT
 *
 * The implementation of textured.h.
 */
#include "nqm/textured.h"

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
    const nqm_status status = nqm_texture_open(argument, show_progress, NULL, texture_ret, err);
    if (status == NQM_OK && *nqm_texture_get_info(*texture_ret, NULL).remark)
        report(EXIT_OK, "%s: %s", shown(argument), nqm_texture_get_info(*texture_ret, NULL).remark);
    return status;
}

nqm_status open_textured(const char *argument, nqm_texture **texture_ret, nqm_error *err) {
    *texture_ret = NULL;
    return is_textured(argument) ? open_texture(argument, texture_ret, err) : NQM_OK;
}

found_maps find_maps(const char *argument) {
    found_maps found = {NULL, NULL, NULL};
    size_t index = 0;
    const nqm_status status = nqm_maps_probe(argument)
                                  ? nqm_maps_open(argument, &found.own, NULL)
                                  : nqm_brdf_find_textured(argument, &found.materials, &index, NULL);
    if (status == NQM_OK)
        found.maps = found.materials ? nqm_materials_maps(found.materials, index, ~0U) : found.own;
    return found;
}

void free_maps(found_maps *found) {
    nqm_textured_free(found->own);
    nqm_materials_free(found->materials);
    *found = (found_maps){NULL, NULL, NULL};
}

void each_map(const char *argument, void (*visit)(void *user, const char *path), void *user) {
    found_maps found = find_maps(argument);
    for (size_t i = 0; found.maps && i < found.maps->n_images; ++i)
        if (found.maps->images[i].path)
            visit(user, found.maps->images[i].path);
    free_maps(&found);
}

static void keep_file(void *user, const char *path) {
    struct stat st;
    (void)user;
    if (stat(path, &st) == 0)
        (void)!nqm_role_input(&st, path, NULL);
}

void keep_maps(const char *argument) {
    each_map(argument, keep_file, NULL);
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
