/* SPDX-License-Identifier: MIT
 *
 * Materials of pbrt-v4 scenes (pbrt_scene.c) as shadings. `conductor`, `diffuse`,
 * `coateddiffuse`, `coatedconductor` and `measured` are read, with textures of the classes imagemap, constant, scale and
 * mix. Colours are those of the default colour space, linear sRGB. pbrt is a spectral renderer: eta and k given as
 * "metal-Au-eta" are the RGB values of bsdf.c.
 */
#include "material/bsdf.h"

#include <math.h>

/* ---- colours ----------------------------------------------------------------------------------------------------- */

/* The values of "metal-Au-eta" or "metal-Au-k"; NULL: it is none. pbrt takes either for any parameter. */
static const double *find_metal(const char *value) {
    const char *dash = strrchr(value, '-');
    char name[32] = "";
    if (dash && nqm_contains_word("eta k", dash + 1, false))
        snprintf(name, sizeof name, "%.*s", (int)(dash - value), value);
    const nqm_metal *metal = nqm_metal_find(true, name);
    return !metal ? NULL : dash[1] == 'k' ? metal->k : metal->eta;
}

/* A constant colour; `v` keeps its value when the parameter is not given. */
static bool read_colour(nqm_bsdf_reading *r, const char *name, double v[3]) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    const double *metal = node && node->kind == NQM_BSDF_SPECTRUM ? find_metal(node->value) : NULL;
    char names[100];
    double number;
    if (metal) {
        memcpy(v, metal, 3 * sizeof *v);
        return true;
    }
    if (node && node->kind == NQM_BSDF_SPECTRUM && strncmp(node->value, "metal-", 6) == 0) {
        nqm_metal_names(true, names, sizeof names);
        return nqm_refuse(&r->reading, node, "%s: pbrt has no spectrum '%.40s'; with -eta and -k it has %s", name,
                          node->value, names);
    }
    if (node && node->kind == NQM_BSDF_SPECTRUM && nqm_parse_numbers(node->value, 1, &number) == 1)
        return nqm_refuse(&r->reading, node,
                          "%s is a spectrum of one number; it needs pairs of a wavelength in nm and a value", name);
    if (node && node->kind == NQM_BSDF_NUMBER)
        return nqm_refuse(&r->reading, node, "%s needs three numbers, \"rgb %s\" [ r g b ]", name, name);
    return nqm_bsdf_numbers(r, name, 3, v);
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

enum { MAX_TEXTURES = 256 }; /* a mix of mixes of the same two textures names them exponentially often */

static bool read_texture(nqm_bsdf_reading *r, size_t n, uint16_t *value_ret);

/* The value of the texture that a parameter names. Floats (n = 1) and spectra (n = 3) have names of their own. */
static bool read_named(nqm_bsdf_reading *r, const nqm_bsdf_node *parameter, size_t n, uint16_t *value_ret) {
    const size_t at = r->at;
    const char *type = n == 3 ? "spectrum" : "float";
    const size_t i = nqm_pbrt_find(r->ids, type, parameter->value);
    if (i >= at)
        return nqm_refuse(&r->reading, parameter, "%s: there is no %s texture '%.40s' before it", parameter->name, type,
                          parameter->value);
    if (++r->n_textures > MAX_TEXTURES)
        return nqm_refuse(&r->reading, parameter, "%s: more than %d textures", parameter->name, MAX_TEXTURES);
    nqm_bsdf_varies(r, parameter);
    r->at = i;
    const bool is_read = read_texture(r, n, value_ret);
    r->at = at;
    return is_read;
}

/* The value of a parameter that is a constant, a metal or a texture: n = 1 of type float, 3 of type spectrum. missing
 * (n): when it is not given. */
static bool read_value(nqm_bsdf_reading *r, const char *name, size_t n, const double *missing, uint16_t *value_ret) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    double v[3] = {0};
    if (nqm_bsdf_is_texture(node))
        return read_named(r, node, n, value_ret);
    if (!node)
        memcpy(v, missing, n * sizeof *v);
    if (!(n == 3 ? read_colour(r, name, v) : nqm_bsdf_numbers(r, name, 1, v)))
        return false;
    *value_ret = nqm_graph_value(r->reading.textured, n, v);
    return true;
}

