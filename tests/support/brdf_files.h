/* SPDX-License-Identifier: MIT
 *
 * brdf_files.h - small BRDF files of every format, made in memory: valid ones, whose numbers tests/vectors/brdf.py
 * makes again by the same rule, and broken ones. Nothing here is measured data. Whatever fails aborts the test.
 */
#ifndef NQM_TESTS_BRDF_FILES_H
#define NQM_TESTS_BRDF_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** The bytes of a file; free with blob_free(). */
typedef struct blob {
    unsigned char *data;
    size_t n_bytes;
} blob;

void blob_free(blob *b);
void blob_save(const blob *b, const char *path);
/** Save and free. */
void blob_put(blob b, const char *path);
/** A file of `n_bytes` in all that begins with the blob; the rest are zeros that take no room on the disk. */
void blob_save_sparse(const blob *b, size_t n_bytes, const char *path);
blob blob_load(const char *path);

/** Path of a file with this name in a folder of this process, which is removed with its files at exit. Lent. */
const char *scratch_path(const char *name);

/** The i-th of a row of numbers in [0, 1) with 24 bits: exact in float32 and the same in numpy. */
double noise(uint32_t i, uint32_t row);

/** The double that make_merl() stores, from cell numbers; negative where h + d is beyond the table's valid part. */
double merl_cell(size_t channel, size_t h, size_t d, size_t p);
/** A full MERL table, 35 MB. */
blob make_merl(void);
enum { MERL_BYTES = 12 + 3 * 90 * 90 * 180 * 8 };

/** A tensor to put in place of the valid one of that name, or beside the others. */
typedef struct rgl_change {
    const char *name; /**< NULL: no change */
    bool omit;        /**< leave it out instead */
    unsigned type;    /**< the container's number: 10 is float32 */
    size_t n_dims, dims[6];
    const float *values; /**< NULL: noise in [1, 2) */
} rgl_change;
/** A small isotropic RGL material; `change` may be NULL. */
blob make_rgl(const rgl_change *change);
/** The valid one, with all tensors' data so many bytes behind a multiple of 8. */
blob make_shifted_rgl(size_t shift);

typedef enum nbrdf_kind {
    NBRDF_VALID,
    NBRDF_MISSING,          /**< one dataset less */
    NBRDF_SHAPE,            /**< one dataset transposed */
    NBRDF_DOUBLE,           /**< one dataset in float64 */
    NBRDF_NAN,              /**< one weight not a number */
    NBRDF_CHUNKED,          /**< one dataset packed with deflate */
    NBRDF_EXTERNAL_LINK,    /**< one dataset is a link into another file */
    NBRDF_EXTERNAL_STORAGE, /**< the numbers of one dataset lie in another file */
    NBRDF_KINDS
} nbrdf_kind;
/** A small NBRDF network in the layout of Keras. */
blob make_nbrdf(nbrdf_kind kind);

typedef enum saved_kind {
    SAVED_NETWORK,
    SAVED_MISSING,    /**< one tensor less */
    SAVED_EXTRA,      /**< one tensor more */
    SAVED_SHAPE,      /**< one tensor transposed */
    SAVED_DOUBLE,     /**< one tensor in float64 */
    SAVED_NAN,        /**< one weight not a number */
    SAVED_FORMAT,     /**< says that it is a model */
    SAVED_SCHEMA,     /**< of a later version */
    SAVED_CHECKSUM,   /**< one bit changed */
    SAVED_TABLE,      /**< 4 x 3 x 5 nodes, one without a value */
    SAVED_TABLE_NAN,  /**< one channel of a node not a number */
    SAVED_TABLE_FLAT, /**< one node along theta_h */
    SAVED_KINDS
} saved_kind;
/** A small network, or from SAVED_TABLE on a table, as nqm_brdf_save() writes them. */
blob make_saved(saved_kind kind);

/** An archive with one member. */
blob make_zip(const char *member, const blob *content);

/** The decoder of the neural processes (3.2 MB) and a table of latents with the materials "first" and "second". */
blob make_nps_decoder(void);
blob make_nps_latents(void);

#endif
