/* SPDX-License-Identifier: MIT
 *
 * The nodes of MaterialX documents (MaterialX.StandardNodes; libraries/stdlib, libraries/bxdf) as nodes of maps.h: what
 * each computes is a short program in the table below. Nodes with constant operands become constants at once. Texture
 * coordinates may be computed by any nodes, as long as the result is affine: it becomes part of the image. A node that
 * is not in the table refuses the material.
 */
#include "base/os.h"
#include "io/xml.h"
#include "material/materialx.h"

#include <math.h>

typedef const nqm_xml_element element;
typedef nqm_mtlx_graph graph;

enum { MAX_HOPS = 64 };

/* Nodes of these names. Operands are named with their defaults ("@": the texture coordinates), and are a, b, ... in the
 * program (materialx.h). */
typedef struct node_kind {
    const char *name, *operands, *program;
    /* Of a node that reads an image, which is I in the program: its texture coordinates. */
    const char *uv_operands, *uv_program;
} node_kind;

#define UV "texcoord=@"
#define GLTF_UV                                                                                                        \
    UV " pivot=0,1 scale=1,1 rotate=0 offset=0,0 operationorder=0", "1c/! 0d-! e01-1&*! ab-g/hDi-! ab-i-hDg/! f0kj>b+"

static const node_kind kinds[] = {
    {"constant", "value=0", "a", 0, 0},
    {"dot convert separate2 separate3 separate4", "in=0", "a", 0, 0},
    {"texcoord geompropvalue UsdPrimvarReader", UV, "a", 0, 0},
    {"add", "in1=0 in2=0", "ab+", 0, 0},
    {"subtract", "in1=0 in2=0", "ab-", 0, 0},
    {"multiply", "in1=0 in2=1", "ab*", 0, 0},
    {"divide", "in1=0 in2=1", "ab/", 0, 0},
    {"modulo", "in1=0 in2=1", "ab%", 0, 0},
    {"power", "in1=0 in2=1", "ab^", 0, 0},
    {"min", "in1=0 in2=0", "ab[", 0, 0},
    {"max", "in1=0 in2=0", "ab]", 0, 0},
    {"absval", "in=0", "a|", 0, 0},
    {"floor", "in=0", "a_", 0, 0},
    {"ceil", "in=0", "00a-_-", 0, 0},
    {"round", "in=0", "a12/+_", 0, 0},
    {"sin", "in=0", "aS", 0, 0},
    {"cos", "in=0", "aC", 0, 0},
    {"sqrt", "in=0", "a12/^", 0, 0},
    {"invert", "in=0 amount=1", "ba-", 0, 0},
    {"clamp", "in=0 low=0 high=1", "ab]c[", 0, 0},
    {"mix", "bg=0 fg=0 mix=0", "abcM", 0, 0},
    {"smoothstep", "in=0 low=0 high=1", "abcT", 0, 0},
    {"remap", "in=0 inlow=0 inhigh=1 outlow=0 outhigh=1", "ab-cb-/ed-*d+", 0, 0},
    /* h: between inlow and inhigh; i: with the exponent, keeping the sign; j: between outlow and outhigh */
    {"range", "in=0 inlow=0 inhigh=1 gamma=1 outlow=0 outhigh=1 doclamp=0", "ab-cb-/! h|1d/^! 0h0i-i>fe-*e+! g0je]f[j>",
     0, 0},
    {"contrast", "in=0 amount=1 pivot=0.5", "ac-b*c+", 0, 0},
    {"luminance", "in=0 lumacoeffs=0.2722287,0.6740818,0.0536895", "ab.", 0, 0},
    {"saturate", "in=0 amount=1 lumacoeffs=0.2722287,0.6740818,0.0536895", "ac.abM", 0, 0},
    {"hsvadjust", "in=0 amount=0,1,1", "aR bx00&&+ 1bybz&&* H", 0, 0},
    {"rgbtohsv", "in=0", "aR", 0, 0},
    {"hsvtorgb", "in=0", "aH", 0, 0},
    {"ifgreater", "value1=1 value2=0 in1=0 in2=0", "abcd>", 0, 0},
    {"ifgreatereq", "value1=1 value2=0 in1=0 in2=0", "badc>", 0, 0},
    {"ifequal", "value1=0 value2=0 in1=0 in2=0", "abcd=", 0, 0},
    {"combine2", "in1=0 in2=0", "ab&", 0, 0},
    {"combine3", "in1=0 in2=0 in3=0", "abc&&", 0, 0},
    {"combine4", "in1=0 in2=0 in3=0 in4=0", "abcd&&&", 0, 0},
    {"dotproduct", "in1=0 in2=0", "ab.", 0, 0},
    {"magnitude", "in=0", "aa.12/^", 0, 0},
    {"normalize", "in=0", "aaa.12/^/", 0, 0},
    {"normalmap", "in=0.5,0.5,1 scale=1", "abN", 0, 0},
    {"rotate2d", "in=0,0 amount=0", "abD", 0, 0},
    {"place2d", UV " pivot=0,0 scale=1,1 rotate=0 offset=0,0 operationorder=0", "ab-c/dDe-! ab-e-dDc/! f0hg>b+", 0, 0},
    {"UsdTransform2d", "in=0,0 rotation=0 scale=1,1 translation=0,0", "ac*0b-Dd+", 0, 0},
    {"image", "", "I", UV, "a"},
    {"tiledimage", "", "I", UV " uvtiling=1,1 uvoffset=0,0 realworldimagesize=1,1 realworldtilesize=1,1", "ab*c-d/e*"},
    {"hextiledimage", "", "I", UV " tiling=1,1", "ab*"},
    {"gltf_image", "factor=1", "Ia*", GLTF_UV},
    {"gltf_colorimage", "color=1 geomcolor=1", "Ia*b*", GLTF_UV},
    {"gltf_normalmap", "", "I1N", GLTF_UV},
    {"UsdUVTexture", "scale=1 bias=0", "Ia*b+", "st=@", "a"},
};

