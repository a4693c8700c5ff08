/* SPDX-License-Identifier: MIT
 *
 * evaluate.h - a texture with decoded maps, and the values of its nodes at positions of the surface.
 */
#ifndef NQM_SRC_TEXTURE_EVALUATE_H
#define NQM_SRC_TEXTURE_EVALUATE_H

#include "brdf/core/spec.h"
#include "io/raster.h"
#include "material/material.h"
#include "texture/texture.h"

/** A decoded map. */
typedef struct nqm_texels {
    nqm_raster raster; /* of floats: linear already */
    float *table;      /* (2, 256 or 65536) of integers: the value of a colour, and of alpha */
    bool has_matrix;   /* of a colour space with other primaries: applied after interpolation */
    float matrix[3][3];
} nqm_texels;

/** A property that maps change. */
typedef struct nqm_varying {
    char key[48];
    uint16_t node;
    uint8_t n;        /* components of the property */
    size_t at;        /* its first row among the values of a texel */
    double low, high; /* its range */
} nqm_varying;

/** See nqm_texture. Its shading has the constant properties. */
struct nqm_texture {
    nqm_texture_info info;
    char *name, *argument; /* argument: of a BRDF that is none of a shading model; NULL: the shading is the material */
    nqm_materials *materials;
    nqm_textured *owned;      /* one of both owns `maps` */
    const nqm_textured *maps; /* NULL: none */
    nqm_shading shading;
    const nqm_spec_schema *schema; /* of the model; NULL with an argument */
    nqm_texels *images;            /* (maps->n_images) */
    double (*constants)[4];        /* (maps->n_nodes) of nodes that do not vary */
    uint8_t *roles;                /* (maps->n_nodes) nqm_node_role */
    uint16_t *rows;                /* (maps->n_nodes) the first row of each needed node in the workspace */
    size_t n_rows, n_values;
    size_t n_varying;
    nqm_varying varying[NQM_MAX_PROPERTIES];
    bool has_normal; /* the last three values are the normal */
    char words[1024];
};

typedef enum nqm_node_role { NQM_NODE_VARIES = 1, NQM_NODE_NEEDED = 2 } nqm_node_role;

enum { NQM_TEXEL_BLOCK = 256 };

/** Lay out the nodes that the outputs need; properties that do not vary become constants of the shading. */
NQM_MUST_CHECK nqm_status nqm_texture_prepare(nqm_texture *t, nqm_error *err);
/** Floats of the workspace of nqm_texture_evaluate(). */
size_t nqm_texture_workspace(const nqm_texture *t);
/** The values at n <= NQM_TEXEL_BLOCK positions, within the ranges of the model: (n_values, NQM_TEXEL_BLOCK), in the
 *  workspace. */
const float *nqm_texture_evaluate(const nqm_texture *t, size_t n, const double *u, const double *v, float *workspace);
/** Build the table or matrix of a decoded map, or decode its floats. NQM_ERR_FORMAT: no such colour space. */
NQM_MUST_CHECK nqm_status nqm_texels_decode(nqm_texels *texels, const char *space, nqm_error *err);

/** Texels along u (axis 0) or v of one period of both, and by how many such periods the surface is tiled. */
size_t nqm_texture_tiles(const nqm_texture *ref, const nqm_texture *test, size_t axis, size_t *n_texels_ret);

/** The spec of the texel with these values, one in every `stride` floats; nqm_free(). NULL: out of memory. */
char *nqm_texture_spec(const nqm_texture *t, const float *values, size_t stride);
/** "tilt:...;of=SPEC" of a spec, which is freed, towards a unit vector; the spec itself where that is the normal. */
char *nqm_texture_tilt(char *spec, const double normal[3]);
/** The constant value of a property, or that of the model. */
void nqm_texture_constant(const nqm_texture *t, const char *key, float v[3]);
/** The key of the model; NULL: it has none of this name. */
const nqm_spec_key *nqm_texture_key(const nqm_texture *t, const char *key);

#endif
