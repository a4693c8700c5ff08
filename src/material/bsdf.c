/* SPDX-License-Identifier: MIT
 *
 * Lists of BSDFs with their properties, and the reading of one by the rules of its type.
 */
#include "material/bsdf.h"
#include "material/color_space.h"

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
    nqm_bsdf_node copy = *node;
    char **texts[] = {&copy.type, &copy.name, &copy.id, &copy.value};
    enum { N = sizeof texts / sizeof *texts };
    nqm_array arrays[N];
    char *blocks[N];
    for (size_t i = 0; i < N; ++i)
        arrays[i] = (nqm_array){&blocks[i], *texts[i] ? strlen(*texts[i]) + 1 : 1, 1};
    nqm_status status = nqm_alloc_arrays(N, arrays, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < N; ++i)
        *texts[i] = memcpy(blocks[i], *texts[i] ? *texts[i] : "", arrays[i].n);
    nodes->list[nodes->n++] = copy;
    return NQM_OK;
}

void nqm_bsdf_clear(nqm_bsdf_nodes *nodes) {
    for (size_t i = 0; i < nodes->n; ++i)
        nqm_free(nodes->list[i].type); /* the first text owns the block */
    nqm_free(nodes->list);
    *nodes = (nqm_bsdf_nodes){.n = 0};
}

size_t nqm_bsdf_next(const nqm_bsdf_nodes *nodes, size_t parent, size_t i) {
    /* A child comes after its parent, and the first node that is no descendant ends the search. */
    for (; i < nodes->n && nodes->list[i].parent != NQM_BSDF_ROOT && nodes->list[i].parent >= parent; ++i)
        if (nodes->list[i].parent == parent)
            return i;
    return nodes->n;
}

nqm_bsdf_kind nqm_bsdf_kind_of(const nqm_bsdf_word *words, const char *word) {
    while (words->word && strcmp(words->word, word) != 0)
        ++words;
    return words->word ? words->kind : NQM_BSDF_OTHER;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

size_t nqm_bsdf_parse(const char *text, size_t max_n, double *v) {
    static const char separators[] = " ,\t\r\n";
    size_t n = 0;
    for (text += strspn(text, separators); *text; text += strspn(text, separators)) {
        if (n == max_n || !nqm_parse_double(text, &text, &v[n]) || (*text && !strchr(separators, *text)))
            return 0;
        ++n;
    }
    return n;
}

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
    switch (node->kind) {
    case NQM_BSDF_OTHER:
    case NQM_BSDF_BSDF:
    case NQM_BSDF_TEXTURE:
        return nqm_refuse(r, node, IS_PLUGIN, node->name, node->type);
    case NQM_BSDF_REF:
        return nqm_refuse(r, node, IS_REFERENCE, node->name, node->id);
    case NQM_BSDF_STRING:
    case NQM_BSDF_BOOLEAN:
        return nqm_refuse(r, node, "%s needs a number, not '%.40s'", node->name, node->value);
    case NQM_BSDF_SPECTRUM:
        if (!*node->value || strchr(node->value, ':'))
            return nqm_refuse(r, node, "%s is a spectrum by wavelength; only constants and RGB are read", node->name);
        break;
    case NQM_BSDF_NUMBER:
    case NQM_BSDF_RGB:
    case NQM_BSDF_TRIPLE:
        break;
    }
    return true;
}

static bool read_values(nqm_reading *r, const nqm_rule *rule, const void *property, double v[4], size_t *n) {
    const nqm_bsdf_node *node = property;
    const bool is_rgb = node->kind == NQM_BSDF_RGB, is_triple = node->kind == NQM_BSDF_TRIPLE;
    if (!check_kind(r, node))
        return false;
    *n = is_rgb && parse_hex(node->value, v) ? 3 : nqm_bsdf_parse(node->value, 3, v);
    if (!(*n == 1 && !is_triple) && !(*n == 3 && (is_rgb || is_triple)))
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
    for (size_t i = nqm_bsdf_next(r->nodes, r->at, r->at + 1); i < r->nodes->n;
         i = nqm_bsdf_next(r->nodes, r->at, i + 1))
        if (strcmp(r->nodes->list[i].name, name) == 0)
            return &r->nodes->list[i];
    return NULL;
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

bool nqm_bsdf_choice(nqm_bsdf_reading *r, const char *name, const char *words, uint8_t *v) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    *v = 0;
    if (!node)
        return true;
    if (node->kind != NQM_BSDF_STRING || strchr(node->value, ' ') || !nqm_has_word(words, node->value, false))
        return nqm_refuse(&r->reading, node, "%s is '%.40s'; these are read: %s", name, node->value, words);
    const size_t n = strlen(node->value);
    for (const char *word = words; strncmp(word, node->value, n) != 0 || (word[n] && word[n] != ' '); ++*v)
        word += strcspn(word, " ") + 1;
    return true;
}

