/* SPDX-License-Identifier: MIT
 *
 * PLY (G. Turk, "The PLY Polygon File Format", 1994): a text header that lists elements and their properties, then
 * their values as text or binary in either byte order. The reader keeps x y z and nx ny nz of "vertex" and the list
 * vertex_indices (or vertex_index) of "face"; it skips all other properties.
 */
#include "io/mesh_build.h"

#include <math.h>
#include <string.h>

enum { MAX_ELEMENTS = 32, MAX_PROPERTIES = 256 };

typedef enum ply_role { ROLE_SKIP, ROLE_X, ROLE_Y, ROLE_Z, ROLE_NX, ROLE_NY, ROLE_NZ, ROLE_CORNERS } ply_role;

typedef struct ply_property {
    bool is_list;
    nqm_number_type count_type, type;
    ply_role role;
} ply_property;

typedef struct ply_element {
    bool is_vertex, is_face;
    uint64_t count;
    size_t first, n_properties; /* range in ply_file.property */
    unsigned roles;             /* bit r: one of its properties has ply_role r */
} ply_element;

typedef struct ply_file {
    nqm_mesh_reader *r;
    enum { PLY_ASCII, PLY_LITTLE, PLY_BIG } encoding;
    size_t n_elements, n_properties;
    ply_element element[MAX_ELEMENTS];
    ply_property property[MAX_PROPERTIES];
    uint64_t n_vertices;
} ply_file;

/* ---- header ------------------------------------------------------------------------------------------------------ */

static bool find_type(const char *word, nqm_number_type *type) {
    static const struct {
        const char *names[2];
        nqm_number_type type;
    } types[] = {{{"char", "int8"}, {'i', 1}},     {{"uchar", "uint8"}, {'u', 1}},   {{"short", "int16"}, {'i', 2}},
                 {{"ushort", "uint16"}, {'u', 2}}, {{"int", "int32"}, {'i', 4}},     {{"uint", "uint32"}, {'u', 4}},
                 {{"float", "float32"}, {'f', 4}}, {{"double", "float64"}, {'f', 8}}};
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
        if (strcmp(word, types[i].names[0]) == 0 || strcmp(word, types[i].names[1]) == 0) {
            *type = types[i].type;
            return true;
        }
    return false;
}

static ply_role find_role(const ply_element *element, bool is_list, const char *name) {
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    if (element->is_face && is_list)
        return strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0 ? ROLE_CORNERS : ROLE_SKIP;
    for (int i = 0; element->is_vertex && !is_list && i < 6; ++i)
        if (strcmp(name, names[i]) == 0)
            return (ply_role)(ROLE_X + i);
    return ROLE_SKIP;
}

static nqm_status read_encoding(ply_file *ply) {
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char word[NQM_MESH_TOKEN], version[NQM_MESH_TOKEN];
    if (!nqm_mesh_word(ply->r, word) || !nqm_mesh_word(ply->r, version))
        return nqm_mesh_fail(ply->r, "the format line is incomplete");
    if (strcmp(version, "1.0") != 0)
        return nqm_mesh_fail(ply->r, "version '%.20s' is not read, only 1.0", version);
    for (int i = 0; i < 3; ++i)
        if (strcmp(word, names[i]) == 0) {
            ply->encoding = i == 0 ? PLY_ASCII : i == 1 ? PLY_LITTLE : PLY_BIG;
            return NQM_OK;
        }
    return nqm_mesh_fail(ply->r, "format '%.30s' is not known", word);
}

static nqm_status read_element(ply_file *ply) {
    char name[NQM_MESH_TOKEN], count[NQM_MESH_TOKEN];
    if (ply->n_elements == MAX_ELEMENTS)
        return nqm_mesh_fail(ply->r, "more than %d elements", (int)MAX_ELEMENTS);
    if (!nqm_mesh_word(ply->r, name) || !nqm_mesh_word(ply->r, count))
        return nqm_mesh_fail(ply->r, "an element needs a name and a count");
    ply_element element = {
        .first = ply->n_properties, .is_vertex = strcmp(name, "vertex") == 0, .is_face = strcmp(name, "face") == 0};
    size_t n_digits = strspn(count, "0123456789");
    if (n_digits == 0 || n_digits > 18 || count[n_digits])
        return nqm_mesh_fail(ply->r, "'%.30s' is no count", count);
    for (const char *p = count; *p; ++p)
        element.count = 10 * element.count + (uint64_t)(*p - '0');
    for (size_t i = 0; i < ply->n_elements; ++i)
        if ((element.is_vertex && ply->element[i].is_vertex) || (element.is_face && ply->element[i].is_face))
            return nqm_mesh_fail(ply->r, "element '%s' occurs twice", name);
    if (element.is_vertex)
        ply->n_vertices = element.count;
    ply->element[ply->n_elements++] = element;
    return NQM_OK;
}

