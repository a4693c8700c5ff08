/* SPDX-License-Identifier: MIT
 *
 * nqm's own dataset file: a safetensors file with the arrays of struct nqm_dataset under their member names, and the
 * names of references, groups, kinds and tests as JSON arrays in the metadata (doc/files.md). The dataset points into
 * the mapped file; nothing is copied.
 */
#include "data/data.h"
#include "io/io.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "tensors are used as they lie in the file: little-endian");

static const char format_name[] = "nqm-dataset", schema[] = "1";

/* ---- the tensors of the file ------------------------------------------------------------------------------------- */

enum {
    DIRECTIONS,
    REF_RGB,
    TEST_RGB,
    REF_USED,
    TEST_USED,
    PAIR_REF,
    PAIR_KIND,
    DELTA_E,
    JOD,
    REF_GROUP,
    GROUP_SPLIT,
    N_COLUMNS
};

typedef struct column {
    const char *name;
    nqm_dtype dtype;
    bool optional;
    size_t n_dims, dims[3];
    const void *data;
} column;

static void list_columns(const nqm_dataset *d, column columns[N_COLUMNS]) {
    const size_t n = d->n_directions, r = d->n_refs, p = d->n_pairs;
    const column list[N_COLUMNS] = {
        [DIRECTIONS] = {"directions_deg", NQM_F64, false, 2, {n, 3}, d->directions_deg},
        [REF_RGB] = {"ref_rgb", NQM_F32, false, 3, {r, n, 3}, d->ref_rgb},
        [TEST_RGB] = {"test_rgb", NQM_F32, false, 3, {p, n, 3}, d->test_rgb},
        [REF_USED] = {"ref_used", NQM_U8, true, 2, {r, n}, d->ref_used},
        [TEST_USED] = {"test_used", NQM_U8, true, 2, {p, n}, d->test_used},
        [PAIR_REF] = {"pair_ref", NQM_U32, false, 1, {p}, d->pair_ref},
        [PAIR_KIND] = {"pair_kind", NQM_U32, false, 1, {p}, d->pair_kind},
        [DELTA_E] = {"delta_e", NQM_F64, false, 1, {p}, d->delta_e},
        [JOD] = {"jod", NQM_F64, false, 1, {p}, d->jod},
        [REF_GROUP] = {"ref_group", NQM_U32, false, 1, {r}, d->ref_group},
        [GROUP_SPLIT] = {"group_split", NQM_U8, false, 1, {d->n_groups}, d->group_split},
    };
    memcpy(columns, list, sizeof list);
}

static size_t dtype_size(nqm_dtype dtype) {
    return dtype == NQM_F64 || dtype == NQM_I64 ? 8 : dtype == NQM_U8 ? 1 : 4;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* Read a count from the first dimension of `tensor`, which has one row per item. */
static nqm_status read_count(const nqm_safetensors *st, const char *tensor, size_t *n_ret, const char *name,
                             nqm_error *err) {
    const nqm_tensor *t = nqm_safetensors_find(st, tensor);
    if (!t || t->n_dims == 0)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the dataset has no tensor '%s'", name, tensor);
    *n_ret = t->dims[0];
    return NQM_OK;
}

static nqm_status read_column(const nqm_safetensors *st, column *c, const char *name, nqm_error *err) {
    const nqm_tensor *t = nqm_safetensors_find(st, c->name);
    c->data = NULL;
    if (!t && c->optional)
        return NQM_OK;
    if (!t)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the dataset has no tensor '%s'", name, c->name);
    if (t->dtype != c->dtype || t->n_dims != c->n_dims || memcmp(t->dims, c->dims, c->n_dims * sizeof *c->dims) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, t->byte_offset,
                        "%s: tensor '%s' (byte %lld) has another type or shape than %s", name, c->name,
                        (long long)t->byte_offset, "the rest of the dataset asks for");
    if ((uintptr_t)t->data % dtype_size(c->dtype) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, t->byte_offset,
                        "%s: tensor '%s' begins at byte %lld, which is not aligned", name, c->name,
                        (long long)t->byte_offset);
    c->data = t->data;
    return NQM_OK;
}

static nqm_status read_columns(const nqm_safetensors *st, nqm_dataset *d, const char *name, nqm_error *err) {
    nqm_status status = read_count(st, "directions_deg", &d->n_directions, name, err);
    if (status == NQM_OK)
        status = read_count(st, "ref_rgb", &d->n_refs, name, err);
    if (status == NQM_OK)
        status = read_count(st, "test_rgb", &d->n_pairs, name, err);
    if (status == NQM_OK)
        status = read_count(st, "group_split", &d->n_groups, name, err);
    column columns[N_COLUMNS];
    list_columns(d, columns);
    for (size_t i = 0; status == NQM_OK && i < N_COLUMNS; ++i)
        status = read_column(st, &columns[i], name, err);
    if (status != NQM_OK)
        return status;
    d->directions_deg = columns[DIRECTIONS].data;
    d->ref_rgb = columns[REF_RGB].data;
    d->test_rgb = columns[TEST_RGB].data;
    d->ref_used = columns[REF_USED].data;
    d->test_used = columns[TEST_USED].data;
    d->pair_ref = columns[PAIR_REF].data;
    d->pair_kind = columns[PAIR_KIND].data;
    d->delta_e = columns[DELTA_E].data;
    d->jod = columns[JOD].data;
    d->ref_group = columns[REF_GROUP].data;
    d->group_split = columns[GROUP_SPLIT].data;
    return NQM_OK;
}

/* Read a metadata value that is a JSON array of n strings. */
static nqm_status read_names(const nqm_safetensors *st, const char *key, size_t n, nqm_names *names, const char *name,
                             nqm_error *err) {
    const char *text = nqm_safetensors_meta(st, key);
    json_t *array = text ? json_loads(text, 0, NULL) : NULL, *item;
    nqm_status status = NQM_OK;
    if (!json_is_array(array) || json_array_size(array) != n)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: metadata '%s' is not a JSON array of %zu names", name, key, n);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        item = json_array_get(array, i);
        status = json_is_string(item) ? nqm_names_add(names, json_string_value(item), json_string_length(item), err)
                                      : nqm_fail(err, NQM_ERR_FORMAT, -1,
                                                 "%s: metadata '%s' has an element that is no string", name, key);
    }
    json_decref(array);
    return status;
}

