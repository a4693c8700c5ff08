/* SPDX-License-Identifier: MIT
 *
 * Scenes of pbrt-v4 as text (pbrt.org/fileformat-v4): tokens, declared parameters, and the directives Texture, Material,
 * MakeNamedMaterial, Include and Import; others are skipped. The nodes become materials in pbrt.c.
 */
#include "material/bsdf.h"

#include <ctype.h>

enum { MAX_PARAMETERS = 32, MAX_BYTES = 256 << 20, MAX_TOKEN = 256 };

/* ---- tokens ------------------------------------------------------------------------------------------------------ */

typedef struct scanner {
    nqm_pbrt_scene scene;
    size_t n_names;
    nqm_includes includes;
    const char *path, *text; /* of the file that is read, which the scene may include */
    size_t n, at;
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

/* Position of the last token for messages; -1: it is in another file than the scene. */
static int64_t byte_in_scene(const scanner *s) {
    return s->includes.depth ? -1 : s->byte_offset;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

typedef struct named {
    size_t at;
    char key[]; /* "spectrum wood" */
} named;

static nqm_index_key key_of_named(const void *value) {
    return (nqm_index_key){NULL, ((const named *)value)->key};
}

size_t nqm_pbrt_find(const nqm_index *names, const char *kind, const char *name) {
    char key[MAX_TOKEN + 20];
    snprintf(key, sizeof key, "%s %s", kind, name);
    const named *found = nqm_index_find(names, (nqm_index_key){NULL, key});
    return found ? found->at : SIZE_MAX;
}

/* Of equal names the first one is found. */
static nqm_status add_name(scanner *s, const char *kind, const char *name, size_t at) {
    const size_t n = strlen(kind) + strlen(name) + 2;
    nqm_status status = nqm_index_reserve(&s->scene.names, s->n_names + 1, s->err);
    if (status != NQM_OK || nqm_pbrt_find(&s->scene.names, kind, name) != SIZE_MAX)
        return status;
    named *entry = nqm_alloc(1, sizeof *entry + n);
    if (!entry)
        return nqm_fail_nomem(s->err, n);
    entry->at = at;
    snprintf(entry->key, n, "%s %s", kind, name);
    nqm_index_add(&s->scene.names, entry);
    ++s->n_names;
    return NQM_OK;
}

static void clear_scene(nqm_pbrt_scene *scene) {
    for (size_t i = 0; i < scene->names.n_slots; ++i)
        nqm_free((void *)scene->names.slots[i]);
    nqm_index_free(&scene->names);
    nqm_bsdf_clear(&scene->nodes);
}

/* ---- parameters -------------------------------------------------------------------------------------------------- */

typedef struct value_text {
    char *text; /* owned; separated by blanks, strings by ends of lines */
    size_t n, max_n;
} value_text;

static const nqm_bsdf_word kinds[] = {{"float integer", NQM_BSDF_NUMBER},
                                      {"rgb", NQM_BSDF_TRIPLE},
                                      {"string", NQM_BSDF_STRING},
                                      {"spectrum", NQM_BSDF_SPECTRUM},
                                      {"bool", NQM_BSDF_BOOLEAN},
                                      {"texture", NQM_BSDF_TEXTURE},
                                      {NULL, NQM_BSDF_OTHER}};

/* Append one value, the last token, to the others; a string among numbers keeps its quotes and is no number. */
static nqm_status add_value(scanner *s, nqm_bsdf_kind kind, value_text *v) {
    const size_t room = strlen(s->token) + 4;
    const char *end = s->token,
               *separator = !v->n                     ? ""
                            : kind == NQM_BSDF_STRING ? "\n"
                                                      : " ",
               *quote = s->is_quoted && (kind == NQM_BSDF_NUMBER || kind == NQM_BSDF_TRIPLE) ? "\"" : "";
    double number;
    if (!s->is_quoted && strcmp(s->token, "true") != 0 && strcmp(s->token, "false") != 0 &&
        (!nqm_parse_double(s->token, &end, &number) || *end))
        return fail(s, "a value that is not a number, string, true or false");
    if (kind == NQM_BSDF_OTHER && v->n)
        return NQM_OK; /* of "point3 P" with millions of values */
    char *text = nqm_grow(v->text, &v->max_n, v->n + room, 1);
    if (!text)
        return nqm_fail_nomem(s->err, v->n + room);
    v->text = text;
    v->n += (size_t)snprintf(text + v->n, room, "%s%s%s%s", separator, quote, s->token, quote);
    return NQM_OK;
}

/* The values behind a declaration, with or without brackets. */
static nqm_status read_values(scanner *s, nqm_bsdf_kind kind, value_text *v) {
    nqm_status status = next(s);
    if (status != NQM_OK)
        return status;
    if (s->is_quoted || strcmp(s->token, "[") != 0)
        return add_value(s, kind, v);
    while ((status = next(s)) == NQM_OK && (s->is_quoted || strcmp(s->token, "]") != 0)) {
        if (!s->is_quoted && !*s->token)
            return fail(s, "a list without its closing bracket");
        status = add_value(s, kind, v);
        if (status != NQM_OK)
            return status;
    }
    return status;
}

/* Read a parameter, whose declaration "type name" is the last token. The first string "type" of a named material is its type. */
static nqm_status read_parameter(scanner *s) {
    const size_t blank = strcspn(s->token, " \t"), start = blank + strspn(s->token + blank, " \t");
    char declaration[MAX_TOKEN];
    value_text v = {.n = 0};
    memcpy(declaration, s->token, sizeof declaration);
    if (!blank || !declaration[start])
        return fail(s, "a parameter that is not declared as \"type name\"");
    declaration[blank] = 0;
    declaration[start + strcspn(declaration + start, " \t")] = 0;
    nqm_bsdf_node node = {.kind = nqm_bsdf_kind_of(kinds, declaration),
                          .parent = s->owner,
                          .type = declaration,
                          .name = declaration + start,
                          .byte_offset = byte_in_scene(s)};
    nqm_status status = read_values(s, node.kind, &v);
    node.value = v.text;
    if (status == NQM_OK && s->is_named && !*s->type && node.kind == NQM_BSDF_STRING && strcmp(node.name, "type") == 0)
        snprintf(s->type, sizeof s->type, "%.*s", MAX_TOKEN - 1, v.text ? v.text : "");
    else if (status == NQM_OK && s->scene.nodes.n - s->owner > MAX_PARAMETERS)
        status = fail(s, "a material or texture with more than 32 parameters");
    else if (status == NQM_OK)
        status = nqm_bsdf_add(&s->scene.nodes, &node, s->path, s->err);
    nqm_free(v.text);
    return status;
}

/* Add the node of a directive, and its parameters. The scanner stops before the next directive. */
static nqm_status read_parameters(scanner *s, const nqm_bsdf_node *directive) {
    s->owner = s->scene.nodes.n;
    nqm_status status = nqm_bsdf_add(&s->scene.nodes, directive, s->path, s->err);
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
static nqm_status read_material(scanner *s, bool is_named) {
    nqm_bsdf_node material = {.parent = NQM_BSDF_ROOT, .byte_offset = byte_in_scene(s)};
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
        status = nqm_pbrt_add(&s->scene, s->owner, s->type, s->refusal, s->err);
    if (status == NQM_OK && is_named)
        status = add_name(s, "material", name, nqm_materials_count(s->scene.materials) - 1);
    nqm_bsdf_cut(&s->scene.nodes, s->owner);
    return status;
}

/* The class of a texture becomes the type of its node, its type the name. */
static nqm_status read_texture_directive(scanner *s) {
    char words[3][MAX_TOKEN];
    const nqm_bsdf_node texture = {.kind = NQM_BSDF_TEXTURE,
                                   .parent = NQM_BSDF_ROOT,
                                   .byte_offset = byte_in_scene(s),
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
    nqm_status status = add_name(s, words[1], words[0], s->scene.nodes.n);
    return status == NQM_OK ? read_parameters(s, &texture) : status;
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

static nqm_status read_directives(scanner *s);

/* Read the file that is the next token; pbrt finds it in the folder of the scene. */
static nqm_status read_included(scanner *s) {
    nqm_map map;
    char *path;
    nqm_status status = next(s);
    if (status == NQM_OK && !s->is_quoted)
        return fail(s, "Include or Import without the name of a file");
    if (status == NQM_OK)
        status = nqm_include_open(&s->includes, s->scene.path, s->token, &map, &path, s->err);
    if (status != NQM_OK || !path)
        return status;
    const scanner outer = *s;
    s->path = path;
    s->text = (const char *)map.data;
    s->n = map.n_bytes;
    s->at = 0;
    status = read_directives(s);
    s->path = outer.path;
    s->text = outer.text;
    s->n = outer.n;
    s->at = outer.at;
    nqm_include_close(&s->includes, &map, path);
    return status;
}

/* Read the directive that is the last token. */
static nqm_status read_directive(scanner *s) {
    const bool is_named = strcmp(s->token, "MakeNamedMaterial") == 0;
    if (strcmp(s->token, "Include") == 0 || strcmp(s->token, "Import") == 0)
        return read_included(s);
    if (strcmp(s->token, "ColorSpace") == 0)
        return read_setting(s, "srgb", "the colour space is not srgb (directive ColorSpace)");
    if (strcmp(s->token, "Attribute") == 0)
        return read_setting(s, NULL, "the directive Attribute changes the defaults of materials or textures");
    if (strcmp(s->token, "Texture") == 0)
        return read_texture_directive(s);
    return is_named || strcmp(s->token, "Material") == 0 ? read_material(s, is_named) : NQM_OK;
}

static nqm_status read_directives(scanner *s) {
    nqm_status status = next(s);
    while (status == NQM_OK && (s->is_quoted || *s->token)) {
        if (!s->is_quoted)
            status = read_directive(s);
        if (status == NQM_OK)
            status = next(s);
    }
    return status;
}

static nqm_status read_scene(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    scanner s = {.scene = {.path = map->path, .names = {.key_of = key_of_named}, .materials = materials},
                 .includes = {.root = map->path, .materials = materials},
                 .path = map->path,
                 .text = (const char *)map->data,
                 .n = map->n_bytes,
                 .err = err};
    if (map->n_bytes > MAX_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: a scene of %zu bytes (byte 0); at most %d are read", map->path,
                        map->n_bytes, MAX_BYTES);
    nqm_status status = nqm_index_reserve(&s.scene.names, 1, err);
    if (status == NQM_OK)
        status = read_directives(&s);
    clear_scene(&s.scene);
    return status;
}

/* true when the first word is a directive of pbrt. */
static bool probe(const nqm_map *map) {
    static const char directives[] =
        " Material MakeNamedMaterial NamedMaterial Accelerator AreaLightSource Attribute Camera "
        "AttributeBegin ColorSpace Film Identity Include Integrator LookAt MakeNamedMedium Option "
        "PixelFilter Rotate Sampler Scale Shape Texture Transform ConcatTransform Translate WorldBegin "
        "LightSource ObjectBegin ReverseOrientation Import TransformBegin MediumInterface ";
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

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_material(const nqm_values *values, const char *name, FILE *stream) {
    static const char *const written[][2] = {{"lambert", "diffuse"},
                                             {"pbrt-conductor", "conductor"},
                                             {"pbrt-coated-diffuse", "coateddiffuse"},
                                             {"pbrt-coated-conductor", "coatedconductor"}};
    char numbers[100];
    size_t at = 0;
    while (strcmp(written[at][0], values->schema->model) != 0)
        ++at;
    fprintf(stream, "MakeNamedMaterial \"%s\"\n    \"string type\" \"%s\"\n", name, written[at][1]);
    for (size_t k = 0; k < values->schema->n_keys; ++k) {
        const nqm_schema_key *key = &values->schema->keys[k];
        const double *v = values->v[k];
        const bool is_pair = key->n == 2 && v[0] != v[1];
        const char *type = key->n == 3 ? "rgb" : key->whole ? "integer" : "float";
        if (!(values->given >> k & 1))
            continue;
        for (size_t c = 0; c < (is_pair ? 2 : 1); ++c)
            fprintf(stream, "    \"%s %s%s\" [ %s ]\n", type,
                    !is_pair ? ""
                    : c      ? "v"
                             : "u",
                    at == 0 ? "reflectance" : key->name,
                    nqm_format_doubles(numbers, sizeof numbers, key->n == 3 ? 3 : 1, v + c, " "));
    }
}

static nqm_status write_pbrt(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                             nqm_error *err) {
    (void)path;
    (void)err;
    for (size_t i = 0; i < n; ++i)
        write_material(&materials[i].values, materials[i].name, stream);
    return NQM_OK;
}

const nqm_material_format nqm_pbrt_format = {
    .name = "pbrt-v4",
    .extensions = ".pbrt",
    .models = "pbrt-conductor lambert pbrt-coated-diffuse pbrt-coated-conductor",
    .probe = probe,
    .read = read_scene,
    .write = write_pbrt,
};
