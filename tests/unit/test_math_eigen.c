/* SPDX-License-Identifier: MIT
 *
 * Eigenvectors: the second-difference matrix, whose eigenvalues are known in closed form, and a random matrix rebuilt
 * from its eigenvectors.
 */
#include "math/math.h"
#include "support/check.h"

TEST(second_difference) {
    enum { N = 12 };
    double a[N * N] = {0}, values[N], vectors[N * N];
    for (size_t i = 0; i < N; ++i) {
        a[i * N + i] = 2;
        if (i > 0)
            a[i * N + i - 1] = a[(i - 1) * N + i] = -1;
    }
    nqm_eigen_symmetric(N, a, values, vectors);
    for (size_t k = 0; k < N; ++k)
        assert_near(values[k], 2 - 2 * cos((double)(N - k) * NQM_PI / (N + 1)), 1e-13);
}

TEST(vectors_give_the_matrix_back) {
    enum { N = 30 };
    static double a[N * N], given[N * N], values[N], v[N * N];
    nqm_rng rng = nqm_rng_make(3, 0);
    for (size_t i = 0; i < N; ++i)
        for (size_t j = 0; j <= i; ++j)
            given[i * N + j] = given[j * N + i] = a[i * N + j] = a[j * N + i] = nqm_rng_normal(&rng);
    nqm_eigen_symmetric(N, a, values, v);
    for (size_t i = 0; i < N; ++i)
        for (size_t j = 0; j < N; ++j) {
            double sum = 0, product = 0;
            for (size_t k = 0; k < N; ++k) {
                sum += values[k] * v[k * N + i] * v[k * N + j];
                product += v[i * N + k] * v[j * N + k];
            }
            assert_near(sum, given[i * N + j], 1e-12);
            assert_near(product, i == j, 1e-13);
        }
    for (size_t k = 1; k < N; ++k)
        assert_true(values[k - 1] >= values[k]);
}

TEST(nothing_has_no_directions) {
    double a[4] = {0}, values[2], v[4];
    nqm_eigen_symmetric(2, a, values, v);
    assert_true(values[0] == 0 && values[1] == 0 && v[0] == 1 && v[1] == 0 && v[3] == 1);
}
