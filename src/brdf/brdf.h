/* SPDX-License-Identifier: MIT
 *
 * brdf.h - the vtable that every BRDF implements, BRDFs made of arrays and of other BRDFs, and their files.
 *
 * core/brdf.c contains what is common to all: clamping and flagging of values, conversion of coordinates, information.
 * A file format is a file of formats/ with one struct (formats/format.h), a model is one of models/ (core/spec.h).
 * open.c and specs.c list them.
 */
#ifndef NQM_SRC_BRDF_H
#define NQM_SRC_BRDF_H

#include "base/base.h"
#include "math/math.h"
#include "schema/schema.h"
#include <nqm/brdf.h>

/** What a format implements. `self` is its own immutable state. All functions are thread-safe. */
typedef struct nqm_brdf_class {
    const char *format; /**< short name, as in nqm_brdf_info.format */
    int reciprocal;     /**< 1: always; 0: the caller of nqm_brdf_wrap() says it */
    bool anisotropic;   /**< 1: f_r may depend on the azimuth, unless nqm_brdf_wrap() is told that it does not */
    bool is_costly;     /**< a pair takes 10 us or more: many pictures or points are made from a table */

    /** Raw values for n pairs above the horizon (wi.z > 0 and wo.z > 0 are guaranteed): may be negative (out of gamut)
     * or not finite; NaN in channel 0 means "no data". wi, wo, rgb: (n, 3). NULL for formats stored in half-vector
     * coordinates: core/brdf.c converts and calls eval_half_diff. */
    void (*eval)(const void *self, size_t n, const double *wi, const double *wo, double *rgb);

    /** The same in half-vector coordinates hd (n, 3) = theta_h, theta_d, phi_d (radians; phi_d in [0, pi) of a
     * reciprocal BRDF, otherwise in [0, 2 pi)). NULL: core/brdf.c converts to vectors and calls eval. */
    void (*eval_half_diff)(const void *self, size_t n, const double *hd, double *rgb);

    /** Instead of it, for BRDFs that may be anisotropic. turn: (n, 2) sine and cosine of phi_h; NULL: 0. */
    void (*eval_turned)(const void *self, size_t n, const double *hd, const double *turn, double *rgb);

    /** As eval for at most 64 pairs, and the derivatives: jacobian (n, 3, info.n_values), zero on entry, receives d
     *  channel / d parameter in the entries that are not 0. rgb has the bits of eval. NULL: the format has no
     *  parameters. */
    void (*jacobian)(const void *self, size_t n, const double *wi, const double *wo, double *rgb, double *jacobian);

    /** Release `self`. */
    void (*free)(void *self);
} nqm_brdf_class;

/* Allocated as one block; the texts of `info`, except the DOI, follow the struct. */
struct nqm_brdf {
    const nqm_brdf_class *class_;
    void *self;
    nqm_brdf_info info;
};

/** Create a BRDF object that owns `self`; `self` is freed on failure too. The name, spec and layout of `info` are copied,
 *  the DOI is not; the format is that of the class. */
NQM_MUST_CHECK nqm_status nqm_brdf_wrap(const nqm_brdf_class *class_, void *self, const nqm_brdf_info *info,
                                        nqm_brdf **brdf_ret, nqm_error *err);

/** Add to the remark on a BRDF, which is another object then; on failure it is freed and NULL. */
NQM_MUST_CHECK nqm_status nqm_brdf_remark(nqm_brdf **brdf, const char *remark, nqm_error *err);

/** As nqm_brdf_eval_half_diff() of pairs that are turned about the normal. turn: (n, 2) sine and cosine of phi_h; NULL: 0. */
void nqm_brdf_eval_turned(const nqm_brdf *brdf, size_t n, const double *hd, const double *turn, double *rgb,
                          uint8_t *flag);

