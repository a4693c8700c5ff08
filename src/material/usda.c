/* SPDX-License-Identifier: MIT
 *
 * USD as text (.usda; openusd.org, "USDA File Format Specification" and UsdShade): materials with a UsdPreviewSurface
 * or the shaders of MaterialX ("ND_standard_surface_surfaceshader"). The prims become a document of MaterialX, whose
 * reader does the rest, textures included. One layer is read, without composition. Binary layers (crate, .usdc) and
 * packages (.usdz) are recognised, to say what to do with them.
 */
#include "io/xml.h"
#include "material/materialx.h"

#include <ctype.h>

enum { MAX_DEPTH = 60, MAX_TEXT = 1024, MAX_PATH = 256, MAX_HOPS = 64 };

typedef nqm_xml_element element;

/* ---- tokens -------------------------------------------------------------------------------------------------------- */

/* After a failure, only the end of the file follows. */
typedef struct scanner {
    const char *path, *text;
    size_t n, at, token_at;
    char kind; /* of the token: 'w' word or number, 's' string, '@' asset, '<' path, punctuation, 0 at the end */
    char token[MAX_TEXT]; /* without its quotes; cut if it is longer */
    nqm_xml prims; /* <Shader name="tex"> with properties <color3f name="inputs:scale" value="..."> and child prims */
    size_t max_elements;
    nqm_status status;
    nqm_error *err;
} scanner;

static void fail(scanner *s, const char *what) {
    if (s->status == NQM_OK)
        s->status =
            nqm_fail(s->err, NQM_ERR_FORMAT, (int64_t)s->token_at, "%s: %s (byte %zu)", s->path, what, s->token_at);
    s->at = s->n;
    s->kind = 0;
}

static bool begins(const scanner *s, const char *text) {
    return s->n - s->at >= strlen(text) && memcmp(s->text + s->at, text, strlen(text)) == 0;
}

static void skip_blanks(scanner *s) {
    while (s->at < s->n && (isspace((unsigned char)s->text[s->at]) || s->text[s->at] == '#'))
        if (s->text[s->at++] == '#')
            while (s->at < s->n && s->text[s->at] != '\n')
                ++s->at;
}

/* Text between quotes, of which the first has been read. */
static void read_quoted(scanner *s, const char *quote) {
    size_t n = 0;
    for (; s->at < s->n && !begins(s, quote); ++s->at) {
        s->at += *quote != '@' && s->text[s->at] == '\\' && s->at + 1 < s->n;
        if (n + 1 < sizeof s->token)
            s->token[n++] = s->text[s->at];
    }
    s->token[n] = 0;
    if (s->at >= s->n || memchr(s->token, 0, n))
        fail(s, "a string, asset or path without its end, or with a byte 0");
    else
        s->at += strlen(quote);
}

static bool is_word(char c) {
    return isalnum((unsigned char)c) || (c && strchr("_:.+-|", c)) || (unsigned char)c >= 0x80;
}

static void next(scanner *s) {
    static const char *const quotes[] = {"\"\"\"", "'''", "\"", "'", "@@@", "@", "<"};
    size_t n = 0;
    skip_blanks(s);
    s->token_at = s->at;
    s->token[0] = s->kind = 0;
    for (size_t i = 0; i < sizeof quotes / sizeof *quotes; ++i)
        if (begins(s, quotes[i])) {
            s->kind = *quotes[i] == '\'' || *quotes[i] == '"' ? 's' : *quotes[i];
            s->at += strlen(quotes[i]);
            read_quoted(s, *quotes[i] == '<' ? ">" : quotes[i]);
            return;
        }
    if (s->at == s->n)
        return;
    s->kind = is_word(s->text[s->at]) ? 'w' : s->text[s->at++];
    if (s->kind == 0)
        fail(s, "a byte 0");
    for (; s->kind == 'w' && s->at < s->n && is_word(s->text[s->at]); ++s->at)
        if (n + 1 < sizeof s->token)
            s->token[n++] = s->text[s->at];
    s->token[n] = 0;
}

static bool is_token(const scanner *s, const char *words) {
    return s->kind == 'w' && nqm_contains_word(words, s->token, false);
}

static bool is_bracket(const scanner *s, const char *brackets) {
    return s->kind && strchr(brackets, s->kind);
}

/* Go to the end of the bracket that is the token. text: what is inside, "" if that is long. Of metadata that `words` name, found
 * receives the last value that is a string, or else the name. */
