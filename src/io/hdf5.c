/* SPDX-License-Identifier: MIT
 *
 * Reads float datasets of an HDF5 file in memory. It supports the subset of the format (HDF5 File Format Specification
 * 2.0) that h5py and Keras write by default: superblock version 0 or 1, groups as symbol tables, version 1 object
 * headers and contiguous datasets.
 *
 * nqm does not use libhdf5 because NBRDF files come from untrusted sources and libhdf5 is not safe for damaged files:
 * version 1.10.8 crashes, leaks memory and requests exabytes within seconds of fuzzing. This reader allocates no memory
 * based on sizes in the file, follows no links, and checks every address against the size of the file (bytes_at()). It
 * refuses newer layouts, datasets that are not contiguous, and data in external files.
 */
#include "io/io.h"

#include <math.h>
#include <string.h>

/* Pointer to n bytes at an address of the file; NULL when they are not all inside the file. */
static const unsigned char *bytes_at(const nqm_hdf5 *f, uint64_t address, uint64_t n) {
    if (address > f->n_bytes || n > f->n_bytes - address)
        return NULL;
    return f->data + address;
}

/* ---- superblock -------------------------------------------------------------------------------------------------- */

nqm_status nqm_hdf5_open(const unsigned char *data, size_t n_bytes, const char *name, nqm_hdf5 *f, nqm_error *err) {
    static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    *f = (nqm_hdf5){.data = data, .n_bytes = n_bytes, .name = name};
    if (n_bytes < 100 || memcmp(data, signature, sizeof signature) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: byte 0 begins no complete HDF5 superblock", name);
    unsigned version = data[8];
    if (version > 1)
        return nqm_fail(
            err, NQM_ERR_FORMAT, 8,
            "%s: superblock version %u (byte 8) is not read, only 0 and 1, which h5py and Keras write by default", name,
            version);
    if (data[13] != 8 || data[14] != 8)
        return nqm_fail(err, NQM_ERR_FORMAT, 13, "%s: addresses and lengths must have 8 bytes (byte 13)", name);
    size_t base_at = version == 0 ? 24 : 28; /* version 1 has four additional bytes before this field */
    uint64_t base = nqm_load_u64(data + base_at), end = nqm_load_u64(data + base_at + 16);
    if (base != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)base_at, "%s: the base address at byte %zu is not 0", name,
                        base_at);
    if (end > n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)n_bytes,
                        "%s: ends at byte %zu, but its superblock claims %llu bytes (byte %zu)", name, n_bytes,
                        (unsigned long long)end, base_at + 16);
    f->root = nqm_load_u64(data + base_at + 40);
    return NQM_OK;
}

/* ---- object headers ---------------------------------------------------------------------------------------------- */

enum message_type {
    MESSAGE_DATASPACE = 0x01,
    MESSAGE_DATATYPE = 0x03,
    MESSAGE_EXTERNAL = 0x07,
    MESSAGE_LAYOUT = 0x08,
    MESSAGE_CONTINUATION = 0x10,
    MESSAGE_SYMBOL_TABLE = 0x11
};

/* Data of the first message of a type in an object header; NULL when there is none, or it is shared or has fewer than n
 * bytes. */
