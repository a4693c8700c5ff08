/* SPDX-License-Identifier: MIT
 *
 * Builds a dataset row by row, for every source of pairs except nqm's own file. All arrays are stored in one memory
 * block. Names are copied; a name that was added before is found again.
 */
#include "data/data.h"

#include <string.h>

/* Reserve the next n * size bytes of the block, 64-byte aligned. base NULL: only advance *at to compute the size. */
static void *take(unsigned char *base, size_t *at, size_t n, size_t size) {
    enum { ALIGNMENT = 64 };
    void *part = base ? base + *at : NULL;
    size_t n_bytes = 0;
    if (!nqm_mul_size(n, size, &n_bytes) || __builtin_add_overflow(*at, n_bytes + ALIGNMENT, at))
        *at = SIZE_MAX / 2; /* overflow: nqm_alloc() fails for this size */
    *at = *at / ALIGNMENT * ALIGNMENT;
    return part;
}

/* Set the array pointers into the block at `base` (NULL: none); returns the block's size in bytes. */
static size_t lay_out(const nqm_dataset_limits *l, unsigned char *base, nqm_dataset_builder *b) {
    const size_t n = l->n_directions, r = l->max_refs, p = l->max_pairs;
    size_t at = 0;
    if (!l->borrows_samples) {
        b->ref_rgb = take(base, &at, r, 3 * n * sizeof *b->ref_rgb);
        b->test_rgb = take(base, &at, p, 3 * n * sizeof *b->test_rgb);
    }
    if (l->has_masks) {
        b->ref_used = take(base, &at, r, n);
        b->test_used = take(base, &at, p, n);
    }
    b->delta_e = take(base, &at, p, sizeof *b->delta_e);
    b->jod = take(base, &at, p, sizeof *b->jod);
    b->pair_ref = take(base, &at, p, sizeof *b->pair_ref);
    b->pair_kind = take(base, &at, p, sizeof *b->pair_kind);
    b->ref_group = take(base, &at, r, sizeof *b->ref_group);
    b->group_split = take(base, &at, r, sizeof *b->group_split);
    return at;
}

nqm_status nqm_dataset_begin(const nqm_dataset_limits *limits, nqm_dataset_builder *builder_ret, nqm_error *err) {
    nqm_dataset_builder b = {.max_refs = limits->max_refs, .max_pairs = limits->max_pairs};
    const size_t n_bytes = lay_out(limits, NULL, &b);
    *builder_ret = (nqm_dataset_builder){0};
    nqm_dataset *d = b.dataset = nqm_alloc(1, sizeof *d);
    if (!d || !(d->block = nqm_alloc(n_bytes, 1))) {
        nqm_dataset_free(d);
        return nqm_fail_nomem(err, n_bytes);
    }
    lay_out(limits, d->block, &b);
    d->n_directions = limits->n_directions;
    nqm_status status = nqm_directions_from_degrees(d->n_directions, limits->directions_deg, &d->directions, err);
    if (status != NQM_OK) {
        nqm_dataset_free(d);
        return status;
    }
    d->directions_deg = nqm_directions_degrees(d->directions);
    d->pair_ref = b.pair_ref;
    d->pair_kind = b.pair_kind;
    d->delta_e = b.delta_e;
    d->jod = b.jod;
    d->ref_group = b.ref_group;
    d->group_split = b.group_split;
    *builder_ret = b;
    return NQM_OK;
}

nqm_status nqm_dataset_add_group(nqm_dataset_builder *b, const char *name, size_t n_name, nqm_split split,
                                 uint32_t *group_ret, nqm_error *err) {
    nqm_status status = nqm_names_intern(&b->dataset->group_names, name, n_name, group_ret, err);
    if (status == NQM_OK && *group_ret == b->dataset->n_groups) {
        if (b->dataset->n_groups == b->max_refs)
            return nqm_fail(err, NQM_ERR_LIMIT, -1, "more material groups than the %zu references", b->max_refs);
        b->group_split[b->dataset->n_groups++] = (uint8_t)split;
    }
    return status;
}

nqm_status nqm_dataset_add_kind(nqm_dataset_builder *b, const char *name, const char *family, uint32_t *kind_ret,
                                nqm_error *err) {
    nqm_dataset *d = b->dataset;
    nqm_status status = nqm_names_intern(&d->kind_names, name, strlen(name), kind_ret, err);
    if (status == NQM_OK && *kind_ret == d->n_kinds && family)
        status = nqm_names_add(&d->kind_families, family, strlen(family), err);
    d->n_kinds = d->kind_names.n;
    return status;
}

nqm_status nqm_dataset_add_reference(nqm_dataset_builder *b, const char *name, uint32_t group, nqm_error *err) {
    nqm_dataset *d = b->dataset;
    if (d->n_refs == b->max_refs)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "more than the %zu references announced", b->max_refs);
    b->ref_group[d->n_refs++] = group;
    return nqm_names_add(&d->ref_names, name, strlen(name), err);
}

nqm_status nqm_dataset_add_pair(nqm_dataset_builder *b, uint32_t ref, const char *test, uint32_t kind, double delta_e,
                                double jod, nqm_error *err) {
    nqm_dataset *d = b->dataset;
    if (d->n_pairs == b->max_pairs)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "more than the %zu pairs announced", b->max_pairs);
    b->pair_ref[d->n_pairs] = ref;
    b->pair_kind[d->n_pairs] = kind;
    b->delta_e[d->n_pairs] = delta_e;
    b->jod[d->n_pairs++] = jod;
    return nqm_names_add(&d->pair_names, test, strlen(test), err);
}

nqm_status nqm_dataset_finish(nqm_dataset_builder *b, nqm_status status, const char *manifest, const char *name,
                              nqm_dataset **dataset_ret, nqm_error *err) {
    nqm_dataset *d = b->dataset;
    *dataset_ret = NULL;
    if (status == NQM_OK) {
        d->ref_rgb = b->ref_rgb;
        d->test_rgb = b->test_rgb;
        d->ref_used = b->ref_used;
        d->test_used = b->test_used;
        if (manifest && !(d->manifest = nqm_strdup(manifest)))
            status = nqm_fail_nomem(err, strlen(manifest));
    }
    if (status == NQM_OK && name)
        status = nqm_dataset_validate(d, name, err);
    if (status == NQM_OK)
        status = nqm_dataset_hash(d, d->sha256, err);
    if (status == NQM_OK)
        *dataset_ret = d;
    else
        nqm_dataset_free(d);
    *b = (nqm_dataset_builder){0};
    return status;
}