element *nqm_mtlx_child(const graph *g, element *parent, const char *kind, const char *name) {
    return parent && name ? nqm_xml_find(&g->names, parent, kind, name) : NULL;
}

static const char *name_of(element *node) {
    return nqm_xml_get(node, "name");
}

static const char *inherited(element *e, const char *attribute) {
    const char *value = NULL;
    for (; e && !value; e = e->parent)
        value = nqm_xml_get(e, attribute);
    return value;
}

bool nqm_mtlx_is_connected(element *e) {
    return nqm_xml_get(e, "nodename") || nqm_xml_get(e, "nodegraph") || nqm_xml_get(e, "interfacename");
}

bool nqm_mtlx_has_value(element *e) {
    return nqm_mtlx_is_connected(e) || nqm_xml_get(e, "value");
}

/* What the element itself says about its value. */
static void take_remark(graph *g, element *e) {
    if (nqm_xml_get(e, "remark"))
        nqm_textured_remark(g->t, nqm_xml_get(e, "remark"));
}

/* Names an element for messages: in other nodes than the shader, with the node. Returns text. */
static const char *label(const graph *g, element *e, char text[200]) {
    const char *name = name_of(e), *node = name_of(e->parent);
    const bool is_own = e->parent == g->input->parent || !name || !node;
    snprintf(text, 200, is_own ? "%.60s" : "%.60s: '%.60s' of '%.60s'", g->name, name, node);
    return text;
}

#define REFUSE(G, ...) (nqm_refuse((G)->reading, (G)->input, __VA_ARGS__), (uint16_t)NQM_NO_NODE)

/* ---- values -------------------------------------------------------------------------------------------------------- */

/* The components of a type; 0: its values are not numbers. */
static size_t components(const char *type) {
    static const char *const names[] = {"float integer boolean", "vector2", "color3 vector3", "color4 vector4"};
    for (size_t n = 0; type && n < 4; ++n)
        if (nqm_contains_word(names[n], type, false))
            return n + 1;
    return 0;
}

static bool is_color(const char *type) {
    return nqm_texts_equal(type, "color3") || nqm_texts_equal(type, "color4");
}

static bool parse_numbers(const char *text, size_t n, double *v) {
    for (size_t c = 0; c < n; ++c) {
        text += strspn(text, " \t\n");
        if (!nqm_parse_double(text, &text, &v[c]))
            return false;
        const size_t n_blanks = strspn(text, " \t\n");
        text += n_blanks;
        if (c + 1 == n ? *text != 0 : *text != ',' && !n_blanks) /* files by hand have blanks alone */
            return false;
        text += *text == ',';
    }
    return true;
}

