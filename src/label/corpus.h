/* SPDX-License-Identifier: MIT
 *
 * corpus.h - the parts of making a corpus: the list of references, the plan of tests for each, the making of one material
 * group, and the manifest.
 */
#ifndef NQM_SRC_LABEL_CORPUS_H
#define NQM_SRC_LABEL_CORPUS_H

#include "base/options.h"
#include "io/io.h"
#include "render/render.h"
#include <nqm/fit.h>
#include <nqm/label.h>
#include <stdatomic.h>

extern const nqm_option_table nqm_corpus_option_table;

/* ---- references -------------------------------------------------------------------------------------------------- */

typedef struct nqm_corpus_ref {
    const char *name;   /* unique in the list */
    const char *brdf;   /* as in the list */
    const char *source; /* its origin: "rgl", "nbrdf", "nps", "sgd", or any other word */
    char *path;         /* argument of nqm_brdf_open(); owned */
    size_t group;
    char file_sha256[65]; /* of its file (a decoder and its latents: of both); "" for specs and presets */
} nqm_corpus_ref;

typedef struct nqm_corpus_group {
    const char *name;
    nqm_split split;
    size_t first_ref, n_refs; /* its references in the list */
} nqm_corpus_group;

/** A material list; its strings are owned by the CSV. */
typedef struct nqm_corpus_list {
    nqm_csv *csv;
    size_t n_refs, n_groups;
    nqm_corpus_ref *refs;     /* (n_refs) grouped, in the order of the list within a group */
    nqm_corpus_group *groups; /* (n_groups) in the order of their first reference */
} nqm_corpus_list;

/** Read a material list. Duplicate names and groups in two splits are errors. `root`: folder of relative paths; NULL: the folder
 * of the list. */
NQM_MUST_CHECK nqm_status nqm_corpus_list_load(const char *materials_csv, const char *root, nqm_corpus_list *list_ret,
                                               nqm_error *err);
void nqm_corpus_list_free(nqm_corpus_list *list);
/** SHA-256 of a file, or of the concatenation of two; path_more: NULL for one. */
NQM_MUST_CHECK nqm_status nqm_corpus_hash_file(const char *path, const char *path_more, char hex[65], nqm_error *err);
/** Whether the group belongs to this part of the corpus. */
bool nqm_corpus_in_part(const nqm_corpus_group *group, nqm_corpus_part part);
/** "train", "validation" or "test" */
const char *nqm_corpus_split_name(nqm_split split);

/* ---- kinds of test ----------------------------------------------------------------------------------------------- */

/** Families of kinds of test; nqm_dataset_get_kind() gives them for a dataset. */
typedef enum nqm_corpus_family {
    NQM_FAMILY_ENCODING = 0, /* an encoding of the reference by this program; a kind is a model of nqm_fit() */
    NQM_FAMILY_PUBLISHED,    /* published parameters of the same material: "published-ward" */
    NQM_FAMILY_FORM,         /* another form of the same material: "form-rgl", "form-nbrdf" */
    NQM_FAMILY_PERTURBATION, /* one perturbation of the reference: "gloss" */
    NQM_FAMILY_COMPOSED,     /* two perturbations of the reference ("composed") or one of an encoding ("refit") */
    NQM_FAMILY_COUNT
} nqm_corpus_family;

const char *nqm_corpus_family_name(nqm_corpus_family family);

typedef struct nqm_corpus_kind {
    char name[48];
    nqm_corpus_family family;
} nqm_corpus_kind;

/** The names of the perturbations in a fixed order; NULL after the last. */
const char *nqm_corpus_perturbation(size_t i);
/** Whether a perturbation is in the test part only, for judging on kinds that are not in training. */
bool nqm_corpus_kind_unseen(const char *name);

/* ---- the plan of tests ------------------------------------------------------------------------------------------- */

enum { NQM_CORPUS_MAX_MODELS = 64 };

/** A form of a material: a reference of the list, or a preset, which is used as a test only. */
typedef struct nqm_corpus_form {
    const char *brdf;     /* as in the list */
    const char *path;     /* argument of nqm_brdf_open() */
    nqm_corpus_kind kind; /* kind of test when compared with another form */
} nqm_corpus_form;

/** The BRDF that a test is derived from: the reference, one of its fits, or another form of its material. */
typedef enum nqm_corpus_base { NQM_BASE_REF, NQM_BASE_FIT, NQM_BASE_FORM } nqm_corpus_base;

/** One test of a reference: a base and up to two perturbations of it. */
typedef struct nqm_corpus_test {
    size_t ref; /* within the group */
    nqm_corpus_kind kind;
    nqm_corpus_base base;
    size_t which;             /* index of the model of the corpus, or of the plan's form */
    char perturbation[2][80]; /* "gloss=0.8"; the first is applied first; "": none */
} nqm_corpus_test;

/** The models that encode each reference. */
typedef struct nqm_corpus_models {
    size_t n;
    const char *name[NQM_CORPUS_MAX_MODELS]; /* static storage */
} nqm_corpus_models;

/** Parse nqm_corpus_options.models; the result is in the order of nqm_fit_model(). */
NQM_MUST_CHECK nqm_status nqm_corpus_models_parse(const char *list, nqm_corpus_models *models_ret, nqm_error *err);

