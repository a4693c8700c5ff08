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

/* ---- references -------------------------------------------------------------------------------------------------- */

typedef struct nqm_corpus_ref {
    const char *name;   /* unique in the list */
    const char *brdf;   /* as the list has it */
    const char *source; /* where it comes from: "rgl", "nbrdf", "nps", "sgd", or anything else */
    char *path;         /* what nqm_brdf_open() takes; owned */
    size_t group;
    char file_sha256[65]; /* of the file behind it; "" for specs and presets */
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
/** SHA-256 of a file's bytes. */
NQM_MUST_CHECK nqm_status nqm_corpus_hash_file(const char *path, char hex[65], nqm_error *err);
/** true when the group belongs to the part of the corpus that is being made. */
bool nqm_corpus_in_part(const nqm_corpus_group *group, nqm_corpus_part part);
/** "train", "validation" or "test" */
const char *nqm_corpus_split_name(nqm_split split);

/* ---- the plan of tests ------------------------------------------------------------------------------------------- */

/** Kinds of test; the dataset holds their names. */
typedef enum nqm_corpus_kind {
    NQM_KIND_WARD = 0, /* own fit of Ward's model */
    NQM_KIND_GGX,      /* own fit of GGX */
    NQM_KIND_MEASURED, /* another form of the same material: its measurement, ... */
    NQM_KIND_NBRDF,    /* its published network, ... */
    NQM_KIND_NPS,      /* its neural-process reconstruction, ... */
    NQM_KIND_PRESET,   /* its published parameters */
    NQM_KIND_GLOSS,    /* one perturbation of the reference each, from here ... */
    NQM_KIND_TINT,
    NQM_KIND_SCALE,
    NQM_KIND_FRESNEL,
    NQM_KIND_SMOOTH,
    NQM_KIND_MIX,
    NQM_KIND_NOISE,
    NQM_KIND_PEAK,
    NQM_KIND_DESATURATE,
    NQM_KIND_QUANTISE,
    NQM_KIND_SHIFT,    /* ... to here */
    NQM_KIND_COMPOSED, /* two of them, one after the other */
    NQM_KIND_REFIT,    /* a perturbed fit */
    NQM_KIND_COUNT
} nqm_corpus_kind;

const char *nqm_corpus_kind_name(nqm_corpus_kind kind);
/** true for kinds that only the test part holds, so that judging can ask for kinds never trained on. */
bool nqm_corpus_kind_unseen(nqm_corpus_kind kind);

/** The fits that every reference gets. */
typedef struct nqm_corpus_fit {
    const char *model;
    nqm_fit_loss loss;
    nqm_corpus_kind kind;
} nqm_corpus_fit;
enum { NQM_CORPUS_N_FITS = 4 };
extern const nqm_corpus_fit nqm_corpus_fits[NQM_CORPUS_N_FITS];

/** A form of a material: a reference of the list, or a preset that is a test only. */
typedef struct nqm_corpus_form {
    const char *brdf;     /* as listed */
    const char *path;     /* as opened */
    nqm_corpus_kind kind; /* as a test */
} nqm_corpus_form;
enum { NQM_CORPUS_MAX_PRESETS = 2 };

/** What a test starts from: the reference, one of its fits, or another form of its material. */
typedef enum nqm_corpus_base { NQM_BASE_REF, NQM_BASE_FIT, NQM_BASE_FORM } nqm_corpus_base;

/** One test of a reference: a base and up to two perturbations of it. */
typedef struct nqm_corpus_test {
    size_t ref; /* within the group */
    nqm_corpus_kind kind;
    nqm_corpus_base base;
    size_t which;             /* of nqm_corpus_fits, or of the plan's forms */
    char perturbation[2][80]; /* "gloss=0.8"; the first is applied first; "" for none */
} nqm_corpus_test;

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
                                               const nqm_corpus_options *options, nqm_corpus_plan *plan_ret,
                                               nqm_error *err);
void nqm_corpus_plan_free(nqm_corpus_plan *plan);

/* ---- the work on one group --------------------------------------------------------------------------------------- */

/** What all groups share. */
typedef struct nqm_corpus_context {
    const nqm_corpus_list *list;
    const nqm_corpus_options *options;
    const nqm_directions *directions;
    const nqm_scene *scene;
    nqm_scene_options scene_options;
    char light_sha256[65];    /* "" for the built-in sky */
    bool (*step)(void *user); /* called after each test; true: stop */
    void *step_user;
} nqm_corpus_context;

/** A group, sampled and labelled. */
typedef struct nqm_corpus_item {
    nqm_corpus_plan plan;
    /* Views into the arrays of the dataset: n = n_directions */
    float *ref_rgb;     /* (n_refs, n, 3) */
    uint8_t *ref_used;  /* (n_refs, n) */
    float *test_rgb;    /* (n_tests, n, 3) */
    uint8_t *test_used; /* (n_tests, n) */
    double *delta_e;    /* (n_tests) */
    char **names;       /* (n_tests) each test as a spec; the strings are owned */
} nqm_corpus_item;

/** Fit, sample, render. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item,
                                               nqm_error *err);

/** The work file of a group: all that its results depend on is hashed into its name. Free the path with nqm_free(). */
NQM_MUST_CHECK nqm_status nqm_corpus_item_path(const nqm_corpus_context *context, const nqm_corpus_item *item,
                                               char **path_ret, nqm_error *err);
/** true when `path` holds the finished item; false when there is none or it is damaged (it is then made again). */
bool nqm_corpus_item_load(const char *path, size_t n_directions, nqm_corpus_item *item);
NQM_MUST_CHECK nqm_status nqm_corpus_item_save(const char *path, size_t n_directions, const nqm_corpus_item *item,
                                               nqm_error *err);

/** `brdf` as a table; see corpus_forms.c. */
NQM_MUST_CHECK nqm_status nqm_corpus_tabulate(const nqm_brdf *brdf, nqm_brdf **table_ret, nqm_error *err);
/** `brdf` read in half-vector coordinates with phi_d in [0, pi) only, so that it is reciprocal. It is owned by the
 * result (freed with it, also when this fails) or only lent to it. */
NQM_MUST_CHECK nqm_status nqm_corpus_fold(nqm_brdf *brdf, bool owned, nqm_brdf **folded_ret, nqm_error *err);

/* ---- the manifest ------------------------------------------------------------------------------------------------ */

/** How the corpus was made, as JSON text (nqm_free); NULL when out of memory or a name is not UTF-8. */
char *nqm_corpus_manifest(const nqm_corpus_context *context, size_t n_items, const nqm_corpus_item *items);

#endif
