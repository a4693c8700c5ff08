/* SPDX-License-Identifier: MIT
 *
 * pbrt-v4 scenes (pbrt.org/fileformat-v4): the materials of the directives Material and MakeNamedMaterial; other directives are
 * skipped. `conductor`, `diffuse` and `measured` are read; coated materials are not, because pbrt evaluates them by random walks.
 * Colours are those of the default colour space, linear sRGB. pbrt is a spectral renderer: eta and k given as "metal-Au-eta" are the
 * RGB values of metals.c.
 */
#include "material/mitsuba.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>

enum { MAX_PARAMETERS = 32, MAX_BYTES = 256 << 20, MAX_TOKEN = 256 };

/* ---- tokens ------------------------------------------------------------------------------------------------------ */

typedef struct scanner {
    const char *path, *text;
    size_t n, at;
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

typedef enum kind { NUMBER, RGB, SPECTRUM, TEXT, BOOLEAN, TEXTURE, OTHER } kind;

/* "rgb eta" [ .2 .9 1.1 ]. At most 3 values are kept. */
typedef struct parameter {
    kind kind;
    char name[MAX_TOKEN];
    char text[MAX_TOKEN]; /* text of the first value */
    size_t n;             /* values in the file */
    bool has_words;       /* one of them is no number */
    double v[3];
    int64_t byte_offset;
} parameter;

typedef struct material {
    char name[MAX_TOKEN], type[MAX_TOKEN];
    int64_t byte_offset;
    size_t n;
    parameter list[MAX_PARAMETERS];
} material;

static kind kind_of(const char *type) {
    static const struct {
        const char *type;
        kind kind;
    } kinds[] = {{"float", NUMBER}, {"integer", NUMBER}, {"rgb", RGB},        {"spectrum", SPECTRUM},
                 {"string", TEXT},  {"bool", BOOLEAN},   {"texture", TEXTURE}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        if (strcmp(type, kinds[i].type) == 0)
            return kinds[i].kind;
    return OTHER;
}

/* Add the last token to the values of a parameter. */
static nqm_status add_value(scanner *s, parameter *p) {
    const char *end = s->token;
    double v = 0;
    if (!s->is_quoted && strcmp(s->token, "true") != 0 && strcmp(s->token, "false") != 0 &&
        (!nqm_parse_double(s->token, &end, &v) || *end))
        return fail(s, "a value that is not a number, string, true or false");
    p->has_words = p->has_words || s->is_quoted || *end || !*s->token;
    if (p->n == 0)
        strcpy(p->text, s->token);
    if (p->n < 3)
        p->v[p->n] = v;
    ++p->n;
    return NQM_OK;
}

/* The values behind a declaration, with or without brackets. */
static nqm_status read_values(scanner *s, parameter *p) {
    nqm_status status = next(s);
    if (status != NQM_OK)
        return status;
    if (s->is_quoted || strcmp(s->token, "[") != 0)
        return add_value(s, p);
    while ((status = next(s)) == NQM_OK && (s->is_quoted || strcmp(s->token, "]") != 0)) {
        if (!s->is_quoted && !*s->token)
            return fail(s, "a list without its closing bracket");
        status = add_value(s, p);
        if (status != NQM_OK)
            return status;
    }
    return status;
}

/* Read a parameter, whose declaration "type name" is the last token. */
static nqm_status read_parameter(scanner *s, parameter *p) {
    const size_t blank = strcspn(s->token, " \t"), start = blank + strspn(s->token + blank, " \t");
    *p = (parameter){.byte_offset = s->byte_offset};
    if (!blank || !s->token[start])
        return fail(s, "a parameter that is not declared as \"type name\"");
    memcpy(p->name, s->token + start, strlen(s->token + start) + 1);
    p->name[strcspn(p->name, " \t")] = 0;
    s->token[blank] = 0;
    p->kind = kind_of(s->token);
    return read_values(s, p);
}

/* Read the parameters of a directive. The scanner stops before the next directive. */
static nqm_status read_parameters(scanner *s, material *m) {
    for (;;) {
        const scanner before = *s;
        parameter p;
        nqm_status status = next(s);
        if (status != NQM_OK)
            return status;
        if (!s->is_quoted) {
            *s = before;
            return NQM_OK;
        }
        if ((status = read_parameter(s, &p)) != NQM_OK)
            return status;
        if (m->n == MAX_PARAMETERS)
            return fail(s, "a material with more than 32 parameters");
        m->list[m->n++] = p;
    }
}

/* ---- materials to shadings --------------------------------------------------------------------------------------- */

typedef struct translation {
    const material *m;
    nqm_shading shading;
    char refusal[400];
    int64_t byte_offset;
    bool remap;
    double roughness[2]; /* u, v */
} translation;

__attribute__((format(printf, 3, 4))) static bool refuse(translation *t, int64_t byte_offset, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(t->refusal, sizeof t->refusal, format, arguments);
    va_end(arguments);
    t->byte_offset = byte_offset;
    return false;
}

static const parameter *find(const translation *t, const char *name) {
    for (size_t i = 0; i < t->m->n; ++i)
        if (strcmp(t->m->list[i].name, name) == 0)
            return &t->m->list[i];
    return NULL;
}

/* The names of the material's parameters are among `names`, which ends with NULL. */
static bool only_has(translation *t, const char *const *names) {
    for (size_t i = 0; i < t->m->n; ++i) {
        const parameter *p = &t->m->list[i];
        size_t k = 0;
        while (names[k] && strcmp(names[k], p->name) != 0)
            ++k;
        if (p->kind == TEXTURE)
            return refuse(t, p->byte_offset, "%.40s is a texture; only constants are read", p->name);
        if (!names[k])
            return refuse(t, p->byte_offset, "the parameter '%.40s' is not supported", p->name);
        if (find(t, p->name) != p)
            return refuse(t, p->byte_offset, "%.40s is given twice", p->name);
    }
    return true;
}

/* A number; `v` keeps its value when the parameter is not given. */
static bool get_number(translation *t, const char *name, double *v) {
    const parameter *p = find(t, name);
    if (p && (p->kind != NUMBER || p->n != 1 || p->has_words))
        return refuse(t, p->byte_offset, "%s needs one float", name);
    if (p)
        *v = p->v[0];
    return true;
}

/* "metal-Au-eta" */
static bool get_metal(translation *t, const parameter *p, const char *part, double v[3]) {
    char name[MAX_TOKEN] = "", names[300];
    const size_t n = strlen(p->text), n_part = strlen(part);
    if (n > 7 + n_part && strncmp(p->text, "metal-", 6) == 0 && p->text[n - n_part - 1] == '-' &&
        strcmp(p->text + n - n_part, part) == 0)
        memcpy(name, p->text + 6, n - 7 - n_part);
    const nqm_metal *metal = nqm_metal_find(name);
    if (!metal) {
        nqm_metal_names(names, sizeof names);
        return refuse(t, p->byte_offset, "%s: the spectrum '%.40s' is not known; these metals are: %s", p->name,
                      p->text, names);
    }
    memcpy(v, strcmp(part, "k") == 0 ? metal->k : metal->eta, 3 * sizeof *v);
    return true;
}

/* A colour; `v` keeps its value when the parameter is not given. */
static bool get_colour(translation *t, const char *name, double v[3]) {
    const parameter *p = find(t, name);
    if (!p)
        return true;
    if (p->kind == SPECTRUM && (strcmp(name, "eta") == 0 || strcmp(name, "k") == 0) && p->n == 1)
        return get_metal(t, p, name, v);
    if (p->kind == SPECTRUM)
        return refuse(t, p->byte_offset, "%s is a spectrum by wavelength; only RGB is read", name);
    if (p->kind != RGB || p->n != 3 || p->has_words)
        return refuse(t, p->byte_offset, "%s needs three numbers, \"rgb %s\" [ r g b ]", name, name);
    memcpy(v, p->v, sizeof p->v);
    return true;
}

static bool get_bool(translation *t, const char *name, bool *v) {
    const parameter *p = find(t, name);
    const bool is_true = p && strcmp(p->text, "true") == 0;
    if (p && (p->kind != BOOLEAN || p->n != 1 || (!is_true && strcmp(p->text, "false") != 0)))
        return refuse(t, p->byte_offset, "%s needs true or false", name);
    if (p)
        *v = is_true;
    return true;
}

/* eta and k from a reflectance at normal incidence, as pbrt, which clamps r to 0.9999. */
static bool reflectance_index(translation *t, double eta[3], double k[3]) {
    const parameter *p = find(t, "reflectance");
    double r[3];
    if (!p)
        return true;
    if (find(t, "eta") || find(t, "k"))
        return refuse(t, p->byte_offset, "reflectance is given as well as eta or k");
    if (!get_colour(t, "reflectance", r))
        return false;
    for (size_t c = 0; c < 3; ++c) {
        const double clamped = fmin(fmax(r[c], 0), 0.9999);
        eta[c] = 1;
        k[c] = 2 * sqrt(clamped / (1 - clamped));
    }
    return true;
}

static bool conductor_roughness(translation *t, double *roughness) {
    double common = 0;
    bool remap = true;
    if (!get_number(t, "roughness", &common) || !get_bool(t, "remaproughness", &remap))
        return false;
    double u = common, v = common;
    if (!get_number(t, "uroughness", &u) || !get_number(t, "vroughness", &v))
        return false;
    if (u != v)
        return refuse(t, t->m->byte_offset,
                      "uroughness and vroughness differ; anisotropic materials are not supported");
    if (u < 0)
        return refuse(t, t->m->byte_offset, "the roughness is negative");
    *roughness = remap ? u : u * u;
    if (!(*roughness >= 1e-6))
        return refuse(t, t->m->byte_offset,
                      "a smooth surface reflects into one direction only; only rough ones have a BRDF");
    return true;
}

static bool read_conductor(translation *t) {
    static const char *const names[] = {"eta",        "k",          "reflectance",    "roughness",
                                        "uroughness", "vroughness", "remaproughness", NULL};
    const nqm_metal *copper = nqm_metal_find("Cu"); /* pbrt's default */
    double roughness, eta[3], k[3];
    memcpy(eta, copper->eta, sizeof eta);
    memcpy(k, copper->k, sizeof k);
    if (!only_has(t, names) || !conductor_roughness(t, &roughness) || !get_colour(t, "eta", eta) ||
        !get_colour(t, "k", k) || !reflectance_index(t, eta, k))
        return false;
    strcpy(t->shading.model, "pbrt-conductor");
    nqm_shading_set(&t->shading, "roughness", 1, &roughness);
    nqm_shading_set(&t->shading, "eta", 3, eta);
    nqm_shading_set(&t->shading, "k", 3, k);
    return true;
}

static bool read_diffuse(translation *t) {
    static const char *const names[] = {"reflectance", NULL};
    double r[3] = {0.5, 0.5, 0.5};
    if (!only_has(t, names) || !get_colour(t, "reflectance", r))
        return false;
    for (size_t c = 0; c < 3; ++c)
        r[c] = fmin(fmax(r[c], 0), 1); /* as pbrt */
    strcpy(t->shading.model, "lambert");
    nqm_shading_set(&t->shading, "kd", 3, r);
    return true;
}

static bool read_measured(translation *t) {
    static const char *const names[] = {"filename", NULL};
    const parameter *p = find(t, "filename");
    if (!only_has(t, names))
        return false;
    return p && p->kind == TEXT && *p->text ? true : refuse(t, t->m->byte_offset, "filename is missing");
}

#define WALKS     "pbrt evaluates layers by random walks; there is no formula"
#define TRANSMITS "transmission is not supported"
static const struct {
    const char *type, *refusal;
    bool (*read)(translation *t);
} types[] = {{"conductor", NULL, read_conductor},
             {"diffuse", NULL, read_diffuse},
             {"measured", NULL, read_measured},
             {"coateddiffuse", WALKS, NULL},
             {"coatedconductor", WALKS, NULL},
             {"dielectric", TRANSMITS, NULL},
             {"thindielectric", TRANSMITS, NULL},
             {"diffusetransmission", TRANSMITS, NULL},
             {"subsurface", "subsurface scattering is not supported", NULL},
             {"hair", "hair has no BRDF of a surface", NULL},
             {"mix", "mixtures of materials are not supported", NULL},
             {"interface", "it reflects nothing", NULL}};
enum { N_TYPES = sizeof types / sizeof *types };

static bool translate(translation *t) {
    for (size_t i = 0; i < N_TYPES; ++i)
        if (strcmp(types[i].type, t->m->type) == 0)
            return types[i].refusal ? refuse(t, t->m->byte_offset, "%s", types[i].refusal) : types[i].read(t);
    return refuse(t, t->m->byte_offset, "the type '%.40s' is not known", t->m->type);
}

static nqm_status add_material(const scanner *s, const material *m, nqm_materials *materials) {
    translation t = {.m = m, .byte_offset = m->byte_offset};
    nqm_material_info info = {.name = m->name, .surface = m->type};
    const bool ok = s->refusal ? refuse(&t, m->byte_offset, "%s", s->refusal) : translate(&t);
    info.byte_offset = t.byte_offset;
    if (ok && *t.shading.model)
        return nqm_materials_add_shading(materials, info.name, info.surface, &t.shading, info.byte_offset, s->err);
    if (ok)
        info.spec = find(&t, "filename")->text;
    else
        info.refusal = t.refusal;
    return nqm_materials_add(materials, &info, s->err);
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* The type of a material: a string parameter of a named one, the word after the directive of others. */
static nqm_status read_material(scanner *s, bool is_named, material *m) {
    m->n = 0;
    m->name[0] = m->type[0] = 0;
    m->byte_offset = s->byte_offset;
    nqm_status status = next(s);
    if (status == NQM_OK && !s->is_quoted)
        return fail(s, is_named ? "MakeNamedMaterial without the name of a material"
                                : "Material without the type of a material");
    if (status == NQM_OK) {
        strcpy(is_named ? m->name : m->type, s->token);
        status = read_parameters(s, m);
    }
    for (size_t i = 0; status == NQM_OK && is_named && i < m->n; ++i)
        if (!*m->type && strcmp(m->list[i].name, "type") == 0 && m->list[i].kind == TEXT) {
            strcpy(m->type, m->list[i].text);
            m->list[i--] = m->list[--m->n];
        }
    return status;
}

/* Directives that change what the parameters of later materials mean. They end with the enclosing attribute block, which is not
 * tracked: all materials after them are refused. */
static nqm_status read_setting(scanner *s, const char *neutral, const char *refusal) {
    const scanner before = *s;
    nqm_status status = next(s);
    if (status == NQM_OK && (strcmp(s->token, "material") == 0 || (neutral && strcmp(s->token, neutral) != 0)))
        s->refusal = refusal;
    if (!s->is_quoted) {
        const char *kept = s->refusal;
        *s = before;
        s->refusal = kept;
    }
    return status;
}

/* Read the directive that is the last token. m: scratch. */
static nqm_status read_directive(scanner *s, material *m, nqm_materials *materials) {
    const bool is_named = strcmp(s->token, "MakeNamedMaterial") == 0;
    if (strcmp(s->token, "Include") == 0 || strcmp(s->token, "Import") == 0)
        return fail(s, "included files are not read; name the included file itself");
    if (strcmp(s->token, "ColorSpace") == 0)
        return read_setting(s, "srgb", "the colour space is not srgb (directive ColorSpace)");
    if (strcmp(s->token, "Attribute") == 0)
        return read_setting(s, NULL, "the directive Attribute changes the defaults of materials");
    if (!is_named && strcmp(s->token, "Material") != 0)
        return NQM_OK;
    nqm_status status = read_material(s, is_named, m);
    return status == NQM_OK ? add_material(s, m, materials) : status;
}

static nqm_status read_pbrt(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    scanner s = {.path = map->path, .text = (const char *)map->data, .n = map->n_bytes, .err = err};
    if (map->n_bytes > MAX_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: a scene of %zu bytes (byte 0); at most %d are read", map->path,
                        map->n_bytes, MAX_BYTES);
    material *m = nqm_alloc(1, sizeof *m);
    nqm_status status = m ? next(&s) : nqm_fail_nomem(err, sizeof *m);
    while (status == NQM_OK && (s.is_quoted || *s.token)) {
        if (!s.is_quoted)
            status = read_directive(&s, m, materials);
        if (status == NQM_OK)
            status = next(&s);
    }
    nqm_free(m);
    return status;
}

/* true when the first word is a directive of pbrt. */
static bool probe(const nqm_map *map) {
    static const char *const directives[] = {"Material",
                                             "MakeNamedMaterial",
                                             "NamedMaterial",
                                             "Accelerator",
                                             "AreaLightSource",
                                             "Attribute",
                                             "Camera",
                                             "AttributeBegin",
                                             "ColorSpace",
                                             "Film",
                                             "Identity",
                                             "Include",
                                             "Integrator",
                                             "LookAt",
                                             "MakeNamedMedium",
                                             "Option",
                                             "PixelFilter",
                                             "Rotate",
                                             "Sampler",
                                             "Scale",
                                             "Shape",
                                             "Texture",
                                             "Transform",
                                             "ConcatTransform",
                                             "Translate",
                                             "WorldBegin",
                                             "LightSource",
                                             "ObjectBegin",
                                             "ReverseOrientation"};
    scanner s = {.text = (const char *)map->data, .n = nqm_smaller(map->n_bytes, 4096)};
    skip_blanks(&s);
    for (size_t i = 0; i < sizeof directives / sizeof *directives; ++i) {
        const size_t end = s.at + strlen(directives[i]);
        if (end < s.n && memcmp(s.text + s.at, directives[i], end - s.at) == 0 && is_end(s.text[end]))
            return true;
    }
    return false;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_material(const nqm_shading *shading, const char *name, FILE *stream) {
    const bool is_diffuse = strcmp(shading->model, "lambert") == 0;
    char number[32];
    fprintf(stream, "MakeNamedMaterial \"%s\"\n    \"string type\" \"%s\"\n", name,
            is_diffuse ? "diffuse" : "conductor");
    for (size_t i = 0; i < shading->n; ++i) {
        const nqm_property *p = &shading->properties[i];
        const bool is_number = strcmp(p->key, "roughness") == 0;
        fprintf(stream, "    \"%s %s\" [", is_number ? "float" : "rgb", is_diffuse ? "reflectance" : p->key);
        for (size_t c = 0; c < (is_number ? 1 : 3); ++c)
            fprintf(stream, " %s", nqm_format_double(number, sizeof number, p->v[c]));
        fprintf(stream, " ]\n");
    }
}

static nqm_status write_pbrt(size_t n, const nqm_named_shading *materials, const char *path, FILE *stream,
                             nqm_error *err) {
    (void)path;
    (void)err;
    for (size_t i = 0; i < n; ++i)
        write_material(&materials[i].shading, materials[i].name, stream);
    return NQM_OK;
}

const nqm_material_format nqm_pbrt_format = {
    .name = "pbrt-v4",
    .extensions = ".pbrt",
    .models = "pbrt-conductor lambert",
    .probe = probe,
    .read = read_pbrt,
    .write = write_pbrt,
};
