/* SPDX-License-Identifier: MIT
 *
 * The encodings sparse-low, -mid and -high: a dictionary from its file, and a BRDF coded in it.
 */
#include "fit/sparse.h"
#include "brdf/brdf.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { CELLS = NQM_SPARSE_CELLS, CORE = NQM_SPARSE_CORE };

/* Atoms kept at each budget; doc/encodings.md shows what they look like. */
static const size_t budget_atoms[] = {[NQM_BUDGET_LOW] = 4, [NQM_BUDGET_MID] = 8, [NQM_BUDGET_HIGH] = 32};

/* ---- the file ---------------------------------------------------------------------------------------------------- */

static nqm_status copy_tensor(const nqm_safetensors *st, const char *name, const char *tensor_name, size_t rows,
                              size_t cols, float *out, nqm_error *err) {
    const nqm_tensor *tensor;
    nqm_status status = nqm_encoder_tensor(st, name, tensor_name, 2, (size_t[]){rows, cols}, &tensor, err);
    if (status == NQM_OK)
        memcpy(out, tensor->data, tensor->n_bytes);
    return status;
}

static nqm_status read_atoms(const nqm_safetensors *st, const char *name, nqm_sparse_dictionary *dictionary,
                             nqm_error *err) {
    const nqm_tensor *tensor;
    nqm_status status = nqm_encoder_tensor(st, name, "atoms", 2, (size_t[]){0, CORE}, &tensor, err);
    if (status != NQM_OK)
        return status;
    dictionary->n_atoms = tensor->dims[0];
    if (dictionary->n_atoms > NQM_OMP_MAX_DICTIONARY)
        return nqm_fail(err, NQM_ERR_MODEL, tensor->byte_offset, "%s: %zu atoms, more than %d", name,
                        dictionary->n_atoms, NQM_OMP_MAX_DICTIONARY);
    dictionary->atoms = nqm_alloc(tensor->n_bytes, 1);
    if (!dictionary->atoms)
        return nqm_fail_nomem(err, tensor->n_bytes);
    memcpy(dictionary->atoms, tensor->data, tensor->n_bytes);
    return NQM_OK;
}

/* The mapping takes the logarithm of it; matching pursuit takes the atoms for unit vectors. */
static nqm_status check_values(const nqm_sparse_dictionary *dictionary, const char *name, nqm_error *err) {
    for (size_t i = 0; i < CELLS; ++i)
        if (dictionary->typical[i] < 0)
            return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: tensor 'typical' holds a negative value", name);
    for (size_t k = 0; k < dictionary->n_atoms; ++k) {
        const float *atom = dictionary->atoms + k * CORE;
        double sum = 0;
        for (size_t i = 0; i < CORE; ++i)
            sum += (double)atom[i] * (double)atom[i];
        if (!(fabs(sum - 1) < 1e-4))
            return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: tensor 'atoms': atom %zu has not the length 1", name, k);
    }
    return NQM_OK;
}

static nqm_status read_all(const nqm_safetensors *st, const char *name, nqm_sparse_dictionary *dictionary,
                           nqm_error *err) {
    nqm_sparse_bases *b = &dictionary->bases;
    nqm_status status = copy_tensor(st, name, "typical", NQM_SPARSE_H, CELLS / NQM_SPARSE_H, dictionary->typical, err);
    if (status == NQM_OK)
        status = copy_tensor(st, name, "basis.theta_h", NQM_SPARSE_BASIS_H, NQM_SPARSE_H, b->h, err);
    if (status == NQM_OK)
        status = copy_tensor(st, name, "basis.theta_d", NQM_SPARSE_BASIS_D, NQM_SPARSE_D, b->d, err);
    if (status == NQM_OK)
        status = copy_tensor(st, name, "basis.phi_d", NQM_SPARSE_BASIS_P, NQM_SPARSE_P, b->p, err);
    if (status == NQM_OK)
        status = read_atoms(st, name, dictionary, err);
    return status == NQM_OK ? check_values(dictionary, name, err) : status;
}

