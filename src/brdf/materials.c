/* SPDX-License-Identifier: MIT
 *
 * The materials of renderers' files as BRDFs: of a spec, or of the measured file that a material names.
 */
#include "brdf/formats/format.h"

#include "base/names.h"
#include "material/maps.h"
#include <string.h>
#include <unistd.h>

/* There is no material of that name, or it is to be named (NULL). */
static nqm_status fail_select(const char *path, const nqm_materials *materials, const char *material, nqm_error *err) {
    enum { MOST = 1000 }; /* materials of which the nearest name is found */
    char names[256] = "";
    size_t used = 0;
    nqm_nearest nearest = nqm_nearest_begin(material ? material : "");
    for (size_t i = 0; i < nqm_smaller(nqm_materials_count(materials), MOST); ++i) {
        const char *name = nqm_materials_get(materials, i).name;
        nqm_nearest_add(&nearest, name);
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", name);
    }
    return material ? nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no material '%s' in this file%s; it has %s", path,
                               material, nearest.advice, names)
                    : nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this file, '%s:MATERIAL': %s", path,
                               path, names);
}

/* The material of that name; NULL: the only one. */
static nqm_status select_material(const char *path, const nqm_materials *materials, const char *material,
                                  size_t *index_ret, nqm_material_info *info, nqm_error *err) {
    static const size_t only[] = {0};
    size_t n_found = nqm_materials_count(materials) == 1;
    const size_t *found = material ? nqm_materials_named(materials, material, &n_found) : only;
    if (n_found == 0)
        return fail_select(path, materials, material, err);
    *index_ret = found[0];
    *info = nqm_materials_get(materials, found[0]);
    if (n_found == 1)
        return NQM_OK;
    const int64_t other = nqm_materials_get(materials, found[1]).byte_offset;
    return nqm_fail(err, NQM_ERR_FORMAT, other,
                    "%s: two materials have the name '%s' (bytes %lld and %lld); rename one", path, material,
                    (long long)info->byte_offset, (long long)other);
}

