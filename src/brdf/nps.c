/* SPDX-License-Identifier: MIT
 *
 * Neural-process BRDFs (Zheng et al. 2021, DOI 10.1145/3490385): one decoder network for all materials, and a latent
 * vector of seven values for each. The decoder file contains 808,003 little-endian float32: per layer the weights (in,
 * out), then the biases; the latents are the columns mean0..mean6 of nps_latents.csv in the same folder. Input: (cos,
 * sin)(2 phi_d) / 2 + 1/2, theta_h and theta_d over pi/2, latents. All seven layers end in ReLU; the output is expm1(),
 * applied four times to 0.15 y.
 */
#include "base/names.h"
#include "brdf/brdf.h"

#include "io/io.h"
#include "kernel/kernel.h"
#include "math/math.h"
#include <float.h>
#include <math.h>
#include <string.h>

enum { N_LATENTS = 7, N_IN = 4 + N_LATENTS, N_HIDDEN = 400, N_OUT = 3, N_LAYERS = 7 };
enum { N_NUMBERS = (N_IN + 1) * N_HIDDEN + (N_LAYERS - 2) * (N_HIDDEN + 1) * N_HIDDEN + (N_HIDDEN + 1) * N_OUT };

typedef struct nps {
    float latent[N_LATENTS];
    nqm_map map; /* the decoder; weights (N_NUMBERS) in the order of the file */
} nps;

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/* Pairs per batch: large enough to amortise reading the weights, small enough for buffers on the stack. */
enum { TILE = 32 };

/* y (n, n_out) = relu(x (n, n_in) w + b); returns the weights of the next layer. */
static const float *apply_layer(size_t n, size_t n_in, size_t n_out, const float *w, const float *x, float *y) {
    const float *b = w + n_in * n_out;
    for (size_t i = 0; i < n; ++i)
        memcpy(y + i * n_out, b, n_out * sizeof *y);
    nqm_gemm g = {.m = n, .n = n_out, .k = n_in, .alpha = 1, .beta = 1, .a = x, .b = w, .c = y};
    g.lda = n_in;
    g.ldb = g.ldc = n_out;
    nqm_kernels_get()->gemm(&g);
    for (size_t i = 0; i < n * n_out; ++i)
        y[i] = y[i] > 0 ? y[i] : 0;
    return b + n_out;
}

static void eval_tile(const nps *net, size_t n, const double *hd, double *rgb) {
    float buffer[2][TILE * N_HIDDEN];
    float *x = buffer[0], *y = buffer[1];
    for (size_t i = 0; i < n; ++i) {
        float *row = x + i * N_IN;
        row[0] = (float)(0.5 * cos(2 * hd[3 * i + 2]) + 0.5);
        row[1] = (float)(0.5 * sin(2 * hd[3 * i + 2]) + 0.5);
        row[2] = (float)(hd[3 * i] / (NQM_PI / 2));
        row[3] = (float)(hd[3 * i + 1] / (NQM_PI / 2));
        memcpy(row + 4, net->latent, sizeof net->latent);
    }
    const float *w = (const void *)net->map.data;
    for (size_t layer = 0; layer < N_LAYERS; ++layer) {
        w = apply_layer(n, layer == 0 ? N_IN : N_HIDDEN, layer == N_LAYERS - 1 ? N_OUT : N_HIDDEN, w, x, y);
        float *swap = x;
        x = y;
        y = swap;
    }
    for (size_t i = 0; i < n * N_OUT; ++i)
        rgb[i] = expm1(expm1(expm1(expm1(0.15 * (double)x[i]))));
}

static void nps_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    for (size_t i = 0; i < n; i += TILE)
        eval_tile(self, n - i < TILE ? n - i : TILE, hd + 3 * i, rgb + 3 * i);
}

static void nps_free(void *self) {
    nps *net = self;
    nqm_map_close(&net->map);
    nqm_free(net);
}

