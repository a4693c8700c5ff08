/* SPDX-License-Identifier: MIT
 *
 * Locks between processes: flock() on a file, which also works over NFS, as a lock of the server.
 */
#include "base/base.h"
#include "base/memory_test.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

static void (*lock_hook)(void);

void nqm_lock_hook(void (*hook)(void)) {
    lock_hook = hook;
}

static void call_lock_hook(void) {
    void (*hook)(void) = lock_hook;
    lock_hook = NULL;
    if (hook)
        hook();
}

static int open_or_create(const char *path, bool *existed_ret) {
    enum { FLAGS = O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC };
    int fd = open(path, FLAGS | O_EXCL, 0666);
    *existed_ret = fd < 0 && errno == EEXIST;
    return *existed_ret ? open(path, FLAGS, 0666) : fd;
}

nqm_status nqm_lock_open(const char *path, int *fd_ret, bool *existed_ret, nqm_error *err) {
    for (;;) {
        const int fd = *fd_ret = open_or_create(path, existed_ret);
        if (fd < 0)
            return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot be written: %s", path, strerror(errno));
        call_lock_hook();
        const bool is_held = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        if (!is_held && nqm_is_file_at(fd, path))
            return NQM_OK;
        close(fd);
        *fd_ret = -1;
        if (is_held)
            return NQM_OK;
    }
}
