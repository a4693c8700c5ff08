/* SPDX-License-Identifier: MIT
 *
 * What can be said about sets that fail, whatever the mistake: which keys separate them from those that pass, at which angles their
 * difference is, and where it is largest.
 */
#include "conform/conform.h"

#include "math/math.h"
#include <nqm/brdf.h>

#include <math.h>
#include <string.h>

/* ---- keys -------------------------------------------------------------------------------------------------------- */

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

/* ---- directions -------------------------------------------------------------------------------------------------- */

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

nqm_status nqm_conform_find_facts(const nqm_conform_kit *kit, const float *values, const bool *fails,
                                  nqm_conform_report *report, nqm_error *err) {
    const nqm_suspect none = {.n_flaws = 0};
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
