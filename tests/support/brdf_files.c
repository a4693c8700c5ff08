/* SPDX-License-Identifier: MIT
 *
 * Blobs and temporary files; BRDF files of fixed layout: MERL tables and the decoder of the neural processes.
 */
#include "support/brdf_files.h"

#include "base/base.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static _Noreturn void give_up(const char *what) {
    perror(what);
    abort();
}

void blob_free(blob *b) {
    free(b->data);
    *b = (blob){0};
}

void blob_save_sparse(const blob *b, size_t n_bytes, const char *path) {
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(b->data, 1, b->n_bytes, f) != b->n_bytes || fflush(f) != 0)
        give_up(path);
    if (n_bytes > b->n_bytes && ftruncate(fileno(f), (off_t)n_bytes) != 0)
        give_up(path);
    if (fclose(f) != 0)
        give_up(path);
}

void blob_save(const blob *b, const char *path) {
    blob_save_sparse(b, 0, path);
}

const char *blob_put(blob b, const char *path) {
    blob_save(&b, path);
    blob_free(&b);
    return path;
}

blob blob_load(const char *path) {
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END) != 0)
        give_up(path);
    long n = ftell(f);
    rewind(f);
    blob b = {.data = malloc((size_t)n + 1), .n_bytes = (size_t)n};
    if (!b.data || fread(b.data, 1, b.n_bytes, f) != b.n_bytes)
        give_up(path);
    fclose(f);
    return b;
}

double noise(uint32_t i, uint32_t row) {
    uint32_t x = i + row * 0x9e3779b9u; /* the finaliser of MurmurHash3 */
    x = (x ^ (x >> 16)) * 0x85ebca6bu;
    x = (x ^ (x >> 13)) * 0xc2b2ae35u;
    return (double)((x ^ (x >> 16)) >> 8) / 16777216;
}

double merl_cell(size_t channel, size_t h, size_t d, size_t p) {
    if (h + d > 100)
        return -1;
    return 1 + (double)channel + (double)h / 128 + (double)d / 16384 + (double)p / 4194304;
}

static blob make_merl_table(uint32_t n_phi) {
    const size_t n_bytes = 12 + (MERL_BYTES - 12) / 180 * n_phi;
    blob b = {.data = malloc(n_bytes), .n_bytes = n_bytes};
    if (!b.data)
        give_up("MERL table");
    nqm_store_u32(b.data, 90);
    nqm_store_u32(b.data + 4, 90);
    nqm_store_u32(b.data + 8, n_phi);
    unsigned char *at = b.data + 12;
    for (size_t channel = 0; channel < 3; ++channel)
        for (size_t h = 0; h < 90; ++h)
            for (size_t d = 0; d < 90; ++d)
                for (size_t p = 0; p < n_phi; ++p, at += 8)
                    nqm_store_f64(at, merl_cell(channel, h, d, p));
    return b;
}

blob make_merl(void) {
    return make_merl_table(180);
}

blob make_merl_360(void) {
    return make_merl_table(360);
}

blob make_utia(void) {
    blob b = {.data = malloc(UTIA_BYTES), .n_bytes = UTIA_BYTES};
    if (!b.data)
        give_up("UTIA measurement");
    for (uint32_t i = 0; i < UTIA_BYTES / 8; ++i)
        nqm_store_f64(b.data + 8 * (size_t)i, 2 * noise(i, 'u') - 0.1);
    return b;
}

blob make_nps_decoder(void) {
    static const uint32_t widths[8] = {11, 400, 400, 400, 400, 400, 400, 3};
    blob b = {.data = malloc(4 * 808003), .n_bytes = 4 * 808003};
    if (!b.data)
        give_up("decoder");
    unsigned char *at = b.data;
    uint32_t i = 0;
    for (size_t layer = 0; layer < 7; ++layer) {
        float scale = (float)sqrt(6.0 / widths[layer]);
        for (uint32_t k = 0; k < widths[layer] * widths[layer + 1]; ++k, at += 4)
            nqm_store_f32(at, (float)(2 * noise(i++, 23) - 1) * scale);
        for (uint32_t k = 0; k < widths[layer + 1]; ++k, at += 4)
            nqm_store_f32(at, (float)noise(i++, 23));
    }
    return b;
}

blob make_nps_latents(void) {
    static const char text[] = "material,mean0,mean1,mean2,mean3,mean4,mean5,mean6,logvar0\n"
                               "first,0.5,-0.25,1,0,-1,0.125,0.75,-9\n"
                               "second,-0.5,0.25,0,1,0.5,-0.125,-0.75,-9\n";
    blob b = {.data = malloc(sizeof text - 1), .n_bytes = sizeof text - 1};
    if (!b.data)
        give_up("latents");
    memcpy(b.data, text, b.n_bytes);
    return b;
}
