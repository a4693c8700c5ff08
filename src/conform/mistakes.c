/* SPDX-License-Identifier: MIT
 *
 * Which mistake explains the values of a shader? Suspects are mistakes in the formulas of the model (brdf/core/mistakes.h), wrong
 * values of its parameters, which follow from the schema, and wrong channels. Each is evaluated and compared with the values.
 */
#include "conform/conform.h"

#include "brdf/core/mistakes.h"
#include "math/math.h"

#include <stdatomic.h>
#include <stdlib.h>

enum { MAX_SUSPECTS = 400 };

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

static const char *channels_of(const nqm_schema *schema, const nqm_conform_flaw *f) {
    const size_t first = f->key < schema->n_keys ? N_PROPERTY_MISTAKES : NQM_N_MISTAKES;
    return f->how < first ? NULL : channels[f->how - first];
}

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static bool is_possible(const nqm_schema *schema, size_t k, size_t how) {
    const nqm_schema_key *key = &schema->keys[k];
    const bool is_rotation = nqm_schema_is_azimuth(key->role),
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
static void add_suspects(nqm_conform_flaw f, bool is_formula, nqm_conform_suspect *list, size_t *n) {
    const bool is_exponent = is_formula && f.how == NQM_MISTAKE_SCHLICK_EXPONENT,
               is_limit = is_formula && f.how == NQM_MISTAKE_CLAMPED,
               is_leak = is_formula && f.how >= NQM_N_MISTAKES + N_COLOUR_MISTAKES;
    const size_t kind = *n;
    const double factor = is_exponent ? 1.4 : is_limit ? 4 : 2;
    f.amount = is_exponent ? 3 : is_limit ? 1 : is_leak || (!is_formula && f.how == RAISED) ? 0.05 : 0;
    for (size_t i = 0; i < (f.amount == 0 ? 1 : 4) && *n < MAX_SUSPECTS; ++i, f.amount *= factor)
        list[(*n)++] = (nqm_conform_suspect){.n_flaws = 1, .flaws[0] = f, .kind = kind};
}

/* All that the model can have with one flaw, some with several amounts, and first none. Returns their number. */
static size_t list_suspects(const nqm_conform_kit *kit, nqm_conform_suspect list[MAX_SUSPECTS]) {
    const nqm_schema *schema = kit->schema;
    size_t n = 1;
    list[0] = (nqm_conform_suspect){.n_flaws = 0};
    for (size_t how = 0; how < NQM_N_MISTAKES + N_CHANNEL_MISTAKES; ++how)
        add_suspects((nqm_conform_flaw){.key = schema->n_keys, .how = how}, true, list, &n);
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const bool has_values = kit->keys >> k & 1; /* else the default, which may be taken as 0 */
        for (size_t how = 0; how < N_PROPERTY_MISTAKES + N_COLOUR_MISTAKES; ++how)
            if ((has_values || how == ABSENT) && is_possible(schema, k, how))
                add_suspects((nqm_conform_flaw){.key = k, .how = how}, false, list, &n);
    }
    return n;
}

/* Append the words of a suspect to a text. */
static void describe(const nqm_conform_kit *kit, const nqm_conform_suspect *s, char *text, size_t n_text) {
    const nqm_schema *schema = kit->schema;
    size_t at = strlen(text);
    for (const nqm_conform_flaw *f = s->flaws; f < s->flaws + s->n_flaws; ++f, at = strlen(text)) {
        const nqm_schema_key *key = f->key < schema->n_keys ? &schema->keys[f->key] : NULL;
        /* Roughness is squared once by most models: the common names of the mistakes are those of shaders. */
        const bool is_squared = key && key->n == 1 && nqm_schema_is_width(key->role) && key->unit == NQM_UNIT_PLAIN;
        const char *wrong = channels_of(schema, f);
        char words[64], amount[32];
        snprintf(words, sizeof words, wrong && strlen(wrong) == 2 ? "the values: .%c is added to .%c, times" : "",
                 wrong ? wrong[1] : 0, wrong ? wrong[0] : 0);
        if (wrong && strlen(wrong) == 3)
            snprintf(words, sizeof words, "%s read as .%s", key ? " is" : "the values are", wrong);
        snprintf(amount, sizeof amount, f->amount != 0 ? " %.3g" : "", f->amount);
        snprintf(text + at, n_text - at, "%s%s%s%s%s", f > s->flaws ? ", and " : "", key ? key->name : "",
                 wrong                             ? words
                 : !key                            ? nqm_mistake_words(f->how)
                 : is_squared && f->how == SQUARED ? " is squared twice"
                 : is_squared && f->how == ROOT    ? " is not squared"
                                                   : property_mistakes[f->how].text,
                 key && f->how == OF_BASE ? schema->keys[nqm_schema_key_of(schema, NQM_ROLE_WIDTH)].name : "", amount);
    }
}