/* Units (MaterialX Specification, "Units"), in degrees and nanometres. */
static const struct unit {
    const char *name;
    bool is_angle;
    double size;
} units[] = {{"degree", true, 1},        {"radian", true, 57.29577951308232},
             {"nanometer", false, 1},    {"micron", false, 1e3},
             {"micrometer", false, 1e3}, {"millimeter", false, 1e6},
             {"centimeter", false, 1e7}, {"inch", false, 25.4e6},
             {"foot", false, 304.8e6},   {"yard", false, 914.4e6},
             {"meter", false, 1e9},      {"kilometer", false, 1e12},
             {"mile", false, 1609.344e9}};

/* Convert n values from the unit that an element names to that of its definition: angles to degrees, thicknesses of films to micrometres
 * in OpenPBR and to nanometres in the others, as sizes of images, of which ratios count. false: the material is refused. */
static bool convert_unit(graph *g, element *e, size_t n, double *v) {
    const char *name = nqm_xml_get(e, "name"), *unit = nqm_xml_get(e, "unit");
    const struct unit *u = units, *end = units + sizeof units / sizeof *units;
    if (!unit)
        return true;
    while (u < end && strcmp(u->name, unit) != 0)
        ++u;
    const bool is_film = name && strstr(name, "thickness"), is_size = name && strncmp(name, "realworld", 9) == 0;
    if (u == end || (!u->is_angle && !is_film && !is_size))
        return nqm_refuse(g->reading, g->input, "%s: the unit '%.40s' of '%.60s' is not known here", g->name, unit,
                          name ? name : e->name);
    const double to = is_film && nqm_texts_equal(e->parent->name, "open_pbr_surface") ? 1e3 : 1;
    for (size_t c = 0; c < n; ++c)
        v[c] *= u->size / to;
    return true;
}

/* The value that an element has itself; of the type, unless it names another. */
static uint16_t read_constant(graph *g, element *e, const char *type) {
    static const char *const counts[] = {"", "a number", "two numbers", "three numbers", "four numbers"};
    const char *text = nqm_xml_get(e, "value"), *own = nqm_xml_get(e, "type"), *space = inherited(e, "colorspace");
    const char *geometry = nqm_xml_get(e, "defaultgeomprop");
    char name[200];
    label(g, e, name);
    take_remark(g, e);
    type = own ? own : type;
    double v[4];
    const size_t n = components(type);
    if (n == 0)
        return REFUSE(g, "%s has the type '%.40s', which is not read", name, type ? type : "");
    if (!text && nqm_texts_equal(geometry, "UV0"))
        return nqm_graph_add(g->t, (nqm_map_node){.op = NQM_MAP_TEXCOORD, .n = 2});
    if (!text && geometry)
        return REFUSE(g, "%s depends on the geometry ('%.40s')", name, geometry);
    if (!text)
        return REFUSE(g, "%s has no value", name);
    if (nqm_texts_equal(type, "boolean") && (nqm_texts_equal(text, "true") || nqm_texts_equal(text, "false")))
        v[0] = *text == 't';
    else if (!parse_numbers(text, n, v))
        return REFUSE(g, "%s needs %s, not '%.40s'", name, counts[n], text);
    if (is_color(type) && !nqm_color_to_rec709(space, v))
        return REFUSE(g, "%s is in the colour space '%.40s', which is not known", name, space);
    for (size_t c = 0; c < n; ++c)
        if (!isfinite(v[c]))
            return REFUSE(g, "%s is not finite", name);
    if (!convert_unit(g, e, n, v))
        return NQM_NO_NODE;
    return nqm_graph_value(g->t, n, v);
}

/* ---- nodes of the document ----------------------------------------------------------------------------------------- */

static uint16_t read(graph *g, element *e, const char *type);

/* The operands of a program, from the inputs of a node or their defaults. */
static nqm_mtlx_program read_operands(graph *g, element *node, const char *operands) {
    nqm_mtlx_program m = {.t = g->t};
    for (size_t n; *operands; operands += n + strspn(operands + n, " ")) {
        char text[80], *value;
        double v[4];
        n = strcspn(operands, " ");
        snprintf(text, sizeof text, "%.*s", (int)n, operands);
        value = strchr(text, '=');
        *value++ = 0;
        element *input = nqm_mtlx_child(g, node, "input", text);
        if (input && nqm_mtlx_has_value(input))
            m.operand[m.n_operands++] = read(g, input, nqm_xml_get(node, "type"));
        else if (*value == '@')
            m.operand[m.n_operands++] = nqm_graph_add(g->t, (nqm_map_node){.op = NQM_MAP_TEXCOORD, .n = 2});
        else
            m.operand[m.n_operands++] = nqm_graph_value(g->t, nqm_parse_numbers(value, 4, v), v);
    }
    return m;
}

