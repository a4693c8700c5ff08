/* SPDX-License-Identifier: MIT
 *
 * mmap() by copying, and what a page does not have: processes, shared libraries, archives, and the decoders of pictures, which the
 * browser decodes.
 */
#include "base/library.h"
#include "io/io.h"
#include "io/raster_decoders.h"

#include <sys/mman.h>
#include <unistd.h>

void *mmap(void *address, size_t n_bytes, int protection, int flags, int fd, off_t offset) {
    (void)address, (void)protection;
    unsigned char *block = nqm_alloc(n_bytes, 1);
    size_t at = 0;
    while (block && !(flags & MAP_ANONYMOUS) && at < n_bytes) {
        const ssize_t n = pread(fd, block + at, n_bytes - at, offset + (off_t)at);
        if (n <= 0) {
            nqm_free(block);
            return MAP_FAILED;
        }
        at += (size_t)n;
    }
    return block ? block : MAP_FAILED;
}

int munmap(void *address, size_t n_bytes) {
    (void)n_bytes;
    nqm_free(address);
    return 0;
}

nqm_status nqm_zip_read(const nqm_map *map, const char *member, size_t max_bytes, unsigned char **data_ret,
                        size_t *n_bytes_ret, nqm_error *err) {
    (void)max_bytes;
    *data_ret = NULL, *n_bytes_ret = 0;
    return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: '%s' is not read from an archive here (byte 0); drop the archive on the page", map->path,
                    member);
}

nqm_status nqm_zip_examples(const nqm_map *map, const char *suffix, char *text, size_t n_text, nqm_error *err) {
    (void)map, (void)suffix, (void)n_text, (void)err;
    *text = 0;
    return NQM_OK;
}

/* expat's hash salt. */
int getpid(void);
int getpid(void) {
    return 1;
}

const char *nqm_build_info(void) {
    return "WebAssembly, 128-bit SIMD";
}
