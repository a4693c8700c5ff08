/* SPDX-License-Identifier: MIT
 *
 * MaterialX documents (.mtlx, version 1.38 and 1.39; https://github.com/AcademySoftwareFoundation/MaterialX,
 * MaterialX.Specification): the materials whose surface shader is in materialx_surfaces.c. Inputs may be connected to
 * the nodes of materialx_nodes.c; where these read images, the material is textured. Other documents (xi:include),
 * looks and geometry are not read.
 */
#include "material/materialx.h"
#include "io/xml.h"
#include "material/material.h"

#include <math.h>

typedef const nqm_xml_element element;

/* Negative components down to this are rounding of a conversion to BT.709, and become 0. */
static const double OUT_OF_GAMUT = -1e-3;

/* What is read of a material. */
typedef struct reading {
    nqm_reading reading;
    nqm_index shaders; /* of `known` */
    struct known_shader {
        element *shader;
        size_t material; /* the first one that has it */
    } known[NQM_MAX_MATERIALS];
    element *shader;
    const nqm_mtlx_surface *surface;
    nqm_mtlx_graph graph;
    element *coat_normal;      /* the input */
    uint16_t coat_normal_node; /* NQM_NO_NODE: none, or 0, 0, 1 */
    char why[200];             /* of describe() */
} reading;

/* ---- values -------------------------------------------------------------------------------------------------------- */

/* Where an input names a type, it is that of the definition; a flag may be boolean. */
static bool has_type(element *e, const char *type) {
    const char *given = nqm_xml_get(e, "type");
    return !given || strcmp(given, type) == 0 || (strcmp(type, "color3") != 0 && strcmp(given, "boolean") == 0);
}

/* The node of an input of the shader; NQM_NO_NODE: refused. */
static uint16_t read_node(reading *r, const nqm_rule *rule, element *input) {
    if (!has_type(input, rule->type)) {
        nqm_refuse(&r->reading, input, "%s is of type %s, not '%.40s'", rule->name, rule->type,
                   nqm_xml_get(input, "type"));
        return NQM_NO_NODE;
    }
    const uint16_t node = nqm_mtlx_read(&r->graph, input, rule->name, rule->type);
    const size_t n = node == NQM_NO_NODE ? rule->n : r->graph.t->nodes[node].n;
    if (n == rule->n)
        return node;
    nqm_refuse(&r->reading, input, "%s needs %zu components, and node '%.60s' has %zu", rule->name, rule->n,
               r->graph.source ? nqm_xml_get(r->graph.source, "name") : "", n);
    return NQM_NO_NODE;
}

/* Why an input has no constant value. */
static const char *describe(reading *r, const nqm_rule *rule) {
    element *node = r->graph.source;
    const bool is_texture = !node || nqm_mtlx_child(&r->graph, node, "input", "file");
    const char *end = r->graph.t->n_images ? "" : ", of texture coordinates alone";
    snprintf(r->why, sizeof r->why, "%s %s node '%.60s'%s%.40s%s%s; only constants are read", rule->name,
             is_texture ? "reads the texture of" : "is computed by", node ? nqm_xml_get(node, "name") : "",
             is_texture ? "" : " (", is_texture ? "" : node->name, is_texture ? "" : ")", end);
    return r->why;
}

/* The value of an input of the shader as 1 or 3 numbers; colours in linear BT.709. */
static bool read_values(nqm_reading *base, const nqm_rule *rule, const void *property, double v[4], size_t *n) {
    reading *r = (reading *)base;
    *n = rule->n;
    const uint16_t node = read_node(r, rule, property);
    if (node == NQM_NO_NODE)
        return false;
    if (!nqm_graph_is_constant(r->graph.t, node))
        return nqm_refuse(base, property, "%s", describe(r, rule));
    memcpy(v, r->graph.t->nodes[node].v, sizeof r->graph.t->nodes[node].v);
    return true;
}

/* Inputs without a value have the default. */
static const void *find_input(nqm_reading *base, const char *name) {
    const reading *r = (const reading *)base;
    element *input = nqm_mtlx_child(&r->graph, r->shader, "input", name);
    return input && nqm_mtlx_has_value(input) ? input : NULL;
}

static int64_t byte_of(const nqm_reading *base, const void *property) {
    (void)base;
    return ((element *)property)->byte_offset;
}

