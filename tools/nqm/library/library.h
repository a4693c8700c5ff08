/* SPDX-License-Identifier: MIT
 *
 * library.h - many materials at once, for `nqm diff`, `nqm dedup` and `nqm nearest`: the materials of files and
 * folders, and a picture of each, by which those that may look alike are found before they are scored.
 */
#ifndef NQM_TOOL_LIBRARY_H
#define NQM_TOOL_LIBRARY_H

#include "nqm/score/score.h"

/** A material, or a BRDF file. */
typedef struct member {
    char *argument; /* of nqm_brdf_open() */
    char *key;      /* its name in the library: "gold", or in a folder "metals/a.gltf:gold" */
    bool is_textured;
    bool is_left_out; /* once it is sampled: it has no values */
} member;

typedef struct library {
    const char *path; /* the argument; of several, how many */
    size_t n, max_n;
    member *members;      /* (n) in the order of the paths, then of the file */
    size_t n_failed;      /* members that were left out because they have no values */
    nqm_gallery *gallery; /* of draw_library() */
    nqm_map index;        /* file of the pictures; zeroed: the gallery has them */
    unsigned char *block; /* of the pictures, where the bytes of the file have another order; NULL: none */
} library;

/** A member for an argument that is none of a file or folder. */
member member_of(const char *argument);
/** Append the materials of a file, or of all files of a folder and its folders; "/dev/null" has none. Stops when a file
 *  cannot be read, and when there is none in a folder. */
void list_library(const char *path, library *to);
/** Draw one member as picture `at`: that of a textured one is the mean over positions of its surface. err: why it has no values. */
void draw_member(const member *m, const nqm_model *model, nqm_scorer *scorer, nqm_gallery *gallery, size_t at,
                 nqm_error *err);
/** List the members of n files and folders, sample them and draw their pictures, with progress. Those without values are left out and
 *  reported. index: a file that keeps names and pictures, and is written unless it fits the files;
 *  NULL: none. */
void draw_library(size_t n, const char *const *where, const nqm_model *model, nqm_scorer *scorer, const char *index,
                  library *to);
void free_library(library *of);
/** The near score of a pair with a textured member; NaN: there is none. */
double score_textured(const nqm_named_pair *pair, const nqm_model *with);

/** The properties and maps that changed between two materials: [{property, old, new}], a map as text; null: the file has no value, so that
 *  it is the default of the model. What has no such properties has an empty list. */
json_t *list_changes(const nqm_named_pair *pair);
/** A value of such a list as text. */
void print_value(const json_t *value, FILE *to);

/** A pair of members, and its estimated JOD. */
typedef struct near_pair {
    size_t a, b;
    float jod;
} near_pair;
/** Pairs a < b that may have this JOD. *pairs: free(). Returns how many. */
size_t find_near_pairs(const library *of, double jod, near_pair **pairs);
/** The least estimate of pairs that may have a JOD. */
double least_estimate(double jod);

/** Replace the rows of a run by n whose `pair` and `name` are to be set before make_scores(). The texts must outlive it. */
void begin_rows(score_run *run, size_t n);

#endif
