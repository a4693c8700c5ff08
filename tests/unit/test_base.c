/* SPDX-License-Identifier: MIT
 *
 * The base module: allocation limits, atomic output files, mapped input, number formats under another locale, random
 * numbers against published values, SHA-256 against the FIPS 180-4 examples, parallel loops, libraries loaded at run
 * time.
 */
#include "base/base.h"
#include "base/memory_test.h"
#include "base/os.h"
#include "support/test.h"

#include <errno.h>
#include <fcntl.h>
#include <locale.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

/* A text is added once, also where it is a part of another one; one that does not fit is cut and ends with dots. */
TEST(remarks_are_joined) {
    char remark[20] = "";
    nqm_remark_add(remark, sizeof remark, "xab");
    nqm_remark_add(remark, sizeof remark, "ab");
    nqm_remark_add(remark, sizeof remark, "%s", "ab");
    nqm_remark_add(remark, sizeof remark, "%s", "");
    assert_string_equal(remark, "xab; ab");
    nqm_remark_add(remark, sizeof remark, "%d texels differ", 12);
    assert_string_equal(remark, "xab; ab; 12 texe...");
    nqm_remark_add(remark, sizeof remark, "more");
    assert_string_equal(remark, "xab; ab; 12 texe...");
}

TEST(test_alloc_refuses_overflow) {
    assert_null(nqm_alloc(SIZE_MAX / 2, 4));
    assert_null(nqm_alloc(SIZE_MAX, 1));
    unsigned char *block = nqm_alloc(100, 3);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 64, 0);
    for (int i = 0; i < 300; ++i)
        assert_int_equal(block[i], 0);
    nqm_free(block);
}

TEST(test_alloc_fails_when_told) {
    nqm_alloc_fail_after(1);
    void *first = nqm_alloc(1, 1), *second = nqm_alloc(1, 1), *third = nqm_alloc(1, 1);
    nqm_alloc_fail_after(-1);
    assert_non_null(first);
    assert_null(second);
    assert_non_null(third);
    nqm_free(first);
    nqm_free(third);
}

TEST(test_libraries_when_needed) {
    const char *const names[] = {"cos", "sqrt"}, *const missing[] = {"cos", "nqm_no_such_function"};
    struct {
        double (*cosine)(double), (*root)(double);
    } m;
    assert_true(nqm_dynamic_load("libm.so.6", 2, names, &m));
    assert_true(m.cosine(0) == 1 && m.root(9) == 3);
    assert_false(nqm_dynamic_load("libm.so.6", 2, missing, &m));
    assert_false(nqm_dynamic_load("libnqm-no-such-library.so.1", 2, names, &m));
}

static char folder[] = "/tmp/nqm-test-base-XXXXXX";

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    return rmdir(folder); /* fails if a test has not removed a temporary file */
}

static void path_in_folder(char *path, size_t n, const char *name) {
    snprintf(path, n, "%s/%s", folder, name);
}

static void write_text(const char *path, const char *text) {
    nqm_outfile out;
    assert_int_equal(nqm_outfile_open(path, &out, NULL), NQM_OK);
    fputs(text, out.stream);
    assert_int_equal(nqm_outfile_commit(&out, NULL), NQM_OK);
}

static void assert_content(const char *path, const char *text) {
    nqm_map map;
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    assert_int_equal(map.n_bytes, strlen(text));
    if (map.n_bytes)
        assert_memory_equal(map.data, text, map.n_bytes);
    nqm_map_close(&map);
}

TEST(test_outfile_appears_only_when_complete) {
    char path[256];
    path_in_folder(path, sizeof path, "out.txt");
    write_text(path, "old");
    nqm_outfile out;
    assert_int_equal(nqm_outfile_open(path, &out, NULL), NQM_OK);
    fputs("new and longer", out.stream);
    fflush(out.stream);
    assert_content(path, "old");
    nqm_outfile_abort(&out);
    assert_content(path, "old");
    write_text(path, "newer");
    assert_content(path, "newer");
    write_text(path, "");
    assert_content(path, "");
    unlink(path);
}

/* Write `text` to both files as a set, of which the second may be refused. */
static nqm_status write_set(const char *first, const char *second, const char *text) {
    nqm_outset set = {0};
    const char *const paths[] = {first, second};
    for (int i = 0; i < 2; ++i) {
        nqm_outfile out;
        assert_int_equal(nqm_outfile_open(paths[i], &out, NULL), NQM_OK);
        fputs(text, out.stream);
        assert_int_equal(nqm_outfile_keep(&out, &set, NULL), NQM_OK);
        assert_null(out.path);
    }
    assert_content(first, "old");
    return nqm_outset_commit(&set, NULL);
}

