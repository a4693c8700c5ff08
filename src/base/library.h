/* SPDX-License-Identifier: MIT
 *
 * library.h - loads shared libraries at their first use. Linking them would slow the start of every program, including
 * those that never use them (doc/performance.md, "Loading and start"). A module lists the functions that it uses in a
 * macro SOME_FUNCTIONS(X) with one X(name) per function, and defines
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

/* NOLINTNEXTLINE(bugprone-macro-parentheses): a member name takes no parentheses */
#define NQM_LIBRARY_MEMBER(name) __typeof__(name) *name;
#define NQM_LIBRARY_NAME(name)   #name,

/** A library; the object must have static storage. */
typedef struct nqm_library {
    const char *soname;
    size_t n;
    const char *const *names; /**< (n) */
    void *functions;          /**< a struct of exactly n function pointers */
    bool tried, loaded;
} nqm_library;

#define NQM_LIBRARY(SONAME, NAMES, FUNCTIONS)                                                                          \
    { .soname = (SONAME), .n = sizeof(NAMES) / sizeof *(NAMES), .names = (NAMES), .functions = &(FUNCTIONS) }

/** The first call loads the library and looks up its functions; it is never unloaded. false when the library is not
 *  installed or lacks a function. Any thread. */
bool nqm_library_get(nqm_library *library);

#endif
