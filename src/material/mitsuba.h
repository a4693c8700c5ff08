/* SPDX-License-Identifier: MIT
 *
 * mitsuba.h - the BSDFs of a Mitsuba 3 scene, read from XML or from a JSON dictionary into one list of nodes, and their translation
 * to shadings. Also what Mitsuba and pbrt-v4 share: lists of numbers, and the indices of metals by name.
 */
#ifndef NQM_SRC_MATERIAL_MITSUBA_H
#define NQM_SRC_MATERIAL_MITSUBA_H

#include "material/material.h"

typedef enum nqm_mitsuba_kind {
    NQM_MITSUBA_BSDF,
    NQM_MITSUBA_NUMBER,
    NQM_MITSUBA_BOOLEAN,
    NQM_MITSUBA_STRING,
    NQM_MITSUBA_RGB,
    NQM_MITSUBA_SPECTRUM,
    NQM_MITSUBA_REF,
    NQM_MITSUBA_OTHER, /**< textures and other plugins */
} nqm_mitsuba_kind;

/** A BSDF or a property inside one. Texts are "" when absent. */
typedef struct nqm_mitsuba_node {
    nqm_mitsuba_kind kind;
    size_t parent; /**< index; NQM_MITSUBA_ROOT: not inside of a BSDF */
    char *type;    /**< of a plugin */
    char *name;    /**< name of a property */
    char *id;
    char *value; /**< value of a property as text: "0.1", "0.2 0.3 0.4", "true" */
    int64_t byte_offset;
} nqm_mitsuba_node;
#define NQM_MITSUBA_ROOT ((size_t)-1)

/** A zeroed list is empty. */
typedef struct nqm_mitsuba_nodes {
    size_t n, max_n;
    nqm_mitsuba_node *list; /* (n), parents before their children */
} nqm_mitsuba_nodes;

/** Append a node; its texts are copied, NULL as "". NQM_ERR_LIMIT: more than 100000. */
NQM_MUST_CHECK nqm_status nqm_mitsuba_add(nqm_mitsuba_nodes *nodes, const nqm_mitsuba_node *node, const char *path,
                                          nqm_error *err);
void nqm_mitsuba_free(nqm_mitsuba_nodes *nodes);
/** true when Mitsuba has a BSDF plugin of this name. */
bool nqm_mitsuba_is_bsdf(const char *type);
/** Append a material for each BSDF that is not inside of another one. */
NQM_MUST_CHECK nqm_status nqm_mitsuba_translate(const nqm_mitsuba_nodes *nodes, nqm_materials *materials,
                                                nqm_error *err);

/** Write the BSDF as a JSON dictionary or as XML. */
nqm_status nqm_mitsuba_write(size_t n, const nqm_named_shading *materials, const char *path, FILE *stream,
                             nqm_error *err);

/** Parse numbers separated by blanks or commas; the whole text must be numbers. Returns their count, 0 when there is anything
 *  else or more than max_n. */
size_t nqm_parse_numbers(const char *text, size_t max_n, double *v);

/** A conductor's index of refraction eta + i k, for the three channels. */
typedef struct nqm_metal {
    const char *name;
    double eta[3], k[3];
} nqm_metal;
/** NULL: there is none of this name. "Au_palik" is "Au". */
const nqm_metal *nqm_metal_find(const char *name);
/** All names, separated by ", ". */
void nqm_metal_names(char *text, size_t n_text);

#endif
