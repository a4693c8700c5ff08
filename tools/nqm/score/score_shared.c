/* SPDX-License-Identifier: MIT
 *
 * Shared by the commands that score: remarks on the values of a pair, parsing of --metrics, and the model in JSON.
 */
#include "nqm/score/score.h"

#include <stdarg.h>
#include <string.h>

/* ---- remarks ----------------------------------------------------------------------------------------------------- */

__attribute__((format(printf, 2, 3))) static void add_remark(json_t *remarks, const char *format, ...) {
    char text[600];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    json_array_append_new(remarks, json_string(text));
}

/* Numbers of directions at which one BRDF gives cause for a remark. */
typedef struct causes {
    const char *who;
    size_t n_clamped, n_invalid, n_unusual;
} causes;

static void remark(const remark_terms *terms, const causes *c, json_t *remarks) {
    static const char *const remedy[] = {"left out", "taken as 0", "taken from the nearest direction", "refused"};
    if (c->n_clamped)
        add_remark(remarks, "%s: negative channel at %zu of %zu directions, taken as 0", c->who, c->n_clamped,
                   terms->n_directions);
    if (c->n_invalid)
        add_remark(remarks, "%s: no value at %zu of %zu directions, %s", c->who, c->n_invalid, terms->n_directions,
                   remedy[terms->invalid]);
    if (c->n_unusual)
        add_remark(remarks, "%s: far brighter at %zu of %zu directions than what the model was trained on", c->who,
                   c->n_unusual, terms->n_directions);
}

void remark_on_reference(const remark_terms *terms, const char *who, const nqm_score_result *r, json_t *remarks) {
    remark(terms, &(causes){who, r->n_clamped_ref, r->n_invalid_ref, r->n_unusual_ref}, remarks);
}

void remark_on_test(const remark_terms *terms, const char *who, const nqm_score_result *r, json_t *remarks) {
    remark(terms, &(causes){who, r->n_clamped_test, r->n_invalid_test, r->n_unusual_test}, remarks);
    if (r->novelty > 1 && !r->identical) /* false for NaN */
        add_remark(remarks,
                   "%s: unlike the training pairs: novelty %.2f, where 95 %% of pairs of new materials "
                   "are below 1",
                   who, r->novelty);
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

static int report_metric_names(const char *verb, const char *given) {
    char names[256] = "";
    for (int m = 0; m < NQM_METRIC_COUNT; ++m) {
        size_t n = strlen(names);
        snprintf(names + n, sizeof names - n, ", %s", nqm_metric_name((nqm_metric)m));
    }
    return report(verb, EXIT_USAGE, "--metrics is a list with commas of all%s; not '%s'", names, given);
}

int choose_metrics(const char *verb, const char *text, bool *chosen) {
    bool all = strcmp(text, "all") == 0;
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        chosen[m] = all;
    for (const char *word = all ? "" : text; *word;) {
        size_t n = strcspn(word, ",");
        int m = 0;
        while (m < NQM_METRIC_COUNT &&
               (strlen(nqm_metric_name((nqm_metric)m)) != n || memcmp(nqm_metric_name((nqm_metric)m), word, n) != 0))
            ++m;
        if (m == NQM_METRIC_COUNT)
            return report_metric_names(verb, text);
        chosen[m] = true;
        word += n + (word[n] == ',');
    }
    return EXIT_OK;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

json_t *model_json(const nqm_model *model, nqm_precision precision) {
    nqm_model_info info = nqm_model_get_info(model);
    json_t *json =
        json_pack("{s:s,s:s,s:I}", "id", info.id, "sha256", info.sha256, "parameters", (json_int_t)info.n_parameters);
    if (precision != NQM_PRECISION_F32)
        json_object_set_new(json, "precision", json_string(nqm_precision_name(precision)));
    return json;
}
