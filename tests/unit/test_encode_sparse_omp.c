/* SPDX-License-Identifier: MIT
 *
 * Matching pursuit against an independent implementation step by step (tests/vectors/omp.py), and against the closed
 * form for an orthonormal dictionary; a sum of atoms is recovered exactly; linearly dependent atoms are skipped.
 */
#include "encode/encode.h"
#include "support/check.h"
#include "support/vectors.h"

enum { BLOCKS = 2, ATOMS = 14, LENGTH = 9, OMP_CHOSEN = 7 };

static double omp_atoms[ATOMS * LENGTH], omp_signals[BLOCKS * LENGTH], omp_coefficient[OMP_CHOSEN],
    omp_residual[OMP_CHOSEN];
static int64_t omp_index[OMP_CHOSEN];

static int read_vectors(void **state) {
    (void)state;
    get_vector("omp.safetensors", "atoms", sizeof omp_atoms, omp_atoms);
    get_vector("omp.safetensors", "signals", sizeof omp_signals, omp_signals);
    get_vector("omp.safetensors", "index", sizeof omp_index, omp_index);
    get_vector("omp.safetensors", "coefficient", sizeof omp_coefficient, omp_coefficient);
    get_vector("omp.safetensors", "residual", sizeof omp_residual, omp_residual);
    return 0;
}

static double dot(const double *a, const double *b) {
    double sum = 0;
    for (size_t i = 0; i < LENGTH; ++i)
        sum += a[i] * b[i];
    return sum;
}

typedef struct coded {
    size_t n, index[NQM_OMP_MAX_ATOMS];
    double coefficient[NQM_OMP_MAX_ATOMS];
    double residual; /* norm of the residual */
} coded;

static coded code(size_t n_atoms, const double *atoms, const double *signals, size_t max_atoms) {
    double gram[ATOMS * ATOMS], correlation[BLOCKS * ATOMS], scratch[BLOCKS * ATOMS], rest[BLOCKS * LENGTH];
    for (size_t i = 0; i < n_atoms; ++i) {
        for (size_t j = 0; j < n_atoms; ++j)
            gram[i * n_atoms + j] = dot(atoms + i * LENGTH, atoms + j * LENGTH);
        for (size_t b = 0; b < BLOCKS; ++b)
            correlation[b * n_atoms + i] = dot(atoms + i * LENGTH, signals + b * LENGTH);
    }
    const nqm_omp_problem problem = {BLOCKS, n_atoms, gram, correlation};
    coded c;
    c.n = nqm_omp(&problem, max_atoms, c.index, c.coefficient, scratch);
    for (size_t i = 0; i < BLOCKS * LENGTH; ++i)
        rest[i] = signals[i];
    for (size_t k = 0; k < c.n; ++k)
        for (size_t i = 0; i < LENGTH; ++i)
            rest[c.index[k] / n_atoms * LENGTH + i] -= c.coefficient[k] * atoms[c.index[k] % n_atoms * LENGTH + i];
    c.residual = sqrt(dot(rest, rest) + dot(rest + LENGTH, rest + LENGTH));
    return c;
}

TEST(every_step_is_that_of_the_definition) {
    for (size_t n = 1; n <= OMP_CHOSEN; ++n) {
        coded c = code(ATOMS, omp_atoms, omp_signals, n);
        assert_int_equal(c.n, n);
        for (size_t k = 0; k < n; ++k)
            assert_int_equal(c.index[k], omp_index[k]);
        assert_near(c.residual, omp_residual[n - 1], 1e-12);
    }
    coded c = code(ATOMS, omp_atoms, omp_signals, OMP_CHOSEN);
    for (size_t k = 0; k < OMP_CHOSEN; ++k)
        assert_near(c.coefficient[k], omp_coefficient[k], 1e-12);
}

/* For orthonormal atoms, the pursuit selects the largest inner products, which are the coefficients. */
TEST(orthonormal_atoms_are_sorted) {
    double atoms[LENGTH * LENGTH] = {0}, signals[BLOCKS * LENGTH];
    for (size_t i = 0; i < LENGTH; ++i) {
        atoms[i * LENGTH + i] = 1;
        signals[i] = i % 2 ? (double)i : -(double)i;
        signals[LENGTH + i] = 0.5 * (double)i + 0.25;
    }
    coded c = code(LENGTH, atoms, signals, 4);
    static const double expected[4] = {-8, 7, -6, 5};
    for (size_t k = 0; k < 4; ++k) {
        assert_int_equal(c.index[k], 8 - k);
        assert_near(c.coefficient[k], expected[k], 0);
    }
}

TEST(what_is_made_of_atoms_is_found) {
    double signals[BLOCKS * LENGTH];
    for (size_t i = 0; i < LENGTH; ++i) {
        signals[i] = 2 * omp_atoms[3 * LENGTH + i] - 0.5 * omp_atoms[11 * LENGTH + i];
        signals[LENGTH + i] = 0;
    }
    coded c = code(ATOMS, omp_atoms, signals, ATOMS);
    assert_true(c.residual < 1e-9 && c.n <= LENGTH);
    for (size_t k = 0; k < c.n; ++k)
        assert_true(c.index[k] < ATOMS); /* the second signal is zero: no atom for it */
}

TEST(dependent_atoms_are_passed_over) {
    double atoms[3 * LENGTH];
    for (size_t i = 0; i < LENGTH; ++i) {
        atoms[i] = atoms[LENGTH + i] = omp_atoms[i];
        atoms[2 * LENGTH + i] = omp_atoms[LENGTH + i];
    }
    coded c = code(3, atoms, omp_signals, 6);
    assert_int_equal(c.n, 4); /* two independent atoms per signal */
    for (size_t k = 0; k < c.n; ++k)
        assert_true(isfinite(c.coefficient[k]) && c.index[k] % 3 != 1);
}

TEST(nothing_needs_no_atom) {
    const double signals[BLOCKS * LENGTH] = {0};
    assert_int_equal(code(ATOMS, omp_atoms, signals, 5).n, 0);
}

TEST_FILE(read_vectors, NULL)
