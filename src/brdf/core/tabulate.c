/* SPDX-License-Identifier: MIT
 *
 * A BRDF as a table with linear interpolation and theta_h spaced as in MERL's tables, for BRDFs whose evaluation is too
 * slow to render many times (the decoder of a neural process: 806,000 multiplications per pair). A table is reciprocal: it has
 * the values at phi_d in [0, pi). Nodes without a value are excluded from the interpolation.
 */
#include "brdf/brdf.h"

#include <math.h>

typedef struct tabulation {
    const nqm_brdf *brdf;
    nqm_table_size size;
    float *rgb; /* (n_h, n_d, n_p, n_phi_h, 3) */
} tabulation;

/* Evaluate all nodes of one theta_h and phi_h: NaN where there is no value. */
static void fill_slice(void *user, size_t slice) {
    const tabulation *t = user;
    const size_t n_p = t->size.n_p, n = t->size.n_d * n_p, n_m = t->size.n_phi_h, h = slice / n_m, m = slice % n_m;
    const double phi_h = (double)m / (double)n_m * 2 * NQM_PI;
    double hd[3 * NQM_TABLE_SLICE] = {0}, turn[2 * NQM_TABLE_SLICE] = {0}, rgb[3 * NQM_TABLE_SLICE];
    uint8_t flag[NQM_TABLE_SLICE];
    for (size_t i = 0; i < n; ++i) {
        nqm_table_node(t->size.n_h, t->size.n_d, n_p, h, i / n_p, i % n_p, hd + 3 * i);
        turn[2 * i] = sin(phi_h);
        turn[2 * i + 1] = cos(phi_h);
    }
    nqm_brdf_eval_turned(t->brdf, n, hd, m ? turn : NULL, rgb, flag);
    for (size_t i = 0; i < 3 * n; ++i)
        t->rgb[3 * ((h * n + i / 3) * n_m + m) + i % 3] = nqm_has_value(flag[i / 3]) ? (float)rgb[i] : NAN;
}

nqm_status nqm_brdf_tabulate(const nqm_brdf *brdf, nqm_table_size size, nqm_ticker *ticker, nqm_brdf **table_ret,
                             nqm_error *err) {
    if (!size.n_phi_h)
        size.n_phi_h = brdf->info.isotropic ? 1 : NQM_TABLE_PHI_H;
    const size_t n_slices = size.n_h * size.n_phi_h, n = 3 * n_slices * size.n_d * size.n_p;
    tabulation t = {brdf, size, nqm_alloc(n, sizeof *t.rgb)};
    *table_ret = NULL;
    if (!t.rgb)
        return nqm_fail_nomem(err, n * sizeof *t.rgb);
    nqm_status status = nqm_parallel_ticking(ticker, "table", n_slices, fill_slice, &t)
                            ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted")
                            : nqm_table_create(size, t.rgb, nqm_brdf_get_info(brdf).name, table_ret, err);
    nqm_free(t.rgb);
    return status;
}
