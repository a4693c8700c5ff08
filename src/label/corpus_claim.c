/* SPDX-License-Identifier: MIT
 *
 * Who makes which work file, among processes that share a folder and nothing else: a lock on a file beside it. The
 * system drops the lock of a process that ends, however it ends, so that its work is free for the others at once; no
 * clock and no heartbeat is needed. (flock() works over NFS too, there as a lock of the server.)
 */
#include "label/corpus.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

static char *claim_path(const char *path) {
    size_t n = strlen(path) + sizeof ".claim";
    char *name = nqm_alloc(n, 1);
    if (name)
        snprintf(name, n, "%s.claim", path);
    return name;
}

nqm_status nqm_corpus_claim(const char *path, int *claim_ret, nqm_error *err) {
    *claim_ret = -1;
    char *name = claim_path(path);
    if (!name)
        return nqm_fail_nomem(err, strlen(path));
    int fd = open(name, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    nqm_status status = NQM_OK;
    if (fd < 0) {
        status = nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot be written: %s", name, strerror(errno));
    } else if (flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) {
        /* Where the file system knows no locks, work may be done twice, with the same result. */
        *claim_ret = fd;
    } else {
        close(fd);
    }
    nqm_free(name);
    return status;
}

/* The file goes before the lock: who has opened it meanwhile gets a lock on a file without a name, and finds the work
 * done. */
void nqm_corpus_release(const char *path, int claim) {
    char *name = claim_path(path);
    if (name)
        unlink(name);
    nqm_free(name);
    close(claim);
}
