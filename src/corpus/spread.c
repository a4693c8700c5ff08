/* SPDX-License-Identifier: MIT
 *
 * Selects tests by label: most random pairs of materials have nearly the same low JOD, and a metric learns little from many of
 * them. Values are removed one by one from the densest place until the requested number is left.
 */
#include "corpus/corpus.h"
#include "math/math.h"

#include <math.h>
#include <stdlib.h>

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
