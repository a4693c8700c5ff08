/* SPDX-License-Identifier: MIT
 *
 * BSDFs of Mitsuba 3 (mitsuba.readthedocs.io, "BSDFs") to shadings: one table of properties for each plugin that has a shading
 * model. Properties that concern sampling only are ignored; any other property that the model does not have is refused, as are
 * all other plugins.
 */
#include "material/mitsuba.h"
#include "material/color_space.h"

#include <math.h>
#include <stdarg.h>
#include <strings.h>

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

enum { MAX_NODES = 100 * 1000 };

nqm_status nqm_mitsuba_add(nqm_mitsuba_nodes *nodes, const nqm_mitsuba_node *node, const char *path, nqm_error *err) {
    if (nodes->n == MAX_NODES)
        return nqm_fail(err, NQM_ERR_LIMIT, node->byte_offset, "%s: more than %d properties of BSDFs (byte %lld)", path,
                        MAX_NODES, (long long)node->byte_offset);
    nqm_mitsuba_node *list = nqm_grow(nodes->list, &nodes->max_n, nodes->n + 1, sizeof *list);
    if (!list)
        return nqm_fail_nomem(err, (nodes->n + 1) * sizeof *list);
    nodes->list = list;
    nqm_mitsuba_node copy = *node;
    char **texts[] = {&copy.type, &copy.name, &copy.id, &copy.value};
    enum { N = sizeof texts / sizeof *texts };
    nqm_array arrays[N];
    char *blocks[N];
    for (size_t i = 0; i < N; ++i)
        arrays[i] = (nqm_array){&blocks[i], *texts[i] ? strlen(*texts[i]) + 1 : 1, 1};
    nqm_status status = nqm_alloc_arrays(N, arrays, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < N; ++i)
        *texts[i] = memcpy(blocks[i], *texts[i] ? *texts[i] : "", arrays[i].n);
    nodes->list[nodes->n++] = copy;
    return NQM_OK;
}

void nqm_mitsuba_free(nqm_mitsuba_nodes *nodes) {
    for (size_t i = 0; i < nodes->n; ++i)
        nqm_free(nodes->list[i].type); /* the first text owns the block */
    nqm_free(nodes->list);
}

