/* SPDX-License-Identifier: MIT
 *
 * Selects pairs by label: most random pairs of materials have nearly the same low JOD, and a metric learns little from many of
 * them. Values are removed one by one from the densest place until the requested number is left.
 */
#include "corpus/corpus.h"
#include "math/math.h"
#include "percept/percept.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Distance of value i from its neighbours: the smaller one first; the ends have one neighbour. */
static void gaps(size_t n, const nqm_indexed *v, size_t i, double gap[2]) {
    double below = i > 0 ? v[i].value - v[i - 1].value : HUGE_VAL,
           above = i + 1 < n ? v[i + 1].value - v[i].value : HUGE_VAL;
    gap[0] = fmin(below, above);
    gap[1] = fmax(below, above);
}

/* The value with the nearest neighbour; of two such neighbours the one whose other neighbour is nearer. */
static size_t densest(size_t n, const nqm_indexed *v) {
    size_t found = 0;
    double least[2] = {HUGE_VAL, HUGE_VAL};
    for (size_t i = 0; i < n; ++i) {
        double gap[2];
        gaps(n, v, i, gap);
        if (gap[0] < least[0] || (gap[0] == least[0] && gap[1] < least[1])) {
            found = i;
            least[0] = gap[0];
            least[1] = gap[1];
        }
    }
    return found;
}

nqm_status nqm_corpus_spread(size_t n, const double *jod, size_t n_kept, uint8_t *kept, nqm_error *err) {
    nqm_indexed *v = nqm_alloc(n, sizeof *v);
    size_t left = 0;
    if (!v)
        return nqm_fail_nomem(err, n * sizeof *v);
    for (size_t i = 0; i < n; ++i) {
        kept[i] = 0;
        if (!isnan(jod[i]))
            v[left++] = (nqm_indexed){jod[i], i};
    }
    if (left > 0)
        qsort(v, left, sizeof *v, nqm_compare_indexed);
    while (left > n_kept) {
        size_t gap = densest(left, v);
        --left;
        for (size_t i = gap; i < left; ++i)
            v[i] = v[i + 1];
    }
    for (size_t i = 0; i < left; ++i)
        kept[v[i].index] = 1;
    nqm_free(v);
    return NQM_OK;
}

nqm_status nqm_corpus_parse_keep(const char *keep, size_t *n_name_ret, size_t *n_kept_ret, nqm_error *err) {
    const char *equals = keep ? strrchr(keep, '=') : NULL, *end;
    double n = 0;
    *n_name_ret = *n_kept_ret = 0;
    if (!keep)
        return NQM_OK;
    if (!equals || equals == keep || !nqm_parse_double(equals + 1, &end, &n) || *end || !(n >= 1 && n <= 1e6) ||
        n != floor(n))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "keep needs the form FAMILY=N with a whole number from 1 to 1000000, not '%s'", keep);
    *n_name_ret = (size_t)(equals - keep);
    *n_kept_ret = (size_t)n;
    return NQM_OK;
}

/* The rows of a family of one reference, and scratch. */
typedef struct selection {
    size_t *index; /* (n_rows); owns the block */
    double *jod;
    uint8_t *kept;
} selection;

static nqm_status select_of(nqm_corpus *c, const nqm_corpus_ref *ref, const selection *s, nqm_error *err) {
    const nqm_curve curve = nqm_curve_published;
    size_t n = 0;
    for (size_t row = ref->first_row; row < ref->first_row + ref->n_rows; ++row) {
        const char *name = c->list.rows[row].family;
        if (strlen(name) != c->n_keep_name || strncmp(name, c->options->keep, c->n_keep_name) != 0)
            continue;
        s->jod[n] = c->failures[row] ? NAN : nqm_curve_jod(&curve, c->label[row].delta_e);
        s->index[n++] = row;
    }
    nqm_status status = n > 0 ? nqm_corpus_spread(n, s->jod, c->n_keep, s->kept, err) : NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        c->kept[s->index[i]] = s->kept[i];
    return status;
}

nqm_status nqm_corpus_select(nqm_corpus *c, nqm_error *err) {
    selection s = {0};
    const size_t n = c->list.n_rows;
    for (size_t row = 0; row < n; ++row)
        c->kept[row] = !c->failures[row];
    if (c->n_keep_name == 0)
        return NQM_OK;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s.index, n, sizeof *s.index}, {&s.jod, n, sizeof *s.jod}, {&s.kept, n, 1}), err);
    for (size_t r = 0; status == NQM_OK && r < c->list.n_refs; ++r)
        status = select_of(c, &c->list.refs[r], &s, err);
    nqm_free(s.index);
    return status;
}
