/* SPDX-License-Identifier: MIT
 *
 * Polarimetric materials (Baek et al. 2020, DOI 10.1145/3386569.3392387; doc/files.md) in the tensor container: 4 x 4 Mueller matrices,
 * of which element (0, 0) is read. Values stay in the mapped file, which has about a gigabyte.
 */
#include "brdf/formats/format.h"

#include "brdf/formats/grid.h"
#include "io/io.h"

/* Allocated as one block; nodes and weights follow the struct. */
typedef struct pbsdf {
    nqm_grid grid; /* the first member: the class evaluates it */
    nqm_map map;
} pbsdf;

static void pbsdf_free(void *self) {
    nqm_map_close(&((pbsdf *)self)->map);
    nqm_free(self);
}

static const nqm_brdf_class pbsdf_class = {.format = "pbsdf", .eval_half_diff = nqm_grid_eval, .free = pbsdf_free};

nqm_status nqm_brdf_fail_tensor(const char *path, const nqm_tensor *t, const char *fault, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, t->byte_offset, "%s: '%s' at byte %lld %s", path, t->name,
                    (long long)t->byte_offset, fault);
}

nqm_status nqm_brdf_tensor_weights(const char *path, const nqm_tensor *wavelengths, nqm_illuminant illuminant,
                                   double *weights, nqm_error *err) {
    const unsigned char *stored = wavelengths->data;
    const size_t size = nqm_dtype_size(wavelengths->dtype), n = wavelengths->n_bytes / size;
    float *nm = nqm_alloc(n, sizeof *nm);
    if (!nm)
        return nqm_fail_nomem(err, n * sizeof *nm);
    for (size_t i = 0; i < n; ++i, stored += size)
        nm[i] = wavelengths->dtype == NQM_U16 ? (float)nqm_load_u16(stored) : nqm_load_f32(stored);
    const bool visible = nqm_spectrum_is_visible(n, nm);
    if (visible)
        nqm_spectrum_weights(illuminant, n, nm, weights);
    nqm_free(nm);
    return visible ? NQM_OK
                   : nqm_brdf_fail_tensor(path, wavelengths, "does not rise from at most 500 to at least 600 nm", err);
}

enum { N_AXES = 3, MATRIX = 16 }; /* axes of M: theta_h, theta_d, phi_d; elements of a matrix */

/* In the order of the half-vector coordinates. dim: dimension of M. */
static const struct {
    const char *name;
    size_t dim, least;
    double low, high; /* range of the nodes, radians */
} axes[N_AXES] = {
    {"theta_h", 2, 2, 0, NQM_PI / 2}, {"theta_d", 1, 2, 0, NQM_PI / 2}, {"phi_d", 0, 1, -NQM_PI, 2 * NQM_PI}};

typedef struct contents {
    const char *path;
    const nqm_tensor *m, *wavelengths, *axis[N_AXES];
} contents;

static nqm_status find_tensors(const nqm_tensor_file *file, contents *c, nqm_error *err) {
    const struct {
        const char *name;
        nqm_dtype dtype;
        const nqm_tensor **t;
    } needed[] = {{"M", NQM_F32, &c->m},
                  {"wvls", NQM_U16, &c->wavelengths},
                  {axes[0].name, NQM_F32, c->axis},
                  {axes[1].name, NQM_F32, c->axis + 1},
                  {axes[2].name, NQM_F32, c->axis + 2}};
    for (size_t i = 0; i < sizeof needed / sizeof *needed; ++i) {
        const nqm_tensor *t = *needed[i].t = nqm_tensor_file_find(file, needed[i].name);
        if (!t)
            return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: has no tensor '%s' (byte 0)", c->path, needed[i].name);
        if (t->dtype != needed[i].dtype)
            return nqm_brdf_fail_tensor(c->path, t, "has a type that is not that of a polarimetric material", err);
    }
    return NQM_OK;
}

static nqm_status check_shapes(const contents *c, nqm_error *err) {
    const size_t *dims = c->m->dims;
    if (c->m->n_dims != 6 || dims[4] != 4 || dims[5] != 4)
        return nqm_brdf_fail_tensor(c->path, c->m, "does not have 4 x 4 matrices over four coordinates", err);
    if (dims[3] < 2 || dims[3] != nqm_tensor_count(c->wavelengths))
        return nqm_brdf_fail_tensor(c->path, c->m, "does not have a matrix for each of two or more `wvls`", err);
    for (size_t i = 0; i < N_AXES; ++i)
        if (dims[axes[i].dim] < axes[i].least || dims[axes[i].dim] != nqm_tensor_count(c->axis[i]))
            return nqm_brdf_fail_tensor(c->path, c->axis[i], "does not have one angle for each matrix, or too few",
                                        err);
    return NQM_OK;
}

