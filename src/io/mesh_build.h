/* SPDX-License-Identifier: MIT
 *
 * mesh_build.h - shared by the readers of PLY and OBJ: arrays of rows that grow as the file is read (so that the bytes
 * present bound the memory), triangulation of polygons, words of a text file.
 */
#ifndef NQM_SRC_IO_MESH_BUILD_H
#define NQM_SRC_IO_MESH_BUILD_H

#include "io/io.h"

/** A growing array of rows; a row is three 4-byte values. */
typedef struct nqm_mesh_rows {
    size_t n, max_n;
    void *data; /* (n, 3) float or uint32_t; nqm_free */
} nqm_mesh_rows;

/** Append a row; false when out of memory. */
bool nqm_mesh_rows_add(nqm_mesh_rows *rows, const void *row);

/** Distinct rows of three uint32_t, with a hash table. */
typedef struct nqm_mesh_set {
    nqm_mesh_rows rows;
    uint32_t *slot; /* (n_slots) index of a row plus 1; 0: free */
    size_t n_slots; /* power of 2 */
} nqm_mesh_set;

/** Find a row, or append it; *index_ret is its index. false when out of memory. */
bool nqm_mesh_set_add(nqm_mesh_set *set, const uint32_t row[3], uint32_t *index_ret);
/** Free the arrays of a set; it is empty then. */
void nqm_mesh_set_clear(nqm_mesh_set *set);

/** A file being read; positions are bytes from its start. */
typedef struct nqm_mesh_reader {
    const nqm_map *map;
    size_t position, line; /* line: from 1; 0 in the binary part of a PLY */
    const char *format;    /* name of the format in messages */
    nqm_mesh_rows vertices, normals, triangles;
    nqm_mesh_set seen; /* the triangles, each beginning with its smallest index */
    nqm_error *err;
} nqm_mesh_reader;

/** Fail with a message that names the current line or byte. */
__attribute__((format(printf, 2, 3))) nqm_status nqm_mesh_fail(const nqm_mesh_reader *r, const char *format, ...);

enum { NQM_MESH_TOKEN = 64 };
/** Read the next word of the line; blanks, tabs and carriage returns separate words. A word that does not fit is
 *  truncated and ends in '~', so that it does not parse as a number. false at the end of the line or file; the position
 *  does not change then. */
bool nqm_mesh_word(nqm_mesh_reader *r, char word[NQM_MESH_TOKEN]);
/** Go to the beginning of the next line; false at the end of the file. */
bool nqm_mesh_next_line(nqm_mesh_reader *r);

/** Append three values as a row of floats; values that are not finite are refused. `what` names the row in messages. */
NQM_MUST_CHECK nqm_status nqm_mesh_add_vector(nqm_mesh_reader *r, nqm_mesh_rows *rows, const double *xyz,
                                              const char *what);

/** State of the triangulation of a polygon. A corner is a pair of indices: vertex, normal. */
typedef struct nqm_fan {
    size_t n_corners;
    uint32_t first[2], last[2];
} nqm_fan;
/** Add a corner and, from the third corner on, a triangle: vertices to r->triangles, normals to `normals` unless
 *  NULL. Triangles that have a vertex twice, or the vertices of another one in the same order, are left out: rays would meet all of
 *  them. NQM_ERR_LIMIT: more triangles than a mesh in a file of this size has. */
NQM_MUST_CHECK nqm_status nqm_fan_add(nqm_mesh_reader *r, nqm_fan *fan, uint32_t vertex, uint32_t normal,
                                      nqm_mesh_rows *normals);

/** The readers fill vertices, triangles and, when the file has one for each vertex, normals. */
NQM_MUST_CHECK nqm_status nqm_mesh_read_ply(nqm_mesh_reader *r);
NQM_MUST_CHECK nqm_status nqm_mesh_read_obj(nqm_mesh_reader *r);

#endif
