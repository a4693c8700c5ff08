/* SPDX-License-Identifier: MIT
 *
 * A BRDF as a table over half-vector coordinates with linear interpolation between nodes. Nodes without a value are
 * excluded from the interpolation, so that the table has values as close to the horizon as its source.
 */
#include "brdf/brdf.h"

#include "math/math.h"
#include <math.h>
#include <string.h>

enum { MAX_NODES = 1 << 24 }; /* eleven times a MERL table */

typedef struct table {
    size_t n_h, n_d, n_p;
    double per_h, per_d, per_p; /* nodes per unit of sqrt(theta_h), theta_d, phi_d */
    float rgb[];                /* (n_h, n_d, n_p, 3); channel 0 is NaN where there is no value */
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

static void interpolate(const table *t, const double *hd, double *rgb) {
    double weight_h[2], weight_d[2], weight_p[2];
    size_t h = below(sqrt(fmax(hd[0], 0)) * t->per_h, t->n_h, weight_h);
    size_t d = below(hd[1] * t->per_d, t->n_d, weight_d);
    double phi = hd[2] * t->per_p;
    size_t p = (size_t)phi;
    weight_p[1] = phi - (double)p;
    weight_p[0] = 1 - weight_p[1];
    p = p < t->n_p ? p : 0; /* phi_d just below pi may round up to it */
    size_t column[2] = {3 * p, 3 * (p + 1 < t->n_p ? p + 1 : 0)};
    double sum[3] = {0}, total = 0;
    for (size_t a = 0; a < 2; ++a)
        for (size_t b = 0; b < 2; ++b) {
            const float *line = t->rgb + ((h + a) * t->n_d + d + b) * t->n_p * 3;
            double both = weight_h[a] * weight_d[b];
            for (size_t c = 0; c < 2; ++c) {
                const float *value = line + column[c];
                double weight = both * weight_p[c];
                if (isnan(value[0]))
                    continue;
                sum[0] += weight * (double)value[0];
                sum[1] += weight * (double)value[1];
                sum[2] += weight * (double)value[2];
                total += weight;
            }
        }
    for (int c = 0; c < 3; ++c)
        rgb[c] = sum[c] / total; /* NaN, "no value", where no neighbour has one */
}

static void table_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        interpolate(self, hd + 3 * i, rgb + 3 * i);
}

static const nqm_brdf_class table_class = {
    .format = "table", .reciprocal = 1, .eval_half_diff = table_eval_half_diff, .free = nqm_free};

const float *nqm_table_values(const nqm_brdf *brdf, size_t *dims) {
    const table *t = brdf->self;
    dims[0] = t->n_h;
    dims[1] = t->n_d;
    dims[2] = t->n_p;
    return t->rgb;
}

nqm_status nqm_table_create(size_t n_h, size_t n_d, size_t n_p, const void *rgb, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err) {
    size_t n_nodes;
    char layout[80];
    *brdf_ret = NULL;
    if (n_h < 2 || n_d < 2 || n_p < 1 || !nqm_mul_size(n_h, n_d, &n_nodes) || !nqm_mul_size(n_nodes, n_p, &n_nodes) ||
        n_nodes > MAX_NODES)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: a table of %zu x %zu x %zu nodes (2 x 2 x 1 to %d in all)", name,
                        n_h, n_d, n_p, MAX_NODES);
    const size_t n_bytes = 3 * n_nodes * sizeof(float);
    table *t = nqm_alloc(sizeof *t + n_bytes, 1);
    if (!t)
        return nqm_fail_nomem(err, sizeof *t + n_bytes);
    *t = (table){.n_h = n_h,
                 .n_d = n_d,
                 .n_p = n_p,
                 .per_h = (double)(n_h - 1) / sqrt(NQM_PI / 2),
                 .per_d = (double)(n_d - 1) / (NQM_PI / 2),
                 .per_p = (double)n_p / NQM_PI};
    memcpy(t->rgb, rgb, n_bytes);
    snprintf(layout, sizeof layout, "%zux%zux%zu nodes", n_h, n_d, n_p);
    const nqm_brdf_info info = {.name = name, .layout = layout, .n_values = 3 * n_nodes};
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
    nqm_status status = nqm_table_create(n_theta_h, n_theta_d, n_phi_d, rgb, name, brdf_ret, err);
    const size_t n_nodes = n_theta_h * n_theta_d * n_phi_d,
                 bad = status == NQM_OK ? nqm_table_first_bad(n_nodes, rgb) : 0;
    if (status == NQM_OK && bad < 3 * n_nodes) {
        nqm_brdf_free(*brdf_ret);
        *brdf_ret = NULL;
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: channel %zu of node %zu is not finite", name, bad % 3, bad / 3);
    }
    return status;
}
