/* SPDX-License-Identifier: MIT
 *
 * The tensor container of the RGL material database (Dupuy and Jakob 2018, DOI 10.1145/3272127.3275059): named arrays
 * after a table of contents. Every name, shape and offset is checked against the bytes present; the values are not.
 *
 * File, little-endian: "tensor_file\0"; u8 major, minor version; u32 fields; per field u16 length and name, u16
 * dimensions, u8 type, u64 offset of the data from the start of the file, u64 per dimension.
 */
#include "io/io.h"

#include <string.h>

static const unsigned char magic[12] = "tensor_file"; /* includes the NUL */

enum { MAX_FIELDS = 256, MAX_NAME = 63 }; /* the database's files have 11 fields with names of up to 11 bytes */

typedef struct field {
    nqm_tensor tensor;
    char name[MAX_NAME + 1];
    bool readable; /* nqm_dtype has its type */
} field;

struct nqm_tensor_file {
    size_t n_fields;
    field fields[]; /* (n_fields) */
};

/** A read position in the file. */
typedef struct cursor {
    const unsigned char *data;
    size_t n_bytes, at;
    const char *file;
} cursor;

/* Skip n bytes and return a pointer to the first of them; NULL when fewer are left. */
static const unsigned char *take(cursor *c, size_t n) {
    if (n > c->n_bytes - c->at)
        return NULL;
    c->at += n;
    return c->data + c->at - n;
}

static nqm_status fail_short(const cursor *c, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)c->n_bytes, "%s: ends at byte %zu, inside its table of contents",
                    c->file, c->n_bytes);
}

/* Element types, indexed by the type codes of the container: the nqm_dtype, or one of the same size. */
static const struct {
    nqm_dtype dtype;
    bool readable;
} element_types[] = {{NQM_U8, false},  {NQM_U8, true},   {NQM_U8, false}, {NQM_U16, true},
                     {NQM_U16, false}, {NQM_U32, true},  {NQM_I32, true}, {NQM_I64, false},
                     {NQM_I64, true},  {NQM_F16, false}, {NQM_F32, true}, {NQM_F64, true}};
enum { N_TYPES = sizeof element_types / sizeof *element_types };

/* Check that a field's data are inside the file, and set its size and pointer. */
static nqm_status check_extent(const cursor *c, nqm_tensor *t, nqm_error *err) {
    const uint64_t offset = (uint64_t)t->byte_offset;
    if (!nqm_tensor_measure(t))
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)c->at, "%s: the shape of '%s' before byte %zu is impossible",
                        c->file, t->name, c->at);
    if (offset > c->n_bytes || t->n_bytes > c->n_bytes - offset)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)c->n_bytes,
                        "%s: ends at byte %zu, but '%s' has %zu bytes from byte %llu on", c->file, c->n_bytes, t->name,
                        t->n_bytes, (unsigned long long)offset);
    t->data = c->data + offset;
    return NQM_OK;
}

/* Read one entry of the table of contents. */
static nqm_status read_field(cursor *c, field *f, nqm_error *err) {
    nqm_tensor *t = &f->tensor;
    const unsigned char *p = take(c, 2);
    size_t n_name = p ? nqm_load_u16(p) : 0;
    const unsigned char *text = p ? take(c, n_name) : NULL;
    const unsigned char *head = text ? take(c, 2 + 1 + 8) : NULL;
    if (!head)
        return fail_short(c, err);
    size_t head_at = c->at - 11, type = head[2];
    t->n_dims = nqm_load_u16(head);
    t->byte_offset = (int64_t)nqm_load_u64(head + 3);
    if (n_name > MAX_NAME || type == 0 || type >= N_TYPES || t->n_dims > NQM_MAX_DIMS)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)head_at,
                        "%s: a field with %zu bytes of name, type %zu and %zu dimensions at byte %zu", c->file, n_name,
                        type, t->n_dims, head_at);
    memcpy(f->name, text, n_name);
    t->name = f->name;
    const unsigned char *dims = take(c, 8 * t->n_dims);
    if (!dims)
        return fail_short(c, err);
    for (size_t i = 0; i < t->n_dims; ++i)
        t->dims[i] = (size_t)nqm_load_u64(dims + 8 * i);
    f->readable = element_types[type].readable;
    t->dtype = element_types[type].dtype;
    return check_extent(c, t, err);
}

nqm_status nqm_tensor_file_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                 nqm_tensor_file **file_ret, nqm_error *err) {
    *file_ret = NULL;
    cursor c = {.data = data, .n_bytes = n_bytes, .file = name};
    const unsigned char *head = take(&c, sizeof magic + 2 + 4);
    if (!head || memcmp(head, magic, sizeof magic) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: byte 0 begins no complete header of a tensor file", name);
    if (head[12] != 1)
        return nqm_fail(err, NQM_ERR_FORMAT, 12, "%s: tensor file version %d at byte 12 is unknown", name, head[12]);
    size_t n_fields = nqm_load_u32(head + 14);
    if (n_fields > MAX_FIELDS)
        return nqm_fail(err, NQM_ERR_FORMAT, 14, "%s: claims %zu fields (byte 14), at most %d are read", name, n_fields,
                        MAX_FIELDS);
    const size_t n_file = sizeof(nqm_tensor_file) + n_fields * sizeof(field);
    nqm_tensor_file *file = nqm_alloc(n_file, 1);
    if (!file)
        return nqm_fail_nomem(err, n_file);
    nqm_status status = NQM_OK;
    file->n_fields = n_fields;
    for (size_t i = 0; i < n_fields && status == NQM_OK; ++i)
        status = read_field(&c, file->fields + i, err);
    if (status == NQM_OK)
        *file_ret = file;
    else
        nqm_free(file);
    return status;
}

const nqm_tensor *nqm_tensor_file_find(const nqm_tensor_file *file, const char *tensor_name) {
    for (size_t i = 0; i < file->n_fields; ++i)
        if (file->fields[i].readable && strcmp(file->fields[i].name, tensor_name) == 0)
            return &file->fields[i].tensor;
    return NULL;
}
