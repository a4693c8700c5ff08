/* SPDX-License-Identifier: MIT
 *
 * plot.h - drawings of labels, models and BRDFs as SVG, PDF or PNG: the paper's figures and more. Needs cairo (NQM_CAIRO).
 *
 * The ending of the file name gives the format (".svg", ".pdf", ".png", any case). Colours are those of Okabe and Ito
 * (2008), chosen for colour-blind readers, and viridis. No file contains a date: the same input gives the same bytes on one
 * machine; fonts differ between machines. Functions return NQM_ERR_ARG (file name, options, a build without cairo),
 * NQM_ERR_IO, NQM_ERR_NOMEM, and the errors of reading their input: NQM_ERR_FORMAT with file and line for a malformed one,
 * NQM_ERR_INCOMPATIBLE for one without anything to draw.
 */
#ifndef NQM_FIGURES_PLOT_H
#define NQM_FIGURES_PLOT_H

#include "figures/picture.h"

#include <nqm/metric.h>
#include <nqm/percept.h>

/** Look of a drawing. Take the defaults from nqm_plot_options_default(). */
typedef struct nqm_plot_options {
    const char *title;    /**< NULL: automatic; "": none */
    double width, height; /**< CSS pixels (1/96 inch), 200 to 4000; 0: automatic; default 0 */
    double scale;         /**< PNG: pixels per CSS pixel, 0.5 to 8; default 2 */
} nqm_plot_options;

/** The defaults above. */
nqm_plot_options nqm_plot_options_default(void);

/**
 * JOD against Delta-E ITP of a labels CSV, with the curve fitted to it (paper, figure 1a).
 *
 * @param labels_csv  columns DeltaE, JOD; a column `model`, if there is one, gives the colour
 * @param fit         the curve and its statistics, by nqm_regress()
 * @param options     NULL: the defaults (here and below)
 */
NQM_MUST_CHECK nqm_status nqm_plot_curve(const char *path, const char *labels_csv, const nqm_regress_report *fit,
                                         const nqm_plot_options *options, nqm_error *err);

/** Spearman correlation of every predictor with labels or human scores, over all pairs and as the mean over materials, with 95 %
 *  intervals, best first (paper, figure 3); or the fraction of human choices that it predicts. eval_json: output of
 *  `nqm eval --json`. */
NQM_MUST_CHECK nqm_status nqm_plot_bars(const char *path, const char *eval_json, const nqm_plot_options *options,
                                        nqm_error *err);

/**
 * Prediction against label for each pair, coloured by the family of the distortion.
 *
 * @param pairs_csv  output of `nqm eval --pairs`: columns jod, one per predictor, family; an empty delta_e: jod has human scores,
 *                   whose scale is unknown. Scores of `nqm batch` (a column jod_low) are NQM_ERR_INCOMPATIBLE
 * @param predictor  column of the predictor; NULL: the column after jod, which is the model's
 */
NQM_MUST_CHECK nqm_status nqm_plot_predictions(const char *path, const char *pairs_csv, const char *predictor,
                                               const nqm_plot_options *options, nqm_error *err);

/** Training and validation loss over the epochs and, below, the learning rate of the first layer. log_csv (n, 1 to 8):
 *  output of `nqm train --log`, columns epoch, train_loss, validation_loss, lr_first. */
NQM_MUST_CHECK nqm_status nqm_plot_losses(const char *path, size_t n, const char *const *log_csv,
                                          const nqm_plot_options *options, nqm_error *err);

/** JOD over size, a line for each map: scores_csv is the output of `nqm batch` of a list with columns map and size. */
NQM_MUST_CHECK nqm_status nqm_plot_sizes(const char *path, const char *scores_csv, const nqm_plot_options *options,
                                         nqm_error *err);

/** Directions in half-vector coordinates: theta_d and phi_d over theta_h (paper, figure 1b). */
NQM_MUST_CHECK nqm_status nqm_plot_directions(const char *path, const nqm_directions *directions,
                                              const nqm_plot_options *options, nqm_error *err);

/** Where slices are taken. */
typedef struct nqm_slice_angles {
    double theta_d_rad, phi_d_rad; /**< of the slice over theta_h; theta_d 0 to below pi/2 */
    double azimuth_rad;            /**< of all slices, from the tangent: for anisotropic BRDFs */
} nqm_slice_angles;

/**
 * Luminance of BRDFs: over theta_h, over theta_d in the mirror direction (theta_h = 0), as polar lobes for light at 45
 * degrees, and in the plane of incidence for light at 15, 45 and 70 degrees; axes of f_r are logarithmic.
 *
 * @param brdfs  (n), n 1 to 8
 * @param names  (n) for the legend; NULL, or NULL members: nqm_plot_brdf_name()
 */
NQM_MUST_CHECK nqm_status nqm_plot_slices(const char *path, size_t n, const nqm_brdf *const *brdfs,
                                          const char *const *names, const nqm_slice_angles *angles,
                                          const nqm_plot_options *options, nqm_error *err);
/** What the drawing calls a BRDF: `given` up to 60 bytes; NULL: the file name without folder and ending, or the spec. */
void nqm_plot_brdf_name(const nqm_brdf *brdf, const char *given, char name[64]);

/** Where two BRDFs differ: a heat map over (theta_h, theta_d) of the mean absolute difference of log(f_r + 0.003) over
 *  phi_d, azimuths of anisotropic BRDFs, and channels, as in NQM_METRIC_LOG_DIFF. It compares the BRDFs (reference,
 *  test); no model is involved. `names` as for nqm_plot_slices(). */
NQM_MUST_CHECK nqm_status nqm_plot_attribution(const char *path, const nqm_brdf *const brdfs[2],
                                               const char *const *names, const nqm_plot_options *options,
                                               nqm_error *err);

/** The layers of a model's network as a table: sizes, parameters, multiplications (paper, figure 2). */
NQM_MUST_CHECK nqm_status nqm_plot_network(const char *path, const nqm_model *model, const nqm_plot_options *options,
                                           nqm_error *err);

#endif
