/* SPDX-License-Identifier: MIT
 *
 * Names of tests, "NAME=BRDF", and that they differ.
 */
#include "pairs/pairs.h"

#include <stdlib.h>

static bool same_name(const nqm_pairs_name *x, const nqm_pairs_name *y) {
    return x->group == y->group && strcmp(x->reference, y->reference) == 0 && strcmp(x->name, y->name) == 0;
}

static int compare_names(const void *a, const void *b) {
    const nqm_pairs_name *x = a, *y = b;
    int order = (x->group > y->group) - (x->group < y->group);
    order = order ? order : strcmp(x->reference, y->reference);
    order = order ? order : strcmp(x->name, y->name);
    return order ? order : (x->row > y->row) - (x->row < y->row);
}

/* ASCII, and U+0080 to U+009F. */
static bool has_control(const char *text) {
    for (const unsigned char *c = (const unsigned char *)text; *c; ++c)
        if (*c < ' ' || *c == 0x7f || (*c == 0xc2 && c[1] >= 0x80 && c[1] <= 0x9f))
            return true;
    return false;
}

static nqm_status fail_name(nqm_error *err, const char *list, const char *rows, const char *flaw) {
    return nqm_fail(err, list ? NQM_ERR_FORMAT : NQM_ERR_ARG, -1, "%s%s%s%s", list ? list : "", list ? ": " : "",
                    list ? rows : "", flaw);
}

nqm_status nqm_pairs_check_names(size_t n, nqm_pairs_name *names, const char *list, nqm_error *err) {
    char rows[80], flaw[300];
    for (size_t i = 0; i < n; ++i)
        if (has_control(names[i].name)) {
            snprintf(rows, sizeof rows, "row %zu: ", names[i].row);
            snprintf(flaw, sizeof flaw, "the name '%.200s' has a control character", names[i].name);
            return fail_name(err, list, rows, flaw);
        }
    qsort(names, n, sizeof *names, compare_names);
    for (size_t i = 1; i < n; ++i)
        if (same_name(&names[i - 1], &names[i])) {
            snprintf(rows, sizeof rows, "rows %zu and %zu: ", names[i - 1].row, names[i].row);
            snprintf(flaw, sizeof flaw, "two BRDFs have the name '%.200s'; give each a name of its own", names[i].name);
            return fail_name(err, list, rows, flaw);
        }
    return NQM_OK;
}
