/* SPDX-License-Identifier: MIT
 *
 * Reads the dataset layout of the paper's authors (github.com/behnazkavoosi/neural-brdf-quality-metric): a CSV with one
 * row per pair, `material,model,level,DeltaE,JOD,class`, and for each row, whose `material` field is NAME, the files
 * ROOT/ref/NAME.mat and ROOT/model/NAME.mat, as in their notebook. NAME is the material followed by a running number
 * ("brass_12"): rows whose names differ only in that number belong to one group. A reference that is stored once per
 * material (ROOT/ref/brass.mat) is also accepted.
 */
#include "base/os.h"
#include "data/data.h"
#include "io/io.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

enum { MAX_DIRECTIONS = 100000, MAX_PATH_BYTES = 4096 };

typedef struct reader {
    nqm_dataset *dataset;
    const char *root, *csv_path;
    nqm_split split; /* assigned to every row */
    nqm_csv *csv;
    int material, model, level, delta_e, jod; /* column numbers */
    double *directions_deg, *scratch;         /* (n_directions, 3) */
    size_t n_directions;
    size_t n_clamped; /* number of negative values, which are replaced by 0 */
} reader;

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* Length of the material's name: "brass" in "brass_12". A name without a number is the material's name. */
static size_t material_length(const char *name) {
    size_t n = strlen(name), digits = 0;
    while (digits < n && isdigit((unsigned char)name[n - 1 - digits]))
        ++digits;
    return digits && digits + 1 < n && name[n - 1 - digits] == '_' ? n - 1 - digits : n;
}

/* The kind of a row is its encoding, with the level if it has levels: "ward", "sbrdf.0", "sbrdf.2". The authors give
 * two encodings at levels 0 to 2, of which 0 is the finest. */
static nqm_status find_kind(reader *r, size_t row, uint32_t *kind_ret, nqm_error *err) {
    char kind[64];
    const char *model = nqm_csv_text(r->csv, row, r->model), *level = nqm_csv_text(r->csv, row, r->level);
    bool plain = strcmp(level, "0") == 0 && strcmp(model, "sbrdf") != 0 && strcmp(model, "hbrdf") != 0;
    snprintf(kind, sizeof kind, "%.40s%s%.20s", model, plain ? "" : ".", plain ? "" : level);
    return nqm_dataset_add_kind(r->dataset, kind, "encoding", kind_ret, err);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Find ROOT/FOLDER/NAME.mat, or ROOT/FOLDER/MATERIAL.mat. */
static nqm_status find_file(const reader *r, const char *folder, const char *name, size_t n_material,
                            char path[MAX_PATH_BYTES], nqm_error *err) {
    if (strchr(name, '/'))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: a material's name must not contain '/': '%.100s'", r->csv_path,
                        name);
    const size_t lengths[2] = {strlen(name), n_material};
    for (int i = 0; i < 2; ++i) {
        int n = snprintf(path, MAX_PATH_BYTES, "%s/%s/%.*s.mat", r->root, folder, (int)lengths[i], name);
        if (n > 0 && n < MAX_PATH_BYTES && nqm_os_exists(path))
            return NQM_OK;
    }
    return nqm_fail(err, NQM_ERR_IO, -1, "%s/%s: neither %.100s.mat nor %.*s.mat is there (row '%.100s' of %s)",
                    r->root, folder, name, (int)n_material, name, name, r->csv_path);
}

static nqm_status check_locations(reader *r, nqm_mat *mat, const char *path, nqm_error *err) {
    const double tolerance_deg = 1e-9;
    size_t n = r->n_directions;
    nqm_status status = nqm_mat_read(mat, "random_locations", n, 3, r->scratch, err);
    for (size_t i = 0; status == NQM_OK && i < 3 * n; ++i)
        if (!(fabs(r->scratch[i] - r->directions_deg[i]) <= tolerance_deg))
            status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                              "%s: random_locations differ from those of the first file (row %zu: %g, there %g)", path,
                              i / 3 + 1, r->scratch[i], r->directions_deg[i]);
    return status;
}

