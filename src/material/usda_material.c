/* SPDX-License-Identifier: MIT
 *
 * The materials of a layer of USD (UsdShade) as a document of MaterialX, whose reader reads them.
 */
#include "material/materialx.h"
#include "material/usda.h"

#include <ctype.h>

enum { MAX_TEXT = NQM_USDA_MAX_TEXT, MAX_HOPS = 64 };

typedef const nqm_xml_element element;

typedef struct writer {
    const nqm_usda *layer;
    nqm_xml document;
    nqm_materials *materials;
    bool has_memory;
} writer;

static nqm_xml_element *put(writer *w, nqm_xml_element *parent, const char *name, const char *const *attributes,
                            int64_t byte_offset) {
    nqm_xml_element *e = w->has_memory ? nqm_xml_append(&w->document, parent, name, attributes, byte_offset) : NULL;
    w->has_memory = e != NULL;
    return e;
}

/* ---- properties ---------------------------------------------------------------------------------------------------- */

static bool is_output(const char *name) {
    return strncmp(name, "outputs:", 8) == 0;
}

/* The property of a name with an ending; NULL: the prim does not have it. */
static element *property_of(const writer *w, element *prim, const char *name, const char *ending) {
    char whole[MAX_TEXT];
    snprintf(whole, sizeof whole, "%s%s", name, ending);
    return nqm_xml_find(&w->layer->names, prim, NULL, whole);
}

/* NULL: it has none, or is NULL. */
static const char *value_of(element *property) {
    const char *value = property ? nqm_xml_get(property, "value") : NULL;
    return value && *value ? value : NULL;
}

/* Where an input or output has its value from. */
typedef struct origin {
    element *shader;    /* of which it is an output; NULL: a value, or nothing */
    const char *output; /* "outputs:rgb" */
    element *property;  /* with the value; NULL: there is none */
    bool is_lost;       /* a connection leads to nothing */
} origin;

/* From a property through the interfaces of materials and node graphs: a connection is stronger than a value, the values farther away
 * are stronger than the nearer ones, and samples in time are stronger than the default. */
static origin follow(const writer *w, element *prim, const char *name) {
    origin o = {.shader = NULL};
    for (int hops = 0; hops < MAX_HOPS; ++hops) {
        element *value = property_of(w, prim, name, ""), *samples = property_of(w, prim, name, ".timeSamples");
        const char *path = value_of(property_of(w, prim, name, ".connect"));
        o.is_lost = hops > 0 && !value && !samples && !path;
        o.property = value_of(samples) ? samples : value_of(value) ? value : o.property;
        prim = path ? nqm_usda_find(w->layer, prim, path, &name) : NULL;
        o.is_lost = o.is_lost || (path && (!prim || !name));
        if (!path || o.is_lost)
            return o;
        if (strcmp(prim->name, "Shader") == 0 && is_output(name)) {
            o.shader = prim;
            o.output = name;
            return o;
        }
    }
    o.is_lost = true;
    return o;
}

/* ---- shaders ------------------------------------------------------------------------------------------------------- */

static const char *type_of(const char *usd) {
    static const char *const types[] = {"float",    "float",   "float",   "integer", "boolean", "string", "string",
                                        "filename", "vector2", "vector2", "vector2", "color3",  "color3", "vector3",
                                        "vector3",  "vector3", "vector3", "vector3", "color4",  "vector4"};
    const size_t i = nqm_find_word("float double half int bool string token asset float2 double2 texCoord2f color3f "
                                   "color3d float3 double3 vector3f normal3f point3f color4f float4",
                                   usd, false);
    return i == SIZE_MAX ? usd : types[i];
}

/* The space of an image: of its metadata; a UsdUVTexture finds it by the picture unless it says something else. */
static const char *space_of(const char *node, element *property) {
    const char *space = nqm_xml_get(property, "space"),
               *by_picture = nqm_texts_equal(node, "UsdUVTexture") ? NQM_SPACE_AUTO : "none";
    return *space && strcmp(space, "auto") != 0 ? space : by_picture;
}

/* The type of an input of a surface: exporters give colours as vectors, and numbers as integers. */
static const char *type_in(const char *surface, const char *input, const char *type) {
    const nqm_mtlx_surface *s = nqm_mtlx_find_surface(surface, NULL);
    const nqm_rule *rule = s ? nqm_rule_find(s->inputs, input) : NULL;
    const bool is_number = nqm_contains_word("float integer", type, false);
    return rule && rule->type && (is_number ? rule->n == 1 : rule->n == 3 && strcmp(type, "vector3") == 0) ? rule->type
                                                                                                           : type;
}

