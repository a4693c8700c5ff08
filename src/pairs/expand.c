/* SPDX-License-Identifier: MIT
 *
 * Files of several materials as pairs of materials.
 */
#include "pairs/pairs.h"

char *nqm_pairs_join(const char *a, const char *b) {
    return nqm_strdupf("%s%s%s", a, *a && *b ? ":" : "", b);
}

bool nqm_pairs_refused_alike(nqm_argument_files *files, const nqm_named_pair *pair) {
    nqm_argument *ref = nqm_argument_parse(pair->ref, files), *test = nqm_argument_parse(pair->test, files);
    nqm_material_info a, b;
    const bool is = ref && test && nqm_argument_material(ref, &a) && nqm_argument_material(test, &b) && a.refusal &&
                    b.refusal && strcmp(a.refusal, b.refusal) == 0;
    nqm_argument_free(ref);
    nqm_argument_free(test);
    return is;
}

/* Pairs that are being made. Without memory, `is_short` is set and the rest is left out. */
typedef struct expansion {
    nqm_pairs pairs;
    struct nqm_pairs_state s;
    size_t max_pair, max_name, max_row, max_made;
    nqm_argument_files *files;
    bool is_short; /* of memory */
    unsigned ignored;
} expansion;

/* Keep a text, and return it. */
static char *own(expansion *e, char *text) {
    char **owned = text ? nqm_grow(e->s.owned, &e->s.max_owned, e->s.n_owned + 1, sizeof *owned) : NULL;
    if (!owned) {
        e->is_short = true;
        nqm_free(text);
        return NULL;
    }
    e->s.owned = owned;
    return owned[e->s.n_owned++] = text;
}

static bool grow(expansion *e) {
    const size_t n = e->pairs.n + 1;
    void *pair = nqm_grow(e->s.pair, &e->max_pair, n, sizeof *e->s.pair),
         *name = nqm_grow(e->s.name, &e->max_name, n, sizeof *e->s.name),
         *row = nqm_grow(e->s.row, &e->max_row, n, sizeof *e->s.row),
         *is_made = nqm_grow(e->s.is_made, &e->max_made, n, sizeof *e->s.is_made);
    e->s.pair = pair ? pair : e->s.pair;
    e->s.name = name ? name : e->s.name;
    e->s.row = row ? row : e->s.row;
    e->s.is_made = is_made ? is_made : e->s.is_made;
    return pair && name && row && is_made;
}

/* NULL: out of memory. */
static nqm_argument *parse(expansion *e, const char *text) {
    nqm_argument *a = text ? nqm_argument_parse(text, e->files) : NULL;
    e->is_short = e->is_short || !a;
    return a;
}

/* "ignore:...:FILE" with what is ignored. */
static const char *reflect(expansion *e, const char *argument) {
    nqm_argument *a = e->ignored ? parse(e, argument) : NULL;
    char *text = a ? nqm_argument_reflecting(a, e->ignored) : NULL;
    nqm_argument_free(a);
    return text ? own(e, text) : argument;
}

static void add_pair(expansion *e, const char *ref, const char *test, const char *name, size_t row, bool is_made) {
    if (e->is_short || !grow(e)) {
        e->is_short = true;
        return;
    }
    const size_t at = e->pairs.n++;
    e->s.pair[at] = (nqm_named_pair){reflect(e, ref), reflect(e, test)};
    e->s.name[at] = name;
    e->s.row[at] = row;
    e->s.is_made[at] = is_made;
}

/* Add a message on a material without a partner, or the end (NULL). */
static void leave_out(expansion *e, const char *message) {
    const char **left_out = nqm_grow(e->s.left_out, &e->s.max_left_out, e->s.n_left_out + 1, sizeof *left_out);
    e->is_short = e->is_short || !left_out;
    if (left_out) {
        e->s.left_out = left_out;
        left_out[e->s.n_left_out++] = message;
    }
}

