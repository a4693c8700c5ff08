/* SPDX-License-Identifier: MIT
 *
 * Reading of materials of glTF 2.0, as JSON (.gltf) and binary (.glb), with the properties of gltf_properties.c and the textures of
 * gltf_textures.c. They are parsed one by one, because the tree of a whole file takes twenty times its bytes.
 */
#define _GNU_SOURCE /* strcasestr */
#include "material/gltf.h"
#include "io/io.h"

#include "schema/models.h"
#include <limits.h>

static const char SURFACE[] = "glTF metallic-roughness";
static const char TEXTURE_REASON[] = "a texture varies over the surface, and a BRDF is that of one point";

/** Extensions that a file may require and that are read with its textures. */
static const char of_textures[] =
    "KHR_texture_basisu KHR_texture_transform EXT_texture_webp EXT_texture_avif MSFT_texture_dds";

static bool has_word(const char *name, size_t n, const char *const *words) {
    bool has = false;
    for (; *name; ++name)
        for (size_t i = 0; i < n; ++i)
            has = has || nqm_equal_any_case(name, words[i], strlen(words[i]));
    return has;
}

/* Whether a required extension may change materials. Those whose name says that they are about geometry, lights, places or data do
 * not; what an unknown name means is not known. */
static bool changes_materials(const char *name) {
    static const char *const of_materials[] = {"material", "texture", "shader", "technique", "packing"},
                             *const of_others[] = {"mesh",         "draco",      "geometry", "primitive", "splat",
                                                   "light",        "node",       "instanc",  "scene",     "camera",
                                                   "georef",       "rtc",        "tile",     "animation", "pointer",
                                                   "articulation", "physics",    "audio",    "visibil",   "select",
                                                   "hover",        "interactiv", "lod",      "xmp",       "metadata",
                                                   "feature",      "json"};
    const bool is_other = has_word(name, sizeof of_others / sizeof *of_others, of_others);
    return strcmp(name, "KHR_materials_variants") != 0 &&
           (!is_other || has_word(name, sizeof of_materials / sizeof *of_materials, of_materials));
}

/* Extensions that have no effect where the property `weight` is 0 or missing: drafts, mostly. */
static const struct {
    const char *name, *weight;
} drafts[] = {{"KHR_materials_diffuse_roughness", "diffuseRoughnessFactor"},
              {"KHR_materials_coat", "coatFactor"},
              {"KHR_materials_fuzz", "fuzzFactor"},
              {"KHR_materials_subsurface", "subsurfaceFactor"},
              {"KHR_materials_volume_scatter", "multiscatterColor"},
              {"KHR_materials_sss", "scatterDistance"},
              {"ADOBE_materials_thin_transparency", "transmissionFactor"}};

/* The weight of a draft; NULL: it is none. */
static const char *weight_of(const char *name) {
    for (size_t i = 0; i < sizeof drafts / sizeof *drafts; ++i)
        if (strcmp(drafts[i].name, name) == 0)
            return drafts[i].weight;
    return NULL;
}

static const nqm_gltf_group *find_extension(const char *name) {
    for (size_t i = 0; i < NQM_GLTF_N_EXTENSIONS; ++i)
        if (strcmp(nqm_gltf_extensions[i].name, name) == 0)
            return &nqm_gltf_extensions[i];
    return strcmp(nqm_gltf_glossiness.name, name) == 0 ? &nqm_gltf_glossiness : NULL;
}

/* ---- reading one material ---------------------------------------------------------------------------------------- */

enum { PATH_SIZE = 256, MAX_TEXTURES = 16 };

/** A property with its path in the material: "extensions.KHR_materials_ior.ior". */
typedef struct property {
    char path[PATH_SIZE];
    const json_t *value;
} property;

/** The state of reading; a refusal ends the reading of one material, a failure that of the file. */
typedef struct reader {
    nqm_reading reading;
    nqm_gltf_document document;
    size_t at;          /**< of the document or material in the JSON text; SIZE_MAX: none */
    const char *prefix; /**< of the paths of properties of the present object, with a dot at its end */
    json_t *object;     /**< the present one */
    property gate;
    double alpha;
    size_t n_textures;
    property textures[MAX_TEXTURES]; /**< of the material that have an effect */
    nqm_status status;               /**< of the reading of numbers */
    nqm_error *err;
} reader;

