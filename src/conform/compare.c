/* SPDX-License-Identifier: MIT
 *
 * Scores of a shader's values, and of what remains of them with a mistake.
 */
#include "conform/conform.h"

/* What is scored again for each mistake. */
typedef struct scoring {
    nqm_scorer *scorer;
    float *ref, *test;         /* (n_sets, n_directions, 3); test: 0 where it has no value */
    uint8_t *used;             /* (n_sets, n_directions) */
    nqm_sample_pair *pairs;    /* (n_sets) */
    nqm_score_result *results; /* (n_sets) of mistakes */
} scoring;

/* Take over the values of a shader. */
static nqm_status begin_scoring(scoring *s, const nqm_conform_kit *kit, const float *values, nqm_error *err) {
    const size_t n = kit->n_sets * kit->n_directions;
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    *s = (scoring){.scorer = NULL};
    const nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&s->ref, 3 * n, sizeof *s->ref}, {&s->test, 3 * n, sizeof *s->test}, {&s->used, n, 1},
                   {&s->pairs, kit->n_sets, sizeof *s->pairs}, {&s->results, kit->n_sets, sizeof *s->results}),
        err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        s->used[i] = nqm_conform_is_value(values + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            s->test[3 * i + c] = s->used[i] ? fmaxf(values[3 * i + c], 0) : 0;
    }
    return status == NQM_OK ? nqm_scorer_create(kit->metric, &options, &s->scorer, err) : status;
}

/* Score the values against a suspect, and find the lowest JOD. */
static nqm_status score(scoring *s, const nqm_conform_kit *kit, const nqm_suspect *suspect, nqm_score_result *results,
                        double *lowest, nqm_error *err) {
    for (size_t set = 0, at = 0; set < kit->n_sets; ++set, at += kit->n_directions) {
        s->pairs[set] = (nqm_sample_pair){s->ref + 3 * at, s->test + 3 * at, s->used + at};
        nqm_conform_sample(kit, set, suspect, 1, false, s->ref + 3 * at);
    }
    const nqm_status status = nqm_scorer_run_samples(s->scorer, kit->n_sets, s->pairs, results, err);
    *lowest = 10;
    for (size_t set = 0; status == NQM_OK && set < kit->n_sets; ++set)
        *lowest = fmin(*lowest, results[set].jod); /* without NaN */
    return status;
}

/* Directions without a value and with a negative one. */
static void count_values(const nqm_conform_kit *kit, const float *values, nqm_score_result *results) {
    for (size_t i = 0; i < kit->n_sets * kit->n_directions; ++i) {
        nqm_score_result *r = &results[i / kit->n_directions];
        const float *v = values + 3 * i;
        if (!nqm_conform_is_value(v))
            ++r->n_invalid[1];
        else
            r->n_clamped[1] += v[0] < 0 || v[1] < 0 || v[2] < 0;
    }
}

/* All sets pass with it, or it leaves less than half of the difference (with an amount, which fits more, a tenth), and no worse
 * set than without it. */
static bool is_named(const nqm_conform_report *r, const nqm_suspect *s) {
    const nqm_conform_mistake *m = &r->mistakes[0];
    const double most = s->flaws[0].amount != 0 || s->flaws[1].amount != 0 ? 0.1 : 0.5;
    return r->n_mistakes && ((m->remaining < most && m->lowest_jod > r->lowest_jod - 0.01) ||
                             (r->lowest_jod < NQM_CONFORM_PASS && m->lowest_jod >= NQM_CONFORM_PASS));
}

nqm_status nqm_conform_compare(const nqm_conform_kit *kit, const float *values, nqm_progress_fn progress, void *user,
                               nqm_score_result *results, nqm_conform_report *report, nqm_error *err) {
    NQM_REQUIRE(err, kit, values, results, report);
    nqm_suspect found[NQM_CONFORM_MISTAKES] = {{0}};
    bool fails[NQM_CONFORM_MAX_SETS];
    scoring s;
    nqm_conform_report *r = report;
    *r = (nqm_conform_report){.n_passed = 0};
    nqm_status status = begin_scoring(&s, kit, values, err);
    if (status == NQM_OK)
        status = score(&s, kit, &found[0], results, &r->lowest_jod, err); /* no mistake */
    for (size_t set = 0; status == NQM_OK && set < kit->n_sets; ++set) {
        fails[set] = !(results[set].jod >= NQM_CONFORM_PASS);
        r->n_passed += !fails[set];
    }
    if (status == NQM_OK)
        status = nqm_conform_search(kit, values, &(nqm_ticker){.fn = progress, .user = user}, found, r, err);
    for (size_t i = 0; status == NQM_OK && i < r->n_mistakes; ++i)
        status = score(&s, kit, &found[i], s.results, &r->mistakes[i].lowest_jod, err);
    if (status == NQM_OK) {
        count_values(kit, values, results);
        r->is_named = is_named(r, &found[0]);
        if (r->n_passed == kit->n_sets && !r->is_named) { /* rounding */
            r->n_mistakes = 0;
            r->difference = 0;
        }
        status = nqm_conform_find_facts(kit, values, fails, r, err);
    }
    nqm_scorer_free(s.scorer);
    nqm_free(s.ref);
    return status;
}