/* The measured file that a material names, if it does. */
static nqm_status find_companion(const nqm_map *map, const char *material, char **path_ret, nqm_error *err) {
    nqm_materials *materials = NULL;
    nqm_material_info info = {.spec = NULL};
    size_t index;
    *path_ret = NULL;
    nqm_status status = nqm_materials_read(map, &materials, err);
    if (status == NQM_OK)
        status = select_material(map->path, materials, material, &index, &info, err);
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
static nqm_status open_material(const char *path, const nqm_materials *materials, const nqm_brdf_argument *argument,
                                nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_material_info info = {.name = ""};
    char byte[40];
    size_t index;
    nqm_status status = select_material(path, materials, argument->member, &index, &info, err);
    if (status == NQM_OK)
        info = nqm_materials_reflecting(materials, index, argument->ignored);
    if (status == NQM_OK && info.refusal) {
        const char *way_out = info.ignorable && info.reflection ? info.ignorable : "";
        status = nqm_fail(err, NQM_ERR_FORMAT, info.byte_offset, "%s: the material '%s' (%s%s) is refused: %s%s%s",
                          path, info.name, info.surface, byte_text(info.byte_offset, byte), info.refusal,
                          *way_out ? "; what of it reflects is taken with --ignore " : "", way_out);
    }
    if (status == NQM_OK)
        status = nqm_spec_probe(info.spec) ? open_spec(path, &info, argument, brdf_ret, err)
                                           : open_measured(path, info.spec, argument->open, brdf_ret, err);
    if (status == NQM_OK && info.remark)
        status = nqm_brdf_remark(brdf_ret, info.remark, err);
    return status;
}

nqm_status nqm_brdf_find_textured(const char *argument, nqm_materials **materials_ret, size_t *index_ret,
                                  nqm_error *err) {
    unsigned ignored;
    argument += nqm_ignore_prefix(argument, &ignored);
    const bool is_spec = nqm_spec_probe(argument);
    const char *colon = is_spec ? NULL : nqm_member_colon(argument);
    nqm_materials *materials = NULL;
    nqm_material_info info;
    nqm_map map = {0};
    char *path = nqm_strdup(argument);
    nqm_status status = path ? NQM_OK : nqm_fail_nomem(err, strlen(argument) + 1);
    *materials_ret = NULL;
    if (path && colon)
        path[colon - argument] = 0;
    if (path && (is_spec || access(path, F_OK) != 0 || nqm_map_open_sparse(path, &map, NULL) != NQM_OK)) {
        nqm_free(path);
        return NQM_OK;
    }
    if (status == NQM_OK && map.n_bytes && nqm_materials_probe(&map)) {
        status = nqm_materials_read(&map, &materials, err);
        if (status == NQM_OK)
            status = select_material(path, materials, colon ? colon + 1 : NULL, index_ret, &info, err);
        if (status == NQM_OK && nqm_materials_maps(materials, *index_ret, ignored)) {
            *materials_ret = materials;
            materials = NULL;
        }
    }
    nqm_materials_free(materials);
    nqm_map_close(&map);
    nqm_free(path);
    return status;
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_materials *materials = NULL;
    nqm_status status = nqm_materials_read(map, &materials, err);
    if (status == NQM_OK)
        status = open_material(map->path, materials, argument, brdf_ret, err);
    nqm_materials_free(materials);
    return status;
}

const nqm_brdf_format nqm_material_file_format = {
    .takes_members = true, .probe = nqm_materials_probe, .open = open_file, .find_companion = find_companion};

/* ---- files that stay parsed -------------------------------------------------------------------------------------- */

struct nqm_material_file {
    char *path;
    nqm_materials *materials; /* NULL: it is no material file, or a damaged one, which opening reports */
    struct nqm_material_file *next;
};

void nqm_material_files_trim(nqm_material_file **list, size_t n_kept) {
    while (*list && n_kept--)
        list = &(*list)->next;
    while (*list) {
        nqm_material_file *last = *list;
        *list = last->next;
        nqm_materials_free(last->materials);
        nqm_free(last->path);
        nqm_free(last);
    }
}

/* NULL: out of memory. */
static nqm_material_file *read_kept(const char *path, size_t n_path) {
    nqm_material_file *file = nqm_alloc(1, sizeof *file);
    if (!file || !(file->path = nqm_alloc(n_path + 1, 1))) {
        nqm_free(file);
        return NULL;
    }
    memcpy(file->path, path, n_path);
    (void)!nqm_materials_open(file->path, &file->materials, NULL);
    return file;
}

const nqm_material_file *nqm_material_file_find(nqm_material_file **list, const char *name) {
    unsigned ignored;
    name += nqm_ignore_prefix(name, &ignored);
    const char *colon = nqm_spec_probe(name) ? NULL : nqm_member_colon(name);
    if (!colon)
        return NULL;
    const size_t n_path = (size_t)(colon - name);
    nqm_material_file **at = list;
    while (*at && !(strncmp((*at)->path, name, n_path) == 0 && (*at)->path[n_path] == 0))
        at = &(*at)->next;
    nqm_material_file *found = *at;
    if (found)
        *at = found->next;
    else
        found = read_kept(name, n_path);
    if (!found)
        return NULL;
    found->next = *list;
    *list = found;
    return found->materials ? found : NULL;
}

nqm_status nqm_material_file_open(const nqm_material_file *file, const char *name, nqm_brdf **brdf_ret,
                                  nqm_error *err) {
    nqm_brdf_argument argument = {.name = name, .open = nqm_brdf_open_argument};
    argument.member = name + nqm_ignore_prefix(name, &argument.ignored) + strlen(file->path) + 1;
    *brdf_ret = NULL;
    return open_material(file->path, file->materials, &argument, brdf_ret, err);
}
