/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: lists of pairs. Every row of an accepted list must have a pair, and every cell a known column.
 */
#include "fuzz.h"
#include "pairs/pairs.h"

#include <stdlib.h>
#include <string.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    nqm_pairs *list;
    nqm_error err = {0};
    if (nqm_pairs_parse((const char *)data, n_bytes, "fuzz", &list, &err) != NQM_OK) {
        must(!list && err.message[0]);
        return 0;
    }
    size_t n_text = 0;
    nqm_pairs_cell cell;
    for (size_t row = 0; row < list->n; ++row) {
        must(nqm_pairs_get_cell(list, row, 1, &cell));
        for (size_t i = 0; nqm_pairs_get_cell(list, row, i, &cell); ++i) {
            must(cell.column < list->n_columns && list->columns[cell.column]);
            n_text += strlen(cell.text);
        }
        n_text += strlen(list->pairs[row].ref) + strlen(list->pairs[row].test);
    }
    must(n_text <= 60 * (n_bytes + 1));
    must(strlen(list->sha256) == 64);
    nqm_pairs_free(list);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "{\"reference\":\"a\",\"test\":\"b,c\",\"x\":[1,{\"y\":null}]}\n"
                               "{\"test\":\"caf\\u00e9\",\"z\":8.25,\"reference\":\"d\"}\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
