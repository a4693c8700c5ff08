/* SPDX-License-Identifier: MIT
 *
 * USD as text (.usda; openusd.org, "USDA File Format Specification" and UsdShade): materials with a UsdPreviewSurface or the shaders of
 * MaterialX ("ND_standard_surface_surfaceshader"). The prims become a document of MaterialX, whose reader does the rest, textures
 * included. One layer is read, without composition. Binary layers (crate, .usdc) and packages (.usdz) are recognised, to say
 * what to do with them.
 */
#include "io/xml.h"
#include "material/materialx.h"

#include <ctype.h>

enum { MAX_DEPTH = 60, MAX_TEXT = 1024, MAX_HOPS = 64 };

typedef nqm_xml_element element;

/* ---- tokens -------------------------------------------------------------------------------------------------------- */

typedef struct scanner {
    const char *path, *text;
    size_t n, at, token_at;
    char kind; /* of the token: 'w' word or number, 's' string, '@' asset, '<' path, punctuation, 0 at the end */
    char token[MAX_TEXT]; /* without its quotes; cut if it is longer */
    nqm_xml prims; /* <Shader name="tex"> with properties <color3f name="inputs:scale" value="..."> and child prims */
    size_t max_elements;
    nqm_error *err;
} scanner;

static nqm_status fail(const scanner *s, const char *what) {
    return nqm_fail(s->err, NQM_ERR_FORMAT, (int64_t)s->token_at, "%s: %s (byte %zu)", s->path, what, s->token_at);
}

static bool begins(const scanner *s, const char *text) {
    return s->n - s->at >= strlen(text) && memcmp(s->text + s->at, text, strlen(text)) == 0;
}

static void skip_blanks(scanner *s) {
    while (s->at < s->n) {
        if (begins(s, "/*")) {
            while (s->at < s->n && !begins(s, "*/"))
                ++s->at;
            s->at = nqm_smaller(s->at + 2, s->n);
        } else if (s->text[s->at] == '#' || begins(s, "//")) {
            while (s->at < s->n && s->text[s->at] != '\n')
                ++s->at;
        } else if (isspace((unsigned char)s->text[s->at]))
            ++s->at;
        else
            break;
    }
}

/* Text between quotes that have been read up to its first character. */
static nqm_status read_quoted(scanner *s, const char *quote) {
    size_t n = 0;
    for (; s->at < s->n && !begins(s, quote); ++s->at) {
        const bool is_escape = *quote != '@' && s->text[s->at] == '\\' && s->at + 1 < s->n;
        s->at += is_escape;
        if (n + 1 < sizeof s->token)
            s->token[n++] = s->text[s->at];
    }
    s->token[n] = 0;
    if (s->at >= s->n)
        return fail(s, "a string, asset or path without its end");
    s->at += strlen(quote);
    return memchr(s->token, 0, n) ? fail(s, "a byte 0 inside of a string") : NQM_OK;
}

static bool is_word(char c) {
    return isalnum((unsigned char)c) || (c && strchr("_:.+-|", c)) || (unsigned char)c >= 0x80;
}

static nqm_status next(scanner *s) {
    static const char *const quotes[] = {"\"\"\"", "'''", "\"", "'", "@@@", "@", "<"};
    size_t n = 0;
    skip_blanks(s);
    s->token_at = s->at;
    s->token[0] = 0;
    s->kind = 0;
    if (s->at == s->n)
        return NQM_OK;
    for (size_t i = 0; i < sizeof quotes / sizeof *quotes; ++i)
        if (begins(s, quotes[i])) {
            s->kind = *quotes[i] == '\'' || *quotes[i] == '"' ? 's' : *quotes[i];
            s->at += strlen(quotes[i]);
            return read_quoted(s, *quotes[i] == '<' ? ">" : quotes[i]);
        }
    s->kind = is_word(s->text[s->at]) ? 'w' : s->text[s->at++];
    if (s->kind == 0)
        return fail(s, "a byte 0");
    for (; s->kind == 'w' && s->at < s->n && is_word(s->text[s->at]); ++s->at)
        if (n + 1 < sizeof s->token)
            s->token[n++] = s->text[s->at];
    s->token[n] = 0;
    return NQM_OK;
}

