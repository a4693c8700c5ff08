/* SPDX-License-Identifier: MIT
 *
 * Nodes of textured materials at blocks of positions, as rows of floats: one row per component. Nodes that do not vary are computed
 * once, in double. Maps are interpolated bilinearly in linear colour, and exact at the centres of their texels.
 */
#include "texture/evaluate.h"

#include "material/color_space.h"
#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK };

/* ---- colour ------------------------------------------------------------------------------------------------------ */

/* The curve of a colour space alone: greys have no primaries. */
static double decode(const char *space, double v) {
    double rgb[3] = {v, v, v};
    return nqm_color_to_rec709(space, rgb) ? rgb[0] : v;
}

static void find_matrix(nqm_texels *t, const char *space) {
    for (size_t from = 0; from < 3; ++from) {
        double rgb[3] = {from == 0, from == 1, from == 2};
        (void)nqm_color_to_rec709(space, rgb);
        for (size_t to = 0; to < 3; ++to) {
            t->matrix[to][from] = (float)rgb[to];
            t->has_matrix = t->has_matrix || rgb[to] != (from == to);
        }
    }
}

nqm_status nqm_texels_decode(nqm_texels *t, const char *space, nqm_error *err) {
    nqm_raster *r = &t->raster;
    const size_t n_levels = r->type == NQM_RASTER_U8 ? 256 : 65536, n_colors = r->channels < 3 ? 1 : 3;
    if (!nqm_color_to_rec709(space, (double[3]){0}))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "no colour space '%s' is known", space);
    find_matrix(t, space);
    if (r->type == NQM_RASTER_F32) {
        float *v = r->data;
        for (size_t i = 0; *space && i < r->width * r->height * r->channels; ++i)
            if (i % r->channels < n_colors)
                v[i] = (float)decode(space, (double)v[i]);
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

/* The two texels between which a position is, and the weight of the second. -1: beyond the border. */
typedef struct taps {
    int64_t at[2];
    float weight;
} taps;

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

/* position: in texels, a centre at each half. Within a thousandth of a centre its value is exact. */
static inline taps find_taps(double position, size_t n, uint8_t mode) {
    const double x = fabs(position) < 1e15 ? position - 0.5 : 0, snapped = floor(x + 1e-3), rest = x - snapped;
    const int64_t first = (int64_t)snapped;
    taps t = {{wrap(first, (int64_t)n, mode), 0}, rest < 1e-3 ? 0 : (float)rest};
    t.at[1] = t.weight > 0 ? wrap(first + 1, (int64_t)n, mode) : t.at[0];
    return t;
}

/* Component c of the texel of which the values begin at `at`. Grey repeats; a map without alpha is opaque. */
static inline float component(const nqm_texels *t, size_t at, size_t c) {
    const nqm_raster *r = &t->raster;
    const bool is_alpha = c == 3, is_grey = r->channels < 3;
    if (is_alpha && r->channels % 2 == 1)
        return 1;
    at += is_grey ? is_alpha : c;
    switch (r->type) {
    case NQM_RASTER_U8:
        return t->table[256 * is_alpha + ((const uint8_t *)r->data)[at]];
    case NQM_RASTER_U16:
        return t->table[65536 * is_alpha + ((const uint16_t *)r->data)[at]];
    default:
        return ((const float *)r->data)[at];
    }
}

static inline float fetch(const nqm_texels *t, const nqm_map_node *node, int64_t x, int64_t y, size_t c) {
    return x < 0 || y < 0 ? (float)node->v[c]
                          : component(t, ((size_t)y * t->raster.width + (size_t)x) * t->raster.channels, c);
}

static inline float interpolate(const nqm_texels *t, const nqm_map_node *node, const taps *x, const taps *y, size_t c) {
    float row[2] = {0, 0};
    for (size_t k = 0; k < (y->weight > 0 ? 2 : 1); ++k) {
        row[k] = fetch(t, node, x->at[0], y->at[k], c);
        if (x->weight > 0)
            row[k] += x->weight * (fetch(t, node, x->at[1], y->at[k], c) - row[k]);
    }
    return y->weight > 0 ? row[0] + y->weight * (row[1] - row[0]) : row[0];
}

/* Texels themselves, of which the values begin at at[]: a loop for each type, without a branch. */
static void copy_texels(const nqm_texels *t, size_t n_components, size_t n, const size_t *at, float *out) {
    const nqm_raster *r = &t->raster;
    for (size_t c = 0; c < n_components; ++c, out += BLOCK) {
        const bool is_alpha = c == 3, is_grey = r->channels < 3, is_opaque = is_alpha && r->channels % 2 == 1;
        const size_t channel = is_grey ? is_alpha : c;
        const float *table = t->table ? t->table + (r->type == NQM_RASTER_U8 ? 256 : 65536) * is_alpha : NULL;
        if (is_opaque)
            for (size_t i = 0; i < n; ++i)
                out[i] = 1;
        else if (r->type == NQM_RASTER_U8)
            for (size_t i = 0; i < n; ++i)
                out[i] = table[((const uint8_t *)r->data)[at[i] + channel]];
        else if (r->type == NQM_RASTER_U16)
            for (size_t i = 0; i < n; ++i)
                out[i] = table[((const uint16_t *)r->data)[at[i] + channel]];
        else
            for (size_t i = 0; i < n; ++i)
                out[i] = ((const float *)r->data)[at[i] + channel];
    }
}

/* Whether all positions are centres of texels: then their places. */
static bool find_texels(const nqm_texels *t, const nqm_map_node *node, size_t n, const double *u, const double *v,
                        size_t *at) {
    const nqm_raster *r = &t->raster;
    const double w = (double)r->width, h = (double)r->height, (*m)[3] = node->uv;
    bool is_exact = !t->has_matrix;
    for (size_t i = 0; is_exact && i < n; ++i) {
        const taps x = find_taps((m[0][0] * u[i] + m[0][1] * v[i] + m[0][2]) * w, r->width, node->wrap[0]);
        const taps y = find_taps((m[1][0] * u[i] + m[1][1] * v[i] + m[1][2]) * h, r->height, node->wrap[1]);
        is_exact = x.weight <= 0 && y.weight <= 0 && x.at[0] >= 0 && y.at[0] >= 0;
        at[i] = is_exact ? ((size_t)y.at[0] * r->width + (size_t)x.at[0]) * r->channels : 0;
    }
    return is_exact;
}

static void evaluate_image(const nqm_texels *t, const nqm_map_node *node, size_t n, const double *u, const double *v,
                           float *out) {
    const double w = (double)t->raster.width, h = (double)t->raster.height, (*m)[3] = node->uv;
    size_t at[BLOCK];
    if (find_texels(t, node, n, u, v, at)) {
        copy_texels(t, node->n, n, at, out);
        return;
    }
    const size_t n_read = t->has_matrix ? nqm_larger(node->n, 3) : node->n;
    for (size_t i = 0; i < n; ++i) {
        const taps x = find_taps((m[0][0] * u[i] + m[0][1] * v[i] + m[0][2]) * w, t->raster.width, node->wrap[0]);
        const taps y = find_taps((m[1][0] * u[i] + m[1][1] * v[i] + m[1][2]) * h, t->raster.height, node->wrap[1]);
        float value[4];
        for (size_t c = 0; c < n_read; ++c)
            value[c] = interpolate(t, node, &x, &y, c);
        for (size_t c = 0; c < node->n; ++c)
            out[c * BLOCK + i] = t->has_matrix && c < 3 ? t->matrix[c][0] * value[0] + t->matrix[c][1] * value[1] +
                                                              t->matrix[c][2] * value[2]
                                                        : value[c];
    }
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

/* A block of positions that is being evaluated. */
typedef struct block {
    const nqm_texture *t;
    size_t n;
    const double *u, *v;
    float *workspace;
} block;

/* The row of component c of an operand, the last one of which repeats. */
static const float *row_of(const block *b, uint16_t node, size_t c) {
    const size_t n = b->t->maps->nodes[node].n;
    return b->workspace + (b->t->rows[node] + nqm_smaller(c, n - 1)) * BLOCK;
}

/* Operations that have no loop of their own. */
static void evaluate_each(const block *b, const nqm_map_node *node, size_t n_operands, float *out) {
    double values[4][4], result[4] = {0};
    nqm_map_node local = *node;
    for (size_t k = 0; k < n_operands; ++k)
        local.in[k] = (uint16_t)k;
    for (size_t i = 0; i < b->n; ++i) {
        for (size_t k = 0; k < n_operands; ++k)
            for (size_t c = 0; c < 4; ++c)
                values[k][c] = (double)row_of(b, node->in[k], c)[i];
        nqm_map_node_value(&local, (const double(*)[4])values, result);
        for (size_t c = 0; c < node->n; ++c)
            out[c * BLOCK + i] = (float)result[c];
    }
}

NQM_FOR_EACH_VECTOR_WIDTH
static void evaluate_row(nqm_map_op op, size_t n, const float *a, const float *b, const float *t, float *restrict out) {
    switch (op) {
    case NQM_MAP_ADD:
        for (size_t i = 0; i < n; ++i)
            out[i] = a[i] + b[i];
        break;
    case NQM_MAP_SUBTRACT:
        for (size_t i = 0; i < n; ++i)
            out[i] = a[i] - b[i];
        break;
    case NQM_MAP_MULTIPLY:
        for (size_t i = 0; i < n; ++i)
            out[i] = a[i] * b[i];
        break;
    case NQM_MAP_MINIMUM:
        for (size_t i = 0; i < n; ++i)
            out[i] = a[i] < b[i] ? a[i] : b[i];
        break;
    case NQM_MAP_MAXIMUM:
        for (size_t i = 0; i < n; ++i)
            out[i] = a[i] > b[i] ? a[i] : b[i];
        break;
    case NQM_MAP_MIX:
        for (size_t i = 0; i < n; ++i)
            out[i] = a[i] + (b[i] - a[i]) * t[i];
        break;
    default:
        memcpy(out, a, n * sizeof *a);
    }
}

static void evaluate_normal(const block *b, const nqm_map_node *node, float *out) {
    const float *in[3] = {row_of(b, node->in[0], 0), row_of(b, node->in[0], 1), row_of(b, node->in[0], 2)};
    const float *scale[2] = {row_of(b, node->in[1], 0), row_of(b, node->in[1], 1)};
    for (size_t i = 0; i < b->n; ++i) {
        const float x = (2 * in[0][i] - 1) * scale[0][i], y = (2 * in[1][i] - 1) * scale[1][i], z = 2 * in[2][i] - 1;
        const float length = sqrtf(x * x + y * y + z * z), times = length > 0 ? 1 / length : 0;
        out[i] = x * times;
        out[BLOCK + i] = y * times;
        out[2 * BLOCK + i] = length > 0 ? z * times : 1;
    }
}

static void evaluate_node(const block *b, size_t k) {
    const nqm_map_node *node = &b->t->maps->nodes[k];
    float *out = b->workspace + b->t->rows[k] * BLOCK;
    const bool varies = b->t->roles[k] & NQM_NODE_VARIES;
    for (size_t c = 0; !varies && c < node->n; ++c)
        for (size_t i = 0; i < b->n; ++i)
            out[c * BLOCK + i] = (float)b->t->constants[k][c];
    if (!varies)
        return;
    switch (node->op) {
    case NQM_MAP_IMAGE:
        evaluate_image(&b->t->images[node->image], node, b->n, b->u, b->v, out);
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
        memcpy(out, row_of(b, node->in[0], (size_t)node->v[0]), b->n * sizeof *out);
        return;
    case NQM_MAP_COMBINE:
        for (size_t c = 0; c < node->n; ++c)
            memcpy(out + c * BLOCK, row_of(b, node->in[c], 0), b->n * sizeof *out);
        return;
    case NQM_MAP_ADD:
    case NQM_MAP_SUBTRACT:
    case NQM_MAP_MULTIPLY:
    case NQM_MAP_MINIMUM:
    case NQM_MAP_MAXIMUM:
    case NQM_MAP_MIX:
        for (size_t c = 0; c < node->n; ++c)
            evaluate_row(node->op, b->n, row_of(b, node->in[0], c), row_of(b, node->in[1], c),
                         node->op == NQM_MAP_MIX ? row_of(b, node->in[2], c) : NULL, out + c * BLOCK);
        return;
    default:
        evaluate_each(b, node, nqm_map_operands(node->op, node->n), out);
    }
}

/* ---- values of texels -------------------------------------------------------------------------------------------- */

size_t nqm_texture_workspace(const nqm_texture *t) {
    return (t->n_rows + t->n_values) * BLOCK;
}

/* Steeper normals than this are the steepest: the surface is seen. */
static void limit_normals(size_t n, float *x, float *y, float *z) {
    const float least = 0.05f;
    for (size_t i = 0; i < n; ++i) {
        float length = sqrtf(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
        if (!(length > 0 && length < 1e30f))
            x[i] = y[i] = 0, z[i] = length = 1;
        if (z[i] < least * length) {
            z[i] = least * length;
            length = sqrtf(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
        }
        x[i] /= length;
        y[i] /= length;
        z[i] /= length;
    }
}

const float *nqm_texture_evaluate(const nqm_texture *t, size_t n, const double *u, const double *v, float *workspace) {
    const block b = {t, n, u, v, workspace};
    float *values = workspace + t->n_rows * BLOCK;
    for (size_t k = 0; t->n_values && k < t->maps->n_nodes; ++k)
        if (t->roles[k] & NQM_NODE_NEEDED)
            evaluate_node(&b, k);
    for (size_t k = 0; k < t->n_varying; ++k) {
        const nqm_varying *p = &t->varying[k];
        const float low = (float)p->low, high = (float)p->high;
        for (size_t c = 0; c < p->n; ++c) {
            const float *in = row_of(&b, p->node, c);
            float *out = values + (p->at + c) * BLOCK;
            for (size_t i = 0; i < n; ++i) /* NaN becomes the least */
                out[i] = in[i] >= low ? in[i] <= high ? in[i] : high : low;
        }
    }
    if (t->has_normal) {
        float *out = values + (t->n_values - 3) * BLOCK;
        for (size_t c = 0; c < 3; ++c)
            memcpy(out + c * BLOCK, row_of(&b, t->maps->normal, c), n * sizeof *out);
        limit_normals(n, out, out + BLOCK, out + 2 * BLOCK);
    }
    return values;
}
