/* SPDX-License-Identifier: MIT
 *
 * Nodes of textured materials at blocks of positions, as rows of floats: one row per component. Maps are interpolated bilinearly in
 * linear colour, and exact at the centres of their texels. Operations that are rare have no loop of their own.
 */
#include "texture/texture.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK };

/* ---- colour ------------------------------------------------------------------------------------------------------ */

/* The curve of a colour space alone: greys have no primaries. */
static double decode(const char *space, double v) {
    double rgb[3] = {v, v, v};
    return nqm_color_to_rec709(space, rgb) ? rgb[0] : v;
}

nqm_status nqm_texels_decode(nqm_texels *t, const char *space, nqm_error *err) {
    const float most = 1e30f; /* infinities could not be interpolated */
    const nqm_raster *r = &t->raster;
    const size_t n_levels = r->type == NQM_RASTER_U8 ? 256 : 65536, n_colors = r->channels < 3 ? 1 : 3;
    if (!nqm_color_to_rec709(space, (double[3]){0}))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "no colour space '%s' is known", space);
    for (size_t from = 0; from < 3; ++from) {
        double rgb[3] = {from == 0, from == 1, from == 2};
        (void)nqm_color_to_rec709(space, rgb);
        for (size_t to = 0; to < 3; ++to) {
            t->matrix[to][from] = (float)rgb[to];
            t->has_matrix = t->has_matrix || rgb[to] != (from == to);
        }
    }
    if (r->type == NQM_RASTER_F32) {
        float *v = r->data;
        for (size_t i = 0; i < r->width * r->height * r->channels; ++i) {
            v[i] = fminf(fmaxf(v[i], -most), most);
            if (*space && i % r->channels < n_colors)
                v[i] = (float)decode(space, (double)v[i]);
        }
        return NQM_OK;
    }
    t->table = nqm_alloc(2 * n_levels, sizeof *t->table);
    if (!t->table)
        return nqm_fail_nomem(err, 2 * n_levels * sizeof *t->table);
    for (size_t i = 0; i < n_levels; ++i) {
        const double v = (double)i / (double)(n_levels - 1);
        t->table[i] = (float)decode(space, v);
        t->table[n_levels + i] = (float)v;
    }
    return NQM_OK;
}

/* ---- images ------------------------------------------------------------------------------------------------------ */

/* A block of positions that is being evaluated. */
typedef struct block {
    const nqm_texture *t;
    size_t n;
    const double *u, *v;
    float *rows;
    const nqm_map_node *placed; /* the image node whose places these are: */
    int32_t at[4][BLOCK];       /* the texels around each position, by rows; -1: beyond the border */
    float weight[2][BLOCK];     /* of the right and the lower ones */
    bool is_between;            /* some weight is not 0 */
} block;

static inline int64_t wrap(int64_t i, int64_t n, uint8_t mode) {
    if (i >= 0 && i < n)
        return i;
    if (mode == NQM_MAP_BORDER)
        return -1;
    if (mode == NQM_MAP_CLAMP)
        return i < 0 ? 0 : n - 1;
    const int64_t period = mode == NQM_MAP_MIRROR ? 2 * n : n;
    i %= period;
    i += i < 0 ? period : 0;
    return i < n ? i : 2 * n - 1 - i;
}

/* Centres of texels are at halves. Within a thousandth of a centre its value is exact. */
static void find_places(block *b, const nqm_map_node *node) {
    const nqm_raster *r = &b->t->images[node->image].raster;
    const size_t size[2] = {r->width, r->height};
    b->placed = node;
    b->is_between = false;
    for (size_t i = 0; i < b->n; ++i) {
        int64_t at[2][2];
        for (size_t axis = 0; axis < 2; ++axis) {
            const double *m = node->uv[axis];
            const double position = (m[0] * b->u[i] + m[1] * b->v[i] + m[2]) * (double)size[axis];
            const double x = fabs(position) < 1e15 ? position - 0.5 : 0, first = floor(x + 1e-3), rest = x - first;
            const bool is_between = rest >= 1e-3;
            at[axis][0] = wrap((int64_t)first, (int64_t)size[axis], node->wrap[axis]);
            at[axis][1] = is_between ? wrap((int64_t)first + 1, (int64_t)size[axis], node->wrap[axis]) : at[axis][0];
            b->weight[axis][i] = is_between ? (float)rest : 0;
            b->is_between = b->is_between || is_between;
        }
        for (size_t k = 0; k < 4; ++k) {
            const int64_t x = at[0][k % 2], y = at[1][k / 2];
            b->at[k][i] = x < 0 || y < 0 ? -1 : (int32_t)(y * (int64_t)size[0] + x);
        }
    }
}

