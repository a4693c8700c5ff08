/* SPDX-License-Identifier: MIT
 *
 * Directions and values (doc/files.md): which rows are one direction, which are a grid, between whose nodes f_r is linear in the
 * angles, and which are scattered (scattered.c). A grid has theta_h, theta_d and phi_d, or theta_i, theta_o and phi = phi_o - phi_i.
 */
#include "brdf/formats/listed.h"

#include "brdf/formats/grid.h"
#include "io/io.h"
#include <math.h>
#include <stdlib.h>

static const double degree = NQM_PI / 180, default_tolerance = 0.1;

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* So that equal differences of azimuths are one node. */
static double round_angle(double angle) {
    return 1e-9 * round(angle / 1e-9);
}

/* At the normal the azimuth means nothing. */
static bool has_azimuth(const nqm_list *l, const nqm_listed *row) {
    return !l->has_pairs || (row->at[0] > 0 && row->at[1] > 0);
}

/* Whether all phi are in the same half of the turn. */
static bool is_half_turn(const nqm_list *l) {
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < l->n; ++i)
        if (has_azimuth(l, &l->rows[i])) {
            low = fmin(low, l->rows[i].at[2]);
            high = fmax(high, l->rows[i].at[2]);
        }
    return high <= (floor(low / NQM_PI + 1e-6) + 1) * NQM_PI + 1e-6;
}

/* Coordinate k of a grid. */
static double coordinate(const nqm_list *l, const nqm_listed *row, size_t k) {
    return k == 2 && l->is_half_turn ? round_angle(fabs(remainder(row->at[2], 2 * NQM_PI))) : row->at[k];
}

void nqm_listed_pair(const nqm_list *l, const nqm_listed *row, double *wi, double *wo) {
    if (!l->has_pairs) {
        nqm_half_diff_to_pair(row->at, wi, wo);
        return;
    }
    nqm_spherical(row->at[0], row->phi_i, wi);
    nqm_spherical(row->at[1], row->phi_i + row->at[2], wo);
}

/* Compare rows by theta_i, theta_o and phi modulo a turn, for qsort(). */
static int compare_pairs(const void *a, const void *b) {
    const nqm_listed *row[] = {*(const nqm_listed *const *)a, *(const nqm_listed *const *)b};
    double phi[2];
    for (size_t k = 0; k < 2; ++k) {
        phi[k] = round_angle(remainder(row[k]->at[2], 2 * NQM_PI));
        phi[k] = phi[k] > 1e-9 - NQM_PI ? phi[k] : -phi[k];
    }
    int order = nqm_compare_doubles(row[0]->at, row[1]->at);
    order = order ? order : nqm_compare_doubles(row[0]->at + 1, row[1]->at + 1);
    return order ? order : nqm_compare_doubles(phi, phi + 1);
}

/* The part of the largest value by which the smallest of the same pair at several phi_i is below it; NaN: there is one phi_i. */
static double spread(size_t n, const nqm_listed *const *row) {
    double low = INFINITY, high = 0;
    bool is_turned = false;
    for (size_t i = 0; i < n; ++i) {
        const double sum = (double)row[i]->rgb[0] + (double)row[i]->rgb[1] + (double)row[i]->rgb[2];
        low = fmin(low, sum);
        high = fmax(high, sum);
        is_turned |= fabs(remainder(row[i]->phi_i - row[0]->phi_i, 2 * NQM_PI)) > 1e-6;
    }
    return is_turned ? (high - low) / fmax(high, 1e-30) : NAN;
}

/* Whether pairs that are listed at several phi_i differ by more than noise. */
static nqm_status find_anisotropy(nqm_list *l, nqm_error *err) {
    static const double noise = 0.1;
    const nqm_listed **row = nqm_alloc(l->n, sizeof *row);
    size_t n = 0, n_turned = 0;
    double sum = 0;
    if (!row)
        return nqm_fail_nomem(err, l->n * sizeof *row);
    for (size_t i = 0; i < l->n; ++i)
        if (has_azimuth(l, l->rows + i) && !isnan(l->rows[i].rgb[0]))
            row[n++] = l->rows + i;
    qsort(row, n, sizeof *row, compare_pairs);
    for (size_t i = 0, m; i < n; i += m) {
        for (m = 1; i + m < n && compare_pairs(row + i, row + i + m) == 0; ++m)
            ;
        const double part = spread(m, row + i);
        n_turned += isnan(part) ? 0 : 1;
        sum += isnan(part) ? 0 : part;
    }
    l->is_anisotropic = sum > noise * (double)n_turned;
    nqm_free(row);
    return NQM_OK;
}

