/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: MAT v5 files. Values that are read must be finite, failures must set a message, and no input may cause a
 * large allocation (limit of libFuzzer, run.sh).
 */
#include "sample/sample.h"
#include "fuzz.h"
#include "io/io.h"

#include <math.h>
#include <nqm/samples.h>
#include <stdlib.h>
#include <unistd.h>
#include <zlib.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    char path[FUZZ_PATH];
    const int fd = fuzz_file(data, n_bytes, path);
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
    close(fd);
    return 0;
}

/* Samples at 7 directions as they are saved, with the first variable compressed. */
static blob make_seed(void) {
    enum { N = 7, FIRST = 128, TAG = 8, COMPRESSED = 15 }; /* offset of the first variable; bytes of type and size */
    static const float rgb[3 * N] = {0.5, 1, 1.5};
    const char *path = scratch_path("seed.mat");
    double degrees[3 * N];
    nqm_directions *directions;
    for (size_t i = 0; i < 3 * N; ++i)
        degrees[i] = (double)i;
    if (nqm_directions_from_degrees(N, degrees, &directions, NULL) != NQM_OK ||
        nqm_samples_save_mat(directions, rgb, path, NULL) != NQM_OK)
        abort();
    nqm_directions_free(directions);
    blob plain = blob_load(path);
    const size_t end = FIRST + TAG + nqm_load_u32(plain.data + FIRST + 4);
    uLongf n_packed = compressBound(end - FIRST);
    blob b = {.data = calloc(FIRST + TAG + n_packed + plain.n_bytes - end, 1)};
    if (!b.data || compress(b.data + FIRST + TAG, &n_packed, plain.data + FIRST, end - FIRST) != Z_OK)
        abort();
    memcpy(b.data, plain.data, FIRST);
    nqm_store_u32(b.data + FIRST, COMPRESSED);
    nqm_store_u32(b.data + FIRST + 4, (uint32_t)n_packed);
    b.n_bytes = FIRST + TAG + n_packed + plain.n_bytes - end;
    memcpy(b.data + b.n_bytes - (plain.n_bytes - end), plain.data + end, plain.n_bytes - end);
    blob_free(&plain);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