static bool is_token(const scanner *s, const char *words) {
    return s->kind == 'w' && nqm_contains_word(words, s->token, false);
}

/* Go to the end of the bracket that is the token. text: what is inside, "" if that is long. Of metadata that `words` name, found
 * receives the last value that is a string, or else the name. */
static nqm_status skip_brackets(scanner *s, char *text, const char *words, char *found) {
    const size_t first = s->at;
    bool is_named = false;
    for (size_t depth = 1; depth;) {
        nqm_status status = next(s);
        if (status != NQM_OK)
            return status;
        if (s->kind == 0)
            return fail(s, "a bracket without its end");
        depth += strchr("([{", s->kind) != NULL;
        depth -= strchr(")]}", s->kind) != NULL;
        is_named = s->kind == 'w' ? words && nqm_contains_word(words, s->token, false) : is_named;
        if (is_named && (s->kind == 'w' || s->kind == 's'))
            strcpy(found, s->token);
    }
    const size_t n = s->token_at - first;
    if (text && n < MAX_TEXT) {
        memcpy(text, s->text + first, n);
        text[n] = 0;
    }
    return NQM_OK;
}

/* Go on to the next token, and if that is a bracket of metadata, beyond it. */
static nqm_status next_beyond(scanner *s, const char *words, char *found) {
    nqm_status status = next(s);
    if (status == NQM_OK && s->kind == '(')
        status = skip_brackets(s, NULL, words, found);
    else
        return status;
    return status == NQM_OK ? next(s) : status;
}

static bool is_output(const char *name) {
    return strncmp(name, "outputs:", 8) == 0;
}

/* ---- prims --------------------------------------------------------------------------------------------------------- */

/* NULL: the file has too many, or there is no memory; *status says so. */
static element *append(scanner *s, element *parent, const char *name, const char *const *attributes, size_t at,
                       nqm_status *status) {
    element *e = NULL;
    if (s->prims.n_elements == s->max_elements)
        *status = nqm_fail(s->err, NQM_ERR_LIMIT, (int64_t)at, "%s: more than %zu prims and inputs (byte %zu)", s->path,
                           s->max_elements, at);
    else if (!(e = nqm_xml_append(&s->prims, parent, name, attributes, (int64_t)at)))
        *status = nqm_fail_nomem(s->err, sizeof *e);
    return e;
}

/* "color3f inputs:a.connect = </M/t.outputs:rgb> (metadata)", of which the type is the token; stops at the token after it. */
static nqm_status read_property(scanner *s, element *prim, size_t at) {
    static const char *const forms[] = {"value", "connect", "timeSamples"};
    char type[MAX_TEXT], name[MAX_TEXT] = "", value[MAX_TEXT] = "", space[MAX_TEXT] = "";
    strcpy(type, s->token);
    nqm_status status = next(s);
    while (status == NQM_OK && s->kind && strchr("[]", s->kind))
        status = next(s);
    if (status == NQM_OK && s->kind != 'w')
        return fail(s, "a property without its name");
    if (status == NQM_OK)
        strcpy(name, s->token);
    if (status == NQM_OK && (status = next_beyond(s, "colorSpace", space)) == NQM_OK && s->kind == '=') {
        status = next(s);
        strcpy(value, s->token);
        if (status == NQM_OK && s->kind && strchr("([{", s->kind))
            status = skip_brackets(s, value, NULL, NULL);
        if (status == NQM_OK)
            status = next_beyond(s, "colorSpace", space);
    }
    char *dot = strrchr(name, '.');
    size_t form = 0;
    for (size_t i = 1; dot && i < 3; ++i)
        form = strcmp(dot + 1, forms[i]) == 0 ? i : form;
    if (dot)
        *dot = 0;
    const bool is_input = strncmp(name, "inputs:", 7) == 0, is_other = is_output(name) || strcmp(name, "info:id") == 0;
    const char *const attributes[] = {"name", name, forms[form], value, "space", space, NULL};
    if (status == NQM_OK && ((is_input && *value) || is_other) &&
        nqm_contains_word("Material Shader NodeGraph", prim->name, false))
        append(s, prim, type, attributes, at, &status);
    return status;
}

