/* SPDX-License-Identifier: MIT
 *
 * sparse.h - the sparse encoding, after Tongbuasirilai et al. (2022, DOI 10.1145/3533427): a BRDF as a table over
 * half-vector coordinates, mapped to logarithms relative to a typical material (Nielsen et al. 2015, DOI
 * 10.1145/2816795.2818085), converted from RGB to one brightness and two colour channels; each channel is a linear
 * combination of a few atoms of one learned dictionary. The atoms are in the span of separable (Kronecker) bases, one per
 * coordinate, which keeps the dictionary small: a table is represented by a core of NQM_SPARSE_CORE coefficients with the
 * same norm.
 */
#ifndef NQM_SRC_ENCODE_SPARSE_H
#define NQM_SRC_ENCODE_SPARSE_H

#include "encode/encode.h"

/** Nodes of the table (theta_h, theta_d, phi_d), as in nqm_table_create(), and the sizes of the bases. */
enum { NQM_SPARSE_H = 90, NQM_SPARSE_D = 24, NQM_SPARSE_P = 12 };
enum { NQM_SPARSE_CELLS = NQM_SPARSE_H * NQM_SPARSE_D * NQM_SPARSE_P };
enum { NQM_SPARSE_BASIS_H = 40, NQM_SPARSE_BASIS_D = 16, NQM_SPARSE_BASIS_P = 7 };
enum { NQM_SPARSE_CORE = NQM_SPARSE_BASIS_H * NQM_SPARSE_BASIS_D * NQM_SPARSE_BASIS_P };

/* ---- tables (sparse_table.c) ------------------------------------------------------------------------------------- */

/** The nodes with both directions above the horizon. */
typedef struct nqm_sparse_grid {
    size_t n;
    double *hd;     /* (n, 3); owns the block of all arrays */
    double *cosine; /* (n) c = cos(theta_i) cos(theta_o) */
    size_t *cell;   /* (n) index in a table */
} nqm_sparse_grid;

/** nqm_free(grid->hd) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_sparse_grid_make(nqm_sparse_grid *grid, nqm_error *err);

/** c f_r of `brdf`: table (3, NQM_SPARSE_CELLS), 0 below the horizon, NaN where the BRDF has no value. *n_valid_ret: nodes
 *  with a value; fewer than 100: NQM_ERR_INCOMPATIBLE. */
NQM_MUST_CHECK nqm_status nqm_sparse_sample(const nqm_sparse_grid *grid, const nqm_brdf *brdf, float *table,
                                            size_t *n_valid_ret, nqm_error *err);
/** Map such a table in place to log((c f_r + eps) / (typical + eps)), and RGB to brightness and two colours. Cells without a
 *  value get f_r of a neighbour in theta_h or theta_d. typical: (NQM_SPARSE_CELLS) c f_r. */
void nqm_sparse_map(const nqm_sparse_grid *grid, const float *typical, float *table);
/** The inverse, in place: c f_r, clamped at 0. */
void nqm_sparse_unmap(const nqm_sparse_grid *grid, const float *typical, float *table);

/** Orthonormal bases of the three coordinates; each row is a vector. */
typedef struct nqm_sparse_bases {
    float h[NQM_SPARSE_BASIS_H * NQM_SPARSE_H];
    float d[NQM_SPARSE_BASIS_D * NQM_SPARSE_D];
    float p[NQM_SPARSE_BASIS_P * NQM_SPARSE_P];
} nqm_sparse_bases;

/** One channel (NQM_SPARSE_CELLS) to its core (NQM_SPARSE_CORE), and the inverse. */
void nqm_sparse_analyse(const nqm_sparse_bases *bases, const float *channel, double *core);
void nqm_sparse_synthesise(const nqm_sparse_bases *bases, const double *core, float *channel);

/* ---- codes (sparse_omp.c) ---------------------------------------------------------------------------------------- */

enum { NQM_OMP_MAX_ATOMS = 128, NQM_OMP_MAX_BLOCKS = 3, NQM_OMP_MAX_DICTIONARY = 1024 };

/** Signals (blocks) to be coded in one dictionary with atoms of unit length. */
typedef struct nqm_omp_problem {
    size_t n_blocks, n_atoms;  /* at most NQM_OMP_MAX_BLOCKS, NQM_OMP_MAX_DICTIONARY */
    const double *gram;        /* (n_atoms, n_atoms) inner products of the atoms */
    const double *correlation; /* (n_blocks, n_atoms) inner products of atoms and signals */
} nqm_omp_problem;

/**
 * Orthogonal matching pursuit for all blocks together: each step adds the atom with the largest correlation with the
 * residual of any block and solves the coefficients of all chosen atoms again (Batch-OMP with a progressive Cholesky
 * factor: Rubinstein et al. 2008, Technion report CS-2008-08).
 *
 * @param max_atoms    at most NQM_OMP_MAX_ATOMS
 * @param index        (max_atoms) receives block * n_atoms + atom
 * @param coefficient  (max_atoms)
 * @param scratch      (n_blocks, n_atoms)
 * @return the number of atoms: fewer than max_atoms if the residual is 0 or no other atom is linearly independent
 */
size_t nqm_omp(const nqm_omp_problem *problem, size_t max_atoms, size_t *index, double *coefficient, double *scratch);

/* ---- dictionaries ------------------------------------------------------------------------------------------------ */

typedef struct nqm_sparse_dictionary {
    float typical[NQM_SPARSE_CELLS]; /* c f_r of a typical material */
    nqm_sparse_bases bases;
    size_t n_atoms;
    float *atoms; /* (n_atoms, NQM_SPARSE_CORE), unit length; in the same block */
} nqm_sparse_dictionary;

/** A dictionary of zeros; free with nqm_free(). */
NQM_MUST_CHECK nqm_status nqm_sparse_dictionary_create(size_t n_atoms, nqm_sparse_dictionary **dictionary_ret,
                                                       nqm_error *err);
/** The tensors of a dictionary's file; their data are those of the dictionary. */
enum { NQM_SPARSE_TENSORS = 5 };
void nqm_sparse_tensors(const nqm_sparse_dictionary *dictionary, nqm_tensor tensors[NQM_SPARSE_TENSORS]);
/** Read the bytes of an encoder file; NQM_ERR_MODEL if they are not a dictionary. Free with nqm_free(). */
NQM_MUST_CHECK nqm_status nqm_sparse_dictionary_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                                      nqm_sparse_dictionary **dictionary_ret, nqm_error *err);

/** Code `ref` with at most options->n atoms. Fills loss, n_directions and n_numbers of the report. */
NQM_MUST_CHECK nqm_status nqm_sparse_encode(const nqm_sparse_dictionary *dictionary, const nqm_brdf *ref,
                                            const nqm_encode_options *options, nqm_encode_report *report,
                                            nqm_brdf **brdf_ret, nqm_error *err);

#endif