TEST(test_outset_is_replaced_together) {
    char first[256], second[256];
    path_in_folder(first, sizeof first, "material");
    path_in_folder(second, sizeof second, "map");
    write_text(first, "old");
    assert_int_equal(mkdir(second, 0777), 0);
    assert_int_equal(write_set(first, second, "new"), NQM_ERR_IO);
    assert_content(first, "old");
    rmdir(second);
    assert_int_equal(write_set(first, second, "new"), NQM_OK);
    assert_content(first, "new");
    assert_content(second, "new");
    unlink(first);
    unlink(second);
}

/* Two temporary files of the same output that a killed process has left, in the first and third place. */
static void leave_files(const char *path) {
    pid_t child = fork();
    if (child == 0) {
        nqm_outfile left[3];
        for (int i = 0; i < 3; ++i)
            if (nqm_outfile_open(path, &left[i], NULL) != NQM_OK)
                raise(SIGTERM);
        nqm_outfile_abort(&left[1]);
        raise(SIGKILL);
    }
    int end;
    assert_int_equal(waitpid(child, &end, 0), child);
    assert_int_equal(WTERMSIG(end), SIGKILL);
}

static bool exists(const char *path, const char *suffix) {
    char name[300];
    snprintf(name, sizeof name, "%s%s", path, suffix);
    return access(name, F_OK) == 0;
}

TEST(test_outfile_removes_those_of_killed_processes) {
    char path[256], other[256];
    path_in_folder(path, sizeof path, "killed.txt");
    path_in_folder(other, sizeof other, "killed.txt2");
    nqm_outfile living, second;
    leave_files(path);
    assert_true(exists(path, ".1.part") && !exists(path, ".2.part") && exists(path, ".3.part"));
    assert_int_equal(nqm_outfile_open(path, &living, NULL), NQM_OK); /* takes the place of the first */
    fputs("living", living.stream);
    fflush(living.stream);
    assert_content(living.temporary, "living");
    assert_int_equal(nqm_outfile_open(other, &second, NULL), NQM_OK);
    write_text(path, "done");
    assert_content(path, "done");
    assert_true(exists(path, ".1.part") && !exists(path, ".2.part") && !exists(path, ".3.part"));
    assert_true(exists(other, ".1.part"));
    assert_int_equal(nqm_outfile_commit(&living, NULL), NQM_OK);
    assert_content(path, "living");
    nqm_outfile_abort(&second);
    unlink(path);
}

TEST(test_outfiles_vanish_with_the_process) {
    char path[256], other[256];
    path_in_folder(path, sizeof path, "vanish.txt");
    path_in_folder(other, sizeof other, "finished.txt");
    nqm_outfile finished, open_file;
    assert_int_equal(nqm_outfile_open(other, &finished, NULL), NQM_OK);
    assert_int_equal(nqm_outfile_open(path, &open_file, NULL), NQM_OK);
    assert_int_equal(nqm_outfile_commit(&finished, NULL), NQM_OK);
    nqm_outfile_unlink_all();
    assert_false(exists(path, ".1.part"));
    assert_true(exists(other, ""));
    nqm_outfile_abort(&open_file);
    assert_false(exists(path, ""));
    unlink(other);
}

TEST(test_outfile_in_missing_folder) {
    char path[256];
    path_in_folder(path, sizeof path, "no/such/folder/out.txt");
    nqm_outfile out;
    nqm_error err = {0};
    assert_int_equal(nqm_outfile_open(path, &out, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, path));
    assert_null(out.stream);
}

/* Renaming a file over a device would replace the device, which root is allowed to do. */
TEST(test_outfile_writes_pipes_in_place) {
    char path[256], text[8] = "";
    path_in_folder(path, sizeof path, "pipe");
    assert_int_equal(mkfifo(path, 0600), 0);
    int fd = open(path, O_RDWR); /* keeps both ends of the pipe open */
    assert_true(fd >= 0);
    write_text(path, "piped");
    assert_int_equal(read(fd, text, sizeof text), 5);
    assert_string_equal(text, "piped");
    struct stat st;
    assert_int_equal(stat(path, &st), 0);
    assert_true(S_ISFIFO(st.st_mode));
    nqm_outfile out;
    assert_int_equal(nqm_outfile_open(path, &out, NULL), NQM_OK);
    nqm_outfile_abort(&out);
    assert_int_equal(stat(path, &st), 0);
    close(fd);
    unlink(path);
}

