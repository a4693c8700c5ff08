/* SPDX-License-Identifier: MIT
 *
 * corpus.h - the parts of making a dataset from a list of pairs: references and rows, their views, units of work and their files,
 * the manifest.
 */
#ifndef NQM_SRC_CORPUS_CORPUS_H
#define NQM_SRC_CORPUS_CORPUS_H

#include "base/options.h"
#include "io/io.h"
#include "render/render.h"
#include <nqm/corpus.h>

extern const nqm_option_table nqm_corpus_option_table;

/* ---- the list (list.c) ------------------------------------------------------------------------------------------- */

typedef struct nqm_corpus_ref {
    const char *name;   /* unique */
    const char *brdf;   /* as in the list */
    const char *source; /* its origin: "rgl", "nbrdf", "nps", "sgd", or any other word */
    size_t group, n_rows;
    size_t first_row;
    char file_sha256[65]; /* nqm_corpus_hash_content() */
} nqm_corpus_ref;

typedef struct nqm_corpus_group {
    const char *name;
    nqm_split split;
} nqm_corpus_group;

typedef struct nqm_corpus_row {
    size_t ref;
    const char *test, *kind, *family, *other; /* other: "": none */
} nqm_corpus_row;

/** The pairs of a part; all texts are borrowed. */
typedef struct nqm_corpus_list {
    size_t n_refs, n_groups, n_rows, n_unseen;
    nqm_corpus_ref *refs;     /* (n_refs) grouped; owns the block of all arrays */
    nqm_corpus_group *groups; /* (n_groups) in the order of their first pair */
    nqm_corpus_row *rows;     /* (n_rows) by reference, in the order of the list within one */
    const char **unseen;      /* (n_unseen) kinds that the list has in the test split only, if it has others too */
    const char *root;
    nqm_index by_brdf; /* of refs */
} nqm_corpus_list;

NQM_MUST_CHECK nqm_status nqm_corpus_list_make(size_t n, const nqm_corpus_pair *pairs,
                                               const nqm_corpus_options *options, nqm_corpus_list *list_ret,
                                               nqm_error *err);
void nqm_corpus_list_free(nqm_corpus_list *list);
/** "train", "validation" or "test" */
const char *nqm_corpus_split_name(nqm_split split);

/* ---- checksums (work.c) ------------------------------------------------------------------------------------------ */

/** SHA-256 of a file, or of the concatenation of two; path_more: NULL for one. */
NQM_MUST_CHECK nqm_status nqm_corpus_hash_file(const char *path, const char *path_more, char hex[65], nqm_error *err);
/** SHA-256 of the file of an argument and of what that names, latents or a measured file; "" of specs and presets. */
NQM_MUST_CHECK nqm_status nqm_corpus_hash_content(const nqm_corpus_list *list, const char *base, char hex[65],
                                                  nqm_error *err);
/** Set file_sha256 of all references. A missing file is an error here, before the work begins. */
NQM_MUST_CHECK nqm_status nqm_corpus_hash_refs(nqm_corpus_list *list, nqm_error *err);

/* ---- BRDFs as the corpus uses them (view.c) ----------------------------------------------------------------------- */

/** A BRDF with its samples and its picture; rgb owns the block of the arrays. n = n_directions. */
typedef struct nqm_corpus_view {
    nqm_brdf *brdf;
    float *rgb;      /* (n, 3) */
    uint8_t *used;   /* (n) */
    double *picture; /* (3, n_points, 3) of nqm_scene_render_halves() */
    double valid;    /* the fraction of the light where the BRDF has a value */
} nqm_corpus_view;

typedef struct nqm_corpus nqm_corpus;

NQM_MUST_CHECK nqm_status nqm_corpus_view_alloc(const nqm_corpus *corpus, nqm_corpus_view *view, nqm_error *err);
void nqm_corpus_view_free(nqm_corpus_view *view);
/** Sample and render view->brdf. */
NQM_MUST_CHECK nqm_status nqm_corpus_view_fill(const nqm_corpus *corpus, nqm_corpus_view *view, nqm_error *err);

/** The views of all references, each made when it is first needed. */
typedef struct nqm_corpus_cache nqm_corpus_cache;
NQM_MUST_CHECK nqm_status nqm_corpus_cache_create(size_t n_refs, nqm_corpus_cache **cache_ret, nqm_error *err);
void nqm_corpus_cache_free(nqm_corpus_cache *cache);
/** The view of a reference; owned by the cache of the corpus. Any thread. A failure is kept. */
NQM_MUST_CHECK nqm_status nqm_corpus_cached(const nqm_corpus *corpus, size_t ref, const nqm_corpus_view **view_ret,
                                            nqm_error *err);

/** A fit, or why it failed. */
typedef struct nqm_corpus_fit {
    char *argument;
    nqm_brdf *brdf; /* NULL: it failed */
    nqm_error fault;
} nqm_corpus_fit;

/** The fits of a unit of work, which several of its tests may contain. */
typedef struct nqm_corpus_fits {
    size_t n, max_n;
    nqm_corpus_fit *fits; /* (n) */
} nqm_corpus_fits;
void nqm_corpus_fits_free(nqm_corpus_fits *fits);

/** Open an argument of the list. *is_lent_ret: the result belongs to the cache of the corpus or to `fits`. fits NULL:
 *  references are opened too, not taken from the cache. */
