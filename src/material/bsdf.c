/* SPDX-License-Identifier: MIT
 *
 * Lists of BSDFs with their properties, and the reading of one by the rules of its type.
 */
#include "material/bsdf.h"

#include <math.h>

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

enum { MAX_NODES = 100 * 1000 };

nqm_status nqm_bsdf_add(nqm_bsdf_nodes *nodes, const nqm_bsdf_node *node, const char *path, nqm_error *err) {
    if (nodes->n == MAX_NODES)
        return nqm_fail(err, NQM_ERR_LIMIT, node->byte_offset, "%s: more than %d properties of BSDFs (byte %lld)", path,
                        MAX_NODES, (long long)node->byte_offset);
    nqm_bsdf_node *list = nqm_grow(nodes->list, &nodes->max_n, nodes->n + 1, sizeof *list);
    if (!list)
        return nqm_fail_nomem(err, (nodes->n + 1) * sizeof *list);
    nodes->list = list;
    nqm_bsdf_node *copy = &list[nodes->n];
    *copy = *node;
    char **texts[] = {&copy->type, &copy->name, &copy->id, &copy->value};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        *texts[i] = *texts[i] ? *texts[i] : "";
    nqm_status status = nqm_texts_copy(sizeof texts / sizeof *texts, texts, err);
    nodes->n += status == NQM_OK;
    return status;
}

void nqm_bsdf_cut(nqm_bsdf_nodes *nodes, size_t n) {
    while (nodes->n > n)
        nqm_free(nodes->list[--nodes->n].type); /* the first text owns the block */
}

void nqm_bsdf_clear(nqm_bsdf_nodes *nodes) {
    nqm_bsdf_cut(nodes, 0);
    nqm_free(nodes->list);
    *nodes = (nqm_bsdf_nodes){.n = 0};
}

const nqm_bsdf_node *nqm_bsdf_next(const nqm_bsdf_nodes *nodes, size_t parent, const nqm_bsdf_node *after) {
    /* A child comes after its parent, and the first node that is no descendant ends the search. */
    for (size_t i = after ? (size_t)(after - nodes->list) + 1 : parent + 1;
         i < nodes->n && nodes->list[i].parent != NQM_BSDF_ROOT && nodes->list[i].parent >= parent; ++i)
        if (nodes->list[i].parent == parent)
            return &nodes->list[i];
    return NULL;
}

