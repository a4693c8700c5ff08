/* SPDX-License-Identifier: MIT
 *
 * Functions for datasets from any source: validation, properties, memory size and release.
 */
#include "data/data.h"
#include "io/json.h"

#include <math.h>
#include <string.h>

/* ---- arrays ------------------------------------------------------------------------------------------------------ */

#define FIELD(member) offsetof(nqm_dataset, member)

/* Their order is that of the file and of nqm_dataset_hash(). */
static const struct {
    const char *name;
    nqm_dtype dtype;
    size_t offset, n_offset; /* positions of the pointer and of the number of rows */
    size_t n_dims;
    size_t n_last; /* the last dimension; 0: n_directions. The dimension between it and the first is n_directions. */
    bool is_optional;
    size_t n_rows; /* 0: the number at n_offset */
} arrays[NQM_DATASET_ARRAYS] = {
    {"directions_deg", NQM_F64, FIELD(directions_deg), FIELD(n_directions), 2, 3, false, 0},
    {"ref_rgb", NQM_F32, FIELD(ref_rgb), FIELD(n_refs), 3, 3, false, 0},
    {"test_rgb", NQM_F32, FIELD(test_rgb), FIELD(n_pairs), 3, 3, false, 0},
    {"ref_used", NQM_U8, FIELD(ref_used), FIELD(n_refs), 2, 0, true, 0},
    {"test_used", NQM_U8, FIELD(test_used), FIELD(n_pairs), 2, 0, true, 0},
    {"pair_ref", NQM_U32, FIELD(pair_ref), FIELD(n_pairs), 1, 0, false, 0},
    {"pair_kind", NQM_U32, FIELD(pair_kind), FIELD(n_pairs), 1, 0, false, 0},
    {"delta_e", NQM_F64, FIELD(delta_e), FIELD(n_pairs), 1, 0, false, 0},
    {"jod", NQM_F64, FIELD(jod), FIELD(n_pairs), 1, 0, false, 0},
    {"ref_group", NQM_U32, FIELD(ref_group), FIELD(n_refs), 1, 0, false, 0},
    {"group_split", NQM_U8, FIELD(group_split), FIELD(n_groups), 1, 0, false, 0},
    {"parts", NQM_F64, FIELD(parts), FIELD(n_pairs), 2, NQM_LABEL_PARTS, true, 0},
    {"delta_e_error", NQM_F64, FIELD(delta_e_error), FIELD(n_pairs), 1, 0, true, 0},
    {"transport", NQM_F32, FIELD(transport), FIELD(n_directions), 2, 3 * NQM_TRANSPORT_POINTS, true, 0},
    {"transport.points", NQM_F64, FIELD(transport_points), 0, 2, 3, true, NQM_TRANSPORT_POINTS},
};

nqm_tensor nqm_dataset_array(const nqm_dataset *d, size_t i) {
    const char *fields = (const char *)d;
    nqm_tensor t = {.name = arrays[i].name, .dtype = arrays[i].dtype, .n_dims = arrays[i].n_dims};
    memcpy(&t.data, fields + arrays[i].offset, sizeof t.data);
    t.dims[0] = arrays[i].n_rows;
    if (!t.dims[0])
        memcpy(&t.dims[0], fields + arrays[i].n_offset, sizeof t.dims[0]);
    for (size_t k = 1; k < t.n_dims; ++k)
        t.dims[k] = arrays[i].n_last && k + 1 == t.n_dims ? arrays[i].n_last : d->n_directions;
    nqm_tensor_measure(&t);
    return t;
}

bool nqm_dataset_array_is_optional(size_t i) {
    return arrays[i].is_optional;
}

void nqm_dataset_set_array(nqm_dataset *d, size_t i, const void *values) {
    memcpy((char *)d + arrays[i].offset, &values, sizeof values);
}

/* ---- validation -------------------------------------------------------------------------------------------------- */

static const double max_jod = 11; /* human scores of the paper's study reach 10.26 */

