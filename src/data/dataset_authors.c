/* SPDX-License-Identifier: MIT
 *
 * The dataset layout of the paper's authors (github.com/behnazkavoosi/neural-brdf-quality-metric): a CSV with one row a
 * pair, `material,model,level,DeltaE,JOD,class`, and for each row, whose `material` field is NAME, the files
 * ROOT/ref/NAME.mat and ROOT/model/NAME.mat, as their notebook reads them. NAME is the material with a running number
 * ("brass_12"): rows that differ in the number only are one group. A reference that is stored once a material
 * (ROOT/ref/brass.mat) is found too.
 */
#include "data/data.h"
#include "io/io.h"

#include <ctype.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

enum { MAX_DIRECTIONS = 100000, MAX_PATH_BYTES = 4096 };

typedef struct name_list {
    size_t n;
    const char **names;
} name_list;

/* The dataset while it grows: writable sides of the arrays of `d`. */
typedef struct builder {
    nqm_dataset *d;
    const char *root, *csv_path;
    nqm_csv *csv;
    int material, model, level, delta_e, jod; /* column numbers */
    double *directions_deg, *scratch;         /* (n_directions, 3) */
    float *ref_rgb, *test_rgb;
    uint32_t *pair_ref, *pair_kind, *ref_group;
    double *pair_delta_e, *pair_jod;
    name_list refs, groups, kinds, pairs;
    char *text;       /* where the next name goes */
    size_t n_clamped; /* negative values, read as 0 */
} builder;

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* "brass_12" is of material "brass"; a name without a number is a material of its own. */
static size_t material_length(const char *name) {
    size_t n = strlen(name), digits = 0;
    while (digits < n && isdigit((unsigned char)name[n - 1 - digits]))
        ++digits;
    return digits && digits + 1 < n && name[n - 1 - digits] == '_' ? n - 1 - digits : n;
}

static uint32_t append_name(builder *b, name_list *list, const char *name, size_t n) {
    list->names[list->n] = memcpy(b->text, name, n);
    b->text[n] = '\0';
    b->text += n + 1;
    return (uint32_t)list->n++;
}

/* Index of a name, appended when new. Searched from the end: equal names stand together in these files. */
static uint32_t intern_name(builder *b, name_list *list, const char *name, size_t n) {
    for (size_t i = list->n; i-- > 0;)
        if (strlen(list->names[i]) == n && memcmp(list->names[i], name, n) == 0)
            return (uint32_t)i;
    return append_name(b, list, name, n);
}

/* The encoding of a row: "sbrdf" at level 0, "sbrdf.2" at level 2. */
static uint32_t intern_kind(builder *b, size_t row) {
    char kind[64];
    const char *level = nqm_csv_text(b->csv, row, b->level);
    bool plain = strcmp(level, "0") == 0;
    snprintf(kind, sizeof kind, "%.40s%s%.20s", nqm_csv_text(b->csv, row, b->model), plain ? "" : ".",
             plain ? "" : level);
    return intern_name(b, &b->kinds, kind, strlen(kind));
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Find ROOT/FOLDER/NAME.mat, or the same with the material's name alone. */
static nqm_status find_file(const builder *b, const char *folder, const char *name, size_t n_material,
                            char path[MAX_PATH_BYTES], nqm_error *err) {
    if (strchr(name, '/'))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: a material's name must not hold '/': '%.100s'", b->csv_path,
                        name);
    const size_t lengths[2] = {strlen(name), n_material};
    struct stat st;
    for (int i = 0; i < 2; ++i) {
        int n = snprintf(path, MAX_PATH_BYTES, "%s/%s/%.*s.mat", b->root, folder, (int)lengths[i], name);
        if (n > 0 && n < MAX_PATH_BYTES && stat(path, &st) == 0)
            return NQM_OK;
    }
    return nqm_fail(err, NQM_ERR_IO, -1, "%s/%s: neither %.100s.mat nor %.*s.mat is there (row '%.100s' of %s)",
                    b->root, folder, name, (int)n_material, name, name, b->csv_path);
}

static nqm_status check_locations(builder *b, nqm_mat *mat, const char *path, nqm_error *err) {
    const double tolerance_deg = 1e-9;
    size_t n = b->d->n_directions;
    nqm_status status = nqm_mat_read(mat, "random_locations", n, 3, b->scratch, err);
    for (size_t i = 0; status == NQM_OK && i < 3 * n; ++i)
        if (!(fabs(b->scratch[i] - b->directions_deg[i]) <= tolerance_deg))
            status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                              "%s: random_locations differ from those of the first file (row %zu: %g, there %g)", path,
                              i / 3 + 1, b->scratch[i], b->directions_deg[i]);
    return status;
}

