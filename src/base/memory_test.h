/* SPDX-License-Identifier: MIT
 *
 * memory_test.h - for tests only: make an allocation fail; count the allocations; run code while a lock is taken.
 */
#ifndef NQM_SRC_BASE_MEMORY_TEST_H
#define NQM_SRC_BASE_MEMORY_TEST_H

/** Let the next n allocations proceed and the one after them fail, once; n < 0: no allocation is made to fail. */
void nqm_alloc_fail_after(long n);
/** Number of allocations so far, failed ones included. */
long nqm_alloc_count(void);

/** Call `hook` once, when nqm_claim() has opened the file of a claim and not yet locked it. NULL: nothing. */
void nqm_lock_hook(void (*hook)(void));

#endif
