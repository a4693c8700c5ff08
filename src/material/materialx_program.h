/* SPDX-License-Identifier: MIT
 *
 * materialx_program.h - what a node of MaterialX computes, as a program in reverse Polish notation that appends nodes of maps.h: a, b, ...
 * are its operands, I its image, digits are constants, P is pi / 180, x, y and z take a component, `!` makes an operand of the result so
 * far, and run_operation() has the other letters.
 */
#ifndef NQM_SRC_MATERIAL_MATERIALX_PROGRAM_H
#define NQM_SRC_MATERIAL_MATERIALX_PROGRAM_H

#include "material/maps.h"

enum { NQM_MTLX_OPERANDS = 16 };

/** MaterialX's rotate2d of a by b degrees: x cos + y sin, y cos - x sin. */
#define NQM_MTLX_ROTATE "bP*! cS! cC! axe*ayd*+ aye*axd*- &"

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
