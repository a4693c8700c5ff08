/* SPDX-License-Identifier: MIT
 *
 * BRDF files that nqm writes: networks and tables, as safetensors (doc/files.md). The reader accepts only files with
 * exactly the expected tensors, finite values and a matching checksum.
 */
#include "brdf/formats/format.h"

#include "io/io.h"
#include <math.h>

#define NETWORK_FORMAT "nqm-nbrdf"
#define TABLE_FORMAT   "nqm-table"
#define SCHEMA         "1"

/* The network's tensors in the order of its weights; rows 0: a vector. */
static const struct {
    const char *name;
    size_t rows, cols;
} network[] = {{"layers.0.kernel", 6, 21}, {"layers.0.bias", 0, 21},   {"layers.1.kernel", 21, 21},
               {"layers.1.bias", 0, 21},   {"layers.2.kernel", 21, 3}, {"layers.2.bias", 0, 3}};
enum { N_NETWORK = sizeof network / sizeof *network };

static nqm_tensor network_tensor(size_t i, const float *weights) {
    return nqm_tensor_of(network[i].name, NQM_F32, network[i].rows, network[i].cols, weights);
}

static void list_network(const nqm_brdf *brdf, nqm_tensor tensors[N_NETWORK]) {
    const float *next = nqm_nbrdf_weights(brdf);
    for (size_t i = 0; i < N_NETWORK; ++i) {
        tensors[i] = network_tensor(i, next);
        next += tensors[i].n_bytes / sizeof *next;
    }
}

nqm_tensor nqm_table_tensor(const nqm_brdf *brdf) {
    nqm_table_size n;
    nqm_tensor tensor = {.name = "rgb", .data = nqm_table_values(brdf, &n)};
    const size_t dims[] = {n.n_h, n.n_d, n.n_p, n.n_phi_h};
    for (size_t i = 0; i < (n.n_phi_h > 1 ? 4 : 3); ++i)
        tensor.dims[tensor.n_dims++] = dims[i];
    tensor.dims[tensor.n_dims++] = 3;
    tensor.n_bytes = brdf->info.n_values * sizeof(float);
    return tensor;
}

bool nqm_table_size_of(const nqm_tensor *t, nqm_table_size *size) {
    if ((t->n_dims != 4 && t->n_dims != 5) || t->dims[t->n_dims - 1] != 3)
        return false;
    *size = (nqm_table_size){t->dims[0], t->dims[1], t->dims[2], t->n_dims == 5 ? t->dims[3] : 1};
    return size->n_h >= 2 && size->n_d >= 2 && size->n_p >= 1 && size->n_phi_h >= 1;
}

nqm_status nqm_brdf_save(const nqm_brdf *brdf, const char *path, nqm_error *err) {
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    const bool is_network = strcmp(info.format, "nbrdf") == 0;
    nqm_tensor tensors[N_NETWORK];
    const nqm_meta meta[] = {{"format", is_network ? NETWORK_FORMAT : TABLE_FORMAT}, {"schema", SCHEMA}};
    if (is_network)
        list_network(brdf, tensors);
    else if (strcmp(info.format, "table") == 0)
        tensors[0] = nqm_table_tensor(brdf);
    else
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "%s: only networks and tables can be saved, not a BRDF of the format '%s'", info.name,
                        info.format);
    return nqm_safetensors_write(path, is_network ? N_NETWORK : 1, tensors, 2, meta, NULL, err);
}

static nqm_status refuse(const char *name, const nqm_tensor *tensor, size_t at, const char *what, nqm_error *err) {
    long long byte = tensor->byte_offset + (long long)at;
    return nqm_fail(err, NQM_ERR_FORMAT, byte, "%s: tensor '%.64s' %s (byte %lld)", name, tensor->name, what, byte);
}

static nqm_status refuse_value(const char *name, const nqm_tensor *tensor, size_t i, nqm_error *err) {
    return refuse(name, tensor, i * sizeof(float), "contains a value that is not finite", err);
}

static nqm_status open_network(const nqm_safetensors *st, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    float weights[NQM_NBRDF_WEIGHTS], *next = weights;
    for (size_t t = 0; t < N_NETWORK; ++t) {
        const nqm_tensor expected = network_tensor(t, NULL), *tensor;
        nqm_status status = nqm_safetensors_floats(st, &expected, NQM_ERR_FORMAT, &tensor, err);
        if (status != NQM_OK)
            return status;
        const size_t n = tensor->n_bytes / sizeof *next;
        memcpy(next, tensor->data, n * sizeof *next); /* files of other writers may be misaligned */
        for (size_t i = 0; i < n; ++i)
            if (!isfinite(next[i]))
                return refuse_value(name, tensor, i, err);
        next += n;
    }
    return nqm_nbrdf_create(weights, name, brdf_ret, err);
}

static nqm_status open_table(const nqm_safetensors *st, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_tensor *tensor = nqm_safetensors_find(st, "rgb");
    const bool turns = tensor && tensor->n_dims == 5;
    const nqm_tensor expected = {.name = "rgb", .n_dims = turns ? 5 : 4, .dims = {0, 0, 0, turns ? 0 : 3, 3}};
    nqm_status status = nqm_safetensors_floats(st, &expected, NQM_ERR_FORMAT, &tensor, err);
    nqm_table_size size;
    if (status != NQM_OK)
        return status;
    if (!nqm_table_size_of(tensor, &size))
        return refuse(name, tensor, 0, "has fewer than two nodes along theta_h or theta_d", err);
    const size_t n = tensor->n_bytes / sizeof(float), bad = nqm_table_first_bad(n / 3, tensor->data);
    if (bad < n)
        return refuse_value(name, tensor, bad, err);
    return nqm_table_create(size, tensor->data, name, brdf_ret, err);
}

/* Check the format, and open the network or table of the file. */
static nqm_status open_any(const nqm_safetensors *st, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const char *format = nqm_safetensors_meta(st, "format");
    const bool is_network = format && strcmp(format, NETWORK_FORMAT) == 0;
    if (!is_network && (!format || strcmp(format, TABLE_FORMAT) != 0))
        return nqm_fail(err, NQM_ERR_FORMAT, 8,
                        "%s: a safetensors file of the format '%.40s', no BRDF (header at byte 8)", name,
                        format ? format : "");
    nqm_status status = nqm_safetensors_verify(st, SCHEMA, true, NQM_ERR_FORMAT, err);
    if (status != NQM_OK)
        return status;
    if (nqm_safetensors_count(st) > (is_network ? N_NETWORK : 1))
        return nqm_fail(err, NQM_ERR_FORMAT, 8, "%s: has more tensors than its format (header at byte 8)", name);
    return (is_network ? open_network : open_table)(st, name, brdf_ret, err);
}

static bool probe(const nqm_map *map) {
    return map->n_bytes > 8 && map->data[8] == '{';
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_safetensors *st;
    nqm_map_expect(map, true);
    nqm_status status = nqm_safetensors_parse(map->data, map->n_bytes, argument->name, &st, err);
    if (status == NQM_OK)
        status = open_any(st, argument->name, brdf_ret, err);
    nqm_safetensors_free(st);
    return status;
}

const nqm_brdf_format nqm_saved_format = {.files = "nqm's own .safetensors", .probe = probe, .open = open_file};
