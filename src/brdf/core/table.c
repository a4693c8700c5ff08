/* SPDX-License-Identifier: MIT
 *
 * A BRDF as a table over half-vector coordinates with linear interpolation between nodes. Nodes without a value are
 * excluded from the interpolation, so that the table has values as close to the horizon as its source.
 */
#include "brdf/brdf.h"

#include <math.h>

enum { MAX_NODES = 1 << 24 }; /* eleven times a MERL table */

typedef struct table {
    nqm_table_size n;
    double per_h, per_d, per_p, per_phi_h; /* nodes per unit of sqrt(theta_h), theta_d, phi_d, phi_h */
    float rgb[];                           /* (n_h, n_d, n_p, n_phi_h, 3); channel 0 is NaN where there is no value */
} table;

void nqm_table_node(size_t n_h, size_t n_d, size_t n_p, size_t h, size_t d, size_t p, double *hd) {
    double u = (double)h / (double)(n_h - 1);
    hd[0] = u * u * NQM_PI / 2;
    hd[1] = (double)d / (double)(n_d - 1) * NQM_PI / 2;
    hd[2] = (double)p / (double)n_p * NQM_PI;
}

/* Index of the lower of the two nodes around x. weight: (2) receives the interpolation weights of both. */
static size_t below(double x, size_t n, double *weight) {
    size_t i = x > 0 ? (size_t)x : 0;
    i = i > n - 2 ? n - 2 : i;
    weight[1] = fmin(x - (double)i, 1);
    weight[0] = 1 - weight[1];
    return i;
}

/* The two of n nodes of a periodic axis around x >= 0, and their weights. x just below n may be rounded up to it. */
static void around(double x, size_t n, size_t *node, double *weight) {
    const size_t i = (size_t)x;
    weight[1] = x - (double)i;
    weight[0] = 1 - weight[1];
    node[0] = i < n ? i : 0;
    node[1] = node[0] + 1 < n ? node[0] + 1 : 0;
}

static void add_node(const float *value, double weight, double *sum, double *total) {
    if (isnan(value[0]))
        return;
    sum[0] += weight * (double)value[0];
    sum[1] += weight * (double)value[1];
    sum[2] += weight * (double)value[2];
    *total += weight;
}

static void interpolate(const table *t, const double *hd, double phi_h, double *rgb) {
    double weight_h[2], weight_d[2], weight_p[2], weight_m[2];
    size_t h = below(sqrt(fmax(hd[0], 0)) * t->per_h, t->n.n_h, weight_h);
    size_t d = below(hd[1] * t->per_d, t->n.n_d, weight_d), p[2], m[2];
    around(hd[2] * t->per_p, t->n.n_p, p, weight_p);
    around(phi_h * t->per_phi_h, t->n.n_phi_h, m, weight_m);
    double sum[3] = {0}, total = 0;
    for (size_t a = 0; a < 2; ++a)
        for (size_t b = 0; b < 2; ++b) {
            const float *line = t->rgb + ((h + a) * t->n.n_d + d + b) * t->n.n_p * t->n.n_phi_h * 3;
            double both = weight_h[a] * weight_d[b];
            for (size_t c = 0; c < 2; ++c) {
                const float *turn = line + 3 * p[c] * t->n.n_phi_h;
                add_node(turn + 3 * m[0], both * weight_p[c] * weight_m[0], sum, &total);
                if (t->n.n_phi_h > 1)
                    add_node(turn + 3 * m[1], both * weight_p[c] * weight_m[1], sum, &total);
            }
        }
    for (int c = 0; c < 3; ++c)
        rgb[c] = sum[c] / total; /* NaN, "no value", where no neighbour has one */
}

static void table_eval_turned(const void *self, size_t n, const double *hd, const double *turn, double *rgb) {
    for (size_t i = 0; i < n; ++i) {
        const double phi_h = turn ? atan2(turn[2 * i], turn[2 * i + 1]) : 0;
        interpolate(self, hd + 3 * i, phi_h < 0 ? phi_h + 2 * NQM_PI : phi_h, rgb + 3 * i);
    }
}

