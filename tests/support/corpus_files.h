/* SPDX-License-Identifier: MIT
 *
 * corpus_files.h - a temporary folder, removed at the end of the test program, for tests that write files.
 */
#ifndef NQM_TESTS_SUPPORT_CORPUS_FILES_H
#define NQM_TESTS_SUPPORT_CORPUS_FILES_H

/** Group fixtures of cmocka: create and remove the temporary folder. */
int make_folder(void **state);
int remove_made_folder(void **state);
/** Remove a folder and its files. */
void remove_folder(const char *path);
/** A path in the folder; valid until the second call after this one. */
const char *in_folder(const char *name);
/** Write a file in the folder; returns its path as in_folder() does. */
const char *write_text(const char *name, const char *text);

#endif
