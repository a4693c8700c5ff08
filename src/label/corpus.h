/* SPDX-License-Identifier: MIT
 *
 * corpus.h - the parts of making a corpus: the list of references, the plan of tests for each, the work on one
 * reference, and the manifest.
 */
#ifndef NQM_SRC_LABEL_CORPUS_H
#define NQM_SRC_LABEL_CORPUS_H

#include "base/base.h"
#include "io/io.h"
#include <nqm/fit.h>
#include <nqm/label.h>
#include <stdatomic.h>

/* ---- references -------------------------------------------------------------------------------------------------- */

typedef struct nqm_corpus_ref {
    const char *name;   /* unique in the list */
    const char *brdf;   /* as the list has it */
    const char *source; /* where it comes from: "rgl", "nbrdf", "nps", "sgd", or anything else */
    char *path;         /* what nqm_brdf_open() takes; owned */
    size_t group;
    char file_sha256[65]; /* of the file behind it (a decoder and its latents: of both); "" for specs and presets */
} nqm_corpus_ref;

typedef struct nqm_corpus_group {
    const char *name;
    nqm_split split;
    size_t first_ref, n_refs; /* its references in the list */
} nqm_corpus_group;

/** A material list, whole; strings are lent by its CSV. */
typedef struct nqm_corpus_list {
    nqm_csv *csv;
    size_t n_refs, n_groups;
    nqm_corpus_ref *refs;     /* (n_refs) group by group, else in the order of the list */
    nqm_corpus_group *groups; /* (n_groups) in the order of their first reference */
} nqm_corpus_list;

/** Read a material list. Refuses names given twice and a group in two splits. `root`: where relative paths start; NULL:
 * the folder of the list. */
NQM_MUST_CHECK nqm_status nqm_corpus_list_load(const char *materials_csv, const char *root, nqm_corpus_list *list_ret,
                                               nqm_error *err);
void nqm_corpus_list_free(nqm_corpus_list *list);
/** SHA-256 of a file's bytes, or of those of two files one behind the other; path_more: NULL for one. */
NQM_MUST_CHECK nqm_status nqm_corpus_hash_file(const char *path, const char *path_more, char hex[65], nqm_error *err);
/** true when the group belongs to the part of the corpus that is being made. */
bool nqm_corpus_in_part(const nqm_corpus_group *group, nqm_corpus_part part);
/** "train", "validation" or "test" */
const char *nqm_corpus_split_name(nqm_split split);

/* ---- kinds of test ----------------------------------------------------------------------------------------------- */

