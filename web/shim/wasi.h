/* SPDX-License-Identifier: MIT
 *
 * Included before every file of the WebAssembly build: what POSIX has and wasi-libc has not. There is one process and one thread, and
 * files are in the memory of the page, so locks are always free, nothing is prefetched, and permissions do not exist.
 */
#ifndef NQM_WEB_WASI_H
#define NQM_WEB_WASI_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <time.h>

#define LOCK_EX 2
#define LOCK_NB 4
static inline int flock(int fd, int operation) {
    (void)fd, (void)operation;
    return 0;
}
static inline int fchmod(int fd, mode_t mode) {
    (void)fd, (void)mode;
    return 0;
}
static inline char *realpath(const char *path, char *resolved) {
    (void)resolved;
    return strdup(path);
}
#define tmpfile() ((FILE *)NULL)

#endif
