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
    size_t n_text = 0;
    for (size_t row = 0; row < list->n_rows; ++row) {
        must(list->row_begin[row + 1] >= list->row_begin[row] + 2);
        for (size_t i = list->row_begin[row]; i < list->row_begin[row + 1]; ++i) {
            must(list->cell[i].column < list->n_columns && list->column[list->cell[i].column]);
            n_text += strlen(list->cell[i].text);
        }
        n_text += strlen(list->pair[row].ref) + strlen(list->pair[row].test);
    }
    must(n_text <= 60 * (n_bytes + 1));
    must(strlen(list->sha256) == 64);
    nqm_pair_list_free(list);
    return 0;
}

blob fuzz_seed(void) {
    static const char text[] = "{\"reference\":\"a\",\"test\":\"b,c\",\"x\":[1,{\"y\":null}]}\n"
                               "{\"test\":\"caf\\u00e9\",\"z\":8.25,\"reference\":\"\"}\n";
    return blob_of(sizeof text - 1, text);
}
