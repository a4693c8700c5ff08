/* SPDX-License-Identifier: MIT
 *
 * Textures of glTF 2.0 materials as nodes of maps.h, with KHR_texture_transform. The arrays of the file that they refer to are
 * parsed when a material needs them.
 */
#include "io/io.h"
#include "material/gltf.h"
#include "material/materialx.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

enum { TEXTURES, SAMPLERS, IMAGES, VIEWS, BUFFERS };
static const char *const array_names[NQM_GLTF_N_ARRAYS] = {"textures", "samplers", "images", "bufferViews", "buffers"};
static const char no_memory[] = "out of memory, or more than 64 images or 1024 operations";

__attribute__((format(printf, 2, 3))) static bool fail(nqm_gltf_document *d, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(d->why, sizeof d->why, format, arguments);
    va_end(arguments);
    return false;
}

void nqm_gltf_document_clear(nqm_gltf_document *d) {
    for (size_t i = 0; i < NQM_GLTF_N_ARRAYS; ++i)
        json_decref(d->arrays[i]);
}

nqm_status nqm_gltf_parse(const nqm_gltf_document *d, const char *text, size_t n, size_t at, json_t **value_ret,
                          nqm_error *err) {
    const nqm_json_place place = {d->path, d->source.n, d->source_at + at};
    return nqm_json_read(text, n, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &place, value_ret, err);
}

/* Element i of an array, which is parsed when it is first needed; of one that is damaged only the first use tells how. */
static const json_t *element(nqm_gltf_document *d, size_t which, size_t i) {
    json_t **array = &d->arrays[which];
    if (!*array) {
        const size_t at = nqm_json_path(&d->source, d->root, array_names[which]), end = nqm_json_end(&d->source, at);
        nqm_error err = {0};
        const bool is_damaged =
            at != d->root && nqm_gltf_parse(d, d->source.text + at, end - at, at, array, &err) != NQM_OK;
        *array = *array ? *array : json_array();
        if (is_damaged) {
            fail(d, "%s", err.message);
            return NULL;
        }
    }
    const json_t *value = json_array_get(*array, i);
    if (!value)
        fail(d, "%s[%zu] is missing; the file has %zu", array_names[which], i, json_array_size(*array));
    return value;
}

/* An integer that is not negative. SIZE_MAX as fallback: the member must be there. */
static bool read_size(nqm_gltf_document *d, const json_t *object, const char *key, size_t fallback, size_t *v) {
    const json_t *value = json_object_get(object, key);
    const bool is_valid = value ? json_is_integer(value) && json_integer_value(value) >= 0 : fallback != SIZE_MAX;
    *v = value ? (size_t)json_integer_value(value) : fallback;
    return is_valid || fail(d, "'%s' needs an integer of at least 0", key);
}

/* The element that the index `key` of an object names; *i receives the index. NULL: fail() has been called. */
static const json_t *element_of(nqm_gltf_document *d, const json_t *object, const char *key, size_t which, size_t *i) {
    return read_size(d, object, key, SIZE_MAX, i) ? element(d, which, *i) : NULL;
}

/* ---- images ------------------------------------------------------------------------------------------------------ */

static bool is_data(const char *uri) {
    return nqm_equal_any_case(uri, "data:", 5);
}

/* A base64 digit, or -1. */
static int digit_of(char c) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *found = c ? strchr(digits, c) : NULL;
    return found ? (int)(found - digits) : -1;
}

