/* SPDX-License-Identifier: MIT
 *
 * allocations.h - what must work whichever allocation fails.
 */
#ifndef NQM_TESTS_ALLOCATIONS_H
#define NQM_TESTS_ALLOCATIONS_H

#include "base/memory_test.h"
#include <nqm/base.h>
#include <stdbool.h>

/** Run a block, which sets `status`, with allocation 0, 1, 2 ... failing once, until it succeeds: until then `status` must be
 *  NQM_ERR_NOMEM. n: a long, -1; afterwards the number of rounds that failed, which must not be 0. `skip`: after allocation n comes
 *  n + 1 + n / skip, for calls of very many; 0: each fails. */
#define EVERY_ALLOCATION(n, status, skip) while (next_allocation(&(n), (status), (skip)))
bool next_allocation(long *n, nqm_status status, long skip);

/** The number of allocations of opening a BRDF, each of which fails cleanly. */
long check_brdf_allocations(const char *argument);

#endif
