/* SPDX-License-Identifier: MIT
 *
 * safetensors files (huggingface.co/docs/safetensors): an 8-byte little-endian header length, a JSON header, then the
 * tensors' bytes without gaps. The reader validates type, shape and offsets of every tensor; its tensors point into the
 * given bytes. The writer pads the header so that the data begin at a multiple of 64 bytes, and writes tensors whose
 * size is a multiple of 64 bytes first, so that these stay aligned; it stores a checksum of the file in the header.
 */
#include "io/io.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_AT = 8, MAX_HEADER = 100 * 1000 * 1000, SHA_DIGITS = 64, ALIGNMENT = 64 };

struct nqm_safetensors {
    const unsigned char *data;
    size_t n_bytes, n_header;
    json_t *root;        /* owns names and metadata */
    json_t *meta;        /* borrowed from root, or NULL */
    nqm_tensor *tensors; /* (n_tensors) */
    size_t n_tensors;
};

static const struct {
    const char *name;
    size_t n_bytes;
} dtypes[] = {[NQM_F32] = {"F32", 4}, [NQM_F64] = {"F64", 8}, [NQM_I32] = {"I32", 4}, [NQM_I64] = {"I64", 8},
              [NQM_U8] = {"U8", 1},   [NQM_U32] = {"U32", 4}, [NQM_F16] = {"F16", 2}};

static const char sha_key[] = "\"sha256\":\"";

size_t nqm_dtype_size(nqm_dtype dtype) {
    return dtypes[dtype].n_bytes;
}

static bool tensor_size(nqm_dtype dtype, size_t n_dims, const size_t *dims, size_t *n_bytes) {
    size_t n = dtypes[dtype].n_bytes;
    for (size_t i = 0; i < n_dims; ++i)
        if (!nqm_mul_size(n, dims[i], &n))
            return false;
    *n_bytes = n;
    return true;
}

/* ---- one tensor of the header ------------------------------------------------------------------------------------ */

/* Context of messages about a tensor. */
typedef struct place {
    const char *file;
    const char *tensor;
    nqm_error *err;
} place;

static nqm_status bad_tensor(const place *at, int64_t byte, const char *what) {
    return nqm_fail(at->err, NQM_ERR_FORMAT, byte, "%s: tensor '%.64s': %s (byte %lld)", at->file, at->tensor, what,
                    (long long)byte);
}

static bool size_from_json(const json_t *value, size_t *size) {
    if (!json_is_integer(value) || json_integer_value(value) < 0)
        return false;
    *size = (size_t)json_integer_value(value);
    return true;
}

static nqm_status read_dtype(const place *at, const json_t *entry, nqm_tensor *tensor) {
    const char *name = json_string_value(json_object_get(entry, "dtype"));
    if (!name)
        return bad_tensor(at, HEADER_AT, "has no dtype");
    for (size_t i = 0; i < sizeof dtypes / sizeof *dtypes; ++i)
        if (strcmp(name, dtypes[i].name) == 0) {
            tensor->dtype = (nqm_dtype)i;
            return NQM_OK;
        }
    return bad_tensor(at, HEADER_AT, "has a dtype other than F16, F32, F64, I32, I64, U8, U32");
}

static nqm_status read_shape(const place *at, const json_t *entry, nqm_tensor *tensor) {
    const json_t *shape = json_object_get(entry, "shape");
    if (!json_is_array(shape) || json_array_size(shape) > NQM_MAX_DIMS)
        return bad_tensor(at, HEADER_AT, "shape is not a list of sizes, or has too many");
    tensor->n_dims = json_array_size(shape);
    for (size_t i = 0; i < tensor->n_dims; ++i)
        if (!size_from_json(json_array_get(shape, i), &tensor->dims[i]))
            return bad_tensor(at, HEADER_AT, "shape holds something that is not a size");
    return NQM_OK;
}

