/* SPDX-License-Identifier: MIT
 *
 * The state of a training in a safetensors file, so that a resumed training gives bit-identical results: parameters,
 * both moments of Adam, step, learning rates, the state of the schedule and the losses so far. Shuffling, dropout and
 * augmentation are computed from counters and have no state. A checkpoint contains the options and the hash of its
 * dataset.
 */
#include "io/io.h"
#include "io/json.h"
#include "train/train.h"

#include <stdlib.h>
#include <string.h>

static const char format_name[] = "nqm-checkpoint", schema[] = "1";

enum { STATE_EPOCH, STATE_STEP, STATE_LR_FIRST, STATE_LR_DEEPER, STATE_BEST, STATE_BAD_EPOCHS, N_STATE };

enum { PARAMS, ADAM_M, ADAM_V, STATE, HISTORY, N_TENSORS };

static void list_tensors(const nqm_training *t, const double state[N_STATE], nqm_tensor tensors[N_TENSORS]) {
    const size_t n = t->params.n;
    tensors[PARAMS] = nqm_tensor_of("params", NQM_F32, 0, n, t->params.block);
    tensors[ADAM_M] = nqm_tensor_of("adam_m", NQM_F32, 0, n, t->adam.m.block);
    tensors[ADAM_V] = nqm_tensor_of("adam_v", NQM_F32, 0, n, t->adam.v.block);
    tensors[STATE] = nqm_tensor_of("state", NQM_F64, 0, N_STATE, state);
    tensors[HISTORY] = nqm_tensor_of("history", NQM_F64, t->epoch, sizeof(nqm_epoch) / sizeof(double), t->history);
}

