/* SPDX-License-Identifier: MIT
 *
 * Loading of files: sampling a MERL table loads few of its pages, and results depend neither on the number of
 * directions read before nor on the number of open files; tensors of RGL files can have any alignment.
 */
#include "base/base.h"
#include "brdf/brdf.h"
#include "support/brdf_files.h"
#include "support/check.h"

#include <fcntl.h>
#include <nqm/samples.h>
#include <sys/mman.h>
#include <sys/resource.h>

static const double degree = 3.14159265358979323846 / 180;

static const char *merl_path(void) {
    const char *path = scratch_path("table.binary");
    if (access(path, R_OK) != 0)
        blob_put(make_merl(), path);
    return path;
}

/* n directions in random order. hd: (n, 3). */
static void scatter_directions(size_t n, double *hd) {
    nqm_rng rng = nqm_rng_make(7, 0);
    for (size_t i = 0; i < n; ++i) {
        hd[3 * i] = 60 * degree * nqm_rng_uniform(&rng);
        hd[3 * i + 1] = 80 * degree * nqm_rng_uniform(&rng);
        hd[3 * i + 2] = 180 * degree * nqm_rng_uniform(&rng);
    }
}

/* ---- MERL -------------------------------------------------------------------------------------------------------- */

/* So many that the table is loaded into memory: in one call, again, and one by one in reverse order. */
TEST(gives_the_same_to_early_and_late) {
    enum { N = 3000 };
    static double hd[3 * N], at_once[3 * N], single[3 * N], again[3 * N];
    uint8_t flag[N], flag_single[N];
    scatter_directions(N, hd);
    nqm_brdf *table = must_open(merl_path()), *other = must_open(merl_path());
    nqm_brdf_eval_half_diff(table, N, hd, at_once, flag);
    nqm_brdf_eval_half_diff(table, N, hd, again, NULL);
    for (size_t i = N; i-- > 0;)
        nqm_brdf_eval_half_diff(other, 1, hd + 3 * i, single + 3 * i, flag_single + i);
    assert_memory_equal(at_once, again, sizeof again);
    assert_memory_equal(at_once, single, sizeof single);
    assert_memory_equal(flag, flag_single, sizeof flag);
    nqm_brdf_free(table);
    nqm_brdf_free(other);
}

/* Number of pages of the file in the page cache; *n_pages: number of all its pages. */
static size_t count_resident(const char *path, size_t *n_pages) {
    nqm_map map;
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    size_t page = (size_t)sysconf(_SC_PAGESIZE), n = (map.n_bytes + page - 1) / page, n_resident = 0;
    unsigned char *resident = calloc(n, 1);
    assert_non_null(resident);
    assert_int_equal(mincore((void *)(uintptr_t)map.data, map.n_bytes, resident), 0);
    for (size_t i = 0; i < n; ++i)
        n_resident += resident[i] & 1;
    free(resident);
    nqm_map_close(&map);
    *n_pages = n;
    return n_resident;
}

/* Evict the file from the page cache; false if the file system does not support that. */
static bool drop_from_memory(const char *path) {
    int fd = open(path, O_RDONLY);
    assert_true(fd >= 0);
    assert_int_equal(fsync(fd), 0);
    bool told = posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED) == 0;
    close(fd);
    size_t n_pages;
    return told && count_resident(path, &n_pages) < n_pages / 100;
}

TEST(loads_only_what_a_sampling_needs) {
    enum { N = 500 };
    const char *path = merl_path();
    if (!drop_from_memory(path))
        skip();
    nqm_directions_options options = nqm_directions_options_default();
    options.n = N;
    nqm_directions *directions;
    assert_int_equal(nqm_directions_create(&options, 0, NULL, &directions, NULL), NQM_OK);
    nqm_brdf *table = must_open(path);
    float rgb[3 * N];
    size_t n_pages, n_opened = count_resident(path, &n_pages);
    assert_true(n_opened <= 40); /* the header, a few cells, and pages read ahead */
    assert_int_equal(nqm_sample(table, directions, NQM_INVALID_DROP, rgb, NULL, NULL, NULL), NQM_OK);
    size_t n_sampled = count_resident(path, &n_pages);
    print_message("%zu of %zu pages after opening, %zu after %d directions\n", n_opened, n_pages, n_sampled, N);
    assert_true(n_sampled > 500);
    assert_true(n_sampled < n_pages * 3 / 10);
    nqm_brdf_free(table);
    nqm_directions_free(directions);
}

/* Tables keep their files open, but not so many that the process runs out of file descriptors. */
TEST(leaves_files_to_others) {
    enum { N_TABLES = 300, N = 30 };
    static nqm_brdf *tables[N_TABLES];
    double hd[3 * N], first[3 * N], last[3 * N];
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &limit), 0);
    if (limit.rlim_cur < 290)
        skip();
    limit.rlim_cur = 290;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &limit), 0);
    for (size_t i = 0; i < N_TABLES; ++i)
        tables[i] = must_open(merl_path());
    scatter_directions(N, hd);
    nqm_brdf_eval_half_diff(tables[0], N, hd, first, NULL);
    nqm_brdf_eval_half_diff(tables[N_TABLES - 1], N, hd, last, NULL);
    assert_memory_equal(first, last, sizeof last);
    for (size_t i = 0; i < N_TABLES; ++i)
        nqm_brdf_free(tables[i]);
}

/* ---- RGL --------------------------------------------------------------------------------------------------------- */

TEST(reads_tensors_at_any_byte) {
    enum { N = 200 };
    double hd[3 * N], aligned[3 * N], shifted[3 * N];
    scatter_directions(N, hd);
    for (size_t shift = 0; shift < 6; ++shift) {
        const char *path = scratch_path("shifted.bsdf");
        blob_put(make_shifted_rgl(shift), path);
        nqm_brdf *brdf = must_open(path);
        assert_int_equal(unlink(path), 0); /* open files stay readable */
        nqm_brdf_eval_half_diff(brdf, N, hd, shift ? shifted : aligned, NULL);
        if (shift)
            assert_memory_equal(shifted, aligned, sizeof aligned);
        nqm_brdf_free(brdf);
    }
}