static nqm_status read_property(ply_file *ply) {
    char word[NQM_MESH_TOKEN], name[NQM_MESH_TOKEN];
    if (ply->n_elements == 0 || ply->n_properties == MAX_PROPERTIES)
        return nqm_mesh_fail(ply->r, ply->n_elements ? "too many properties" : "a property before any element");
    ply_property property = {0};
    bool good = nqm_mesh_word(ply->r, word);
    property.is_list = good && strcmp(word, "list") == 0;
    if (property.is_list)
        good = nqm_mesh_word(ply->r, word) && find_type(word, &property.count_type) &&
               property.count_type.kind != 'f' && nqm_mesh_word(ply->r, word);
    good = good && find_type(word, &property.type) && nqm_mesh_word(ply->r, name);
    if (!good)
        return nqm_mesh_fail(ply->r, "a property needs a type and a name");
    ply_element *element = &ply->element[ply->n_elements - 1];
    property.role = find_role(element, property.is_list, name);
    if (property.role != ROLE_SKIP && (element->roles >> property.role & 1))
        return nqm_mesh_fail(ply->r, "property '%s' occurs twice", name);
    element->roles |= 1U << property.role;
    ++element->n_properties;
    ply->property[ply->n_properties++] = property;
    return NQM_OK;
}

/* Check that vertices and faces have the required properties, and that the rows that the header declares fit into the
 * bytes present. */
static nqm_status check_elements(ply_file *ply) {
    const unsigned xyz = 1U << ROLE_X | 1U << ROLE_Y | 1U << ROLE_Z, corners = 1U << ROLE_CORNERS;
    const char *path = ply->r->map->path;
    bool has_vertices = false, has_faces = false;
    double n_least = 0, n_left = (double)(ply->r->map->n_bytes - ply->r->position);
    for (size_t i = 0; i < ply->n_elements; ++i) {
        const ply_element *e = &ply->element[i];
        has_vertices = has_vertices || (e->is_vertex && (e->roles & xyz) == xyz);
        has_faces = has_faces || (e->is_face && (e->roles & corners));
        double row = 0;
        for (size_t k = e->first; k < e->first + e->n_properties; ++k) {
            const ply_property *p = &ply->property[k];
            row += ply->encoding == PLY_ASCII ? 2 : (double)(p->is_list ? p->count_type : p->type).n_bytes;
        }
        if (row == 0 && e->count)
            return nqm_mesh_fail(ply->r, "an element has no properties");
        n_least += row * (double)e->count;
    }
    if (!has_vertices || !has_faces)
        return nqm_mesh_fail(ply->r, "it has no %s",
                             has_vertices ? "faces with vertex_indices" : "vertices with x, y and z");
    if (n_least > n_left + 1) /* the last line of an ASCII file may lack its newline */
        return nqm_mesh_fail(ply->r, "the header claims %.0f bytes at least, %.0f are there", n_least, n_left);
    if (ply->n_vertices > NQM_MESH_MAX_VERTICES)
        return nqm_fail(ply->r->err, NQM_ERR_LIMIT, -1, "%s: more than %d vertices", path, (int)NQM_MESH_MAX_VERTICES);
    return NQM_OK;
}