TEST(test_outfile_keeps_permissions_and_links) {
    char path[256], link_path[256];
    struct stat st;
    nqm_outfile out;
    path_in_folder(path, sizeof path, "private.txt");
    path_in_folder(link_path, sizeof link_path, "link.txt");
    write_text(path, "first");
    assert_int_equal(chmod(path, 0600), 0);
    assert_int_equal(symlink("private.txt", link_path), 0);
    write_text(link_path, "second");
    assert_content(path, "second");
    assert_true(lstat(link_path, &st) == 0 && S_ISLNK(st.st_mode));
    assert_true(stat(path, &st) == 0 && (st.st_mode & 0777) == 0600);
    assert_int_equal(chmod(path, 0400), 0);
    assert_int_equal(nqm_outfile_open(link_path, &out, NULL), NQM_ERR_IO);
    unlink(path);
    assert_int_equal(nqm_outfile_open(link_path, &out, NULL), NQM_ERR_IO);
    unlink(link_path);
}

/* Last, because roles are kept until the process ends. */
TEST(test_inputs_are_not_replaced) {
    char path[256], other[256];
    nqm_map map;
    nqm_outfile out, late;
    path_in_folder(path, sizeof path, "input.txt");
    path_in_folder(other, sizeof other, "output.txt");
    write_text(path, "input");
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    nqm_map_close(&map);
    write_text(path, "input"); /* nothing is kept before this: */
    nqm_roles_enforce();
    assert_int_equal(nqm_outfile_open(other, &late, NULL), NQM_OK);
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    nqm_map_close(&map);
    assert_int_equal(nqm_outfile_open(path, &out, NULL), NQM_ERR_ARG);
    assert_int_equal(link(path, other), 0); /* becomes an input while it is written */
    assert_int_equal(nqm_outfile_commit(&late, NULL), NQM_ERR_ARG);
    assert_content(path, "input");
    unlink(other);
    write_text(other, "old");
    assert_int_equal(nqm_outfile_open(other, &out, NULL), NQM_OK);
    assert_int_equal(nqm_map_open(other, &map, NULL), NQM_ERR_ARG);
    assert_int_equal(nqm_map_open_own(other, &map, NULL), NQM_OK);
    nqm_map_close(&map);
    nqm_outfile_abort(&out);
    unlink(other);
    unlink(path);
}

TEST(test_map_refuses_what_is_no_file) {
    nqm_map map;
    nqm_error err = {0};
    assert_int_equal(nqm_map_open(folder, &map, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "directory"));
    assert_int_equal(nqm_map_open("/nonexistent/file", &map, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "/nonexistent/file"));
    assert_null(map.data);
    char path[256];
    path_in_folder(path, sizeof path, "fifo");
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(nqm_map_open(path, &map, &err), NQM_ERR_IO);
    unlink(path);
}

TEST(folders_are_listed_in_order) {
    static const char *const expected[] = {".hidden", "B", "a", "inside", "link"};
    char path[256], inner[300];
    nqm_names names = {.n = 0};
    nqm_file_info info, same;
    path_in_folder(path, sizeof path, "listed");
    assert_true(nqm_os_make_folder(path) && nqm_os_is_folder(path) && !nqm_os_make_folder(path));
    for (size_t i = 0; i < 5; ++i) {
        snprintf(inner, sizeof inner, "%s/%s", path, expected[4 - i]);
        if (i == 0)
            assert_int_equal(symlink("nothing", inner), 0);
        else if (i == 1)
            assert_true(nqm_os_make_folder(inner) && !nqm_os_is_link(inner));
        else
            write_text(inner, "text");
        assert_true(i > 0 || (nqm_os_is_link(inner) && !nqm_os_exists(inner)));
    }
    assert_true(nqm_os_get_info(inner, &info) && info.kind == NQM_FILE_REGULAR && info.n_bytes == 4);
    assert_true(nqm_os_get_info(path, &same) && same.kind == NQM_FILE_FOLDER && same.number != info.number);
    assert_int_equal(nqm_os_list_folder(path, &names, NULL), NQM_OK);
    assert_int_equal(names.n, 5);
    for (size_t i = 0; i < names.n; ++i) {
        assert_string_equal(nqm_name(&names, i), expected[i]);
        snprintf(inner, sizeof inner, "%s/%s", path, expected[i]);
        assert_false(nqm_os_remove_folder(path));
        assert_true(nqm_os_remove(inner) || nqm_os_remove_folder(inner));
    }
    nqm_names_free(&names);
    assert_true(nqm_os_remove_folder(path));
    assert_int_equal(nqm_os_list_folder(path, &names, NULL), NQM_ERR_IO);
}

