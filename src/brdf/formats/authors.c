/* SPDX-License-Identifier: MIT
 *
 * A BRDF in the layout of the paper's authors (doc/files.md), as `nqm sample -o FILE.mat` writes it: a list of directions.
 */
#include "brdf/formats/listed.h"

#include "io/io.h"

static bool probe(const nqm_map *map) {
    static const char start[] = "MATLAB 5.0 MAT-file";
    return map->n_bytes >= sizeof start && memcmp(map->data, start, sizeof start - 1) == 0;
}

/* values: scratch (6, l->n). */
static nqm_status read_rows(const nqm_mat *mat, nqm_list *l, double *values, nqm_error *err) {
    static const char *const channels[] = {"r", "g", "b"};
    static const double high[] = {90, 90, 360};
    nqm_status status = nqm_mat_read(mat, "random_locations", l->n, 3, values, err);
    for (size_t c = 0; c < 3 && status == NQM_OK; ++c)
        status = nqm_mat_read(mat, channels[c], l->n, 1, values + (3 + c) * l->n, err);
    for (size_t i = 0; i < 3 * l->n && status == NQM_OK; ++i) {
        nqm_listed *row = &l->rows[i / 3];
        row->at[i % 3] = values[i] * NQM_PI / 180;
        row->rgb[i % 3] = (float)values[(3 + i % 3) * l->n + i / 3];
        l->is_reciprocal = l->is_reciprocal && (i % 3 < 2 || values[i] <= 180);
        if (!(values[i] >= 0 && values[i] <= high[i % 3]))
            status =
                nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: random_locations at row %zu: %g is not within 0 to %g degrees",
                         l->path, i / 3 + 1, values[i], high[i % 3]);
    }
    return status;
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_list l = {.path = map->path, .has_unit = true, .is_reciprocal = true};
    nqm_mat *mat = NULL;
    double *values;
    size_t n_columns;
    nqm_status status = nqm_mat_open(map->path, &mat, err);
    if (status == NQM_OK)
        status = nqm_mat_shape(mat, "random_locations", &l.n, &n_columns, err);
    if (status == NQM_OK && l.n > nqm_listed_most(map->n_bytes))
        status = nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: %zu directions; %zu are the limit", l.path, l.n,
                          nqm_listed_most(map->n_bytes));
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&l.rows, l.n, sizeof *l.rows}, {&values, l.n, 6 * sizeof *values}), err);
    if (status == NQM_OK)
        status = read_rows(mat, &l, values, err);
    if (status == NQM_OK)
        status = nqm_listed_create(&l, map->n_bytes, argument, brdf_ret, err);
    nqm_mat_close(mat);
    nqm_free(l.rows);
    return status;
}

const nqm_brdf_format nqm_authors_format = {
    .files = ".mat of the paper's authors", .takes_members = true, .probe = probe, .open = open_file};