static uint16_t node_of(nqm_reading *base, const nqm_rule *rule, const void *property) {
    return read_node((reading *)base, rule, property);
}

static const nqm_rule_source source = {
    .term = "input", .find = find_input, .read = read_values, .node = node_of, .byte_of = byte_of};

/* ---- a material ---------------------------------------------------------------------------------------------------- */

/* The node of an input that is no constant; NQM_NO_NODE: it is one, or refused. */
static uint16_t read_map(reading *r, const nqm_rule *rule, element *input) {
    const uint16_t node = read_node(r, rule, input);
    return nqm_graph_is_constant(r->graph.t, node) ? NQM_NO_NODE : node;
}

bool nqm_mtlx_read_key(nqm_reading *base, const nqm_rule *rule, const void *property) {
    reading *r = (reading *)base;
    const uint16_t node = read_map(r, rule, property);
    double v[4];
    size_t n;
    if (node != NQM_NO_NODE) {
        nqm_graph_output_set(r->graph.t, rule->key, node);
        return nqm_vary(base, property, "%s", describe(r, rule));
    }
    if (!read_values(base, rule, property, v, &n))
        return false;
    for (size_t c = 0; n == 3 && c < n; ++c) {
        if (v[c] < OUT_OF_GAMUT)
            return nqm_refuse(base, property, "%s is outside BT.709: %.4g %.4g %.4g", rule->name, v[0], v[1], v[2]);
        v[c] = fmax(v[c], 0);
    }
    if (!(v[0] > 0) &&
        nqm_texts_equal(rule->name, "specular_ior")) /* of OpenPBR; MaterialX's velvet has specular_IOR 0 */
        return nqm_refuse(base, property, "%s is %.4g; an index of refraction is above 0", rule->name, v[0]);
    nqm_values_set(&base->values, rule->key, n, v);
    return true;
}

/* The node of a normal; 0, 0, 1 is NQM_NO_NODE. false: refused. UsdPreviewSurface takes the vector in the frame of the tangent, the
 * other surfaces take what a node normalmap makes of it. */
static bool read_normal(reading *r, const nqm_rule *rule, element *input, uint16_t *node_ret) {
    const bool is_usd = nqm_texts_equal(r->surface->model, "usd-preview");
    nqm_textured *t = r->graph.t;
    *node_ret = NQM_NO_NODE;
    uint16_t node = nqm_mtlx_read(&r->graph, input, rule->name, "vector3");
    if (node == NQM_NO_NODE)
        return false;
    const nqm_map_node value = t->nodes[node];
    if (value.op == NQM_MAP_VALUE && value.n == 3 && value.v[0] == 0 && value.v[1] == 0 && value.v[2] == 1)
        return true;
    if (value.n != 3 || value.op == NQM_MAP_VALUE || (!is_usd && value.op != NQM_MAP_NORMAL))
        return nqm_refuse(&r->reading, input, "%s changes the normal, and not by a normal map", rule->name);
    if (is_usd) {
        node = nqm_graph_with(t, NQM_MAP_ADD, 3, nqm_graph_with(t, NQM_MAP_MULTIPLY, 3, node, 0.5), 0.5);
        node = nqm_graph_with(t, NQM_MAP_NORMAL, 3, node, 1);
    }
    *node_ret = node;
    return node != NQM_NO_NODE ||
           nqm_refuse(&r->reading, input, "%s: its graph needs too many nodes, or memory is short", rule->name);
}

bool nqm_mtlx_read_normal(nqm_reading *base, const nqm_rule *rule, const void *property) {
    reading *r = (reading *)base;
    uint16_t node;
    if (!read_normal(r, rule, property, &node))
        return false;
    r->graph.t->normal = node;
    return node == NQM_NO_NODE || nqm_vary(base, property, "%s changes the normal; a BRDF has one normal", rule->name);
}

bool nqm_mtlx_read_coat_normal(nqm_reading *base, const nqm_rule *rule, const void *property) {
    reading *r = (reading *)base;
    r->coat_normal = property;
    return read_normal(r, rule, property, &r->coat_normal_node);
}

