/* SPDX-License-Identifier: MIT
 *
 * MaterialX documents (.mtlx, version 1.38 and 1.39; https://github.com/AcademySoftwareFoundation/MaterialX, MaterialX.Specification): the
 * materials whose surface shader is in materialx_surfaces.c, with constant inputs. Inputs may be connected to nodes `constant`
 * and `dot`, to outputs of node graphs and to inputs of the graph, as long as a number is at the end. Other documents
 * (xi:include), looks and geometry are not read.
 */
#include "material/materialx.h"
#include "io/xml.h"
#include "material/color_space.h"
#include "material/material.h"

#include <math.h>

typedef const nqm_xml_element element;

enum { MAX_HOPS = 32 };

/* Negative components down to this are rounding of a conversion to BT.709, and become 0. */
static const double OUT_OF_GAMUT = -1e-3;

/* What is read of a material. */
typedef struct reading {
    nqm_reading reading;
    nqm_index names;
    nqm_index shaders; /* of `known` */
    struct known_shader {
        element *shader;
        size_t material; /* the first one that has it */
    } * known;           /* (NQM_MAX_MATERIALS) */
    element *root, *material, *shader;
    const nqm_mtlx_surface *surface;
} reading;

/* ---- finding elements ---------------------------------------------------------------------------------------------- */

static bool is_text(const char *a, const char *b) {
    return a && strcmp(a, b) == 0;
}

/* The first child with this name attribute; `category` NULL: of any element. */
static element *find_child(const reading *r, element *parent, const char *category, const char *name) {
    return parent && name ? nqm_xml_find(&r->names, parent, category, name) : NULL;
}

/* An attribute of the element or of the nearest enclosing element that has it. */
static const char *inherited(element *e, const char *attribute) {
    const char *value = NULL;
    for (; e && !value; e = e->parent)
        value = nqm_xml_get(e, attribute);
    return value;
}

/* ---- values -------------------------------------------------------------------------------------------------------- */

static bool is_connected(element *e) {
    return nqm_xml_get(e, "nodename") || nqm_xml_get(e, "nodegraph") || nqm_xml_get(e, "interfacename");
}

/* The element whose children an input or output may be connected to. Inputs of a node graph itself are connected
 * outside of it. */
static element *scope_of(const reading *r, element *e) {
    if (e->parent == r->root)
        return r->root;
    if (strcmp(e->parent->name, "nodegraph") == 0)
        return strcmp(e->name, "output") == 0 ? e->parent : r->root;
    return e->parent->parent;
}

/* What a connected node passes on unchanged: its input, or NULL (refused). */
static element *pass_through(reading *r, const char *name, element *input, element *node) {
    const char *node_name = nqm_xml_get(node, "name");
    if (strcmp(node->name, "constant") == 0)
        return find_child(r, node, "input", "value");
    if (strcmp(node->name, "dot") == 0)
        return find_child(r, node, "input", "in");
    if (find_child(r, node, "input", "file"))
        nqm_refuse(&r->reading, input, "%s reads the texture of node '%.60s'; only constants are read", name,
                   node_name);
    else
        nqm_refuse(&r->reading, input, "%s is computed by node '%.60s' (%.40s); only constants are read", name,
                   node_name, node->name);
    return NULL;
}

/* What an input or output is connected to; NULL: nothing that the file has, or refused. */
static element *hop(reading *r, const char *name, element *input, element *at) {
    const char *node_name = nqm_xml_get(at, "nodename"), *graph_name = nqm_xml_get(at, "nodegraph");
    const char *interface = nqm_xml_get(at, "interfacename"), *output = nqm_xml_get(at, "output");
    if (interface)
        return find_child(r, at->parent->parent, "input", interface);
    if (graph_name)
        return find_child(r, find_child(r, r->root, "nodegraph", graph_name), "output", output ? output : "out");
    element *node = find_child(r, scope_of(r, at), NULL, node_name);
    return node ? pass_through(r, name, input, node) : NULL;
}

/* The element that has the number: follow the connections of an input. NULL: refused; the name of the shader's input is for the
 * message. */
static element *follow(reading *r, const char *name, element *input) {
    element *at = input;
    for (int n = 0; n < MAX_HOPS; ++n) {
        if (!is_connected(at))
            return at;
        at = hop(r, name, input, at);
        if (!at && !*r->reading.refusal)
            nqm_refuse(&r->reading, input, "%s is connected to something that the file does not have", name);
        if (!at)
            return NULL;
    }
    nqm_refuse(&r->reading, input, "%s: more than %d connections in a row", name, MAX_HOPS);
    return NULL;
}

