/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the reader of dictionaries. The checksum is corrected first, because the reader checks it before the
 * content. Encoding a BRDF with an accepted dictionary must not crash.
 */
#include "encode/sparse.h"
#include "fuzz.h"

#include <stdlib.h>
#include <unistd.h>

/* Encode with one in ten accepted dictionaries only, because encoding takes much longer than reading. */
static void code(const nqm_sparse_dictionary *dictionary) {
    static size_t n_calls;
    nqm_brdf *ref, *coded;
    nqm_encode_report report;
    if (n_calls++ % 10 != 0)
        return;
    if (nqm_brdf_open("lambert:kd=0.2", &ref, NULL) != NQM_OK)
        abort();
    if (nqm_sparse_encode(dictionary, ref, &(nqm_encode_options){.n = 4}, &report, &coded, NULL) == NQM_OK)
        nqm_brdf_free(coded);
    nqm_brdf_free(ref);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    nqm_sparse_dictionary *dictionary;
    nqm_error err = {0};
    blob b = fuzz_with_checksum(data, n_bytes);
    nqm_status status = nqm_sparse_dictionary_parse(b.data, b.n_bytes, "fuzz", &dictionary, &err);
    if ((status == NQM_OK) != (dictionary != NULL) || (status != NQM_OK && err.message[0] == '\0'))
        abort();
    if (dictionary)
        code(dictionary);
    nqm_free(dictionary);
    blob_free(&b);
    return 0;
}

static blob make_seed(void) {
    static const char path[] = "fuzz_dictionary.tmp";
    static const char *const names[] = {"sgd:nickel"};
    nqm_learn_options options = nqm_learn_options_default();
    nqm_brdf *ref;
    options.n_steps = 1;
    if (nqm_brdf_open(names[0], &ref, NULL) != NQM_OK ||
        nqm_learn(NQM_ENCODER_SPARSE, 1, (const nqm_brdf *const *)&ref, names, &options, path, NULL) != NQM_OK)
        abort();
    nqm_brdf_free(ref);
    blob b = blob_load(path);
    unlink(path);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
