/* SPDX-License-Identifier: MIT
 *
 * materialx.h - the surface shaders of MaterialX that are read and written, with their inputs.
 */
#ifndef NQM_SRC_MATERIAL_MATERIALX_H
#define NQM_SRC_MATERIAL_MATERIALX_H

#include <stddef.h>

typedef enum nqm_mtlx_kind {
    NQM_MTLX_KEY,     /**< a key of the shading model, of the same name */
    NQM_MTLX_NEUTRAL, /**< must have the value of the table, or be gated off */
    NQM_MTLX_NORMAL,  /**< must be 0, 0, 1 or absent */
    NQM_MTLX_IGNORED  /**< has no effect where the other inputs are accepted */
} nqm_mtlx_kind;

typedef struct nqm_mtlx_input {
    const char *name;
    nqm_mtlx_kind kind;
    const char *type; /**< type in MaterialX: "float", "color3", "integer"; NULL for NORMAL and IGNORED */
    double value;     /**< default of the definition, in every channel */
    const char *what; /**< NEUTRAL: what it would do, for the refusal */
    const char *gate; /**< NEUTRAL: without effect where this input is 0; NULL: none */
} nqm_mtlx_input;

typedef struct nqm_mtlx_surface {
    const char *node;  /**< "open_pbr_surface" */
    const char *model; /**< "open-pbr" */
    size_t n;
    const nqm_mtlx_input *inputs;
} nqm_mtlx_surface;

enum { NQM_MTLX_N_SURFACES = 5 };
extern const nqm_mtlx_surface nqm_mtlx_surfaces[NQM_MTLX_N_SURFACES];

#endif
