/* SPDX-License-Identifier: MIT
 *
 * Mitsuba 3 scenes in XML (mitsuba.readthedocs.io, "Scene XML file format"). Only BSDFs, textures and what is inside them
 * become nodes. A value `$name` is replaced by that of the <default> of this name. What a file contains takes the place of the
 * <include> that names it.
 */
#include "io/xml.h"
#include "material/bsdf.h"

static const nqm_bsdf_word kinds[] = {{"bsdf", NQM_BSDF_BSDF},         {"float integer", NQM_BSDF_NUMBER},
                                      {"boolean", NQM_BSDF_BOOLEAN},   {"string", NQM_BSDF_STRING},
                                      {"rgb", NQM_BSDF_RGB},           {"ref", NQM_BSDF_REF},
                                      {"spectrum", NQM_BSDF_SPECTRUM}, {"texture", NQM_BSDF_TEXTURE},
                                      {NULL, NQM_BSDF_OTHER}};

enum {
    MAX_DEFAULTS = 1000, /* each value is searched among them */
    STEP_SIZE = 4 * 41 + 1
};

/* The walk through the elements of a scene. */
typedef struct walk {
    const char *path; /* of the file that is read */
    nqm_includes includes;
    nqm_bsdf_nodes nodes, defaults;
    nqm_error *err;
} walk;

/* The value of an attribute, or of the default that it names. */
static char *value_of(const walk *w, const nqm_xml_element *element, const char *attribute) {
    const char *text = nqm_xml_get(element, attribute);
    for (size_t i = 0; text && *text == '$' && i < w->defaults.n; ++i)
        if (strcmp(w->defaults.list[i].name, text + 1) == 0)
            return w->defaults.list[i].value;
    return (char *)text;
}

/* The numbers of a step of a transform, as text: "x y z", of a rotation "x y z angle". NULL: the element is none, or
 * its value has them. */
static char *step_of(const walk *w, const nqm_xml_element *element, char text[STEP_SIZE]) {
    static const char *const attributes[] = {"x", "y", "z", "angle"};
    const bool is_scale = strcmp(element->name, "scale") == 0, is_rotation = strcmp(element->name, "rotate") == 0;
    size_t n = 0;
    if ((!is_scale && !is_rotation && strcmp(element->name, "translate") != 0) || nqm_xml_get(element, "value"))
        return NULL;
    for (size_t i = 0; i < (is_rotation ? 4 : 3); ++i) {
        const char *number = value_of(w, element, attributes[i]);
        n += (size_t)snprintf(text + n, STEP_SIZE - n, "%.40s ", number ? number : is_scale ? "1" : "0");
    }
    return text;
}

static nqm_status add_element(walk *w, const nqm_xml_element *element, size_t parent);

/* Add the elements of a file, except for its scene. */
static nqm_status add_file(walk *w, const nqm_map *map, size_t parent) {
    nqm_xml xml;
    nqm_status status = nqm_xml_parse(map->data, map->n_bytes, map->path, &xml, w->err);
    if (status != NQM_OK)
        return status;
    if (strcmp(xml.root->name, "scene") != 0)
        status = add_element(w, xml.root, parent);
    else
        for (const nqm_xml_element *child = xml.root->first; status == NQM_OK && child; child = child->next)
            status = add_element(w, child, parent);
    nqm_xml_free(&xml);
    return status;
}

static nqm_status add_included(walk *w, const nqm_xml_element *element, size_t parent) {
    const char *name = value_of(w, element, "filename"), *outer = w->path;
    nqm_map map;
    char *path;
    if (!name)
        return nqm_fail(w->err, NQM_ERR_FORMAT, element->byte_offset, "%s: an <include> without a filename (byte %lld)",
                        w->path, (long long)element->byte_offset);
    nqm_status status = nqm_include_open(&w->includes, w->path, name, &map, &path, w->err);
    if (status != NQM_OK || !path)
        return status;
    w->path = path;
    status = add_file(w, &map, parent);
    w->path = outer;
    nqm_include_close(&w->includes, &map, path);
    return status;
}

