/* SPDX-License-Identifier: MIT
 *
 * The list of pairs of a corpus: its references, their material groups and splits, the rows by reference, and the kinds of
 * distortion that only the test split has.
 */
#include "corpus/corpus.h"

#include <string.h>

static const char *const split_names[] = {"train", "validation", "test"};

const char *nqm_corpus_split_name(nqm_split split) {
    return split_names[split];
}

static const char *text_or(const char *text, const char *fallback) {
    return text && *text ? text : fallback;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

typedef struct kind {
    const char *name;
    bool in_rest; /* in another split than the test split */
} kind;

/* Of a reference, a group or a kind, which begin with their name. */
static nqm_index_key key_of_name(const void *value) {
    return (nqm_index_key){.name = *(const char *const *)value};
}

static nqm_index_key key_of_brdf(const void *value) {
    return (nqm_index_key){.name = ((const nqm_corpus_ref *)value)->brdf};
}

/* All references, groups and kinds of the list, in the order in which they occur. */
typedef struct names {
    size_t n_refs, n_groups, n_kinds;
    nqm_corpus_ref *refs; /* owns the block */
    nqm_corpus_group *groups;
    kind *kinds;
    nqm_index by_ref, by_group, by_kind;
    size_t *ref_of; /* (n) of each pair */
} names;

static nqm_status names_begin(size_t n, names *s, nqm_error *err) {
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s->refs, n, sizeof *s->refs}, {&s->groups, n, sizeof *s->groups},
                                    {&s->kinds, n, sizeof *s->kinds}, {&s->ref_of, n, sizeof *s->ref_of}),
                         err);
    if (status == NQM_OK)
        status = nqm_index_create(n, key_of_name, &s->by_ref, err);
    if (status == NQM_OK)
        status = nqm_index_create(n, key_of_name, &s->by_group, err);
    return status == NQM_OK ? nqm_index_create(n, key_of_name, &s->by_kind, err) : status;
}

static void names_end(names *s) {
    nqm_free(s->refs);
    nqm_index_free(&s->by_ref);
    nqm_index_free(&s->by_group);
    nqm_index_free(&s->by_kind);
}

/* The index of the element with the name of element *n, which is kept as one more if there is none. */
static size_t intern(nqm_index *index, const void *elements, size_t n_each, size_t *n) {
    const char *first = elements, *last = first + *n * n_each, *found = nqm_index_find(index, key_of_name(last));
    if (!found) {
        nqm_index_add(index, last);
        ++*n;
    }
    return (size_t)((found ? found : last) - first) / n_each;
}

static nqm_status add_group(names *s, const char *name, nqm_split split, size_t *group_ret, nqm_error *err) {
    s->groups[s->n_groups] = (nqm_corpus_group){name, split};
    *group_ret = intern(&s->by_group, s->groups, sizeof *s->groups, &s->n_groups);
    const nqm_corpus_group *found = &s->groups[*group_ret];
    return found->split == split ? NQM_OK
                                 : nqm_fail(err, NQM_ERR_ARG, -1,
                                            "group '%s' is in '%s' and in '%s'; all forms of a material belong to one "
                                            "split",
                                            name, split_names[found->split], split_names[split]);
}

static nqm_status add_ref(names *s, size_t i, const nqm_corpus_pair *pair, nqm_error *err) {
    nqm_corpus_ref *ref = &s->refs[s->n_refs];
    *ref = (nqm_corpus_ref){.name = text_or(pair->name, pair->reference), .brdf = pair->reference};
    ref->source = text_or(pair->source, "list");
    nqm_status status = add_group(s, text_or(pair->group, ref->name), pair->split, &ref->group, err);
    if (status != NQM_OK)
        return status;
    s->ref_of[i] = intern(&s->by_ref, s->refs, sizeof *s->refs, &s->n_refs);
    const nqm_corpus_ref *found = &s->refs[s->ref_of[i]];
    if (strcmp(found->brdf, ref->brdf) != 0 || found->group != ref->group || strcmp(found->source, ref->source) != 0)
        return nqm_fail(err, NQM_ERR_ARG, -1, "pair %zu: the name '%s' has two references, groups or sources", i + 1,
                        ref->name);
    return NQM_OK;
}

static void add_kind(names *s, const nqm_corpus_pair *pair) {
    s->kinds[s->n_kinds].name = text_or(pair->kind, "pair");
    kind *one = &s->kinds[intern(&s->by_kind, s->kinds, sizeof *s->kinds, &s->n_kinds)];
    one->in_rest = one->in_rest || pair->split != NQM_SPLIT_TEST;
}

static nqm_status add_pair(names *s, size_t i, const nqm_corpus_pair *pair, nqm_error *err) {
    if (!pair->reference || !*pair->reference || !pair->test || !*pair->test)
        return nqm_fail(err, NQM_ERR_ARG, -1, "pair %zu has no reference or no test", i + 1);
    if ((unsigned)pair->split > NQM_SPLIT_TEST)
        return nqm_fail(err, NQM_ERR_ARG, -1, "pair %zu: there is no split %d", i + 1, (int)pair->split);
    add_kind(s, pair);
    return add_ref(s, i, pair, err);
}