static int64_t byte_of(const reader *r, const char *path) {
    return (int64_t)(r->document.source_at + nqm_json_path(&r->document.source, r->at, path));
}

/* at: a property, which begins with its path, or a path. */
static int64_t byte_of_property(const nqm_reading *r, const void *at) {
    return byte_of((const reader *)r, at);
}

/* The path of a property as messages have it. */
static const char *shown_path(const char *path) {
    static const char prefix[] = "extensions.";
    return strncmp(path, prefix, sizeof prefix - 1) == 0 ? path + sizeof prefix - 1 : path;
}

/* Refuse the material as "PROPERTY: REASON". `path` is that of the property in the material. */
static bool refuse(reader *r, const char *path, const char *value, const char *reason) {
    return nqm_refuse(&r->reading, path, "%.120s%s%s: %s", shown_path(path), *value ? " = " : "", value, reason);
}

/* The same, unless `ignorable` is ignored. */
static bool set_aside(reader *r, unsigned ignorable, const char *path, const char *value, const char *reason) {
    return nqm_set_aside(&r->reading, ignorable, path, "%.120s%s%s: %s", shown_path(path), *value ? " = " : "", value,
                         reason);
}

/* The file is damaged: the status is that of the first failure. */
static bool fail_value(reader *r, const char *path, const char *needed) {
    const int64_t byte = byte_of(r, path);
    if (r->status == NQM_OK)
        r->status = nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: %.120s needs %s", r->document.path,
                             (long long)byte, path, needed);
    return false;
}

/* v: (n) */
static bool read_numbers(reader *r, const char *path, const json_t *value, size_t n, double *v) {
    static const char *const needed[] = {"", "a number", "", "an array of 3 numbers", "an array of 4 numbers"};
    bool is_valid = n == 1 || json_array_size(value) == n;
    for (size_t i = 0; is_valid && i < n; ++i) {
        const json_t *number = n == 1 ? value : json_array_get(value, i);
        is_valid = json_is_number(number);
        v[i] = json_number_value(number);
    }
    return is_valid || fail_value(r, path, needed[n]);
}

static bool read_values(nqm_reading *reading, const nqm_rule *rule, const void *at, double v[4], size_t *n) {
    const property *p = at;
    *n = rule->n;
    return read_numbers((reader *)reading, p->path, p->value, rule->n, v);
}

/* Of a layer: the factor, which gates its textures. */
static const void *find_property(nqm_reading *reading, const char *name) {
    reader *r = (reader *)reading;
    snprintf(r->gate.path, sizeof r->gate.path, "%s%.100s", r->prefix, name);
    r->gate.value = json_object_get(r->object, name);
    return r->gate.value ? &r->gate : NULL;
}

static const nqm_rule_source source = {
    .term = "property", .shows_owner = true, .find = find_property, .read = read_values, .byte_of = byte_of_property};

bool nqm_gltf_read_base_color(nqm_reading *reading, const nqm_rule *rule, const void *at) {
    reader *r = (reader *)reading;
    double v[4];
    size_t n;
    if (!read_values(reading, rule, at, v, &n))
        return false;
    nqm_values_set(&reading->values, rule->key, 3, v);
    r->alpha = v[3];
    return (v[3] >= 0 && v[3] <= 1) ||
           refuse(r, ((const property *)at)->path, "", "alpha, its fourth number, is outside of 0 to 1");
}

bool nqm_gltf_read_glossiness(nqm_reading *reading, const nqm_rule *rule, const void *at) {
    double v[4];
    size_t n;
    if (!read_values(reading, rule, at, v, &n))
        return false;
    v[0] = 1 - v[0];
    nqm_values_set(&reading->values, rule->key, 1, v);
    return true;
}