static nqm_status check_counts(const nqm_dataset *d, const char *name, nqm_error *err) {
    const struct {
        const char *what;
        size_t n;
    } counts[] = {{"directions", d->n_directions},
                  {"references", d->n_refs},
                  {"material groups", d->n_groups},
                  {"kinds", d->n_kinds},
                  {"pairs", d->n_pairs}};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        if (counts[i].n == 0)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the dataset has no %s", name, counts[i].what);
        if (counts[i].n > UINT32_MAX)
            return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: %zu %s are too many", name, counts[i].n, counts[i].what);
    }
    return NQM_OK;
}

static nqm_status check_rgb(size_t n_rows, size_t n_columns, const float *rgb, const char *what, const char *name,
                            nqm_error *err) {
    for (size_t i = 0; i < n_rows * n_columns; ++i)
        if (!(rgb[i] >= 0) || isinf(rgb[i]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: %s %zu is %g at direction %zu; f_r must be finite and >= 0",
                            name, what, i / n_columns, (double)rgb[i], i % n_columns / 3);
    return NQM_OK;
}

static nqm_status check_used(size_t n, const uint8_t *used, const char *what, const char *name, nqm_error *err) {
    for (size_t i = 0; used && i < n; ++i)
        if (used[i] > 1)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: %s[%zu] is %d, not 0 or 1", name, what, i, used[i]);
    return NQM_OK;
}

/* Whether both BRDFs of a pair have a value at direction k. */
static bool is_used(const nqm_dataset *d, size_t pair, size_t k) {
    return (!d->ref_used || d->ref_used[d->pair_ref[pair] * d->n_directions + k]) &&
           (!d->test_used || d->test_used[pair * d->n_directions + k]);
}

static nqm_status check_pairs_used(const nqm_dataset *d, const char *name, nqm_error *err) {
    for (size_t pair = 0; (d->ref_used || d->test_used) && pair < d->n_pairs; ++pair) {
        size_t k = 0;
        while (k < d->n_directions && !is_used(d, pair, k))
            ++k;
        if (k == d->n_directions)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: pair %zu has no direction with a value", name, pair);
    }
    return NQM_OK;
}

static nqm_status check_indices(size_t n, const uint32_t *index, size_t limit, const char *what, const char *name,
                                nqm_error *err) {
    for (size_t i = 0; i < n; ++i)
        if (index[i] >= limit)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: %s[%zu] is %lu, there are %zu", name, what, i,
                            (unsigned long)index[i], limit);
    return NQM_OK;
}

static nqm_status check_labels(const nqm_dataset *d, const char *name, nqm_error *err) {
    for (size_t i = 0; !d->order_only && i < d->n_pairs; ++i) {
        if (!(d->delta_e[i] >= 0) || isinf(d->delta_e[i]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: Delta-E of pair %zu is %g, it must be finite and >= 0", name,
                            i, d->delta_e[i]);
        if (!(d->jod[i] >= 0 && d->jod[i] <= max_jod))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: JOD of pair %zu is %g, outside 0..%g", name, i, d->jod[i],
                            max_jod);
    }
    for (size_t i = 0; d->delta_e_error && i < d->n_pairs; ++i)
        if (!(d->delta_e_error[i] >= 0) || isinf(d->delta_e_error[i]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: delta_e_error of pair %zu is %g, it must be finite and >= 0",
                            name, i, d->delta_e_error[i]);
    for (size_t i = 0; d->parts && i < d->n_pairs * NQM_LABEL_PARTS; ++i)
        if (!isfinite(d->parts[i]))
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: parts of the label of pair %zu are not finite", name,
                            i / NQM_LABEL_PARTS);
    for (size_t i = 0; i < d->n_groups; ++i)
        if (d->group_split[i] > NQM_SPLIT_TEST)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: group_split[%zu] is %d; 0, 1 and 2 are known", name, i,
                            d->group_split[i]);
    return NQM_OK;
}

