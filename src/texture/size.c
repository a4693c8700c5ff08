/* SPDX-License-Identifier: MIT
 *
 * How many texels one period of textured materials has.
 */
#include "texture/evaluate.h"

#include <math.h>

enum { MAX_SIDE = 8192 };

static size_t common_divisor(size_t a, size_t b) {
    return b ? common_divisor(b, a % b) : a;
}

/* Along u (axis 0) or v: texels on the surface, and the number of equal tiles into which all maps divide it; 0: any. */
typedef struct extent {
    double n_texels;
    size_t n_tiles;
} extent;

/* Tiles of an image that is repeated a whole number of times and not turned. */
static size_t count_tiles(const nqm_map_node *node, size_t axis) {
    const double times = fabs(node->uv[axis][axis]), nearest = nearbyint(times);
    const bool is_turned = node->uv[0][1] != 0 || node->uv[1][0] != 0;
    return node->wrap[axis] == NQM_MAP_REPEAT && !is_turned && nearest >= 1 && nearest < 1e6 &&
                   fabs(times - nearest) < 1e-6
               ? (size_t)nearest
               : 1;
}

static void extend(const nqm_texture *t, size_t axis, extent *e) {
    for (size_t k = 0; t->maps && k < t->maps->n_nodes; ++k) {
        const nqm_map_node *node = &t->maps->nodes[k];
        if (!(t->roles[k] & NQM_NODE_NEEDED) || (node->op != NQM_MAP_IMAGE && node->op != NQM_MAP_TEXCOORD))
            continue;
        e->n_tiles = common_divisor(e->n_tiles, node->op == NQM_MAP_IMAGE ? count_tiles(node, axis) : 1);
        if (node->op == NQM_MAP_IMAGE) {
            const nqm_raster *r = &t->images[node->image].raster;
            e->n_texels = fmax(e->n_texels, fmax((double)r->width * fabs(node->uv[0][axis]),
                                                 (double)r->height * fabs(node->uv[1][axis])));
        }
    }
}

size_t nqm_texture_tiles(const nqm_texture *ref, const nqm_texture *test, size_t axis, size_t *n_texels_ret) {
    extent e = {0, 0};
    extend(ref, axis, &e);
    extend(test, axis, &e);
    const size_t n_tiles = nqm_larger(e.n_tiles, 1);
    *n_texels_ret = (size_t)fmin(fmax(ceil(e.n_texels / (double)n_tiles - 1e-6), 1), MAX_SIDE);
    return n_tiles;
}