/* r, g, b of one file into rgb (n_directions, 3); negative values (out of gamut) become 0 and are counted. */
static nqm_status read_rgb(builder *b, const char *path, float *rgb, nqm_error *err) {
    static const char *const channels[3] = {"r", "g", "b"};
    nqm_mat *mat;
    nqm_status status = nqm_mat_open(path, &mat, err);
    if (status == NQM_OK)
        status = check_locations(b, mat, path, err);
    for (size_t k = 0; status == NQM_OK && k < 3; ++k) {
        status = nqm_mat_read(mat, channels[k], b->d->n_directions, 1, b->scratch, err);
        for (size_t i = 0; status == NQM_OK && i < b->d->n_directions; ++i) {
            double v = b->scratch[i];
            b->n_clamped += v < 0;
            rgb[3 * i + k] = v > 0 ? (float)v : 0;
        }
    }
    nqm_mat_close(mat);
    return status;
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* The reference that has just been read behind the last one: kept, or found to equal an earlier one of its material. */
static uint32_t intern_reference(builder *b, const char *name, uint32_t group) {
    size_t n_columns = 3 * b->d->n_directions, n_refs = b->refs.n;
    const float *rgb = b->ref_rgb + n_refs * n_columns;
    for (size_t i = n_refs; i-- > 0;)
        if (b->ref_group[i] == group && memcmp(b->ref_rgb + i * n_columns, rgb, n_columns * sizeof *rgb) == 0)
            return (uint32_t)i;
    b->ref_group[n_refs] = group;
    return append_name(b, &b->refs, name, strlen(name));
}

static nqm_status read_row(builder *b, size_t row, nqm_error *err) {
    char path[MAX_PATH_BYTES];
    size_t n_columns = 3 * b->d->n_directions;
    const char *name = nqm_csv_text(b->csv, row, b->material);
    size_t n_material = material_length(name);
    nqm_status status = nqm_csv_number(b->csv, row, b->delta_e, &b->pair_delta_e[row], err);
    if (status == NQM_OK)
        status = nqm_csv_number(b->csv, row, b->jod, &b->pair_jod[row], err);
    if (status == NQM_OK)
        status = find_file(b, "ref", name, n_material, path, err);
    if (status == NQM_OK)
        status = read_rgb(b, path, b->ref_rgb + b->refs.n * n_columns, err);
    if (status == NQM_OK)
        status = find_file(b, "model", name, strlen(name), path, err);
    if (status == NQM_OK)
        status = read_rgb(b, path, b->test_rgb + row * n_columns, err);
    if (status != NQM_OK)
        return status;
    b->pair_ref[row] = intern_reference(b, name, intern_name(b, &b->groups, name, n_material));
    b->pair_kind[row] = intern_kind(b, row);
    append_name(b, &b->pairs, name, strlen(name));
    return NQM_OK;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static nqm_status open_labels(builder *b, nqm_error *err) {
    const struct {
        const char *name;
        int *column;
    } needed[] = {{"material", &b->material},
                  {"model", &b->model},
                  {"level", &b->level},
                  {"DeltaE", &b->delta_e},
                  {"JOD", &b->jod}};
    nqm_status status = nqm_csv_load(b->csv_path, &b->csv, err);
    for (size_t i = 0; status == NQM_OK && i < sizeof needed / sizeof needed[0]; ++i)
        if ((*needed[i].column = nqm_csv_column(b->csv, needed[i].name)) < 0)
            status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no column '%s'", b->csv_path, needed[i].name);
    if (status == NQM_OK && nqm_csv_rows(b->csv) == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no rows", b->csv_path);
    return status;
}

/* The directions of the first row's model, which all others must share. */
static nqm_status read_directions(builder *b, nqm_error *err) {
    char path[MAX_PATH_BYTES];
    size_t n = 0, n_columns = 0;
    nqm_mat *mat = NULL;
    const char *name = nqm_csv_text(b->csv, 0, b->material);
    nqm_status status = find_file(b, "model", name, strlen(name), path, err);
    if (status == NQM_OK)
        status = nqm_mat_open(path, &mat, err);
    if (status == NQM_OK)
        status = nqm_mat_shape(mat, "random_locations", &n, &n_columns, err);
    if (status == NQM_OK && (n == 0 || n > MAX_DIRECTIONS))
        status = nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: %zu directions; 1 to %d are possible", path, n, MAX_DIRECTIONS);
    if (status == NQM_OK) {
        b->directions_deg = nqm_dataset_alloc(b->d, n, 3 * sizeof(double));
        b->scratch = nqm_alloc(n, 3 * sizeof(double));
        if (!b->directions_deg || !b->scratch)
            status = nqm_fail_nomem(err, n * 6 * sizeof(double));
        else
            status = nqm_mat_read(mat, "random_locations", n, 3, b->directions_deg, err);
    }
    b->d->n_directions = n;
    nqm_mat_close(mat);
    return status;
}

static nqm_status allocate(builder *b, nqm_error *err) {
    nqm_dataset *d = b->d;
    size_t n = nqm_csv_rows(b->csv), n_text = 0, n_bytes = n * d->n_directions * 3 * sizeof(float);
    for (size_t row = 0; row < n; ++row) /* each row adds at most: reference, group, pair, and a kind of 64 bytes */
        n_text += 3 * (strlen(nqm_csv_text(b->csv, row, b->material)) + 1) + 64;
    b->ref_rgb = nqm_dataset_alloc(d, n, d->n_directions * 3 * sizeof(float));
    b->test_rgb = nqm_dataset_alloc(d, n, d->n_directions * 3 * sizeof(float));
    b->pair_ref = nqm_dataset_alloc(d, n, sizeof *b->pair_ref);
    b->pair_kind = nqm_dataset_alloc(d, n, sizeof *b->pair_kind);
    b->ref_group = nqm_dataset_alloc(d, n, sizeof *b->ref_group);
    b->pair_delta_e = nqm_dataset_alloc(d, n, sizeof(double));
    b->pair_jod = nqm_dataset_alloc(d, n, sizeof(double));
    b->text = nqm_dataset_alloc(d, n_text, 1);
    name_list *lists[] = {&b->refs, &b->groups, &b->kinds, &b->pairs};
    bool ok =
        b->ref_rgb && b->test_rgb && b->pair_ref && b->pair_kind && b->ref_group && b->pair_delta_e && b->pair_jod;
    for (size_t i = 0; i < 4; ++i) {
        lists[i]->names = nqm_dataset_alloc(d, n, sizeof(char *));
        ok = ok && lists[i]->names;
    }
    return ok && b->text ? NQM_OK : nqm_fail_nomem(err, 2 * n_bytes);
}

/* Lend the arrays to the dataset; every group gets the one split. */
static nqm_status finish(builder *b, nqm_split split, nqm_error *err) {
    enum { MANIFEST_BYTES = 200 };
    nqm_dataset *d = b->d;
    uint8_t *group_split = nqm_dataset_alloc(d, b->groups.n, 1);
    const char **families = nqm_dataset_alloc(d, b->kinds.n, sizeof *families);
    char *manifest = nqm_dataset_alloc(d, MANIFEST_BYTES, 1);
    if (!group_split || !families || !manifest)
        return nqm_fail_nomem(err, b->groups.n);
    memset(group_split, split == NQM_SPLIT_ALL ? NQM_SPLIT_TRAIN : (int)split, b->groups.n);
    snprintf(manifest, MANIFEST_BYTES, "{\"source\": \"authors' layout\", \"negative_values_read_as_0\": %zu}",
             b->n_clamped);
    d->n_pairs = b->pairs.n;
    d->n_refs = b->refs.n;
    d->n_groups = b->groups.n;
    d->n_kinds = b->kinds.n;
    d->directions_deg = b->directions_deg;
    d->ref_rgb = b->ref_rgb;
    d->test_rgb = b->test_rgb;
    d->pair_ref = b->pair_ref;
    d->pair_kind = b->pair_kind;
    d->delta_e = b->pair_delta_e;
    d->jod = b->pair_jod;
    d->ref_group = b->ref_group;
    d->group_split = group_split;
    d->ref_names = b->refs.names;
    d->group_names = b->groups.names;
    d->kind_names = b->kinds.names;
    for (size_t i = 0; i < b->kinds.n; ++i)
        families[i] = "encoding";
    d->kind_families = families;
    d->pair_names = b->pairs.names;
    d->manifest = manifest;
    nqm_status status = nqm_dataset_validate(d, b->csv_path, err);
    if (status == NQM_OK)
        status = nqm_directions_from_degrees(d->n_directions, d->directions_deg, &d->directions, err);
    return status == NQM_OK ? nqm_dataset_hash(d, d->sha256, err) : status;
}

nqm_status nqm_dataset_load_authors(const char *root, const char *labels_csv, nqm_split split,
                                    nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
    builder b = {.root = root, .csv_path = labels_csv, .d = nqm_alloc(1, sizeof *b.d)};
    nqm_status status = b.d ? open_labels(&b, err) : nqm_fail_nomem(err, sizeof *b.d);
    if (status == NQM_OK)
        status = read_directions(&b, err);
    if (status == NQM_OK)
        status = allocate(&b, err);
    for (size_t row = 0; status == NQM_OK && row < nqm_csv_rows(b.csv); ++row)
        status = read_row(&b, row, err);
    if (status == NQM_OK)
        status = finish(&b, split, err);
    nqm_free(b.scratch);
    nqm_csv_free(b.csv);
    if (status == NQM_OK)
        *dataset_ret = b.d;
    else
        nqm_dataset_free(b.d);
    return status;
}
