/* SPDX-License-Identifier: MIT
 *
 * Textured materials: lists of nodes, without doubles, with the value of a node at one position, and lists of images. HSV as in
 * MaterialX (libraries/stdlib/genglsl/lib/mx_hsv.glsl, after Foley and van Dam).
 */
#include "material/maps.h"

#include <math.h>
#include <string.h>

nqm_textured *nqm_textured_create(void) {
    nqm_textured *t = nqm_alloc(1, sizeof *t);
    if (t)
        t->normal = NQM_NO_NODE;
    return t;
}

static void clear_image(nqm_map_image *image) {
    nqm_free(image->path);
    nqm_free(image->data);
    nqm_free(image->name);
}

void nqm_textured_free(nqm_textured *t) {
    if (!t)
        return;
    for (size_t i = 0; i < t->n_images; ++i)
        clear_image(&t->images[i]);
    nqm_free(t->images);
    nqm_free(t->nodes);
    nqm_free(t);
}

size_t nqm_textured_bytes(const nqm_textured *t) {
    size_t n = sizeof *t + t->max_nodes * sizeof *t->nodes + t->max_images * sizeof *t->images;
    for (size_t i = 0; i < t->n_images; ++i)
        n += t->images[i].n_bytes * (t->images[i].data != NULL) + strlen(t->images[i].name) +
             (t->images[i].path ? strlen(t->images[i].path) : 0);
    return n;
}

void nqm_textured_remark(nqm_textured *t, const char *text) {
    nqm_remark_add(t->remark, sizeof t->remark, "%s", text);
}

