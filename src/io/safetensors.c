/* SPDX-License-Identifier: MIT
 *
 * safetensors files (huggingface.co/docs/safetensors): an 8-byte little-endian header length, a JSON header, then the
 * tensors' bytes without gaps. The reader validates type, shape and offsets of every tensor; its tensors point into the
 * given bytes, on a big-endian host into a converted copy. The writer pads the header so that the data begin at a
 * multiple of 64 bytes, and writes tensors whose size is a multiple of 64 bytes first, so that these stay aligned; it
 * stores a checksum of the file in the header.
 */
#include "io/io.h"
#include "io/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_AT = 8, MAX_HEADER = 100 * 1000 * 1000, SHA_DIGITS = 64, ALIGNMENT = 64 };

/* One block; the tensors follow the struct. */
struct nqm_safetensors {
    const unsigned char *data;
    size_t n_bytes, n_header;
    const char *name;    /* name in messages; owned by the caller */
    json_t *root;        /* owns names and metadata */
    json_t *meta;        /* part of root, or NULL */
    nqm_tensor *tensors; /* (n_tensors) */
    size_t n_tensors;
    unsigned char *native; /* (n_bytes) big-endian hosts: the tensors' values in the order of the host; others: NULL */
};

static const struct {
    const char *name;
    size_t n_bytes;
} dtypes[] = {[NQM_F32] = {"F32", 4}, [NQM_F64] = {"F64", 8}, [NQM_I32] = {"I32", 4}, [NQM_I64] = {"I64", 8},
              [NQM_U8] = {"U8", 1},   [NQM_U16] = {"U16", 2}, [NQM_U32] = {"U32", 4}, [NQM_F16] = {"F16", 2}};
enum { N_DTYPES = sizeof dtypes / sizeof *dtypes };

static const char sha_key[] = "\"sha256\":\"";
static const char zeros[SHA_DIGITS + 1] = "0000000000000000000000000000000000000000000000000000000000000000";

size_t nqm_dtype_size(nqm_dtype dtype) {
    return dtypes[dtype].n_bytes;
}

nqm_tensor nqm_tensor_of(const char *name, nqm_dtype dtype, size_t rows, size_t cols, const void *data) {
    nqm_tensor tensor = {.name = name, .dtype = dtype, .n_dims = rows ? 2 : 1, .data = data};
    tensor.dims[0] = rows;
    tensor.dims[rows ? 1 : 0] = cols;
    nqm_tensor_measure(&tensor);
    return tensor;
}

size_t nqm_tensor_count(const nqm_tensor *tensor) {
    return tensor->n_bytes / dtypes[tensor->dtype].n_bytes;
}

bool nqm_tensor_measure(nqm_tensor *tensor) {
    tensor->n_bytes = dtypes[tensor->dtype].n_bytes;
    for (size_t i = 0; i < tensor->n_dims; ++i)
        if (!nqm_mul_size(tensor->n_bytes, tensor->dims[i], &tensor->n_bytes))
            return false;
    return true;
}

