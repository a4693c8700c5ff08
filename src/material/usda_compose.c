/* SPDX-License-Identifier: MIT
 *
 * The prims of a layer of USD, and what they are composed of inside the layer (openusd.org, "LIVRPS"): a prim receives what it does
 * not have itself of the prims that it inherits, references and specializes, in this order. Paths into these become
 * paths into it.
 */
#include "material/usda.h"

enum { MAX_DEPTH = NQM_USDA_MAX_DEPTH, MAX_TEXT = NQM_USDA_MAX_TEXT };

typedef nqm_xml_element element;

/* ---- prims --------------------------------------------------------------------------------------------------------- */

element *nqm_usda_append(nqm_usda *layer, element *parent, const char *name, const char *const *attributes,
                         int64_t byte_offset) {
    element *e = NULL;
    if (layer->status == NQM_OK && layer->prims.n_elements == layer->max_elements)
        layer->status = nqm_fail(layer->err, NQM_ERR_LIMIT, byte_offset, "%s: more than %zu prims and inputs (byte %lld)",
                                 layer->path, layer->max_elements, (long long)byte_offset);
    if (layer->status == NQM_OK &&
        !(e = nqm_xml_append(&layer->prims, parent, name, attributes, byte_offset)))
        layer->status = nqm_fail_nomem(layer->err, sizeof *e);
    if (e && parent)
        nqm_index_add(&layer->names, e);
    return e;
}

const element *nqm_usda_find(const nqm_usda *layer, const element *base, const char *path, const char **property_ret) {
    const element *e = *path == '/' ? layer->prims.root : base;
    char name[MAX_TEXT];
    path += *path == '/';
    while (e && *path && (*path != '.' || strncmp(path, "..", 2) == 0)) {
        const size_t n = *path == '.' ? 2 : strcspn(path, "/.");
        snprintf(name, sizeof name, "%.*s", (int)nqm_smaller(n, sizeof name - 1), path);
        e = *path == '.' ? e->parent : nqm_xml_find(&layer->names, e, NULL, name);
        path += n + (path[n] == '/');
    }
    *property_ret = e && *path ? path + 1 : NULL;
    return e;
}

void nqm_usda_path(const element *prim, char path[MAX_TEXT]) {
    const element *chain[MAX_DEPTH + 2];
    size_t n = 0, used = 0;
    for (; prim->parent; prim = prim->parent)
        chain[n++] = prim;
    *path = 0;
    while (n-- && used < MAX_TEXT)
        used += (size_t)snprintf(path + used, MAX_TEXT - used, "/%s", nqm_xml_get(chain[n], "name"));
    if (used >= MAX_TEXT)
        *path = 0;
}

/* ---- composition --------------------------------------------------------------------------------------------------- */

typedef struct arc {
    char from[MAX_TEXT], to[MAX_TEXT]; /* paths of the prims */
} arc;

static bool is_inside(const char *path, const char *prim) {
    const size_t n = strlen(prim);
    return strncmp(path, prim, n) == 0 && memchr("/.", path[n], sizeof "/.");
}

static void fail_deep(nqm_usda *layer, const element *prim) {
    if (layer->status == NQM_OK)
        layer->status = nqm_fail(layer->err, NQM_ERR_FORMAT, prim->byte_offset,
                                 "%s: prims that are composed of prims, nested too deeply (byte %lld)", layer->path,
                                 (long long)prim->byte_offset);
}

/* The type of a prim of this kind, which may be a class or an over. */
static const char *type_of(const char *kind) {
    const size_t n = strlen("class:");
    return strcmp(kind, "over") == 0 ? "prim" : kind + (strncmp(kind, "class:", n) == 0 ? n : 0);
}