/* The number of kinds is counted in the metadata, because no tensor has one row per kind. */
static size_t count_kinds(const nqm_safetensors *st) {
    const char *text = nqm_safetensors_meta(st, "kind_names");
    json_t *array = text ? json_loads(text, 0, NULL) : NULL;
    size_t n = json_array_size(array);
    json_decref(array);
    return n;
}

static nqm_status check_identity(const nqm_safetensors *st, bool verify_checksum, const char *name, nqm_error *err) {
    const char *format = nqm_safetensors_meta(st, "format"), *version = nqm_safetensors_meta(st, "schema");
    if (!format || strcmp(format, format_name) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, -1,
                        "%s: a safetensors file, but no nqm dataset (metadata 'format' is '%.40s')", name,
                        format ? format : "missing");
    if (!version || strcmp(version, schema) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: dataset schema '%.40s'; this version of nqm reads schema %s",
                        name, version ? version : "missing", schema);
    char hex[65];
    bool matches = false;
    if (verify_checksum && !(nqm_safetensors_checksum(st, hex, &matches) && matches))
        return nqm_fail(err, NQM_ERR_FORMAT, -1,
                        "%s: the SHA-256 of the content is not the stored one: the file is damaged", name);
    return NQM_OK;
}

static nqm_status read_dataset(const nqm_safetensors *st, bool verify_checksum, nqm_dataset *d, const char *name,
                               nqm_error *err) {
    nqm_status status = check_identity(st, verify_checksum, name, err);
    if (status == NQM_OK)
        status = read_columns(st, d, name, err);
    d->n_kinds = count_kinds(st);
    const struct {
        const char *key;
        size_t n;
        nqm_names *names;
    } lists[] = {{"ref_names", d->n_refs, &d->ref_names},
                 {"group_names", d->n_groups, &d->group_names},
                 {"kind_names", d->n_kinds, &d->kind_names},
                 {"pair_names", d->n_pairs, &d->pair_names},
                 {"kind_families", d->n_kinds, &d->kind_families}};
    const size_t n_lists = nqm_safetensors_meta(st, "kind_families") ? 5 : 4; /* older files have no families */
    for (size_t i = 0; status == NQM_OK && i < n_lists; ++i)
        status = read_names(st, lists[i].key, lists[i].n, lists[i].names, name, err);
    const char *manifest = nqm_safetensors_meta(st, "manifest");
    if (status == NQM_OK && manifest && !(d->manifest = nqm_strdup(manifest)))
        status = nqm_fail_nomem(err, strlen(manifest));
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
    nqm_safetensors_free(st);
    if (status == NQM_OK)
        *dataset_ret = d;
    else
        nqm_dataset_free(d);
    return status;
}

nqm_status nqm_dataset_load(const char *path, nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
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
    char *text = array ? json_dumps(array, JSON_COMPACT) : NULL;
    json_decref(array);
    return text;
}

static size_t list_tensors(const nqm_dataset *d, nqm_tensor tensors[N_COLUMNS]) {
    column columns[N_COLUMNS];
    list_columns(d, columns);
    size_t n = 0;
    for (size_t i = 0; i < N_COLUMNS; ++i) {
        const column *c = &columns[i];
        if (!c->data)
            continue;
        nqm_tensor t = {.name = c->name, .dtype = c->dtype, .n_dims = c->n_dims, .data = c->data};
        t.n_bytes = dtype_size(c->dtype);
        for (size_t k = 0; k < c->n_dims; ++k)
            t.n_bytes *= t.dims[k] = c->dims[k];
        tensors[n++] = t;
    }
    return n;
}

nqm_status nqm_dataset_write(const nqm_dataset *d, const char *path, char sha256_ret[65], nqm_error *err) {
    nqm_status status = nqm_dataset_validate(d, path, err);
    if (status != NQM_OK)
        return status;
    char *refs = names_to_json(&d->ref_names), *groups = names_to_json(&d->group_names);
    char *kinds = names_to_json(&d->kind_names), *pairs = names_to_json(&d->pair_names);
    char *families = d->kind_families.n ? names_to_json(&d->kind_families) : NULL;
    nqm_meta meta[8] = {{"format", format_name}, {"schema", schema},    {"ref_names", refs},
                        {"group_names", groups}, {"kind_names", kinds}, {"pair_names", pairs}};
    size_t n_meta = 6;
    if (families)
        meta[n_meta++] = (nqm_meta){"kind_families", families};
    if (d->manifest)
        meta[n_meta++] = (nqm_meta){"manifest", d->manifest};
    nqm_tensor tensors[N_COLUMNS];
    size_t n_tensors = list_tensors(d, tensors);
    if (refs && groups && kinds && pairs && (families || !d->kind_families.n))
        status = nqm_safetensors_write(path, n_tensors, tensors, n_meta, meta, sha256_ret, err);
    else
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: a name is not UTF-8, or memory is short", path);
    free(refs);
    free(groups);
    free(kinds);
    free(families);
    free(pairs);
    return status;
}
