/* SPDX-License-Identifier: MIT
 *
 * Pairs of two versions of a library: by name, then by look.
 */
#include "library/library.h"

#include <stdlib.h>

/* The versions and what becomes of their members. */
typedef struct versions {
    nqm_library *before, *after;
    size_t *partner;  /* (before->n) number in `after`; SIZE_MAX: it is gone */
    bool *is_partner; /* (after->n) */
} versions;

/* ---- names ------------------------------------------------------------------------------------------------------- */

static nqm_index_key key_of(const void *member) {
    return (nqm_index_key){.name = ((const nqm_library_member *)member)->key};
}

static nqm_status pair_names(versions *v, nqm_error *err) {
    const size_t n = v->after->n;
    if (v->before->n == 1 && n == 1 && v->before->state->is_file) { /* files of one material, whatever it is called */
        v->partner[0] = 0;
        v->is_partner[0] = true;
        return NQM_OK;
    }
    nqm_index by_key;
    const nqm_status status = nqm_index_create(n, key_of, &by_key, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        nqm_index_add(&by_key, &v->after->members[i]);
    for (size_t i = 0; status == NQM_OK && i < v->before->n; ++i) {
        const nqm_library_member *same = nqm_index_find(&by_key, key_of(&v->before->members[i]));
        const size_t at = same ? (size_t)(same - v->after->members) : SIZE_MAX;
        v->partner[i] = same && !v->is_partner[at] ? at : SIZE_MAX;
        if (v->partner[i] != SIZE_MAX)
            v->is_partner[at] = true;
    }
    nqm_index_free(&by_key);
    return status;
}

/* ---- looks ------------------------------------------------------------------------------------------------------- */

/* Whether only its version has a member. */
static bool is_single(const versions *v, bool is_new, size_t i) {
    return is_new ? !v->is_partner[i] : v->partner[i] == SIZE_MAX;
}

/* Members that only one version has, and that have values, with pictures. */
typedef struct singles {
    size_t n, *from; /* (n) their numbers */
    nqm_gallery *gallery;
} singles;

static nqm_status draw_singles(const versions *v, bool is_new, singles *of, nqm_error *err) {
    struct nqm_library_state *s = v->after->state;
    const nqm_library *library = is_new ? v->after : v->before;
    size_t n = 0;
    for (size_t i = 0; i < library->n; ++i)
        n += is_single(v, is_new, i);
    *of = (singles){.n = 0};
    of->from = nqm_alloc(n, sizeof *of->from);
    nqm_status status =
        of->from ? nqm_gallery_create(s->model, n, NULL, &of->gallery, err) : nqm_fail_nomem(err, n * sizeof *of->from);
    for (size_t i = 0; status == NQM_OK && i < library->n; ++i) {
        nqm_error why = {0};
        if (!is_single(v, is_new, i))
            continue;
        status = nqm_library_step(s, "sample", of->n, n, err);
        if (status == NQM_OK)
            status = nqm_library_draw_one(s, &library->members[i], of->gallery, of->n, &why, err);
        if (status == NQM_OK && why.status == NQM_OK)
            of->from[of->n++] = i;
    }
    return status;
}

/* Find the member of the new version that looks most like an old one, by its estimate, and confirm it by score. */
static nqm_status pair_one(versions *v, const singles *old, size_t i, const singles *new, float *jods, nqm_error *err) {
    static const double same = 9.5;
    struct nqm_library_state *s = v->after->state;
    size_t best = SIZE_MAX;
    nqm_gallery_jods(old->gallery, i, new->gallery, 0, new->n, false, jods);
    for (size_t k = 0; k < new->n; ++k)
        if (!v->is_partner[new->from[k]] && (best == SIZE_MAX || jods[k] > jods[best]))
            best = k;
    if (best == SIZE_MAX || (double)jods[best] < nqm_library_least_estimate(same))
        return NQM_OK;
    const size_t a = old->from[i], b = new->from[best];
    nqm_status status = nqm_library_begin_pairs(s, 1, err);
    if (status == NQM_OK) {
        nqm_library_set_pair(s, 0, &v->before->members[a], a, &v->after->members[b], b);
        status = nqm_library_score_few(s, 1, err);
    }
    if (status == NQM_OK && s->pairs->result.jod >= same) { /* false for NaN */
        v->partner[a] = b;
        v->is_partner[b] = true;
    }
    return status;
}

/* Of names that only one version has, those that look the same are the same material. */
static nqm_status pair_looks(versions *v, nqm_error *err) {
    struct nqm_library_state *s = v->after->state;
    singles old = {.n = 0}, new = {.n = 0};
    float *jods = NULL;
    size_t n_paired = 0;
    for (size_t i = 0; i < v->before->n; ++i)
        n_paired += v->partner[i] != SIZE_MAX;
    if (n_paired == v->before->n || n_paired == v->after->n || nqm_gallery_size(s->model) == 0)
        return NQM_OK;
    nqm_status status = nqm_library_need_scorer(s, err);
    if (status == NQM_OK)
        status = draw_singles(v, false, &old, err);
    if (status == NQM_OK)
        status = draw_singles(v, true, &new, err);
    if (status == NQM_OK && !(jods = nqm_alloc(new.n, sizeof *jods)))
        status = nqm_fail_nomem(err, new.n * sizeof *jods);
    for (size_t i = 0; status == NQM_OK && i < old.n; ++i) {
        status = nqm_library_step(s, "compare", i, old.n, err);
        if (status == NQM_OK)
            status = pair_one(v, &old, i, &new, jods, err);
    }
    nqm_free(jods);
    nqm_free(old.from);
    nqm_free(new.from);
    nqm_gallery_free(old.gallery);
    nqm_gallery_free(new.gallery);
    return status;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

static int worst_first(const void *a, const void *b) {
    const nqm_library_pair *x = a, *y = b;
    const bool has_x = x->error.status == NQM_OK, has_y = y->error.status == NQM_OK;
    if (has_x != has_y)
        return has_x ? 1 : -1;
    if (has_x && x->result.jod != y->result.jod)
        return x->result.jod < y->result.jod ? -1 : 1;
    return x->ref < y->ref ? -1 : 1;
}

/* Pairs in the order of the old members, then those of one member. Returns the number of the former. */
static size_t set_pairs(const versions *v) {
    struct nqm_library_state *s = v->after->state;
    size_t n = 0, n_pairs = 0;
    for (int is_single = 0; is_single < 2; ++is_single)
        for (size_t i = 0; i < v->before->n; ++i) {
            const size_t k = v->partner[i];
            if ((k == SIZE_MAX) != is_single)
                continue;
            nqm_library_set_pair(s, n++, &v->before->members[i], i, is_single ? NULL : &v->after->members[k], k);
            n_pairs += !is_single;
        }
    for (size_t k = 0; k < v->after->n; ++k)
        if (!v->is_partner[k])
            nqm_library_set_pair(s, n++, NULL, SIZE_MAX, &v->after->members[k], k);
    return n_pairs;
}

static nqm_status score_versions(versions *v, nqm_error *err) {
    struct nqm_library_state *s = v->after->state;
    nqm_argument_files *files = nqm_argument_files_create(); /* NULL: they are parsed again */
    size_t n = v->before->n;
    for (size_t k = 0; k < v->after->n; ++k)
        n += !v->is_partner[k];
    nqm_status status = nqm_library_begin_pairs(s, n, err);
    const size_t n_pairs = status == NQM_OK ? set_pairs(v) : 0;
    if (status == NQM_OK)
        status = nqm_library_score(s, n_pairs, false, err);
    for (size_t i = 0; status == NQM_OK && i < n_pairs; ++i) {
        nqm_library_pair *pair = &s->pairs[i];
        status = nqm_library_step(s, "compare", i, n_pairs, err);
        if (status == NQM_OK)
            status = nqm_library_compare(files, pair, err);
        pair->is_refused_alike = pair->error.status != NQM_OK && nqm_pairs_refused_alike(files, &pair->names);
    }
    nqm_argument_files_free(files);
    if (status == NQM_OK)
        qsort(s->pairs, n_pairs, sizeof *s->pairs, worst_first);
    return status;
}

nqm_status nqm_library_diff(nqm_library *before, nqm_library *after, size_t *n_ret, const nqm_library_pair **pairs_ret,
                            nqm_error *err) {
    NQM_REQUIRE(err, before, after, n_ret, pairs_ret);
    if (!after->state->model)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: the library was opened without a model", after->path);
    versions v = {before, after, NULL, NULL};
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&v.partner, before->n, sizeof *v.partner}, {&v.is_partner, after->n, sizeof *v.is_partner}), err);
    if (status == NQM_OK)
        status = pair_names(&v, err);
    if (status == NQM_OK)
        status = pair_looks(&v, err);
    if (status == NQM_OK)
        status = score_versions(&v, err);
    nqm_free(v.partner);
    *n_ret = status == NQM_OK ? after->state->n_pairs : 0;
    *pairs_ret = status == NQM_OK ? after->state->pairs : NULL;
    return status;
}
