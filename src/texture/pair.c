/* SPDX-License-Identifier: MIT
 *
 * Properties and dimensions of two textures beside each other, and their values at texels.
 */
#include "texture/texels.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK };

/* ---- properties -------------------------------------------------------------------------------------------------- */

static bool has_property(const nqm_texel_pair *pair, const char *key) {
    size_t k = 0;
    while (k < pair->n_properties && strcmp(pair->properties[k].key, key) != 0)
        ++k;
    return k < pair->n_properties;
}

static int row_of(const nqm_texture *t, const char *key) {
    for (size_t k = 0; k < t->n_varying; ++k)
        if (strcmp(t->varying[k].key, key) == 0)
            return (int)t->varying[k].at;
    return -1;
}

/* Of a key of the model of one side. */
static void add_property(nqm_texel_pair *pair, size_t side, const nqm_spec_key *key) {
    nqm_pair_property p = {.n = key->n, .at = {-1, -1}};
    if (pair->n_properties == NQM_MAX_PAIR_PROPERTIES || (pair->is_same_model && has_property(pair, key->name)))
        return;
    snprintf(p.key, sizeof p.key, "%s", key->name);
    for (size_t s = 0; s < 2; ++s) {
        p.has[s] = s == side || pair->is_same_model;
        if (p.has[s]) {
            p.at[s] = row_of(pair->side[s], key->name);
            nqm_texture_constant(pair->side[s], key->name, p.constant[s]);
        }
    }
    if (p.at[0] >= 0 || p.at[1] >= 0 ||
        (pair->is_same_model && memcmp(p.constant[0], p.constant[1], sizeof p.constant[0]) != 0))
        pair->properties[pair->n_properties++] = p;
}

static void add_dimension(nqm_texel_pair *pair, int kind, size_t property, size_t component) {
    nqm_pair_dimension *d = &pair->dimensions[pair->n_dimensions++];
    *d = (nqm_pair_dimension){.property = property, .component = component};
    d->kind = kind;
}

/* The first bits of a key are those of differences. */
static void add_dimensions(nqm_texel_pair *pair, int kind, size_t side) {
    for (size_t k = 0; k < pair->n_properties; ++k) {
        const nqm_pair_property *p = &pair->properties[k];
        const bool is_difference = kind == NQM_DIFFERENCE, is_shared = p->has[0] && p->has[1];
        const bool varies = is_difference ? is_shared && (p->at[0] >= 0 || p->at[1] >= 0) : p->at[side] >= 0;
        for (size_t c = 0; varies && (side == 0 || !is_shared) && c < p->n; ++c)
            add_dimension(pair, kind, k, c);
    }
}

void nqm_texel_pair_begin(const nqm_texture *ref, const nqm_texture *test, nqm_texel_pair *pair) {
    *pair = (nqm_texel_pair){.side = {ref, test}, .has_normals = ref->has_normal || test->has_normal};
    size_t size[2];
    for (size_t axis = 0; axis < 2; ++axis)
        pair->period[axis] = 1 / (double)nqm_texture_tiles(ref, test, axis, &size[axis]);
    pair->width = size[0];
    pair->height = size[1];
    pair->n = size[0] * size[1];
    pair->is_same_model = ref->schema && ref->schema == test->schema;
    for (size_t s = 0; s < 2; ++s)
        for (size_t k = 0; pair->side[s]->schema && k < pair->side[s]->schema->n_keys; ++k)
            add_property(pair, s, &pair->side[s]->schema->keys[k]);
    add_dimensions(pair, NQM_DIFFERENCE, 0);
    for (size_t c = 0; pair->has_normals && c < 2; ++c)
        add_dimension(pair, NQM_NORMAL, 0, c);
    add_dimensions(pair, NQM_OF_REF, 0);
    add_dimensions(pair, NQM_OF_TEST, 1);
}

bool nqm_texel_pair_tilts(const nqm_texel_pair *pair) {
    bool tilts = false;
    for (size_t d = 0; d < pair->n_dimensions; ++d)
        tilts = tilts || pair->dimensions[d].kind == NQM_NORMAL;
    return tilts;
}

bool nqm_texel_pair_is_equal(const nqm_texel_pair *pair) {
    bool is_equal = pair->is_same_model;
    for (size_t d = 0; d < pair->n_dimensions; ++d)
        is_equal = is_equal && pair->dimensions[d].kind == NQM_OF_REF;
    for (size_t k = 0; k < pair->n_properties; ++k) /* two constants are a property only if they differ */
        is_equal = is_equal && (pair->properties[k].at[0] >= 0 || pair->properties[k].at[1] >= 0);
    return is_equal;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

size_t nqm_texel_pair_workspace(const nqm_texel_pair *pair) {
    return nqm_texture_workspace(pair->side[0]) + nqm_texture_workspace(pair->side[1]);
}

void nqm_texel_pair_evaluate(const nqm_texel_pair *pair, size_t n, const uint32_t *texels, size_t first,
                             float *workspace, const float *values[2]) {
    double u[BLOCK], v[BLOCK];
    const double du = pair->period[0] / (double)pair->width, dv = pair->period[1] / (double)pair->height;
    for (size_t i = 0; i < n; ++i) {
        const size_t texel = texels ? texels[i] : first + i;
        u[i] = ((double)(texel % pair->width) + 0.5) * du;
        v[i] = ((double)(texel / pair->width) + 0.5) * dv;
    }
    values[0] = nqm_texture_evaluate(pair->side[0], n, u, v, workspace);
    values[1] = nqm_texture_evaluate(pair->side[1], n, u, v, workspace + nqm_texture_workspace(pair->side[0]));
}

float nqm_texel_pair_value(const nqm_pair_property *p, size_t side, const float *values, size_t c, size_t i) {
    return p->at[side] < 0 ? p->constant[side][c] : values[((size_t)p->at[side] + c) * BLOCK + i];
}

void nqm_texel_pair_normal(const nqm_texel_pair *pair, size_t side, const float *values, size_t i, double normal[3]) {
    const nqm_texture *t = pair->side[side];
    for (size_t c = 0; c < 3; ++c)
        normal[c] = t->has_normal ? (double)values[(t->n_values - 3 + c) * BLOCK + i] : c == 2;
}

/* With the axis (-y, x, 0) of the rotation and 1 / (1 + z) in place of (1 - cos) / sin^2. Equal normals give (0, 0, 1) exactly. */
void nqm_texel_pair_tilt(const double ref[3], const double test[3], double tilt[3]) {
    const double x = ref[0], y = ref[1], z = ref[2], along = (x * test[0] + y * test[1]) / (1 + z);
    const bool is_equal = memcmp(ref, test, 3 * sizeof *ref) == 0;
    tilt[0] = is_equal ? 0 : test[0] - x * along - x * test[2];
    tilt[1] = is_equal ? 0 : test[1] - y * along - y * test[2];
    tilt[2] = is_equal ? 1 : x * test[0] + y * test[1] + z * test[2];
}
