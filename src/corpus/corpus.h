/* SPDX-License-Identifier: MIT
 *
 * corpus.h - the parts of making a corpus: the list of references, the plan of tests for each, the making of one material
 * group, and the manifest.
 */
#ifndef NQM_SRC_CORPUS_CORPUS_H
#define NQM_SRC_CORPUS_CORPUS_H

#include "base/options.h"
#include "io/io.h"
#include "render/render.h"
#include <nqm/corpus.h>
#include <nqm/fit.h>
#include <stdatomic.h>

extern const nqm_option_table nqm_corpus_option_table;

/* ---- references -------------------------------------------------------------------------------------------------- */

typedef struct nqm_corpus_ref {
    const char *name;   /* unique in the list */
    const char *brdf;   /* as in the list */
    const char *source; /* origin of the material: "rgl", "nbrdf", "nps", "sgd", or any other word */
    char *path;         /* argument of nqm_brdf_open(); owned */
    size_t group;
    char file_sha256[65]; /* SHA-256 of its file, and of latents or a measured file; "" for specs and presets */
} nqm_corpus_ref;

typedef struct nqm_corpus_group {
    const char *name;
    nqm_split split;
    size_t first_ref, n_refs; /* range of its references in the list */
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
    NQM_FAMILY_VARIANT,      /* a changed spec ("roughness", "key"), "translated", "folded", "overfit": variants.c */
    NQM_FAMILY_FAR,          /* a BRDF that really differs: "other-same", "random-ggx", "path-ward", "white" */
    NQM_FAMILY_ROUNDING,     /* the reference with rounded values: "float16" */
    NQM_FAMILY_COUNT
} nqm_corpus_family;

const char *nqm_corpus_family_name(nqm_corpus_family family);

typedef struct nqm_corpus_kind {
    char name[48];
    nqm_corpus_family family;
} nqm_corpus_kind;

/** The names of the perturbations, and of the far kinds, in a fixed order; NULL after the last. */
const char *nqm_corpus_perturbation(size_t i);
const char *nqm_corpus_far_kind(size_t i);
/** Whether a perturbation or a far kind is in the test part only, for judging on kinds that are not in training. */
bool nqm_corpus_kind_unseen(const char *name);
/** The same for far kinds only. */
bool nqm_corpus_far_unseen(const char *name);

/* ---- the plan of tests ------------------------------------------------------------------------------------------- */

enum { NQM_CORPUS_MAX_MODELS = 64 };

/** A form of a material: a reference of the list, or a preset, which is used as a test only. */
typedef struct nqm_corpus_form {
    const char *brdf;     /* as in the list */
    const char *path;     /* argument of nqm_brdf_open() */
    nqm_corpus_kind kind; /* kind of test when compared with another form */
} nqm_corpus_form;

/** The BRDF that a test is, or is derived from. */
typedef enum nqm_corpus_base {
    NQM_BASE_REF,     /* the reference */
    NQM_BASE_FIT,     /* one of its fits */
    NQM_BASE_FORM,    /* another form of its material */
    NQM_BASE_OTHER,   /* another material */
    NQM_BASE_BETWEEN, /* between the reference and another material; this and the following are made for their test */
    NQM_BASE_SPEC,    /* a BRDF that does not depend on the reference */
    NQM_BASE_PATH,    /* a point on the path of an optimiser that fits an analytic model to the reference */
    NQM_BASE_TRANSLATED, /* a fit of a shading model to the reference */
    NQM_BASE_TABLE,      /* the reference as a reciprocal table, as `nqm convert` makes it */
    NQM_BASE_OVERFIT     /* a network that was fitted to few directions of the reference */
} nqm_corpus_base;

/** A point on the path of an optimiser: arguments of nqm_fit_path(). Of TRANSLATED model and seed, of OVERFIT seed and number of
 *  directions. */
typedef struct nqm_corpus_path {
    const char *model; /* static storage; NULL: none */
    nqm_fit_loss loss;
    size_t n_steps; /* OVERFIT: directions */
    uint64_t seed;
} nqm_corpus_path;

