/* SPDX-License-Identifier: MIT
 *
 * brdf.h - the vtable that every BRDF implements, and the constructors of all formats.
 *
 * Each format has its own file with one constructor. brdf.c contains what is common to all: opening by content or by
 * spec, clamping and flagging of values, conversion of coordinates, information.
 */
#ifndef NQM_SRC_BRDF_H
#define NQM_SRC_BRDF_H

#include "base/base.h"
#include "math/math.h"
#include <nqm/brdf.h>

/** What a format implements. `self` is its own immutable state. All functions are thread-safe. */
typedef struct nqm_brdf_class {
    const char *format; /**< short name, as in nqm_brdf_info.format */
    int reciprocal;     /**< 1 when reciprocal by construction */
    bool is_costly;     /**< a pair takes 10 us or more: many pictures or points are made from a table */

    /** Raw values for n pairs above the horizon (wi.z > 0 and wo.z > 0 are guaranteed): may be negative (out of gamut)
     * or not finite; NaN in channel 0 means "no data". wi, wo, rgb: (n, 3). NULL for formats stored in half-vector
     * coordinates: brdf.c converts and calls eval_half_diff. */
    void (*eval)(const void *self, size_t n, const double *wi, const double *wo, double *rgb);

    /** The same in half-vector coordinates hd (n, 3) = theta_h, theta_d, phi_d (radians; phi_d in [0, pi) of a
     * reciprocal class, otherwise in [0, 2 pi)). NULL: brdf.c converts to vectors and calls eval. */
    void (*eval_half_diff)(const void *self, size_t n, const double *hd, double *rgb);

    /** As eval for at most 64 pairs, and the derivatives: jacobian (n, 3, info.n_values), zero on entry, receives d channel / d parameter in the
     * entries that are not 0. rgb has the bits of eval. NULL: the format has no parameters. */
    void (*jacobian)(const void *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian);

    /** Release `self`. */
    void (*free)(void *self);
} nqm_brdf_class;

/* One block; the texts of `info`, except the DOI, follow the struct. */
struct nqm_brdf {
    const nqm_brdf_class *class_;
    void *self;
    nqm_brdf_info info;
};

/** Create a BRDF object that owns `self`; `self` is freed on failure too. The name, spec and layout of `info` are copied,
 *  the DOI is not; format and reciprocity are those of the class. */
NQM_MUST_CHECK nqm_status nqm_brdf_wrap(const nqm_brdf_class *class_, void *self, const nqm_brdf_info *info,
                                        nqm_brdf **brdf_ret, nqm_error *err);

/* ---- BRDFs that a list names ------------------------------------------------------------------------------------- */

/** The argument of nqm_brdf_open() for a BRDF that is named in a list: specs and absolute paths unchanged, relative
 *  paths prefixed with the folder `root` of n_root characters (0: the working folder). NULL: out of memory. nqm_free()
 *  it. */
char *nqm_brdf_path_below(const char *path_or_spec, const char *root, size_t n_root);
/** The measured file that a material of the material file `path` names (material NULL: its only one); nqm_free() it. NULL: there is
 *  none, or nqm_brdf_open() reports why it cannot be read. */
char *nqm_brdf_measured(const char *path, const char *material);
/** Open such a BRDF; `root` NULL or "" is the working folder. */
NQM_MUST_CHECK nqm_status nqm_brdf_open_below(const char *path_or_spec, const char *root, nqm_brdf **brdf_ret,
                                              nqm_error *err);

/* ---- constructors, one per format -------------------------------------------------------------------------------- */

/* Files: `map` has the bytes of the whole file. On success the constructor owns the map (it keeps or closes it); on failure the
 * caller still owns it. */

/** true when the first bytes look like the format (a short or damaged file of that format must still be recognised
 * where possible, so that its message can name the fault). */