nqm_status nqm_sparse_dictionary_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                       nqm_sparse_dictionary **dictionary_ret, nqm_error *err) {
    *dictionary_ret = NULL;
    nqm_safetensors *st;
    nqm_status status = nqm_encoder_parse(data, n_bytes, name, "sparse", &st, err);
    if (status != NQM_OK)
        return status;
    nqm_sparse_dictionary *dictionary = nqm_alloc(1, sizeof *dictionary);
    status = dictionary ? read_all(st, name, dictionary, err) : nqm_fail_nomem(err, sizeof *dictionary);
    nqm_safetensors_free(st);
    if (status == NQM_OK)
        *dictionary_ret = dictionary;
    else
        nqm_sparse_dictionary_free(dictionary);
    return status;
}

void nqm_sparse_dictionary_free(nqm_sparse_dictionary *dictionary) {
    if (!dictionary)
        return;
    nqm_free(dictionary->atoms);
    nqm_free(dictionary);
}

/* ---- coding ------------------------------------------------------------------------------------------------------ */

void nqm_sparse_gram(size_t n, const double *vectors, double *gram) {
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j <= i; ++j) {
            double sum = 0;
            for (size_t k = 0; k < CORE; ++k)
                sum += vectors[i * CORE + k] * vectors[j * CORE + k];
            gram[i * n + j] = gram[j * n + i] = sum;
        }
}

/* What coding one BRDF needs besides the dictionary. */
typedef struct workspace {
    nqm_sparse_grid grid;
    float *table;  /* (3, CELLS) */
    float *sample; /* (3, CELLS) c f_r of the reference */
    double *atoms, *gram, *correlation, *scratch, *core;
} workspace;

static nqm_status make_workspace(size_t n_atoms, workspace *w, nqm_error *err) {
    *w = (workspace){.table = nqm_alloc(3 * CELLS, sizeof(float)),
                     .sample = nqm_alloc(3 * CELLS, sizeof(float)),
                     .atoms = nqm_alloc(n_atoms, CORE * sizeof(double)),
                     .gram = nqm_alloc(n_atoms, n_atoms * sizeof(double)),
                     .correlation = nqm_alloc(n_atoms, 3 * sizeof(double)),
                     .scratch = nqm_alloc(n_atoms, 3 * sizeof(double)),
                     .core = nqm_alloc(3 * CORE, sizeof(double))};
    if (!w->table || !w->sample || !w->atoms || !w->gram || !w->correlation || !w->scratch || !w->core)
        return nqm_fail_nomem(err, (n_atoms + 3) * CORE * sizeof(double));
    return nqm_sparse_grid_make(&w->grid, err);
}

static void free_workspace(workspace *w) {
    nqm_sparse_grid_free(&w->grid);
    void *blocks[] = {w->table, w->sample, w->atoms, w->gram, w->correlation, w->scratch, w->core};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
}

/* The mapped channels of w->table become the sum of at most max_atoms atoms; returns how many. */
static size_t approximate(const nqm_sparse_dictionary *dictionary, size_t max_atoms, workspace *w) {
    size_t n = dictionary->n_atoms, index[NQM_OMP_MAX_ATOMS];
    double coefficient[NQM_OMP_MAX_ATOMS];
    for (size_t i = 0; i < n * CORE; ++i)
        w->atoms[i] = (double)dictionary->atoms[i];
    nqm_sparse_gram(n, w->atoms, w->gram);
    for (size_t c = 0; c < 3; ++c) {
        double *core = w->core + c * CORE;
        nqm_sparse_analyse(&dictionary->bases, w->table + c * CELLS, core);
        for (size_t k = 0; k < n; ++k) {
            double sum = 0;
            for (size_t i = 0; i < CORE; ++i)
                sum += w->atoms[k * CORE + i] * core[i];
            w->correlation[c * n + k] = sum;
        }
    }
    const nqm_omp_problem problem = {3, n, w->gram, w->correlation};
    size_t n_chosen = nqm_omp(&problem, max_atoms, index, coefficient, w->scratch);
    memset(w->core, 0, 3 * CORE * sizeof *w->core);
    for (size_t a = 0; a < n_chosen; ++a)
        for (size_t i = 0; i < CORE; ++i)
            /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): nothing is chosen from no atoms */
            w->core[index[a] / n * CORE + i] += coefficient[a] * w->atoms[index[a] % n * CORE + i];
    for (size_t c = 0; c < 3; ++c)
        nqm_sparse_synthesise(&dictionary->bases, w->core + c * CORE, w->table + c * CELLS);
    return n_chosen;
}

