/* SPDX-License-Identifier: MIT
 *
 * io.h - reads and writes files of named arrays, tables, images and meshes: safetensors, NumPy, HDF5, MAT, zip members, CSV,
 * latitude-longitude images, PLY and OBJ. Independent of BRDFs. Every reader checks sizes against the bytes that are
 * present before it allocates.
 */
#ifndef NQM_SRC_IO_H
#define NQM_SRC_IO_H

#include "base/base.h"

/** What a file is, from its first bytes, for messages: "a PNG picture", "CSV", "text"; NULL: unknown. */
const char *nqm_file_kind(const unsigned char *data, size_t n_bytes);

/* ---- safetensors (huggingface.co/docs/safetensors): u64 header length, JSON header, raw little-endian tensors ---- */

typedef enum nqm_dtype { NQM_F32, NQM_F64, NQM_I32, NQM_I64, NQM_U8, NQM_U16, NQM_U32, NQM_F16 } nqm_dtype;
enum { NQM_MAX_DIMS = 6 };
/** Bytes of one value. */
size_t nqm_dtype_size(nqm_dtype dtype);

typedef struct nqm_tensor {
    const char *name;
    nqm_dtype dtype;
    size_t n_dims, dims[NQM_MAX_DIMS];
    size_t n_bytes;
    bool is_column_major; /* NumPy only: Fortran order */
    /** Aligned as in the file; the writer aligns to 64 bytes. safetensors: values in the byte order of the host; NumPy and RGL: of
     *  the file, for nqm_load_f32() and its like. */
    const void *data;
    int64_t byte_offset; /* position of the data in the file */
} nqm_tensor;

/** Number of values. */
size_t nqm_tensor_count(const nqm_tensor *tensor);
/** Set n_bytes from the type and the shape; false: a size_t cannot hold it. */
bool nqm_tensor_measure(nqm_tensor *tensor);
/** A matrix (rows, cols), or for rows 0 a vector (cols), to be written. */
nqm_tensor nqm_tensor_of(const char *name, nqm_dtype dtype, size_t rows, size_t cols, const void *data);

/** A parsed file. Its tensors point into the bytes it was parsed from, which must outlive it, or on a big-endian host into a
 *  copy that it owns. */
typedef struct nqm_safetensors nqm_safetensors;
/** Parse and check (offsets in range, no overlap, shapes match bytes, header at most 100 MB). `name` is for messages and
 *  must outlive the result. */
NQM_MUST_CHECK nqm_status nqm_safetensors_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                                nqm_safetensors **st_ret, nqm_error *err);
void nqm_safetensors_free(nqm_safetensors *st);
/** Big-endian hosts: the block that contains the tensors' data, which from now on the caller owns (nqm_free). Others: NULL. */
unsigned char *nqm_safetensors_take(nqm_safetensors *st);
size_t nqm_safetensors_count(const nqm_safetensors *st);
/** The i-th tensor in the order of the header. */
const nqm_tensor *nqm_safetensors_at(const nqm_safetensors *st, size_t i);
/** Find a tensor by name; NULL when there is none. */
const nqm_tensor *nqm_safetensors_find(const nqm_safetensors *st, const char *tensor_name);
/** Find a tensor of float32 with the name and dimensions of `expected` (dimension 0: any size >= 1); fail with the status
 *  `failure` when it is missing or of another type or shape. Its data may be misaligned. */
NQM_MUST_CHECK nqm_status nqm_safetensors_floats(const nqm_safetensors *st, const nqm_tensor *expected,
                                                 nqm_status failure, const nqm_tensor **tensor_ret, nqm_error *err);
/** A value of __metadata__, or NULL. */
const char *nqm_safetensors_meta(const nqm_safetensors *st, const char *key);
/** false when a tensor of floats (F16, F32, F64) contains a value that is not finite. */
bool nqm_tensor_all_finite(const nqm_tensor *tensor);
/** Recompute the checksum that nqm_safetensors_write() stores under metadata "sha256": SHA-256 of the whole file with
 *  those 64 digits replaced by '0'. false when the file stores no checksum. *matches: the recomputed checksum equals
 *  the stored one. */
bool nqm_safetensors_checksum(const nqm_safetensors *st, char hex[65], bool *matches);
/** Fail with the status `failure` unless metadata "schema" is `schema` and, if has_checksum, the checksum is stored and
 *  correct. */
NQM_MUST_CHECK nqm_status nqm_safetensors_verify(const nqm_safetensors *st, const char *schema, bool has_checksum,
                                                 nqm_status failure, nqm_error *err);

typedef struct nqm_meta {
    const char *key, *value;
} nqm_meta;
/** Write a file with tensors (their `data`, dtype, dims, n_bytes), metadata, and the checksum; sha256_ret may be
 *  NULL. */
NQM_MUST_CHECK nqm_status nqm_safetensors_write(const char *path, size_t n_tensors, const nqm_tensor *tensors,
                                                size_t n_meta, const nqm_meta *meta, char sha256_ret[65],
                                                nqm_error *err);

/* ---- tensor container of the RGL material database (Dupuy and Jakob 2018) ---------------------------------------- */

