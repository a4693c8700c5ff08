/* SPDX-License-Identifier: MIT
 *
 * What nqm check does with materials that have image maps: the texels to check, and what is suspicious of the maps.
 */
#include "nqm/brdf/check.h"

#include <math.h>
#include <stdlib.h>

/* ---- texels ------------------------------------------------------------------------------------------------------ */

static nqm_status add_texels(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                             nqm_error *err) {
    checked_texels *texels = ((void **)user)[0];
    const nqm_texture *texture = ((void **)user)[1];
    for (size_t i = 0; i < n; ++i) {
        texels->at[texels->n] = samples[i].texel;
        texels->specs[texels->n] = nqm_texture_spec(texture, rows[0], i, NULL);
        if (!texels->specs[texels->n++])
            return nqm_fail_nomem(err, sizeof(nqm_shading));
    }
    return NQM_OK;
}

nqm_status choose_checked_texels(const nqm_texture *texture, checked_texels *texels, nqm_error *err) {
    *texels = (checked_texels){.width = nqm_texture_get_info(texture, NULL).width};
    return visit_texels(texture, MAX_CHECKED_TEXELS, add_texels, (void *[]){texels, (void *)(uintptr_t)texture}, err);
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

enum { MAX_SIDE = 1024, N_VALUES = NQM_SPEC_MAX_KEYS * 3 };

/* A part of the texture at its own size, so that neighbours are neighbours there. */
typedef struct part {
    const nqm_texture *texture;
    size_t width, height;
    double *slope;                       /* (height, width, 2) of the surface, to the right and upwards */
    float low[N_VALUES], high[N_VALUES]; /* of each component of each property */
} part;

/* is_spread: of the whole texture, in place of neighbours. */
static nqm_status read_part(part *p, bool is_spread, nqm_error *err) {
    enum { BLOCK = NQM_TEXEL_BLOCK };
    size_t n_all[2];
    double u[BLOCK], v[BLOCK], normal[3];
    const size_t tiles[2] = {nqm_texture_tiles(p->texture, p->texture, 0, &n_all[0]),
                             nqm_texture_tiles(p->texture, p->texture, 1, &n_all[1])};
    p->width = nqm_smaller(n_all[0], MAX_SIDE);
    p->height = nqm_smaller(n_all[1], MAX_SIDE);
    const double du = 1 / (double)(tiles[0] * (is_spread ? p->width : n_all[0]));
    const double dv = 1 / (double)(tiles[1] * (is_spread ? p->height : n_all[1]));
    p->slope = p->slope ? p->slope : allocate(2 * p->width * p->height, sizeof *p->slope);
    float *rows = allocate((size_t)p->texture->n_rows * BLOCK, sizeof *rows);
    for (size_t first = 0, n; first < p->width * p->height; first += n) {
        n = nqm_smaller(p->width * p->height - first, BLOCK);
        if (show_progress(NULL, "maps", (double)first, (double)(p->width * p->height))) {
            free(rows);
            return nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
        }
        for (size_t i = 0; i < n; ++i) {
            u[i] = ((double)((first + i) % p->width) + 0.5) * du;
            v[i] = ((double)((first + i) / p->width) + 0.5) * dv;
        }
        nqm_texture_evaluate(p->texture, n, u, v, rows);
        for (size_t i = 0; i < n; ++i) {
            nqm_texture_normal(p->texture, rows, i, normal);
            p->slope[2 * (first + i)] = -normal[0] / normal[2];
            p->slope[2 * (first + i) + 1] = -normal[1] / normal[2];
            for (size_t k = 0; k < 3 * p->texture->n_properties; ++k) {
                const float x = (float)nqm_texture_value(p->texture, k / 3, k % 3, rows, i);
                p->low[k] = fminf(p->low[k], x);
                p->high[k] = fmaxf(p->high[k], x);
            }
        }
    }
    free(rows);
    return NQM_OK;
}

/* The normals of a surface of heights have slopes without curl; with the green channel flipped, these have. */
static void suspect_normals(const part *p, json_t *remarks) {
    double curl = 0, flipped = 0, mean[2] = {0, 0};
    for (size_t y = 0; y + 1 < p->height; ++y)
        for (size_t x = 0; x + 1 < p->width; ++x) {
            const double *s = &p->slope[2 * (y * p->width + x)], *right = s + 2, *below = s + 2 * p->width;
            const double along_y = s[0] - below[0], along_x = right[1] - s[1];
            curl += (along_y - along_x) * (along_y - along_x);
            flipped += (along_y + along_x) * (along_y + along_x);
        }
    for (size_t i = 0; i < 2 * p->width * p->height; ++i)
        mean[i % 2] += p->slope[i] / (double)(p->width * p->height);
    const double lean_deg = atan(hypot(mean[0], mean[1])) * 57.29577951308232;
    if (lean_deg > 10)
        json_array_append_new(
            remarks, json_sprintf("the normals lean by %.0f degrees on average: is the map read as sRGB?", lean_deg));
    if (2 * flipped < curl)
        json_array_append_new(remarks, json_string("the normals fit no surface, and do with green flipped: is it a "
                                                   "map for DirectX?"));
}

nqm_status suspect_maps(const nqm_texture *texture, json_t **remarks_ret, nqm_error *err) {
    part p = {.texture = texture};
    for (size_t k = 0; k < N_VALUES; ++k) {
        p.low[k] = INFINITY;
        p.high[k] = -INFINITY;
    }
    nqm_status status = read_part(&p, true, err);
    if (status == NQM_OK)
        status = read_part(&p, false, err);
    json_t *remarks = json_array();
    for (size_t k = 0; status == NQM_OK && k < texture->n_properties; ++k) {
        bool varies = false;
        for (size_t c = 0; c < texture->keys[k].n; ++c)
            varies = varies || p.low[3 * k + c] < p.high[3 * k + c];
        if (texture->properties[k].node != NQM_NO_NODE && !varies)
            json_array_append_new(remarks, json_sprintf("the map of %s is constant", texture->keys[k].name));
    }
    if (status == NQM_OK && texture->normal != NQM_NO_NODE)
        suspect_normals(&p, remarks);
    free(p.slope);
    *remarks_ret = remarks;
    return status;
}