NQM_MUST_CHECK nqm_status nqm_corpus_open(const nqm_corpus *corpus, nqm_corpus_fits *fits, const char *argument,
                                          nqm_brdf **brdf_ret, bool *is_lent_ret, nqm_error *err);
/** The reference that this argument is; NULL: none. */
const nqm_corpus_ref *nqm_corpus_ref_of(const nqm_corpus_list *list, const char *argument);

/* ---- units of work (unit.c, work.c, run.c) ------------------------------------------------------------------------ */

/** The names of the learned encoders. */
extern const char *const nqm_corpus_encoders[2];

enum { NQM_CORPUS_UNIT_ROWS = 128 };

/** Up to NQM_CORPUS_UNIT_ROWS rows of one reference, with their samples and labels. */
typedef struct nqm_corpus_unit {
    size_t ref, first_row, n_rows;
    char *path; /* its work file; NULL without a checkpoint folder; owned */
    bool is_done;
    /* views into the arrays of nqm_corpus; n = n_directions */
    float *ref_rgb;     /* (n, 3) */
    uint8_t *ref_used;  /* (n) */
    float *test_rgb;    /* (n_rows, n, 3) */
    uint8_t *test_used; /* (n_rows, n) */
    nqm_label *label;   /* (n_rows) */
    char **names;       /* (n_rows) each test as an argument; the strings are owned */
    char **failures;    /* (n_rows) error message of a failed pair, else NULL; owned */
} nqm_corpus_unit;

/** Label the rows. The error of a pair is stored as its failure; cancellation and lack of memory are errors of the call. */
NQM_MUST_CHECK nqm_status nqm_corpus_unit_make(const nqm_corpus *corpus, nqm_corpus_unit *unit, nqm_error *err);

/** Path of the work file of a unit; its name is a hash of everything that determines the result. nqm_free() it. */
NQM_MUST_CHECK nqm_status nqm_corpus_unit_path(const nqm_corpus *corpus, const nqm_corpus_unit *unit, char **path_ret,
                                               nqm_error *err);
/** Load the finished unit from unit->path; false: no such file, or a damaged one (the unit is made again). */
bool nqm_corpus_unit_load(size_t n_directions, nqm_corpus_unit *unit);
/** Save the first n_done rows: to unit->path if they are all, otherwise to the file of an unfinished unit, unit->path +
 *  ".progress", which the finished one replaces. */
NQM_MUST_CHECK nqm_status nqm_corpus_unit_save(size_t n_directions, const nqm_corpus_unit *unit, size_t n_done,
                                               nqm_error *err);
/** Load the rows of an unfinished unit; returns their number, 0: none. */
size_t nqm_corpus_unit_resume(size_t n_directions, nqm_corpus_unit *unit);

/* ---- a corpus ---------------------------------------------------------------------------------------------------- */

/** A corpus. What units share comes first; they have views into the arrays, which are one block owned by ref_rgb. */
struct nqm_corpus {
    const nqm_corpus_options *options;
    const nqm_directions *directions;
    size_t n_directions;
    size_t n_keep_name, n_keep; /* of options->keep: nqm_corpus_parse_keep() */
    nqm_corpus_list list;
    nqm_scene *scene;
    nqm_corpus_cache *cache;
    char light_sha256[65];                   /* "" for built-in lights */
    char shape_sha256[65];                   /* of a mesh file; "" for built-in shapes */
    char encoder_sha256[2][65];              /* of nqm_corpus_encoders; "": not in this build */
    bool (*step)(void *user, size_t n_rows); /* called with finished rows, 0 within one; any thread; true: stop */
    void *step_user;
    size_t n_units;
    nqm_corpus_unit *units; /* (n_units) in the order of the rows */
    float *ref_rgb, *test_rgb;
    uint8_t *ref_used, *test_used; /* (n_units, n), (n_rows, n) */
    nqm_label *label;              /* (n_rows) */
    char **names, **failures;      /* (n_rows) */
    uint8_t *kept;                 /* (n_rows) whether the row is a pair of the dataset */
};

/** Make all units on all threads, together with other processes that share the checkpoint folder. */
NQM_MUST_CHECK nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err);
/** Set `kept`: rows that did not fail, without those that options->keep leaves out (spread.c). */
NQM_MUST_CHECK nqm_status nqm_corpus_select(nqm_corpus *corpus, nqm_error *err);
/** Parse options->keep: the length of the family's name (0: nothing is left out) and the number. */
NQM_MUST_CHECK nqm_status nqm_corpus_parse_keep(const char *keep, size_t *n_name_ret, size_t *n_kept_ret,
                                                nqm_error *err);
/** Mark n_kept of n JODs (n) such that they are spread as evenly as possible; NaN is never marked. kept (n). */
NQM_MUST_CHECK nqm_status nqm_corpus_spread(size_t n, const double *jod, size_t n_kept, uint8_t *kept, nqm_error *err);
/** Write the finished corpus and its manifest. Rows that are no pairs are removed from the arrays. */
NQM_MUST_CHECK nqm_status nqm_corpus_write(nqm_corpus *corpus, const char *path, nqm_error *err);

/** Open the file of the manifest, which is written next to a dataset: `dataset_path`.json. */
NQM_MUST_CHECK nqm_status nqm_corpus_manifest_open(const char *dataset_path, nqm_outfile *out_ret, nqm_error *err);
/** The manifest as JSON text (nqm_free); NULL: out of memory, or a name is not UTF-8. */
char *nqm_corpus_manifest(const nqm_corpus *corpus);

#endif