bool nqm_bsdf_file(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const nqm_bsdf_node *node = property;
    r->file = node->value;
    return (node->kind == NQM_BSDF_STRING && *r->file) ||
           nqm_refuse(r, node, "%s needs the name of a file", rule->name);
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

nqm_textured *nqm_bsdf_textured(nqm_bsdf_reading *r, const nqm_bsdf_node *node) {
    return node->kind == NQM_BSDF_REF ? nqm_reading_textured(&r->reading, node, IS_REFERENCE, node->name, node->id)
                                      : nqm_reading_textured(&r->reading, node, IS_PLUGIN, node->name, node->type);
}

bool nqm_bsdf_is_texture(const nqm_bsdf_node *node) {
    return node && (node->kind == NQM_BSDF_TEXTURE || node->kind == NQM_BSDF_REF);
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
    return dot && nqm_has_word(".exr .hdr .rgbe .pfm", dot, true);
}

/* The node exists, or the material is refused. */
static bool check_value(nqm_bsdf_reading *r, const nqm_bsdf_node *node, uint16_t value) {
    return value != NQM_NO_NODE ||
           nqm_refuse(&r->reading, node, "%s: its textures need more than %d operations, or memory is short",
                      node->name, NQM_MAX_MAP_NODES);
}

bool nqm_bsdf_image(nqm_bsdf_reading *r, const nqm_bsdf_node *file, const char *space, const double uv[2][3],
                    nqm_map_wrap wrap, uint16_t *value_ret) {
    size_t image;
    if (!nqm_map_add_file(r->reading.textured, r->path, file->value, space, &image))
        return nqm_refuse(&r->reading, file, "%s: more than %d images, or memory is short", file->value,
                          NQM_MAX_MAP_IMAGES);
    *value_ret = nqm_map_image_at(r->reading.textured, image, 3, uv, (const uint8_t[2]){(uint8_t)wrap, (uint8_t)wrap});
    return check_value(r, file, *value_ret);
}

uint16_t nqm_bsdf_compute(nqm_bsdf_reading *r, nqm_map_op op, size_t n, uint16_t a, double b) {
    nqm_textured *t = r->reading.textured;
    return nqm_map_compute(t, op, n, a, nqm_map_value(t, 1, &b), NQM_NO_NODE);
}

bool nqm_bsdf_output(nqm_bsdf_reading *r, const nqm_bsdf_node *node, const char *key, uint16_t value) {
    nqm_map_output_set(r->reading.textured, key, value);
    return check_value(r, node, value);
}

bool nqm_bsdf_normal(nqm_bsdf_reading *r, const nqm_bsdf_node *node, uint16_t rgb) {
    r->reading.textured->normal = nqm_bsdf_compute(r, NQM_MAP_NORMAL, 3, rgb, 1);
    return check_value(r, node, r->reading.textured->normal);
}

/* ---- types ------------------------------------------------------------------------------------------------------- */

const nqm_bsdf_plugin *nqm_bsdf_find_plugin(const nqm_bsdf_plugin *plugins, const char *type) {
    for (const nqm_bsdf_plugin *p = plugins; p->type; ++p)
        if (strcmp(p->type, type) == 0)
            return p;
    return NULL;
}

bool nqm_bsdf_read(nqm_bsdf_reading *r, const nqm_bsdf_plugin *plugins, const char *type) {
    nqm_reading *reading = &r->reading;
    const nqm_bsdf_node *bsdf = &r->nodes->list[r->at];
    const nqm_bsdf_plugin *p = nqm_bsdf_find_plugin(plugins, type);
    if (!p)
        return nqm_refuse(reading, bsdf, "the type '%.40s' is not known", type);
    if (p->refusal)
        return nqm_refuse(reading, bsdf, "%s", p->refusal);
    reading->rules = p->rules;
    reading->owner = p->type;
    snprintf(reading->shading.model, sizeof reading->shading.model, "%s", p->model ? p->model : "");
    for (size_t i = nqm_bsdf_next(r->nodes, r->at, r->at + 1); i < r->nodes->n;
         i = nqm_bsdf_next(r->nodes, r->at, i + 1))
        if (!nqm_rules_apply(reading, r->nodes->list[i].name, &r->nodes->list[i]))
            return false;
    if (!p->model && reading->textured)
        return nqm_refuse(reading, bsdf, "a measured BSDF with maps is not supported");
    if (!p->model && !reading->file)
        return nqm_refuse(reading, bsdf, "filename is missing");
    return !p->finish || p->finish(r, bsdf);
}