/** One test of a reference: a base and up to two perturbations of it. */
typedef struct nqm_corpus_test {
    size_t ref; /* within the group */
    nqm_corpus_kind kind;
    nqm_corpus_base base;
    /* Index of the model of the corpus, of the plan's form, or of a reference of the list; of OVERFIT 1: the directions are among
     * those of the corpus. */
    size_t which;
    char perturbation[2][80]; /* "gloss=0.8"; the first is applied first; "": none */
    char between[80];         /* BETWEEN: the settings of the spec, "t=0.3" */
    char *spec;               /* SPEC: the argument of nqm_brdf_open(), owned by the plan; otherwise NULL */
    nqm_corpus_path path;     /* PATH, TRANSLATED, OVERFIT */
} nqm_corpus_test;

/** Whether `which` is another material: a reference of the list. */
static inline bool nqm_corpus_uses_other(const nqm_corpus_test *test) {
    return test->base == NQM_BASE_OTHER || test->base == NQM_BASE_BETWEEN;
}

/** The models that encode each reference. */
typedef struct nqm_corpus_models {
    size_t n;
    const char *name[NQM_CORPUS_MAX_MODELS]; /* static storage */
} nqm_corpus_models;

/** Parse nqm_corpus_options.models (NULL, and a list with "all": each); the result is in the order of nqm_fit_model(). */
NQM_MUST_CHECK nqm_status nqm_corpus_models_parse(const char *list, nqm_corpus_models *models_ret, nqm_error *err);

/** The tests of one material group. */
typedef struct nqm_corpus_plan {
    size_t group;
    size_t n_refs, n_forms; /* the first n_refs forms are the references of the group */
    nqm_corpus_form *forms;
    size_t n_tests;
    nqm_corpus_test *tests; /* sorted by reference */
} nqm_corpus_plan;

/** Plan a group; a function of the list, the seed and the options. Free with nqm_corpus_plan_free(). */
NQM_MUST_CHECK nqm_status nqm_corpus_plan_make(const nqm_corpus_list *list, size_t group,
                                               const nqm_corpus_models *models, const nqm_corpus_options *options,
                                               nqm_corpus_plan *plan_ret, nqm_error *err);
void nqm_corpus_plan_free(nqm_corpus_plan *plan);
/** Draw n perturbed copies of a reference with n_fits encodings; they cycle through the kinds of this part. tests (n). */
void nqm_corpus_draw_tests(nqm_rng *rng, size_t ref, size_t n_fits, nqm_corpus_part part, size_t n,
                           nqm_corpus_test *tests);
/** Draw n roundings of a reference. tests (n). */
void nqm_corpus_draw_roundings(nqm_rng *rng, size_t ref, size_t n, nqm_corpus_test *tests);

/** Draw up to n variants of a reference; changed specs only if it has a spec. path: as for nqm_brdf_open(). tests (n): `ref` is
 *  not set; the specs are owned by the caller, also after a failure. */
NQM_MUST_CHECK nqm_status nqm_corpus_draw_variants(nqm_rng *rng, const char *path, size_t n, size_t *n_drawn,
                                                   nqm_corpus_test *tests, nqm_error *err);
/** The spec with another value of one key, of a lobe's width or of any other, that changes the BRDF; nqm_free() it. NULL: it
 *  has no such key. */
NQM_MUST_CHECK nqm_status nqm_corpus_change_spec(nqm_rng *rng, const char *spec, bool of_width, char **spec_ret,
                                                 nqm_error *err);

/** Draw n far tests of a reference of the list; they cycle through the kinds of this part. Other materials are of the same
 *  split. tests (n): `ref` is not set; the specs are owned by the caller, also after a failure. */
NQM_MUST_CHECK nqm_status nqm_corpus_draw_far(const nqm_corpus_list *list, size_t list_ref, uint64_t seed,
                                              nqm_corpus_part part, size_t n, nqm_corpus_test *tests, nqm_error *err);
/** The random stream of a name; it does not depend on the other materials in the list. */
uint64_t nqm_corpus_stream(const char *name);
/** An analytic model with random parameters, as a spec; nqm_free() it. */
NQM_MUST_CHECK nqm_status nqm_corpus_random_spec(nqm_rng *rng, const char *model, char **spec_ret, nqm_error *err);