nqm_status nqm_checkpoint_write(const nqm_training *t, const nqm_train_options *o, const char *dataset_sha256,
                                nqm_error *err) {
    const double state[N_STATE] = {
        [STATE_EPOCH] = (double)t->epoch, [STATE_STEP] = (double)t->adam.step,
        [STATE_LR_FIRST] = t->lr_first,   [STATE_LR_DEEPER] = t->lr_deeper,
        [STATE_BEST] = t->plateau.best,   [STATE_BAD_EPOCHS] = (double)t->plateau.bad_epochs};
    nqm_tensor tensors[N_TENSORS];
    list_tensors(t, state, tensors);
    char *options = nqm_json_text(nqm_train_options_json(o), 17); /* digits, so that values read back compare equal */
    if (!options)
        return nqm_fail_nomem(err, 0);
    const nqm_meta meta[] = {{"format", format_name},
                             {"schema", schema},
                             {"version", nqm_version()},
                             {"options", options},
                             {"dataset_sha256", dataset_sha256}};
    nqm_status status =
        nqm_safetensors_write(o->run.checkpoint, N_TENSORS, tensors, sizeof meta / sizeof meta[0], meta, NULL, err);
    nqm_free(options);
    return status;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static nqm_status check_format(const nqm_safetensors *st, const char *path, nqm_error *err) {
    const char *format = nqm_safetensors_meta(st, "format");
    if (!format || strcmp(format, format_name) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: a safetensors file, but no checkpoint", path);
    return nqm_safetensors_verify(st, schema, true, NQM_ERR_FORMAT, err);
}

/* Fails unless the options are equal; the message names the first one that differs. */
static nqm_status compare_options(json_t *theirs, json_t *ours, const char *path, nqm_error *err) {
    const char *key;
    json_t *value;
    json_object_foreach(ours, key, value) {
        if (json_equal(value, json_object_get(theirs, key)))
            continue;
        char *was = json_dumps(json_object_get(theirs, key), JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
        char *is = json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
        nqm_status status =
            nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                     "%s: this checkpoint was made with %s %.60s, not %.60s; start anew or give the same options", path,
                     key, was ? was : "unset", is ? is : "unset");
        free(was);
        free(is);
        return status;
    }
    json_object_foreach(theirs, key, value) /* options that are stored only if set */
        if (!json_object_get(ours, key)) return nqm_fail(
            err, NQM_ERR_INCOMPATIBLE, -1, "%s: this checkpoint was made with %s; start anew or give the same options",
            path, key);
    return NQM_OK;
}

static nqm_status check_origin(const nqm_safetensors *st, const nqm_train_options *o, const char *dataset_sha256,
                               nqm_error *err) {
    const char *options = nqm_safetensors_meta(st, "options"), *dataset = nqm_safetensors_meta(st, "dataset_sha256");
    const char *version = nqm_safetensors_meta(st, "version");
    if (!version || strcmp(version, nqm_version()) != 0)
        return nqm_fail(
            err, NQM_ERR_INCOMPATIBLE, -1,
            "%s: this checkpoint was made by nqm %.20s, this is nqm %s; start anew, or resume with that version",
            o->run.checkpoint, version ? version : "of another version", nqm_version());
    if (!dataset || strcmp(dataset, dataset_sha256) != 0)
        return nqm_fail(
            err, NQM_ERR_INCOMPATIBLE, -1,
            "%s: this checkpoint is of another dataset (%.16s..., not %.16s...); start anew or give the same dataset",
            o->run.checkpoint, dataset ? dataset : "none", dataset_sha256);
    json_t *theirs, *ours = nqm_train_options_json(o);
    nqm_status status = nqm_json_parse(options, &theirs, err);
    if (status == NQM_OK)
        status = ours ? compare_options(theirs, ours, o->run.checkpoint, err) : nqm_fail_nomem(err, 0);
    json_decref(theirs);
    json_decref(ours);
    return status;
}

/* Copy the tensor with the name, type and size of `like`. */
static nqm_status copy_tensor(const nqm_safetensors *st, const nqm_tensor *like, void *to, const char *path,
                              nqm_error *err) {
    const nqm_tensor *tensor = nqm_safetensors_find(st, like->name);
    if (!tensor || tensor->dtype != like->dtype || tensor->n_bytes != like->n_bytes)
        return nqm_fail(err, NQM_ERR_FORMAT, tensor ? tensor->byte_offset : -1,
                        "%s: tensor '%s' is missing or of another type or size", path, like->name);
    memcpy(to, tensor->data, like->n_bytes);
    return NQM_OK;
}

static nqm_status read_state(const nqm_safetensors *st, nqm_training *t, const char *path, nqm_error *err) {
    double state[N_STATE] = {0};
    nqm_tensor tensors[N_TENSORS];
    list_tensors(t, state, tensors);
    nqm_status status = copy_tensor(st, &tensors[STATE], state, path, err);
    if (status != NQM_OK)
        return status;
    if (!(state[STATE_EPOCH] >= 1 && state[STATE_EPOCH] <= (double)t->max_epochs))
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "%s: this checkpoint is of %g epochs, more than the %zu requested", path, state[STATE_EPOCH],
                        t->max_epochs);
    if (!(state[STATE_STEP] >= 1 && state[STATE_STEP] < 1e15 && state[STATE_BAD_EPOCHS] >= 0 &&
          state[STATE_BAD_EPOCHS] < 1e9))
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the state is out of range", path);
    t->epoch = (size_t)state[STATE_EPOCH];
    t->adam.step = (uint64_t)state[STATE_STEP];
    t->lr_first = state[STATE_LR_FIRST];
    t->lr_deeper = state[STATE_LR_DEEPER];
    t->plateau.best = state[STATE_BEST];
    t->plateau.bad_epochs = (size_t)state[STATE_BAD_EPOCHS];
    list_tensors(t, state, tensors); /* again, because the length of the history is now known */
    void *const to[N_TENSORS] = {t->params.block, t->adam.m.block, t->adam.v.block, state, t->history};
    for (size_t i = 0; status == NQM_OK && i < N_TENSORS; ++i)
        status = copy_tensor(st, &tensors[i], to[i], path, err);
    return status;
}

nqm_status nqm_checkpoint_read(nqm_training *t, const nqm_train_options *o, const char *dataset_sha256,
                               nqm_error *err) {
    nqm_map map;
    nqm_safetensors *st = NULL;
    nqm_status status = nqm_map_open_own(o->run.checkpoint, &map, err);
    if (status == NQM_OK)
        status = nqm_safetensors_parse(map.data, map.n_bytes, o->run.checkpoint, &st, err);
    if (status == NQM_OK)
        status = check_format(st, o->run.checkpoint, err);
    if (status == NQM_OK)
        status = check_origin(st, o, dataset_sha256, err);
    if (status == NQM_OK)
        status = read_state(st, t, o->run.checkpoint, err);
    nqm_safetensors_free(st);
    nqm_map_close(&map);
    return status;
}
