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

#include <math.h>

enum { N_THETA_H = 90, N_THETA_D = 46, N_PHI_D = 24, N_SLICE = N_THETA_D * N_PHI_D };

/* One theta_h at a time: all its nodes. rgb: (N_THETA_D, N_PHI_D, 3); channel 0 is NaN where there is no value. */
static void fill_slice(const nqm_brdf *brdf, size_t h, float *slice) {
    double hd[3 * N_SLICE], rgb[3 * N_SLICE];
    uint8_t flag[N_SLICE];
    for (size_t i = 0; i < N_SLICE; ++i)
        nqm_table_node(N_THETA_H, N_THETA_D, N_PHI_D, h, i / N_PHI_D, i % N_PHI_D, hd + 3 * i);
    nqm_brdf_eval_half_diff(brdf, N_SLICE, hd, rgb, flag);
    for (size_t i = 0; i < 3 * N_SLICE; ++i)
        slice[i] = flag[i / 3] == NQM_VALUE_OK || flag[i / 3] == NQM_VALUE_CLAMPED ? (float)rgb[i] : NAN;
}

nqm_status nqm_corpus_tabulate(const nqm_brdf *brdf, nqm_brdf **table_ret, nqm_error *err) {
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