/** A parsed file. Its tensors point into the bytes it was parsed from, which must outlive it. */
typedef struct nqm_tensor_file nqm_tensor_file;
/** Parse and check that all offsets and shapes are inside the bytes. `name` is for messages. Free with nqm_free(). */
NQM_MUST_CHECK nqm_status nqm_tensor_file_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                                nqm_tensor_file **file_ret, nqm_error *err);
/** Find a tensor by name; NULL when there is none, or nqm_dtype does not have its type. */
const nqm_tensor *nqm_tensor_file_find(const nqm_tensor_file *file, const char *tensor_name);

/* ---- CSV with a header line -------------------------------------------------------------------------------------- */

typedef struct nqm_csv nqm_csv;
enum { NQM_CSV_MAX_COLUMNS = 1 << 14 };
/** Read a whole CSV (RFC 4180 quoting, LF or CRLF, '#' lines and blank lines skipped, blanks around unquoted fields
 *  dropped; separated by commas, or by ';' or tabs if the header has no comma outside of quotes). Every row must have
 *  as many fields as the header. Takes at most seven times the bytes of the file. NQM_ERR_LIMIT: more than
 *  NQM_CSV_MAX_COLUMNS columns, or 4 GiB. */
NQM_MUST_CHECK nqm_status nqm_csv_load(const char *path, nqm_csv **csv_ret, nqm_error *err);
/** The same from memory; `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_csv_parse(const char *text, size_t n_bytes, const char *name, nqm_csv **csv_ret,
                                        nqm_error *err);
void nqm_csv_free(nqm_csv *csv);
size_t nqm_csv_rows(const nqm_csv *csv);
size_t nqm_csv_columns(const nqm_csv *csv);
/** Column number of a name (ASCII case ignored), or -1. */
int nqm_csv_column(const nqm_csv *csv, const char *column_name);
/** The name of a column. */
const char *nqm_csv_header(const nqm_csv *csv, int column);
const char *nqm_csv_text(const nqm_csv *csv, size_t row, int column);
/** Byte offset of a field in the file. */
size_t nqm_csv_byte(const nqm_csv *csv, size_t row, int column);
/** Parse a field as a finite number. NQM_ERR_FORMAT: it is not one; the message names file, line and byte. */
NQM_MUST_CHECK nqm_status nqm_csv_number(const nqm_csv *csv, size_t row, int column, double *value_ret, nqm_error *err);

/* ---- arrays of NumPy --------------------------------------------------------------------------------------------- */

bool nqm_npy_probe(const nqm_map *map);
/** Parse a .npy file with one array of float32 or float64; its data point into the map, at any alignment. */
NQM_MUST_CHECK nqm_status nqm_npy_parse(const nqm_map *map, nqm_tensor *tensor_ret, nqm_error *err);
/** Write an array; dtype NQM_F32 or NQM_F64. The name of the tensor is not stored. */
NQM_MUST_CHECK nqm_status nqm_npy_write(const char *path, const nqm_tensor *tensor, nqm_error *err);

/* ---- zip members (libzip) ---------------------------------------------------------------------------------------- */

/** Read the member whose last path component is `member` ("x.h5") into a new block (nqm_free); at most max_bytes. */
NQM_MUST_CHECK nqm_status nqm_zip_read(const nqm_map *map, const char *member, size_t max_bytes,
                                       unsigned char **data_ret, size_t *n_bytes_ret, nqm_error *err);
/** For messages: names of the first few members that end with `suffix`, without the suffix, and the number of such
 *  members when more exist ("a, b, ... (9 in all)"); "" when there is none. */
NQM_MUST_CHECK nqm_status nqm_zip_examples(const nqm_map *map, const char *suffix, char *text, size_t n_text,
                                           nqm_error *err);

/* ---- HDF5 float datasets (as h5py and Keras write them) ---------------------------------------------------------- */

/** An HDF5 image in memory. It owns nothing. */
typedef struct nqm_hdf5 {
    const unsigned char *data;
    size_t n_bytes;
    const char *name; /**< name in messages */
    uint64_t root;    /**< address of the root group's object header */
} nqm_hdf5;

/** Begin to read an HDF5 image; the bytes and `name` must outlive the result. */
NQM_MUST_CHECK nqm_status nqm_hdf5_open(const unsigned char *data, size_t n_bytes, const char *name, nqm_hdf5 *file_ret,
                                        nqm_error *err);
/** Read a float32 dataset of exactly these dimensions into out (product of dims); values that are not finite are
 *  refused. */
NQM_MUST_CHECK nqm_status nqm_hdf5_read_f32(const nqm_hdf5 *file, const char *path, size_t n_dims, const size_t *dims,
                                            float *out, nqm_error *err);

/* ---- MAT v5 ------------------------------------------------------------------------------------------------------ */