/* Parse n numbers separated by commas. */
static bool parse_numbers(const char *text, size_t n, double *v) {
    for (size_t c = 0; c < n; ++c) {
        text += strspn(text, " \t\n");
        if (!nqm_parse_double(text, &text, &v[c]))
            return false;
        text += strspn(text, " \t\n");
        if (*text != (c + 1 < n ? ',' : 0))
            return false;
        text += c + 1 < n;
    }
    return true;
}

/* Where an input and the constant that it is connected to name types, these are that of the definition; a flag may be boolean. */
static bool has_type(element *e, const char *type) {
    const char *given = nqm_xml_get(e, "type");
    return !given || strcmp(given, type) == 0 || (strcmp(type, "color3") != 0 && strcmp(given, "boolean") == 0);
}

static bool has_value(element *e) {
    return is_connected(e) || nqm_xml_get(e, "value");
}

/* The value of an input of the shader as 1 or 3 numbers; colours in linear BT.709. */
static bool read_values(nqm_reading *base, const nqm_rule *rule, const void *property, double v[4], size_t *n) {
    reading *r = (reading *)base;
    element *input = property;
    const char *name = rule->name, *type = rule->type;
    *n = rule->n;
    v[0] = v[1] = v[2] = rule->value;
    if (!has_value(input))
        return true;
    element *at = follow(r, name, input);
    if (!at)
        return false;
    const char *text = nqm_xml_get(at, "value");
    if (!text)
        return nqm_refuse(base, input, "%s has no value", name);
    if (!has_type(input, type) || !has_type(at, type))
        return nqm_refuse(base, input, "%s is of type %s, not '%.40s'", name, type,
                          nqm_xml_get(has_type(input, type) ? at : input, "type"));
    if (is_text(nqm_xml_get(at, "type"), "boolean") && *n == 1 && (is_text(text, "true") || is_text(text, "false"))) {
        v[0] = *text == 't';
        return true;
    }
    if (!parse_numbers(text, *n, v))
        return nqm_refuse(base, input, "%s needs %s, not '%.40s'", name, *n == 3 ? "three numbers" : "a number", text);
    const char *space = inherited(at, "colorspace");
    if (*n == 3 && !nqm_color_to_rec709(space, v))
        return nqm_refuse(base, input, "%s is in the colour space '%.40s', which is not known", name, space);
    for (size_t c = 0; c < *n; ++c)
        if (!isfinite(v[c]))
            return nqm_refuse(base, input, "%s is not finite", name);
    return true;
}

static const void *find_input(nqm_reading *base, const char *name) {
    const reading *r = (const reading *)base;
    return find_child(r, r->shader, "input", name);
}

static int64_t byte_of(const nqm_reading *base, const void *property) {
    (void)base;
    return ((element *)property)->byte_offset;
}

static const nqm_rule_source source = {.term = "input", .find = find_input, .read = read_values, .byte_of = byte_of};

/* ---- a material ---------------------------------------------------------------------------------------------------- */

bool nqm_mtlx_read_key(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[4];
    size_t n;
    if (!has_value(property))
        return true; /* the default, which is set */
    if (!read_values(r, rule, property, v, &n))
        return false;
    for (size_t c = 0; n == 3 && c < n; ++c) {
        if (v[c] < OUT_OF_GAMUT)
            return nqm_refuse(r, property, "%s is outside BT.709: %.4g %.4g %.4g", rule->name, v[0], v[1], v[2]);
        v[c] = fmax(v[c], 0);
    }
    if (!(v[0] > 0) && is_text(rule->name, "specular_ior")) /* of OpenPBR; MaterialX's velvet has specular_IOR 0 */
        return nqm_refuse(r, property, "%s is %.4g; an index of refraction is above 0", rule->name, v[0]);
    nqm_shading_set(&r->shading, rule->key, n, v);
    return true;
}

bool nqm_mtlx_read_normal(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[3];
    if (!has_value(property) || (!is_connected(property) && parse_numbers(nqm_xml_get(property, "value"), 3, v) &&
                                 v[0] == 0 && v[1] == 0 && v[2] == 1))
        return true;
    return nqm_refuse(r, property, "%s changes the normal; a BRDF has one normal", rule->name);
}

