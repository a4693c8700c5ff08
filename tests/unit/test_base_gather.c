/* SPDX-License-Identifier: MIT
 *
 * Gathering scattered bytes from a file: correct bytes whether or not pages are in memory, across page boundaries,
 * and past the end.
 */
#include "base/base.h"
#include "support/check.h"
#include "support/scratch.h"

#include <fcntl.h>

enum { N_BYTES = 3000001, N_EACH = 8, N_PIECES = 700 };

static unsigned char byte_at(size_t i) {
    return (unsigned char)nqm_hash_u64(3, i);
}

static int make_file(void **state) {
    (void)state;
    unsigned char *data = malloc(N_BYTES);
    nqm_outfile out;
    if (!data || nqm_outfile_open(scratch_path("large"), &out, NULL) != NQM_OK)
        return -1;
    for (size_t i = 0; i < N_BYTES; ++i)
        data[i] = byte_at(i);
    fwrite(data, 1, N_BYTES, out.stream);
    free(data);
    return nqm_outfile_commit(&out, NULL) == NQM_OK ? 0 : -1;
}

static void drop_from_memory(void) {
    int fd = open(scratch_path("large"), O_RDONLY);
    (void)posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED); /* a failure does not change the bytes */
    close(fd);
}

/* Some offsets at the ends of the file, some across page boundaries, most of them uniform. */
static size_t choose_offset(size_t i, nqm_rng *rng) {
    const size_t special[] = {0, N_BYTES - N_EACH, 4096 - 4, 8192 - 1, 4096, 2 * 65536 - 7};
    return i < 6 ? special[i] : (size_t)nqm_rng_below(rng, N_BYTES - N_EACH + 1);
}

static void check_gathered(const nqm_map *map) {
    static unsigned char out[N_PIECES][N_EACH];
    nqm_piece pieces[N_PIECES];
    size_t offset[N_PIECES];
    nqm_rng rng = nqm_rng_make(5, 0);
    memset(out, 0, sizeof out);
    for (size_t i = 0; i < N_PIECES; ++i) {
        offset[i] = choose_offset(i, &rng);
        pieces[i] = (nqm_piece){offset[i], out[i]};
    }
    nqm_map_gather(map, N_PIECES, pieces, N_EACH);
    for (size_t i = 0; i < N_PIECES; ++i)
        for (size_t k = 0; k < N_EACH; ++k)
            assert_int_equal(out[i][k], byte_at(offset[i] + k));
}

TEST(gathers_from_disk_and_memory) {
    nqm_map map;
    drop_from_memory();
    assert_int_equal(nqm_map_open_sparse(scratch_path("large"), &map, NULL), NQM_OK);
    assert_true(map.has_fd);
    check_gathered(&map);
    check_gathered(&map);
    nqm_map_expect(&map, false);
    check_gathered(&map);
    nqm_map_expect(&map, true);
    check_gathered(&map);
    assert_int_equal(map.data[N_BYTES - 1], byte_at(N_BYTES - 1));
    nqm_map_close(&map);
    assert_null(map.data);
}

static void assert_past_end(const nqm_map *map, size_t offset) {
    static const unsigned char missing[N_EACH] = {255, 255, 255, 255, 255, 255, 255, 255};
    unsigned char out[2][N_EACH] = {{0}};
    nqm_piece pieces[2] = {{offset, out[0]}, {100, out[1]}};
    nqm_map_gather(map, 2, pieces, N_EACH);
    assert_memory_equal(out[0], missing, N_EACH);
    for (size_t k = 0; k < N_EACH; ++k)
        assert_int_equal(out[1][k], byte_at(100 + k));
}

TEST(says_what_is_past_the_end) {
    nqm_map map;
    assert_int_equal(nqm_map_open_sparse(scratch_path("large"), &map, NULL), NQM_OK);
    const size_t offsets[] = {N_BYTES - N_EACH + 1, N_BYTES, N_BYTES + 10000};
    for (size_t i = 0; i < 3; ++i)
        assert_past_end(&map, offsets[i]);
    assert_int_equal(truncate(scratch_path("large"), 1000),
                     0); /* after opening: reading a plain mapping would raise SIGBUS */
    assert_past_end(&map, 500000);
    nqm_map_close(&map);
}

TEST_FILE(make_file, NULL)