/* A coat with a normal of its own is refused; one that is smooth on a base with a normal map is evaluated with that. */
static bool check_coat_normal(reading *r) {
    static const char *const weights[] = {"coat", "coat_weight", "clearcoat"};
    const uint16_t base = r->graph.t->normal;
    bool has_coat = false;
    for (size_t i = 0; i < 3; ++i) {
        const double *weight = nqm_values_given(&r->reading.values, weights[i]);
        has_coat = has_coat || (weight && *weight > 0) || nqm_graph_output(r->graph.t, weights[i]);
    }
    if (r->coat_normal_node == base || !has_coat || nqm_texts_equal(r->surface->model, "usd-preview"))
        return true;
    if (r->coat_normal_node != NQM_NO_NODE)
        return nqm_refuse(&r->reading, r->coat_normal, "%s changes the normal of the coat alone; a BRDF has one normal",
                          nqm_xml_get(r->coat_normal, "name"));
    nqm_textured_remark(r->graph.t, "the coat, which is smooth in the file, has the normal map of the base");
    return true;
}

/* Whether both inputs of the shader have the same value everywhere. */
static bool is_same_color(reading *r, const char *a, const char *b) {
    element *inputs[2] = {find_input(&r->reading, a), find_input(&r->reading, b)};
    if (!inputs[0] || !inputs[1])
        return false;
    const uint16_t node = nqm_mtlx_read(&r->graph, inputs[0], a, "color3");
    return node != NQM_NO_NODE && node == nqm_mtlx_read(&r->graph, inputs[1], b, "color3");
}

bool nqm_mtlx_read_subsurface(nqm_reading *base, const nqm_rule *rule, const void *property) {
    reading *r = (reading *)base;
    if (read_map(r, rule, property) == NQM_NO_NODE || !is_same_color(r, "subsurface_color", "base_color"))
        return nqm_rule_neutral(base, rule, property);
    nqm_textured_remark(r->graph.t,
                        "light leaves the surface where it arrives: the map of the subsurface scattering, which "
                        "has the color of the base, is ignored");
    return true;
}

bool nqm_mtlx_read_emission(nqm_reading *base, const nqm_rule *rule, const void *property) {
    reading *r = (reading *)base;
    if (read_map(r, rule, property) == NQM_NO_NODE)
        return nqm_rule_neutral(base, rule, property);
    nqm_textured_remark(r->graph.t, "the map of the emission is ignored: emission is no part of a BRDF");
    return true;
}

bool nqm_mtlx_read_tangent(nqm_reading *r, const nqm_rule *rule, const void *property) {
    return nqm_refuse(r, property, "%s turns the anisotropy (%s), which needs the tangent of the surface", rule->name,
                      rule->gate);
}

bool nqm_mtlx_read_unused(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const char *name = nqm_xml_get(property, "name");
    char text[160];
    (void)rule;
    snprintf(text, sizeof text, "'%.60s' is ignored: no part of the reflection of UsdPreviewSurface", name);
    if (strcmp(name, "displacement") != 0 || !nqm_texts_equal(nqm_xml_get(property, "value"), "0"))
        nqm_textured_remark(r->textured, text);
    return true;
}

bool nqm_mtlx_read_occlusion(nqm_reading *r, const nqm_rule *rule, const void *property) {
    (void)rule, (void)property;
    nqm_textured_remark(r->textured, NQM_OCCLUSION_REMARK);
    return true;
}

/* Version 1.0.0 of standard_surface, and the film of gltf_pbr, have other defaults than the table. */
static void set_defaults(reading *r) {
    const char *version = nqm_xml_get(r->shader, "version"), *definition = nqm_xml_get(r->shader, "nodedef");
    nqm_values *values = &r->reading.values;
    *values = nqm_values_of(nqm_schema_find(r->surface->model, strlen(r->surface->model)));
    for (const nqm_rule *rule = r->surface->inputs; rule->name; ++rule)
        if (rule->key)
            nqm_values_set(values, rule->key, rule->n, (double[]){rule->value, rule->value, rule->value});
    if (strcmp(r->surface->node, "gltf_pbr") == 0)
        nqm_values_set(values, "iridescence_thickness", 1, (double[]){100});
    if (strcmp(r->surface->node, "standard_surface") == 0 &&
        (nqm_texts_equal(version, "1.0.0") || nqm_texts_equal(definition, "ND_standard_surface_surfaceshader_100"))) {
        nqm_values_set(values, "base", 1, (double[]){0.8});
        nqm_values_set(values, "base_color", 3, (double[]){1, 1, 1});
    }
}

