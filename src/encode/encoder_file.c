/* SPDX-License-Identifier: MIT
 *
 * Checking the common format of learned encoders.
 */
#include "encode/encode.h"

#include <string.h>

const unsigned char *nqm_encoder_bytes(const char *name, size_t *n_bytes_ret) {
    for (const nqm_embedded_file *file = nqm_embedded_encoders; file->name; ++file)
        if (strcmp(file->name, name) == 0) {
            *n_bytes_ret = (size_t)(file->end - file->begin);
            return file->begin;
        }
    return NULL;
}

static nqm_status check(const nqm_safetensors *st, const char *name, const char *kind, nqm_error *err) {
    const char *found_format = nqm_safetensors_meta(st, "format"), *found_kind = nqm_safetensors_meta(st, "kind");
    if (!found_format || strcmp(found_format, "nqm-encoder") != 0 || !found_kind || strcmp(found_kind, kind) != 0)
        return nqm_fail(err, NQM_ERR_MODEL, 8, "%s: a safetensors file, but not an encoder '%s' (byte 8)", name, kind);
    nqm_status status = nqm_safetensors_verify(st, "1", true, NQM_ERR_MODEL, err);
    for (size_t i = 0; status == NQM_OK && i < nqm_safetensors_count(st); ++i) {
        const nqm_tensor *tensor = nqm_safetensors_at(st, i);
        if (!nqm_tensor_all_finite(tensor))
            status = nqm_fail(err, NQM_ERR_MODEL, tensor->byte_offset,
                              "%s: tensor '%.64s' contains a value that is not finite", name, tensor->name);
    }
    return status;
}

nqm_status nqm_encoder_parse(const unsigned char *data, size_t n_bytes, const char *name, const char *kind,
                             nqm_safetensors **st_ret, nqm_error *err) {
    *st_ret = NULL;
    if (!data)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "this build has no %s: models/encoders/%s.safetensors", name, kind);
    nqm_status status = nqm_safetensors_parse(data, n_bytes, name, st_ret, err);
    if (status == NQM_OK)
        status = check(*st_ret, name, kind, err);
    if (status != NQM_OK) {
        nqm_safetensors_free(*st_ret);
        *st_ret = NULL;
    }
    return status;
}
