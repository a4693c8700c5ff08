/* SPDX-License-Identifier: MIT
 *
 * mmap() by copying, and what else of POSIX a page does not have.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void *mmap(void *address, size_t n_bytes, int protection, int flags, int fd, off_t offset) {
    (void)address, (void)protection;
    const size_t n_block = (n_bytes + 63) / 64 * 64;
    unsigned char *block = aligned_alloc(64, n_block);
    size_t at = 0;
    if (block)
        memset(block, 0, n_block);
    while (block && !(flags & MAP_ANONYMOUS) && at < n_bytes) {
        const ssize_t n = pread(fd, block + at, n_bytes - at, offset + (off_t)at);
        if (n <= 0) {
            free(block);
            return MAP_FAILED;
        }
        at += (size_t)n;
    }
    return block ? block : MAP_FAILED;
}

int munmap(void *address, size_t n_bytes) {
    (void)n_bytes;
    free(address);
    return 0;
}

/* expat's hash salt. */
int getpid(void);
int getpid(void) {
    return 1;
}
