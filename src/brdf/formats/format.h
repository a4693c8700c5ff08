/* SPDX-License-Identifier: MIT
 *
 * format.h - what a file format of BRDFs implements, and the list of all formats.
 */
#ifndef NQM_SRC_BRDF_FORMAT_H
#define NQM_SRC_BRDF_FORMAT_H

#include "brdf/brdf.h"

/** An argument "FILE" or "FILE:MEMBER" of nqm_brdf_open(). */
typedef struct nqm_brdf_argument {
    const char *name;   /**< the whole argument, which becomes the name of the BRDF */
    const char *member; /**< MEMBER: which of several BRDFs, or a setting of the reader; NULL: "FILE" */
} nqm_brdf_argument;

/** One file format. */
typedef struct nqm_brdf_format {
    const char *files;  /**< for messages: ".npy"; NULL: its files have nothing that a reader would recognise */
    bool takes_members; /**< otherwise open() is called without a member only */
    /** true when the first bytes look like the format, also those of a short or damaged file, so that the message of
     *  open() can name the fault. The file is not empty. */
    bool (*probe)(const nqm_map *map);
    /** `map` has the bytes of the whole file; a BRDF that keeps it zeroes *map. The caller sets info.n_bytes, if it is 0. Without
     *  a member that it needs, it fails with NQM_ERR_ARG and examples. */
    nqm_status (*open)(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err);
    /** The path of a second file that open() reads; nqm_free() it. NULL: there is none. */
    nqm_status (*find_companion)(const nqm_map *map, char **path_ret, nqm_error *err);
} nqm_brdf_format;

/** Every format, in the order of probing. A new one is defined in a file of its own, and named here. Material files are
 *  recognised only: src/argument reads them. */
#define NQM_BRDF_FORMATS(X)                                                                                            \
    X(nqm_merl_format)                                                                                                 \
    X(nqm_rgl_format)                                                                                                  \
    X(nqm_nbrdf_format)                                                                                                \
    X(nqm_npy_format)                                                                                                  \
    X(nqm_listed_format)                                                                                               \
    X(nqm_zemax_format)                                                                                                \
    X(nqm_authors_format)                                                                                              \
    X(nqm_nps_format)                                                                                                  \
    X(nqm_utia_format)                                                                                                 \
    X(nqm_saved_format)                                                                                                \
    X(nqm_material_file_format)                                                                                        \
    X(nqm_nbrdf_zip_format)
#define NQM_DECLARE_BRDF_FORMAT(NAME) extern const nqm_brdf_format NAME;
NQM_BRDF_FORMATS(NQM_DECLARE_BRDF_FORMAT)

/** The format of a file that is not empty; NULL: none. */
const nqm_brdf_format *nqm_brdf_format_of(const nqm_map *map);
/** Open a file of a format (NULL: fail), as its open() does. */
NQM_MUST_CHECK nqm_status nqm_brdf_open_file(const nqm_brdf_format *format, nqm_map *map,
                                             const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err);

/** The values of a BRDF whose format is "table" as a tensor "rgb": (n_h, n_d, n_p, 3), or (n_h, n_d, n_p, n_phi_h, 3). */
struct nqm_tensor nqm_table_tensor(const nqm_brdf *brdf);
/** The nodes of such a tensor; false: it has another shape. */
bool nqm_table_size_of(const struct nqm_tensor *tensor, nqm_table_size *size);

/** Whether the name of a .npy file is that of the weights of a layer of an NBRDF, "..._fc1.npy" or "..._b3.npy". */
bool nqm_nbrdf_is_part(const char *path);
/** Open the NBRDF of six such files, of which one is given. */
NQM_MUST_CHECK nqm_status nqm_nbrdf_open_parts(const char *path, const char *name, nqm_brdf **brdf_ret, nqm_error *err);

/** Fail with a fault of a tensor. */
nqm_status nqm_brdf_fail_tensor(const char *path, const struct nqm_tensor *tensor, const char *fault, nqm_error *err);
/** nqm_spectrum_weights() of `wavelengths` (n), NQM_F32 or NQM_U16, or the fault that makes them invisible. weights: (n, 3). */
NQM_MUST_CHECK nqm_status nqm_brdf_tensor_weights(const char *path, const struct nqm_tensor *wavelengths,
                                                  nqm_illuminant illuminant, double *weights, nqm_error *err);

/** A polarimetric material in a file of tensors, which has a tensor "M"; nqm_rgl_format opens it. */
struct nqm_tensor_file;
NQM_MUST_CHECK nqm_status nqm_pbsdf_open(nqm_map *map, const struct nqm_tensor_file *file, nqm_illuminant illuminant,
                                         const char *name, nqm_brdf **brdf_ret, nqm_error *err);

#endif