/* The element that has the text of an input; NULL: none. */
static element *find_text(const graph *g, element *node, const char *name) {
    element *e = nqm_mtlx_child(g, node, "input", name);
    for (int hops = 0; e && nqm_xml_get(e, "interfacename") && hops < MAX_HOPS; ++hops)
        e = nqm_mtlx_child(g, e->parent->parent, NULL, nqm_xml_get(e, "interfacename"));
    return e;
}

static const char *text_of_input(const graph *g, element *node, const char *name) {
    element *e = find_text(g, node, name);
    return e ? nqm_xml_get(e, "value") : NULL;
}

/* The position in an image of a position on the surface, if that is affine: from three positions, tried at two others. Values of
 * images must make no difference. */
static bool find_affine(const nqm_textured *t, uint16_t uv, double affine[2][3]) {
    static const double positions[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.37, -1.61, 0.8}, {-2.3, 5.7, 0.35}};
    double values[NQM_MAX_MAP_NODES][4];
    for (size_t p = 0; p < 5; ++p) {
        const double *at = positions[p];
        for (size_t i = 0; i <= uv; ++i) {
            const bool is_image = t->nodes[i].op == NQM_MAP_IMAGE;
            for (size_t c = 0; c < 4; ++c)
                values[i][c] = at[is_image ? 2 : c > 0];
            if (!is_image && t->nodes[i].op != NQM_MAP_TEXCOORD)
                nqm_graph_node_value(&t->nodes[i], (const double(*)[4])values, values[i]);
        }
        for (size_t c = 0; c < 2; ++c) {
            const double value = values[uv][c], *a = affine[c];
            if (p < 3)
                affine[c][p == 0 ? 2 : p - 1] = p == 0 ? value : value - a[2];
            else if (!(fabs(a[0] * at[0] + a[1] * at[1] + a[2] - value) <= 1e-9 * (1 + fabs(value))))
                return false;
        }
    }
    return true;
}

static uint8_t read_wrap(graph *g, element *node, const char *name, const char *usd_name) {
    static const uint8_t wraps[] = {NQM_MAP_REPEAT, NQM_MAP_REPEAT, NQM_MAP_REPEAT, NQM_MAP_MIRROR,
                                    NQM_MAP_CLAMP,  NQM_MAP_BORDER, NQM_MAP_BORDER};
    const char *mode = text_of_input(g, node, name);
    mode = mode ? mode : text_of_input(g, node, usd_name);
    const size_t found =
        mode ? nqm_find_word("periodic repeat useMetadata mirror clamp constant black", mode, false) : 0;
    if (found != SIZE_MAX)
        return wraps[found];
    nqm_refuse(g->reading, g->input,
               "%s: node '%.60s' has the %s '%.40s'; periodic, mirror, clamp and constant are read", g->name,
               name_of(node), name, mode);
    return NQM_MAP_REPEAT;
}

/* Documents name files by where they are in their library, "../../../Images/wood.jpg", which MaterialX finds by a list
 * of folders: one that is not there is looked for without "../". The name as it is given if there is none. */
static const char *find_file(const graph *g, const char *name) {
    enum { MAX_UP = 16 };
    const char *at = name;
    bool is_there = false;
    for (int up = 0; up <= MAX_UP && !is_there && (up == 0 || strncmp(at, "../", 3) == 0); ++up) {
        at += up ? 3 : 0;
        char *path = nqm_path_beside(g->path, at);
        is_there = !path || nqm_os_exists(path);
        nqm_free(path);
    }
    return is_there ? at : name;
}