static bool is_placed(const block *b, const nqm_map_node *node) {
    const nqm_map_node *placed = b->placed;
    const nqm_texels *images = b->t->images;
    return placed && memcmp(placed->uv, node->uv, sizeof node->uv) == 0 &&
           memcmp(placed->wrap, node->wrap, sizeof node->wrap) == 0 &&
           images[placed->image].raster.width == images[node->image].raster.width &&
           images[placed->image].raster.height == images[node->image].raster.height;
}

/* Component c of texels. Grey repeats; a map without alpha is opaque. */
static void gather(const nqm_texels *t, size_t n, const int32_t *at, size_t c, float border, float *out) {
    const nqm_raster *r = &t->raster;
    const bool is_alpha = c == 3, is_opaque = is_alpha && r->channels % 2 == 1;
    const size_t step = r->channels, channel = is_opaque ? 0 : r->channels < 3 ? is_alpha : c;
    const float *table = t->table ? t->table + (r->type == NQM_RASTER_U8 ? 256 : 65536) * is_alpha : NULL;
    bool is_beyond = false;
    if (r->type == NQM_RASTER_U8)
        for (size_t i = 0; i < n; ++i)
            out[i] = table[((const uint8_t *)r->data)[(at[i] < 0 ? 0 : (size_t)at[i]) * step + channel]];
    else if (r->type == NQM_RASTER_U16)
        for (size_t i = 0; i < n; ++i)
            out[i] = table[((const uint16_t *)r->data)[(at[i] < 0 ? 0 : (size_t)at[i]) * step + channel]];
    else
        for (size_t i = 0; i < n; ++i)
            out[i] = ((const float *)r->data)[(at[i] < 0 ? 0 : (size_t)at[i]) * step + channel];
    for (size_t i = 0; i < n; ++i)
        is_beyond = is_beyond || at[i] < 0;
    for (size_t i = 0; (is_beyond || is_opaque) && i < n; ++i)
        out[i] = at[i] < 0 ? border : is_opaque ? 1 : out[i];
}