/* The albedo of subsurface scattering; of a sheet, the part of it that returns to the side of the light. */
static bool read_subsurface_color(reading *r) {
    const bool is_open = nqm_texts_equal(r->surface->model, "open-pbr");
    const nqm_rule color = {.name = "subsurface_color", .n = 3, .type = "color3"};
    const nqm_rule thin = {.name = is_open ? "geometry_thin_walled" : "thin_walled", .n = 1, .type = "boolean"};
    const nqm_rule forward = {.name = "subsurface_scatter_anisotropy", .n = 1, .type = "float"};
    const void *given = find_input(&r->reading, color.name), *sheet = find_input(&r->reading, thin.name);
    const void *scatter = find_input(&r->reading, forward.name);
    double v[4] = {0}, g[4] = {0};
    size_t n;
    uint16_t node = nqm_graph_number(r->graph.t, is_open ? 0.8 : 1);
    if (given && (node = read_node(r, &color, given)) == NQM_NO_NODE)
        return false;
    if ((sheet && !read_values(&r->reading, &thin, sheet, v, &n)) ||
        (v[0] != 0 && is_open && scatter && !read_values(&r->reading, &forward, scatter, g, &n)))
        return false;
    if (v[0] != 0)
        node = nqm_graph_with(r->graph.t, NQM_MAP_MULTIPLY, 3, node, is_open ? (1 - g[0]) / 2 : 0);
    r->reading.subsurface_color = node;
    return true;
}

/* Whether an input before this one has its name and a value; those without a value are the defaults. */
static bool is_repeated(const reading *r, const element *input) {
    const element *e = r->shader->first;
    const char *name = nqm_xml_get(input, "name");
    while (e != input &&
           !(strcmp(e->name, "input") == 0 && nqm_mtlx_has_value(e) && nqm_texts_equal(name, nqm_xml_get(e, "name"))))
        e = e->next;
    return e != input;
}

static bool read_shader(reading *r) {
    r->surface = nqm_mtlx_find_surface(r->shader->name, NULL);
    if (!r->surface)
        return nqm_refuse(&r->reading, r->shader,
                          "its surface shader is '%.40s', which is not one of those that are read", r->shader->name);
    r->reading.rules = r->surface->inputs;
    r->reading.owner = r->surface->node;
    set_defaults(r);
    const bool is_usd =
        strcmp(r->surface->model, "usd-preview") == 0; /* exporters write `specular`, which renderers ignore */
    bool ok = true;
    for (element *e = r->shader->first; e && ok; e = e->next) {
        const char *name = nqm_xml_get(e, "name");
        if (strcmp(e->name, "input") != 0 || !nqm_mtlx_has_value(e))
            continue;
        if (is_usd && name && !nqm_rule_find(r->surface->inputs, name))
            nqm_mtlx_read_unused(&r->reading, NULL, e);
        else
            ok = nqm_rules_apply(&r->reading, name, e, is_repeated(r, e));
    }
    if (ok && r->reading.weights[1] != NQM_NO_NODE)
        ok = read_subsurface_color(r);
    return ok && check_coat_normal(r);
}

/* The node that a material's input `surfaceshader` is connected to; NULL: refused. */
static element *find_shader(reading *r, element *material) {
    element *input = nqm_mtlx_child(&r->graph, material, "input", "surfaceshader");
    if (!input) {
        nqm_refuse(&r->reading, material, "it has no surface shader");
        return NULL;
    }
    element *shader = nqm_mtlx_target(&r->graph, input);
    if (shader && strcmp(shader->name, "output") == 0)
        shader = nqm_mtlx_target(&r->graph, shader);
    if (!shader)
        nqm_refuse(&r->reading, input, "its surface shader is not in the file");
    return shader;
}

/* Whether the input is 0, given or by its default. */
static bool is_zero(reading *r, element *shader, const char *name, bool is_default_zero) {
    element *input = nqm_mtlx_child(&r->graph, shader, "input", name);
    if (!input || !nqm_mtlx_has_value(input))
        return is_default_zero;
    const uint16_t node = nqm_mtlx_read(&r->graph, input, name, "float");
    const nqm_map_node *value = nqm_graph_is_constant(r->graph.t, node) ? &r->graph.t->nodes[node] : NULL;
    if (!strstr(r->reading.refusal.text, "memory")) /* it is not the reflection that cannot be read */
        r->reading.refusal = (nqm_reason){.byte_offset = 0};
    return value && value->v[0] == 0 && value->v[1] == 0 && value->v[2] == 0;
}

