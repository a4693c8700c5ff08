/* SPDX-License-Identifier: MIT
 *
 * nqm/brdf.h - BRDFs: open one from a file or a parameter string, or create one from a callback or a table in
 * memory; evaluate, check and save it.
 *
 * The half-vector coordinates are those of Rusinkiewicz (1998, DOI 10.1007/978-3-7091-6453-2_2): theta_h is the angle
 * between normal and half vector, theta_d the angle between half vector and light, phi_d the azimuth of the light about the
 * half vector, phi_h the azimuth of the half vector about the normal, from the tangent (the first axis). phi_h is 0 where it is not
 * named (isotropy); phi_d is in [0, pi) (reciprocity).
 */
#ifndef NQM_BRDF_H
#define NQM_BRDF_H

#include <nqm/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** An RGB BRDF f_r(wi, wo) over unit vectors with the axes tangent, bitangent and normal. Immutable; any number of threads
 *  may evaluate it at the same time. */
typedef struct nqm_brdf nqm_brdf;

/** Result of the evaluation of one direction pair. */
typedef enum nqm_value_flag {
    NQM_VALUE_OK = 0,      /**< finite and not negative */
    NQM_VALUE_CLAMPED = 1, /**< a channel was negative (out of gamut) and was replaced by 0; usable */
    NQM_VALUE_INVALID = 2, /**< no value: empty table cell, or a channel is NaN or infinite; rgb is 0,0,0 */
    NQM_VALUE_HORIZON = 3  /**< light or viewer at or below the horizon; rgb is 0,0,0 */
} nqm_value_flag;
/** 1 for NQM_VALUE_OK and NQM_VALUE_CLAMPED, 0 for flags without a value. */
static inline uint8_t nqm_has_value(uint8_t flag) {
    return flag < NQM_VALUE_INVALID;
}

/** Facts about a BRDF. The strings belong to the BRDF and are valid until it is freed. */
typedef struct nqm_brdf_info {
    const char *format;     /**< "merl", "rgl", "utia", "nbrdf", "nps", "table", "callback", "ggx", "perturb", ... */
    const char *name;       /**< the path or spec that was opened, or the name given to nqm_brdf_create*() */
    const char *spec;       /**< analytic models: the canonical spec, which opens the same BRDF; otherwise NULL */
    const char *source_doi; /**< publication of the format or of the parameters, "10...."; NULL if there is none */
    const char *layout;     /**< one line: resolution or parameters ("90 x 90 x 180 cells"); NULL if there is none */
    size_t n_values;        /**< number of stored values: cells times channels, weights, or parameters */
    size_t n_bytes;         /**< size of the file; 0 if the BRDF has no file */
    const char *remark;     /**< what of the file is not used, or is assumed; NULL: nothing */
    int reciprocal;         /**< 1 when f_r(wi,wo) = f_r(wo,wi) by construction */
    int isotropic;          /**< 1 when turning light and viewer about the normal changes nothing, by construction */
} nqm_brdf_info;

/**
 * Open a BRDF from a path or a spec.
 *
 * The format of a file is recognised by its first bytes or its size, not by its name:
 *  - `PATH`: MERL `.binary` (also DTU, and 360 phi_d), RGL `*_rgb.bsdf` and `*_spec.bsdf`, UTIA `.bin`, polarimetric `.pbsdf`
 *    (its unpolarised part), NBRDF `.h5` or six `.npy` or their folder, a table `.npy`, a CSV of directions and values, a BSDF table of
 *    Zemax, a `.mat` of the paper's authors, a safetensors file of nqm_brdf_write();
 *  - `FILE.bsdf:E`, `FILE.bsdf:D65`: a spectral file as linear RGB under this illuminant, adapted so that a constant spectrum
 *    is grey; without a suffix E;
 *  - `FILE.csv:DEGREES`: a CSV (or another list) of scattered directions: no value (NQM_VALUE_INVALID) at pairs further than this from every row;
 *    without a suffix 0.1 degrees (doc/files.md);
 *  - `ARCHIVE.zip:MATERIAL`: an NBRDF inside a zip archive;
 *  - `DIR/nps_decoder_f32le.bin:MATERIAL`: a neural-process BRDF; nps_latents.csv must be in the same folder;
 *  - `FILE`, or `FILE:MATERIAL` where it has several: a material of a renderer (<nqm/material.h>).
 *
 * A spec is one of
 *  - `MODEL:key=value;key=value`: an analytic model (`ggx:`, `cook-torrance:`, ...) with its parameters;
 *  - `TABLE:NAME`: a preset (`sgd:nickel`, `abc:nickel`);
 *  - `perturb:gloss=.8;tint=1.1,1,1;of=PATH_OR_SPEC`: a distorted copy of another BRDF;
 *  - `between:t=.3;with=(PATH_OR_SPEC);of=PATH_OR_SPEC`: a mixture of two BRDFs;
 *  - `rotate:deg=30;of=PATH_OR_SPEC`, `tilt:deg=5;azimuth=90;of=PATH_OR_SPEC`: a BRDF in another frame.
 *
 * doc/brdf.md lists every key with unit, range and default. A path that begins like a spec must be written with `./`. RGL
 * measurements are not exactly reciprocal: their parametrised direction (theta_i) is taken as the viewer (doc/files.md).
 *
 * @param path_or_spec  see above
 * @param brdf_ret      receives the BRDF; free with nqm_brdf_free()
 * @param err           optional
 * @return NQM_ERR_IO (missing, a directory, unreadable), NQM_ERR_FORMAT (malformed, or a material that is refused; byte_offset
 *         is the position),
 *         NQM_ERR_ARG (bad spec), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_open(const char *path_or_spec, nqm_brdf **brdf_ret, nqm_error *err);

/**
 * Evaluates a BRDF of the caller.
 *
 * Negative channels and values that are not finite are treated as in files: nqm_brdf_eval() replaces a negative channel by
 * 0 and flags the value NQM_VALUE_CLAMPED; a NaN or infinite channel means "no value here" and is flagged
 * NQM_VALUE_INVALID.
 *
 * @param user  nqm_brdf_callbacks.user
 * @param n     number of pairs, 1 to 512
 * @param wi    (n, 3) unit vectors to the light, wi.z > 0
 * @param wo    (n, 3) unit vectors to the viewer, wo.z > 0
 * @param rgb   (n, 3) receives f_r in 1/sr, without the cosine; linear RGB with BT.709 primaries
 */
