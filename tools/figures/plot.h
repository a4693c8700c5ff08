/* SPDX-License-Identifier: MIT
 *
 * nqm/plot.h - drawings of labels, models and BRDFs: the paper's figures and more, as SVG, PDF or PNG. In libnqm-full
 * only; needs cairo (CMake option NQM_CAIRO).
 *
 * The end of the file's name says the format (".svg", ".pdf", ".png", any case). Colours are those of Okabe and Ito
 * (2008), which colour-blind eyes tell apart, and viridis. No file holds a date: the same input gives the same bytes on
 * one machine; fonts differ between machines. Functions return NQM_ERR_ARG (name, options, a build without cairo), NQM_ERR_IO,
 * NQM_ERR_NOMEM, and what reading their input gives: NQM_ERR_FORMAT with file and line for a malformed one,
 * NQM_ERR_INCOMPATIBLE where there is nothing to draw.
 */
#ifndef NQM_PLOT_H
#define NQM_PLOT_H

#include <nqm/metric.h>
#include <nqm/percept.h>

/** How a drawing looks. Take the defaults from nqm_plot_options_default(). */
typedef struct nqm_plot_options {
    const char *title;    /**< on top; NULL: what is drawn; "": none */
    double width, height; /**< CSS pixels (1/96 inch), 200 to 4000; 0: what suits the drawing; default 0 */
    double scale;         /**< PNG: pixels a CSS pixel, 0.5 to 8; default 2 */
} nqm_plot_options;

/** The defaults above. */
nqm_plot_options nqm_plot_options_default(void);

/**
 * JOD against Delta-E ITP of a labels CSV with the curve fitted to it (the paper's figure 1a).
 *
 * @param labels_csv  columns DeltaE, JOD; a column `model`, where there is one, colours the points
 * @param fit         the curve and its statistics, by nqm_regress()
 * @param options     NULL: the defaults (here and below)
 */
NQM_MUST_CHECK nqm_status nqm_plot_curve(const char *path, const char *labels_csv, const nqm_regress_report *fit,
                                         const nqm_plot_options *options, nqm_error *err);

/**
 * Spearman correlation of every predictor with the labels, overall and as the mean over materials, with 95 % intervals
 * (the paper's figure 3): bars, best on top.
 *
 * @param eval_json  what `nqm eval --json` prints
 */
NQM_MUST_CHECK nqm_status nqm_plot_bars(const char *path, const char *eval_json, const nqm_plot_options *options,
                                        nqm_error *err);

/**
 * What a predictor says against the label, pair by pair, coloured by the family of the distortion.
 *
 * @param pairs_csv  what `nqm eval --pairs` writes: columns jod, a column a predictor, family
 * @param predictor  name of the predictor's column; NULL: the first, which is the model's
 */
NQM_MUST_CHECK nqm_status nqm_plot_predictions(const char *path, const char *pairs_csv, const char *predictor,
                                               const nqm_plot_options *options, nqm_error *err);

/**
 * Training and validation loss over the epochs and, below, the learning rate of the first layer.
 *
 * @param log_csv  (n) what `nqm train --log` writes: columns epoch, train_loss, validation_loss, lr_first; n 1 to 8
 */
NQM_MUST_CHECK nqm_status nqm_plot_losses(const char *path, size_t n, const char *const *log_csv,
                                          const nqm_plot_options *options, nqm_error *err);

/** Directions in half-vector coordinates: theta_d and phi_d over theta_h (the paper's figure 1b). */
NQM_MUST_CHECK nqm_status nqm_plot_directions(const char *path, const nqm_directions *directions,
                                              const nqm_plot_options *options, nqm_error *err);

/** Where nqm_plot_slices() cuts. */
typedef struct nqm_slice_options {
    double theta_d_rad, phi_d_rad; /**< of the slice over theta_h; default 0 and pi/2 */
    double theta_i_rad[3];         /**< light of the three cuts through the plane of incidence; below pi/2; default 15,
                                        45 and 70 degrees; the second is that of the polar lobes */
} nqm_slice_options;

/** The defaults above. */
nqm_slice_options nqm_slice_options_default(void);

/**
 * Luminance of BRDFs over each other: over theta_h, over theta_d in the mirror direction (theta_h = 0), as polar lobes,
 * and in the plane of incidence for three angles of the light; axes of f_r are logarithmic.
 *
 * @param brdfs   (n), n 1 to 8
 * @param names   (n) for the legend; NULL: the BRDFs' own
 * @param slices  NULL: the defaults
 */
NQM_MUST_CHECK nqm_status nqm_plot_slices(const char *path, size_t n, const nqm_brdf *const *brdfs,
                                          const char *const *names, const nqm_slice_options *slices,
                                          const nqm_plot_options *options, nqm_error *err);

/**
 * Where two BRDFs differ: a map over (theta_h, theta_d) of the mean absolute difference of log(f_r + 0.003) over phi_d
 * and channels, as in NQM_METRIC_LOG_DIFF. It shows the BRDFs, not what a network makes of them.
 */
NQM_MUST_CHECK nqm_status nqm_plot_attribution(const char *path, const nqm_brdf *ref, const nqm_brdf *test,
                                               const nqm_plot_options *options, nqm_error *err);

/** The layers of a model's network as a table: sizes, parameters, multiplications (the paper's figure 2). */
NQM_MUST_CHECK nqm_status nqm_plot_network(const char *path, const nqm_model *model, const nqm_plot_options *options,
                                           nqm_error *err);

#endif
