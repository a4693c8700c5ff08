/* SPDX-License-Identifier: MIT
 *
 * Lists of strings and the nearest of several names (base.h).
 */
#include "base/base.h"

nqm_status nqm_names_add(nqm_names *names, const char *name, size_t n_bytes, nqm_error *err) {
    size_t *start = nqm_grow(names->start, &names->max_n, names->n + 1, sizeof *start);
    names->start = start ? start : names->start;
    char *text = start ? nqm_grow(names->text, &names->max_text, names->n_text + n_bytes + 1, 1) : NULL;
    if (!text)
        return nqm_fail_nomem(err, n_bytes);
    names->text = text;
    names->start[names->n++] = names->n_text;
    memcpy(names->text + names->n_text, name, n_bytes);
    names->text[names->n_text + n_bytes] = '\0';
    names->n_text += n_bytes + 1;
    return NQM_OK;
}

nqm_status nqm_names_intern(nqm_names *names, const char *name, size_t n_bytes, uint32_t *index_ret, nqm_error *err) {
    size_t i = names->n;
    for (; i-- > 0;)
        if (strncmp(nqm_name(names, i), name, n_bytes) == 0 && nqm_name(names, i)[n_bytes] == '\0')
            break;
    *index_ret = (uint32_t)(i < names->n ? i : names->n);
    return i < names->n ? NQM_OK : nqm_names_add(names, name, n_bytes, err);
}

void nqm_names_free(nqm_names *names) {
    nqm_free(names->start);
    nqm_free(names->text);
    *names = (nqm_names){0};
}

enum { MAX_LENGTH = 40 };

static char lower(char c) {
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

static char fold(char c) {
    return c == '_' ? '-' : lower(c);
}

/* Edit distance with exchanges of neighbours; a and b have at most MAX_LENGTH characters. d[i][j]: of the first i characters
 * of a to the first j of b. */
static size_t distance(const char *a, const char *b) {
    size_t d[MAX_LENGTH + 1][MAX_LENGTH + 1];
    const size_t n_a = strlen(a), n_b = strlen(b);
    for (size_t i = 0; i <= n_a; ++i)
        for (size_t j = 0; j <= n_b; ++j) {
            d[i][j] = i + j;
            if (i == 0 || j == 0)
                continue;
            const bool equal = fold(a[i - 1]) == fold(b[j - 1]);
            d[i][j] = nqm_smaller(d[i - 1][j - 1] + !equal, nqm_smaller(d[i - 1][j], d[i][j - 1]) + 1);
            if (i > 1 && j > 1 && fold(a[i - 1]) == fold(b[j - 2]) && fold(a[i - 2]) == fold(b[j - 1]))
                d[i][j] = nqm_smaller(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[n_a][n_b];
}

nqm_nearest nqm_nearest_begin(const char *wanted) {
    size_t n = strlen(wanted), limit = n < 6 ? 1 : n / 3;
    return (nqm_nearest){.wanted = wanted, .distance = nqm_smaller(limit, 4) + 1};
}

void nqm_nearest_add(nqm_nearest *nearest, const char *name) {
    if (strlen(name) > MAX_LENGTH || strlen(nearest->wanted) > MAX_LENGTH)
        return;
    const size_t d = distance(nearest->wanted, name);
    if (d >= nearest->distance)
        return;
    nearest->distance = d;
    snprintf(nearest->advice, sizeof nearest->advice, " (did you mean '%s'?)", name);
}

bool nqm_name_ends_in(const char *path, const char *suffix) {
    size_t n = strlen(path), n_suffix = strlen(suffix);
    return n > n_suffix && nqm_equal_any_case(path + n - n_suffix, suffix, n_suffix);
}

bool nqm_equal_any_case(const char *a, const char *b, size_t n) {
    size_t i = 0;
    while (i < n && a[i] && lower(a[i]) == lower(b[i]))
        ++i;
    return i == n || lower(a[i]) == lower(b[i]);
}
