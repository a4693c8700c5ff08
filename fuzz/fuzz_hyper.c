/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the reader of hypernetworks. The checksum is corrected first, because the reader checks it before the
 * content. Predicting weights with an accepted network must not return NQM_ERR_ARG.
 */
#include "brdf/brdf.h"
#include "encode/encode.h"
#include "fuzz.h"
#include "support/encoder_files.h"

#include <stdlib.h>
#include <unistd.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    static const double hd[6] = {0.1, 0.2, 0.3, 1, 0.1, 2}, rgb[6] = {1, 2, 3, 0, 0, 1e5};
    float weights[NQM_NBRDF_WEIGHTS];
    nqm_hyper hyper;
    nqm_error err = {0};
    blob b = fuzz_with_checksum(data, n_bytes);
    nqm_status status = nqm_hyper_read(b.data, b.n_bytes, "fuzz", &hyper, &err);
    if ((status == NQM_OK) != (hyper.block != NULL) || (status != NQM_OK && err.message[0] == '\0'))
        abort();
    if (status == NQM_OK && nqm_hyper_encode(&hyper, 2, hd, rgb, 0, weights, NULL) == NQM_ERR_ARG)
        abort();
    nqm_free(hyper.block);
    blob_free(&b);
    return 0;
}

static blob make_seed(void) {
    static const char path[] = "fuzz_hyper.tmp";
    nqm_hyper hyper = make_hyper(&(nqm_hyper_shape){{1, 1, 1, 1, 1, NQM_NBRDF_WEIGHTS}}, 1);
    write_hyper(path, &hyper);
    nqm_free(hyper.block);
    blob b = blob_load(path);
    unlink(path);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