static void copy_property(nqm_usda *layer, element *to, const element *property, const arc *a) {
    const char *name = nqm_xml_get(property, "name"), *value = nqm_xml_get(property, "value");
    const char *space = nqm_xml_get(property, "space"), *dot = strrchr(name, '.');
    char path[2 * MAX_TEXT] = "";
    if (value && dot && strcmp(dot, ".connect") == 0 && is_inside(value, a->from))
        snprintf(path, sizeof path, "%s%s", a->to, value + strlen(a->from));
    const char *const attributes[] = {
        "name", name, "space", space ? space : "", value ? "value" : NULL, *path ? path : value, NULL};
    nqm_usda_append(layer, to, property->name, attributes, property->byte_offset);
}

/* Copy what a prim does not have. */
static void merge(nqm_usda *layer, element *to, const element *from, const arc *a, size_t depth) {
    if (depth == MAX_DEPTH)
        fail_deep(layer, from);
    for (const element *e = from->first; e && layer->status == NQM_OK; e = e->next) {
        const char *name = nqm_xml_get(e, "name");
        element *own = (element *)nqm_xml_find(&layer->names, to, NULL, name);
        if (strchr(name, ':')) {
            if (!own)
                copy_property(layer, to, e, a);
            else if (!nqm_xml_get(own, "value")) { /* declared only */
                own->attributes = e->attributes;
                own->n_attributes = e->n_attributes;
            }
            continue;
        }
        if (!own)
            own = nqm_usda_append(layer, to, e->name, (const char *const[]){"name", name, NULL}, e->byte_offset);
        else if (strcmp(own->name, "over") == 0)
            own->name = e->name;
        else if (strcmp(own->name, "prim") == 0)
            own->name = type_of(e->name);
        if (own)
            merge(layer, own, e, a, depth + 1);
    }
}

/* Give a prim what another one has. Instances that change nothing are left: the materials of their source are read there. */
static void take(nqm_usda *layer, element *prim, const element *from) {
    static const char shading[] = "Material Shader NodeGraph";
    const bool is_plain = strcmp(from->name, type_of(from->name)) == 0 && !prim->first;
    size_t depth = 0;
    arc a;
    nqm_usda_path(from, a.from);
    nqm_usda_path(prim, a.to);
    for (const element *e = prim; e->parent; e = e->parent)
        ++depth;
    const bool is_shading =
        nqm_contains_word(shading, type_of(from->name), false) || nqm_contains_word(shading, prim->name, false);
    if ((is_plain && !is_shading) || !*a.from || is_inside(a.from, a.to) || is_inside(a.to, a.from))
        return;
    if (strcmp(prim->name, "prim") == 0)
        prim->name = type_of(from->name);
    merge(layer, prim, from, &a, depth);
}

/* The first of a list of paths, of which *paths becomes the rest; NULL: the layer does not have it. */
static element *next_source(const nqm_usda *layer, const char **paths) {
    char path[MAX_TEXT];
    const char *property;
    const size_t n = strcspn(*paths, " ");
    snprintf(path, sizeof path, "%.*s", (int)n, *paths);
    *paths += n + 1;
    const element *found = nqm_usda_find(layer, NULL, path, &property);
    return found && found->parent ? (element *)found : NULL;
}

/* A prim, what it is composed of, and what is in it. One that has no attribute `arcs` any more is done, or being done. */
static void compose(nqm_usda *layer, element *prim, size_t depth) {
    const char *arcs = nqm_xml_get(prim, "arcs");
    if (depth == 2 * MAX_DEPTH)
        fail_deep(layer, prim);
    if ((prim->parent && !arcs) || layer->status != NQM_OK)
        return;
    prim->n_attributes = nqm_smaller(prim->n_attributes, 1);
    while (arcs && *arcs && layer->status == NQM_OK) {
        element *from = next_source(layer, &arcs);
        if (from)
            compose(layer, from, depth + 1);
        if (from && layer->status == NQM_OK)
            take(layer, prim, from);
    }
    for (element *e = prim->first; e; e = e->next)
        compose(layer, e, depth + 1);
}

void nqm_usda_compose(nqm_usda *layer) {
    compose(layer, layer->prims.root, 0);
}
