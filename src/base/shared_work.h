/* SPDX-License-Identifier: MIT
 *
 * shared_work.h - items of work that several processes with one folder share: each result is a file, and whoever holds the
 * claim on the file makes it. Processes need no other connection; one that is killed loses the items that it was making, and the
 * others make them.
 */
#ifndef NQM_BASE_SHARED_WORK_H
#define NQM_BASE_SHARED_WORK_H

#include "base/base.h"

/** Claim the making of a file at `path` among all processes that share the folder: PATH.claim is locked until it is released or
 *  the process ends. *claim_ret: for nqm_claim_release(), or -1 if another process holds the claim. */
NQM_MUST_CHECK nqm_status nqm_claim(const char *path, int *claim_ret, nqm_error *err);
void nqm_claim_release(const char *path, int claim);

/** Items 0 to n - 1 of one process. All callbacks may be called from any thread, each item from one at a time. */
typedef struct nqm_shared_work {
    size_t n;
    const size_t *order; /**< (n) which items are started first; NULL: from item `first`, cyclically */
    size_t first;        /**< < n; differs between processes, so that they seldom want the same item */
    bool one_at_a_time;  /**< items are made by the calling thread only; false: one item per thread */
    void *user;
    /** The file of an item's result; NULL: it has none, and this process makes it. */
    const char *(*path)(void *user, size_t item);
    /** Load the result if it is there. */
    bool (*load)(void *user, size_t item);
    /** Make the result and save it. */
    nqm_status (*make)(void *user, size_t item, nqm_error *err);
    /** Whether to stop; called before each item, and several times per second while other processes are waited for. */
    bool (*is_stopped)(void *user);
} nqm_shared_work;

/** Load or make all items; waits for those that other processes make. Returns NQM_ERR_CANCELLED if it was stopped, or the first
 *  failure of make(), after which nothing more is started. */
NQM_MUST_CHECK nqm_status nqm_shared_work_run(const nqm_shared_work *work, nqm_error *err);

#endif
