/* SPDX-License-Identifier: MIT
 *
 * BRDF files that nqm writes: networks and tables, as safetensors (doc/files.md). The reader accepts only files with
 * exactly the expected tensors, finite values and a matching checksum.
 */
#include "brdf/brdf.h"

#include "io/io.h"
#include <math.h>
#include <string.h>

#define NETWORK_FORMAT "nqm-nbrdf"
#define TABLE_FORMAT   "nqm-table"
#define SCHEMA         "1"

/* The network's tensors in the order of its weights. */
enum { N_NETWORK = 6 };
static const nqm_tensor network_tensors[N_NETWORK] = {
    {.name = "layers.0.kernel", .n_dims = 2, .dims = {6, 21}},  {.name = "layers.0.bias", .n_dims = 1, .dims = {21}},
    {.name = "layers.1.kernel", .n_dims = 2, .dims = {21, 21}}, {.name = "layers.1.bias", .n_dims = 1, .dims = {21}},
    {.name = "layers.2.kernel", .n_dims = 2, .dims = {21, 3}},  {.name = "layers.2.bias", .n_dims = 1, .dims = {3}}};

static size_t count(const nqm_tensor *tensor) {
    size_t n = 1;
    for (size_t i = 0; i < tensor->n_dims; ++i)
        n *= tensor->dims[i];
    return n;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static nqm_status write_file(const char *path, const char *format, size_t n, const nqm_tensor *tensors,
                             nqm_error *err) {
    const nqm_meta meta[] = {{"format", format}, {"schema", SCHEMA}};
    return nqm_safetensors_write(path, n, tensors, 2, meta, NULL, err);
}

static nqm_status save_network(const nqm_brdf *brdf, const char *path, nqm_error *err) {
    float weights[NQM_NBRDF_WEIGHTS], *next = weights;
    nqm_tensor tensors[N_NETWORK];
    nqm_nbrdf_weights(brdf, weights);
    for (size_t i = 0; i < N_NETWORK; ++i) {
        tensors[i] = network_tensors[i];
        tensors[i].data = next;
        tensors[i].n_bytes = count(&tensors[i]) * sizeof *weights;
        next += count(&tensors[i]);
    }
    return write_file(path, NETWORK_FORMAT, N_NETWORK, tensors, err);
}

static nqm_status save_table(const nqm_brdf *brdf, const char *path, nqm_error *err) {
    nqm_tensor tensor = {.name = "rgb", .n_dims = 4, .dims = {0, 0, 0, 3}};
    tensor.data = nqm_table_values(brdf, tensor.dims);
    tensor.n_bytes = count(&tensor) * sizeof(float);
    return write_file(path, TABLE_FORMAT, 1, &tensor, err);
}

nqm_status nqm_brdf_save(const nqm_brdf *brdf, const char *path, nqm_error *err) {
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    if (strcmp(info.format, "nbrdf") == 0)
        return save_network(brdf, path, err);
    if (strcmp(info.format, "table") == 0)
        return save_table(brdf, path, err);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: only networks and tables can be saved, not a BRDF of the format '%s'",
                    info.name, info.format);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static nqm_status refuse(const char *name, const nqm_tensor *tensor, size_t at, const char *what, nqm_error *err) {
    long long byte = tensor->byte_offset + (long long)at;
    return nqm_fail(err, NQM_ERR_FORMAT, byte, "%s: tensor '%.64s' %s (byte %lld)", name, tensor->name, what, byte);
}

static nqm_status refuse_file(const char *name, const char *what, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, 8, "%s: %s (header at byte 8)", name, what);
}

/* Find a float tensor with these dimensions; an expected dimension of 0 means any size >= 1. */
static nqm_status find(const nqm_safetensors *st, const char *name, const nqm_tensor *expected,
                       const nqm_tensor **tensor_ret, nqm_error *err) {
    const nqm_tensor *tensor = nqm_safetensors_find(st, expected->name);
    if (!tensor)
        return nqm_fail(err, NQM_ERR_FORMAT, 8, "%s: tensor '%s' is missing (header at byte 8)", name, expected->name);
    bool fits = tensor->dtype == NQM_F32 && tensor->n_dims == expected->n_dims;
    for (size_t i = 0; fits && i < expected->n_dims; ++i)
        fits = expected->dims[i] ? tensor->dims[i] == expected->dims[i] : tensor->dims[i] > 0;
    if (!fits)
        return refuse(name, tensor, 0, "has the wrong type or shape", err);
    *tensor_ret = tensor;
    return NQM_OK;
}