/* A displacement of 0, or times 0, has no effect. */
static void check_displacement(reading *r, element *material) {
    element *input = nqm_mtlx_child(&r->graph, material, "input", "displacementshader");
    element *shader = input && nqm_mtlx_is_connected(input) ? nqm_mtlx_target(&r->graph, input) : NULL;
    if (shader && strcmp(shader->name, "output") == 0)
        shader = nqm_mtlx_target(&r->graph, shader);
    const bool is_known = shader && nqm_contains_word("displacement UsdPreviewSurface", shader->name, false);
    const bool is_neutral =
        is_known && (is_zero(r, shader, "displacement", true) || is_zero(r, shader, "scale", false));
    if (input && nqm_mtlx_is_connected(input) && !is_neutral)
        nqm_set_aside(&r->reading, NQM_IGNORE_DISPLACEMENT, input,
                      "displacementshader is connected: displacement is not part of a BRDF");
}

static nqm_index_key key_of_known(const void *value) {
    return (nqm_index_key){((const struct known_shader *)value)->shader, ""};
}

/* Add a material whose shader an earlier one has, too. */
static nqm_status add_again(size_t i, element *material, nqm_materials *materials, nqm_error *err) {
    nqm_material_info info = nqm_materials_get(materials, i);
    info.name = nqm_xml_get(material, "name");
    info.byte_offset = info.spec ? material->byte_offset : info.byte_offset;
    const nqm_status status = nqm_materials_add(materials, &info, err);
    if (status == NQM_OK)
        nqm_materials_attach(materials, nqm_materials_maps(materials, i, ~0U), false);
    return status;
}

/* `material` is a surfacematerial, or a shader that no material uses. */
static nqm_status add_material(reading *r, element *material, nqm_materials *materials, nqm_error *err) {
    const size_t number = nqm_materials_count(materials);
    const bool has_memory = nqm_reading_begin(&r->reading, &source);
    r->graph.t = r->reading.textured;
    r->graph.n_built = 0;
    r->graph.depth = 0;
    r->coat_normal_node = NQM_NO_NODE;
    r->shader = strcmp(material->name, "surfacematerial") == 0 ? find_shader(r, material) : material;
    const bool has_shader = r->shader && has_memory, is_own = nqm_xml_get(material, "remark") != NULL;
    if (has_memory && is_own)
        nqm_textured_remark(r->graph.t, nqm_xml_get(material, "remark"));
    if (has_shader)
        check_displacement(r, material);
    const bool is_shared = has_shader && !is_own && !r->reading.ignorable;
    const struct known_shader *known = is_shared ? nqm_index_find(&r->shaders, (nqm_index_key){r->shader, ""}) : NULL;
    if (known) {
        nqm_textured_free(r->graph.t);
        return add_again(known->material, material, materials, err);
    }
    if (!nqm_materials_reserve(materials, 0))
        nqm_refuse(&r->reading, material, NQM_MATERIALS_FULL);
    else if (has_shader)
        read_shader(r);
    nqm_status status =
        nqm_reading_add(&r->reading, nqm_xml_get(material, "name"), r->shader ? r->shader->name : material->name,
                        material->byte_offset, materials, err);
    if (status == NQM_OK && is_shared) {
        r->known[number] = (struct known_shader){r->shader, number};
        nqm_index_add(&r->shaders, &r->known[number]);
    }
    return status;
}

/* The surfacematerials, or the shaders if there are none. */
static nqm_status add_all(reading *r, nqm_materials *materials, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (element *e = r->graph.root->first; e && status == NQM_OK; e = e->next)
        if (strcmp(e->name, "surfacematerial") == 0)
            status = add_material(r, e, materials, err);
    const bool has_none = nqm_materials_count(materials) == 0;
    for (element *e = r->graph.root->first; e && status == NQM_OK && has_none; e = e->next)
        if (nqm_mtlx_find_surface(e->name, NULL))
            status = add_material(r, e, materials, err);
    return status;
}

