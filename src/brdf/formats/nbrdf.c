/* SPDX-License-Identifier: MIT
 *
 * NBRDF (Sztrajman et al. 2021, DOI 10.1111/cgf.14335; doc/files.md): a network of 6-21-21-3 in a Keras .h5 file, plain or inside a
 * zip, or in six .npy files.
 */
#include "brdf/formats/format.h"

#include "io/io.h"
#include <math.h>

/* Rows are padded with zeros to a multiple of four, so that vectorised loops need no remainder. */
enum { N_IN = 6, N_HIDDEN = 21, N_OUT = 3, HIDDEN_PADDED = 24, OUT_PADDED = 4 };
enum { MAX_FILE_BYTES = 4 << 20 }; /* the published files have 18,736 */

enum { N_LAYERS = 3 };
typedef struct nbrdf {
    struct {
        double w[N_HIDDEN * HIDDEN_PADDED], b[HIDDEN_PADDED]; /* (in, padded out), (padded out) */
    } layer[N_LAYERS];
    float weights[NQM_NBRDF_WEIGHTS]; /* the same values in the order of files */
} nbrdf;

/* y (n_out) = b + x (n_in) w (n_in, n_out); inlined, so that n_out is a constant. */
static inline void dense(size_t n_in, size_t n_out, const double *x, const double *w, const double *b, double *y) {
    memcpy(y, b, n_out * sizeof *y);
    for (size_t k = 0; k < n_in; ++k)
        for (size_t j = 0; j < n_out; ++j)
            y[j] += x[k] * w[k * n_out + j];
}

static inline void relu(double *x) {
    for (size_t j = 0; j < HIDDEN_PADDED; ++j)
        x[j] = x[j] > 0 ? x[j] : 0;
}

static void nbrdf_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    const nbrdf *net = self;
    for (size_t i = 0; i < n; ++i) {
        double x[N_IN] = {sin(hd[3 * i]), 0, cos(hd[3 * i])};
        double first[HIDDEN_PADDED], second[HIDDEN_PADDED], out[OUT_PADDED];
        nqm_spherical(hd[3 * i + 1], hd[3 * i + 2], x + 3);
        dense(N_IN, HIDDEN_PADDED, x, net->layer[0].w, net->layer[0].b, first);
        relu(first);
        dense(N_HIDDEN, HIDDEN_PADDED, first, net->layer[1].w, net->layer[1].b, second);
        relu(second);
        dense(N_HIDDEN, OUT_PADDED, second, net->layer[2].w, net->layer[2].b, out);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = expm1(out[c]);
    }
}

static const nqm_brdf_class nbrdf_class = {
    .format = "nbrdf", .reciprocal = 1, .eval_half_diff = nbrdf_eval_half_diff, .free = nqm_free};

/** A layer, and its datasets in a Keras file. */
typedef struct layer {
    const char *kernel, *bias;
    size_t n_in, n_out, n_padded;
} layer;
static const layer layers[N_LAYERS] = {
    {"dense_1/dense_1/kernel:0", "dense_1/dense_1/bias:0", N_IN, N_HIDDEN, HIDDEN_PADDED},
    {"dense_2/dense_2/kernel:0", "dense_2/dense_2/bias:0", N_HIDDEN, N_HIDDEN, HIDDEN_PADDED},
    {"dense_3/dense_3/kernel:0", "dense_3/dense_3/bias:0", N_HIDDEN, N_OUT, OUT_PADDED}};

nqm_status nqm_nbrdf_create(const float *weights, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    nbrdf *net = nqm_alloc(1, sizeof *net);
    if (!net)
        return nqm_fail_nomem(err, sizeof *net);
    memcpy(net->weights, weights, sizeof net->weights);
    for (const layer *l = layers; l < layers + N_LAYERS; ++l) {
        double *w = net->layer[l - layers].w, *b = net->layer[l - layers].b;
        for (size_t k = 0; k < l->n_in; ++k)
            for (size_t j = 0; j < l->n_out; ++j)
                w[k * l->n_padded + j] = (double)*weights++;
        for (size_t j = 0; j < l->n_out; ++j)
            b[j] = (double)*weights++;
    }
    const nqm_brdf_info info = {
        .name = name, .source_doi = "10.1111/cgf.14335", .layout = "network 6-21-21-3", .n_values = NQM_NBRDF_WEIGHTS};
    return nqm_brdf_wrap(&nbrdf_class, net, &info, brdf_ret, err);
}

