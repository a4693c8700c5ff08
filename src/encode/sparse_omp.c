/* SPDX-License-Identifier: MIT
 *
 * Orthogonal matching pursuit; needs the inner products of atoms and signals only, not the vectors.
 */
#include "encode/encode.h"

#include <math.h>
#include <string.h>

/* Row k of the packed lower triangle. */
static double *row_of(double *factor, size_t k) {
    return factor + k * (k + 1) / 2;
}

static double product(const nqm_omp_problem *p, size_t i, size_t j) {
    bool same_block = i / p->n_atoms == j / p->n_atoms;
    return same_block ? p->gram[i % p->n_atoms * p->n_atoms + j % p->n_atoms] : 0;
}

/* Add atom `next` to the Cholesky factor of the n chosen atoms; false if it is linearly dependent on them. */
static bool extend(const nqm_omp_problem *p, size_t n, const size_t *index, size_t next, double *factor) {
    const double min_new = 1e-8; /* squared length of the part orthogonal to the chosen atoms */
    double *row = row_of(factor, n), rest = product(p, next, next);
    for (size_t k = 0; k < n; ++k) {
        const double *above = row_of(factor, k);
        double sum = product(p, next, index[k]);
        for (size_t j = 0; j < k; ++j)
            sum -= above[j] * row[j];
        row[k] = sum / above[k];
        rest -= row[k] * row[k];
    }
    if (rest < min_new)
        return false;
    row[n] = sqrt(rest);
    return true;
}

/* Coefficients of the n chosen atoms: factor factor^T coefficient = their correlations. */
static void solve(const nqm_omp_problem *p, size_t n, const size_t *index, double *factor, double *coefficient) {
    for (size_t k = 0; k < n; ++k) {
        const double *row = row_of(factor, k);
        double sum = p->correlation[index[k]];
        for (size_t j = 0; j < k; ++j)
            sum -= row[j] * coefficient[j];
        coefficient[k] = sum / row[k];
    }
    for (size_t k = n; k-- > 0;) {
        double sum = coefficient[k];
        for (size_t j = k + 1; j < n; ++j)
            sum -= row_of(factor, j)[k] * coefficient[j];
        coefficient[k] = sum / row_of(factor, k)[k];
    }
}

/* Correlations of the atoms with the residual; 0 for chosen and linearly dependent atoms. */
static void update(const nqm_omp_problem *p, size_t n, const size_t *index, const double *coefficient,
                   const bool *closed, double *left) {
    size_t n_all = p->n_blocks * p->n_atoms;
    memcpy(left, p->correlation, n_all * sizeof *left);
    for (size_t k = 0; k < n; ++k) {
        const double *gram = p->gram + index[k] % p->n_atoms * p->n_atoms;
        double *block = left + index[k] / p->n_atoms * p->n_atoms;
        for (size_t j = 0; j < p->n_atoms; ++j)
            block[j] -= coefficient[k] * gram[j];
    }
    for (size_t i = 0; i < n_all; ++i)
        if (closed[i])
            left[i] = 0;
}

static size_t largest(size_t n, const double *values) {
    size_t best = 0;
    for (size_t i = 1; i < n; ++i)
        if (fabs(values[i]) > fabs(values[best]))
            best = i;
    return best;
}

size_t nqm_omp(const nqm_omp_problem *p, size_t max_atoms, size_t *index, double *coefficient, double *scratch) {
    const double tolerance = 1e-10; /* relative to the first correlation */
    double factor[NQM_OMP_MAX_ATOMS * (NQM_OMP_MAX_ATOMS + 1) / 2], first = 0;
    bool closed[NQM_OMP_MAX_BLOCKS * NQM_OMP_MAX_DICTIONARY] = {false};
    size_t n = 0, n_all = p->n_blocks * p->n_atoms;
    memcpy(scratch, p->correlation, n_all * sizeof *scratch);
    while (n < max_atoms) {
        size_t next = largest(n_all, scratch);
        double match = fabs(scratch[next]);
        first = n == 0 ? match : first;
        if (!(match > tolerance * first))
            break;
        closed[next] = true;
        if (!extend(p, n, index, next, factor)) {
            scratch[next] = 0;
            continue;
        }
        index[n++] = next;
        solve(p, n, index, factor, coefficient);
        update(p, n, index, coefficient, closed, scratch);
    }
    return n;
}