/** Far tests that are drawn and rendered so that n_far are kept. */
static inline size_t nqm_corpus_candidates(size_t n_far) {
    return n_far + (n_far + 1) / 2;
}
/** The far tests of a reference that are kept. */
static inline size_t nqm_corpus_far_kept(const nqm_corpus_options *options) {
    return (options->n_far + options->every - 1) / options->every;
}
/** Mark n_kept of n JODs (n) such that they are spread as evenly as possible; NaN is never marked. kept (n). */
NQM_MUST_CHECK nqm_status nqm_corpus_spread(size_t n, const double *jod, size_t n_kept, uint8_t *kept, nqm_error *err);

/* ---- references as the corpus uses them -------------------------------------------------------------------------- */

/** A BRDF with its samples and its picture; rgb owns the block of the arrays. n = n_directions. */
typedef struct nqm_corpus_view {
    nqm_brdf *brdf;
    float *rgb;      /* (n, 3) */
    uint8_t *used;   /* (n) */
    double *picture; /* (3, n_points, 3) of nqm_scene_render_halves() */
} nqm_corpus_view;

typedef struct nqm_corpus_context nqm_corpus_context;

NQM_MUST_CHECK nqm_status nqm_corpus_view_alloc(const nqm_corpus_context *context, nqm_corpus_view *view,
                                                nqm_error *err);
void nqm_corpus_view_free(nqm_corpus_view *view);
/** Sample and render view->brdf. */
NQM_MUST_CHECK nqm_status nqm_corpus_view_fill(const nqm_corpus_context *context, nqm_corpus_view *view,
                                               nqm_error *err);
/** Open a form as the corpus uses it, as reference, test and base of perturbations. */
NQM_MUST_CHECK nqm_status nqm_corpus_open(const nqm_corpus_context *context, const char *path, nqm_brdf **brdf_ret,
                                          nqm_error *err);

/** The views of all references of a list, each made when it is first needed. */
typedef struct nqm_corpus_cache nqm_corpus_cache;
NQM_MUST_CHECK nqm_status nqm_corpus_cache_create(size_t n_refs, nqm_corpus_cache **cache_ret, nqm_error *err);
void nqm_corpus_cache_free(nqm_corpus_cache *cache);
/** The view of a reference of the list; owned by the context's cache. Any thread. */
NQM_MUST_CHECK nqm_status nqm_corpus_cached(const nqm_corpus_context *context, size_t list_ref,
                                            const nqm_corpus_view **view_ret, nqm_error *err);

/* ---- making one group --------------------------------------------------------------------------------------------- */

/** Data shared by all groups. */
struct nqm_corpus_context {
    const nqm_corpus_list *list;
    const nqm_corpus_options *options;
    const nqm_directions *directions;
    const nqm_scene *scene;
    nqm_corpus_cache *cache;
    nqm_corpus_models models;
    char light_sha256[65];      /* "" for built-in lights */
    char shape_sha256[65];      /* SHA-256 of a mesh file; "" for built-in shapes */
    char encoder_sha256[2][65]; /* SHA-256 of nqm_corpus_encoders; "": not in this build */
    bool (*step)(void *user,
                 size_t n_units); /* called with finished units of work, 0 within one; any thread; true: stop */
    void *step_user;
};

/** Units of work, for the progress: a test is one, and an encoding takes about as long as this many tests. */
enum { NQM_CORPUS_FIT_UNITS = 8 };

/** The names of the learned encoders. */
extern const char *const nqm_corpus_encoders[2];

/** A group with its samples and labels. */
typedef struct nqm_corpus_item {
    nqm_corpus_plan plan;
    char *path; /* path of its work file; NULL without a checkpoint folder; owned */
    bool is_done;
    /* views into the arrays of nqm_corpus; n = n_directions */
    float *ref_rgb;     /* (n_refs, n, 3) */
    uint8_t *ref_used;  /* (n_refs, n) */
    float *test_rgb;    /* (n_tests, n, 3) */
    uint8_t *test_used; /* (n_tests, n) */
    nqm_label *label;   /* (n_tests) */
    double *fit_loss;   /* (n_tests) nqm_fit_report.loss of encodings; else 0 */
    uint8_t *kept;      /* (n_tests) 0: a far test that was drawn but not selected, or that failed */
    char **names;       /* (n_tests) each test as a spec; the strings are owned */
    char **failures;    /* (n_tests) error message of a failed test, else NULL; owned */
} nqm_corpus_item;