static nqm_status read_offsets(const place *at, const json_t *entry, const nqm_safetensors *st, nqm_tensor *tensor) {
    const json_t *offsets = json_object_get(entry, "data_offsets");
    size_t begin, end, expected, data_at = HEADER_AT + st->n_header;
    if (json_array_size(offsets) != 2 || !size_from_json(json_array_get(offsets, 0), &begin) ||
        !size_from_json(json_array_get(offsets, 1), &end))
        return bad_tensor(at, HEADER_AT, "data_offsets are not two sizes");
    if (begin > end || end > st->n_bytes - data_at)
        return bad_tensor(at, (int64_t)st->n_bytes, "lies outside the file");
    if (!tensor_size(tensor->dtype, tensor->n_dims, tensor->dims, &expected) || expected != end - begin)
        return bad_tensor(at, (int64_t)(data_at + begin), "shape does not match its bytes");
    tensor->n_bytes = end - begin;
    tensor->data = st->data + data_at + begin;
    tensor->byte_offset = (int64_t)(data_at + begin);
    return NQM_OK;
}

static nqm_status read_tensor(const place *at, const json_t *entry, const nqm_safetensors *st, nqm_tensor *tensor) {
    tensor->name = at->tensor;
    if (!json_is_object(entry))
        return bad_tensor(at, HEADER_AT, "its entry is not an object");
    nqm_status status = read_dtype(at, entry, tensor);
    if (status == NQM_OK)
        status = read_shape(at, entry, tensor);
    if (status == NQM_OK)
        status = read_offsets(at, entry, st, tensor);
    return status;
}

/* ---- the whole header -------------------------------------------------------------------------------------------- */

static int by_position(const void *a, const void *b) {
    const nqm_tensor *const *left = a, *const *right = b;
    int64_t begin_l = (*left)->byte_offset, begin_r = (*right)->byte_offset;
    if (begin_l != begin_r)
        return begin_l < begin_r ? -1 : 1;
    return ((*left)->n_bytes > (*right)->n_bytes) - ((*left)->n_bytes < (*right)->n_bytes);
}

/* Check that the tensors fill the file from the end of the header to the end of the file, without gaps or overlaps. */
static nqm_status check_contiguous(const nqm_safetensors *st, const char *name, nqm_error *err) {
    const nqm_tensor **order = nqm_alloc(st->n_tensors, sizeof(nqm_tensor *));
    if (!order)
        return nqm_fail_nomem(err, st->n_tensors * sizeof(nqm_tensor *));
    for (size_t i = 0; i < st->n_tensors; ++i)
        order[i] = &st->tensors[i];
    qsort(order, st->n_tensors, sizeof *order, by_position);
    nqm_status status = NQM_OK;
    int64_t next = (int64_t)(HEADER_AT + st->n_header);
    for (size_t i = 0; status == NQM_OK && i < st->n_tensors; ++i) {
        const place at = {name, order[i]->name, err};
        if (order[i]->byte_offset != next)
            status =
                bad_tensor(&at, next, order[i]->byte_offset < next ? "overlaps another" : "leaves a hole before it");
        next = order[i]->byte_offset + (int64_t)order[i]->n_bytes;
    }
    if (status == NQM_OK && next != (int64_t)st->n_bytes)
        status =
            nqm_fail(err, NQM_ERR_FORMAT, next, "%s: bytes after the last tensor (byte %lld)", name, (long long)next);
    nqm_free(order);
    return status;
}

static nqm_status check_meta(const nqm_safetensors *st, const char *name, nqm_error *err) {
    const char *key;
    json_t *value;
    if (!json_is_object(st->meta))
        return nqm_fail(err, NQM_ERR_FORMAT, HEADER_AT, "%s: __metadata__ is not an object (byte 8)", name);
    json_object_foreach(st->meta, key, value) {
        if (!json_is_string(value))
            return nqm_fail(err, NQM_ERR_FORMAT, HEADER_AT, "%s: metadata '%.64s' is not a string (byte 8)", name, key);
    }
    return NQM_OK;
}

