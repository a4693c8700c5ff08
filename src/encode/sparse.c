/* SPDX-License-Identifier: MIT
 *
 * The encodings sparse-*: a dictionary from its file, and a BRDF coded in it.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"

#include <math.h>
#include <string.h>

enum { CELLS = NQM_SPARSE_CELLS, CORE = NQM_SPARSE_CORE };

/* ---- the file ---------------------------------------------------------------------------------------------------- */

nqm_status nqm_sparse_dictionary_create(size_t n_atoms, nqm_sparse_dictionary **dictionary_ret, nqm_error *err) {
    float *atoms;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({dictionary_ret, 1, sizeof(nqm_sparse_dictionary)}, {&atoms, n_atoms, CORE * sizeof(float)}), err);
    if (status == NQM_OK) {
        (*dictionary_ret)->n_atoms = n_atoms;
        (*dictionary_ret)->atoms = atoms;
    }
    return status;
}

void nqm_sparse_tensors(const nqm_sparse_dictionary *d, nqm_tensor tensors[NQM_SPARSE_TENSORS]) {
    tensors[0] = nqm_tensor_of("typical", NQM_F32, NQM_SPARSE_H, CELLS / NQM_SPARSE_H, d->typical);
    tensors[1] = nqm_tensor_of("basis.theta_h", NQM_F32, NQM_SPARSE_BASIS_H, NQM_SPARSE_H, d->bases.h);
    tensors[2] = nqm_tensor_of("basis.theta_d", NQM_F32, NQM_SPARSE_BASIS_D, NQM_SPARSE_D, d->bases.d);
    tensors[3] = nqm_tensor_of("basis.phi_d", NQM_F32, NQM_SPARSE_BASIS_P, NQM_SPARSE_P, d->bases.p);
    tensors[4] = nqm_tensor_of("atoms", NQM_F32, d->n_atoms, CORE, d->atoms);
}

/* The mapping takes the logarithm of `typical`; matching pursuit needs atoms of unit length. */
static nqm_status check_values(const nqm_sparse_dictionary *dictionary, const char *name, nqm_error *err) {
    for (size_t i = 0; i < CELLS; ++i)
        if (dictionary->typical[i] < 0)
            return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: tensor 'typical' contains a negative value", name);
    for (size_t k = 0; k < dictionary->n_atoms; ++k) {
        const float *atom = dictionary->atoms + k * CORE;
        double sum = 0;
        for (size_t i = 0; i < CORE; ++i)
            sum += (double)atom[i] * (double)atom[i];
        if (!(fabs(sum - 1) < 1e-4))
            return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: tensor 'atoms': the length of atom %zu is not 1", name, k);
    }
    return NQM_OK;
}

static nqm_status read_all(const nqm_safetensors *st, const char *name, nqm_sparse_dictionary **dictionary_ret,
                           nqm_error *err) {
    const nqm_tensor any_atoms = {.name = "atoms", .n_dims = 2, .dims = {0, CORE}}, *atoms;
    nqm_status status = nqm_safetensors_floats(st, &any_atoms, NQM_ERR_MODEL, &atoms, err);
    if (status != NQM_OK)
        return status;
    size_t n_atoms = atoms->dims[0];
    if (n_atoms > NQM_OMP_MAX_DICTIONARY)
        return nqm_fail(err, NQM_ERR_MODEL, atoms->byte_offset, "%s: %zu atoms, more than %d", name, n_atoms,
                        NQM_OMP_MAX_DICTIONARY);
    status = nqm_sparse_dictionary_create(n_atoms, dictionary_ret, err);
    if (status != NQM_OK)
        return status;
    nqm_tensor tensors[NQM_SPARSE_TENSORS];
    nqm_sparse_tensors(*dictionary_ret, tensors);
    for (size_t i = 0; status == NQM_OK && i < NQM_SPARSE_TENSORS; ++i) {
        const nqm_tensor *tensor;
        status = nqm_safetensors_floats(st, &tensors[i], NQM_ERR_MODEL, &tensor, err);
        if (status == NQM_OK)
            memcpy((void *)(uintptr_t)tensors[i].data, tensor->data, tensor->n_bytes);
    }
    return status == NQM_OK ? check_values(*dictionary_ret, name, err) : status;
}

nqm_status nqm_sparse_dictionary_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                       nqm_sparse_dictionary **dictionary_ret, nqm_error *err) {
    *dictionary_ret = NULL;
    nqm_safetensors *st;
    nqm_status status = nqm_encoder_parse(data, n_bytes, name, "sparse", &st, err);
    if (status != NQM_OK)
        return status;
    status = read_all(st, name, dictionary_ret, err);
    nqm_safetensors_free(st);
    if (status != NQM_OK) {
        nqm_free(*dictionary_ret);
        *dictionary_ret = NULL;
    }
    return status;
}

/* ---- coding ------------------------------------------------------------------------------------------------------ */

static double dot(const double *a, const double *b) {
    double sum = 0;
    for (size_t k = 0; k < CORE; ++k)
        sum += a[k] * b[k];
    return sum;
}

/* Inner products (n, n) of n vectors of CORE. */
static void fill_gram(size_t n, const double *vectors, double *gram) {
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j <= i; ++j)
            gram[i * n + j] = gram[j * n + i] = dot(vectors + i * CORE, vectors + j * CORE);
}

