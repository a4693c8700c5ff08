/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the checkpoint of a training, with its checksum corrected. An accepted one is of an epoch of that training.
 */
#include "fuzz.h"
#include "train/train.h"

#include <unistd.h>

enum { MAX_EPOCHS = 2 };

/* The state of a small network before its second epoch. */
static nqm_training make_training(void) {
    static const nqm_net_shape shape = {2, {2, 2, 1}};
    static nqm_epoch history[MAX_EPOCHS];
    nqm_training t = {.lr_first = 1, .lr_deeper = 1, .epoch = 1, .history = history, .max_epochs = MAX_EPOCHS};
    must(nqm_params_create(&shape, &t.params, NULL) == NQM_OK && nqm_adam_create(&shape, &t.adam, NULL) == NQM_OK);
    nqm_params_init(&t.params, 1);
    t.adam.step = 1;
    return t;
}

static nqm_train_options options_at(const char *path) {
    nqm_train_options options;
    must(nqm_train_options_recipe("nqm", &options, NULL) == NQM_OK);
    options.run.checkpoint = path;
    return options;
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    static nqm_training t;
    char path[FUZZ_PATH];
    nqm_error err = {0};
    if (!t.history)
        t = make_training();
    blob b = fuzz_with_checksum(data, n_bytes);
    const int fd = fuzz_file(b.data, b.n_bytes, path);
    const nqm_train_options options = options_at(path);
    if (nqm_checkpoint_read(&t, &options, "dataset", &err) == NQM_OK)
        must(t.epoch >= 1 && t.epoch <= MAX_EPOCHS);
    else
        must(err.message[0]);
    close(fd);
    blob_free(&b);
    return 0;
}

static blob make_seed(void) {
    nqm_training t = make_training();
    const nqm_train_options options = options_at(scratch_path("checkpoint"));
    must(nqm_checkpoint_write(&t, &options, "dataset", NULL) == NQM_OK);
    nqm_adam_free(&t.adam);
    nqm_free(t.params.block);
    return blob_load(options.run.checkpoint);
}

FUZZ_TARGET(run_one, make_seed)