/* The file of an image, with its colour space; false: refused. */
static bool read_file(graph *g, element *node, const char *type, size_t *image_ret) {
    element *e = find_text(g, node, "file");
    char path[4096];
    const char *file = e ? nqm_xml_get(e, "value") : NULL, *source = text_of_input(g, node, "sourceColorSpace");
    if (!file || !*file)
        return nqm_refuse(g->reading, g->input, "%s reads node '%.60s', which names no file", g->name, name_of(node));
    take_remark(g, e);
    if (strpbrk(file, "<[{"))
        return nqm_refuse(g->reading, g->input,
                          "%s: the file of node '%.60s' depends on the geometry ('%.80s'), which is not read", g->name,
                          name_of(node), file);
    const char *prefix = inherited(e, "fileprefix"), *space = is_color(type) ? inherited(e, "colorspace") : NULL;
    if (source && !nqm_texts_equal(source, "auto"))
        space = nqm_texts_equal(source, "sRGB") ? "srgb_texture" : nqm_texts_equal(source, "raw") ? NULL : source;
    if (!nqm_texts_equal(space, NQM_SPACE_AUTO) && !nqm_color_to_rec709(space, (double[3]){0}))
        return nqm_refuse(g->reading, g->input, "%s is in the colour space '%.40s', which is not known", g->name,
                          space);
    const int n_path = snprintf(path, sizeof path, "%s%s", prefix ? prefix : "", file);
    return (n_path < (int)sizeof path && nqm_graph_add_file(g->t, g->path, find_file(g, path), space, image_ret)) ||
           nqm_refuse(g->reading, g->input,
                      "%s: its graph has more than %d images, a name that is too long, or memory is short", g->name,
                      NQM_MAX_MAP_IMAGES);
}

static uint16_t read_image(graph *g, const node_kind *kind, element *node) {
    const bool is_usd = nqm_texts_equal(kind->name, "UsdUVTexture");
    const char *type = is_usd || nqm_texts_equal(kind->name, "gltf_colorimage") ? "color4" : nqm_xml_get(node, "type");
    nqm_mtlx_program m = read_operands(g, node, kind->uv_operands);
    const uint16_t uv = nqm_mtlx_run(&m, kind->uv_program);
    size_t image;
    double a[2][3];
    if (uv == NQM_NO_NODE || !read_file(g, node, type, &image))
        return NQM_NO_NODE;
    if (nqm_mtlx_width(g->t, uv) != 2 || !find_affine(g->t, uv, a))
        return REFUSE(g, "%s: the texture coordinates of node '%.60s' are no affine function of those of the surface",
                      g->name, name_of(node));
    if (components(type) == 0)
        return REFUSE(g, "%s: node '%.60s' has no type that is read", g->name, name_of(node));
    nqm_map_node result = {
        .op = NQM_MAP_IMAGE,
        .n = (uint8_t)components(type),
        .image = (uint16_t)image,
        .wrap = {read_wrap(g, node, "uaddressmode", "wrapS"), read_wrap(g, node, "vaddressmode", "wrapT")},
        /* v of the document is measured upwards, that of the node downwards, both on the surface and in the image */
        .uv = {{a[0][0], -a[0][1], a[0][2] + a[0][1]}, {-a[1][0], a[1][1], 1 - a[1][1] - a[1][2]}}};
    if (result.wrap[0] == NQM_MAP_BORDER || result.wrap[1] == NQM_MAP_BORDER) {
        const uint16_t outside = read_operands(g, node, is_usd ? "fallback=0,0,0,1" : "default=0").operand[0];
        if (!nqm_graph_is_constant(g->t, outside))
            return REFUSE(g, "%s: the value of node '%.60s' beyond its image is no constant", g->name, name_of(node));
        nqm_graph_node_value(&g->t->nodes[outside], NULL, result.v);
    } else if (nqm_mtlx_child(g, node, "input", is_usd ? "fallback" : "default"))
        nqm_reading_unused(g->reading, is_usd ? "fallback" : "default");
    if (nqm_texts_equal(kind->name, "hextiledimage"))
        nqm_textured_remark(g->t,
                            "hextiledimage repeats its image without the random offsets of the tiles: the texels are "
                            "the same, their order is not");
    return nqm_graph_add(g->t, result);
}