const float *nqm_nbrdf_weights(const nqm_brdf *brdf) {
    return ((const nbrdf *)brdf->self)->weights;
}

/* ---- Keras files ------------------------------------------------------------------------------------------------- */

static nqm_status read_keras(const unsigned char *data, size_t n_bytes, const char *name, float *weights,
                             nqm_error *err) {
    if (n_bytes > MAX_FILE_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, MAX_FILE_BYTES, "%s: %zu bytes are too many for an NBRDF (limit: %d)", name,
                        n_bytes, MAX_FILE_BYTES);
    nqm_hdf5 file;
    nqm_status status = nqm_hdf5_open(data, n_bytes, name, &file, err);
    for (const layer *l = layers; l < layers + N_LAYERS && status == NQM_OK; ++l) {
        const size_t dims[2] = {l->n_in, l->n_out};
        status = nqm_hdf5_read_f32(&file, l->kernel, 2, dims, weights, err);
        weights += l->n_in * l->n_out;
        if (status == NQM_OK)
            status = nqm_hdf5_read_f32(&file, l->bias, 1, dims + 1, weights, err);
        weights += l->n_out;
    }
    return status;
}

static nqm_status open_bytes(const unsigned char *data, size_t n_bytes, const char *name, nqm_brdf **brdf_ret,
                             nqm_error *err) {
    float weights[NQM_NBRDF_WEIGHTS];
    nqm_status status = read_keras(data, n_bytes, name, weights, err);
    if (status == NQM_OK)
        status = nqm_nbrdf_create(weights, name, brdf_ret, err);
    if (status == NQM_OK)
        (*brdf_ret)->info.n_bytes = n_bytes;
    return status;
}

static bool begins_hdf5(const nqm_map *map) {
    static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    size_t n = map->n_bytes < sizeof signature ? map->n_bytes : sizeof signature;
    return n >= 4 && memcmp(map->data, signature, n) == 0;
}

static nqm_status open_hdf5(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_map_expect(map, true);
    return open_bytes(map->data, map->n_bytes, argument->name, brdf_ret, err);
}

const nqm_brdf_format nqm_nbrdf_format = {.files = "NBRDF .h5", .probe = begins_hdf5, .open = open_hdf5};

/* ---- arrays of NumPy --------------------------------------------------------------------------------------------- */

static const char *const parts[2 * N_LAYERS] = {"fc1.npy", "b1.npy", "fc2.npy", "b2.npy", "fc3.npy", "b3.npy"};

/* The part of a path before the name of a part; SIZE_MAX: it has none. */
static size_t prefix_of(const char *path) {
    const char *slash = strrchr(path, '/'), *file = slash ? slash + 1 : path;
    const size_t n = strlen(path);
    for (size_t k = 0; k < 2 * N_LAYERS; ++k) {
        const size_t n_part = strlen(parts[k]);
        if (strlen(file) >= n_part && strcmp(path + n - n_part, parts[k]) == 0)
            return n - n_part;
    }
    return SIZE_MAX;
}

bool nqm_nbrdf_is_part(const char *path) {
    return prefix_of(path) != SIZE_MAX;
}

