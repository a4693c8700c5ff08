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
