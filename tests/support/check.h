/* SPDX-License-Identifier: MIT
 *
 * check.h - what the unit tests share: comparison of doubles (cmocka compares floats only), numbers of CSV files, BRDFs
 * that must open, and the way to the stored vectors and the shared data. Includes cmocka with what it needs.
 */
#ifndef NQM_TESTS_CHECK_H
#define NQM_TESTS_CHECK_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "io/io.h"
#include <cmocka.h>
#include <nqm/brdf.h>

/** |actual - expected| <= tolerance; fails for NaN. */
#define assert_near(actual, expected, tolerance)                                                                       \
    check_near((actual), (expected), (tolerance), #actual, __FILE__, __LINE__)
/** |actual - expected| <= tolerance |expected|; fails for NaN. */
#define assert_relative(actual, expected, tolerance)                                                                   \
    check_relative((actual), (expected), (tolerance), #actual, __FILE__, __LINE__)

void check_near(double actual, double expected, double tolerance, const char *what, const char *file, int line);
void check_relative(double actual, double expected, double tolerance, const char *what, const char *file, int line);

/** For qsort(). */
int compare_doubles(const void *a, const void *b);

/** The number in a field; fails where there is none. */
double csv_number(const nqm_csv *csv, size_t row, int column);

/** Open a BRDF; fails with the library's message. */
nqm_brdf *open_brdf(const char *argument);
/** For classes of BRDFs that own nothing. */
void free_nothing(void *self);

/** The path of a file in the shared data ($NQM_DATA, else ../shared/data beside the source), or NULL when it is absent.
 * Lent until the next call. */
const char *shared_data(const char *relative_path);

/** The path of a file of tests/vectors. Lent until the next call. */
const char *test_vector(const char *name);

#endif