static const nqm_brdf_class nps_class = {
    .format = "nps", .reciprocal = 1, .eval_half_diff = nps_eval_half_diff, .free = nps_free};

/* ---- reading ----------------------------------------------------------------------------------------------------- */

bool nqm_nps_probe(const nqm_map *map) {
    return map->n_bytes == (size_t)N_NUMBERS * 4;
}

static nqm_status map_weights(const char *path, nps *net, nqm_error *err) {
    nqm_map *map = &net->map;
    nqm_status status = nqm_map_open(path, map, err);
    if (status != NQM_OK)
        return status;
    if (!nqm_nps_probe(map))
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)map->n_bytes,
                        "%s: a decoder has %d bytes, this file ends at byte %zu", path, N_NUMBERS * 4, map->n_bytes);
    nqm_map_expect(map, true);
    const float *weights = (const void *)map->data;
    if (nqm_all_within(N_NUMBERS, weights, -FLT_MAX))
        return NQM_OK;
    size_t at = 4 * nqm_first_outside(N_NUMBERS, weights, -FLT_MAX);
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at, "%s: the weight at byte %zu is not finite", path, at);
}

static nqm_status find_latent(const nqm_csv *csv, const char *path, const char *material, nps *net, nqm_error *err) {
    int name_column = nqm_csv_column(csv, "material");
    size_t row = 0;
    nqm_nearest nearest = nqm_nearest_begin(material);
    for (; name_column >= 0 && row < nqm_csv_rows(csv); ++row) {
        const char *name = nqm_csv_text(csv, row, name_column);
        if (strcmp(name, material) == 0)
            break;
        nqm_nearest_add(&nearest, name);
    }
    if (name_column < 0 || row == nqm_csv_rows(csv))
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: has no material '%s'%s", path, material, nearest.advice);
    for (int k = 0; k < N_LATENTS; ++k) {
        char column_name[8];
        snprintf(column_name, sizeof column_name, "mean%d", k);
        int column = nqm_csv_column(csv, column_name);
        if (column < 0)
            return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no column '%s' (byte 0)", path, column_name);
        double value;
        nqm_status status = nqm_csv_number(csv, row, column, &value, err);
        if (status != NQM_OK)
            return status;
        net->latent[k] = (float)value;
    }
    return NQM_OK;
}

static nqm_status read_latent(const char *decoder_path, const char *material, nps *net, nqm_error *err) {
    const char *slash = strrchr(decoder_path, '/');
    const size_t n_folder = slash ? nqm_larger((size_t)(slash - decoder_path), 1) : 0; /* 1: the root folder */
    char *path = nqm_brdf_path_below("nps_latents.csv", decoder_path, n_folder);
    if (!path)
        return nqm_fail_nomem(err, strlen(decoder_path));
    nqm_csv *csv;
    nqm_status status = nqm_csv_load(path, &csv, err);
    if (status == NQM_OK)
        status = find_latent(csv, path, material, net, err);
    nqm_csv_free(csv);
    nqm_free(path);
    return status;
}

nqm_status nqm_nps_open(const char *decoder_path, const char *material, const char *name, nqm_brdf **brdf_ret,
                        nqm_error *err) {
    nps *net = nqm_alloc(1, sizeof *net);
    if (!net)
        return nqm_fail_nomem(err, sizeof *net);
    nqm_status status = read_latent(decoder_path, material, net, err);
    if (status == NQM_OK)
        status = map_weights(decoder_path, net, err);
    if (status != NQM_OK) {
        nps_free(net);
        return status;
    }
    const nqm_brdf_info info = {.name = name,
                                .source_doi = "10.1145/3490385",
                                .layout = "7 latents, shared decoder 11-400x6-3",
                                .n_values = N_NUMBERS + N_LATENTS,
                                .n_bytes = (size_t)N_NUMBERS * 4};
    return nqm_brdf_wrap(&nps_class, net, &info, brdf_ret, err);
}
