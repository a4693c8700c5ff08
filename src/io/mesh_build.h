/* SPDX-License-Identifier: MIT
 *
 * mesh_build.h - shared by the readers of PLY and OBJ: rows that grow as the file is read (so that memory is bounded by the
 * bytes present), triangulation of polygons, words of a text file.
 */
#ifndef NQM_SRC_IO_MESH_BUILD_H
#define NQM_SRC_IO_MESH_BUILD_H

#include "io/io.h"

/** A growing list of rows of three 4-byte values. */
typedef struct nqm_mesh_rows {
    size_t n, room;
    void *data; /* (n, 3) float or uint32_t; nqm_free */
} nqm_mesh_rows;

/** Append a row; false when out of memory. */
bool nqm_mesh_rows_add(nqm_mesh_rows *rows, const void *row);

/** A file being read; positions are bytes from its start. */
typedef struct nqm_mesh_reader {
    const nqm_map *map;
    size_t position, line; /* line: from 1; 0 in the binary part of a PLY */
    const char *format;    /* for messages */
    nqm_mesh_rows vertices, normals, triangles;
    nqm_error *err;
} nqm_mesh_reader;

/** Fail with a message that names the current line or byte. */
__attribute__((format(printf, 2, 3))) nqm_status nqm_mesh_fail(const nqm_mesh_reader *r, const char *format, ...);

enum { NQM_MESH_TOKEN = 64 };
/** The next word of the line (words are separated by blanks, tabs and carriage returns) as text, cut with a '~' where it
 *  is longer than any number; false at the end of the line or file, where the position stays. */
bool nqm_mesh_word(nqm_mesh_reader *r, char word[NQM_MESH_TOKEN]);
/** Go to the beginning of the next line; false at the end of the file. */
bool nqm_mesh_next_line(nqm_mesh_reader *r);

/** Three numbers as a row of finite floats. `what` names them in the message. */
NQM_MUST_CHECK nqm_status nqm_mesh_add_vector(nqm_mesh_reader *r, nqm_mesh_rows *rows, const double *xyz,
                                              const char *what);

/** State of the triangulation of a polygon. A corner is a pair of indices: vertex, normal. */
typedef struct nqm_fan {
    size_t n_corners;
    uint32_t first[2], last[2];
} nqm_fan;
/** Add a corner and, from the third on, a triangle: vertices to r->triangles, normals to `normals` unless NULL. */
NQM_MUST_CHECK nqm_status nqm_fan_add(nqm_mesh_reader *r, nqm_fan *fan, uint32_t vertex, uint32_t normal,
                                      nqm_mesh_rows *normals);

/** The readers: fill vertices, triangles and, when the file gives one for each vertex, normals. */
NQM_MUST_CHECK nqm_status nqm_mesh_read_ply(nqm_mesh_reader *r);
NQM_MUST_CHECK nqm_status nqm_mesh_read_obj(nqm_mesh_reader *r);

#endif