/* The next child of `parent` from index `i` on; nodes->n when there is none. */
static size_t next_child(const nqm_mitsuba_nodes *nodes, size_t parent, size_t i) {
    /* A child comes after its parent, and the first node that is no descendant ends the search. */
    for (; i < nodes->n && nodes->list[i].parent != NQM_MITSUBA_ROOT && nodes->list[i].parent >= parent; ++i)
        if (nodes->list[i].parent == parent)
            return i;
    return nodes->n;
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

/* One material that is being translated. */
typedef struct translation {
    const nqm_mitsuba_nodes *nodes;
    const nqm_index *ids; /* of BSDFs */
    nqm_shading shading;
    const char *file;    /* file of a measured material; NULL: the shading is the result */
    char refusal[400];   /* "": accepted */
    int64_t byte_offset; /* position of the refused property */
    uint32_t given;      /* bit i: rule i of the plugin has been read */
    double alpha_uv[2];  /* NAN: not given */
    const nqm_mitsuba_node *metal;
    double int_ior, ext_ior;
} translation;

/* Record why the material is refused; returns false. */
__attribute__((format(printf, 3, 4))) static bool refuse(translation *t, const nqm_mitsuba_node *node,
                                                         const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(t->refusal, sizeof t->refusal, format, arguments);
    va_end(arguments);
    t->byte_offset = node->byte_offset;
    return false;
}

size_t nqm_parse_numbers(const char *text, size_t max_n, double *v) {
    static const char separators[] = " ,\t\r\n";
    size_t n = 0;
    for (text += strspn(text, separators); *text; text += strspn(text, separators)) {
        if (n == max_n || !nqm_parse_double(text, &text, &v[n]) || (*text && !strchr(separators, *text)))
            return 0;
        ++n;
    }
    return n;
}

/* "#rrggbb" in the encoding of sRGB (IEC 61966-2-1) to linear values. */
static bool parse_hex(const char *text, double rgb[3]) {
    if (*text != '#' || strlen(text) != 7 || strspn(text + 1, "0123456789abcdefABCDEF") != 6)
        return false;
    for (size_t c = 0; c < 3; ++c) {
        unsigned byte = 0;
        sscanf(text + 1 + 2 * c, "%2x", &byte);
        rgb[c] = nqm_srgb_to_linear(byte / 255.0);
    }
    return true;
}

/* A number, or with max_n = 3 also a colour: *n is 1 or 3. */
static bool read_values(translation *t, const nqm_mitsuba_node *node, size_t max_n, size_t *n, double v[3]) {
    switch (node->kind) {
    case NQM_MITSUBA_OTHER:
    case NQM_MITSUBA_BSDF:
        return refuse(t, node, "%s is a texture or plugin ('%.40s'); only constants are read", node->name, node->type);
    case NQM_MITSUBA_REF:
        return refuse(t, node, "%s refers to the object '%.40s'; only constants are read", node->name, node->id);
    case NQM_MITSUBA_STRING:
    case NQM_MITSUBA_BOOLEAN:
        return refuse(t, node, "%s needs a number, not '%.40s'", node->name, node->value);
    case NQM_MITSUBA_SPECTRUM:
        if (!*node->value || strchr(node->value, ':'))
            return refuse(t, node, "%s is a spectrum by wavelength; only constants and RGB are read", node->name);
        break;
    case NQM_MITSUBA_NUMBER:
    case NQM_MITSUBA_RGB:
        break;
    }
    if (node->kind == NQM_MITSUBA_RGB && parse_hex(node->value, v)) {
        *n = 3;
    } else {
        *n = nqm_parse_numbers(node->value, 3, v);
        if (*n != 1 && (*n != 3 || node->kind != NQM_MITSUBA_RGB))
            return refuse(t, node, "%s needs %s, not '%.40s'", node->name,
                          node->kind == NQM_MITSUBA_RGB ? "one or three numbers" : "a number", node->value);
    }
    if (*n == 3 && max_n == 1 && !(v[0] == v[1] && v[0] == v[2]))
        return refuse(t, node, "%s needs a number, not the colour '%.40s'", node->name, node->value);
    *n = nqm_smaller(*n, max_n);
    return true;
}

static bool read_number(translation *t, const nqm_mitsuba_node *node, double *v) {
    double values[3];
    size_t n;
    if (!read_values(t, node, 1, &n, values))
        return false;
    *v = values[0];
    return true;
}

/* What a property becomes; key is that of the shading. */
typedef bool read_property(translation *t, const nqm_mitsuba_node *node, const char *key);

/* Set a property of the shading, once. */
static bool set(translation *t, const nqm_mitsuba_node *node, const char *key, size_t n, const double *v) {
    if (nqm_shading_find(&t->shading, key))
        return refuse(t, node, "%s is given twice", key);
    nqm_shading_set(&t->shading, key, n, v);
    return true;
}

static bool number(translation *t, const nqm_mitsuba_node *node, const char *key) {
    double v;
    return read_number(t, node, &v) && set(t, node, key, 1, &v);
}

static bool colour(translation *t, const nqm_mitsuba_node *node, const char *key) {
    double v[3];
    size_t n;
    return read_values(t, node, 3, &n, v) && set(t, node, key, n, v);
}

static bool ignored(translation *t, const nqm_mitsuba_node *node, const char *key) {
    (void)t;
    (void)node;
    (void)key;
    return true;
}

/* Mitsuba clamps alpha so that the distribution is finite. */
static bool alpha(translation *t, const nqm_mitsuba_node *node, const char *key) {
    double v;
    if (!read_number(t, node, &v))
        return false;
    v = fmax(v, 1e-4);
    if (strcmp(node->name, "alpha") == 0)
        nqm_shading_set(&t->shading, key, 1, &v);
    else
        t->alpha_uv[strcmp(node->name, "alpha_v") == 0] = v;
    return true;
}

static bool distribution(translation *t, const nqm_mitsuba_node *node, const char *key) {
    static const char *const names[] = {"beckmann", "ggx"};
    for (size_t i = 0; i < 2; ++i) {
        const double v = (double)i;
        if (strcmp(node->value, names[i]) == 0) {
            nqm_shading_set(&t->shading, key, 1, &v);
            return true;
        }
    }
    return refuse(t, node, "distribution is '%.40s'; Mitsuba has beckmann and ggx", node->value);
}

/* The reason `why` refuses values other than 0. */
static bool neutral(translation *t, const nqm_mitsuba_node *node, const char *why) {
    double v;
    if (!read_number(t, node, &v))
        return false;
    return v == 0 ? true : refuse(t, node, "%s is %s, not 0: %s", node->name, node->value, why);
}

/* Burley's specular level, which stands for eta. */
static bool specular(translation *t, const nqm_mitsuba_node *node, const char *key) {
    double v;
    (void)key;
    if (!read_number(t, node, &v))
        return false;
    if (!(v >= 0 && v <= 1))
        return refuse(t, node, "specular is %s; its range is 0 to 1", node->value);
    if (nqm_shading_find(&t->shading, "eta"))
        return refuse(t, node, "specular is given as well as eta");
    const double eta = 2 / (1 - sqrt(0.08 * v)) - 1;
    nqm_shading_set(&t->shading, "eta", 1, &eta);
    return true;
}

/* A number or one of Mitsuba's names. */
static bool index_of_refraction(translation *t, const nqm_mitsuba_node *node, const char *key) {
    static const struct {
        const char *name;
        double ior;
    } named[] = {{"vacuum", 1},        {"helium", 1.000036},        {"hydrogen", 1.000132},
                 {"air", 1.000277},    {"carbon dioxide", 1.00045}, {"water", 1.333},
                 {"acetone", 1.36},    {"ethanol", 1.361},          {"carbon tetrachloride", 1.461},
                 {"glycerol", 1.4729}, {"benzene", 1.501},          {"silicone oil", 1.52045},
                 {"bromine", 1.661},   {"water ice", 1.31},         {"fused quartz", 1.458},
                 {"pyrex", 1.47},      {"acrylic glass", 1.49},     {"polypropylene", 1.49},
                 {"bk7", 1.5046},      {"sodium chloride", 1.544},  {"amber", 1.55},
                 {"pet", 1.575},       {"diamond", 2.419}};
    double *ior = strcmp(key, "int_ior") == 0 ? &t->int_ior : &t->ext_ior;
    if (node->kind != NQM_MITSUBA_STRING)
        return read_number(t, node, ior);
    for (size_t i = 0; i < sizeof named / sizeof *named; ++i)
        if (strcasecmp(node->value, named[i].name) == 0) {
            *ior = named[i].ior;
            return true;
        }
    return refuse(t, node, "%s: the index of refraction of '%.40s' is not known", node->name, node->value);
}

static bool flag(translation *t, const nqm_mitsuba_node *node, const char *key) {
    const double v = strcmp(node->value, "true") == 0;
    if (node->kind != NQM_MITSUBA_BOOLEAN || (v == 0 && strcmp(node->value, "false") != 0))
        return refuse(t, node, "%s needs true or false", node->name);
    return set(t, node, key, 1, &v);
}

static bool metal(translation *t, const nqm_mitsuba_node *node, const char *key) {
    (void)key;
    t->metal = node;
    return true;
}

static bool file(translation *t, const nqm_mitsuba_node *node, const char *key) {
    (void)key;
    t->file = node->value;
    return *node->value ? true : refuse(t, node, "filename is empty");
}

/* ---- plugins ----------------------------------------------------------------------------------------------------- */

enum { MAX_RULES = 24 };
typedef struct plugin {
    const char *type;
    const char *refusal;                                          /* NULL: the plugin is read */
    const char *model;                                            /* shading model; NULL: a measured file */
    bool (*finish)(translation *t, const nqm_mitsuba_node *bsdf); /* after the properties, or NULL */
    struct {
        const char *name;
        read_property *read;
        const char *key; /* NULL: as the name */
    } rules[MAX_RULES];
} plugin;

static bool finish_alpha(translation *t, const nqm_mitsuba_node *bsdf) {
    const double *uv = t->alpha_uv;
    if (isnan(uv[0]) && isnan(uv[1]))
        return true;
    if (isnan(uv[0]) || isnan(uv[1]))
        return refuse(t, bsdf, "only one of alpha_u and alpha_v is given");
    if (uv[0] != uv[1])
        return refuse(t, bsdf, "alpha_u and alpha_v differ; anisotropic materials are not supported");
    if (nqm_shading_find(&t->shading, "alpha"))
        return refuse(t, bsdf, "alpha is given as well as alpha_u and alpha_v");
    nqm_shading_set(&t->shading, "alpha", 1, uv);
    return true;
}

static bool finish_conductor(translation *t, const nqm_mitsuba_node *bsdf) {
    if (!finish_alpha(t, bsdf))
        return false;
    if (!t->metal || strcmp(t->metal->value, "none") == 0)
        return true; /* eta = 0, k = 1: the defaults, a mirror */
    const nqm_metal *m = nqm_metal_find(t->metal->value);
    if (nqm_shading_find(&t->shading, "eta") || nqm_shading_find(&t->shading, "k"))
        return refuse(t, t->metal, "material is given as well as eta or k");
    if (!m) {
        char names[300];
        nqm_metal_names(names, sizeof names);
        return refuse(t, t->metal, "the indices of the material '%.40s' are not known; these are: %s", t->metal->value,
                      names);
    }
    nqm_shading_set(&t->shading, "eta", 3, m->eta);
    nqm_shading_set(&t->shading, "k", 3, m->k);
    return true;
}

static bool finish_plastic(translation *t, const nqm_mitsuba_node *bsdf) {
    const double eta = t->int_ior / t->ext_ior;
    if (!finish_alpha(t, bsdf))
        return false;
    if (!(eta >= 1.05 && eta <= 3))
        return refuse(t, bsdf, "int_ior / ext_ior is %.4g; the model's range is 1.05 to 3", eta);
    nqm_shading_set(&t->shading, "eta", 1, &eta);
    return true;
}

static bool finish_diffuse(translation *t, const nqm_mitsuba_node *bsdf) {
    const double grey = 0.5; /* Mitsuba's default; the key is required */
    (void)bsdf;
    if (!nqm_shading_find(&t->shading, "kd"))
        nqm_shading_set(&t->shading, "kd", 1, &grey);
    return true;
}

static bool finish_measured(translation *t, const nqm_mitsuba_node *bsdf) {
    return t->file ? true : refuse(t, bsdf, "filename is missing");
}

#define DELTA     "a smooth surface reflects into one direction only; only rough ones have a BRDF"
#define TRANSMITS "transmission is not supported"
#define LAYERED   "combinations of BSDFs and textures are not supported"
static const plugin plugins[] = {
    {.type = "roughconductor",
     .model = "rough-conductor",
     .finish = finish_conductor,
     .rules = {{"alpha", alpha, NULL},
               {"alpha_u", alpha, NULL},
               {"alpha_v", alpha, NULL},
               {"distribution", distribution, NULL},
               {"eta", colour, NULL},
               {"k", colour, NULL},
               {"material", metal, NULL},
               {"specular_reflectance", colour, NULL},
               {"sample_visible", ignored, NULL}}},
    {.type = "roughplastic",
     .model = "rough-plastic",
     .finish = finish_plastic,
     .rules = {{"alpha", alpha, NULL},
               {"alpha_u", alpha, NULL},
               {"alpha_v", alpha, NULL},
               {"distribution", distribution, NULL},
               {"int_ior", index_of_refraction, NULL},
               {"ext_ior", index_of_refraction, NULL},
               {"diffuse_reflectance", colour, NULL},
               {"specular_reflectance", colour, NULL},
               {"nonlinear", flag, NULL},
               {"sample_visible", ignored, NULL}}},
    {.type = "principled",
     .model = "principled",
     .rules = {{"base_color", colour, NULL},
               {"roughness", number, NULL},
               {"metallic", number, NULL},
               {"eta", number, NULL},
               {"specular", specular, NULL},
               {"spec_tint", number, NULL},
               {"sheen", number, NULL},
               {"sheen_tint", number, NULL},
               {"flatness", number, NULL},
               {"clearcoat", number, NULL},
               {"clearcoat_gloss", number, NULL},
               {"anisotropic", neutral, "anisotropic materials are not supported"},
               {"spec_trans", neutral, "transmission is not supported"},
               {"main_specular_sampling_rate", ignored, NULL},
               {"clearcoat_sampling_rate", ignored, NULL},
               {"diffuse_reflectance_sampling_rate", ignored, NULL}}},
    {.type = "diffuse", .model = "lambert", .finish = finish_diffuse, .rules = {{"reflectance", colour, "kd"}}},
    {.type = "measured", .finish = finish_measured, .rules = {{"filename", file, NULL}}},
    {.type = "conductor", .refusal = DELTA},
    {.type = "plastic", .refusal = DELTA},
    {.type = "dielectric", .refusal = DELTA},
    {.type = "thindielectric", .refusal = DELTA},
    {.type = "roughdielectric", .refusal = TRANSMITS},
    {.type = "principledthin", .refusal = TRANSMITS},
    {.type = "hair", .refusal = "hair has no BRDF of a surface"},
    {.type = "pplastic", .refusal = "polarised materials are not supported"},
    {.type = "measured_polarized", .refusal = "polarised materials are not supported"},
    {.type = "polarizer", .refusal = "polarised materials are not supported"},
    {.type = "retarder", .refusal = "polarised materials are not supported"},
    {.type = "circular", .refusal = "polarised materials are not supported"},
    {.type = "null", .refusal = "it reflects nothing"},
    {.type = "mask", .refusal = "opacity is not supported"},
    {.type = "blendbsdf", .refusal = LAYERED},
    {.type = "bumpmap", .refusal = LAYERED},
    {.type = "normalmap", .refusal = LAYERED},
    {.type = "twosided"},
};
enum { N_PLUGINS = sizeof plugins / sizeof *plugins };

static const plugin *find_plugin(const char *type) {
    for (size_t i = 0; i < N_PLUGINS; ++i)
        if (strcmp(plugins[i].type, type) == 0)
            return &plugins[i];
    return NULL;
}

bool nqm_mitsuba_is_bsdf(const char *type) {
    return find_plugin(type) != NULL;
}

static bool read_child(translation *t, const plugin *p, const nqm_mitsuba_node *node) {
    for (size_t i = 0; i < MAX_RULES && p->rules[i].name; ++i)
        if (strcmp(p->rules[i].name, node->name) == 0) {
            if (t->given >> i & 1)
                return refuse(t, node, "%s is given twice", node->name);
            t->given |= 1U << i;
            return p->rules[i].read(t, node, p->rules[i].key ? p->rules[i].key : node->name);
        }
    return refuse(t, node, "%s has no property '%.40s'", p->type, node->name);
}

/* Translate the properties of BSDF `at`. */
static bool read_bsdf(translation *t, size_t at) {
    const nqm_mitsuba_node *bsdf = &t->nodes->list[at];
    const plugin *p = find_plugin(bsdf->type);
    if (!p)
        return refuse(t, bsdf, "the plugin is not known");
    if (p->refusal)
        return refuse(t, bsdf, "%s", p->refusal);
    if (p->model)
        strcpy(t->shading.model, p->model);
    for (size_t i = next_child(t->nodes, at, at + 1); i < t->nodes->n; i = next_child(t->nodes, at, i + 1))
        if (!read_child(t, p, &t->nodes->list[i]))
            return false;
    return !p->finish || p->finish(t, bsdf);
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static nqm_index_key key_of_bsdf(const void *value) {
    return (nqm_index_key){NULL, NULL, ((const nqm_mitsuba_node *)value)->id};
}

/* The first BSDF of that id, or nodes->n. */
static size_t find_bsdf(const translation *t, const char *id) {
    const nqm_mitsuba_node *bsdf = nqm_index_find(t->ids, (nqm_index_key){NULL, NULL, id});
    return bsdf ? (size_t)(bsdf - t->nodes->list) : t->nodes->n;
}

/* The BSDF inside a twosided one; nodes->n and a refusal when there is not exactly one. */
static size_t unwrap(translation *t, size_t at) {
    const nqm_mitsuba_nodes *nodes = t->nodes;
    size_t inner = nodes->n, n_inner = 0;
    for (size_t i = next_child(nodes, at, at + 1); i < nodes->n; i = next_child(nodes, at, i + 1)) {
        const nqm_mitsuba_node *node = &nodes->list[i];
        if (node->kind != NQM_MITSUBA_BSDF && node->kind != NQM_MITSUBA_REF)
            continue;
        inner = node->kind == NQM_MITSUBA_BSDF ? i : find_bsdf(t, node->id);
        ++n_inner;
        if (inner == nodes->n)
            refuse(t, node, "there is no BSDF '%.40s' in this file", node->id);
    }
    if (n_inner != 1)
        refuse(t, &nodes->list[at], n_inner ? "its two sides have different BSDFs" : "it contains no BSDF");
    else if (inner < nodes->n && strcmp(nodes->list[inner].type, "twosided") == 0)
        refuse(t, &nodes->list[at], "it contains another twosided BSDF");
    return *t->refusal ? nodes->n : inner;
}

static nqm_status add_material(const nqm_mitsuba_nodes *nodes, const nqm_index *ids, size_t at,
                               nqm_materials *materials, nqm_error *err) {
    translation t = {.nodes = nodes,
                     .ids = ids,
                     .alpha_uv = {NAN, NAN},
                     .int_ior = 1.49,
                     .ext_ior = 1.000277,
                     .byte_offset = nodes->list[at].byte_offset};
    const bool is_wrapped = strcmp(nodes->list[at].type, "twosided") == 0;
    const size_t inner = is_wrapped ? unwrap(&t, at) : at;
    const nqm_mitsuba_node *bsdf = &nodes->list[inner < nodes->n ? inner : at];
    nqm_material_info info = {.name = *nodes->list[at].id ? nodes->list[at].id : bsdf->id, .surface = bsdf->type};
    const bool ok = inner < nodes->n && read_bsdf(&t, inner);
    info.byte_offset = t.byte_offset;
    if (ok && !t.file)
        return nqm_materials_add_shading(materials, info.name, info.surface, &t.shading, info.byte_offset, err);
    if (ok)
        info.spec = t.file;
    else
        info.refusal = t.refusal;
    return nqm_materials_add(materials, &info, err);
}

nqm_status nqm_mitsuba_translate(const nqm_mitsuba_nodes *nodes, nqm_materials *materials, nqm_error *err) {
    nqm_index ids;
    nqm_status status = nqm_index_create(nodes->n, key_of_bsdf, &ids, err);
    for (size_t i = 0; status == NQM_OK && i < nodes->n; ++i)
        if (nodes->list[i].kind == NQM_MITSUBA_BSDF)
            nqm_index_add(&ids, &nodes->list[i]);
    for (size_t i = 0; status == NQM_OK && i < nodes->n; ++i)
        if (nodes->list[i].parent == NQM_MITSUBA_ROOT && nodes->list[i].kind == NQM_MITSUBA_BSDF)
            status = add_material(nodes, &ids, i, materials, err);
    nqm_index_free(&ids);
    return status;
}
