/* SPDX-License-Identifier: MIT
 *
 * Writing and checking the common format of learned encoders.
 */
#include "encode/encode.h"

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

nqm_status nqm_encoder_write(const char *path, const nqm_encoder_source *source, size_t n_tensors,
                             const nqm_tensor *tensors, nqm_error *err) {
    char *references, tool[32], seed[24], steps[24];
    nqm_status status = list_names(source->n_refs, source->names, &references, err);
    if (status != NQM_OK)
        return status;
    snprintf(tool, sizeof tool, "nqm %s", nqm_version());
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)source->options->seed);
    snprintf(steps, sizeof steps, "%zu", source->options->n_steps);
    const nqm_meta meta[] = {{"format", format}, {"schema", schema}, {"kind", source->kind},    {"tool", tool},
                             {"seed", seed},     {"steps", steps},   {"references", references}};
    status = nqm_safetensors_write(path, n_tensors, tensors, sizeof meta / sizeof *meta, meta, NULL, err);
    free(references);
    return status;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static nqm_status check(const nqm_safetensors *st, const char *name, const char *kind, nqm_error *err) {
    const char *found_format = nqm_safetensors_meta(st, "format"), *found_kind = nqm_safetensors_meta(st, "kind");
    if (!found_format || strcmp(found_format, format) != 0 || !found_kind || strcmp(found_kind, kind) != 0)
        return nqm_fail(err, NQM_ERR_MODEL, 8, "%s: a safetensors file, but not an encoder '%s' (byte 8)", name, kind);
    nqm_status status = nqm_safetensors_verify(st, schema, true, NQM_ERR_MODEL, err);
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
