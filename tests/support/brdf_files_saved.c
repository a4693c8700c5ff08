/* SPDX-License-Identifier: MIT
 *
 * Writes networks and tables in the layout of nqm_brdf_save(), valid or with one fault, using only the safetensors
 * writer.
 */
#include "io/io.h"
#include "support/brdf_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { N_TABLE = 4 * 3 * 5 * 3, N_VALUES = 675 };

static size_t shape_network(nqm_tensor *t) {
    static const nqm_tensor layout[6] = {{.name = "layers.0.kernel", .n_dims = 2, .dims = {6, 21}},
                                         {.name = "layers.0.bias", .n_dims = 1, .dims = {21}},
                                         {.name = "layers.1.kernel", .n_dims = 2, .dims = {21, 21}},
                                         {.name = "layers.1.bias", .n_dims = 1, .dims = {21}},
                                         {.name = "layers.2.kernel", .n_dims = 2, .dims = {21, 3}},
                                         {.name = "layers.2.bias", .n_dims = 1, .dims = {3}}};
    memcpy(t, layout, sizeof layout);
    return 6;
}

static void fill(size_t n, nqm_tensor *t, float *values, saved_kind kind) {
    for (size_t i = 0; i < N_VALUES; ++i)
        values[i] = (float)noise((uint32_t)i, 9) - (kind >= SAVED_TABLE ? 0 : 0.5f);
    for (size_t i = 0; i < n; ++i) {
        size_t count = t[i].dims[0];
        for (size_t k = 1; k < t[i].n_dims; ++k)
            count *= t[i].dims[k];
        t[i].n_bytes = count * sizeof *values;
        t[i].data = values;
        values += count;
    }
}

static const char *format_of(saved_kind kind) {
    return kind == SAVED_FORMAT ? "nqm-model" : kind >= SAVED_TABLE ? "nqm-table" : "nqm-nbrdf";
}

blob make_saved(saved_kind kind) {
    const char *path = scratch_path("saved.safetensors"); /* tests run beside each other in one folder */
    nqm_tensor t[8] = {{.name = "rgb", .n_dims = 4, .dims = {4, 3, 5, 3}}};
    float values[N_VALUES];
    const double numbers[21] = {0};
    size_t n = kind >= SAVED_TABLE ? 1 : shape_network(t);
    if (kind == SAVED_TABLE_FLAT)
        t[0] = (nqm_tensor){.name = "rgb", .n_dims = 4, .dims = {1, 12, 5, 3}};
    fill(n, t, values, kind);
    if (kind == SAVED_MISSING)
        --n;
    if (kind == SAVED_EXTRA)
        t[n++] = (nqm_tensor){.name = "more", .n_dims = 1, .dims = {3}, .n_bytes = 12, .data = values};
    if (kind == SAVED_SHAPE)
        t[0].dims[0] = 21, t[0].dims[1] = 6;
    if (kind == SAVED_DOUBLE)
        t[1] = (nqm_tensor){
            .name = t[1].name, .dtype = NQM_F64, .n_dims = 1, .dims = {21}, .n_bytes = 168, .data = numbers};
    if (kind == SAVED_NAN)
        values[200] = NAN;
    if (kind == SAVED_TABLE_NAN)
        values[31] = NAN; /* channel 1 of a node; its other channels are valid */
    if (kind == SAVED_TABLE)
        values[60] = values[61] = values[62] = NAN; /* no value */
    const nqm_meta meta[] = {{"format", format_of(kind)}, {"schema", kind == SAVED_SCHEMA ? "2" : "1"}};
    if (nqm_safetensors_write(path, n, t, 2, meta, NULL, NULL) != NQM_OK)
        abort();
    blob b = blob_load(path);
    unlink(path);
    if (kind == SAVED_CHECKSUM)
        b.data[b.n_bytes - 3] ^= 1;
    return b;
}
