/* SPDX-License-Identifier: MIT
 *
 * Memory-mapped input files.
 */
#include "base/os.h"

#include <errno.h>
#include <stdlib.h>

static void close_file(nqm_map *map) {
    if (map->has_fd)
        nqm_os_close(map->fd);
    map->has_fd = false;
}

static char *only_within; /* of which files are read, without links; NULL: of any */

nqm_status nqm_files_within(const char *folder, nqm_error *err) {
    char *real = folder ? nqm_os_real_path(folder) : NULL;
    if (folder && !real)
        return nqm_fail(err, errno == ENOMEM ? NQM_ERR_NOMEM : NQM_ERR_IO, -1, "%s: %s", folder, strerror(errno));
    free(only_within);
    only_within = real;
    return NQM_OK;
}

static nqm_status check_folder(const char *path, nqm_error *err) {
    char *real = only_within ? nqm_os_real_path(path) : NULL;
    const size_t n = real ? strlen(only_within) : 0;
    const bool is_within =
        real && strncmp(real, only_within, n) == 0 && (real[n] == '/' || strcmp(only_within, "/") == 0);
    free(real);
    return !only_within || is_within
               ? NQM_OK
               : nqm_fail(err, NQM_ERR_IO, -1, "%s: is not read: no file inside of %s", path, only_within);
}

/* keep: leave the descriptor open, owned by the map. is_input: the run must not replace the file. */
static nqm_status open_map(const char *path, bool keep, bool is_input, nqm_map *map_ret, nqm_error *err) {
    *map_ret = (nqm_map){0};
    nqm_status status = check_folder(path, err);
    if (status != NQM_OK)
        return status;
    const int fd = nqm_os_open(path, NQM_OPEN_READ);
    if (fd < 0)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(errno));
    nqm_file_info info;
    const char *fault = !nqm_os_get_info_of(fd, &info)  ? strerror(errno)
                        : info.kind == NQM_FILE_FOLDER  ? "is a directory, a file is needed"
                        : info.kind != NQM_FILE_REGULAR ? "is not a regular file"
                                                        : NULL;
    status = !fault && is_input ? nqm_role_input(&info, path, err) : NQM_OK;
    const bool has_bytes = !fault && status == NQM_OK && info.n_bytes > 0;
    void *data = has_bytes ? nqm_os_map(fd, (size_t)info.n_bytes) : NULL;
    if (has_bytes && !data)
        fault = strerror(errno);
    if (fault)
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, fault);
    if (status == NQM_OK)
        *map_ret = (nqm_map){data, data ? (size_t)info.n_bytes : 0, path, keep && data, fd};
    if (!map_ret->has_fd)
        nqm_os_close(fd);
    return status;
}

nqm_status nqm_map_open(const char *path, nqm_map *map_ret, nqm_error *err) {
    return open_map(path, false, true, map_ret, err);
}

nqm_status nqm_map_open_own(const char *path, nqm_map *map_ret, nqm_error *err) {
    return open_map(path, false, false, map_ret, err);
}

nqm_status nqm_map_open_sparse(const char *path, nqm_map *map_ret, nqm_error *err) {
    enum { MAX_KEPT_FD = 256 }; /* the usual limit of a process is 1024 */
    nqm_status status = open_map(path, true, true, map_ret, err);
    if (map_ret->data)
        nqm_os_advise_pages(map_ret->data, map_ret->n_bytes, NQM_ADVICE_RANDOM);
    if (map_ret->has_fd && map_ret->fd >= MAX_KEPT_FD)
        close_file(map_ret);
    return status;
}

void nqm_map_expect(const nqm_map *map, bool everything) {
    if (!map->data)
        return;
    nqm_os_advise_pages(map->data, map->n_bytes, NQM_ADVICE_NORMAL);
    if (everything)
        nqm_os_advise_pages(map->data, map->n_bytes, NQM_ADVICE_SOON);
}

void nqm_map_close(nqm_map *map) {
    close_file(map);
    if (map->data)
        nqm_os_free_pages(map->data, map->n_bytes);
    *map = (nqm_map){0};
}