/* Radians read as degrees: all directions are within 1.571 degrees of the normal. */
static nqm_status refuse_radians(const nqm_list *l, nqm_error *err) {
    double theta = 0;
    for (size_t i = 0; i < l->n; ++i)
        theta = fmax(theta, fmax(l->rows[i].at[0], l->rows[i].at[1]) / degree);
    if (l->has_unit || l->n < 20 || !(theta > 0.5 && theta < 1.571))
        return NQM_OK;
    return nqm_fail(
        err, NQM_ERR_FORMAT, 0,
        "%s: the polar angles of all rows (from byte 0 on) are at most %.3g: these are radians, and degrees "
        "are read unless the names of columns have a unit: 'theta_i [rad]', or 'theta_i [deg]' if they are "
        "degrees",
        l->path, theta);
}

static int compare_directions(const nqm_listed *x, const nqm_listed *y) {
    int order = nqm_compare_doubles(&x->phi_i, &y->phi_i);
    for (size_t k = 0; k < 3 && !order; ++k)
        order = nqm_compare_doubles(x->at + k, y->at + k);
    return order;
}

/* By direction, then by value, so that the order of the file does not matter; for qsort(). */
static int compare_rows(const void *a, const void *b) {
    const nqm_listed *x = a, *y = b;
    int order = compare_directions(x, y);
    for (size_t c = 0; c < 3 && !order; ++c)
        order = isnan(x->rgb[c]) - isnan(y->rgb[c]) + (x->rgb[c] > y->rgb[c]) - (x->rgb[c] < y->rgb[c]);
    return order;
}

/* Replace rows of one direction by their mean. The azimuth of the light is a part of the direction if it counts; phi is one modulo its
 * period. */
static void merge_repeated(nqm_list *l) {
    size_t n_kept = 0, n_none = 0;
    const double period = l->is_reciprocal ? NQM_PI : 2 * NQM_PI;
    for (size_t i = 0; i < l->n; ++i) {
        nqm_listed *row = &l->rows[i];
        row->at[2] = round_angle(row->at[2] - period * floor(row->at[2] / period + 1e-9));
        row->phi_i = l->is_anisotropic ? row->phi_i : 0;
    }
    qsort(l->rows, l->n, sizeof *l->rows, compare_rows);
    for (size_t i = 0, m; i < l->n; i += m) {
        double sum[3] = {0};
        size_t n_values = 0;
        for (m = 0; i + m < l->n && compare_directions(&l->rows[i], &l->rows[i + m]) == 0; ++m) {
            const nqm_listed *row = &l->rows[i + m];
            n_values += isnan(row->rgb[0]) ? 0 : 1;
            for (size_t c = 0; c < 3 && !isnan(row->rgb[0]); ++c)
                sum[c] += (double)row->rgb[c];
        }
        nqm_listed mean = l->rows[i];
        for (size_t c = 0; c < 3 && n_values > 1; ++c)
            mean.rgb[c] = (float)(sum[c] / (double)n_values);
        n_none += m - n_values;
        l->rows[n_kept++] = mean;
    }
    if (n_none)
        nqm_remark_add(l->remark, sizeof l->remark, "rows without a value: %zu", n_none);
    l->n_repeated = l->n - n_kept;
    l->n = n_kept;
}

/* ---- complete grids ---------------------------------------------------------------------------------------------- */

static const nqm_brdf_class grid_class = {.format = "grid", .eval_half_diff = nqm_grid_eval, .free = nqm_free};

/* theta_i, theta_o and phi. The value at -phi is that at phi where the nodes are of one half of the turn. */
static void place_pair(const nqm_grid *g, const double *wi, const double *wo, double *at) {
    at[0] = atan2(hypot(wi[0], wi[1]), wi[2]);
    at[1] = atan2(hypot(wo[0], wo[1]), wo[2]);
    at[2] = atan2(wi[0] * wo[1] - wi[1] * wo[0], wi[0] * wo[0] + wi[1] * wo[1]);
    at[2] = g->period < 2 * NQM_PI ? fabs(at[2]) : at[2];
}

