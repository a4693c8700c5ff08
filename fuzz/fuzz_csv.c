/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the CSV reader. An accepted file is written again with every field quoted, and must parse to the same
 * fields.
 */
#include "fuzz.h"
#include "io/io.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static char *put_field(char *out, const char *text, bool last) {
    *out++ = '"';
    for (; *text; ++text) {
        if (*text == '"')
            *out++ = '"';
        *out++ = *text;
    }
    *out++ = '"';
    *out++ = last ? '\n' : ',';
    return out;
}

/* All rows as CSV under a header of empty names. free() it. */
static char *write_again(const nqm_csv *csv, size_t *n_bytes_ret) {
    size_t n_columns = nqm_csv_columns(csv), n_bytes = 3 * n_columns;
    for (size_t i = 0; i < nqm_csv_rows(csv) * n_columns; ++i)
        n_bytes += 2 * strlen(nqm_csv_text(csv, i / n_columns, (int)(i % n_columns))) + 3;
    char *text = malloc(n_bytes), *out = text;
    must(text != NULL);
    for (size_t k = 0; k < n_columns; ++k)
        out = put_field(out, "", k + 1 == n_columns);
    for (size_t i = 0; i < nqm_csv_rows(csv) * n_columns; ++i)
        out = put_field(out, nqm_csv_text(csv, i / n_columns, (int)(i % n_columns)), (i + 1) % n_columns == 0);
    *n_bytes_ret = (size_t)(out - text);
    return text;
}

static void check_fields(const nqm_csv *csv, const nqm_csv *back, size_t n_bytes) {
    size_t n_columns = nqm_csv_columns(csv);
    must(nqm_csv_columns(back) == n_columns && nqm_csv_rows(back) == nqm_csv_rows(csv));
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row)
        for (int k = 0; k < (int)n_columns; ++k) {
            must(strcmp(nqm_csv_text(csv, row, k), nqm_csv_text(back, row, k)) == 0);
            nqm_error err = {0};
            double value;
            if (nqm_csv_number(csv, row, k, &value, &err) == NQM_OK)
                must(isfinite(value));
            else
                must(err.message[0] && err.byte_offset >= 0 && (size_t)err.byte_offset <= n_bytes);
        }
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    nqm_csv *csv, *back;
    nqm_error err = {0};
    if (nqm_csv_parse((const char *)data, n_bytes, "fuzz", &csv, &err) != NQM_OK) {
        must(!csv && err.message[0] && err.byte_offset >= 0 && (size_t)err.byte_offset <= n_bytes);
        return 0;
    }
    size_t n_again;
    char *again = write_again(csv, &n_again);
    must(nqm_csv_parse(again, n_again, "again", &back, &err) == NQM_OK);
    check_fields(csv, back, n_bytes);
    nqm_csv_free(csv);
    nqm_csv_free(back);
    free(again);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "\xef\xbb\xbf# made up\nname, JOD ,\"Delta, E\"\r\nfelt,9.5,-1e-3\n\n\"two\nlines\",\"say "
        "\"\"so\"\"\",.5\nleaf,,\" 7 \"";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
