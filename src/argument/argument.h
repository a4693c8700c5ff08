/* SPDX-License-Identifier: MIT
 *
 * argument.h - what a BRDF argument is: its text is taken apart once, here, and the result opens the BRDF, the image maps or the
 * materials that it names. nqm_brdf_open() of <nqm/brdf.h> is implemented here, too. "fit:" is recognised here and opened by fit/,
 * which is above.
 */
#ifndef NQM_SRC_ARGUMENT_H
#define NQM_SRC_ARGUMENT_H

#include "brdf/formats/format.h"
#include "material/maps.h"

typedef enum nqm_argument_kind {
    NQM_ARGUMENT_NOTHING,  /**< no file, no spec: opening it says what it may mean */
    NQM_ARGUMENT_SPEC,     /**< "ggx:alpha=.1;...", "sgd:nickel" */
    NQM_ARGUMENT_WRAPPER,  /**< "perturb:SETTINGS;of=BRDF", "between:SETTINGS;with=(BRDF);of=BRDF" */
    NQM_ARGUMENT_FIT,      /**< "fit:SETTINGS;of=BRDF" */
    NQM_ARGUMENT_MAPS,     /**< "maps:base_color=a.png;..." */
    NQM_ARGUMENT_FOLDER,   /**< of image maps, or of other files */
    NQM_ARGUMENT_NETWORKS, /**< a folder with the files of networks */
    NQM_ARGUMENT_MATERIAL, /**< "FILE" or "FILE:NAME" of a renderer's material file */
    NQM_ARGUMENT_FILE      /**< another "FILE" or "FILE:MEMBER" */
} nqm_argument_kind;

/** A material file that stays parsed as long as an argument needs it, or longer (nqm_argument_files). */
typedef struct nqm_argument_file nqm_argument_file;
/** The last used ones. */
typedef struct nqm_argument_files nqm_argument_files;

/** An argument. One thread at a time. */
typedef struct nqm_argument {
    nqm_argument_kind kind;
    const char *text;          /**< the whole argument */
    const char *rest;          /**< after "ignore:WORDS:"; cut into the parts below */
    unsigned ignored;          /**< NQM_IGNORE_... of these words */
    const char *path, *member; /**< "PATH" or "PATH:MEMBER"; path NULL: of a spec or list; member NULL: there is none */
    const nqm_spec_wrapper *wrapper;
    const char *settings, *with, *of; /**< of a wrapper or fit: in the text; NULL: there is none */
    const nqm_materials *materials;   /**< of a material file, also of several; valid as long as the argument */
    nqm_error err;                    /**< why it cannot be opened, as far as that is known; status NQM_OK: unknown */
    /* private: */
    nqm_argument_file *file;
    nqm_map map; /* of another file, until it is opened */
    const nqm_brdf_format *format;
    char *network; /* a file of the folder */
    size_t n_networks;
} nqm_argument;

/** Take a text apart, and read the file if it is a material file. files: where material files stay parsed; NULL: in the argument
 *  only. NULL: out of memory; other faults are told when it is opened. nqm_argument_free() it. */
nqm_argument *nqm_argument_parse(const char *text, nqm_argument_files *files);
/** Free; NULL is allowed. */
void nqm_argument_free(nqm_argument *argument);

/** See nqm_brdf_open(). */
NQM_MUST_CHECK nqm_status nqm_argument_open(nqm_argument *argument, nqm_brdf **brdf_ret, nqm_error *err);
/** nqm_brdf_open() for a BRDF that is named in a list: nqm_argument_below(). */
NQM_MUST_CHECK nqm_status nqm_argument_open_below(const char *text, const char *root, nqm_brdf **brdf_ret,
                                                  nqm_error *err);
/** Opens the BRDFs that wrappers name. *is_lent_ret: the BRDF belongs to the opener and outlives the result. */
typedef nqm_status nqm_base_opener(void *user, const char *text, nqm_brdf **brdf_ret, bool *is_lent_ret,
                                   nqm_error *err);
/** Open a wrapper whose BRDFs are opened by a function. name: of the result; NULL: its spec. */
NQM_MUST_CHECK nqm_status nqm_argument_wrap(const nqm_argument *argument, const char *name, nqm_base_opener *open,
                                            void *user, nqm_brdf **brdf_ret, nqm_error *err);

/** The material that is named, or the only one of the file, without what is ignored; false: there is not one. */
bool nqm_argument_material(const nqm_argument *argument, nqm_material_info *info);
/** Whether image maps change it over a surface. No image is read. */
bool nqm_argument_is_textured(const nqm_argument *argument);
/** What is computed from its maps; NULL and NQM_OK: nothing, it is a BRDF. *owned_ret: nqm_textured_free() it. */
NQM_MUST_CHECK nqm_status nqm_argument_maps(const nqm_argument *argument, const nqm_textured **maps_ret,
                                            nqm_textured **owned_ret, nqm_error *err);