/** The tests of one material group. */
typedef struct nqm_corpus_plan {
    size_t group;
    size_t n_refs, n_forms; /* the first n_refs forms are the references of the group */
    nqm_corpus_form *forms;
    size_t n_tests;
    nqm_corpus_test *tests; /* by reference */
} nqm_corpus_plan;

/** Plan a group; a function of the list, the seed and the options. Free with nqm_corpus_plan_free(). */
NQM_MUST_CHECK nqm_status nqm_corpus_plan_make(const nqm_corpus_list *list, size_t group,
                                               const nqm_corpus_models *models, const nqm_corpus_options *options,
                                               nqm_corpus_plan *plan_ret, nqm_error *err);
void nqm_corpus_plan_free(nqm_corpus_plan *plan);
/** Draw n perturbed copies of a reference with n_fits encodings; they cycle through the kinds of this part. tests (n). */
void nqm_corpus_draw_tests(nqm_rng *rng, size_t ref, size_t n_fits, nqm_corpus_part part, size_t n,
                           nqm_corpus_test *tests);

/* ---- making one group --------------------------------------------------------------------------------------------- */

/** Data shared by all groups. */
typedef struct nqm_corpus_context {
    const nqm_corpus_list *list;
    const nqm_corpus_options *options;
    const nqm_directions *directions;
    const nqm_scene *scene;
    nqm_corpus_models models;
    char light_sha256[65];                    /* "" for the built-in sky */
    char shape_sha256[65];                    /* of a mesh file; "" for built-in shapes */
    char encoder_sha256[2][65];               /* of nqm_corpus_encoders; "": not in this build */
    bool (*step)(void *user, size_t n_tests); /* called with the number of finished tests, 0 during fits; true: stop */
    void *step_user;
} nqm_corpus_context;

/** The names of the learned encoders. */
extern const char *const nqm_corpus_encoders[2];

/** A group with its samples and labels. */
typedef struct nqm_corpus_item {
    nqm_corpus_plan plan;
    char *path;       /* its work file; NULL without a checkpoint folder; owned */
    atomic_int state; /* NQM_ITEM_... */
    /* views into the arrays of nqm_corpus; n = n_directions */
    float *ref_rgb;     /* (n_refs, n, 3) */
    uint8_t *ref_used;  /* (n_refs, n) */
    float *test_rgb;    /* (n_tests, n, 3) */
    uint8_t *test_used; /* (n_tests, n) */
    double *delta_e;    /* (n_tests) */
    double *fit_loss;   /* (n_tests) nqm_fit_report.loss of encodings; else 0 */
    char **names;       /* (n_tests) each test as a spec; the strings are owned */
    char **failures;    /* (n_tests) error message of a failed test, else NULL; owned */
} nqm_corpus_item;

enum { NQM_ITEM_OPEN = 0, NQM_ITEM_SKIPPED /* another process has claimed it */, NQM_ITEM_ACTIVE, NQM_ITEM_DONE };

/** Fit, sample and render. The error of a test is stored as its failure; cancellation, lack of memory and unreadable references
 *  are errors of the call. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item,
                                               nqm_error *err);

/** Path of the work file of a group; its name is a hash of everything that determines the result. nqm_free() it. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_path(const nqm_corpus_context *context, const nqm_corpus_item *item,
                                               char **path_ret, nqm_error *err);
/** Load the finished item from item->path; false: no such file, or a damaged one (the item is made again). */
bool nqm_corpus_item_load(size_t n_directions, nqm_corpus_item *item);
NQM_MUST_CHECK nqm_status nqm_corpus_item_save(size_t n_directions, const nqm_corpus_item *item, nqm_error *err);

/** Claim the making of a file at `path` among all processes that share the folder: PATH.claim is locked until it is released or
 *  the process ends. *claim_ret: for nqm_corpus_release(), or -1 if another process holds the claim. */
NQM_MUST_CHECK nqm_status nqm_corpus_claim(const char *path, int *claim_ret, nqm_error *err);
void nqm_corpus_release(const char *path, int claim);

/* ---- a corpus ---------------------------------------------------------------------------------------------------- */

/** A corpus. The items have views into its arrays, which are one block owned by ref_rgb. */
typedef struct nqm_corpus {
    nqm_corpus_context context;
    nqm_corpus_list list;
    nqm_scene *scene;
    size_t n_items, n_refs, n_tests, n_directions;
    nqm_corpus_item *items;
    float *ref_rgb, *test_rgb;
    uint8_t *ref_used, *test_used;
    double *delta_e, *fit_loss;
    char **names, **failures;
} nqm_corpus;

/** Make all items on all threads, together with other processes that share the checkpoint folder. */
NQM_MUST_CHECK nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err);
/** Write the finished corpus and its manifest. Failed tests are removed from the arrays. */
NQM_MUST_CHECK nqm_status nqm_corpus_write(nqm_corpus *corpus, const char *path, nqm_error *err);

/** The manifest as JSON text (nqm_free); NULL: out of memory, or a name is not UTF-8. */
char *nqm_corpus_manifest(const nqm_corpus_context *context, size_t n_items, const nqm_corpus_item *items);

#endif