/* Read r, g and b of a file into rgb (n_directions, 3). Negative values (out of gamut) become 0 and are counted. */
static nqm_status read_rgb(reader *r, const char *path, float *rgb, nqm_error *err) {
    static const char *const channels[3] = {"r", "g", "b"};
    nqm_mat *mat;
    nqm_status status = nqm_mat_open(path, &mat, err);
    if (status == NQM_OK)
        status = check_locations(r, mat, path, err);
    for (size_t k = 0; status == NQM_OK && k < 3; ++k) {
        status = nqm_mat_read(mat, channels[k], r->n_directions, 1, r->scratch, err);
        for (size_t i = 0; status == NQM_OK && i < r->n_directions; ++i) {
            double v = r->scratch[i];
            r->n_clamped += v < 0;
            rgb[3 * i + k] = v > 0 ? (float)v : 0;
        }
    }
    nqm_mat_close(mat);
    return status;
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* Find the reference whose samples were just read into row n_refs of ref_rgb: an earlier reference of the same material
 * with equal samples, or else a new one. */
static nqm_status find_reference(reader *r, const char *name, uint32_t group, uint32_t *ref_ret, nqm_error *err) {
    const nqm_dataset *d = r->dataset;
    const size_t n_columns = 3 * r->n_directions, n_refs = d->n_refs;
    const float *rgb = d->ref_rgb + n_refs * n_columns;
    for (size_t i = n_refs; i-- > 0;)
        if (d->ref_group[i] == group && memcmp(d->ref_rgb + i * n_columns, rgb, n_columns * sizeof *rgb) == 0) {
            *ref_ret = (uint32_t)i;
            return NQM_OK;
        }
    *ref_ret = (uint32_t)n_refs;
    return nqm_dataset_add_reference(r->dataset, name, group, err);
}

static nqm_status read_row(reader *r, size_t row, nqm_error *err) {
    char path[MAX_PATH_BYTES];
    nqm_dataset *d = r->dataset;
    const size_t n_columns = 3 * r->n_directions;
    const char *name = nqm_csv_text(r->csv, row, r->material);
    size_t n_material = material_length(name);
    uint32_t group = 0, ref = 0, kind = 0;
    double delta_e = 0, jod = 0;
    nqm_status status = nqm_csv_number(r->csv, row, r->delta_e, &delta_e, err);
    if (status == NQM_OK)
        status = nqm_csv_number(r->csv, row, r->jod, &jod, err);
    if (status == NQM_OK)
        status = find_file(r, "ref", name, n_material, path, err);
    if (status == NQM_OK)
        status = read_rgb(r, path, d->ref_rgb + d->n_refs * n_columns, err);
    if (status == NQM_OK)
        status = find_file(r, "model", name, strlen(name), path, err);
    if (status == NQM_OK)
        status = read_rgb(r, path, d->test_rgb + row * n_columns, err);
    if (status == NQM_OK)
        status = nqm_dataset_add_group(d, name, n_material, r->split, &group, err);
    if (status == NQM_OK)
        status = find_reference(r, name, group, &ref, err);
    if (status == NQM_OK)
        status = find_kind(r, row, &kind, err);
    return status == NQM_OK ? nqm_dataset_add_pair(d, ref, name, kind, delta_e, jod, err) : status;
}

/* ---- dataset ----------------------------------------------------------------------------------------------------- */

static nqm_status open_labels(reader *r, nqm_error *err) {
    const struct {
        const char *name;
        int *column;
    } needed[] = {{"material", &r->material},
                  {"model", &r->model},
                  {"level", &r->level},
                  {"DeltaE", &r->delta_e},
                  {"JOD", &r->jod}};
    nqm_status status = nqm_csv_load(r->csv_path, &r->csv, err);
    for (size_t i = 0; status == NQM_OK && i < sizeof needed / sizeof needed[0]; ++i)
        if ((*needed[i].column = nqm_csv_column(r->csv, needed[i].name)) < 0)
            status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no column '%s'", r->csv_path, needed[i].name);
    if (status == NQM_OK && nqm_csv_rows(r->csv) == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no rows", r->csv_path);
    return status;
}

/* Read the directions from the model file of the first row; all other files must have the same ones. */
static nqm_status read_directions(reader *r, nqm_error *err) {
    char path[MAX_PATH_BYTES];
    size_t n = 0, n_columns = 0;
    nqm_mat *mat = NULL;
    const char *name = nqm_csv_text(r->csv, 0, r->material);
    nqm_status status = find_file(r, "model", name, strlen(name), path, err);
    if (status == NQM_OK)
        status = nqm_mat_open(path, &mat, err);
    if (status == NQM_OK)
        status = nqm_mat_shape(mat, "random_locations", &n, &n_columns, err);
    if (status == NQM_OK && (n == 0 || n > MAX_DIRECTIONS))
        status = nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: %zu directions; 1 to %d are possible", path, n, MAX_DIRECTIONS);
    if (status == NQM_OK) {
        r->directions_deg = nqm_alloc(n, 6 * sizeof(double));
        status = r->directions_deg ? nqm_mat_read(mat, "random_locations", n, 3, r->directions_deg, err)
                                   : nqm_fail_nomem(err, n * 6 * sizeof(double));
        r->scratch = r->directions_deg + 3 * n;
    }
    r->n_directions = n;
    nqm_mat_close(mat);
    return status;
}

nqm_status nqm_dataset_read_authors(const char *root, const char *labels_csv, nqm_split split,
                                    nqm_dataset **dataset_ret, nqm_error *err) {
    reader r = {.root = root, .csv_path = labels_csv, .split = split == NQM_SPLIT_ALL ? NQM_SPLIT_TRAIN : split};
    nqm_status status = open_labels(&r, err);
    if (status == NQM_OK)
        status = read_directions(&r, err);
    if (status == NQM_OK) {
        const size_t n_rows = nqm_csv_rows(r.csv);
        const nqm_dataset_limits limits = {.n_directions = r.n_directions,
                                           .directions_deg = r.directions_deg,
                                           .max_refs = n_rows,
                                           .max_pairs = n_rows};
        status = nqm_dataset_begin(&limits, &r.dataset, err);
    }
    if (status == NQM_OK) {
        char manifest[200];
        for (size_t row = 0; status == NQM_OK && row < nqm_csv_rows(r.csv); ++row)
            status = read_row(&r, row, err);
        snprintf(manifest, sizeof manifest, "{\"source\": \"authors' layout\", \"negative_values_read_as_0\": %zu}",
                 r.n_clamped);
        status = nqm_dataset_finish(r.dataset, status, manifest, labels_csv, dataset_ret, err);
    }
    nqm_free(r.directions_deg);
    nqm_csv_free(r.csv);
    return status;
}
