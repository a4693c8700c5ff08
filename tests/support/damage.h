/* SPDX-License-Identifier: MIT
 *
 * damage.h - bytes that are cut or changed: readers refuse them, and read nothing beyond their end.
 */
#ifndef NQM_TESTS_DAMAGE_H
#define NQM_TESTS_DAMAGE_H

#include "io/io.h"
#include "support/brdf_files.h"

/** Read the bytes of a map, which has exactly so many (for sanitizers), and free what was read. */
typedef nqm_status (*byte_reader)(const nqm_map *map, nqm_error *err);
nqm_status read_csv(const nqm_map *map, nqm_error *err);
nqm_status read_mesh(const nqm_map *map, nqm_error *err);
nqm_status read_safetensors(const nqm_map *map, nqm_error *err);
nqm_status read_materials(const nqm_map *map, nqm_error *err);
/** The map's path is an argument of nqm_brdf_open(); what is before its ":" is written. */
nqm_status read_brdf(const nqm_map *map, nqm_error *err);
/** The same, and the byte of an error is the beginning of the file or its end. */
nqm_status read_brdf_ends(const nqm_map *map, nqm_error *err);

/** Read the bytes cut at each of the first 500 lengths, and at every step-th beyond: each cut is refused with NQM_ERR_FORMAT, and the
 *  message has the path. */
void refuse_cuts(const char *path, blob whole, size_t step, byte_reader read);
/** The same where a part may be valid: each is read or refused. */
void survive_cuts(const char *path, blob whole, size_t step, byte_reader read);
/** Read the bytes with each of them changed in three ways, every step-th: they are read, or refused with NQM_ERR_FORMAT or NQM_ERR_LIMIT. */
void survive_changes(const char *path, blob whole, size_t step, byte_reader read);

#endif
