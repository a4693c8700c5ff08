/* SPDX-License-Identifier: MIT
 *
 * BSDFs of Mitsuba 3 (mitsuba.readthedocs.io, "BSDFs") to shadings: one list of rules for each plugin that has a shading
 * model. Properties that concern sampling only are ignored; any other property that the model does not have is refused, as are
 * all other plugins.
 */
#include "material/bsdf.h"
#include "schema/models.h"

#include <math.h>

enum { MAX_BLENDS = 3 }; /* specs can have no more (doc/brdf.md) */

/* ---- textures ---------------------------------------------------------------------------------------------------- */

static const nqm_bsdf_node *find_by_id(const nqm_bsdf_reading *r, const char *id) {
    return nqm_index_find(r->ids, (nqm_index_key){NULL, id});
}

/* Apply a step of a transform after the steps before it. Only the rows and columns of u and v of a matrix have an effect. */
static bool apply_step(nqm_bsdf_reading *r, const nqm_bsdf_node *node, double uv[2][3]) {
    double v[16], step[2][3] = {{1, 0, 0}, {0, 1, 0}};
    const size_t n = nqm_parse_numbers(node->value, 16, v), n_columns = n == 16 ? 4 : 3;
    if ((strcmp(node->type, "matrix") == 0 || !*node->type) && (n == 9 || n == 16)) {
        for (size_t i = 0; i < 2; ++i)
            for (size_t j = 0; j < 3; ++j)
                step[i][j] = v[i * n_columns + (j == 2 ? n_columns - 1 : j)];
    } else if (strcmp(node->type, "scale") == 0 && (n == 1 || n == 3)) {
        step[0][0] = v[0];
        step[1][1] = v[n == 3];
    } else if (strcmp(node->type, "translate") == 0 && n == 3) {
        step[0][2] = v[0];
        step[1][2] = v[1];
    } else if (strcmp(node->type, "rotate") == 0 && n == 4 && v[0] == 0 && v[1] == 0 && v[2] != 0) {
        const double angle = copysign(v[3], v[2] * v[3]) * acos(-1) / 180;
        step[0][0] = step[1][1] = cos(angle);
        step[1][0] = sin(angle);
        step[0][1] = -step[1][0];
    } else
        return nqm_refuse(&r->reading, node,
                          "to_uv: the step '%.40s' with '%.40s' is not read; use scale, translate, rotate about z or a "
                          "matrix of 9 or 16 numbers",
                          node->type, node->value);
    for (size_t j = 0; j < 3; ++j) {
        const double u = uv[0][j], w = uv[1][j];
        for (size_t i = 0; i < 2; ++i)
            uv[i][j] = step[i][0] * u + step[i][1] * w + (j == 2 ? step[i][2] : 0);
    }
    return true;
}

/* Mitsuba's v is 0 in the first row of an image and its readers of meshes turn v over, so that it points downwards as that of
 * nqm_map_node: to_uv is taken as it is. */
static bool read_to_uv(nqm_bsdf_reading *r, double uv[2][3]) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, "to_uv");
    if (!node)
        return true;
    if (strcmp(node->type, "transform") != 0) /* numbers of JSON */
        return apply_step(r, node, uv);
    for (const nqm_bsdf_node *step = NULL; (step = nqm_bsdf_next(r->nodes, (size_t)(node - r->nodes->list), step));)
        if (!apply_step(r, step, uv))
            return false;
    return true;
}

/* RGB of the bitmap r->at, or one of its channels (of Blender). */
static bool read_bitmap(nqm_bsdf_reading *r, uint16_t *value_ret) {
    const nqm_bsdf_node *file = nqm_bsdf_filename(r);
    double uv[2][3] = {{1, 0, 0}, {0, 1, 0}};
    bool is_raw = false;
    size_t wrap, channel;
    if (!file || !nqm_bsdf_check(r, "filename wrap_mode raw to_uv channel", "filter_type format accel") ||
        !nqm_bsdf_flag(r, "raw", &is_raw) || !nqm_bsdf_choice(r, "wrap_mode", "repeat mirror clamp", &wrap) ||
        !nqm_bsdf_choice(r, "channel", "rgb r g b", &channel) || !read_to_uv(r, uv))
        return false;
    const char *space = is_raw || nqm_bsdf_is_float_image(file->value) ? "" : "srgb_texture";
    if (!nqm_bsdf_image(r, file, space, uv, (nqm_map_wrap)wrap, value_ret))
        return false;
    *value_ret = channel ? nqm_graph_channel(r->reading.textured, *value_ret, channel - 1) : *value_ret;
    return true;
}