static nqm_status read_prim(scanner *s, element *parent, size_t depth);

/* The statements between braces; stops at the last brace. The prims of variants are not read. */
static nqm_status read_body(scanner *s, element *prim, size_t depth) {
    nqm_status status = next(s);
    while (status == NQM_OK && s->kind != '}') {
        const size_t at = s->token_at;
        while (status == NQM_OK && is_token(s, "custom uniform varying prepend append add delete"))
            status = next(s);
        if (status != NQM_OK)
            break;
        if (is_token(s, "def over class"))
            status = read_prim(s, prim, depth);
        else if (is_token(s, "variantSet"))
            while ((status = next(s)) == NQM_OK && s->kind && s->kind != '{') {
            }
        else if (s->kind == 'w') {
            status = read_property(s, prim, at);
            continue;
        } else if (s->kind != ';')
            return fail(s, "neither a prim nor a property");
        if (status == NQM_OK && s->kind == '{')
            status = skip_brackets(s, NULL, NULL, NULL);
        if (status == NQM_OK)
            status = next(s);
    }
    return status;
}

/* "def Shader "name" (metadata) { ... }", of which the first word is the token; stops at its last brace. */
static nqm_status read_prim(scanner *s, element *parent, size_t depth) {
    const bool is_def = is_token(s, "def");
    const size_t at = s->token_at;
    char type[MAX_TEXT] = "prim", name[MAX_TEXT] = "", composed[MAX_TEXT] = "";
    nqm_status status = next(s);
    if (status == NQM_OK && s->kind == 'w') {
        strcpy(type, s->token);
        status = next(s);
    }
    if (status == NQM_OK && s->kind != 's')
        return fail(s, "a prim without its name");
    if (status == NQM_OK)
        strcpy(name, s->token);
    if (status == NQM_OK)
        status = next_beyond(s, "references payload inherits specializes variants", composed);
    if (status == NQM_OK && s->kind != '{')
        return fail(s, "a prim without its body");
    if (status == NQM_OK && depth == MAX_DEPTH)
        return nqm_fail(s->err, NQM_ERR_LIMIT, (int64_t)at, "%s: prims are nested more than %d deep (byte %zu)",
                        s->path, MAX_DEPTH, at);
    const char *const attributes[] = {"name", name, "composed", composed, NULL};
    element *prim = status == NQM_OK ? append(s, parent, is_def ? type : "over", attributes, at, &status) : NULL;
    return prim ? read_body(s, prim, depth + 1) : status;
}

static nqm_status read_layer(scanner *s) {
    nqm_status status = NQM_OK;
    element *root = append(s, NULL, "layer", (const char *const[]){NULL}, 0, &status);
    while (status == NQM_OK && (status = next(s)) == NQM_OK && s->kind)
        if (s->kind == '(')
            status = skip_brackets(s, NULL, NULL, NULL);
        else if (is_token(s, "def over class"))
            status = read_prim(s, root, 0);
    return status;
}

/* ---- the document of MaterialX --------------------------------------------------------------------------------------- */

typedef struct writer {
    const scanner *s;
    nqm_index names; /* of the prims */
    nqm_xml document;
    nqm_materials *materials;
    bool has_memory;
} writer;