static nqm_status read_header(nqm_safetensors *st, const char *name, nqm_error *err) {
    json_error_t json_err;
    st->root = json_loadb((const char *)st->data + HEADER_AT, st->n_header, JSON_REJECT_DUPLICATES, &json_err);
    if (!json_is_object(st->root)) {
        long long byte = HEADER_AT + (st->root ? 0 : json_err.position);
        return nqm_fail(err, NQM_ERR_FORMAT, byte, "%s: not a safetensors file: header: %s (byte %lld)", name,
                        st->root ? "not an object" : json_err.text, byte);
    }
    st->meta = json_object_get(st->root, "__metadata__");
    nqm_status status = st->meta ? check_meta(st, name, err) : NQM_OK;
    size_t n_max = json_object_size(st->root);
    st->tensors = nqm_alloc(n_max, sizeof *st->tensors);
    if (status == NQM_OK && !st->tensors)
        status = nqm_fail_nomem(err, n_max * sizeof *st->tensors);
    const char *key;
    json_t *entry;
    json_object_foreach(st->root, key, entry) {
        if (status != NQM_OK)
            break;
        if (entry == st->meta)
            continue;
        const place at = {name, key, err};
        status = read_tensor(&at, entry, st, &st->tensors[st->n_tensors++]);
    }
    return status;
}

nqm_status nqm_safetensors_parse(const unsigned char *data, size_t n_bytes, const char *name, nqm_safetensors **st_ret,
                                 nqm_error *err) {
    *st_ret = NULL;
    if (n_bytes < HEADER_AT)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)n_bytes, "%s: not a safetensors file: %zu bytes only", name,
                        n_bytes);
    uint64_t n_header = nqm_load_u64(data);
    if (n_header > MAX_HEADER || n_header > n_bytes - HEADER_AT)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: not a safetensors file, or cut off: a header of %llu bytes in a file of %zu (byte 0)",
                        name, (unsigned long long)n_header, n_bytes);
    nqm_safetensors *st = nqm_alloc(1, sizeof *st);
    if (!st)
        return nqm_fail_nomem(err, sizeof *st);
    *st = (nqm_safetensors){.data = data, .n_bytes = n_bytes, .n_header = (size_t)n_header};
    nqm_status status = read_header(st, name, err);
    if (status == NQM_OK)
        status = check_contiguous(st, name, err);
    if (status != NQM_OK) {
        nqm_safetensors_free(st);
        return status;
    }
    *st_ret = st;
    return NQM_OK;
}

void nqm_safetensors_free(nqm_safetensors *st) {
    if (!st)
        return;
    json_decref(st->root);
    nqm_free(st->tensors);
    nqm_free(st);
}

/* ---- getters ----------------------------------------------------------------------------------------------------- */

size_t nqm_safetensors_count(const nqm_safetensors *st) {
    return st->n_tensors;
}

const nqm_tensor *nqm_safetensors_at(const nqm_safetensors *st, size_t i) {
    return &st->tensors[i];
}

const nqm_tensor *nqm_safetensors_find(const nqm_safetensors *st, const char *tensor_name) {
    for (size_t i = 0; i < st->n_tensors; ++i)
        if (strcmp(st->tensors[i].name, tensor_name) == 0)
            return &st->tensors[i];
    return NULL;
}

const char *nqm_safetensors_meta(const nqm_safetensors *st, const char *key) {
    return json_string_value(json_object_get(st->meta, key));
}

bool nqm_tensor_all_finite(const nqm_tensor *tensor) {
    const unsigned char *p = tensor->data;
    if (tensor->dtype == NQM_F64) {
        for (size_t i = 0; i < tensor->n_bytes; i += 8)
            if (!isfinite(nqm_load_f64(p + i)))
                return false;
        return true;
    }
    uint32_t largest = 0; /* magnitude as bits: infinities and NaN have the largest exponent */
    if (tensor->dtype == NQM_F16) {
        for (size_t i = 1; i < tensor->n_bytes; i += 2) /* the byte with the exponent */
            largest = (p[i] & 0x7fu) > largest ? p[i] & 0x7fu : largest;
        return largest < 0x7c;
    }
    for (size_t i = 0; tensor->dtype == NQM_F32 && i < tensor->n_bytes; i += 4) {
        uint32_t bits = nqm_load_u32(p + i) & 0x7fffffff;
        largest = bits > largest ? bits : largest;
    }
    return largest < 0x7f800000;
}

/* ---- checksum ---------------------------------------------------------------------------------------------------- */

/* Offset of the checksum's digits in the header; n_header when there are none. A text search is sufficient: the
 * unescaped quotes of the key cannot occur inside a JSON string. */
