/* SPDX-License-Identifier: MIT
 *
 * Small pieces from many places of a large file: first the leading pieces that are in the page cache, without waiting; then the
 * others, in order of offset, after asking the system to prefetch all of them.
 */
#include "base/os.h"

#include <stdlib.h>

/* Bytes. Pieces with a smaller gap are fetched in one request: a request costs as much as reading a few more pages. */
enum { MAX_GAP = 8192 };

/* Read the pieces up to the first one that is not in the page cache; returns the number of pieces read. */
static size_t read_present(int fd, size_t n, const nqm_piece *pieces, size_t n_each) {
    size_t i = 0;
    while (i < n && nqm_os_read_at(fd, pieces[i].offset, n_each, pieces[i].out, true))
        ++i;
    return i;
}

static int by_offset(const void *a, const void *b) {
    size_t left = ((const nqm_piece *)a)->offset, right = ((const nqm_piece *)b)->offset;
    return (left > right) - (left < right);
}

/* Prefetch all pieces, so that the disk reads them concurrently. */
static void announce(int fd, size_t n, const nqm_piece *pieces, size_t n_each) {
    for (size_t i = 0; i < n;) {
        size_t begin = pieces[i].offset, end = begin + n_each;
        for (; i < n && pieces[i].offset <= end + MAX_GAP; ++i)
            end = pieces[i].offset + n_each;
        nqm_os_advise(fd, begin, end - begin, NQM_ADVICE_SOON);
    }
}

void nqm_map_gather(const nqm_map *map, size_t n, nqm_piece *pieces, size_t n_each) {
    nqm_os_advise(map->fd, 0, 0, NQM_ADVICE_RANDOM); /* no read-ahead beyond the requested pieces */
    size_t n_read = read_present(map->fd, n, pieces, n_each);
    pieces += n_read, n -= n_read;
    qsort(pieces, n, sizeof *pieces, by_offset);
    announce(map->fd, n, pieces, n_each);
    for (size_t i = 0; i < n; ++i)
        if (!nqm_os_read_at(map->fd, pieces[i].offset, n_each, pieces[i].out, false))
            memset(pieces[i].out, 0xff, n_each);
}