/* The value of a texture, or of a reference to one, as n components: of a number Mitsuba takes the luminance. */
static bool read_texture(nqm_bsdf_reading *r, const nqm_bsdf_node *node, size_t n, uint16_t *value_ret) {
    const nqm_bsdf_node *texture = node->kind == NQM_BSDF_REF ? find_by_id(r, node->id) : node;
    if (!texture || texture->kind != NQM_BSDF_TEXTURE)
        return nqm_refuse(&r->reading, node, "%s refers to the object '%.40s', which is no texture of this file",
                          node->name, node->id);
    if (strcmp(texture->type, "bitmap") != 0)
        return nqm_refuse(&r->reading, node, "%s is of type '%.40s'; of textures only bitmap is read", node->name,
                          texture->type);
    const size_t at = r->at;
    nqm_bsdf_varies(r, node);
    r->at = (size_t)(texture - r->nodes->list);
    const bool is_read = read_bitmap(r, value_ret);
    r->at = at;
    if (is_read && n == 1 && *value_ret != NQM_NO_NODE && r->reading.textured->nodes[*value_ret].n == 3)
        *value_ret = nqm_graph_compute(r->reading.textured, NQM_MAP_LUMINANCE, 1, *value_ret, 0, 0);
    return is_read;
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

static bool set_or_map(nqm_reading *r, const nqm_rule *rule, const void *property) {
    nqm_bsdf_reading *bsdf = (nqm_bsdf_reading *)r;
    uint16_t value;
    if (!nqm_bsdf_is_texture(property))
        return nqm_rule_set(r, rule, property);
    return read_texture(bsdf, property, rule->n, &value) && nqm_bsdf_output(bsdf, rule->key, value);
}

/* finish_alpha() sets it again: here it gets its place in the spec. */
static bool read_alpha(nqm_reading *r, const nqm_rule *rule, const void *property) {
    return nqm_bsdf_is_texture(property) || nqm_rule_set(r, rule, property);
}

static bool read_distribution(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const nqm_bsdf_node *node = property;
    const double v = strcmp(node->value, "ggx") == 0;
    if (v == 0 && strcmp(node->value, "beckmann") != 0)
        return nqm_refuse(r, node, "distribution is '%.40s'; Mitsuba has beckmann and ggx", node->value);
    nqm_values_set(&r->values, rule->key, 1, &v);
    return true;
}

static bool read_eta(nqm_reading *r, const nqm_rule *rule, const void *property) {
    if (nqm_values_given(&r->values, "eta"))
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
    if (nqm_values_given(&r->values, "eta"))
        return nqm_refuse(r, property, "specular is given as well as eta");
    const double eta = 2 / (1 - sqrt(0.08 * v[0])) - 1;
    nqm_values_set(&r->values, "eta", 1, &eta);
    return true;
}

static bool read_flag(nqm_reading *r, const nqm_rule *rule, const void *property) {
    bool is_true;
    (void)property; /* the only one of this name */
    if (!nqm_bsdf_flag((nqm_bsdf_reading *)r, rule->name, &is_true))
        return false;
    nqm_values_set(&r->values, rule->key, 1, &(double){is_true});
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
        if (nqm_equal_any_case(node->value, named[i].name, SIZE_MAX)) {
            *v = named[i].ior;
            return true;
        }
    return nqm_refuse(&r->reading, node, "%s: the index of refraction of '%.40s' is not known", name, node->value);
}

/* ---- plugins ----------------------------------------------------------------------------------------------------- */

/* Mitsuba clamps alpha so that the distribution is finite. Its roughplastic integrates over the lobe of a constant
 * alpha beforehand. A smooth surface, of a type without alpha, has the narrowest lobe. */
static bool finish_alpha(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    const nqm_bsdf_node *common = nqm_bsdf_find(r, "alpha"),
                        *nodes[] = {nqm_bsdf_find(r, "alpha_u"), nqm_bsdf_find(r, "alpha_v")};
    nqm_textured *t = r->reading.textured;
    uint16_t value[2];
    if (strncmp(bsdf->type, "rough", 5) != 0) {
        nqm_textured_remark(t, NQM_BSDF_SMOOTH);
        return nqm_bsdf_output(r, "alpha", nqm_graph_number(t, 1e-4));
    }
    if (!nodes[0] != !nodes[1])
        return nqm_refuse(&r->reading, bsdf, "only one of alpha_u and alpha_v is given");
    if (nodes[0] && common)
        return nqm_refuse(&r->reading, bsdf, "alpha is given as well as alpha_u and alpha_v");
    for (size_t c = 0; c < 2 && (nodes[0] || common); ++c) {
        const nqm_bsdf_node *node = common ? common : nodes[c];
        double alpha = 0;
        if (nqm_bsdf_is_texture(node) && strcmp(bsdf->type, "roughplastic") != 0) {
            if (!read_texture(r, node, 1, &value[c]))
                return false;
        } else if (nqm_bsdf_numbers(r, node->name, 1, &alpha))
            value[c] = nqm_graph_number(t, fmax(alpha, 1e-4));
        else
            return false;
    }
    if (!nodes[0] && !common)
        return true;
    const size_t n = value[0] == value[1] ? 1 : 2;
    value[0] = n == 2 ? nqm_graph_compute(t, NQM_MAP_COMBINE, 2, value[0], value[1], 0) : value[0];
    return nqm_bsdf_output(r, "alpha", nqm_graph_with(t, NQM_MAP_MAXIMUM, n, value[0], 1e-4));
}

static bool finish_conductor(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, "material");
    nqm_values *values = &r->reading.values;
    char names[300];
    if (!finish_alpha(r, bsdf))
        return false;
    if (!node || strcmp(node->value, "none") == 0)
        return true; /* eta = 0, k = 1: the defaults, a mirror */
    const nqm_metal *m = nqm_metal_find(false, node->value);
    if (nqm_bsdf_find(r, "eta") || nqm_bsdf_find(r, "k"))
        return nqm_refuse(&r->reading, node, "material is given as well as eta or k");
    nqm_metal_names(false, names, sizeof names);
    if (!m)
        return nqm_refuse(&r->reading, node, "the indices of the material '%.40s' are not known; these are: %s",
                          node->value, names);
    nqm_values_set(values, "eta", 3, m->eta);
    nqm_values_set(values, "k", 3, m->k);
    return true;
}

