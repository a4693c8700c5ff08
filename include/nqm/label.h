/* SPDX-License-Identifier: MIT
 *
 * nqm/label.h - labels by rendering: Delta-E ITP between pictures of two BRDFs, the curve from Delta-E to JOD and its
 * regression on human scores, and the making of training corpora. In libnqm-full only.
 */
#ifndef NQM_LABEL_H
#define NQM_LABEL_H

#include <nqm/brdf.h>
#include <nqm/fit.h>
#include <nqm/train.h>

#ifdef __cplusplus
extern "C" {
#endif

/** One line on what libnqm-full holds beside nqm_build_info(): the libraries that draw, trace rays and read pictures,
 *  with their versions or "off", and what is loaded when it is needed only; nothing is loaded to say so. Static storage.
 *  Any thread. */
NQM_API const char *nqm_full_build_info(void);

/* ---- colour ------------------------------------------------------------------------------------------------------ */

/** Linear BT.709 RGB in cd/m2 to ITP (ITU-R BT.2124: I, T = Ct/2, P of ICtCp, PQ of SMPTE ST 2084). Negative channels
 *  count as 0, channels above 10000 as 10000. rgb_cdm2, itp: (3). */
NQM_API void nqm_itp_from_rgb(const double *rgb_cdm2, double *itp);
/** Delta-E ITP of two colours: 720 times their distance in ITP (ITU-R BT.2124). rgb_cdm2: (3) each. */
NQM_API double nqm_delta_e_itp(const double *rgb_a_cdm2, const double *rgb_b_cdm2);

/* ---- JOD curve --------------------------------------------------------------------------------------------------- */

/** JOD = 10 (1 - 1 / (1 + exp(b1 (-(max(Delta-E, 0)^b3) - b2)))) (paper, eq. 1). */
typedef struct nqm_curve {
    double b1, b2, b3;
} nqm_curve;

/** The coefficients behind the authors' published labels, in full precision. */
NQM_API nqm_curve nqm_curve_default(void);
/** JOD in [0, 10]; Delta-E 0 (or less) gives exactly 10. */
NQM_API double nqm_curve_jod(const nqm_curve *curve, double delta_e);

typedef struct nqm_regress_report {
    nqm_curve curve;
    double rmse;     /**< of JOD */
    double spearman; /**< of Delta-E with JOD (negative: more difference, less quality) */
    size_t n;
} nqm_regress_report;

/** Fit the curve to n pairs (delta_e, jod) by Levenberg-Marquardt from several starts; n >= 4. */
NQM_API NQM_MUST_CHECK nqm_status nqm_regress(size_t n, const double *delta_e, const double *jod,
                                              nqm_regress_report *report_ret, nqm_error *err);
/** The same for a CSV with columns DeltaE and JOD (any order, any case; others ignored). */
NQM_API NQM_MUST_CHECK nqm_status nqm_regress_csv(const char *path, nqm_regress_report *report_ret, nqm_error *err);

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/** A scene in which BRDFs are compared: a shape under a light, on a turntable, seen from far away (without
 *  perspective). The light and the viewer stand still. Immutable. */
typedef struct nqm_scene nqm_scene;

typedef struct nqm_scene_options {
    const char *light;    /**< latitude-longitude map: RGBE in PNG, OpenEXR or Radiance HDR; NULL: a built-in sky */
    const char *shape;    /**< "sphere", "blob" (a built-in smooth shape with hollows, which shadows itself), or a mesh
                               file (PLY, OBJ), which is centred and scaled to the picture; NULL: "sphere" */
    size_t width, height; /**< picture in pixels: every pixel that shows the shape is a point. 0 (default): n_points
                               instead, spread evenly over the pictures of all frames, which is quicker */
    size_t n_points;      /**< surface points in all, where width is 0; default 3072 */
    size_t n_frames;      /**< views of the turntable, evenly over 360 degrees; default 1 */
    double turn_rad;      /**< angle of the turntable in the first frame, its front to the right; default 0 */
    double elevation_rad; /**< of the viewer above the horizon of the light map, -pi/2 to pi/2; default 0 */
    size_t n_lights;      /**< light directions a point; 0 (default): 128, or 96 where width is not 0 */
    size_t light_width;   /**< the light map is filtered to light_width x light_width / 2 cells; a multiple of 16 up to
                               4096; default 256 */
    int shadows;          /**< 1: the shape keeps light from itself; default 1 */
    int interreflection;  /**< 1: light that the shape reflects once onto itself; default 0 */
    double exposure_cdm2; /**< luminance at which a white Lambert surface shows on average over the points, with no
                               shadows and no interreflection; default 200 */
    double peak_cdm2;     /**< display peak; brighter is clipped; default 1000 */
    uint64_t seed;        /**< default 1 */
} nqm_scene_options;

/** The defaults above. */
NQM_API nqm_scene_options nqm_scene_options_default(void);
/** Light directions a point: n_lights, or what 0 stands for. */
NQM_API size_t nqm_scene_options_lights(const nqm_scene_options *options);
/** Make a scene; options NULL: the defaults. Every visible point gets light directions of its own, and what shadows
 *  leave of their light, once: the balance heuristic of multiple importance sampling (Veach and Guibas 1995, DOI
 *  10.1145/218380.218498) over light map, mirror lobes of five widths and cosine. NQM_ERR_ARG (an option is out of its
 *  range; a shape other than the sphere in a build without Embree), or what reading the light map or mesh gives. */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_create(const nqm_scene_options *options, nqm_scene **scene_ret,
                                                   nqm_error *err);
/** Free a scene; NULL is allowed. */
NQM_API void nqm_scene_free(nqm_scene *scene);
/** Number of surface points, of all frames together. */
NQM_API size_t nqm_scene_count(const nqm_scene *scene);
/** Light reflected at each point: rgb_cdm2 (n_points, 3), before the clip at the display's peak. All BRDFs share points
 *  and light directions, so that equal BRDFs give equal pictures to the bit. Deterministic. */
NQM_API NQM_MUST_CHECK nqm_status nqm_scene_render(const nqm_scene *scene, const nqm_brdf *brdf, double *rgb_cdm2,
                                                   nqm_error *err);
/** The share of the picture for which each point stands: (n_points), summing to 1. Only for scenes of a mesh or blob
 *  without a width, where points are denser in possible highlights; NULL otherwise: all alike. Lent by the scene. */
NQM_API const double *nqm_scene_shares(const nqm_scene *scene);
/** Mean Delta-E ITP over the points (by their shares) of two renderings of the scene; equal pictures give exactly 0. */
NQM_API double nqm_scene_delta_e(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2);
/** The same, point by point: delta_e (n_points). */
NQM_API void nqm_scene_delta_e_map(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2,
                                   double *delta_e);
/** Where the points lie: index (n_points) = (frame * height + y) * width + x, first row on top. Only for scenes with a
 *  width; NULL otherwise. Lent by the scene. */
NQM_API const size_t *nqm_scene_pixels(const nqm_scene *scene);
/** The light map behind the shape in any frame, in a view 60 degrees high: rgb_cdm2 (height, width, 3). Only for scenes
 *  with a width. */
NQM_API void nqm_scene_background(const nqm_scene *scene, double *rgb_cdm2);

/* ---- comparing labels with somebody else's ----------------------------------------------------------------------- */

enum { NQM_COMPARE_MAX_ENCODINGS = 32 };

/** Our Delta-E beside theirs, over the references of one encoding. */
typedef struct nqm_compare_row {
    char encoding[32];
    size_t n;                          /**< references */
    double spearman, spearman_ci95[2]; /**< of ours with theirs; interval: bootstrap over references */
    double null_luminance; /**< of the mean luminance of the reference's picture with theirs: what an order of the
                                references alone reaches */
    double median_theirs, median_ours, median_ratio;
} nqm_compare_row;

typedef struct nqm_comparison {
    size_t n_encodings;
    nqm_compare_row rows[NQM_COMPARE_MAX_ENCODINGS]; /**< in the order of the file */
    nqm_compare_row pooled;                          /**< all pairs together; encoding "all" */
    double pooled_null_encoding; /**< Spearman of theirs with the median of the encoding over the other references */
    size_t n_triples, n_ordered; /**< references with ward, ggx and nbrdf; of them those with nbrdf < min(ggx, ward) in
                                        our Delta-E */
    size_t n_ordered_theirs;     /**< the same in theirs */
} nqm_comparison;

/**
 * Make our labels for pairs that somebody else has labelled, and compare: by rank over references, encoding by encoding,
 * because the encoding's name alone explains most of a pooled correlation.
 *
 * @param pairs_csv  columns reference, test (BRDFs; test `fit`: our own fit of the model that `encoding` names),
 *                   encoding, delta_e (theirs); rows of one reference side by side make it quicker
 * @param root       folder at which relative paths start; NULL: the current one
 * @param fit        options of the fits; NULL: the defaults
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_compare_labels(const char *pairs_csv, const char *root, const nqm_scene *scene,
                                                     const nqm_fit_options *fit, nqm_progress_fn progress,
                                                     void *progress_user, nqm_comparison *comparison_ret,
                                                     nqm_error *err);

/* ---- corpora ----------------------------------------------------------------------------------------------------- */

/** Which splits a dataset file holds. Test materials never share a file with training materials. */
typedef enum nqm_corpus_part {
    NQM_CORPUS_TRAINING = 0, /**< train and validation; without the kinds of distortion that are kept unseen */
    NQM_CORPUS_TEST          /**< test; all kinds */
} nqm_corpus_part;

typedef struct nqm_corpus_options {
    nqm_corpus_part part;    /**< default NQM_CORPUS_TRAINING */
    const char *root;        /**< folder at which relative paths of the list start; NULL: the list's own */
    nqm_scene_options scene; /**< where the labels are rendered; strings are lent */
    const char *checkpoint;  /**< folder that keeps finished groups, so that an interrupted run goes on; processes that
                                 share it share the work: each makes groups that no other has begun, and waits for the
                                 others' at the end; NULL: none */
    int work_only;           /**< 1: help those that share `checkpoint`, but write no dataset; default 0 */
    const char *models;      /**< models of nqm_fit() that encode each reference, with commas between them; "": none;
                                 NULL: all; default NULL */
    size_t n_perturbations;  /**< perturbed copies a reference; default 26 */
    uint64_t seed;           /**< default 1 */
    nqm_progress_fn progress;
    void *progress_user;
} nqm_corpus_options;

/** The defaults above. */
NQM_API nqm_corpus_options nqm_corpus_options_default(void);

/**
 * Make a dataset file from a list of materials: for each reference its encodings by every model of nqm_fit(), the other
 * forms of the same material that the list or the presets hold, and seeded perturbations; labels by rendering. What
 * cannot be fitted or rendered is left out and named in the manifest ("failures"). The manifest is stored in the file and
 * written beside it as PATH.json, there with the dataset's checksum. The file is the same for any number of threads and
 * processes.
 *
 * @param materials_csv  columns name, group, brdf (path or spec), source, split (train, validation, test); see
 *                       nqm_corpus_scan()
 * @param directions     where to sample
 * @param path           the dataset file to write; not "-"
 * @return besides what reading the inputs gives: NQM_ERR_ARG (options), NQM_ERR_INCOMPATIBLE (no material of this part),
 *         NQM_ERR_CANCELLED (finished groups are kept in `checkpoint`)
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_build(const char *materials_csv, const nqm_directions *directions,
                                                   const nqm_corpus_options *options, const char *path, nqm_error *err);

/**
 * Write the material list of a data folder: DIR/rgl/ *.bsdf, the members of DIR/nbrdf/ *.zip, the rows of
 * DIR/nps/nps_latents.csv, and the presets `sgd:`. Paths are relative to DIR. All forms of one material make one group.
 * The materials of DIR/labels/labels_real.csv are the test split; a seeded 15 % of the other groups are validation.
 *
 * @param data_dir  DIR
 * @param path      the CSV to write ("-" is standard output)
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_corpus_scan(const char *data_dir, uint64_t seed, const char *path,
                                                  nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
