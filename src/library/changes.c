/* SPDX-License-Identifier: MIT
 *
 * Which properties and maps changed between two materials: values, and what maps compute as text, "col.png [8 0 0; 0 8 0]".
 */
#include "base/os.h"
#include "library/library.h"

#include <ctype.h>
#include <stdlib.h>

/* A material that has values or maps. */
typedef struct look {
    nqm_values values;
    nqm_argument *argument;
    nqm_textured *owned;
    const nqm_textured *maps; /* NULL: none */
} look;

/* Both, and what changes. */
typedef struct comparison {
    look before, after;
    size_t n, max_n;
    nqm_library_change *changes; /* (n) */
    bool is_short;               /* of memory */
} comparison;

/* false: it has neither. */
static bool open_look(comparison *c, nqm_argument_files *files, const char *argument, look *to) {
    nqm_material_info info = {.spec = NULL};
    to->argument = nqm_argument_parse(argument, files);
    c->is_short = c->is_short || !to->argument;
    if (!to->argument)
        return false;
    if (nqm_argument_material(to->argument, &info) && info.spec)
        return nqm_values_parse_spec(info.spec, &to->values, NULL) == NQM_OK;
    if (nqm_argument_maps(to->argument, &to->maps, &to->owned, NULL) == NQM_ERR_NOMEM)
        c->is_short = true;
    if (to->maps)
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
    const bool is_hashed = is_read && nqm_sha256_begin(&sha);
    if (is_hashed) {
        nqm_sha256_add(&sha, data, n);
        nqm_sha256_end(&sha, hash);
    }
    if (is_read)
        nqm_map_close(&map);
    fputs(is_hashed ? hash : image->name, to);
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

/* nqm_free() it; NULL: out of memory. */
static char *map_text(comparison *c, const look *of, uint16_t node, bool by_content) {
    char *text = NULL, *copy;
    size_t n;
    FILE *to = nqm_os_memory_stream(&text, &n);
    if (to)
        put_node(of->maps, node, by_content, to);
    copy = to && nqm_os_close_memory(to, &text, &n) ? nqm_strdup(text) : NULL;
    c->is_short = c->is_short || !copy;
    free(text);
    return copy;
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

static nqm_library_value value_of(comparison *c, const look *of, const char *key) {
    const uint16_t node = node_of(of, key);
    const double *v = nqm_values_given(&of->values, key);
    nqm_library_value value = {.text = NULL};
    if (node != NQM_NO_NODE) {
        value.text = map_text(c, of, node, false);
    } else if (v) {
        value.n = of->values.schema->keys[nqm_schema_key_named(of->values.schema, key, strlen(key))].n;
        memcpy(value.v, v, value.n * sizeof *v);
    }
    return value;
}

static bool is_same(comparison *c, const char *key) {
    const look *before = &c->before, *after = &c->after;
    const uint16_t nodes[2] = {node_of(before, key), node_of(after, key)};
    const double *p = nqm_values_given(&before->values, key), *q = nqm_values_given(&after->values, key);
    if ((nodes[0] == NQM_NO_NODE) != (nodes[1] == NQM_NO_NODE))
        return false;
    if (nodes[0] == NQM_NO_NODE)
        return p && q ? memcmp(p, q, 3 * sizeof *p) == 0 : p == q; /* values after the last repeat it */
    char *texts[2] = {map_text(c, before, nodes[0], true), map_text(c, after, nodes[1], true)};
    const bool is = texts[0] && texts[1] && strcmp(texts[0], texts[1]) == 0;
    nqm_free(texts[0]);
    nqm_free(texts[1]);
    return is;
}

static void add_change(comparison *c, const char *property, nqm_library_value before, nqm_library_value after) {
    nqm_library_change *changes = nqm_grow(c->changes, &c->max_n, c->n + 1, sizeof *changes);
    if (!changes) {
        c->is_short = true;
        nqm_free((char *)(uintptr_t)before.text);
        nqm_free((char *)(uintptr_t)after.text);
        return;
    }
    c->changes = changes;
    changes[c->n] = (nqm_library_change){.before = before, .after = after};
    snprintf(changes[c->n++].property, sizeof changes->property, "%s", property);
}

static void compare_key(comparison *c, const char *key) {
    for (size_t i = 0; i < c->n; ++i)
        if (strcmp(c->changes[i].property, key) == 0)
            return;
    if (is_same(c, key))
        return;
    nqm_library_value before = value_of(c, &c->before, key), after = value_of(c, &c->after, key);
    if (before.text && after.text && strcmp(before.text, after.text) == 0) {
        char *other = nqm_strdupf("%s (other pixels)", after.text);
        c->is_short = c->is_short || !other;
        nqm_free((char *)(uintptr_t)after.text);
        after.text = other;
    }
    add_change(c, key, before, after);
}

static void compare_keys(comparison *c, const look *keys) {
    for (size_t k = 0; k < keys->values.schema->n_keys; ++k)
        if (keys->values.given >> k & 1)
            compare_key(c, keys->values.schema->keys[k].name);
    for (size_t k = 0; keys->maps && k < keys->maps->n_outputs; ++k)
        compare_key(c, keys->maps->outputs[k].key);
    if (keys->maps)
        compare_key(c, "normal");
}

nqm_status nqm_library_compare(nqm_argument_files *files, nqm_library_pair *pair, nqm_error *err) {
    comparison *c = nqm_alloc(1, sizeof *c);
    if (!c)
        return nqm_fail_nomem(err, sizeof *c);
    const bool is_known =
        open_look(c, files, pair->names.ref, &c->before) && open_look(c, files, pair->names.test, &c->after);
    const nqm_schema *before = c->before.values.schema, *after = c->after.values.schema;
    if (is_known && before != after) {
        add_change(c, "model", (nqm_library_value){.text = nqm_strdup(before->model)},
                   (nqm_library_value){.text = nqm_strdup(after->model)});
    } else if (is_known) {
        compare_keys(c, &c->before);
        compare_keys(c, &c->after);
    }
    for (size_t i = 0; i < 2; ++i) {
        look *of = i ? &c->after : &c->before;
        nqm_textured_free(of->owned);
        nqm_argument_free(of->argument);
    }
    pair->changes = c->changes;
    pair->n_changes = c->n;
    const bool is_short = c->is_short;
    nqm_free(c);
    return is_short ? nqm_fail_nomem(err, sizeof *c) : NQM_OK;
}