/** Whether a test is a pair of the corpus. */
static inline bool nqm_corpus_is_pair(const nqm_corpus_item *item, size_t test) {
    return item->kept[test] && !item->failures[test];
}

/** Fit, sample and render. The error of a test is stored as its failure; cancellation, lack of memory and unreadable references
 *  are errors of the call. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_make(const nqm_corpus_context *context, nqm_corpus_item *item,
                                               nqm_error *err);

/** An encoding of a reference. */
typedef struct nqm_corpus_fit {
    nqm_corpus_view view;
    bool is_viewed; /* the view is filled; that of a loaded fit only when a test needs it */
    nqm_fit_report report;
    nqm_error fault; /* status NQM_OK: the encoding succeeded */
} nqm_corpus_fit;

/** Save the fit of a model to a reference of an unfinished group, in the folder item->path + ".fits"; without item->path does
 *  nothing. */
NQM_MUST_CHECK nqm_status nqm_corpus_fit_save(const nqm_corpus_item *item, size_t ref, const char *model,
                                              const nqm_corpus_fit *fit, nqm_error *err);
/** Load the BRDF, spec, loss and fault of a saved fit; false: there is none, or a damaged one. */
bool nqm_corpus_fit_load(const nqm_corpus_item *item, size_t ref, const char *model, nqm_corpus_fit *fit);
/** Remove the saved fits of a group. */
void nqm_corpus_fits_remove(const nqm_corpus_item *item);

/** Path of the work file of a group; its name is a hash of everything that determines the result. nqm_free() it. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_path(const nqm_corpus_context *context, const nqm_corpus_item *item,
                                               char **path_ret, nqm_error *err);
/** Load the finished item from item->path; false: no such file, or a damaged one (the item is made again). */
bool nqm_corpus_item_load(size_t n_directions, nqm_corpus_item *item);
/** Save the first n_done tests: to item->path if they are all, otherwise to the file of an unfinished group, item->path +
 *  ".progress", which the finished one replaces. */
NQM_MUST_CHECK nqm_status nqm_corpus_item_save(size_t n_directions, const nqm_corpus_item *item, size_t n_done,
                                               nqm_error *err);
/** Load the tests of an unfinished group; returns their number, 0: none. */
size_t nqm_corpus_item_resume(size_t n_directions, nqm_corpus_item *item);

/* ---- a corpus ---------------------------------------------------------------------------------------------------- */

/** A corpus. The items have views into its arrays, which are one block owned by ref_rgb. */
typedef struct nqm_corpus {
    nqm_corpus_context context;
    nqm_corpus_list list;
    nqm_scene *scene;
    size_t n_items, n_refs, n_tests, n_directions;
    nqm_corpus_item *items;
    float *ref_rgb, *test_rgb;
    uint8_t *ref_used, *test_used, *kept;
    nqm_label *label;
    double *fit_loss;
    char **names, **failures;
} nqm_corpus;

/** Make all items on all threads, together with other processes that share the checkpoint folder. */
NQM_MUST_CHECK nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err);
/** Write the finished corpus and its manifest. Tests that are no pairs are removed from the arrays. */
NQM_MUST_CHECK nqm_status nqm_corpus_write(nqm_corpus *corpus, const char *path, nqm_error *err);

/** Open the file of the manifest, which is written next to a dataset: `dataset_path`.json. */
NQM_MUST_CHECK nqm_status nqm_corpus_manifest_open(const char *dataset_path, nqm_outfile *out_ret, nqm_error *err);
/** The manifest as JSON text (nqm_free); NULL: out of memory, or a name is not UTF-8. */
char *nqm_corpus_manifest(const nqm_corpus_context *context, size_t n_items, const nqm_corpus_item *items);

#endif