/* One or more channels by their letters. */
static uint16_t swizzle(graph *g, uint16_t node, const char *letters) {
    static const char names[] = "rgbaxyzw01";
    nqm_map_node result = {.op = NQM_MAP_COMBINE};
    for (; letters && letters[result.n] && result.n < 4; ++result.n) {
        const char *found = strchr(names, letters[result.n]);
        const size_t c = found ? (size_t)(found - names) : 0;
        if (!found)
            return REFUSE(g, "%s: '%.40s' are no channels", g->name, letters);
        result.in[result.n] = c < 8 ? nqm_graph_channel(g->t, node, nqm_smaller(c % 4, nqm_mtlx_width(g->t, node) - 1))
                                    : nqm_graph_number(g->t, (double)(c - 8));
    }
    return result.n == 0 ? node : result.n == 1 ? result.in[0] : nqm_graph_add(g->t, result);
}

/* Nodes whose meaning depends on more than their operands. */
static uint16_t build_channels(graph *g, element *node) {
    const bool is_swizzle = nqm_texts_equal(node->name, "swizzle");
    if (is_swizzle || nqm_texts_equal(node->name, "extract")) {
        const nqm_mtlx_program m = read_operands(g, node, "in=0 index=0");
        if (is_swizzle)
            return swizzle(g, m.operand[0], text_of_input(g, node, "channels"));
        if (nqm_graph_is_constant(g->t, m.operand[1]))
            return nqm_graph_channel(g->t, m.operand[0], (size_t)fmin(fmax(g->t->nodes[m.operand[1]].v[0], 0), 3));
    }
    return REFUSE(g, "%s is computed by node '%.60s' (%.40s), which is not evaluated", g->name, name_of(node),
                  node->name);
}

/* Inputs that change what a node of the table computes. */
static bool is_evaluated(const graph *g, element *node) {
    const char *index = text_of_input(g, node, "index"), *property = text_of_input(g, node, "geomprop");
    property = property ? property : text_of_input(g, node, "varname");
    if (nqm_contains_word("geompropvalue UsdPrimvarReader", node->name, false))
        return property && nqm_contains_word("UV0 st uv UVMap map1", property, false);
    if (nqm_texts_equal(node->name, "texcoord"))
        return !index || nqm_texts_equal(index, "0");
    return !nqm_texts_equal(node->name, "normalmap") ||
           (!nqm_mtlx_child(g, node, "input", "tangent") && !nqm_mtlx_child(g, node, "input", "bitangent") &&
            !nqm_mtlx_child(g, node, "input", "normal") && !nqm_texts_equal(text_of_input(g, node, "space"), "object"));
}

/* Whether `name` is among operands as of read_operands(). */
static bool is_operand(const char *operands, const char *name) {
    const size_t n = strlen(name);
    const char *at = operands;
    while (at && !(strncmp(at, name, n) == 0 && at[n] == '='))
        at = (at = strchr(at, ' ')) ? at + 1 : NULL;
    return at != NULL;
}

/* Name the inputs of a node that its value does not depend on. */
static void name_unused(graph *g, element *node, const node_kind *kind) {
    static const char read[] = "file uaddressmode vaddressmode wrapS wrapT sourceColorSpace in channels index geomprop "
                               "varname space";
    const bool is_image = kind && kind->uv_program; /* read_image() knows whether its value beyond the border counts */
    for (element *e = node->first; e; e = e->next) {
        const char *name = nqm_xml_get(e, "name");
        if (name && strcmp(e->name, "input") == 0 && !nqm_contains_word(read, name, false) &&
            !(is_image && nqm_contains_word("default fallback", name, false)) &&
            !(kind && (is_operand(kind->operands, name) || is_operand(kind->uv_operands, name))))
            nqm_reading_unused(g->reading, name);
    }
}

/* The value of an output of a node. */
static uint16_t build(graph *g, element *node, const char *output) {
    const size_t n = components(nqm_xml_get(node, "type")), n_kinds = sizeof kinds / sizeof *kinds;
    size_t k = 0;
    while (k < n_kinds && !nqm_contains_word(kinds[k].name, node->name, false))
        ++k;
    uint16_t result;
    if (k == n_kinds || !is_evaluated(g, node)) {
        result = build_channels(g, node);
    } else {
        const uint16_t image = kinds[k].uv_program ? read_image(g, &kinds[k], node) : NQM_NO_NODE;
        nqm_mtlx_program m = read_operands(g, node, kinds[k].operands);
        m.image = image;
        result = nqm_mtlx_run(&m, kinds[k].program);
    }
    name_unused(g, node, k < n_kinds ? &kinds[k] : NULL);
    result = n ? nqm_mtlx_resize(g->t, result, n) : result;
    if (!*output || (n > 0 && !nqm_texts_equal(node->name, "UsdUVTexture")))
        return result;
    return nqm_contains_word("outcolor rgb", output, false)
               ? nqm_mtlx_resize(g->t, result, 3)
               : swizzle(g, result, output + (strncmp(output, "out", 3) == 0 ? 3 : 0));
}