/* Decode bytes `at` to at + n_bytes of a data: URI for the image; n_bytes SIZE_MAX: all of them. */
static bool decode_data(nqm_gltf_document *d, const char *uri, size_t at, size_t n_bytes, nqm_map_image *image) {
    const char *comma = strchr(uri, ','), *code = comma ? comma + 1 : "";
    size_t n_code = strlen(code);
    if (!comma || comma - uri < 7 || !nqm_equal_any_case(comma - 7, ";base64", 7))
        return fail(d, "a data: URI that is not base64 is not read");
    while (n_code && code[n_code - 1] == '=')
        --n_code;
    const size_t n_all = n_code / 4 * 3 + n_code % 4 * 3 / 4, n = n_bytes == SIZE_MAX ? n_all : n_bytes;
    if (at > n_all || n > n_all - at || n == 0)
        return fail(d, "bytes %zu to %zu are not in the data: URI, which has %zu bytes", at, at + n, n_all);
    /* Images that many materials use are decoded for each of them. */
    d->n_decoded += n;
    if (d->n_decoded > NQM_JSON_ROOM + 8 * d->source.n)
        return fail(d, "the images in the JSON text, decoded for each material, take too much memory; store the file "
                       "as .glb");
    unsigned char *bytes = nqm_alloc(n, 1);
    for (size_t i = 0; bytes && i < n; ++i) {
        const char *pair = code + (at + i) / 3 * 4 + (at + i) % 3;
        const int shift = 2 + 2 * (int)((at + i) % 3), high = digit_of(pair[0]), low = digit_of(pair[1]);
        if (high < 0 || low < 0) {
            nqm_free(bytes);
            return fail(d, "byte %zu of the base64 text of a data: URI is no base64 digit", (size_t)(pair - code));
        }
        bytes[i] = (unsigned char)(high << shift | low >> (6 - shift));
    }
    image->data = bytes;
    image->n_bytes = n;
    return bytes != NULL;
}

/* The file name of a URI, without percent-encoding; nqm_free(). */
static char *decode_name(nqm_gltf_document *d, const char *uri) {
    const char *colon = strchr(uri, ':');
    char *name = nqm_strdup(uri), *end = name;
    unsigned value;
    if (colon && colon - uri > 1 && strcspn(uri, "/?#%") > (size_t)(colon - uri)) {
        fail(d, "%.100s: only files on this computer are read; store the image next to %.60s", uri, d->path);
        nqm_free(name);
        return NULL;
    }
    for (const char *c = name; c && *c; ++c) {
        const bool is_code =
            *c == '%' && strspn(c + 1, "0123456789abcdefABCDEF") >= 2 && sscanf(c + 1, "%2x", &value) == 1;
        *end++ = is_code && value ? (char)value : *c;
        c += is_code && value ? 2 : 0;
    }
    if (name)
        *end = 0;
    return name;
}

/* The part of a buffer that an image is. */
static bool read_view(nqm_gltf_document *d, const json_t *image, nqm_map_image *result) {
    size_t view_i, buffer_i, at, n, n_buffer;
    const json_t *view = element_of(d, image, "bufferView", VIEWS, &view_i);
    const json_t *buffer = view ? element_of(d, view, "buffer", BUFFERS, &buffer_i) : NULL;
    if (!buffer || !read_size(d, view, "byteOffset", 0, &at) || !read_size(d, view, "byteLength", SIZE_MAX, &n) ||
        !read_size(d, buffer, "byteLength", SIZE_MAX, &n_buffer))
        return false;
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    n_buffer = uri ? n_buffer : nqm_smaller(n_buffer, buffer_i == 0 ? d->n_bin : 0);
    if (n == 0 || at > n_buffer || n > n_buffer - at)
        return fail(d, "bufferViews[%zu]: %zu bytes at byte %zu are not in buffers[%zu], which has %zu bytes", view_i,
                    n, at, buffer_i, n_buffer);
    if (uri && is_data(uri))
        return decode_data(d, uri, at, n, result);
    result->n_bytes = n;
    result->at = uri ? at : d->bin_at + at;
    char *name = uri ? decode_name(d, uri) : NULL;
    result->path = name ? nqm_path_beside(d->path, name) : uri ? NULL : nqm_strdup(d->path);
    nqm_free(name);
    return result->path != NULL;
}