static void skip_brackets(scanner *s, char *text, const char *words, char *found) {
    const size_t first = s->at;
    size_t depth = 1;
    bool is_named = false;
    do {
        next(s);
        depth += is_bracket(s, "([{");
        depth -= is_bracket(s, ")]}");
        is_named = s->kind == 'w' ? words && is_token(s, words) : is_named;
        if (is_named && (s->kind == 'w' || s->kind == 's'))
            strcpy(found, s->token);
    } while (depth && s->kind);
    const size_t n = s->token_at - first;
    if (depth)
        fail(s, "a bracket without its end");
    else if (text && n < MAX_TEXT) {
        memcpy(text, s->text + first, n);
        text[n] = 0;
    }
}

/* Go on to the next token, and if that is a bracket of metadata, beyond it. */
static void next_beyond(scanner *s, const char *words, char *found) {
    next(s);
    if (s->kind == '(') {
        skip_brackets(s, NULL, words, found);
        next(s);
    }
}

/* ---- prims --------------------------------------------------------------------------------------------------------- */

static bool is_output(const char *name) {
    return strncmp(name, "outputs:", 8) == 0;
}

/* NULL: the file has too many, or there is no memory. */
static element *append(scanner *s, element *parent, const char *name, const char *const *attributes, size_t at) {
    element *e = NULL;
    if (s->status == NQM_OK && s->prims.n_elements == s->max_elements)
        s->status = nqm_fail(s->err, NQM_ERR_LIMIT, (int64_t)at, "%s: more than %zu prims and inputs (byte %zu)",
                             s->path, s->max_elements, at);
    if (s->status == NQM_OK && !(e = nqm_xml_append(&s->prims, parent, name, attributes, (int64_t)at)))
        s->status = nqm_fail_nomem(s->err, sizeof *e);
    if (!e)
        fail(s, "");
    return e;
}

/* "color3f inputs:a.connect = </M/t.outputs:rgb> (metadata)", of which the type is the token; stops at the token after it. */
static void read_property(scanner *s, element *prim) {
    char type[MAX_TEXT], name[MAX_TEXT], value[MAX_TEXT] = "", space[MAX_TEXT] = "";
    const size_t at = s->token_at;
    strcpy(type, s->token);
    do
        next(s);
    while (is_bracket(s, "[]"));
    if (s->kind != 'w')
        fail(s, "a property without its name");
    strcpy(name, s->token);
    next_beyond(s, "colorSpace", space);
    if (s->kind == '=') {
        next(s);
        strcpy(value, s->token);
        if (is_bracket(s, "([{"))
            skip_brackets(s, value, NULL, NULL);
        next_beyond(s, "colorSpace", space);
    }
    char *dot = strrchr(name, '.'), *form = "value";
    if (dot) {
        form = strcmp(dot, ".connect") == 0 ? "connect" : "times";
        *dot = 0;
    }
    const bool is_input = strncmp(name, "inputs:", 7) == 0 && *value; /* others are declared only */
    const char *const attributes[] = {"name", name, form, value, "space", space, NULL};
    if ((is_input || is_output(name) || strcmp(name, "info:id") == 0) &&
        nqm_contains_word("Material Shader NodeGraph", prim->name, false))
        append(s, prim, type, attributes, at);
}

static void read_prim(scanner *s, element *parent, size_t depth);

/* The statements between braces; stops at the last brace. The prims of variants are not read. */
static void read_body(scanner *s, element *prim, size_t depth) {
    next(s);
    while (s->kind && s->kind != '}') {
        while (is_token(s, "custom uniform varying prepend append add delete"))
            next(s);
        if (s->kind == 'w' && !is_token(s, "def over class variantSet")) {
            read_property(s, prim);
            continue;
        }
        if (is_token(s, "def over class"))
            read_prim(s, prim, depth);
        else if (s->kind == 'w') {
            while (s->kind && s->kind != '{')
                next(s);
            skip_brackets(s, NULL, NULL, NULL);
        } else if (s->kind != ';')
            fail(s, "neither a prim nor a property");
        next(s);
    }
    if (s->kind == 0)
        fail(s, "a prim without its end");
}

/* "def Shader "name" (metadata) { ... }", of which the first word is the token; stops at its last brace. */
static void read_prim(scanner *s, element *parent, size_t depth) {
    const bool is_def = is_token(s, "def");
    const size_t at = s->token_at;
    char type[MAX_TEXT] = "prim", name[MAX_TEXT], composed[MAX_TEXT] = "";
    next(s);
    if (s->kind == 'w') {
        strcpy(type, s->token);
        next(s);
    }
    if (s->kind != 's')
        fail(s, "a prim without its name");
    strcpy(name, s->token);
    next_beyond(s, "references payload inherits specializes variants", composed);
    if (s->kind != '{')
        fail(s, "a prim without its body");
    if (depth == MAX_DEPTH)
        fail(s, "prims that are nested more than 60 deep");
    const char *const attributes[] = {"name", name, "composed", composed, NULL};
    element *prim = append(s, parent, is_def ? type : "over", attributes, at);
    if (prim)
        read_body(s, prim, depth + 1);
}

