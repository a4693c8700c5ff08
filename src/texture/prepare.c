/* SPDX-License-Identifier: MIT
 *
 * What of a textured material varies: its nodes are divided into constant ones, needed ones and others. The material of a texel as a
 * spec.
 */
#include "texture/evaluate.h"

#include <math.h>

/* ---- roles of nodes ---------------------------------------------------------------------------------------------- */

/* Operands are earlier nodes. */
static void find_varying(nqm_texture *t) {
    for (size_t k = 0; k < t->maps->n_nodes; ++k) {
        const nqm_map_node *node = &t->maps->nodes[k];
        bool varies = node->op == NQM_MAP_IMAGE || node->op == NQM_MAP_TEXCOORD;
        for (size_t i = 0; i < nqm_map_operands(node->op, node->n); ++i)
            varies = varies || (t->roles[node->in[i]] & NQM_NODE_VARIES);
        if (varies)
            t->roles[k] = NQM_NODE_VARIES;
        else
            nqm_map_node_value(node, (const double(*)[4])t->constants, t->constants[k]);
    }
}

static void find_needed(nqm_texture *t) {
    for (size_t k = 0; k < t->n_varying; ++k)
        t->roles[t->varying[k].node] |= NQM_NODE_NEEDED;
    if (t->has_normal)
        t->roles[t->maps->normal] |= NQM_NODE_NEEDED;
    for (size_t k = t->maps->n_nodes; k-- > 0;) {
        const nqm_map_node *node = &t->maps->nodes[k];
        if (t->roles[k] == (NQM_NODE_NEEDED | NQM_NODE_VARIES))
            for (size_t i = 0; i < nqm_map_operands(node->op, node->n); ++i)
                t->roles[node->in[i]] |= NQM_NODE_NEEDED;
    }
    for (size_t k = 0; k < t->maps->n_nodes; ++k)
        if (t->roles[k] & NQM_NODE_NEEDED) {
            t->rows[k] = (uint16_t)t->n_rows;
            t->n_rows += t->maps->nodes[k].n;
        }
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

const nqm_spec_key *nqm_texture_key(const nqm_texture *t, const char *key) {
    for (size_t k = 0; t->schema && k < t->schema->n_keys; ++k)
        if (strcmp(t->schema->keys[k].name, key) == 0)
            return &t->schema->keys[k];
    return NULL;
}

static void add_word(nqm_texture *t, const char *word) {
    const size_t used = strlen(t->words);
    snprintf(t->words + used, sizeof t->words - used, "%s%s", used ? " " : "", word);
}

static nqm_status add_output(nqm_texture *t, const nqm_map_output *output, nqm_error *err) {
    const nqm_spec_key *key = nqm_texture_key(t, output->key);
    if (!key)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the model '%s' has no property '%s' that a map can change", t->name,
                        t->shading.model, output->key);
    if (!(t->roles[output->node] & NQM_NODE_VARIES)) {
        nqm_shading_set(&t->shading, key->name, nqm_smaller(key->n, t->maps->nodes[output->node].n),
                        t->constants[output->node]);
        return NQM_OK;
    }
    nqm_varying *p = &t->varying[t->n_varying++];
    *p = (nqm_varying){
        .node = output->node, .n = (uint8_t)key->n, .at = t->n_values, .low = key->low, .high = key->high};
    memcpy(p->key, output->key, sizeof p->key);
    t->n_values += key->n;
    add_word(t, p->key);
    return NQM_OK;
}

nqm_status nqm_texture_prepare(nqm_texture *t, nqm_error *err) {
    const nqm_analytic_model *model = nqm_analytic_model_find(t->maps->shading.model, strlen(t->maps->shading.model));
    t->shading = t->maps->shading;
    t->info.model = t->shading.model;
    if (!model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: there is no model '%s'", t->name, t->shading.model);
    t->schema = &model->schema;
    const size_t n = t->maps->n_nodes;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&t->constants, n, sizeof *t->constants}, {&t->roles, n, 1}, {&t->rows, n, sizeof *t->rows}), err);
    if (status != NQM_OK)
        return status;
    find_varying(t);
    for (size_t i = 0; status == NQM_OK && i < t->maps->n_outputs; ++i)
        status = add_output(t, &t->maps->outputs[i], err);
    t->has_normal = t->maps->normal != NQM_NO_NODE && (t->roles[t->maps->normal] & NQM_NODE_VARIES);
    if (t->has_normal) {
        add_word(t, "normal");
        t->n_values += 3;
    }
    find_needed(t);
    return status;
}

/* ---- materials of texels ----------------------------------------------------------------------------------------- */

void nqm_texture_constant(const nqm_texture *t, const char *name, float v[3]) {
    const nqm_property *p = nqm_shading_find(&t->shading, name);
    const nqm_spec_key *key = nqm_texture_key(t, name);
    for (size_t c = 0; c < 3; ++c)
        v[c] = (float)(p ? p->v[c] : key ? key->fallback : 0);
}

char *nqm_texture_spec(const nqm_texture *t, const float *values, size_t stride) {
    nqm_shading shading = t->shading;
    if (t->argument)
        return nqm_strdup(t->argument);
    for (size_t k = 0; k < t->n_varying; ++k) {
        const nqm_varying *p = &t->varying[k];
        double v[3] = {0};
        for (size_t c = 0; c < p->n; ++c)
            v[c] = fmin(fmax((double)values[(p->at + c) * stride], p->low), p->high);
        nqm_shading_set(&shading, p->key, p->n, v);
    }
    return nqm_shading_spec(&shading);
}

char *nqm_texture_tilt(char *spec, const double normal[3]) {
    enum { MORE = 100 };
    const double sine = hypot(normal[0], normal[1]), degrees = atan2(sine, normal[2]) * 180 / NQM_PI;
    if (!spec || degrees < 1e-3)
        return spec;
    char numbers[2][32], *tilted = nqm_alloc(strlen(spec) + MORE, 1);
    if (tilted)
        snprintf(tilted, strlen(spec) + MORE, "tilt:deg=%s;azimuth=%s;of=%s",
                 nqm_format_double(numbers[0], sizeof numbers[0], fmin(degrees, 60)),
                 nqm_format_double(numbers[1], sizeof numbers[1], atan2(normal[1], normal[0]) * 180 / NQM_PI), spec);
    nqm_free(spec);
    return tilted;
}
