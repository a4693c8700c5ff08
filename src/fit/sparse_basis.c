/* SPDX-License-Identifier: MIT
 *
 * The separable bases: along each coordinate the directions in which the tables vary most (higher-order singular value
 * decomposition: De Lathauwer et al. 2000, DOI 10.1137/S0895479896305696).
 */
#include "fit/sparse.h"
#include "math/math.h"

enum { H = NQM_SPARSE_H, D = NQM_SPARSE_D, P = NQM_SPARSE_P, CELLS = NQM_SPARSE_CELLS };

/* Of which coordinate: `n` nodes, `stride` cells apart. */
typedef struct coordinate {
    size_t n, stride, n_kept;
} coordinate;

/* Add the products of all pairs of slices of a table: matrix (n, n), lower triangle. */
static void add_products(const coordinate *c, const float *table, double *matrix) {
    for (size_t i = 0; i < c->n; ++i)
        for (size_t j = 0; j <= i; ++j) {
            double sum = 0;
            for (size_t outer = 0; outer < CELLS; outer += c->n * c->stride)
                for (size_t inner = 0; inner < c->stride; ++inner)
                    sum += (double)table[outer + i * c->stride + inner] * (double)table[outer + j * c->stride + inner];
            matrix[i * c->n + j] += sum;
        }
}

static nqm_status learn(const coordinate *c, size_t n_tables, const float *tables, float *basis, nqm_error *err) {
    double *matrix = nqm_alloc(2 * c->n * c->n + c->n, sizeof *matrix);
    if (!matrix)
        return nqm_fail_nomem(err, 2 * c->n * c->n * sizeof *matrix);
    double *vectors = matrix + c->n * c->n, *values = vectors + c->n * c->n;
    for (size_t t = 0; t < n_tables; ++t)
        add_products(c, tables + t * CELLS, matrix);
    for (size_t i = 0; i < c->n; ++i)
        for (size_t j = 0; j < i; ++j)
            matrix[j * c->n + i] = matrix[i * c->n + j];
    nqm_eigen_symmetric(c->n, matrix, values, vectors);
    for (size_t i = 0; i < c->n_kept * c->n; ++i)
        basis[i] = (float)vectors[i];
    nqm_free(matrix);
    return NQM_OK;
}

nqm_status nqm_sparse_bases_learn(size_t n_tables, const float *tables, nqm_sparse_bases *bases, nqm_error *err) {
    nqm_status status = learn(&(coordinate){H, D * P, NQM_SPARSE_BASIS_H}, n_tables, tables, bases->h, err);
    if (status == NQM_OK)
        status = learn(&(coordinate){D, P, NQM_SPARSE_BASIS_D}, n_tables, tables, bases->d, err);
    if (status == NQM_OK)
        status = learn(&(coordinate){P, 1, NQM_SPARSE_BASIS_P}, n_tables, tables, bases->p, err);
    return status;
}
