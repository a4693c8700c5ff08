/* SPDX-License-Identifier: MIT
 *
 * nqm's own dataset file: a safetensors file with the arrays of struct nqm_dataset under their member names, and the
 * names of references, groups, kinds and tests as JSON arrays in the metadata (doc/files.md). The dataset points into
 * the mapped file; nothing is copied.
 */
#include "data/data.h"
#include "io/json.h"

#include <string.h>

static const char format_name[] = "nqm-dataset", schema[] = "1";

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static nqm_status fail_missing(const char *name, const char *tensor, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the dataset has no tensor '%s'", name, tensor);
}

/* Point the i-th array into the file. */
static nqm_status read_array(const nqm_safetensors *st, nqm_dataset *d, size_t i, const char *name, nqm_error *err) {
    const nqm_tensor like = nqm_dataset_array(d, i), *t = nqm_safetensors_find(st, like.name);
    if (!t)
        return nqm_dataset_array_is_optional(i) ? NQM_OK : fail_missing(name, like.name, err);
    if (t->dtype != like.dtype || t->n_dims != like.n_dims ||
        memcmp(t->dims, like.dims, like.n_dims * sizeof *t->dims) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, t->byte_offset,
                        "%s: tensor '%s' (byte %lld) does not have the type and shape that the other tensors require",
                        name, like.name, (long long)t->byte_offset);
    if ((uintptr_t)t->data % nqm_dtype_size(like.dtype) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, t->byte_offset,
                        "%s: tensor '%s' begins at byte %lld, which is not aligned", name, like.name,
                        (long long)t->byte_offset);
    nqm_dataset_set_array(d, i, t->data);
    return NQM_OK;
}

static nqm_status read_arrays(const nqm_safetensors *st, nqm_dataset *d, const char *name, nqm_error *err) {
    /* Counts are the first dimensions of tensors with one row per item. */
    const struct {
        const char *tensor;
        size_t *n;
    } counts[] = {{"directions_deg", &d->n_directions},
                  {"ref_rgb", &d->n_refs},
                  {"test_rgb", &d->n_pairs},
                  {"group_split", &d->n_groups}};
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        const nqm_tensor *t = nqm_safetensors_find(st, counts[i].tensor);
        if (!t || !t->n_dims)
            return fail_missing(name, counts[i].tensor, err);
        *counts[i].n = t->dims[0];
    }
    for (size_t i = 0; status == NQM_OK && i < NQM_DATASET_ARRAYS; ++i)
        status = read_array(st, d, i, name, err);
    return status;
}

/* A list of names in the metadata. */
typedef struct name_list {
    const char *key;
    const size_t *n; /* the number of names; NULL: any */
    nqm_names *names;
} name_list;

enum { N_LISTS = 5 };

static void list_names(nqm_dataset *d, name_list lists[N_LISTS]) {
    const name_list list[N_LISTS] = {{"ref_names", &d->n_refs, &d->ref_names},
                                     {"group_names", &d->n_groups, &d->group_names},
                                     {"kind_names", NULL, &d->kind_names},
                                     {"pair_names", &d->n_pairs, &d->pair_names},
                                     {"kind_families", &d->kind_names.n, &d->kind_families}};
    memcpy(lists, list, sizeof list);
}

/* Read a metadata value that is a JSON array of strings. */
static nqm_status read_names(const nqm_safetensors *st, const name_list *list, const char *name, nqm_error *err) {
    const char *text = nqm_safetensors_meta(st, list->key);
    json_t *array;
    nqm_status status = nqm_json_parse(text, &array, err);
    if (status != NQM_OK)
        return status;
    const size_t n = list->n ? *list->n : json_array_size(array);
    if (!json_is_array(array) || json_array_size(array) != n)
        status =
            nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: metadata '%s' is not a JSON array of %zu names", name, list->key, n);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        const json_t *item = json_array_get(array, i);
        status = json_is_string(item)
                     ? nqm_names_add(list->names, json_string_value(item), json_string_length(item), err)
                     : nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: metadata '%s' has an element that is no string", name,
                                list->key);
    }
    json_decref(array);
    return status;
}