bool nqm_gltf_read_texture(nqm_reading *reading, const nqm_rule *rule, const void *at) {
    reader *r = (reader *)reading;
    const property *p = at;
    if (rule->why)
        return set_aside(r, rule->ignorable, p->path, "", rule->why);
    if (r->n_textures < MAX_TEXTURES) /* there are fewer rules for textures */
        r->textures[r->n_textures++] = *p;
    return true;
}

bool nqm_gltf_read_occlusion(nqm_reading *reading, const nqm_rule *rule, const void *at) {
    (void)rule, (void)at;
    nqm_textured_remark(reading->textured, NQM_OCCLUSION_REMARK);
    return true;
}

bool nqm_gltf_read_minimum(nqm_reading *reading, const nqm_rule *rule, const void *at) {
    const property *p = at;
    reader *r = (reader *)reading;
    if (!json_object_get(r->object, "iridescenceThicknessTexture"))
        return nqm_reading_unused(reading, rule->name);
    return read_numbers(r, p->path, p->value, rule->n, &r->document.film_minimum);
}

static void read_object(reader *r, const nqm_gltf_group *group, const char *path, json_t *object) {
    char prefix[PATH_SIZE / 2];
    const char *name;
    json_t *value;
    if (!json_is_object(object))
        fail_value(r, path, "an object");
    snprintf(prefix, sizeof prefix, "%.120s%s", path, *path ? "." : "");
    r->prefix = prefix;
    r->object = object;
    r->reading.rules = group->rules;
    r->reading.owner = group->name;
    json_object_foreach(object, name, value) {
        property p = {.value = value};
        snprintf(p.path, sizeof p.path, "%s%.100s", prefix, name);
        const bool is_free =
            strcmp(name, "extras") == 0 || (strcmp(name, "extensions") == 0 && json_object_size(p.value) == 0);
        if (!is_free && r->status == NQM_OK)
            nqm_rules_apply(&r->reading, name, &p, false); /* the JSON has none twice */
    }
}

/* 0, three of them, or missing */
static bool is_zero(const json_t *value) {
    bool is = !value || json_is_number(value) || json_array_size(value) == 3;
    for (size_t i = 0; i < 3; ++i)
        is = is && json_number_value(json_is_array(value) ? json_array_get(value, i) : value) == 0;
    return is;
}

/* Specular-glossiness stands for metallic-roughness, and its defaults are other ones. */
static void begin_glossiness(reader *r, const json_t *list, const json_t *core) {
    static const char *const others[] = {"KHR_materials_specular", "KHR_materials_ior"};
    static const char *const keys[] = {"metallic", "roughness", "ior", "base_color"};
    for (size_t i = 0; i < 4; ++i)
        nqm_values_set(&r->reading.values, keys[i], 1, &(double){i == 3});
    for (size_t i = 0; i < 2; ++i)
        if (json_object_get(list, others[i]))
            refuse(r, "extensions.KHR_materials_pbrSpecularGlossiness", "",
                   "it excludes KHR_materials_specular and KHR_materials_ior");
    if (core)
        nqm_textured_remark(r->reading.textured,
                            "pbrMetallicRoughness is not used beside KHR_materials_pbrSpecularGlossiness");
}

static void read_extensions(reader *r, json_t *list) {
    const char *name;
    json_t *object;
    char path[PATH_SIZE];
    if (!json_is_object(list))
        fail_value(r, "extensions", "an object");
    json_object_foreach(list, name, object) {
        const nqm_gltf_group *extension = find_extension(name);
        snprintf(path, sizeof path, "extensions.%.100s", name);
        const char *weight = weight_of(name);
        if (strncmp(name, "MSFT_packing_", 13) == 0)
            nqm_textured_remark(r->reading.textured, "packed copies of its textures (MSFT_packing) are not used");
        else if (extension && !extension->refusal)
            read_object(r, extension, path, object);
        else if (!weight)
            refuse(r, path, "", extension ? extension->refusal : "this extension is not known");
        else if (!is_zero(json_object_get(object, weight)))
            refuse(r, path, "", "this extension is not read");
    }
}

