/* SPDX-License-Identifier: MIT
 *
 * Builds a dataset row by row, for every source of pairs except nqm's own file. All arrays are stored in one memory
 * block. Names are copied; a name that was added before is found again.
 */
#include "data/data.h"

#include <string.h>

/* d is zeroed: the arrays that it does not have stay NULL. */
static nqm_status allocate_arrays(const nqm_dataset_limits *l, nqm_dataset *d, nqm_error *err) {
    const size_t n = l->n_directions, r = l->max_refs, p = l->max_pairs;
    return nqm_alloc_arrays(
        NQM_ARRAYS(
            {&d->block, 0, 1}, {l->borrows_samples ? NULL : &d->ref_rgb, r, 3 * n * sizeof *d->ref_rgb},
            {l->borrows_samples ? NULL : &d->test_rgb, p, 3 * n * sizeof *d->test_rgb},
            {l->has_masks ? &d->ref_used : NULL, r, n}, {l->has_masks ? &d->test_used : NULL, p, n},
            {&d->delta_e, p, sizeof *d->delta_e}, {&d->jod, p, sizeof *d->jod},
            {l->has_parts ? &d->parts : NULL, p, NQM_LABEL_PARTS * sizeof *d->parts},
            {l->has_parts ? &d->delta_e_error : NULL, p, sizeof *d->delta_e_error},
            {l->has_transport ? &d->transport : NULL, n, 3 * NQM_TRANSPORT_POINTS * sizeof *d->transport},
            {l->has_transport ? &d->transport_points : NULL, NQM_TRANSPORT_POINTS, 3 * sizeof *d->transport_points},
            {&d->pair_ref, p, sizeof *d->pair_ref}, {&d->pair_kind, p, sizeof *d->pair_kind},
            {&d->ref_group, r, sizeof *d->ref_group}, {&d->group_split, r, sizeof *d->group_split}),
        err);
}

nqm_status nqm_dataset_begin(const nqm_dataset_limits *limits, nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
    nqm_dataset *d = nqm_alloc(1, sizeof *d);
    if (!d)
        return nqm_fail_nomem(err, sizeof *d);
    nqm_status status = nqm_directions_from_degrees(limits->n_directions, limits->directions_deg, &d->directions, err);
    if (status == NQM_OK)
        status = allocate_arrays(limits, d, err);
    if (status != NQM_OK) {
        nqm_dataset_free(d);
        return status;
    }
    d->n_directions = limits->n_directions;
    d->directions_deg = d->directions->degrees;
    *dataset_ret = d;
    return NQM_OK;
}

nqm_status nqm_dataset_add_group(nqm_dataset *d, const char *name, size_t n_name, nqm_split split, uint32_t *group_ret,
                                 nqm_error *err) {
    nqm_status status = nqm_names_intern(&d->group_names, name, n_name, group_ret, err);
    if (status == NQM_OK && *group_ret == d->n_groups)
        d->group_split[d->n_groups++] = (uint8_t)split;
    return status;
}

nqm_status nqm_dataset_add_kind(nqm_dataset *d, const char *name, const char *family, uint32_t *kind_ret,
                                nqm_error *err) {
    nqm_status status = nqm_names_intern(&d->kind_names, name, strlen(name), kind_ret, err);
    if (status == NQM_OK && *kind_ret == d->n_kinds && family)
        status = nqm_names_add(&d->kind_families, family, strlen(family), err);
    d->n_kinds = d->kind_names.n;
    return status;
}

nqm_status nqm_dataset_add_reference(nqm_dataset *d, const char *name, uint32_t group, nqm_error *err) {
    d->ref_group[d->n_refs++] = group;
    return nqm_names_add(&d->ref_names, name, strlen(name), err);
}

nqm_status nqm_dataset_add_pair(nqm_dataset *d, uint32_t ref, const char *test, uint32_t kind, double delta_e,
                                double jod, nqm_error *err) {
    d->pair_ref[d->n_pairs] = ref;
    d->pair_kind[d->n_pairs] = kind;
    d->delta_e[d->n_pairs] = delta_e;
    d->jod[d->n_pairs++] = jod;
    return nqm_names_add(&d->pair_names, test, strlen(test), err);
}

nqm_status nqm_dataset_finish(nqm_dataset *d, nqm_status status, const char *manifest, const char *name,
                              nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
    if (status == NQM_OK)
        status = nqm_dataset_set_manifest(d, manifest, err);
    if (status == NQM_OK && name)
        status = nqm_dataset_validate(d, name, err);
    if (status == NQM_OK)
        status = nqm_dataset_hash(d, d->sha256, err);
    if (status == NQM_OK)
        *dataset_ret = d;
    else
        nqm_dataset_free(d);
    return status;
}
