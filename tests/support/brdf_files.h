/* SPDX-License-Identifier: MIT
 *
 * brdf_files.h - writers of small BRDF files of every format: valid files, whose values tests/vectors/brdf.py computes
 * with the same noise function, and broken ones. None contains measured data. Any failure aborts the test.
 */
#ifndef NQM_TESTS_BRDF_FILES_H
#define NQM_TESTS_BRDF_FILES_H

#include "support/scratch.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** The content of a file; free with blob_free(). */
typedef struct blob {
    unsigned char *data;
    size_t n_bytes;
} blob;

void blob_free(blob *b);
void blob_save(const blob *b, const char *path);
/** Write the blob to a file and free it; returns the path. */
const char *blob_put(blob b, const char *path);
/** Write a file of `n_bytes` that begins with the blob; the rest is a hole (zeros without disk blocks). */
void blob_save_sparse(const blob *b, size_t n_bytes, const char *path);
blob blob_load(const char *path);

/** The i-th value of the pseudo-random sequence `row`: in [0, 1), 24 bits, so exact in float32 and the same in
 * numpy. */
double noise(uint32_t i, uint32_t row);

/** The double that make_merl() stores in a cell; negative where h + d is outside the valid part of the table. */
double merl_cell(size_t channel, size_t h, size_t d, size_t p);
/** A full MERL table, 35 MB; and one with 360 phi_d, 70 MB. */
blob make_merl(void);
blob make_merl_360(void);
enum { MERL_BYTES = 12 + 3 * 90 * 90 * 180 * 8 };

/** A tensor that replaces the valid one of that name or is added to the others. */
typedef struct rgl_change {
    const char *name; /**< NULL: no change */
    bool omit;        /**< remove the tensor of that name */
    unsigned type;    /**< type code of the container: 10 is float32 */
    size_t n_dims, dims[7];
    const float *values; /**< NULL: noise in [1, 2) */
} rgl_change;
/** A small isotropic RGL material; `change` may be NULL. */
blob make_rgl(const rgl_change *change);
/** The same with `spectra` at nine wavelengths instead of `rgb`. */
blob make_spectral_rgl(const rgl_change *change);
/** An anisotropic one, with phi_i over 1 / reduction (1, 2 or 4) of a turn. */
blob make_anisotropic_rgl(size_t reduction, bool is_spectral, const rgl_change *change);
/** A small polarimetric material; M is NaN at some nodes. */
blob make_pbsdf(const rgl_change *change);
/** The valid material, with the data of every tensor at an offset of 8 n + shift bytes. */
blob make_shifted_rgl(size_t shift);

/** A full UTIA measurement, 2 MB. */
blob make_utia(void);
enum { UTIA_BYTES = 3 * 288 * 288 * 8 };

typedef enum nbrdf_kind {
    NBRDF_VALID,
    NBRDF_MISSING,          /**< one dataset is missing */
    NBRDF_SHAPE,            /**< one dataset is transposed */
    NBRDF_DOUBLE,           /**< one dataset is float64 */
    NBRDF_NAN,              /**< one weight is NaN */
    NBRDF_CHUNKED,          /**< one dataset is compressed with deflate */
    NBRDF_EXTERNAL_LINK,    /**< one dataset is a link into another file */
    NBRDF_EXTERNAL_STORAGE, /**< the values of one dataset are stored in another file */
    NBRDF_KINDS
} nbrdf_kind;
/** A small NBRDF network in the HDF5 layout of Keras. */
blob make_nbrdf(nbrdf_kind kind);

typedef enum saved_kind {
    SAVED_NETWORK,
    SAVED_MISSING,    /**< one tensor is missing */
    SAVED_EXTRA,      /**< one extra tensor */
    SAVED_SHAPE,      /**< one tensor is transposed */
    SAVED_DOUBLE,     /**< one tensor is float64 */
    SAVED_NAN,        /**< one weight is NaN */
    SAVED_FORMAT,     /**< the metadata declare a model */
    SAVED_SCHEMA,     /**< a later schema version */
    SAVED_CHECKSUM,   /**< one bit differs */
    SAVED_TABLE,      /**< a table of 4 x 3 x 5 nodes, one without a value */
    SAVED_TABLE_NAN,  /**< one channel of a node is NaN */
    SAVED_TABLE_FLAT, /**< only one node along theta_h */
    SAVED_KINDS
} saved_kind;
/** A small network, or a table for SAVED_TABLE and later kinds, in the layout of nqm_brdf_save(). */
blob make_saved(saved_kind kind);

/** A zip archive with one member. */
blob make_zip(const char *member, const blob *content);

/** The decoder of the neural processes (3.2 MB) and a table of latents with the materials "first" and "second". */
blob make_nps_decoder(void);
blob make_nps_latents(void);

#endif