/* The image, decoded: pbrt uses `encoding` for PNG only, and that of sRGB for other images of 8 bits. */
static bool read_image(nqm_bsdf_reading *r, const nqm_bsdf_node *file, const char *encoding, const double uv[2][3],
                       nqm_map_wrap wrap, uint16_t *value_ret) {
    const char *dot = strrchr(file->value, '.'), *end;
    double gamma = 1;
    if (nqm_bsdf_is_float_image(file->value))
        encoding = "linear";
    else if (!dot || !nqm_contains_word(".png", dot, true))
        encoding = "sRGB";
    const bool is_srgb = strcmp(encoding, "sRGB") == 0;
    if (!is_srgb && strcmp(encoding, "linear") != 0 &&
        (strncmp(encoding, "gamma ", 6) != 0 || !nqm_parse_double(encoding + 6, &end, &gamma) || *end || gamma <= 0))
        return nqm_refuse(&r->reading, file, "encoding '%.40s' is not read; use sRGB, linear or gamma with a number",
                          encoding);
    if (!nqm_bsdf_image(r, file, is_srgb ? "srgb_texture" : "", uv, wrap, value_ret))
        return false;
    if (gamma != 1)
        *value_ret = nqm_graph_with(r->reading.textured, NQM_MAP_POWER, 3, *value_ret, gamma);
    return true;
}

/* pbrt's v points upwards, and the first row of an image is at v = 1: with v downwards, its t = 1 - (vscale (1 - v) + vdelta). */
static bool read_mapping(nqm_bsdf_reading *r, double uv[2][3]) {
    double u[2] = {1, 0}, v[2] = {1, 0};
    size_t mapping;
    if (!nqm_bsdf_choice(r, "mapping", "uv", &mapping) || !nqm_bsdf_numbers(r, "uscale", 1, &u[0]) ||
        !nqm_bsdf_numbers(r, "udelta", 1, &u[1]) || !nqm_bsdf_numbers(r, "vscale", 1, &v[0]) ||
        !nqm_bsdf_numbers(r, "vdelta", 1, &v[1]))
        return false;
    memcpy(uv, (const double[2][3]){{u[0], 0, u[1]}, {0, v[0], 1 - v[0] - v[1]}}, 6 * sizeof **uv);
    return true;
}

#define IMAGE_PARAMETERS "filename mapping uscale udelta vscale vdelta wrap scale invert"

/* The imagemap r->at; a number is the mean of RGB. */
static bool read_imagemap(nqm_bsdf_reading *r, size_t n, uint16_t *value_ret) {
    static const nqm_map_wrap wraps[] = {NQM_MAP_REPEAT, NQM_MAP_BORDER, NQM_MAP_CLAMP};
    const nqm_bsdf_node *file = nqm_bsdf_filename(r), *encoding = nqm_bsdf_find(r, "encoding");
    nqm_textured *t = r->reading.textured;
    double uv[2][3], scale = 1;
    bool is_inverted = false;
    size_t wrap;
    const bool is_png = file && strrchr(file->value, '.') && nqm_contains_word(".png", strrchr(file->value, '.'), true);
    if (!file ||
        !nqm_bsdf_check(r, is_png ? IMAGE_PARAMETERS " encoding" : IMAGE_PARAMETERS,
                        is_png ? "filter maxanisotropy" : "filter maxanisotropy encoding") ||
        !read_mapping(r, uv) || !nqm_bsdf_choice(r, "wrap", "repeat black clamp", &wrap) ||
        !nqm_bsdf_numbers(r, "scale", 1, &scale) || !nqm_bsdf_flag(r, "invert", &is_inverted) ||
        !read_image(r, file, encoding ? encoding->value : "sRGB", uv, wraps[wrap], value_ret))
        return false;
    uint16_t value = *value_ret;
    if (n == 1) {
        value = nqm_graph_channel(t, *value_ret, 0);
        for (size_t c = 1; c < 3; ++c)
            value = nqm_graph_compute(t, NQM_MAP_ADD, 1, value, nqm_graph_channel(t, *value_ret, c), 0);
        value = nqm_graph_with(t, NQM_MAP_MULTIPLY, 1, value, 1.0 / 3);
    }
    value = nqm_graph_with(t, NQM_MAP_MULTIPLY, n, value, scale);
    if (is_inverted) {
        value = nqm_graph_compute(t, NQM_MAP_SUBTRACT, n, nqm_graph_number(t, 1), value, 0);
        value = nqm_graph_with(t, NQM_MAP_MAXIMUM, n, value, 0);
    }
    *value_ret = value;
    return true;
}