static size_t find_digits(const unsigned char *header, size_t n_header, const char *digits) {
    const size_t n_key = sizeof sha_key - 1, n = n_key + SHA_DIGITS + 1;
    for (size_t i = 0; i + n <= n_header; ++i)
        if (memcmp(header + i, sha_key, n_key) == 0 && memcmp(header + i + n_key, digits, SHA_DIGITS) == 0)
            return i + n_key;
    return n_header;
}

bool nqm_safetensors_checksum(const nqm_safetensors *st, char hex[65], bool *matches) {
    char zeros[SHA_DIGITS];
    memset(zeros, '0', sizeof zeros);
    *matches = false;
    hex[0] = '\0';
    const char *stored = nqm_safetensors_meta(st, "sha256");
    if (!stored || strlen(stored) != SHA_DIGITS)
        return false;
    size_t at = find_digits(st->data + HEADER_AT, st->n_header, stored);
    if (at == st->n_header)
        return false;
    size_t before = HEADER_AT + at, after = before + SHA_DIGITS;
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        return true; /* out of memory: the file has a checksum, but it was not verified */
    nqm_sha256_add(&sha, st->data, before);
    nqm_sha256_add(&sha, zeros, sizeof zeros);
    nqm_sha256_add(&sha, st->data + after, st->n_bytes - after);
    nqm_sha256_end(&sha, hex);
    *matches = strcmp(hex, stored) == 0;
    return true;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* A tensor to write. */
typedef struct outgoing {
    const nqm_tensor *tensor;
    size_t index; /* position in the caller's array */
} outgoing;

/* Order: tensors whose size is a multiple of 64 bytes first; the others by decreasing element size, so that each is
 * aligned to its element size; then by decreasing size, then in the caller's order. */
static int by_alignment(const void *a, const void *b) {
    const outgoing *left = a, *right = b;
    size_t n_l = left->tensor->n_bytes, n_r = right->tensor->n_bytes;
    bool odd_l = n_l % ALIGNMENT != 0, odd_r = n_r % ALIGNMENT != 0;
    if (odd_l != odd_r)
        return odd_l ? 1 : -1;
    size_t element_l = dtypes[left->tensor->dtype].n_bytes, element_r = dtypes[right->tensor->dtype].n_bytes;
    if (odd_l && element_l != element_r)
        return element_l > element_r ? -1 : 1;
    if (n_l != n_r)
        return n_l > n_r ? -1 : 1;
    return (left->index > right->index) - (left->index < right->index);
}

static json_t *tensor_entry(const nqm_tensor *tensor, size_t begin) {
    json_t *shape = json_array();
    for (size_t i = 0; i < tensor->n_dims; ++i)
        json_array_append_new(shape, json_integer((json_int_t)tensor->dims[i]));
    return json_pack("{s:s, s:o, s:[I, I]}", "dtype", dtypes[tensor->dtype].name, "shape", shape, "data_offsets",
                     (json_int_t)begin, (json_int_t)(begin + tensor->n_bytes));
}

static json_t *meta_object(size_t n_meta, const nqm_meta *meta) {
    char zeros[SHA_DIGITS + 1] = {0};
    memset(zeros, '0', SHA_DIGITS);
    json_t *object = json_object();
    for (size_t i = 0; i < n_meta; ++i)
        if (json_object_get(object, meta[i].key) || strcmp(meta[i].key, "sha256") == 0 ||
            json_object_set_new(object, meta[i].key, json_string(meta[i].value)) != 0)
            goto fail;
    if (json_object_set_new(object, "sha256", json_string(zeros)) == 0)
        return object;
fail:
    json_decref(object);
    return NULL;
}

/* The header's JSON text (free() it), or NULL when a name occurs twice, a text is not UTF-8, or memory runs out. */
static char *header_text(size_t n_tensors, const outgoing *order, size_t n_meta, const nqm_meta *meta) {
    char *text = NULL;
    json_t *root = json_object();
    bool good = json_object_set_new(root, "__metadata__", meta_object(n_meta, meta)) == 0;
    size_t begin = 0;
    for (size_t i = 0; good && i < n_tensors; ++i) {
        const nqm_tensor *tensor = order[i].tensor;
        good = !json_object_get(root, tensor->name) &&
               json_object_set_new(root, tensor->name, tensor_entry(tensor, begin)) == 0;
        begin += tensor->n_bytes;
    }
    if (good)
        text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}

/* The bytes before the tensors: length, JSON, spaces up to a multiple of 64 bytes. nqm_free() it. */
static unsigned char *make_front(const char *text, size_t *n_front) {
    size_t n_text = strlen(text);
    *n_front = (HEADER_AT + n_text + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    unsigned char *front = nqm_alloc(*n_front, 1);
    if (!front)
        return NULL;
    memset(front, ' ', *n_front);
    nqm_store_u64(front, *n_front - HEADER_AT);
    memcpy(front + HEADER_AT, text, n_text);
    return front;
}

/* Compute the checksum of front and tensors and store it in the front, in place of the zeros; false when out of
 * memory. */
static bool seal(unsigned char *front, size_t n_front, size_t n_tensors, const outgoing *order, char hex[65]) {
    char zeros[SHA_DIGITS];
    memset(zeros, '0', sizeof zeros);
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        return false;
    nqm_sha256_add(&sha, front, n_front);
    for (size_t i = 0; i < n_tensors; ++i)
        nqm_sha256_add(&sha, order[i].tensor->data, order[i].tensor->n_bytes);
    nqm_sha256_end(&sha, hex);
    memcpy(front + HEADER_AT + find_digits(front + HEADER_AT, n_front - HEADER_AT, zeros), hex, SHA_DIGITS);
    return true;
}

static nqm_status write_bytes(const char *path, const unsigned char *front, size_t n_front, size_t n_tensors,
                              const outgoing *order, nqm_error *err) {
    nqm_outfile out;
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    fwrite(front, 1, n_front, out.stream);
    for (size_t i = 0; i < n_tensors; ++i)
        fwrite(order[i].tensor->data, 1, order[i].tensor->n_bytes, out.stream);
    return nqm_outfile_commit(&out, err); /* checks the stream's error flag */
}

static nqm_status order_tensors(const char *path, size_t n_tensors, const nqm_tensor *tensors, outgoing *order,
                                nqm_error *err) {
    for (size_t i = 0; i < n_tensors; ++i) {
        const nqm_tensor *tensor = &tensors[i];
        size_t n_bytes;
        if (tensor->n_dims > NQM_MAX_DIMS || !tensor_size(tensor->dtype, tensor->n_dims, tensor->dims, &n_bytes) ||
            n_bytes != tensor->n_bytes)
            return nqm_fail(err, NQM_ERR_ARG, -1, "%s: tensor '%.64s': shape does not match its bytes", path,
                            tensor->name);
        order[i] = (outgoing){tensor, i};
    }
    qsort(order, n_tensors, sizeof *order, by_alignment);
    return NQM_OK;
}

nqm_status nqm_safetensors_write(const char *path, size_t n_tensors, const nqm_tensor *tensors, size_t n_meta,
                                 const nqm_meta *meta, char sha256_ret[65], nqm_error *err) {
    nqm_status status;
    char hex[65];
    char *text = NULL;
    unsigned char *front = NULL;
    size_t n_front = 0;
    outgoing *order = nqm_alloc(n_tensors, sizeof *order);
    if (!order)
        return nqm_fail_nomem(err, n_tensors * sizeof *order);
    status = order_tensors(path, n_tensors, tensors, order, err);
    if (status != NQM_OK)
        goto done;
    text = header_text(n_tensors, order, n_meta, meta);
    if (!text) {
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: a tensor's or metadata name occurs twice, or a text is not UTF-8",
                          path);
        goto done;
    }
    front = make_front(text, &n_front);
    if (!front || !seal(front, n_front, n_tensors, order, hex)) {
        status = nqm_fail_nomem(err, n_front);
        goto done;
    }
    status = write_bytes(path, front, n_front, n_tensors, order, err);
    if (status == NQM_OK && sha256_ret)
        memcpy(sha256_ret, hex, sizeof hex);
done:
    free(text);
    nqm_free(front);
    nqm_free(order);
    return status;
}
