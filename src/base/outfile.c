/* SPDX-License-Identifier: MIT
 *
 * Output files that are renamed to their final name when they are complete. The temporary file is locked while it is written, so that
 * a later run can tell the file of a killed process, which it removes, from one that another process is writing.
 */
#include "base/os.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>

/* Devices, pipes and open descriptors (/dev/null, /dev/fd/3) are written in place: a rename would replace them. */
static bool is_special(const char *path) {
    nqm_file_info info;
    return nqm_os_is_device(path) ||
           (nqm_os_get_info(path, &info) && info.kind != NQM_FILE_REGULAR && info.kind != NQM_FILE_FOLDER);
}

/* ---- temporary names: PATH.1.part, PATH.2.part, ... --------------------------------------------------------------- */

/* Room for the suffix ".N.part". */
enum { N_SUFFIX = 24 };

static void name_temporary(nqm_outfile *out, unsigned number) {
    const size_t n_path = strlen(out->path);
    snprintf(out->temporary, n_path + N_SUFFIX, "%s.%u.part", out->path, number);
}

/* Remove a temporary file that no process is writing. On a file system without locks it stays. */
static void remove_abandoned(const char *name) {
    const int fd = nqm_os_open(name, NQM_OPEN_WRITE);
    if (fd < 0)
        return;
    if (nqm_os_lock(fd, name) == NQM_LOCK_TAKEN)
        nqm_os_remove(name);
    nqm_os_close(fd);
}

/* Remove what killed processes have left of this output. Numbers are given from 1 up, the first free one first; gaps come from
 * writers that ended in another order. */
static void remove_all_abandoned(nqm_outfile *out) {
    enum { MAX_GAP = 8 };
    for (unsigned number = 1, gap = 0; gap < MAX_GAP; ++number) {
        name_temporary(out, number);
        gap = nqm_os_exists(out->temporary) ? 0 : gap + 1;
        if (gap == 0)
            remove_abandoned(out->temporary);
    }
}

/* Create and lock the first free temporary file. Returns a descriptor, or -1 with errno set. */
static int create_temporary(nqm_outfile *out) {
    nqm_file_info info;
    for (unsigned number = 1;; ++number) {
        name_temporary(out, number);
        remove_abandoned(out->temporary);
        const int fd = nqm_os_open_new(out->temporary, out->path);
        if (fd < 0 && errno != EEXIST)
            return -1;
        /* Another process may remove the new file before it is locked. */
        const nqm_lock lock = fd >= 0 ? nqm_os_lock(fd, out->temporary) : NQM_LOCK_GONE;
        if (lock == NQM_LOCK_TAKEN || lock == NQM_LOCK_UNSUPPORTED) {
            if (nqm_os_get_info_of(fd, &info))
                nqm_role_forget(&info);
            return fd;
        }
        if (fd >= 0)
            nqm_os_close(fd);
    }
}

/* ---- temporary files of a process that ends at once ---------------------------------------------------------------- */

enum { N_UNFINISHED = 64, N_NAME = 4096 };

/* Names are copies, because a signal handler reads them while other threads open and close outputs. More files at a time, or
 * longer names, are left to the next run with the same output. */
static struct {
    atomic_int state; /* 0: free, 1: a name is being written, 2: a file to remove */
    char name[N_NAME];
} unfinished[N_UNFINISHED];

static void note_unfinished(const char *name) {
    const size_t n = strlen(name) + 1;
    for (size_t i = 0; n <= N_NAME && i < N_UNFINISHED; ++i) {
        int is_free = 0;
        if (atomic_compare_exchange_strong(&unfinished[i].state, &is_free, 1)) {
            memcpy(unfinished[i].name, name, n);
            atomic_store(&unfinished[i].state, 2);
            return;
        }
    }
}

static void forget_unfinished(const char *name) {
    for (size_t i = 0; i < N_UNFINISHED; ++i)
        if (atomic_load(&unfinished[i].state) == 2 && strcmp(unfinished[i].name, name) == 0) {
            atomic_store(&unfinished[i].state, 0);
            return;
        }
}

void nqm_outfile_unlink_all(void) {
    for (size_t i = 0; i < N_UNFINISHED; ++i)
        if (atomic_load(&unfinished[i].state) == 2)
            nqm_os_remove(unfinished[i].name);
}

/* ---- output files ------------------------------------------------------------------------------------------------ */

/* Rename a complete file to `path`, unless that would replace an input of this run. */
static nqm_status replace(const char *temporary, const char *path, nqm_error *err) {
    nqm_file_info old;
    const bool exists = nqm_os_get_info(path, &old);
    nqm_status status = nqm_role_output(path, err);
    if (status == NQM_OK && !nqm_os_replace(temporary, path))
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", path, strerror(errno));
    if (status == NQM_OK && exists)
        nqm_role_forget(&old);
    return status;
}

