/* SPDX-License-Identifier: MIT
 *
 * dynamic.h - loads shared libraries at their first use. Linking them would slow the start of every program, including
 * those that never use them (doc/performance.md, "Loading and start"). A module lists the functions that it uses in a
 * macro SOME_FUNCTIONS(X) with one X(name) per function, and defines
 *
 *     typedef struct nqm_some {
 *         SOME_FUNCTIONS(NQM_DYNAMIC_MEMBER)
 *     } nqm_some;
 *     static const char *const names[] = {SOME_FUNCTIONS(NQM_DYNAMIC_NAME)};
 *     static nqm_some some;
 *     static nqm_dynamic library = NQM_DYNAMIC("libsome.so.1", names, some);
 */
#ifndef NQM_SRC_BASE_DYNAMIC_H
#define NQM_SRC_BASE_DYNAMIC_H

#include "base/base.h"

/* NOLINTNEXTLINE(bugprone-macro-parentheses): a member name takes no parentheses */
#define NQM_DYNAMIC_MEMBER(name) __typeof__(name) *name;
#define NQM_DYNAMIC_NAME(name)   #name,

/** A library; the object must have static storage. */
typedef struct nqm_dynamic {
    const char *soname;
    size_t n;
    const char *const *names; /**< (n) */
    void *functions;          /**< a struct of exactly n function pointers */
    bool tried, loaded;
} nqm_dynamic;

#define NQM_DYNAMIC(SONAME, NAMES, FUNCTIONS)                                                                          \
    { .soname = (SONAME), .n = sizeof(NAMES) / sizeof *(NAMES), .names = (NAMES), .functions = &(FUNCTIONS) }

/** The first call loads the library and looks up its functions; it is never unloaded. false when the library is not
 *  installed or lacks a function. Any thread. */
bool nqm_dynamic_get(nqm_dynamic *library);

#endif
