/* SPDX-License-Identifier: MIT
 *
 * The materials of renderers' files as BRDFs: of a spec, or of the measured file that a material names.
 */
#include "brdf/formats/format.h"

#include "base/names.h"
#include "material/material.h"
#include <string.h>

/* The material of that name; NULL: the only one. */
static nqm_status select_material(const char *path, const nqm_materials *materials, const char *material,
                                  nqm_material_info *info, nqm_error *err) {
    const size_t n = nqm_materials_count(materials);
    char names[256] = "";
    size_t used = 0, n_found = 0;
    nqm_nearest nearest = nqm_nearest_begin(material ? material : "");
    for (size_t i = 0; i < n; ++i) {
        const nqm_material_info one = nqm_materials_get(materials, i);
        const bool is_it = material ? strcmp(one.name, material) == 0 : n == 1;
        if (is_it && n_found++)
            return nqm_fail(err, NQM_ERR_FORMAT, one.byte_offset,
                            "%s: two materials have the name '%s' (bytes %lld and %lld); rename one", path, material,
                            (long long)info->byte_offset, (long long)one.byte_offset);
        if (is_it)
            *info = one;
        if (n_found)
            continue;
        nqm_nearest_add(&nearest, one.name);
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", one.name);
    }
    if (n_found)
        return NQM_OK;
    return material ? nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no material '%s' in this file%s; it has %s", path,
                               material, nearest.advice, names)
                    : nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this file, '%s:MATERIAL': %s", path,
                               path, names);
}

/* The measured file that a material names, if it does. */
static nqm_status find_companion(const nqm_map *map, const char *material, char **path_ret, nqm_error *err) {
    nqm_materials *materials = NULL;
    nqm_material_info info = {.spec = NULL};
    *path_ret = NULL;
    nqm_status status = nqm_materials_read(map, &materials, err);
    if (status == NQM_OK)
        status = select_material(map->path, materials, material, &info, err);
    if (status == NQM_OK && info.spec && !nqm_spec_probe(info.spec)) {
        *path_ret = nqm_path_beside(map->path, info.spec);
        status = *path_ret ? NQM_OK : nqm_fail_nomem(err, strlen(info.spec) + 1);
    }
    nqm_materials_free(materials);
    return status;
}

static nqm_status open_measured(const char *path, const char *measured, nqm_brdf_opener *open, nqm_brdf **brdf_ret,
                                nqm_error *err) {
    nqm_map map = {0};
    char *target = nqm_path_beside(path, measured);
    if (!target)
        return nqm_fail_nomem(err, strlen(measured) + 1);
    nqm_status status = nqm_map_open_sparse(target, &map, err);
    if (status == NQM_OK && map.n_bytes && nqm_materials_probe(&map))
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: its measured file %s is a material file too", path, target);
    nqm_map_close(&map);
    if (status == NQM_OK)
        status = open(target, target, brdf_ret, err);
    nqm_free(target);
    return status;
}

/* ", byte N"; "" when the reader of the format does not know it. */
static const char *byte_text(int64_t byte, char text[40]) {
    *text = 0;
    if (byte >= 0)
        snprintf(text, 40, ", byte %lld", (long long)byte);
    return text;
}

/* The spec of a material; a value outside of its model's range is a fault of the file. */
static nqm_status open_spec(const char *path, const nqm_material_info *info, const nqm_brdf_argument *argument,
                            nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_error why = {0};
    nqm_status status = argument->open(info->spec, argument->name, brdf_ret, &why);
    char byte[40];
    if (status == NQM_ERR_ARG)
        return nqm_fail(err, NQM_ERR_FORMAT, info->byte_offset, "%s: the material '%s' (%s%s): %s", path, info->name,
                        info->surface, byte_text(info->byte_offset, byte), why.message);
    if (status != NQM_OK && err)
        *err = why;
    return status;
}

/* The member is the material; NULL: the file has only one. */
static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_materials *materials = NULL;
    nqm_material_info info = {.name = ""};
    char byte[40];
    nqm_status status = nqm_materials_read(map, &materials, err);
    if (status == NQM_OK)
        status = select_material(map->path, materials, argument->member, &info, err);
    if (status == NQM_OK && info.refusal)
        status = nqm_fail(err, NQM_ERR_FORMAT, info.byte_offset, "%s: the material '%s' (%s%s) is refused: %s",
                          map->path, info.name, info.surface, byte_text(info.byte_offset, byte), info.refusal);
    if (status == NQM_OK)
        status = nqm_spec_probe(info.spec) ? open_spec(map->path, &info, argument, brdf_ret, err)
                                           : open_measured(map->path, info.spec, argument->open, brdf_ret, err);
    nqm_materials_free(materials);
    if (status == NQM_OK)
        nqm_map_close(map);
    return status;
}

const nqm_brdf_format nqm_material_file_format = {
    .takes_members = true, .probe = nqm_materials_probe, .open = open_file, .find_companion = find_companion};
