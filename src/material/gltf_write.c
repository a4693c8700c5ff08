/* SPDX-License-Identifier: MIT
 *
 * Writing of a material as glTF 2.0: JSON, also in a binary container, with those extensions whose values differ from the defaults.
 */
#include "base/os.h"
#include "material/gltf.h"

#include <stdlib.h>

/* The values of a property: those of the material, or the default of the specification. */
static void get_values(const nqm_values *values, const nqm_rule *p, double v[3]) {
    const double *given = nqm_values_given(values, p->key);
    for (size_t c = 0; c < 3; ++c)
        v[c] = given ? given[c] : p->value;
    /* the formula has the same value for both, and only one is valid */
    if (strcmp(p->key, "ior") == 0 && v[0] > 0 && v[0] < 1)
        v[0] = 1 / v[0];
}

/* The map of a texture; n_maps: there is none. */
static size_t find_map(const nqm_written_material *material, const char *texture) {
    size_t k = 0;
    while (k < material->n_maps && strcmp(material->maps[k].texture, texture) != 0)
        ++k;
    return k;
}

/* A value of one of n materials differs from the default, or has a map. */
static bool is_needed(size_t n, const nqm_written_material *materials, const nqm_gltf_group *group) {
    for (size_t i = 0; i < n; ++i)
        for (const nqm_rule *p = group->rules; p->name; ++p) {
            double v[3];
            if (find_map(&materials[i], p->name) < materials[i].n_maps)
                return true;
            if (!p->key)
                continue;
            get_values(&materials[i].values, p, v);
            if (v[0] != p->value || v[1] != p->value || v[2] != p->value)
                return true;
        }
    return false;
}

/* `"NAME": {texture}`, if the material has it; its number is that of all maps of earlier materials and of this one before it. */
static void write_texture(FILE *stream, const nqm_written_material *material, size_t first, const char *name,
                          const char *separator) {
    const size_t k = find_map(material, name), *tiles = material->tiles;
    if (k == material->n_maps)
        return;
    fprintf(stream, "%s\"%s\": {\"index\": %zu", separator, name, first + k);
    if (tiles[0] > 1 || tiles[1] > 1)
        fprintf(stream, ", \"extensions\": {\"KHR_texture_transform\": {\"scale\": [%zu, %zu]}}", tiles[0], tiles[1]);
    fputc('}', stream);
}

/* "NAME": {properties}, with `indent` in front of each line. first: as in write_texture(). */
static void write_layer(FILE *stream, const nqm_written_material *material, size_t first, const nqm_gltf_group *group,
                        const char *indent) {
    char separator[32];
    char numbers[100];
    fprintf(stream, "%s\"%s\": {", indent, group->name);
    for (const nqm_rule *p = group->rules; p->name && p->key; ++p) {
        const bool is_array = p->n > 1;
        double v[3];
        get_values(&material->values, p, v);
        fprintf(stream, "%s\n%s  \"%s\": %s%s%s%s", p == group->rules ? "" : ",", indent, p->name, is_array ? "[" : "",
                nqm_format_doubles(numbers, sizeof numbers, is_array ? 3 : 1, v, ", "), p->n == 4 ? ", 1" : "",
                is_array ? "]" : "");
    }
    snprintf(separator, sizeof separator, ",\n%s  ", indent);
    for (const nqm_rule *p = group->rules; p->name; ++p)
        write_texture(stream, material, first, p->name, separator);
    fprintf(stream, "\n%s}", indent);
}

static void write_material(FILE *stream, const nqm_written_material *material, size_t first) {
    const char *separator = ",\n      \"extensions\": {\n";
    fprintf(stream, "    {\n      \"name\": \"%s\",\n", material->name);
    write_layer(stream, material, first, &nqm_gltf_core, "      ");
    write_texture(stream, material, first, "normalTexture", ",\n      ");
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (is_needed(1, material, &nqm_gltf_extensions[i])) {
            fputs(separator, stream);
            write_layer(stream, material, first, &nqm_gltf_extensions[i], "        ");
            separator = ",\n";
        }
    fprintf(stream, "%s\n    }", strcmp(separator, ",\n") == 0 ? "\n      }" : "");
}

