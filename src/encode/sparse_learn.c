/* SPDX-License-Identifier: MIT
 *
 * The learning of the dictionary: tables of all references, a typical material (their median), the separable bases, and
 * the atoms by K-SVD.
 */
#include "encode/sparse.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { CELLS = NQM_SPARSE_CELLS, CORE = NQM_SPARSE_CORE, N_ATOMS = 128, DEFAULT_STEPS = 40 };

typedef struct learning {
    size_t n;
    const nqm_brdf *const *refs; /* (n) */
    nqm_sparse_grid grid;
    float *tables;       /* (n, 3, CELLS); owns the block of the arrays */
    double *cores;       /* (n, 3, CORE) */
    nqm_status *outcome; /* (n) of sampling */
    nqm_error *errors;   /* (n) */
    nqm_sparse_dictionary *dictionary;
    double *atoms; /* (N_ATOMS, CORE) */
} learning;

static nqm_status alloc_learning(learning *l, nqm_error *err) {
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&l->tables, l->n, 3 * CELLS * sizeof *l->tables}, {&l->cores, l->n, 3 * CORE * sizeof *l->cores},
                   {&l->outcome, l->n, sizeof *l->outcome}, {&l->errors, l->n, sizeof *l->errors},
                   {&l->atoms, N_ATOMS, CORE * sizeof *l->atoms}),
        err);
    if (status == NQM_OK)
        status = nqm_sparse_dictionary_create(N_ATOMS, &l->dictionary, err);
    return status == NQM_OK ? nqm_sparse_grid_make(&l->grid, err) : status;
}

static void release(learning *l) {
    nqm_free(l->tables);
    nqm_free(l->dictionary);
    nqm_free(l->grid.hd);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* References first .. first + CHUNK; progress is reported after each chunk. */
enum { CHUNK = 4 };
typedef struct chunk {
    learning *l;
    size_t first;
} chunk;

static void sample_one(void *user, size_t i) {
    chunk *c = user;
    size_t r = c->first + i, n_valid;
    learning *l = c->l;
    l->outcome[r] = nqm_sparse_sample(&l->grid, l->refs[r], l->tables + r * 3 * CELLS, &n_valid, &l->errors[r]);
}

static nqm_status sample_all(learning *l, nqm_ticker *ticker, nqm_error *err) {
    for (size_t first = 0; first < l->n; first += CHUNK) {
        size_t n = l->n - first < CHUNK ? l->n - first : CHUNK;
        nqm_parallel_for(n, sample_one, &(chunk){l, first});
        for (size_t r = first; r < first + n; ++r)
            if (l->outcome[r] != NQM_OK)
                return nqm_fail(err, l->outcome[r], -1, "%s", l->errors[r].message);
        if (nqm_tick(ticker, "references", (double)(first + n), (double)l->n))
            return nqm_fail(err, NQM_ERR_CANCELLED, -1, "learning was stopped");
    }
    return NQM_OK;
}

/* The median over references and channels, cell by cell; 0 where none has a value. */
static nqm_status find_typical(const learning *l, nqm_error *err) {
    double *values = nqm_alloc(3 * l->n, sizeof *values);
    if (!values)
        return nqm_fail_nomem(err, 3 * l->n * sizeof *values);
    for (size_t i = 0; i < l->grid.n; ++i) {
        size_t cell = l->grid.cell[i], n_values = 0;
        for (size_t t = 0; t < 3 * l->n; ++t) {
            float value = l->tables[t * CELLS + cell];
            if (!isnan(value))
                values[n_values++] = (double)value;
        }
        l->dictionary->typical[cell] = n_values ? (float)nqm_quantile(n_values, values, 0.5) : 0;
    }
    nqm_free(values);
    return NQM_OK;
}

static void map_one(void *user, size_t r) {
    learning *l = user;
    nqm_sparse_map(&l->grid, l->dictionary->typical, l->tables + r * 3 * CELLS);
}

static void analyse_one(void *user, size_t t) {
    learning *l = user;
    nqm_sparse_analyse(&l->dictionary->bases, l->tables + t * CELLS, l->cores + t * CORE);
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

/* Bases and atoms of the sampled tables. */
static nqm_status learn(learning *l, const nqm_learn_options *options, nqm_ticker *ticker, nqm_error *err) {
    nqm_sparse_dictionary *d = l->dictionary;
    nqm_status status = find_typical(l, err);
    if (status != NQM_OK)
        return status;
    nqm_parallel_for(l->n, map_one, l);
    status = nqm_sparse_bases_learn(3 * l->n, l->tables, &d->bases, err);
    if (status != NQM_OK)
        return status;
    nqm_parallel_for(3 * l->n, analyse_one, l);
    d->n_atoms = N_ATOMS;
    status = nqm_sparse_ksvd(3 * l->n, l->cores, options, ticker, &d->n_atoms, l->atoms, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < d->n_atoms * CORE; ++i)
        d->atoms[i] = (float)l->atoms[i];
    return NQM_OK;
}

nqm_status nqm_learn_sparse(size_t n, const nqm_brdf *const *refs, const char *const *names,
                            const nqm_learn_options *options, const char *path, nqm_error *err) {
    nqm_ticker ticker = {.fn = options->progress, .user = options->progress_user};
    nqm_learn_options used = *options;
    used.n_steps = options->n_steps ? options->n_steps : DEFAULT_STEPS;
    learning l = {.n = n, .refs = refs};
    nqm_status status = alloc_learning(&l, err);
    if (status == NQM_OK)
        status = sample_all(&l, &ticker, err);
    if (status == NQM_OK)
        status = learn(&l, &used, &ticker, err);
    if (status == NQM_OK) {
        nqm_tensor tensors[NQM_SPARSE_TENSORS];
        nqm_sparse_tensors(l.dictionary, tensors);
        status =
            nqm_encoder_write(path, &(nqm_encoder_source){"sparse", n, names, &used}, NQM_SPARSE_TENSORS, tensors, err);
    }
    release(&l);
    return status;
}
