/* SPDX-License-Identifier: MIT
 *
 * Float datasets of an HDF5 file in memory, through libhdf5. The superblock is checked here first, because libhdf5
 * trusts sizes and addresses in damaged files more than it should; links to other files, external storage and packed
 * (chunked) datasets are refused. libhdf5 keeps global state: one lock guards it, and its own error printing is off in
 * each call.
 */
#include "io/io.h"

#include <hdf5.h>
#include <math.h>
#include <pthread.h>
#include <string.h>

static pthread_mutex_t hdf5_lock = PTHREAD_MUTEX_INITIALIZER;

struct nqm_hdf5 {
    hid_t file;
    const char *name;
    size_t n_bytes;
};

/* libhdf5's error printing is switched off between silence_begin and silence_end, and put back as the host had it. */
typedef struct silence {
    H5E_auto2_t print;
    void *user;
} silence;

static silence silence_begin(void) {
    silence host = {0};
    pthread_mutex_lock(&hdf5_lock);
    H5Eget_auto2(H5E_DEFAULT, &host.print, &host.user);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    return host;
}

static void silence_end(silence host) {
    H5Eset_auto2(H5E_DEFAULT, host.print, host.user);
    pthread_mutex_unlock(&hdf5_lock);
}

/* Offsets of the superblock's fields, HDF5 File Format Specification III.A. */
static nqm_status check_superblock(const unsigned char *data, size_t n_bytes, const char *name, nqm_error *err) {
    static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    if (n_bytes < 48 || memcmp(data, signature, sizeof signature) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: byte 0 begins no complete HDF5 superblock", name);
    unsigned version = data[8];
    if (version > 3)
        return nqm_fail(err, NQM_ERR_FORMAT, 8, "%s: HDF5 superblock version %u at byte 8 is unknown", name, version);
    size_t sizes_at = version < 2 ? 13 : 9;
    size_t base_at = version == 0 ? 24 : version == 1 ? 28 : 12;
    size_t end_at = base_at + 16;
    if (end_at + 8 > n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)n_bytes, "%s: the superblock ends at byte %zu", name, n_bytes);
    if (data[sizes_at] != 8 || data[sizes_at + 1] != 8)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)sizes_at,
                        "%s: addresses and lengths must have 8 bytes (byte %zu)", name, sizes_at);
    uint64_t base = nqm_load_u64(data + base_at), end = nqm_load_u64(data + end_at);
    if (base != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)base_at, "%s: the base address at byte %zu is not 0", name,
                        base_at);
    if (end > n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)n_bytes,
                        "%s: ends at byte %zu, but its superblock claims %llu bytes (byte %zu)", name, n_bytes,
                        (unsigned long long)end, end_at);
    return NQM_OK;
}

