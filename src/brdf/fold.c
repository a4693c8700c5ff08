/* SPDX-License-Identifier: MIT
 *
 * Two derived BRDFs. Folded: evaluated at phi_d in [0, pi) only, the half that sampling directions and perturbations
 * use, so that a measurement that is not reciprocal (up to 39 % in the RGL data) does not differ from its own perturbed
 * copy in the other half. Tabulated: interpolated linearly in a table with theta_h spaced as in MERL's tables, for
 * BRDFs whose evaluation is too slow to render many times (the decoder of a neural process: 806,000 multiplications per
 * pair). Table nodes without a value are excluded from the interpolation.
 */
#include "brdf/brdf.h"

#include <math.h>

enum { N_THETA_H = 90, N_THETA_D = 46, N_PHI_D = 24, N_SLICE = N_THETA_D * N_PHI_D };

/* Evaluate all nodes of one theta_h: slice (N_THETA_D, N_PHI_D, 3), NaN where there is no value. */
static void fill_slice(const nqm_brdf *brdf, size_t h, float *slice) {
    double hd[3 * N_SLICE], rgb[3 * N_SLICE];
    uint8_t flag[N_SLICE];
    for (size_t i = 0; i < N_SLICE; ++i)
        nqm_table_node(N_THETA_H, N_THETA_D, N_PHI_D, h, i / N_PHI_D, i % N_PHI_D, hd + 3 * i);
    nqm_brdf_eval_half_diff(brdf, N_SLICE, hd, rgb, flag);
    for (size_t i = 0; i < 3 * N_SLICE; ++i)
        slice[i] = nqm_has_value(flag[i / 3]) ? (float)rgb[i] : NAN;
}

nqm_status nqm_brdf_tabulate(const nqm_brdf *brdf, nqm_brdf **table_ret, nqm_error *err) {
    *table_ret = NULL;
    float *rgb = nqm_alloc(3 * N_THETA_H * N_SLICE, sizeof *rgb);
    if (!rgb)
        return nqm_fail_nomem(err, 3 * N_THETA_H * N_SLICE * sizeof *rgb);
    for (size_t h = 0; h < N_THETA_H; ++h)
        fill_slice(brdf, h, rgb + 3 * h * N_SLICE);
    nqm_status status =
        nqm_table_create(N_THETA_H, N_THETA_D, N_PHI_D, rgb, nqm_brdf_get_info(brdf).name, table_ret, err);
    nqm_free(rgb);
    return status;
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
    if (brdf->class_->eval_half_diff) { /* the caller has excluded pairs below the horizon */
        brdf->class_->eval_half_diff(brdf->self, n, hd, rgb);
        return;
    }
    for (size_t first = 0; first < n; first += BLOCK) {
        size_t m = n - first < BLOCK ? n - first : BLOCK;
        nqm_brdf_eval_half_diff(brdf, m, hd + 3 * first, rgb + 3 * first, flag);
        for (size_t i = 0; i < m; ++i)
            if (!nqm_has_value(flag[i]))
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

nqm_status nqm_brdf_fold(nqm_brdf *brdf, bool owned, nqm_brdf **folded_ret, nqm_error *err) {
    *folded_ret = NULL;
    fold *f = nqm_alloc(1, sizeof *f);
    if (!f) {
        if (owned)
            nqm_brdf_free(brdf);
        return nqm_fail_nomem(err, sizeof *f);
    }
    *f = (fold){brdf, owned};
    return nqm_brdf_wrap(&fold_class, f, &(nqm_brdf_info){.name = brdf->info.name}, folded_ret, err);
}
