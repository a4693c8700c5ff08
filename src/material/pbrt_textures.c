/* SPDX-License-Identifier: MIT
 *
 * Colours and textures of pbrt-v4: of the classes imagemap, constant, scale and mix, as nodes of a textured material.
 */
#include "material/pbrt.h"

/* ---- colours ----------------------------------------------------------------------------------------------------- */

/* "metal-Au-eta" */
static bool read_metal(nqm_bsdf_reading *r, const nqm_bsdf_node *node, double v[3]) {
    char name[NQM_PBRT_MAX_TOKEN] = "", names[300];
    const char *part = node->name;
    const size_t n = strlen(node->value), n_part = strlen(part);
    if (n > 7 + n_part && n < sizeof name && strncmp(node->value, "metal-", 6) == 0 &&
        node->value[n - n_part - 1] == '-' && strcmp(node->value + n - n_part, part) == 0)
        memcpy(name, node->value + 6, n - 7 - n_part);
    const nqm_metal *metal = nqm_metal_find(name);
    nqm_metal_names(names, sizeof names);
    if (!metal)
        return nqm_refuse(&r->reading, node, "%s: the spectrum '%.40s' is not known; these metals are: %s", part,
                          node->value, names);
    memcpy(v, strcmp(part, "k") == 0 ? metal->k : metal->eta, 3 * sizeof *v);
    return true;
}

/* A constant colour; `v` keeps its value when the parameter is not given. */
static bool read_colour(nqm_bsdf_reading *r, const char *name, double v[3]) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    const bool is_spectrum = node && node->kind == NQM_BSDF_SPECTRUM;
    if (is_spectrum && strcmp(name, "reflectance") != 0 && !strchr(node->value, ' '))
        return read_metal(r, node, v);
    if (is_spectrum)
        return nqm_refuse(&r->reading, node, "%s is a spectrum by wavelength; only RGB is read", name);
    if (node && node->kind == NQM_BSDF_NUMBER)
        return nqm_refuse(&r->reading, node, "%s needs three numbers, \"rgb %s\" [ r g b ]", name, name);
    return nqm_bsdf_numbers(r, name, 3, v);
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

enum { MAX_TEXTURES = 256 }; /* a mix of mixes of the same two textures names them exponentially often */

static bool read_texture(nqm_bsdf_reading *r, size_t n, uint16_t *value_ret);

/* The value of the texture that a parameter names. Floats (n = 1) and spectra (n = 3) have names of their own. */
static bool read_named(nqm_bsdf_reading *r, const nqm_bsdf_node *parameter, size_t n, uint16_t *value_ret) {
    const nqm_bsdf_nodes *nodes = r->nodes;
    const size_t at = r->at, end = nodes == r->textures ? at : r->textures->n; /* none contains itself */
    const char *type = n == 3 ? "spectrum" : "float";
    const nqm_bsdf_node *list = r->textures->list;
    size_t i = 0;
    while (i < end && !(list[i].parent == NQM_BSDF_ROOT && strcmp(list[i].name, type) == 0 &&
                        strcmp(list[i].id, parameter->value) == 0))
        ++i;
    if (i == end)
        return nqm_refuse(&r->reading, parameter, "%s: there is no %s texture '%.40s' before it", parameter->name, type,
                          parameter->value);
    if (++r->n_textures > MAX_TEXTURES)
        return nqm_refuse(&r->reading, parameter, "%s: more than %d textures", parameter->name, MAX_TEXTURES);
    nqm_bsdf_varies(r, parameter);
    r->nodes = r->textures;
    r->at = i;
    const bool is_read = read_texture(r, n, value_ret);
    r->nodes = nodes;
    r->at = at;
    return is_read;
}

bool nqm_pbrt_value(nqm_bsdf_reading *r, const char *name, size_t n, const double *missing, uint16_t *value_ret) {
    const nqm_bsdf_node *node = nqm_bsdf_find(r, name);
    double v[3] = {0};
    if (nqm_bsdf_is_texture(node))
        return read_named(r, node, n, value_ret);
    if (!node)
        memcpy(v, missing, n * sizeof *v);
    if (!(n == 3 ? read_colour(r, name, v) : nqm_bsdf_numbers(r, name, 1, v)))
        return false;
    *value_ret = nqm_map_value(r->reading.textured, n, v);
    return true;
}

