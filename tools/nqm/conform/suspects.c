/* SPDX-License-Identifier: MIT
 *
 * Which mistake explains the values of a shader? Suspects are mistakes in the formulas of the model (brdf/core/mistakes.h) and
 * wrong values of its parameters, which follow from the schema. Each is evaluated and compared with the values.
 */
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { IGNORED, ABSENT, SQUARED, ROOT, DECODED, NOT_DECODED, INVERTED, FLIPPED, N_PROPERTY_MISTAKES };
static const nqm_property_mistake property_mistakes[] = {[IGNORED] = {" is ignored (its default is used)", NULL},
                                                         [ABSENT] = {" is taken as 0", NULL},
                                                         NQM_PROPERTY_MISTAKES};

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static bool is_possible(const nqm_spec_key *key, size_t how) {
    const bool is_rotation = key->low < 0, is_amount = !is_rotation && key->turns;
    switch (how) {
    case IGNORED:
        return !key->required;
    case ABSENT:
        return key->n == 1 && key->low <= 0 && key->fallback != 0 && !key->whole && !is_width_key(key);
    case SQUARED:
    case ROOT:
        return is_width_key(key) || is_amount;
    case INVERTED:
        return is_width_key(key);
    case FLIPPED:
        return is_rotation;
    default:
        return key->n == 3 && (key->high <= 2 || strstr(key->name, "color"));
    }
}

/* Roughness is squared once by most models: the common names of the mistakes are those of shaders. */
static const char *text_of(const conform_kit *kit, size_t k, size_t how) {
    const bool is_squared = strstr(kit->model->schema.keys[k].name, "oughness") && kit->model->schema.keys[k].n == 1;
    return is_squared && how == SQUARED ? " is squared twice"
           : is_squared && how == ROOT  ? " is not squared"
                                        : property_mistakes[how].text;
}

suspect *list_suspects(const conform_kit *kit, size_t *n) {
    const nqm_spec_schema *schema = &kit->model->schema;
    suspect *list = allocate(MAX_SUSPECTS, sizeof *list);
    *n = 1;
    for (size_t m = 0; m < NQM_N_MISTAKES; ++m) {
        list[*n].mistakes = (nqm_mistakes)1 << m;
        snprintf(list[(*n)++].text, SUSPECT_TEXT, "%s", nqm_mistake_words(m));
    }
    for (size_t k = 0; k < schema->n_keys; ++k)
        for (size_t how = 0; how < N_PROPERTY_MISTAKES && *n < MAX_SUSPECTS; ++how)
            if (is_possible(&schema->keys[k], how)) {
                suspect *s = &list[(*n)++];
                s->n_changes = 1;
                s->change[0].key = k;
                s->change[0].how = how;
                snprintf(s->text, SUSPECT_TEXT, "%s%s", schema->keys[k].name, text_of(kit, k, how));
            }
    return list;
}

/* ---- their values ------------------------------------------------------------------------------------------------ */

static nqm_spec_values changed_values(const conform_kit *kit, const kit_set *set, const suspect *s) {
    nqm_spec_values values = set->values;
    for (size_t i = 0; i < s->n_changes; ++i) {
        const size_t k = s->change[i].key;
        const nqm_spec_key *key = &kit->model->schema.keys[k];
        double (*apply)(double) = property_mistakes[s->change[i].how].apply;
        for (size_t c = 0; c < 3; ++c)
            values.v[k][c] = apply                        ? fmin(fmax(apply(values.v[k][c]), key->low), key->high)
                             : s->change[i].how == ABSENT ? 0
                                                          : key->fallback;
    }
    return values;
}