static void read_layer(scanner *s) {
    element *root = append(s, NULL, "layer", (const char *const[]){NULL}, 0);
    for (next(s); s->kind; next(s))
        if (s->kind == '(')
            skip_brackets(s, NULL, NULL, NULL);
        else if (is_token(s, "def over class"))
            read_prim(s, root, 0);
}

/* ---- the document of MaterialX --------------------------------------------------------------------------------------- */

typedef struct writer {
    const scanner *s;
    nqm_index names; /* of the prims */
    nqm_xml document;
    nqm_materials *materials;
    bool has_memory;
} writer;

static element *put(writer *w, element *parent, const char *name, const char *const *attributes, int64_t byte_offset) {
    element *e = w->has_memory ? nqm_xml_append(&w->document, parent, name, attributes, byte_offset) : NULL;
    w->has_memory = e != NULL;
    return e;
}

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

/* The path of a prim; "" if it is long. */
static void path_of(const writer *w, const element *prim, char path[MAX_PATH]) {
    const element *chain[MAX_DEPTH + 2];
    size_t n = 0, used = 0;
    for (; prim != w->s->prims.root; prim = prim->parent)
        chain[n++] = prim;
    *path = 0;
    while (n-- && used < MAX_PATH)
        used += (size_t)snprintf(path + used, MAX_PATH - used, "/%s", nqm_xml_get(chain[n], "name"));
    if (used >= MAX_PATH)
        *path = 0;
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
    static const char *const types[] = {"float",   "float",    "integer", "boolean", "string",
                                        "string",  "filename", "vector2", "vector2", "color3",
                                        "vector3", "vector3",  "vector3", "color4",  "vector4"};
    const size_t i = nqm_find_word("float double int bool string token asset float2 texCoord2f color3f float3 vector3f "
                                   "normal3f color4f float4",
                                   usd, false);
    return i == SIZE_MAX ? usd : types[i];
}

/* The space of an image: of its metadata; a UsdUVTexture finds it by the picture unless it says something else. */
static const char *space_of(const char *node, const element *property) {
    const char *space = nqm_xml_get(property, "space");
    if (strcmp(space, "sRGB") == 0)
        return "srgb_texture";
    if (*space && strcmp(space, "auto") != 0)
        return nqm_contains_word("raw Raw", space, false) ? "none" : space;
    return strcmp(node, "UsdUVTexture") == 0 ? NQM_SPACE_AUTO : "none";
}

static void add_input(writer *w, element *shader, const element *property) {
    const element *to = follow(w, property);
    const char *name = nqm_xml_get(property, "name") + strlen("inputs:"), *type = type_of(property->name);
    const char *value = to && !is_of_shader(to) ? nqm_xml_get(to, "value") : NULL;
    char path[MAX_PATH] = "";
    const char *output = to ? nqm_xml_get(to, "name") + strlen("outputs:") : "";
    if (to && is_of_shader(to))
        path_of(w, to->parent, path);
    else if (to && !value)
        type = "value that varies with time"; /* which the reader refuses by this name */
    const bool is_file = value && strcmp(type, "filename") == 0;
    const char *space = is_file ? space_of(shader->name, property) : "lin_rec709";
    const char *const constant[] = {"name", name, "type", type, "value", value, "colorspace", space, NULL};
    const char *const connected[] = {
        "name", name, "type", type, "nodename", path, "output", strcmp(output, "out") == 0 ? "" : output, NULL};
    w->has_memory &=
        nqm_xml_append(&w->document, shader, "input", value ? constant : connected, property->byte_offset) != NULL;
}

/* "image" of "ND_image_color3", "standard_surface" of "ND_standard_surface_surfaceshader_100". */
static void node_of(const char *id, char node[MAX_TEXT]) {
    static const char *const endings[] = {"float",   "color3", "color4",   "vector",        "integer",
                                          "boolean", "string", "filename", "surfaceshader", "1"};
    enum { N = sizeof endings / sizeof *endings };
    snprintf(node, MAX_TEXT, "%s", strncmp(id, "ND_", 3) == 0 ? id + 3 : id);
    for (char *last; (last = strrchr(node, '_')); *last = 0) {
        size_t i = 0;
        while (i < N && strncmp(last + 1, endings[i], strlen(endings[i])) != 0)
            ++i;
        if (i == N)
            return;
    }
}

