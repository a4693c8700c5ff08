/* SPDX-License-Identifier: MIT
 *
 * Programs of the nodes of MaterialX: see materialx.h.
 */
#include "material/materialx.h"

/* MaterialX's rotate2d of a by b degrees: x cos + y sin, y cos - x sin. */
static const char rotation[] = "bP*! cS! cC! axe*ayd*+ aye*axd*- &";

size_t nqm_mtlx_width(const nqm_textured *t, uint16_t node) {
    return node == NQM_NO_NODE ? 1 : t->nodes[node].n;
}

uint16_t nqm_mtlx_resize(nqm_textured *t, uint16_t node, size_t n) {
    const size_t have = nqm_mtlx_width(t, node);
    nqm_map_node result = {.op = NQM_MAP_COMBINE, .n = (uint8_t)n};
    if (have == n || node == NQM_NO_NODE)
        return node;
    if (t->nodes[node].op == NQM_MAP_IMAGE && have == 4 && n == 3) {
        result = t->nodes[node];
        result.n = 3;
        return nqm_graph_add(t, result);
    }
    for (size_t c = 0; c < n; ++c)
        result.in[c] = c < have || have == 1 ? nqm_graph_channel(t, node, c) : nqm_graph_number(t, c == 3);
    return n == 1 ? result.in[0] : nqm_graph_add(t, result);
}

static uint16_t dot_product(nqm_textured *t, uint16_t a, uint16_t b) {
    const size_t n = nqm_larger(nqm_mtlx_width(t, a), nqm_mtlx_width(t, b));
    const uint16_t product = nqm_graph_compute(t, NQM_MAP_MULTIPLY, n, a, b, 0);
    uint16_t sum = nqm_graph_channel(t, product, 0);
    for (size_t c = 1; c < n; ++c)
        sum = nqm_graph_compute(t, NQM_MAP_ADD, 1, sum, nqm_graph_channel(t, product, c), 0);
    return sum;
}

/* The components of a, then those of b: at most four. */
static uint16_t join(nqm_textured *t, uint16_t a, uint16_t b) {
    const size_t n_a = nqm_mtlx_width(t, a), n = nqm_smaller(n_a + nqm_mtlx_width(t, b), 4);
    nqm_map_node result = {.op = NQM_MAP_COMBINE, .n = (uint8_t)n};
    for (size_t c = 0; c < n; ++c)
        result.in[c] = c < n_a ? nqm_graph_channel(t, a, c) : nqm_graph_channel(t, b, c - n_a);
    return nqm_graph_add(t, result);
}

/* An operation on the last values of the stack, which its result replaces. */
static uint16_t run_operation(nqm_mtlx_program *m, char token) {
    static const struct {
        char token;
        nqm_map_op op;
        unsigned char n; /* components; 0: as many as the widest operand */
    } operations[] = {
        {'+', NQM_MAP_ADD, 0},      {'-', NQM_MAP_SUBTRACT, 0},   {'*', NQM_MAP_MULTIPLY, 0},
        {'/', NQM_MAP_DIVIDE, 0},   {'^', NQM_MAP_POWER, 0},      {'%', NQM_MAP_MODULO, 0},
        {'[', NQM_MAP_MINIMUM, 0},  {']', NQM_MAP_MAXIMUM, 0},    {'|', NQM_MAP_ABSOLUTE, 0},
        {'_', NQM_MAP_FLOOR, 0},    {'S', NQM_MAP_SINE, 0},       {'C', NQM_MAP_COSINE, 0},
        {'M', NQM_MAP_MIX, 0},      {'T', NQM_MAP_SMOOTHSTEP, 0}, {'>', NQM_MAP_IF_GREATER, 0},
        {'=', NQM_MAP_IF_EQUAL, 0}, {'R', NQM_MAP_RGB_TO_HSV, 3}, {'H', NQM_MAP_HSV_TO_RGB, 3},
        {'N', NQM_MAP_NORMAL, 3},
    };
    size_t o = 0, n = 1;
    while (operations[o].token != token)
        ++o;
    const size_t n_in = nqm_graph_operands(operations[o].op, operations[o].n);
    nqm_map_node node = {.op = operations[o].op};
    m->n_stack -= n_in;
    for (size_t i = 0; i < n_in; ++i) {
        node.in[i] = m->stack[m->n_stack + i];
        n = nqm_larger(n, nqm_mtlx_width(m->t, node.in[i]));
    }
    node.n = (uint8_t)(operations[o].n ? operations[o].n : n);
    return nqm_graph_add(m->t, node);
}

static uint16_t run_token(nqm_mtlx_program *m, char token) {
    if (token >= 'a' && token <= 'p')
        return m->operand[token - 'a'];
    if (token >= '0' && token <= '9')
        return nqm_graph_number(m->t, token - '0');
    if (token == 'I')
        return m->image;
    if (token == 'P')
        return nqm_graph_number(m->t, 3.14159265358979323846 / 180);
    if (token >= 'x' && token <= 'z') /* a component */
        return nqm_graph_channel(m->t, m->stack[--m->n_stack], (size_t)(token - 'x'));
    if (!strchr(".&D", token))
        return run_operation(m, token);
    const uint16_t *in = &m->stack[m->n_stack -= 2];
    return token == '.' ? dot_product(m->t, in[0], in[1])
           : token == '&'
               ? join(m->t, in[0], in[1])
               : nqm_mtlx_run(&(nqm_mtlx_program){.t = m->t, .n_operands = 2, .operand = {in[0], in[1]}}, rotation);
}

uint16_t nqm_mtlx_run(nqm_mtlx_program *m, const char *program) {
    m->n_stack = 0;
    for (; *program; ++program) {
        if (*program == '!')
            m->operand[m->n_operands++] = m->stack[--m->n_stack];
        else if (*program != ' ') {
            const uint16_t result = run_token(m, *program);
            m->stack[m->n_stack++] = result;
        }
    }
    return m->stack[0];
}
