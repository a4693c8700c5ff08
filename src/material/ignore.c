/* SPDX-License-Identifier: MIT
 *
 * What of a material reflects, when its transmission, subsurface scattering, emission, opacity or displacement is ignored:
 * "ignore:WORDS:FILE:NAME". The last three are left out. The surface shaders mix transmission, and before it
 * subsurface scattering, with the diffuse reflection of the part that is no metal (the node graphs of MaterialX's
 * definitions; KHR_materials_transmission); so the diffuse reflection keeps 1 - transmission, and subsurface scattering
 * becomes diffuse reflection with the albedo that its specification names. What is partly a metal becomes a mixture ("between:");
 * one whose keys vary over the surface has a remark instead: its metal is darkened like the rest, which is right at 0 and 1.
 */
#include "material/rules.h"

static const char *const words[] = {"transmission", "subsurface", "emission", "opacity", "displacement", "bump"};
enum { N_WORDS = sizeof words / sizeof *words };

const char *nqm_ignore_words(unsigned set, char text[NQM_IGNORE_SIZE]) {
    size_t used = 0;
    *text = 0;
    for (size_t i = 0; i < N_WORDS; ++i)
        if (set & 1U << i)
            used += (size_t)snprintf(text + used, NQM_IGNORE_SIZE - used, "%s%s", used ? "," : "", words[i]);
    return text;
}

bool nqm_ignore_parse(const char *text, size_t n, unsigned *set_ret) {
    *set_ret = 0;
    for (const char *end = text + n; text <= end;) {
        const char *comma = memchr(text, ',', (size_t)(end - text));
        const size_t n_word = (size_t)((comma ? comma : end) - text);
        size_t i = 0;
        while (i < N_WORDS && !(strlen(words[i]) == n_word && memcmp(words[i], text, n_word) == 0))
            ++i;
        if (i == N_WORDS) {
            *set_ret = 0;
            return false;
        }
        *set_ret |= 1U << i;
        text += n_word + 1;
    }
    return true;
}

nqm_status nqm_ignore_refuse(const char *text, nqm_error *err) {
    return nqm_fail(
        err, NQM_ERR_ARG, -1,
        "what is ignored is a list with commas of transmission, subsurface, emission, opacity, displacement "
        "and bump, not '%.*s'",
        (int)strcspn(text, ":"), text);
}

/* ---- what reflects ----------------------------------------------------------------------------------------------- */

static const nqm_schema_key *key_of(const nqm_reading *r, nqm_role role) {
    return &r->values.schema->keys[nqm_schema_key_of(r->values.schema, role)];
}

static uint16_t node_of(nqm_reading *r, const nqm_schema_key *key) {
    const nqm_map_output *output = nqm_graph_output(r->textured, key->name);
    return output ? output->node : nqm_graph_value(r->textured, key->n, r->values.v[key - r->values.schema->keys]);
}

static void set_key(nqm_reading *r, const nqm_schema_key *key, uint16_t node) {
    nqm_textured *t = r->textured;
    if (node == NQM_NO_NODE) {
        r->refusal = r->aside; /* too many nodes, or a value that is not finite */
        return;
    }
    if (!nqm_graph_is_constant(t, node) || nqm_graph_output(t, key->name))
        nqm_graph_output_set(t, key->name, node);
    else
        nqm_values_set(&r->values, key->name, t->nodes[node].n, t->nodes[node].v);
}

/* Multiply a property by a factor. */
static void scale(nqm_reading *r, const nqm_schema_key *key, uint16_t factor) {
    set_key(r, key, nqm_graph_compute(r->textured, NQM_MAP_MULTIPLY, key->n, node_of(r, key), factor, 0));
}

/* 1 minus a weight, of which only the part that is no metal has a share; *share receives that share. */
static uint16_t rest_of(nqm_reading *r, uint16_t weight, uint16_t *share) {
    nqm_textured *t = r->textured;
    const uint16_t one = nqm_graph_number(t, 1), metal = node_of(r, key_of(r, NQM_ROLE_METAL));
    *share =
        nqm_graph_compute(t, NQM_MAP_MULTIPLY, 1, nqm_graph_compute(t, NQM_MAP_SUBTRACT, 1, one, metal, 0), weight, 0);
    return nqm_graph_compute(t, NQM_MAP_SUBTRACT, 1, one, *share, 0);
}

/* The diffuse reflection has the color mix(weight color, subsurface color). Between 0 and 1 of the subsurface
 * scattering this is exact for Lambertian reflection, and where the part that is a metal is 0 or 1. */
static void add_subsurface(nqm_reading *r) {
    const nqm_schema_key *color = key_of(r, NQM_ROLE_BASE_COLOR), *weight = key_of(r, NQM_ROLE_BASE_WEIGHT);
    nqm_textured *t = r->textured;
    uint16_t share;
    const uint16_t rest = rest_of(r, r->weights[1], &share);
    const uint16_t weighted = nqm_graph_compute(t, NQM_MAP_MULTIPLY, 3, node_of(r, color), node_of(r, weight), 0);
    set_key(r, color, nqm_graph_compute(t, NQM_MAP_MIX, 3, weighted, r->subsurface_color, share));
    set_key(r, weight, nqm_graph_number(t, 1));
    scale(r, key_of(r, NQM_ROLE_DIFFUSE_ROUGHNESS), rest);
}

/* A constant material that is a metal in part is the mixture of a metal and of a dielectric, of which alone something is ignored:
 * the keys of one material have the same colour for both. */
static void split_metal(nqm_reading *r) {
    const char *metal = key_of(r, NQM_ROLE_METAL)->name;
    const double share = r->values.v[nqm_schema_key_of(r->values.schema, NQM_ROLE_METAL)][0], zero = 0, one = 1;
    const bool varies = r->textured->n_outputs || r->textured->normal != NQM_NO_NODE;
    if (nqm_graph_output(r->textured, metal) || (varies && share > 0 && share < 1))
        nqm_textured_remark(r->textured, "where it is partly a metal, the metal is darkened with the rest");
    if (varies || !(share > 0 && share < 1))
        return;
    nqm_values whole = r->values;
    nqm_values_set(&whole, metal, 1, &one);
    nqm_values_set(&r->values, metal, 1, &zero);
    r->metal = nqm_values_spec(&whole);
    r->metal_share = share;
}

void nqm_reading_reflect(nqm_reading *r) {
    const nqm_schema *schema = r->values.schema;
    uint16_t share;
    size_t n_below = 0;
    for (size_t k = 0; schema && k < schema->n_keys; ++k)
        n_below += schema->keys[k].is_below;
    if (!r->textured || n_below == 0)
        return;
    if (r->weights[0] != NQM_NO_NODE || r->weights[1] != NQM_NO_NODE)
        split_metal(r);
    if (r->weights[1] != NQM_NO_NODE && r->subsurface_color != NQM_NO_NODE &&
        nqm_schema_key_of(schema, NQM_ROLE_BASE_WEIGHT) < schema->n_keys)
        add_subsurface(r);
    if (r->weights[0] == NQM_NO_NODE)
        return;
    const uint16_t rest = rest_of(r, r->weights[0], &share);
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (schema->keys[k].is_below)
            scale(r, &schema->keys[k], rest);
}