static const unsigned char *find_message(const nqm_hdf5 *f, uint64_t object, enum message_type type, size_t n) {
    enum { MAX_BLOCKS = 16, SHARED = 2 };
    struct {
        uint64_t address, n_bytes;
    } blocks[MAX_BLOCKS];
    const unsigned char *head = bytes_at(f, object, 16);
    if (!head || head[0] != 1)
        return NULL;
    size_t n_blocks = 1;
    blocks[0].address = object + 16;
    blocks[0].n_bytes = nqm_load_u32(head + 8);
    for (size_t i = 0; i < n_blocks; ++i) {
        const unsigned char *p = bytes_at(f, blocks[i].address, blocks[i].n_bytes);
        uint64_t left = p ? blocks[i].n_bytes : 0;
        while (left >= 8) {
            unsigned this_type = nqm_load_u16(p), flags = p[4];
            size_t size = nqm_load_u16(p + 2);
            if (size > left - 8)
                return NULL;
            if (this_type == (unsigned)type)
                return size >= n && !(flags & SHARED) ? p + 8 : NULL;
            if (this_type == MESSAGE_CONTINUATION && size >= 16 && n_blocks < MAX_BLOCKS) {
                blocks[n_blocks].address = nqm_load_u64(p + 8);
                blocks[n_blocks++].n_bytes = nqm_load_u64(p + 16);
            }
            p += 8 + size;
            left -= 8 + size;
        }
    }
    return NULL;
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

/** A search for one name in a group. */
typedef struct search {
    const nqm_hdf5 *file;
    uint64_t names, n_names; /* address and size of the heap data with the group's names */
    const char *name;        /* not NUL-terminated */
    size_t n_name;
    unsigned n_steps_left; /* bounds the search in a tree with cycles */
} search;

static bool is_name(const search *s, uint64_t offset) {
    if (offset > s->n_names || s->n_name >= s->n_names - offset)
        return false;
    const unsigned char *p = bytes_at(s->file, s->names + offset, s->n_name + 1);
    return p && memcmp(p, s->name, s->n_name) == 0 && p[s->n_name] == 0;
}

/* Search a symbol table node, a leaf of the group's B-tree. */
static bool search_symbols(search *s, uint64_t address, uint64_t *object) {
    enum { ENTRY_BYTES = 40, SYMBOLIC_LINK = 2 };
    const unsigned char *head = bytes_at(s->file, address, 8);
    if (!head || memcmp(head, "SNOD", 4) != 0)
        return false;
    size_t n = nqm_load_u16(head + 6);
    const unsigned char *entry = bytes_at(s->file, address + 8, n * ENTRY_BYTES);
    for (size_t i = 0; entry && i < n && s->n_steps_left; ++i, entry += ENTRY_BYTES) {
        --s->n_steps_left;
        if (nqm_load_u32(entry + 16) != SYMBOLIC_LINK && is_name(s, nqm_load_u64(entry))) {
            *object = nqm_load_u64(entry + 8);
            return true;
        }
    }
    return false;
}

/* Search a B-tree node of a group. `level` is the level that follows from the parent; a node with another level is
 * refused. */
static bool search_tree(search *s, uint64_t address, unsigned level, uint64_t *object) {
    const unsigned char *head = bytes_at(s->file, address, 24);
    if (!head || memcmp(head, "TREE", 4) != 0 || head[4] != 0 || head[5] != level)
        return false;
    size_t n = nqm_load_u16(head + 6);
    const unsigned char *children = bytes_at(s->file, address + 24, n * 16); /* (key, child) pairs */
    for (size_t i = 0; children && i < n && s->n_steps_left; ++i) {
        --s->n_steps_left;
        uint64_t child = nqm_load_u64(children + 16 * i + 8);
        if (level == 0 ? search_symbols(s, child, object) : search_tree(s, child, level - 1, object))
            return true;
    }
    return false;
}

/* Find a member of a group by name; *object receives the address of its object header. */
static bool find_member(const nqm_hdf5 *f, uint64_t group, const char *name, size_t n_name, uint64_t *object) {
    enum { MAX_STEPS = 1 << 16, MAX_LEVEL = 8 };
    const unsigned char *table = find_message(f, group, MESSAGE_SYMBOL_TABLE, 16);
    const unsigned char *heap = table ? bytes_at(f, nqm_load_u64(table + 8), 32) : NULL;
    if (!heap || memcmp(heap, "HEAP", 4) != 0)
        return false;
    uint64_t tree = nqm_load_u64(table);
    const unsigned char *root = bytes_at(f, tree, 24);
    search s = {.file = f, .name = name, .n_name = n_name, .n_steps_left = MAX_STEPS};
    s.n_names = nqm_load_u64(heap + 8);
    s.names = nqm_load_u64(heap + 24);
    if (!root || root[5] > MAX_LEVEL || !bytes_at(f, s.names, s.n_names))
        return false;
    return search_tree(&s, tree, root[5], object);
}

/* ---- datasets ---------------------------------------------------------------------------------------------------- */

static bool has_shape(const nqm_hdf5 *f, uint64_t object, size_t n_dims, const size_t *dims) {
    const unsigned char *p = find_message(f, object, MESSAGE_DATASPACE, 4);
    if (!p || (p[0] != 1 && p[0] != 2) || p[1] != n_dims)
        return false;
    size_t head = p[0] == 1 ? 8 : 4;
    p = find_message(f, object, MESSAGE_DATASPACE, head + 8 * n_dims);
    for (size_t i = 0; p && i < n_dims; ++i)
        if (nqm_load_u64(p + head + 8 * i) != dims[i])
            return false;
    return p != NULL;
}

static bool is_f32(const nqm_hdf5 *f, uint64_t object) {
    /* Class 1 (floating point); implied leading bit, sign at bit 31; size of 4 bytes; bit offset 0, precision of 32
     * bits; exponent at bit 23, 8 bits; mantissa at bit 0, 23 bits; exponent bias 127. */
    static const unsigned char ieee_f32le[20] = {1, 0x20, 31, 0, 4, 0, 0, 0, 0, 0, 32, 0, 23, 8, 0, 23, 127};
    const unsigned char *p = find_message(f, object, MESSAGE_DATATYPE, sizeof ieee_f32le);
    return p && (p[0] & 15) == ieee_f32le[0] && memcmp(p + 1, ieee_f32le + 1, sizeof ieee_f32le - 1) == 0;
}

/* Check a dataset and copy its values to `out`. Returns NULL, or a text that names the fault; *at_ret receives the byte
 * offset of the fault. */
static const char *read_dataset(const nqm_hdf5 *f, uint64_t object, size_t n_dims, const size_t *dims, float *out,
                                uint64_t *at_ret) {
    enum { LAYOUT_VERSION = 3, CONTIGUOUS = 1 };
    size_t n = 1;
    for (size_t i = 0; i < n_dims; ++i)
        n *= dims[i];
    *at_ret = object;
    if (!has_shape(f, object, n_dims, dims))
        return "has another shape";
    if (!is_f32(f, object))
        return "is not little-endian float32";
    const unsigned char *layout = find_message(f, object, MESSAGE_LAYOUT, 18);
    if (!layout || layout[0] != LAYOUT_VERSION || layout[1] != CONTIGUOUS ||
        find_message(f, object, MESSAGE_EXTERNAL, 0))
        return "is compressed, chunked or stored in another file";
    uint64_t address = nqm_load_u64(layout + 2);
    const unsigned char *p = bytes_at(f, address, 4 * n);
    if (!p || nqm_load_u64(layout + 10) != 4 * n)
        return "extends beyond the end of the file";
    for (size_t i = 0; i < n; ++i) {
        out[i] = nqm_load_f32(p + 4 * i);
        *at_ret = address + 4 * i;
        if (!isfinite(out[i]))
            return "is not finite";
    }
    return NULL;
}

nqm_status nqm_hdf5_read_f32(const nqm_hdf5 *file, const char *path, size_t n_dims, const size_t *dims, float *out,
                             nqm_error *err) {
    uint64_t at = file->root;
    const char *fault = NULL;
    for (const char *part = path; *part && !fault;) {
        size_t n = strcspn(part, "/");
        if (!find_member(file, at, part, n, &at))
            fault = "is missing or unreadable";
        part += n + (part[n] == '/');
    }
    if (!fault)
        fault = read_dataset(file, at, n_dims, dims, out, &at);
    if (!fault)
        return NQM_OK;
    return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at, "%s: dataset %s %s (byte %llu)", file->name, path, fault,
                    (unsigned long long)at);
}