static void pair_grid_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    const nqm_grid *g = self;
    for (size_t i = 0; i < n; ++i) {
        double at[3];
        place_pair(g, wi + 3 * i, wo + 3 * i, at);
        nqm_grid_eval_folded(g, at, rgb + 3 * i);
    }
}

static const nqm_brdf_class pair_class = {.format = "grid", .eval = pair_grid_eval, .free = nqm_free};

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* Write the distinct values of coordinate k to node (n), rising; returns their number. */
static size_t distinct(const nqm_list *l, size_t k, double *node) {
    size_t n = 0, n_node = 0;
    for (size_t i = 0; i < l->n; ++i)
        if (k < 2 || has_azimuth(l, &l->rows[i]))
            node[n++] = coordinate(l, &l->rows[i], k);
    qsort(node, n, sizeof *node, nqm_compare_doubles);
    for (size_t i = 0; i < n; ++i)
        if (i == 0 || node[i] > node[n_node - 1])
            node[n_node++] = node[i];
    return n_node;
}

/* 0 for a value that is no node. */
static size_t index_of(const double *node, size_t n, double x) {
    const double *found = bsearch(&x, node, n, sizeof *node, nqm_compare_doubles);
    return found ? (size_t)(found - node) : 0;
}

static bool is_above_horizon(const nqm_list *l, const nqm_listed *row) {
    double wi[3], wo[3];
    nqm_listed_pair(l, row, wi, wo);
    return fmin(wi[2], wo[2]) > 1e-9;
}

/* Store each row at its node; false when two rows have the same one. value: (product of g->n, 3) float32; filled: one
 * per node, zero. */
static bool fill(const nqm_grid *g, const nqm_list *l, unsigned char *value, unsigned char *filled) {
    for (size_t i = 0; i < l->n; ++i) {
        const nqm_listed *row = &l->rows[i];
        size_t at = 0;
        for (size_t k = 0; k < 3; ++k)
            at = at * g->n[k] + index_of(g->node[k], g->n[k], coordinate(l, row, k));
        if (filled[at]++)
            return false;
        for (size_t c = 0; c < 3; ++c)
            nqm_store_f32(value + (3 * at + c) * sizeof(float), is_above_horizon(l, row) ? row->rgb[c] : NAN);
    }
    return true;
}

/* Give nodes without a row the value at another phi where the azimuth means nothing, and none elsewhere; returns the
 * number of those. */
static size_t fill_rest(const nqm_grid *g, unsigned char *value, const unsigned char *filled) {
    const size_t n_phi = g->n[2], n_bytes = 3 * sizeof(float);
    size_t n_missing = 0;
    for (size_t i = 0; i < g->n[0] * g->n[1]; ++i) {
        const bool is_normal = g->node[0][i / g->n[1]] <= 0 || g->node[1][i % g->n[1]] <= 0;
        const unsigned char *first = memchr(filled + i * n_phi, 1, n_phi);
        for (size_t k = 0; k < n_phi; ++k) {
            unsigned char *to = value + (i * n_phi + k) * n_bytes;
            if (filled[i * n_phi + k])
                continue;
            if (first && is_normal) {
                memcpy(to, value + (size_t)(first - filled) * n_bytes, n_bytes);
                continue;
            }
            for (size_t c = 0; c < 3; ++c)
                nqm_store_f32(to + c * sizeof(float), NAN);
            ++n_missing;
        }
    }
    return n_missing;
}

/* Whether the n_product nodes are those of a goniometer, of whose rows some are missing. The limits keep a list that
 * happens to share angles from being a grid, and the memory below ten times the file. */
static bool is_nearly_complete(const nqm_list *l, const nqm_grid *g) {
    size_t n = 0, n_nodes = 0;
    const size_t n_i = g->n[0] - (g->node[0][0] <= 0), n_o = g->n[1] - (g->node[1][0] <= 0);
    for (size_t i = 0; i < l->n; ++i)
        n += has_azimuth(l, &l->rows[i]);
    return l->has_pairs && n_i >= 2 && n_o >= 2 && nqm_mul_size(n_i, n_o, &n_nodes) &&
           nqm_mul_size(n_nodes, g->n[2], &n_nodes) && n_nodes / 4 <= n / 3;
}

