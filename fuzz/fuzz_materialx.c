/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: MaterialX documents. Accepted specs must parse; refusals and errors must have a byte of the file. Nodes of textured materials
 * must have operands before them.
 */
#include "fuzz.h"
#include "material/maps.h"

#include <math.h>

static void check_maps(const nqm_textured *t) {
    must(t->n_outputs > 0 || t->normal != NQM_NO_NODE);
    for (size_t i = 0; i < t->n_nodes; ++i) {
        const nqm_map_node *node = &t->nodes[i];
        must(node->op < NQM_MAP_OPS && node->n >= 1 && node->n <= 4);
        for (size_t k = 0; k < nqm_graph_operands(node->op, node->n); ++k)
            must(node->in[k] < i);
        must(node->op != NQM_MAP_IMAGE || node->image < t->n_images);
        for (size_t c = 0; c < 6; ++c)
            must(isfinite(node->uv[c / 3][c % 3]));
        for (size_t c = 0; c < 4; ++c)
            must(isfinite(node->v[c]));
    }
    for (size_t i = 0; i < t->n_images; ++i)
        must(t->images[i].path && t->images[i].name);
    for (size_t i = 0; i < t->n_outputs; ++i)
        must(t->outputs[i].node < t->n_nodes);
    must(t->normal == NQM_NO_NODE || t->nodes[t->normal].op == NQM_MAP_NORMAL);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz.mtlx"};
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (!nqm_materialx_format.probe(&map))
        return 0;
    if (nqm_materials_read(&map, &materials, &err) != NQM_OK) {
        must(!materials && err.message[0] && err.byte_offset >= 0 && (size_t)err.byte_offset <= n_bytes);
        return 0;
    }
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        nqm_values values;
        nqm_error fault; /* of a value beyond its range */
        must(info.name && info.surface && !info.spec == (info.refusal != NULL));
        if (nqm_materials_maps(materials, i, 0))
            check_maps(nqm_materials_maps(materials, i, 0));
        must(info.byte_offset >= 0 && (size_t)info.byte_offset < n_bytes);
        must(!info.spec ||
             (nqm_values_parse_spec(info.spec, &values, &fault) == NQM_OK || strstr(fault.message, " needs ")));
    }
    nqm_materials_free(materials);
    fuzz_brdf(data, n_bytes, n_bytes, "");
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"acescg\">\n"
        "<nodegraph name=\"g\"><input name=\"i\" type=\"float\" value=\".5\"/><constant name=\"c\" type=\"float\">"
        "<input name=\"value\" type=\"float\" interfacename=\"i\"/></constant>"
        "<output name=\"o\" type=\"float\" nodename=\"c\"/></nodegraph>\n"
        "<open_pbr_surface name=\"s\" type=\"surfaceshader\">\n"
        "<input name=\"base_color\" type=\"color3\" value=\"0.9, 0.7, 0.4\"/>\n"
        "<input name=\"coat_weight\" type=\"float\" nodegraph=\"g\" output=\"o\"/>\n"
        "<input name=\"fuzz_weight\" type=\"float\" value=\"0.5\"/>\n"
        "<input name=\"transmission_weight\" type=\"float\" value=\"0\"/></open_pbr_surface>\n"
        "<standard_surface name=\"t\"><input name=\"base_color\" type=\"color3\" nodename=\"m\"/><input name=\"base\" "
        "type=\"float\" nodename=\"x\" output=\"outy\"/><input name=\"normal\" type=\"vector3\" nodename=\"n\"/>"
        "</standard_surface><tiledimage name=\"a\" type=\"color3\"><input name=\"file\" value=\"a.png\"/><input "
        "name=\"texcoord\" type=\"vector2\" nodename=\"p\"/><input name=\"uvtiling\" type=\"vector2\" value=\"2,3\"/>"
        "</tiledimage><place2d name=\"p\" type=\"vector2\"><input name=\"rotate\" type=\"float\" "
        "value=\"9\"/></place2d>"
        "<hsvadjust name=\"m\" type=\"color3\"><input name=\"in\" nodename=\"a\"/></hsvadjust><separate3 name=\"x\" "
        "type=\"multioutput\"><input name=\"in\" nodename=\"r\"/></separate3><range name=\"r\" type=\"color3\"><input "
        "name=\"in\" nodename=\"a\"/></range><normalmap name=\"n\" type=\"vector3\"><input name=\"in\" nodename=\"v\"/>"
        "</normalmap><swizzle name=\"v\" type=\"vector3\"><input name=\"in\" nodename=\"a\"/><input name=\"channels\" "
        "value=\"bgr\"/></swizzle><surfacematerial name=\"o\"><input name=\"surfaceshader\" nodename=\"t\"/>"
        "</surfacematerial>\n"
        "<surfacematerial name=\"m\" type=\"material\">"
        "<input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial>\n</materialx>\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
