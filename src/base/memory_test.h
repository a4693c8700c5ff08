/* SPDX-License-Identifier: MIT
 *
 * memory_test.h - for tests only: make an allocation fail; count them.
 */
#ifndef NQM_SRC_BASE_MEMORY_TEST_H
#define NQM_SRC_BASE_MEMORY_TEST_H

/** The allocation after the next n of nqm_alloc() fails once; n < 0 switches this off. */
void nqm_alloc_fail_after(long n);
/** Number of allocations so far, failed ones included. */
long nqm_alloc_count(void);

#endif