nqm_bsdf_kind nqm_bsdf_kind_of(const nqm_bsdf_word *kinds, const char *word) {
    while (kinds->words && !nqm_contains_word(kinds->words, word, false))
        ++kinds;
    return kinds->words ? kinds->kind : NQM_BSDF_OTHER;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* "#rrggbb" in the encoding of sRGB (IEC 61966-2-1) to linear values. */
static bool parse_hex(const char *text, double rgb[3]) {
    if (*text != '#' || strlen(text) != 7 || strspn(text + 1, "0123456789abcdefABCDEF") != 6)
        return false;
    for (size_t c = 0; c < 3; ++c) {
        unsigned byte = 0;
        sscanf(text + 1 + 2 * c, "%2x", &byte);
        rgb[c] = nqm_srgb_to_linear(byte / 255.0);
    }
    return true;
}

#define IS_PLUGIN    "%s is of type '%.40s'; only constants are read, no textures or plugins"
#define IS_REFERENCE "%s refers to the object '%.40s'; only constants are read"

/* Fail for a node that holds no constant numbers. */
static bool check_kind(nqm_reading *r, const nqm_bsdf_node *node) {
    if (node->kind == NQM_BSDF_OTHER || node->kind == NQM_BSDF_BSDF || node->kind == NQM_BSDF_TEXTURE)
        return nqm_refuse(r, node, IS_PLUGIN, node->name, node->type);
    if (node->kind == NQM_BSDF_REF)
        return nqm_refuse(r, node, IS_REFERENCE, node->name, node->id);
    if (node->kind == NQM_BSDF_STRING || node->kind == NQM_BSDF_BOOLEAN)
        return nqm_refuse(r, node, "%s needs a number, not '%.40s'", node->name, node->value);
    if (node->kind == NQM_BSDF_SPECTRUM && !*node->value)
        return nqm_refuse(r, node, "%s is a spectrum of type '%.40s', which is not read; give it value or filename",
                          node->name, node->type);
    return true;
}

static bool read_values(nqm_reading *r, const nqm_rule *rule, const void *property, double v[4], size_t *n) {
    const nqm_bsdf_node *node = property;
    const bool is_rgb = node->kind == NQM_BSDF_RGB, is_triple = node->kind == NQM_BSDF_TRIPLE;
    if (!check_kind(r, node))
        return false;
    const bool is_spectrum = node->kind == NQM_BSDF_SPECTRUM && nqm_parse_numbers(node->value, 1, v) != 1;
    if (is_spectrum && rule->n == 1)
        return nqm_refuse(r, node, "%s needs a number, not the spectrum '%.40s'", node->name, node->value);
    if (is_spectrum && !nqm_bsdf_spectrum((nqm_bsdf_reading *)r, node, v))
        return false;
    *n = is_spectrum || (is_rgb && parse_hex(node->value, v)) ? 3 : nqm_parse_numbers(node->value, 3, v);
    if (!(*n == 1 && !is_triple) && !(*n == 3 && (is_rgb || is_triple || is_spectrum)))
        return nqm_refuse(r, node, "%s needs %s, not '%.40s'", node->name,
                          is_rgb      ? "one or three numbers"
                          : is_triple ? "three numbers"
                                      : "a number",
                          node->value);
    if (rule->n == 1 && (is_triple || (*n == 3 && !(v[0] == v[1] && v[0] == v[2]))))
        return nqm_refuse(r, node, "%s needs a number, not the colour '%.40s'", node->name, node->value);
    *n = nqm_smaller(*n, rule->n);
    return true;
}

static int64_t byte_of(const nqm_reading *r, const void *property) {
    (void)r;
    return ((const nqm_bsdf_node *)property)->byte_offset;
}

const nqm_rule_source nqm_bsdf_source = {.term = "property", .read = read_values, .byte_of = byte_of};

/* ---- a BSDF ------------------------------------------------------------------------------------------------------ */

const nqm_bsdf_node *nqm_bsdf_find(const nqm_bsdf_reading *r, const char *name) {
    const nqm_bsdf_node *node = NULL;
    while ((node = nqm_bsdf_next(r->nodes, r->at, node)) && strcmp(node->name, name) != 0) {
    }
    return node;
}

bool nqm_bsdf_numbers(nqm_bsdf_reading *r, const char *name, size_t n, double *v) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    double values[4];
    size_t n_values;
    if (!node)
        return true;
    if (!read_values(&r->reading, &(nqm_rule){.n = n}, node, values, &n_values))
        return false;
    for (size_t c = 0; c < n; ++c)
        v[c] = values[n_values == n ? c : 0];
    return true;
}

bool nqm_bsdf_flag(nqm_bsdf_reading *r, const char *name, bool *v) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    if (!node)
        return true;
    *v = strcmp(node->value, "true") == 0;
    if (node->kind == NQM_BSDF_BOOLEAN && (*v || strcmp(node->value, "false") == 0))
        return true;
    return nqm_refuse(&r->reading, node, "%s needs true or false", name);
}

bool nqm_bsdf_choice(nqm_bsdf_reading *r, const char *name, const char *words, size_t *v) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    *v = node && node->kind == NQM_BSDF_STRING ? nqm_find_word(words, node->value, false) : node ? SIZE_MAX : 0;
    return *v != SIZE_MAX ||
           nqm_refuse(&r->reading, node, "%s is '%.40s'; these are read: %s", name, node->value, words);
}