static uint16_t build_once(graph *g, element *node, const char *output) {
    if (!g->source && !nqm_contains_word("constant dot", node->name, false))
        g->source = node;
    for (size_t i = 0; i < g->n_built; ++i)
        if (g->built[i].node == node && strcmp(g->built[i].output, output) == 0)
            return g->built[i].value;
    const uint16_t value = build(g, node, output);
    if (value == NQM_NO_NODE || g->n_built == NQM_MAX_MAP_NODES)
        return REFUSE(g, "%s is not finite, its graph needs more than %d nodes, or memory is short", g->name,
                      NQM_MAX_MAP_NODES);
    g->built[g->n_built++] = (struct nqm_mtlx_built){node, output, value};
    return value;
}

/* The output of a node graph, by name; without one "out", or the only output that there is. */
static element *output_of(const graph *g, element *node_graph, const char *name) {
    element *found = nqm_mtlx_child(g, node_graph, NULL, name ? name : "out"), *only = NULL;
    size_t n = 0;
    for (element *e = node_graph ? node_graph->first : NULL; e && !name && !found; e = e->next)
        if (strcmp(e->name, "output") == 0) {
            only = e;
            ++n;
        }
    return found || n != 1 ? found : only;
}

element *nqm_mtlx_target(const graph *g, element *e) {
    const char *graph_name = nqm_xml_get(e, "nodegraph"), *interface = nqm_xml_get(e, "interfacename");
    const char *output = nqm_xml_get(e, "output");
    const bool is_of_graph = strcmp(e->parent->name, "nodegraph") == 0, is_output = strcmp(e->name, "output") == 0;
    /* inputs of a node graph itself are connected outside of it */
    element *scope = e->parent == g->root || (is_of_graph && !is_output) ? g->root
                     : is_of_graph                                       ? e->parent
                                                                         : e->parent->parent;
    if (interface)
        return nqm_mtlx_child(g, e->parent->parent, NULL, interface);
    if (graph_name)
        return output_of(g, nqm_mtlx_child(g, g->root, NULL, graph_name), output);
    return nqm_mtlx_child(g, scope, NULL, nqm_xml_get(e, "nodename"));
}

static uint16_t follow(graph *g, element *e, const char *type) {
    const char *output = nqm_xml_get(e, "output"), *channels = nqm_xml_get(e, "channels");
    element *to = nqm_mtlx_target(g, e);
    char name[200];
    if (!to)
        return REFUSE(g, "%s is connected to something that the file does not have", label(g, e, name));
    const char *to_type = nqm_xml_get(to, "type");
    const bool differs =
        type && to_type && components(to_type) && !nqm_texts_equal(type, to_type) && !output && !channels;
    if (differs && (components(type) > 1 || components(to_type) > 1))
        return REFUSE(g, "%s is of type %s, not '%.40s'", label(g, e, name), type, to_type);
    const bool is_node = !nqm_xml_get(e, "interfacename") && !nqm_xml_get(e, "nodegraph");
    const uint16_t value = is_node ? build_once(g, to, output ? output : "") : read(g, to, to_type ? to_type : type);
    return channels ? swizzle(g, value, channels) : value;
}

static uint16_t read(graph *g, element *e, const char *type) {
    const char *own = nqm_xml_get(e, "type");
    if (*g->reading->refusal.text)
        return NQM_NO_NODE;
    if (!nqm_mtlx_is_connected(e))
        return read_constant(g, e, own ? own : type);
    if (g->depth == MAX_HOPS)
        return REFUSE(g, "%s: more than %d connections in a row", g->name, MAX_HOPS);
    ++g->depth;
    const uint16_t value = follow(g, e, own ? own : type);
    --g->depth;
    return value;
}

uint16_t nqm_mtlx_read(graph *g, element *input, const char *name, const char *type) {
    g->input = input;
    g->name = name;
    g->source = NULL;
    const uint16_t value = read(g, input, type);
    if (value == NQM_NO_NODE)
        return REFUSE(g, "%s: out of memory", name);
    return value;
}