static int compare(uint64_t a, uint64_t b) {
    return (a > b) - (a < b);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static nqm_status fail_tensor(const nqm_safetensors *st, const char *name, int64_t byte, const char *what,
                              nqm_error *err) {
    return nqm_fail(err, NQM_ERR_FORMAT, byte, "%s: tensor '%.64s': %s (byte %lld)", st->name, name, what,
                    (long long)byte);
}

/* Read a list of at most n_max sizes; false when the value is anything else. */
static bool read_sizes(const json_t *list, size_t n_max, size_t *n_ret, size_t *sizes) {
    *n_ret = json_array_size(list);
    bool ok = json_is_array(list) && *n_ret <= n_max;
    for (size_t i = 0; ok && i < *n_ret; ++i) {
        const json_t *value = json_array_get(list, i);
        ok = json_is_integer(value) && json_integer_value(value) >= 0;
        sizes[i] = (size_t)json_integer_value(value);
    }
    return ok;
}

static nqm_status read_tensor(const nqm_safetensors *st, const char *name, const json_t *entry, nqm_tensor *tensor,
                              nqm_error *err) {
    const char *dtype = json_string_value(json_object_get(entry, "dtype"));
    size_t n, range[2], type = 0, data_at = HEADER_AT + st->n_header;
    while (dtype && type < N_DTYPES && strcmp(dtype, dtypes[type].name) != 0)
        ++type;
    if (!dtype || type == N_DTYPES)
        return fail_tensor(st, name, HEADER_AT, "its dtype is none of F16, F32, F64, I32, I64, U8, U16, U32", err);
    *tensor = (nqm_tensor){.name = name, .dtype = (nqm_dtype)type};
    if (!read_sizes(json_object_get(entry, "shape"), NQM_MAX_DIMS, &tensor->n_dims, tensor->dims))
        return fail_tensor(st, name, HEADER_AT, "its shape is not a list of at most 6 sizes", err);
    if (!read_sizes(json_object_get(entry, "data_offsets"), 2, &n, range) || n != 2)
        return fail_tensor(st, name, HEADER_AT, "its data_offsets are not two sizes", err);
    if (range[0] > range[1] || range[1] > st->n_bytes - data_at)
        return fail_tensor(st, name, (int64_t)st->n_bytes, "its data_offsets extend beyond the end of the file", err);
    tensor->data = st->data + data_at + range[0];
    tensor->byte_offset = (int64_t)(data_at + range[0]);
    return nqm_tensor_measure(tensor) && tensor->n_bytes == range[1] - range[0]
               ? NQM_OK
               : fail_tensor(st, name, tensor->byte_offset, "its shape does not match its bytes", err);
}

static int by_position(const void *a, const void *b) {
    const nqm_tensor *left = *(const nqm_tensor *const *)a, *right = *(const nqm_tensor *const *)b;
    const int order = compare((uint64_t)left->byte_offset, (uint64_t)right->byte_offset);
    return order ? order : compare(left->n_bytes, right->n_bytes);
}

/* Check that the tensors fill the file from the end of the header to the end of the file, without gaps or overlaps.
 * order: (n_tensors) scratch. */
static nqm_status check_contiguous(const nqm_safetensors *st, const nqm_tensor **order, nqm_error *err) {
    for (size_t i = 0; i < st->n_tensors; ++i)
        order[i] = &st->tensors[i];
    qsort(order, st->n_tensors, sizeof *order, by_position);
    int64_t next = (int64_t)(HEADER_AT + st->n_header);
    for (size_t i = 0; i < st->n_tensors; ++i) {
        if (order[i]->byte_offset != next)
            return fail_tensor(st, order[i]->name, next,
                               order[i]->byte_offset < next ? "overlaps another" : "leaves a gap before it", err);
        next += (int64_t)order[i]->n_bytes;
    }
    return next == (int64_t)st->n_bytes
               ? NQM_OK
               : nqm_fail(err, NQM_ERR_FORMAT, next, "%s: bytes after the last tensor (byte %lld)", st->name,
                          (long long)next);
}

static nqm_status read_entries(nqm_safetensors *st, nqm_error *err) {
    const char *key;
    json_t *value;
    st->meta = json_object_get(st->root, "__metadata__");
    if (st->meta && !json_is_object(st->meta))
        return nqm_fail(err, NQM_ERR_FORMAT, HEADER_AT, "%s: __metadata__ is not an object (byte 8)", st->name);
    json_object_foreach(st->meta, key, value) {
        if (!json_is_string(value))
            return nqm_fail(err, NQM_ERR_FORMAT, HEADER_AT, "%s: metadata '%.64s' is not a string (byte 8)", st->name,
                            key);
    }
    json_object_foreach(st->root, key, value) {
        nqm_status status = value == st->meta ? NQM_OK : read_tensor(st, key, value, &st->tensors[st->n_tensors], err);
        if (status != NQM_OK)
            return status;
        st->n_tensors += value != st->meta;
    }
    return NQM_OK;
}

/* Point the tensors to a copy in the byte order of the host, at the same offsets, so that it is aligned as the file. */
static nqm_status make_native(nqm_safetensors *st, nqm_error *err) {
    st->native = nqm_alloc(st->n_bytes, 1);
    if (!st->native)
        return nqm_fail_nomem(err, st->n_bytes);
    for (size_t i = 0; i < st->n_tensors; ++i) {
        nqm_tensor *t = &st->tensors[i];
        unsigned char *to = st->native + t->byte_offset;
        nqm_copy_little_endian(nqm_tensor_count(t), nqm_dtype_size(t->dtype), t->data, to);
        t->data = to;
    }
    return NQM_OK;
}

nqm_status nqm_safetensors_parse(const unsigned char *data, size_t n_bytes, const char *name, nqm_safetensors **st_ret,
                                 nqm_error *err) {
    *st_ret = NULL;
    const char *kind = nqm_file_kind(data, n_bytes);
    const uint64_t n_header = n_bytes < HEADER_AT ? UINT64_MAX : nqm_load_u64(data);
    if (n_header > n_bytes && kind && (n_bytes <= HEADER_AT || data[HEADER_AT] != '{'))
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: not a safetensors file: it begins like %s (byte 0)", name, kind);
    if (n_bytes < HEADER_AT)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)n_bytes, "%s: not a safetensors file: it %s (byte %zu)", name,
                        n_bytes ? "ends in its header's length" : "is empty", n_bytes);
    if (n_header > MAX_HEADER || n_header > n_bytes - HEADER_AT)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: not a safetensors file, or cut off: a header of %llu bytes in a file of %zu (byte 0)",
                        name, (unsigned long long)n_header, n_bytes);
    json_error_t why;
    nqm_status status = nqm_json_check((const char *)data + HEADER_AT, (size_t)n_header, n_bytes, name, HEADER_AT, err);
    if (status != NQM_OK)
        return status;
    json_t *root;
    status = nqm_json_load((const char *)data + HEADER_AT, (size_t)n_header, JSON_REJECT_DUPLICATES, &root, &why, err);
    if (status == NQM_ERR_NOMEM)
        return status;
    const long long byte = HEADER_AT + (root ? 0 : why.position);
    const size_t n_max = json_object_size(root);
    nqm_safetensors *st;
    nqm_tensor *tensors;
    const nqm_tensor **order;
    if (json_is_object(root))
        status = nqm_alloc_arrays(
            NQM_ARRAYS({&st, 1, sizeof *st}, {&tensors, n_max, sizeof *tensors}, {&order, n_max, sizeof *order}), err);
    else
        status = nqm_fail(err, NQM_ERR_FORMAT, byte, "%s: not a safetensors file: header: %s (byte %lld)", name,
                          root ? "not an object" : why.text, byte);
    if (status != NQM_OK) {
        json_decref(root);
        return status;
    }
    *st = (nqm_safetensors){
        .data = data, .n_bytes = n_bytes, .n_header = (size_t)n_header, .name = name, .root = root, .tensors = tensors};
    status = read_entries(st, err);
    if (status == NQM_OK)
        status = check_contiguous(st, order, err);
    if (status == NQM_OK && NQM_BIG_ENDIAN)
        status = make_native(st, err);
    if (status == NQM_OK)
        *st_ret = st;
    else
        nqm_safetensors_free(st);
    return status;
}