bool nqm_mtlx_read_tangent(nqm_reading *r, const nqm_rule *rule, const void *property) {
    return !has_value(property) ||
           nqm_refuse(r, property, "%s turns the anisotropy (%s), which needs the tangent of the surface", rule->name,
                      rule->gate);
}

bool nqm_mtlx_read_occlusion(nqm_reading *r, const nqm_rule *rule, const void *property) {
    (void)rule;
    if (has_value(property))
        r->shading.remark = NQM_OCCLUSION_REMARK;
    return true;
}

static void set_defaults(reading *r) {
    strcpy(r->reading.shading.model, r->surface->model);
    for (const nqm_rule *rule = r->surface->inputs; rule->name; ++rule)
        if (rule->key)
            nqm_shading_set(&r->reading.shading, rule->key, rule->n, (double[]){rule->value, rule->value, rule->value});
}

/* Version 1.0.0 of standard_surface has other defaults. */
static void set_version(reading *r) {
    const char *version = nqm_xml_get(r->shader, "version"), *definition = nqm_xml_get(r->shader, "nodedef");
    const double base = 0.8, white[3] = {1, 1, 1};
    if (strcmp(r->surface->node, "standard_surface") == 0 &&
        (is_text(version, "1.0.0") || is_text(definition, "ND_standard_surface_surfaceshader_100"))) {
        nqm_shading_set(&r->reading.shading, "base", 1, &base);
        nqm_shading_set(&r->reading.shading, "base_color", 3, white);
    }
}

static bool read_shader(reading *r) {
    size_t s = 0;
    while (s < NQM_MTLX_N_SURFACES && strcmp(nqm_mtlx_surfaces[s].node, r->shader->name) != 0)
        ++s;
    if (s == NQM_MTLX_N_SURFACES)
        return nqm_refuse(&r->reading, r->shader,
                          "its surface shader is '%.40s', which is not one of those that are read", r->shader->name);
    r->surface = &nqm_mtlx_surfaces[s];
    r->reading.rules = r->surface->inputs;
    r->reading.owner = r->surface->node;
    set_defaults(r);
    set_version(r);
    bool ok = true;
    for (element *e = r->shader->first; e && ok; e = e->next)
        ok = strcmp(e->name, "input") != 0 || nqm_rules_apply(&r->reading, nqm_xml_get(e, "name"), e);
    return ok;
}

/* The node that a material's input `surfaceshader` is connected to; NULL: refused. */
static element *find_shader(reading *r) {
    element *input = find_child(r, r->material, "input", "surfaceshader");
    if (!input) {
        nqm_refuse(&r->reading, r->material, "it has no surface shader");
        return NULL;
    }
    const char *graph = nqm_xml_get(input, "nodegraph"), *node = nqm_xml_get(input, "nodename");
    element *scope = r->root;
    if (graph) {
        const char *output = nqm_xml_get(input, "output");
        scope = find_child(r, r->root, "nodegraph", graph);
        element *end = find_child(r, scope, "output", output ? output : "out");
        node = end ? nqm_xml_get(end, "nodename") : NULL;
    }
    element *shader = node ? find_child(r, scope, NULL, node) : NULL;
    if (!shader)
        nqm_refuse(&r->reading, input, "its surface shader is not in the file");
    return shader;
}

static bool check_displacement(reading *r) {
    element *input = find_child(r, r->material, "input", "displacementshader");
    return !input || !is_connected(input) ||
           nqm_refuse(&r->reading, input, "displacementshader is connected: displacement is not part of a BRDF");
}

/* Whether an element of the root is a surface shader of the table. */
static bool is_shader(element *e) {
    for (size_t s = 0; s < NQM_MTLX_N_SURFACES; ++s)
        if (strcmp(e->name, nqm_mtlx_surfaces[s].node) == 0)
            return true;
    return false;
}

static nqm_index_key key_of_known(const void *value) {
    return (nqm_index_key){((const struct known_shader *)value)->shader, ""};
}

/* Add a material whose shader an earlier one has, too. */
static nqm_status add_again(nqm_material_info earlier, element *material, nqm_materials *materials, nqm_error *err) {
    earlier.name = nqm_xml_get(material, "name");
    earlier.byte_offset = earlier.spec ? material->byte_offset : earlier.byte_offset;
    return nqm_materials_add(materials, &earlier, err);
}

