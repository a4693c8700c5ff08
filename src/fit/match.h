/* SPDX-License-Identifier: MIT
 *
 * match.h - the parts of a match: the text of a loss, and metrics as differentiable losses of fits.
 */
#ifndef NQM_SRC_FIT_MATCH_H
#define NQM_SRC_FIT_MATCH_H

#include "base/base.h"
#include <nqm/label.h>
#include <nqm/match.h>

enum { NQM_MATCH_MAX_TERMS = 8 };

/** What a term of a sum is. */
typedef enum nqm_match_kind { NQM_MATCH_VALUES, NQM_MATCH_METRIC, NQM_MATCH_TRANSPORT } nqm_match_kind;

typedef struct nqm_match_term {
    double weight;
    nqm_match_kind kind;
    nqm_fit_loss loss; /* of NQM_MATCH_VALUES */
} nqm_match_term;

typedef struct nqm_match_sum {
    bool is_auto;
    size_t n;
    nqm_match_term terms[NQM_MATCH_MAX_TERMS]; /* of "auto": those of the polish */
} nqm_match_sum;

/** The sum of "auto". */
extern const char *const nqm_match_polish;
/** nqm_match_report.selected where "auto" has no perceptual terms: the reference is anisotropic, or a list of few directions. */
extern const char *const nqm_match_uncovered;
/** NQM_ERR_ARG names the word at fault. */
NQM_MUST_CHECK nqm_status nqm_match_parse(const char *text, nqm_match_sum *sum, nqm_error *err);

/** A difference from one reference, as a loss of a fit: a metric, or Delta-E on rays of a scene. Used by one thread at
 *  a time; it must not be moved. */
typedef struct nqm_match_visual {
    nqm_fit_visual visual;
    nqm_error failure; /* of the last evaluation */
    /* of a metric: */
    nqm_scorer *scorer;
    nqm_score_quantity quantity; /* NQM_SCORE_JOD: the loss is 10 minus it */
    float *ref, *test, *slopes;  /* (n, 3); ref owns the block of the arrays */
    uint8_t *used;               /* (n) */
    /* of a scene: */
    nqm_rays rays;
    double *ref_rgb; /* (rays.n, 3) */
} nqm_match_visual;

/** NQM_ERR_INCOMPATIBLE: too few directions have a value, or the reference is anisotropic. Free it also after a failure. */
NQM_MUST_CHECK nqm_status nqm_match_visual_make(const nqm_model *model, const nqm_brdf *ref, nqm_match_visual *visual,
                                                nqm_error *err);
/** Delta-E on n random rays of a scene. It judges fits, by a seed of which no step of an optimiser has seen the rays,
 *  and is the loss 'transport' of anisotropic references. Free it also after a failure. */
NQM_MUST_CHECK nqm_status nqm_match_rays_make(const nqm_scene *scene, const nqm_brdf *ref, size_t n, uint64_t seed,
                                              nqm_match_visual *visual, nqm_error *err);
void nqm_match_visual_free(nqm_match_visual *visual);

#endif