typedef void (*nqm_brdf_eval_fn)(void *user, size_t n, const double *wi, const double *wo, double *rgb);

/** A BRDF of the caller, for nqm_brdf_create(). Zero-initialise it; only `eval` is required. */
typedef struct nqm_brdf_callbacks {
    nqm_brdf_eval_fn eval;    /**< must return the same values whenever it gets the same directions */
    void (*free)(void *user); /**< called once by nqm_brdf_free(); NULL: nothing to free */
    void *user;               /**< passed to both functions */
    const char *name;         /**< name in messages and nqm_brdf_info; copied; NULL: "callback" */
    int reciprocal;           /**< 1: f_r(wi,wo) = f_r(wo,wi) always; reported by nqm_brdf_get_info(), not checked */
    int serialize; /**< 0: threads of the library call `eval` concurrently; 1: never two calls at the same time
                                   (a mutex of this BRDF is held during the call, so `eval` must not evaluate this BRDF) */
} nqm_brdf_callbacks;

/**
 * Create a BRDF that the caller evaluates, for example the one of a renderer.
 *
 * Whether it is isotropic is measured where that matters (nqm_brdf_check_report.anisotropy).
 *
 * @param callbacks  copied
 * @param brdf_ret   receives the BRDF; free with nqm_brdf_free(). On failure `callbacks->free` is not called.
 * @return NQM_ERR_ARG (`callbacks` or `eval` is NULL), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_create(const nqm_brdf_callbacks *callbacks, nqm_brdf **brdf_ret,
                                                  nqm_error *err);

/**
 * Create a BRDF from a table over half-vector coordinates, with linear interpolation between nodes:
 *
 *     theta_h of node i = (i / (n_theta_h - 1))^2 pi/2    (dense at the mirror direction, like the cells of MERL files)
 *     theta_d of node j = j / (n_theta_d - 1) pi/2
 *     phi_d   of node k = k / n_phi_d pi                  (periodic)
 *
 * nqm_brdf_write() writes it, nqm_brdf_open() reads it back to the same values. Linear interpolation is done in
 * sqrt(theta_h), theta_d and phi_d. Negative channels are allowed and flagged NQM_VALUE_CLAMPED at evaluation.
 *
 * @param n_theta_h, n_theta_d  nodes, >= 2
 * @param n_phi_d               nodes, >= 1; at most 2^24 nodes in total
 * @param rgb   (n_theta_h, n_theta_d, n_phi_d, 3) f_r in 1/sr, copied. NaN in channel 0 marks a node without a value; it is
 *              left out of the interpolation, and a point whose neighbours all have none is NQM_VALUE_INVALID
 * @param name  for messages and nqm_brdf_info.name; copied; NULL: "table"
 * @return NQM_ERR_ARG (`rgb` is NULL, or a channel is infinite, or NaN where channel 0 is not), NQM_ERR_LIMIT (number of
 *         nodes), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_create_table(size_t n_theta_h, size_t n_theta_d, size_t n_phi_d,
                                                        const float *rgb, const char *name, nqm_brdf **brdf_ret,
                                                        nqm_error *err);

/** Free a BRDF; NULL is allowed. */
NQM_API void nqm_brdf_free(nqm_brdf *brdf);

