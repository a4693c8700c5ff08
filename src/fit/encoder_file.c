/* SPDX-License-Identifier: MIT
 *
 * Writing and checking the common format of learned encoders.
 */
#include "fit/encoder_file.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static const char format[] = "nqm-encoder", schema[] = "1";

const unsigned char *nqm_encoder_bytes(const char *name, size_t *n_bytes_ret) {
    for (const nqm_embedded_file *file = nqm_embedded_encoders; file->name; ++file)
        if (strcmp(file->name, name) == 0) {
            *n_bytes_ret = (size_t)(file->end - file->begin);
            return file->begin;
        }
    return NULL;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* A JSON list; free() it. */
static nqm_status list_names(size_t n, const char *const *names, char **text_ret, nqm_error *err) {
    *text_ret = NULL;
    json_t *list = json_array();
    for (size_t i = 0; list && i < n; ++i)
        if (json_array_append_new(list, json_string(names[i])) != 0) {
            json_decref(list);
            return nqm_fail(err, NQM_ERR_ARG, -1, "the name of reference %zu is not UTF-8, or memory ran out", i);
        }
    *text_ret = list ? json_dumps(list, JSON_COMPACT) : NULL;
    json_decref(list);
    return *text_ret ? NQM_OK : nqm_fail_nomem(err, n);
}

nqm_status nqm_encoder_write(const char *path, const char *kind, size_t n_refs, const char *const *names,
                             const nqm_learn_options *options, size_t n_tensors, const nqm_tensor *tensors,
                             nqm_error *err) {
    char *references, tool[32], seed[24], steps[24];
    nqm_status status = list_names(n_refs, names, &references, err);
    if (status != NQM_OK)
        return status;
    snprintf(tool, sizeof tool, "nqm %s", nqm_version());
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)options->seed);
    snprintf(steps, sizeof steps, "%zu", options->n_steps);
    const nqm_meta meta[] = {
        {"format", format}, {"schema", schema},        {"kind", kind}, {"tool", tool}, {"seed", seed},
        {"steps", steps},   {"references", references}};
    status = nqm_safetensors_write(path, n_tensors, tensors, sizeof meta / sizeof *meta, meta, NULL, err);
    free(references);
    return status;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static bool meta_is(const nqm_safetensors *st, const char *key, const char *value) {
    const char *found = nqm_safetensors_meta(st, key);
    return found && strcmp(found, value) == 0;
}

static nqm_status check(const nqm_safetensors *st, const char *name, const char *kind, nqm_error *err) {
    if (!meta_is(st, "format", format) || !meta_is(st, "schema", schema) || !meta_is(st, "kind", kind))
        return nqm_fail(err, NQM_ERR_MODEL, 8, "%s: a safetensors file, but not an encoder '%s' of schema %s (byte 8)",
                        name, kind, schema);
    char hex[65];
    bool matches;
    if (!nqm_safetensors_checksum(st, hex, &matches) || !matches)
        return nqm_fail(err, NQM_ERR_MODEL, 8, "%s: the checksum is missing or wrong: the file was changed or damaged",
                        name);
    for (size_t i = 0; i < nqm_safetensors_count(st); ++i) {
        const nqm_tensor *tensor = nqm_safetensors_at(st, i);
        if (!nqm_tensor_all_finite(tensor))
            return nqm_fail(err, NQM_ERR_MODEL, tensor->byte_offset,
                            "%s: tensor '%.64s' holds a value that is not finite", name, tensor->name);
    }
    return NQM_OK;
}

nqm_status nqm_encoder_parse(const unsigned char *data, size_t n_bytes, const char *name, const char *kind,
                             nqm_safetensors **st_ret, nqm_error *err) {
    nqm_status status = nqm_safetensors_parse(data, n_bytes, name, st_ret, err);
    if (status != NQM_OK)
        return status;
    status = check(*st_ret, name, kind, err);
    if (status != NQM_OK) {
        nqm_safetensors_free(*st_ret);
        *st_ret = NULL;
    }
    return status;
}

nqm_status nqm_encoder_tensor(const nqm_safetensors *st, const char *name, const char *tensor_name, size_t n_dims,
                              const size_t *dims, const nqm_tensor **tensor_ret, nqm_error *err) {
    const nqm_tensor *tensor = nqm_safetensors_find(st, tensor_name);
    if (!tensor)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: tensor '%s' is missing", name, tensor_name);
    bool fits = tensor->dtype == NQM_F32 && tensor->n_dims == n_dims && (uintptr_t)tensor->data % 4 == 0;
    for (size_t i = 0; fits && i < n_dims; ++i)
        fits = dims[i] ? tensor->dims[i] == dims[i] : tensor->dims[i] > 0;
    if (!fits)
        return nqm_fail(err, NQM_ERR_MODEL, tensor->byte_offset, "%s: tensor '%s' has the wrong type or shape", name,
                        tensor_name);
    *tensor_ret = tensor;
    return NQM_OK;
}
