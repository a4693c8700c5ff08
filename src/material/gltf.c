/* SPDX-License-Identifier: MIT
 *
 * Reading of materials of glTF 2.0, as JSON (.gltf) and binary (.glb): metallic-roughness with KHR_materials_specular, _ior, _clearcoat and
 * _sheen. Meshes, images and everything else of the file are not read; the materials are parsed one by one, because the tree of a whole
 * file takes twenty times its bytes.
 */
#include "material/gltf.h"
#include "io/io.h"
#include "io/options_json.h"
#include "material/json_where.h"

#include <limits.h>
#include <stdarg.h>
#include <strings.h>

static const char TEXTURE_REASON[] = "a texture varies over the surface, and a BRDF is that of one point";

/** Extensions that a file may require without any consequence for its materials. */
static const char *const harmless[] = {
    "KHR_draco_mesh_compression", "KHR_mesh_quantization",  "EXT_meshopt_compression", "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",    "KHR_texture_basisu",     "KHR_texture_transform",   "EXT_texture_webp",
    "EXT_texture_avif",           "MSFT_texture_dds",       "KHR_lights_punctual",     "EXT_lights_image_based",
    "KHR_animation_pointer",      "KHR_materials_variants", "KHR_node_visibility",     "KHR_xmp_json_ld"};

static const nqm_gltf_group *find_extension(const char *name) {
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (strcmp(nqm_gltf_extensions[i].name, name) == 0)
            return &nqm_gltf_extensions[i];
    return NULL;
}

/* ---- reading one material ---------------------------------------------------------------------------------------- */

/** The state of reading; a refusal ends the reading of one material, a failure that of the file. */
typedef struct reader {
    const char *path;
    nqm_json_source source;
    size_t source_at; /**< position of the JSON text in the file */
    size_t at;        /**< position of the material in the JSON text; SIZE_MAX: none */
    nqm_shading shading;
    double alpha;
    char refusal[256];
    int64_t refusal_byte;
    nqm_error *err;
} reader;

/* Position of a property of the material in the file. */
static int64_t byte_of(const reader *r, const char *path) {
    return (int64_t)(r->source_at + nqm_json_path(&r->source, r->at, path));
}

/* Set the refusal "PROPERTY: REASON", if there is none yet. `path` is that of the property in the material. */
static void refuse(reader *r, const char *path, const char *value, const char *reason) {
    static const char prefix[] = "extensions.";
    if (*r->refusal)
        return;
    const char *shown = strncmp(path, prefix, sizeof prefix - 1) == 0 ? path + sizeof prefix - 1 : path;
    snprintf(r->refusal, sizeof r->refusal, "%.120s%s%s: %s", shown, *value ? " = " : "", value, reason);
    r->refusal_byte = byte_of(r, path);
}

static nqm_status fail_value(const reader *r, const char *path, const char *needed) {
    const int64_t byte = byte_of(r, path);
    return nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: %.120s needs %s", r->path, (long long)byte, path,
                    needed);
}

/* v: (n) */
static nqm_status read_numbers(const reader *r, const char *path, const json_t *value, size_t n, double *v) {
    static const char *const needed[] = {"", "a number", "", "an array of 3 numbers", "an array of 4 numbers"};
    bool is_valid = n == 1 || json_array_size(value) == n;
    for (size_t i = 0; is_valid && i < n; ++i) {
        const json_t *number = n == 1 ? value : json_array_get(value, i);
        is_valid = json_is_number(number);
        v[i] = json_number_value(number);
    }
    return is_valid ? NQM_OK : fail_value(r, path, needed[n]);
}

enum { PATH_SIZE = 256 };

static nqm_status read_property(reader *r, const nqm_gltf_property *p, const nqm_gltf_group *group, const char *path,
                                const json_t *value, bool is_off) {
    double v[4] = {0};
    char text[32];
    nqm_status status = NQM_OK;
    switch (p->kind) {
    case NQM_GLTF_NUMBER:
    case NQM_GLTF_ZERO:
        status = read_numbers(r, path, value, 1, v);
        if (status == NQM_OK && p->kind == NQM_GLTF_NUMBER)
            nqm_shading_set(&r->shading, p->key, 1, v);
        else if (status == NQM_OK && v[0] != 0)
            refuse(r, path, nqm_format_double(text, sizeof text, v[0]), group->why);
        break;
    case NQM_GLTF_COLOR:
    case NQM_GLTF_BASE_COLOR:
        status = read_numbers(r, path, value, p->kind == NQM_GLTF_COLOR ? 3 : 4, v);
        if (status == NQM_OK)
            nqm_shading_set(&r->shading, p->key, 3, v);
        if (status == NQM_OK && p->kind == NQM_GLTF_BASE_COLOR && !(v[3] >= 0 && v[3] <= 1))
            refuse(r, path, "", "alpha, its fourth number, is outside of 0 to 1");
        if (status == NQM_OK && p->kind == NQM_GLTF_BASE_COLOR)
            r->alpha = v[3];
        break;
    case NQM_GLTF_TEXTURE:
        if (!is_off)
            refuse(r, path, "", TEXTURE_REASON);
        break;
    case NQM_GLTF_IGNORED:
        break;
    }
    return status;
}

