/* SPDX-License-Identifier: MIT
 *
 * Writes RGL materials in the tensor container (layout: src/io/tensor_file.c), valid or with one tensor changed.
 */
#include "support/brdf_files.h"

#include "base/base.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FLOAT32 = 10, UINT8 = 1, UINT16 = 3, MAX_FILE = 1 << 20 };

typedef struct tensor {
    const char *name;
    unsigned type;
    size_t n_dims, dims[7];
    double scale, shift; /* value = scale * noise + shift */
    const float *values; /* used instead of noise unless NULL */
} tensor;

static const float theta_i[4] = {0, 0.6F, 1.1F, 1.5707964F};
static const float one_zero[1] = {0};
static const float wavelengths[9] = {360, 420, 450, 500, 540, 580, 620.5F, 700, 1000};

static const tensor valid[] = {
    {"description", UINT8, 1, {5}, 0, 0, NULL},  {"phi_i", FLOAT32, 1, {1}, 0, 0, one_zero},
    {"theta_i", FLOAT32, 1, {4}, 0, 0, theta_i}, {"sigma", FLOAT32, 2, {2, 7}, 1, 0.125, NULL},
    {"ndf", FLOAT32, 2, {2, 9}, 2, 0.25, NULL},  {"vndf", FLOAT32, 4, {1, 4, 6, 8}, 1, 0, NULL},
    {"jacobian", UINT8, 1, {1}, 0, 0, NULL},     {"valid", UINT8, 1, {35}, 0, 0, NULL},
};
static const tensor rgb[] = {{"rgb", FLOAT32, 5, {1, 4, 3, 5, 7}, 4, -1, NULL}};
static const tensor spectral[] = {{"spectra", FLOAT32, 5, {1, 4, 9, 5, 7}, 4, -1, NULL},
                                  {"wavelengths", FLOAT32, 1, {9}, 0, 0, wavelengths}};
enum { N_VALID = sizeof valid / sizeof *valid, MAX_TENSORS = N_VALID + 3 };

/* phi_i over a turn, a half and a quarter, as in tests/vectors/brdf.py. */
static const float phi_1[5] = {-3.1415927F, -1.5F, 0.25F, 1.75F, 3.1415927F}, phi_2[4] = {-3.1415927F, -2, -1.25F, 0},
                   phi_4[3] = {-3.1415927F, -2.5F, -1.5707964F};

static const float phi_d[6] = {-3.1415927F, -2, -0.5F, 1, 2.25F, 3.1415927F};
static const float theta_d[4] = {0, 0.25F, 0.75F, 1.5707964F};
static const float theta_h[5] = {0, 0.125F, 0.5F, 1, 1.5707964F};
static const float bands[5] = {450, 500, 550, 600, 650};
static const tensor polarised[] = {{"phi_d", FLOAT32, 2, {1, 6}, 0, 0, phi_d},
                                   {"theta_d", FLOAT32, 2, {1, 4}, 0, 0, theta_d},
                                   {"theta_h", FLOAT32, 2, {1, 5}, 0, 0, theta_h},
                                   {"wvls", UINT16, 1, {5}, 0, 0, bands},
                                   {"M", FLOAT32, 6, {6, 4, 5, 5, 4, 4}, 2, -0.25, NULL}};
enum { N_POLARISED = sizeof polarised / sizeof *polarised };

static size_t count(const tensor *t) {
    size_t n = 1;
    for (size_t i = 0; i < t->n_dims && t->dims[i] < MAX_FILE; ++i)
        n *= t->dims[i];
    return n;
}

static bool is_changed(const tensor *t, const rgl_change *change) {
    return change && change->name && strcmp(change->name, t->name) == 0;
}

/* Append a list of tensors, without those that the change replaces; returns the number in `out`. */
static size_t append(size_t n, size_t n_list, const tensor *list, const rgl_change *change, tensor *out) {
    for (size_t i = 0; i < n_list; ++i)
        if (!is_changed(list + i, change))
            out[n++] = list[i];
    return n;
}

static size_t append_change(size_t n, const rgl_change *change, tensor *out) {
    if (change && change->name && !change->omit) {
        out[n] = (tensor){.name = change->name, .type = change->type, .n_dims = change->n_dims, .scale = 1, .shift = 1};
        out[n].values = change->values;
        memcpy(out[n++].dims, change->dims, sizeof change->dims);
    }
    return n;
}

/* The two lowest rows of the visible-normal density are zero at the two smallest angles, as occurs in measured
 * files. */