static void check_emission(reader *r, const json_t *material) {
    const json_t *factor = json_object_get(material, "emissiveFactor");
    const json_t *strength =
        json_object_get(json_object_get(json_object_get(material, "extensions"), "KHR_materials_emissive_strength"),
                        "emissiveStrength");
    double v[3];
    if (factor && read_numbers(r, "emissiveFactor", factor, 3, v) && (v[0] != 0 || v[1] != 0 || v[2] != 0) &&
        !(json_is_number(strength) && json_number_value(strength) == 0))
        set_aside(r, NQM_IGNORE_EMISSION, "emissiveFactor", "", "light that the surface emits is not part of a BRDF");
}

/* The mode is unknown, or the surface is not opaque in it. */
static void check_alpha(reader *r, const json_t *material) {
    const json_t *mode = json_object_get(material, "alphaMode"), *limit = json_object_get(material, "alphaCutoff");
    const char *text = mode ? json_string_value(mode) : "OPAQUE";
    double cutoff = 0.5;
    if (limit && !read_numbers(r, "alphaCutoff", limit, 1, &cutoff))
        return;
    if (!text || !nqm_contains_word("OPAQUE MASK BLEND", text, false))
        fail_value(r, "alphaMode", "\"OPAQUE\", \"MASK\" or \"BLEND\"");
    else if (strcmp(text, "BLEND") == 0 && r->alpha < 1)
        set_aside(r, NQM_IGNORE_OPACITY, "alphaMode", text,
                  "the alpha of baseColorFactor is below 1, and a transparent surface has more than a BRDF");
    else if (strcmp(text, "MASK") == 0 && r->alpha < cutoff)
        set_aside(r, NQM_IGNORE_OPACITY, "alphaMode", text,
                  "the alpha of baseColorFactor is below alphaCutoff: the surface is invisible");
    else if (mode)
        nqm_reading_unused(&r->reading, "alphaMode");
}

static void remark(reader *r, bool is_needed, const char *text) {
    if (is_needed)
        nqm_textured_remark(r->reading.textured, text);
}

/* The textures of a material whose factors are read. There is one normal for all layers: that of the base. */
static void add_textures(reader *r, const json_t *material) {
    const json_t *mode = json_object_get(material, "alphaMode"), *base = json_object_get(material, "normalTexture");
    const double *coat = nqm_values_given(&r->reading.values, "clearcoat");
    bool has_coat = coat && coat[0] > 0;
    r->document.has_other_set = r->document.has_filter = false;
    for (size_t i = 0; i < r->n_textures && !*r->reading.refusal.text; ++i) {
        const property *p = &r->textures[i];
        const char *dot = strrchr(p->path, '.'), *name = dot ? dot + 1 : p->path;
        nqm_vary(&r->reading, p, "%.120s: %s", shown_path(p->path), TEXTURE_REASON);
        if (strcmp(name, "clearcoatNormalTexture") == 0) {
            has_coat = false;
            if (!json_equal(p->value, base))
                set_aside(r, NQM_IGNORE_BUMP, p->path, "",
                          "a coat with another normal map than normalTexture is not read");
            remark(r, !json_equal(p->value, base),
                   "the normal map of the clear coat is not used: it has that of the base");
        } else if (!nqm_gltf_add_texture(&r->document, name, p->value, &r->reading))
            refuse(r, p->path, "", r->document.why);
        remark(r, mode && strcmp(name, "baseColorTexture") == 0 && strcmp(json_string_value(mode), "OPAQUE") != 0,
               "the alpha of baseColorTexture is ignored: the surface is taken as opaque");
    }
    if (r->document.has_filter)
        nqm_reading_unused(&r->reading, "magFilter, minFilter");
    remark(r, r->document.has_other_set, "all sets of texture coordinates are taken as the same");
    remark(r, base && has_coat, "the clear coat is taken to have the normal map of the base");
}