nqm_status nqm_dataset_validate(const nqm_dataset *d, const char *name, nqm_error *err) {
    size_t n_columns = 3 * d->n_directions;
    const nqm_transport transport = nqm_dataset_transport(d);
    const char *fault = NULL;
    nqm_status status = check_counts(d, name, err);
    if (status == NQM_OK)
        status = check_indices(d->n_pairs, d->pair_ref, d->n_refs, "pair_ref", name, err);
    if (status == NQM_OK)
        status = check_indices(d->n_pairs, d->pair_kind, d->n_kinds, "pair_kind", name, err);
    if (status == NQM_OK)
        status = check_indices(d->n_refs, d->ref_group, d->n_groups, "ref_group", name, err);
    if (status == NQM_OK)
        status = check_labels(d, name, err);
    if (status == NQM_OK && (fault = nqm_transport_fault(&transport, true)))
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: %s", name, fault);
    if (status == NQM_OK)
        status = check_used(d->n_refs * d->n_directions, d->ref_used, "ref_used", name, err);
    if (status == NQM_OK)
        status = check_used(d->n_pairs * d->n_directions, d->test_used, "test_used", name, err);
    if (status == NQM_OK)
        status = check_pairs_used(d, name, err);
    if (status == NQM_OK)
        status = check_rgb(d->n_refs, n_columns, d->ref_rgb, "reference", name, err);
    if (status == NQM_OK)
        status = check_rgb(d->n_pairs, n_columns, d->test_rgb, "the test of pair", name, err);
    return status;
}

/* ---- facts ------------------------------------------------------------------------------------------------------- */

nqm_status nqm_dataset_hash(const nqm_dataset *d, char sha256_ret[65], nqm_error *err) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        return nqm_fail_nomem(err, sizeof sha);
    const uint64_t counts[] = {d->n_directions, d->n_refs, d->n_groups, d->n_kinds, d->n_pairs};
    nqm_sha256_add_values(&sha, sizeof counts / sizeof *counts, sizeof *counts, counts);
    for (size_t i = 0; i < NQM_DATASET_ARRAYS; ++i) {
        const nqm_tensor t = nqm_dataset_array(d, i);
        if (t.data)
            nqm_sha256_add_values(&sha, nqm_tensor_count(&t), nqm_dtype_size(t.dtype), t.data);
    }
    nqm_sha256_end(&sha, sha256_ret);
    return NQM_OK;
}

void nqm_dataset_free(nqm_dataset *dataset) {
    if (!dataset)
        return;
    nqm_directions_free(dataset->directions);
    nqm_names_free(&dataset->ref_names);
    nqm_names_free(&dataset->group_names);
    nqm_names_free(&dataset->kind_names);
    nqm_names_free(&dataset->kind_families);
    nqm_names_free(&dataset->ref_sources);
    nqm_names_free(&dataset->pair_names);
    nqm_free(dataset->manifest);
    nqm_free(dataset->block);
    nqm_map_close(&dataset->file);
    nqm_free(dataset);
}

nqm_dataset_info nqm_dataset_get_info(const nqm_dataset *dataset) {
    assert(dataset);
    nqm_dataset_info info = {.n_directions = dataset->n_directions,
                             .n_refs = dataset->n_refs,
                             .n_groups = dataset->n_groups,
                             .n_pairs = dataset->n_pairs,
                             .n_kinds = dataset->n_kinds,
                             .sha256 = dataset->sha256,
                             .manifest = dataset->manifest ? dataset->manifest : "",
                             .directions = dataset->directions};
    for (size_t i = 0; i < dataset->n_pairs; ++i)
        ++info.n_pairs_in[nqm_dataset_pair_split(dataset, i)];
    return info;
}

nqm_dataset_kind nqm_dataset_get_kind(const nqm_dataset *d, size_t i) {
    assert(d);
    if (i >= d->n_kinds)
        return (nqm_dataset_kind){NULL, NULL};
    return (nqm_dataset_kind){nqm_name(&d->kind_names, i), d->kind_families.n ? nqm_name(&d->kind_families, i) : ""};
}

nqm_dataset_pair nqm_dataset_get_pair(const nqm_dataset *d, size_t i) {
    assert(d);
    uint32_t ref = d->pair_ref[i];
    const nqm_dataset_kind kind = nqm_dataset_get_kind(d, d->pair_kind[i]);
    return (nqm_dataset_pair){.ref = nqm_name(&d->ref_names, ref),
                              .group = nqm_name(&d->group_names, d->ref_group[ref]),
                              .test = nqm_name(&d->pair_names, i),
                              .kind = kind.name,
                              .material_class = nqm_material_class_name(nqm_dataset_ref_class(d, ref)),
                              .family = kind.family,
                              .source = nqm_dataset_ref_source(d, ref),
                              .split = nqm_dataset_pair_split(d, i),
                              .delta_e = d->delta_e[i],
                              .jod = d->jod[i]};
}

