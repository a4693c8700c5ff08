/* SPDX-License-Identifier: MIT
 *
 * temp_file.h - one empty temporary file for all tests of a group.
 */
#ifndef NQM_TESTS_SUPPORT_TEMP_FILE_H
#define NQM_TESTS_SUPPORT_TEMP_FILE_H

/** The path of the file, which exists between make_temp_file() and remove_temp_file(). */
extern char temp_file[];

/** Group fixtures of cmocka. Removal fails if the file no longer exists. */
int make_temp_file(void **state);
int remove_temp_file(void **state);

#endif
