/* SPDX-License-Identifier: MIT
 *
 * Which properties and maps changed between two materials: values, and what maps compute as text, "col.png [8 0 0; 0 8 0]".
 */
#include "io/io.h"
#include "material/maps.h"
#include "nqm/library/library.h"
#include "nqm/textured.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* A material that has values or maps. */
typedef struct look {
    nqm_values values;
    nqm_argument *argument;
    nqm_textured *owned;
    const nqm_textured *maps; /* NULL: none */
} look;

static bool open_look(const char *argument, look *to) {
    nqm_material_info info = {.spec = NULL};
    to->argument = parse_argument(argument);
    if (nqm_argument_material(to->argument, &info) && info.spec)
        return nqm_values_parse_spec(info.spec, &to->values, NULL) == NQM_OK;
    if (nqm_argument_maps(to->argument, &to->maps, &to->owned, NULL) == NQM_OK && to->maps)
        to->values = to->maps->values;
    return to->maps != NULL;
}

/* ---- maps as text ------------------------------------------------------------------------------------------------ */

#define OP_NAME(NAME, N_OPERANDS, VALUE) [NQM_MAP_##NAME] = #NAME,
static const char *const op_names[NQM_MAP_OPS] = {NQM_MAP_COMPONENT_OPS(OP_NAME)[NQM_MAP_CHANNEL] = "CHANNEL",
                                                  [NQM_MAP_COMBINE] = "COMBINE",
                                                  [NQM_MAP_LUMINANCE] = "LUMINANCE",
                                                  [NQM_MAP_RGB_TO_HSV] = "RGB_TO_HSV",
                                                  [NQM_MAP_HSV_TO_RGB] = "HSV_TO_RGB",
                                                  [NQM_MAP_TEXCOORD] = "TEXCOORD",
                                                  [NQM_MAP_NORMAL] = "NORMAL"};

/* The bytes of an image stand for it whatever its name is. */
static void put_content(const nqm_map_image *image, FILE *to) {
    nqm_map map;
    nqm_sha256 sha;
    char hash[65];
    const unsigned char *data;
    size_t n;
    const bool is_read = nqm_textured_open_image(image, &map, &data, &n, NULL) == NQM_OK;
    if (!nqm_sha256_begin(&sha))
        stop(EXIT_LIMIT, "out of memory");
    if (is_read)
        nqm_sha256_add(&sha, data, n);
    nqm_sha256_end(&sha, hash);
    nqm_map_close(&map);
    fputs(is_read ? hash : image->name, to);
}

static void put_image(const nqm_textured *t, const nqm_map_node *node, bool by_content, FILE *to) {
    static const char *const wraps[] = {"repeat", "mirror", "clamp", "border"};
    static const double identity[2][3] = {{1, 0, 0}, {0, 1, 0}};
    const nqm_map_image *image = &t->images[node->image];
    if (by_content)
        put_content(image, to);
    else
        fputs(image->name, to);
    fprintf(to, "%s%s", *image->space ? " " : "", image->space);
    bool is_plain = true;
    for (size_t k = 0; k < 6; ++k)
        is_plain = is_plain && node->uv[k / 3][k % 3] == identity[k / 3][k % 3];
    for (size_t k = 0; !is_plain && k < 6; ++k) /* no -0 */
        fprintf(to, "%s%g%s", k == 0 ? " [" : k == 3 ? "; " : " ", node->uv[k / 3][k % 3] + 0.0, k == 5 ? "]" : "");
    for (size_t axis = 0; axis < 2; ++axis)
        if (node->wrap[0] || node->wrap[1])
            fprintf(to, "%c%s", axis ? '/' : ' ', wraps[node->wrap[axis]]);
}

static void put_node(const nqm_textured *t, uint16_t at, bool by_content, FILE *to) {
    const nqm_map_node *node = &t->nodes[at];
    if (node->op == NQM_MAP_IMAGE) {
        put_image(t, node, by_content, to);
        return;
    }
    for (const char *c = op_names[node->op]; c && *c; ++c)
        fputc(tolower((unsigned char)*c), to);
    const size_t n = nqm_graph_operands(node->op, node->n);
    for (size_t i = 0; i < n; ++i) {
        fputs(i ? ", " : "(", to);
        put_node(t, node->in[i], by_content, to);
    }
    fputs(n ? ")" : "", to);
    for (size_t c = 0; c < node->n && (node->op == NQM_MAP_VALUE || (node->op == NQM_MAP_CHANNEL && c == 0)); ++c)
        fprintf(to, "%s%g", c || node->op == NQM_MAP_CHANNEL ? " " : "", node->v[c]);
}