/* `material` is a surfacematerial, or a shader that no material uses. */
static nqm_status add_material(reading *r, element *material, nqm_materials *materials, nqm_error *err) {
    const size_t number = nqm_materials_count(materials);
    r->material = material;
    r->reading = (nqm_reading){.source = &source};
    r->shader = strcmp(material->name, "surfacematerial") == 0 ? find_shader(r) : material;
    const bool has_shader = r->shader && check_displacement(r);
    const struct known_shader *known = has_shader ? nqm_index_find(&r->shaders, (nqm_index_key){r->shader, ""}) : NULL;
    if (known)
        return add_again(nqm_materials_get(materials, known->material), material, materials, err);
    if (has_shader)
        read_shader(r);
    nqm_status status =
        nqm_reading_add(&r->reading, nqm_xml_get(material, "name"), r->shader ? r->shader->name : material->name,
                        material->byte_offset, materials, err);
    if (status == NQM_OK && has_shader) {
        r->known[number] = (struct known_shader){r->shader, number};
        nqm_index_add(&r->shaders, &r->known[number]);
    }
    return status;
}

/* The surfacematerials, or the shaders if there are none. */
static nqm_status add_all(reading *r, nqm_materials *materials, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (element *e = r->root->first; e && status == NQM_OK; e = e->next)
        if (strcmp(e->name, "surfacematerial") == 0)
            status = add_material(r, e, materials, err);
    const bool has_none = nqm_materials_count(materials) == 0;
    for (element *e = r->root->first; e && status == NQM_OK && has_none; e = e->next)
        if (is_shader(e))
            status = add_material(r, e, materials, err);
    return status;
}

static nqm_status read_root(const nqm_xml *xml, nqm_materials *materials, nqm_error *err) {
    reading *r;
    struct known_shader *known;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&r, 1, sizeof *r}, {&known, NQM_MAX_MATERIALS, sizeof *known}), err);
    if (status != NQM_OK)
        return status;
    r->root = xml->root;
    r->known = known;
    status = nqm_xml_names_create(xml, &r->names, err);
    if (status == NQM_OK)
        status = nqm_index_create(NQM_MAX_MATERIALS, key_of_known, &r->shaders, err);
    if (status == NQM_OK)
        status = add_all(r, materials, err);
    nqm_index_free(&r->names);
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
        if (strcmp(e->name, "xi:include") == 0)
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
        status = read_root(&xml, materials, err);
    if (status == NQM_OK && nqm_materials_count(materials) == 0)
        status = fail_empty(map, xml.root, err);
    nqm_xml_free(&xml);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------------- */

static nqm_status write_material(const nqm_shading *shading, const char *name, const char *path, FILE *stream,
                                 nqm_error *err) {
    char numbers[100];
    size_t s = 0;
    while (strcmp(nqm_mtlx_surfaces[s].model, shading->model) != 0) /* one of those of the format */
        ++s;
    const nqm_mtlx_surface *surface = &nqm_mtlx_surfaces[s];
    fprintf(stream, "  <%s name=\"SR_%s\" type=\"surfaceshader\">\n", surface->node, name);
    for (size_t i = 0; i < shading->n; ++i) {
        const nqm_rule *input = nqm_rule_find(surface->inputs, shading->properties[i].key);
        if (!input || !input->key)
            return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %s has no input '%s'", path, surface->node,
                            shading->properties[i].key);
        fprintf(stream, "    <input name=\"%s\" type=\"%s\" value=\"%s\" />\n", input->name, input->type,
                nqm_format_doubles(numbers, sizeof numbers, input->n, shading->properties[i].v, ", "));
    }
    fprintf(stream,
            "  </%s>\n  <surfacematerial name=\"%s\" type=\"material\">\n"
            "    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"SR_%s\" />\n  </surfacematerial>\n",
            surface->node, name, name);
    return NQM_OK;
}

static nqm_status write_materialx(size_t n, const nqm_named_shading *materials, const char *path, FILE *stream,
                                  nqm_error *err) {
    nqm_status status = NQM_OK;
    fputs("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n", stream);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = write_material(&materials[i].shading, materials[i].name, path, stream, err);
    fputs("</materialx>\n", stream);
    return status;
}

const nqm_material_format nqm_materialx_format = {
    .name = "MaterialX",
    .extensions = ".mtlx",
    .models = "open-pbr standard-surface gltf usd-preview disney",
    .probe = probe,
    .read = read_materials,
    .write = write_materialx,
};
