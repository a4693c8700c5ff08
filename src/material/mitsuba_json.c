/* SPDX-License-Identifier: MIT
 *
 * Dictionaries of Mitsuba 3's load_dict() as JSON: a BSDF, or a scene with BSDFs, whose objects have a "type". In a scene a BSDF
 * without an "id" has the name of its entry, and inside of a shape that of the shape.
 */
#include "io/io.h"
#include "io/json.h"
#include "material/bsdf.h"

enum { MAX_DEPTH = 64, MAX_BYTES = 64 << 20, TEXT_SIZE = 256, MAX_NUMBERS = 9 };

typedef struct walk {
    const char *path;
    nqm_bsdf_nodes nodes;
    nqm_error *err;
} walk;

static const char *text_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* The numbers of a value, as text; "" when it has none or too many. */
static void format_numbers(const json_t *value, char text[TEXT_SIZE]) {
    const size_t n = json_is_number(value) ? 1 : json_array_size(value);
    double v[MAX_NUMBERS] = {0};
    bool is_good = n <= MAX_NUMBERS;
    for (size_t i = 0; i < n && is_good; ++i) {
        const json_t *element = json_is_number(value) ? value : json_array_get(value, i);
        is_good = json_is_number(element);
        v[i] = json_number_value(element);
    }
    nqm_format_doubles(text, TEXT_SIZE, is_good ? n : 0, v, " ");
}

static nqm_bsdf_kind kind_of(const json_t *value) {
    static const nqm_bsdf_word kinds[] = {{"rgb srgb", NQM_BSDF_RGB},
                                          {"spectrum uniform regular irregular", NQM_BSDF_SPECTRUM},
                                          {"ref", NQM_BSDF_REF},
                                          {"bitmap checkerboard mesh_attribute volume", NQM_BSDF_TEXTURE},
                                          {NULL, NQM_BSDF_OTHER}};
    return json_is_number(value)                         ? NQM_BSDF_NUMBER
           : json_is_boolean(value)                      ? NQM_BSDF_BOOLEAN
           : json_is_string(value)                       ? NQM_BSDF_STRING
           : json_is_array(value)                        ? NQM_BSDF_RGB
           : nqm_mitsuba_is_bsdf(text_of(value, "type")) ? NQM_BSDF_BSDF
                                                         : nqm_bsdf_kind_of(kinds, text_of(value, "type"));
}

/* Write [[nm, value], ...] as numbers into *text, nqm_free(); NULL: it is no such list. */
static nqm_status format_spectrum(const json_t *value, char **text, nqm_error *err) {
    char *json = json_is_array(json_array_get(value, 0)) ? json_dumps(value, JSON_COMPACT) : NULL;
    *text = json ? nqm_strdup(json) : NULL;
    free(json);
    if (!*text && json_is_array(json_array_get(value, 0)))
        return nqm_fail_nomem(err, json_array_size(value));
    for (char *c = *text; c && (c = strpbrk(c, "[]"));)
        *c = ' ';
    return NQM_OK;
}

/* The value of a property as text, which is in `text` or belongs to the JSON. */
static const char *value_of(const json_t *value, char text[TEXT_SIZE]) {
    if (json_is_boolean(value))
        return json_is_true(value) ? "true" : "false";
    if (json_is_object(value)) {
        const json_t *inner = json_object_get(value, "value"), *color = json_object_get(value, "color");
        value = inner ? inner : color ? color : json_object_get(value, "filename");
    }
    if (json_is_string(value))
        return json_string_value(value);
    format_numbers(value, text);
    return text;
}

/* Add the value `value` of the key `key`, and what is inside it. `id`: the name of a BSDF without an id. */
static nqm_status add_value(walk *w, const char *key, json_t *value, size_t parent, const char *id, int depth) {
    char text[TEXT_SIZE];
    const bool is_scene = strcmp(text_of(value, "type"), "scene") == 0;
    nqm_bsdf_node node = {.kind = kind_of(value), .parent = parent, .name = (char *)key, .byte_offset = -1};
    const size_t at = w->nodes.n;
    const bool has_inner = node.kind == NQM_BSDF_BSDF || node.kind == NQM_BSDF_TEXTURE;
    const bool is_node = has_inner || parent != NQM_BSDF_ROOT;
    if (depth == MAX_DEPTH)
        return nqm_fail(w->err, NQM_ERR_LIMIT, 0, "%s: objects are nested more than %d deep", w->path, MAX_DEPTH);
    if (is_node) {
        node.type = (char *)text_of(value, "type");
        node.id = (char *)(*text_of(value, "id") ? text_of(value, "id") : id);
        char *spectrum = NULL;
        nqm_status status = format_spectrum(json_object_get(value, "value"), &spectrum, w->err);
        node.value = spectrum ? spectrum : (char *)value_of(value, text);
        if (status == NQM_OK)
            status = nqm_bsdf_add(&w->nodes, &node, w->path, w->err);
        nqm_free(spectrum);
        if (status != NQM_OK || !has_inner)
            return status;
    }
    const char *inner_key;
    json_t *inner;
    nqm_status status = NQM_OK;
    json_object_foreach(value, inner_key, inner) {
        if (status == NQM_OK && strcmp(inner_key, "type") != 0 && strcmp(inner_key, "id") != 0)
            status = add_value(w, inner_key, inner, is_node ? at : NQM_BSDF_ROOT,
                               is_node    ? ""
                               : is_scene ? inner_key
                                          : id,
                               depth + 1);
    }
    return status;
}

/* true when the text has an object of the type "scene" or of a BSDF. */
static bool probe(const nqm_map *map) {
    const char *text = (const char *)map->data;
    const size_t n = nqm_smaller(map->n_bytes, NQM_PROBE_BYTES);
    size_t i = n >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (i < n && memchr(" \t\r\n", text[i], 4))
        ++i;
    if (i == n || text[i] != '{')
        return false;
    for (; i + 6 < n; ++i) {
        if (memcmp(text + i, "\"type\"", 6) != 0)
            continue;
        size_t at = i + 6, n_type = 0;
        char type[32];
        while (at < n && memchr(" \t\r\n:", text[at], 5))
            ++at;
        for (++at; at < n && text[at] != '"' && n_type + 1 < sizeof type; ++at)
            type[n_type++] = text[at];
        type[n_type] = 0;
        if (strcmp(type, "scene") == 0 || nqm_mitsuba_is_bsdf(type))
            return true;
    }
    return false;
}

static nqm_status read_json(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    const char *text = (const char *)map->data;
    const size_t n = map->n_bytes, skip = n >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    walk w = {.path = map->path, .err = err};
    json_t *root = NULL;
    if (n > MAX_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %zu bytes of JSON (byte 0); at most %d are read", map->path, n,
                        MAX_BYTES);
    nqm_status status =
        nqm_json_read(text + skip, n - skip, JSON_REJECT_DUPLICATES, &(nqm_json_place){map->path, n, skip}, &root, err);
    if (status == NQM_OK)
        status = add_value(&w, "", root, NQM_BSDF_ROOT, "", 0);
    json_decref(root);
    if (status == NQM_OK)
        status = nqm_mitsuba_translate(&w.nodes, map->path, materials, err);
    nqm_bsdf_clear(&w.nodes);
    return status;
}

const nqm_material_format nqm_mitsuba_json_format = {
    .name = "Mitsuba JSON",
    .extensions = ".json",
    .models = "rough-conductor rough-plastic principled lambert blender-principled",
    .probe = probe,
    .read = read_json,
    .write = nqm_mitsuba_write,
};
