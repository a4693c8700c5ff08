/* SPDX-License-Identifier: MIT
 *
 * USD as text (.usda; openusd.org, "USDA File Format Specification" and UsdShade): materials with a UsdPreviewSurface
 * or the shaders of MaterialX ("ND_standard_surface_surfaceshader"). This file reads one layer as prims and composes
 * them, and usda_material.c makes a document of MaterialX of them, whose reader does the rest, textures included. Variants and
 * other layers are not read. Binary layers (crate, .usdc) and packages (.usdz) are recognised, to say what to do with them.
 */
#include "material/usda.h"

#include <ctype.h>

enum { MAX_DEPTH = NQM_USDA_MAX_DEPTH, MAX_TEXT = NQM_USDA_MAX_TEXT };

typedef nqm_xml_element element;

/* ---- tokens -------------------------------------------------------------------------------------------------------- */

/* After a failure, only the end of the file follows. */
typedef struct scanner {
    nqm_usda layer;
    const char *text;
    size_t n, at, token_at;
    char kind; /* of the token: 'w' word or number, 's' string, '@' asset, '<' path, punctuation, 0 at the end */
    char token[MAX_TEXT]; /* without its quotes; cut if it is longer */
} scanner;

static void fail(scanner *s, const char *what) {
    nqm_usda *layer = &s->layer;
    if (layer->status == NQM_OK)
        layer->status = nqm_fail(layer->err, NQM_ERR_FORMAT, (int64_t)s->token_at, "%s: %s (byte %zu)", layer->path,
                                 what, s->token_at);
    s->at = s->n;
    s->kind = 0;
}

static bool begins(const scanner *s, const char *text) {
    return s->n - s->at >= strlen(text) && memcmp(s->text + s->at, text, strlen(text)) == 0;
}

