/* SPDX-License-Identifier: MIT
 *
 * Memory-mapped input files, and output files that are renamed to their final name when they are complete: a reader
 * never sees a partial file, and an interrupted run leaves an existing file unchanged.
 */
#include "base/base.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

void nqm_map_close_file(nqm_map *map) {
    if (map->has_fd)
        close(map->fd);
    map->has_fd = false;
}

/* keep: leave the descriptor open, owned by the map. */
static nqm_status open_map(const char *path, bool keep, nqm_map *map_ret, nqm_error *err) {
    *map_ret = (nqm_map){0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* O_NONBLOCK: opening a FIFO must not block */
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
    enum { MAX_KEPT_FD = 256 }; /* the usual limit of a process is 1024 */
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

/* Devices, pipes and open descriptors (/dev/null, /dev/fd/3) are written in place: a rename would replace them. */
static bool is_special(const char *path) {
    struct stat st;
    return strncmp(path, "/dev/", 5) == 0 || (stat(path, &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode));
}

static const char suffix[] = ".XXXXXX.part";

/* Create the file `name`, which ends in `suffix`, after replacing each X with a random character. Returns a descriptor,
 * or -1 with errno set. open() applies the umask; mkstemps() would make the file accessible to its owner only. */
static int create_temporary(char *name) {
    static const char letters[] = "0123456789abcdefghijklmnopqrstuvwxyz";
    static atomic_uint counter;
    char *random = name + strlen(name) - (sizeof suffix - 1) + 1;
    int fd;
    do {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        uint64_t bits = nqm_hash_u64((uint64_t)getpid() << 32 | (uint64_t)now.tv_nsec, atomic_fetch_add(&counter, 1));
        for (int i = 0; i < 6; ++i, bits /= sizeof letters - 1)
            random[i] = letters[bits % (sizeof letters - 1)];
        fd = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (fd < 0 && errno == EEXIST);
    return fd;
}

nqm_status nqm_outfile_open(const char *path, nqm_outfile *out_ret, nqm_error *err) {
    size_t n_path = strlen(path) + 1;
    bool in_place = is_special(path);
    char *names = nqm_alloc(2 * n_path + sizeof suffix, 1); /* `path`, then `temporary` */
    *out_ret = (nqm_outfile){.path = names};
    if (!names)
        return nqm_fail_nomem(err, 2 * n_path + sizeof suffix);
    memcpy(names, path, n_path);
    if (!in_place) {
        out_ret->temporary = names + n_path;
        snprintf(out_ret->temporary, n_path + sizeof suffix, "%s%s", path, suffix);
    }
    int fd =
        in_place ? open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : create_temporary(out_ret->temporary);
    out_ret->stream = fd < 0 ? NULL : fdopen(fd, "wb");
    if (out_ret->stream)
        return NQM_OK;
    nqm_status status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    else
        out_ret->temporary = NULL; /* no file was created */
    nqm_outfile_abort(out_ret);
    return status;
}

void nqm_outfile_abort(nqm_outfile *out) {
    if (out->stream)
        fclose(out->stream);
    if (out->temporary)
        unlink(out->temporary);
    nqm_free(out->path);
    *out = (nqm_outfile){0};
}

nqm_status nqm_outfile_commit(nqm_outfile *out, nqm_error *err) {
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
    if (!bad)
        out->temporary = NULL; /* renamed: there is nothing to remove */
    nqm_outfile_abort(out);
    return status;
}