bool nqm_merl_probe(const nqm_map *map);
bool nqm_nbrdf_probe(const nqm_map *map);
bool nqm_saved_probe(const nqm_map *map);
nqm_status nqm_merl_open(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
/** Write a MERL table; n_phi: 180 or 360 cells of phi_d. */
NQM_MUST_CHECK nqm_status nqm_merl_write(const nqm_brdf *brdf, size_t n_phi, const char *path, nqm_progress_fn progress,
                                         void *progress_user, nqm_error *err);
nqm_status nqm_nbrdf_open(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
nqm_status nqm_saved_open(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
struct nqm_meta;
/** nqm_brdf_save() with more metadata, at most 8. */
NQM_MUST_CHECK nqm_status nqm_brdf_save_with(const nqm_brdf *brdf, const char *path, size_t n_more,
                                             const struct nqm_meta *more, nqm_error *err);
/** A table as an array of NumPy (nqm_npy_probe() of io.h); and any BRDF written as one: its own nodes if its format is "table",
 *  otherwise those of nqm_brdf_tabulate(). */
nqm_status nqm_npy_open(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_npy_write_brdf(const nqm_brdf *brdf, const char *path, nqm_error *err);
struct nqm_tensor_file;
/** A polarimetric material, which has a tensor "M"; see pbsdf.c. */
nqm_status nqm_pbsdf_open(nqm_map *map, const struct nqm_tensor_file *file, nqm_illuminant illuminant, const char *name,
                          nqm_brdf **brdf_ret, nqm_error *err);
/** Files of the tensor container: RGL materials and polarimetric ones. `illuminant` for spectra: "E" or "D65"; NULL: E. */
bool nqm_tensor_brdf_probe(const nqm_map *map);
nqm_status nqm_tensor_brdf_open(nqm_map *map, const char *illuminant, const char *name, nqm_brdf **brdf_ret,
                                nqm_error *err);
/** One material of an archive or of a decoder. */
nqm_status nqm_nbrdf_zip_open(const char *zip_path, const char *material, const char *name, nqm_brdf **brdf_ret,
                              nqm_error *err);
nqm_status nqm_nps_open(const char *decoder_path, const char *material, const char *name, nqm_brdf **brdf_ret,
                        nqm_error *err);

enum { NQM_NBRDF_WEIGHTS = 6 * 21 + 21 + 21 * 21 + 21 + 21 * 3 + 3 };
/** An NBRDF from its weights (NQM_NBRDF_WEIGHTS): kernel (in, out) then bias, layer by layer, as in the Keras files. */
nqm_status nqm_nbrdf_create(const float *weights, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
/** The weights of a BRDF whose format is "nbrdf", in that order; valid until it is freed. */
const float *nqm_nbrdf_weights(const nqm_brdf *brdf);

/** A table over half-vector coordinates with linear interpolation between nodes: theta_h of node i = (i / (n_h - 1))^2
 *  pi/2 (denser towards the mirror direction, as in MERL's files), theta_d of node j = j / (n_d - 1) pi/2, phi_d of
 *  node k = k / n_p pi, which is periodic. rgb: (n_h, n_d, n_p, 3) float at any alignment, copied; f_r in 1/sr, finite;
 *  NaN in channel 0: the node has no value and is excluded from the interpolation. NQM_ERR_LIMIT: fewer than 2 x 2 x 1
 *  nodes, or more than 2^24. */
nqm_status nqm_table_create(size_t n_h, size_t n_d, size_t n_p, const void *rgb, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err);
/** Index of the first of the 3 n_nodes floats that is not finite at a node that has a value; 3 n_nodes when there is
 *  none. `rgb` at any alignment. */
size_t nqm_table_first_bad(size_t n_nodes, const void *rgb);
/** Coordinates of a node. hd: (3) receives theta_h, theta_d, phi_d in radians. */
void nqm_table_node(size_t n_h, size_t n_d, size_t n_p, size_t h, size_t d, size_t p, double *hd);
/** The values of a BRDF whose format is "table"; valid until it is freed. dims: (3) receives n_h, n_d, n_p. */
const float *nqm_table_values(const nqm_brdf *brdf, size_t *dims);

/** true when the file has the size of the neural processes' decoder. */
bool nqm_nps_probe(const nqm_map *map);

/** true when `text` starts with the name of an analytic model and a colon ("ggx:..."). */
bool nqm_spec_probe(const char *text);
/** An analytic model, preset, perturbation or BRDF between two others from its spec. `name` is that of its information. */
nqm_status nqm_spec_open(const char *spec, const char *name, nqm_brdf **brdf_ret, nqm_error *err);

/** A perturbation of an opened BRDF: `settings` as in a `perturb:` spec, without `of`. The result owns `base` if `owned` (it
 *  is freed also on failure), otherwise it borrows it. */
nqm_status nqm_perturb_wrap(const char *settings, nqm_brdf *base, bool owned, nqm_brdf **brdf_ret, nqm_error *err);

/** A BRDF between two opened ones: `settings` as in a `between:` spec, without `with` and `of`. The result borrows
 *  both. */
nqm_status nqm_between_wrap(const char *settings, nqm_brdf *of, nqm_brdf *with, nqm_brdf **brdf_ret, nqm_error *err);

/** Nodes of a table (nqm_table_create()). */
typedef struct nqm_table_size {
    size_t n_h, n_d, n_p; /**< n_d n_p: at most NQM_TABLE_SLICE */
} nqm_table_size;

enum { NQM_TABLE_SLICE = 46 * 24 };
/** Of corpora and exported tables. */
static const nqm_table_size nqm_table_general = {90, 46, 24};
/** Of pictures: twice as dense in theta_h, where highlights are narrow. */
static const nqm_table_size nqm_table_picture = {180, 32, 12};

/** Sample `brdf` into a table, on all threads. ticker: stage "table"; NULL: silent. NQM_ERR_CANCELLED, NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_brdf_tabulate(const nqm_brdf *brdf, nqm_table_size size, nqm_ticker *ticker,
                                            nqm_brdf **table_ret, nqm_error *err);

/** As nqm_material_write(): a file of n > 0 materials of one shading model, in this order; names that are equal get numbers. */
NQM_MUST_CHECK nqm_status nqm_materials_write(size_t n, const char *const *specs, const char *const *names,
                                              const char *path, nqm_error *err);

#endif
