/* SPDX-License-Identifier: MIT
 *
 * gate.h - the lowest scores that `nqm score` and `nqm batch` accept: --fail-under and --fail-under-low.
 */
#ifndef NQM_TOOL_GATE_H
#define NQM_TOOL_GATE_H

#include "nqm/tool.h"

/** The lowest JOD, and the lowest lower end of its 95 % interval, that pass; 0: any. */
typedef struct score_gate {
    double jod, jod_low;
} score_gate;

/** The rows of its options. */
#define OPTION_ROWS_GATE(gate)                                                                                         \
    {"fail-under", 0, OPTION_NUMBER, &(gate)->jod, "JOD", "exit with 1 when a score is below this", 0, 10}, {          \
        "fail-under-low", 0, OPTION_NUMBER, &(gate)->jod_low, "JOD",                                                   \
            "exit with 1 when the lower end of a 95 % interval is below this", 0, 10                                   \
    }

bool has_gate(const score_gate *gate);
/** Report an error and exit when the gate needs intervals and the model has none. */
void check_gate(const score_gate *gate, const nqm_model *model);
/** Whether a pair fails. A pair without a score does not: it is an error of its own. Identical BRDFs pass every gate. */
bool fails_gate(const score_gate *gate, const nqm_score_result *result);
/** "FAIL", "pass", or "" without a score. */
const char *gate_mark(const score_gate *gate, const nqm_score_result *result);

enum { GATE_TEXT = 96 };
/** What fails: "JOD below 9", "lower end of the interval below 8.5", or both. Returns text. */
const char *gate_words(const score_gate *gate, char text[GATE_TEXT]);
/** Print "nqm VERB: 2 of 7 pairs FAIL: JOD below 9" on standard error. */
void report_gate(const score_gate *gate, size_t n_failed, size_t n_pairs);

#endif