/* free() it. */
static char *map_text(const look *of, uint16_t node, bool by_content) {
    char *text;
    size_t n;
    FILE *to = open_text(&text, &n);
    put_node(of->maps, node, by_content, to);
    fclose(to);
    return text;
}

/* The node of a key, or of "normal"; NQM_NO_NODE: no map has it. */
static uint16_t node_of(const look *of, const char *key) {
    uint16_t node = of->maps && strcmp(key, "normal") == 0 ? of->maps->normal : NQM_NO_NODE;
    for (size_t i = 0; of->maps && i < of->maps->n_outputs; ++i)
        if (strcmp(of->maps->outputs[i].key, key) == 0)
            node = of->maps->outputs[i].node;
    return node;
}

/* ---- changes ----------------------------------------------------------------------------------------------------- */

static json_t *json_value(const look *of, const char *key) {
    const uint16_t node = node_of(of, key);
    const double *v = nqm_values_given(&of->values, key);
    if (node != NQM_NO_NODE) {
        char *text = map_text(of, node, false);
        json_t *name = json_name(text);
        free(text);
        return name;
    }
    if (!v || (v[0] == v[1] && v[1] == v[2]))
        return v ? json_number(v[0]) : json_null();
    json_t *list = json_array();
    for (size_t c = 0; c < of->values.schema->keys[nqm_schema_key_named(of->values.schema, key, strlen(key))].n; ++c)
        json_array_append_new(list, json_number(v[c]));
    return list;
}

static bool is_same(const look *old, const look *new, const char *key) {
    const uint16_t nodes[2] = {node_of(old, key), node_of(new, key)};
    const double *p = nqm_values_given(&old->values, key), *q = nqm_values_given(&new->values, key);
    if ((nodes[0] == NQM_NO_NODE) != (nodes[1] == NQM_NO_NODE))
        return false;
    if (nodes[0] == NQM_NO_NODE)
        return p && q ? memcmp(p, q, 3 * sizeof *p) == 0 : p == q; /* values after the last repeat it */
    char *texts[2] = {map_text(old, nodes[0], true), map_text(new, nodes[1], true)};
    const bool is = strcmp(texts[0], texts[1]) == 0;
    free(texts[0]);
    free(texts[1]);
    return is;
}

static void compare_key(json_t *to, const look *old, const look *new, const char *key) {
    json_t *change;
    size_t i;
    json_array_foreach(to, i,
                       change) if (strcmp(json_string_value(json_object_get(change, "property")), key) == 0) return;
    if (is_same(old, new, key))
        return;
    json_t *values[2] = {json_value(old, key), json_value(new, key)};
    if (json_is_string(values[0]) && json_equal(values[0], values[1])) {
        json_t *other = json_sprintf("%s (other pixels)", json_string_value(values[1]));
        json_decref(values[1]);
        values[1] = other;
    }
    json_array_append_new(to, json_row("property:s old:o new:o", key, values[0], values[1]));
}

static void compare_keys(json_t *to, const look *old, const look *new, const look *keys) {
    for (size_t k = 0; k < keys->values.schema->n_keys; ++k)
        if (keys->values.given >> k & 1)
            compare_key(to, old, new, keys->values.schema->keys[k].name);
    for (size_t k = 0; keys->maps && k < keys->maps->n_outputs; ++k)
        compare_key(to, old, new, keys->maps->outputs[k].key);
    if (keys->maps)
        compare_key(to, old, new, "normal");
}

json_t *list_changes(const nqm_named_pair *pair) {
    look *old = allocate(2, sizeof *old), *new = old + 1;
    json_t *list = json_array();
    const bool is_known = open_look(pair->ref, old) && open_look(pair->test, new);
    if (is_known && old->values.schema != new->values.schema) {
        json_array_append_new(
            list, json_row("property:s old:s new:s", "model", old->values.schema->model, new->values.schema->model));
    } else if (is_known) {
        compare_keys(list, old, new, old);
        compare_keys(list, old, new, new);
    }
    for (size_t i = 0; i < 2; ++i) {
        nqm_textured_free(old[i].owned);
        nqm_argument_free(old[i].argument);
    }
    free(old);
    return list;
}

void print_value(const json_t *value, FILE *to) {
    for (size_t c = 0; c < json_array_size(value); ++c)
        fprintf(to, "%s%.4g", c ? "," : "", json_number_value(json_array_get(value, c)));
    if (json_is_number(value))
        fprintf(to, "%.4g", json_number_value(value));
    else if (!json_is_array(value))
        fputs(json_is_string(value) ? shown(json_string_value(value)) : "default", to);
}
