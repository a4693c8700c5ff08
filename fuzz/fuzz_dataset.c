/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the dataset reader, with and without its checksum. Every pair of an accepted dataset must have readable
 * strings and a JOD in [0, 11], and an evaluation of the dataset must be possible.
 */
#include "fuzz.h"
#include "judge/judge.h"
#include "support/toy_dataset.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void look_at(const nqm_dataset *d) {
    size_t n_chars = 0;
    for (size_t i = 0; i < d->n_pairs; ++i) {
        nqm_dataset_pair pair = nqm_dataset_get_pair(d, i);
        n_chars += strlen(pair.ref) + strlen(pair.group) + strlen(pair.test) + strlen(pair.kind);
        if (!(pair.jod >= 0 && pair.jod <= 11))
            abort();
    }
    nqm_evaluation *ev;
    const nqm_eval_options options = nqm_eval_options_default();
    nqm_status status = nqm_evaluation_create(d, 0, NULL, NULL, &options, &ev, NULL);
    if (status != NQM_OK && n_chars < SIZE_MAX)
        abort();
    nqm_evaluation_free(ev);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    void *block; /* aligned like a mapped file, so that tensors are aligned */
    if (posix_memalign(&block, 64, n_bytes + 1) != 0)
        abort();
    memcpy(block, data, n_bytes);
    for (int verify = 0; verify < 2; ++verify) {
        nqm_dataset *d;
        nqm_error err = {0};
        nqm_status status = nqm_dataset_parse(block, n_bytes, "fuzz", verify, &d, &err);
        if ((status == NQM_OK) != (d != NULL) || (status != NQM_OK && err.message[0] == '\0'))
            abort();
        if (d)
            look_at(d);
        nqm_dataset_free(d);
    }
    free(block);
    return 0;
}

static blob make_seed(void) {
    toy_options o = {.n_directions = 2,
                     .n_groups = 3,
                     .pairs_per_ref = 1,
                     .with_masks = true,
                     .with_transport = true,
                     .splits = true,
                     .seed = 1};
    nqm_dataset *d = toy_dataset(&o);
    const char *path = scratch_path("dataset");
    if (nqm_dataset_write(d, path, NULL, NULL) != NQM_OK)
        abort();
    nqm_dataset_free(d);
    return blob_load(path);
}

FUZZ_TARGET(run_one, make_seed)
