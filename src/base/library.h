/* SPDX-License-Identifier: MIT
 *
 * library.h - shared libraries that are loaded when they are needed: linked in, they would delay the start of all the
 * programs that never need them (doc/performance.md, "Start-up"). A module lists the functions of a library that it uses
 * in a macro SOME_FUNCTIONS(X), an X(name) for each; their pointers and their names are then
 *
 *     typedef struct nqm_some {
 *         SOME_FUNCTIONS(NQM_LIBRARY_MEMBER)
 *     } nqm_some;
 *     static const char *const names[] = {SOME_FUNCTIONS(NQM_LIBRARY_NAME)};
 */
#ifndef NQM_SRC_BASE_LIBRARY_H
#define NQM_SRC_BASE_LIBRARY_H

#include "base/base.h"

/* NOLINTNEXTLINE(bugprone-macro-parentheses): the name of a member */
#define NQM_LIBRARY_MEMBER(name) __typeof__(name) *name;
#define NQM_LIBRARY_NAME(name)   #name,

/** Load the library `soname` for good and look up n functions.
 *
 * @param functions  n pointers to functions, one behind the other: a struct of nothing else
 * @return false when the library is not installed or lacks one of them
 */
bool nqm_library_load(const char *soname, size_t n, const char *const *names, void *functions);

#endif
