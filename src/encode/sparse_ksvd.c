/* SPDX-License-Identifier: MIT
 *
 * Approximate K-SVD: each step codes all signals by matching pursuit, then updates the atoms one by one, together with
 * their coefficients, on the residual of the other atoms.
 */
#include "encode/sparse.h"

#include <math.h>
#include <string.h>

/* Atoms per signal during learning: enough for sums, few enough that each atom stays a typical material. */
enum { CORE = NQM_SPARSE_CORE, N_CODE = 8 };

typedef struct code {
    size_t n, atom[N_CODE];
    double coefficient[N_CODE];
} code;

typedef struct learning {
    size_t n_signals, n_atoms;
    const double *signals; /* (n_signals, CORE) */
    double *atoms;         /* (n_atoms, CORE) */
    double *gram;          /* (n_atoms, n_atoms) */
    double *residual;      /* (n_signals, CORE) */
    double *scratch;       /* (n_signals, 2, n_atoms) */
    code *codes;           /* (n_signals) */
    bool *taken;           /* (n_signals) its residual has become an atom in this step */
} learning;

static void add(double factor, const double *a, double *sum) {
    for (size_t i = 0; i < CORE; ++i)
        sum[i] += factor * a[i];
}

/* Scale to unit length; false for a zero vector. */
static bool normalise(double *a) {
    double length = sqrt(nqm_sparse_dot(a, a));
    if (!(length > 0))
        return false;
    for (size_t i = 0; i < CORE; ++i)
        a[i] /= length;
    return true;
}

/* ---- the parts of a step ----------------------------------------------------------------------------------------- */

static void code_signal(void *user, size_t s) {
    learning *l = user;
    code *c = &l->codes[s];
    double *correlation = l->scratch + 2 * s * l->n_atoms, *residual = l->residual + s * CORE;
    for (size_t k = 0; k < l->n_atoms; ++k)
        correlation[k] = nqm_sparse_dot(l->atoms + k * CORE, l->signals + s * CORE);
    const nqm_omp_problem problem = {1, l->n_atoms, l->gram, correlation};
    c->n = nqm_omp(&problem, N_CODE, c->atom, c->coefficient, correlation + l->n_atoms);
    memcpy(residual, l->signals + s * CORE, CORE * sizeof *residual);
    for (size_t i = 0; i < c->n; ++i)
        add(-c->coefficient[i], l->atoms + c->atom[i] * CORE, residual);
}

/* The coefficient of atom k in a code, or NULL. */
static double *coefficient_of(code *c, size_t k) {
    for (size_t i = 0; i < c->n; ++i)
        if (c->atom[i] == k)
            return &c->coefficient[i];
    return NULL;
}

/* Replace an unused atom by the largest residual of any signal. */
static void replace_atom(learning *l, double *atom) {
    size_t worst = l->n_signals;
    double most = 0;
    for (size_t s = 0; s < l->n_signals; ++s) {
        double left = l->taken[s] ? 0 : nqm_sparse_dot(l->residual + s * CORE, l->residual + s * CORE);
        if (left > most) {
            most = left;
            worst = s;
        }
    }
    if (worst == l->n_signals)
        return;
    l->taken[worst] = true;
    memcpy(atom, l->residual + worst * CORE, CORE * sizeof *atom);
    (void)normalise(atom);
}

/* One step of the power method on the signals that use atom k, minus the contributions of the other atoms. */
static void improve_atom(learning *l, size_t k) {
    double *atom = l->atoms + k * CORE, better[CORE] = {0};
    bool used = false;
    for (size_t s = 0; s < l->n_signals; ++s) {
        const double *coefficient = coefficient_of(&l->codes[s], k);
        if (!coefficient)
            continue;
        used = true;
        add(*coefficient, l->residual + s * CORE, better);
        add(*coefficient * *coefficient, atom, better);
    }
    if (!used || !normalise(better)) {
        replace_atom(l, atom);
        return;
    }
    for (size_t s = 0; s < l->n_signals; ++s) {
        double *coefficient = coefficient_of(&l->codes[s], k);
        if (!coefficient)
            continue;
        add(*coefficient, atom, l->residual + s * CORE);
        *coefficient = nqm_sparse_dot(better, l->residual + s * CORE);
        add(-*coefficient, better, l->residual + s * CORE);
    }
    memcpy(atom, better, sizeof better);
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

/* Initial atoms: signals drawn without replacement, with probability proportional to their length. */
static size_t begin(learning *l, size_t n_max, uint64_t seed, double *length) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    double longest = 0;
    for (size_t s = 0; s < l->n_signals; ++s) {
        length[s] = sqrt(nqm_sparse_dot(l->signals + s * CORE, l->signals + s * CORE));
        longest = fmax(longest, length[s]);
    }
    for (size_t s = 0; s < l->n_signals; ++s) /* the colour channels of grey materials are no atoms */
        length[s] = length[s] > 1e-6 * longest ? length[s] : 0;
    size_t n = 0;
    for (; n < n_max; ++n) {
        double total = 0;
        for (size_t s = 0; s < l->n_signals; ++s)
            total += length[s];
        double point = nqm_rng_uniform(&rng) * total;
        size_t chosen = l->n_signals;
        for (size_t s = 0; s < l->n_signals; ++s)
            if (length[s] > 0 && point >= 0) {
                chosen = s;
                point -= length[s];
            }
        if (chosen == l->n_signals)
            break;
        length[chosen] = 0;
        memcpy(l->atoms + n * CORE, l->signals + chosen * CORE, CORE * sizeof *l->atoms);
        (void)normalise(l->atoms + n * CORE);
    }
    return n;
}

static nqm_status run(learning *l, size_t n_steps, nqm_ticker *ticker, nqm_error *err) {
    for (size_t step = 0; step < n_steps; ++step) {
        nqm_sparse_gram(l->n_atoms, l->atoms, l->gram);
        nqm_parallel_for(l->n_signals, code_signal, l);
        memset(l->taken, 0, l->n_signals * sizeof *l->taken);
        for (size_t k = 0; k < l->n_atoms; ++k)
            improve_atom(l, k);
        if (nqm_tick(ticker, "dictionary", (double)(step + 1), (double)n_steps))
            return nqm_fail(err, NQM_ERR_CANCELLED, -1, "learning was stopped");
    }
    return NQM_OK;
}

nqm_status nqm_sparse_ksvd(size_t n_signals, const double *signals, const nqm_learn_options *options,
                           nqm_ticker *ticker, size_t *n_atoms_ret, double *atoms, nqm_error *err) {
    size_t n_max = *n_atoms_ret;
    learning l = {.n_signals = n_signals, .signals = signals, .atoms = atoms};
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&l.gram, n_max, n_max * sizeof(double)}, {&l.residual, n_signals, CORE * sizeof(double)},
                   {&l.scratch, n_signals, 2 * n_max * sizeof(double)}, {&l.codes, n_signals, sizeof(code)},
                   {&l.taken, n_signals, sizeof(bool)}),
        err);
    if (status == NQM_OK) {
        l.n_atoms = begin(&l, n_max, options->seed, l.scratch);
        if (l.n_atoms == 0)
            status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the references are all equal: no atoms can be learned");
    }
    if (status == NQM_OK)
        status = run(&l, options->n_steps, ticker, err);
    *n_atoms_ret = l.n_atoms;
    nqm_free(l.gram);
    return status;
}