bool nqm_bsdf_file(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const nqm_bsdf_node *node = property;
    r->file = node->value;
    return (node->kind == NQM_BSDF_STRING && *r->file) ||
           nqm_refuse(r, node, "%s needs the name of a file", rule->name);
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

void nqm_bsdf_varies(nqm_bsdf_reading *r, const nqm_bsdf_node *node) {
    const bool is_reference = node->kind == NQM_BSDF_REF;
    nqm_vary(&r->reading, node, is_reference ? IS_REFERENCE : IS_PLUGIN, node->name,
             is_reference ? node->id : node->type);
}

bool nqm_bsdf_is_texture(const nqm_bsdf_node *node) {
    return node && (node->kind == NQM_BSDF_TEXTURE || node->kind == NQM_BSDF_REF);
}

bool nqm_bsdf_check(nqm_bsdf_reading *r, const char *read, const char *unused) {
    const nqm_bsdf_node *texture = &r->nodes->list[r->at], *property = NULL;
    while ((property = nqm_bsdf_next(r->nodes, r->at, property)))
        if (nqm_contains_word(unused, property->name, false))
            nqm_reading_unused(&r->reading, property->name);
        else if (!nqm_contains_word(read, property->name, false))
            return nqm_refuse(&r->reading, property, "%s has no property '%.40s'", texture->type, property->name);
    return true;
}

const nqm_bsdf_node *nqm_bsdf_filename(nqm_bsdf_reading *r) {
    const nqm_bsdf_node *texture = &r->nodes->list[r->at], *file = nqm_bsdf_find(r, "filename");
    if (file && file->kind == NQM_BSDF_STRING && *file->value)
        return file;
    nqm_refuse(&r->reading, texture, "the %s texture '%.40s' has no filename", texture->type,
               *texture->id ? texture->id : texture->name);
    return NULL;
}

bool nqm_bsdf_is_float_image(const char *file) {
    const char *dot = strrchr(file, '.');
    return dot && nqm_contains_word(".exr .hdr .rgbe .pfm", dot, true);
}

bool nqm_bsdf_image(nqm_bsdf_reading *r, const nqm_bsdf_node *file, const char *space, const double uv[2][3],
                    nqm_map_wrap wrap, uint16_t *value_ret) {
    nqm_textured *t = r->reading.textured;
    size_t image;
    if (!nqm_graph_add_file(t, r->path, file->value, space, &image))
        return nqm_refuse(&r->reading, file, "%s: more than %d images, or memory is short", file->value,
                          NQM_MAX_MAP_IMAGES);
    *value_ret = nqm_graph_image_at(t, image, 3, uv, (const uint8_t[2]){(uint8_t)wrap, (uint8_t)wrap});
    return true;
}

bool nqm_bsdf_output(nqm_bsdf_reading *r, const char *key, uint16_t value) {
    nqm_textured *t = r->reading.textured;
    const bool is_normal = strcmp(key, "normal") == 0;
    if (is_normal)
        t->normal = value = nqm_graph_with(t, NQM_MAP_NORMAL, 3, value, 1);
    if (value == NQM_NO_NODE)
        return nqm_refuse(&r->reading, &r->nodes->list[r->at],
                          "%s: it is not finite, its textures need more than %d operations, or memory is short", key,
                          NQM_MAX_MAP_NODES);
    if (nqm_graph_is_constant(t, value))
        nqm_values_set(&r->reading.values, key, t->nodes[value].n, t->nodes[value].v);
    else if (!is_normal)
        nqm_graph_output_set(t, key, value);
    return true;
}

/* ---- interfaces -------------------------------------------------------------------------------------------------- */

/* Without absorption the Fresnel factor of conductors is that of dielectrics. The faces of a pane reflect 2 R / (1 +
 * R), with light that is reflected between them: that of an absorbing index differs by at most 12 % for eta from 1.33
 * to 3, and not at normal incidence. */
bool nqm_bsdf_interface(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf, double eta, bool is_thin) {
    nqm_textured *t = r->reading.textured;
    double k = 0;
    if (!(eta > 0 && eta <= 20))
        return nqm_refuse(&r->reading, bsdf, "the index of refraction is %.4g; the model's range is 0 to 20", eta);
    if (is_thin) {
        const double one = (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)), both = 2 * one / (1 + one);
        eta = 1.08;
        k = sqrt(fmax(0, (both * (eta + 1) * (eta + 1) - (eta - 1) * (eta - 1)) / (1 - both)));
    }
    return nqm_set_aside(&r->reading, NQM_IGNORE_TRANSMISSION, bsdf, "transmission is not supported") &&
           nqm_bsdf_output(r, "eta", nqm_graph_number(t, eta)) && nqm_bsdf_output(r, "k", nqm_graph_number(t, k));
}

