/* SPDX-License-Identifier: MIT
 *
 * Options described by tables: defaults, range checks, names, conversion to and from text.
 */
#include "base/options.h"

#include <math.h>

/* ---- values ------------------------------------------------------------------------------------------------------ */

static void *field_of(const nqm_option *o, const void *options) {
    return (char *)options + o->offset;
}

/* The value of a numeric, bool or enum field. */
static double number_at(const nqm_option *o, const void *field) {
    switch (o->kind) {
    case NQM_OPTION_DOUBLE:
        return o->scale != 0 ? nqm_round_digits(*(const double *)field / o->scale, 14) : *(const double *)field;
    case NQM_OPTION_SIZE:
    case NQM_OPTION_SIZES: /* one element of the list */
        return (double)*(const size_t *)field;
    case NQM_OPTION_U64:
        return (double)*(const uint64_t *)field;
    default:
        return *(const int *)field;
    }
}

static void store_number(const nqm_option *o, void *field, double value) {
    switch (o->kind) {
    case NQM_OPTION_DOUBLE:
        *(double *)field = o->scale != 0 ? o->scale * value : value;
        break;
    case NQM_OPTION_SIZE:
    case NQM_OPTION_SIZES:
        *(size_t *)field = (size_t)value;
        break;
    case NQM_OPTION_U64:
        *(uint64_t *)field = (uint64_t)value;
        break;
    default:
        *(int *)field = (int)value;
    }
}

static bool has_range(const nqm_option *o) {
    return o->min != 0 || o->max != 0;
}

static size_t count_words(const nqm_option *o) {
    size_t n = 0;
    while (o->words && o->words[n])
        ++n;
    return n;
}

static bool is_valid(const nqm_option *o, double value) {
    if (o->kind == NQM_OPTION_BOOL)
        return true;
    if (o->kind == NQM_OPTION_ENUM)
        return value >= 0 && value < (double)count_words(o) && *o->words[(size_t)value];
    return isfinite(value) && (!has_range(o) || (value >= o->min && value <= o->max));
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

bool nqm_option_is_flag(const nqm_option *o) {
    return o->kind == NQM_OPTION_BOOL && !o->words;
}

char *nqm_option_name(const nqm_option *o, char *text) {
    snprintf(text, NQM_OPTION_TEXT_MAX, "%s", o->name ? o->name : o->key);
    for (char *p = text; !o->name && *p; ++p)
        *p = *p == '_' ? '-' : *p;
    return text;
}

char *nqm_option_allowed(const nqm_option *o, char *text) {
    size_t n = count_words(o), at = 0;
    if (n) {
        for (size_t i = 0; i < n && at < NQM_OPTION_TEXT_MAX; ++i)
            if (*o->words[i])
                at += (size_t)snprintf(text + at, NQM_OPTION_TEXT_MAX - at, "%s%s",
                                       i == 0      ? ""
                                       : i + 1 < n ? ", "
                                                   : " or ",
                                       o->words[i]);
        return text;
    }
    char count[48] = "", range[80] = "";
    if (o->kind == NQM_OPTION_SIZES)
        snprintf(count, sizeof count, "up to %zu whole numbers with commas", o->max_sizes);
    if (has_range(o))
        snprintf(range, sizeof range, "%s from %g to %g", o->kind == NQM_OPTION_SIZES ? ", each" : "", o->min, o->max);
    snprintf(text, NQM_OPTION_TEXT_MAX, "%s%s",
             *count                         ? count
             : o->kind == NQM_OPTION_DOUBLE ? "a number"
             : o->kind == NQM_OPTION_TEXT   ? "a text"
                                            : "a whole number",
             range);
    return text;
}

char *nqm_option_format(const nqm_option *o, const void *options, char *text) {
    const void *field = field_of(o, options);
    text[0] = '\0';
    if (o->kind == NQM_OPTION_TEXT) {
        const char *value = *(const char *const *)field;
        snprintf(text, NQM_OPTION_TEXT_MAX, "%s", value ? value : "");
    } else if (o->kind == NQM_OPTION_SIZES) {
        const size_t *list = field;
        for (size_t i = 0, at = 0; i < list[0] && i < o->max_sizes && at < NQM_OPTION_TEXT_MAX; ++i)
            at += (size_t)snprintf(text + at, NQM_OPTION_TEXT_MAX - at, "%s%zu", i ? "," : "", list[i + 1]);
    } else if (o->words && is_valid(o, number_at(o, field))) {
        snprintf(text, NQM_OPTION_TEXT_MAX, "%s", o->words[(size_t)number_at(o, field)]);
    } else if (o->kind == NQM_OPTION_U64) {
        snprintf(text, NQM_OPTION_TEXT_MAX, "%llu", (unsigned long long)*(const uint64_t *)field);
    } else {
        nqm_format_double(text, NQM_OPTION_TEXT_MAX, number_at(o, field));
    }
    return text;
}

/* ---- setting ----------------------------------------------------------------------------------------------------- */

/* Index of the word that equals `text`, else of the only word that starts with `text` and an underscore, else -1. */
static int find_word(const nqm_option *o, const char *text) {
    const size_t n_text = strlen(text);
    int found = -1;
    for (int i = 0; n_text > 0 && o->words[i]; ++i) {
        if (strcmp(o->words[i], text) == 0)
            return i;
        if (strncmp(o->words[i], text, n_text) == 0 && o->words[i][n_text] == '_')
            found = found == -1 ? i : -2;
    }
    return found < 0 ? -1 : found;
}

/* Parse a number that is valid for the option at the start of `text`; *end_ret points after it. */
static bool parse_number(const nqm_option *o, const char *text, const char **end_ret, double *value_ret) {
    enum { DOUBLE_DIGITS = 53 };
    if (!nqm_parse_double(text, end_ret, value_ret) || !is_valid(o, *value_ret))
        return false;
    return o->kind == NQM_OPTION_DOUBLE ||
           (*value_ret >= 0 && *value_ret == floor(*value_ret) && *value_ret <= ldexp(1, DOUBLE_DIGITS));
}

static bool parse_list(const nqm_option *o, const char *text, size_t *list) {
    size_t n = 0;
    do {
        double value;
        if (n == o->max_sizes || !parse_number(o, text, &text, &value))
            return false;
        list[++n] = (size_t)value;
    } while (*text == ',' && ++text);
    if (*text)
        return false;
    list[0] = n;
    return true;
}

nqm_status nqm_option_set(const nqm_option *o, void *options, const char *text, nqm_error *err) {
    void *field = field_of(o, options);
    const char *end = "";
    double value = 0;
    bool is_good = true;
    if (o->kind == NQM_OPTION_TEXT) {
        *(const char **)field = text;
        return NQM_OK;
    }
    if (o->kind == NQM_OPTION_SIZES) {
        is_good = parse_list(o, text, field);
    } else if (o->words) {
        value = find_word(o, text);
        is_good = value >= 0;
    } else {
        is_good = parse_number(o, text, &end, &value) && *end == '\0';
    }
    if (is_good && o->kind != NQM_OPTION_SIZES)
        store_number(o, field, value);
    if (is_good)
        return NQM_OK;
    char name[NQM_OPTION_TEXT_MAX], allowed[NQM_OPTION_TEXT_MAX];
    nqm_nearest nearest = nqm_nearest_begin(text);
    for (size_t i = 0; i < count_words(o); ++i)
        nqm_nearest_add(&nearest, o->words[i]);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s needs %s, not '%.80s'%s", nqm_option_name(o, name),
                    nqm_option_allowed(o, allowed), text, nearest.advice);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static nqm_status find_recipe(const nqm_option_table *t, const char *recipe, size_t *index_ret, nqm_error *err) {
    const nqm_option names = {.kind = NQM_OPTION_ENUM, .words = t->recipes};
    char allowed[NQM_OPTION_TEXT_MAX];
    for (*index_ret = 0; recipe && t->recipes[*index_ret]; ++*index_ret)
        if (strcmp(t->recipes[*index_ret], recipe) == 0)
            return NQM_OK;
    return recipe ? nqm_fail(err, NQM_ERR_ARG, -1, "there is no recipe '%.40s'; give %s", recipe,
                             nqm_option_allowed(&names, allowed))
                  : NQM_OK;
}

nqm_status nqm_options_begin(const nqm_option_table *t, const char *recipe, void *options, nqm_error *err) {
    size_t index = 0;
    nqm_status status = t->recipes ? find_recipe(t, recipe, &index, err) : NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < t->n; ++i) {
        const nqm_option *o = &t->rows[i];
        const char *value = o->values[index] ? o->values[index] : o->values[0];
        if (value)
            status = nqm_option_set(o, options, value, err);
        else if (o->kind == NQM_OPTION_TEXT)
            *(const char **)field_of(o, options) = NULL;
        else
            store_number(o, field_of(o, options), 0);
    }
    return status;
}