static bool finish_plastic(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    double inside = 1.49, outside = 1.000277;
    if (!read_ior(r, "int_ior", &inside) || !read_ior(r, "ext_ior", &outside) || !finish_alpha(r, bsdf))
        return false;
    const double eta = inside / outside;
    const double *alpha = nqm_values_given(&r->reading.values, "alpha");
    if (alpha && alpha[0] != alpha[1])
        return nqm_refuse(&r->reading, bsdf, "alpha_u and alpha_v differ; the roughplastic of Mitsuba has one alpha");
    if (!(eta >= 1.05 && eta <= 3))
        return nqm_refuse(&r->reading, bsdf, "int_ior / ext_ior is %.4g; the model's range is 1.05 to 3", eta);
    nqm_values_set(&r->reading.values, "eta", 1, &eta);
    return true;
}

static bool finish_dielectric(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    double inside = 1.5046, outside = 1.000277;
    if (!read_ior(r, "int_ior", &inside) || !read_ior(r, "ext_ior", &outside) || !finish_alpha(r, bsdf))
        return false;
    return nqm_bsdf_interface(r, bsdf, inside / outside, strcmp(bsdf->type, "thindielectric") == 0);
}

static bool finish_diffuse(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    (void)bsdf;
    if (!nqm_values_given(&r->reading.values, "kd")) /* Mitsuba's default; the key is required */
        nqm_values_set(&r->reading.values, "kd", 1, &(double){0.5});
    return true;
}

#define KEY(INDEX, NAME, TYPE, ...) {.name = NAME, .read = set_or_map, .key = NAME, .n = NQM_KEY_N(TYPE)},
#define COLOUR(NAME, KEY)                                                                                              \
    { .name = NAME, .read = set_or_map, .key = KEY, .n = 3 }
