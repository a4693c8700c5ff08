/* SPDX-License-Identifier: MIT
 *
 * encode.h - the encodings that are not analytic: a network trained for one BRDF, sparse codes in a learned dictionary,
 * networks predicted by a learned hypernetwork. The room `fit` lists them as models.
 */
#ifndef NQM_SRC_ENCODE_H
#define NQM_SRC_ENCODE_H

#include "brdf/brdf.h"
#include "io/io.h"
#include <nqm/brdf.h>

/** What an encoder is asked for. */
typedef struct nqm_encode_options {
    size_t n_directions; /* as nqm_fit_options.n_directions */
    uint64_t seed;
    size_t n;   /* atoms of a sparse code; samples that the hypernetwork reads */
    float step; /* coefficients of the atoms, or the latent vector, are rounded to multiples of it; 0: they are not */
    const char *name;         /* name of the predicted network */
    nqm_progress_fn progress; /* NULL: silent */
    void *progress_user;
} nqm_encode_options;

/** As in nqm_fit_report. */
typedef struct nqm_encode_report {
    double loss;
    size_t n_directions, best_start, n_numbers;
} nqm_encode_report;

typedef nqm_status (*nqm_encode_fn)(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                                    nqm_brdf **brdf_ret, nqm_error *err);

/** Train a network for `ref` (nbrdf_fit.c). */
NQM_MUST_CHECK nqm_status nqm_encode_nbrdf(const nqm_brdf *ref, const nqm_encode_options *options,
                                           nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err);
/** Train a network at n half-vector coordinates hd (n, 3) only, for so long that it overfits them. NQM_ERR_INCOMPATIBLE: no
 *  direction has a value. */
NQM_MUST_CHECK nqm_status nqm_encode_nbrdf_at(const nqm_brdf *ref, size_t n, const double *hd, uint64_t seed,
                                              nqm_brdf **brdf_ret, nqm_error *err);
/** Compute a sparse code of `ref` in the embedded dictionary (sparse.c). */
NQM_MUST_CHECK nqm_status nqm_encode_sparse(const nqm_brdf *ref, const nqm_encode_options *options,
                                            nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err);
/** Predict a network for `ref` by the embedded hypernetwork (hyper.c). */
NQM_MUST_CHECK nqm_status nqm_encode_hyper(const nqm_brdf *ref, const nqm_encode_options *options,
                                           nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err);

/** Draw a direction pair uniform by solid angle, both polar angles at most max_polar. */
void nqm_encode_draw_uniform(nqm_rng *rng, double max_polar, double *wi, double *wo);
/** Draw half-vector coordinates hd (3): theta_h = max_theta u^2 with uniform u, as in MERL's tables; theta_d uniform up to
 *  max_theta, phi_d up to max_phi; both polar angles at most max_polar. */
void nqm_encode_draw_dense(nqm_rng *rng, double max_polar, double max_theta, double max_phi, double *hd);

/** Move the rows of hd and rgb (n, 3) that have a value to the front; returns their number. */
size_t nqm_encode_keep_valid(size_t n, const uint8_t *flag, double *hd, double *rgb);
enum { NQM_ENCODE_MAX_TRIES = 16 };
/** Draw directions until n of them have a value: hd, rgb (n, 3); returns fewer than n if hardly one in NQM_ENCODE_MAX_TRIES has. */
size_t nqm_encode_sample(const nqm_brdf *ref, size_t n, void (*draw)(nqm_rng *rng, double *hd), nqm_rng *rng,
                         double *hd, double *rgb);

/* ---- files of learned encoders (doc/files.md), which studies/learn.py writes ------------------------------------- */

/** The files of models/encoders. */
extern const nqm_embedded_file nqm_embedded_encoders[];

/** The bytes of an embedded encoder file ("sparse", "hyper"; models/encoders/NAME.safetensors); NULL when this build has
 *  none. */
const unsigned char *nqm_encoder_bytes(const char *name, size_t *n_bytes_ret);

/** Parse an encoder file; NQM_ERR_MODEL if data is NULL (nqm_encoder_bytes() found none), and unless it is of this kind,
 *  its checksum is correct and all values are finite. `name` is for messages. Free with nqm_safetensors_free(). */
NQM_MUST_CHECK nqm_status nqm_encoder_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                            const char *kind, nqm_safetensors **st_ret, nqm_error *err);

/* ---- training of the network of an NBRDF, 6-21-21-3 (nbrdf_net.c) ------------------------------------------------ */

/** A batch of directions; the innermost dimension of all arrays is the direction. */
typedef struct nqm_nbrdf_batch {
    size_t n;
    const float *input;  /* (6, n) unit half vector with phi_h = 0, unit difference vector */
    const float *weight; /* (n) c = cos(theta_i), in [0, 1] */
    const float *goal;   /* (3, n) log(1 + c f_r) of the reference */
} nqm_nbrdf_batch;