nqm_status nqm_mtlx_read_document(const nqm_xml *xml, const char *path, nqm_materials *materials, nqm_error *err) {
    reading *r = nqm_alloc(1, sizeof *r);
    if (!r)
        return nqm_fail_nomem(err, sizeof *r);
    r->graph.path = path;
    r->graph.root = xml->root;
    r->graph.reading = &r->reading;
    nqm_status status = nqm_xml_names_create(xml->n_elements, xml, &r->graph.names, err);
    if (status == NQM_OK)
        status = nqm_index_create(NQM_MAX_MATERIALS, key_of_known, &r->shaders, err);
    if (status == NQM_OK)
        status = add_all(r, materials, err);
    nqm_index_free(&r->graph.names);
    nqm_index_free(&r->shaders);
    nqm_free(r);
    return status;
}

/* ---- a file -------------------------------------------------------------------------------------------------------- */

static bool probe(const nqm_map *map) {
    return nqm_material_probe_text(map, nqm_smaller(map->n_bytes, 4096), "<materialx");
}

static nqm_status fail_empty(const nqm_map *map, element *root, nqm_error *err) {
    for (element *e = root->first; e; e = e->next)
        if (strcmp(e->name, "material") == 0)
            return nqm_fail(
                err, NQM_ERR_FORMAT, e->byte_offset,
                "%s: its material (byte %lld) is of MaterialX %.10s, which is not read: open it with MaterialX "
                "1.38 or later, which upgrades it, and write it",
                map->path, (long long)e->byte_offset,
                nqm_xml_get(root, "version") ? nqm_xml_get(root, "version") : "1.37 or older");
        else if (strcmp(e->name, "xi:include") == 0)
            return nqm_fail(
                err, NQM_ERR_FORMAT, e->byte_offset,
                "%s: it has no material of its own, and includes '%.80s' (byte %lld), which is not read: open "
                "that file",
                map->path, nqm_xml_get(e, "href") ? nqm_xml_get(e, "href") : "", (long long)e->byte_offset);
    return nqm_fail(err, NQM_ERR_FORMAT, root->byte_offset, "%s: no surfacematerial in this MaterialX file (byte %lld)",
                    map->path, (long long)root->byte_offset);
}

static nqm_status read_materials(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    nqm_xml xml;
    nqm_status status = nqm_xml_parse(map->data, map->n_bytes, map->path, &xml, err);
    if (status != NQM_OK)
        return status;
    if (strcmp(xml.root->name, "materialx") != 0)
        status =
            nqm_fail(err, NQM_ERR_FORMAT, xml.root->byte_offset, "%s: the root is <%.40s>, not <materialx> (byte %lld)",
                     map->path, xml.root->name, (long long)xml.root->byte_offset);
    if (status == NQM_OK)
        status = nqm_mtlx_read_document(&xml, map->path, materials, err);
    if (status == NQM_OK && nqm_materials_count(materials) == 0)
        status = fail_empty(map, xml.root, err);
    nqm_xml_free(&xml);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------------- */

static void write_material(const nqm_values *values, const char *name, FILE *stream) {
    char numbers[100];
    const nqm_mtlx_surface *surface =
        nqm_mtlx_find_surface(NULL, values->schema->model); /* one of those of the format */
    fprintf(stream, "  <%s name=\"SR_%s\" type=\"surfaceshader\">\n", surface->node, name);
    for (size_t k = 0; k < values->schema->n_keys; ++k) {
        const nqm_rule *input = nqm_rule_find(surface->inputs, values->schema->keys[k].name);
        if (!(values->given >> k & 1))
            continue;
        fprintf(stream, "    <input name=\"%s\" type=\"%s\" value=\"%s\" />\n", input->name, input->type,
                nqm_format_doubles(numbers, sizeof numbers, input->n, values->v[k], ", "));
    }
    fprintf(stream,
            "  </%s>\n  <surfacematerial name=\"%s\" type=\"material\">\n"
            "    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"SR_%s\" />\n  </surfacematerial>\n",
            surface->node, name, name);
}

static nqm_status write_materialx(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                                  nqm_error *err) {
    (void)path;
    (void)err;
    fputs("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n", stream);
    for (size_t i = 0; i < n; ++i)
        write_material(&materials[i].values, materials[i].name, stream);
    fputs("</materialx>\n", stream);
    return NQM_OK;
}

const nqm_material_format nqm_materialx_format = {
    .name = "MaterialX",
    .extensions = ".mtlx",
    .models = "open-pbr standard-surface gltf usd-preview disney",
    .probe = probe,
    .read = read_materials,
    .write = write_materialx,
};
