/* SPDX-License-Identifier: MIT
 *
 * names.h - a growing list of strings, stored in one block, with a linear search; and the nearest of several names.
 */
#ifndef NQM_SRC_BASE_NAMES_H
#define NQM_SRC_BASE_NAMES_H

#include "base/base.h"

/** A list of strings; a zeroed list is empty. */
typedef struct nqm_names {
    size_t n, max_n, n_text, max_text;
    size_t *start; /* (n) offset of each string in `text` */
    char *text;    /* (n_text) NUL-terminated strings */
} nqm_names;

/** The i-th string, i < n; valid until the next string is added. */
static inline const char *nqm_name(const nqm_names *names, size_t i) {
    return names->text + names->start[i];
}
/** Append a string of n_bytes without NUL. */
NQM_MUST_CHECK nqm_status nqm_names_add(nqm_names *names, const char *name, size_t n_bytes, nqm_error *err);
/** Find a string, or append it; *index_ret is its index. The search is linear and starts at the end. */
NQM_MUST_CHECK nqm_status nqm_names_intern(nqm_names *names, const char *name, size_t n_bytes, uint32_t *index_ret,
                                           nqm_error *err);
void nqm_names_free(nqm_names *names);

/** Whether a file name ends in `suffix` (any case) and has something before it. */
bool nqm_name_ends_in(const char *path, const char *suffix);

/** The name among several that is most like a misspelt one. */
typedef struct nqm_nearest {
    const char *wanted;
    size_t distance;  /* distance of the nearest name so far; larger than the limit when there is none */
    char advice[120]; /* " (did you mean 'score'?)", or "" */
} nqm_nearest;
nqm_nearest nqm_nearest_begin(const char *wanted);
/** Offer a name. Names count as near when a third of the letters (at least 1, at most 4) must be inserted, deleted, replaced or
 *  exchanged with the next. Case, '-' and '_' make no difference. */
void nqm_nearest_add(nqm_nearest *nearest, const char *name);

#endif