static bool is_zero(const json_t *value) {
    if (!json_is_array(value))
        return json_is_number(value) && json_number_value(value) == 0;
    size_t i = 0;
    while (i < json_array_size(value) && is_zero(json_array_get(value, i)))
        ++i;
    return i == json_array_size(value);
}

/* The factor of a layer is 0: its textures have no effect. */
static bool is_layer_off(const nqm_gltf_group *group, const json_t *object) {
    const json_t *factor = json_object_get(object, group->properties[0].name);
    return group != &nqm_gltf_core && (factor ? is_zero(factor) : group->is_off_by_default);
}

/* `prefix` is the path of the object with a dot at its end. */
static nqm_status read_layer(reader *r, const nqm_gltf_group *group, const char *prefix, json_t *object) {
    const char *name;
    json_t *value;
    char path[PATH_SIZE];
    nqm_status status = NQM_OK;
    json_object_foreach(object, name, value) {
        const nqm_gltf_property *p = group->properties, *end = p + sizeof group->properties / sizeof *group->properties;
        snprintf(path, sizeof path, "%s%.100s", prefix, name);
        while (p < end && p->name && strcmp(p->name, name) != 0)
            ++p;
        if (p < end && p->name)
            status = read_property(r, p, group, path, value, is_layer_off(group, object));
        else if (strcmp(name, "extras") != 0 && !(strcmp(name, "extensions") == 0 && json_object_size(value) == 0))
            refuse(r, path, "", "this property is not known");
        if (status != NQM_OK)
            return status;
    }
    return NQM_OK;
}

static nqm_status read_object(reader *r, const nqm_gltf_group *group, const char *path, json_t *object) {
    char prefix[PATH_SIZE / 2];
    if (!json_is_object(object))
        return fail_value(r, path, "an object");
    snprintf(prefix, sizeof prefix, "%.120s.", path);
    return read_layer(r, group, prefix, object);
}

static nqm_status read_extensions(reader *r, json_t *list) {
    const char *name;
    json_t *object;
    char path[PATH_SIZE];
    if (!json_is_object(list))
        return fail_value(r, "extensions", "an object");
    json_object_foreach(list, name, object) {
        const nqm_gltf_group *extension = find_extension(name);
        nqm_status status = NQM_OK;
        snprintf(path, sizeof path, "extensions.%.100s", name);
        if (extension)
            status = read_object(r, extension, path, object);
        else
            refuse(r, path, "",
                   strcmp(name, "KHR_materials_unlit") == 0 ? "a surface without lighting has no BRDF"
                   : strcmp(name, "KHR_materials_pbrSpecularGlossiness") == 0
                       ? "this archived shading model is not supported; convert the material to metallic-roughness"
                       : "this extension is not known");
        if (status != NQM_OK)
            return status;
    }
    return NQM_OK;
}

static nqm_status check_emission(reader *r, const json_t *material) {
    const json_t *factor = json_object_get(material, "emissiveFactor");
    const json_t *strength =
        json_object_get(json_object_get(json_object_get(material, "extensions"), "KHR_materials_emissive_strength"),
                        "emissiveStrength");
    double v[3];
    nqm_status status = factor ? read_numbers(r, "emissiveFactor", factor, 3, v) : NQM_OK;
    if (status == NQM_OK && factor && !is_zero(factor) && !(strength && is_zero(strength)))
        refuse(r, "emissiveFactor", "", "light that the surface emits is not part of a BRDF");
    return status;
}

