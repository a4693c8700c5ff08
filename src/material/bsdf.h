/* SPDX-License-Identifier: MIT
 *
 * bsdf.h - what Mitsuba 3 and pbrt-v4 share: BSDFs with typed properties as a list of nodes, their reading by rules,
 * and the indices of metals by name.
 */
#ifndef NQM_SRC_MATERIAL_BSDF_H
#define NQM_SRC_MATERIAL_BSDF_H

#include "material/rules.h"

typedef enum nqm_bsdf_kind {
    NQM_BSDF_BSDF,
    NQM_BSDF_NUMBER,
    NQM_BSDF_BOOLEAN,
    NQM_BSDF_STRING,
    NQM_BSDF_RGB,    /**< three numbers, one, or "#rrggbb" */
    NQM_BSDF_TRIPLE, /**< three numbers */
    NQM_BSDF_SPECTRUM,
    NQM_BSDF_REF,
    NQM_BSDF_TEXTURE, /**< in pbrt also a parameter whose value is the name of one */
    NQM_BSDF_OTHER,   /**< other plugins, and steps of a transform */
} nqm_bsdf_kind;

/** The kind that words of a format, separated by blanks, stand for; NULL ends a list. */
typedef struct nqm_bsdf_word {
    const char *words;
    nqm_bsdf_kind kind;
} nqm_bsdf_word;
/** NQM_BSDF_OTHER: the word is not in the list. */
nqm_bsdf_kind nqm_bsdf_kind_of(const nqm_bsdf_word *words, const char *word);

/** A BSDF or a property inside one. Texts are "" when absent. */
typedef struct nqm_bsdf_node {
    nqm_bsdf_kind kind;
    size_t parent; /**< index; NQM_BSDF_ROOT: not inside of a BSDF */
    char *type;    /**< of a plugin */
    char *name;    /**< of a property */
    char *id;
    char *value; /**< of a property, as text: "0.1", "0.2 0.3 0.4", "true" */
    int64_t byte_offset;
} nqm_bsdf_node;
#define NQM_BSDF_ROOT ((size_t)-1)

/** A zeroed list is empty. */
typedef struct nqm_bsdf_nodes {
    size_t n, max_n;
    nqm_bsdf_node *list; /* (n), parents before their children */
} nqm_bsdf_nodes;

/** Append a node; its texts are copied, NULL as "". NQM_ERR_LIMIT: more than 100000. */
NQM_MUST_CHECK nqm_status nqm_bsdf_add(nqm_bsdf_nodes *nodes, const nqm_bsdf_node *node, const char *path,
                                       nqm_error *err);
/** Remove all nodes from index n on. */
void nqm_bsdf_cut(nqm_bsdf_nodes *nodes, size_t n);
/** The list is empty then. */
void nqm_bsdf_clear(nqm_bsdf_nodes *nodes);
/** The child of `parent` after one of them, or after NULL the first one; NULL when there is none. */
const nqm_bsdf_node *nqm_bsdf_next(const nqm_bsdf_nodes *nodes, size_t parent, const nqm_bsdf_node *after);

/** The files that a scene includes, while it is read. */
typedef struct nqm_includes {
    const char *root; /**< path of the scene */
    nqm_materials *materials;
    size_t depth, n_files, n_bytes;
} nqm_includes;
/** Map an included file, whose name is relative to the folder of `from`, or else of the scene. *path_ret receives its path; NULL: it is
 *  not read, and a remark says why. NQM_ERR_FORMAT: it includes itself. NQM_ERR_LIMIT, NQM_ERR_NOMEM */
NQM_MUST_CHECK nqm_status nqm_include_open(nqm_includes *in, const char *from, const char *name, nqm_map *map,
                                           char **path_ret, nqm_error *err);
/** Whether a file of this name, which a file names, is inside of its folder: no absolute path, and no "..". */
bool nqm_include_is_inside(const char *name);
void nqm_include_close(nqm_includes *in, nqm_map *map, char *path);

/** A BSDF that is being read. Properties are nodes. */
typedef struct nqm_bsdf_reading {
    nqm_reading reading;
    const nqm_bsdf_nodes *nodes;
    size_t at;            /**< index of the BSDF, or of the texture that is being read for it */
    const char *path;     /**< of the scene */
    const nqm_index *ids; /**< BSDFs, materials and textures by name */
    size_t n_textures;    /**< pbrt: how many have been evaluated for the material */
    size_t depth;         /**< Mitsuba: of the blendbsdf that contains the BSDF */
} nqm_bsdf_reading;

/** Types of BSDFs. */
typedef struct nqm_bsdf_plugin {
    const char *type;    /**< one, or several that are refused; NULL ends a list */
    const char *refusal; /**< NULL: the plugin is read */
    const char *model;   /**< of the shading; NULL: a measured file */
    bool (*finish)(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf); /**< after the properties, or NULL */
    nqm_rule rules[26];
} nqm_bsdf_plugin;

