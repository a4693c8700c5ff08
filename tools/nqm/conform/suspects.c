/* SPDX-License-Identifier: MIT
 *
 * Which mistake explains the values of a shader? Suspects are mistakes in the formulas of the model (brdf/core/mistakes.h), wrong
 * values of its parameters, which follow from the schema, and mixed channels. Each is evaluated and compared with the values.
 */
#include "fit/fit.h"
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct property_mistake {
    const char *text; /* what follows is a name, an amount or channels */
    double (*apply)(double x);
    double factor;        /* of rotations */
    const char *channels; /* of colours: where each channel is read from */
} property_mistake;

enum { IGNORED, ABSENT, OF_BASE, LIMITED, SQUARED, ROOT, DECODED, NOT_DECODED, INVERTED, FLIPPED };
#define READ_AS(CHANNELS)                                                                                              \
    { .text = " is read as .", .channels = (CHANNELS) }
static const property_mistake property_mistakes[] = {
    [IGNORED] = {.text = " is ignored (its default is used)"},
    [ABSENT] = {.text = " is taken as 0"},
    [OF_BASE] = {.text = " is that of the base, "},
    [LIMITED] = {.text = " is raised to at least"},
    NQM_PROPERTY_MISTAKES,
    {.text = " is multiplied by pi / 180, as if it were in degrees", .factor = NQM_PI / 180},
    {.text = " is multiplied by 180 / pi, to degrees", .factor = 180 / NQM_PI},
    {.text = " is multiplied by 2 pi, as if it were in turns", .factor = 2 * NQM_PI},
    {.text = " is divided by 2 pi, as if it were in radians", .factor = 0.5 / NQM_PI},
    {.text = " is divided by 360, as if it were in degrees", .factor = 1.0 / 360},
    READ_AS("bgr"),
    READ_AS("grb"),
    READ_AS("rbg"),
    READ_AS("rrr"),
    READ_AS("rrb"),
    READ_AS("rgr"),
    READ_AS("ggb"),
    READ_AS("rgg"),
    READ_AS("bgb"),
    READ_AS("rbb"),
};
enum { N_PROPERTY_MISTAKES = sizeof property_mistakes / sizeof *property_mistakes };

/* ---- the list ---------------------------------------------------------------------------------------------------- */

/* The key of the base with the ending of a layer's key, as specular_roughness for coat_roughness; n_keys: none. */
static size_t base_key_of(const nqm_spec_schema *schema, size_t k) {
    const char *ending = schema->keys[k].name + strcspn(schema->keys[k].name, "_ABCDEFGHIJKLMNOPQRSTUVWXYZ");
    const size_t n = strlen(ending += *ending == '_');
    for (size_t j = 0; n && nqm_fit_describe(schema, k).layer != k && j < schema->n_keys; ++j) {
        const char *name = schema->keys[j].name;
        if (nqm_fit_describe(schema, j).layer == j && !nqm_fit_is_layer(&schema->keys[j]) && strlen(name) >= n &&
            strcasecmp(name + strlen(name) - n, ending) == 0 && !strstr(name, "diffuse_"))
            return j;
    }
    return schema->n_keys;
}

static bool is_possible(const nqm_spec_schema *schema, size_t k, size_t how) {
    const nqm_spec_key *key = &schema->keys[k];
    const bool is_rotation = key->low < 0, is_amount = !is_rotation && key->turns;
    switch (how) {
    case IGNORED:
        return !key->required;
    case ABSENT:
        return key->n == 1 && key->low <= 0 && key->fallback != 0 && !key->whole && !is_width_key(key);
    case OF_BASE:
        return base_key_of(schema, k) < schema->n_keys;
    case SQUARED:
    case ROOT:
        return is_width_key(key) || is_amount;
    case LIMITED:
    case INVERTED:
        return is_width_key(key);
    case FLIPPED:
        return is_rotation;
    case DECODED:
    case NOT_DECODED:
        return key->n == 3 && (key->high <= 2 || strstr(key->name, "color"));
    default:
        return property_mistakes[how].channels ? key->n == 3 : is_rotation;
    }
}