/* The texture r->at: an image, or an operation of other values. */
static bool read_texture(nqm_bsdf_reading *r, size_t n, uint16_t *value_ret) {
    static const double zero[3], one[3] = {1, 1, 1}, half = 0.5;
    const nqm_bsdf_node *texture = &r->nodes->list[r->at];
    const bool is_mix = strcmp(texture->type, "mix") == 0;
    uint16_t a, b, amount = 0;
    if (strcmp(texture->type, "imagemap") == 0)
        return read_imagemap(r, n, value_ret);
    if (strcmp(texture->type, "constant") == 0)
        return nqm_bsdf_check(r, "value", "") && read_value(r, "value", n, one, value_ret);
    if (!is_mix && strcmp(texture->type, "scale") != 0)
        return nqm_refuse(&r->reading, texture,
                          "the texture '%.40s' is of class '%.40s'; imagemap, constant, scale and mix are read",
                          texture->id, texture->type);
    if (!nqm_bsdf_check(r, is_mix ? "tex1 tex2 amount" : "tex scale", ""))
        return false;
    if (is_mix ? !read_value(r, "tex1", n, zero, &a) || !read_value(r, "tex2", n, one, &b) ||
                     !read_value(r, "amount", 1, &half, &amount)
               : !read_value(r, "tex", n, one, &a) || !read_value(r, "scale", 1, one, &b))
        return false;
    *value_ret = nqm_graph_compute(r->reading.textured, is_mix ? NQM_MAP_MIX : NQM_MAP_MULTIPLY, n, a, b, amount);
    return true;
}

/* RGB of the file that the parameter names; it is repeated, and linear as far as pbrt allows that. */
static bool read_normal_map(nqm_reading *r, const nqm_rule *rule, const void *property) {
    nqm_bsdf_reading *bsdf = (nqm_bsdf_reading *)r;
    const nqm_bsdf_node *node = property;
    uint16_t rgb;
    if (node->kind != NQM_BSDF_STRING || !*node->value)
        return nqm_refuse(r, node, "%s needs the name of a file", rule->name);
    return nqm_vary(r, node, "normalmap varies over the surface") &&
           read_image(bsdf, node, "linear", NULL, NQM_MAP_REPEAT, &rgb) && nqm_bsdf_output(bsdf, "normal", rgb);
}

/* A bump map, unless it is constant. */
static bool read_displacement(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[4];
    size_t n;
    return nqm_bsdf_is_texture(property) ? nqm_set_aside(r, NQM_IGNORE_BUMP, property, "displacement: " NQM_BSDF_BUMPED)
                                         : nqm_bsdf_source.read(r, rule, property, v, &n);
}

/* ---- materials to shadings --------------------------------------------------------------------------------------- */

/* A value clamped to 0 to `high`. */
static uint16_t clamp(nqm_textured *t, uint16_t value, double high) {
    return nqm_graph_with(t, NQM_MAP_MINIMUM, 3, nqm_graph_with(t, NQM_MAP_MAXIMUM, 3, value, 0), high);
}

/* A conductor's parameters by their names in pbrt, which are the keys of the models, and a coat's interface. */
typedef struct surface {
    const char *roughness[3]; /* in both directions, along u, along v */
    const char *eta, *k;
    bool is_smooth_modelled; /* by a roughness of 0 */
} surface;
#define ROUGHNESS(prefix)                                                                                              \
    { prefix "roughness", prefix "uroughness", prefix "vroughness" }
static const surface bare = {ROUGHNESS(""), "eta", "k", false},
                     interface = {ROUGHNESS("interface."), .is_smooth_modelled = true},
                     coated = {ROUGHNESS("conductor."), "conductor.eta", "conductor.k", true};

