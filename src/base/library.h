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
 *     static nqm_some some;
 *     static nqm_library library = NQM_LIBRARY("libsome.so.1", names, some);
 */
#ifndef NQM_SRC_BASE_LIBRARY_H
#define NQM_SRC_BASE_LIBRARY_H

#include "base/base.h"

/* NOLINTNEXTLINE(bugprone-macro-parentheses): the name of a member */
#define NQM_LIBRARY_MEMBER(name) __typeof__(name) *name;
#define NQM_LIBRARY_NAME(name)   #name,

/** A library; of static storage. */
typedef struct nqm_library {
    const char *soname;
    size_t n;
    const char *const *names; /**< (n) */
    void *functions;          /**< struct of n function pointers and nothing else */
    bool tried, loaded;
} nqm_library;

#define NQM_LIBRARY(SONAME, NAMES, FUNCTIONS)                                                                          \
    { .soname = (SONAME), .n = sizeof(NAMES) / sizeof *(NAMES), .names = (NAMES), .functions = &(FUNCTIONS) }

/** Load it for good, at the first call, and look up its functions. false when it is not installed or lacks one of them.
 *  Any thread. */
bool nqm_library_get(nqm_library *library);

#endif
