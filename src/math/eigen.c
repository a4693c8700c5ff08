/* SPDX-License-Identifier: MIT
 *
 * Eigenvectors of small symmetric matrices by cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, section
 * 8.5): accurate and reproducible on every machine, but too slow for large matrices.
 */
#include "math/math.h"

#include <math.h>

/* Rotate rows and columns i and j of a, and rows i and j of v, so that a(i, j) becomes 0. */
static void rotate(size_t n, double *a, double *v, size_t i, size_t j) {
    double t, c, s, tau = (a[j * n + j] - a[i * n + i]) / (2 * a[i * n + j]);
    t = (tau >= 0 ? 1 : -1) / (fabs(tau) + sqrt(1 + tau * tau));
    c = 1 / sqrt(1 + t * t);
    s = t * c;
    for (size_t k = 0; k < n; ++k) {
        double x = a[k * n + i], y = a[k * n + j];
        a[k * n + i] = c * x - s * y;
        a[k * n + j] = s * x + c * y;
    }
    double *rows[2] = {a, v};
    for (size_t m = 0; m < 2; ++m)
        for (size_t k = 0; k < n; ++k) {
            double x = rows[m][i * n + k], y = rows[m][j * n + k];
            rows[m][i * n + k] = c * x - s * y;
            rows[m][j * n + k] = s * x + c * y;
        }
}

static void swap_rows(size_t n, double *v, size_t i, size_t j) {
    for (size_t k = 0; k < n; ++k) {
        double x = v[i * n + k];
        v[i * n + k] = v[j * n + k];
        v[j * n + k] = x;
    }
}

void nqm_eigen_symmetric(size_t n, double *a, double *values, double *vectors) {
    enum { MAX_SWEEPS = 50 };
    double total = 0;
    for (size_t i = 0; i < n * n; ++i) {
        total += a[i] * a[i];
        vectors[i] = i % (n + 1) == 0;
    }
    double outside = total;
    for (int sweep = 0; sweep < MAX_SWEEPS && outside > 1e-30 * total; ++sweep) {
        outside = 0;
        for (size_t i = 0; i + 1 < n; ++i)
            for (size_t j = i + 1; j < n; ++j) {
                outside += a[i * n + j] * a[i * n + j];
                if (a[i * n + j] != 0)
                    rotate(n, a, vectors, i, j);
            }
    }
    for (size_t i = 0; i < n; ++i)
        values[i] = a[i * n + i];
    for (size_t i = 0; i < n; ++i) {
        size_t best = i;
        for (size_t j = i + 1; j < n; ++j)
            best = values[j] > values[best] ? j : best;
        double x = values[i];
        values[i] = values[best];
        values[best] = x;
        if (best != i)
            swap_rows(n, vectors, i, best);
    }
}
