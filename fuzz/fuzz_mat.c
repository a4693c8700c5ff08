/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: MAT v5 files. Values that are read must be finite, failures must set a message, and no input may cause a
 * large allocation (limit of libFuzzer, run.sh).
 */
#include "fuzz.h"
#include "io/io.h"

#include <math.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    const char *path = scratch_path("mat");
    const blob b = {.data = (unsigned char *)(uintptr_t)data, .n_bytes = n_bytes};
    blob_save(&b, path);
    nqm_mat *mat;
    nqm_error err = {0};
    nqm_status status = nqm_mat_open(path, &mat, &err);
    if ((status == NQM_OK) != (mat != NULL) || (status != NQM_OK && err.message[0] == '\0'))
        abort();
    static const char *const variables[] = {"r", "random_locations"};
    for (size_t i = 0; mat && i < 2; ++i) {
        double values[21];
        size_t rows, cols, n = i ? 21 : 7;
        err = (nqm_error){0};
        status = nqm_mat_read(mat, variables[i], 7, i ? 3 : 1, values, &err);
        for (size_t k = 0; status == NQM_OK && k < n; ++k)
            if (!isfinite(values[k]))
                abort();
        if (status != NQM_OK && err.message[0] == '\0')
            abort();
        if (nqm_mat_shape(mat, variables[i], &rows, &cols, NULL) == NQM_OK && rows > 0 && cols > SIZE_MAX / rows)
            abort();
    }
    nqm_mat_close(mat);
    return 0;
}

/* A variable "r" of 7 doubles: tag of the array, flags, dimensions, name, data. */
blob fuzz_seed(void) {
    const uint32_t words[] = {14, 0, 6, 8, 6, 0, 5, 8, 7, 1, 1 | 1 << 16, 'r', 9, 56};
    blob b = {.n_bytes = 128 + sizeof words + 56};
    b.data = calloc(b.n_bytes, 1);
    if (!b.data)
        abort();
    static const char head[] = "MATLAB 5.0 MAT-file";
    for (size_t i = 0; i < sizeof head - 1; ++i)
        b.data[i] = (unsigned char)head[i];
    b.data[125] = 1;
    b.data[126] = 'I';
    b.data[127] = 'M';
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i)
        nqm_store_u32(b.data + 128 + 4 * i, words[i]);
    nqm_store_u32(b.data + 132, (uint32_t)(b.n_bytes - 136)); /* bytes after the array's tag */
    for (size_t i = 0; i < 7; ++i)
        nqm_store_f64(b.data + 128 + sizeof words + 8 * i, 0.5 * (double)i);
    return b;
}
