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

typedef struct tabulation {
    const nqm_brdf *brdf;
    nqm_table_size size;
    float *rgb; /* (n_h, n_d, n_p, 3) */
} tabulation;

/* Evaluate all nodes of one theta_h: NaN where there is no value. */
static void fill_slice(void *user, size_t h) {
    const tabulation *t = user;
    const size_t n_p = t->size.n_p, n = t->size.n_d * n_p;
    float *slice = t->rgb + 3 * h * n;
    double hd[3 * NQM_TABLE_SLICE] = {0}, rgb[3 * NQM_TABLE_SLICE];
    uint8_t flag[NQM_TABLE_SLICE];
    for (size_t i = 0; i < n; ++i)
        nqm_table_node(t->size.n_h, t->size.n_d, n_p, h, i / n_p, i % n_p, hd + 3 * i);
    nqm_brdf_eval_half_diff(t->brdf, n, hd, rgb, flag);
    for (size_t i = 0; i < 3 * n; ++i)
        slice[i] = nqm_has_value(flag[i / 3]) ? (float)rgb[i] : NAN;
}

nqm_status nqm_brdf_tabulate(const nqm_brdf *brdf, nqm_table_size size, nqm_ticker *ticker, nqm_brdf **table_ret,
                             nqm_error *err) {
    const size_t n = 3 * size.n_h * size.n_d * size.n_p;
    tabulation t = {brdf, size, nqm_alloc(n, sizeof *t.rgb)};
    *table_ret = NULL;
    if (!t.rgb)
        return nqm_fail_nomem(err, n * sizeof *t.rgb);
    nqm_status status =
        nqm_parallel_ticking(ticker, "table", size.n_h, fill_slice, &t)
            ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted")
            : nqm_table_create(size.n_h, size.n_d, size.n_p, t.rgb, nqm_brdf_get_info(brdf).name, table_ret, err);
    nqm_free(t.rgb);
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
