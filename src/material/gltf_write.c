/* SPDX-License-Identifier: MIT
 *
 * Writing of a material as glTF 2.0: JSON, also in a binary container, with those extensions whose values differ from the defaults.
 */
#include "material/gltf.h"

#include <stdarg.h>
#include <strings.h>

enum { MATERIAL_TEXT = 4096 }; /* a material with all properties of the tables is shorter */

/** A text of limited size. */
typedef struct buffer {
    char *text;
    size_t n, size;
} buffer;

__attribute__((format(printf, 2, 3))) static void append(buffer *b, const char *format, ...) {
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(b->text + b->n, b->size - b->n, format, args);
    va_end(args);
    b->n = nqm_smaller(b->size - 1, b->n + (size_t)(n > 0 ? n : 0));
}

/* The values of a property: those of the shading, or the default of the specification. */
static nqm_property value_of(const nqm_shading *shading, const nqm_rule *p) {
    const nqm_property *set = nqm_shading_find(shading, p->key);
    nqm_property value = {.v = {p->value, p->value, p->value}};
    if (set)
        value = *set;
    value.n = p->n == 1 ? 1 : 3;
    /* the formula has the same value for both, and only one is valid */
    if (strcmp(p->key, "ior") == 0 && value.v[0] > 0 && value.v[0] < 1)
        value.v[0] = 1 / value.v[0];
    return value;
}

static bool is_default(const nqm_shading *shading, const nqm_rule *p) {
    const nqm_property value = value_of(shading, p);
    return value.v[0] == p->value && value.v[1] == p->value && value.v[2] == p->value;
}

static bool is_needed(const nqm_shading *shading, const nqm_gltf_group *group) {
    for (const nqm_rule *p = group->rules; p->name && p->key; ++p)
        if (!is_default(shading, p))
            return true;
    return false;
}

/* "NAME": {properties}, with `indent` in front of each line. */
static void append_layer(buffer *b, const nqm_shading *shading, const nqm_gltf_group *group, const char *indent) {
    char number[32];
    append(b, "%s\"%s\": {", indent, group->name);
    for (const nqm_rule *p = group->rules; p->name && p->key; ++p) {
        const nqm_property value = value_of(shading, p);
        append(b, "%s\n%s  \"%s\": %s", p == group->rules ? "" : ",", indent, p->name, value.n == 1 ? "" : "[");
        for (size_t c = 0; c < value.n; ++c)
            append(b, "%s%s", c ? ", " : "", nqm_format_double(number, sizeof number, value.v[c]));
        append(b, "%s%s", p->n == 4 ? ", 1" : "", value.n == 1 ? "" : "]");
    }
    append(b, "\n%s}", indent);
}

static void append_material(buffer *b, const nqm_shading *shading, const char *name) {
    const char *separator = ",\n      \"extensions\": {\n";
    append(b, "    {\n      \"name\": \"%s\",\n", name);
    append_layer(b, shading, &nqm_gltf_core, "      ");
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (is_needed(shading, &nqm_gltf_extensions[i])) {
            append(b, "%s", separator);
            append_layer(b, shading, &nqm_gltf_extensions[i], "        ");
            separator = ",\n";
        }
    append(b, "%s\n    }", strcmp(separator, ",\n") == 0 ? "\n      }" : "");
}

static bool is_needed_by_any(size_t n, const nqm_named_shading *materials, const nqm_gltf_group *group) {
    for (size_t i = 0; i < n; ++i)
        if (is_needed(&materials[i].shading, group))
            return true;
    return false;
}

static void append_document(buffer *b, size_t n, const nqm_named_shading *materials) {
    const char *separator = "";
    append(b, "{\n  \"asset\": {\"version\": \"2.0\", \"generator\": \"nqm %s\"},\n", nqm_version());
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (is_needed_by_any(n, materials, &nqm_gltf_extensions[i])) {
            append(b, "%s\"%s\"", *separator ? separator : "  \"extensionsUsed\": [", nqm_gltf_extensions[i].name);
            separator = ", ";
        }
    append(b, "%s  \"materials\": [\n", *separator ? "],\n" : "");
    for (size_t i = 0; i < n; ++i) {
        append(b, "%s", i ? ",\n" : "");
        append_material(b, &materials[i].shading, materials[i].name);
    }
    append(b, "\n  ]\n}\n");
}

nqm_status nqm_gltf_write(size_t n, const nqm_named_shading *materials, const char *path, FILE *stream,
                          nqm_error *err) {
    const char *dot = strrchr(path, '.');
    buffer b = {.size = (n + 1) * MATERIAL_TEXT};
    b.text = nqm_alloc(b.size, 1);
    if (!b.text)
        return nqm_fail_nomem(err, b.size);
    append_document(&b, n, materials);
    if (dot && strcasecmp(dot, ".glb") == 0) {
        unsigned char header[NQM_GLTF_GLB_HEADER + NQM_GLTF_CHUNK_HEADER];
        while (b.n % 4)
            append(&b, " ");
        const uint32_t words[] = {NQM_GLTF_GLB_MAGIC, 2, (uint32_t)(sizeof header + b.n), (uint32_t)b.n,
                                  NQM_GLTF_JSON_CHUNK};
        for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
            nqm_store_u32(header + 4 * i, words[i]);
        fwrite(header, 1, sizeof header, stream);
    }
    fwrite(b.text, 1, b.n, stream);
    nqm_free(b.text);
    return NQM_OK;
}
