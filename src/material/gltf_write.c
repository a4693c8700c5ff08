/* SPDX-License-Identifier: MIT
 *
 * Writing of a material as glTF 2.0: JSON, also in a binary container, with those extensions whose values differ from the defaults.
 */
#include "material/gltf.h"

#include <stdarg.h>
#include <strings.h>

/** A text of limited size. */
typedef struct buffer {
    char text[4096];
    size_t n;
} buffer;

__attribute__((format(printf, 2, 3))) static void append(buffer *b, const char *format, ...) {
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(b->text + b->n, sizeof b->text - b->n, format, args);
    va_end(args);
    b->n = nqm_smaller(sizeof b->text - 1, b->n + (size_t)(n > 0 ? n : 0));
}

/* The values of a property: those of the shading, or the default of the specification. */
static nqm_property value_of(const nqm_shading *shading, const nqm_gltf_property *p) {
    const nqm_property *set = nqm_shading_find(shading, p->key);
    nqm_property value = {.v = {p->fallback, p->fallback, p->fallback}};
    if (set)
        value = *set;
    value.n = p->kind == NQM_GLTF_NUMBER ? 1 : 3;
    /* the formula has the same value for both, and only one is valid */
    if (strcmp(p->key, "ior") == 0 && value.v[0] > 0 && value.v[0] < 1)
        value.v[0] = 1 / value.v[0];
    return value;
}

static bool is_default(const nqm_shading *shading, const nqm_gltf_property *p) {
    const nqm_property value = value_of(shading, p);
    return value.v[0] == p->fallback && value.v[1] == p->fallback && value.v[2] == p->fallback;
}

static bool is_needed(const nqm_shading *shading, const nqm_gltf_group *group) {
    for (const nqm_gltf_property *p = group->properties; p->name && p->key; ++p)
        if (!is_default(shading, p))
            return true;
    return false;
}

/* "NAME": {properties}, with `indent` in front of each line. */
static void append_layer(buffer *b, const nqm_shading *shading, const nqm_gltf_group *group, const char *indent) {
    char number[32];
    append(b, "%s\"%s\": {", indent, group->name);
    for (const nqm_gltf_property *p = group->properties; p->name && p->key; ++p) {
        const nqm_property value = value_of(shading, p);
        append(b, "%s\n%s  \"%s\": %s", p == group->properties ? "" : ",", indent, p->name, value.n == 1 ? "" : "[");
        for (size_t c = 0; c < value.n; ++c)
            append(b, "%s%s", c ? ", " : "", nqm_format_double(number, sizeof number, value.v[c]));
        append(b, "%s%s", p->kind == NQM_GLTF_BASE_COLOR ? ", 1" : "", value.n == 1 ? "" : "]");
    }
    append(b, "\n%s}", indent);
}

static void append_document(buffer *b, const nqm_shading *shading, const char *name) {
    const char *separator = "";
    append(b, "{\n  \"asset\": {\"version\": \"2.0\", \"generator\": \"nqm %s\"},\n", nqm_version());
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (is_needed(shading, &nqm_gltf_extensions[i])) {
            append(b, "%s\"%s\"", *separator ? separator : "  \"extensionsUsed\": [", nqm_gltf_extensions[i].name);
            separator = ", ";
        }
    append(b, "%s  \"materials\": [\n    {\n      \"name\": \"%s\",\n", *separator ? "],\n" : "", name);
    append_layer(b, shading, &nqm_gltf_core, "      ");
    separator = ",\n      \"extensions\": {\n";
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (is_needed(shading, &nqm_gltf_extensions[i])) {
            append(b, "%s", separator);
            append_layer(b, shading, &nqm_gltf_extensions[i], "        ");
            separator = ",\n";
        }
    append(b, "%s\n    }\n  ]\n}\n", strcmp(separator, ",\n") == 0 ? "\n      }" : "");
}

nqm_status nqm_gltf_write(const nqm_shading *shading, const char *name, const char *path, FILE *stream,
                          nqm_error *err) {
    const char *dot = strrchr(path, '.');
    buffer b = {.n = 0};
    (void)err; /* the text has the size of the tables, and the caller checks the stream */
    append_document(&b, shading, name);
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
    return NQM_OK;
}