static nqm_status refuse_value(const char *name, const nqm_tensor *tensor, size_t i, nqm_error *err) {
    return refuse(name, tensor, i * sizeof(float), "holds a value that is not finite", err);
}

/* Copy the floats of a tensor, which may be misaligned in files of other writers. */
static nqm_status copy(const char *name, const nqm_tensor *tensor, float *values, nqm_error *err) {
    size_t n = count(tensor);
    memcpy(values, tensor->data, n * sizeof *values);
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(values[i]))
            return refuse_value(name, tensor, i, err);
    return NQM_OK;
}

static nqm_status open_network(const nqm_safetensors *st, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    float weights[NQM_NBRDF_WEIGHTS], *next = weights;
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < N_NETWORK && status == NQM_OK; ++i) {
        const nqm_tensor *tensor;
        status = find(st, name, &network_tensors[i], &tensor, err);
        if (status == NQM_OK)
            status = copy(name, tensor, next, err);
        next += count(&network_tensors[i]);
    }
    return status == NQM_OK ? nqm_nbrdf_create(weights, name, brdf_ret, err) : status;
}

static nqm_status open_table(const nqm_safetensors *st, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_tensor expected = {.name = "rgb", .n_dims = 4, .dims = {0, 0, 0, 3}}, *tensor;
    nqm_status status = find(st, name, &expected, &tensor, err);
    if (status != NQM_OK)
        return status;
    if (tensor->dims[0] < 2 || tensor->dims[1] < 2)
        return refuse(name, tensor, 0, "has fewer than two nodes along theta_h or theta_d", err);
    size_t bad = nqm_table_first_bad(count(tensor) / 3, tensor->data);
    if (bad < count(tensor))
        return refuse_value(name, tensor, bad, err);
    return nqm_table_create(tensor->dims[0], tensor->dims[1], tensor->dims[2], tensor->data, name, brdf_ret, err);
}

/* Check format, schema, number of tensors and checksum. *network: the file is a network, not a table. */
static nqm_status check_file(const nqm_safetensors *st, const char *name, bool *network, nqm_error *err) {
    const char *format = nqm_safetensors_meta(st, "format"), *schema = nqm_safetensors_meta(st, "schema");
    char digits[65];
    bool matches;
    if (!format)
        return refuse_file(name, "a safetensors file that does not say what it holds; no BRDF", err);
    *network = strcmp(format, NETWORK_FORMAT) == 0;
    if (!*network && strcmp(format, TABLE_FORMAT) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 8, "%s: a file of the kind '%.40s', no BRDF (header at byte 8)", name,
                        format);
    if (!schema || strcmp(schema, SCHEMA) != 0)
        return refuse_file(name, "this version of nqm reads schema " SCHEMA " only", err);
    if (!nqm_safetensors_checksum(st, digits, &matches) || !matches)
        return refuse_file(name, "the checksum is absent or does not match", err);
    if (nqm_safetensors_count(st) > (*network ? N_NETWORK : 1))
        return refuse_file(name, "holds more tensors than belong in it", err);
    return NQM_OK;
}

bool nqm_saved_probe(const nqm_map *map) {
    return map->n_bytes > 8 && map->data[8] == '{';
}

nqm_status nqm_saved_open(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_safetensors *st;
    bool network = false;
    nqm_map_expect(map, true);
    nqm_status status = nqm_safetensors_parse(map->data, map->n_bytes, name, &st, err);
    if (status != NQM_OK)
        return status;
    status = check_file(st, name, &network, err);
    if (status == NQM_OK)
        status = (network ? open_network : open_table)(st, name, brdf_ret, err);
    nqm_safetensors_free(st);
    if (status != NQM_OK)
        return status;
    (*brdf_ret)->n_bytes = map->n_bytes;
    nqm_map_close(map);
    return NQM_OK;
}