/* The mode is unknown, or the surface is not opaque in it. */
static nqm_status check_alpha(reader *r, const json_t *material) {
    const json_t *mode = json_object_get(material, "alphaMode"), *limit = json_object_get(material, "alphaCutoff");
    const char *text = mode ? json_string_value(mode) : "OPAQUE";
    double cutoff = 0.5;
    nqm_status status = limit ? read_numbers(r, "alphaCutoff", limit, 1, &cutoff) : NQM_OK;
    if (status != NQM_OK)
        return status;
    if (!text || (strcmp(text, "OPAQUE") != 0 && strcmp(text, "MASK") != 0 && strcmp(text, "BLEND") != 0))
        return fail_value(r, "alphaMode", "\"OPAQUE\", \"MASK\" or \"BLEND\"");
    if (strcmp(text, "BLEND") == 0 && r->alpha < 1)
        refuse(r, "alphaMode", text,
               "the alpha of baseColorFactor is below 1, and a transparent surface has more than a BRDF");
    if (strcmp(text, "MASK") == 0 && r->alpha < cutoff)
        refuse(r, "alphaMode", text, "the alpha of baseColorFactor is below alphaCutoff: the surface is invisible");
    return NQM_OK;
}

/* The properties that lie in the material itself. */
static nqm_status read_members(reader *r, json_t *material) {
    static const char *const known[] = {"name",           "extras",      "extensions",  "pbrMetallicRoughness",
                                        "emissiveFactor", "alphaCutoff", "doubleSided", "alphaMode"};
    static const char *const textures[] = {"normalTexture", "emissiveTexture"};
    enum { N_KNOWN = sizeof known / sizeof *known, N_TEXTURES = sizeof textures / sizeof *textures };
    const char *name;
    json_t *value;
    json_object_foreach(material, name, value) {
        size_t i = 0, k = 0;
        if (strcmp(name, "occlusionTexture") == 0) {
            r->shading.remark = NQM_OCCLUSION_REMARK;
            continue;
        }
        while (i < N_KNOWN && strcmp(known[i], name) != 0)
            ++i;
        while (k < N_TEXTURES && strcmp(textures[k], name) != 0)
            ++k;
        /* the emission is texture times factor, whose default is 0 */
        if (k == 1 &&
            (!json_object_get(material, "emissiveFactor") || is_zero(json_object_get(material, "emissiveFactor"))))
            continue;
        if (k < N_TEXTURES)
            refuse(r, name, "", TEXTURE_REASON);
        else if (i == N_KNOWN)
            refuse(r, name, "", "this property is not known");
    }
    json_t *pbr = json_object_get(material, nqm_gltf_core.name), *list = json_object_get(material, "extensions");
    nqm_status status = pbr ? read_object(r, &nqm_gltf_core, nqm_gltf_core.name, pbr) : NQM_OK;
    if (status == NQM_OK && list)
        status = read_extensions(r, list);
    return status;
}

static nqm_status read_material(reader *r, json_t *material, nqm_materials *materials) {
    const json_t *name = json_object_get(material, "name");
    r->shading = (nqm_shading){.model = "gltf"};
    r->alpha = 1;
    r->refusal[0] = 0;
    if (!json_is_object(material))
        return fail_value(r, "", "an object as material");
    if (name && !json_is_string(name))
        return fail_value(r, "name", "a string");
    nqm_status status = read_members(r, material);
    if (status == NQM_OK)
        status = check_emission(r, material);
    if (status == NQM_OK)
        status = check_alpha(r, material);
    if (status != NQM_OK)
        return status;
    const nqm_property *ior = nqm_shading_find(&r->shading, "ior");
    if (ior && (ior->v[0] < 0 || (ior->v[0] > 0 && ior->v[0] < 1)))
        refuse(r, "extensions.KHR_materials_ior.ior", "", "the index must be 0, or 1 or greater");
    const char *text = name ? json_string_value(name) : NULL;
    if (!*r->refusal)
        return nqm_materials_add_shading(materials, text, "glTF metallic-roughness", &r->shading, byte_of(r, ""),
                                         r->err);
    const nqm_material_info info = {
        .name = text, .surface = "glTF metallic-roughness", .refusal = r->refusal, .byte_offset = r->refusal_byte};
    return nqm_materials_add(materials, &info, r->err);
}

/* ---- reading the file -------------------------------------------------------------------------------------------- */

static bool is_glb(const nqm_map *map) {
    return map->n_bytes >= 4 && memcmp(map->data, "glTF", 4) == 0;
}

