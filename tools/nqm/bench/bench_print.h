/* SPDX-License-Identifier: MIT
 *
 * bench_print.h - the rows of `nqm bench` as JSON or as tables.
 */
#ifndef NQM_TOOL_BENCH_H
#define NQM_TOOL_BENCH_H

#include "bench/bench.h"
#include "nqm/tool.h"

/** Rows as {"machine", "rows"}: fields that do not apply are omitted. */
json_t *bench_json(const nqm_bench *bench);
/** Print the machine and a table for each benchmark, the peaks first. */
void print_bench_tables(const nqm_bench *bench, const json_t *machine);

#endif
