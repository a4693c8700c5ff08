/* SPDX-License-Identifier: MIT
 *
 * BSDFs of Mitsuba 3 (mitsuba.readthedocs.io, "BSDFs") to shadings: one list of rules for each plugin that has a shading
 * model. Properties that concern sampling only are ignored; any other property that the model does not have is refused, as are
 * all other plugins.
 */
#include "material/mitsuba.h"

#include <math.h>
#include <strings.h>

/* ---- properties -------------------------------------------------------------------------------------------------- */

/* Mitsuba clamps alpha so that the distribution is finite. */
static bool read_alpha(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[4];
    size_t n;
    if (!nqm_bsdf_source.read(r, rule, property, v, &n))
        return false;
    v[0] = fmax(v[0], 1e-4);
    nqm_shading_set(&r->shading, rule->key, 1, v);
    return true;
}

static bool read_distribution(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const nqm_bsdf_node *node = property;
    const double v = strcmp(node->value, "ggx") == 0;
    if (v == 0 && strcmp(node->value, "beckmann") != 0)
        return nqm_refuse(r, node, "distribution is '%.40s'; Mitsuba has beckmann and ggx", node->value);
    nqm_shading_set(&r->shading, rule->key, 1, &v);
    return true;
}

static bool read_eta(nqm_reading *r, const nqm_rule *rule, const void *property) {
    if (nqm_shading_find(&r->shading, "eta"))
        return nqm_refuse(r, property, "eta is given twice: specular stands for it");
    return nqm_rule_set(r, rule, property);
}

/* Burley's specular level, which stands for eta. */
static bool read_specular(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[4];
    size_t n;
    if (!nqm_bsdf_source.read(r, rule, property, v, &n))
        return false;
    if (!(v[0] >= 0 && v[0] <= 1))
        return nqm_refuse(r, property, "specular is %s; its range is 0 to 1", ((const nqm_bsdf_node *)property)->value);
    if (nqm_shading_find(&r->shading, "eta"))
        return nqm_refuse(r, property, "specular is given as well as eta");
    const double eta = 2 / (1 - sqrt(0.08 * v[0])) - 1;
    nqm_shading_set(&r->shading, "eta", 1, &eta);
    return true;
}

static bool read_flag(nqm_reading *r, const nqm_rule *rule, const void *property) {
    bool is_true;
    (void)property; /* the only one of this name */
    if (!nqm_bsdf_flag((nqm_bsdf_reading *)r, rule->name, &is_true))
        return false;
    nqm_shading_set(&r->shading, rule->key, 1, &(double){is_true});
    return true;
}

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

/* A number or one of Mitsuba's names; the value stays when the property is not given. */
static bool read_ior(nqm_bsdf_reading *r, const char *name, double *v) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    if (!node || node->kind != NQM_BSDF_STRING)
        return nqm_bsdf_numbers(r, name, 1, v);
    for (size_t i = 0; i < sizeof named / sizeof *named; ++i)
        if (strcasecmp(node->value, named[i].name) == 0) {
            *v = named[i].ior;
            return true;
        }
    return nqm_refuse(&r->reading, node, "%s: the index of refraction of '%.40s' is not known", name, node->value);
}

/* ---- plugins ----------------------------------------------------------------------------------------------------- */

static bool finish_alpha(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    double alpha[2] = {NAN, NAN};
    if (!nqm_bsdf_numbers(r, "alpha_u", 1, &alpha[0]) || !nqm_bsdf_numbers(r, "alpha_v", 1, &alpha[1]))
        return false;
    if (isnan(alpha[0]) && isnan(alpha[1]))
        return true;
    if (isnan(alpha[0]) || isnan(alpha[1]))
        return nqm_refuse(&r->reading, bsdf, "only one of alpha_u and alpha_v is given");
    if (nqm_shading_find(&r->reading.shading, "alpha"))
        return nqm_refuse(&r->reading, bsdf, "alpha is given as well as alpha_u and alpha_v");
    for (size_t c = 0; c < 2; ++c)
        alpha[c] = fmax(alpha[c], 1e-4);
    nqm_shading_set(&r->reading.shading, "alpha", alpha[0] == alpha[1] ? 1 : 2, alpha);
    return true;
}