/** What kinds of test have in common; nqm_dataset_kind_family() says it of a dataset. */
typedef enum nqm_corpus_family {
    NQM_FAMILY_ENCODING = 0, /* the reference fitted or encoded by this program; a kind is a model of nqm_fit() */
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

/** The names of the perturbations, in a fixed order; NULL for i behind the last. */
const char *nqm_corpus_perturbation(size_t i);
/** true for perturbations that only the test part holds, so that judging can ask for kinds never trained on. */
bool nqm_corpus_kind_unseen(const char *name);

/* ---- the plan of tests ------------------------------------------------------------------------------------------- */

enum { NQM_CORPUS_MAX_MODELS = 64 };

/** A form of a material: a reference of the list, or a preset that is a test only. */
typedef struct nqm_corpus_form {
    const char *brdf;     /* as listed */
    const char *path;     /* as opened */
    nqm_corpus_kind kind; /* as a test */
} nqm_corpus_form;

/** What a test starts from: the reference, one of its fits, or another form of its material. */
typedef enum nqm_corpus_base { NQM_BASE_REF, NQM_BASE_FIT, NQM_BASE_FORM } nqm_corpus_base;

/** One test of a reference: a base and up to two perturbations of it. */
typedef struct nqm_corpus_test {
    size_t ref; /* within the group */
    nqm_corpus_kind kind;
    nqm_corpus_base base;
    size_t which;             /* of the models of the corpus, or of the plan's forms */
    char perturbation[2][80]; /* "gloss=0.8"; the first is applied first; "" for none */
} nqm_corpus_test;

/** The models that encode each reference. */
typedef struct nqm_corpus_models {
    size_t n;
    const char *name[NQM_CORPUS_MAX_MODELS]; /* static storage */
} nqm_corpus_models;

/** As nqm_corpus_options.models; each once, in the order of nqm_fit_model(). */
NQM_MUST_CHECK nqm_status nqm_corpus_models_parse(const char *list, nqm_corpus_models *models_ret, nqm_error *err);

/** All that is to be done for one material group. */
typedef struct nqm_corpus_plan {
    size_t group;
    size_t n_refs, n_forms; /* the first n_refs forms are the references of the group */
    nqm_corpus_form *forms;
    size_t n_tests;
    nqm_corpus_test *tests; /* by reference */
} nqm_corpus_plan;

/** Plan a group: depends on the list, the seed and the options only. Free with nqm_corpus_plan_free(). */
NQM_MUST_CHECK nqm_status nqm_corpus_plan_make(const nqm_corpus_list *list, size_t group,
                                               const nqm_corpus_models *models, const nqm_corpus_options *options,
                                               nqm_corpus_plan *plan_ret, nqm_error *err);
void nqm_corpus_plan_free(nqm_corpus_plan *plan);
/** n perturbed copies of a reference, of which there are n_fits encodings, that go through the kinds of this part in
 *  turn; tests (n). */
void nqm_corpus_draw_tests(nqm_rng *rng, size_t ref, size_t n_fits, nqm_corpus_part part, size_t n,
                           nqm_corpus_test *tests);

/* ---- the work on one group --------------------------------------------------------------------------------------- */

/** What all groups share. */
typedef struct nqm_corpus_context {
    const nqm_corpus_list *list;
    const nqm_corpus_options *options;
    const nqm_directions *directions;
    const nqm_scene *scene;
    nqm_corpus_models models;
    char light_sha256[65];                    /* "" for the built-in sky */
    char shape_sha256[65];                    /* of a mesh file; "" for built-in shapes */
    char encoder_sha256[2][65];               /* of nqm_corpus_encoders; "" where this build has none */
    bool (*step)(void *user, size_t n_tests); /* called for finished tests and, with 0, now and then; true: stop */
    void *step_user;
} nqm_corpus_context;

/** The names of what learned encodings lean on. */
extern const char *const nqm_corpus_encoders[2];

/** A group, sampled and labelled. */
typedef struct nqm_corpus_item {
    nqm_corpus_plan plan;
    char *path;       /* its work file; NULL without a folder for them; owned */
    atomic_int state; /* NQM_ITEM_... */
    /* Views into the arrays of the dataset: n = n_directions */
    float *ref_rgb;     /* (n_refs, n, 3) */
    uint8_t *ref_used;  /* (n_refs, n) */
    float *test_rgb;    /* (n_tests, n, 3) */
    uint8_t *test_used; /* (n_tests, n) */
    double *delta_e;    /* (n_tests) */
    double *fit_loss;   /* (n_tests) nqm_fit_report.loss of own fits; else 0 */
    char **names;       /* (n_tests) each test as a spec; the strings are owned */
    char **failures;    /* (n_tests) why there is no such test; NULL where there is one; owned */
} nqm_corpus_item;

enum { NQM_ITEM_OPEN = 0, NQM_ITEM_PASSED_BY /* another process has claimed it */, NQM_ITEM_IN_HAND, NQM_ITEM_DONE };

/** Fit, sample, render. A test that cannot be made is kept as a failure; only being cancelled, out of memory and
 *  references that cannot be read end the work. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item,
                                               nqm_error *err);

/** The work file of a group: all that its results depend on is hashed into its name. Free the path with nqm_free(). */
NQM_MUST_CHECK nqm_status nqm_corpus_item_path(const nqm_corpus_context *context, const nqm_corpus_item *item,
                                               char **path_ret, nqm_error *err);
/** true when item->path holds the finished item; false when there is none or it is damaged (it is then made again). */
bool nqm_corpus_item_load(size_t n_directions, nqm_corpus_item *item);
NQM_MUST_CHECK nqm_status nqm_corpus_item_save(size_t n_directions, const nqm_corpus_item *item, nqm_error *err);

/** Claim the work on a file that is to be made at `path`, among all processes that can see it: PATH.claim is locked until
 *  it is released or the process ends, however it ends. *claim_ret: for nqm_corpus_release(), or -1 when another has
 *  it. */
NQM_MUST_CHECK nqm_status nqm_corpus_claim(const char *path, int *claim_ret, nqm_error *err);
void nqm_corpus_release(const char *path, int claim);

/** `brdf` as a table; see corpus_forms.c. */
NQM_MUST_CHECK nqm_status nqm_corpus_tabulate(const nqm_brdf *brdf, nqm_brdf **table_ret, nqm_error *err);
/** `brdf` read in half-vector coordinates with phi_d in [0, pi) only, so that it is reciprocal. It is owned by the
 * result (freed with it, also when this fails) or only lent to it. */
NQM_MUST_CHECK nqm_status nqm_corpus_fold(nqm_brdf *brdf, bool owned, nqm_brdf **folded_ret, nqm_error *err);

/* ---- a corpus ---------------------------------------------------------------------------------------------------- */

/** A corpus in the making. The groups' items are views into its arrays. */
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

/** Make all items, on all threads and together with other processes that share the folder of work files. */
NQM_MUST_CHECK nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err);
/** Write the finished corpus with its manifest. Failed tests are left out: the arrays are changed. */
NQM_MUST_CHECK nqm_status nqm_corpus_write(nqm_corpus *corpus, const char *path, nqm_error *err);

/** How the corpus was made, as JSON text (nqm_free); NULL when out of memory or a name is not UTF-8. */
char *nqm_corpus_manifest(const nqm_corpus_context *context, size_t n_items, const nqm_corpus_item *items);

#endif
