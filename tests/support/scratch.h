/* SPDX-License-Identifier: MIT
 *
 * scratch.h - files in a temporary folder of this process, which is removed at exit.
 */
#ifndef NQM_TESTS_SCRATCH_H
#define NQM_TESTS_SCRATCH_H

/** The path of a file with this name, which may not exist. Valid until exit. */
const char *scratch_path(const char *name);
/** Write a file with this text; its path. */
const char *scratch_text(const char *name, const char *text);

/** Remove a folder and what is in it. */
void remove_folder(const char *path);

#endif
