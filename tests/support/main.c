/* SPDX-License-Identifier: MIT
 *
 * main() of the unit tests of a room: `test_io` runs all of them, `test_io test_io_csv` those of one file,
 * `test_io test_io_csv quotes` one test. Exits with 77 when every file lacked what it needs.
 */
#include "support/test.h"

enum { MAX_FILES = 64, MAX_TESTS = 128, NAME_SIZE = 64 };

typedef struct test_file {
    char name[NAME_SIZE]; /* test_io_csv */
    size_t n;
    struct CMUnitTest tests[MAX_TESTS];
    CMFixtureFunction setup, teardown;
    bool (*has_needs)(void);
} test_file;

static test_file files[MAX_FILES];
static size_t n_files;

static test_file *find_file(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const int n_chars = (int)strcspn(name, ".");
    for (size_t i = 0; i < n_files; ++i)
        if (strlen(files[i].name) == (size_t)n_chars && strncmp(files[i].name, name, (size_t)n_chars) == 0)
            return &files[i];
    if (n_files == MAX_FILES || n_chars >= NAME_SIZE) {
        fprintf(stderr, "support/main.c: too many files, or a long name: %s\n", name);
        abort();
    }
    snprintf(files[n_files].name, NAME_SIZE, "%.*s", n_chars, name);
    return &files[n_files++];
}

void register_test(const char *file, struct CMUnitTest test) {
    test_file *f = find_file(file);
    if (f->n == MAX_TESTS) {
        fprintf(stderr, "support/main.c: too many tests in %s\n", file);
        abort();
    }
    f->tests[f->n++] = test;
}

void register_fixtures(const char *file, CMFixtureFunction setup, CMFixtureFunction teardown) {
    test_file *f = find_file(file);
    f->setup = setup;
    f->teardown = teardown;
}

void register_need(const char *file, bool (*has_needs)(void)) {
    find_file(file)->has_needs = has_needs;
}

/* Keep only the test of this name. */
static void select_test(test_file *f, const char *name) {
    for (size_t i = 0; i < f->n; ++i)
        if (strcmp(f->tests[i].name, name) == 0) {
            f->tests[0] = f->tests[i];
            f->n = 1;
            return;
        }
    f->n = 0;
}

int main(int argc, char **argv) {
    size_t n_run = 0, n_skipped = 0;
    int n_failed = 0;
    for (size_t i = 0; i < n_files; ++i) {
        test_file *f = &files[i];
        if (argc > 1 && strcmp(f->name, argv[1]) != 0)
            continue;
        if (argc > 2)
            select_test(f, argv[2]);
        if (!f->n)
            continue;
        ++n_run;
        if (f->has_needs && !f->has_needs()) {
            ++n_skipped;
            printf("%s: skipped: something that it needs is missing\n", f->name);
            continue;
        }
        n_failed += _cmocka_run_group_tests(f->name, f->tests, f->n, f->setup, f->teardown) != 0;
    }
    if (!n_run) {
        fprintf(stderr, "no such test\n");
        return 2;
    }
    return n_failed ? 1 : n_skipped == n_run ? 77 : 0;
}
