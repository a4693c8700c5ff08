/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: lists of pairs. Every row of an accepted list must have a pair, and every cell a known column.
 */
#include "fuzz.h"
#include "nqm/score/pair_list.h"

#include <stdlib.h>
#include <string.h>

static void must(bool holds) {
    if (!holds)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    nqm_pair_list *list;
    nqm_error err = {0};
    if (nqm_pair_list_parse((const char *)data, n_bytes, "fuzz", &list, &err) != NQM_OK) {
        must(!list && err.message[0]);
        return 0;
    }
    size_t n_columns = nqm_pair_list_columns(list), n_text = 0;
    for (size_t row = 0; row < nqm_pair_list_count(list); ++row) {
        const nqm_list_cell *cells;
        size_t n_cells = nqm_pair_list_cells(list, row, &cells);
        must(n_cells >= 2);
        for (size_t i = 0; i < n_cells; ++i) {
            must(cells[i].column < n_columns && nqm_pair_list_column(list, cells[i].column));
            n_text += strlen(cells[i].text);
        }
        n_text += strlen(nqm_pair_list_pairs(list)[row].ref) + strlen(nqm_pair_list_pairs(list)[row].test);
    }
    must(n_text <= 60 * (n_bytes + 1));
    must(strlen(nqm_pair_list_sha256(list)) == 64);
    nqm_pair_list_free(list);
    return 0;
}

blob fuzz_seed(void) {
    static const char text[] = "{\"reference\":\"a\",\"test\":\"b,c\",\"x\":[1,{\"y\":null}]}\n"
                               "{\"test\":\"caf\\u00e9\",\"z\":8.25,\"reference\":\"\"}\n";
    return blob_of(sizeof text - 1, text);
}
