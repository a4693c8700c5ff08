/* SPDX-License-Identifier: MIT
 *
 * encoder_file.h - what the files of learned encoders share (doc/files.md): safetensors that say their kind, how they
 * were learned and from which references, under a checksum; and those that the build has put into the library.
 */
#ifndef NQM_SRC_FIT_ENCODER_FILE_H
#define NQM_SRC_FIT_ENCODER_FILE_H

#include "base/embedded.h"
#include "io/io.h"
#include <nqm/fit.h>

/** The files of models/encoders. */
extern const nqm_embedded_file nqm_embedded_encoders[];

/** The bytes of an embedded encoder file ("sparse", "hyper"; models/encoders/NAME.safetensors); NULL when this build has
 *  none. */
const unsigned char *nqm_encoder_bytes(const char *name, size_t *n_bytes_ret);

/** Write a file of `kind` ("sparse", "hyper") with metadata format, schema, kind, tool, seed, steps and references. Names
 *  must be UTF-8: NQM_ERR_ARG. */
NQM_MUST_CHECK nqm_status nqm_encoder_write(const char *path, const char *kind, size_t n_refs, const char *const *names,
                                            const nqm_learn_options *options, size_t n_tensors,
                                            const nqm_tensor *tensors, nqm_error *err);

/** Parse such a file; NQM_ERR_MODEL unless it is of this kind, its checksum holds and every number in it is finite. `name`
 *  is for messages. Free with nqm_safetensors_free(). */
NQM_MUST_CHECK nqm_status nqm_encoder_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                            const char *kind, nqm_safetensors **st_ret, nqm_error *err);

/** A tensor of float32 with these dimensions (0: any, at least 1); NQM_ERR_MODEL when it is missing or of another type or
 *  shape. Data begin at a multiple of 4 bytes. */
NQM_MUST_CHECK nqm_status nqm_encoder_tensor(const nqm_safetensors *st, const char *name, const char *tensor_name,
                                             size_t n_dims, const size_t *dims, const nqm_tensor **tensor_ret,
                                             nqm_error *err);

#endif
