/* SPDX-License-Identifier: MIT
 *
 * Scenes of pbrt-v4 as text (pbrt.org/fileformat-v4): tokens, declared parameters, and the directives Texture, Material and
 * MakeNamedMaterial; others are skipped. The nodes become materials in pbrt.c.
 */
#include "material/pbrt.h"

#include <ctype.h>

enum { MAX_PARAMETERS = 32, MAX_BYTES = 256 << 20, MAX_TOKEN = 256 };

/* ---- tokens ------------------------------------------------------------------------------------------------------ */

typedef struct scanner {
    const char *path, *text;
    size_t n, at;
    nqm_bsdf_nodes nodes;  /* the textures so far, then the material that is being read, each with its parameters */
    size_t owner;          /* the one of these that has the parameters which are being read */
    char type[MAX_TOKEN];  /* of the material */
    bool is_named;         /* the type of the material is one of its parameters */
    const char *refusal;   /* why materials from here on are refused; NULL: they are not */
    int64_t byte_offset;   /* position of the last token */
    char token[MAX_TOKEN]; /* without its quotes */
    bool is_quoted;
    nqm_error *err;
} scanner;

static nqm_status fail(const scanner *s, const char *what) {
    return nqm_fail(s->err, NQM_ERR_FORMAT, s->byte_offset, "%s: %s (byte %lld)", s->path, what,
                    (long long)s->byte_offset);
}

static void skip_blanks(scanner *s) {
    while (s->at < s->n && (isspace((unsigned char)s->text[s->at]) || s->text[s->at] == '#'))
        if (s->text[s->at] == '#')
            while (s->at < s->n && s->text[s->at] != '\n')
                ++s->at;
        else
            ++s->at;
}

/* true when a character ends an unquoted token. */
static bool is_end(char c) {
    return isspace((unsigned char)c) || c == '"' || c == '[' || c == ']' || c == '#';
}

/* Read a token; an empty unquoted one is the end of the file. */
static nqm_status next(scanner *s) {
    size_t n = 0;
    skip_blanks(s);
    s->byte_offset = (int64_t)s->at;
    s->token[0] = 0;
    s->is_quoted = s->at < s->n && s->text[s->at] == '"';
    if (s->at == s->n)
        return NQM_OK;
    const size_t start = s->at + s->is_quoted;
    size_t end = start;
    if (s->is_quoted)
        while (end < s->n && s->text[end] != '"' && s->text[end] != '\n')
            ++end;
    else
        while (end < s->n && (end == start || (!is_end(s->text[end]) && !memchr("[]", s->text[start], 2))))
            ++end;
    if (s->is_quoted && (end == s->n || s->text[end] != '"'))
        return fail(s, "a string without its closing quote");
    n = end - start;
    if (n >= MAX_TOKEN)
        return fail(s, "a word or string of more than 255 characters");
    memcpy(s->token, s->text + start, n);
    s->token[n] = 0;
    s->at = end + s->is_quoted;
    if (memchr(s->token, 0, n))
        return fail(s, "a byte 0 inside of a word");
    return NQM_OK;
}

/* ---- parameters -------------------------------------------------------------------------------------------------- */

enum { VALUES = 4 * (MAX_TOKEN + 3) }; /* characters of four values; no parameter that is read has more than three */

static const nqm_bsdf_word kinds[] = {{"float integer", NQM_BSDF_NUMBER},
                                      {"rgb", NQM_BSDF_TRIPLE},
                                      {"string", NQM_BSDF_STRING},
                                      {"spectrum", NQM_BSDF_SPECTRUM},
                                      {"bool", NQM_BSDF_BOOLEAN},
                                      {"texture", NQM_BSDF_TEXTURE},
                                      {NULL, NQM_BSDF_OTHER}};

