/* SPDX-License-Identifier: MIT
 *
 * Neural-process BRDFs (Zheng et al. 2021, DOI 10.1145/3490385): one decoder network for all materials, and a latent
 * vector of seven values for each. The decoder file contains 808,003 little-endian float32: per layer the weights (in,
 * out), then the biases; the latents are the columns mean0..mean6 of nps_latents.csv in the same folder. Input: (cos,
 * sin)(2 phi_d) / 2 + 1/2, theta_h and theta_d over pi/2, latents. All seven layers end in ReLU; the output is expm1(),
 * applied four times to 0.15 y.
 */
#include "brdf/formats/format.h"

#include "io/io.h"
#include "kernel/panel.h"
#include <float.h>
#include <math.h>

enum { N_LATENTS = 7, N_IN = 4 + N_LATENTS, N_HIDDEN = 400, N_OUT = 3, N_LAYERS = 7 };
enum { N_NUMBERS = (N_IN + 1) * N_HIDDEN + (N_LAYERS - 2) * (N_HIDDEN + 1) * N_HIDDEN + (N_HIDDEN + 1) * N_OUT };

/* Floats from row to row of the activations. */
enum { LD = (N_HIDDEN + NQM_PANEL - 1) / NQM_PANEL * NQM_PANEL + 16 };

typedef struct nps {
    float latent[N_LATENTS];
    nqm_panels layer[N_LAYERS]; /* (in, out) the decoder's weights */
    float bias[N_LAYERS][N_HIDDEN];
} nps;

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/* Pairs per batch: whole strips of the kernels, and all light directions of a point of a scene; buffers are on the stack. */
enum { TILE = 11 * NQM_STRIP };

/* y (n, out) = relu(x (n, in) w + b) */
static void apply_layer(size_t n, const nqm_panels *w, const float *b, const float *x, float *y) {
    nqm_kernels_get()->product[NQM_PRECISION_F32](&(nqm_product){.m = n,
                                                                 .words = w->words,
                                                                 .n_panels = w->n_panels,
                                                                 .a = x,
                                                                 .lda = LD,
                                                                 .b = w->data,
                                                                 .panel_step = w->stride * NQM_PANEL,
                                                                 .c = y,
                                                                 .ldc = LD});
    for (size_t i = 0; i < n; ++i) {
        float *row = y + i * LD;
#pragma omp simd
        for (size_t j = 0; j < w->n; ++j) {
            const float sum = row[j] + b[j];
            row[j] = sum > 0 ? sum : 0;
        }
    }
}

static void eval_tile(const nps *net, size_t n, const double *hd, double *rgb) {
    float buffer[2][TILE * LD];
    float *x = buffer[0], *y = buffer[1];
    for (size_t i = 0; i < n; ++i) {
        float *row = x + i * LD;
        row[0] = (float)(0.5 * cos(2 * hd[3 * i + 2]) + 0.5);
        row[1] = (float)(0.5 * sin(2 * hd[3 * i + 2]) + 0.5);
        row[2] = (float)(hd[3 * i] / (NQM_PI / 2));
        row[3] = (float)(hd[3 * i + 1] / (NQM_PI / 2));
        memcpy(row + 4, net->latent, sizeof net->latent);
    }
    for (size_t l = 0; l < N_LAYERS; ++l) {
        apply_layer(n, &net->layer[l], net->bias[l], x, y);
        float *swap = x;
        x = y;
        y = swap;
    }
    for (size_t i = 0; i < n; ++i)
        for (size_t c = 0; c < N_OUT; ++c)
            rgb[N_OUT * i + c] = expm1(expm1(expm1(expm1(0.15 * (double)x[i * LD + c]))));
}

static void nps_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    for (size_t i = 0; i < n; i += TILE)
        eval_tile(self, n - i < TILE ? n - i : TILE, hd + 3 * i, rgb + 3 * i);
}

static void nps_free(void *self) {
    nps *net = self;
    for (size_t l = 0; l < N_LAYERS; ++l)
        nqm_panels_free(&net->layer[l]);
    nqm_free(net);
}

