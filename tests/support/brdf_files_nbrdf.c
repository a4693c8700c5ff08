/* SPDX-License-Identifier: MIT
 *
 * Writes NBRDF networks with libhdf5 in the layout of Keras, valid or with one fault, and zip archives.
 */
#include "support/brdf_files.h"

#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zip.h>

static void need(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "%s failed\n", what);
    abort();
}

typedef struct shape {
    const char *name;
    int n_dims;
    hsize_t dims[2];
} shape;

static const shape shapes[6] = {{"kernel:0", 2, {6, 21}}, {"bias:0", 1, {21, 0}},   {"kernel:0", 2, {21, 21}},
                                {"bias:0", 1, {21, 0}},   {"kernel:0", 2, {21, 3}}, {"bias:0", 1, {3, 0}}};
enum { BROKEN = 4 }; /* index of the dataset that `kind` changes */

static hid_t creation_list(nbrdf_kind kind, hsize_t n_bytes) {
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk[2] = {7, 3};
    need(H5Pset_obj_track_times(list, false) >= 0, "times"); /* no timestamps: equal bytes in every run */
    if (kind == NBRDF_CHUNKED)
        need(H5Pset_chunk(list, 2, chunk) >= 0 && H5Pset_deflate(list, 1) >= 0, "chunks");
    if (kind == NBRDF_EXTERNAL_STORAGE)
        need(H5Pset_external(list, "/etc/passwd", 0, n_bytes) >= 0, "external storage");
    return list;
}

/* Values: noise of row i in [-1, 1) over the square root of the layer's inputs. */
static void write_dataset(hid_t group, size_t i, nbrdf_kind kind) {
    shape s = shapes[i];
    size_t n = (size_t)(s.dims[0] * (s.n_dims == 2 ? s.dims[1] : 1));
    float values[441];
    float scale = (float)(1 / sqrt((double)shapes[i & ~(size_t)1].dims[0]));
    for (size_t k = 0; k < n; ++k)
        values[k] = (float)(2 * noise((uint32_t)k, (uint32_t)i + 1) - 1) * scale;
    if (kind == NBRDF_NAN)
        values[5] = NAN;
    if (kind == NBRDF_SHAPE) {
        s.dims[0] = shapes[i].dims[1];
        s.dims[1] = shapes[i].dims[0];
    }
    hid_t space = H5Screate_simple(s.n_dims, s.dims, NULL), list = creation_list(kind, 4 * n);
    hid_t type = kind == NBRDF_DOUBLE ? H5T_IEEE_F64LE : H5T_IEEE_F32LE;
    hid_t data = H5Dcreate2(group, s.name, type, space, H5P_DEFAULT, list, H5P_DEFAULT);
    need(data >= 0, "dataset");
    if (kind != NBRDF_EXTERNAL_STORAGE)
        need(H5Dwrite(data, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0, "write");
    H5Dclose(data);
    H5Pclose(list);
    H5Sclose(space);
}

static void write_layer(hid_t file, size_t layer, nbrdf_kind kind) {
    char name[16];
    snprintf(name, sizeof name, "dense_%zu", layer + 1);
    hid_t outer = H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    hid_t inner = H5Gcreate2(outer, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    for (size_t i = 2 * layer; i < 2 * layer + 2; ++i) {
        nbrdf_kind this_kind = i == BROKEN ? kind : NBRDF_VALID;
        if (this_kind == NBRDF_EXTERNAL_LINK)
            need(H5Lcreate_external("/tmp/other.h5", "/x", inner, shapes[i].name, H5P_DEFAULT, H5P_DEFAULT) >= 0,
                 "link");
        else if (this_kind != NBRDF_MISSING)
            write_dataset(inner, i, this_kind);
    }
    H5Gclose(inner);
    H5Gclose(outer);
}

blob make_nbrdf(nbrdf_kind kind) {
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    need(H5Pset_fapl_core(access, 1024, 0) >= 0, "core driver");
    hid_t file = H5Fcreate("made in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    need(file >= 0, "file");
    for (size_t layer = 0; layer < 3; ++layer)
        write_layer(file, layer, kind);
    need(H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0, "flush");
    ssize_t n = H5Fget_file_image(file, NULL, 0);
    need(n > 0, "image");
    blob b = {.data = malloc((size_t)n), .n_bytes = (size_t)n};
    need(b.data && H5Fget_file_image(file, b.data, b.n_bytes) == n, "image");
    H5Fclose(file);
    H5Pclose(access);
    return b;
}

blob make_zip(const char *member, const blob *content) {
    const char *path = scratch_path("made.zip");
    remove(path);
    int code;
    zip_t *archive = zip_open(path, ZIP_CREATE | ZIP_TRUNCATE, &code);
    need(archive != NULL, "zip");
    zip_source_t *source = zip_source_buffer(archive, content->data, content->n_bytes, 0);
    need(source && zip_file_add(archive, member, source, 0) >= 0, "zip");
    need(zip_file_set_mtime(archive, 0, 1000000000, 0) == 0 && zip_close(archive) == 0, "zip");
    return blob_load(path);
}
