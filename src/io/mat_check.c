/* SPDX-License-Identifier: MIT
 *
 * The structure of MAT v5 files ("MAT-File Format", The MathWorks): a header of 128 bytes, then elements of a tag
 * (type, size) and data; an array is an element of elements: flags, dimensions, name, data. matio 1.5 allocates what
 * the sizes of dimensions and names claim, 8 GB for one changed byte; so they are checked here first, in compressed
 * elements through their first bytes.
 */
#include "io/mat_check.h"

#include <string.h>
#include <zlib.h>

enum {
    TYPE_INT8 = 1,
    TYPE_INT32 = 5,
    TYPE_UINT32 = 6,
    TYPE_MATRIX = 14,
    TYPE_COMPRESSED = 15,
    CLASS_CHAR = 4,
    CLASS_SPARSE = 5,
    CLASS_UINT64 = 15,
    TAG_BYTES = 8,
    HEAD_BYTES = 256, /* of a compressed array: enough for the longest flags, dimensions and name that are let pass */
    MAX_DIMENSIONS = 8,
    MAX_NAME_BYTES = 63 /* of MATLAB */
};

/* Bytes of the name element, tag and padding included; 0 when it is none. Up to 4 bytes lie inside the tag. */
static size_t name_size(const unsigned char *p, size_t n) {
    if (n < TAG_BYTES)
        return 0;
    uint32_t type = nqm_load_u32(p);
    if (type >> 16) /* small: size in the upper half, data in the second word */
        return (type & 0xffff) == TYPE_INT8 && type >> 16 <= 4 ? TAG_BYTES : 0;
    uint32_t size = nqm_load_u32(p + 4);
    return type == TYPE_INT8 && size <= MAX_NAME_BYTES ? TAG_BYTES + (size + 7) / 8 * 8 : 0;
}

/* The flags, dimensions and name of an array that begins at p, of which n bytes are present. */
static const char *fault_of_array(const unsigned char *p, size_t n) {
    const size_t at_dimensions = 2 * TAG_BYTES, at_sizes = at_dimensions + TAG_BYTES;
    if (n < at_sizes || nqm_load_u32(p) != TYPE_UINT32 || nqm_load_u32(p + 4) != 8)
        return "has damaged flags";
    uint32_t class_type = nqm_load_u32(p + TAG_BYTES) & 0xff;
    if (class_type < CLASS_CHAR || class_type > CLASS_UINT64 || class_type == CLASS_SPARSE)
        return "is no plain array";
    uint32_t size = nqm_load_u32(p + at_dimensions + 4);
    if (nqm_load_u32(p + at_dimensions) != TYPE_INT32 || size % 4 != 0 || size < 8 || size > 4 * MAX_DIMENSIONS)
        return "has damaged dimensions";
    size_t at_name = at_sizes + (size + 7) / 8 * 8;
    size_t name = at_name < n ? name_size(p + at_name, n - at_name) : 0;
    if (name == 0 || name > n - at_name)
        return "has a damaged name";
    return NULL;
}

/* The first bytes of a compressed element of n bytes; returns how many there are. */
static size_t inflate_head(const unsigned char *p, size_t n, unsigned char head[HEAD_BYTES]) {
    z_stream z = {
        .next_in = (unsigned char *)(uintptr_t)p, .avail_in = (uInt)n, .next_out = head, .avail_out = HEAD_BYTES};
    if (inflateInit(&z) != Z_OK)
        return 0;
    int result = inflate(&z, Z_SYNC_FLUSH);
    inflateEnd(&z);
    return result == Z_OK || result == Z_STREAM_END || result == Z_BUF_ERROR ? HEAD_BYTES - z.avail_out : 0;
}

/* One top-level element of n data bytes. */
static const char *fault_of_element(uint32_t type, const unsigned char *p, size_t n) {
    if (type == TYPE_MATRIX)
        return fault_of_array(p, n);
    if (type != TYPE_COMPRESSED)
        return "is of an unknown type";
    unsigned char head[HEAD_BYTES];
    size_t n_head = inflate_head(p, n, head);
    if (n_head < TAG_BYTES || nqm_load_u32(head) != TYPE_MATRIX)
        return "is no compressed array";
    return fault_of_array(head + TAG_BYTES, n_head - TAG_BYTES);
}

nqm_status nqm_mat_check(const nqm_map *map, nqm_error *err) {
    const unsigned char *p = map->data;
    if (p[NQM_MAT_HEADER_BYTES - 2] != 'I' || p[NQM_MAT_HEADER_BYTES - 1] != 'M')
        return nqm_fail(err, NQM_ERR_FORMAT, NQM_MAT_HEADER_BYTES - 2, "%s: not a little-endian MAT file (byte %d)",
                        map->path, NQM_MAT_HEADER_BYTES - 2);
    for (size_t at = NQM_MAT_HEADER_BYTES; at < map->n_bytes;) {
        size_t left = map->n_bytes - at;
        size_t size = left < TAG_BYTES ? SIZE_MAX : nqm_load_u32(p + at + 4);
        const char *fault = left < TAG_BYTES || size > left - TAG_BYTES ? "is cut off" : NULL;
        if (!fault)
            fault = fault_of_element(nqm_load_u32(p + at), p + at + TAG_BYTES, size);
        if (fault)
            return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at, "%s: the variable at byte %zu %s", map->path, at, fault);
        at += TAG_BYTES + size;
    }
    return NQM_OK;
}