/* The JSON text of a binary file. */
static nqm_status find_chunk(const nqm_map *map, reader *r, nqm_error *err) {
    const unsigned char *d = map->data;
    const size_t begin = NQM_GLTF_GLB_HEADER + NQM_GLTF_CHUNK_HEADER;
    if (map->n_bytes < begin)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)map->n_bytes,
                        "%s: the binary glTF ends in its header, at byte %zu", map->path, map->n_bytes);
    const uint32_t version = nqm_load_u32(d + 4), n_file = nqm_load_u32(d + 8), n_chunk = nqm_load_u32(d + 12);
    if (version != 2)
        return nqm_fail(err, NQM_ERR_FORMAT, 4, "%s: byte 4: binary glTF of version %u; only 2 is read", map->path,
                        version);
    if (n_file < begin || n_file > map->n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, 8, "%s: byte 8: the header says %u bytes, the file has %zu", map->path,
                        n_file, map->n_bytes);
    if (nqm_load_u32(d + 16) != NQM_GLTF_JSON_CHUNK)
        return nqm_fail(err, NQM_ERR_FORMAT, 16, "%s: byte 16: the first chunk is not JSON", map->path);
    if (n_chunk > n_file - begin)
        return nqm_fail(err, NQM_ERR_FORMAT, 12, "%s: byte 12: a chunk of %u bytes, and %zu bytes follow", map->path,
                        n_chunk, (size_t)n_file - begin);
    r->source = (nqm_json_source){(const char *)d + begin, n_chunk};
    r->source_at = begin;
    return NQM_OK;
}

/* Whether a word is among the first n_bytes. */
static bool contains(const nqm_map *map, size_t n_bytes, const char *word) {
    const size_t n = strlen(word);
    for (const unsigned char *p = map->data, *end = p + n_bytes; (size_t)(end - p) >= n; ++p) {
        p = memchr(p, word[0], (size_t)(end - p) - n + 1);
        if (!p)
            return false;
        if (memcmp(p, word, n) == 0)
            return true;
    }
    return false;
}

static bool has_suffix(const char *path, const char *suffix) {
    const size_t n = strlen(path), n_suffix = strlen(suffix);
    return n >= n_suffix && strcasecmp(path + n - n_suffix, suffix) == 0;
}

static bool gltf_probe(const nqm_map *map) {
    const size_t n = nqm_smaller(map->n_bytes, NQM_PROBE_BYTES);
    size_t i = 0;
    if (is_glb(map))
        return true;
    while (i < n && memchr(" \t\r\n", map->data[i], 4))
        ++i;
    return i < n && map->data[i] == '{' &&
           (has_suffix(map->path, ".gltf") || contains(map, n, "\"asset\"") ||
            contains(map, n, "\"pbrMetallicRoughness\""));
}

/* An extension that every reader must know; NULL: none. */
static const char *unknown_requirement(const json_t *root) {
    const json_t *list = json_object_get(root, "extensionsRequired"), *value;
    size_t i;
    json_array_foreach(list, i, value) {
        const char *name = json_string_value(value);
        size_t k = 0, n = sizeof harmless / sizeof *harmless;
        while (name && k < n && strcmp(harmless[k], name) != 0)
            ++k;
        /* extensions that a material refuses are named at the material */
        if (name && k == n && !find_extension(name) && strcmp(name, "KHR_materials_unlit") != 0 &&
            strcmp(name, "KHR_materials_pbrSpecularGlossiness") != 0)
            return name;
    }
    return NULL;
}

/* "2.0", "2.1", ...; with max_minor the minor version is at most that. */
static bool is_version_2(const char *version, int max_minor) {
    int minor = 0, n = 0;
    const bool is_valid = sscanf(version, "2.%9d%n", &minor, &n) == 1 && !version[n] && version[2] >= '0';
    return is_valid && minor <= max_minor;
}