/* Add the element and those inside it; parent: the node that contains them. The depth is limited by the XML reader. */
static nqm_status add_element(walk *w, const nqm_xml_element *element, size_t parent) {
    char step[STEP_SIZE], *numbers = step_of(w, element, step);
    nqm_bsdf_node node = {.kind = nqm_bsdf_kind_of(kinds, element->name),
                          .parent = parent,
                          .type = value_of(w, element, "type"),
                          .name = value_of(w, element, "name"),
                          .id = value_of(w, element, "id"),
                          .value = numbers ? numbers : value_of(w, element, "value"),
                          .byte_offset = w->includes.depth ? -1 : element->byte_offset};
    if (node.kind == NQM_BSDF_SPECTRUM && !node.value)
        node.value = value_of(w, element, "filename");
    if (node.kind == NQM_BSDF_OTHER && !node.type)
        node.type = (char *)element->name;
    const bool is_default = strcmp(element->name, "default") == 0;
    const bool is_node =
        !is_default && (node.kind == NQM_BSDF_BSDF || node.kind == NQM_BSDF_TEXTURE || parent != NQM_BSDF_ROOT);
    if (strcmp(element->name, "include") == 0)
        return add_included(w, element, parent);
    if (is_default && w->defaults.n == MAX_DEFAULTS)
        return nqm_fail(w->err, NQM_ERR_LIMIT, node.byte_offset, "%s: more than %d defaults (byte %lld)", w->path,
                        (int)MAX_DEFAULTS, (long long)node.byte_offset);
    const size_t at = is_node ? w->nodes.n : NQM_BSDF_ROOT;
    nqm_status status = is_node      ? nqm_bsdf_add(&w->nodes, &node, w->path, w->err)
                        : is_default ? nqm_bsdf_add(&w->defaults, &node, w->path, w->err)
                                     : NQM_OK;
    for (const nqm_xml_element *child = element->first; status == NQM_OK && child; child = child->next)
        status = add_element(w, child, at);
    return status;
}

/* Skip a byte order mark, blanks, declarations and comments. */
static size_t skip_prolog(const char *text, size_t n) {
    size_t i = n >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (i < n && (memchr(" \t\r\n", text[i], 4) || (text[i] == '<' && i + 1 < n && memchr("?!", text[i + 1], 2)))) {
        const bool is_comment = n - i >= 4 && memcmp(text + i, "<!--", 4) == 0;
        if (text[i] == '<')
            while (i < n && !(text[i] == '>' && (!is_comment || memcmp(text + i - 2, "--", 2) == 0)))
                ++i;
        ++i;
    }
    return i;
}

static bool probe(const nqm_map *map) {
    static const char *const roots[] = {"<scene", "<bsdf"};
    const char *text = (const char *)map->data;
    const size_t n = nqm_smaller(map->n_bytes, 4096), i = skip_prolog(text, n);
    for (size_t r = 0; r < sizeof roots / sizeof *roots; ++r) {
        const size_t end = i + strlen(roots[r]);
        if (end < n && memcmp(text + i, roots[r], end - i) == 0 && memchr(" \t\r\n>/", text[end], 6))
            return true;
    }
    return false;
}

static nqm_status read_xml(const nqm_map *map, nqm_materials *materials, nqm_error *err) {
    walk w = {.path = map->path, .includes = {.root = map->path, .materials = materials}, .err = err};
    nqm_status status = add_file(&w, map, NQM_BSDF_ROOT);
    if (status == NQM_OK)
        status = nqm_mitsuba_translate(&w.nodes, map->path, materials, err);
    nqm_bsdf_clear(&w.nodes);
    nqm_bsdf_clear(&w.defaults);
    return status;
}

const nqm_material_format nqm_mitsuba_xml_format = {
    .name = "Mitsuba XML",
    .extensions = ".xml",
    .models = "rough-conductor rough-plastic principled lambert",
    .probe = probe,
    .read = read_xml,
    .write = nqm_mitsuba_write,
};
