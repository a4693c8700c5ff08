/* SPDX-License-Identifier: MIT
 *
 * The list of all file formats, and BRDFs from files.
 */
#include "brdf/formats/format.h"

#include "io/io.h"
#include "material/material.h"

#define POINTER_TO(NAME) &(NAME),
static const nqm_brdf_format *const formats[] = {NQM_BRDF_FORMATS(POINTER_TO) NULL};

const nqm_brdf_format *nqm_brdf_format_of(const nqm_map *map) {
    const nqm_brdf_format *const *f = formats;
    while (*f && !(map->n_bytes && (*f)->probe(map)))
        ++f;
    return *f;
}

bool nqm_brdf_probe(const char *path) {
    nqm_map map = {0};
    const bool is = nqm_map_open_sparse(path, &map, NULL) == NQM_OK && nqm_brdf_format_of(&map);
    nqm_map_close(&map);
    return is;
}

static nqm_status fail_unknown(const nqm_map *map, nqm_error *err) {
    char known[512] = "", materials[256];
    size_t used = 0;
    const char *kind = nqm_file_kind(map->data, map->n_bytes);
    for (const nqm_brdf_format *const *f = formats; *f && used < sizeof known; ++f)
        if ((*f)->files)
            used += (size_t)snprintf(known + used, sizeof known - used, "%s, ", (*f)->files);
    nqm_material_format_names(materials, sizeof materials);
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: %s%s: byte 0 begins none of %s%s", map->path,
                    kind ? "not a BRDF file but " : "not a BRDF file", kind ? kind : "", known, materials);
}

nqm_status nqm_brdf_open_file(const nqm_brdf_format *format, nqm_map *map, const nqm_brdf_argument *argument,
                              nqm_brdf **brdf_ret, nqm_error *err) {
    const size_t n_bytes = map->n_bytes;
    if (n_bytes == 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the file is empty (byte 0)", map->path);
    if (argument->member && !(format && format->takes_members))
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: neither a zip nor a decoder (byte 0), so '%s' cannot be named in it", map->path,
                        argument->member);
    nqm_status status = format ? format->open(map, argument, brdf_ret, err) : fail_unknown(map, err);
    if (status == NQM_OK && !(*brdf_ret)->info.n_bytes)
        (*brdf_ret)->info.n_bytes = n_bytes;
    return status;
}

const nqm_brdf_format nqm_material_file_format = {.takes_members = true, .probe = nqm_materials_probe};