/* A suspect for each amount that is tried. They are less than a factor of 2.2^2 apart, so that refine() finds those between. */
static void add_suspects(const nqm_spec_schema *schema, size_t key, size_t how, suspect *list, size_t *n) {
    enum { N_AMOUNTS = 4 };
    struct fault f = {.key = key, .how = how};
    double factor = 0;
    if (key == schema->n_keys && how == NQM_MISTAKE_SCHLICK_EXPONENT)
        f.amount = 3, factor = 1.4;
    else if (key == schema->n_keys && how == NQM_MISTAKE_CLAMPED)
        f.amount = 1, factor = 4;
    else if (key < schema->n_keys && how == LIMITED)
        f.amount = 0.05, factor = 2;
    else if (key < schema->n_keys && how == OF_BASE)
        f.base = base_key_of(schema, key);
    for (size_t i = 0; i < (factor == 0 ? 1 : N_AMOUNTS) && *n < MAX_SUSPECTS; ++i, f.amount *= factor)
        list[(*n)++] = (suspect){.n_faults = 1, .faults[0] = f};
}

suspect *list_suspects(const conform_kit *kit, size_t *n) {
    const nqm_spec_schema *schema = &kit->model->schema;
    suspect *list = allocate(MAX_SUSPECTS, sizeof *list);
    *n = 1;
    for (size_t m = 0; m < NQM_N_MISTAKES; ++m)
        add_suspects(schema, schema->n_keys, m, list, n);
    for (size_t k = 0; k < schema->n_keys; ++k)
        for (size_t how = 0; how < N_PROPERTY_MISTAKES; ++how)
            if (is_possible(schema, k, how))
                add_suspects(schema, k, how, list, n);
    return list;
}

/* ---- their words ------------------------------------------------------------------------------------------------- */