/* The axes of a grid. Where these are half a turn the value at -phi is that at phi. */
static void find_axes(const nqm_list *l, nqm_grid *g, double *const node[3]) {
    for (size_t k = 0; k < 3; ++k) {
        g->n[k] = distinct(l, k, node[k]);
        g->node[k] = node[k];
    }
    g->period = l->is_reciprocal ? NQM_PI : 2 * NQM_PI;
    if (l->has_pairs && g->n[2] && node[2][0] > -1e-6 && node[2][g->n[2] - 1] < NQM_PI + 1e-6)
        g->period = node[2][g->n[2] - 1] - node[2][0];
    g->n_channels = 3;
    g->channel_stride = sizeof(float);
    g->stride[2] = 3 * sizeof(float);
    g->stride[1] = g->n[2] * g->stride[2];
    g->stride[0] = g->n[1] * g->stride[1];
    g->weights = identity;
}

/* Whether the axes can be those of a grid, and the number of its nodes. */
static bool can_be_grid(const nqm_list *l, const nqm_grid *g, size_t *n_product) {
    const double turn = l->is_reciprocal ? NQM_PI : 2 * NQM_PI;
    const bool is_turn = g->n[2] && g->node[2][g->n[2] - 1] - g->node[2][0] <= turn + 1e-9;
    if (g->n[0] < 2 || g->n[1] < 2 || !is_turn || !nqm_mul_size(g->n[0], g->n[1], n_product) ||
        !nqm_mul_size(*n_product, g->n[2], n_product))
        return false;
    if (l->has_pairs && (g->n[2] < 2 || nqm_grid_gap(g, 2) > NQM_GRID_WIDEST))
        return false; /* between distant azimuths nothing is known: in the plane of incidence alone there are two */
    return *n_product == l->n || is_nearly_complete(l, g);
}

/* *grid_ret is NULL when the rows are no grid. n_missing_ret: nodes without a row. */
static nqm_status make_grid(const nqm_list *l, nqm_grid **grid_ret, size_t *n_missing_ret, nqm_error *err) {
    double *found[3], *node[3];
    unsigned char *value, *filled;
    size_t n_product;
    nqm_grid axes = {0}, *g;
    *grid_ret = NULL;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({found, l->n, sizeof(double)}, {found + 1, l->n, sizeof(double)}, {found + 2, l->n, sizeof(double)}),
        err);
    if (status != NQM_OK)
        return status;
    find_axes(l, &axes, found);
    if (!can_be_grid(l, &axes, &n_product))
        goto done;
    status = nqm_alloc_arrays(NQM_ARRAYS({&g, 1, sizeof *g}, {node, axes.n[0], sizeof(double)},
                                         {node + 1, axes.n[1], sizeof(double)}, {node + 2, axes.n[2], sizeof(double)},
                                         {&value, 3 * n_product, sizeof(float)}, {&filled, n_product, 1}),
                              err);
    if (status != NQM_OK)
        goto done;
    *g = axes;
    g->value = value;
    for (size_t k = 0; k < 3; ++k)
        g->node[k] = memcpy(node[k], found[k], g->n[k] * sizeof(double));
    if (fill(g, l, value, filled)) {
        *n_missing_ret = fill_rest(g, value, filled);
        *grid_ret = g;
    } else {
        nqm_free(g);
    }
done:
    nqm_free(found[0]);
    return status;
}

