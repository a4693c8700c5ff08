/* SPDX-License-Identifier: MIT
 *
 * How a corpus reads the forms of a material. Folded: in half-vector coordinates with phi_d in [0, pi), the half of all
 * pairs that sampling directions and perturbations see, so that a measurement that is not reciprocal (up to 39 % in the
 * RGL data) does not differ from its own perturbed copy in the other half. Tabulated, besides, where the form's own
 * evaluation is too slow to render dozens of perturbed copies (the decoder of a neural process: 806,000 multiplications
 * a pair): theta_h spaced as in MERL's tables, linear between nodes; nodes without a value are left out of the mean.
 */
#include "brdf/brdf.h"
#include "label/corpus.h"
#include "math/math.h"

#include <math.h>

enum { N_THETA_H = 90, N_THETA_D = 46, N_PHI_D = 24, N_NODES = N_THETA_H * N_THETA_D * N_PHI_D };

typedef struct table {
    float rgb[N_NODES][3]; /* (theta_h, theta_d, phi_d); channel 0 is NaN where there is no value */
} table;

static size_t node(size_t h, size_t d, size_t p) {
    return (h * N_THETA_D + d) * N_PHI_D + p;
}

/* The node below x and the share of the next. */
static size_t below(double x, size_t n, double *share) {
    size_t i = x > 0 ? (size_t)x : 0;
    i = i > n - 2 ? n - 2 : i;
    *share = fmin(x - (double)i, 1);
    return i;
}

static void interpolate(const table *t, const double *hd, double *rgb) {
    double share[3];
    size_t h = below(sqrt(fmax(hd[0], 0) / (NQM_PI / 2)) * (N_THETA_H - 1), N_THETA_H, &share[0]);
    size_t d = below(hd[1] / (NQM_PI / 2) * (N_THETA_D - 1), N_THETA_D, &share[1]);
    double phi = hd[2] / NQM_PI * N_PHI_D;
    phi -= floor(phi / N_PHI_D) * N_PHI_D;
    size_t p = (size_t)phi;
    share[2] = phi - (double)p;
    double sum[3] = {0}, total = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        size_t dh = corner & 1, dd = corner >> 1 & 1, dp = corner >> 2;
        const float *value = t->rgb[node(h + dh, d + dd, (p + dp) % N_PHI_D)];
        double weight =
            (dh ? share[0] : 1 - share[0]) * (dd ? share[1] : 1 - share[1]) * (dp ? share[2] : 1 - share[2]);
        if (isnan(value[0]))
            continue;
        for (int c = 0; c < 3; ++c)
            sum[c] += weight * (double)value[c];
        total += weight;
    }
    for (int c = 0; c < 3; ++c)
        rgb[c] = sum[c] / total; /* NaN, "no value", where no corner has one */
}

static void table_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        interpolate(self, hd + 3 * i, rgb + 3 * i);
}

static const nqm_brdf_class table_class = {
    .format = "table", .reciprocal = 1, .eval_half_diff = table_eval_half_diff, .free = nqm_free};

/* One theta_h at a time: all its nodes. */
static void fill_slice(const nqm_brdf *brdf, size_t h, table *t) {
    enum { N = N_THETA_D * N_PHI_D };
    double hd[3 * N], rgb[3 * N], u = (double)h / (N_THETA_H - 1);
    uint8_t flag[N];
    for (size_t i = 0; i < N; ++i) {
        hd[3 * i] = u * u * NQM_PI / 2;
        hd[3 * i + 1] = (double)(i / N_PHI_D) / (N_THETA_D - 1) * NQM_PI / 2;
        hd[3 * i + 2] = (double)(i % N_PHI_D) / N_PHI_D * NQM_PI;
    }
    nqm_brdf_eval_half_diff(brdf, N, hd, rgb, flag);
    for (size_t i = 0; i < N; ++i)
        for (size_t c = 0; c < 3; ++c)
            t->rgb[h * N + i][c] =
                flag[i] == NQM_VALUE_OK || flag[i] == NQM_VALUE_CLAMPED ? (float)rgb[3 * i + c] : NAN;
}

nqm_status nqm_corpus_tabulate(const nqm_brdf *brdf, nqm_brdf **table_ret, nqm_error *err) {
    *table_ret = NULL;
    table *t = nqm_alloc(1, sizeof *t);
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    for (size_t h = 0; h < N_THETA_H; ++h)
        fill_slice(brdf, h, t);
    return nqm_brdf_wrap(&table_class, t, nqm_brdf_get_info(brdf).name, NULL, "90x46x24 nodes", table_ret, err);
}

/* ---- folded ------------------------------------------------------------------------------------------------------ */

typedef struct fold {
    nqm_brdf *brdf;
    bool owned;
} fold;

static void fold_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    enum { BLOCK = 128 };
    const nqm_brdf *brdf = ((const fold *)self)->brdf;
    uint8_t flag[BLOCK];
    if (brdf->class_->eval_half_diff) { /* the caller has sorted out the horizon already */
        brdf->class_->eval_half_diff(brdf->self, n, hd, rgb);
        return;
    }
    for (size_t first = 0; first < n; first += BLOCK) {
        size_t m = n - first < BLOCK ? n - first : BLOCK;
        nqm_brdf_eval_half_diff(brdf, m, hd + 3 * first, rgb + 3 * first, flag);
        for (size_t i = 0; i < m; ++i)
            if (flag[i] >= NQM_VALUE_INVALID)
                rgb[3 * (first + i)] = NAN;
    }
}

static void fold_free(void *self) {
    fold *f = self;
    if (f->owned)
        nqm_brdf_free(f->brdf);
    nqm_free(f);
}

static const nqm_brdf_class fold_class = {
    .format = "folded", .reciprocal = 1, .eval_half_diff = fold_eval_half_diff, .free = fold_free};

nqm_status nqm_corpus_fold(nqm_brdf *brdf, bool owned, nqm_brdf **folded_ret, nqm_error *err) {
    *folded_ret = NULL;
    fold *f = nqm_alloc(1, sizeof *f);
    if (!f) {
        if (owned)
            nqm_brdf_free(brdf);
        return nqm_fail_nomem(err, sizeof *f);
    }
    *f = (fold){brdf, owned};
    return nqm_brdf_wrap(&fold_class, f, nqm_brdf_get_info(brdf).name, NULL, NULL, folded_ret, err);
}
