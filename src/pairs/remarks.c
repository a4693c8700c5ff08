/* SPDX-License-Identifier: MIT
 *
 * What is said of a score: its verdict, and remarks on its values.
 */
#include "pairs/pairs.h"

#include <math.h>
#include <stdarg.h>

/* ---- verdicts ---------------------------------------------------------------------------------------------------- */

const char *nqm_verdict_words(double jod) {
    if (jod >= 9.5)
        return "practically the same";
    if (jod >= 9)
        return "hardly visible";
    if (jod >= 8)
        return "visible";
    return jod >= 6 ? "clearly visible" : "very different";
}

const char *nqm_verdict(const nqm_score_result *result, char *text) {
    assert(result && text);
    if (result->status != NQM_OK)
        return "";
    if (result->identical)
        return "identical";
    if (isnan(result->jod_low))
        return nqm_verdict_words(result->jod);
    const char *best = nqm_verdict_words(result->jod_high), *worst = nqm_verdict_words(result->jod_low);
    if (best == worst)
        return best;
    snprintf(text, NQM_VERDICT_TEXT, "between %s and %s", best, worst);
    return text;
}

double nqm_verdict_preference(const nqm_score_result *result) {
    return result->identical ? 0.5 : nqm_jod_preference(fmax(10, result->jod), result->jod);
}

/* ---- remarks ----------------------------------------------------------------------------------------------------- */

bool nqm_pairs_describe_distance(const char *argument, const double distance_deg[2], size_t n, char *text) {
    if (!(distance_deg[0] > 0.1))
        return false;
    snprintf(text, n,
             "%s: its nearest row is %.2g degrees (median; 95 %%: %.2g) away from a direction of the model: narrower "
             "highlights are not seen; `nqm directions show MODEL --pairs` writes directions to measure",
             argument, distance_deg[0], distance_deg[1]);
    return true;
}

bool nqm_pairs_describe_ignored(const char *argument, size_t n, char *text) {
    char words[NQM_IGNORE_SIZE];
    const unsigned ignored = nqm_argument_ignored(argument);
    snprintf(text, n, "only what reflects is taken: %s ignored", nqm_ignore_words(ignored, words));
    return ignored;
}

/* Remarks that are being written. */
typedef struct remarks {
    size_t n_directions;
    nqm_invalid_policy invalid;
    const nqm_score_result *result;
    char *at;
} remarks;

enum { REMARK = 600 }; /* bytes of one; at most 14 are made */

__attribute__((format(printf, 2, 3))) static void add_remark(remarks *to, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(to->at, REMARK, format, args);
    va_end(args);
    to->at += strlen(to->at) + 1;
}

/* The numbers of directions at which one BRDF (k: 0 reference, 1 test) gives cause for a remark. */
static void add_counts(remarks *to, const char *who, size_t k) {
    static const char *const remedy[] = {"left out", "taken as 0", "taken from the nearest direction", "refused"};
    const nqm_score_result *r = to->result;
    if (r->n_clamped[k])
        add_remark(to, "%s: negative channel at %zu of %zu directions, taken as 0", who, r->n_clamped[k],
                   to->n_directions);
    if (r->n_invalid[k])
        add_remark(to, "%s: no value at %zu of %zu directions, %s", who, r->n_invalid[k], to->n_directions,
                   remedy[to->invalid]);
    if (r->n_unusual[k])
        add_remark(to, "%s: at %zu of %zu directions far brighter than most BRDFs of the training", who,
                   r->n_unusual[k], to->n_directions);
}

/* Faults of files that a low score shows. */
static void add_suspicions(remarks *to, const char *test) {
    const nqm_score_result *r = to->result;
    if (r->suspect_scale > 0 && fabs(log(r->suspect_scale)) < 2)
        add_remark(to, "%s: its reference %s pi at nearly all directions: a Lambertian f_r is its albedo / pi", test,
                   r->suspect_scale > 1 ? "times" : "divided by");
    else if (r->suspect_scale > 0)
        add_remark(to,
                   "%s: about %.4g times its reference at most directions: is a scale missing in one of them? It is "
                   "1500, 1304 and 904 in MERL files, 255 in values of 8 bits",
                   test, r->suspect_scale);
    if (r->suspect_cosine != 0)
        add_remark(to, "%s: about its reference %s the cosine of light or viewer: f_r is without a cosine", test,
                   r->suspect_cosine > 0 ? "times" : "divided by");
}

static void add_ignored(remarks *to, const char *who, const char *argument) {
    char ignored[200];
    if (argument && nqm_pairs_describe_ignored(argument, sizeof ignored, ignored))
        add_remark(to, "%s: %s", who, ignored);
}

const char *nqm_pairs_remarks(const nqm_model *model, nqm_invalid_policy invalid, const nqm_named_pair *pair,
                              const char *ref, const char *test, const nqm_score_result *r, char *text) {
    assert(model && test && r && text);
    const nqm_named_pair none = {NULL, NULL}, *arguments = pair ? pair : &none;
    remarks to = {nqm_directions_get_info(nqm_model_get_info(model).directions).n, invalid, r, text};
    char distance[400];
    if (ref && nqm_pairs_describe_distance(ref, r->distance_deg, sizeof distance, distance))
        add_remark(&to, "%s", distance);
    if (ref && *r->remark[0])
        add_remark(&to, "%s: %s", ref, r->remark[0]);
    if (*r->remark[1])
        add_remark(&to, "%s: %s", test, r->remark[1]);
    if (r->status == NQM_OK) {
        if (ref)
            add_ignored(&to, ref, arguments->ref);
        add_ignored(&to, test, arguments->test);
        if (ref)
            add_counts(&to, ref, 0);
        add_counts(&to, test, 1);
        if (r->novelty > 1 && r->jod_high - r->jod_low > 0.1) /* false for NaN */
            add_remark(&to,
                       "%s: unlike the training pairs: novelty %.2f, where 95 %% of pairs of new materials are below 1",
                       test, r->novelty);
        add_suspicions(&to, test);
    }
    *to.at = '\0';
    return text;
}