/** Inputs and cosine weight of n half-vector coordinates hd (n, 3): input (6, n), weight (n). */
void nqm_nbrdf_inputs(size_t n, const double *hd, float *input, float *weight);
/** The same, and the goal (3, n) of values rgb (n, 3): the arrays of a batch. */
void nqm_nbrdf_fill(size_t n, const double *hd, const double *rgb, float *input, float *weight, float *goal);

/**
 * Mean over directions and channels of |log(1 + c f_r) - goal| (Sztrajman et al. 2021, section 3.1), f_r = exp(x) - 1 of
 * the network's output x. A negative f_r is not clamped, so that gradient descent can raise it; evaluation clamps it to 0.
 * Safe to call from several threads; the same bits on every machine.
 *
 * @param weights   (NQM_NBRDF_WEIGHTS)
 * @param gradient  (NQM_NBRDF_WEIGHTS) receives (overwrites) the gradient of the loss; NULL: loss only
 */
double nqm_nbrdf_loss(const float *weights, const nqm_nbrdf_batch *batch, float *gradient);

/* ---- the hypernetwork (network: hyper_net.c; file, input samples and use: hyper.c) ------------------------------- */

/* After Gokbudak et al. 2024, arXiv:2311.15783, "Hypernetworks for Generalizable BRDF Representation": a network on each sample of a
 * BRDF, mean and maximum over all samples, and a second network that predicts the weights of an NBRDF. */

enum {
    NQM_HYPER_PLACE = 7,                      /* features of a sample's direction pair */
    NQM_HYPER_FEATURES = NQM_HYPER_PLACE + 6, /* and the features of its value */
    NQM_HYPER_N_LAYERS = 6,
    NQM_HYPER_POOLED = 3 /* index of the first layer after the pooling */
};

/** Widths of the layers: three for each sample, two after the pooling, the predicted weights (NQM_NBRDF_WEIGHTS). */
typedef struct nqm_hyper_shape {
    size_t n_out[NQM_HYPER_N_LAYERS];
} nqm_hyper_shape;

/** y = GELU(x W + b), linear in the last layer. */
typedef struct nqm_hyper_layer {
    size_t n_in, n_out;
    float *w; /* (n_in, n_out) */
    float *b; /* (n_out) */
} nqm_hyper_layer;

typedef struct nqm_hyper {
    nqm_hyper_layer layer[NQM_HYPER_N_LAYERS];
    size_t n;     /* number of parameters */
    float *block; /* (n) weights and biases, layer by layer */
} nqm_hyper;

/** A network of zeros; nqm_free(hyper->block) also after a failure. */
NQM_MUST_CHECK nqm_status nqm_hyper_create(const nqm_hyper_shape *shape, nqm_hyper *hyper_ret, nqm_error *err);
/** Predict weights (n_out of the last layer) from the features x (n_samples, NQM_HYPER_FEATURES) of samples. step: mean and
 *  maximum of the pooling are rounded to multiples of it; 0: they are not. */
NQM_MUST_CHECK nqm_status nqm_hyper_forward(const nqm_hyper *hyper, size_t n_samples, const float *x, float step,
                                            float *weights, nqm_error *err);

/** Read the bytes of a file; NQM_ERR_MODEL unless it contains a hypernetwork that predicts NBRDFs. */
NQM_MUST_CHECK nqm_status nqm_hyper_read(const unsigned char *data, size_t n_bytes, const char *name,
                                         nqm_hyper *hyper_ret, nqm_error *err);
/** Tensor i (of 2 NQM_HYPER_N_LAYERS) of the file of a network, part of `layer`: its weights if i is even, otherwise its
 *  biases. */
enum { NQM_HYPER_NAME_BYTES = 40 };
nqm_tensor nqm_hyper_tensor(size_t i, const nqm_hyper_layer *layer, char name[NQM_HYPER_NAME_BYTES]);

/** Predict the NBRDF of n samples hd, rgb (n, 3): weights (NQM_NBRDF_WEIGHTS). step: as in nqm_hyper_forward(). */
NQM_MUST_CHECK nqm_status nqm_hyper_encode(const nqm_hyper *hyper, size_t n, const double *hd, const double *rgb,
                                           float step, float *weights, nqm_error *err);
/** nqm_encode_hyper() by this network. */
NQM_MUST_CHECK nqm_status nqm_hyper_encode_brdf(const nqm_hyper *hyper, const nqm_brdf *ref,
                                                const nqm_encode_options *options, nqm_encode_report *report,
                                                nqm_brdf **brdf_ret, nqm_error *err);

/* ---- the sparse encoding ----------------------------------------------------------------------------------------- */

/* After Tongbuasirilai et al. (2022, DOI 10.1145/3533427): a BRDF as a table over half-vector coordinates, mapped to logarithms
 * relative to a typical material (Nielsen et al. 2015, DOI 10.1145/2816795.2818085), converted from RGB to one brightness and two
 * colour channels; each channel is a linear combination of a few atoms of one learned dictionary. The atoms are in the span of
 * separable (Kronecker) bases, one per coordinate, which keeps the dictionary small: a table is represented by a core of
 * NQM_SPARSE_CORE coefficients with the same norm. */

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