/* Append one value, the last token, to the others; a string among numbers keeps its quotes and is no number. */
static nqm_status add_value(scanner *s, nqm_bsdf_kind kind, char values[VALUES]) {
    const size_t used = strlen(values), n = strlen(s->token);
    const char *end = s->token,
               *quote = s->is_quoted && (kind == NQM_BSDF_NUMBER || kind == NQM_BSDF_TRIPLE) ? "\"" : "";
    double v;
    if (!s->is_quoted && strcmp(s->token, "true") != 0 && strcmp(s->token, "false") != 0 &&
        (!nqm_parse_double(s->token, &end, &v) || *end))
        return fail(s, "a value that is not a number, string, true or false");
    if (used + n + 4 < VALUES)
        snprintf(values + used, VALUES - used, "%s%s%s%s", used ? " " : "", quote, s->token, quote);
    return NQM_OK;
}

/* The values behind a declaration, with or without brackets. */
static nqm_status read_values(scanner *s, nqm_bsdf_kind kind, char values[VALUES]) {
    nqm_status status = next(s);
    *values = 0;
    if (status != NQM_OK)
        return status;
    if (s->is_quoted || strcmp(s->token, "[") != 0)
        return add_value(s, kind, values);
    while ((status = next(s)) == NQM_OK && (s->is_quoted || strcmp(s->token, "]") != 0)) {
        if (!s->is_quoted && !*s->token)
            return fail(s, "a list without its closing bracket");
        status = add_value(s, kind, values);
        if (status != NQM_OK)
            return status;
    }
    return status;
}

/* Read a parameter, whose declaration "type name" is the last token. The first string "type" of a named material is its type. */
static nqm_status read_parameter(scanner *s) {
    const size_t blank = strcspn(s->token, " \t"), start = blank + strspn(s->token + blank, " \t");
    char declaration[MAX_TOKEN], values[VALUES];
    memcpy(declaration, s->token, sizeof declaration);
    if (!blank || !declaration[start])
        return fail(s, "a parameter that is not declared as \"type name\"");
    declaration[blank] = 0;
    declaration[start + strcspn(declaration + start, " \t")] = 0;
    const nqm_bsdf_node node = {.kind = nqm_bsdf_kind_of(kinds, declaration),
                                .parent = s->owner,
                                .type = declaration,
                                .name = declaration + start,
                                .value = values,
                                .byte_offset = s->byte_offset};
    nqm_status status = read_values(s, node.kind, values);
    if (status != NQM_OK)
        return status;
    if (s->is_named && !*s->type && node.kind == NQM_BSDF_STRING && strcmp(node.name, "type") == 0) {
        snprintf(s->type, sizeof s->type, "%.*s", MAX_TOKEN - 1, values);
        return NQM_OK;
    }
    if (s->nodes.n - s->owner > MAX_PARAMETERS)
        return fail(s, "a material or texture with more than 32 parameters");
    return nqm_bsdf_add(&s->nodes, &node, s->path, s->err);
}