static const nqm_brdf_class table_class = {
    .format = "table", .reciprocal = 1, .anisotropic = true, .eval_turned = table_eval_turned, .free = nqm_free};

const float *nqm_table_values(const nqm_brdf *brdf, nqm_table_size *size) {
    const table *t = brdf->self;
    *size = t->n;
    return t->rgb;
}

nqm_status nqm_table_create(nqm_table_size n, const void *rgb, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    size_t n_nodes;
    char layout[100];
    *brdf_ret = NULL;
    if (n.n_h < 2 || n.n_d < 2 || n.n_p < 1 || n.n_phi_h < 1 || !nqm_mul_size(n.n_h, n.n_d, &n_nodes) ||
        !nqm_mul_size(n_nodes, n.n_p, &n_nodes) || !nqm_mul_size(n_nodes, n.n_phi_h, &n_nodes) || n_nodes > MAX_NODES)
        return nqm_fail(err, NQM_ERR_LIMIT, -1,
                        "%s: a table of %zu x %zu x %zu x %zu nodes (2 x 2 x 1 x 1 to %d in all)", name, n.n_h, n.n_d,
                        n.n_p, n.n_phi_h, MAX_NODES);
    const size_t n_bytes = 3 * n_nodes * sizeof(float);
    table *t = nqm_alloc(sizeof *t + n_bytes, 1);
    if (!t)
        return nqm_fail_nomem(err, sizeof *t + n_bytes);
    *t = (table){.n = n,
                 .per_h = (double)(n.n_h - 1) / sqrt(NQM_PI / 2),
                 .per_d = (double)(n.n_d - 1) / (NQM_PI / 2),
                 .per_p = (double)n.n_p / NQM_PI,
                 .per_phi_h = (double)n.n_phi_h / (2 * NQM_PI)};
    memcpy(t->rgb, rgb, n_bytes);
    int used = snprintf(layout, sizeof layout, "%zux%zux%zu", n.n_h, n.n_d, n.n_p);
    if (n.n_phi_h > 1)
        used += snprintf(layout + used, sizeof layout - (size_t)used, "x%zu", n.n_phi_h);
    snprintf(layout + used, sizeof layout - (size_t)used, " nodes");
    const nqm_brdf_info info = {.name = name, .layout = layout, .n_values = 3 * n_nodes, .isotropic = n.n_phi_h == 1};
    return nqm_brdf_wrap(&table_class, t, &info, brdf_ret, err);
}

size_t nqm_table_first_bad(size_t n_nodes, const void *rgb) {
    for (size_t i = 0; i < n_nodes; ++i) {
        float node[3];
        memcpy(node, (const char *)rgb + i * sizeof node, sizeof node);
        for (size_t c = 0; c < 3 && !isnan(node[0]); ++c)
            if (!isfinite(node[c]))
                return 3 * i + c;
    }
    return 3 * n_nodes;
}

nqm_status nqm_brdf_create_table(size_t n_theta_h, size_t n_theta_d, size_t n_phi_d, const float *rgb, const char *name,
                                 nqm_brdf **brdf_ret, nqm_error *err) {
    NQM_MAKE(err, brdf_ret, rgb);
    name = name ? name : "table";
    nqm_status status = nqm_table_create((nqm_table_size){n_theta_h, n_theta_d, n_phi_d, 1}, rgb, name, brdf_ret, err);
    const size_t n_nodes = n_theta_h * n_theta_d * n_phi_d,
                 bad = status == NQM_OK ? nqm_table_first_bad(n_nodes, rgb) : 0;
    if (status == NQM_OK && bad < 3 * n_nodes) {
        nqm_brdf_free(*brdf_ret);
        *brdf_ret = NULL;
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: channel %zu of node %zu is not finite", name, bad % 3, bad / 3);
    }
    return status;
}

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
