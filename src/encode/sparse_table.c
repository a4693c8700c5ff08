/* SPDX-License-Identifier: MIT
 *
 * Tables of the sparse encoding: sampling a BRDF at their nodes, the logarithmic mapping with its colour channels, and
 * the products with the separable bases.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { H = NQM_SPARSE_H, D = NQM_SPARSE_D, P = NQM_SPARSE_P, CELLS = NQM_SPARSE_CELLS, MIN_VALID = 100 };
enum { BH = NQM_SPARSE_BASIS_H, BD = NQM_SPARSE_BASIS_D, BP = NQM_SPARSE_BASIS_P };

static const double eps = 1e-3; /* value of Nielsen et al. 2015 */

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

nqm_status nqm_sparse_grid_make(nqm_sparse_grid *grid, nqm_error *err) {
    const double min_cosine = 1e-6; /* nodes on the horizon have no value */
    *grid = (nqm_sparse_grid){0};
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&grid->hd, CELLS, 3 * sizeof(double)}, {&grid->cosine, CELLS, sizeof(double)},
                                    {&grid->cell, CELLS, sizeof(size_t)}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t cell = 0; cell < CELLS; ++cell) {
        double *hd = grid->hd + 3 * grid->n, wi[3], wo[3];
        nqm_table_node(H, D, P, cell / (D * P), cell / P % D, cell % P, hd);
        nqm_half_diff_to_directions(hd, wi, wo);
        if (wi[2] < min_cosine || wo[2] < min_cosine)
            continue;
        grid->cosine[grid->n] = wi[2] * wo[2];
        grid->cell[grid->n++] = cell;
    }
    return NQM_OK;
}

nqm_status nqm_sparse_sample(const nqm_sparse_grid *grid, const nqm_brdf *brdf, float *table, size_t *n_valid_ret,
                             nqm_error *err) {
    double *rgb;
    uint8_t *flag;
    size_t n_valid = 0;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&rgb, grid->n, 3 * sizeof(double)}, {&flag, grid->n, 1}), err);
    if (status != NQM_OK)
        return status;
    nqm_brdf_eval_half_diff(brdf, grid->n, grid->hd, rgb, flag);
    memset(table, 0, 3 * CELLS * sizeof *table);
    for (size_t i = 0; i < grid->n; ++i) {
        bool valid = nqm_has_value(flag[i]);
        n_valid += valid;
        for (size_t c = 0; c < 3; ++c)
            table[c * CELLS + grid->cell[i]] = valid ? (float)(grid->cosine[i] * rgb[3 * i + c]) : NAN;
    }
    if (n_valid < MIN_VALID)
        status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions; codes need %d",
                          nqm_brdf_get_info(brdf).name, n_valid, grid->n, MIN_VALID);
    *n_valid_ret = n_valid;
    nqm_free(rgb);
    return status;
}

/* ---- the mapping ------------------------------------------------------------------------------------------------- */

/* Orthonormal opponent colours (grey, red - blue, green - magenta): an error has the same norm in both spaces. */
static void rotate_colour(double rgb[3], bool inverse) {
    static const double axes[3][3] = {{0.57735026918962576, 0.57735026918962576, 0.57735026918962576},
                                      {0.70710678118654752, 0, -0.70710678118654752},
                                      {-0.40824829046386302, 0.81649658092772603, -0.40824829046386302}};
    double in[3] = {rgb[0], rgb[1], rgb[2]};
    for (size_t i = 0; i < 3; ++i)
        rgb[i] = inverse ? axes[0][i] * in[0] + axes[1][i] * in[1] + axes[2][i] * in[2] : nqm_dot3(axes[i], in);
}

/* Fill cells without a value with f_r of the previous node along a coordinate of n nodes (`stride` cells apart), else of the
 * next node. cosine: (CELLS) c, 0 below the horizon. */
