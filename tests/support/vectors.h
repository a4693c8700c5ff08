/* SPDX-License-Identifier: MIT
 *
 * vectors.h - arrays that scripts of tests/vectors have stored.
 */
#ifndef NQM_TESTS_VECTORS_H
#define NQM_TESTS_VECTORS_H

#include "support/brdf_files.h"

/** Copy array `name` of tests/vectors/FILE, safetensors; it must have n_bytes. */
void get_vector(const char *file, const char *name, size_t n_bytes, void *to);

/** A picture of images.py. */
blob vector_picture(const char *name);
/** An array of npy.py, "f4". */
blob vector_npy(const char *name);

/** Light and viewer of pairs for which brdf.py has f_r. Group fixture of cmocka. */
enum { VECTOR_PAIRS = 60 };
extern double pair_vector[VECTOR_PAIRS][6];
int read_pair_vector(void **state);
/** f_r of these pairs: an array of brdf.safetensors. Valid until the next call. */
const double (*rgb_vector(const char *name))[3];

#endif
