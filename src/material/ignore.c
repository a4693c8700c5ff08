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

/* The keys of a model that take part; NULL: it has none. Values of keys that the file does not give. */
static const struct parts {
    const char *model, *weight, *color, *metal, *roughness, *sheen;
    double default_color, default_metal;
} parts[] = {
    {"open-pbr", "base_weight", "base_color", "base_metalness", "base_diffuse_roughness", NULL, 0.8, 0},
    {"standard-surface", "base", "base_color", "metalness", "diffuse_roughness", "sheen", 0.8, 0},
    {"gltf", NULL, "base_color", "metallic", NULL, NULL, 1, 1},
    {"disney", NULL, "baseColor", "metallic", NULL, "sheen", 0.16, 0},
    {"principled", NULL, "base_color", "metallic", NULL, NULL, 0.5, 0},
    {"blender-principled", NULL, "base_color", "metallic", NULL, NULL, 0.8, 0},
};

static const struct parts *find_parts(const char *model) {
    size_t i = 0;
    while (i + 1 < sizeof parts / sizeof *parts && strcmp(parts[i].model, model) != 0)
        ++i;
    return &parts[i];
}

static nqm_map_output *find_output(nqm_textured *t, const char *key) {
    size_t i = 0;
    while (i < t->n_outputs && strcmp(t->outputs[i].key, key) != 0)
        ++i;
    return i < t->n_outputs ? &t->outputs[i] : NULL;
}

static uint16_t node_of(nqm_reading *r, const char *key, double value) {
    const nqm_map_output *output = find_output(r->textured, key);
    const nqm_property *p = nqm_shading_find(&r->shading, key);
    return output ? output->node : p ? nqm_graph_value(r->textured, p->n, p->v) : nqm_graph_number(r->textured, value);
}

static void set_key(nqm_reading *r, const char *key, uint16_t node) {
    nqm_textured *t = r->textured;
    if (node == NQM_NO_NODE) {
        r->refusal = r->aside; /* too many nodes, or a value that is not finite */
        return;
    }
    if (!nqm_graph_is_constant(t, node) || find_output(t, key))
        nqm_graph_output_set(t, key, node);
    else
        nqm_shading_set(&r->shading, key, t->nodes[node].n, t->nodes[node].v);
}

/* Multiply a property by a factor. */
static void scale(nqm_reading *r, const char *key, size_t n, double value, uint16_t factor) {
    set_key(r, key, nqm_graph_compute(r->textured, NQM_MAP_MULTIPLY, n, node_of(r, key, value), factor, 0));
}

/* 1 minus a weight, of which only the part that is no metal has a share; *share receives that share. */
static uint16_t rest_of(nqm_reading *r, const struct parts *p, uint16_t weight, uint16_t *share) {
    nqm_textured *t = r->textured;
    const uint16_t one = nqm_graph_number(t, 1), metal = node_of(r, p->metal, p->default_metal);
    *share =
        nqm_graph_compute(t, NQM_MAP_MULTIPLY, 1, nqm_graph_compute(t, NQM_MAP_SUBTRACT, 1, one, metal, 0), weight, 0);
    return nqm_graph_compute(t, NQM_MAP_SUBTRACT, 1, one, *share, 0);
}

/* The diffuse reflection has the color mix(weight color, subsurface color). Between 0 and 1 of the subsurface
 * scattering this is exact for Lambertian reflection, and where the part that is a metal is 0 or 1. */
static void add_subsurface(nqm_reading *r, const struct parts *p) {
    nqm_textured *t = r->textured;
    uint16_t share;
    const uint16_t rest = rest_of(r, p, r->weights[1], &share), color = node_of(r, p->color, p->default_color);
    const uint16_t weighted = nqm_graph_compute(t, NQM_MAP_MULTIPLY, 3, color, node_of(r, p->weight, 1), 0);
    set_key(r, p->color, nqm_graph_compute(t, NQM_MAP_MIX, 3, weighted, r->subsurface_color, share));
    set_key(r, p->weight, nqm_graph_number(t, 1));
    scale(r, p->roughness, 1, 0, rest);
}

/* A constant material that is a metal in part is the mixture of a metal and of a dielectric, of which alone something is ignored:
 * the keys of one material have the same colour for both. */
static void split_metal(nqm_reading *r, const struct parts *p) {
    const nqm_property *metal = nqm_shading_find(&r->shading, p->metal);
    const double share = metal ? metal->v[0] : p->default_metal, zero = 0, one = 1;
    const bool varies = r->textured->n_outputs || r->textured->normal != NQM_NO_NODE;
    if (find_output(r->textured, p->metal) || (varies && share > 0 && share < 1))
        nqm_textured_remark(r->textured, "where it is partly a metal, the metal is darkened with the rest");
    if (varies || !(share > 0 && share < 1))
        return;
    nqm_shading whole = r->shading;
    nqm_shading_set(&whole, p->metal, 1, &one);
    nqm_shading_set(&r->shading, p->metal, 1, &zero);
    r->metal = nqm_shading_spec(&whole);
    r->metal_share = share;
}

void nqm_reading_reflect(nqm_reading *r) {
    const struct parts *p = find_parts(r->shading.model);
    uint16_t share;
    if (!r->textured || strcmp(p->model, r->shading.model) != 0)
        return;
    if (r->weights[0] != NQM_NO_NODE || r->weights[1] != NQM_NO_NODE)
        split_metal(r, p);
    if (r->weights[1] != NQM_NO_NODE && r->subsurface_color != NQM_NO_NODE && p->weight)
        add_subsurface(r, p);
    if (r->weights[0] == NQM_NO_NODE)
        return;
    const uint16_t rest = rest_of(r, p, r->weights[0], &share);
    if (p->weight)
        scale(r, p->weight, 1, 1, rest);
    else
        scale(r, p->color, 3, p->default_color, rest);
    if (p->sheen)
        scale(r, p->sheen, 1, 0, rest);
}