static nqm_status read_dataset(const nqm_safetensors *st, bool verify_checksum, nqm_dataset *d, const char *name,
                               nqm_error *err) {
    const char *format = nqm_safetensors_meta(st, "format");
    if (!format || strcmp(format, format_name) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, -1,
                        "%s: a safetensors file, but no nqm dataset (metadata 'format' is '%.40s')", name,
                        format ? format : "missing");
    nqm_status status = nqm_safetensors_verify(st, schema, verify_checksum, NQM_ERR_FORMAT, err);
    if (status == NQM_OK)
        status = read_arrays(st, d, name, err);
    name_list lists[N_LISTS];
    list_names(d, lists);
    const size_t n_lists =
        nqm_safetensors_meta(st, "kind_families") ? N_LISTS : N_LISTS - 1; /* absent in older files */
    for (size_t i = 0; status == NQM_OK && i < n_lists; ++i)
        status = read_names(st, &lists[i], name, err);
    d->n_kinds = d->kind_names.n;
    if (status == NQM_OK)
        status = nqm_dataset_set_manifest(d, nqm_safetensors_meta(st, "manifest"), err);
    if (status == NQM_OK)
        status = nqm_dataset_validate(d, name, err);
    if (status == NQM_OK)
        status = nqm_directions_from_degrees(d->n_directions, d->directions_deg, &d->directions, err);
    const char *stored = nqm_safetensors_meta(st, "sha256");
    if (status == NQM_OK && stored && strlen(stored) == sizeof d->sha256 - 1)
        strcpy(d->sha256, stored);
    return status;
}

nqm_status nqm_dataset_parse(const unsigned char *data, size_t n_bytes, const char *name, bool verify_checksum,
                             nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
    nqm_safetensors *st = NULL;
    nqm_dataset *d = nqm_alloc(1, sizeof *d);
    nqm_status status = d ? nqm_safetensors_parse(data, n_bytes, name, &st, err) : nqm_fail_nomem(err, sizeof *d);
    if (status == NQM_OK)
        status = read_dataset(st, verify_checksum, d, name, err);
    if (status == NQM_OK)
        d->block = nqm_safetensors_take(st);
    nqm_safetensors_free(st);
    if (status == NQM_OK)
        *dataset_ret = d;
    else
        nqm_dataset_free(d);
    return status;
}

nqm_status nqm_dataset_load(const char *path, const char *labels_csv, nqm_split split, nqm_dataset **dataset_ret,
                            nqm_error *err) {
    NQM_MAKE(err, dataset_ret, path);
    if (labels_csv)
        return nqm_dataset_read_authors(path, labels_csv, split, dataset_ret, err);
    nqm_map map;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status != NQM_OK)
        return status;
    status = nqm_dataset_parse(map.data, map.n_bytes, path, true, dataset_ret, err);
    map.path = NULL; /* the string belongs to the caller */
    if (status == NQM_OK)
        (*dataset_ret)->file = map;
    else
        nqm_map_close(&map);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static char *names_to_json(const nqm_names *names) {
    json_t *array = json_array();
    for (size_t i = 0; array && i < names->n; ++i)
        if (json_array_append_new(array, json_string(nqm_name(names, i))) != 0) {
            json_decref(array);
            array = NULL;
        }
    return nqm_json_text(array, 17);
}

nqm_status nqm_dataset_write(const nqm_dataset *d, const char *path, char sha256_ret[65], nqm_error *err) {
    nqm_status status = nqm_dataset_validate(d, path, err);
    if (status != NQM_OK)
        return status;
    name_list lists[N_LISTS];
    list_names((nqm_dataset *)(uintptr_t)d, lists); /* the names are only read */
    nqm_meta meta[N_LISTS + 3] = {{"format", format_name}, {"schema", schema}};
    char *texts[N_LISTS] = {0};
    size_t n_meta = 2, n_tensors = 0;
    for (size_t i = 0; status == NQM_OK && i < (d->kind_families.n ? N_LISTS : N_LISTS - 1); ++i) {
        meta[n_meta++] = (nqm_meta){lists[i].key, texts[i] = names_to_json(lists[i].names)};
        if (!texts[i])
            status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: a name is not UTF-8, or memory is short", path);
    }
    if (d->manifest)
        meta[n_meta++] = (nqm_meta){"manifest", d->manifest};
    nqm_tensor tensors[NQM_DATASET_ARRAYS];
    for (size_t i = 0; i < NQM_DATASET_ARRAYS; ++i) {
        tensors[n_tensors] = nqm_dataset_array(d, i);
        n_tensors += tensors[n_tensors].data != NULL;
    }
    if (status == NQM_OK)
        status = nqm_safetensors_write(path, n_tensors, tensors, n_meta, meta, sha256_ret, err);
    for (size_t i = 0; i < N_LISTS; ++i)
        nqm_free(texts[i]);
    return status;
}