static void skip_blanks(scanner *s) {
    while (s->at < s->n && (isspace((unsigned char)s->text[s->at]) || s->text[s->at] == '#' || begins(s, "//")))
        if (!isspace((unsigned char)s->text[s->at++]))
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

/* Go to the end of the bracket that is the token. text: what is inside, "" if that is long. Of metadata `word`, found receives the
 * last value that is a string. */
static void skip_brackets(scanner *s, char *text, const char *word, char *found) {
    const size_t first = s->at;
    size_t depth = 1;
    bool is_named = false;
    do {
        next(s);
        depth += is_bracket(s, "([{");
        depth -= is_bracket(s, ")]}");
        is_named = s->kind == 'w' ? word && is_token(s, word) : is_named;
        if (is_named && s->kind == 's')
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
static void next_beyond(scanner *s, const char *word, char *found) {
    next(s);
    if (s->kind == '(') {
        skip_brackets(s, NULL, word, found);
        next(s);
    }
}

/* ---- properties ---------------------------------------------------------------------------------------------------- */

/* NULL: the file has too many, or there is no memory; `status` says which. */
static element *append(nqm_usda *layer, element *parent, const char *name, const char *const *attributes, int64_t at) {
    element *e = NULL;
    if (layer->status == NQM_OK && layer->prims.n_elements == layer->max_elements)
        layer->status = nqm_fail(layer->err, NQM_ERR_LIMIT, at, "%s: more than %zu prims and inputs (byte %lld)",
                                 layer->path, layer->max_elements, (long long)at);
    if (layer->status == NQM_OK && !(e = nqm_xml_append(&layer->prims, parent, name, attributes, at)))
        layer->status = nqm_fail_nomem(layer->err, sizeof *e);
    if (layer->status == NQM_OK)
        layer->status = nqm_index_reserve(&layer->names, layer->prims.n_elements, layer->err);
    if (layer->status == NQM_OK && parent)
        nqm_index_add(&layer->names, e);
    return layer->status == NQM_OK ? e : NULL;
}

/* The value that is the token; stops at its last one. */
static void read_value(scanner *s, char value[MAX_TEXT]) {
    *value = 0;
    if (is_bracket(s, "([{"))
        skip_brackets(s, value, NULL, NULL);
    else if (!is_token(s, "None"))
        strcpy(value, s->token);
}

/* The first value of "{ 1: 0.5, 10: 0.6 }" or of a list, of which the bracket is the token; stops at the last bracket. */
static void read_first(scanner *s, char value[MAX_TEXT]) {
    const bool has_times = s->kind == '{';
    const char *colon;
    *value = 0;
    next(s);
    for (; has_times && s->kind == 'w'; next(s))
        if ((colon = strchr(s->token, ':'))) {
            if (colon[1]) /* "1:0.5" */
                memmove(s->token, colon + 1, strlen(colon));
            else
                next(s);
            break;
        }
    if (is_bracket(s, "]}"))
        return;
    read_value(s, value);
    skip_brackets(s, NULL, NULL, NULL);
}

/* "color3f inputs:a.connect = </M/t.outputs:rgb> (metadata)", of which the type is the token; stops at the token after it. */
static void read_property(scanner *s, element *prim, bool is_deleted) {
    static const char owners[] =
        "Material Shader NodeGraph prim over class:Material class:Shader class:NodeGraph class:prim";
    char type[MAX_TEXT], name[MAX_TEXT], value[MAX_TEXT] = "", space[MAX_TEXT] = "";
    const size_t at = s->token_at;
    const char *form, *has_value = NULL;
    strcpy(type, s->token);
    do
        next(s);
    while (is_bracket(s, "[]"));
    if (s->kind != 'w')
        fail(s, "a property without its name");
    strcpy(name, s->token);
    next_beyond(s, "colorSpace", space);
    form = strrchr(name, '.');
    if (s->kind == '=') {
        has_value = "value";
        next(s);
        if (form && is_bracket(s, strcmp(form, ".connect") == 0 ? "[" : "{"))
            read_first(s, value);
        else
            read_value(s, value);
        next_beyond(s, "colorSpace", space);
    }
    const char *const attributes[] = {"name", name, "space", space, has_value, value, NULL};
    const bool is_read =
        strncmp(name, "inputs:", 7) == 0 || strncmp(name, "outputs:", 8) == 0 || strncmp(name, "info:", 5) == 0;
    if (is_read && !is_deleted && nqm_contains_word(owners, prim->name, false))
        append(&s->layer, prim, type, attributes, (int64_t)at);
}

/* ---- prims --------------------------------------------------------------------------------------------------------- */

/* What the metadata, of which the bracket is the token, say that the prim is composed of: paths in this layer, as the attribute of
 * nqm_usda, and something else, as NQM_USDA_EXTERNAL. */
static void read_arcs(scanner *s, char arcs[MAX_TEXT], char external[MAX_TEXT]) {
    enum { N = 4, VARIANTS = N };
    static const char words[] = "inherits references payload specializes variants";
    char lists[N + 1][MAX_TEXT] = {""};
    size_t depth = 1, arc = SIZE_MAX, used = 0;
    for (char last = 0; depth && s->kind; last = s->kind) {
        next(s);
        depth += is_bracket(s, "([{");
        depth -= is_bracket(s, ")]}");
        if (s->kind == 'w' && depth == 1) /* what is deleted is no word of these */
            arc = last == 'w' && arc == N + 1 ? SIZE_MAX
                  : is_token(s, "delete")     ? N + 1
                                              : nqm_find_word(words, s->token, false);
        if (arc > VARIANTS)
            continue;
        if (s->kind == '@' && !*s->token) /* this layer */
            s->kind = ',';
        else if (s->kind == '@' || (arc == VARIANTS && s->kind == 's'))
            snprintf(external, MAX_TEXT, s->kind == '@' ? "the layer '%.80s'" : "variants ('%.80s')", s->token);
        else if (s->kind == '<' && last != '@' && strlen(lists[arc]) + strlen(s->token) + 2 < MAX_TEXT / N)
            strcat(strcat(lists[arc], s->token), " ");
        else if (s->kind == '<' && last != '@')
            strcpy(external, "more prims than are read");
    }
    for (arc = 0; arc < N; used += strlen(lists[arc++]))
        strcpy(arcs + used, lists[arc]);
    if (depth)
        fail(s, "a bracket without its end");
}

static void read_prim(scanner *s, element *parent, size_t depth);

/* The statements between braces; stops at the last brace. The prims of variants are not read. */
static void read_body(scanner *s, element *prim, size_t depth) {
    next(s);
    while (s->kind && s->kind != '}') {
        bool is_deleted = false;
        for (; is_token(s, "custom config uniform varying prepend append add delete"); next(s))
            is_deleted = is_deleted || is_token(s, "delete");
        if (s->kind == 'w' && !is_token(s, "def over class variantSet")) {
            read_property(s, prim, is_deleted);
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
    const bool is_over = is_token(s, "over"), is_class = is_token(s, "class");
    const size_t at = s->token_at;
    char type[MAX_TEXT] = "prim", kind[MAX_TEXT + 8], name[MAX_TEXT], arcs[MAX_TEXT] = "", external[MAX_TEXT] = "";
    next(s);
    if (s->kind == 'w') {
        strcpy(type, s->token);
        next(s);
    }
    if (s->kind != 's')
        fail(s, "a prim without its name");
    strcpy(name, s->token);
    next(s);
    if (s->kind == '(') {
        read_arcs(s, arcs, external);
        next(s);
    }
    if (s->kind != '{')
        fail(s, "a prim without its body");
    if (depth == MAX_DEPTH)
        fail(s, "prims that are nested more than 60 deep");
    snprintf(kind, sizeof kind, "%s%s", is_class ? "class:" : "", is_over ? "over" : type);
    element *prim =
        append(&s->layer, parent, kind, (const char *const[]){"name", name, "arcs", arcs, NULL}, (int64_t)at);
    if (prim && *external)
        append(&s->layer, prim, "token", (const char *const[]){"name", NQM_USDA_EXTERNAL, "value", external, NULL},
               (int64_t)at);
    if (prim)
        read_body(s, prim, depth + 1);
}

static void read_layer(scanner *s) {
    element *root = append(&s->layer, NULL, "layer", (const char *const[]){NULL}, 0);
    for (next(s); s->kind; next(s))
        if (s->kind == '(')
            skip_brackets(s, NULL, NULL, NULL);
        else if (is_token(s, "def over class"))
            read_prim(s, root, 0);
}

/* ---- composition --------------------------------------------------------------------------------------------------- */

const element *nqm_usda_find(const nqm_usda *layer, const element *base, const char *path, const char **property_ret) {
    const element *e = *path == '/' ? layer->prims.root : base;
    char name[MAX_TEXT];
    path += *path == '/';
    while (e && *path && (*path != '.' || strncmp(path, "..", 2) == 0)) {
        const size_t n = *path == '.' ? 2 : strcspn(path, "/.");
        snprintf(name, sizeof name, "%.*s", (int)nqm_smaller(n, sizeof name - 1), path);
        e = *path == '.' ? e->parent : nqm_xml_find(&layer->names, e, NULL, name);
        path += n + (path[n] == '/');
    }
    *property_ret = e && *path ? path + 1 : NULL;
    return e;
}

void nqm_usda_path(const element *prim, char path[MAX_TEXT]) {
    const element *chain[MAX_DEPTH + 2];
    size_t n = 0, used = 0;
    for (; prim->parent; prim = prim->parent)
        chain[n++] = prim;
    *path = 0;
    while (n-- && used < MAX_TEXT)
        used += (size_t)snprintf(path + used, MAX_TEXT - used, "/%s", nqm_xml_get(chain[n], "name"));
    if (used >= MAX_TEXT)
        *path = 0;
}

typedef struct arc {
    char from[MAX_TEXT], to[MAX_TEXT]; /* paths of the prims */
} arc;

static bool is_inside(const char *path, const char *prim) {
    const size_t n = strlen(prim);
    return strncmp(path, prim, n) == 0 && memchr("/.", path[n], sizeof "/.");
}

static void fail_deep(nqm_usda *layer, const element *prim) {
    if (layer->status == NQM_OK)
        layer->status = nqm_fail(layer->err, NQM_ERR_FORMAT, prim->byte_offset,
                                 "%s: prims that are composed of prims, nested too deeply (byte %lld)", layer->path,
                                 (long long)prim->byte_offset);
}

/* The type of a prim of this kind, which may be a class or an over. */
static const char *type_of(const char *kind) {
    const size_t n = strlen("class:");
    return strcmp(kind, "over") == 0 ? "prim" : kind + (strncmp(kind, "class:", n) == 0 ? n : 0);
}

static void copy_property(nqm_usda *layer, element *to, const element *property, const arc *a) {
    const char *name = nqm_xml_get(property, "name"), *value = nqm_xml_get(property, "value");
    const char *space = nqm_xml_get(property, "space"), *dot = strrchr(name, '.');
    char path[2 * MAX_TEXT] = "";
    if (value && dot && strcmp(dot, ".connect") == 0 && is_inside(value, a->from))
        snprintf(path, sizeof path, "%s%s", a->to, value + strlen(a->from));
    const char *const attributes[] = {
        "name", name, "space", space ? space : "", value ? "value" : NULL, *path ? path : value, NULL};
    append(layer, to, property->name, attributes, property->byte_offset);
}

/* Copy what a prim does not have. */
static void merge(nqm_usda *layer, element *to, const element *from, const arc *a, size_t depth) {
    if (depth == MAX_DEPTH)
        fail_deep(layer, from);
    for (const element *e = from->first; e && layer->status == NQM_OK; e = e->next) {
        const char *name = nqm_xml_get(e, "name");
        element *own = (element *)nqm_xml_find(&layer->names, to, NULL, name);
        if (strchr(name, ':')) {
            if (!own)
                copy_property(layer, to, e, a);
            else if (!nqm_xml_get(own, "value")) { /* declared only */
                own->attributes = e->attributes;
                own->n_attributes = e->n_attributes;
            }
            continue;
        }
        if (!own)
            own = append(layer, to, e->name, (const char *const[]){"name", name, NULL}, e->byte_offset);
        else if (strcmp(own->name, "over") == 0)
            own->name = e->name;
        else if (strcmp(own->name, "prim") == 0)
            own->name = type_of(e->name);
        if (own)
            merge(layer, own, e, a, depth + 1);
    }
}

/* Give a prim what another one has. Instances that change nothing are left: the materials of their source are read there. */
static void take(nqm_usda *layer, element *prim, const element *from) {
    static const char shading[] = "Material Shader NodeGraph";
    const bool is_plain = strcmp(from->name, type_of(from->name)) == 0 && !prim->first;
    size_t depth = 0;
    arc a;
    nqm_usda_path(from, a.from);
    nqm_usda_path(prim, a.to);
    for (const element *e = prim; e->parent; e = e->parent)
        ++depth;
    const bool is_shading =
        nqm_contains_word(shading, type_of(from->name), false) || nqm_contains_word(shading, prim->name, false);
    if ((is_plain && !is_shading) || !*a.from || is_inside(a.from, a.to) || is_inside(a.to, a.from))
        return;
    if (strcmp(prim->name, "prim") == 0)
        prim->name = type_of(from->name);
    merge(layer, prim, from, &a, depth);
}

/* The first of a list of paths, of which *paths becomes the rest; NULL: the layer does not have it. */
static element *next_source(const nqm_usda *layer, const char **paths) {
    char path[MAX_TEXT];
    const char *property;
    const size_t n = strcspn(*paths, " ");
    snprintf(path, sizeof path, "%.*s", (int)n, *paths);
    *paths += n + 1;
    const element *found = nqm_usda_find(layer, NULL, path, &property);
    return found && found->parent ? (element *)found : NULL;
}

/* A prim, what it is composed of, and what is in it. One that has no attribute `arcs` any more is done, or being done. */
static void compose(nqm_usda *layer, element *prim, size_t depth) {
    const char *arcs = nqm_xml_get(prim, "arcs");
    if (depth == 2 * MAX_DEPTH)
        fail_deep(layer, prim);
    if ((prim->parent && !arcs) || layer->status != NQM_OK)
        return;
    prim->n_attributes = nqm_smaller(prim->n_attributes, 1);
    while (arcs && *arcs && layer->status == NQM_OK) {
        element *from = next_source(layer, &arcs);
        if (from)
            compose(layer, from, depth + 1);
        if (from && layer->status == NQM_OK)
            take(layer, prim, from);
    }
    for (element *e = prim->first; e; e = e->next)
        compose(layer, e, depth + 1);
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
    scanner s = {.layer = {.path = map->path, .err = err}, .text = (const char *)map->data, .n = map->n_bytes};
    nqm_usda *layer = &s.layer;
    const char *fault = fault_of(map);
    layer->max_elements = (NQM_XML_FREE_ELEMENTS + s.n / NQM_XML_BYTES_PER_ELEMENT) / 2; /* there are two trees */
    if (*fault)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: %s", map->path, fault);
    layer->status = nqm_xml_names_create(1, NULL, &layer->names, err);
    if (layer->status == NQM_OK)
        read_layer(&s);
    if (layer->status == NQM_OK)
        compose(layer, layer->prims.root, 0);
    if (layer->status == NQM_OK)
        layer->status = nqm_usda_add_materials(layer, materials);
    if (layer->status == NQM_OK && nqm_materials_count(materials) == 0)
        layer->status =
            nqm_fail(err, NQM_ERR_FORMAT, 0,
                     "%s: no Material in this layer (byte 0); materials of other layers are not read: usdcat "
                     "--flatten IN -o OUT.usda",
                     map->path);
    nqm_index_free(&layer->names);
    nqm_xml_free(&layer->prims);
    return layer->status;
}

const nqm_material_format nqm_usd_format = {
    .name = "USD (.usda)", .extensions = "", .models = "", .probe = probe, .read = read_usda};