/* ---- types ------------------------------------------------------------------------------------------------------- */

const nqm_bsdf_plugin *nqm_bsdf_find_plugin(const nqm_bsdf_plugin *plugins, const char *type) {
    while (plugins->type && !nqm_contains_word(plugins->type, type, false))
        ++plugins;
    return plugins->type ? plugins : NULL;
}

bool nqm_bsdf_read(nqm_bsdf_reading *r, const nqm_bsdf_plugin *plugins, const char *type) {
    nqm_reading *reading = &r->reading;
    const nqm_bsdf_node *bsdf = &r->nodes->list[r->at], *property = NULL;
    const nqm_bsdf_plugin *p = nqm_bsdf_find_plugin(plugins, type);
    if (!p)
        return nqm_refuse(reading, bsdf, "the type '%.40s' is not known", type);
    if (p->refusal)
        return nqm_refuse(reading, bsdf, "%s", p->refusal);
    reading->rules = p->rules;
    reading->owner = p->type;
    if (p->model)
        reading->values = nqm_values_of(nqm_schema_find(p->model, strlen(p->model)));
    while ((property = nqm_bsdf_next(r->nodes, r->at, property)))
        if (!nqm_rules_apply(reading, property->name, property, nqm_bsdf_find(r, property->name) != property))
            return false;
    if (!p->model && *reading->varies.text)
        return nqm_refuse(reading, bsdf, "a measured BSDF with maps is not supported");
    if (!p->model && !reading->file)
        return nqm_refuse(reading, bsdf, "filename is missing");
    return !p->finish || p->finish(r, bsdf);
}

/* ---- indices of refraction of conductors, with their sources in presets/metals.txt -------------------------------- */

static const nqm_metal metals[] = {
#include "metals_table.h" /* generated from presets/metals.txt */
};
enum { N_METALS = sizeof metals / sizeof *metals };

/* Whether row i is one of pbrt's spectra, or else of Mitsuba's materials. */
static bool is_of(bool is_pbrt, size_t i) {
    return is_pbrt == (strncmp(metals[i].name, "metal-", 6) == 0);
}

/* "Au_palik" is "Au" unless it has a row of its own, which comes later. */
const nqm_metal *nqm_metal_find(bool is_pbrt, const char *name) {
    const size_t n = strlen(name), n_suffix = strlen("_palik");
    const bool has_suffix = n > n_suffix && strcmp(name + n - n_suffix, "_palik") == 0;
    const nqm_metal *found = NULL;
    for (size_t i = 0; i < N_METALS; ++i)
        if (is_of(is_pbrt, i) &&
            (strcmp(metals[i].name, name) == 0 || (has_suffix && strlen(metals[i].name) == n - n_suffix &&
                                                   strncmp(metals[i].name, name, n - n_suffix) == 0)))
            found = &metals[i];
    return found;
}

void nqm_metal_names(bool is_pbrt, char *text, size_t n_text) {
    size_t used = 0;
    *text = 0;
    for (size_t i = 0; i < N_METALS && used < n_text; ++i)
        if (is_of(is_pbrt, i))
            used += (size_t)snprintf(text + used, n_text - used, "%s%s", used ? ", " : "", metals[i].name);
}