/* Buffers for coding one BRDF; `table` owns the block of all arrays. */
typedef struct workspace {
    nqm_sparse_grid grid;
    float *table;  /* (3, CELLS) */
    float *sample; /* (3, CELLS) c f_r of the reference */
    double *atoms, *gram, *correlation, *scratch, *core;
    float *rgb; /* (CELLS, 3) f_r of the result */
} workspace;

static nqm_status make_workspace(size_t n_atoms, workspace *w, nqm_error *err) {
    *w = (workspace){0};
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&w->table, 3 * CELLS, sizeof(float)}, {&w->sample, 3 * CELLS, sizeof(float)},
                   {&w->atoms, n_atoms, CORE * sizeof(double)}, {&w->gram, n_atoms, n_atoms * sizeof(double)},
                   {&w->correlation, n_atoms, 3 * sizeof(double)}, {&w->scratch, n_atoms, 3 * sizeof(double)},
                   {&w->core, 3 * CORE, sizeof(double)}, {&w->rgb, 3 * CELLS, sizeof(float)}),
        err);
    return status == NQM_OK ? nqm_sparse_grid_make(&w->grid, err) : status;
}

/* Replace the mapped channels of w->table by a linear combination of at most options->n atoms; returns their number. */
static size_t approximate(const nqm_sparse_dictionary *dictionary, const nqm_encode_options *options, workspace *w) {
    size_t n = dictionary->n_atoms, index[NQM_OMP_MAX_ATOMS];
    double coefficient[NQM_OMP_MAX_ATOMS];
    for (size_t i = 0; i < n * CORE; ++i)
        w->atoms[i] = (double)dictionary->atoms[i];
    fill_gram(n, w->atoms, w->gram);
    for (size_t c = 0; c < 3; ++c) {
        double *core = w->core + c * CORE;
        nqm_sparse_analyse(&dictionary->bases, w->table + c * CELLS, core);
        for (size_t k = 0; k < n; ++k)
            w->correlation[c * n + k] = dot(w->atoms + k * CORE, core);
    }
    const nqm_omp_problem problem = {3, n, w->gram, w->correlation};
    size_t n_chosen = nqm_omp(&problem, options->n, index, coefficient, w->scratch);
    const double step = (double)options->step;
    for (size_t a = 0; step > 0 && a < n_chosen; ++a)
        coefficient[a] = step * round(coefficient[a] / step);
    memset(w->core, 0, 3 * CORE * sizeof *w->core);
    for (size_t a = 0; a < n_chosen; ++a)
        for (size_t i = 0; i < CORE; ++i)
            /* NOLINTNEXTLINE(clang-analyzer-core.DivideZero): n_chosen is 0 if n is 0 */
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

/* The BRDF of w->table, c f_r (3, CELLS) above the horizon. */
static nqm_status make_brdf(const workspace *w, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    for (size_t i = 0; i < 3 * CELLS; ++i)
        w->rgb[i] = NAN;
    for (size_t i = 0; i < w->grid.n; ++i)
        for (size_t c = 0; c < 3; ++c)
            w->rgb[3 * w->grid.cell[i] + c] =
                (float)((double)w->table[c * CELLS + w->grid.cell[i]] / w->grid.cosine[i]);
    return nqm_table_create((nqm_table_size){NQM_SPARSE_H, NQM_SPARSE_D, NQM_SPARSE_P, 1}, w->rgb, name, brdf_ret, err);
}

nqm_status nqm_sparse_encode(const nqm_sparse_dictionary *dictionary, const nqm_brdf *ref,
                             const nqm_encode_options *options, nqm_encode_report *report, nqm_brdf **brdf_ret,
                             nqm_error *err) {
    workspace w;
    *brdf_ret = NULL;
    nqm_status status = make_workspace(dictionary->n_atoms, &w, err);
    if (status == NQM_OK)
        status = nqm_sparse_sample(&w.grid, ref, w.sample, &report->n_directions, err);
    if (status == NQM_OK) {
        memcpy(w.table, w.sample, 3 * CELLS * sizeof *w.table);
        nqm_sparse_map(&w.grid, dictionary->typical, w.table);
        report->n_numbers = 2 * approximate(dictionary, options, &w);
        nqm_sparse_unmap(&w.grid, dictionary->typical, w.table);
        report->loss = loss_of(&w);
        status = make_brdf(&w, nqm_brdf_get_info(ref).name, brdf_ret, err);
    }
    nqm_free(w.grid.hd);
    nqm_free(w.table);
    return status;
}

nqm_status nqm_encode_sparse(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                             nqm_brdf **brdf_ret, nqm_error *err) {
    size_t n_bytes = 0;
    const unsigned char *bytes = nqm_encoder_bytes("sparse", &n_bytes);
    nqm_sparse_dictionary *dictionary;
    nqm_status status = nqm_sparse_dictionary_parse(bytes, n_bytes, "built-in dictionary", &dictionary, err);
    if (status == NQM_OK)
        status = nqm_sparse_encode(dictionary, ref, options, report, brdf_ret, err);
    nqm_free(dictionary);
    return status;
}
