/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the safetensors reader. Every byte of the tensors of an accepted file is read.
 */
#include "fuzz.h"
#include "io/io.h"

#include <stdlib.h>
#include <unistd.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    nqm_safetensors *st;
    nqm_error err = {0};
    if (nqm_safetensors_parse(data, n_bytes, "fuzz", &st, &err) != NQM_OK) {
        if (st || err.message[0] == '\0' || err.byte_offset < 0)
            abort();
        return 0;
    }
    volatile unsigned sum = 0;
    for (size_t i = 0; i < nqm_safetensors_count(st); ++i) {
        const nqm_tensor *tensor = nqm_safetensors_at(st, i);
        const unsigned char *bytes = tensor->data;
        for (size_t k = 0; k < tensor->n_bytes; ++k)
            sum += bytes[k];
        if (nqm_safetensors_find(st, tensor->name) != tensor)
            abort();
    }
    (void)sum;
    char hex[65];
    bool matches;
    nqm_safetensors_checksum(st, hex, &matches);
    nqm_safetensors_free(st);
    return 0;
}

static blob make_seed(void) {
    static const char path[] = "fuzz_safetensors.tmp";
    static const double numbers[12] = {1, 2, 3};
    const nqm_tensor tensors[] = {
        {.name = "a", .dtype = NQM_F32, .n_dims = 2, .dims = {2, 8}, .n_bytes = 64, .data = numbers},
        {.name = "b", .dtype = NQM_F64, .n_dims = 3, .dims = {2, 3, 2}, .n_bytes = 96, .data = numbers},
        {.name = "c", .dtype = NQM_U8, .n_dims = 1, .dims = {5}, .n_bytes = 5, .data = numbers}};
    const nqm_meta meta = {"key", "value"};
    if (nqm_safetensors_write(path, 3, tensors, 1, &meta, NULL, NULL) != NQM_OK)
        abort();
    blob b = blob_load(path);
    unlink(path);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