static nqm_status check_root(const reader *r, const json_t *root) {
    const json_t *asset = json_object_get(root, "asset"), *min_version = json_object_get(asset, "minVersion");
    const char *version = json_string_value(json_object_get(asset, "version"));
    const size_t at = nqm_json_path(&r->source, nqm_json_begin(&r->source), "asset.version");
    const int64_t byte = (int64_t)(r->source_at + at);
    if (!version)
        return nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: this JSON has no asset.version and is no glTF",
                        r->path, (long long)byte);
    if (!is_version_2(version, INT_MAX))
        return nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: glTF %.20s; only glTF 2 is read", r->path,
                        (long long)byte, version);
    if (min_version && !(json_is_string(min_version) && is_version_2(json_string_value(min_version), 0)))
        return nqm_fail(r->err, NQM_ERR_FORMAT, byte,
                        "%s: byte %lld: asset.minVersion is '%.20s'; a reader of glTF 2.0 must refuse such a file",
                        r->path, (long long)byte,
                        json_is_string(min_version) ? json_string_value(min_version) : "no string");
    const json_t *materials = json_object_get(root, "materials");
    const int64_t at_materials =
        (int64_t)(r->source_at + nqm_json_path(&r->source, nqm_json_begin(&r->source), "materials"));
    if (materials && !json_is_array(materials))
        return nqm_fail(r->err, NQM_ERR_FORMAT, at_materials, "%s: byte %lld: materials needs an array", r->path,
                        (long long)at_materials);
    return NQM_OK;
}

/* Refuse a material because of an extension that the file requires. at: of the list of these in the JSON text. */
static nqm_status refuse_required(const reader *r, const char *required, size_t at, const json_t *material,
                                  nqm_materials *materials) {
    char refusal[160];
    snprintf(refusal, sizeof refusal, "extensionsRequired: %.80s is not known", required);
    const nqm_material_info info = {.name = json_string_value(json_object_get(material, "name")),
                                    .surface = "glTF metallic-roughness",
                                    .refusal = refusal,
                                    .byte_offset = (int64_t)(r->source_at + at)};
    return nqm_materials_add(materials, &info, r->err);
}

/* Parse n bytes of text, which are at byte `at` of the source or a part of it with the same positions. */
static nqm_status parse(const reader *r, const char *text, size_t n, size_t at, json_t **value_ret) {
    json_error_t why;
    const size_t in_file = r->source_at + at;
    nqm_status status = nqm_json_check(text, n, r->source.n, r->path, in_file, r->err);
    *value_ret = NULL;
    if (status != NQM_OK)
        return status;
    status = nqm_json_load(text, n, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, value_ret, &why, r->err);
    if (status != NQM_ERR_FORMAT)
        return status;
    const int64_t byte = (int64_t)in_file + why.position;
    return nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: invalid JSON: %s", r->path, (long long)byte,
                    why.text);
}

/* root: the outline of the file. */
static nqm_status read_root(reader *r, const json_t *root, nqm_materials *materials) {
    nqm_status status = check_root(r, root);
    if (status != NQM_OK)
        return status;
    const char *required = unknown_requirement(root);
    const size_t required_at = nqm_json_path(&r->source, nqm_json_begin(&r->source), "extensionsRequired");
    const size_t n = json_array_size(json_object_get(root, "materials"));
    r->at = nqm_json_first(&r->source, nqm_json_path(&r->source, nqm_json_begin(&r->source), "materials"));
    if (n && r->at == SIZE_MAX)
        return nqm_fail(r->err, NQM_ERR_FORMAT, (int64_t)r->source_at,
                        "%s: byte %zu: the key \"materials\" is written with escapes", r->path, r->source_at);
    for (size_t i = 0; i < n && status == NQM_OK; ++i) {
        const size_t at = r->at;
        json_t *material;
        status = parse(r, r->source.text + at, nqm_json_end(&r->source, at) - at, at, &material);
        if (status == NQM_OK)
            status = required ? refuse_required(r, required, required_at, material, materials)
                              : read_material(r, material, materials);
        json_decref(material);
        r->at = nqm_json_next(&r->source, at);
    }
    return status;
}

static nqm_status gltf_read(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    reader r = {.path = map->path, .source = {(const char *)map->data, map->n_bytes}, .err = err};
    nqm_status status = is_glb(map) ? find_chunk(map, &r, err) : NQM_OK;
    if (status != NQM_OK)
        return status;
    json_t *root;
    char *outline = nqm_alloc(r.source.n + 1, 1);
    if (!outline)
        return nqm_fail_nomem(err, r.source.n);
    nqm_json_outline(&r.source, outline);
    status = parse(&r, outline, r.source.n, 0, &root);
    nqm_free(outline);
    if (status == NQM_OK)
        status = read_root(&r, root, materials);
    json_decref(root);
    return status;
}

const nqm_material_format nqm_gltf_format = {
    .name = "glTF 2.0",
    .extensions = ".gltf .glb",
    .models = "gltf",
    .probe = gltf_probe,
    .read = gltf_read,
    .write = nqm_gltf_write,
};
