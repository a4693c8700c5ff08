/* SPDX-License-Identifier: MIT
 *
 * loops_of_width.h - compiles sample/loops.c for the width of vectors that the including file has chosen by a pragma,
 * with names that end in WIDTH, and makes the table of its functions.
 */
#define PASTE(name, width)  name##_##width
#define EXPAND(name, width) PASTE(name, width)
#define OF_WIDTH(name)      EXPAND(name, WIDTH)

#define nqm_sample_logs             OF_WIDTH(nqm_sample_logs)
#define nqm_sample_scale            OF_WIDTH(nqm_sample_scale)
#define nqm_sample_log_ratios       OF_WIDTH(nqm_sample_log_ratios)
#define nqm_sample_root_differences OF_WIDTH(nqm_sample_root_differences)
#define nqm_sample_limit            OF_WIDTH(nqm_sample_limit)
#define nqm_sample_differences      OF_WIDTH(nqm_sample_differences)
#define nqm_sample_sums             OF_WIDTH(nqm_sample_sums)
#define nqm_sample_whiten           OF_WIDTH(nqm_sample_whiten)
#define nqm_sample_nearest          OF_WIDTH(nqm_sample_nearest)

#include "sample/loops.c"

const sample_loops OF_WIDTH(loops) = {
    .logs = nqm_sample_logs,
    .scale = nqm_sample_scale,
    .log_ratios = nqm_sample_log_ratios,
    .root_differences = nqm_sample_root_differences,
    .limit = nqm_sample_limit,
    .differences = nqm_sample_differences,
    .sums = nqm_sample_sums,
    .whiten = nqm_sample_whiten,
    .nearest = nqm_sample_nearest,
};