/* The prim or property of "/Looks/M/tex.outputs:rgb"; NULL: there is none. */
static const element *find(const writer *w, const char *path) {
    const element *e = w->s->prims.root;
    const char *dot = strchr(path, '.');
    char name[MAX_TEXT];
    while (e && *path == '/') {
        const size_t n = strcspn(++path, "/.");
        snprintf(name, sizeof name, "%.*s", (int)nqm_smaller(n, sizeof name - 1), path);
        e = nqm_xml_find(&w->names, e, NULL, name);
        path += n;
    }
    return e && dot ? nqm_xml_find(&w->names, e, NULL, dot + 1) : e;
}

/* The path of a prim. */
static void path_of(const writer *w, const element *prim, char path[MAX_TEXT]) {
    const element *chain[MAX_DEPTH + 2];
    size_t n = 0, used = 0;
    for (; prim != w->s->prims.root; prim = prim->parent)
        chain[n++] = prim;
    *path = 0;
    while (n-- && used < MAX_TEXT)
        used += (size_t)snprintf(path + used, MAX_TEXT - used, "/%s", nqm_xml_get(chain[n], "name"));
}

/* Whether it is the output of a shader. */
static bool is_of_shader(const element *property) {
    return strcmp(property->parent->name, "Shader") == 0 && is_output(nqm_xml_get(property, "name"));
}

/* From a property through the interfaces of materials and node graphs to one with a value, or to the output of a shader. */
static const element *follow(const writer *w, const element *property) {
    for (int hops = 0; hops < MAX_HOPS && nqm_xml_get(property, "connect"); ++hops) {
        const element *to = find(w, nqm_xml_get(property, "connect"));
        if (!to || is_of_shader(to))
            return to;
        property = to;
    }
    return property;
}

static const char *type_of(const char *usd) {
    static const char *const types[][2] = {{"float half double", "float"},
                                           {"int", "integer"},
                                           {"bool", "boolean"},
                                           {"string token", "string"},
                                           {"asset", "filename"},
                                           {"float2 half2 double2 texCoord2f texCoord2h texCoord2d", "vector2"},
                                           {"color3f color3h color3d", "color3"},
                                           {"float3 half3 double3 vector3f normal3f point3f", "vector3"},
                                           {"color4f color4h color4d", "color4"},
                                           {"float4 half4 double4", "vector4"}};
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
        if (nqm_contains_word(types[i][0], usd, false))
            return types[i][1];
    return usd;
}

/* The space of an image: of its metadata; UsdUVTexture takes pictures of 8 bits as sRGB unless it says something else. */
static const char *space_of(const char *node, const element *property, const char *value) {
    const char *space = nqm_xml_get(property, "space"), *dot = strrchr(value, '.');
    if (strcmp(space, "sRGB") == 0)
        return "srgb_texture";
    if (*space)
        return nqm_contains_word("raw Raw auto", space, false) ? "none" : space;
    const bool is_float = dot && nqm_contains_word(".exr .hdr", dot, true);
    return strcmp(node, "UsdUVTexture") == 0 && !is_float ? "srgb_texture" : "none";
}

static void add_input(writer *w, element *shader, const element *property) {
    const element *to = follow(w, property);
    const char *name = nqm_xml_get(property, "name") + strlen("inputs:"), *type = type_of(property->name);
    const bool is_connected = !to || is_of_shader(to);
    const char *value = is_connected ? NULL : nqm_xml_get(to, "value"), *output = "";
    char path[MAX_TEXT] = "";
    if (to && is_connected) {
        path_of(w, to->parent, path);
        output = nqm_xml_get(to, "name") + strlen("outputs:");
    } else if (!is_connected && !value) {
        type = "value that varies with time"; /* which the reader refuses by this name */
        value = "";
    }
    const char *space = !value || strcmp(type, "filename") != 0 ? NULL : space_of(shader->name, property, value);
    const char *const attributes[] = {"name",
                                      name,
                                      "type",
                                      type,
                                      value ? "value" : "nodename",
                                      value ? value : path,
                                      value ? "colorspace" : "output",
                                      value                        ? (space ? space : "lin_rec709")
                                      : strcmp(output, "out") == 0 ? ""
                                                                   : output,
                                      NULL};
    w->has_memory &= nqm_xml_append(&w->document, shader, "input", attributes, property->byte_offset) != NULL;
}

