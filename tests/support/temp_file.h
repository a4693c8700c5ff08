/* SPDX-License-Identifier: MIT
 *
 * temp_file.h - one empty file for all tests of a group, for their fixtures.
 */
#ifndef NQM_TESTS_SUPPORT_TEMP_FILE_H
#define NQM_TESTS_SUPPORT_TEMP_FILE_H

/** The path of the file; it is there between make_temp_file() and remove_temp_file(). */
extern char temp_file[];

/** Group fixtures of cmocka. Removing fails when the file is gone. */
int make_temp_file(void **state);
int remove_temp_file(void **state);

#endif
