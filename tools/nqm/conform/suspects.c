/* SPDX-License-Identifier: MIT
 *
 * Which mistake explains the values of a shader? Suspects are mistakes in the formulas of the model (brdf/core/mistakes.h), wrong
 * values of its parameters, which follow from the schema, and wrong channels. Each is evaluated and compared with the values.
 */
#include "fit/fit.h"
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { IGNORED, ABSENT, OF_BASE, RAISED, SQUARED, ROOT, DECODED, NOT_DECODED, INVERTED, FLIPPED, FACTOR };
static const struct {
    const char *text;
    double (*apply)(double x);
    double factor; /* of rotations */
} property_mistakes[] = {
    [IGNORED] = {.text = " is ignored (its default is used)"},
    [ABSENT] = {.text = " is taken as 0"},
    [OF_BASE] = {.text = " has the value of "},
    [RAISED] = {.text = " is raised to at least"},
    NQM_PROPERTY_MISTAKES,
    [FACTOR] = {.text = " is multiplied by pi / 180, as if it were in degrees", .factor = NQM_PI / 180},
    {.text = " is multiplied by 180 / pi, to degrees", .factor = 180 / NQM_PI},
    {.text = " is multiplied by 2 pi, as if it were in turns", .factor = 2 * NQM_PI},
    {.text = " is divided by 2 pi, as if it were in radians", .factor = 0.5 / NQM_PI},
    {.text = " is divided by 360, as if it were in degrees", .factor = 1.0 / 360},
};
enum { N_PROPERTY_MISTAKES = sizeof property_mistakes / sizeof *property_mistakes };

/* Mistakes of channels (nqm_mistakes.channels) follow them: the first ones, of colours; and all, of values, those of formulas. */
static const char *const channels[] = {"bgr", "grb", "rbg", "rrr", "rrb", "rgr", "ggb", "rgg",
                                       "bgb", "rbb", "rg",  "rb",  "gr",  "gb",  "br",  "bg"};
enum { N_COLOUR_MISTAKES = 10, N_CHANNEL_MISTAKES = sizeof channels / sizeof *channels };

static const char *channels_of(const nqm_schema *schema, const flaw *f) {
    const size_t first = f->key < schema->n_keys ? N_PROPERTY_MISTAKES : NQM_N_MISTAKES;
    return f->how < first ? NULL : channels[f->how - first];
}

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static bool is_possible(const nqm_schema *schema, size_t k, size_t how) {
    const nqm_schema_key *key = &schema->keys[k];
    const bool is_rotation = key->role == NQM_ROLE_AZIMUTH || key->role == NQM_ROLE_COAT_AZIMUTH,
               is_amount = !is_rotation && nqm_schema_is_anisotropic(key->role),
               is_width = nqm_schema_is_width(key->role);
    switch (how) {
    case IGNORED:
        return !key->required;
    case ABSENT:
        return key->n == 1 && key->low <= 0 && key->fallback != 0 && !key->whole && !is_width;
    case OF_BASE:
        return is_width && nqm_schema_layer_of(schema, k) != k;
    case SQUARED:
    case ROOT:
        return is_width || is_amount;
    case RAISED:
        return is_width && key->unit != NQM_UNIT_GLOSS;
    case INVERTED:
        return is_width;
    case DECODED:
    case NOT_DECODED:
        return key->n == 3 && key->role != NQM_ROLE_METAL_ETA && key->role != NQM_ROLE_METAL_K;
    default:
        return how < N_PROPERTY_MISTAKES ? is_rotation : key->n == 3;
    }
}