/* Mean absolute difference of log(1 + c f_r) where the reference has values. */
static double loss_of(const workspace *w) {
    double sum = 0;
    size_t n = 0;
    for (size_t i = 0; i < w->grid.n; ++i)
        for (size_t c = 0; c < 3; ++c) {
            size_t at = c * CELLS + w->grid.cell[i];
            if (isnan(w->sample[at]))
                continue;
            sum += fabs(log1p((double)w->table[at]) - log1p((double)w->sample[at]));
            ++n;
        }
    return sum / (double)n;
}

/* A BRDF of c f_r (3, CELLS) above the horizon. */
static nqm_status make_brdf(const workspace *w, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    float *rgb = nqm_alloc(3 * CELLS, sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, 3 * CELLS * sizeof *rgb);
    for (size_t i = 0; i < 3 * CELLS; ++i)
        rgb[i] = NAN;
    for (size_t i = 0; i < w->grid.n; ++i)
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * w->grid.cell[i] + c] = (float)((double)w->table[c * CELLS + w->grid.cell[i]] / w->grid.cosine[i]);
    nqm_status status = nqm_table_create(NQM_SPARSE_H, NQM_SPARSE_D, NQM_SPARSE_P, rgb, name, brdf_ret, err);
    nqm_free(rgb);
    return status;
}

nqm_status nqm_sparse_encode(const nqm_sparse_dictionary *dictionary, const nqm_brdf *ref, size_t max_atoms,
                             nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    workspace w;
    *brdf_ret = NULL;
    nqm_status status = make_workspace(dictionary->n_atoms, &w, err);
    if (status == NQM_OK)
        status = nqm_sparse_sample(&w.grid, ref, w.sample, &report->n_directions, err);
    if (status == NQM_OK) {
        memcpy(w.table, w.sample, 3 * CELLS * sizeof *w.table);
        nqm_sparse_map(&w.grid, dictionary->typical, w.table);
        report->n_numbers = 2 * approximate(dictionary, max_atoms, &w);
        nqm_sparse_unmap(&w.grid, dictionary->typical, w.table);
        report->loss = loss_of(&w);
        status = make_brdf(&w, nqm_brdf_get_info(ref).name, brdf_ret, err);
    }
    free_workspace(&w);
    return status;
}

nqm_status nqm_fit_sparse(const nqm_brdf *ref, nqm_budget budget, const nqm_fit_options *options,
                          nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    (void)options; /* the nodes of the table are the directions */
    size_t n_bytes;
    const unsigned char *bytes = nqm_encoder_bytes("sparse", &n_bytes);
    if (!bytes)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "this build has no dictionary: models/encoders/sparse.safetensors");
    nqm_sparse_dictionary *dictionary;
    nqm_status status = nqm_sparse_dictionary_parse(bytes, n_bytes, "the built-in dictionary", &dictionary, err);
    if (status == NQM_OK)
        status = nqm_sparse_encode(dictionary, ref, budget_atoms[budget], report, brdf_ret, err);
    nqm_sparse_dictionary_free(dictionary);
    return status;
}