/* The image, decoded: pbrt uses `encoding` for PNG only, and that of sRGB for other images of 8 bits. */
static bool read_image(nqm_bsdf_reading *r, const nqm_bsdf_node *file, const char *encoding, const double uv[2][3],
                       nqm_map_wrap wrap, uint16_t *value_ret) {
    const char *dot = strrchr(file->value, '.'), *end;
    double gamma = 1;
    if (nqm_bsdf_is_float_image(file->value))
        encoding = "linear";
    else if (!dot || !nqm_has_word(".png", dot, true))
        encoding = "sRGB";
    const bool is_srgb = strcmp(encoding, "sRGB") == 0;
    if (!is_srgb && strcmp(encoding, "linear") != 0 &&
        (strncmp(encoding, "gamma ", 6) != 0 || !nqm_parse_double(encoding + 6, &end, &gamma) || *end || gamma <= 0))
        return nqm_refuse(&r->reading, file, "encoding '%.40s' is not read; use sRGB, linear or gamma with a number",
                          encoding);
    if (!nqm_bsdf_image(r, file, is_srgb ? "srgb_texture" : "", uv, wrap, value_ret))
        return false;
    if (gamma != 1)
        *value_ret = nqm_map_with(r->reading.textured, NQM_MAP_POWER, 3, *value_ret, gamma);
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

/* The imagemap r->at; a number is the mean of RGB. */
static bool read_imagemap(nqm_bsdf_reading *r, size_t n, uint16_t *value_ret) {
    static const nqm_map_wrap wraps[] = {NQM_MAP_REPEAT, NQM_MAP_BORDER, NQM_MAP_CLAMP};
    const nqm_bsdf_node *file = nqm_bsdf_filename(r), *encoding = nqm_bsdf_find(r, "encoding");
    nqm_textured *t = r->reading.textured;
    double uv[2][3], scale = 1;
    bool is_inverted = false;
    size_t wrap;
    if (!file || !read_mapping(r, uv) || !nqm_bsdf_choice(r, "wrap", "repeat black clamp", &wrap) ||
        !nqm_bsdf_numbers(r, "scale", 1, &scale) || !nqm_bsdf_flag(r, "invert", &is_inverted) ||
        !read_image(r, file, encoding ? encoding->value : "sRGB", uv, wraps[wrap], value_ret))
        return false;
    uint16_t value = *value_ret;
    if (n == 1) {
        value = nqm_map_channel(t, *value_ret, 0);
        for (size_t c = 1; c < 3; ++c)
            value = nqm_map_compute(t, NQM_MAP_ADD, 1, value, nqm_map_channel(t, *value_ret, c), 0);
        value = nqm_map_with(t, NQM_MAP_MULTIPLY, 1, value, 1.0 / 3);
    }
    value = nqm_map_with(t, NQM_MAP_MULTIPLY, n, value, scale);
    if (is_inverted) {
        value = nqm_map_compute(t, NQM_MAP_SUBTRACT, n, nqm_map_number(t, 1), value, 0);
        value = nqm_map_with(t, NQM_MAP_MAXIMUM, n, value, 0);
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
        return nqm_pbrt_value(r, "value", n, one, value_ret);
    if (!is_mix && strcmp(texture->type, "scale") != 0)
        return nqm_refuse(&r->reading, texture,
                          "the texture '%.40s' is of class '%.40s'; imagemap, constant, scale and mix are read",
                          texture->id, texture->type);
    if (is_mix ? !nqm_pbrt_value(r, "tex1", n, zero, &a) || !nqm_pbrt_value(r, "tex2", n, one, &b) ||
                     !nqm_pbrt_value(r, "amount", 1, &half, &amount)
               : !nqm_pbrt_value(r, "tex", n, one, &a) || !nqm_pbrt_value(r, "scale", 1, one, &b))
        return false;
    *value_ret = nqm_map_compute(r->reading.textured, is_mix ? NQM_MAP_MIX : NQM_MAP_MULTIPLY, n, a, b, amount);
    return true;
}

/* RGB of the file that the parameter names; it is repeated, and linear as far as pbrt allows that. */
bool nqm_pbrt_normal_map(nqm_reading *r, const nqm_rule *rule, const void *property) {
    nqm_bsdf_reading *bsdf = (nqm_bsdf_reading *)r;
    const nqm_bsdf_node *node = property;
    uint16_t rgb;
    if (node->kind != NQM_BSDF_STRING || !*node->value)
        return nqm_refuse(r, node, "%s needs the name of a file", rule->name);
    return nqm_reading_textured(r, node, "normalmap varies over the surface") &&
           read_image(bsdf, node, "linear", NULL, NQM_MAP_REPEAT, &rgb) && nqm_bsdf_output(bsdf, "normal", rgb);
}