/* "image" of "ND_image_color3", "standard_surface" of "ND_standard_surface_surfaceshader_100". */
static void node_of(const char *id, char node[MAX_TEXT]) {
    static const char *const endings[] = {"float",         "color3",  "color4",  "vector2", "vector3",
                                          "vector4",       "integer", "boolean", "string",  "filename",
                                          "surfaceshader", "1",       "2",       "3"};
    snprintf(node, MAX_TEXT, "%s", strncmp(id, "ND_", 3) == 0 ? id + 3 : id);
    for (char *last; (last = strrchr(node, '_'));) {
        size_t i = 0;
        while (i < sizeof endings / sizeof *endings && strncmp(last + 1, endings[i], strlen(endings[i])) != 0)
            ++i;
        if (i == sizeof endings / sizeof *endings)
            return;
        *last = 0;
    }
}

static void add_shader(writer *w, const element *prim) {
    const element *id = nqm_xml_find(&w->names, prim, NULL, "info:id");
    const char *type = NULL, *definition = id && nqm_xml_get(id, "value") ? nqm_xml_get(id, "value") : "shader";
    char path[MAX_TEXT], node[MAX_TEXT];
    path_of(w, prim, path);
    node_of(definition, node);
    for (const element *e = prim->first; e; e = e->next)
        if (is_output(nqm_xml_get(e, "name")))
            type = type ? "multioutput" : strcmp(e->name, "token") == 0 ? "surfaceshader" : type_of(e->name);
    const bool is_typed = type && strcmp(node, "UsdUVTexture") != 0;
    const char *const attributes[] = {"name", path, "nodedef", definition, is_typed ? "type" : NULL, type, NULL};
    element *shader = nqm_xml_append(&w->document, w->document.root, node, attributes, prim->byte_offset);
    w->has_memory &= shader != NULL;
    for (const element *e = prim->first; e && w->has_memory; e = e->next)
        if (strncmp(nqm_xml_get(e, "name"), "inputs:", 7) == 0)
            add_input(w, shader, e);
}

/* The surface of MaterialX comes before that for previews. */
static nqm_status add_material(writer *w, const element *prim) {
    static const char *const outputs[][2] = {{"outputs:mtlx:surface", "surfaceshader"},
                                             {"outputs:surface", "surfaceshader"},
                                             {"outputs:displacement", "displacementshader"}};
    const char *name = nqm_xml_get(prim, "name"), *composed = nqm_xml_get(prim, "composed");
    char path[MAX_TEXT], refusal[200];
    bool has_surface = false;
    snprintf(refusal, sizeof refusal,
             "it is composed of other prims or layers (%.40s): write one layer by 'usdcat --flatten'", composed);
    const nqm_material_info info = {
        .name = name, .surface = prim->name, .refusal = refusal, .byte_offset = prim->byte_offset};
    if (*composed)
        return nqm_materials_add(w->materials, &info, w->s->err);
    element *material = nqm_xml_append(&w->document, w->document.root, "surfacematerial",
                                       (const char *const[]){"name", name, NULL}, prim->byte_offset);
    w->has_memory &= material != NULL;
    for (size_t i = 0; i < 3 && material; ++i) {
        const element *output = nqm_xml_find(&w->names, prim, NULL, outputs[i][0]);
        const char *connected = output ? nqm_xml_get(output, "connect") : NULL;
        if (!connected || (i == 1 && has_surface))
            continue;
        has_surface = true;
        const element *to = follow(w, output);
        snprintf(path, sizeof path, "%s", connected);
        if (to)
            path_of(w, to->parent, path);
        const char *const attributes[] = {"name", outputs[i][1], "nodename", path, NULL};
        w->has_memory &= nqm_xml_append(&w->document, material, "input", attributes, output->byte_offset) != NULL;
    }
    return NQM_OK;
}