extern const nqm_rule_source nqm_bsdf_source;
/** NULL: there is no plugin of that type. */
const nqm_bsdf_plugin *nqm_bsdf_find_plugin(const nqm_bsdf_plugin *plugins, const char *type);
/** Read the BSDF `r->at` as one of these types; false: it is refused. */
bool nqm_bsdf_read(nqm_bsdf_reading *r, const nqm_bsdf_plugin *plugins, const char *type);
/** A property of the BSDF, or NULL. */
const nqm_bsdf_node *nqm_bsdf_find(const nqm_bsdf_reading *r, const char *name);
/** A number, or n = 3 numbers; the values stay when the property is not given. false: refused. */
bool nqm_bsdf_numbers(nqm_bsdf_reading *r, const char *name, size_t n, double *v);
/** "true" or "false", likewise. */
bool nqm_bsdf_flag(nqm_bsdf_reading *r, const char *name, bool *v);
/** Index of the property's value in `words` (separated by blanks); 0 if the property is absent. */
bool nqm_bsdf_choice(nqm_bsdf_reading *r, const char *name, const char *words, size_t *v);
/** RGB of a spectrum by wavelength (bsdf_spectrum.c). false: refused. */
bool nqm_bsdf_spectrum(nqm_bsdf_reading *r, const nqm_bsdf_node *node, double rgb[3]);
/** The text of a property that names a measured file. */
nqm_rule_read nqm_bsdf_file;

/** Record that the property `node` is no constant, if it is the first one. */
void nqm_bsdf_varies(nqm_bsdf_reading *r, const nqm_bsdf_node *node);
/** Whether a property has a texture instead of a constant value; false for NULL. */
bool nqm_bsdf_is_texture(const nqm_bsdf_node *node);
/** Check the properties of the texture r->at: `read` names those that are read, `unused` those without effect, which are listed as such;
 *  any other refuses the material: false. */
bool nqm_bsdf_check(nqm_bsdf_reading *r, const char *read, const char *unused);
/** The filename of the texture r->at; NULL: refused. */
const nqm_bsdf_node *nqm_bsdf_filename(nqm_bsdf_reading *r);
/** Whether the file holds linear floats: OpenEXR, Radiance or PFM. */
bool nqm_bsdf_is_float_image(const char *file);
/** RGB of an image file. uv as in nqm_map_node, or NULL; wrap: along both axes. */
bool nqm_bsdf_image(nqm_bsdf_reading *r, const nqm_bsdf_node *file, const char *space, const double uv[2][3],
                    nqm_map_wrap wrap, uint16_t *value_ret);
/** Let a key have the value of a node, or "normal" that of an RGB map. */
bool nqm_bsdf_output(nqm_bsdf_reading *r, const char *key, uint16_t value);

#define NQM_BSDF_SMOOTH "a smooth surface is taken as the narrowest lobe of the model"
#define NQM_BSDF_BUMPED "bump maps are not read"
/** Let the conductor that is being read, except for its lobe, be what the interface of a dielectric, or both faces of a
 *  thin pane of it, reflect: the material is refused unless transmission is ignored. false: refused. */
bool nqm_bsdf_interface(nqm_bsdf_reading *r, const nqm_bsdf_node *bsdf, double eta, bool is_thin);

/** A conductor's index of refraction eta + i k, for the three channels. */
typedef struct nqm_metal {
    const char *name;
    double eta[3], k[3];
} nqm_metal;
/** NULL: pbrt, or else Mitsuba, has none of this name ("metal-Au" in pbrt). "Au_palik" is "Au". */
const nqm_metal *nqm_metal_find(bool is_pbrt, const char *name);
/** All its names, separated by ", ". */
void nqm_metal_names(bool is_pbrt, char *text, size_t n_text);

/* ---- Mitsuba: its scenes are read from XML or from a JSON dictionary into one list of nodes ----------------------- */

/** true when Mitsuba has a BSDF plugin of this name. */
bool nqm_mitsuba_is_bsdf(const char *type);
/** Append a material for each BSDF that is not inside of another one. path: of the scene. */
NQM_MUST_CHECK nqm_status nqm_mitsuba_translate(const nqm_bsdf_nodes *nodes, const char *path, nqm_materials *materials,
                                                nqm_error *err);

/** Write the BSDF as a JSON dictionary or as XML. */
nqm_status nqm_mitsuba_write(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                             nqm_error *err);

/* ---- pbrt ---------------------------------------------------------------------------------------------------------- */

/** What is read of a scene. */
typedef struct nqm_pbrt_scene {
    const char *path;
    nqm_bsdf_nodes nodes; /**< the textures so far, then the material that is being read, each with its parameters */
    nqm_index names;      /**< of textures and materials */
    nqm_materials *materials;
} nqm_pbrt_scene;
/** The node of a "float" or "spectrum" texture, or the number of a "material"; SIZE_MAX: there is none of this name. */
size_t nqm_pbrt_find(const nqm_index *names, const char *kind, const char *name);
/** Append the material of this type at node `at`, after the textures that it can name. refusal: why it is refused; NULL: it is not. */
NQM_MUST_CHECK nqm_status nqm_pbrt_add(const nqm_pbrt_scene *scene, size_t at, const char *type, const char *refusal,
                                       nqm_error *err);

#endif
