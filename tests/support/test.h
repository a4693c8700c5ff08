/* SPDX-License-Identifier: MIT
 *
 * test.h - tests register themselves: one program a room runs those of all its files (support/main.c). Includes cmocka and the
 * headers that it needs, and those of the standard library that most tests need.
 */
#ifndef NQM_TESTS_TEST_H
#define NQM_TESTS_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/** A test: TEST(rows_are_added) { ... }. The tests of a file run in the order of the file. */
#define TEST(name) TEST_WITH(name, NULL, NULL)

/** A test with cmocka's fixture functions, which run before and after it. */
#define TEST_WITH(name, setup, teardown)                                                                               \
    static void name(void **state);                                                                                    \
    __attribute__((constructor)) static void register_##name(void) {                                                   \
        register_test(__FILE__, (struct CMUnitTest){#name, name, setup, teardown, NULL});                              \
    }                                                                                                                  \
    static void name(__attribute__((unused)) void **state)

/** The fixture functions (or NULL) that run before the first and after the last test of this file. */
#define TEST_FILE(setup, teardown)                                                                                     \
    __attribute__((constructor)) static void register_file(void) {                                                     \
        register_fixtures(__FILE__, setup, teardown);                                                                  \
    }

/** The tests of this file are skipped unless `has_needs()`: a file of data, or a library. */
#define TEST_FILE_NEEDS(has_needs)                                                                                     \
    __attribute__((constructor)) static void register_needs(void) {                                                    \
        register_need(__FILE__, has_needs);                                                                            \
    }

void register_test(const char *file, struct CMUnitTest test);
void register_fixtures(const char *file, CMFixtureFunction setup, CMFixtureFunction teardown);
void register_need(const char *file, bool (*has_needs)(void));

#endif