TEST(test_numbers_survive_any_locale) {
    /* A locale with decimal commas, if installed; the round trip must be exact in any locale. */
    (void)(setlocale(LC_ALL, "de_DE.UTF-8") || setlocale(LC_ALL, "fr_FR.UTF-8"));
    const double values[] = {0.1, 1.0 / 3.0, -2.5e-300, 6.02214076e23, 0, 123456789012345678.0};
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i) {
        char text[32];
        const char *end;
        double back;
        nqm_format_double(text, sizeof text, values[i]);
        assert_null(strchr(text, ','));
        assert_true(nqm_parse_double(text, &end, &back));
        assert_true(back == values[i] && *end == '\0');
    }
    setlocale(LC_ALL, "C");
    const char *end;
    double v;
    assert_false(nqm_parse_double("nan", &end, &v));
    assert_false(nqm_parse_double("inf", &end, &v));
    assert_false(nqm_parse_double("x", &end, &v));
    assert_false(nqm_parse_double("1e999", &end, &v));
}

TEST(test_endian) {
    const unsigned char bytes[] = {0, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0xf0, 0x3f};
    assert_int_equal(nqm_load_u16(bytes + 1), 0x0201);
    assert_int_equal(nqm_load_u32(bytes + 1), 0x04030201);
    assert_true(nqm_load_u64(bytes + 1) == 0x3ff0060504030201u);
    unsigned char out[8];
    nqm_store_f64(out, 1.5);
    assert_int_equal(out[7], 0x3f);
    assert_int_equal(out[6], 0xf8);
    assert_true(nqm_load_f64(out) == 1.5);
    nqm_store_f32(out, -0.25f);
    assert_true(nqm_load_f32(out) == -0.25f);
    /* two's complement of every length, in both orders of bytes */
    const unsigned char minus[] = {0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff}, low[] = {0x80, 0, 0, 0, 0, 0, 0, 0};
    for (unsigned char n = 1; n <= 8; n = (unsigned char)(2 * n)) {
        const nqm_number_type is_signed = {.kind = 'i', .n_bytes = n}, is_unsigned = {.kind = 'u', .n_bytes = n};
        assert_true(nqm_load_number(minus, is_signed, false) == -2);
        assert_true(nqm_load_number(low, is_signed, true) == -ldexp(1, 8 * n - 1));
        assert_true(nqm_load_number(low, is_unsigned, true) == ldexp(1, 8 * n - 1));
    }
    enum { N = 1000 }; /* more than one piece of the conversion */
    uint64_t values[N];
    unsigned char written[8 * N + 1]; /* and the NUL of fmemopen() */
    for (size_t i = 0; i < N; ++i)
        values[i] = 0x8000000000000000u + i;
    FILE *stream = fmemopen(written, sizeof written, "w");
    assert_non_null(stream);
    setvbuf(stream, NULL, _IONBF, 0);
    nqm_write_values(stream, N, sizeof *values, values);
    fclose(stream);
    for (size_t i = 0; i < N; ++i)
        assert_true(nqm_load_integer(written + 8 * i, 8, false) == values[i]);
}

TEST(test_xoshiro_against_its_authors) {
    /* The first outputs of the authors' xoshiro256starstar.c from state 1, 2, 3, 4, as in rand_xoshiro's tests. */
    nqm_rng rng = {{1, 2, 3, 4}};
    const uint64_t expected[] = {11520u, 0u, 1509978240u, 1215971899390074240u};
    for (int i = 0; i < 4; ++i)
        assert_true(nqm_rng_u64(&rng) == expected[i]);
}