static void evaluate_image(block *b, const nqm_map_node *node, float *out) {
    const nqm_texels *t = &b->t->images[node->image];
    const size_t n = b->n, n_read = t->has_matrix ? nqm_larger(node->n, 3) : node->n;
    float read[4][BLOCK], around[3][BLOCK];
    if (!is_placed(b, node))
        find_places(b, node);
    for (size_t c = 0; c < n_read; ++c) {
        float *v = read[c];
        const float border = (float)node->v[c];
        gather(t, n, b->at[0], c, border, v);
        for (size_t k = 0; b->is_between && k < 3; ++k)
            gather(t, n, b->at[k + 1], c, border, around[k]);
        for (size_t i = 0; b->is_between && i < n; ++i) {
            const float right = b->weight[0][i], above = v[i] + right * (around[0][i] - v[i]);
            v[i] = above + b->weight[1][i] * (around[1][i] + right * (around[2][i] - around[1][i]) - above);
        }
    }
    for (size_t c = 0; c < node->n; ++c)
        if (t->has_matrix && c < 3)
            for (size_t i = 0; i < n; ++i)
                out[c * BLOCK + i] =
                    t->matrix[c][0] * read[0][i] + t->matrix[c][1] * read[1][i] + t->matrix[c][2] * read[2][i];
        else
            memcpy(out + c * BLOCK, read[c], n * sizeof *out);
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

/* The row of component c of a node, the last one of which repeats. */
static const float *row_of(const block *b, uint16_t node, size_t c) {
    return b->rows + (b->t->rows[node] + nqm_smaller(c, (size_t)b->t->maps->nodes[node].n - 1)) * BLOCK;
}

static void evaluate_each(const block *b, const nqm_map_node *node, float *out) {
    const size_t n_operands = nqm_graph_operands(node->op, node->n);
    double values[4][4], result[4] = {0};
    nqm_map_node local = *node;
    for (size_t k = 0; k < n_operands; ++k)
        local.in[k] = (uint16_t)k;
    for (size_t i = 0; i < b->n; ++i) {
        for (size_t k = 0; k < n_operands; ++k)
            for (size_t c = 0; c < 4; ++c)
                values[k][c] = (double)row_of(b, node->in[k], c)[i];
        nqm_graph_node_value(&local, (const double(*)[4])values, result);
        for (size_t c = 0; c < node->n; ++c)
            out[c * BLOCK + i] = (float)result[c];
    }
}

static void evaluate_normal(const block *b, const nqm_map_node *node, float *out) {
    const float *in[3] = {row_of(b, node->in[0], 0), row_of(b, node->in[0], 1), row_of(b, node->in[0], 2)};
    const float *scale[2] = {row_of(b, node->in[1], 0), row_of(b, node->in[1], 1)};
    for (size_t i = 0; i < b->n; ++i) {
        const float x = (2 * in[0][i] - 1) * scale[0][i], y = (2 * in[1][i] - 1) * scale[1][i], z = 2 * in[2][i] - 1;
        const bool has_value = in[0][i] != 0 || in[1][i] != 0 || in[2][i] != 0; /* as in nqm_graph_node_value() */
        const float length = has_value ? sqrtf(x * x + y * y + z * z) : 0, times = length > 0 ? 1 / length : 0;
        out[i] = x * times;
        out[BLOCK + i] = y * times;
        out[2 * BLOCK + i] = length > 0 ? z * times : 1;
    }
}

static void evaluate_component(const block *b, const nqm_map_node *node, size_t c, float *out) {
    const bool picks = node->op == NQM_MAP_CHANNEL, combines = node->op == NQM_MAP_COMBINE;
    const float *x = row_of(b, node->in[combines ? c : 0], picks ? (size_t)node->v[0] : combines ? 0 : c);
    const float *y = picks || combines ? x : row_of(b, node->in[1], c);
    if (node->op == NQM_MAP_ADD)
        for (size_t i = 0; i < b->n; ++i)
            out[i] = x[i] + y[i];
    else if (node->op == NQM_MAP_MULTIPLY)
        for (size_t i = 0; i < b->n; ++i)
            out[i] = x[i] * y[i];
    else
        memcpy(out, x, b->n * sizeof *out);
}

static void evaluate_node(block *b, size_t k) {
    const nqm_map_node *node = &b->t->maps->nodes[k];
    float *out = b->rows + (size_t)b->t->rows[k] * BLOCK;
    if (!b->t->varies[k]) {
        for (size_t i = 0; i < node->n * (size_t)BLOCK; ++i)
            out[i] = (float)b->t->constants[k][i / BLOCK];
        return;
    }
    switch (node->op) {
    case NQM_MAP_IMAGE:
        evaluate_image(b, node, out);
        return;
    case NQM_MAP_TEXCOORD:
        for (size_t i = 0; i < b->n; ++i) {
            out[i] = (float)b->u[i];
            out[BLOCK + i] = (float)(1 - b->v[i]);
        }
        return;
    case NQM_MAP_NORMAL:
        evaluate_normal(b, node, out);
        return;
    case NQM_MAP_CHANNEL:
    case NQM_MAP_COMBINE:
    case NQM_MAP_ADD:
    case NQM_MAP_MULTIPLY:
        for (size_t c = 0; c < node->n; ++c)
            evaluate_component(b, node, c, out + c * BLOCK);
        return;
    default:
        evaluate_each(b, node, out);
    }
}

void nqm_texture_evaluate(const nqm_texture *t, size_t n, const double *u, const double *v, float *rows) {
    block b;
    b.t = t;
    b.n = n;
    b.u = u;
    b.v = v;
    b.rows = rows;
    b.placed = NULL;
    for (size_t k = 0; t->n_rows && k < t->maps->n_nodes; ++k)
        if (t->rows[k] != NQM_NO_ROW)
            evaluate_node(&b, k);
}

void nqm_texture_normal(const nqm_texture *t, const float *rows, size_t i, double normal[3]) {
    const double least = 0.05;
    const size_t last = t->normal == NQM_NO_NODE ? 0 : (size_t)t->maps->nodes[t->normal].n - 1;
    for (size_t c = 0; c < 3; ++c)
        normal[c] = t->normal == NQM_NO_NODE
                        ? c == 2
                        : (double)rows[(t->rows[t->normal] + nqm_smaller(c, last)) * (size_t)BLOCK + i];
    double length = sqrt(nqm_dot3(normal, normal));
    if (!(length > 0 && length < 1e30)) {
        normal[0] = normal[1] = 0;
        normal[2] = length = 1;
    }
    if (normal[2] < least * length) {
        normal[2] = least * length;
        length = sqrt(nqm_dot3(normal, normal));
    }
    for (size_t c = 0; c < 3; ++c)
        normal[c] /= length;
}
