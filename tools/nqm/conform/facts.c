/* SPDX-License-Identifier: MIT
 *
 * What can be said about sets that fail, whatever the mistake: which keys separate them from those that pass, at which angles their
 * difference is, and where it is largest.
 */
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* Of the largest value of a key. */
typedef struct condition {
    size_t key;
    enum { ABOVE, BELOW, CHANGED, N_KINDS } kind; /* CHANGED: is not the default */
    double limit;                                 /* of ABOVE and BELOW */
} condition;

static double most_of(const kit_set *set, size_t key) {
    const double *v = set->values.v[key];
    return fmax(v[0], fmax(v[1], v[2]));
}

/* How many passing sets have all n conditions; SIZE_MAX where a failing one lacks one. */
static size_t count_exceptions(const conform_kit *kit, const bool *fails, size_t n, const condition *c) {
    size_t n_exceptions = 0;
    for (const kit_set *set = kit->sets; set < kit->sets + kit->n_sets; ++set) {
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

/* One or two conditions that all failing sets have and few others; NULL: none. They are told if that is no coincidence: to name them,
 * and the failing ones of the sets that have them, takes fewer bits than to name the failing ones of all, and eight to spare. */
static json_t *separate_sets(const conform_kit *kit, const bool *fails, size_t n_fails) {
    const size_t n_keys = kit->model->schema->n_keys;
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
        const nqm_schema_key *key = &kit->model->schema->keys[c[i].key];
        const char *which = key->n == 1 ? "" : c[i].kind == ABOVE ? "a value of " : "all values of ";
        if (c[i].kind == CHANGED)
            snprintf(words[i], sizeof *words, "%s other than %g", key->name, key->fallback);
        else
            snprintf(words[i], sizeof *words, "%s%s %c %g", which, key->name, c[i].kind == ABOVE ? '>' : '<',
                     c[i].limit);
    }
    return !n_found ? NULL
                    : json_pack("{s:o}", "text",
                                json_sprintf("All %zu sets that fail have %s%s%s; so have %zu of the %zu that pass.",
                                             n_fails, words[0], n_found > 1 ? " and " : "", words[1], n_exceptions,
                                             kit->n_sets - n_fails));
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

enum { N_ANGLES = 4 };
static const char *const angle_names[N_ANGLES] = {"theta_h", "theta_d", "theta_light", "theta_viewer"};

static double angle_deg(const conform_kit *kit, size_t direction, size_t angle) {
    const double *wi = kit_directions(kit, 0, 0) + 3 * direction, *wo = kit_directions(kit, 0, 1) + 3 * direction;
    double hd[3];
    nqm_directions_to_half_diff(wi, wo, hd);
    return (const double[]){hd[0], hd[1], acos(fmin(wi[2], 1)), acos(fmin(wo[2], 1))}[angle] * 180 / NQM_PI;
}

/* The side of an angle where most of the difference is, and few directions are; difference: fraction at each; NULL: none. */
static json_t *find_angle(const conform_kit *kit, const double *difference) {
    enum { STEP_DEG = 5, N_SIDES = 2 * 90 / STEP_DEG }; /* below and above each step */
    double best[2] = {0.4, 0};                          /* fractions of difference and directions */
    size_t found = 0;
    for (size_t k = 0; k < N_ANGLES * N_SIDES; ++k) {
        const double limit = (double)(k % N_SIDES / 2 * STEP_DEG);
        double of[2] = {0};
        for (size_t i = 0; i < kit->n_directions; ++i)
            if ((angle_deg(kit, i, k / N_SIDES) > limit) == k % 2) {
                of[0] += difference[i];
                of[1] += 1 / (double)kit->n_directions;
            }
        if (of[0] - of[1] > best[0] - best[1]) {
            memcpy(best, of, sizeof best);
            found = k;
        }
    }
    return !found ? NULL
                  : json_pack("{s:o}", "text",
                              json_sprintf(
                                  "%.0f %% of their difference is where %s %c %zu degrees: %.0f %% of the directions.",
                                  100 * best[0], angle_names[found / N_SIDES], found % 2 ? '>' : '<',
                                  found % N_SIDES / 2 * STEP_DEG, 100 * best[1]));
}

/* The largest difference; at: index of the value. */
static json_t *json_largest(const conform_kit *kit, size_t at, double value, double right) {
    static const char *const names[] = {"red", "green", "blue"};
    const size_t row = at / 3, set = row / kit->n_directions + 1, direction = row % kit->n_directions;
    double deg[N_ANGLES];
    for (size_t a = 0; a < N_ANGLES; ++a)
        deg[a] = angle_deg(kit, direction, a);
    return json_pack(
        "{s:o,s:I,s:I,s:s,s:o,s:f,s:f,s:[f,f,f,f]}", "text",
        json_sprintf("Largest difference: %s of set %zu is %.3g times the right value (%.3g for %.3g) at theta_h %.0f, "
                     "theta_d %.0f, theta_light %.0f, theta_viewer %.0f degrees, row %zu of the kit.",
                     names[at % 3], set, value / right, value, right, deg[0], deg[1], deg[2], deg[3], row + 1),
        "set", (json_int_t)set, "row", (json_int_t)row + 1, "channel", names[at % 3], "ratio",
        json_number(value / right), "value", value, "right", right, "angles_deg", deg[0], deg[1], deg[2], deg[3]);
}

json_t *list_facts(const conform_kit *kit, const float *values, const bool *fails) {
    const suspect none = {.n_flaws = 0};
    const size_t n = kit->n_directions;
    double *difference = allocate(n, sizeof *difference), sum = 0, most = 0;
    float *ref = allocate(3 * n, sizeof *ref);
    size_t n_fails = 0, at = 0;
    for (size_t set = 0; set < kit->n_sets; ++set) {
        n_fails += fails[set];
        sample_suspect(kit, set, &none, ref);
        for (size_t i = 0; i < 3 * n && fails[set]; ++i) {
            const double r = (double)ref[i], v = fmax(0, (double)values[3 * n * set + i]);
            const double d = isnan(values[3 * n * set + i]) ? 0 : fabs(log((v + 0.003) / (r + 0.003)));
            difference[i / 3] += d;
            sum += d;
            at = d > most ? 3 * n * set + i : at;
            most = fmax(most, d);
        }
    }
    sample_suspect(kit, at / n / 3, &none, ref);
    for (size_t i = 0; i < n; ++i)
        difference[i] /= sum;
    json_t *facts =
        json_pack("{s:o*,s:o*,s:o*}", "sets", separate_sets(kit, fails, n_fails), "angles",
                  sum > 0 ? find_angle(kit, difference) : NULL, "largest",
                  sum > 0 ? json_largest(kit, at, fmax(0, (double)values[at]), (double)ref[at % (3 * n)]) : NULL);
    free(ref);
    free(difference);
    return facts;
}