TEST(test_rng_moments) {
    enum { N = 200000 };
    nqm_rng rng = nqm_rng_make(7, 3);
    double mean = 0, square = 0, uniform = 0;
    for (int i = 0; i < N; ++i) {
        double x = nqm_rng_normal(&rng);
        mean += x / N;
        square += x * x / N;
        double u = nqm_rng_uniform(&rng);
        assert_true(u >= 0 && u < 1);
        uniform += u / N;
    }
    assert_true(fabs(mean) < 5 / sqrt(N));
    assert_true(fabs(square - 1) < 5 * sqrt(2.0 / N));
    assert_true(fabs(uniform - 0.5) < 5 * sqrt(1.0 / 12 / N));
    nqm_rng a = nqm_rng_make(7, 3), b = nqm_rng_make(7, 4);
    assert_true(nqm_rng_u64(&a) != nqm_rng_u64(&b));
}

/* n = 3/4 of 2^64: without rejection the lowest third would be drawn half of the time. */
TEST(test_below_has_no_bias) {
    enum { N = 10000 };
    nqm_rng rng = nqm_rng_make(9, 0);
    int n_low = 0;
    for (int i = 0; i < N; ++i)
        n_low += nqm_rng_below(&rng, UINT64_C(3) << 62) < UINT64_C(1) << 62;
    assert_true(fabs(n_low / (double)N - 1 / 3.0) < 5 * sqrt(2.0 / 9 / N));
}

TEST(test_shuffle_is_a_permutation) {
    size_t idx[100], seen[100] = {0}, moved = 0;
    for (size_t i = 0; i < 100; ++i)
        idx[i] = i;
    nqm_rng rng = nqm_rng_make(1, 0);
    nqm_rng_shuffle(&rng, 100, idx);
    for (size_t i = 0; i < 100; ++i) {
        seen[idx[i]]++;
        moved += idx[i] != i;
    }
    for (size_t i = 0; i < 100; ++i)
        assert_int_equal(seen[i], 1);
    assert_true(moved > 80);
}

TEST(test_sha256) {
    nqm_sha256 sha;
    char hex[65];
    assert_true(nqm_sha256_begin(&sha));
    nqm_sha256_add(&sha, "a", 1);
    nqm_sha256_add(&sha, "bc", 2);
    nqm_sha256_end(&sha, hex);
    assert_string_equal(hex, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

static void mark(void *user, size_t i) {
    ((unsigned char *)user)[i]++;
}

TEST(test_parallel_for_visits_each_once) {
    unsigned char seen[1000] = {0};
    nqm_parallel_for(1000, mark, seen);
    for (int i = 0; i < 1000; ++i)
        assert_int_equal(seen[i], 1);
}

static int count_and_stop(void *user, const char *stage, double done, double total) {
    (void)stage;
    (void)done;
    (void)total;
    return ++*(int *)user >= 1;
}

TEST(test_ticker) {
    int calls = 0;
    nqm_ticker ticker = {.fn = count_and_stop, .user = &calls};
    double begin_s = nqm_clock_s();
    assert_true(nqm_tick(&ticker, "work", 1, 10));
    assert_true(ticker.next_s > begin_s);
    ticker.next_s = INFINITY;                       /* so that, on a machine of any speed, */
    assert_false(nqm_tick(&ticker, "work", 2, 10)); /* the callback is not due */
    assert_true(nqm_tick(&ticker, "work", 10, 10)); /* the end is always reported */
    assert_int_equal(calls, 2);
    nqm_ticker silent = {0};
    assert_false(nqm_tick(&silent, "work", 1, 1));
}

TEST(test_keyed_hash_equals_hash) {
    uint64_t key = nqm_hash_key(42);
    for (uint64_t i = 0; i < 9; ++i)
        assert_true(nqm_hash_mix(key + (1001 + i) * NQM_GOLDEN) == nqm_hash_u64(42, 1000 + i));
}

TEST(test_errors) {
    nqm_error err = {0};
    assert_int_equal(nqm_fail(&err, NQM_ERR_FORMAT, 12, "%s: bad", "f"), NQM_ERR_FORMAT);
    assert_string_equal(err.message, "f: bad");
    assert_int_equal(err.byte_offset, 12);
    assert_int_equal(nqm_fail(NULL, NQM_ERR_IO, -1, "x"), NQM_ERR_IO);
    for (int s = NQM_ERR_CANCELLED; s <= NQM_OK; ++s)
        assert_string_not_equal(nqm_status_text((nqm_status)s), "unknown status");
}

TEST_FILE(make_folder, remove_folder)