/** The materials of a file of several, if the argument names none of them; NULL: it does. */
const nqm_materials *nqm_argument_library(const nqm_argument *argument);
/** The argument with "ignore:WORDS:" if it is a material that is refused for properties of a set alone; NULL: it is not, or there is no
 *  memory. nqm_free() it. */
char *nqm_argument_reflecting(const nqm_argument *argument, unsigned set);

/** The second file that "FILE:MEMBER" reads, the latents of a decoder or the measured file of a material. NULL: there is none.
 *  nqm_free() it. */
NQM_MUST_CHECK nqm_status nqm_argument_companion(const nqm_argument *argument, char **path_ret, nqm_error *err);
/** Visit the files that an argument reads: its own, its companion, its image maps, and those of the BRDFs that it is made from. */
void nqm_argument_visit_files(const nqm_argument *argument, void (*visit)(void *user, const char *path), void *user);
/** Visit the texts of the files, specs and presets that an argument is made from, until `visit` fails. */
NQM_MUST_CHECK nqm_status nqm_argument_visit_bases(const char *text,
                                                   nqm_status (*visit)(void *user, const char *base, nqm_error *err),
                                                   void *user, nqm_error *err);

/** The text of a BRDF that is named in a list: specs and absolute paths unchanged, relative paths prefixed with the folder `root`
 *  (NULL or "": the working folder). NULL: out of memory. nqm_free() it. */
char *nqm_argument_below(const char *text, const char *root);
/** Length of NAME in "NAME=BRDF"; 0 for an argument without a name. A name has no ':' and no '/'; an existing file with this
 *  name is not split, nor is a spec with another character for its colon. */
size_t nqm_argument_name_length(const char *text);
/** NQM_IGNORE_... of a text; 0: it does not begin with "ignore:WORDS:". */
unsigned nqm_argument_ignored(const char *text);
/** What follows "ignore:WORDS:" in a text; else the text. */
const char *nqm_argument_rest(const char *text);
/** The kind of a text that is no name of a file; NQM_ARGUMENT_NOTHING: it may be one, no file is looked for. */
nqm_argument_kind nqm_argument_kind_of(const char *text);

/* ---- files that stay parsed -------------------------------------------------------------------------------------- */

/** NULL: out of memory. Any thread may use it. */
nqm_argument_files *nqm_argument_files_create(void);
/** Free; NULL is allowed. Files of arguments remain until these are freed. */
void nqm_argument_files_free(nqm_argument_files *files);
/** From here on all arguments of the process share one list of parsed files: for the tool, during whose run they do not change. */
void nqm_argument_files_share(void);

/** Take a file, which is then released; NULL is allowed. */
nqm_argument_file *nqm_argument_file_hold(nqm_argument_file *file);
void nqm_argument_file_release(nqm_argument_file *file);

/** What to do with what image maps change. */
#define NQM_TEXTURE_ADVICE                                                                                             \
    "; score, batch, rank, report, info, check, label, render and translate take textures (doc/textures.md)"

/* Inside of the room. Read the file of an argument at its path. */
void nqm_argument_read(nqm_argument *argument, nqm_argument_files *files);
/* Select the material of an argument, and open it. name: of the BRDF. */
nqm_status nqm_argument_open_material(const nqm_argument *argument, const char *name, nqm_brdf **brdf_ret,
                                      nqm_error *err);
/* As nqm_brdf_open(), with another name for the BRDF's information. files: of nqm_argument_parse(). */
nqm_status nqm_argument_open_text(const char *text, const char *name, nqm_argument_files *files, nqm_brdf **brdf_ret,
                                  nqm_error *err);

/* ---- BRDFs that are not open yet ---------------------------------------------------------------------------------- */

/** A BRDF that is not open yet: of a name, or of values; with a tilted normal. It borrows both. */
typedef struct nqm_subject {
    const char *name; /**< of nqm_brdf_open(); NULL: of `values`, in their ranges */
    const nqm_values *values;
    double tilt_deg, azimuth_deg; /**< of the normal, as in "tilt:"; 0: it is (0, 0, 1) */
} nqm_subject;
/** Set the normal, a unit vector: tilted by at most 60 degrees, and not below a thousandth. */
void nqm_subject_tilt(nqm_subject *subject, const double normal[3]);
/** Whether they have the same name, or the same values, and the same normal. */
bool nqm_subjects_equal(const nqm_subject *a, const nqm_subject *b);
uint64_t nqm_subject_hash(const nqm_subject *subject);
/** Open it; the errors of nqm_brdf_open(). files: where material files stay parsed; NULL: nowhere. Any thread. */
NQM_MUST_CHECK nqm_status nqm_subject_open(const nqm_subject *subject, nqm_argument_files *files, nqm_brdf **brdf_ret,
                                           nqm_error *err);
#endif