#define OWN(NAME, READ)                                                                                                \
    { .name = NAME, .read = READ, .key = NAME, .n = 1 }
#define OPAQUE(NAME)                                                                                                   \
    { .name = NAME, .read = nqm_rule_neutral, .n = 1, .value = 1, .why = MASKED, .ignorable = NQM_IGNORE_OPACITY }
#define MASKED    "opacity is not supported"
#define EMITS     "emission is not part of a BRDF"
#define SCATTERS  "subsurface scattering is not supported"
#define TRANSMITS "transmission is not supported"
#define LAYERED   "combinations of BSDFs and textures are not supported"
#define NESTED    "mask, twosided, normalmap and bumpmap are read around a BSDF of another type only"
static const nqm_bsdf_plugin plugins[] = {
    {.type = "roughconductor",
     .model = "rough-conductor",
     .finish = finish_conductor,
     .rules = {OWN("alpha", read_alpha), NQM_RULE_LATER("alpha_u alpha_v"), OWN("distribution", read_distribution),
               COLOUR("eta", "eta"), COLOUR("k", "k"), NQM_RULE_LATER("material"),
               COLOUR("specular_reflectance", "specular_reflectance"), NQM_RULE_IGNORED("sample_visible")}},
    {.type = "roughplastic",
     .model = "rough-plastic",
     .finish = finish_plastic,
     .rules = {OWN("alpha", read_alpha), NQM_RULE_LATER("alpha_u alpha_v"), OWN("distribution", read_distribution),
               NQM_RULE_LATER("int_ior ext_ior"), COLOUR("diffuse_reflectance", "diffuse_reflectance"),
               COLOUR("specular_reflectance", "specular_reflectance"), OWN("nonlinear", read_flag),
               NQM_RULE_IGNORED("sample_visible")}},
    {.type = "conductor",
     .model = "rough-conductor",
     .finish = finish_conductor,
     .rules = {COLOUR("eta", "eta"), COLOUR("k", "k"), NQM_RULE_LATER("material"),
               COLOUR("specular_reflectance", "specular_reflectance")}},
    {.type = "plastic",
     .model = "rough-plastic",
     .finish = finish_plastic,
     .rules = {NQM_RULE_LATER("int_ior ext_ior"), COLOUR("diffuse_reflectance", "diffuse_reflectance"),
               COLOUR("specular_reflectance", "specular_reflectance"), OWN("nonlinear", read_flag)}},
    {.type = "principled",
     .model = "principled",
     .rules = {OWN("eta", read_eta), OWN("specular", read_specular),
               NQM_PRINCIPLED_KEYS(KEY) NQM_RULE_WEIGHT("spec_trans", TRANSMITS, NQM_IGNORE_TRANSMISSION),
               NQM_RULE_IGNORED(
                   "main_specular_sampling_rate clearcoat_sampling_rate diffuse_reflectance_sampling_rate")}},
    /* Blender's, as doc/blender.py writes it */
    {.type = "blender-principled",
     .model = "blender-principled",
     .rules = {NQM_BLENDER_KEYS(KEY) NQM_RULE_WEIGHT("transmission_weight", TRANSMITS, NQM_IGNORE_TRANSMISSION),
               NQM_RULE_ASIDE("subsurface_weight", SCATTERS, NQM_IGNORE_SUBSURFACE), /* of the base colour */
               NQM_RULE_ASIDE("emission_strength", EMITS, NQM_IGNORE_EMISSION), OPAQUE("alpha"),
               NQM_RULE_IGNORED("subsurface_radius subsurface_scale subsurface_ior subsurface_anisotropy "
                                "emission_color")}},
    {.type = "diffuse", .model = "lambert", .finish = finish_diffuse, .rules = {COLOUR("reflectance", "kd")}},
    {.type = "measured", .rules = {OWN("filename", nqm_bsdf_file)}},
    {.type = "roughdielectric",
     .model = "rough-conductor",
     .finish = finish_dielectric,
     .rules = {OWN("alpha", read_alpha), NQM_RULE_LATER("alpha_u alpha_v"), OWN("distribution", read_distribution),
               NQM_RULE_LATER("int_ior ext_ior"), COLOUR("specular_reflectance", "specular_reflectance"),
               NQM_RULE_IGNORED("specular_transmittance sample_visible")}},
    {.type = "dielectric thindielectric",
     .model = "rough-conductor",
     .finish = finish_dielectric,
     .rules = {NQM_RULE_LATER("int_ior ext_ior"), COLOUR("specular_reflectance", "specular_reflectance"),
               NQM_RULE_IGNORED("specular_transmittance")}},
    {.type = "principledthin", .refusal = TRANSMITS},
    {.type = "hair", .refusal = "hair has no BRDF of a surface"},
    {.type = "pplastic measured_polarized polarizer retarder circular",
     .refusal = "polarised materials are not supported"},
    {.type = "null", .refusal = "it reflects nothing"},
    {.type = "mask normalmap twosided bumpmap blendbsdf", .refusal = NESTED},
    {.type = NULL},
};

