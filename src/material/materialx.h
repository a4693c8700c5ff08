/* SPDX-License-Identifier: MIT
 *
 * materialx.h - the surface shaders of MaterialX that are read and written, with their inputs.
 */
#ifndef NQM_SRC_MATERIAL_MATERIALX_H
#define NQM_SRC_MATERIAL_MATERIALX_H

#include "material/rules.h"

typedef struct nqm_mtlx_surface {
    const char *node;       /**< "open_pbr_surface" */
    const char *model;      /**< "open-pbr" */
    const nqm_rule *inputs; /**< with the defaults of the definition; types "float", "color3" and "integer" */
} nqm_mtlx_surface;

enum { NQM_MTLX_N_SURFACES = 5 };
extern const nqm_mtlx_surface nqm_mtlx_surfaces[NQM_MTLX_N_SURFACES];
/** The surface with this node or this model, one of which is NULL. NULL: there is none. */
const nqm_mtlx_surface *nqm_mtlx_find_surface(const char *node, const char *model);

/** A key of the shading; the normal, and that of the coat; a tangent, which is refused; occlusion; what has no effect; emission, and subsurface
 *  scattering of the color of the base, which are ignored if they are maps. */
nqm_rule_read nqm_mtlx_read_key, nqm_mtlx_read_normal, nqm_mtlx_read_coat_normal, nqm_mtlx_read_tangent,
    nqm_mtlx_read_occlusion, nqm_mtlx_read_unused, nqm_mtlx_read_emission, nqm_mtlx_read_subsurface;

/** The nodes that the inputs of one material are connected to. */
typedef struct nqm_mtlx_graph {
    const char *path; /**< of the document */
    nqm_index names;
    const struct nqm_xml_element *root;
    nqm_reading *reading; /**< receives why the material is refused */
    nqm_textured *t;      /**< receives the nodes */
    size_t n_built;
    struct nqm_mtlx_built {
        const struct nqm_xml_element *node;
        const char *output;
        uint16_t value;
    } built[NQM_MAX_MAP_NODES]; /**< nodes of the document and what they have become */
    /* of the input that is read: */
    const struct nqm_xml_element *input;
    const char *name;
    const struct nqm_xml_element *source; /**< the first node that does more than to pass on a value; NULL: none */
    int depth;                            /**< connections that are being followed */
} nqm_mtlx_graph;

/** The node that computes an input: a constant where nothing varies. NQM_NO_NODE: refused. name: for messages; type: if the input
 *  names none. */
uint16_t nqm_mtlx_read(nqm_mtlx_graph *graph, const struct nqm_xml_element *input, const char *name, const char *type);
/** The first child with this name attribute; `kind` NULL: of any element. NULL: none, or `parent` or `name` is NULL. */
const struct nqm_xml_element *nqm_mtlx_child(const nqm_mtlx_graph *graph, const struct nqm_xml_element *parent,
                                             const char *kind, const char *name);
/** What an input or output is connected to: an input or output of a node graph, or a node; NULL: the file does not have it. */
const struct nqm_xml_element *nqm_mtlx_target(const nqm_mtlx_graph *graph, const struct nqm_xml_element *e);
bool nqm_mtlx_is_connected(const struct nqm_xml_element *e);
/** Whether an input is connected or has a value itself. */
bool nqm_mtlx_has_value(const struct nqm_xml_element *e);
/** Append the materials of a document. path: of its file. */
struct nqm_xml;
NQM_MUST_CHECK nqm_status nqm_mtlx_read_document(const struct nqm_xml *xml, const char *path, nqm_materials *materials,
                                                 nqm_error *err);
/** false for NULL. */
static inline bool nqm_texts_equal(const char *a, const char *b) {
    return a && strcmp(a, b) == 0;
}

/* ---- programs (materialx_program.c): what a node computes, in reverse Polish notation. a, b, ... are its operands, I its image,
 * digits are constants, P is pi / 180, x, y and z take a component, `!` makes an operand of the result so far, and run_operation()
 * has the other letters. */

enum { NQM_MTLX_OPERANDS = 16 };
/** The operands and results of a program. */
typedef struct nqm_mtlx_program {
    nqm_textured *t;
    size_t n_operands, n_stack;
    uint16_t operand[NQM_MTLX_OPERANDS], stack[NQM_MTLX_OPERANDS], image;
} nqm_mtlx_program;

/** The node of the result; NQM_NO_NODE as of nqm_graph_add(). */
uint16_t nqm_mtlx_run(nqm_mtlx_program *m, const char *program);
/** Components of a node; of NQM_NO_NODE 1. */
size_t nqm_mtlx_width(const nqm_textured *t, uint16_t node);
/** The value with n components: a number is repeated, others are cut, or continued as MaterialX's node convert does. */
uint16_t nqm_mtlx_resize(nqm_textured *t, uint16_t node, size_t n);

#endif