static nqm_status read_material(reader *r, json_t *material, nqm_materials *materials) {
    const json_t *name = json_object_get(material, "name");
    if (!nqm_reading_begin(&r->reading, &source))
        return nqm_fail_nomem(r->err, sizeof *r->reading.textured);
    r->reading.values = nqm_values_of(&nqm_gltf_schema);
    r->alpha = 1;
    r->n_textures = 0;
    r->document.film_minimum = 100;
    json_t *pbr = json_object_get(material, nqm_gltf_core.name), *list = json_object_get(material, "extensions");
    if (!json_is_object(material))
        fail_value(r, "", "an object as material");
    if (name && !json_is_string(name))
        fail_value(r, "name", "a string");
    read_object(r, &nqm_gltf_members, "", material);
    const bool is_glossy = json_object_get(list, nqm_gltf_glossiness.name) != NULL;
    if (is_glossy)
        begin_glossiness(r, list, pbr);
    else if (pbr)
        read_object(r, &nqm_gltf_core, nqm_gltf_core.name, pbr);
    if (list)
        read_extensions(r, list);
    check_emission(r, material);
    check_alpha(r, material);
    if (r->status != NQM_OK) {
        nqm_textured_free(r->reading.textured);
        return r->status;
    }
    const double *ior = nqm_values_given(&r->reading.values, "ior");
    if (ior && (*ior < 0 || (*ior > 0 && *ior < 1)))
        refuse(r, "extensions.KHR_materials_ior.ior", "", "the index must be 0, or 1 or greater");
    add_textures(r, material);
    return nqm_reading_add(&r->reading, json_string_value(name), SURFACE, byte_of(r, ""), materials, r->err);
}

/* ---- reading the file -------------------------------------------------------------------------------------------- */

static bool is_glb(const nqm_map *map) {
    return map->n_bytes >= 4 && memcmp(map->data, "glTF", 4) == 0;
}

/* The JSON text of a binary file. */
static nqm_status find_chunk(const nqm_map *map, nqm_gltf_document *document, nqm_error *err) {
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
    document->source = (nqm_json_source){(const char *)d + begin, n_chunk};
    document->source_at = begin;
    const size_t end = begin + n_chunk, bin = end + NQM_GLTF_CHUNK_HEADER; /* a binary chunk may follow */
    if (bin <= n_file && nqm_load_u32(d + end + 4) == NQM_GLTF_BIN_CHUNK) {
        document->bin_at = bin;
        document->n_bin = nqm_smaller(nqm_load_u32(d + end), n_file - bin);
    }
    return NQM_OK;
}

static bool gltf_probe(const nqm_map *map) {
    const size_t n = nqm_smaller(map->n_bytes, NQM_PROBE_BYTES);
    const char *dot = strrchr(map->path, '.');
    size_t i = 0;
    if (is_glb(map))
        return true;
    while (i < n && memchr(" \t\r\n", map->data[i], 4))
        ++i;
    return i < n && map->data[i] == '{' &&
           ((dot && nqm_equal_any_case(dot, ".gltf", SIZE_MAX)) || nqm_material_probe_text(map, n, "\"asset\"") ||
            nqm_material_probe_text(map, n, "\"pbrMetallicRoughness\""));
}

/* An extension that every reader must know; NULL: none. Remarks name those that are ignored. */
static const char *unknown_requirement(const json_t *root, nqm_materials *materials) {
    char text[200];
    const json_t *list = json_object_get(root, "extensionsRequired"), *value;
    size_t i;
    json_array_foreach(list, i, value) {
        const char *name = json_string_value(value);
        /* extensions that a material refuses are named at the material */
        if (!name || nqm_contains_word(of_textures, name, false) || find_extension(name) || weight_of(name))
            continue;
        if (changes_materials(name))
            return name;
        snprintf(text, sizeof text, "the required extension %.80s, which is not about materials", name);
        nqm_materials_unread(materials, text);
    }
    return NULL;
}

/* "2.0", "2.1", ...; with max_minor the minor version is at most that. */
static bool is_version_2(const char *version, int max_minor) {
    int minor = 0, n = 0;
    const bool is_valid = sscanf(version, "2.%9d%n", &minor, &n) == 1 && !version[n] && version[2] >= '0';
    return is_valid && minor <= max_minor;
}