static nqm_status read_axis(const contents *c, size_t i, double *node, nqm_error *err) {
    const double slack = 1e-3; /* tolerance for angles stored as rounded degrees */
    const unsigned char *stored = c->axis[i]->data;
    const size_t n = nqm_tensor_count(c->axis[i]);
    for (size_t k = 0; k < n; ++k) {
        node[k] = (double)nqm_load_f32(stored + k * sizeof(float));
        if (!(node[k] >= axes[i].low - slack && node[k] <= axes[i].high + slack) || (k && !(node[k] > node[k - 1])))
            return nqm_brdf_fail_tensor(c->path, c->axis[i], "does not rise within the range of its angle, in radians",
                                        err);
    }
    return node[n - 1] - node[0] <= 2 * NQM_PI + slack
               ? NQM_OK
               : nqm_brdf_fail_tensor(c->path, c->axis[i], "is longer than a turn", err);
}

static nqm_status read_material(const contents *c, nqm_illuminant illuminant, pbsdf **p_ret, nqm_error *err) {
    const size_t *dims = c->m->dims, n_wavelengths = dims[3], matrix_bytes = MATRIX * sizeof(float);
    double *node[N_AXES], *weights;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({p_ret, 1, sizeof(pbsdf)}, {node, nqm_tensor_count(c->axis[0]), sizeof(double)},
                                    {node + 1, nqm_tensor_count(c->axis[1]), sizeof(double)},
                                    {node + 2, nqm_tensor_count(c->axis[2]), sizeof(double)},
                                    {&weights, 3 * n_wavelengths, sizeof(double)}),
                         err);
    for (size_t i = 0; status == NQM_OK && i < N_AXES; ++i)
        status = read_axis(c, i, node[i], err);
    if (status == NQM_OK)
        status = nqm_brdf_tensor_weights(c->path, c->wavelengths, illuminant, weights, err);
    if (status != NQM_OK)
        return status;
    const size_t h_bytes = n_wavelengths * matrix_bytes, d_bytes = dims[2] * h_bytes;
    (*p_ret)->grid = (nqm_grid){.n = {dims[2], dims[1], dims[0]},
                                .node = {node[0], node[1], node[2]},
                                .period = 2 * NQM_PI,
                                .value = c->m->data,
                                .stride = {h_bytes, d_bytes, dims[1] * d_bytes},
                                .n_channels = n_wavelengths,
                                .channel_stride = matrix_bytes,
                                .weights = weights};
    return NQM_OK;
}

nqm_status nqm_pbsdf_open(nqm_map *map, const nqm_tensor_file *file, nqm_illuminant illuminant, const char *name,
                          nqm_brdf **brdf_ret, nqm_error *err) {
    contents c = {.path = map->path};
    pbsdf *p = NULL;
    nqm_status status = find_tensors(file, &c, err);
    if (status == NQM_OK)
        status = check_shapes(&c, err);
    if (status == NQM_OK)
        status = read_material(&c, illuminant, &p, err);
    if (status != NQM_OK) {
        nqm_free(p);
        return status;
    }
    const unsigned char *nm = c.wavelengths->data;
    const size_t *dims = c.m->dims;
    char layout[200];
    snprintf(layout, sizeof layout,
             "%zu theta_h x %zu theta_d x %zu phi_d, %zu wavelengths %u to %u nm under illuminant %s, unpolarised",
             dims[2], dims[1], dims[0], dims[3], (unsigned)nqm_load_u16(nm),
             (unsigned)nqm_load_u16(nm + c.wavelengths->n_bytes - sizeof(uint16_t)), nqm_illuminant_name(illuminant));
    const nqm_brdf_info info = {.name = name,
                                .source_doi = "10.1145/3386569.3392387",
                                .layout = layout,
                                .n_values = nqm_tensor_count(c.m) / MATRIX};
    nqm_map_expect(map, false);
    p->map = *map;
    *map = (nqm_map){0};
    return nqm_brdf_wrap(&pbsdf_class, p, &info, brdf_ret, err);
}