static const nqm_brdf_class nps_class = {
    .format = "nps", .reciprocal = 1, .is_costly = true, .eval_half_diff = nps_eval_half_diff, .free = nps_free};

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static bool probe(const nqm_map *map) {
    return map->n_bytes == (size_t)N_NUMBERS * 4;
}

/* Copy the weights (in, out) and biases of all layers from the numbers of a file. */
static nqm_status copy_layers(const float *numbers, nps *net, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t l = 0; l < N_LAYERS && status == NQM_OK; ++l) {
        const size_t n_in = l == 0 ? N_IN : N_HIDDEN, n_out = l + 1 < N_LAYERS ? N_HIDDEN : N_OUT;
        nqm_panels *layer = &net->layer[l];
        status = nqm_panels_create(NQM_PRECISION_F32, n_in, n_out, layer, err);
        for (size_t p = 0; p < layer->n_panels; ++p)
            for (size_t i = 0; i < n_in; ++i)
                memcpy(nqm_panel_at(layer, p) + i * NQM_PANEL, numbers + i * n_out + p * NQM_PANEL,
                       nqm_smaller(n_out - p * NQM_PANEL, NQM_PANEL) * sizeof *numbers);
        memcpy(net->bias[l], numbers + n_in * n_out, n_out * sizeof *numbers);
        numbers += (n_in + 1) * n_out;
    }
    return status;
}

static nqm_status read_decoder(const nqm_map *map, nps *net, nqm_error *err) {
    nqm_map_expect(map, true);
    float *numbers = nqm_alloc(N_NUMBERS, sizeof *numbers); /* numbers in the byte order of the host */
    if (!numbers)
        return nqm_fail_nomem(err, N_NUMBERS * sizeof *numbers);
    nqm_copy_little_endian(N_NUMBERS, sizeof *numbers, map->data, numbers);
    const size_t n_finite = nqm_first_outside(N_NUMBERS, numbers, -FLT_MAX), at = 4 * n_finite;
    const nqm_status status =
        n_finite == N_NUMBERS
            ? copy_layers(numbers, net, err)
            : nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at, "%s: the weight at byte %zu is not finite", map->path, at);
    nqm_free(numbers);
    return status;
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

static nqm_status find_companion(const nqm_map *map, char **path_ret, nqm_error *err) {
    *path_ret = nqm_path_beside(map->path, "nps_latents.csv");
    return *path_ret ? NQM_OK : nqm_fail_nomem(err, strlen(map->path));
}

static nqm_status read_latent(const nqm_map *map, const char *material, nps *net, nqm_error *err) {
    char *path;
    nqm_csv *csv = NULL;
    nqm_status status = find_companion(map, &path, err);
    if (status == NQM_OK)
        status = nqm_csv_load(path, &csv, err);
    if (status == NQM_OK)
        status = find_latent(csv, path, material, net, err);
    nqm_csv_free(csv);
    nqm_free(path);
    return status;
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    if (!argument->member)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this decoder's nps_latents.csv, '%s:MATERIAL'",
                        map->path, map->path);
    nps *net = nqm_alloc(1, sizeof *net);
    if (!net)
        return nqm_fail_nomem(err, sizeof *net);
    nqm_status status = read_latent(map, argument->member, net, err);
    if (status == NQM_OK)
        status = read_decoder(map, net, err);
    if (status != NQM_OK) {
        nps_free(net);
        return status;
    }
    const nqm_brdf_info info = {.name = argument->name,
                                .source_doi = "10.1145/3490385",
                                .layout = "7 latents, shared decoder 11-400x6-3",
                                .n_values = N_NUMBERS + N_LATENTS};
    return nqm_brdf_wrap(&nps_class, net, &info, brdf_ret, err);
}

const nqm_brdf_format nqm_nps_format = {
    .takes_members = true, .probe = probe, .open = open_file, .find_companion = find_companion};
