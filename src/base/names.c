/* SPDX-License-Identifier: MIT
 *
 * Lists of strings (names.h).
 */
#include "base/names.h"

#include <string.h>

nqm_status nqm_names_add(nqm_names *names, const char *name, size_t n_bytes, nqm_error *err) {
    size_t *start = nqm_grow(names->start, &names->max_n, names->n + 1, sizeof *start);
    names->start = start ? start : names->start;
    char *text = start ? nqm_grow(names->text, &names->max_text, names->n_text + n_bytes + 1, 1) : NULL;
    if (!text)
        return nqm_fail_nomem(err, n_bytes);
    names->text = text;
    names->start[names->n++] = names->n_text;
    memcpy(names->text + names->n_text, name, n_bytes);
    names->text[names->n_text + n_bytes] = '\0';
    names->n_text += n_bytes + 1;
    return NQM_OK;
}

nqm_status nqm_names_intern(nqm_names *names, const char *name, size_t n_bytes, uint32_t *index_ret, nqm_error *err) {
    size_t i = names->n;
    for (; i-- > 0;)
        if (strncmp(nqm_name(names, i), name, n_bytes) == 0 && nqm_name(names, i)[n_bytes] == '\0')
            break;
    *index_ret = (uint32_t)(i < names->n ? i : names->n);
    return i < names->n ? NQM_OK : nqm_names_add(names, name, n_bytes, err);
}

void nqm_names_free(nqm_names *names) {
    nqm_free(names->start);
    nqm_free(names->text);
    *names = (nqm_names){0};
}
