/* SPDX-License-Identifier: MIT
 *
 * encoder_file.h - the common format of learned encoders (doc/files.md): safetensors with their kind, seed, steps and
 * references as metadata and a checksum; and the encoder files embedded in the library.
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

/** Parse such a file; NQM_ERR_MODEL unless it is of this kind, its checksum is correct and all values are finite. `name` is
 *  for messages. Free with nqm_safetensors_free(). */
NQM_MUST_CHECK nqm_status nqm_encoder_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                            const char *kind, nqm_safetensors **st_ret, nqm_error *err);

#endif
