/* SPDX-License-Identifier: MIT
 *
 * texture.h - textured materials inside the library: a texture with decoded maps, and the values of its nodes at positions of the
 * surface. The public functions are declared in <nqm/texture.h>.
 */
#ifndef NQM_SRC_TEXTURE_H
#define NQM_SRC_TEXTURE_H

#include "argument/argument.h"
#include "brdf/core/spec.h"
#include "io/raster.h"
#include "material/maps.h"
#include <nqm/texture.h>

/** A decoded map. */
typedef struct nqm_texels {
    nqm_raster raster; /* of floats: linear already */
    float *table;      /* (2, 256 or 65536) of integers: the value of a colour, and of alpha */
    bool has_matrix;   /* of a colour space with other primaries: applied after interpolation */
    float matrix[3][3];
} nqm_texels;

/** A property of the model. */
typedef struct nqm_texture_property {
    const nqm_schema_key *key;
    double v[3];     /* its value where no map changes it */
    uint16_t node;   /* NQM_NO_NODE: none does */
    uint16_t row[3]; /* of each component among those of the nodes */
} nqm_texture_property;

/** See nqm_texture. Its shading has the constant properties. */
struct nqm_texture {
    char *name, *argument; /* argument: of a BRDF that is none of a shading model; NULL: the shading is the material */
    nqm_argument_file *file;    /* NULL: none */
    nqm_textured *owned;        /* one of both owns `maps` */
    const nqm_textured *maps;   /* NULL: none */
    nqm_values values;          /* constant ones; schema NULL: an argument */
    nqm_texels *images;         /* (maps->n_images) */
    double (*constants)[4];     /* (maps->n_nodes) of nodes that do not vary */
    bool *varies;               /* (maps->n_nodes) */
    uint16_t *rows, n_rows;     /* (maps->n_nodes) the first row of each node that is needed; NQM_NO_ROW: it is not */
    uint16_t normal;            /* the node of the normal; NQM_NO_NODE: it does not vary */
    const char *model;          /* its name, or the format of the argument */
    const nqm_schema_key *keys; /* (n_properties) of the model; NULL with an argument */
    size_t n_properties;
    nqm_texture_property properties[NQM_SCHEMA_MAX_KEYS];
    char words[1024];
    char remark[2 * NQM_REMARK_SIZE]; /* that of `maps`, and what nqm_texture_inspect() has found */
};

enum { NQM_TEXEL_BLOCK = 256, NQM_NO_ROW = 0xffff };

/** See nqm_texture_open(). */
NQM_MUST_CHECK nqm_status nqm_texture_open_argument(nqm_argument *argument, nqm_progress_fn progress,
                                                    void *progress_user, nqm_texture **texture_ret, nqm_error *err);
/** Lay out the nodes that the outputs need; properties that do not vary become constants of the shading. */
NQM_MUST_CHECK nqm_status nqm_texture_prepare(nqm_texture *t, nqm_error *err);
/** Build the table or matrix of a decoded map, or decode its floats. NQM_ERR_FORMAT: no such colour space. */
NQM_MUST_CHECK nqm_status nqm_texels_decode(nqm_texels *texels, const char *space, nqm_error *err);

/** The needed nodes at n <= NQM_TEXEL_BLOCK positions. rows: (n_rows, NQM_TEXEL_BLOCK) */
void nqm_texture_evaluate(const nqm_texture *t, size_t n, const double *u, const double *v, float *rows);
/** Component c of a property at position i of evaluated ones, within the range of the model; NaN becomes the least. */
static inline double nqm_texture_value(const nqm_texture *t, size_t property, size_t c, const float *rows, size_t i) {
    const nqm_texture_property *p = &t->properties[property];
    if (p->node == NQM_NO_NODE)
        return p->v[c];
    const double x = (double)rows[(size_t)p->row[c] * NQM_TEXEL_BLOCK + i], low = p->key->low, high = p->key->high;
    return x >= low ? x <= high ? x : high : low;
}
/** Look at a grid of positions, and say in the remark what the maps hold that the model cannot have. Cost: as 16,384 texels. */
NQM_MUST_CHECK nqm_status nqm_texture_inspect(nqm_texture *t, nqm_error *err);
/** The normal there, a unit vector. Steeper ones than the steepest are that: the surface is seen. */
void nqm_texture_normal(const nqm_texture *t, const float *rows, size_t i, double normal[3]);
/** The values of the material there, of a texture without argument. */
nqm_values nqm_texture_values(const nqm_texture *t, const float *rows, size_t i);
/** The material there, without its normal: *values receives the values, unless it is an argument. */
nqm_subject nqm_texture_subject(const nqm_texture *t, const float *rows, size_t i, nqm_values *values);

/** Texels along u (axis 0) or v of one period of both, and by how many such periods the surface is tiled. */
size_t nqm_texture_tiles(const nqm_texture *ref, const nqm_texture *test, size_t axis, size_t *n_texels_ret);

/** The BRDF at a position of the surface, and its normal (unit vector: tangent, which is the direction of u; bitangent; normal). u
 *  to the right and v downwards, 0 to 1 over the texture, which is repeated. Any thread. */
NQM_MUST_CHECK nqm_status nqm_texture_at(const nqm_texture *texture, double u, double v, nqm_brdf **brdf_ret,
                                         double normal[3], nqm_error *err);

#endif
