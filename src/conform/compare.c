/* SPDX-License-Identifier: MIT
 *
 * Scores of a shader's values, and of what remains of them with a mistake; and what can be said about sets that fail, whatever the
 * mistake: which keys separate them from those that pass, at which angles their difference is, and where it is largest.
 */
#include "conform/conform.h"

#include "math/math.h"

/* ---- scores ------------------------------------------------------------------------------------------------------ */

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
static nqm_status score(scoring *s, const nqm_conform_kit *kit, const nqm_conform_suspect *suspect,
                        nqm_score_result *results, double *lowest, nqm_error *err) {
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
static bool is_named(const nqm_conform_report *r, const nqm_conform_suspect *s) {
    const nqm_conform_mistake *m = &r->mistakes[0];
    const double most = s->flaws[0].amount != 0 || s->flaws[1].amount != 0 ? 0.1 : 0.5;
    return r->n_mistakes && ((m->remaining < most && m->lowest_jod > r->lowest_jod - 0.01) ||
                             (r->lowest_jod < NQM_CONFORM_PASS && m->lowest_jod >= NQM_CONFORM_PASS));
}

/* ---- facts: keys ------------------------------------------------------------------------------------------------- */

/* Of the largest value of a key. */
typedef struct condition {
    size_t key;
    enum { ABOVE, BELOW, CHANGED, N_KINDS } kind; /* CHANGED: is not the default */
    double limit;                                 /* of ABOVE and BELOW */
} condition;

static double most_of(const nqm_kit_set *set, size_t key) {
    const double *v = set->values.v[key];
    return fmax(v[0], fmax(v[1], v[2]));
}

/* How many passing sets have all n conditions; SIZE_MAX where a failing one lacks one. */
static size_t count_exceptions(const nqm_conform_kit *kit, const bool *fails, size_t n, const condition *c) {
    size_t n_exceptions = 0;
    for (const nqm_kit_set *set = kit->sets; set < kit->sets + kit->n_sets; ++set) {
        bool has_all = true;
        for (size_t i = 0; i < n; ++i) {
            const double v = most_of(set, c[i].key);
            has_all = has_all && (c[i].kind == ABOVE     ? v > c[i].limit
                                  : c[i].kind == CHANGED ? set->values.given >> c[i].key & 1
                                                         : v < c[i].limit);
        }
        if (fails[set - kit->sets] && !has_all)
            return SIZE_MAX;
        n_exceptions += !fails[set - kit->sets] && has_all;
    }
    return n_exceptions;
}

/* log2 of the number of ways to choose k of n. */
static double choices(size_t n, size_t k) {
    return (lgamma((double)n + 1) - lgamma((double)k + 1) - lgamma((double)(n - k) + 1)) / log(2);
}

/* One or two conditions that all failing sets have and few others. They are told if that is no coincidence: to name them, and the
 * failing ones of the sets that have them, takes fewer bits than to name the failing ones of all, and eight to spare. */
static void separate_sets(const nqm_conform_kit *kit, const bool *fails, size_t n_fails, char *text) {
    const size_t n_keys = kit->schema->n_keys;
    double least = choices(kit->n_sets, n_fails) - 8;
    condition c[2] = {{0}};
    size_t n_found = 0, n_exceptions = SIZE_MAX;
    for (size_t n = 0; n < 2; ++n) {
        condition best = {0};
        size_t fewest = SIZE_MAX;
        for (size_t i = 0; i < n_keys * kit->n_sets * N_KINDS; ++i) {
            const size_t key = i / kit->n_sets / N_KINDS;
            c[n] = (condition){key, i / kit->n_sets % N_KINDS, most_of(&kit->sets[i % kit->n_sets], key)};
            const size_t exceptions = count_exceptions(kit, fails, n + 1, c);
            best = exceptions < fewest ? c[n] : best;
            fewest = nqm_smaller(fewest, exceptions);
        }
        c[n] = best;
        const double bits = (double)(n + 1) * log2((double)(N_KINDS * n_keys)) + choices(n_fails + fewest, n_fails);
        if (fewest <= (kit->n_sets - n_fails) / 2 && bits < least) {
            n_found = n + 1;
            n_exceptions = fewest;
            least = bits;
        }
    }
    char words[2][128] = {"", ""};
    for (size_t i = 0; i < n_found; ++i) {
        const nqm_schema_key *key = &kit->schema->keys[c[i].key];
        const char *which = key->n == 1 ? "" : c[i].kind == ABOVE ? "a value of " : "all values of ";
        if (c[i].kind == CHANGED)
            snprintf(words[i], sizeof *words, "%s other than %g", key->name, key->fallback);
        else
            snprintf(words[i], sizeof *words, "%s%s %c %g", which, key->name, c[i].kind == ABOVE ? '>' : '<',
                     c[i].limit);
    }
    if (n_found)
        snprintf(text, NQM_CONFORM_TEXT, "All %zu sets that fail have %s%s%s; so have %zu of the %zu that pass.",
                 n_fails, words[0], n_found > 1 ? " and " : "", words[1], n_exceptions, kit->n_sets - n_fails);
}

/* ---- facts: directions ------------------------------------------------------------------------------------------- */

enum { N_ANGLES = 4 };
static const char *const angle_names[N_ANGLES] = {"theta_h", "theta_d", "theta_light", "theta_viewer"};

static void find_angles(const nqm_conform_kit *kit, size_t direction, double angles_rad[N_ANGLES]) {
    const double *wi = nqm_conform_directions(kit, 0, 0) + 3 * direction,
                 *wo = nqm_conform_directions(kit, 0, 1) + 3 * direction;
    nqm_directions_to_half_diff(wi, wo, angles_rad); /* the third is replaced */
    angles_rad[2] = acos(fmin(wi[2], 1));
    angles_rad[3] = acos(fmin(wo[2], 1));
}

/* The side of an angle where most of the difference is, and few directions are; difference: fraction at each. */
static void find_side(const nqm_conform_kit *kit, const double *difference, char *text) {
    enum { STEP_DEG = 5, N_SIDES = 2 * 90 / STEP_DEG }; /* below and above each step */
    double of[N_ANGLES * N_SIDES][2] = {{0}};           /* fractions of difference and directions */
    double best[2] = {0.4, 0}, angles[N_ANGLES];
    size_t found = 0;
    for (size_t i = 0; i < kit->n_directions; ++i) {
        find_angles(kit, i, angles);
        for (size_t k = 0; k < N_ANGLES * N_SIDES; ++k)
            if ((angles[k / N_SIDES] * 180 / NQM_PI > (double)(k % N_SIDES / 2 * STEP_DEG)) == k % 2) {
                of[k][0] += difference[i];
                of[k][1] += 1 / (double)kit->n_directions;
            }
    }
    for (size_t k = 0; k < N_ANGLES * N_SIDES; ++k)
        if (of[k][0] - of[k][1] > best[0] - best[1]) {
            memcpy(best, of[k], sizeof best);
            found = k;
        }
    if (found)
        snprintf(text, NQM_CONFORM_TEXT,
                 "%.0f %% of their difference is where %s %c %zu degrees: %.0f %% of the directions.", 100 * best[0],
                 angle_names[found / N_SIDES], found % 2 ? '>' : '<', found % N_SIDES / 2 * STEP_DEG, 100 * best[1]);
}

/* The largest difference; at: index of the value. */
static void describe_largest(const nqm_conform_kit *kit, size_t at, double value, double right,
                             nqm_conform_report *report) {
    static const char *const names[] = {"red", "green", "blue"};
    const size_t row = at / 3;
    nqm_conform_largest *l = &report->largest;
    *l = (nqm_conform_largest){row / kit->n_directions, row % kit->n_directions, at % 3, value, right, {0}};
    find_angles(kit, l->direction, l->angles_rad);
    const double deg = 180 / NQM_PI, *a = l->angles_rad;
    snprintf(report->most, NQM_CONFORM_TEXT,
             "Largest difference: %s of set %zu is %.3g times the right value (%.3g for %.3g) at theta_h %.0f, "
             "theta_d %.0f, theta_light %.0f, theta_viewer %.0f degrees, row %zu of the kit.",
             names[l->channel], l->set + 1, value / right, value, right, a[0] * deg, a[1] * deg, a[2] * deg, a[3] * deg,
             row + 1);
}

/* Fill the facts about the sets that fail (n_sets) of a report. */
static nqm_status find_facts(const nqm_conform_kit *kit, const float *values, const bool *fails,
                             nqm_conform_report *report, nqm_error *err) {
    const nqm_conform_suspect none = {.n_flaws = 0};
    const size_t n = kit->n_directions;
    double *difference, sum = 0, most = 0;
    float *ref;
    size_t at = 0;
    const nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&difference, n, sizeof *difference}, {&ref, 3 * n, sizeof *ref}), err);
    if (status != NQM_OK)
        return status;
    for (size_t set = 0; set < kit->n_sets; ++set) {
        nqm_conform_sample(kit, set, &none, 1, false, ref);
        for (size_t i = 0; i < 3 * n && fails[set]; ++i) {
            const double r = (double)ref[i], v = fmax(0, (double)values[3 * n * set + i]);
            const bool counts = nqm_conform_is_value(values + 3 * n * set + i / 3 * 3);
            const double d = counts ? fabs(log((v + 0.003) / (r + 0.003))) : 0;
            difference[i / 3] += d;
            sum += d;
            at = d > most ? 3 * n * set + i : at;
            most = fmax(most, d);
        }
    }
    nqm_conform_sample(kit, at / n / 3, &none, 1, false, ref);
    for (size_t i = 0; i < n; ++i)
        difference[i] /= sum;
    separate_sets(kit, fails, kit->n_sets - report->n_passed, report->sets);
    if (sum > 0) {
        find_side(kit, difference, report->angles);
        describe_largest(kit, at, fmax(0, (double)values[at]), (double)ref[at % (3 * n)], report);
    }
    nqm_free(difference);
    return NQM_OK;
}

/* ---- the report -------------------------------------------------------------------------------------------------- */

nqm_status nqm_conform_compare(const nqm_conform_kit *kit, const float *values, nqm_progress_fn progress, void *user,
                               nqm_score_result *results, nqm_conform_report *report, nqm_error *err) {
    NQM_REQUIRE(err, kit, values, results, report);
    nqm_conform_suspect found[NQM_CONFORM_MISTAKES] = {{0}};
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
        status = find_facts(kit, values, fails, r, err);
    }
    nqm_scorer_free(s.scorer);
    nqm_free(s.ref);
    return status;
}
