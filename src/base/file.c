/* SPDX-License-Identifier: MIT
 *
 * Input files mapped into memory, and output files that appear under their name only when they are complete: a reader
 * never sees half a file, and an interrupted run leaves what was there before.
 */
#include "base/base.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

void nqm_map_close_file(nqm_map *map) {
    if (map->has_fd)
        close(map->fd);
    map->has_fd = false;
}

/* keep: the descriptor stays with the map. */
static nqm_status open_map(const char *path, bool keep, nqm_map *map_ret, nqm_error *err) {
    *map_ret = (nqm_map){0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* O_NONBLOCK: a FIFO must not hang us */
    if (fd < 0)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(errno));
    nqm_status status = NQM_OK;
    struct stat st;
    if (fstat(fd, &st) != 0) {
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(errno));
    } else if (S_ISDIR(st.st_mode)) {
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: is a directory, a file is needed", path);
    } else if (!S_ISREG(st.st_mode)) {
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: is not a regular file", path);
    } else if (st.st_size > 0) {
        void *data = mmap(NULL, (size_t)st.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
        if (data == MAP_FAILED) {
            status = nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(errno));
        } else {
            map_ret->data = data;
            map_ret->n_bytes = (size_t)st.st_size;
        }
    }
    if (status == NQM_OK)
        map_ret->path = path;
    if (status == NQM_OK && keep && map_ret->data) {
        map_ret->has_fd = true;
        map_ret->fd = fd;
    } else {
        close(fd);
    }
    return status;
}

nqm_status nqm_map_open(const char *path, nqm_map *map_ret, nqm_error *err) {
    return open_map(path, false, map_ret, err);
}

nqm_status nqm_map_open_sparse(const char *path, nqm_map *map_ret, nqm_error *err) {
    enum { MAX_KEPT_FD = 256 }; /* of the 1024 that a process may usually have */
    nqm_status status = open_map(path, true, map_ret, err);
    if (map_ret->data) /* advice only, failure is harmless */
        (void)posix_madvise((void *)(uintptr_t)map_ret->data, map_ret->n_bytes, POSIX_MADV_RANDOM);
    if (map_ret->has_fd && map_ret->fd >= MAX_KEPT_FD)
        nqm_map_close_file(map_ret);
    return status;
}

void nqm_map_expect(const nqm_map *map, bool everything) {
    if (!map->data)
        return;
    void *data = (void *)(uintptr_t)map->data;
    (void)posix_madvise(data, map->n_bytes, POSIX_MADV_NORMAL);
    if (everything)
        (void)posix_madvise(data, map->n_bytes, POSIX_MADV_WILLNEED);
}

void nqm_map_close(nqm_map *map) {
    nqm_map_close_file(map);
    if (map->data)
        munmap((void *)(uintptr_t)map->data, map->n_bytes);
    *map = (nqm_map){0};
}

/* Devices and pipes (/dev/null): renaming would put a file in their place. */
static bool is_special(const char *path) {
    struct stat st;
    return stat(path, &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode);
}

static nqm_status open_special(const char *path, nqm_outfile *out_ret, nqm_error *err) {
    char *copy = nqm_strdup(path);
    if (!copy)
        return nqm_fail_nomem(err, strlen(path));
    FILE *stream = fopen(path, "wb");
    if (!stream) {
        nqm_free(copy);
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", path, strerror(errno));
    }
    *out_ret = (nqm_outfile){.stream = stream, .path = copy};
    return NQM_OK;
}

nqm_status nqm_outfile_open(const char *path, nqm_outfile *out_ret, nqm_error *err) {
    *out_ret = (nqm_outfile){0};
    if (strcmp(path, "-") == 0) {
        out_ret->stream = stdout;
        return NQM_OK;
    }
    if (is_special(path))
        return open_special(path, out_ret, err);
    static const char suffix[] = ".XXXXXX.part";
    size_t n_path = strlen(path);
    char *final_path = nqm_strdup(path);
    char *temporary = nqm_alloc(n_path + sizeof suffix, 1);
    if (!final_path || !temporary) {
        nqm_free(final_path);
        nqm_free(temporary);
        return nqm_fail_nomem(err, n_path);
    }
    memcpy(temporary, path, n_path);
    memcpy(temporary + n_path, suffix, sizeof suffix);
    int fd = mkstemps(temporary, 5);
    FILE *stream = fd < 0 ? NULL : fdopen(fd, "wb");
    if (!stream) {
        nqm_status status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", path, strerror(errno));
        if (fd >= 0) {
            close(fd);
            unlink(temporary);
        }
        nqm_free(final_path);
        nqm_free(temporary);
        return status;
    }
    mode_t mask = umask(0); /* mkstemps makes files private; give the mode that fopen would */
    umask(mask);
    (void)fchmod(fd, 0666 & ~mask);
    *out_ret = (nqm_outfile){.stream = stream, .path = final_path, .temporary = temporary};
    return NQM_OK;
}

void nqm_outfile_abort(nqm_outfile *out) {
    if (out->path && out->stream) /* standard output has no path */
        fclose(out->stream);
    if (out->temporary)
        unlink(out->temporary);
    nqm_free(out->path);
    nqm_free(out->temporary);
    *out = (nqm_outfile){0};
}

nqm_status nqm_outfile_commit(nqm_outfile *out, nqm_error *err) {
    if (!out->path) { /* standard output */
        bool bad = fflush(out->stream) != 0 || ferror(out->stream);
        *out = (nqm_outfile){0};
        return bad ? nqm_fail(err, NQM_ERR_IO, -1, "standard output: %s", strerror(errno)) : NQM_OK;
    }
    bool bad = ferror(out->stream) != 0;
    bad = fflush(out->stream) != 0 || bad;
    if (out->temporary)
        bad = fsync(fileno(out->stream)) != 0 || bad;
    bad = fclose(out->stream) != 0 || bad;
    out->stream = NULL;
    if (!bad && out->temporary)
        bad = rename(out->temporary, out->path) != 0;
    nqm_status status =
        bad ? nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", out->path, strerror(errno)) : NQM_OK;
    if (!bad) {
        nqm_free(out->temporary);
        out->temporary = NULL;
    }
    nqm_outfile_abort(out);
    return status;
}
