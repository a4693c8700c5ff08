/* SPDX-License-Identifier: MIT
 *
 * score.h - what the parts of the score of two textures share: the texels of both beside each other, groups of pairs
 * that are alike, and samples of them.
 */
#ifndef NQM_SRC_TEXTURE_SCORE_H
#define NQM_SRC_TEXTURE_SCORE_H

#include "metric/metric.h"
#include "texture/texture.h"

#include <stdatomic.h>

/** A number that tells pairs of texels apart: a component of the reference, of the test or, of the same model, their
 *  difference; or of the normal of the test in the frame of the reference's. Of colours the square roots are compared,
 *  whose steps are about equally visible. */
typedef struct nqm_texel_column {
    enum { NQM_DIFFERENCE, NQM_TILT, NQM_OF_REF, NQM_OF_TEST } kind;
    size_t property, component;
    float low, high;        /* at some texels */
    atomic_bool is_nonzero; /* anywhere */
} nqm_texel_column;

enum { NQM_MAX_COLUMNS = 6 * NQM_SCHEMA_MAX_KEYS + 2 };

/** Texels in an order in which similar pairs are near each other, so that a random one of each of equal runs is a
 *  stratified sample. */
typedef struct nqm_texel_order {
    uint32_t *texels; /* (n) owned; NULL: by number */
    size_t n, n_groups;
    size_t *begin; /* (n_groups + 1) of groups of equal keys, in the same block; NULL: of equal runs */
} nqm_texel_order;

/** A texel that represents others, and its score. */
typedef struct nqm_texel_sample {
    uint32_t texel;
    double weight; /* the sum of all is 1 */
    double delta_e, jod, jod_low, jod_high;
} nqm_texel_sample;

typedef struct nqm_texture_job {
    const nqm_model *model;
    nqm_texture_options options;
    nqm_ticker ticker;
    nqm_scorer *scorer;
    const nqm_texture *side[2];
    size_t width, height;
    double period[2];                /* what of the surface is compared, along u and v */
    bool is_same_model, has_normals; /* has_normals: those of a texture vary */
    size_t n_columns;
    nqm_texel_column columns[NQM_MAX_COLUMNS];
    nqm_texel_order order;
    size_t n_different;
    double correction, error; /* of the mean Delta-E, by nqm_texels_correct(); the error is 0 without */
} nqm_texture_job;

/** Compare the textures, and order their texels. 4 bytes a texel, and 16 more meanwhile. */
NQM_MUST_CHECK nqm_status nqm_texels_compare(nqm_texture_job *job, nqm_error *err);
/** Whether a property, of the same model, or the normal (NQM_TILT) differs anywhere. */
bool nqm_texels_differ(const nqm_texture_job *job, int kind, size_t property);
/** Choose a texel of each group, or of equal runs if these are more than max_n. samples: (max_n); returns how many. */
size_t nqm_texels_choose(const nqm_texel_order *order, size_t max_n, uint64_t seed, nqm_texel_sample *samples);
/** The first place of group or run k of n that were chosen. */
size_t nqm_texels_begin(const nqm_texel_order *order, size_t n, size_t k);

/** Receives n <= NQM_TEXEL_BLOCK samples and the rows of both textures there. */
typedef nqm_status nqm_texels_visitor(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                                      nqm_error *err);
/** Visit all samples; stage, for progress; NULL: it cannot be cancelled. */
NQM_MUST_CHECK nqm_status nqm_texels_visit(nqm_texture_job *job, const char *stage, size_t n, nqm_texel_sample *samples,
                                           nqm_texels_visitor *visit, void *user, nqm_error *err);
/** The normal of the test at visited texel i, in the frame of the reference's, which the smallest rotation from (0, 0,
 *  1) turned. */
void nqm_texels_tilt(const nqm_texture_job *job, const float *const rows[2], size_t i, double tilt[3]);

/** What of the test the reference gets: a property by its number, or one of these. FLAT: all but the normal. */
enum { NQM_EXCHANGE_ALL = -1, NQM_EXCHANGE_NORMAL = -2, NQM_EXCHANGE_FLAT = -3 };
/** Score the reference beside itself with what is exchanged. stage: for progress; parts: NULL, or a mean to which those
 *  of the samples are added. */
NQM_MUST_CHECK nqm_status nqm_texels_score(nqm_texture_job *job, const char *stage, int exchange, size_t n,
                                           nqm_texel_sample *samples, nqm_label *parts, nqm_error *err);
/** Set the correction of the mean Delta-E of n samples of runs, whose normals differ, and its standard error. */
NQM_MUST_CHECK nqm_status nqm_texels_correct(nqm_texture_job *job, size_t n, const nqm_texel_sample *samples,
                                             nqm_error *err);
/** Delta-E of a texel if the normals were equal, and the angle between its normals, radians. */
typedef struct nqm_covariates {
    double x[2];
} nqm_covariates;
/** The slopes of the Delta-E of n samples by both, by least squares; 0 by one that tells nothing more than the other. */
void nqm_covariate_slopes(size_t n, const nqm_texel_sample *samples, const nqm_covariates *x, double slope[2]);
/** Of two samples, for qsort(). */
int nqm_texels_compare_delta_e(const void *a, const void *b);
/** Fill the blame of the result, the worst first. */
NQM_MUST_CHECK nqm_status nqm_texture_blame_find(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err);
/** Score pixels of options.texels_per_pixel texels along each side, those that contain the samples; parts as in
 *  nqm_texels_score(). */
NQM_MUST_CHECK nqm_status nqm_pixels_score(nqm_texture_job *job, size_t n, nqm_texel_sample *samples, nqm_label *parts,
                                           nqm_error *err);
/** Choose at most max_n texels that represent all, those of equal runs of similar ones, and visit them; rows[0] has their values. */
NQM_MUST_CHECK nqm_status nqm_texture_visit(const nqm_texture *texture, size_t max_n, nqm_texels_visitor *visit,
                                            void *user, nqm_error *err);
/** Receives the values of a texture at evaluated position i, and writes a texel of so many bytes as the picture has channels. */
typedef void nqm_texel_writer(void *user, const float *rows, size_t i, unsigned char *out);
/** Write texels at the centres of the pixels of one period of the texture, of which tiles[0] x tiles[1] are its whole. picture: of
 *  bytes, with width, height and channels; receives pixels, nqm_raster_clear() it. ticker: stage "maps". */
NQM_MUST_CHECK nqm_status nqm_texture_write(const nqm_texture *texture, const size_t tiles[2], nqm_texel_writer *write,
                                            void *user, nqm_ticker *ticker, nqm_raster *picture, nqm_error *err);

/** Set the prediction of a result: of the means of n references and n tests (2 n) with different normals, by a model of slopes,
 *  weights (n) with the sum 1.
 *  The status of a BRDF that cannot be opened; NQM_ERR_CANCELLED. */
NQM_MUST_CHECK nqm_status nqm_texture_score_tilted(const nqm_model *model, size_t n, const nqm_subject *subjects,
                                                   const double *weights, nqm_ticker *ticker, nqm_score_result *result,
                                                   nqm_error *err);
/** Fill the far score of the result. */
NQM_MUST_CHECK nqm_status nqm_texture_score_far(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err);

#endif
