/* SPDX-License-Identifier: MIT
 *
 * nqm/brdf.h - open any isotropic BRDF (measured, neural or analytic) and evaluate it for direction pairs.
 *
 * The half-vector coordinates are those of Rusinkiewicz (1998, DOI 10.1007/978-3-7091-6453-2_2): theta_h, the angle
 * between normal and half vector; theta_d, between half vector and light; phi_d, the azimuth of the light about the
 * half vector. phi_h is 0 (isotropy); phi_d lies in [0, pi) (reciprocity).
 */
#ifndef NQM_BRDF_H
#define NQM_BRDF_H

#include <nqm/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** An isotropic RGB BRDF. Immutable; may be evaluated by several threads at once. */
typedef struct nqm_brdf nqm_brdf;

/** What an evaluation found, per direction pair. */
typedef enum nqm_value_flag {
    NQM_VALUE_OK = 0,      /**< finite and not negative */
    NQM_VALUE_CLAMPED = 1, /**< some channel was negative in the data (out of gamut) and is given as 0; usable */
    NQM_VALUE_INVALID = 2, /**< the data hold no value here (empty cell, not finite); rgb is 0,0,0 */
    NQM_VALUE_HORIZON = 3  /**< light or viewer at or below the horizon; rgb is 0,0,0 */
} nqm_value_flag;

/** Facts about an opened BRDF. Strings are lent by the BRDF and live as long as it. */
typedef struct nqm_brdf_info {
    const char *format; /**< "merl", "rgl", "nbrdf", "table", "nps", "lambert", "ggx", "ward", "sgd", "perturb", ... */
    const char *name;   /**< the argument it was opened with */
    const char *spec;   /**< analytic models: the full canonical spec that opens the same BRDF; else NULL */
    const char *source_doi; /**< the publication of the format or parameters, "10...."; NULL if none */
    const char *layout;     /**< one line: resolution or parameters ("90x90x180 cells") */
    size_t n_values;        /**< stored numbers (cells, weights or parameters) */
    size_t n_bytes;         /**< size of the file; 0 for specs */
    int reciprocal;         /**< 1 when f_r(wi,wo) = f_r(wo,wi) by construction */
} nqm_brdf_info;

/**
 * Open a BRDF from a path or a spec.
 *
 * A path's format is found by its bytes, never by its name: MERL `.binary` (also DTU), RGL `*_rgb.bsdf` (isotropic),
 * NBRDF `.h5`, networks and tables of nqm_brdf_save(); `ARCHIVE.zip:MATERIAL` names an NBRDF inside a zip;
 * `DIR/nps_decoder_f32le.bin:MATERIAL` a neural-process reconstruction (its latents lie beside the decoder in
 * nps_latents.csv). A spec is
 * `MODEL:key=value;key=value` (`ggx:`, `cook-torrance:`, ... with parameters) or a preset `TABLE:NAME` (`sgd:nickel`,
 * `abc:nickel`), or a perturbation `perturb:gloss=.8;tint=1.1,1,1;of=PATH_OR_SPEC`. doc/brdf.md lists every key with
 * unit, range and default. RGL data are not quite reciprocal: their parametrised direction (theta_i) is taken as the
 * viewer (doc/files.md). A relative path that begins like a spec is opened as a path when written with `./`.
 *
 * @param path_or_spec  see above
 * @param brdf_ret      receives the BRDF; free with nqm_brdf_free()
 * @param err           optional
 * @return NQM_ERR_IO (missing, a directory, unreadable), NQM_ERR_FORMAT (malformed; byte_offset says where),
 *         NQM_ERR_ARG (bad spec), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_open(const char *path_or_spec, nqm_brdf **brdf_ret, nqm_error *err);

/** Free a BRDF; NULL is allowed. */
NQM_API void nqm_brdf_free(nqm_brdf *brdf);

/** Facts about `brdf`. */
NQM_API nqm_brdf_info nqm_brdf_get_info(const nqm_brdf *brdf);

/**
 * Evaluate f_r (1/sr, without the cosine) for n direction pairs.
 *
 * Values are never negative and always finite. Pairs outside the upper hemisphere give 0 and NQM_VALUE_HORIZON.
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
 * As nqm_brdf_eval(), for half-vector coordinates. Tables and networks stored in these coordinates are read without a
 * round trip through vectors.
 *
 * @param hd  (n, 3) theta_h in [0, pi/2], theta_d in [0, pi/2], phi_d (any; period 2 pi), radians
 */
NQM_API void nqm_brdf_eval_half_diff(const nqm_brdf *brdf, size_t n, const double *hd, double *rgb, uint8_t *flag);

/** (theta_h, theta_d, phi_d) to unit vectors, with phi_h = 0. hd, wi, wo: (3). */
NQM_API void nqm_half_diff_to_directions(const double *hd, double *wi, double *wo);

/** Unit vectors to (theta_h, theta_d, phi_d); phi_d in [0, pi) by reciprocity. hd, wi, wo: (3). */
NQM_API void nqm_directions_to_half_diff(const double *wi, const double *wo, double *hd);

/**
 * Write `brdf` as a MERL `.binary` table (90 x 90 x 180 cells, evaluated at cell centres; cells below the horizon or
 * invalid are -1). The file appears under its name only when complete.
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_write_merl(const nqm_brdf *brdf, const char *path, nqm_progress_fn progress,
                                                      void *progress_user, nqm_error *err);

/**
 * Write a BRDF that is a small network ("nbrdf") or a table ("table") as the safetensors file that nqm_brdf_open()
 * reads back to the same values (doc/files.md). Analytic models are kept as specs, measurements as their own files.
 *
 * @return NQM_ERR_ARG (another format), NQM_ERR_IO
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_save(const nqm_brdf *brdf, const char *path, nqm_error *err);

/** Number of presets ("sgd:nickel", ...) in the library. */
NQM_API size_t nqm_brdf_preset_count(void);
/** Name of preset i in [0, count), in the order of the tables; static storage. */
NQM_API const char *nqm_brdf_preset_name(size_t i);

/** Physical plausibility of a BRDF, from nqm_brdf_check(). */
typedef struct nqm_brdf_check_report {
    size_t n_pairs;              /**< direction pairs tested */
    size_t n_clamped;            /**< pairs with a negative channel in the data */
    size_t n_invalid;            /**< pairs without data */
    double reciprocity_median;   /**< median of |f(a,b)-f(b,a)| / mean, luminance, over pairs above 1e-4 1/sr */
    double reciprocity_p95;      /**< 95th percentile of the same */
    double albedo_max[3];        /**< largest directional-hemispherical albedo, theta_i 0 to 75 degrees, per channel */
    double albedo_max_theta_rad; /**< the angle of incidence at which the largest of them occurs */
} nqm_brdf_check_report;

/**
 * Measure reciprocity, energy conservation and positivity.
 *
 * The albedo integrates f_r cos(theta_o) over the hemisphere with half-vector importance sampling, so that lobes of 0.2
 * degrees are caught. Deterministic for a seed.
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_brdf_check(const nqm_brdf *brdf, uint64_t seed, nqm_brdf_check_report *report_ret,
                                                 nqm_error *err);

/**
 * Directional-hemispherical albedo: the integral of f_r cos(theta_o) over the viewer's hemisphere, for light at
 * theta_i_rad.
 *
 * @param rgb  (3) receives the albedo per channel
 */
NQM_API void nqm_brdf_albedo(const nqm_brdf *brdf, double theta_i_rad, uint64_t seed, double *rgb);

#ifdef __cplusplus
}
#endif
#endif
