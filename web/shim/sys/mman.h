/* SPDX-License-Identifier: MIT
 *
 * Mapped files as copies, aligned to 64 bytes (shim/posix.c).
 */
#ifndef NQM_WEB_SYS_MMAN_H
#define NQM_WEB_SYS_MMAN_H
#include <sys/types.h>
#define PROT_READ                   1
#define PROT_WRITE                  2
#define MAP_PRIVATE                 2
#define MAP_ANONYMOUS               32
#define MAP_FAILED                  ((void *)-1)
#define POSIX_MADV_NORMAL           0
#define POSIX_MADV_RANDOM           1
#define POSIX_MADV_WILLNEED         3
#define MADV_HUGEPAGE               14
#define posix_madvise(a, n, advice) ((void)(a), (void)(n), (void)(advice), 0)
#define madvise(a, n, advice)       ((void)(a), 0)
void *mmap(void *address, size_t n_bytes, int protection, int flags, int fd, off_t offset);
int munmap(void *address, size_t n_bytes);
#endif