/* Why a file that exists must not be replaced, or NULL. Its owner could rename over a write-protected file, and root over any. */
static const char *find_protection(const char *path) {
    nqm_file_info info;
    if (!nqm_os_get_info(path, &info))
        return nqm_os_is_link(path) ? "it is a symbolic link to nothing; remove it, or create its file" : NULL;
    if (info.kind == NQM_FILE_REGULAR && !nqm_os_is_writable(path))
        return "it is write-protected; change its permissions (chmod u+w), or give another name";
    return NULL;
}

static nqm_status open_target(const char *path, nqm_outfile *out_ret, nqm_error *err) {
    size_t n_path = strlen(path) + 1;
    bool in_place = is_special(path);
    char *names = nqm_alloc(2 * n_path + N_SUFFIX, 1); /* `path`, then `temporary` */
    *out_ret = (nqm_outfile){.path = names};
    if (!names)
        return nqm_fail_nomem(err, 2 * n_path + N_SUFFIX);
    memcpy(names, path, n_path);
    if (!in_place)
        out_ret->temporary = names + n_path;
    int fd = in_place ? nqm_os_open(path, NQM_OPEN_EMPTY) : create_temporary(out_ret);
    out_ret->stream = fd < 0 ? NULL : nqm_os_stream(fd);
    if (out_ret->stream) {
        if (!in_place)
            note_unfinished(out_ret->temporary);
        return NQM_OK;
    }
    nqm_status status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", path, strerror(errno));
    if (fd >= 0)
        nqm_os_close(fd);
    else
        out_ret->temporary = NULL; /* no file was created */
    nqm_outfile_abort(out_ret);
    return status;
}

nqm_status nqm_outfile_open(const char *path, nqm_outfile *out_ret, nqm_error *err) {
    *out_ret = (nqm_outfile){0};
    if (is_special(path))
        return open_target(path, out_ret, err);
    const char *protection = find_protection(path);
    if (protection)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", path, protection);
    char *target = nqm_os_is_link(path) ? nqm_os_real_path(path) : NULL;
    nqm_status status = nqm_role_output(path, err);
    if (status == NQM_OK)
        status = open_target(target ? target : path, out_ret, err);
    free(target);
    return status;
}

void nqm_outfile_abort(nqm_outfile *out) {
    if (out->stream)
        fclose(out->stream);
    if (out->temporary) {
        nqm_os_remove(out->temporary);
        forget_unfinished(out->temporary);
    }
    nqm_free(out->path);
    *out = (nqm_outfile){0};
}

/* Write out what is buffered. */
static nqm_status complete(nqm_outfile *out, nqm_error *err) {
    bool bad = ferror(out->stream) != 0;
    bad = fflush(out->stream) != 0 || bad;
    if (out->temporary)
        bad = !nqm_os_sync(out->stream) || bad;
    return bad ? nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", out->path, strerror(errno)) : NQM_OK;
}

nqm_status nqm_outfile_commit(nqm_outfile *out, nqm_error *err) {
    nqm_status status = complete(out, err);
    /* Rename before closing, which releases the lock. */
    if (status == NQM_OK && out->temporary) {
        status = replace(out->temporary, out->path, err);
        if (status == NQM_OK) {
            forget_unfinished(out->temporary); /* before its name can be that of another process */
            remove_all_abandoned(out);
            out->temporary = NULL; /* renamed: there is nothing to remove */
        }
    }
    const bool bad = fclose(out->stream) != 0;
    out->stream = NULL;
    if (status == NQM_OK && bad)
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", out->path, strerror(errno));
    nqm_outfile_abort(out);
    return status;
}

/* ---- sets of files ----------------------------------------------------------------------------------------------- */

nqm_status nqm_outfile_keep(nqm_outfile *out, nqm_outset *set, nqm_error *err) {
    if (!set)
        return nqm_outfile_commit(out, err);
    nqm_status status = complete(out, err);
    nqm_outfile *files = nqm_grow(set->files, &set->max_n, set->n + 1, sizeof *files);
    if (files)
        set->files = files;
    else if (status == NQM_OK)
        status = nqm_fail_nomem(err, sizeof *files);
    if (status == NQM_OK) {
        set->files[set->n++] = *out;
        *out = (nqm_outfile){0};
    }
    nqm_outfile_abort(out);
    return status;
}

nqm_status nqm_outset_commit(nqm_outset *set, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < set->n; ++i) {
        status = nqm_role_output(set->files[i].path, err);
        if (status == NQM_OK && nqm_os_is_folder(set->files[i].path))
            status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write: %s", set->files[i].path, strerror(EISDIR));
    }
    for (size_t i = 0; status == NQM_OK && i < set->n; ++i)
        status = nqm_outfile_commit(&set->files[i], err);
    nqm_outset_abort(set);
    return status;
}

void nqm_outset_abort(nqm_outset *set) {
    for (size_t i = 0; i < set->n; ++i)
        nqm_outfile_abort(&set->files[i]);
    nqm_free(set->files);
    *set = (nqm_outset){0};
}
