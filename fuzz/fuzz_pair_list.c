/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: lists of pairs. Every row of an accepted list must have a pair, and every cell a known column.
 */
#include "fuzz.h"
#include "nqm/score/pair_list.h"

#include <stdlib.h>
#include <string.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    nqm_pair_list *list;
    nqm_error err = {0};
    if (nqm_pair_list_parse((const char *)data, n_bytes, "fuzz", &list, &err) != NQM_OK) {
        must(!list && err.message[0]);
        return 0;
    }
    size_t n_text = 0;
    for (size_t row = 0; row < list->n_rows; ++row) {
        must(nqm_pair_list_cells(list, row) >= 2);
        for (size_t i = 0; i < nqm_pair_list_cells(list, row); ++i) {
            const nqm_list_cell cell = nqm_pair_list_cell(list, row, i);
            must(cell.column < list->n_columns && list->column[cell.column]);
            n_text += strlen(cell.text);
        }
        n_text += strlen(list->pair[row].ref) + strlen(list->pair[row].test);
    }
    must(n_text <= 60 * (n_bytes + 1));
    must(strlen(list->sha256) == 64);
    nqm_pair_list_free(list);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "{\"reference\":\"a\",\"test\":\"b,c\",\"x\":[1,{\"y\":null}]}\n"
                               "{\"test\":\"caf\\u00e9\",\"z\":8.25,\"reference\":\"d\"}\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