__attribute__((format(printf, 2, 3))) static void append(suspect *s, const char *format, ...) {
    const size_t at = strlen(s->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(s->text + at, SUSPECT_TEXT - at, format, arguments);
    va_end(arguments);
}

static void append_fault(const nqm_spec_schema *schema, const struct fault *f, suspect *s) {
    const nqm_spec_key *key = f->key < schema->n_keys ? &schema->keys[f->key] : NULL;
    /* Roughness is squared once by most models: the common names of the mistakes are those of shaders. */
    const bool is_squared = key && key->n == 1 && strstr(key->name, "oughness");
    const bool is_gloss = key && strstr(key->name, "loss");
    append(s, "%s%s", key ? key->name : "",
           !key                              ? nqm_mistake_words(f->how)
           : is_squared && f->how == SQUARED ? " is squared twice"
           : is_squared && f->how == ROOT    ? " is not squared"
           : is_gloss && f->how == LIMITED   ? " is lowered to at most"
                                             : property_mistakes[f->how].text);
    if (f->amount != 0)
        append(s, " %.3g", is_gloss ? 1 - f->amount : f->amount);
    else if (key)
        append(s, "%s",
               f->how == OF_BASE                    ? schema->keys[f->base].name
               : property_mistakes[f->how].channels ? property_mistakes[f->how].channels
                                                    : "");
}

void describe_suspect(const conform_kit *kit, suspect *s) {
    static const char *const names[] = {"red", "green", "blue"};
    *s->text = '\0';
    for (size_t i = 0; i < s->n_faults; ++i) {
        append(s, i ? ", and " : "");
        append_fault(&kit->model->schema, &s->faults[i], s);
    }
    for (size_t c = 0; s->mixes && c < 3; ++c) {
        append(s, *s->text ? ", and %s is" : "%s is", names[c]);
        for (size_t from = 0, n = 0; from < 3; ++from)
            if (fabs(s->channels[c][from]) > 0.005)
                append(s, n++ ? " + %.2g %s" : " %.2g %s", s->channels[c][from], names[from]);
    }
}

/* ---- their values ------------------------------------------------------------------------------------------------ */

static double changed(const nqm_spec_schema *schema, const nqm_spec_values *values, const struct fault *f, size_t c) {
    const nqm_spec_key *key = &schema->keys[f->key];
    const property_mistake *m = &property_mistakes[f->how];
    const double *v = values->v[f->key];
    if (f->how == IGNORED || f->how == ABSENT)
        return f->how == ABSENT ? 0 : key->fallback;
    if (f->how == LIMITED)
        return strstr(key->name, "loss") ? fmin(v[c], 1 - f->amount) : fmax(v[c], f->amount);
    const double wrong = f->how == OF_BASE ? values->v[f->base][c]
                         : m->channels     ? v[m->channels[c] == 'r'   ? 0
                                               : m->channels[c] == 'g' ? 1
                                                                       : 2]
                         : m->factor != 0  ? m->factor * v[c]
                                           : m->apply(v[c]);
    return fmin(fmax(wrong, key->low), key->high);
}

void sample_suspect(const conform_kit *kit, size_t set, const suspect *s, float *rgb) {
    const kit_set *of = &kit->sets[set];
    nqm_spec_values values = of->values;
    nqm_mistakes mistakes = {.made = 0};
    for (const struct fault *f = s->faults; f < s->faults + s->n_faults; ++f) {
        const nqm_spec_values before = values;
        for (size_t c = 0; c < 3 && f->key < kit->model->schema.n_keys; ++c)
            values.v[f->key][c] = changed(&kit->model->schema, &before, f, c);
        if (f->key < kit->model->schema.n_keys)
            continue;
        mistakes.made |= (uint64_t)1 << f->how;
        mistakes.exponent = f->how == NQM_MISTAKE_SCHLICK_EXPONENT ? f->amount : mistakes.exponent;
        mistakes.limit = f->how == NQM_MISTAKE_CLAMPED ? f->amount : mistakes.limit;
    }
    nqm_mistaken_eval(kit->model, &values, &mistakes, kit->n_directions, kit_directions(kit, of->turn, 0),
                      kit_directions(kit, of->turn, 1), rgb);
    for (float *v = rgb; s->mixes && v < rgb + 3 * kit->n_directions; v += 3) {
        const double red = (double)v[0], green = (double)v[1], blue = (double)v[2];
        for (size_t c = 0; c < 3; ++c)
            v[c] = (float)(s->channels[c][0] * red + s->channels[c][1] * green + s->channels[c][2] * blue);
    }
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
    for (struct fault *f = s->faults; f < s->faults + s->n_faults; ++f)
        for (double step = 1.5; f->amount != 0 && step > 1.004; step = sqrt(step)) {
            const double amounts[] = {f->amount, nqm_round_digits(f->amount, 2), f->amount * step, f->amount / step};
            suspect tries[] = {*s, *s, *s, *s};
            for (size_t i = 0; i < 4; ++i)
                tries[i].faults[f - s->faults].amount = amounts[i];
            sort_suspects(kit, values, 4, tries);
            *s = tries[0];
        }
}

/* Whether they differ in their amounts only. */
static bool is_same_kind(const suspect *a, const suspect *b) {
    bool is_same = a->n_faults == b->n_faults && a->mixes == b->mixes;
    for (size_t i = 0; i < a->n_faults && is_same; ++i)
        is_same = a->faults[i].key == b->faults[i].key && a->faults[i].how == b->faults[i].how;
    return is_same;
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
        while (k < kept && !is_same_kind(&found[k], &list[s]) && !are_equal(kit, &found[k], &list[s]))
            ++k;
        describe_suspect(kit, &list[s]);
        if (k == kept)
            found[kept++] = list[s];
        else if (!is_same_kind(&found[k], &list[s]))
            append(&found[k], "; or %s", list[s].text);
    }
    return kept;
}

