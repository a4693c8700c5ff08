/* SPDX-License-Identifier: MIT
 *
 * Which BRDF an argument names: a spec, a file, or a member of a file. The list of all formats.
 */
#include "brdf/core/spec.h"
#include "brdf/formats/format.h"
#include "schema/presets.h"

#include "base/names.h"
#include "io/io.h"
#include "material/maps.h"
#include "material/material.h"
#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#define POINTER_TO(NAME) &(NAME),
static const nqm_brdf_format *const formats[] = {NQM_BRDF_FORMATS(POINTER_TO) NULL};

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* NULL: none. */
static const nqm_brdf_format *find_format(const nqm_map *map) {
    const nqm_brdf_format *const *f = formats;
    while (*f && !(map->n_bytes && (*f)->probe(map)))
        ++f;
    return *f;
}

bool nqm_brdf_probe(const char *path) {
    nqm_map map = {0};
    const bool is = nqm_map_open_sparse(path, &map, NULL) == NQM_OK && find_format(&map);
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

static nqm_status open_file(const char *path, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_map map = {0};
    nqm_status status = nqm_map_open_sparse(path, &map, err);
    if (status != NQM_OK)
        return status;
    const nqm_brdf_format *format = find_format(&map);
    const size_t n_bytes = map.n_bytes;
    if (n_bytes == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the file is empty (byte 0)", path);
    else if (argument->member && !(format && format->takes_members))
        status =
            nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: neither a zip nor a decoder (byte 0), so '%s' cannot be named in it",
                     path, argument->member);
    else
        status = format ? format->open(&map, argument, brdf_ret, err) : fail_unknown(&map, err);
    if (status == NQM_OK && !(*brdf_ret)->info.spec &&
        !(*brdf_ret)->info.n_bytes) /* specs of materials have no bytes */
        (*brdf_ret)->info.n_bytes = n_bytes;
    nqm_map_close(&map);
    return status;
}

/* ---- arguments --------------------------------------------------------------------------------------------------- */

/* The number of the system's error; 0: the file exists. */
static int find_fault(const char *path) {
    struct stat st;
    return stat(path, &st) == 0 ? 0 : errno;
}

static nqm_status fail_absent(const char *path, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(find_fault(path)));
}

/* A file, or a folder with the files of one network. */
static nqm_status open_path(const char *path, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    char *network;
    const size_t n = nqm_networks_in_folder(path, &network);
    nqm_status status;
    if (n && !network)
        status = nqm_fail_nomem(err, strlen(path));
    else if (n > 1)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: a folder of %zu networks; give one of their files, %s", path, n,
                          network);
    else
        status = open_file(n ? network : path, argument, brdf_ret, err);
    nqm_free(network);
    return status;
}

/* Neither a file nor a spec: is it a misspelt spec, or one without its colon or with another character there? */
static nqm_status fail_missing(const char *path_or_spec, nqm_error *err) {
    char model[64];
    if (!*path_or_spec)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a BRDF argument is empty");
    if (!strchr(path_or_spec, ':') && nqm_analytic_model_find(path_or_spec, strlen(path_or_spec)))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no such file; a spec of this model is '%s:key=value;...'",
                        path_or_spec, path_or_spec);
    const char *preset = nqm_preset_named(path_or_spec);
    if (preset)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no such file; a preset of this name is '%s'", path_or_spec, preset);
    const size_t n_model = nqm_spec_lacks_colon(path_or_spec);
    if (n_model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%.150s: no such file; in a spec, ':' follows the model: '%.*s:%.150s'",
                        path_or_spec, (int)n_model, path_or_spec, path_or_spec + n_model + 1);
    preset = nqm_preset_without_colon(path_or_spec);
    if (preset)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: No such file or directory (did you mean '%s'?)", path_or_spec,
                        preset);
    snprintf(model, sizeof model, "%.*s", (int)strcspn(path_or_spec, ":"), path_or_spec);
    nqm_nearest nearest = nqm_nearest_begin(model);
    nqm_spec_nearest(&nearest);
    if (!strpbrk(path_or_spec, ":/.")) { /* a word: also a preset without its table */
        nqm_preset_nearest(&nearest);
        return *nearest.advice ? nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: there is no such file, model or preset%s",
                                          path_or_spec, nearest.advice)
                               : fail_absent(path_or_spec, err);
    }
    if (!strchr(path_or_spec, ':') || (!*nearest.advice && strpbrk(model, "/.")))
        return fail_absent(path_or_spec, err);
    return *nearest.advice ? nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: no such file, and there is no model '%s'%s",
                                      path_or_spec, model, nearest.advice)
                           : nqm_fail(err, NQM_ERR_IO, -1, "%.200s: No such file or directory, and no model '%s'",
                                      path_or_spec, model);
}