static nqm_status wrap_grid(nqm_list *l, nqm_grid *grid, size_t n_missing, const char *name, nqm_brdf **brdf_ret,
                            nqm_error *err) {
    static const char *const axes[2][3] = {{"theta_h", "theta_d", "phi_d"}, {"theta_i", "theta_o", "phi"}};
    const char *const *axis = axes[l->has_pairs];
    char text[300];
    snprintf(text, sizeof text,
             "%zu %s x %zu %s x %zu %s, linear between them, at most %.3g, %.3g and %.3g degrees apart", grid->n[0],
             axis[0], grid->n[1], axis[1], grid->n[2], axis[2], nqm_grid_gap(grid, 0), nqm_grid_gap(grid, 1),
             nqm_grid_gap(grid, 2));
    if (n_missing)
        snprintf(text + strlen(text), sizeof text - strlen(text), "; %zu of %zu nodes have no row", n_missing,
                 grid->n[0] * grid->n[1] * grid->n[2]);
    if (l->n_repeated)
        nqm_remark_add(l->remark, sizeof l->remark, NQM_REPEATED_ROWS, l->n_repeated);
    const nqm_brdf_info info = {
        .name = name, .layout = text, .n_values = 3 * l->n, .remark = l->remark, .reciprocal = l->is_reciprocal};
    return nqm_brdf_wrap(l->has_pairs ? &pair_class : &grid_class, grid, &info, brdf_ret, err);
}

static double nearest_node(const nqm_grid *g, size_t axis, double x) {
    size_t nearest = 0;
    double least = INFINITY;
    for (size_t i = 0; i < g->n[axis]; ++i) {
        const double distance = fabs(remainder(x - g->node[axis][i], 2 * NQM_PI));
        nearest = distance < least ? i : nearest;
        least = fmin(distance, least);
    }
    return g->node[axis][nearest];
}

void nqm_listed_snap(const nqm_brdf *brdf, size_t n, double *wi, double *wo) {
    for (size_t i = 0; i < n && brdf->class_ == &pair_class; ++i) {
        double at[3];
        place_pair(brdf->self, wi + 3 * i, wo + 3 * i, at);
        for (size_t k = 0; k < 3; ++k)
            at[k] = nearest_node(brdf->self, k, at[k]);
        nqm_spherical(at[0], 0, wi + 3 * i);
        nqm_spherical(at[1], at[2], wo + 3 * i);
    }
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

static nqm_status read_tolerance(const char *path, const char *text, double *tolerance, nqm_error *err) {
    const char *end = text;
    *tolerance = default_tolerance;
    if (text && (!nqm_parse_double(text, &end, tolerance) || *end || !(*tolerance > 0 && *tolerance <= 45)))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "%s: '%s' is not an angle around its directions: degrees above 0, up to 45", path, text);
    *tolerance *= degree;
    return NQM_OK;
}

/* A scattered direction takes about 350 bytes, and 40 bytes or more of a large file. */
size_t nqm_listed_most(size_t n_bytes) {
    enum { FREE_ROWS = 1 << 16, BYTES_PER_ROW = 40 };
    return FREE_ROWS + n_bytes / BYTES_PER_ROW;
}

nqm_status nqm_listed_create(nqm_list *l, size_t n_bytes, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret,
                             nqm_error *err) {
    const char *tolerance_text = argument->member;
    double tolerance;
    size_t n_missing = 0;
    nqm_grid *grid = NULL;
    nqm_status status = refuse_radians(l, err);
    if (status == NQM_OK && l->has_pairs)
        status = find_anisotropy(l, err);
    if (status == NQM_OK)
        status = read_tolerance(l->path, tolerance_text, &tolerance, err);
    if (status != NQM_OK)
        return status;
    l->is_half_turn = l->has_pairs && !l->is_anisotropic && is_half_turn(l);
    merge_repeated(l);
    if (!l->is_anisotropic)
        status = make_grid(l, &grid, &n_missing, err);
    if (status != NQM_OK)
        return status;
    if (n_missing && tolerance_text) { /* rows alone are asked for */
        nqm_free(grid);
        grid = NULL;
    }
    if (!grid && l->n > nqm_listed_most(n_bytes))
        return nqm_fail(
            err, NQM_ERR_LIMIT, 0,
            "%s: %zu directions (from byte 0 on) that are no complete grid; %zu are the limit for a file of "
            "%zu bytes",
            l->path, l->n, nqm_listed_most(n_bytes), n_bytes);
    if (!grid)
        return nqm_scattered_create(l, tolerance, argument->name, brdf_ret, err);
    if (!tolerance_text)
        return wrap_grid(l, grid, n_missing, argument->name, brdf_ret, err);
    nqm_free(grid);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: is a complete grid, which is interpolated: open it without ':%s'",
                    l->path, tolerance_text);
}