/** Facts about `brdf`. */
NQM_API nqm_brdf_info nqm_brdf_get_info(const nqm_brdf *brdf);

/**
 * Evaluate f_r (1/sr, without the cosine) for n direction pairs.
 *
 * The results are finite and >= 0. Pairs outside the upper hemisphere give 0 and NQM_VALUE_HORIZON.
 *
 * @param n     number of pairs
 * @param wi    (n, 3) unit vectors to the light
 * @param wo    (n, 3) unit vectors to the viewer
 * @param rgb   (n, 3) receives f_r
 * @param flag  (n) receives an nqm_value_flag each; NULL allowed
 */
NQM_API void nqm_brdf_eval(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo, double *rgb,
                           uint8_t *flag);

/**
 * As nqm_brdf_eval(), for half-vector coordinates. Tables and networks over these coordinates are evaluated without
 * converting to vectors and back.
 *
 * @param hd  (n, 3) theta_h in [0, pi/2], theta_d in [0, pi/2], phi_d (any; period 2 pi), radians
 */
NQM_API void nqm_brdf_eval_half_diff(const nqm_brdf *brdf, size_t n, const double *hd, double *rgb, uint8_t *flag);

/**
 * Evaluate f_r of an analytic model (a spec or a preset of one) and its exact derivatives by its parameters: the values
 * of the keys in the order of nqm_brdf_info.spec, three for an RGB key (red, green, blue) and two for a key with two
 * values (x, y), also where the spec has one number for all. Their number, n_parameters, is nqm_brdf_info.n_values.
 *
 * A channel depends only on its own value of an RGB key; the entries of the other two are 0. All entries are 0 below the
 * horizon, in a channel that was negative and is replaced by 0, and in all channels when one is not finite. At a kink the
 * derivative is that of the branch that the evaluation takes:
 *  - lafortune: the lobe has derivatives 0 where the generalised cosine is not positive; at -cxy = cz it is scaled by cxy;
 *  - sgd: the shadowing has derivatives 0 where it is 0, or 1 to double precision; theta = theta0 belongs to 1;
 *  - Fresnel terms of eta: 0 by eta where eta^2 + cos^2 - 1 is 0 in double precision (eta = 1 at grazing).
 * The shading models of renderers are differentiated by differences of second order, with a relative error of about 1e-7 away from
 * kinks; that takes as long as two evaluations for each parameter.
 *
 * Minima and maxima of directions (the V-grooves, max(cos theta_i, cos theta_o)) do not depend on parameters. At the ends of a
 * key's range the formula is differentiated as inside it. Allocates nothing; takes 1.4 to 2 times as long as nqm_brdf_eval().
 *
 * @param n         number of pairs
 * @param wi        (n, 3) unit vectors to the light
 * @param wo        (n, 3) unit vectors to the viewer
 * @param rgb       (n, 3) receives f_r in 1/sr, the same bits as nqm_brdf_eval()
 * @param jacobian  (n, 3, n_parameters) receives d f_channel / d parameter
 * @return NQM_ERR_ARG: `brdf` is not analytic (a file, a callback, a BRDF made of others)
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_jacobian(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo,
                                                    double *rgb, double *jacobian, nqm_error *err);

/** (theta_h, theta_d, phi_d) to unit vectors, with phi_h = 0. hd, wi, wo: (3). */
NQM_API void nqm_half_diff_to_directions(const double *hd, double *wi, double *wo);

/** Unit vectors to (theta_h, theta_d, phi_d); phi_d in [0, pi) by reciprocity. hd, wi, wo: (3). */
NQM_API void nqm_directions_to_half_diff(const double *wi, const double *wo, double *hd);

/** Files that nqm_brdf_write() writes (doc/files.md). */
typedef enum nqm_file_format {
    NQM_FILE_MERL = 0, /**< MERL `.binary`, 90 x 90 x 180 cells: f_r at phi_d in [0, pi), which makes it reciprocal */
    NQM_FILE_MERL_360, /**< the same layout with 90 x 90 x 360 cells: distinguishes light and viewer */
    /** `.npy` of NumPy, float32 (n_theta_h, n_theta_d, n_phi_d, 3), or n_phi_h before the 3 if it is anisotropic: the nodes of a BRDF
     *  whose format is "table", otherwise 90 x 46 x 24 (x 48) nodes as of nqm_brdf_create_table(), NaN where there is no value; phi_h of
     *  node m = m / n_phi_h 2 pi */
    NQM_FILE_NPY,
    /** safetensors, of a BRDF whose format is "nbrdf" (a small network) or "table"; it opens to the same values */
    NQM_FILE_SAFETENSORS,
    /** material file of a renderer with one material, of a shading model that the format has; the extension selects the format. It
     *  opens to the same BRDF within the precision of the format */
    NQM_FILE_MATERIAL
} nqm_file_format;

