/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: the CSV of latents next to the decoder of neural processes. A material that opens has finite values.
 */
#include "fuzz.h"

#include <math.h>
#include <nqm/brdf.h>
#include <stdio.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    static char argument[300];
    if (!argument[0]) {
        blob_put(make_nps_decoder(), scratch_path("decoder.bin"));
        snprintf(argument, sizeof argument, "%s:second", scratch_path("decoder.bin"));
    }
    remove(scratch_path("nps_latents.csv")); /* overwriting a file waits for the disk on some file systems */
    blob_put(blob_of(n_bytes, (const char *)data), scratch_path("nps_latents.csv"));
    nqm_brdf *brdf;
    nqm_error err = {0};
    const nqm_status status = nqm_brdf_open(argument, &brdf, &err);
    must((status == NQM_OK) == (brdf != NULL) && (status == NQM_OK || (err.status == status && err.message[0])));
    if (brdf) {
        const double hd[3] = {0.1, 0.7, 1};
        double rgb[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        for (int c = 0; c < 3; ++c)
            must(isfinite(rgb[c]) && rgb[c] >= 0);
    }
    nqm_brdf_free(brdf);
    return 0;
}

static blob make_seed(void) {
    return make_nps_latents();
}

FUZZ_TARGET(run_one, make_seed)
