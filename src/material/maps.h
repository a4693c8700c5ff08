/* SPDX-License-Identifier: MIT
 *
 * maps.h - a material that varies over a surface: its shading, and what of it is computed from image maps, as a list of nodes that
 * texture/ evaluates texel by texel. Each reader of a file format appends the nodes that its format describes; nothing here
 * reads an image.
 */
#ifndef NQM_SRC_MATERIAL_MAPS_H
#define NQM_SRC_MATERIAL_MAPS_H

#include "material/material.h"

/** The operations of one value per component: X(NAME, number of operands, what it computes of these, a to d). */
#define NQM_MAP_COMPONENT_OPS(X)                                                                                       \
    X(ADD, 2, a + b)                                                                                                   \
    X(SUBTRACT, 2, a - b)                                                                                              \
    X(MULTIPLY, 2, (a * b))                                                                                            \
    X(DIVIDE, 2, b != 0 ? a / b : 0)                                                                                   \
    X(POWER, 2, pow(fmax(a, 0), b))                                                                                    \
    X(MINIMUM, 2, fmin(a, b))                                                                                          \
    X(MAXIMUM, 2, fmax(a, b))                                                                                          \
    X(ABSOLUTE, 1, fabs(a))                                                                                            \
    X(FLOOR, 1, floor(a))                                                                                              \
    X(MODULO, 2, b != 0 ? a - b * floor(a / b) : 0)                                                                    \
    X(SINE, 1, sin(a))                                                                                                 \
    X(COSINE, 1, cos(a))                                                                                               \
    X(ANGLE, 2, atan2(a, b))                                                                                           \
    X(MIX, 3, a + (b - a) * c)                                                                                         \
    X(SMOOTHSTEP, 3, smoothstep(a, b, c))                                                                              \
    X(IF_GREATER, 4, a > b ? c : d)                                                                                    \
    X(IF_EQUAL, 4, a == b ? c : d)
#define NQM_MAP_OP_NAME(NAME, N_OPERANDS, VALUE) NQM_MAP_##NAME,

/** What a node computes. A value has 1 to 4 components. Where operations of one value per component get values of different numbers
 *  of components, the shorter repeats its last one. Operands: in[0], in[1], ... */
typedef enum nqm_map_op {
    NQM_MAP_VALUE, /**< the constant v */
    NQM_MAP_IMAGE, /**< `image` at the texture coordinates, in its colour space; missing channels of grey images repeat it */
    NQM_MAP_CHANNEL, /**< component (size_t)v[0] of in[0]: one component */
    NQM_MAP_COMPONENT_OPS(NQM_MAP_OP_NAME)
        NQM_MAP_COMBINE, /**< the first components of in[0], in[1], ... as one value of n components */
    NQM_MAP_LUMINANCE,   /**< of RGB in[0] with BT.709 primaries, n times */
    NQM_MAP_RGB_TO_HSV,  /**< as in MaterialX: 0..1 each */
    NQM_MAP_HSV_TO_RGB,
    NQM_MAP_TEXCOORD, /**< u, and v measured upwards from the lower edge, of the surface: two components */
    NQM_MAP_NORMAL, /**< a tangent-space normal: 2 in[0] - 1, its x and y multiplied by in[1], normalised; y points up; (0, 0, 1) where in[0] is black */
    NQM_MAP_OPS
} nqm_map_op;

/** How an image continues beyond its edges. */
typedef enum nqm_map_wrap {
    NQM_MAP_REPEAT,
    NQM_MAP_MIRROR,
    NQM_MAP_CLAMP,
    NQM_MAP_BORDER /**< v of the node */
} nqm_map_wrap;

/** A node; operands are earlier nodes. */
typedef struct nqm_map_node {
    nqm_map_op op;
    uint8_t n; /**< components of the value, 1 to 4 */
    uint16_t in[4];
    double v[4]; /**< NQM_MAP_VALUE, NQM_MAP_CHANNEL; of NQM_MAP_IMAGE its value beyond the border */
    /* of NQM_MAP_IMAGE: */
    uint16_t image;
    uint8_t wrap[2]; /**< nqm_map_wrap along u and v */
    /** Position in the image, (0, 0) its upper left corner and (1, 1) its lower right one, of a position (u, v) on the surface, v
     *  downwards: uv[i][0] u + uv[i][1] v + uv[i][2]. */
    double uv[2][3];
} nqm_map_node;

/** The colour space of an image that is sRGB if it has 8 bits and three or four channels, else values as they are. */
#define NQM_SPACE_AUTO "auto"

/** An image: bytes of a file, or bytes that the material file contains in another coding. */
typedef struct nqm_map_image {
    char *path;          /**< of the file; NULL: `data` */
    size_t at, n_bytes;  /**< part of the file; n_bytes 0: all of it */
    unsigned char *data; /**< (n_bytes), owned; NULL: `path` */
    char *name;          /**< for people: "boombox/BoomBox_normal.png" */
    bool needs_color;    /**< one of several channels is taken by name: a grey picture is another one */
    bool needs_alpha;    /**< its alpha is taken by name: a picture without is another one */
    bool expects_alpha;  /**< its alpha is a value; one without is opaque, which a remark says */
    char space[32];      /**< colour space as nqm_color_to_rec709() takes it; "": values as they are; NQM_SPACE_AUTO */
} nqm_map_image;

enum { NQM_MAX_MAP_NODES = 1024, NQM_MAX_MAP_IMAGES = 64, NQM_NO_NODE = 0xffff };

