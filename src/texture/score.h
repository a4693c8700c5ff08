/* SPDX-License-Identifier: MIT
 *
 * score.h - what the parts of the score of two textures share.
 */
#ifndef NQM_SRC_TEXTURE_SCORE_H
#define NQM_SRC_TEXTURE_SCORE_H

#include "texture/texels.h"

/** A texel that represents others. */
typedef struct nqm_texel_choice {
    uint32_t texel;
    double weight; /* the sum of all is 1 */
} nqm_texel_choice;

/** The score of a texel pair. */
typedef struct nqm_texel_score {
    double delta_e, jod, jod_low, jod_high;
    nqm_label parts;
} nqm_texel_score;

typedef struct nqm_texture_job {
    const nqm_model *model;
    nqm_texture_options options;
    nqm_ticker ticker;
    nqm_texel_pair pair;
    nqm_texel_groups groups;
    nqm_scorer *scorer;
    float *workspace;
} nqm_texture_job;

/** What of the test the reference gets: a property by its number, or one of these. */
enum { NQM_EXCHANGE_ALL = -1, NQM_EXCHANGE_NORMAL = -2 };

/** Choose a texel of each group if there are at most max_n, or else of equal runs of the order of all; `of_runs`: always of these.
 *  choices: (max_n); returns how many. */
size_t nqm_texels_choose(const nqm_texel_groups *groups, size_t max_n, bool of_runs, uint64_t seed,
                         nqm_texel_choice *choices);
/** Score the reference beside itself with what is exchanged, at n texels. stage: for progress. */
NQM_MUST_CHECK nqm_status nqm_texels_score(nqm_texture_job *job, const char *stage, int exchange, size_t n,
                                           const nqm_texel_choice *choices, nqm_texel_score *scores, nqm_error *err);
/** Fill the blame of the result, the worst first. */
NQM_MUST_CHECK nqm_status nqm_texture_blame_find(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err);
/** Fill the far score of the result. */
NQM_MUST_CHECK nqm_status nqm_texture_score_far(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err);

#endif