static void fill_along(size_t n, size_t stride, const double *cosine, float *channel) {
    for (size_t first = 0; first < CELLS; ++first) {
        if (first / stride % n != 0)
            continue;
        for (size_t k = 1; k < n; ++k) {
            size_t at = first + k * stride, previous = at - stride;
            if (isnan(channel[at]) && cosine[previous] > 0)
                channel[at] = (float)((double)channel[previous] * cosine[at] / cosine[previous]);
        }
        for (size_t k = n - 1; k-- > 0;) {
            size_t at = first + k * stride, next = at + stride;
            if (isnan(channel[at]) && cosine[next] > 0)
                channel[at] = (float)((double)channel[next] * cosine[at] / cosine[next]);
        }
    }
}

void nqm_sparse_map(const nqm_sparse_grid *grid, const float *typical, float *table) {
    double cosine[CELLS] = {0};
    for (size_t i = 0; i < grid->n; ++i)
        cosine[grid->cell[i]] = grid->cosine[i];
    for (size_t c = 0; c < 3; ++c) {
        fill_along(H, D * P, cosine, table + c * CELLS);
        fill_along(D, P, cosine, table + c * CELLS);
    }
    for (size_t i = 0; i < grid->n; ++i) {
        size_t cell = grid->cell[i];
        double v[3];
        for (size_t c = 0; c < 3; ++c) {
            float value = table[c * CELLS + cell];
            v[c] = isnan(value) ? 0 : log(((double)value + eps) / ((double)typical[cell] + eps));
        }
        rotate_colour(v, false);
        for (size_t c = 0; c < 3; ++c)
            table[c * CELLS + cell] = (float)v[c];
    }
}

void nqm_sparse_unmap(const nqm_sparse_grid *grid, const float *typical, float *table) {
    for (size_t i = 0; i < grid->n; ++i) {
        size_t cell = grid->cell[i];
        double v[3] = {(double)table[cell], (double)table[CELLS + cell], (double)table[2 * CELLS + cell]};
        rotate_colour(v, true);
        for (size_t c = 0; c < 3; ++c)
            table[c * CELLS + cell] = (float)fmax(exp(v[c]) * ((double)typical[cell] + eps) - eps, 0);
    }
}

/* ---- separable bases --------------------------------------------------------------------------------------------- */

/* Multiply the first coordinate of in (n_in, n_rest) by a basis and move it to the end: out (n_rest, n_out). Three calls
 * restore the order of the coordinates. basis: (n_out, n_in), or (n_in, n_out) for the inverse. */
static void contract(size_t n_in, size_t n_out, size_t n_rest, const float *basis, bool inverse, const double *in,
                     double *out) {
    for (size_t k = 0; k < n_rest; ++k)
        for (size_t o = 0; o < n_out; ++o) {
            double sum = 0;
            for (size_t i = 0; i < n_in; ++i)
                sum += in[i * n_rest + k] * (double)(inverse ? basis[i * n_out + o] : basis[o * n_in + i]);
            out[k * n_out + o] = sum;
        }
}

void nqm_sparse_analyse(const nqm_sparse_bases *bases, const float *channel, double *core) {
    double table[CELLS], a[D * P * BH], b[P * BH * BD];
    for (size_t i = 0; i < CELLS; ++i)
        table[i] = (double)channel[i];
    contract(H, BH, D * P, bases->h, false, table, a);
    contract(D, BD, P * BH, bases->d, false, a, b);
    contract(P, BP, BH * BD, bases->p, false, b, core);
}

void nqm_sparse_synthesise(const nqm_sparse_bases *bases, const double *core, float *channel) {
    double a[BD * BP * H], b[BP * H * D], table[CELLS];
    contract(BH, H, BD * BP, bases->h, true, core, a);
    contract(BD, D, BP * H, bases->d, true, a, b);
    contract(BP, P, H * D, bases->p, true, b, table);
    for (size_t i = 0; i < CELLS; ++i)
        channel[i] = (float)table[i];
}
