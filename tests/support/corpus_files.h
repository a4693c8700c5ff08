/* SPDX-License-Identifier: MIT
 *
 * corpus_files.h - a temporary folder, removed at the end of the test program, and a small material list, for tests of
 * corpora.
 */
#ifndef NQM_TESTS_SUPPORT_CORPUS_FILES_H
#define NQM_TESTS_SUPPORT_CORPUS_FILES_H

/** Setup and teardown of a group of tests: the folder. */
int make_folder(void **state);
int remove_made_folder(void **state);
/** Remove a folder with its files. */
void remove_folder(const char *path);
/** A path in the folder; valid until the next call but one. */
const char *in_folder(const char *name);
/** Write a file in the folder; its path, as in_folder(). */
const char *write_text(const char *name, const char *text);

/** Two groups for training, one of them with two forms, and one for testing. */
extern const char corpus_materials[];

#endif