/* A suspect for each amount that is tried: refine() finds those between. */
static void add_suspects(flaw f, bool is_formula, suspect *list, size_t *n) {
    const bool is_exponent = is_formula && f.how == NQM_MISTAKE_SCHLICK_EXPONENT,
               is_limit = is_formula && f.how == NQM_MISTAKE_CLAMPED,
               is_leak = is_formula && f.how >= NQM_N_MISTAKES + N_COLOUR_MISTAKES;
    const size_t kind = *n;
    const double factor = is_exponent ? 1.4 : is_limit ? 4 : 2;
    f.amount = is_exponent ? 3 : is_limit ? 1 : is_leak || (!is_formula && f.how == RAISED) ? 0.05 : 0;
    for (size_t i = 0; i < (f.amount == 0 ? 1 : 4) && *n < MAX_SUSPECTS; ++i, f.amount *= factor)
        list[(*n)++] = (suspect){.n_flaws = 1, .flaws[0] = f, .kind = kind};
}

suspect *list_suspects(const conform_kit *kit, size_t *n) {
    const nqm_schema *schema = kit->model->schema;
    suspect *list = allocate(MAX_SUSPECTS, sizeof *list);
    *n = 1;
    for (size_t how = 0; how < NQM_N_MISTAKES + N_CHANNEL_MISTAKES; ++how)
        add_suspects((flaw){.key = schema->n_keys, .how = how}, true, list, n);
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const bool has_values = kit->keys >> k & 1; /* else the default, which may be taken as 0 */
        for (size_t how = 0; how < N_PROPERTY_MISTAKES + N_COLOUR_MISTAKES; ++how)
            if ((has_values || how == ABSENT) && is_possible(schema, k, how))
                add_suspects((flaw){.key = k, .how = how}, false, list, n);
    }
    return list;
}

void describe_suspect(const conform_kit *kit, suspect *s) {
    const nqm_schema *schema = kit->model->schema;
    FILE *out = must_have(fmemopen(s->text, sizeof s->text, "w"));
    for (const flaw *f = s->flaws; f < s->flaws + s->n_flaws; ++f) {
        const nqm_schema_key *key = f->key < schema->n_keys ? &schema->keys[f->key] : NULL;
        /* Roughness is squared once by most models: the common names of the mistakes are those of shaders. */
        const bool is_squared = key && key->n == 1 && nqm_schema_is_width(key->role) && key->unit == NQM_UNIT_PLAIN;
        fprintf(out, "%s%s", f > s->flaws ? ", and " : "", key ? key->name : "");
        const char *wrong = channels_of(schema, f);
        if (wrong && strlen(wrong) == 2)
            fprintf(out, "the values: .%c is added to .%c, times", wrong[1], wrong[0]);
        else if (wrong)
            fprintf(out, "%s read as .%s", key ? " is" : "the values are", wrong);
        else
            fputs(!key                              ? nqm_mistake_words(f->how)
                  : is_squared && f->how == SQUARED ? " is squared twice"
                  : is_squared && f->how == ROOT    ? " is not squared"
                                                    : property_mistakes[f->how].text,
                  out);
        if (key && f->how == OF_BASE)
            fputs(schema->keys[nqm_schema_key_of(schema, NQM_ROLE_WIDTH)].name, out);
        if (f->amount != 0)
            fprintf(out, " %.3g", f->amount);
    }
    fclose(out);
}

/* ---- their values ------------------------------------------------------------------------------------------------ */

static double changed(const nqm_schema *schema, const nqm_values *values, const flaw *f, size_t c) {
    const double *v = values->v[f->key];
    if (channels_of(schema, f))
        return v[nqm_channel_of(channels_of(schema, f)[c])];
    switch (f->how) {
    case IGNORED:
        return schema->keys[f->key].fallback;
    case ABSENT:
        return 0;
    case OF_BASE:
        return values->v[nqm_schema_key_of(schema, NQM_ROLE_WIDTH)][c];
    case RAISED:
        return fmax(v[c], f->amount);
    default:
        return f->how < FACTOR ? property_mistakes[f->how].apply(v[c]) : property_mistakes[f->how].factor * v[c];
    }
}