/* Add the node of a directive, and its parameters. The scanner stops before the next directive. */
static nqm_status read_parameters(scanner *s, const nqm_bsdf_node *directive) {
    s->owner = s->nodes.n;
    nqm_status status = nqm_bsdf_add(&s->nodes, directive, s->path, s->err);
    while (status == NQM_OK) {
        scanner ahead = *s;
        status = next(&ahead);
        if (status != NQM_OK || !ahead.is_quoted)
            break;
        *s = ahead;
        status = read_parameter(s);
    }
    return status;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* The type of a material is a string parameter of a named one, the word after the directive of others. */
static nqm_status read_material(scanner *s, bool is_named, nqm_materials *materials) {
    nqm_bsdf_node material = {.parent = NQM_BSDF_ROOT, .byte_offset = s->byte_offset};
    char name[MAX_TOKEN];
    nqm_status status = next(s);
    if (status == NQM_OK && !s->is_quoted)
        return fail(s, is_named ? "MakeNamedMaterial without the name of a material"
                                : "Material without the type of a material");
    if (status != NQM_OK)
        return status;
    s->is_named = is_named;
    strcpy(s->type, is_named ? "" : s->token);
    strcpy(name, is_named ? s->token : "");
    material.id = name;
    status = read_parameters(s, &material);
    if (status == NQM_OK)
        status = nqm_pbrt_add(&s->nodes, s->owner, s->type, s->refusal, s->path, materials, s->err);
    nqm_bsdf_cut(&s->nodes, s->owner);
    return status;
}

/* The class of a texture becomes the type of its node, its type the name. */
static nqm_status read_texture_directive(scanner *s) {
    char words[3][MAX_TOKEN];
    const nqm_bsdf_node texture = {.kind = NQM_BSDF_TEXTURE,
                                   .parent = NQM_BSDF_ROOT,
                                   .byte_offset = s->byte_offset,
                                   .id = words[0],
                                   .name = words[1],
                                   .type = words[2]};
    for (size_t i = 0; i < 3; ++i) {
        nqm_status status = next(s);
        if (status == NQM_OK && !s->is_quoted)
            return fail(s, "Texture without its name, type and class");
        if (status != NQM_OK)
            return status;
        memcpy(words[i], s->token, sizeof words[i]);
    }
    s->is_named = false;
    return read_parameters(s, &texture);
}

/* Directives that change what the parameters of later materials mean. They end with the enclosing attribute block, which is not
 * tracked: all materials after them are refused. */
static nqm_status read_setting(scanner *s, const char *neutral, const char *refusal) {
    scanner ahead = *s;
    nqm_status status = next(&ahead);
    const bool is_other = neutral && strcmp(ahead.token, neutral) != 0;
    if (ahead.is_quoted)
        *s = ahead;
    if (status == NQM_OK && (is_other || nqm_contains_word("material texture", ahead.token, false)))
        s->refusal = refusal;
    return status;
}

/* Read the directive that is the last token. */
static nqm_status read_directive(scanner *s, nqm_materials *materials) {
    const bool is_named = strcmp(s->token, "MakeNamedMaterial") == 0;
    if (strcmp(s->token, "Include") == 0 || strcmp(s->token, "Import") == 0)
        return fail(s, "included files are not read; name the included file itself");
    if (strcmp(s->token, "ColorSpace") == 0)
        return read_setting(s, "srgb", "the colour space is not srgb (directive ColorSpace)");
    if (strcmp(s->token, "Attribute") == 0)
        return read_setting(s, NULL, "the directive Attribute changes the defaults of materials or textures");
    if (strcmp(s->token, "Texture") == 0)
        return read_texture_directive(s);
    return is_named || strcmp(s->token, "Material") == 0 ? read_material(s, is_named, materials) : NQM_OK;
}

nqm_status nqm_pbrt_read(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    scanner s = {.path = map->path, .text = (const char *)map->data, .n = map->n_bytes, .err = err};
    if (map->n_bytes > MAX_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: a scene of %zu bytes (byte 0); at most %d are read", map->path,
                        map->n_bytes, MAX_BYTES);
    nqm_status status = next(&s);
    while (status == NQM_OK && (s.is_quoted || *s.token)) {
        if (!s.is_quoted)
            status = read_directive(&s, materials);
        if (status == NQM_OK)
            status = next(&s);
    }
    nqm_bsdf_clear(&s.nodes);
    return status;
}

bool nqm_pbrt_probe(const nqm_map *map) {
    static const char directives[] =
        " Material MakeNamedMaterial NamedMaterial Accelerator AreaLightSource Attribute Camera "
        "AttributeBegin ColorSpace Film Identity Include Integrator LookAt MakeNamedMedium Option "
        "PixelFilter Rotate Sampler Scale Shape Texture Transform ConcatTransform Translate WorldBegin "
        "LightSource ObjectBegin ReverseOrientation ";
    char word[40] = " ";
    scanner s = {.text = (const char *)map->data, .n = nqm_smaller(map->n_bytes, 4096)};
    skip_blanks(&s);
    size_t n = 1;
    while (s.at < s.n && n + 2 < sizeof word && s.text[s.at] && !is_end(s.text[s.at]))
        word[n++] = s.text[s.at++];
    word[n++] = ' ';
    word[n] = 0;
    return n > 2 && s.at < s.n && is_end(s.text[s.at]) && strstr(directives, word);
}