nqm_status nqm_brdf_open_argument(const char *path_or_spec, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    nqm_brdf_argument argument = {.name = name, .open = nqm_brdf_open_argument};
    const size_t n_prefix = nqm_ignore_prefix(path_or_spec, &argument.ignored);
    path_or_spec += n_prefix;
    if (n_prefix && !argument.ignored)
        return nqm_fail(
            err, NQM_ERR_ARG, -1,
            "%.300s: after 'ignore:', give some of transmission, subsurface, emission, opacity, displacement and bump, "
            "separated by commas, and a colon",
            name);
    if (nqm_spec_probe(path_or_spec))
        return nqm_spec_open(path_or_spec, name, nqm_brdf_open_argument, brdf_ret, err);
    if (find_fault(path_or_spec) == 0)
        return open_path(path_or_spec, &argument, brdf_ret, err);
    const char *colon = nqm_member_colon(path_or_spec);
    if (!colon)
        return fail_missing(path_or_spec, err);
    char *path = nqm_strdup(path_or_spec);
    if (!path)
        return nqm_fail_nomem(err, strlen(path_or_spec) + 1);
    path[colon - path_or_spec] = 0;
    argument.member = colon + 1;
    nqm_status status = open_path(path, &argument, brdf_ret, err);
    nqm_free(path);
    return status;
}

nqm_status nqm_brdf_open(const char *path_or_spec, nqm_brdf **brdf_ret, nqm_error *err) {
    NQM_MAKE(err, brdf_ret, path_or_spec);
    return nqm_brdf_open_argument(path_or_spec, path_or_spec, brdf_ret, err);
}

nqm_status nqm_brdf_find_companion(const char *path, const char *member, char **path_ret, nqm_error *err) {
    nqm_map map = {0};
    *path_ret = NULL;
    nqm_status status = nqm_map_open_sparse(path, &map, err);
    const nqm_brdf_format *format = status == NQM_OK ? find_format(&map) : NULL;
    if (format && format->find_companion)
        status = format->find_companion(&map, member, path_ret, err);
    nqm_map_close(&map);
    return status;
}

char *nqm_brdf_path_below(const char *path_or_spec, const char *root, size_t n_root) {
    unsigned ignored;
    const size_t n = nqm_ignore_prefix(path_or_spec, &ignored);
    if (n_root == 0 || path_or_spec[n] == '/' || nqm_spec_probe(path_or_spec))
        return nqm_strdup(path_or_spec);
    return nqm_strdupf("%.*s%.*s/%s", (int)n, path_or_spec, (int)n_root, root, path_or_spec + n);
}

nqm_status nqm_brdf_open_below(const char *path_or_spec, const char *root, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    char *path = nqm_brdf_path_below(path_or_spec, root, root ? strlen(root) : 0);
    if (!path)
        return nqm_fail_nomem(err, strlen(path_or_spec) + 1);
    nqm_status status = nqm_brdf_open(path, brdf_ret, err);
    nqm_free(path);
    return status;
}
