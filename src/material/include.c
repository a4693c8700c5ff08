/* SPDX-License-Identifier: MIT
 *
 * Files that a scene includes. Those in the folder of the scene that are there are read; others are named in the remarks of its
 * materials.
 */
#include "base/os.h"
#include "material/bsdf.h"

enum { MAX_DEPTH = 16, MAX_FILES = 10000, MAX_BYTES = 256 << 20 };

bool nqm_include_is_inside(const char *name) {
    const bool is_relative = *name && *name != '/';
    for (size_t n; *name; name += n + (name[n] == '/')) {
        n = strcspn(name, "/");
        if (n == 2 && memcmp(name, "..", 2) == 0)
            return false;
    }
    return is_relative;
}

nqm_status nqm_include_open(nqm_includes *in, const char *from, const char *name, nqm_map *map, char **path_ret,
                            nqm_error *err) {
    const size_t n = strlen(name);
    nqm_error why = {.status = NQM_OK};
    char *path = nqm_path_beside(from, name);
    *path_ret = NULL;
    *map = (nqm_map){0};
    if (path && !nqm_os_exists(path)) {
        nqm_free(path);
        path = nqm_path_beside(in->root, name);
    }
    if (!path)
        return nqm_fail_nomem(err, n);
    snprintf(why.message, sizeof why.message, "%.300s: it is outside of the folder of the scene, or compressed", name);
    const bool is_read = nqm_include_is_inside(name) && !(n > 3 && strcmp(name + n - 3, ".gz") == 0) &&
                         nqm_map_open(path, map, &why) == NQM_OK;
    nqm_status status = NQM_OK;
    in->n_bytes += map->n_bytes;
    if (!is_read)
        nqm_materials_unread(in->materials, why.message);
    else if (in->depth == MAX_DEPTH)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: a file includes itself, or %d files each include the next",
                          path, MAX_DEPTH);
    else if (++in->n_files > MAX_FILES || in->n_bytes > MAX_BYTES)
        status = nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: more than %d included files, or than %d MB of them", path,
                          MAX_FILES, MAX_BYTES >> 20);
    if (is_read && status == NQM_OK) {
        ++in->depth;
        *path_ret = path;
        return NQM_OK;
    }
    nqm_map_close(map);
    nqm_free(path);
    return status;
}

void nqm_include_close(nqm_includes *in, nqm_map *map, char *path) {
    --in->depth;
    nqm_map_close(map);
    nqm_free(path);
}
