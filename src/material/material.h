/* SPDX-License-Identifier: MIT
 *
 * material.h - what the file formats of materials share: the list of materials that a reader fills, and what is
 * written. Nothing here checks the range of a value: src/brdf does when it opens the spec.
 */
#ifndef NQM_SRC_MATERIAL_H
#define NQM_SRC_MATERIAL_H

#include "base/base.h"
#include "schema/schema.h"
#include <nqm/material.h>

/** The remark of a material with a map or factor of ambient occlusion. */
#define NQM_OCCLUSION_REMARK "occlusion is ignored: it is no part of a BRDF, which renderers multiply by it"

/** An image map of a written glTF material. */
typedef struct nqm_written_map {
    const char *texture; /**< "baseColorTexture" */
    char file[256];      /**< name of the image, in the folder of the material file */
} nqm_written_map;
/** The values of a material that is written, and its name in a file: letters, digits and '_'. */
typedef struct nqm_written_material {
    nqm_values values;
    char name[64];
    size_t n_maps; /**< whose values are multiplied by those of the material */
    nqm_written_map maps[12];
    size_t tiles[2]; /**< how often the maps are repeated along u and v */
} nqm_written_material;
/** Write a material file with n > 0 materials of one model. Names become valid and
 *  different ones. See nqm_material_write(). The file is complete at once (set NULL), or when the set is committed. */
NQM_MUST_CHECK nqm_status nqm_materials_write(size_t n, nqm_written_material *materials, const char *path,
                                              nqm_outset *set, nqm_error *err);

/** How many materials the file has. */
size_t nqm_materials_count(const nqm_materials *materials);
/** The number of the first material of that name, and *other_ret of the second; SIZE_MAX: there is none. */
size_t nqm_materials_find(const nqm_materials *materials, const char *name, size_t *other_ret);

enum { NQM_MAX_MATERIALS = 1 << 14 };
/** An empty list, for a reader; NULL: out of memory. path: of the file, for messages of nqm_materials_add(). */
nqm_materials *nqm_materials_create(const char *path);
/** Append a material, at most NQM_MAX_MATERIALS; the texts are copied, "" and NULL in `name` become "materialN". One of
 *  spec and refusal is NULL. */
NQM_MUST_CHECK nqm_status nqm_materials_add(nqm_materials *materials, const nqm_material_info *info, nqm_error *err);

/** Let the remarks of all materials of the file say that an included file is not read; text: its path and why. */
void nqm_materials_unread(nqm_materials *materials, const char *text);

/** What a surface does besides reflecting, as a set of bits. */
enum {
    NQM_IGNORE_TRANSMISSION = 1,
    NQM_IGNORE_SUBSURFACE = 2,
    NQM_IGNORE_EMISSION = 4,
    NQM_IGNORE_OPACITY = 8,
    NQM_IGNORE_DISPLACEMENT = 16,
    NQM_IGNORE_BUMP = 32, /**< bump maps, and the normal map that a coat has of its own */
    NQM_IGNORE_SIZE = 64  /**< of a text with all words */
};
/** The words of a set, "transmission,opacity". Returns text. */
const char *nqm_ignore_words(unsigned set, char text[NQM_IGNORE_SIZE]);
/** The set of n characters of words; false: one of them is no such word, or there is none. */
bool nqm_ignore_parse(const char *words, size_t n, unsigned *set_ret);
/** Fail for wrong words, which end at a colon. */
nqm_status nqm_ignore_refuse(const char *words, nqm_error *err);
/** nqm_materials_get() with the properties of a set ignored: no refusal where they are all that is ignorable. */
nqm_material_info nqm_materials_reflecting(const nqm_materials *materials, size_t i, unsigned ignored);

/** Count memory and work for maps, of which a file may have 64 MB and 16 times its size: many materials may share a large graph, of
 *  which each has a copy. false: it has more, also for all that follow. */
bool nqm_materials_reserve(nqm_materials *materials, size_t n_bytes);
/** Why a material is then refused. */
#define NQM_MATERIALS_FULL                                                                                             \
    "its maps and those of the materials before it take more memory than a file of this size may: write fewer "        \
    "materials into a file"

/** One file format. */
typedef struct nqm_material_format {
    const char *name;       /**< "MaterialX" */
    const char *extensions; /**< endings of written files, with dots, separated by spaces: ".gltf .glb" */
    const char *models;     /**< specs it writes, separated by spaces: "open-pbr standard-surface" */
    /** true when the first bytes look like the format, also those of a damaged file. */
    bool (*probe)(const nqm_map *map);
    /** Append the materials of the file. */
    nqm_status (*read)(const nqm_map *map, nqm_materials *materials, nqm_error *err);
    /** Write a file with n materials of one model; `path` is for its extension, errors of the stream are found by the caller. */
    nqm_status (*write)(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                        nqm_error *err);
} nqm_material_format;

/** Every format. A new one is defined in a file of its own, and named here. */
#define NQM_MATERIAL_FORMATS(X)                                                                                        \
    X(nqm_mitsuba_xml_format)                                                                                          \
    X(nqm_gltf_format)                                                                                                 \
    X(nqm_materialx_format)                                                                                            \
    X(nqm_usd_format)                                                                                                  \
    X(nqm_mitsuba_json_format)                                                                                         \
    X(nqm_pbrt_format)
#define NQM_DECLARE_FORMAT(NAME) extern const nqm_material_format NAME;
NQM_MATERIAL_FORMATS(NQM_DECLARE_FORMAT)

/** Numbers separated by blanks or commas. Returns their count, 0 when there is anything else or more than max_n. */
size_t nqm_parse_numbers(const char *text, size_t max_n, double *v);
/** Replace up to 8 texts by copies in one block, which the first one owns; NULL remains. Unchanged on failure. */
NQM_MUST_CHECK nqm_status nqm_texts_copy(size_t n, char **const *texts, nqm_error *err);
/** The number of `word` among the words of `words`, which blanks separate; SIZE_MAX: it is none of them. */
size_t nqm_find_word(const char *words, const char *word, bool any_case);
/** Whether it is one of them. */
bool nqm_contains_word(const char *words, const char *word, bool any_case);
/** For probes: whether a text is among the first n_bytes. */
bool nqm_material_probe_text(const nqm_map *map, size_t n_bytes, const char *text);
/** true when a format recognises the file. */
bool nqm_materials_probe(const nqm_map *map);
/** Whether nqm_material_write() writes this model to a file of this name: NQM_OK, or its NQM_ERR_ARG. */
NQM_MUST_CHECK nqm_status nqm_material_check(const char *model, const char *path, nqm_error *err);
/** The extensions of the first format that writes this model, as in nqm_material_format; "": none does. */
const char *nqm_material_extensions(const char *model);
/** The names of all formats, separated by ", ". */
void nqm_material_format_names(char *text, size_t n_text);
/** As nqm_materials_open(), of an open file. */
NQM_MUST_CHECK nqm_status nqm_materials_read(const nqm_map *map, nqm_materials **materials_ret, nqm_error *err);

/* ---- colours of files to linear BT.709 (color_space.c) ----------------------------------------------------------- */

/** Convert rgb (3) from the colour space of this name (those of MaterialX; NULL, "" and "none": no conversion). false: no such
 *  space. Values may leave 0 to 1 where the space is larger than BT.709. */
bool nqm_color_to_rec709(const char *space, double *rgb);
/** The component with sRGB's curve to linear (IEC 61966-2-1). */
double nqm_srgb_to_linear(double v);
/** The inverse. */
double nqm_linear_to_srgb(double v);

#endif
