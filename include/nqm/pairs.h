/* SPDX-License-Identifier: MIT
 *
 * nqm/pairs.h - lists of pairs of BRDFs, files of several materials as pairs, and what is said of a score.
 * NQM_EXPERIMENTAL: it may change in any release.
 */
#ifndef NQM_PAIRS_H
#define NQM_PAIRS_H

#include <nqm/metric.h>
#include <nqm/texture.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Pairs of a reference and a test, in an order. Those of the library are immutable; any thread. A caller may fill one: unused members
 *  are 0. */
typedef struct nqm_pairs {
    size_t n;                    /**< pairs */
    const nqm_named_pair *pairs; /**< (n) */
    const char *const *names; /**< (n) names of the tests for people, NULL where there is none; NULL: there are none */
    const size_t *rows; /**< (n) of nqm_pairs_expand(): the given pair that each stands for; NULL: each is itself */
    size_t n_columns;   /**< of a list; else 0 */
    const char *const *columns; /**< (n_columns) names, in the order of the header or of their first appearance */
    const char *sha256;         /**< of the bytes of a list, 64 hex digits; NULL: it is none */
    const char *const
        *left_out; /**< messages of nqm_pairs_expand(), one for each material that has no partner, then NULL */
    struct nqm_pairs_state *state; /**< of the library */
} nqm_pairs;

/**
 * Read a list: CSV with a header that names the columns `reference` and `test` (ASCII case ignored), or JSON Lines with strings
 * "reference" and "test" in each line (doc/files.md). Memory: at most ten times the bytes of the file. Any thread.
 *
 * @param pairs_ret  receives the list; nqm_pairs_free() it
 * @return NQM_ERR_IO, NQM_ERR_FORMAT (the message names line and byte), NQM_ERR_LIMIT (more than 1024 columns), NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_pairs_read(const char *path, nqm_pairs **pairs_ret, nqm_error *err);

/**
 * The pairs that are scored. A test that is a file of several materials stands for a pair with each of them, "FILE:NAME". If the
 * reference is such a file, too, its materials are paired with those of the same names: one that the test lacks is a pair that cannot
 * be opened, and one that only the test has is left out. Other pairs remain. In a list, a test "NAME=BRDF" is the BRDF and its name,
 * and a column `name` has priority. Any thread.
 *
 * @param pairs   must outlive the result. Relative paths begin in the working folder
 * @param ignore  what of refused materials is ignored (<nqm/material.h>), "transmission,opacity"; NULL: nothing
 * @return NQM_ERR_ARG (no such word), NQM_ERR_FORMAT (tests of one reference have one name, or a name has a control character),
 *         NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_pairs_expand(const nqm_pairs *pairs, const char *ignore, nqm_pairs **expanded_ret,
                                                   nqm_error *err);
/** Free; NULL is allowed. */
NQM_API void nqm_pairs_free(nqm_pairs *pairs);

enum { NQM_REMARKS_TEXT = 9000 };

/**
 * What may make a score wrong, in sentences: negative and missing values, BRDFs unlike those of the training, rows of a list that are
 * far from the model's directions, a scale that is missing, what of a file is not used or ignored. Any thread.
 *
 * @param model    that of the score
 * @param invalid  its policy for missing values
 * @param pair     the arguments of the BRDFs; NULL: they have none
 * @param ref      name of the reference in the sentences; NULL: no remarks about it
 * @param test     name of the test
 * @param text     (NQM_REMARKS_TEXT) receives the remarks, each with its NUL, then an empty one
 * @return text
 */
NQM_API const char *nqm_pairs_remarks(const nqm_model *model, nqm_invalid_policy invalid, const nqm_named_pair *pair,
                                      const char *ref, const char *test, const nqm_score_result *result, char *text);

/** What a column is about. */
typedef enum nqm_column_group {
    NQM_COLUMN_SCORE = 0,
    NQM_COLUMN_PARTS, /**< of the pictures, as of a label; the text is "" and numbers are NaN where the model has none */
    NQM_COLUMN_LABEL,      /**< of labels only */
    NQM_COLUMN_SIMILARITY, /**< of scores only */
    NQM_COLUMN_METRIC,
    NQM_COLUMN_TEXTURE,
} nqm_column_group;

typedef enum nqm_column_kind {
    NQM_COLUMN_REAL = 0,
    NQM_COLUMN_WHOLE, /**< a whole number */
    NQM_COLUMN_FLAG,  /**< 0 or 1 */
    NQM_COLUMN_TEXT,
} nqm_column_kind;

/** A number or a text of a score, as every output names it. Strings have static storage. */
typedef struct nqm_column {
    const char *name;   /**< the heading of CSV, the key in Python; NULL: there is no such column */
    const char *member; /**< the member in JSON, "shift_itp.0": the first of a list */
    const char *object; /**< the object that has the member: "parts", "metrics", "texture"; "": the result itself */
    const char *about;  /**< one line */
    nqm_column_group group;
    nqm_column_kind kind;
    nqm_metric metric;         /**< of NQM_COLUMN_METRIC */
    int digits;                /**< after the point, for people; below 0: significant ones */
    double number;             /**< NaN: none */
    char text[NQM_LABEL_TEXT]; /**< of a text */
} nqm_column;

/**
 * The table of what a score consists of, in the order of the columns of CSV: the score and its verdict ("visible", "between visible and
 * very different", "identical"), parts, metrics, textures. doc/reference-cli.md lists it. Any thread.
 *
 * @param i        from 0; the first without a name ends the table
 * @param score    the result whose values are wanted; of a label one with these parts; NULL: none, only facts about the columns
 * @param texture  the same for those of textures
 */
NQM_API nqm_column nqm_score_column(size_t i, const nqm_score_result *score, const nqm_texture_result *texture);

#ifdef __cplusplus
}
#endif
#endif