nqm_sample_pair nqm_dataset_samples(const nqm_dataset *d, size_t pair, uint8_t *scratch) {
    const size_t n = 3 * d->n_directions;
    const bool has_masks = d->ref_used || d->test_used;
    for (size_t i = 0; has_masks && i < d->n_directions; ++i)
        scratch[i] = is_used(d, pair, i);
    return (nqm_sample_pair){d->ref_rgb + d->pair_ref[pair] * n, d->test_rgb + pair * n, has_masks ? scratch : NULL};
}

/* ---- what the manifest of a corpus says: unseen kinds, sources of references, whether pairs may be anisotropic --- */

nqm_status nqm_dataset_unseen_kinds(const nqm_dataset *d, bool *unseen, nqm_error *err) {
    json_t *manifest;
    const nqm_status status = nqm_json_parse(d->manifest, &manifest, err);
    const json_t *names = json_object_get(manifest, "unseen_kinds");
    for (size_t kind = 0; kind < d->n_kinds; ++kind) {
        unseen[kind] = false;
        for (size_t i = 0; i < json_array_size(names); ++i) {
            const char *name = json_string_value(json_array_get(names, i));
            unseen[kind] = unseen[kind] || (name && strcmp(name, nqm_name(&d->kind_names, kind)) == 0);
        }
    }
    json_decref(manifest);
    return status;
}

/* ---- sources ----------------------------------------------------------------------------------------------------- */

/* Words of manifests, also as the beginning of words like "rgl-unfolded", and the groups that they belong to. */
static const struct {
    const char *word, *group;
} sources[] = {{"rgl", "measured"}, {"merl", "measured"}, {"nbrdf", "neural"}, {"nps", "neural"}, {"sgd", "analytic"}};

static const char *group_of(const char *source) {
    const size_t n = strcspn(source, "-");
    for (size_t i = 0; i < sizeof sources / sizeof *sources; ++i)
        if (strlen(sources[i].word) == n && strncmp(source, sources[i].word, n) == 0)
            return sources[i].group;
    return source;
}

nqm_status nqm_dataset_set_manifest(nqm_dataset *d, const char *text, nqm_error *err) {
    json_t *manifest;
    d->manifest = text ? nqm_strdup(text) : NULL;
    if (text && !d->manifest)
        return nqm_fail_nomem(err, strlen(text));
    nqm_status status = nqm_json_parse(d->manifest, &manifest, err);
    if (status != NQM_OK)
        return status;
    const json_t *references = json_object_get(manifest, "references");
    d->is_anisotropic = json_is_true(json_object_get(manifest, "anisotropic"));
    bool is_listed = json_array_size(references) == d->n_refs;
    for (size_t i = 0; is_listed && status == NQM_OK && i < d->n_refs; ++i) {
        const json_t *row = json_array_get(references, i), *source = json_object_get(row, "source");
        const char *name = json_string_value(json_object_get(row, "name"));
        is_listed = name && json_is_string(source) && strcmp(name, nqm_name(&d->ref_names, i)) == 0;
        if (is_listed)
            status = nqm_names_add(&d->ref_sources, json_string_value(source), json_string_length(source), err);
    }
    json_decref(manifest);
    if (!is_listed)
        nqm_names_free(&d->ref_sources);
    return status;
}

nqm_status nqm_dataset_check_isotropic(const nqm_dataset *d, nqm_error *err) {
    return d->is_anisotropic
               ? nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                          "its pairs are anisotropic and its samples of one azimuth; the model 'anisotropic' opens the "
                          "BRDFs themselves")
               : NQM_OK;
}

const char *nqm_dataset_ref_source(const nqm_dataset *d, size_t ref) {
    return d->ref_sources.n ? group_of(nqm_name(&d->ref_sources, ref)) : "";
}
