/* SPDX-License-Identifier: MIT
 *
 * Textured materials: lists of nodes, without doubles, and of images.
 */
#include "material/maps.h"

#include <string.h>

nqm_textured *nqm_textured_create(void) {
    nqm_textured *t = nqm_alloc(1, sizeof *t);
    if (t)
        t->normal = NQM_NO_NODE;
    return t;
}

void nqm_textured_free(nqm_textured *t) {
    if (!t)
        return;
    for (size_t i = 0; i < t->n_images; ++i) {
        nqm_free(t->images[i].path);
        nqm_free(t->images[i].data);
        nqm_free(t->images[i].name);
    }
    nqm_free(t->images);
    nqm_free(t->nodes);
    nqm_free(t);
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

size_t nqm_map_operands(nqm_map_op op, size_t n) {
    switch (op) {
    case NQM_MAP_VALUE:
    case NQM_MAP_IMAGE:
    case NQM_MAP_TEXCOORD:
        return 0;
    case NQM_MAP_ABSOLUTE:
    case NQM_MAP_FLOOR:
    case NQM_MAP_SINE:
    case NQM_MAP_COSINE:
    case NQM_MAP_CHANNEL:
    case NQM_MAP_LUMINANCE:
    case NQM_MAP_RGB_TO_HSV:
    case NQM_MAP_HSV_TO_RGB:
        return 1;
    case NQM_MAP_MIX:
    case NQM_MAP_SMOOTHSTEP:
        return 3;
    case NQM_MAP_IF_GREATER:
    case NQM_MAP_IF_EQUAL:
        return 4;
    case NQM_MAP_COMBINE:
        return n;
    default:
        return 2;
    }
}

static bool is_same(const nqm_map_node *a, const nqm_map_node *b) {
    return a->op == b->op && a->n == b->n && a->image == b->image && memcmp(a->in, b->in, sizeof a->in) == 0 &&
           memcmp(a->v, b->v, sizeof a->v) == 0 && memcmp(a->wrap, b->wrap, sizeof a->wrap) == 0 &&
           memcmp(a->uv, b->uv, sizeof a->uv) == 0;
}

uint16_t nqm_map_add(nqm_textured *t, nqm_map_node node) {
    for (size_t i = 0; i < nqm_map_operands(node.op, node.n); ++i)
        if (node.in[i] == NQM_NO_NODE)
            return NQM_NO_NODE;
    for (size_t i = 0; i < t->n_nodes; ++i)
        if (is_same(&t->nodes[i], &node))
            return (uint16_t)i;
    if (t->n_nodes == NQM_MAX_MAP_NODES)
        return NQM_NO_NODE;
    nqm_map_node *nodes = nqm_grow(t->nodes, &t->max_nodes, t->n_nodes + 1, sizeof *nodes);
    if (!nodes)
        return NQM_NO_NODE;
    t->nodes = nodes;
    nodes[t->n_nodes] = node;
    return (uint16_t)t->n_nodes++;
}

uint16_t nqm_map_value(nqm_textured *t, size_t n, const double *v) {
    nqm_map_node node = {.op = NQM_MAP_VALUE, .n = (uint8_t)n};
    memcpy(node.v, v, n * sizeof *v);
    return nqm_map_add(t, node);
}

uint16_t nqm_map_compute(nqm_textured *t, nqm_map_op op, size_t n, uint16_t a, uint16_t b, uint16_t c) {
    return nqm_map_add(t, (nqm_map_node){.op = op, .n = (uint8_t)n, .in = {a, b, c}});
}

uint16_t nqm_map_channel(nqm_textured *t, uint16_t of, size_t c) {
    if (of == NQM_NO_NODE || t->nodes[of].n == 1)
        return of;
    return nqm_map_add(t, (nqm_map_node){.op = NQM_MAP_CHANNEL, .n = 1, .in = {of}, .v = {(double)c}});
}

uint16_t nqm_map_image_at(nqm_textured *t, size_t image, size_t n, const double uv[2][3], const uint8_t wrap[2]) {
    nqm_map_node node = {.op = NQM_MAP_IMAGE, .n = (uint8_t)n, .image = (uint16_t)image};
    memcpy(node.uv, uv, sizeof node.uv);
    memcpy(node.wrap, wrap, sizeof node.wrap);
    return nqm_map_add(t, node);
}

void nqm_map_output_set(nqm_textured *t, const char *key, uint16_t node) {
    size_t i = 0;
    while (i < t->n_outputs && strcmp(t->outputs[i].key, key) != 0)
        ++i;
    if (i == NQM_MAX_PROPERTIES)
        return;
    t->n_outputs = nqm_larger(t->n_outputs, i + 1);
    snprintf(t->outputs[i].key, sizeof t->outputs[i].key, "%s", key);
    t->outputs[i].node = node;
}

/* ---- images ------------------------------------------------------------------------------------------------------ */

bool nqm_map_add_file(nqm_textured *t, const char *from, const char *name, const char *space, size_t *image_ret) {
    nqm_map_image image = {.path = nqm_path_beside(from, name), .name = nqm_strdup(name)};
    snprintf(image.space, sizeof image.space, "%s", space ? space : "");
    for (size_t i = 0; image.path && i < t->n_images; ++i)
        if (t->images[i].path && t->images[i].n_bytes == 0 && strcmp(t->images[i].path, image.path) == 0 &&
            strcmp(t->images[i].space, image.space) == 0) {
            *image_ret = i;
            nqm_free(image.path);
            nqm_free(image.name);
            return true;
        }
    return nqm_map_add_image(t, image, image_ret);
}

bool nqm_map_add_image(nqm_textured *t, nqm_map_image image, size_t *image_ret) {
    const bool is_whole = image.name && (image.path || image.data), has_room = t->n_images < NQM_MAX_MAP_IMAGES;
    nqm_map_image *images =
        is_whole && has_room ? nqm_grow(t->images, &t->max_images, t->n_images + 1, sizeof *images) : NULL;
    if (!images) {
        nqm_free(image.path);
        nqm_free(image.data);
        nqm_free(image.name);
        return false;
    }
    t->images = images;
    images[t->n_images] = image;
    *image_ret = t->n_images++;
    return true;
}