/* n_in: 0 of a bias. */
static nqm_status read_part(const char *path, size_t n_in, size_t n_out, float *to, nqm_error *err) {
    nqm_map map = {0};
    nqm_tensor t = {0};
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_npy_parse(&map, &t, err);
    const size_t n_rows = nqm_larger(n_in, 1);
    if (status == NQM_OK &&
        (t.n_dims != (n_in ? 2 : 1) || t.dims[t.n_dims - 1] != n_out || (n_in && t.dims[0] != n_in)))
        status = nqm_fail(err, NQM_ERR_FORMAT, 10,
                          "%s: weights of an NBRDF (header at byte 10) of another shape than %zu x %zu", path, n_rows,
                          n_out);
    for (size_t i = 0; status == NQM_OK && i < n_rows * n_out; ++i) {
        const size_t at = t.is_column_major ? i % n_out * n_rows + i / n_out : i, size = nqm_dtype_size(t.dtype);
        const unsigned char *value = (const unsigned char *)t.data + at * size;
        to[i] = t.dtype == NQM_F32 ? nqm_load_f32(value) : (float)nqm_load_f64(value);
        if (!isfinite(to[i]))
            status = nqm_fail(err, NQM_ERR_FORMAT, t.byte_offset + (int64_t)(at * size),
                              "%s: the value at byte %lld is not finite", path,
                              (long long)t.byte_offset + (long long)(at * size));
    }
    nqm_map_close(&map);
    return status;
}

nqm_status nqm_nbrdf_open_parts(const char *path, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    float weights[NQM_NBRDF_WEIGHTS], *to = weights;
    nqm_status status = NQM_OK;
    for (size_t k = 0; k < 2 * N_LAYERS && status == NQM_OK; ++k) {
        const size_t n_in = k % 2 ? 0 : layers[k / 2].n_in, n_out = layers[k / 2].n_out;
        char *part = nqm_strdupf("%.*s%s", (int)prefix_of(path), path, parts[k]);
        status = part ? read_part(part, n_in, n_out, to, err) : nqm_fail_nomem(err, strlen(path));
        to += nqm_larger(n_in, 1) * n_out;
        nqm_free(part);
    }
    return status == NQM_OK ? nqm_nbrdf_create(weights, name, brdf_ret, err) : status;
}

/* ---- archives ---------------------------------------------------------------------------------------------------- */

static bool begins_zip(const nqm_map *map) {
    static const unsigned char member[4] = {'P', 'K', 3, 4}, end[4] = {'P', 'K', 5, 6};
    return map->n_bytes >= 4 && (memcmp(map->data, member, 4) == 0 || memcmp(map->data, end, 4) == 0);
}

/* Fail for an archive without the name of a material; the message lists some of its materials, or says what it is. */
static nqm_status request_material(const nqm_map *map, nqm_error *err) {
    static const struct {
        const char *suffix, *kind;
    } others[] = {{".pkl", "a PyTorch file; save the weights of an NBRDF as .npy files"},
                  {".npy", "an .npz archive of NumPy; save one table with numpy.save() as .npy"},
                  {"", "it contains no NBRDF .h5 file"}};
    char examples[256];
    nqm_status status = nqm_zip_examples(map, ".h5", examples, sizeof examples, err);
    if (status == NQM_OK && *examples)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: name one material of this archive, '%s:MATERIAL': %s", map->path,
                        map->path, examples);
    *examples = '\0';
    for (size_t i = 0; status == NQM_OK; ++i) {
        status = nqm_zip_examples(map, others[i].suffix, examples, sizeof examples, err);
        if (status == NQM_OK && (*examples || !*others[i].suffix))
            return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: this zip (byte 0) is no archive of NBRDFs: %s", map->path,
                            others[i].kind);
    }
    return status;
}

static nqm_status open_zip(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    const char *material = argument->member;
    nqm_map_expect(map, false);
    if (!material)
        return request_material(map, err);
    size_t n = strlen(material);
    const char *ending = n > 3 && strcmp(material + n - 3, ".h5") == 0 ? "" : ".h5";
    char member[256];
    if ((size_t)snprintf(member, sizeof member, "%s%s", material, ending) >= sizeof member)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the name of the material is too long", argument->name);
    unsigned char *data;
    size_t n_bytes;
    nqm_status status = nqm_zip_read(map, member, MAX_FILE_BYTES, &data, &n_bytes, err);
    if (status == NQM_OK)
        status = open_bytes(data, n_bytes, argument->name, brdf_ret, err);
    nqm_free(data);
    return status;
}

const nqm_brdf_format nqm_nbrdf_zip_format = {
    .files = "zip", .takes_members = true, .probe = begins_zip, .open = open_zip};