static bool finish_conductor(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, "material");
    nqm_shading *shading = &r->reading.shading;
    char names[300];
    if (!finish_alpha(r, bsdf))
        return false;
    if (!node || strcmp(node->value, "none") == 0)
        return true; /* eta = 0, k = 1: the defaults, a mirror */
    const nqm_metal *m = nqm_metal_find(node->value);
    if (nqm_shading_find(shading, "eta") || nqm_shading_find(shading, "k"))
        return nqm_refuse(&r->reading, node, "material is given as well as eta or k");
    nqm_metal_names(names, sizeof names);
    if (!m)
        return nqm_refuse(&r->reading, node, "the indices of the material '%.40s' are not known; these are: %s",
                          node->value, names);
    nqm_shading_set(shading, "eta", 3, m->eta);
    nqm_shading_set(shading, "k", 3, m->k);
    return true;
}

static bool finish_plastic(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    double inside = 1.49, outside = 1.000277;
    if (!read_ior(r, "int_ior", &inside) || !read_ior(r, "ext_ior", &outside) || !finish_alpha(r, bsdf))
        return false;
    const double eta = inside / outside;
    const nqm_property *alpha = nqm_shading_find(&r->reading.shading, "alpha");
    if (alpha && alpha->n == 2)
        return nqm_refuse(&r->reading, bsdf, "alpha_u and alpha_v differ; the roughplastic of Mitsuba has one alpha");
    if (!(eta >= 1.05 && eta <= 3))
        return nqm_refuse(&r->reading, bsdf, "int_ior / ext_ior is %.4g; the model's range is 1.05 to 3", eta);
    nqm_shading_set(&r->reading.shading, "eta", 1, &eta);
    return true;
}

static bool finish_diffuse(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    const double grey = 0.5; /* Mitsuba's default; the key is required */
    (void)bsdf;
    if (!nqm_shading_find(&r->reading.shading, "kd"))
        nqm_shading_set(&r->reading.shading, "kd", 1, &grey);
    return true;
}

#define NUMBER(NAME)                                                                                                   \
    { .name = NAME, .read = nqm_rule_set, .key = NAME, .n = 1 }
#define COLOUR(NAME, KEY)                                                                                              \
    { .name = NAME, .read = nqm_rule_set, .key = KEY, .n = 3 }
#define OWN(NAME, READ)                                                                                                \
    { .name = NAME, .read = READ, .key = NAME, .n = 1 }
#define DELTA     "a smooth surface reflects into one direction only; only rough ones have a BRDF"
#define TRANSMITS "transmission is not supported"
#define LAYERED   "combinations of BSDFs and textures are not supported"
static const nqm_bsdf_plugin plugins[] = {
    {.type = "roughconductor",
     .model = "rough-conductor",
     .finish = finish_conductor,
     .rules = {OWN("alpha", read_alpha), NQM_RULE_LATER("alpha_u"), NQM_RULE_LATER("alpha_v"),
               OWN("distribution", read_distribution), COLOUR("eta", "eta"), COLOUR("k", "k"),
               NQM_RULE_LATER("material"), COLOUR("specular_reflectance", "specular_reflectance"),
               NQM_RULE_IGNORED("sample_visible")}},
    {.type = "roughplastic",
     .model = "rough-plastic",
     .finish = finish_plastic,
     .rules = {OWN("alpha", read_alpha), NQM_RULE_LATER("alpha_u"), NQM_RULE_LATER("alpha_v"),
               OWN("distribution", read_distribution), NQM_RULE_LATER("int_ior"), NQM_RULE_LATER("ext_ior"),
               COLOUR("diffuse_reflectance", "diffuse_reflectance"),
               COLOUR("specular_reflectance", "specular_reflectance"), OWN("nonlinear", read_flag),
               NQM_RULE_IGNORED("sample_visible")}},
    {.type = "principled",
     .model = "principled",
     .rules = {COLOUR("base_color", "base_color"), NUMBER("roughness"), NUMBER("anisotropic"), NUMBER("metallic"),
               OWN("eta", read_eta), OWN("specular", read_specular), NUMBER("spec_tint"), NUMBER("sheen"),
               NUMBER("sheen_tint"), NUMBER("flatness"), NUMBER("clearcoat"), NUMBER("clearcoat_gloss"),
               NQM_RULE_ZERO("spec_trans", TRANSMITS),
               NQM_RULE_IGNORED(
                   "main_specular_sampling_rate clearcoat_sampling_rate diffuse_reflectance_sampling_rate")}},
    {.type = "diffuse", .model = "lambert", .finish = finish_diffuse, .rules = {COLOUR("reflectance", "kd")}},
    {.type = "measured", .rules = {OWN("filename", nqm_bsdf_file)}},
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
    {.type = NULL},
};