/** nqm_brdf_check_report.anisotropy; 0 without an evaluation if the BRDF is isotropic by construction. Takes 1,024 evaluations. */
double nqm_brdf_anisotropy(const nqm_brdf *brdf);

/** Where a lobe of half vectors is, and its shape: a circle of radius `width` about 0 becomes, by center + axes * (x,
 *  y), the ellipse of slopes h.xy / h.z at which it has fallen to a half. The determinant of `axes` is 1. */
typedef struct nqm_lobe {
    double center[2];
    double axes[4]; /* (2, 2) */
    double width;
} nqm_lobe;
/** The lobe of a BRDF about the peak of f_r(h, h) over h. Takes about 1,500 evaluations. */
nqm_lobe nqm_lobe_measure(const nqm_brdf *brdf);

/* ---- specs and files ---------------------------------------------------------------------------------------------- */

/** true when `text` starts with the name of a model, table of presets or wrapper and a colon ("ggx:..."). */
bool nqm_spec_probe(const char *text);
/** Whether a file begins as one of a BRDF, which may yet be damaged. */
bool nqm_brdf_probe(const char *path);

/* ---- files ------------------------------------------------------------------------------------------------------- */

/** Write a MERL table; n_phi: 180 or 360 cells of phi_d. */
NQM_MUST_CHECK nqm_status nqm_brdf_write_merl(const nqm_brdf *brdf, size_t n_phi, const char *path,
                                              nqm_progress_fn progress, void *progress_user, nqm_error *err);
/** Write an array of NumPy: a BRDF's own nodes if its format is "table", otherwise those of nqm_brdf_tabulate(), with several phi_h
 *  unless it is_isotropic. */
NQM_MUST_CHECK nqm_status nqm_brdf_write_npy(const nqm_brdf *brdf, bool is_isotropic, const char *path, nqm_error *err);
/** Write a network or a table as safetensors (NQM_FILE_SAFETENSORS). */
NQM_MUST_CHECK nqm_status nqm_brdf_save(const nqm_brdf *brdf, const char *path, nqm_error *err);
/** Write the spec of a shading model as NQM_FILE_MATERIAL. */
NQM_MUST_CHECK nqm_status nqm_material_write(const char *spec, const char *name, const char *path, nqm_error *err);
/** As nqm_material_write(): a file of n > 0 materials of one shading model, in this order; names that are equal get numbers. */
NQM_MUST_CHECK nqm_status nqm_brdf_write_materials(size_t n, const char *const *specs, const char *const *names,
                                                   const char *path, nqm_error *err);

/* ---- BRDFs of arrays and of other BRDFs --------------------------------------------------------------------------- */

/** The BRDF of values in their ranges: without a spec, and with the name of its model. */
NQM_MUST_CHECK nqm_status nqm_brdf_of_values(const nqm_values *values, nqm_brdf **brdf_ret, nqm_error *err);
/** "tilt:" of a BRDF, which the result owns, also on failure. */
NQM_MUST_CHECK nqm_status nqm_brdf_tilt_degrees(nqm_brdf *of, double deg, double azimuth_deg, nqm_brdf **brdf_ret,
                                                nqm_error *err);

/** The normal of the frame of a BRDF that is turned or tilted, in that of the surface; else (0, 0, 1). */
void nqm_brdf_frame_normal(const nqm_brdf *brdf, double normal[3]);
/** "tilt:" of a BRDF that outlives the result, with the normal (3), a unit vector with a positive third component. */
NQM_MUST_CHECK nqm_status nqm_brdf_tilt(nqm_brdf *of, const double *normal, nqm_brdf **brdf_ret, nqm_error *err);

enum { NQM_NBRDF_WEIGHTS = 6 * 21 + 21 + 21 * 21 + 21 + 21 * 3 + 3 };
/** An NBRDF from its weights (NQM_NBRDF_WEIGHTS): kernel (in, out) then bias, layer by layer, as in the Keras files. */
nqm_status nqm_nbrdf_create(const float *weights, const char *name, nqm_brdf **brdf_ret, nqm_error *err);
/** The weights of a BRDF whose format is "nbrdf", in that order; valid until it is freed. */
const float *nqm_nbrdf_weights(const nqm_brdf *brdf);

