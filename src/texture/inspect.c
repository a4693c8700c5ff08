/* SPDX-License-Identifier: MIT
 *
 * What the values of maps cannot be: looks at a grid of positions and says in the remark of a texture which properties leave the
 * range of their key, to which they are moved, and where the normal map holds no direction.
 */
#include "texture/texture.h"

#include <math.h>

enum { SIDE = 128, BLOCK = NQM_TEXEL_BLOCK };

static double value(const nqm_texture *t, uint16_t node, size_t c, const float *rows, size_t i) {
    const size_t last = (size_t)t->maps->nodes[node].n - 1;
    return (double)rows[(t->rows[node] + nqm_smaller(c, last)) * (size_t)BLOCK + i];
}

static bool leaves_range(const nqm_texture *t, size_t property, const float *rows, size_t i) {
    const nqm_texture_property *p = &t->properties[property];
    const double slack = 1e-4; /* of matrices of colour spaces */
    bool leaves = false;
    for (size_t c = 0; p->node != NQM_NO_NODE && c < p->key->n; ++c) {
        const double x = (double)rows[(size_t)p->row[c] * BLOCK + i];
        leaves = leaves || !(x >= p->key->low - slack && x <= p->key->high + slack);
    }
    return leaves;
}

/* Too short to have a direction, as grey is, or below the surface. */
static bool is_no_normal(const nqm_texture *t, const float *rows, size_t i) {
    const double least = 0.05;
    const nqm_map_node *node = &t->maps->nodes[t->normal];
    const bool is_coded = node->op == NQM_MAP_NORMAL;
    double v[3];
    for (size_t c = 0; c < 3; ++c)
        v[c] = is_coded ? 2 * value(t, node->in[0], c, rows, i) - 1 : value(t, t->normal, c, rows, i);
    return v[2] < 0 || nqm_dot3(v, v) < least * least;
}

static void say(nqm_texture *t, const char *what, size_t n, size_t n_all, const char *how) {
    char text[300];
    snprintf(text, sizeof text, "%s at %.2g %% of the surface: %s", what, 100 * (double)n / (double)n_all, how);
    if (n)
        nqm_remark_add(t->remark, sizeof t->remark, "%s", text);
}

nqm_status nqm_texture_inspect(nqm_texture *t, nqm_error *err) {
    const size_t n_rows = (size_t)t->n_rows * BLOCK;
    float *rows = nqm_alloc(n_rows, sizeof *rows);
    size_t size[2], n_outside[NQM_SCHEMA_MAX_KEYS] = {0}, n_below = 0;
    if (!rows)
        return nqm_fail_nomem(err, n_rows * sizeof *rows);
    for (size_t axis = 0; axis < 2; ++axis) {
        (void)nqm_texture_tiles(t, t, axis, &size[axis]);
        size[axis] = nqm_smaller(size[axis], SIDE);
    }
    const size_t n_all = size[0] * size[1];
    for (size_t first = 0; first < n_all; first += BLOCK) {
        const size_t n = nqm_smaller(BLOCK, n_all - first);
        double u[BLOCK], v[BLOCK];
        for (size_t i = 0; i < n; ++i) {
            u[i] = ((double)((first + i) % size[0]) + 0.5) / (double)size[0];
            v[i] = ((double)((first + i) / size[0]) + 0.5) / (double)size[1];
        }
        nqm_texture_evaluate(t, n, u, v, rows);
        for (size_t i = 0; i < n; ++i) {
            for (size_t k = 0; k < t->n_properties; ++k)
                n_outside[k] += leaves_range(t, k, rows, i);
            n_below += t->normal != NQM_NO_NODE && is_no_normal(t, rows, i);
        }
    }
    nqm_free(rows);
    for (size_t i = 0; i < t->maps->n_images; ++i) {
        char text[300];
        snprintf(text, sizeof text, "%.200s has no alpha, which is read as 1", t->maps->images[i].name);
        if (t->maps->images[i].expects_alpha && t->images[i].raster.channels % 2)
            nqm_remark_add(t->remark, sizeof t->remark, "%s", text);
    }
    for (size_t k = 0; k < t->n_properties; ++k) {
        char range[80];
        snprintf(range, sizeof range, "it is moved into %g to %g", t->keys[k].low, t->keys[k].high);
        say(t, t->keys[k].name, n_outside[k], n_all, range);
    }
    say(t, "the normal map has no direction above the surface", n_below, n_all,
        "it is read as the steepest or as the normal of the surface");
    return NQM_OK;
}