static nqm_status read_header(ply_file *ply) {
    nqm_status status = NQM_OK;
    char word[NQM_MESH_TOKEN];
    bool has_format = false;
    while (status == NQM_OK) {
        if (!nqm_mesh_next_line(ply->r))
            return nqm_mesh_fail(ply->r, "the header does not end");
        if (!nqm_mesh_word(ply->r, word))
            continue;
        if (strcmp(word, "end_header") == 0)
            break;
        if (strcmp(word, "format") == 0) {
            status = read_encoding(ply);
            has_format = true;
        } else if (strcmp(word, "element") == 0) {
            status = read_element(ply);
        } else if (strcmp(word, "property") == 0) {
            status = read_property(ply);
        } else if (strcmp(word, "comment") != 0 && strcmp(word, "obj_info") != 0) {
            return nqm_mesh_fail(ply->r, "'%.20s' is not known in a header", word);
        }
    }
    if (status == NQM_OK && !has_format)
        return nqm_mesh_fail(ply->r, "the header names no format");
    nqm_mesh_next_line(ply->r);
    if (ply->encoding != PLY_ASCII)
        ply->r->line = 0;
    return status == NQM_OK ? check_elements(ply) : status;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* Read the next value; `value` NULL: skip it. */
static nqm_status next_value(ply_file *ply, nqm_number_type type, double *value) {
    nqm_mesh_reader *r = ply->r;
    if (ply->encoding == PLY_ASCII) {
        char word[NQM_MESH_TOKEN];
        const char *end;
        while (!nqm_mesh_word(r, word))
            if (!nqm_mesh_next_line(r))
                return nqm_mesh_fail(r, "the file ends too early");
        if (value && (!nqm_parse_double(word, &end, value) || *end))
            return nqm_mesh_fail(r, "'%.20s' is no finite number", word);
        return NQM_OK;
    }
    if (r->map->n_bytes - r->position < type.n_bytes)
        return nqm_mesh_fail(r, "the file ends too early");
    if (value)
        *value = nqm_load_number(r->map->data + r->position, type, ply->encoding == PLY_BIG);
    r->position += type.n_bytes;
    return NQM_OK;
}

static nqm_status read_list(ply_file *ply, const ply_property *p) {
    const bool is_face = p->role == ROLE_CORNERS;
    double count = 0, index = 0;
    nqm_status status = next_value(ply, p->count_type, &count);
    if (status != NQM_OK)
        return status;
    double least = is_face ? 3 : 0, most = (double)(ply->r->map->n_bytes - ply->r->position);
    if (!(count >= least && count <= most && count == floor(count)))
        return nqm_mesh_fail(ply->r, is_face ? "a face has %g corners" : "a list has %g values", count);
    nqm_fan fan = {0};
    for (size_t i = 0; status == NQM_OK && i < (size_t)count; ++i) {
        status = next_value(ply, p->type, is_face ? &index : NULL);
        if (status != NQM_OK || !is_face)
            continue;
        if (!(index >= 0 && index < (double)ply->n_vertices && index == floor(index)))
            return nqm_mesh_fail(ply->r, "a face names vertex %g of %llu", index, (unsigned long long)ply->n_vertices);
        status = nqm_fan_add(ply->r, &fan, (uint32_t)index, 0, NULL);
    }
    return status;
}

static nqm_status read_row(ply_file *ply, const ply_element *e) {
    const unsigned normal = 1U << ROLE_NX | 1U << ROLE_NY | 1U << ROLE_NZ;
    double value[ROLE_CORNERS] = {0};
    nqm_status status = NQM_OK;
    for (size_t k = e->first; status == NQM_OK && k < e->first + e->n_properties; ++k) {
        const ply_property *p = &ply->property[k];
        if (p->is_list)
            status = read_list(ply, p);
        else
            status = next_value(ply, p->type, p->role != ROLE_SKIP ? &value[p->role] : NULL);
    }
    if (status == NQM_OK && e->is_vertex)
        status = nqm_mesh_add_vector(ply->r, &ply->r->vertices, value + ROLE_X, "vertex");
    if (status == NQM_OK && e->is_vertex && (e->roles & normal) == normal)
        status = nqm_mesh_add_vector(ply->r, &ply->r->normals, value + ROLE_NX, "normal");
    return status;
}

nqm_status nqm_mesh_read_ply(nqm_mesh_reader *r) {
    ply_file ply = {.r = r};
    r->format = "PLY";
    nqm_status status = read_header(&ply);
    for (size_t i = 0; status == NQM_OK && i < ply.n_elements; ++i)
        for (uint64_t row = 0; status == NQM_OK && row < ply.element[i].count; ++row)
            status = read_row(&ply, &ply.element[i]);
    return status;
}