static nqm_status check_root(reader *r, const json_t *root) {
    const json_t *asset = json_object_get(root, "asset"), *minimum = json_object_get(asset, "minVersion");
    const char *version = json_string_value(json_object_get(asset, "version")), *path = r->document.path;
    const char *min_version = json_is_string(minimum) ? json_string_value(minimum) : "no string";
    const json_t *materials = json_object_get(root, "materials");
    const int64_t byte = byte_of(r, "asset.version");
    const long long at = (long long)byte;
    if (!version)
        return nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: this JSON has no asset.version and is no glTF",
                        path, at);
    if (!is_version_2(version, INT_MAX))
        return nqm_fail(r->err, NQM_ERR_FORMAT, byte, "%s: byte %lld: glTF %.20s; only glTF 2 is read", path, at,
                        version);
    if (minimum && !is_version_2(min_version, 0))
        return nqm_fail(r->err, NQM_ERR_FORMAT, byte,
                        "%s: byte %lld: asset.minVersion is '%.20s'; a reader of glTF 2.0 must refuse such a file",
                        path, at, min_version);
    if (materials && !json_is_array(materials))
        fail_value(r, "materials", "an array");
    return r->status;
}

/* Refuse a material because of an extension that the file requires. at: of the list of these in the JSON text. */
static nqm_status refuse_required(const reader *r, const char *required, size_t at, const json_t *material,
                                  nqm_materials *materials) {
    char refusal[160];
    snprintf(refusal, sizeof refusal, "extensionsRequired: %.80s is not known", required);
    const nqm_material_info info = {.name = json_string_value(json_object_get(material, "name")),
                                    .surface = SURFACE,
                                    .refusal = refusal,
                                    .byte_offset = (int64_t)(r->document.source_at + at)};
    return nqm_materials_add(materials, &info, r->err);
}

/* root: the outline of the file. */
static nqm_status read_root(reader *r, const json_t *root, nqm_materials *materials) {
    nqm_gltf_document *d = &r->document;
    r->at = d->root = nqm_json_begin(&d->source);
    nqm_status status = check_root(r, root);
    if (status != NQM_OK)
        return status;
    const char *required = unknown_requirement(root, materials);
    const size_t required_at = nqm_json_path(&d->source, d->root, "extensionsRequired");
    const size_t n = json_array_size(json_object_get(root, "materials"));
    r->at = nqm_json_first(&d->source, nqm_json_path(&d->source, d->root, "materials"));
    if (n && r->at == SIZE_MAX)
        return nqm_fail(r->err, NQM_ERR_FORMAT, (int64_t)d->source_at,
                        "%s: byte %zu: the key \"materials\" is written with escapes", d->path, d->source_at);
    for (size_t i = 0; i < n && status == NQM_OK; ++i) {
        const size_t at = r->at;
        json_t *material;
        status = nqm_gltf_parse(d, d->source.text + at, nqm_json_end(&d->source, at) - at, at, &material, r->err);
        if (status == NQM_OK)
            status = required ? refuse_required(r, required, required_at, material, materials)
                              : read_material(r, material, materials);
        json_decref(material);
        r->at = nqm_json_next(&d->source, at);
    }
    return status;
}

static nqm_status gltf_read(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    reader r = {.document = {.path = map->path, .source = {(const char *)map->data, map->n_bytes}}, .err = err};
    nqm_status status = is_glb(map) ? find_chunk(map, &r.document, err) : NQM_OK;
    if (status != NQM_OK)
        return status;
    json_t *root;
    const size_t n = r.document.source.n;
    char *outline = nqm_alloc(n + 1, 1);
    if (!outline)
        return nqm_fail_nomem(err, n);
    nqm_json_outline(&r.document.source, outline);
    status = nqm_gltf_parse(&r.document, outline, n, 0, &root, err);
    nqm_free(outline);
    if (status == NQM_OK)
        status = read_root(&r, root, materials);
    nqm_gltf_document_clear(&r.document);
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