static double value_of(const tensor *t, size_t i) {
    if (t->values)
        return (double)t->values[i];
    if (strcmp(t->name, "M") == 0 && i / 80 % 7 == 3) /* some nodes have no value */
        return NAN;
    bool empty = strcmp(t->name, "vndf") == 0 && i / 48 % 4 < 2 && i / 8 % 6 < 2;
    return empty ? 0 : t->scale * noise((uint32_t)i, (uint32_t)t->name[0]) + t->shift;
}

static size_t put_data(const tensor *t, unsigned char *at) {
    const size_t n = count(t), size = t->type == FLOAT32 ? 4 : t->type == UINT16 ? 2 : 1;
    for (size_t i = 0; i < n; ++i) {
        if (t->type == FLOAT32)
            nqm_store_f32(at + 4 * i, (float)value_of(t, i));
        else if (t->type == UINT16)
            nqm_store_u16(at + 2 * i, (uint16_t)value_of(t, i));
        else
            at[i] = 1;
    }
    return size * n;
}

/* Write the entry of the table of contents; returns its size in bytes. */
static size_t put_entry(const tensor *t, size_t offset, unsigned char *at) {
    size_t n_name = strlen(t->name);
    unsigned char *p = at;
    *p++ = (unsigned char)n_name;
    *p++ = 0;
    memcpy(p, t->name, n_name);
    p += n_name;
    *p++ = (unsigned char)t->n_dims;
    *p++ = 0;
    *p++ = (unsigned char)t->type;
    nqm_store_u64(p, offset);
    p += 8;
    for (size_t i = 0; i < t->n_dims; ++i, p += 8)
        nqm_store_u64(p, t->dims[i]);
    return (size_t)(p - at);
}

static blob make_file(size_t n, const tensor *tensors, size_t shift) {
    static const char magic[12] = "tensor_file";
    blob b = {.data = calloc(MAX_FILE, 1)};
    if (!b.data)
        abort();
    memcpy(b.data, magic, sizeof magic);
    b.data[12] = 1;
    nqm_store_u32(b.data + 14, (uint32_t)n);
    size_t entry_at = 18, data_at = 18;
    for (size_t i = 0; i < n; ++i)
        data_at += put_entry(tensors + i, 0, b.data + data_at);
    for (size_t i = 0; i < n; ++i) {
        data_at = (data_at + 7) / 8 * 8 + shift;
        entry_at += put_entry(tensors + i, data_at, b.data + entry_at);
        data_at += put_data(tensors + i, b.data + data_at);
    }
    b.n_bytes = data_at;
    return b;
}

blob make_rgl(const rgl_change *change) {
    tensor tensors[MAX_TENSORS];
    size_t n = append(0, N_VALID, valid, change, tensors);
    n = append_change(append(n, 1, rgb, change, tensors), change, tensors);
    return make_file(n, tensors, 0);
}

blob make_spectral_rgl(const rgl_change *change) {
    tensor tensors[MAX_TENSORS];
    size_t n = append(0, N_VALID, valid, change, tensors);
    n = append_change(append(n, 2, spectral, change, tensors), change, tensors);
    return make_file(n, tensors, 0);
}

blob make_anisotropic_rgl(size_t reduction, bool is_spectral, const rgl_change *change) {
    tensor tensors[MAX_TENSORS];
    size_t n = append(0, N_VALID, valid, NULL, tensors);
    n = is_spectral ? append(n, 2, spectral, NULL, tensors) : append(n, 1, rgb, NULL, tensors);
    const size_t n_phi = reduction == 1 ? 5 : reduction == 2 ? 4 : 3;
    for (size_t i = 0; i < n; ++i)
        if (strcmp(tensors[i].name, "phi_i") == 0) {
            tensors[i].dims[0] = n_phi;
            tensors[i].values = reduction == 1 ? phi_1 : reduction == 2 ? phi_2 : phi_4;
        } else if (tensors[i].n_dims > 3) {
            tensors[i].dims[0] = n_phi;
        }
    tensor changed[MAX_TENSORS];
    n = append_change(append(0, n, tensors, change, changed), change, changed);
    return make_file(n, changed, 0);
}

blob make_pbsdf(const rgl_change *change) {
    tensor tensors[N_POLARISED + 1];
    return make_file(append_change(append(0, N_POLARISED, polarised, change, tensors), change, tensors), tensors, 0);
}

blob make_shifted_rgl(size_t shift) {
    tensor tensors[MAX_TENSORS];
    return make_file(append(append(0, N_VALID, valid, NULL, tensors), 1, rgb, NULL, tensors), tensors, shift);
}
