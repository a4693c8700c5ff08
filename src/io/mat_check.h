/* SPDX-License-Identifier: MIT
 *
 * mat_check.h - the sizes that a MAT v5 file claims, checked before matio believes them.
 */
#ifndef NQM_SRC_IO_MAT_CHECK_H
#define NQM_SRC_IO_MAT_CHECK_H

#include "io/io.h"

enum { NQM_MAT_HEADER_BYTES = 128 };

/** Walk over the variables of a file whose header is there: every size must fit the bytes present, dimensions and names
 * must be of sane length, and the variables plain arrays (no cells, structures or objects, whose insides would have to
 * be walked, too). */
NQM_MUST_CHECK nqm_status nqm_mat_check(const nqm_map *map, nqm_error *err);

#endif
