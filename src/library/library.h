/* SPDX-License-Identifier: MIT
 *
 * library.h - inside the library: the state of an nqm_library, pictures of members by which those that may look alike are found
 * before they are scored, and scores of pairs with textures.
 */
#ifndef NQM_SRC_LIBRARY_H
#define NQM_SRC_LIBRARY_H

#include "argument/argument.h"
#include "metric/metric.h"
#include "pairs/pairs.h"
#include "texture/texture.h"
#include <nqm/library.h>

/* ---- scores of textures ------------------------------------------------------------------------------------------ */

/** How textures are scored. */
typedef struct nqm_library_terms {
    const nqm_model *model;
    bool exact; /* all texels */
    bool keep_heat, near_only;
    size_t texels_per_pixel; /* 0: 1 */
    nqm_progress_fn progress;
    void (*report)(void *user, nqm_status status, const char *message);
    void *user;
} nqm_library_terms;
/** A texture that stays open for further pairs; zeroed: none. Its name lives as long. */
typedef struct nqm_library_kept {
    const char *name;
    nqm_texture *texture;
} nqm_library_kept;
/** The result of a pair of textures as that of a pair of BRDFs. */
nqm_score_result nqm_library_texture_result(const nqm_texture_result *t);
/** Open an argument as a texture, and report what of it is not used. */
NQM_MUST_CHECK nqm_status nqm_library_open_texture(const nqm_library_terms *terms, nqm_argument *argument,
                                                   nqm_texture **texture_ret, nqm_error *err);
/** Score a pair of textures; result->status is that of the call. heat: receives the Delta-E of the texels if the terms want it;
 *  nqm_free() it. */
NQM_MUST_CHECK nqm_status nqm_library_score_texture(const nqm_library_terms *terms, const nqm_named_pair *pair,
                                                    nqm_library_kept *ref, nqm_texture_result *t,
                                                    nqm_score_result *result, float **heat, nqm_error *err);

/* ---- libraries --------------------------------------------------------------------------------------------------- */

/** The files of a library in the order of their paths. */
typedef struct nqm_library_files {
    size_t n;
    const char **paths; /* (n) */
    nqm_names text;
} nqm_library_files;

struct nqm_library_state {
    const nqm_model *model;
    nqm_score_options score;
    nqm_library_terms terms;
    nqm_ticker ticker;
    nqm_scorer *scorer; /* NULL until it is needed */
    unsigned ignored;
    char *path, *index_path; /* index_path: NULL: none */
    bool is_file;            /* the path is one file */
    char hash[65];           /* of what an index depends on */
    size_t max_n;
    nqm_library_member *members; /* (n) their texts are owned */
    nqm_gallery *gallery;        /* pictures (n); NULL: not yet drawn */
    nqm_map index;               /* file of the pictures; zeroed: the gallery has them */
    unsigned char *block;        /* of the pictures, where the bytes of the file have another order; NULL: none */
    size_t n_pairs;
    nqm_library_pair *pairs; /* (n_pairs) of the last call */
    bool *textured;          /* (n_pairs) in the same block, until they are scored: whether a member is */
};

/** Report `done` of `total`; NQM_ERR_CANCELLED. */
NQM_MUST_CHECK nqm_status nqm_library_step(struct nqm_library_state *s, const char *stage, size_t done, size_t total,
                                           nqm_error *err);
__attribute__((format(printf, 3, 4))) void nqm_library_report(const nqm_library_terms *terms, nqm_status status,
                                                              const char *format, ...);
/** Append a member, whose texts are taken, also on failure; NULL: out of memory. */
NQM_MUST_CHECK nqm_status nqm_library_add(nqm_library *library, char *argument, char *key, bool is_textured,
                                          nqm_error *err);
/** Remove the members whose texts are NULL. */
void nqm_library_compact(nqm_library *library);
/** Free members, pictures and pairs. */
void nqm_library_clear(nqm_library *library);

/** The hash of what an index of the files depends on. */
NQM_MUST_CHECK nqm_status nqm_library_identify(nqm_library *library, const nqm_library_files *files, nqm_error *err);
/** Use members and pictures of the index, if it fits: then there is a gallery. NQM_ERR_ARG: it is another file. */
NQM_MUST_CHECK nqm_status nqm_library_read_index(nqm_library *library, nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_library_write_index(const nqm_library *library, nqm_error *err);

/** Make the scorer. */
NQM_MUST_CHECK nqm_status nqm_library_need_scorer(struct nqm_library_state *s, nqm_error *err);
/** Draw one member as picture `at`: that of a textured one is the mean over positions of its surface. why: of a member without values;
 *  the status is that of the rest. */
NQM_MUST_CHECK nqm_status nqm_library_draw_one(struct nqm_library_state *s, const nqm_library_member *member,
                                               nqm_gallery *gallery, size_t at, nqm_error *why, nqm_error *err);
/** Draw all members, unless they are drawn; those without values leave the library. */
NQM_MUST_CHECK nqm_status nqm_library_draw(nqm_library *library, nqm_error *err);

/** Replace the pairs by n zeroed ones. */
NQM_MUST_CHECK nqm_status nqm_library_begin_pairs(struct nqm_library_state *s, size_t n, nqm_error *err);
/** Set pair `at` to members with these numbers; SIZE_MAX and NULL: none. */
void nqm_library_set_pair(struct nqm_library_state *s, size_t at, const nqm_library_member *ref, size_t ref_number,
                          const nqm_library_member *test, size_t test_number);
/** Score the first n pairs. */
NQM_MUST_CHECK nqm_status nqm_library_score(struct nqm_library_state *s, size_t n, bool near_only, nqm_error *err);
/** The near scores of at most NQM_SCORE_BLOCK pairs, without progress. The scorer is there. */
NQM_MUST_CHECK nqm_status nqm_library_score_few(struct nqm_library_state *s, size_t n, nqm_error *err);
/** The least estimate of pairs that may have a JOD. */
double nqm_library_least_estimate(double jod);

/** Set the properties and maps that changed between the materials of a pair; what has no such properties has none. */
NQM_MUST_CHECK nqm_status nqm_library_compare(nqm_argument_files *files, nqm_library_pair *pair, nqm_error *err);

#endif
