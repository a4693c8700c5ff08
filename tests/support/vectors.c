/* SPDX-License-Identifier: MIT
 *
 * Opens the file for each array: it is small.
 */
#include "support/vectors.h"
#include "io/io.h"
#include "support/check.h"

void get_vector(const char *file, const char *name, size_t n_bytes, void *to) {
    nqm_map map;
    nqm_safetensors *st;
    assert_int_equal(nqm_map_open(test_vector(file), &map, NULL), NQM_OK);
    assert_int_equal(nqm_safetensors_parse(map.data, map.n_bytes, file, &st, NULL), NQM_OK);
    const nqm_tensor *tensor = nqm_safetensors_find(st, name);
    if (!tensor || tensor->n_bytes != n_bytes)
        fail_msg("%s: no vector '%s' of %zu bytes", file, name, n_bytes);
    memcpy(to, tensor->data, n_bytes);
    nqm_safetensors_free(st);
    nqm_map_close(&map);
}

static blob load(const char *folder, const char *name, const char *ending) {
    char path[64];
    snprintf(path, sizeof path, "%s/%s%s", folder, name, ending);
    return blob_load(test_vector(path));
}

blob vector_picture(const char *name) {
    return load("images", name, "");
}

blob vector_npy(const char *name) {
    return load("npy", name, ".npy");
}

double pair_vector[VECTOR_PAIRS][6];

int read_pair_vector(void **state) {
    (void)state;
    get_vector("brdf.safetensors", "pair", sizeof pair_vector, pair_vector);
    return 0;
}

const double (*rgb_vector(const char *name))[3] {
    static double rgb[VECTOR_PAIRS][3];
    get_vector("brdf.safetensors", name, sizeof rgb, rgb);
    return (const double(*)[3])rgb;
}
