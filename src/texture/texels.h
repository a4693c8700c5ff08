/* SPDX-License-Identifier: MIT
 *
 * texels.h - the texels of two textures beside each other: how each pair differs, groups of pairs that are alike, and the texels that
 * represent them.
 */
#ifndef NQM_SRC_TEXTURE_TEXELS_H
#define NQM_SRC_TEXTURE_TEXELS_H

#include "metric/metric.h"
#include "texture/evaluate.h"

/** A property that varies in one of both, or with the same model has different values. */
typedef struct nqm_pair_property {
    char key[48];
    size_t n;             /* components */
    bool has[2];          /* whether the model of each has it */
    int at[2];            /* its row among the values of each; -1: constant */
    float constant[2][3]; /* then this */
} nqm_pair_property;

/** A number that tells pairs apart: a component of the reference, of the test or, with the same model, their difference. Of colours
 *  their square roots are compared, whose steps are about equally visible. */
typedef struct nqm_pair_dimension {
    enum { NQM_DIFFERENCE, NQM_NORMAL, NQM_OF_REF, NQM_OF_TEST } kind;
    size_t property, component;
    float low, high;
} nqm_pair_dimension;

enum {
    NQM_MAX_PAIR_PROPERTIES = 2 * NQM_MAX_PROPERTIES,
    NQM_MAX_DIMENSIONS = 6 * NQM_MAX_PROPERTIES + 2,
    NQM_TEXEL_CHUNK = 64 * NQM_TEXEL_BLOCK /* texels of a task */
};

typedef struct nqm_texel_pair {
    const nqm_texture *side[2];
    size_t width, height, n;
    double period[2]; /* what of the surface is compared, along u and v */
    bool is_same_model, has_normals;
    size_t n_properties, n_dimensions;
    nqm_pair_property properties[NQM_MAX_PAIR_PROPERTIES];
    nqm_pair_dimension dimensions[NQM_MAX_DIMENSIONS];
} nqm_texel_pair;

/** Texels in groups of alike ones. Pairs that their dimensions do not tell apart are a group; if these are too many, groups are equal
 *  runs in an order in which similar pairs are near each other, so that a random texel of each is a stratified sample. */
typedef struct nqm_texel_groups {
    uint32_t *order; /* (n) the texels, group by group */
    size_t n, n_different;
    size_t n_groups;
    size_t *begin; /* (n_groups + 1) */
    bool is_sample;
} nqm_texel_groups;

/** Compare the properties of two textures. pair: the result, which needs no freeing. */
void nqm_texel_pair_begin(const nqm_texture *ref, const nqm_texture *test, nqm_texel_pair *pair);
/** Find the ranges of the dimensions, in one pass over all texels, and drop those that do not vary. */
NQM_MUST_CHECK nqm_status nqm_texel_pair_measure(nqm_texel_pair *pair, nqm_ticker *ticker, nqm_error *err);
/** Whether the normals of both differ anywhere, of a measured pair. */
bool nqm_texel_pair_tilts(const nqm_texel_pair *pair);
/** Whether it has no difference at all. */
bool nqm_texel_pair_is_equal(const nqm_texel_pair *pair);
/** Divide the texels, into at most max_groups groups if is_exact is not set. 24 bytes a texel. */
NQM_MUST_CHECK nqm_status nqm_texel_groups_find(const nqm_texel_pair *pair, size_t max_groups, bool is_exact,
                                                nqm_ticker *ticker, nqm_texel_groups *groups_ret, nqm_error *err);
void nqm_texel_groups_free(nqm_texel_groups *groups);

/** Floats of the workspace of nqm_texel_pair_evaluate(). */
size_t nqm_texel_pair_workspace(const nqm_texel_pair *pair);
/** The values of both at n <= NQM_TEXEL_BLOCK texels; texels NULL: those from `first` on. */
void nqm_texel_pair_evaluate(const nqm_texel_pair *pair, size_t n, const uint32_t *texels, size_t first,
                             float *workspace, const float *values[2]);
/** Component c of a property of one side at texel i of evaluated ones. */
float nqm_texel_pair_value(const nqm_pair_property *property, size_t side, const float *values, size_t c, size_t i);
/** The normal of one side there; (0, 0, 1) if it does not vary. */
void nqm_texel_pair_normal(const nqm_texel_pair *pair, size_t side, const float *values, size_t i, double normal[3]);
/** The normal of the test in the frame of the reference's, which the smallest rotation from (0, 0, 1) turned. */
void nqm_texel_pair_tilt(const double ref[3], const double test[3], double tilt[3]);

#endif
