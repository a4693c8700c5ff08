/* SPDX-License-Identifier: MIT
 *
 * Files of several materials as pairs of materials.
 */
#include "pairs/pairs.h"

/* Pairs that are being made. Without memory, `files.is_short` is set and the rest is left out. */
typedef struct expansion {
    nqm_pairs pairs;
    struct nqm_pairs_state s;
    size_t max_pair, max_name, max_row, max_made;
    nqm_pairs_files files;
    unsigned ignored;
} expansion;

/* Keep a text, and return it. */
static char *own(expansion *e, char *text) {
    char **owned = text ? nqm_grow(e->s.owned, &e->s.max_owned, e->s.n_owned + 1, sizeof *owned) : NULL;
    if (!owned) {
        e->files.is_short = true;
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

/* "ignore:...:FILE" with what is ignored. */
static const char *reflect(expansion *e, const char *argument) {
    char *text = nqm_pairs_reflecting(&e->files, argument, e->ignored);
    return text ? own(e, text) : argument;
}

static void add_pair(expansion *e, const char *ref, const char *test, const char *name, size_t row, bool is_made) {
    if (e->files.is_short || !grow(e)) {
        e->files.is_short = true;
        return;
    }
    const size_t at = e->pairs.n++;
    e->s.pair[at] = (nqm_named_pair){reflect(e, ref), reflect(e, test)};
    e->s.name[at] = name;
    e->s.row[at] = row;
    e->s.is_made[at] = is_made;
}

static void leave_out(expansion *e, const nqm_named_pair *pair, const char *material) {
    char *text = nqm_strdupf("%s:%s is not compared: %s has no material of this name", pair->test, material, pair->ref);
    if (!text || nqm_names_add(&e->s.text, text, strlen(text), NULL) != NQM_OK)
        e->files.is_short = true;
    nqm_free(text);
}

static void add_materials(expansion *e, const nqm_named_pair *pair, const char *name, size_t row,
                          const nqm_materials *ref, const nqm_materials *test) {
    const nqm_materials *named = ref ? ref : test;
    for (size_t i = 0; i < nqm_materials_count(named) && !e->files.is_short; ++i) {
        const char *material = nqm_materials_get(named, i).name;
        const char *test_member =
            own(e, nqm_pairs_join(pair->test, material)); /* if the file lacks it, opening it says so */
        const char *ref_member = ref ? own(e, nqm_pairs_join(pair->ref, material)) : pair->ref;
        add_pair(e, ref_member, test_member, name ? own(e, nqm_pairs_join(name, material)) : NULL, row, true);
    }
    for (size_t i = 0, n; ref && i < nqm_materials_count(test); ++i) {
        const char *material = nqm_materials_get(test, i).name;
        nqm_materials_named(ref, material, &n);
        if (n == 0)
            leave_out(e, pair, material);
    }
}

/* The materials of a file of several. */
static const nqm_materials *read_several(expansion *e, const char *path) {
    const nqm_materials *materials = nqm_pairs_materials(&e->files, path);
    return materials && nqm_materials_count(materials) > 1 ? materials : NULL;
}

static void add_row(expansion *e, const nqm_named_pair *pair, const char *name, size_t row) {
    const nqm_materials *ref = read_several(e, pair->ref), *test = read_several(e, pair->test);
    if (test)
        add_materials(e, pair, name, row, ref, test);
    else
        add_pair(e, pair->ref, pair->test, name, row, false);
}

/* Cut the name off the test of a row of a list; its column `name` has priority. */
static const char *take_name(expansion *e, nqm_named_pair *pair, size_t row) {
    const size_t n = nqm_pairs_name_length(pair->test);
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
    for (size_t row = 0; status == NQM_OK && row < of->n && !e->files.is_short; ++row)
        add_row(e, &pairs[row], names[row], row);
    nqm_free(pairs);
    return status;
}

nqm_status nqm_pairs_expand(const nqm_pairs *of, const char *ignore, nqm_pairs **expanded_ret, nqm_error *err) {
    NQM_MAKE(err, expanded_ret, of);
    NQM_REQUIRE_IF(of->n, err, of->pairs);
    unsigned ignored = 0;
    if (ignore && !nqm_ignore_parse(ignore, strlen(ignore), &ignored))
        return nqm_fail(err, NQM_ERR_ARG, -1, "'%.100s' is no list of what can be ignored", ignore);
    expansion *e = nqm_alloc(1, sizeof *e);
    if (!e)
        return nqm_fail_nomem(err, sizeof *e);
    e->pairs = (nqm_pairs){.n_columns = of->n_columns, .columns = of->columns, .sha256 = of->sha256, .state = &e->s};
    e->s.of = of;
    e->ignored = ignored;
    nqm_status status = of->state ? add_list(e, err) : NQM_OK;
    for (size_t i = 0; !of->state && i < of->n && !e->files.is_short; ++i)
        add_row(e, &of->pairs[i], of->names ? of->names[i] : NULL, i);
    if (status == NQM_OK && (e->files.is_short || nqm_names_add(&e->s.text, "", 0, NULL) != NQM_OK))
        status = nqm_fail_nomem(err, e->pairs.n * sizeof *e->s.pair);
    nqm_pairs_forget(&e->files);
    e->pairs.pairs = e->s.pair;
    e->pairs.names = e->s.name;
    e->pairs.rows = e->s.row;
    e->pairs.left_out = e->s.text.text;
    if (status == NQM_OK)
        *expanded_ret = &e->pairs;
    else
        nqm_pairs_free(&e->pairs);
    return status;
}
