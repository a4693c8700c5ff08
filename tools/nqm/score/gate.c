/* SPDX-License-Identifier: MIT
 *
 * Gates of scores (gate.h).
 */
#include "nqm/score/gate.h"

bool has_gate(const score_gate *gate) {
    return gate->jod > 0 || gate->jod_low > 0;
}

void check_gate(const score_gate *gate, const nqm_model *model) {
    const nqm_model_info info = nqm_model_get_info(model);
    if (gate->jod_low > 0 && !*info.calibration)
        stop(EXIT_INCOMPATIBLE, "--fail-under-low: the model '%s' has no intervals; use --fail-under, or another model",
             info.id);
}

bool fails_gate(const score_gate *gate, const nqm_score_result *result) {
    return result->status == NQM_OK && !result->identical &&
           (result->jod < gate->jod || result->jod_low < gate->jod_low); /* false for NaN */
}

const char *gate_mark(const score_gate *gate, const nqm_score_result *result) {
    return result->status != NQM_OK ? "" : fails_gate(gate, result) ? "FAIL" : "pass";
}

const char *gate_words(const score_gate *gate, char text[GATE_TEXT]) {
    int n = 0;
    *text = '\0';
    if (gate->jod > 0)
        n = snprintf(text, GATE_TEXT, "JOD below %g", gate->jod);
    if (gate->jod_low > 0)
        snprintf(text + n, GATE_TEXT - (size_t)n, "%slower end of the interval below %g", n ? " or " : "",
                 gate->jod_low);
    return text;
}

void report_gate(const score_gate *gate, size_t n_failed, size_t n_pairs) {
    char text[GATE_TEXT];
    report(EXIT_GATE, "%zu of %zu pairs FAIL: %s", n_failed, n_pairs, gate_words(gate, text));
}