/* eta = 1 and k = 2 sqrt(r / (1 - r)) of a reflectance r at normal incidence, as pbrt, which clamps r to 0.9999. */
static bool reflectance_index(nqm_bsdf_reading *r, const surface *s, const nqm_bsdf_node *node) {
    nqm_textured *t = r->reading.textured;
    const double one[3] = {1, 1, 1};
    uint16_t value;
    if (nqm_bsdf_find(r, s->eta) || nqm_bsdf_find(r, s->k))
        return nqm_refuse(&r->reading, node, "reflectance is given as well as eta or k");
    if (!read_value(r, "reflectance", 3, NULL, &value))
        return false;
    value = clamp(t, value, 0.9999);
    const uint16_t rest = nqm_graph_compute(t, NQM_MAP_SUBTRACT, 3, nqm_graph_number(t, 1), value, 0);
    value = nqm_graph_with(t, NQM_MAP_POWER, 3, nqm_graph_compute(t, NQM_MAP_DIVIDE, 3, value, rest, 0), 0.5);
    return nqm_bsdf_output(r, s->eta, nqm_graph_value(t, 3, one)) &&
           nqm_bsdf_output(r, s->k, nqm_graph_with(t, NQM_MAP_MULTIPLY, 3, value, 2));
}

/* Both directions; alpha is the square root. Mirrors, also texels that would be mirrors, have the smallest lobe of the model. */
static bool read_roughness(nqm_bsdf_reading *r, const surface *s, const nqm_bsdf_node *bsdf) {
    const double zero = 0;
    nqm_textured *t = r->reading.textured;
    uint16_t value[2];
    bool remap = true;
    if (!nqm_bsdf_flag(r, "remaproughness", &remap))
        return false;
    for (size_t c = 0; c < 2; ++c) {
        if (!read_value(r, s->roughness[nqm_bsdf_find(r, s->roughness[c + 1]) ? c + 1 : 0], 1, &zero, &value[c]))
            return false;
        if (nqm_graph_is_constant(t, value[c]) && t->nodes[value[c]].v[0] < 0)
            return nqm_refuse(&r->reading, bsdf, "the roughness is negative");
    }
    const size_t n = value[0] == value[1] ? 1 : 2;
    if (n == 2)
        value[0] = nqm_graph_compute(t, NQM_MAP_COMBINE, n, value[0], value[1], 0);
    if (!remap)
        value[0] = nqm_graph_compute(t, NQM_MAP_MULTIPLY, n, value[0], value[0], 0);
    if (nqm_graph_is_constant(t, value[0]) && fmin(t->nodes[value[0]].v[0], t->nodes[value[0]].v[n - 1]) < 1e-6)
        nqm_textured_remark(t, NQM_BSDF_SMOOTH);
    if (s->is_smooth_modelled)
        return nqm_bsdf_output(r, s->roughness[0], value[0]);
    return nqm_bsdf_output(r, s->roughness[0], nqm_graph_with(t, NQM_MAP_MAXIMUM, n, value[0], 1e-6));
}

static bool read_index(nqm_bsdf_reading *r, const surface *s) {
    const nqm_metal *copper = nqm_metal_find(true, "metal-Cu"); /* pbrt's default */
    const nqm_bsdf_node *reflectance = nqm_bsdf_find(r, "reflectance");
    uint16_t eta, k;
    if (reflectance)
        return reflectance_index(r, s, reflectance);
    return read_value(r, s->eta, 3, copper->eta, &eta) && nqm_bsdf_output(r, s->eta, eta) &&
           read_value(r, s->k, 3, copper->k, &k) && nqm_bsdf_output(r, s->k, k);
}

static bool finish_conductor(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    return read_roughness(r, &bare, bsdf) && read_index(r, &bare);
}

/* Glasses: Schott's index at the line d. pbrt renders their dispersion. */
static const struct {
    const char *name;
    double eta;
} glasses[] = {{"glass-BK7", 1.5168}, {"glass-BAF10", 1.67003}, {"glass-FK51A", 1.48656}, {"glass-LASF9", 1.85025},
               {"glass-F5", 1.6727},  {"glass-F10", 1.72825},   {"glass-F11", 1.78472}};

/* What the interface reflects; a pane has no roughness. */
static bool finish_dielectric(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, "eta");
    const bool is_thin = strcmp(r->reading.owner, "thindielectric") == 0;
    double eta = 1.5;
    bool is_glass = false;
    for (size_t i = 0; node && !is_glass && i < sizeof glasses / sizeof *glasses; ++i)
        if ((is_glass = strcmp(node->value, glasses[i].name) == 0))
            eta = glasses[i].eta;
    if (!is_glass && !nqm_bsdf_numbers(r, "eta", 1, &eta))
        return false;
    return read_roughness(r, &bare, bsdf) && nqm_bsdf_interface(r, bsdf, eta, is_thin);
}