/* At most MAX_DEPTH calls deep. */
static nqm_status add_prims(writer *w, const element *prim) {
    nqm_status status = NQM_OK;
    if (strcmp(prim->name, "Shader") == 0)
        add_shader(w, prim);
    if (strcmp(prim->name, "Material") == 0)
        status = add_material(w, prim);
    for (const element *e = prim->first; e && status == NQM_OK && w->has_memory; e = e->next)
        status = add_prims(w, e);
    return status;
}

static nqm_status translate(const scanner *s, nqm_materials *materials) {
    writer w = {.s = s, .materials = materials};
    nqm_status status = nqm_xml_names_create(&s->prims, &w.names, s->err);
    if (status == NQM_OK) {
        w.has_memory = nqm_xml_append(&w.document, NULL, "materialx", (const char *const[]){NULL}, 0) != NULL;
        status = w.has_memory ? add_prims(&w, s->prims.root) : NQM_OK;
    }
    if (status == NQM_OK && !w.has_memory)
        status = nqm_fail_nomem(s->err, s->n);
    if (status == NQM_OK)
        status = nqm_mtlx_read_document(&w.document, s->path, materials, s->err);
    nqm_index_free(&w.names);
    nqm_xml_free(&w.document);
    return status;
}

/* ---- a file -------------------------------------------------------------------------------------------------------- */

/* The first file of a package is a layer, and its name is at byte 30. */
static bool is_package(const nqm_map *map) {
    const char *text = (const char *)map->data;
    if (map->n_bytes < 30 || memcmp(text, "PK\3\4", 4) != 0)
        return false;
    const size_t n = (size_t)map->data[26] | (size_t)map->data[27] << 8;
    return n > 5 && n <= map->n_bytes - 30 && memcmp(text + 30 + n - 5, ".usd", 4) == 0;
}

static bool is_crate(const nqm_map *map) {
    return map->n_bytes >= 8 && memcmp(map->data, "PXR-USDC", 8) == 0;
}

static bool probe(const nqm_map *map) {
    return (map->n_bytes >= 6 && memcmp(map->data, "#usda ", 6) == 0) || is_crate(map) || is_package(map);
}

static nqm_status read_usda(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    scanner s = {.path = map->path, .text = (const char *)map->data, .n = map->n_bytes, .err = err};
    s.max_elements = NQM_XML_FREE_ELEMENTS + s.n / NQM_XML_BYTES_PER_ELEMENT;
    if (is_crate(map))
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: a binary layer of USD (crate, byte 0); write it as text: usdcat IN.usdc -o OUT.usda",
                        s.path);
    if (is_package(map))
        return nqm_fail(
            err, NQM_ERR_FORMAT, 0,
            "%s: a package of USD (byte 0); unpack it by unzip, and write its layer as text: usdcat IN.usdc -o "
            "OUT.usda",
            s.path);
    if (s.n > NQM_XML_MAX_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %zu bytes of USD (byte 0); at most %d are read", s.path, s.n,
                        NQM_XML_MAX_BYTES);
    nqm_status status = read_layer(&s);
    if (status == NQM_OK)
        status = translate(&s, materials);
    if (status == NQM_OK && nqm_materials_count(materials) == 0)
        status =
            nqm_fail(err, NQM_ERR_FORMAT, 0,
                     "%s: no Material in this layer (byte 0); materials of other layers that it names are not read: "
                     "usdcat --flatten IN -o OUT.usda",
                     s.path);
    nqm_xml_free(&s.prims);
    return status;
}

const nqm_material_format nqm_usd_format = {
    .name = "USD (.usda)", .extensions = "", .models = "", .probe = probe, .read = read_usda};