typedef struct nqm_mat nqm_mat;
/** Open a MAT v5 file (MATLAB's -v6 and -v7; scipy.io.savemat) and check its structure. `path` must outlive it. */
NQM_MUST_CHECK nqm_status nqm_mat_open(const char *path, nqm_mat **mat_ret, nqm_error *err);
/** Size of a real numeric matrix. */
NQM_MUST_CHECK nqm_status nqm_mat_shape(const nqm_mat *mat, const char *variable, size_t *rows_ret, size_t *cols_ret,
                                        nqm_error *err);
/** Read such a matrix of exactly rows x cols (a vector may be transposed) into out, row-major; values must be
 *  finite. */
NQM_MUST_CHECK nqm_status nqm_mat_read(const nqm_mat *mat, const char *variable, size_t rows, size_t cols, double *out,
                                       nqm_error *err);
void nqm_mat_close(nqm_mat *mat);

/** One real matrix to write. */
typedef struct nqm_mat_variable {
    const char *name; /* a letter, then letters, digits and _; 63 bytes at most */
    size_t rows, cols;
    const double *data; /* (rows, cols), finite */
} nqm_mat_variable;
/** Write n matrices as a MAT v5 file, uncompressed: equal matrices give identical files. NQM_ERR_ARG: a bad name, or a
 *  value that is not finite; NQM_ERR_LIMIT: no element, or more than 2^24. */
NQM_MUST_CHECK nqm_status nqm_mat_write(const char *path, size_t n, const nqm_mat_variable *variables, nqm_error *err);

/* ---- images ------------------------------------------------------------------------------------------------------ */

/** A linear RGB image. */
typedef struct nqm_image {
    size_t width, height;
    float *rgb; /* (height, width, 3), first row on top; nqm_free */
} nqm_image;

enum { NQM_IMAGE_MAX_WIDTH = 8192, NQM_IMAGE_MAX_HEIGHT = 4096 };

/** Read a high-dynamic-range image: OpenEXR (R, G, B or Y), Radiance HDR, or RGBE stored in an 8-bit RGBA PNG (as Pixar
 *  Campus). The format is detected from the first bytes. Negative values (out of gamut) become 0; a value that is not
 *  finite is refused. */
NQM_MUST_CHECK nqm_status nqm_image_load(const char *path, nqm_image *image_ret, nqm_error *err);

/** The same from mapped bytes. */
NQM_MUST_CHECK nqm_status nqm_image_parse(const nqm_map *map, nqm_image *image_ret, nqm_error *err);

/** Decode Radiance HDR. Fills a zeroed image, whose pixels the caller frees, also on failure; values are not checked. */
NQM_MUST_CHECK nqm_status nqm_image_decode_hdr(const nqm_map *map, nqm_image *image, nqm_error *err);
/** Check the width and height of a header. NQM_ERR_FORMAT: one is 0, or there are more than `per_byte` pixels per byte of the file;
 *  NQM_ERR_LIMIT: larger than max_width x max_height. */
NQM_MUST_CHECK nqm_status nqm_image_check_size(const nqm_map *map, uint64_t width, uint64_t height, double per_byte,
                                               size_t max_width, size_t max_height, nqm_error *err);
/** The same up to NQM_IMAGE_MAX_WIDTH x NQM_IMAGE_MAX_HEIGHT, and allocate the pixels. */
NQM_MUST_CHECK nqm_status nqm_image_alloc(const nqm_map *map, uint64_t width, uint64_t height, double per_byte,
                                          nqm_image *image_ret, nqm_error *err);

/** Write an image as OpenEXR (float, ZIP compression) or as Radiance HDR (RGBE, run-length encoded; negative values
 *  become 0). */
NQM_MUST_CHECK nqm_status nqm_image_write_exr(const char *path, const nqm_image *image, nqm_error *err);
NQM_MUST_CHECK nqm_status nqm_image_write_hdr(const char *path, const nqm_image *image, nqm_error *err);

/* ---- triangle meshes --------------------------------------------------------------------------------------------- */

typedef struct nqm_mesh {
    size_t n_vertices, n_triangles;
    float *position;    /* (n_vertices, 3) */
    uint32_t *triangle; /* (n_triangles, 3) vertex indices, winding order as in the file */
    float *normal;      /* (n_vertices, 3) unit vectors; without them in the file area-weighted means of triangles */
} nqm_mesh;

enum { NQM_MESH_MAX_VERTICES = 20000000, NQM_MESH_MAX_TRIANGLES = 20000000 };

/** Read a mesh: PLY (ASCII, binary of either byte order; properties beyond x y z, nx ny nz and vertex_indices are
 *  skipped) or Wavefront OBJ (v, vn, f; a vertex is duplicated when faces give it several normals). The format is
 *  detected from the first bytes. Polygons are triangulated as fans. Indices are checked; values that are not finite
 *  and meshes without triangles are refused. */
NQM_MUST_CHECK nqm_status nqm_mesh_load(const char *path, nqm_mesh *mesh_ret, nqm_error *err);
/** The same from mapped bytes. */
NQM_MUST_CHECK nqm_status nqm_mesh_parse(const nqm_map *map, nqm_mesh *mesh_ret, nqm_error *err);
/** Free the arrays of a mesh; a zeroed mesh is allowed. */
void nqm_mesh_free(nqm_mesh *mesh);

#endif