/* The surface of what scatters below it. */
static bool finish_subsurface(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    nqm_textured *t = r->reading.textured;
    double eta = 1.33;
    return nqm_set_aside(&r->reading, NQM_IGNORE_SUBSURFACE, bsdf, "subsurface scattering is not supported") &&
           nqm_bsdf_numbers(r, "eta", 1, &eta) && read_roughness(r, &bare, bsdf) &&
           nqm_bsdf_output(r, "eta", nqm_graph_number(t, eta)) && nqm_bsdf_output(r, "k", nqm_graph_number(t, 0));
}

static bool set_albedo(nqm_bsdf_reading *r, double grey, double scale) {
    nqm_textured *t = r->reading.textured;
    const double albedo[3] = {grey, grey, grey};
    uint16_t value;
    return read_value(r, "reflectance", 3, albedo, &value) &&
           nqm_bsdf_output(r, "kd", clamp(t, nqm_graph_with(t, NQM_MAP_MULTIPLY, 3, value, scale), 1)); /* as pbrt */
}

static bool finish_diffuse(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    (void)bsdf;
    return set_albedo(r, 0.5, 1);
}

static bool finish_diffuse_transmission(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    double scale = 1;
    return nqm_set_aside(&r->reading, NQM_IGNORE_TRANSMISSION, bsdf, "transmission is not supported") &&
           nqm_bsdf_numbers(r, "scale", 1, &scale) && set_albedo(r, 0.25, scale);
}

/* Of layers of a coated material. */
static bool read_one_roughness(nqm_bsdf_reading *r, const surface *s, const nqm_bsdf_node *bsdf) {
    if (!read_roughness(r, s, bsdf))
        return false;
    const double *roughness = nqm_values_given(&r->reading.values, s->roughness[0]);
    if (roughness && roughness[0] != roughness[1])
        return nqm_refuse(&r->reading, bsdf, "%s and %s differ; the coat is read with one roughness", s->roughness[1],
                          s->roughness[2]);
    return true;
}

static bool finish_coated_conductor(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    return read_one_roughness(r, &interface, bsdf) && read_one_roughness(r, &coated, bsdf) && read_index(r, &coated);
}

static bool finish_coated_diffuse(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf) {
    const double grey[3] = {0.5, 0.5, 0.5};
    uint16_t value;
    return read_one_roughness(r, &bare, bsdf) && read_value(r, "reflectance", 3, grey, &value) &&
           nqm_bsdf_output(r, "reflectance", clamp(r->reading.textured, value, 1));
}

#define NUMBER(NAME)                                                                                                   \
    { .name = NAME, .read = nqm_rule_set, .key = NAME, .n = 1 }
#define DISPLACEMENT                                                                                                   \
    { .name = "displacement", .read = read_displacement, .n = 1 }
#define NORMAL_MAP                                                                                                     \
    { .name = "normalmap", .read = read_normal_map }
#define MEDIUM                                                                                                         \
    { .name = "albedo", .read = nqm_rule_neutral, .n = 3, .why = "a medium that scatters is not supported" }