/* The images of all maps, and a texture of each. */
static void write_images(FILE *stream, size_t n, const nqm_written_material *materials) {
    size_t n_maps = 0;
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < materials[i].n_maps; ++k) {
            json_t *file = json_string(materials[i].maps[k].file);
            char *text = json_dumps(file, JSON_ENCODE_ANY | JSON_ENSURE_ASCII);
            fprintf(stream, "%s    {\"uri\": %s}", n_maps++ ? ",\n" : ",\n  \"images\": [\n", text ? text : "\"\"");
            free(text);
            json_decref(file);
        }
    for (size_t k = 0; k < n_maps; ++k)
        fprintf(stream, "%s{\"source\": %zu}", k ? ", " : "\n  ],\n  \"textures\": [", k);
    fputs(n_maps ? "]" : "", stream);
}

static void write_document(FILE *stream, size_t n, const nqm_written_material *materials) {
    const char *separator = "";
    size_t n_maps = 0;
    bool is_tiled = false;
    for (size_t i = 0; i < n; ++i)
        is_tiled = is_tiled || (materials[i].n_maps && (materials[i].tiles[0] > 1 || materials[i].tiles[1] > 1));
    fprintf(stream, "{\n  \"asset\": {\"version\": \"2.0\", \"generator\": \"nqm %s\"},\n", nqm_version());
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (is_needed(n, materials, &nqm_gltf_extensions[i])) {
            fprintf(stream, "%s\"%s\"", *separator ? separator : "  \"extensionsUsed\": [",
                    nqm_gltf_extensions[i].name);
            separator = ", ";
        }
    if (is_tiled) {
        fprintf(stream, "%s\"KHR_texture_transform\"", *separator ? separator : "  \"extensionsUsed\": [");
        separator = ", ";
    }
    fprintf(stream, "%s  \"materials\": [\n", *separator ? "],\n" : "");
    for (size_t i = 0; i < n; ++i) {
        fputs(i ? ",\n" : "", stream);
        write_material(stream, &materials[i], n_maps);
        n_maps += materials[i].n_maps;
    }
    fputs("\n  ]", stream);
    write_images(stream, n, materials);
    fputs("\n}\n", stream);
}

/* The container begins with the size of the document, which is written to memory first. */
static nqm_status write_container(FILE *stream, size_t n, const nqm_written_material *materials, nqm_error *err) {
    unsigned char header[NQM_GLTF_GLB_HEADER + NQM_GLTF_CHUNK_HEADER];
    char *text = NULL;
    size_t n_text = 0;
    FILE *document = nqm_os_memory_stream(&text, &n_text);
    if (!document)
        return nqm_fail_nomem(err, sizeof header);
    write_document(document, n, materials);
    while (ftell(document) % 4)
        fputc(' ', document);
    if (!nqm_os_close_memory(document, &text, &n_text))
        return nqm_fail_nomem(err, sizeof header);
    const uint32_t words[] = {NQM_GLTF_GLB_MAGIC, 2, (uint32_t)(sizeof header + n_text), (uint32_t)n_text,
                              NQM_GLTF_JSON_CHUNK};
    nqm_write_values(stream, sizeof words / sizeof *words, sizeof *words, words);
    fwrite(text, 1, n_text, stream);
    free(text);
    return NQM_OK;
}

nqm_status nqm_gltf_write(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                          nqm_error *err) {
    const char *dot = strrchr(path, '.');
    if (dot && nqm_equal_any_case(dot, ".glb", SIZE_MAX))
        return write_container(stream, n, materials, err);
    write_document(stream, n, materials);
    return NQM_OK;
}