/** Nodes of a table. nqm_brdf_tabulate(): n_d n_p is at most NQM_TABLE_SLICE; n_phi_h = 0 stands for 1, or for
 *  NQM_TABLE_PHI_H if the BRDF is not isotropic by construction. */
typedef struct nqm_table_size {
    size_t n_h, n_d, n_p, n_phi_h; /**< of theta_h, theta_d, phi_d, phi_h; isotropic tables have one phi_h */
} nqm_table_size;

enum { NQM_TABLE_SLICE = 46 * 24, NQM_TABLE_PHI_H = 48 };
/** Nodes of corpora and exported tables. */
static const nqm_table_size nqm_table_general = {90, 46, 24, 0};
/** Nodes for pictures: twice as dense in theta_h, where highlights are narrow. */
static const nqm_table_size nqm_table_picture = {180, 32, 12, 0};

/** A table over half-vector coordinates with linear interpolation between nodes: theta_h of node i = (i / (n_h - 1))^2
 *  pi/2 (denser towards the mirror direction, as in MERL's files), theta_d of node j = j / (n_d - 1) pi/2, phi_d of
 *  node k = k / n_p pi, and phi_h of node m = m / n_phi_h 2 pi, which are periodic. rgb: (n_h, n_d, n_p, n_phi_h, 3) float at any
 *  alignment, copied; f_r in 1/sr, finite; NaN in channel 0: the node has no value and is excluded from the interpolation.
 *  NQM_ERR_LIMIT: fewer than 2 x 2 x 1 x 1 nodes, or more than 2^24. */
nqm_status nqm_table_create(nqm_table_size size, const void *rgb, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err);
/** Index of the first of the 3 n_nodes floats that is not finite at a node that has a value; 3 n_nodes when there is
 *  none. `rgb` at any alignment. */
size_t nqm_table_first_bad(size_t n_nodes, const void *rgb);
/** Coordinates of a node. hd: (3) receives theta_h, theta_d, phi_d in radians. */
void nqm_table_node(size_t n_h, size_t n_d, size_t n_p, size_t h, size_t d, size_t p, double *hd);
/** The values of a BRDF whose format is "table"; valid until it is freed. */
const float *nqm_table_values(const nqm_brdf *brdf, nqm_table_size *size);

typedef struct nqm_between_bases {
    nqm_brdf *of, *with;
    bool owns_of, owns_with; /* freed with the result, and on failure; false: borrowed */
} nqm_between_bases;

typedef struct nqm_spec_wrapper nqm_spec_wrapper;
/** The kind of BRDF made of others whose name and a colon begin the text; NULL: none. */
const nqm_spec_wrapper *nqm_spec_wrapper_of(const char *text);
/** Parse its settings, `with` and `of` left out. */
NQM_MUST_CHECK nqm_status nqm_wrapper_parse(const nqm_spec_wrapper *w, const char *settings, nqm_values *values,
                                            nqm_error *err);
/** Such a BRDF of opened ones. name: of the result; NULL: its spec. */
NQM_MUST_CHECK nqm_status nqm_wrapper_make(const nqm_spec_wrapper *w, const nqm_values *values,
                                           const nqm_between_bases *bases, const char *name, nqm_brdf **brdf_ret,
                                           nqm_error *err);

/** Sample `brdf` into a table, on all threads. ticker: stage "table"; NULL: silent. NQM_ERR_CANCELLED, NQM_ERR_NOMEM. */
NQM_MUST_CHECK nqm_status nqm_brdf_tabulate(const nqm_brdf *brdf, nqm_table_size size, nqm_ticker *ticker,
                                            nqm_brdf **table_ret, nqm_error *err);

#endif