nqm_status nqm_options_check(const nqm_option_table *t, const void *options, nqm_error *err) {
    char allowed[NQM_OPTION_TEXT_MAX];
    for (size_t i = 0; i < t->n; ++i) {
        const nqm_option *o = &t->rows[i];
        const size_t *list = field_of(o, options);
        if (o->kind == NQM_OPTION_TEXT)
            continue;
        const bool is_list = o->kind == NQM_OPTION_SIZES;
        if (is_list && (list[0] < 1 || list[0] > o->max_sizes))
            return nqm_fail(err, NQM_ERR_ARG, -1, "option %s has %zu values; it must have 1 to %zu", o->key, list[0],
                            o->max_sizes);
        for (size_t k = 0; k < (is_list ? list[0] : 1); ++k) {
            const double value = number_at(o, list + (is_list ? k + 1 : 0));
            if (!is_valid(o, value))
                return nqm_fail(err, NQM_ERR_ARG, -1, "option %s is %g; it must be %s", o->key, value,
                                nqm_option_allowed(o, allowed));
        }
    }
    return NQM_OK;
}

const nqm_option *nqm_option_by_key(const nqm_option_table *t, const char *key) {
    for (size_t i = 0; i < t->n; ++i)
        if (strcmp(t->rows[i].key, key) == 0)
            return &t->rows[i];
    return NULL;
}

static bool equal(const char *a, const char *b, size_t n_b) {
    return strlen(a) == n_b && memcmp(a, b, n_b) == 0;
}

const nqm_option *nqm_option_by_name(const nqm_option_table *t, const char *name, size_t n_name, bool *is_off_ret) {
    char on[NQM_OPTION_TEXT_MAX], off[NQM_OPTION_TEXT_MAX + 3];
    for (size_t i = 0; n_name > 0 && i < t->n; ++i) {
        const nqm_option *o = &t->rows[i];
        nqm_option_name(o, on);
        snprintf(off, sizeof off, "%s%s", o->off_name ? "" : "no-", o->off_name ? o->off_name : on);
        *is_off_ret = nqm_option_is_flag(o) && *on && equal(off, name, n_name);
        if (*is_off_ret || equal(on, name, n_name))
            return o;
    }
    return NULL;
}