/* The other material of a pair is a reference of the same split, so that no training file contains a test material. */
static nqm_status check_other(const names *s, size_t i, const nqm_corpus_pair *pair, nqm_error *err) {
    if (!pair->other || !*pair->other)
        return NQM_OK;
    const nqm_corpus_ref *other = nqm_index_find(&s->by_ref, (nqm_index_key){.name = pair->other});
    if (!other)
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "pair %zu: no reference of the list has the name '%s' of its column other", i + 1, pair->other);
    if (s->groups[other->group].split != pair->split)
        return nqm_fail(err, NQM_ERR_ARG, -1, "pair %zu: '%s' is in '%s', but the pair in '%s'", i + 1, pair->other,
                        split_names[s->groups[other->group].split], split_names[pair->split]);
    return NQM_OK;
}

/* ---- the rows of a part ------------------------------------------------------------------------------------------ */

static bool in_part(nqm_split split, nqm_corpus_part part) {
    return (split == NQM_SPLIT_TEST) == (part == NQM_CORPUS_TEST);
}

/* Copy the references of the part by group; new_of (n_refs): the index of each, SIZE_MAX: of another part. */
static void take_refs(const names *s, nqm_corpus_part part, size_t *first_in, nqm_corpus_list *list, size_t *new_of) {
    for (size_t r = 0; r < s->n_refs; ++r)
        if (in_part(s->groups[s->refs[r].group].split, part))
            ++first_in[s->refs[r].group + 1];
    for (size_t g = 0; g < s->n_groups; ++g)
        first_in[g + 1] += first_in[g];
    list->n_refs = first_in[s->n_groups];
    for (size_t r = 0; r < s->n_refs; ++r) {
        new_of[r] = SIZE_MAX;
        if (in_part(s->groups[s->refs[r].group].split, part))
            list->refs[new_of[r] = first_in[s->refs[r].group]++] = s->refs[r];
    }
    memcpy(list->groups, s->groups, s->n_groups * sizeof *list->groups);
    list->n_groups = s->n_groups;
}

static void take_rows(const names *s, size_t n, const nqm_corpus_pair *pairs, const size_t *new_of,
                      nqm_corpus_list *list) {
    for (size_t i = 0; i < n; ++i)
        if (new_of[s->ref_of[i]] != SIZE_MAX)
            ++list->refs[new_of[s->ref_of[i]]].n_rows;
    for (size_t r = 0; r < list->n_refs; ++r) {
        list->refs[r].first_row = list->n_rows;
        list->n_rows += list->refs[r].n_rows;
        list->refs[r].n_rows = 0;
    }
    for (size_t i = 0; i < n; ++i) {
        const size_t r = new_of[s->ref_of[i]];
        if (r == SIZE_MAX)
            continue;
        const char *name = text_or(pairs[i].kind, "pair");
        list->rows[list->refs[r].first_row + list->refs[r].n_rows++] =
            (nqm_corpus_row){.ref = r,
                             .test = pairs[i].test,
                             .kind = name,
                             .family = text_or(pairs[i].family, name),
                             .other = text_or(pairs[i].other, "")};
    }
}

static void take_unseen(const names *s, nqm_corpus_list *list) {
    bool has_rest = false;
    for (size_t k = 0; k < s->n_kinds; ++k)
        has_rest = has_rest || s->kinds[k].in_rest;
    for (size_t k = 0; k < s->n_kinds; ++k)
        if (has_rest && !s->kinds[k].in_rest)
            list->unseen[list->n_unseen++] = s->kinds[k].name;
}

static nqm_status take(const names *s, size_t n, const nqm_corpus_pair *pairs, nqm_corpus_part part,
                       nqm_corpus_list *list, nqm_error *err) {
    size_t *new_of, *first_in;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&list->refs, s->n_refs, sizeof *list->refs}, {&list->groups, s->n_groups, sizeof *list->groups},
                   {&list->rows, n, sizeof *list->rows}, {&list->unseen, s->n_kinds, sizeof *list->unseen}),
        err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(
            NQM_ARRAYS({&new_of, s->n_refs, sizeof *new_of}, {&first_in, s->n_groups + 1, sizeof *first_in}), err);
    if (status != NQM_OK)
        return status;
    take_refs(s, part, first_in, list, new_of);
    take_rows(s, n, pairs, new_of, list);
    take_unseen(s, list);
    nqm_free(new_of);
    status = nqm_index_create(list->n_refs, key_of_brdf, &list->by_brdf, err);
    for (size_t r = 0; status == NQM_OK && r < list->n_refs; ++r)
        nqm_index_add(&list->by_brdf, &list->refs[r]);
    if (status == NQM_OK && list->n_rows == 0)
        status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the list has no pair of this part (%s)",
                          part == NQM_CORPUS_TEST ? "test" : "train, validation");
    return status;
}

nqm_status nqm_corpus_list_make(size_t n, const nqm_corpus_pair *pairs, const nqm_corpus_options *options,
                                nqm_corpus_list *list_ret, nqm_error *err) {
    names s = {0};
    *list_ret = (nqm_corpus_list){.root = options->root};
    nqm_status status = names_begin(n, &s, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = add_pair(&s, i, &pairs[i], err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = check_other(&s, i, &pairs[i], err);
    if (status == NQM_OK)
        status = take(&s, n, pairs, options->part, list_ret, err);
    names_end(&s);
    if (status != NQM_OK)
        nqm_corpus_list_free(list_ret);
    return status;
}

void nqm_corpus_list_free(nqm_corpus_list *list) {
    nqm_free(list->refs);
    nqm_index_free(&list->by_brdf);
    *list = (nqm_corpus_list){0};
}