static void add_materials(expansion *e, const nqm_named_pair *pair, const char *name, size_t row,
                          const nqm_materials *ref, const nqm_materials *test) {
    const nqm_materials *named = ref ? ref : test;
    for (size_t i = 0; i < nqm_materials_count(named) && !e->is_short; ++i) {
        const char *material = nqm_materials_get(named, i).name;
        const char *test_member =
            own(e, nqm_pairs_join(pair->test, material)); /* if the file lacks it, opening it says so */
        const char *ref_member = ref ? own(e, nqm_pairs_join(pair->ref, material)) : pair->ref;
        add_pair(e, ref_member, test_member, name ? own(e, nqm_pairs_join(name, material)) : NULL, row, true);
    }
    for (size_t i = 0, other; ref && i < nqm_materials_count(test); ++i) {
        const char *material = nqm_materials_get(test, i).name;
        if (nqm_materials_find(ref, material, &other) == SIZE_MAX)
            leave_out(e, own(e, nqm_strdupf("%s:%s is not compared: %s has no material of this name", pair->test,
                                            material, pair->ref)));
    }
}

static void add_row(expansion *e, const nqm_named_pair *pair, const char *name, size_t row) {
    nqm_argument *ref = parse(e, pair->ref), *test = parse(e, pair->test);
    const nqm_materials *several = test ? nqm_argument_library(test) : NULL;
    if (several && ref)
        add_materials(e, pair, name, row, nqm_argument_library(ref), several);
    else
        add_pair(e, pair->ref, pair->test, name, row, false);
    nqm_argument_free(ref);
    nqm_argument_free(test);
}

/* Cut the name off the test of a row of a list; its column `name` has priority. */
static const char *take_name(expansion *e, nqm_named_pair *pair, size_t row) {
    const size_t n = nqm_argument_name_length(pair->test);
    const char *name = n ? own(e, nqm_strdupf("%.*s", (int)n, pair->test)) : NULL;
    nqm_pairs_cell cell;
    pair->test += n ? n + 1 : 0;
    for (size_t i = 0; nqm_pairs_get_cell(e->s.of, row, i, &cell); ++i)
        if (strcmp(e->s.of->columns[cell.column], "name") == 0 && !cell.is_json && *cell.text)
            name = cell.text;
    return name;
}

static nqm_status add_list(expansion *e, nqm_error *err) {
    const nqm_pairs *of = e->s.of;
    nqm_named_pair *pairs = NULL;
    const char **names;
    nqm_pairs_name *given;
    size_t n = 0;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&pairs, of->n, sizeof *pairs}, {&names, of->n, sizeof *names}, {&given, of->n, sizeof *given}),
        err);
    for (size_t row = 0; status == NQM_OK && row < of->n; ++row) {
        pairs[row] = of->pairs[row];
        names[row] = take_name(e, &pairs[row], row);
        if (names[row])
            given[n++] = (nqm_pairs_name){.row = row + 1, .reference = pairs[row].ref, .name = names[row]};
    }
    if (status == NQM_OK)
        status = nqm_pairs_check_names(n, given, of->state->path, err);
    for (size_t row = 0; status == NQM_OK && row < of->n && !e->is_short; ++row)
        add_row(e, &pairs[row], names[row], row);
    nqm_free(pairs);
    return status;
}

nqm_status nqm_pairs_expand(const nqm_pairs *of, const char *ignore, nqm_pairs **expanded_ret, nqm_error *err) {
    NQM_MAKE(err, expanded_ret, of);
    NQM_REQUIRE_IF(of->n, err, of->pairs);
    unsigned ignored = 0;
    if (ignore && !nqm_ignore_parse(ignore, strlen(ignore), &ignored))
        return nqm_ignore_refuse(ignore, err);
    expansion *e = nqm_alloc(1, sizeof *e);
    if (!e)
        return nqm_fail_nomem(err, sizeof *e);
    e->pairs = (nqm_pairs){.n_columns = of->n_columns, .columns = of->columns, .sha256 = of->sha256, .state = &e->s};
    e->s.of = of;
    e->ignored = ignored;
    e->files = nqm_argument_files_create(); /* NULL: they are parsed again */
    nqm_status status = of->state ? add_list(e, err) : NQM_OK;
    for (size_t i = 0; !of->state && i < of->n && !e->is_short; ++i)
        add_row(e, &of->pairs[i], of->names ? of->names[i] : NULL, i);
    leave_out(e, NULL);
    if (status == NQM_OK && e->is_short)
        status = nqm_fail_nomem(err, e->pairs.n * sizeof *e->s.pair);
    nqm_argument_files_free(e->files);
    e->files = NULL;
    e->pairs.pairs = e->s.pair;
    e->pairs.names = e->s.name;
    e->pairs.rows = e->s.row;
    e->pairs.left_out = e->s.left_out;
    if (status == NQM_OK)
        *expanded_ret = &e->pairs;
    else
        nqm_pairs_free(&e->pairs);
    return status;
}