/* Mix the channels of a suspect so that they come closest to the values: least squares of relative differences. Where it is no channel
 * that leaks into another, they remain. */
static void fit_channels(const conform_kit *kit, const float *values, suspect *s) {
    const size_t n = kit->n_directions;
    double a[3][3][4] = {{{0}}}; /* (channel) normal equations */
    float *rgb = allocate(3 * n, sizeof *rgb);
    for (size_t i = 0; i < kit->n_sets * n; ++i) {
        const float *v = rgb + 3 * (i % n);
        if (i % n == 0)
            sample_suspect(kit, i / n, s, rgb);
        for (size_t c = 0; c < 3 && isfinite(values[3 * i]); ++c) {
            const double value = (double)values[3 * i + c], weight = 1 / ((value + 0.003) * (value + 0.003));
            for (size_t p = 0; p < 3; ++p)
                for (size_t q = 0; q < 4; ++q)
                    a[c][p][q] += weight * (double)v[p] * (q < 3 ? (double)v[q] : value);
        }
    }
    free(rgb);
    bool leaks = false, is_plain = true;
    for (size_t c = 0; c < 3; ++c) {
        for (size_t p = 0; p < 3; ++p)
            for (size_t q = 0; q < 3; ++q)
                for (size_t k = 4; q != p && k-- > p;) /* column p last */
                    a[c][q][k] -= a[c][p][k] * a[c][q][p] / a[c][p][p];
        for (size_t p = 0; p < 3; ++p) {
            s->channels[c][p] = a[c][p][3] / a[c][p][p];
            leaks = leaks || (p != c && fabs(s->channels[c][p]) > 0.02);
            is_plain = is_plain && fabs(s->channels[c][p]) < 4;
        }
    }
    s->mixes = leaks && is_plain;
}

/* The best suspect of a sorted list with each of the others, and with mixed channels, as those alone; their number. */
static size_t list_pairs(const conform_kit *kit, const float *values, size_t n, const suspect *list, suspect *pairs) {
    for (size_t s = 0; s < n; ++s) {
        pairs[s] = list[0];
        if (list[0].n_faults && list[s].n_faults && s)
            pairs[s].faults[pairs[s].n_faults++] = list[s].faults[0];
    }
    pairs[n] = list[0];
    pairs[n + 1] = (suspect){.n_faults = 0};
    fit_channels(kit, values, &pairs[n]);
    fit_channels(kit, values, &pairs[n + 1]);
    return n + 2;
}

size_t find_suspects(const conform_kit *kit, const float *values, size_t n_found, suspect *found, double *none) {
    /* A second mistake is looked for where one leaves more than float32 does, and named if it explains most of that. Mixed channels
     * have nine amounts, and must explain more. */
    const double noise = 2e-4, explained = 0.3, explained_by_channels = 0.1;
    const size_t n_refined = 5;
    size_t n;
    suspect *list = list_suspects(kit, &n), *pairs = allocate(n + 2, sizeof *pairs);
    sort_suspects(kit, values, n, list);
    for (size_t s = 0; s < n; ++s)
        if (!list[s].n_faults)
            *none = list[s].left;
    for (size_t s = 0; *none > noise && s < n_refined; ++s)
        refine(kit, values, &list[s]);
    qsort(list, n, sizeof *list, by_left);
    if (*none <= noise) {
        n = 0;
    } else if (list[0].left > noise) {
        sort_suspects(kit, values, list_pairs(kit, values, n, list, pairs), pairs);
        refine(kit, values, &pairs[0]);
        if (pairs[0].left <
            (pairs[0].mixes ? explained_by_channels : explained) * list[0].left) { /* first, before the single ones */
            memmove(list + 1, list, (n - 1) * sizeof *list);
            list[0] = pairs[0];
        }
    }
    const size_t kept = keep_different(kit, n, list, 0.9 * *none, n_found, found);
    free(pairs);
    free(list);
    return kept;
}