void sample_suspect(const conform_kit *kit, size_t set, const suspect *s, float *rgb) {
    const nqm_spec_values values = changed_values(kit, &kit->sets[set], s);
    sample_set(kit, &kit->sets[set], &values, s->mistakes, rgb);
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

/* Every fifth direction is enough for the choice: neighbours in the list have other azimuths. */
enum { STRIDE = 5 };

typedef struct comparison {
    const conform_kit *kit;
    size_t n; /* suspects */
    const suspect *suspects;
    const suspect_targets *targets;
    conform_kit *own, *planted; /* copies with the directions that are compared */
    double *left;               /* (n_sets, n_targets, n) */
} comparison;

/* log(f_r + 0.003); NaN remains. */
static void take_logs(size_t n, float *values) {
    for (size_t i = 0; i < n; ++i)
        values[i] = logf((values[i] < 0 ? 0 : values[i]) + 0.003F);
}

static void evaluate(const conform_kit *kit, size_t set, const suspect *s, float *logs) {
    sample_suspect(kit, set, s, logs);
    take_logs(3 * kit->n_directions, logs);
}

static double difference(size_t n, const float *a, const float *b) {
    double sum = 0;
    size_t n_used = 0;
    for (size_t i = 0; i < n; ++i) {
        const float d = fabsf(a[i] - b[i]);
        sum += d >= 0 ? (double)d : 0; /* without NaN */
        n_used += d >= 0;
    }
    return n_used ? sum / (double)n_used : 0;
}

/* What remains of one set. */
static void compare_set(void *user, size_t set) {
    const comparison *c = user;
    const suspect_targets *targets = c->targets;
    const size_t n_kept = c->own->n_directions, n_values = 3 * n_kept;
    float *logs = allocate((c->n + 1) * n_values, sizeof *logs), *target = logs + c->n * n_values;
    for (size_t s = 0; s < c->n; ++s)
        evaluate(c->own, set, &c->suspects[s], logs + s * n_values);
    for (size_t t = 0; t < targets->n; ++t) {
        for (size_t i = 0; !targets->planted && i < n_kept; ++i)
            memcpy(target + 3 * i, targets->values + 3 * (set * c->kit->n_directions + STRIDE * i), 3 * sizeof *target);
        if (targets->planted)
            evaluate(c->planted, set, &c->suspects[t], target);
        else
            take_logs(n_values, target);
        for (size_t s = 0; s < c->n; ++s)
            c->left[(set * targets->n + t) * c->n + s] = difference(n_values, logs + s * n_values, target);
    }
    free(logs);
}

void compare_suspects(const conform_kit *kit, size_t n, const suspect *suspects, const suspect_targets *targets,
                      double *left) {
    const size_t n_left = targets->n * n;
    comparison c = {.kit = kit, .n = n, .suspects = suspects, .targets = targets};
    nqm_ticker ticker = {.fn = show_progress};
    c.left = allocate(kit->n_sets * n_left, sizeof *c.left);
    c.own = copy_kit(kit, STRIDE);
    c.planted = copy_kit(targets->planted ? targets->planted : kit, STRIDE);
    if (nqm_parallel_ticking(&ticker, "mistakes", kit->n_sets, compare_set, &c))
        stop(EXIT_INTERRUPTED, "interrupted");
    end_progress();
    memset(left, 0, n_left * sizeof *left);
    for (size_t i = 0; i < kit->n_sets * n_left; ++i)
        left[i % n_left] += c.left[i] / (double)kit->n_sets;
    free_kit_copy(c.own);
    free_kit_copy(c.planted);
    free(c.left);
}

/* ---- the choice -------------------------------------------------------------------------------------------------- */

static int by_left(const void *a, const void *b) {
    const suspect *x = a, *y = b;
    return (x->left > y->left) - (x->left < y->left);
}

/* Compare and sort them, best first. */
static void sort_suspects(const conform_kit *kit, const float *values, size_t n, suspect *list) {
    double *left = allocate(n, sizeof *left);
    compare_suspects(kit, n, list, &(suspect_targets){1, values, NULL}, left);
    for (size_t s = 0; s < n; ++s)
        list[s].left = left[s];
    qsort(list, n, sizeof *list, by_left);
    free(left);
}

/* Whether two suspects with close results have equal values: then nothing can tell one from the other. */
static bool are_equal(const conform_kit *kit, const suspect *a, const suspect *b) {
    double left[2];
    if (fabs(a->left - b->left) > 1e-4)
        return false;
    compare_suspects(kit, 2, (const suspect[]){*a, *b}, &(suspect_targets){1, NULL, kit}, left);
    return left[1] < 1e-5;
}

/* Those of the sorted ones that leave less than `most`. */
static size_t keep_different(const conform_kit *kit, size_t n, const suspect *list, double most, size_t n_found,
                             suspect *found) {
    size_t kept = 0;
    for (size_t s = 0; s < n && list[s].left < most && kept < n_found; ++s) {
        size_t k = 0;
        while (k < kept && !are_equal(kit, &found[k], &list[s]))
            ++k;
        if (k == kept)
            found[kept++] = list[s];
        else {
            const size_t at = strlen(found[k].text);
            snprintf(found[k].text + at, SUSPECT_TEXT - at, "; or %s", list[s].text);
        }
    }
    return kept;
}

/* The best suspect with each of the others; false: there is no room. */
static void add_to_each(size_t n, suspect *list, const suspect *best) {
    for (size_t s = 0; s < n; ++s) {
        suspect both = list[s];
        for (size_t i = 0; i < best->n_changes && both.n_changes < MAX_CHANGES; ++i)
            both.change[both.n_changes++] = best->change[i];
        both.mistakes |= best->mistakes;
        if (both.mistakes == best->mistakes && both.n_changes == best->n_changes)
            snprintf(both.text, SUSPECT_TEXT, "%s", best->text);
        else
            snprintf(both.text, SUSPECT_TEXT, "%.150s, and %.150s", best->text, list[s].text);
        list[s] = both;
    }
}

size_t find_suspects(const conform_kit *kit, const float *values, size_t n_found, suspect *found, double *none) {
    /* A second mistake is looked for where one leaves more than float32 does, and named if it explains most of that. */
    const double noise = 2e-4, explained = 0.3;
    size_t n;
    suspect *list = list_suspects(kit, &n), *pairs = list_suspects(kit, &n);
    sort_suspects(kit, values, n, list);
    for (size_t s = 0; s < n; ++s)
        if (!list[s].mistakes && !list[s].n_changes)
            *none = list[s].left;
    if (*none <= noise)
        n = 0;
    else if (list[0].left > noise && list[0].left < *none) {
        add_to_each(n, pairs, &list[0]);
        sort_suspects(kit, values, n, pairs);
        if (pairs[0].left < explained * list[0].left) { /* first, before the single ones */
            memmove(list + 1, list, (n - 1) * sizeof *list);
            list[0] = pairs[0];
        }
    }
    const size_t kept = keep_different(kit, n, list, 0.9 * *none, n_found, found);
    free(pairs);
    free(list);
    return kept;
}