bool nqm_mitsuba_is_bsdf(const char *type) {
    return nqm_bsdf_find_plugin(plugins, type) != NULL;
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static nqm_index_key key_of_node(const void *value) {
    return (nqm_index_key){NULL, ((const nqm_bsdf_node *)value)->id};
}

/* Go from the mask, twosided, normalmap or bumpmap BSDF r->at to the one inside; false: there is not exactly one. */
static bool unwrap(nqm_bsdf_reading *r) {
    const nqm_bsdf_node *outer = &r->nodes->list[r->at], *inner = NULL;
    size_t n_inner = 0;
    for (const nqm_bsdf_node *node = NULL; (node = nqm_bsdf_next(r->nodes, r->at, node));) {
        if ((node->kind != NQM_BSDF_BSDF && node->kind != NQM_BSDF_REF) ||
            nqm_contains_word("normalmap opacity", node->name, false))
            continue;
        const nqm_bsdf_node *found = node->kind == NQM_BSDF_REF ? find_by_id(r, node->id) : node;
        if (found && found->kind == NQM_BSDF_TEXTURE)
            continue;
        inner = found;
        if (!inner || inner->kind != NQM_BSDF_BSDF)
            return nqm_refuse(&r->reading, node, "there is no BSDF '%.40s' in this file", node->id);
        ++n_inner;
    }
    if (n_inner != 1)
        return nqm_refuse(&r->reading, outer, n_inner ? "its two sides have different BSDFs" : "it contains no BSDF");
    if (strcmp(inner->type, outer->type) == 0)
        return nqm_refuse(&r->reading, outer, "it contains another %s BSDF", outer->type);
    r->at = (size_t)(inner - r->nodes->list);
    return true;
}

/* The map of the normalmap r->at. */
static bool read_normal(nqm_bsdf_reading *r) {
    const nqm_bsdf_node *bsdf = &r->nodes->list[r->at], *node = nqm_bsdf_find(r, "normalmap");
    uint16_t rgb;
    if (!nqm_bsdf_is_texture(node))
        return nqm_refuse(&r->reading, bsdf, "the texture normalmap is missing");
    return nqm_vary(&r->reading, bsdf, LAYERED) && read_texture(r, node, 3, &rgb) && nqm_bsdf_output(r, "normal", rgb);
}

/* The opacity of the mask r->at: 0.5 by default, or a map. */
static bool read_mask(nqm_bsdf_reading *r) {
    double opacity = 0.5;
    if (nqm_bsdf_is_texture(nqm_bsdf_find(r, "opacity")))
        opacity = 0;
    else if (!nqm_bsdf_numbers(r, "opacity", 1, &opacity))
        return false;
    return opacity == 1 || nqm_set_aside(&r->reading, NQM_IGNORE_OPACITY, &r->nodes->list[r->at], MASKED);
}

static bool read_bump(nqm_bsdf_reading *r) {
    return nqm_set_aside(&r->reading, NQM_IGNORE_BUMP, &r->nodes->list[r->at], NQM_BSDF_BUMPED);
}

static nqm_status add_material(nqm_bsdf_reading *r, nqm_materials *materials, nqm_error *err);

/* The two BSDFs of the blendbsdf r->at; false: refused. */
static bool find_blended(nqm_bsdf_reading *r, const nqm_bsdf_node *inner[2]) {
    const nqm_bsdf_node *blend = &r->nodes->list[r->at], *node = NULL;
    size_t n = 0;
    while ((node = nqm_bsdf_next(r->nodes, r->at, node))) {
        const nqm_bsdf_node *found = node->kind == NQM_BSDF_REF ? find_by_id(r, node->id) : node;
        if (strcmp(node->name, "weight") == 0)
            continue;
        if (!found || found->kind != NQM_BSDF_BSDF)
            return nqm_refuse(&r->reading, node, "'%.40s' is no BSDF of this file",
                              *node->name ? node->name : node->id);
        if (n < 2)
            inner[n] = found;
        ++n;
    }
    return n == 2 || nqm_refuse(&r->reading, blend, "it contains %zu BSDFs; two are needed", n);
}

/* The blendbsdf r->at: its two BSDFs are read as materials of a list of their own. */
static bool read_blend(nqm_bsdf_reading *r) {
    const nqm_bsdf_node *blend = &r->nodes->list[r->at], *inner[2];
    double weight = 0.5;
    if (!nqm_bsdf_numbers(r, "weight", 1, &weight) || !find_blended(r, inner))
        return false;
    if (r->depth == MAX_BLENDS)
        return nqm_refuse(&r->reading, blend, "mixtures are nested more than %d deep", MAX_BLENDS);
    nqm_materials *list = nqm_materials_create(r->path);
    nqm_status status = list ? NQM_OK : NQM_ERR_NOMEM;
    for (size_t i = 0; i < 2 && status == NQM_OK; ++i) {
        nqm_bsdf_reading part = {.nodes = r->nodes,
                                 .at = (size_t)(inner[i] - r->nodes->list),
                                 .path = r->path,
                                 .ids = r->ids,
                                 .depth = r->depth + 1};
        status = add_material(&part, list, NULL);
    }
    const bool is_read = status == NQM_OK ? nqm_reading_mix(&r->reading, blend, nqm_materials_get(list, 0),
                                                            nqm_materials_get(list, 1), fmin(fmax(weight, 0), 1))
                                          : nqm_refuse(&r->reading, blend, "memory is short");
    nqm_materials_free(list);
    return is_read;
}

static nqm_status add_material(nqm_bsdf_reading *r, nqm_materials *materials, nqm_error *err) {
    static const char *const wrappers[] = {"mask", "twosided", "normalmap", "bumpmap", "twosided"};
    const nqm_bsdf_node *outer = &r->nodes->list[r->at];
    bool is_read = nqm_reading_begin(&r->reading, &nqm_bsdf_source);
    for (size_t i = 0; i < sizeof wrappers / sizeof *wrappers && is_read; ++i)
        if (strcmp(r->nodes->list[r->at].type, wrappers[i]) == 0)
            is_read = (i != 0 || read_mask(r)) && (i != 2 || read_normal(r)) && (i != 3 || read_bump(r)) && unwrap(r);
    const nqm_bsdf_node *bsdf = &r->nodes->list[r->at];
    if (is_read && strcmp(bsdf->type, "blendbsdf") == 0)
        read_blend(r);
    else if (is_read)
        nqm_bsdf_read(r, plugins, bsdf->type);
    return nqm_reading_add(&r->reading, *outer->id ? outer->id : bsdf->id, bsdf->type, outer->byte_offset, materials,
                           err);
}

nqm_status nqm_mitsuba_translate(const nqm_bsdf_nodes *nodes, const char *path, nqm_materials *materials,
                                 nqm_error *err) {
    nqm_index ids;
    nqm_status status = nqm_index_create(nodes->n, key_of_node, &ids, err);
    for (size_t i = 0; status == NQM_OK && i < nodes->n; ++i)
        if (nodes->list[i].kind == NQM_BSDF_BSDF || nodes->list[i].kind == NQM_BSDF_TEXTURE)
            nqm_index_add(&ids, &nodes->list[i]);
    for (size_t i = 0; status == NQM_OK && i < nodes->n; ++i) {
        nqm_bsdf_reading r = {.nodes = nodes, .at = i, .path = path, .ids = &ids};
        if (nodes->list[i].parent == NQM_BSDF_ROOT && nodes->list[i].kind == NQM_BSDF_BSDF)
            status = add_material(&r, materials, err);
    }
    nqm_index_free(&ids);
    return status;
}

/* ---- writing: every value has the digits that read back to the same bits ------------------------------------------- */

/* The plugin of a shading model. */
static const char *type_of(const char *model) {
    const nqm_bsdf_plugin *p = plugins;
    while (p->type && !(p->model && strcmp(p->model, model) == 0))
        ++p;
    return p->type;
}

/* How a key is named and typed; keys that are not listed are numbers or colours of the same name. */
static const struct {
    const char *model, *key, *name;
    const char *const words[2]; /* words for the values 0 and 1 of a whole number */
} renamed[] = {
    {"lambert", "kd", "reflectance", {NULL}},
    {"rough-conductor", "distribution", "distribution", {"beckmann", "ggx"}},
    {"rough-plastic", "distribution", "distribution", {"beckmann", "ggx"}},
    {"rough-plastic", "nonlinear", "nonlinear", {"false", "true"}},
    {"rough-plastic", "eta", "int_ior", {NULL}},
};
enum { N_RENAMED = sizeof renamed / sizeof *renamed };

/* A property with its text, which is one word or numbers separated by ", "; tag: of the XML element. */
static void write_value(FILE *stream, bool is_json, const char *tag, const char *name, const char *text) {
    const bool is_color = strcmp(tag, "rgb") == 0, is_string = strcmp(tag, "string") == 0;
    if (is_json)
        fprintf(stream, ",\n    \"%s\": %s%s%s", name,
                is_color    ? "{\"type\": \"rgb\", \"value\": ["
                : is_string ? "\""
                            : "",
                text,
                is_color    ? "]}"
                : is_string ? "\""
                            : "");
    else
        fprintf(stream, "        <%s name=\"%s\" value=\"%s\"/>\n", tag, name, text);
}

/* Two numbers are those along u and v. */
static void write_property(FILE *stream, bool is_json, const nqm_values *values, size_t k) {
    const nqm_schema_key *key = &values->schema->keys[k];
    const double *v = values->v[k];
    const bool is_pair = key->n == 2 && v[0] != v[1];
    const size_t n = key->n == 3 ? 3 : 1;
    const char *name = key->name, *word = NULL;
    char text[100], name_of_one[50];
    for (size_t i = 0; i < N_RENAMED; ++i)
        if (strcmp(renamed[i].model, values->schema->model) == 0 && strcmp(renamed[i].key, key->name) == 0) {
            name = renamed[i].name;
            word = renamed[i].words[v[0] != 0];
        }
    const bool is_flag = word && nqm_contains_word("false true", word, false);
    if (strcmp(name, "int_ior") == 0)
        write_value(stream, is_json, "float", "ext_ior", is_json ? "1.0" : "1");
    for (size_t c = 0; c < (is_pair ? 2 : 1); ++c) {
        snprintf(name_of_one, sizeof name_of_one, "%s%s", name, !is_pair ? "" : c ? "_v" : "_u");
        nqm_format_doubles(text, sizeof text, n, v + c, ", ");
        write_value(stream, is_json,
                    is_flag  ? "boolean"
                    : word   ? "string"
                    : n == 3 ? "rgb"
                             : "float",
                    name_of_one, word ? word : text);
    }
}

nqm_status nqm_mitsuba_write(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                             nqm_error *err) {
    const char *dot = strrchr(path, '.');
    const bool is_json = dot && nqm_equal_any_case(dot, ".json", SIZE_MAX);
    fputs(is_json ? "{\n  \"type\": \"scene\"" : "<scene version=\"3.0.0\">\n", stream);
    (void)err;
    for (size_t i = 0; i < n; ++i) {
        const nqm_values *values = &materials[i].values;
        const char *type = type_of(values->schema->model), *name = materials[i].name;
        if (is_json)
            fprintf(stream, ",\n  \"%s\": {\n    \"type\": \"%s\"", name, type);
        else
            fprintf(stream, "    <bsdf type=\"%s\" id=\"%s\">\n", type, name);
        for (size_t k = 0; k < values->schema->n_keys; ++k)
            if (values->given >> k & 1)
                write_property(stream, is_json, values, k);
        fputs(is_json ? "\n  }" : "    </bsdf>\n", stream);
    }
    fputs(is_json ? "\n}\n" : "</scene>\n", stream);
    return NQM_OK;
}
