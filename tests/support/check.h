/* SPDX-License-Identifier: MIT
 *
 * check.h - shared by the unit tests: comparison of doubles (cmocka compares only floats), values of CSV files, BRDFs
 * that must open, the kernels in use, and paths of the stored vectors and the shared data. Includes cmocka and the
 * headers that it needs.
 */
#ifndef NQM_TESTS_CHECK_H
#define NQM_TESTS_CHECK_H

#include "io/io.h"
#include "support/test.h"
#include <nqm/brdf.h>

/** |actual - expected| <= tolerance; fails for NaN. */
#define assert_near(actual, expected, tolerance)                                                                       \
    check_near((actual), (expected), (tolerance), #actual, __FILE__, __LINE__)
/** |actual - expected| <= tolerance |expected|; fails for NaN. */
#define assert_relative(actual, expected, tolerance)                                                                   \
    check_relative((actual), (expected), (tolerance), #actual, __FILE__, __LINE__)

void check_near(double actual, double expected, double tolerance, const char *what, const char *file, int line);
void check_relative(double actual, double expected, double tolerance, const char *what, const char *file, int line);

/** n normal numbers; nqm_free() them. */
float *random_block(nqm_rng *rng, size_t n);

/** The value of a field as a double; fails if the field is not a number. */
double csv_number(const nqm_csv *csv, size_t row, int column);

/** Use the kernels that the environment variable NQM_KERNELS names, or the best: what every unit test begins with. */
void use_chosen_kernels(void);

/** Open a BRDF; on failure the test fails with the library's message. */
nqm_brdf *must_open(const char *argument);
/** Opening a BRDF fails with this status, whoever asks for the error. The message has the words, the path if the argument is one
 *  (but for NQM_ERR_IO, which may be about another file), and for
 *  NQM_ERR_FORMAT the byte, if there is one. */
nqm_error must_refuse(const char *argument, nqm_status status, const char *words);
/** Compare with values before negative ones become 0, within tolerance (1 + |value|), and the flags; returns how many
 *  are clamped. */
size_t check_brdf_values(const nqm_brdf *brdf, size_t n, const double (*pair)[6], const double (*value)[3],
                         double tolerance);
/** The `free` function of BRDF classes that own no memory. */
void free_nothing(void *self);

/** The path of a file in the shared data ($NQM_DATA, or ../shared/data relative to the source), or NULL if it is
 * absent. Valid until the next call. */
const char *shared_data(const char *relative_path);

/** The path of a file of tests/vectors. Valid until the next call. */
const char *test_vector(const char *name);

#endif
