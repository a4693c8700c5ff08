/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: specs of analytic models, presets, perturbations and mixtures. The input is the text, up to its first zero byte.
 */
#include "fuzz.h"

#include <math.h>
#include <nqm/brdf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    char *text = calloc(n_bytes + 1, 1);
    if (!text)
        abort();
    memcpy(text, data, n_bytes);
    nqm_brdf *brdf = NULL;
    nqm_error err = {0};
    /* a text without a colon is the name of a file, not a spec */
    nqm_status status = strchr(text, ':') ? nqm_brdf_open(text, &brdf, &err) : NQM_OK;
    if (status != NQM_OK && (brdf || err.status != status || !err.message[0]))
        abort();
    if (brdf) {
        const double hd[6] = {0.1, 0.7, 1, 0, 1.2, 2};
        double rgb[6];
        nqm_brdf_eval_half_diff(brdf, 2, hd, rgb, NULL);
        for (int i = 0; i < 6; ++i)
            if (!isfinite(rgb[i]) || rgb[i] < 0)
                abort();
        const char *spec = nqm_brdf_get_info(brdf).spec; /* NULL for a file */
        nqm_brdf *again = NULL;
        if (spec && nqm_brdf_open(spec, &again, &err) != NQM_OK) {
            fprintf(stderr, "the canonical form does not open: %s: %s\n", spec, err.message);
            abort();
        }
        nqm_brdf_free(again);
    }
    nqm_brdf_free(brdf);
    free(text);
    return 0;
}

static blob make_seed(void) {
    static const char spec[] = "perturb:gloss=.8;tint=1.1,1,1;noise=.1;seed=2;cells=4;of=between:t=.3;with=(lambert:kd="
                               ".2);of=tilt:deg=5;azimuth=90;of=ggx:kd=.2,.1,.05;ks=1;"
                               "alpha=.1,.4;f0=.04";
    blob b = {.data = malloc(sizeof spec - 1), .n_bytes = sizeof spec - 1};
    if (!b.data)
        abort();
    memcpy(b.data, spec, b.n_bytes);
    return b;
}

FUZZ_TARGET(run_one, make_seed)