void nqm_safetensors_free(nqm_safetensors *st) {
    if (st) {
        json_decref(st->root);
        nqm_free(st->native);
    }
    nqm_free(st);
}

unsigned char *nqm_safetensors_take(nqm_safetensors *st) {
    unsigned char *block = st->native;
    st->native = NULL;
    return block;
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

nqm_status nqm_safetensors_floats(const nqm_safetensors *st, const nqm_tensor *expected, nqm_status failure,
                                  const nqm_tensor **tensor_ret, nqm_error *err) {
    const nqm_tensor *tensor = nqm_safetensors_find(st, expected->name);
    if (!tensor)
        return nqm_fail(err, failure, HEADER_AT, "%s: tensor '%s' is missing (header at byte 8)", st->name,
                        expected->name);
    bool fits = tensor->dtype == NQM_F32 && tensor->n_dims == expected->n_dims;
    for (size_t i = 0; fits && i < expected->n_dims; ++i)
        fits = expected->dims[i] ? tensor->dims[i] == expected->dims[i] : tensor->dims[i] > 0;
    if (!fits)
        return nqm_fail(err, failure, tensor->byte_offset, "%s: tensor '%s' has the wrong type or shape (byte %lld)",
                        st->name, tensor->name, (long long)tensor->byte_offset);
    *tensor_ret = tensor;
    return NQM_OK;
}

const char *nqm_safetensors_meta(const nqm_safetensors *st, const char *key) {
    return json_string_value(json_object_get(st->meta, key));
}

/* The largest magnitude, as bits, of the words that begin every `step` bytes. Infinities and NaN have the largest exponent. */
static inline uint32_t largest_word(const unsigned char *p, size_t n_bytes, size_t step) {
    uint32_t largest = 0;
    for (size_t i = 0; i < n_bytes; i += step) {
        uint32_t bits;
        memcpy(&bits, p + i, sizeof bits);
        bits &= 0x7fffffff;
        largest = bits > largest ? bits : largest;
    }
    return largest;
}

bool nqm_tensor_all_finite(const nqm_tensor *tensor) {
    const unsigned char *p = tensor->data;
    unsigned largest = 0;
    if (tensor->dtype == NQM_F64) /* the half with the exponent */
        return largest_word(p + (NQM_BIG_ENDIAN ? 0 : 4), tensor->n_bytes, 8) < 0x7ff00000;
    if (tensor->dtype == NQM_F32)
        return largest_word(p, tensor->n_bytes, 4) < 0x7f800000;
    for (size_t i = !NQM_BIG_ENDIAN; tensor->dtype == NQM_F16 && i < tensor->n_bytes; i += 2) /* likewise the byte */
        largest = (p[i] & 0x7fu) > largest ? p[i] & 0x7fu : largest;
    return largest < 0x7c;
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
    nqm_sha256_add(&sha, zeros, SHA_DIGITS);
    nqm_sha256_add(&sha, st->data + after, st->n_bytes - after);
    nqm_sha256_end(&sha, hex);
    *matches = strcmp(hex, stored) == 0;
    return true;
}

nqm_status nqm_safetensors_verify(const nqm_safetensors *st, const char *schema, bool has_checksum, nqm_status failure,
                                  nqm_error *err) {
    const char *found = nqm_safetensors_meta(st, "schema");
    char hex[65];
    bool matches;
    if (!found || strcmp(found, schema) != 0)
        return nqm_fail(err, failure, HEADER_AT,
                        "%s: schema %.16s; this version of nqm reads schema %s only (header at byte 8)", st->name,
                        found ? found : "(none)", schema);
    if (has_checksum && (!nqm_safetensors_checksum(st, hex, &matches) || !matches))
        return nqm_fail(err, failure, HEADER_AT,
                        "%s: checksum (SHA-256) missing or wrong: the file was changed or damaged (header at byte 8)",
                        st->name);
    return NQM_OK;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* Order: tensors whose size is a multiple of 64 bytes first; the others by decreasing element size, so that each is
 * aligned to its element size; then by decreasing size, then in the caller's order. */
static int by_alignment(const void *a, const void *b) {
    const nqm_tensor *left = *(const nqm_tensor *const *)a, *right = *(const nqm_tensor *const *)b;
    const bool odd = left->n_bytes % ALIGNMENT != 0;
    int order = compare(odd, right->n_bytes % ALIGNMENT != 0);
    if (order == 0 && odd)
        order = compare(dtypes[right->dtype].n_bytes, dtypes[left->dtype].n_bytes);
    if (order == 0)
        order = compare(right->n_bytes, left->n_bytes);
    return order ? order : compare((uintptr_t)left, (uintptr_t)right);
}

static json_t *tensor_entry(const nqm_tensor *tensor, size_t begin) {
    json_t *shape = json_array();
    for (size_t i = 0; i < tensor->n_dims; ++i)
        json_array_append_new(shape, json_integer((json_int_t)tensor->dims[i]));
    return json_pack("{s:s, s:o, s:[I, I]}", "dtype", dtypes[tensor->dtype].name, "shape", shape, "data_offsets",
                     (json_int_t)begin, (json_int_t)(begin + tensor->n_bytes));
}

static json_t *meta_object(size_t n_meta, const nqm_meta *meta) {
    json_t *object = json_object();
    bool good = true;
    for (size_t i = 0; good && i < n_meta; ++i)
        good = !json_object_get(object, meta[i].key) && strcmp(meta[i].key, "sha256") != 0 &&
               json_object_set_new(object, meta[i].key, json_string(meta[i].value)) == 0;
    if (good && json_object_set_new(object, "sha256", json_string(zeros)) == 0)
        return object;
    json_decref(object);
    return NULL;
}

/* The header's JSON text (free() it), or NULL when a name occurs twice, a text is not UTF-8, or memory runs out. */
static char *header_text(size_t n_tensors, const nqm_tensor *const *order, size_t n_meta, const nqm_meta *meta) {
    char *text = NULL;
    nqm_json_watch();
    json_t *root = json_object();
    bool good = json_object_set_new(root, "__metadata__", meta_object(n_meta, meta)) == 0;
    size_t begin = 0;
    for (size_t i = 0; good && i < n_tensors; ++i) {
        good = !json_object_get(root, order[i]->name) &&
               json_object_set_new(root, order[i]->name, tensor_entry(order[i], begin)) == 0;
        begin += order[i]->n_bytes;
    }
    if (good)
        text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    if (!nqm_json_has_failed())
        return text;
    free(text);
    return NULL;
}

/* The bytes before the tensors: length, JSON with the checksum of the file (hex), spaces up to a multiple of 64 bytes.
 * nqm_free() it; NULL when out of memory. */
static unsigned char *make_front(const char *text, size_t n_tensors, const nqm_tensor *const *order, size_t *n_front,
                                 char hex[65]) {
    size_t n_text = strlen(text);
    nqm_sha256 sha;
    *n_front = (HEADER_AT + n_text + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    unsigned char *front = nqm_alloc(*n_front, 1);
    if (!front || !nqm_sha256_begin(&sha)) {
        nqm_free(front);
        return NULL;
    }
    unsigned char *header = front + HEADER_AT;
    memset(front, ' ', *n_front);
    nqm_store_u64(front, *n_front - HEADER_AT);
    memcpy(header, text, n_text);
    nqm_sha256_add(&sha, front, *n_front);
    for (size_t i = 0; i < n_tensors; ++i)
        nqm_sha256_add_values(&sha, nqm_tensor_count(order[i]), nqm_dtype_size(order[i]->dtype), order[i]->data);
    nqm_sha256_end(&sha, hex);
    memcpy(header + find_digits(header, n_text, zeros), hex, SHA_DIGITS);
    return front;
}

nqm_status nqm_safetensors_write(const char *path, size_t n_tensors, const nqm_tensor *tensors, size_t n_meta,
                                 const nqm_meta *meta, char sha256_ret[65], nqm_error *err) {
    char hex[65], *text = NULL;
    unsigned char *front = NULL;
    size_t n_front = 0;
    nqm_outfile out;
    nqm_status status = NQM_OK;
    const nqm_tensor **order = nqm_alloc(n_tensors, sizeof *order);
    if (!order)
        return nqm_fail_nomem(err, n_tensors * sizeof *order);
    for (size_t i = 0; status == NQM_OK && i < n_tensors; ++i) {
        order[i] = &tensors[i];
        nqm_tensor measured = *order[i];
        if (measured.n_dims > NQM_MAX_DIMS || !nqm_tensor_measure(&measured) || measured.n_bytes != order[i]->n_bytes)
            status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: tensor '%.64s': shape does not match its bytes", path,
                              order[i]->name);
    }
    if (status != NQM_OK)
        goto done;
    qsort(order, n_tensors, sizeof *order, by_alignment);
    text = header_text(n_tensors, order, n_meta, meta);
    if (text)
        front = make_front(text, n_tensors, order, &n_front, hex);
    if (!text && nqm_json_has_failed())
        status = nqm_fail_nomem(err, n_tensors);
    else if (!text)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s: a tensor's or metadata name occurs twice, or a text is not UTF-8",
                          path);
    else if (!front)
        status = nqm_fail_nomem(err, n_front);
    else
        status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        goto done;
    fwrite(front, 1, n_front, out.stream);
    for (size_t i = 0; i < n_tensors; ++i)
        nqm_write_values(out.stream, nqm_tensor_count(order[i]), nqm_dtype_size(order[i]->dtype), order[i]->data);
    status = nqm_outfile_commit(&out, err); /* checks the stream's error flag */
    if (status == NQM_OK && sha256_ret)
        memcpy(sha256_ret, hex, sizeof hex);
done:
    free(text);
    nqm_free(front);
    nqm_free(order);
    return status;
}
