/* SPDX-License-Identifier: MIT
 *
 * nqm/batch.h - lists of pairs that are named by files, specs and presets, and their scores: each BRDF is opened and
 * sampled once for all pairs that lie near each other in the list.
 */
#ifndef NQM_BATCH_H
#define NQM_BATCH_H

#include <nqm/metric.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Two BRDFs, as nqm_brdf_open() takes them. */
typedef struct nqm_named_pair {
    const char *ref, *test;
} nqm_named_pair;

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/** A list of pairs with any further columns. Immutable. */
typedef struct nqm_pair_list nqm_pair_list;

/** What a row of a list holds in one column. */
typedef struct nqm_list_cell {
    size_t column;
    const char *text; /**< UTF-8 as it stood in the file; the text of a number or of another JSON value when is_json */
    int is_json;      /**< 1: `text` is JSON (a number, true, null, an array or an object); 0: it is a plain string */
} nqm_list_cell;

enum { NQM_LIST_MAX_COLUMNS = 1024 }; /**< of JSON Lines; names of members that rows have in all */

/**
 * Read a list: CSV with a header that names the columns `reference` and `test` (ASCII case ignored), or JSON Lines
 * with strings "reference" and "test" in each line (files.md). The form is found by the first byte that is no blank:
 * '{' begins JSON Lines. Other columns are kept as they are.
 *
 * @param path  "-" is standard input
 * @return NQM_ERR_IO, NQM_ERR_FORMAT (the message names line and byte), NQM_ERR_LIMIT, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_pair_list_load(const char *path, nqm_pair_list **list_ret, nqm_error *err);
/** Free a list; NULL is allowed. */
NQM_API void nqm_pair_list_free(nqm_pair_list *list);
/** Rows. */
NQM_API size_t nqm_pair_list_count(const nqm_pair_list *list);
/** (nqm_pair_list_count) the pairs in the order of the list; lent. */
NQM_API const nqm_named_pair *nqm_pair_list_pairs(const nqm_pair_list *list);
/** Columns, `reference` and `test` among them, in the order of the header or of their first appearance. */
NQM_API size_t nqm_pair_list_columns(const nqm_pair_list *list);
/** Name of a column; lent; NULL for one that is too large. */
NQM_API const char *nqm_pair_list_column(const nqm_pair_list *list, size_t column);
/** What a row holds, in its own order; JSON rows may lack columns. Returns how many cells; *cells_ret lends them. */
NQM_API size_t nqm_pair_list_cells(const nqm_pair_list *list, size_t row, const nqm_list_cell **cells_ret);
/** SHA-256 of the bytes of the list, 64 hex digits; lent. */
NQM_API const char *nqm_pair_list_sha256(const nqm_pair_list *list);

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/** Options of nqm_batch_create(). */
typedef struct nqm_batch_options {
    nqm_score_options score; /**< default nqm_score_options_default() */
    int metrics;             /**< 0: leave the scalar metrics out (NaN), which is quicker; default 1 */
    size_t cache_bytes;      /**< sampled BRDFs are kept up to this much memory, those used last longest; the BRDFs of
                                  one block of pairs are kept whatever this says; default 64 MiB (10,000 BRDFs) */
} nqm_batch_options;

/** The defaults above. */
NQM_API nqm_batch_options nqm_batch_options_default(void);

/** A model with the BRDFs that were sampled last. Belongs to one thread at a time; works on all of them. */
typedef struct nqm_batch nqm_batch;

enum { NQM_BATCH_BLOCK = 256 }; /**< pairs that are scored together */

/** `model` is lent and must outlive the batch. options NULL: the defaults. NQM_ERR_ARG, NQM_ERR_NOMEM. */
NQM_API NQM_MUST_CHECK nqm_status nqm_batch_create(const nqm_model *model, const nqm_batch_options *options,
                                                   nqm_batch **batch_ret, nqm_error *err);
/** Free it; NULL is allowed. */
NQM_API void nqm_batch_free(nqm_batch *batch);

/**
 * Score pairs, in blocks of NQM_BATCH_BLOCK. A result depends on its pair and on nothing else. Pairs of one reference in
 * a block are quicker.
 *
 * @param pairs    (n_pairs)
 * @param results  (n_pairs) receives a result each; status is not NQM_OK where the pair has no score
 * @param errors   (n_pairs) receives why; NULL allowed
 * @return faults that concern all pairs: NQM_ERR_NOMEM. A BRDF that cannot be opened or sampled is a fault of its pairs.
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_batch_score(nqm_batch *batch, size_t n_pairs, const nqm_named_pair *pairs,
                                                  nqm_score_result *results, nqm_error *errors, nqm_error *err);

/** How many BRDFs were opened so far, with those that failed; each counts again when it had been dropped meanwhile. */
NQM_API size_t nqm_batch_n_opened(const nqm_batch *batch);

/**
 * The share of people who prefer the better of two to the worse, as the JOD scale is made (Thurstone's model, case V,
 * with one JOD at 75 %: Perez-Ortiz and Mantiuk 2017, arXiv:1712.03686, section 2): Phi(0.6745 (jod - other_jod)), with
 * Phi the normal distribution function. 0.5 for equal scores; below it when `other_jod` is larger.
 */
NQM_API double nqm_jod_preference(double jod, double other_jod);

#ifdef __cplusplus
}
#endif
#endif
