/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the reader of dictionaries. The checksum is corrected first, because the reader checks it before the
 * content. Encoding a BRDF with an accepted dictionary must not crash.
 */
#include "encode/encode.h"
#include "fuzz.h"
#include "support/encoder_files.h"

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

/* Bases and a dictionary of one atom, each with one coefficient of 1. */
static blob make_seed(void) {
    static const char path[] = "fuzz_dictionary.tmp";
    nqm_sparse_dictionary *dictionary;
    nqm_tensor tensors[NQM_SPARSE_TENSORS];
    must(nqm_sparse_dictionary_create(1, &dictionary, NULL) == NQM_OK);
    dictionary->bases.h[0] = dictionary->bases.d[0] = dictionary->bases.p[0] = dictionary->atoms[0] = 1;
    nqm_sparse_tensors(dictionary, tensors);
    write_encoder(path, "sparse", NQM_SPARSE_TENSORS, tensors);
    nqm_free(dictionary);
    blob b = blob_load(path);
    unlink(path);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