static const nqm_bsdf_plugin types[] = {
    {.type = "conductor",
     .model = "pbrt-conductor",
     .finish = finish_conductor,
     .rules = {NQM_RULE_LATER("eta k reflectance roughness uroughness vroughness remaproughness"), NORMAL_MAP,
               DISPLACEMENT}},
    {.type = "diffuse",
     .model = "lambert",
     .finish = finish_diffuse,
     .rules = {NQM_RULE_LATER("reflectance"), NORMAL_MAP, DISPLACEMENT}},
    {.type = "measured", .rules = {{.name = "filename", .read = nqm_bsdf_file}}},
    {.type = "coateddiffuse",
     .model = "pbrt-coated-diffuse",
     .finish = finish_coated_diffuse,
     .rules = {NQM_RULE_LATER("reflectance roughness uroughness vroughness remaproughness"), NUMBER("eta"),
               NUMBER("thickness"), NUMBER("maxdepth"), MEDIUM, NQM_RULE_IGNORED("g nsamples"), NORMAL_MAP,
               DISPLACEMENT}},
    {.type = "coatedconductor",
     .model = "pbrt-coated-conductor",
     .finish = finish_coated_conductor,
     .rules = {NQM_RULE_LATER(
                   "interface.roughness interface.uroughness interface.vroughness conductor.roughness "
                   "conductor.uroughness conductor.vroughness conductor.eta conductor.k reflectance remaproughness"),
               NUMBER("interface.eta"), NUMBER("thickness"), NUMBER("maxdepth"), MEDIUM, NQM_RULE_IGNORED("g nsamples"),
               NORMAL_MAP, DISPLACEMENT}},
    {.type = "dielectric",
     .model = "pbrt-conductor",
     .finish = finish_dielectric,
     .rules = {NQM_RULE_LATER("eta roughness uroughness vroughness remaproughness"), NORMAL_MAP, DISPLACEMENT}},
    {.type = "thindielectric",
     .model = "pbrt-conductor",
     .finish = finish_dielectric,
     .rules = {NQM_RULE_LATER("eta"), NORMAL_MAP, DISPLACEMENT}},
    {.type = "diffusetransmission",
     .model = "lambert",
     .finish = finish_diffuse_transmission,
     .rules = {NQM_RULE_LATER("reflectance scale"), NQM_RULE_IGNORED("transmittance"), NORMAL_MAP, DISPLACEMENT}},
    {.type = "subsurface",
     .model = "pbrt-conductor",
     .finish = finish_subsurface,
     .rules = {NQM_RULE_LATER("eta roughness uroughness vroughness remaproughness"),
               NQM_RULE_IGNORED("reflectance mfp name sigma_a sigma_s scale g"), NORMAL_MAP, DISPLACEMENT}},
    {.type = "hair", .refusal = "hair has no BRDF of a surface"},
    {.type = "interface", .refusal = "it reflects nothing"},
    {.type = NULL}};

/* The two materials before it that it names, with the weight `amount` of the second. */
static bool read_mix(nqm_bsdf_reading *r, const nqm_materials *materials) {
    const nqm_bsdf_node *mix = &r->nodes->list[r->at], *list = nqm_bsdf_find(r, "materials"), *node = NULL;
    const char *end = list ? strchr(list->value, '\n') : NULL;
    nqm_material_info parts[2];
    double amount = 0.5;
    while ((node = nqm_bsdf_next(r->nodes, r->at, node)))
        if (!nqm_contains_word("materials amount", node->name, false))
            return nqm_refuse(&r->reading, node, "mix has no property '%.40s'", node->name);
    if (!end || list->kind != NQM_BSDF_STRING || strchr(end + 1, '\n'))
        return nqm_refuse(&r->reading, mix, "materials needs the names of two materials");
    if (!nqm_bsdf_numbers(r, "amount", 1, &amount))
        return false;
    for (size_t i = 0; i < 2; ++i) {
        char name[256];
        snprintf(name, sizeof name, "%.*s", i ? (int)strlen(end + 1) : (int)(end - list->value),
                 i ? end + 1 : list->value);
        const size_t number = nqm_pbrt_find(r->ids, "material", name);
        if (number == SIZE_MAX)
            return nqm_refuse(&r->reading, list, "materials: there is no material '%.40s' before it", name);
        parts[i] = nqm_materials_get(materials, number);
    }
    return nqm_reading_mix(&r->reading, list, parts[0], parts[1], fmin(fmax(amount, 0), 1));
}

nqm_status nqm_pbrt_add(const nqm_pbrt_scene *scene, size_t at, const char *type, const char *refusal, nqm_error *err) {
    nqm_bsdf_reading r = {.nodes = &scene->nodes, .at = at, .path = scene->path, .ids = &scene->names};
    const bool has_memory = nqm_reading_begin(&r.reading, &nqm_bsdf_source);
    const nqm_bsdf_node *material = &r.nodes->list[at];
    if (refusal)
        nqm_refuse(&r.reading, material, "%s", refusal);
    else if (has_memory && strcmp(type, "mix") == 0)
        read_mix(&r, scene->materials);
    else if (has_memory)
        nqm_bsdf_read(&r, types, type);
    return nqm_reading_add(&r.reading, material->id, type, material->byte_offset, scene->materials, err);
}