bool nqm_mitsuba_is_bsdf(const char *type) {
    return nqm_bsdf_find_plugin(plugins, type) != NULL;
}

const char *nqm_mitsuba_type_of(const char *model) {
    const nqm_bsdf_plugin *p = plugins;
    while (p->type && !(p->model && strcmp(p->model, model) == 0))
        ++p;
    return p->type;
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static nqm_index_key key_of_bsdf(const void *value) {
    return (nqm_index_key){NULL, ((const nqm_bsdf_node *)value)->id};
}

/* The BSDF inside a twosided one; nodes->n and a refusal when there is not exactly one. */
static size_t unwrap(nqm_bsdf_reading *r, const nqm_index *ids, size_t at) {
    const nqm_bsdf_nodes *nodes = r->nodes;
    size_t inner = nodes->n, n_inner = 0;
    for (size_t i = nqm_bsdf_next(nodes, at, at + 1); i < nodes->n; i = nqm_bsdf_next(nodes, at, i + 1)) {
        const nqm_bsdf_node *node = &nodes->list[i], *found = node;
        if (node->kind != NQM_BSDF_BSDF && node->kind != NQM_BSDF_REF)
            continue;
        if (node->kind == NQM_BSDF_REF)
            found = nqm_index_find(ids, (nqm_index_key){NULL, node->id});
        inner = found ? (size_t)(found - nodes->list) : nodes->n;
        ++n_inner;
        if (!found)
            nqm_refuse(&r->reading, node, "there is no BSDF '%.40s' in this file", node->id);
    }
    if (n_inner != 1)
        nqm_refuse(&r->reading, &nodes->list[at],
                   n_inner ? "its two sides have different BSDFs" : "it contains no BSDF");
    else if (inner < nodes->n && strcmp(nodes->list[inner].type, "twosided") == 0)
        nqm_refuse(&r->reading, &nodes->list[at], "it contains another twosided BSDF");
    return *r->reading.refusal ? nodes->n : inner;
}

static nqm_status add_material(const nqm_bsdf_nodes *nodes, const nqm_index *ids, size_t at, nqm_materials *materials,
                               nqm_error *err) {
    nqm_bsdf_reading r = {.reading = {.source = &nqm_bsdf_source}, .nodes = nodes};
    const nqm_bsdf_node *outer = &nodes->list[at];
    r.at = strcmp(outer->type, "twosided") == 0 ? unwrap(&r, ids, at) : at;
    const nqm_bsdf_node *bsdf = r.at < nodes->n ? &nodes->list[r.at] : outer;
    if (r.at < nodes->n)
        nqm_bsdf_read(&r, plugins, bsdf->type);
    return nqm_reading_add(&r.reading, *outer->id ? outer->id : bsdf->id, bsdf->type, outer->byte_offset, materials,
                           err);
}

nqm_status nqm_mitsuba_translate(const nqm_bsdf_nodes *nodes, nqm_materials *materials, nqm_error *err) {
    nqm_index ids;
    nqm_status status = nqm_index_create(nodes->n, key_of_bsdf, &ids, err);
    for (size_t i = 0; status == NQM_OK && i < nodes->n; ++i)
        if (nodes->list[i].kind == NQM_BSDF_BSDF)
            nqm_index_add(&ids, &nodes->list[i]);
    for (size_t i = 0; status == NQM_OK && i < nodes->n; ++i)
        if (nodes->list[i].parent == NQM_BSDF_ROOT && nodes->list[i].kind == NQM_BSDF_BSDF)
            status = add_material(nodes, &ids, i, materials, err);
    nqm_index_free(&ids);
    return status;
}
