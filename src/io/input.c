/* SPDX-License-Identifier: MIT
 *
 * The text that a verb takes from a file or, for the name "-", from standard input.
 */
#include "io/io.h"

#include <stdio.h>
#include <string.h>

static nqm_status read_standard_input(char **text_ret, size_t *n_ret, nqm_error *err) {
    enum { MAX_BYTES = 1 << 30 };
    char *text = NULL;
    size_t n = 0, room = 0;
    for (;;) {
        if (n == room) {
            size_t more = room ? 2 * room : 65536;
            char *larger = more <= MAX_BYTES ? nqm_alloc(more, 1) : NULL;
            if (larger && n)
                memcpy(larger, text, n);
            nqm_free(text);
            text = larger;
            room = more;
            if (!text)
                return nqm_fail(err, NQM_ERR_LIMIT, (int64_t)n, "standard input: more than %zu bytes do not fit", n);
        }
        size_t n_read = fread(text + n, 1, room - n, stdin);
        if (n_read == 0)
            break;
        n += n_read;
    }
    if (ferror(stdin)) {
        nqm_free(text);
        return nqm_fail(err, NQM_ERR_IO, (int64_t)n, "standard input: cannot be read, after %zu bytes", n);
    }
    *text_ret = text;
    *n_ret = n;
    return NQM_OK;
}

nqm_status nqm_input_open(const char *path, nqm_input *input_ret, nqm_error *err) {
    nqm_input input = {.name = path};
    nqm_status status;
    if (strcmp(path, "-") == 0) {
        input.name = "standard input";
        status = read_standard_input(&input.owned, &input.n_bytes, err);
        input.text = input.owned;
    } else {
        status = nqm_map_open(path, &input.map, err);
        input.text = (const char *)input.map.data;
        input.n_bytes = input.map.n_bytes;
    }
    *input_ret = status == NQM_OK ? input : (nqm_input){0};
    return status;
}

void nqm_input_close(nqm_input *input) {
    nqm_map_close(&input->map);
    nqm_free(input->owned);
    *input = (nqm_input){0};
}