/* `name`: "inputs:roughness", of which `property` says something. */
static void add_input(writer *w, nqm_xml_element *shader, element *prim, const char *name, element *property) {
    const origin o = follow(w, prim, name);
    const char *input = name + strlen("inputs:"), *type = type_of(property->name), *value = value_of(o.property);
    char path[MAX_TEXT] = "", remark[200] = "";
    if (!o.shader && !value && !o.is_lost)
        return; /* an interface without a value: the default of the shader */
    if (o.shader)
        nqm_usda_path(o.shader, path);
    else if (value && o.is_lost)
        snprintf(remark, sizeof remark,
                 "%.60s is connected to something that the file does not have: its own value is taken", input);
    else if (value && strchr(nqm_xml_get(o.property, "name"), '.'))
        snprintf(remark, sizeof remark, "%.60s varies with time: its first value is taken", input);
    type = type_in(shader->name, input, type);
    const bool is_file = strcmp(type, "filename") == 0;
    const char *space = is_file && value ? space_of(shader->name, o.property) : "lin_rec709";
    const char *output = o.shader ? o.output + strlen("outputs:") : "";
    const char *const constant[] = {
        "name", input, "type", type, "value", value, "colorspace", space, *remark ? "remark" : NULL, remark, NULL};
    const char *const connected[] = {
        "name", input, "type", type, "nodename", path, "output", strcmp(output, "out") == 0 ? "" : output, NULL};
    put(w, shader, "input", value && !o.shader ? constant : connected, property->byte_offset);
}

/* Each input once: it may have a value, samples in time and a connection. */
static void add_inputs(writer *w, nqm_xml_element *shader, element *prim) {
    static const char *const endings[] = {"", ".connect", ".timeSamples"};
    char name[MAX_TEXT];
    for (element *e = prim->first; e && w->has_memory; e = e->next) {
        snprintf(name, sizeof name, "%s", nqm_xml_get(e, "name"));
        if (strncmp(name, "inputs:", 7) != 0)
            continue;
        name[strcspn(name, ".")] = 0;
        element *first = NULL;
        for (size_t i = 0; i < 3 && !first; ++i)
            first = property_of(w, prim, name, endings[i]);
        if (first == e)
            add_input(w, shader, prim, name, e);
        else if (!first) /* a spline, as a type that the reader refuses */
            put(w, shader, "input",
                (const char *const[]){"name", name + 7, "type", strrchr(nqm_xml_get(e, "name"), '.'), "value", "",
                                      NULL},
                e->byte_offset);
    }
}

/* "image" of "ND_image_color3", "standard_surface" of "ND_standard_surface_surfaceshader_100". */
static void node_of(const char *id, char node[MAX_TEXT]) {
    static const char *const endings[] = {"float", "color3", "color4",   "vector",       "int",
                                          "bool",  "string", "filename", "surfaceshader"};
    enum { N = sizeof endings / sizeof *endings };
    snprintf(node, MAX_TEXT, "%s", strncmp(id, "ND_", 3) == 0 ? id + 3 : id);
    for (char *last; (last = strrchr(node, '_')); *last = 0) {
        size_t i = 0;
        while (i < N && strncmp(last + 1, endings[i], strlen(endings[i])) != 0)
            ++i;
        if (i == N && !isdigit((unsigned char)last[1])) /* of a version */
            return;
    }
}

/* The name of what the shader is: of a definition, or of the file that has the code. */
static const char *definition_of(const writer *w, element *prim) {
    const char *id = value_of(property_of(w, prim, "info:id", ""));
    for (element *e = prim->first; e && !id; e = e->next) {
        const char *name = nqm_xml_get(e, "name"), *last = strrchr(name, ':');
        if (last && strcmp(last, ":sourceAsset") == 0)
            id = value_of(e);
    }
    return id ? id : "shader";
}

static void add_shader(writer *w, element *prim) {
    const char *type = NULL, *definition = definition_of(w, prim);
    char path[MAX_TEXT], node[MAX_TEXT];
    nqm_usda_path(prim, path);
    node_of(definition, node);
    for (element *e = prim->first; e; e = e->next)
        if (is_output(nqm_xml_get(e, "name")))
            type = type ? "multioutput" : strcmp(e->name, "token") == 0 ? "surfaceshader" : type_of(e->name);
    const bool is_typed = type && strcmp(node, "UsdUVTexture") != 0;
    const char *const attributes[] = {"name", path, "nodedef", definition, is_typed ? "type" : NULL, type, NULL};
    nqm_xml_element *shader = put(w, w->document.root, node, attributes, prim->byte_offset);
    if (shader)
        add_inputs(w, shader, prim);
}

/* ---- materials ----------------------------------------------------------------------------------------------------- */

/* What the prim, or one in it, is composed of and this layer does not have; NULL: nothing. */
static const char *external_of(const writer *w, element *prim) {
    const char *found = value_of(nqm_xml_find(&w->layer->names, prim, NULL, NQM_USDA_EXTERNAL));
    for (element *e = prim->first; e && !found; e = e->next)
        found = strchr(nqm_xml_get(e, "name"), ':') ? NULL : external_of(w, e);
    return found;
}