/* A file that exists in memory only: the core driver without backing store, begun with a copy of the bytes. */
static hid_t open_image(const unsigned char *data, size_t n_bytes) {
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (access < 0)
        return -1;
    hid_t file = -1;
    if (H5Pset_fapl_core(access, 65536, 0) >= 0 && H5Pset_file_image(access, (void *)(uintptr_t)data, n_bytes) >= 0)
        file = H5Fopen("image", H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return file;
}

nqm_status nqm_hdf5_open(const unsigned char *data, size_t n_bytes, const char *name, nqm_hdf5 **file_ret,
                         nqm_error *err) {
    *file_ret = NULL;
    nqm_status status = check_superblock(data, n_bytes, name, err);
    if (status != NQM_OK)
        return status;
    nqm_hdf5 *h5 = nqm_alloc(1, sizeof *h5);
    if (!h5)
        return nqm_fail_nomem(err, sizeof *h5);
    silence host = silence_begin();
    *h5 = (nqm_hdf5){.file = open_image(data, n_bytes), .name = name, .n_bytes = n_bytes};
    silence_end(host);
    if (h5->file < 0) {
        nqm_free(h5);
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: libhdf5 finds no valid file behind the superblock (byte 0)", name);
    }
    *file_ret = h5;
    return NQM_OK;
}

void nqm_hdf5_close(nqm_hdf5 *file) {
    if (!file)
        return;
    silence host = silence_begin();
    H5Fclose(file->file);
    silence_end(host);
    nqm_free(file);
}

/** An open dataset and what describes it; negative where not open. */
typedef struct dataset {
    hid_t data, space, type, creation;
} dataset;

static void dataset_close(const dataset *d) {
    if (d->creation >= 0)
        H5Pclose(d->creation);
    if (d->type >= 0)
        H5Tclose(d->type);
    if (d->space >= 0)
        H5Sclose(d->space);
    if (d->data >= 0)
        H5Dclose(d->data);
}

static herr_t refuse_external_link(const char *parent_file, const char *parent_group, const char *child_file,
                                   const char *child_object, unsigned *flags, hid_t access, void *user) {
    (void)parent_file, (void)parent_group, (void)child_file, (void)child_object, (void)flags, (void)access, (void)user;
    return -1;
}

static bool dataset_open(hid_t file, const char *path, dataset *d) {
    *d = (dataset){-1, -1, -1, -1};
    hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
    if (access >= 0 && H5Pset_elink_cb(access, refuse_external_link, NULL) >= 0)
        d->data = H5Dopen2(file, path, access);
    if (access >= 0)
        H5Pclose(access);
    if (d->data < 0)
        return false;
    d->space = H5Dget_space(d->data);
    d->type = H5Dget_type(d->data);
    d->creation = H5Dget_create_plist(d->data);
    return d->space >= 0 && d->type >= 0 && d->creation >= 0;
}

static bool has_shape(hid_t space, size_t n_dims, const size_t *dims) {
    hsize_t extent[NQM_MAX_DIMS];
    if (n_dims > NQM_MAX_DIMS || H5Sget_simple_extent_ndims(space) != (int)n_dims)
        return false;
    if (H5Sget_simple_extent_dims(space, extent, NULL) < 0)
        return false;
    for (size_t i = 0; i < n_dims; ++i)
        if (extent[i] != dims[i])
            return false;
    return true;
}

/* Check an open dataset and fill out; returns what is wrong, or NULL. *offset: where its numbers lie, HADDR_UNDEF for
 * nowhere. */
static const char *read_dataset(const nqm_hdf5 *file, const dataset *d, size_t n_dims, const size_t *dims, float *out,
                                haddr_t *offset) {
    size_t n = 1;
    for (size_t i = 0; i < n_dims; ++i)
        n *= dims[i];
    *offset = H5Dget_offset(d->data);
    if (!has_shape(d->space, n_dims, dims))
        return "has another shape";
    if (H5Tequal(d->type, H5T_IEEE_F32LE) <= 0)
        return "is not little-endian float32";
    if (H5Pget_layout(d->creation) != H5D_CONTIGUOUS || H5Pget_external_count(d->creation) != 0)
        return "is packed or lies in another file";
    if (*offset == HADDR_UNDEF || *offset > file->n_bytes || n > (file->n_bytes - *offset) / 4)
        return "lies outside the file";
    if (H5Dread(d->data, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, out) < 0)
        return "cannot be read";
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(out[i])) {
            *offset += 4 * i;
            return "is not finite";
        }
    }
    return NULL;
}

nqm_status nqm_hdf5_read_f32(const nqm_hdf5 *file, const char *path, size_t n_dims, const size_t *dims, float *out,
                             nqm_error *err) {
    dataset d;
    haddr_t offset = HADDR_UNDEF;
    const char *fault = "is missing or unreadable";
    silence host = silence_begin();
    if (dataset_open(file->file, path, &d))
        fault = read_dataset(file, &d, n_dims, dims, out, &offset);
    dataset_close(&d);
    silence_end(host);
    if (!fault)
        return NQM_OK;
    if (offset == HADDR_UNDEF)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: dataset %s %s", file->name, path, fault);
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)offset, "%s: dataset %s at byte %llu %s", file->name, path,
                    (unsigned long long)offset, fault);
}
