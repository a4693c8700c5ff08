/* SPDX-License-Identifier: MIT
 *
 * One array of NumPy (.npy, versions 1 to 3): read and written.
 *
 * File: "\x93NUMPY"; u8 major, minor version; u16 (version 1) or u32 little-endian length of the header; the header, a Python
 * dictionary with the keys 'descr', 'fortran_order' and 'shape', padded with spaces and a line end; the values.
 */
#include "io/io.h"

#include <ctype.h>
#include <string.h>

static const unsigned char magic[6] = {0x93, 'N', 'U', 'M', 'P', 'Y'};

/** A position in the header, and what was read from it. */
typedef struct header {
    const char *at, *end;
    char descr[16], order[8];
    bool has_shape;
    nqm_tensor *tensor;
} header;

bool nqm_npy_probe(const nqm_map *map) {
    return map->n_bytes >= sizeof magic && memcmp(map->data, magic, sizeof magic) == 0;
}

/* The next character that is no blank, which is not consumed; 0 at the end. */
static char peek(header *h) {
    while (h->at < h->end && (*h->at == ' ' || *h->at == '\n' || *h->at == '\t'))
        ++h->at;
    return h->at < h->end ? *h->at : '\0';
}

static bool accept(header *h, char c) {
    if (peek(h) != c)
        return false;
    ++h->at;
    return true;
}

/* A quoted text; false: none, or longer than fits. */
static bool read_string(header *h, char *text, size_t n_text) {
    const char quote = peek(h);
    if (quote != '\'' && quote != '"')
        return false;
    size_t n = 0;
    for (++h->at; h->at < h->end && *h->at != quote && n + 1 < n_text; ++h->at)
        text[n++] = *h->at;
    text[n] = '\0';
    return accept(h, quote);
}

static bool read_word(header *h, char *word, size_t n_word) {
    size_t n = 0;
    for (peek(h); h->at < h->end && isalpha((unsigned char)*h->at) && n + 1 < n_word; ++h->at)
        word[n++] = *h->at;
    word[n] = '\0';
    return n > 0;
}

static bool read_size(header *h, size_t *size) {
    bool any = false;
    *size = 0;
    for (peek(h); h->at < h->end && isdigit((unsigned char)*h->at); ++h->at, any = true)
        if (!nqm_mul_size(*size, 10, size) || *size > SIZE_MAX - 9)
            return false;
        else
            *size += (size_t)(*h->at - '0');
    return any;
}

static bool read_shape(header *h) {
    nqm_tensor *t = h->tensor;
    if (!accept(h, '('))
        return false;
    while (!accept(h, ')')) {
        if (t->n_dims == NQM_MAX_DIMS || !read_size(h, t->dims + t->n_dims++))
            return false;
        if (!accept(h, ',') && peek(h) != ')')
            return false;
    }
    h->has_shape = true;
    return true;
}

static bool read_dictionary(header *h) {
    char key[16];
    if (!accept(h, '{'))
        return false;
    while (!accept(h, '}')) {
        if (!read_string(h, key, sizeof key) || !accept(h, ':'))
            return false;
        bool right = strcmp(key, "descr") == 0           ? !h->descr[0] && read_string(h, h->descr, sizeof h->descr)
                     : strcmp(key, "fortran_order") == 0 ? !h->order[0] && read_word(h, h->order, sizeof h->order)
                     : strcmp(key, "shape") == 0         ? !h->has_shape && read_shape(h)
                                                         : false;
        if (!right || (!accept(h, ',') && peek(h) != '}'))
            return false;
    }
    return peek(h) == '\0' && h->descr[0] && h->order[0] && h->has_shape;
}

/* Check the type, the order and the size of the values, which begin at byte `at`. */
static nqm_status check_values(header *h, size_t at, const nqm_map *map, nqm_error *err) {
    nqm_tensor *t = h->tensor;
    const bool f32 = strcmp(h->descr, "<f4") == 0;
    if (!f32 && strcmp(h->descr, "<f8") != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 10,
                        "%s: its values are '%s' (header at byte 10); only float32 and float64 "
                        "('<f4', '<f8') are read: array.astype('<f4')",
                        map->path, h->descr);
    t->is_column_major = strcmp(h->order, "False") != 0;
    t->dtype = f32 ? NQM_F32 : NQM_F64;
    if (!nqm_tensor_measure(t))
        return nqm_fail(err, NQM_ERR_FORMAT, 10, "%s: its shape is impossible (header at byte 10)", map->path);
    const size_t n_present = map->n_bytes - at, first = nqm_smaller(n_present, t->n_bytes) + at;
    if (n_present != t->n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)first,
                        "%s: its shape needs %zu bytes from byte %zu on: %s at byte %zu", map->path, t->n_bytes, at,
                        n_present < t->n_bytes ? "it ends" : "more follows", first);
    t->data = map->data + at;
    t->byte_offset = (int64_t)at;
    return NQM_OK;
}

nqm_status nqm_npy_parse(const nqm_map *map, nqm_tensor *tensor_ret, nqm_error *err) {
    const unsigned char *data = map->data;
    *tensor_ret = (nqm_tensor){.name = "array"};
    const size_t head = map->n_bytes > 6 && data[6] == 1 ? 10 : 12;
    if (!nqm_npy_probe(map) || map->n_bytes < head || data[6] < 1 || data[6] > 3)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: byte 0 begins no .npy file of version 1 to 3", map->path);
    const size_t n_header = head == 10 ? nqm_load_u16(data + 8) : nqm_load_u32(data + 8);
    if (n_header > map->n_bytes - head)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)map->n_bytes, "%s: ends at byte %zu, inside its header",
                        map->path, map->n_bytes);
    header h = {.at = (const char *)data + head, .end = (const char *)data + head + n_header, .tensor = tensor_ret};
    if (!read_dictionary(&h))
        return nqm_fail(err, NQM_ERR_FORMAT, (const unsigned char *)h.at - data,
                        "%s: byte %zu is not that of a header with 'descr', 'fortran_order' and 'shape' of one array",
                        map->path, (size_t)((const unsigned char *)h.at - data));
    return check_values(&h, head + n_header, map, err);
}

nqm_status nqm_npy_write(const char *path, const nqm_tensor *tensor, nqm_error *err) {
    char text[256];
    int n = snprintf(text, sizeof text, "{'descr': '<f%zu', 'fortran_order': False, 'shape': (",
                     nqm_dtype_size(tensor->dtype));
    for (size_t i = 0; i < tensor->n_dims; ++i)
        n += snprintf(text + n, sizeof text - (size_t)n, "%zu,", tensor->dims[i]);
    n += snprintf(text + n, sizeof text - (size_t)n, ")}");
    const size_t n_header = ((size_t)n + 10 + 1 + 63) / 64 * 64 - 10; /* the values begin at a multiple of 64 bytes */
    unsigned char head[10] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
    nqm_store_u16(head + 8, (uint16_t)n_header);
    nqm_outfile out;
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    fwrite(head, 1, sizeof head, out.stream);
    fprintf(out.stream, "%-*s\n", (int)n_header - 1, text);
    nqm_write_values(out.stream, nqm_tensor_count(tensor), nqm_dtype_size(tensor->dtype), tensor->data);
    return nqm_outfile_commit(&out, err); /* checks the stream's error flag */
}
