/* SPDX-License-Identifier: MIT
 *
 * encoder_files.h - small files of encoders, as studies/learn.py writes them.
 */
#ifndef NQM_TESTS_ENCODER_FILES_H
#define NQM_TESTS_ENCODER_FILES_H

#include "encode/encode.h"

/** Write a file with the metadata of encoders. */
void write_encoder(const char *path, const char *kind, size_t n_tensors, const nqm_tensor *tensors);

/** A hypernetwork with random weights; nqm_free(hyper.block). */
nqm_hyper make_hyper(const nqm_hyper_shape *shape, uint64_t seed);
/** Write it. */
void write_hyper(const char *path, const nqm_hyper *hyper);

#endif
