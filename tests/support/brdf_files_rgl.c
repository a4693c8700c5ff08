/* SPDX-License-Identifier: MIT
 *
 * Writes RGL materials in the tensor container (layout: src/io/tensor_file.c), valid or with one tensor changed.
 */
#include "support/brdf_files.h"

#include "base/base.h"
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
    {"description", UINT8, 1, {5}, 0, 0, NULL},
    {"phi_i", FLOAT32, 1, {1}, 0, 0, one_zero},
    {"theta_i", FLOAT32, 1, {4}, 0, 0, theta_i},
    {"sigma", FLOAT32, 2, {2, 7}, 1, 0.125, NULL},
    {"ndf", FLOAT32, 2, {2, 9}, 2, 0.25, NULL},
    {"vndf", FLOAT32, 4, {1, 4, 6, 8}, 1, 0, NULL},
    {"rgb", FLOAT32, 5, {1, 4, 3, 5, 7}, 4, -1, NULL},
    {"jacobian", UINT8, 1, {1}, 0, 0, NULL},
    {"valid", UINT8, 1, {35}, 0, 0, NULL},
};
/* These replace `rgb`. */
static const tensor spectral[] = {{"spectra", FLOAT32, 5, {1, 4, 9, 5, 7}, 4, -1, NULL},
                                  {"wavelengths", FLOAT32, 1, {9}, 0, 0, wavelengths}};
enum { N_VALID = sizeof valid / sizeof *valid, MAX_TENSORS = N_VALID + 3 };

static size_t count(const tensor *t) {
    size_t n = 1;
    for (size_t i = 0; i < t->n_dims && t->dims[i] < MAX_FILE; ++i)
        n *= t->dims[i];
    return n;
}

static bool is_changed(const tensor *t, const rgl_change *change) {
    return change && change->name && strcmp(change->name, t->name) == 0;
}

/* Apply the change to the list of tensors; returns their number. */
static size_t choose(const rgl_change *change, bool is_spectral, tensor *out) {
    size_t n = 0;
    for (size_t i = 0; i < N_VALID; ++i)
        if (!is_changed(valid + i, change) && !(is_spectral && strcmp(valid[i].name, "rgb") == 0))
            out[n++] = valid[i];
    for (size_t i = 0; is_spectral && i < 2; ++i)
        if (!is_changed(spectral + i, change))
            out[n++] = spectral[i];
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
    bool empty = strcmp(t->name, "vndf") == 0 && i / 48 % 4 < 2 && i / 8 % 6 < 2;
    return empty ? 0 : t->scale * noise((uint32_t)i, (uint32_t)t->name[0]) + t->shift;
}

static size_t put_data(const tensor *t, unsigned char *at) {
    size_t n = count(t);
    for (size_t i = 0; i < n; ++i) {
        if (t->type == FLOAT32)
            nqm_store_f32(at + 4 * i, (float)value_of(t, i));
        else
            at[i] = 1;
    }
    return t->type == FLOAT32 ? 4 * n : n;
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
    return make_file(choose(change, false, tensors), tensors, 0);
}

blob make_spectral_rgl(const rgl_change *change) {
    tensor tensors[MAX_TENSORS];
    return make_file(choose(change, true, tensors), tensors, 0);
}

blob make_shifted_rgl(size_t shift) {
    tensor tensors[MAX_TENSORS];
    return make_file(choose(NULL, false, tensors), tensors, shift);
}