void sample_suspect(const conform_kit *kit, size_t set, const suspect *s, float *rgb) {
    const nqm_schema *schema = kit->model->schema;
    const size_t turn = kit->sets[set].turn;
    nqm_values values = kit->sets[set].values;
    nqm_mistakes mistakes = {.made = 0};
    for (const flaw *f = s->flaws; f < s->flaws + s->n_flaws; ++f) {
        const nqm_values right = values;
        for (size_t c = 0; c < 3 && f->key < schema->n_keys; ++c)
            values.v[f->key][c] =
                fmin(fmax(changed(schema, &right, f, c), schema->keys[f->key].low), schema->keys[f->key].high);
        if (f->key < schema->n_keys)
            continue;
        if (channels_of(schema, f))
            mistakes.channels = channels_of(schema, f);
        else
            mistakes.made |= (uint64_t)1 << f->how;
        mistakes.amount = fmax(mistakes.amount, f->amount);
    }
    nqm_mistaken_eval(kit->model, &values, &mistakes, kit->n_directions, kit_directions(kit, turn, 0),
                      kit_directions(kit, turn, 1), rgb);
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

/* Move the amounts to where least remains; a round number is one of those that are tried. */
static void refine(const conform_kit *kit, const float *values, suspect *s) {
    for (flaw *f = s->flaws; f < s->flaws + s->n_flaws; ++f)
        for (double step = 1.5; f->amount != 0 && step > 1.004; step = sqrt(step)) {
            const double amounts[] = {f->amount, nqm_round_digits(f->amount, 2), f->amount * step, f->amount / step};
            suspect tries[] = {*s, *s, *s, *s};
            for (size_t i = 0; i < 4; ++i)
                tries[i].flaws[f - s->flaws].amount = amounts[i];
            sort_suspects(kit, values, 4, tries);
            *s = tries[0];
        }
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
static size_t keep_different(const conform_kit *kit, size_t n, suspect *list, double most, size_t n_found,
                             suspect *found) {
    size_t kept = 0;
    for (size_t s = 0; s < n && list[s].left < most && kept < n_found; ++s) {
        size_t k = 0;
        while (k < kept && found[k].kind != list[s].kind && !are_equal(kit, &found[k], &list[s]))
            ++k;
        describe_suspect(kit, &list[s]);
        if (k == kept)
            found[kept++] = list[s];
        else if (found[k].kind != list[s].kind) {
            const size_t at = strlen(found[k].text);
            snprintf(found[k].text + at, SUSPECT_TEXT - at, "; or %s", list[s].text);
        }
    }
    return kept;
}

/* The best suspect with each of the others. */
static void add_to_each(size_t n, suspect *list, const suspect *best) {
    for (size_t s = 0; s < n; ++s) {
        const suspect other = list[s];
        list[s] = *best;
        if (best->kind && other.kind && best->kind != other.kind) {
            list[s].flaws[list[s].n_flaws++] = other.flaws[0];
            list[s].kind = best->kind * MAX_SUSPECTS + other.kind;
        }
    }
}

size_t find_suspects(const conform_kit *kit, const float *values, size_t n_found, suspect *found, double *none) {
    /* A second mistake is looked for where one leaves more than float32 does, and named if it explains most of that. */
    const double noise = 2e-4, explained = 0.3;
    const size_t n_refined = 5;
    size_t n;
    suspect *list = list_suspects(kit, &n), *pairs = list_suspects(kit, &n);
    sort_suspects(kit, values, n, list);
    for (size_t s = 0; s < n; ++s)
        if (!list[s].n_flaws)
            *none = list[s].left;
    for (size_t s = 0; *none > noise && s < n_refined; ++s)
        refine(kit, values, &list[s]);
    qsort(list, n, sizeof *list, by_left);
    if (*none <= noise)
        n = 0;
    else if (list[0].left > noise && list[0].left < *none) {
        add_to_each(n, pairs, &list[0]);
        sort_suspects(kit, values, n, pairs);
        refine(kit, values, &pairs[0]);
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