/* The image of a texture, of which formats that are not read have a fallback in some files. */
static const json_t *find_image(nqm_gltf_document *d, const json_t *texture, size_t *i) {
    static const char *const formats[][2] = {
        {"KHR_texture_basisu", "KTX2"}, {"EXT_texture_avif", "AVIF"}, {"MSFT_texture_dds", "DDS"}};
    const json_t *extensions = json_object_get(texture, "extensions");
    const json_t *webp = json_object_get(extensions, "EXT_texture_webp");
    if (webp || json_object_get(texture, "source"))
        return element_of(d, webp ? webp : texture, "source", IMAGES, i);
    fail(d, "the texture has no image ('source')");
    for (size_t f = 0; f < sizeof formats / sizeof *formats; ++f)
        if (json_object_get(extensions, formats[f][0]))
            fail(d, "the image is %s (%s), which is not read; convert it to PNG", formats[f][1], formats[f][0]);
    return NULL;
}

static bool add_image(nqm_gltf_document *d, const json_t *texture, const char *space, nqm_textured *t,
                      size_t *image_ret) {
    size_t i;
    const json_t *image = find_image(d, texture, &i);
    const char *uri = json_string_value(json_object_get(image, "uri"));
    char text[512];
    if (!image)
        return false;
    if (uri && !is_data(uri)) {
        char *name = decode_name(d, uri);
        const bool is_added = name && nqm_graph_add_file(t, d->path, name, space, image_ret);
        nqm_free(name);
        return is_added;
    }
    nqm_map_image result = {.path = NULL};
    snprintf(text, sizeof text, "images[%zu] of %.450s", i, d->path);
    snprintf(result.space, sizeof result.space, "%s", space);
    if (uri ? !decode_data(d, uri, 0, SIZE_MAX, &result) : !read_view(d, image, &result))
        return false;
    result.name = nqm_strdup(text);
    return nqm_graph_add_image(t, result, image_ret);
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

static bool read_wrap(nqm_gltf_document *d, const json_t *texture, uint8_t wrap[2]) {
    static const char *const keys[] = {"wrapS", "wrapT"};
    enum { REPEAT = 10497, CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648 };
    size_t i, mode;
    if (!json_object_get(texture, "sampler"))
        return true;
    const json_t *sampler = element_of(d, texture, "sampler", SAMPLERS, &i);
    d->has_filter |= json_object_get(sampler, "magFilter") || json_object_get(sampler, "minFilter");
    for (size_t k = 0; k < 2; ++k) {
        if (!sampler || !read_size(d, sampler, keys[k], REPEAT, &mode))
            return false;
        if (mode != REPEAT && mode != CLAMP_TO_EDGE && mode != MIRRORED_REPEAT)
            return fail(d, "samplers[%zu].%s is %zu; 10497, 33071 and 33648 are valid", i, keys[k], mode);
        wrap[k] = mode == REPEAT ? NQM_MAP_REPEAT : mode == CLAMP_TO_EDGE ? NQM_MAP_CLAMP : NQM_MAP_MIRROR;
    }
    return true;
}

/* offset + rotation (scale uv). The rotation is that of the example in the specification, in which v points downwards. */
static bool read_transform(nqm_gltf_document *d, const json_t *transform, double uv[2][3]) {
    static const char *const keys[] = {"offset", "scale"};
    const json_t *rotation = json_object_get(transform, "rotation");
    double v[2][2] = {{0, 0}, {1, 1}};
    for (size_t i = 0; i < 4; ++i) {
        const json_t *list = json_object_get(transform, keys[i / 2]), *number = json_array_get(list, i % 2);
        if (list && (json_array_size(list) != 2 || !json_is_number(number)))
            return fail(d, "KHR_texture_transform.%s needs an array of 2 numbers", keys[i / 2]);
        v[i / 2][i % 2] = list ? json_number_value(number) : v[i / 2][i % 2];
    }
    if (rotation && !json_is_number(rotation))
        return fail(d, "KHR_texture_transform.rotation needs a number");
    const double c = cos(json_number_value(rotation)), s = sin(json_number_value(rotation));
    const double rows[2][3] = {{c * v[1][0], s * v[1][1], v[0][0]}, {-s * v[1][0], c * v[1][1], v[0][1]}};
    memcpy(uv, rows, sizeof rows);
    return true;
}

/* The node of an image with n channels. */
static bool read_texture(nqm_gltf_document *d, const json_t *info, size_t n, const char *space, nqm_textured *t,
                         uint16_t *node) {
    const json_t *transform = json_object_get(json_object_get(info, "extensions"), "KHR_texture_transform");
    double uv[2][3] = {{1, 0, 0}, {0, 1, 0}};
    uint8_t wrap[2] = {NQM_MAP_REPEAT, NQM_MAP_REPEAT};
    size_t i, image, set;
    const json_t *texture = element_of(d, info, "index", TEXTURES, &i);
    const bool has_set = json_object_get(transform, "texCoord") != NULL;
    if (!texture || !read_size(d, has_set ? transform : info, "texCoord", 0, &set) ||
        !read_transform(d, transform, uv) || !read_wrap(d, texture, wrap) || !add_image(d, texture, space, t, &image))
        return false;
    d->has_other_set |= set > 0;
    *node = nqm_graph_image_at(t, image, n, uv, wrap);
    return true;
}

/* The factor of a key: that of the file, or the default. false: 0, so that the texture has no effect. */
static bool find_factor(const nqm_values *values, const char *key, double v[3]) {
    memcpy(v, values->v[nqm_schema_key_named(values->schema, key, strlen(key))], 3 * sizeof *v);
    return v[0] != 0 || v[1] != 0 || v[2] != 0;
}

/* A constant out of the range is refused when the spec is opened; one times a texture would be moved into the range. */
static bool check_factor(nqm_gltf_document *d, const char *key, const double v[3]) {
    const bool is_bounded = strcmp(key, "specular_color") != 0;
    for (size_t c = 0; c < 3; ++c)
        if (!(v[c] >= 0 && (v[c] <= 1 || !is_bounded)))
            return fail(d, "its factor, %s = %g, is outside of 0 to 1", key, v[c]);
    return true;
}

const nqm_gltf_use nqm_gltf_uses[NQM_GLTF_N_USES] = {
    {"baseColorTexture", "base_color", "srgb_texture", 3, SIZE_MAX},
    {"metallicRoughnessTexture", "metallic", "", 3, 2},
    {"metallicRoughnessTexture", "roughness", "", 3, 1},
    {"specularTexture", "specular", "", 4, 3},
    {"specularColorTexture", "specular_color", "srgb_texture", 3, SIZE_MAX},
    {"clearcoatTexture", "clearcoat", "", 3, 0},
    {"clearcoatRoughnessTexture", "clearcoat_roughness", "", 3, 1},
    {"sheenColorTexture", "sheen_color", "srgb_texture", 3, SIZE_MAX},
    {"sheenRoughnessTexture", "sheen_roughness", "", 4, 3},
    {"anisotropyTexture", "anisotropy_strength", "", 3, 2},
    {"iridescenceTexture", "iridescence", "", 3, 0}};

/* Of specular-glossiness, which is read only. */
static const nqm_gltf_use glossy_uses[] = {
    {"diffuseTexture", "base_color", "srgb_texture", 3, SIZE_MAX},
    {"specularGlossinessTexture", "specular_color", "srgb_texture", 3, SIZE_MAX}};

/* Alpha times the factor is 1 - roughness. */
static bool add_glossiness(nqm_gltf_document *d, const json_t *info, const nqm_values *shading, nqm_textured *t) {
    double roughness[3];
    uint16_t image, node;
    find_factor(shading, "roughness", roughness);
    if (!check_factor(d, "roughness", roughness))
        return false;
    if (!read_texture(d, info, 4, "", t, &image))
        return false;
    node = nqm_graph_with(t, NQM_MAP_MULTIPLY, 1, nqm_graph_channel(t, image, 3), 1 - roughness[0]);
    node = nqm_graph_compute(t, NQM_MAP_SUBTRACT, 1, nqm_graph_number(t, 1), node, 0);
    nqm_graph_output_set(t, "roughness", node);
    return node != NQM_NO_NODE;
}

/* Red and green are the direction of the anisotropy from -1 to 1, as a normal has them, which anisotropyRotation turns. */
static uint16_t turn(nqm_textured *t, uint16_t image, const nqm_values *shading) {
    double rotation[3];
    const uint16_t direction = nqm_graph_with(t, NQM_MAP_NORMAL, 3, image, 1);
    const uint16_t x = nqm_graph_channel(t, direction, 0), y = nqm_graph_channel(t, direction, 1);
    find_factor(shading, "anisotropy_rotation", rotation);
    return nqm_graph_with(t, NQM_MAP_ADD, 1, nqm_graph_compute(t, NQM_MAP_ANGLE, 1, y, x, 0), rotation[0]);
}

static bool add_normal(nqm_gltf_document *d, const json_t *info, nqm_textured *t) {
    const json_t *number = json_object_get(info, "scale");
    const double scale = number ? json_number_value(number) : 1;
    uint16_t image;
    if (number && !json_is_number(number))
        return fail(d, "'scale' needs a number");
    if (!read_texture(d, info, 3, "", t, &image))
        return false;
    t->normal = nqm_graph_with(t, NQM_MAP_NORMAL, 3, image, scale);
    return t->normal != NQM_NO_NODE;
}

/* Green is between both thicknesses. */
static bool add_thickness(nqm_gltf_document *d, const json_t *info, const nqm_values *shading, nqm_textured *t) {
    static const char key[] = "iridescence_thickness";
    double maximum[3];
    uint16_t image;
    find_factor(shading, key, maximum);
    if (!read_texture(d, info, 3, "", t, &image))
        return false;
    uint16_t node = nqm_graph_channel(t, image, 1);
    node = nqm_graph_with(t, NQM_MAP_MULTIPLY, 1, node, maximum[0] - d->film_minimum);
    node = nqm_graph_with(t, NQM_MAP_ADD, 1, node, d->film_minimum);
    nqm_graph_output_set(t, key, node);
    return node != NQM_NO_NODE;
}

bool nqm_gltf_add_texture(nqm_gltf_document *d, const char *name, const json_t *info, nqm_reading *reading) {
    const nqm_values *shading = &reading->values;
    nqm_textured *t = reading->textured;
    size_t index;
    bool is_used = strcmp(name, "specularGlossinessTexture") == 0;
    fail(d, "%s", no_memory);
    if (!read_size(d, info, "index", SIZE_MAX, &index))
        return false;
    if (strcmp(name, "normalTexture") == 0)
        return add_normal(d, info, t);
    if (strcmp(name, "iridescenceThicknessTexture") == 0)
        return add_thickness(d, info, shading, t);
    if (is_used && !add_glossiness(d, info, shading, t))
        return false;
    for (size_t i = 0; i < NQM_GLTF_N_USES + 2; ++i) {
        const nqm_gltf_use *use = i < NQM_GLTF_N_USES ? &nqm_gltf_uses[i] : &glossy_uses[i - NQM_GLTF_N_USES];
        const size_t n = use->channel == SIZE_MAX ? 3 : 1;
        double factor[3];
        uint16_t image, node;
        if (strcmp(use->texture, name) != 0 || !find_factor(shading, use->key, factor))
            continue;
        is_used = true;
        if (!check_factor(d, use->key, factor))
            return false;
        if (!read_texture(d, info, use->n, use->space, t, &image))
            return false;
        node = n == 3 ? image : nqm_graph_channel(t, image, use->channel);
        node = nqm_graph_compute(t, NQM_MAP_MULTIPLY, n, node, nqm_graph_value(t, n, factor), 0);
        nqm_graph_output_set(t, use->key, node);
        if (strcmp(name, "anisotropyTexture") == 0)
            nqm_graph_output_set(t, "anisotropy_rotation", node = turn(t, image, shading));
        if (node == NQM_NO_NODE)
            return false;
    }
    return is_used || nqm_reading_unused(reading, name);
}
