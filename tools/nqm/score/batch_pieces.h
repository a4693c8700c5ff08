/* SPDX-License-Identifier: MIT
 *
 * batch_pieces.h - the results of `nqm batch --work DIR`: pieces of a list, one file each, which several processes make together
 * and a later run with the same settings finds again.
 */
#ifndef NQM_TOOL_BATCH_PIECES_H
#define NQM_TOOL_BATCH_PIECES_H

#include "nqm/score/pair_list.h"
#include "nqm/score/score.h"

/** The pieces of one run. */
typedef struct batch_pieces {
    const nqm_pair_list *list;
    nqm_scorer *scorer;
    const nqm_model *model;    /* that of the scorer, for textures */
    char *folder;              /* absolute; NULL: no pieces, results are computed when they are needed */
    char identity[33];         /* hash of all that determines results: the beginning of the files' names */
    size_t size, n;            /* rows of a piece, number of pieces */
    size_t current;            /* the piece whose results are below, n: none */
    bool near_only;            /* of textures */
    nqm_score_result *results; /* (size) */
    texture_numbers *textures; /* (size) NaN: not of a texture */
    nqm_error *errors;         /* (size) */
    json_t *files;             /* files that these results depend on, from identify_files(); owned */
} batch_pieces;

/**
 * Open or make the folder.
 *
 * @param folder  NULL: none; then a piece is a block of results
 * @param terms   an object of scalars: all settings that determine results, the list and its root included
 */
void open_batch_pieces(const char *folder, const json_t *terms, const nqm_pair_list *list, nqm_scorer *scorer,
                       const nqm_model *model, batch_pieces *pieces);
/** Score all pieces together with the other processes of `r`. Returns when all files exist: an exit code, its error reported. */
int share_batch_pieces(batch_pieces *pieces, ranks r);
/** Have results, textures and errors of the rows from `row` to the end of its piece: n of them from *at of these arrays
 *  on. Returns an exit code, its error reported. */
int get_batch_results(batch_pieces *pieces, size_t row, size_t *n_ret, size_t *at);
/** Remove the file of the piece with a row, so that a later run scores it again. */
void forget_batch_piece(batch_pieces *pieces, size_t row);
void close_batch_pieces(batch_pieces *pieces);

#endif