void nqm_textured_prune(nqm_textured *t) {
    bool is_used[NQM_MAX_MAP_NODES + 1] = {false}, is_seen[NQM_MAX_MAP_IMAGES] = {false};
    uint16_t number[NQM_MAX_MAP_NODES], image_number[NQM_MAX_MAP_IMAGES];
    size_t n = 0, n_images = 0;
    is_used[nqm_smaller(t->normal, NQM_MAX_MAP_NODES)] = true;
    for (size_t i = 0; i < t->n_outputs; ++i)
        is_used[t->outputs[i].node] = true;
    for (size_t i = t->n_nodes; i-- > 0;) {
        for (size_t k = 0; is_used[i] && k < nqm_graph_operands(t->nodes[i].op, t->nodes[i].n); ++k)
            is_used[t->nodes[i].in[k]] = true;
        if (is_used[i] && t->nodes[i].op == NQM_MAP_IMAGE)
            is_seen[t->nodes[i].image] = true;
    }
    for (size_t i = 0; i < t->n_images; ++i) {
        image_number[i] = (uint16_t)n_images;
        if (is_seen[i])
            t->images[n_images++] = t->images[i];
        else
            clear_image(&t->images[i]);
    }
    for (size_t i = 0; i < t->n_nodes; ++i) {
        nqm_map_node node = t->nodes[i];
        number[i] = (uint16_t)n;
        if (!is_used[i])
            continue;
        for (size_t k = 0; k < nqm_graph_operands(node.op, node.n); ++k)
            node.in[k] = number[node.in[k]];
        node.image = node.op == NQM_MAP_IMAGE ? image_number[node.image] : 0;
        t->nodes[n++] = node;
    }
    for (size_t i = 0; i < t->n_outputs; ++i)
        t->outputs[i].node = number[t->outputs[i].node];
    t->normal = t->normal == NQM_NO_NODE ? NQM_NO_NODE : number[t->normal];
    t->n_nodes = n;
    t->n_images = n_images;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

#define N_OPERANDS(NAME, N, VALUE) [NQM_MAP_##NAME] = N,
size_t nqm_graph_operands(nqm_map_op op, size_t n) {
    static const unsigned char counts[NQM_MAP_OPS] = {
        NQM_MAP_COMPONENT_OPS(N_OPERANDS)[NQM_MAP_CHANNEL] = 1, [NQM_MAP_LUMINANCE] = 1, [NQM_MAP_RGB_TO_HSV] = 1,
        [NQM_MAP_HSV_TO_RGB] = 1, [NQM_MAP_NORMAL] = 2};
    return op == NQM_MAP_COMBINE ? n : counts[op];
}

static bool is_same(const nqm_map_node *a, const nqm_map_node *b) {
    return a->op == b->op && a->n == b->n && a->image == b->image && memcmp(a->in, b->in, sizeof a->in) == 0 &&
           memcmp(a->v, b->v, sizeof a->v) == 0 && memcmp(a->wrap, b->wrap, sizeof a->wrap) == 0 &&
           memcmp(a->uv, b->uv, sizeof a->uv) == 0;
}

static uint16_t append(nqm_textured *t, const nqm_map_node *node) {
    for (size_t i = 0; i < t->n_nodes; ++i)
        if (is_same(&t->nodes[i], node))
            return (uint16_t)i;
    nqm_map_node *nodes =
        t->n_nodes == NQM_MAX_MAP_NODES ? NULL : nqm_grow(t->nodes, &t->max_nodes, t->n_nodes + 1, sizeof *nodes);
    if (!nodes)
        return NQM_NO_NODE;
    t->nodes = nodes;
    nodes[t->n_nodes] = *node;
    return (uint16_t)t->n_nodes++;
}

bool nqm_graph_is_constant(const nqm_textured *t, uint16_t node) {
    return node != NQM_NO_NODE && t->nodes[node].op == NQM_MAP_VALUE;
}

/* in[0] * 1 or in[0] + 0, as of the unused factor of an image. */
static bool is_neutral(const nqm_textured *t, const nqm_map_node *node) {
    const double neutral = node->op == NQM_MAP_MULTIPLY;
    if ((node->op != NQM_MAP_MULTIPLY && node->op != NQM_MAP_ADD) || t->nodes[node->in[0]].n != node->n)
        return false;
    const nqm_map_node *second = &t->nodes[node->in[1]];
    bool is = second->op == NQM_MAP_VALUE;
    for (size_t c = 0; c < second->n; ++c)
        is = is && second->v[c] == neutral;
    return is;
}

uint16_t nqm_graph_add(nqm_textured *t, nqm_map_node node) {
    const size_t n_operands = nqm_graph_operands(node.op, node.n);
    nqm_map_node local = node;
    double values[4][4], v[4];
    bool is_constant = n_operands > 0, is_finite = true;
    for (size_t i = 0; i < n_operands; ++i) {
        if (node.in[i] == NQM_NO_NODE)
            return NQM_NO_NODE;
        is_constant = is_constant && nqm_graph_is_constant(t, node.in[i]);
        if (is_constant)
            nqm_graph_node_value(&t->nodes[node.in[i]], NULL, values[i]);
        local.in[i] = (uint16_t)i;
    }
    for (size_t i = n_operands; i < 4; ++i)
        node.in[i] = 0;
    if (!is_constant)
        return n_operands && is_neutral(t, &node) ? node.in[0] : append(t, &node);
    nqm_graph_node_value(&local, (const double(*)[4])values, v);
    for (size_t c = 0; c < node.n; ++c)
        is_finite = is_finite && isfinite(v[c]);
    return is_finite ? nqm_graph_value(t, node.n, v) : NQM_NO_NODE;
}

uint16_t nqm_graph_value(nqm_textured *t, size_t n, const double *v) {
    nqm_map_node node = {.op = NQM_MAP_VALUE, .n = (uint8_t)n};
    memcpy(node.v, v, n * sizeof *v);
    return append(t, &node);
}

uint16_t nqm_graph_number(nqm_textured *t, double v) {
    return nqm_graph_value(t, 1, &v);
}

uint16_t nqm_graph_compute(nqm_textured *t, nqm_map_op op, size_t n, uint16_t a, uint16_t b, uint16_t c) {
    return nqm_graph_add(t, (nqm_map_node){.op = op, .n = (uint8_t)n, .in = {a, b, c}});
}

uint16_t nqm_graph_with(nqm_textured *t, nqm_map_op op, size_t n, uint16_t a, double b) {
    return nqm_graph_compute(t, op, n, a, nqm_graph_number(t, b), 0);
}

uint16_t nqm_graph_channel(nqm_textured *t, uint16_t of, size_t c) {
    if (of == NQM_NO_NODE || t->nodes[of].n == 1)
        return of;
    return nqm_graph_add(t, (nqm_map_node){.op = NQM_MAP_CHANNEL, .n = 1, .in = {of}, .v = {(double)c}});
}

uint16_t nqm_graph_image_at(nqm_textured *t, size_t image, size_t n, const double uv[2][3], const uint8_t wrap[2]) {
    nqm_map_node node = {.op = NQM_MAP_IMAGE, .n = (uint8_t)n, .image = (uint16_t)image, .uv = {{1, 0, 0}, {0, 1, 0}}};
    if (uv)
        memcpy(node.uv, uv, sizeof node.uv);
    if (wrap)
        memcpy(node.wrap, wrap, sizeof node.wrap);
    return nqm_graph_add(t, node);
}

nqm_map_output *nqm_graph_output(nqm_textured *t, const char *key) {
    size_t i = 0;
    while (i < t->n_outputs && strcmp(t->outputs[i].key, key) != 0)
        ++i;
    return i < t->n_outputs ? &t->outputs[i] : NULL;
}

void nqm_graph_output_set(nqm_textured *t, const char *key, uint16_t node) {
    nqm_map_output *output = nqm_graph_output(t, key);
    if (!output && t->n_outputs == NQM_SCHEMA_MAX_KEYS)
        return;
    output = output ? output : &t->outputs[t->n_outputs++];
    snprintf(output->key, sizeof output->key, "%s", key);
    output->node = node;
}

/* ---- images ------------------------------------------------------------------------------------------------------ */

bool nqm_graph_add_file(nqm_textured *t, const char *from, const char *name, const char *space, size_t *image_ret) {
    nqm_map_image image = {.path = nqm_path_beside(from, name), .name = nqm_strdup(name)};
    snprintf(image.space, sizeof image.space, "%s", space ? space : "");
    return nqm_graph_add_image(t, image, image_ret);
}

/* The same file, or the same part of one: names of images inside of a file tell which one it is. */
static bool is_same_image(const nqm_map_image *a, const nqm_map_image *b) {
    return (a->path || a->n_bytes) && !a->path == !b->path && a->n_bytes == b->n_bytes &&
           strcmp(a->name, b->name) == 0 && strcmp(a->space, b->space) == 0;
}

bool nqm_graph_add_image(nqm_textured *t, nqm_map_image image, size_t *image_ret) {
    const bool is_whole = image.name && (image.path || image.data);
    size_t i = 0;
    while (is_whole && i < t->n_images && !is_same_image(&t->images[i], &image))
        ++i;
    const bool is_new = i == t->n_images, has_room = i < NQM_MAX_MAP_IMAGES;
    nqm_map_image *images =
        is_whole && has_room ? nqm_grow(t->images, &t->max_images, t->n_images + is_new, sizeof *images) : NULL;
    if (!images || !is_new)
        clear_image(&image);
    if (!images)
        return false;
    t->images = images;
    if (is_new)
        images[t->n_images++] = image;
    *image_ret = i;
    return true;
}

nqm_status nqm_textured_open_image(const nqm_map_image *image, nqm_map *map, const unsigned char **data_ret,
                                   size_t *n_ret, nqm_error *err) {
    *map = (nqm_map){0};
    nqm_status status = image->path ? nqm_map_open(image->path, map, err) : NQM_OK;
    const size_t n_all = image->path ? map->n_bytes : image->n_bytes, at = image->path ? image->at : 0;
    const size_t n = image->n_bytes ? image->n_bytes : n_all;
    if (status == NQM_OK && (n == 0 || at > n_all || n > n_all - at))
        status = nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at, "%s: %zu bytes from byte %zu on are wanted, there are %zu",
                          image->name, n, at, n_all);
    *data_ret = status != NQM_OK ? NULL : image->path ? map->data + at : image->data;
    *n_ret = n;
    if (status != NQM_OK)
        nqm_map_close(map);
    return status;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

static void rgb_to_hsv(const double rgb[4], double hsv[4]) {
    const double high = fmax(fmax(rgb[0], rgb[1]), rgb[2]), low = fmin(fmin(rgb[0], rgb[1]), rgb[2]);
    const double range = high - low, saturation = high > 0 ? range / high : 0;
    double hue = 0;
    if (saturation > 0) {
        hue = rgb[0] >= high   ? (rgb[1] - rgb[2]) / range
              : rgb[1] >= high ? 2 + (rgb[2] - rgb[0]) / range
                               : 4 + (rgb[0] - rgb[1]) / range;
        hue = hue < 0 ? hue / 6 + 1 : hue / 6;
    }
    hsv[0] = hue;
    hsv[1] = saturation;
    hsv[2] = high;
}

static void hsv_to_rgb(const double hsv[4], double rgb[4]) {
    /* The channels of the six sectors of the hue: 0 value, 1 low, 2 falling, 3 rising. */
    static const unsigned char sectors[6][3] = {{0, 3, 1}, {2, 0, 1}, {1, 0, 3}, {1, 2, 0}, {3, 1, 0}, {0, 1, 2}};
    const double saturation = hsv[1] < 0.0001 ? 0 : hsv[1], value = hsv[2];
    const double hue = isfinite(hsv[0]) ? 6 * (hsv[0] - floor(hsv[0])) : 0;
    const size_t sector = nqm_smaller((size_t)hue, 5);
    const double fraction = hue - (double)sector;
    const double levels[4] = {value, value * (1 - saturation), value * (1 - saturation * fraction),
                              value * (1 - saturation * (1 - fraction))};
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = levels[sectors[sector][c]];
}

static double smoothstep(double x, double low, double high) {
    if (x <= low || x >= high)
        return x > low;
    const double t = (x - low) / (high - low);
    return t * t * (3 - 2 * t);
}

#define COMPONENT(NAME, N, VALUE)                                                                                      \
    case NQM_MAP_##NAME:                                                                                               \
        return VALUE;
static double component(nqm_map_op op, double a, double b, double c, double d) {
    switch (op) {
        NQM_MAP_COMPONENT_OPS(COMPONENT)
    default:
        return 0;
    }
}

/* 2 a - 1 with x and y scaled, as a unit vector; (0, 0, 1) if it has no length, or where a is black. */
static void normal(const double a[4], const double scale[4], double out[4]) {
    const bool has_value = a[0] != 0 || a[1] != 0 || a[2] != 0;
    for (size_t c = 0; c < 3; ++c)
        out[c] = (2 * a[c] - 1) * (c < 2 ? scale[c] : 1);
    const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    for (size_t c = 0; c < 3; ++c)
        out[c] = length > 0 && has_value ? out[c] / length : c == 2;
}

void nqm_graph_node_value(const nqm_map_node *node, const double (*values)[4], double out[4]) {
    static const double zero[4];
    const size_t n_operands = nqm_graph_operands(node->op, node->n), n = node->n;
    const double *in[4] = {zero, zero, zero, zero};
    for (size_t i = 0; i < n_operands; ++i)
        in[i] = values[node->in[i]];
    switch (node->op) {
    case NQM_MAP_VALUE:
        memcpy(out, node->v, sizeof node->v);
        break;
    case NQM_MAP_CHANNEL:
        out[0] = in[0][(size_t)node->v[0] & 3];
        break;
    case NQM_MAP_COMBINE:
        for (size_t c = 0; c < n; ++c)
            out[c] = in[c][0];
        break;
    case NQM_MAP_LUMINANCE:
        for (size_t c = 0; c < n; ++c)
            out[c] = 0.2126 * in[0][0] + 0.7152 * in[0][1] + 0.0722 * in[0][2];
        break;
    case NQM_MAP_RGB_TO_HSV:
        rgb_to_hsv(in[0], out);
        break;
    case NQM_MAP_HSV_TO_RGB:
        hsv_to_rgb(in[0], out);
        break;
    case NQM_MAP_NORMAL:
        normal(in[0], in[1], out);
        break;
    default:
        for (size_t c = 0; c < n; ++c)
            out[c] = component(node->op, in[0][c], in[1][c], in[2][c], in[3][c]);
    }
    if ((node->op == NQM_MAP_RGB_TO_HSV || node->op == NQM_MAP_HSV_TO_RGB) && n == 4)
        out[3] = in[0][3]; /* alpha */
    for (size_t c = n; c < 4; ++c)
        out[c] = out[n - 1];
}
