/* SPDX-License-Identifier: MIT
 *
 * tables.h - all kernel tables that tests compare.
 */
#ifndef NQM_TESTS_TABLES_H
#define NQM_TESTS_TABLES_H

#include "kernel/kernel.h"

/** The products by tile registers over an emulation of these, and the other kernels of the best table. Slow. Any thread. */
const nqm_kernels *emulated_kernels(void);
/** nqm_kernels_at(), with emulated_kernels() before the last. */
const nqm_kernels *every_table(size_t i);

#endif