static void add_shader(writer *w, const element *prim) {
    const element *id = nqm_xml_find(&w->names, prim, NULL, "info:id");
    const char *type = NULL, *definition = id && nqm_xml_get(id, "value") ? nqm_xml_get(id, "value") : "shader";
    char path[MAX_PATH], node[MAX_TEXT];
    path_of(w, prim, path);
    node_of(definition, node);
    for (const element *e = prim->first; e; e = e->next)
        if (is_output(nqm_xml_get(e, "name")))
            type = type ? "multioutput" : strcmp(e->name, "token") == 0 ? "surfaceshader" : type_of(e->name);
    const bool is_typed = type && strcmp(node, "UsdUVTexture") != 0;
    const char *const attributes[] = {"name", path, "nodedef", definition, is_typed ? "type" : NULL, type, NULL};
    element *shader = put(w, w->document.root, node, attributes, prim->byte_offset);
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
    const nqm_material_info info = {
        .name = name,
        .surface = prim->name,
        .refusal = "it is composed of other prims or layers: write one layer by 'usdcat --flatten'",
        .byte_offset = prim->byte_offset};
    char path[MAX_PATH];
    bool has_surface = false;
    if (*composed)
        return nqm_materials_add(w->materials, &info, w->s->err);
    element *material =
        put(w, w->document.root, "surfacematerial", (const char *const[]){"name", name, NULL}, prim->byte_offset);
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
        put(w, material, "input", attributes, output->byte_offset);
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
    writer w = {.s = s, .materials = materials, .has_memory = true};
    nqm_status status = nqm_xml_names_create(&s->prims, &w.names, s->err);
    if (status == NQM_OK && put(&w, NULL, "materialx", (const char *const[]){NULL}, 0))
        status = add_prims(&w, s->prims.root);
    if (status == NQM_OK)
        status = w.has_memory ? nqm_mtlx_read_document(&w.document, s->path, materials, s->err)
                              : nqm_fail_nomem(s->err, s->n);
    nqm_index_free(&w.names);
    nqm_xml_free(&w.document);
    return status;
}

/* ---- a file -------------------------------------------------------------------------------------------------------- */

/* Why a file is not read, "" if it is text; NULL: it is another file. The first file of a package is named at its byte 30. */
static const char *fault_of(const nqm_map *map) {
    const char *text = (const char *)map->data;
    const size_t n = map->n_bytes, n_name = n < 30 ? 0 : (size_t)map->data[26] | (size_t)map->data[27] << 8;
    if (n >= 8 && memcmp(text, "PXR-USDC", 8) == 0)
        return "a binary layer of USD (crate, byte 0); write it as text: usdcat IN.usdc -o OUT.usda";
    if (n_name > 5 && n_name <= n - 30 && memcmp(text, "PK\3\4", 4) == 0 && memcmp(text + 25 + n_name, ".usd", 4) == 0)
        return "a package of USD (byte 0); unpack it by unzip, and write its layer as text: usdcat IN.usdc -o OUT.usda";
    return n < 6 || memcmp(text, "#usda ", 6) != 0 ? NULL
           : n > NQM_XML_MAX_BYTES                 ? "more than 64 MB of USD (byte 0), the most that are read"
                                                   : "";
}

static bool probe(const nqm_map *map) {
    return fault_of(map) != NULL;
}

static nqm_status read_usda(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    scanner s = {.path = map->path, .text = (const char *)map->data, .n = map->n_bytes, .err = err};
    const char *fault = fault_of(map);
    s.max_elements = (NQM_XML_FREE_ELEMENTS + s.n / NQM_XML_BYTES_PER_ELEMENT) / 2; /* there are two trees */
    if (*fault)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: %s", s.path, fault);
    read_layer(&s);
    if (s.status == NQM_OK)
        s.status = translate(&s, materials);
    if (s.status == NQM_OK && nqm_materials_count(materials) == 0)
        s.status = nqm_fail(err, NQM_ERR_FORMAT, 0,
                            "%s: no Material in this layer (byte 0); materials of other layers are not read: usdcat "
                            "--flatten IN -o OUT.usda",
                            s.path);
    nqm_xml_free(&s.prims);
    return s.status;
}

const nqm_material_format nqm_usd_format = {
    .name = "USD (.usda)", .extensions = "", .models = "", .probe = probe, .read = read_usda};