/**
 * Write a BRDF to a file, which nqm_brdf_open() reads. MERL: f_r at the centres of the cells, -1 in cells that are invalid or below
 * the horizon. The file appears under its name only when complete.
 *
 * @param name           of a material: letters, digits and '_'; other characters are replaced by '_'; NULL: "material"
 * @param progress       of MERL files; may be NULL
 * @param progress_user  passed to `progress`
 * @return NQM_ERR_ARG (unknown format, MERL for an anisotropic BRDF, or a BRDF, an extension or a shading model that the format does not
 *         have), NQM_ERR_IO, NQM_ERR_CANCELLED (by `progress`), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_write(const nqm_brdf *brdf, nqm_file_format format, const char *name,
                                                 const char *path, nqm_progress_fn progress, void *progress_user,
                                                 nqm_error *err);

/** Name of built-in preset i ("sgd:nickel", ...), NULL after the last; static storage. */
NQM_API const char *nqm_brdf_preset_name(size_t i);

/** Physical plausibility of a BRDF, from nqm_brdf_check(). */
typedef struct nqm_brdf_check_report {
    size_t n_pairs;   /**< direction pairs tested: 8192, or those of a list of measured directions */
    size_t n_clamped; /**< pairs with NQM_VALUE_CLAMPED */
    size_t n_invalid; /**< pairs with NQM_VALUE_INVALID */
    /** Median of |f(a,b)-f(b,a)| / mean (luminance) over pairs with a mean above 1e-4 1/sr; 0: there is none; NaN: no pair has a
     *  value in both orders. */
    double reciprocity_median;
    double reciprocity_p95; /**< 95th percentile of the same */
    /** Mean of |f - f turned| / mean (luminance) over pairs of all widths of lobes and random turns about the normal; 0
     *  if isotropic by construction, or below 1e-5; at most 2; NaN: no pair has a value. */
    double anisotropy;
    /** Largest directional-hemispherical albedo, theta_i 0 to 75 degrees, per channel; NaN: unknown. */
    double albedo_max[3];
    double albedo_max_theta_rad; /**< angle of incidence at which the largest of the three occurs */
} nqm_brdf_check_report;

/**
 * Measure reciprocity, energy conservation and positivity.
 *
 * The albedo integrates f_r cos(theta_o) over the hemisphere with half-vector importance sampling, which resolves lobes of
 * 0.2 degrees. The same seed gives the same report. A list of measured directions that has a value at less than half of random
 * pairs is tested at its own directions; its albedo is unknown.
 *
 * @return NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_check(const nqm_brdf *brdf, uint64_t seed, nqm_brdf_check_report *report_ret,
                                                 nqm_error *err);

/** Where the values of two BRDFs differ most, from nqm_brdf_compare(). */
typedef struct nqm_brdf_difference {
    int is_equal;       /**< 1: no pair of directions differs, and none is missing */
    size_t n_pairs;     /**< pairs where one of them has a value */
    size_t n_different; /**< pairs with a channel that differs by more than the tolerance */
    size_t n_missing;   /**< pairs where only one of them has a value */
    /** Largest |ref - test| / max(ref, test, 1e-9 1/sr) of a channel, 0 to 1. */
    double largest;
    double wi[3], wo[3]; /**< directions of that difference */
    int channel;         /**< its channel: 0 red, 1 green, 2 blue */
    double ref, test;    /**< and the values there, 1/sr */
} nqm_brdf_difference;

/**
 * Compare the values of two BRDFs: whether a formula is implemented as it is specified, which a score cannot tell,
 * because people may not see the difference.
 *
 * Both are evaluated at 8192 random pairs of directions, half of them near the mirror direction, with polar angles up
 * to 89 degrees, and at the directions of lists.
 *
 * @param tolerance  largest relative difference of equal values, 0 or more
 * @param seed       of the pairs; the same seed gives the same answer
 * @return NQM_ERR_ARG, NQM_ERR_INCOMPATIBLE (nowhere do both have a value), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_compare(const nqm_brdf *ref, const nqm_brdf *test, double tolerance,
                                                   uint64_t seed, nqm_brdf_difference *difference_ret, nqm_error *err);

/**
 * Directional-hemispherical albedo: the integral of f_r cos(theta_o) over the hemisphere of wo, for light along the tangent.
 *
 * @param theta_i_rad  polar angle of the light, 0 to pi/2
 * @param seed         of the quadrature's random offsets
 * @param rgb          (3) receives the albedo per channel
 */
NQM_API void nqm_brdf_albedo(const nqm_brdf *brdf, double theta_i_rad, uint64_t seed, double *rgb);

#ifdef __cplusplus
}
#endif
#endif