/* The first connected output that is another surface than `own`, which may be NULL; NULL: there is none. */
static element *find_other(element *prim, element *own) {
    for (element *e = prim->first; e; e = e->next) {
        const char *name = nqm_xml_get(e, "name"), *end = strrchr(name, '.');
        if (is_output(name) && end && strcmp(end, ".connect") == 0 && value_of(e) && e != own &&
            !strstr(name, "displacement") && !strstr(name, "volume") &&
            !(own && strcmp(value_of(e), value_of(own)) == 0))
            return e;
    }
    return NULL;
}

/* Connect an input of a material of the document. false: the prim has no such output. */
static bool connect(writer *w, nqm_xml_element *material, element *prim, const char *output, const char *input) {
    element *e = property_of(w, prim, output, ".connect");
    char path[MAX_TEXT];
    if (!value_of(e) || !material)
        return false;
    const origin o = follow(w, prim, output);
    snprintf(path, sizeof path, "%s", value_of(e));
    if (o.shader)
        nqm_usda_path(o.shader, path);
    put(w, material, "input", (const char *const[]){"name", input, "nodename", path, NULL}, e->byte_offset);
    return true;
}

/* Why the material is refused, or a remark on it; "": neither. `own`: the surface that is read. */
static void describe(const writer *w, element *prim, element *own, char text[300]) {
    const char *external = external_of(w, prim);
    element *other = find_other(prim, own);
    char name[MAX_TEXT];
    snprintf(name, sizeof name, "%s", other ? nqm_xml_get(other, "name") : "");
    name[strcspn(name, ".")] = 0;
    const origin o = follow(w, prim, name);
    *text = 0;
    if (external)
        snprintf(text, 300, "it is composed of %.120s, which is not read: write one layer by 'usdcat --flatten'",
                 external);
    else if (other)
        snprintf(text, 300, "its surface at %.60s ('%.60s') is not read%s", name,
                 o.shader ? definition_of(w, o.shader) : value_of(other),
                 own ? ": there is another one"
                     : "; those of UsdPreviewSurface and MaterialX are, at outputs:mtlx:surface, outputs:surface or "
                       "outputs:glslfx:surface");
    for (element *e = prim->parent; e && !*text; e = e->parent)
        if ((external = value_of(nqm_xml_find(&w->layer->names, e, NULL, NQM_USDA_EXTERNAL))))
            snprintf(text, 300, "'%.60s', which contains it, is also composed of %.120s, which is not read",
                     nqm_xml_get(e, "name"), external);
}

/* The surface of MaterialX comes before that for previews. */
static nqm_status add_material(writer *w, element *prim) {
    static const char *const outputs[][2] = {{"outputs:mtlx:surface", "outputs:mtlx:displacement"},
                                             {"outputs:surface", "outputs:displacement"},
                                             {"outputs:glslfx:surface", "outputs:glslfx:displacement"}};
    enum { UNIVERSAL = 1, N = 3 };
    char text[300];
    element *own = NULL;
    size_t i = 0;
    while (i < N && !value_of(own = property_of(w, prim, outputs[i][0], ".connect")))
        ++i;
    own = i < N ? own : NULL;
    describe(w, prim, own, text);
    const nqm_material_info info = {
        .name = nqm_xml_get(prim, "name"), .surface = prim->name, .refusal = text, .byte_offset = prim->byte_offset};
    if (*text && (!own || external_of(w, prim)))
        return nqm_materials_add(w->materials, &info, w->layer->err);
    nqm_xml_element *material =
        put(w, w->document.root, "surfacematerial",
            (const char *const[]){"name", info.name, *text ? "remark" : NULL, text, NULL}, prim->byte_offset);
    if (own && connect(w, material, prim, outputs[i][0], "surfaceshader") &&
        !connect(w, material, prim, outputs[i][1], "displacementshader"))
        connect(w, material, prim, outputs[UNIVERSAL][1], "displacementshader");
    return NQM_OK;
}

/* At most NQM_USDA_MAX_DEPTH calls deep. */
static nqm_status add_prims(writer *w, element *prim) {
    nqm_status status = NQM_OK;
    if (strcmp(prim->name, "Shader") == 0)
        add_shader(w, prim);
    if (strcmp(prim->name, "Material") == 0)
        status = add_material(w, prim);
    for (element *e = prim->first; e && status == NQM_OK && w->has_memory; e = e->next)
        status = add_prims(w, e);
    return status;
}

nqm_status nqm_usda_add_materials(const nqm_usda *layer, nqm_materials *materials) {
    writer w = {.layer = layer, .materials = materials, .has_memory = true};
    nqm_status status = NQM_OK;
    if (put(&w, NULL, "materialx", (const char *const[]){NULL}, 0))
        status = add_prims(&w, layer->prims.root);
    if (status == NQM_OK)
        status = w.has_memory ? nqm_mtlx_read_document(&w.document, layer->path, materials, layer->err)
                              : nqm_fail_nomem(layer->err, 1);
    nqm_xml_free(&w.document);
    return status;
}