/* ---- their values ------------------------------------------------------------------------------------------------ */

static double changed(const nqm_schema *schema, const nqm_values *values, const nqm_conform_flaw *f, size_t c) {
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

/* The values of a set with its flaws; those of formulas are put into *mistakes. */
static nqm_values mistaken_values(const nqm_values *right, const nqm_conform_suspect *s, nqm_mistakes *mistakes) {
    const nqm_schema *schema = right->schema;
    nqm_values values = *right;
    for (const nqm_conform_flaw *f = s->flaws; f < s->flaws + s->n_flaws; ++f) {
        const nqm_values before = values;
        for (size_t c = 0; c < 3 && f->key < schema->n_keys; ++c)
            values.v[f->key][c] =
                fmin(fmax(changed(schema, &before, f, c), schema->keys[f->key].low), schema->keys[f->key].high);
        if (f->key < schema->n_keys)
            continue;
        if (channels_of(schema, f))
            mistakes->channels = channels_of(schema, f);
        else
            mistakes->made |= (uint64_t)1 << f->how;
        mistakes->amount = fmax(mistakes->amount, f->amount);
    }
    return values;
}

void nqm_conform_sample(const nqm_conform_kit *kit, size_t set, const nqm_conform_suspect *s, size_t stride,
                        bool is_rounded, float *rgb) {
    enum { PIECE = 512 };
    const nqm_kit_set *p = &kit->sets[set];
    const size_t n = nqm_ceil_div(kit->n_directions, stride);
    double w[2][3 * PIECE];
    nqm_values values = p->values;
    nqm_mistakes mistakes = {.made = 0};
    for (size_t i = 0; is_rounded && i < 3 * kit->schema->n_keys; ++i)
        values.v[i / 3][i % 3] = (double)(float)values.v[i / 3][i % 3];
    values = mistaken_values(&values, s, &mistakes);
    for (size_t at = 0, n_piece; at < n; at += n_piece) {
        n_piece = nqm_smaller(n - at, PIECE);
        for (size_t side = 0; side < 2; ++side) {
            const double *from = nqm_conform_directions(kit, p->azimuth, side) + 3 * stride * at;
            for (size_t i = 0; i < n_piece; ++i, from += 3 * stride)
                for (size_t c = 0; c < 3; ++c)
                    w[side][3 * i + c] = is_rounded ? (double)(float)from[c] : from[c];
        }
        nqm_mistaken_eval(&values, &mistakes, n_piece, w[0], w[1], rgb + 3 * at);
    }
}

/* ---- comparison -------------------------------------------------------------------------------------------------- */

/* Every fifth direction is enough for the choice: neighbours in the list have other azimuths. */
enum { STRIDE = 5 };

typedef struct search {
    const nqm_conform_kit *kit;
    const float *values;
    nqm_ticker ticker;
    nqm_error *err;
    nqm_status status; /* after a failure, nothing more is compared */
    /* of explain(): */
    size_t n, n_planted;
    const nqm_conform_suspect *suspects;
    bool is_rounded;
    double *left;           /* (n_sets, targets, n) */
    atomic_bool has_failed; /* out of memory */
} search;

/* log(f_r + 0.003); NaN remains. */
static void take_logs(size_t n, float *values) {
    for (size_t i = 0; i < n; ++i)
        values[i] = logf((values[i] < 0 ? 0 : values[i]) + 0.003F);
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
static void explain_set(void *user, size_t set) {
    search *s = user;
    const size_t n_kept = nqm_ceil_div(s->kit->n_directions, STRIDE), n_values = 3 * n_kept;
    float *logs = nqm_alloc((s->n + 1) * n_values, sizeof *logs);
    if (!logs) {
        atomic_store(&s->has_failed, true);
        return;
    }
    double *left = s->left + set * s->n * nqm_larger(s->n_planted, 1);
    float *target = logs + s->n * n_values;
    for (size_t i = 0; i < s->n; ++i)
        nqm_conform_sample(s->kit, set, &s->suspects[i], STRIDE, false, logs + i * n_values);
    take_logs(s->n * n_values, logs);
    for (size_t t = 0; t < nqm_larger(s->n_planted, 1); ++t) {
        for (size_t i = 0; !s->n_planted && i < n_kept; ++i) {
            const float *v = s->values + 3 * (set * s->kit->n_directions + STRIDE * i);
            for (size_t c = 0; c < 3; ++c)
                target[3 * i + c] = nqm_conform_is_value(v) ? v[c] : NAN;
        }
        if (s->n_planted)
            nqm_conform_sample(s->kit, set, &s->suspects[t], STRIDE, s->is_rounded, target);
        take_logs(n_values, target);
        for (size_t i = 0; i < s->n; ++i)
            left[t * s->n + i] = difference(n_values, logs + i * n_values, target);
    }
    nqm_free(logs);
}

/* What remains of the values by each of n suspects; with n_planted, of the first of them by each, (n_planted, n). is_rounded: planted ones
 * have inputs in float32. */
static void explain(search *s, size_t n, const nqm_conform_suspect *list, size_t n_planted, bool is_rounded,
                    double *left) {
    const size_t n_sets = s->kit->n_sets, n_left = n * nqm_larger(n_planted, 1);
    s->n = n;
    s->n_planted = n_planted;
    s->suspects = list;
    s->is_rounded = is_rounded;
    s->left = s->status == NQM_OK ? nqm_alloc(n_sets * n_left, sizeof *s->left) : NULL;
    if (s->status == NQM_OK && s->left && nqm_parallel_ticking(&s->ticker, "mistakes", n_sets, explain_set, s))
        s->status = nqm_fail(s->err, NQM_ERR_CANCELLED, -1, "interrupted");
    else if (s->status == NQM_OK && (!s->left || atomic_load(&s->has_failed)))
        s->status = nqm_fail_nomem(s->err, n_sets * n_left * sizeof *s->left);
    memset(left, 0, n_left * sizeof *left);
    for (size_t i = 0; s->status == NQM_OK && i < n_sets * n_left; ++i)
        left[i % n_left] += s->left[i] / (double)n_sets;
    nqm_free(s->left);
}

/* ---- the choice -------------------------------------------------------------------------------------------------- */

static int by_left(const void *a, const void *b) {
    const nqm_conform_suspect *x = a, *y = b;
    return (x->left > y->left) - (x->left < y->left);
}

/* Compare and sort them, best first. */
static void sort_suspects(search *s, size_t n, nqm_conform_suspect *list) {
    double left[MAX_SUSPECTS];
    explain(s, n, list, 0, false, left);
    for (size_t i = 0; i < n; ++i)
        list[i].left = left[i];
    qsort(list, n, sizeof *list, by_left);
}

/* Move the amounts to where least remains; a round number is one of those that are tried. */
static void refine(search *s, nqm_conform_suspect *best) {
    for (nqm_conform_flaw *f = best->flaws; f < best->flaws + best->n_flaws; ++f)
        for (double step = 1.5; f->amount != 0 && step > 1.004; step = sqrt(step)) {
            const double amounts[] = {f->amount, nqm_round_digits(f->amount, 2), f->amount * step, f->amount / step};
            nqm_conform_suspect tries[] = {*best, *best, *best, *best};
            for (size_t i = 0; i < 4; ++i)
                tries[i].flaws[f - best->flaws].amount = amounts[i];
            sort_suspects(s, 4, tries);
            *best = tries[0];
        }
}

/* Whether two suspects with close results have equal values: then nothing can tell one from the other. */
static bool are_equal(search *s, const nqm_conform_suspect *a, const nqm_conform_suspect *b) {
    double left[4];
    if (fabs(a->left - b->left) > 1e-4)
        return false;
    explain(s, 2, (const nqm_conform_suspect[]){*a, *b}, 2, false, left);
    return left[1] < 1e-5;
}

/* Report those of the sorted ones that leave less than nine tenths. */
static void report_different(search *s, size_t n, const nqm_conform_suspect *list, nqm_conform_suspect *found,
                             nqm_conform_report *report) {
    for (size_t i = 0; i < n && list[i].left < 0.9 * report->difference && report->n_mistakes < NQM_CONFORM_MISTAKES;
         ++i) {
        size_t k = 0;
        while (k < report->n_mistakes && found[k].kind != list[i].kind && !are_equal(s, &found[k], &list[i]))
            ++k;
        char *text = report->mistakes[k].text;
        if (k == report->n_mistakes) {
            found[report->n_mistakes++] = list[i];
            report->mistakes[k] = (nqm_conform_mistake){.remaining = list[i].left / report->difference};
        } else if (found[k].kind != list[i].kind)
            snprintf(text + strlen(text), NQM_CONFORM_TEXT - strlen(text), "; or ");
        else
            continue;
        describe(s->kit, &list[i], text, NQM_CONFORM_TEXT);
    }
}

/* The best suspect with each of the others. */
static void add_to_each(size_t n, nqm_conform_suspect *list, const nqm_conform_suspect *best) {
    for (size_t i = 0; i < n; ++i) {
        const nqm_conform_suspect other = list[i];
        list[i] = *best;
        if (best->kind && other.kind && best->kind != other.kind) {
            list[i].flaws[list[i].n_flaws++] = other.flaws[0];
            list[i].kind = best->kind * MAX_SUSPECTS + other.kind;
        }
    }
}

nqm_status nqm_conform_search(const nqm_conform_kit *kit, const float *values, const nqm_ticker *ticker,
                              nqm_conform_suspect found[NQM_CONFORM_MISTAKES], nqm_conform_report *report,
                              nqm_error *err) {
    /* A second mistake is looked for where one leaves more than float32 does, and named if it explains most of that. */
    const double noise = 2e-4, explained = 0.3;
    const size_t n_refined = 5;
    search s = {.kit = kit, .values = values, .ticker = *ticker, .err = err};
    nqm_conform_suspect list[MAX_SUSPECTS], pairs[MAX_SUSPECTS];
    const size_t n = list_suspects(kit, list);
    memcpy(pairs, list, n * sizeof *list);
    sort_suspects(&s, n, list);
    for (size_t i = 0; i < n; ++i)
        if (!list[i].n_flaws)
            report->difference = list[i].left;
    if (report->difference <= noise)
        return s.status;
    for (size_t i = 0; i < n_refined; ++i)
        refine(&s, &list[i]);
    qsort(list, n, sizeof *list, by_left);
    if (list[0].left > noise && list[0].left < report->difference) {
        add_to_each(n, pairs, &list[0]);
        sort_suspects(&s, n, pairs);
        refine(&s, &pairs[0]);
        if (pairs[0].left < explained * list[0].left) { /* first, before the single ones */
            memmove(list + 1, list, (n - 1) * sizeof *list);
            list[0] = pairs[0];
        }
    }
    report_different(&s, n, list, found, report);
    return s.status;
}

/* ---- the proof --------------------------------------------------------------------------------------------------- */

/* Count the planted mistakes that are found. left (n, n): what remains of each by each. */
static void count_found(const nqm_conform_kit *kit, size_t n, const nqm_conform_suspect *list, const double *left,
                        nqm_conform_proof *proof) {
    const double noticed = 1e-4;
    for (size_t t = 1; t < n; ++t) {
        if (left[t * n] < noticed) /* this model does not have it */
            continue;
        size_t rank = 0; /* those with equal values (to float32) count as itself */
        for (size_t other = 0; other < n; ++other)
            rank += left[t * n + other] < left[t * n + t] - 1e-6;
        ++proof->n_mistakes;
        proof->n_first += rank == 0;
        proof->n_three += rank < 3;
        if (rank && *proof->missed)
            strncat(proof->missed, "\n", sizeof proof->missed - strlen(proof->missed) - 1);
        if (rank)
            describe(kit, &list[t], proof->missed, sizeof proof->missed);
    }
}

nqm_status nqm_conform_prove(const nqm_conform_kit *kit, nqm_progress_fn progress, void *user, nqm_conform_proof *proof,
                             nqm_error *err) {
    search s = {.kit = kit, .ticker = {.fn = progress, .user = user}, .err = err};
    nqm_conform_suspect list[MAX_SUSPECTS];
    const size_t n = list_suspects(kit, list), n_values = 3 * kit->n_sets * kit->n_directions;
    nqm_conform_report report;
    nqm_score_result *results;
    double *left;
    float *values;
    s.status = nqm_alloc_arrays(NQM_ARRAYS({&results, kit->n_sets, sizeof *results}, {&left, n * n, sizeof *left},
                                           {&values, n_values, sizeof *values}),
                                err);
    *proof = (nqm_conform_proof){.n_mistakes = 0};
    for (size_t set = 0; s.status == NQM_OK && set < kit->n_sets; ++set)
        nqm_conform_sample(kit, set, &list[0], 1, true, values + 3 * set * kit->n_directions);
    if (s.status == NQM_OK)
        s.status = nqm_conform_compare(kit, values, progress, user, results, &report, err);
    if (s.status == NQM_OK)
        explain(&s, n, list, n, true, left);
    if (s.status == NQM_OK) {
        count_found(kit, n, list, left, proof);
        proof->lowest_jod = report.lowest_jod;
        proof->passes = proof->lowest_jod >= NQM_CONFORM_PASS && 10 * proof->n_first >= 9 * proof->n_mistakes &&
                        100 * proof->n_three >= 98 * proof->n_mistakes;
    }
    nqm_free(results);
    return s.status;
}