/** What is computed: a key of the shading, and the node whose value it has. */
typedef struct nqm_map_output {
    char key[48];
    uint16_t node;
} nqm_map_output;

/** A textured material. */
typedef struct nqm_textured {
    nqm_values values; /**< with values of all properties that are constant */
    size_t n_outputs;
    nqm_map_output outputs[NQM_SCHEMA_MAX_KEYS];
    uint16_t normal; /**< a unit vector in the frame of tangent (u), bitangent (v upwards), normal; NQM_NO_NODE: z */
    size_t n_nodes, max_nodes;
    nqm_map_node *nodes;
    size_t n_images, max_images;
    nqm_map_image *images;
    char remark[NQM_REMARK_SIZE]; /**< what of the source is not used, or assumed; "": nothing */
} nqm_textured;

/** The bytes of an image: of its file, which stays mapped until nqm_map_close(map), or its own. NQM_ERR_IO, NQM_ERR_FORMAT (the file is
 *  shorter); `map` is closed then. */
NQM_MUST_CHECK nqm_status nqm_textured_open_image(const nqm_map_image *image, nqm_map *map,
                                                  const unsigned char **data_ret, size_t *n_ret, nqm_error *err);

/** An empty one; NULL: out of memory. */
nqm_textured *nqm_textured_create(void);
/** Free; NULL is allowed. */
void nqm_textured_free(nqm_textured *textured);
/** Memory that it takes. */
size_t nqm_textured_bytes(const nqm_textured *textured);
/** Add to the remark, unless it is there. */
void nqm_textured_remark(nqm_textured *textured, const char *text);
/** Remove nodes and files that no output needs. */
void nqm_textured_prune(nqm_textured *textured);

/** Append a node, or find the equal one that is there already. Constants are computed at once, and a factor of 1 or a
 *  sum with 0 is its first operand. NQM_NO_NODE: out of memory, more than NQM_MAX_MAP_NODES, or a constant that is not
 *  finite; then, and where an operand is NQM_NO_NODE, this is the result of all that follows, so that readers need to
 *  check the last node only. */
uint16_t nqm_graph_add(nqm_textured *t, nqm_map_node node);
/** A constant of n components. */
uint16_t nqm_graph_value(nqm_textured *t, size_t n, const double *v);
/** A constant number. */
uint16_t nqm_graph_number(nqm_textured *t, double v);
/** A node with up to three operands; others are ignored. n: components of the value. */
uint16_t nqm_graph_compute(nqm_textured *t, nqm_map_op op, size_t n, uint16_t a, uint16_t b, uint16_t c);
/** A node whose second operand is a number. */
uint16_t nqm_graph_with(nqm_textured *t, nqm_map_op op, size_t n, uint16_t a, double b);
/** Whether the node is a constant. */
bool nqm_graph_is_constant(const nqm_textured *t, uint16_t node);
/** How many operands a node with this operation and n components has. */
size_t nqm_graph_operands(nqm_map_op op, size_t n);
/** The value of a node at one position, also beyond its n components, where it repeats the last one.
 *  values (4 each): of the earlier nodes, repeated likewise. The caller evaluates NQM_MAP_IMAGE and NQM_MAP_TEXCOORD itself. */
void nqm_graph_node_value(const nqm_map_node *node, const double (*values)[4], double out[4]);
/** Component c of a node; the node itself if it has only one. */
uint16_t nqm_graph_channel(nqm_textured *t, uint16_t of, size_t c);
/** An image, of n channels. uv, wrap: as in nqm_map_node; NULL: the positions of the surface, repeated. */
uint16_t nqm_graph_image_at(nqm_textured *t, size_t image, size_t n, const double uv[2][3], const uint8_t wrap[2]);
/** Add an image of a file named by the material file `from`, or find it; name is relative to its folder, or absolute. false: out of
 *  memory, or more than NQM_MAX_MAP_IMAGES. */
bool nqm_graph_add_file(nqm_textured *t, const char *from, const char *name, const char *space, size_t *image_ret);
/** Add any image; takes its path, data and name, also on failure. A NULL of what it needs is a failure. */
bool nqm_graph_add_image(nqm_textured *t, nqm_map_image image, size_t *image_ret);
/** What computes a key; NULL: it is constant. */
nqm_map_output *nqm_graph_output(nqm_textured *t, const char *key);
/** Let a key have the value of a node. */
void nqm_graph_output_set(nqm_textured *t, const char *key, uint16_t node);

#define NQM_MAPS_PREFIX "maps:"
/** A folder of maps, or "maps:base_color=a.png;roughness=b.png;model=gltf". NQM_ERR_ARG, NQM_ERR_IO, NQM_ERR_NOMEM */
NQM_MUST_CHECK nqm_status nqm_maps_open(const char *folder_or_spec, nqm_textured **textured_ret, nqm_error *err);
/** The number of networks (files "...fc1.npy") in a folder; 0 also for other paths. *first_ret: the path of the first; NULL also when out
 *  of memory; nqm_free() it. */
size_t nqm_networks_in_folder(const char *path, char **first_ret);

/** The textured material i of a file without the properties `ignored` (NQM_IGNORE_...); NULL: it is constant, or refused. */
const nqm_textured *nqm_materials_maps(const nqm_materials *materials, size_t i, unsigned ignored);
/** Give the last material its maps, or NULL; is_owner: it frees them, else they are those of a material that outlives it. */
void nqm_materials_attach(nqm_materials *materials, const nqm_textured *textured, bool is_owner);

#endif
