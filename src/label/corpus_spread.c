/* SPDX-License-Identifier: MIT
 *
 * Selects tests by label: most random pairs of materials have nearly the same low JOD, and a metric learns little from many of
 * them. Values are removed one by one from the densest place until the requested number is left.
 */
#include "label/corpus.h"

#include <math.h>
#include <stdlib.h>

typedef struct value {
    double jod;
    size_t index;
} value;

static int by_jod(const void *a, const void *b) {
    const value *x = a, *y = b;
    if (x->jod != y->jod)
        return x->jod < y->jod ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

/* Distance of value i from its neighbours: the smaller one first; the ends have one neighbour. */
static void gaps(size_t n, const value *v, size_t i, double gap[2]) {
    double below = i > 0 ? v[i].jod - v[i - 1].jod : HUGE_VAL, above = i + 1 < n ? v[i + 1].jod - v[i].jod : HUGE_VAL;
    gap[0] = fmin(below, above);
    gap[1] = fmax(below, above);
}

/* The value with the nearest neighbour; of two such neighbours the one whose other neighbour is nearer. */
static size_t densest(size_t n, const value *v) {
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
    value *v = nqm_alloc(n, sizeof *v);
    size_t left = 0;
    if (!v)
        return nqm_fail_nomem(err, n * sizeof *v);
    for (size_t i = 0; i < n; ++i) {
        kept[i] = 0;
        if (!isnan(jod[i]))
            v[left++] = (value){jod[i], i};
    }
    if (left > 0)
        qsort(v, left, sizeof *v, by_jod);
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
